//! The commands of the workspace.

use egui::Key;

use crate::workspaces::commands::{CommandInfo, CommandSet, Scope};

/// A command of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // The table names them.
pub enum MoldCommand {
    FindUncut,
    DesignElectrodes,
    /// Shows regions or electrodes.
    Electrodes,
    CompareCutters,
    ExportUncut,
    CompareDivisions,
    FlyToRegion,
    Isolate,
    Layers,
    DepthColours,
    FaintMold,
    Section,
    MillFlanks,
    /// Opens or closes the window of the technology table.
    Technology,
    FoldPanel,
    FoldList,
}

impl CommandSet for MoldCommand {
    const SCOPE: Scope = Scope::Workspace("mold");

    fn table() -> &'static [(Self, CommandInfo)] {
        use MoldCommand as C;
        const fn info(name: &'static str) -> CommandInfo {
            CommandInfo::new(name)
        }
        static TABLE: [(C, CommandInfo); 16] = [
            (C::FindUncut, info("Find rest material").key(Key::F6)),
            (C::DesignElectrodes, info("Create electrodes").key(Key::F7)),
            (C::Electrodes, info("Show regions or electrodes").key(Key::E)),
            (
                C::CompareCutters,
                info("Compare with other cutters").needing("Find the rest material of the present cutters first"),
            ),
            (
                C::ExportUncut,
                info("Export rest material").needing("Find the rest material of the present cutters first"),
            ),
            (C::CompareDivisions, info("Compare ways of dividing").needing("Create the electrodes first")),
            (C::FlyToRegion, info("Fly to the region")),
            (C::Isolate, info("Show only this region").key(Key::I)),
            (C::Layers, info("Layers of the mold").key(Key::L)),
            (C::DepthColours, info("Regions by depth or by number").key(Key::D)),
            (C::FaintMold, info("Mold transparent or solid")),
            (C::Section, info("Section plane").key(Key::X)),
            (C::MillFlanks, info("Mill the electrode's flanks").needing("Select an electrode that is up to date")),
            (C::Technology, info("Technology table").key(Key::T)),
            (C::FoldPanel, info("Show or fold the panel on the left")),
            (C::FoldList, info("Show or fold the panel on the right")),
        ];
        &TABLE
    }
}
