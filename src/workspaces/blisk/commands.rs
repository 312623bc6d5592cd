//! The commands of the workspace.

use egui::Key;

use crate::workspaces::blisk::desk::picks::Picked;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::commands::{CommandInfo, CommandSet, Scope};

/// A command of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // The table names them.
pub enum BliskCommand {
    NewDemonstration,
    Plan,
    Release,
    Withdraw,
    Ghost,
    /// Keeps the plan to compare with.
    Keep,
    Section,
    IntoChannel,
    WholeBlisk,
    Measure,
    Colours,
    /// Shows the stock left in the channel as colours.
    ResidualStock,
    /// Shows what measured sections are off on the walls as colours.
    Deviations,
    /// Shows the surfaces of the wheel in the colours of their classes.
    Surfaces,
    /// Picks points in the view where recognition needs help.
    Pick(Picked),
    Unpick,
    ShowRefusal,
    MillFlanks,
    /// Opens or closes the window of the technology table.
    Technology,
    Step(Stage),
}

impl CommandSet for BliskCommand {
    const SCOPE: Scope = Scope::Workspace("blisk");

    fn table() -> &'static [(Self, CommandInfo)] {
        use BliskCommand as C;
        const fn info(name: &'static str) -> CommandInfo {
            CommandInfo::new(name)
        }
        static TABLE: [(C, CommandInfo); 28] = [
            (C::NewDemonstration, info("New from demonstration blisk")),
            (C::Plan, info("Plan feed path").key(Key::F5)),
            (C::Release, info("Release for export")),
            (C::Withdraw, info("Withdraw release")),
            (C::Ghost, info("Keep or remove a previous position here").key(Key::G)),
            (
                C::Keep,
                info("Keep for comparison")
                    .needing("Needs a finished plan that is up to date and not kept yet; six at most"),
            ),
            (C::Section, info("Section plane").key(Key::X)),
            (C::IntoChannel, info("Look into the channel").key(Key::C)),
            (C::WholeBlisk, info("Show the whole blisk").key(Key::B)),
            (C::Measure, info("Measure").key(Key::M)),
            (C::Colours, info("Clearance colours")),
            (C::ResidualStock, info("Residual stock colours")),
            (
                C::Deviations,
                info("Deviation colours")
                    .needing("Needs a scan of the finished part, or one made from measured sections"),
            ),
            (C::Surfaces, info("Surface colours")),
            (C::Pick(Picked::Hub), info("Pick points on the hub")),
            (C::Pick(Picked::Shroud), info("Pick points on the shroud")),
            (C::Pick(Picked::Blades), info("Pick points on blades")),
            (C::Pick(Picked::Axis), info("Pick the axis")),
            (C::Unpick, info("Remove the last picked point").key(Key::Backspace)),
            (C::ShowRefusal, info("Show where the channel was refused")),
            (C::MillFlanks, info("Mill the electrode's flanks").needing("Select an electrode that is up to date")),
            (C::Technology, info("Technology table").key(Key::T)),
            (C::Step(Stage::Part), info("Step 1: Part")),
            (C::Step(Stage::Channel), info("Step 2: Channel")),
            (C::Step(Stage::Electrode), info("Step 3: Electrode")),
            (C::Step(Stage::Plan), info("Step 4: Plan")),
            (C::Step(Stage::Verify), info("Step 5: Verify")),
            (C::Step(Stage::Export), info("Step 6: Export")),
        ];
        &TABLE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_are_called_as_everywhere() {
        for stage in Stage::ALL {
            let name = format!("Step {}: {}", stage.number(), stage.name());
            assert_eq!(BliskCommand::Step(stage).command().info.name, name);
        }
    }
}
