//! The commands of the workspace.

use egui::Key;

use crate::workspaces::commands::{CommandInfo, CommandSet, Scope};

/// A command of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // The table names them.
pub enum FlankCommand {
    PlanFlank,
    NextPath,
    SideBySide,
    FaceFlank,
    ShowCutter,
    AxisSurface,
    Rulings,
    MovingCutter,
    FoldPanel,
    FoldList,
}

impl CommandSet for FlankCommand {
    const SCOPE: Scope = Scope::Workspace("flank");

    fn table() -> &'static [(Self, CommandInfo)] {
        use FlankCommand as C;
        const fn info(name: &'static str) -> CommandInfo {
            CommandInfo::new(name)
        }
        static TABLE: [(C, CommandInfo); 10] = [
            (C::PlanFlank, info("Plan the flank's path").key(Key::F8)),
            (C::NextPath, info("Next of initial, chosen and refined path").key(Key::N)),
            (C::SideBySide, info("Initial, chosen and refined side by side").key(Key::V)),
            (C::FaceFlank, info("View normal to the flank").key(Key::Num5)),
            (C::ShowCutter, info("Show or hide the cutter").key(Key::T)),
            (C::AxisSurface, info("Show or hide the axis surface").key(Key::A)),
            (C::Rulings, info("Show or hide rulings")),
            (C::MovingCutter, info("Swept envelope or static deviation").key(Key::W)),
            (C::FoldPanel, info("Show or fold the panel on the left")),
            (C::FoldList, info("Show or fold the panel on the right")),
        ];
        &TABLE
    }
}
