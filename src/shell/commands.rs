//! Everything that can be commanded, with its name and shortcut: one list for menus, palette, buttons and keys.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::core::Core;
use super::workspace::Workspace;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::pipeline::StageState;
use crate::workspaces::flank::panels::FlankDesk;
use render::view::StandardView;
use task::State;

/// A command of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // `name` says what each of them is.
pub enum Command {
    NewDemonstration,
    Open,
    Reload,
    Save,
    SaveAs,
    SaveJob,
    Quit,
    Undo,
    Redo,
    Preferences,
    Plan,
    Cancel,
    Release,
    Withdraw,
    Export,
    Step(Stage),
    Play,
    NextNode,
    PreviousNode,
    FirstNode,
    LastNode,
    Ghost,
    /// Keeps the plan to compare with.
    Keep,
    Fit,
    View(StandardView),
    Projection,
    Section,
    IntoChannel,
    WholeBlisk,
    Measure,
    Colours,
    /// Shows the stock left in the channel as colours.
    Leftover,
    /// Shows one of the workspaces.
    Workspace(Workspace),
    FindUncut,
    DesignElectrodes,
    /// Shows regions or electrodes.
    Electrodes,
    CompareCutters,
    FlyToRegion,
    Isolate,
    Layers,
    DepthColours,
    FaintMold,
    /// Shows the electrode's flanks in their workspace.
    MillFlanks,
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
    Screenshot,
    Theme,
    Palette,
    Log,
    About,
}

impl Command {
    /// Every command in the order of the palette.
    pub fn all() -> Vec<Self> {
        use Command as C;
        let mut all = vec![
            C::Open,
            C::NewDemonstration,
            C::Reload,
            C::Save,
            C::SaveAs,
            C::SaveJob,
            C::Undo,
            C::Redo,
            C::Plan,
            C::Cancel,
            C::Release,
            C::Withdraw,
            C::Export,
            C::Play,
            C::NextNode,
            C::PreviousNode,
            C::FirstNode,
            C::LastNode,
            C::Ghost,
            C::Keep,
            C::Fit,
            C::Projection,
            C::Section,
            C::IntoChannel,
            C::WholeBlisk,
            C::Measure,
            C::Colours,
            C::Leftover,
            C::FindUncut,
            C::DesignElectrodes,
            C::Electrodes,
            C::CompareCutters,
            C::FlyToRegion,
            C::Isolate,
            C::Layers,
            C::DepthColours,
            C::FaintMold,
            C::MillFlanks,
            C::PlanFlank,
            C::NextPath,
            C::SideBySide,
            C::FaceFlank,
            C::ShowCutter,
            C::AxisSurface,
            C::Rulings,
            C::MovingCutter,
            C::FoldPanel,
            C::FoldList,
            C::Screenshot,
            C::Theme,
            C::Preferences,
            C::Log,
            C::Palette,
            C::About,
            C::Quit,
        ];
        all.extend(Workspace::ALL.map(C::Workspace));
        all.extend(StandardView::ALL.map(C::View));
        all.extend(Stage::ALL.map(C::Step));
        all
    }

    /// Its name.
    pub fn name(self) -> String {
        let fixed = match self {
            Self::NewDemonstration => "New from demonstration blisk",
            Self::Open => "Open…",
            Self::Reload => "Reload meshes",
            Self::Save => "Save",
            Self::SaveAs => "Save as…",
            Self::SaveJob => "Save as job file…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Preferences => "Preferences…",
            Self::Plan => "Plan feed path",
            Self::Cancel => "Cancel",
            Self::Release => "Release for export",
            Self::Withdraw => "Withdraw release",
            Self::Export => "Export…",
            Self::Play => "Play or pause",
            Self::NextNode => "Next node",
            Self::PreviousNode => "Previous node",
            Self::FirstNode => "To the first node",
            Self::LastNode => "To the final pose",
            Self::Ghost => "Keep or remove a previous position here",
            Self::Keep => "Keep for comparison",
            Self::Fit => "Fit all",
            Self::Projection => "Perspective or orthographic",
            Self::Section => "Section plane",
            Self::IntoChannel => "Look into the channel",
            Self::WholeBlisk => "Show the whole blisk",
            Self::Measure => "Measure",
            Self::Colours => "Clearance colours",
            Self::Leftover => "Residual stock colours",
            Self::Workspace(Workspace::Blisk) => "Workspace: blisk feed",
            Self::Workspace(Workspace::Mold) => "Workspace: mold",
            Self::Workspace(Workspace::Flank) => "Workspace: flank milling",
            Self::FindUncut => "Find rest material",
            Self::DesignElectrodes => "Create electrodes",
            Self::Electrodes => "Show regions or electrodes",
            Self::CompareCutters => "Compare with other cutters",
            Self::FlyToRegion => "Fly to the region",
            Self::Isolate => "Show only this region",
            Self::Layers => "Layers of the mold",
            Self::DepthColours => "Regions by depth or by number",
            Self::FaintMold => "Mold transparent or solid",
            Self::MillFlanks => "Mill the electrode's flanks",
            Self::PlanFlank => "Plan the flank's path",
            Self::NextPath => "Next of initial, chosen and refined path",
            Self::SideBySide => "Initial, chosen and refined side by side",
            Self::FaceFlank => "View normal to the flank",
            Self::ShowCutter => "Show or hide the cutter",
            Self::AxisSurface => "Show or hide the axis surface",
            Self::Rulings => "Show or hide rulings",
            Self::MovingCutter => "Swept envelope or static deviation",
            Self::FoldPanel => "Show or fold the panel on the left",
            Self::FoldList => "Show or fold the panel on the right",
            Self::Screenshot => "Save picture…",
            Self::Theme => "Dark or light",
            Self::Palette => "Commands…",
            Self::Log => "Log",
            Self::About => "About Sparkpath",
            Self::View(view) => return format!("View {}", view.name()),
            Self::Step(stage) => return format!("Step {}: {}", stage.number(), stage.name()),
        };
        fixed.to_owned()
    }

    /// Its keys.
    pub fn shortcut(self) -> Option<KeyboardShortcut> {
        const NONE: Modifiers = Modifiers::NONE;
        const CTRL: Modifiers = Modifiers::COMMAND;
        let both = Modifiers::COMMAND | Modifiers::SHIFT;
        let (modifiers, key) = match self {
            Self::Open => (CTRL, Key::O),
            Self::Reload => (CTRL, Key::R),
            Self::Save => (CTRL, Key::S),
            Self::SaveAs => (both, Key::S),
            Self::Quit => (CTRL, Key::Q),
            Self::Undo => (CTRL, Key::Z),
            Self::Redo => (both, Key::Z),
            Self::Preferences => (CTRL, Key::Comma),
            Self::Plan => (NONE, Key::F5),
            Self::FindUncut => (NONE, Key::F6),
            Self::DesignElectrodes => (NONE, Key::F7),
            Self::PlanFlank => (NONE, Key::F8),
            Self::NextPath => (NONE, Key::N),
            Self::SideBySide => (NONE, Key::V),
            Self::FaceFlank => (NONE, Key::Num5),
            Self::ShowCutter => (NONE, Key::T),
            Self::AxisSurface => (NONE, Key::A),
            Self::MovingCutter => (NONE, Key::W),
            Self::Electrodes => (NONE, Key::E),
            Self::Isolate => (NONE, Key::I),
            Self::Layers => (NONE, Key::L),
            Self::DepthColours => (NONE, Key::D),
            Self::Cancel => (NONE, Key::Escape),
            Self::Export => (CTRL, Key::E),
            Self::Play => (NONE, Key::Space),
            Self::NextNode => (NONE, Key::ArrowRight),
            Self::PreviousNode => (NONE, Key::ArrowLeft),
            Self::FirstNode => (NONE, Key::Home),
            Self::LastNode => (NONE, Key::End),
            Self::Ghost => (NONE, Key::G),
            Self::Fit => (NONE, Key::F),
            Self::Projection => (NONE, Key::P),
            Self::Section => (NONE, Key::X),
            Self::IntoChannel => (NONE, Key::C),
            Self::WholeBlisk => (NONE, Key::B),
            Self::Measure => (NONE, Key::M),
            Self::Palette => (CTRL, Key::K),
            Self::Log => (CTRL, Key::L),
            Self::View(StandardView::Isometric) => (NONE, Key::Num0),
            Self::View(StandardView::Front) => (NONE, Key::Num1),
            Self::View(StandardView::Right) => (NONE, Key::Num3),
            Self::View(StandardView::Top) => (NONE, Key::Num7),
            _ => return None,
        };
        Some(KeyboardShortcut::new(modifiers, key))
    }

    /// Whether its keys are those that text fields and sliders need for themselves.
    fn yields_to_focus(self) -> bool {
        self.shortcut().is_some_and(|s| {
            s.modifiers == Modifiers::NONE && !matches!(s.logical_key, Key::F5 | Key::F6 | Key::F7 | Key::F8)
        })
    }

    /// Its name with its keys, for a tooltip.
    pub fn hint(self, ctx: &egui::Context) -> String {
        match self.shortcut() {
            Some(keys) => format!("{}  ({})", self.name(), ctx.format_shortcut(&keys)),
            None => self.name(),
        }
    }

    /// Whether it can be done now.
    pub fn is_enabled(self, core: &Core) -> bool {
        let (mold, is_of_mold) = (&core.mold, core.workspace == Workspace::Mold);
        match self {
            _ if !self.is_of_workspace(core.workspace) => false,
            Self::Cancel if core.opening.is_busy() => true,
            _ if core.workspace == Workspace::Flank => self.is_enabled_for_flank(&core.flank),
            Self::MillFlanks if is_of_mold => mold.is_designed() && mold.electrodes.chosen().is_some(),
            Self::MillFlanks => {
                core.pipeline.state(Stage::Electrode) == StageState::Done && core.shown_electrode().is_some()
            }
            Self::Cancel if is_of_mold => mold.work.is_busy() || mold.electrodes.split.is_some(),
            Self::FindUncut | Self::DesignElectrodes => mold.work.mold_state(&mold.params) == State::Ready,
            Self::Electrodes => mold.electrodes.designed().is_some(),
            Self::FlyToRegion | Self::Isolate if mold.electrodes.seen().is_some() => mold.electrodes.chosen().is_some(),
            Self::Section | Self::Play | Self::NextNode | Self::PreviousNode | Self::FirstNode | Self::LastNode
                if is_of_mold =>
            {
                mold.electrodes.seen().is_some() && mold.electrodes.chosen().is_some()
            }
            Self::Export if is_of_mold => mold.is_designed(),
            Self::CompareCutters => mold.state() == State::Ready,
            Self::FlyToRegion | Self::Isolate => mold.selected.is_some(),
            Self::Layers if mold.electrodes.seen().is_some() => false,
            Self::Layers => mold.found().is_some_and(|found| !found.uncut.layers.is_empty()),
            Self::Undo | Self::Redo if is_of_mold => mold.undo_label(self == Self::Redo).is_some(),
            Self::Undo => core.document.undo_label().is_some(),
            Self::Redo => core.document.redo_label().is_some(),
            // A job file names a mesh file.
            Self::SaveJob => core.document.job().blisk.mesh.is_some(),
            Self::Plan => core.can_plan(),
            Self::Cancel => core.pipeline.is_busy(),
            Self::Keep => core.can_keep(),
            Self::Release => core.pipeline.can_release() && core.pipeline.released().is_none(),
            Self::Withdraw | Self::Export => core.pipeline.released().is_some(),
            Self::Ghost => !core.track().is_empty() && core.feed_cursor().is_some(),
            Self::Play | Self::NextNode | Self::PreviousNode | Self::FirstNode | Self::LastNode => {
                !core.track().is_empty()
            }
            Self::Colours => core.pipeline.state(Stage::Electrode) != StageState::Missing,
            Self::Leftover => core.leftover_shape().is_some(),
            _ => true,
        }
    }

    /// The same while flanks are shown.
    fn is_enabled_for_flank(self, flank: &FlankDesk) -> bool {
        match self {
            Self::Cancel => flank.work.is_busy(),
            Self::PlanFlank => flank.can_plan(),
            Self::Export => flank.is_planned(),
            Self::Undo | Self::Redo => flank.record.undo_label(self == Self::Redo).is_some(),
            Self::Play | Self::NextNode | Self::PreviousNode | Self::FirstNode | Self::LastNode => {
                flank.planned().is_some()
            }
            Self::NextPath | Self::SideBySide | Self::AxisSurface | Self::MovingCutter => flank.planned().is_some(),
            _ => true,
        }
    }

    /// Whether it means something in `workspace`.
    fn is_of_workspace(self, workspace: Workspace) -> bool {
        use Command as C;
        let [of_mold, of_flank] = [Workspace::Mold, Workspace::Flank].map(|one| workspace == one);
        match self {
            C::FindUncut | C::DesignElectrodes | C::Electrodes | C::CompareCutters | C::FlyToRegion => of_mold,
            C::Section => !of_flank,
            C::Play | C::NextNode | C::PreviousNode | C::FirstNode | C::LastNode | C::Export => true,
            C::Isolate | C::Layers | C::DepthColours | C::FaintMold => of_mold,
            C::FoldPanel | C::FoldList => of_mold || of_flank,
            C::MillFlanks => !of_flank,
            C::PlanFlank | C::NextPath | C::SideBySide | C::FaceFlank | C::ShowCutter => of_flank,
            C::AxisSurface | C::Rulings | C::MovingCutter => of_flank,
            C::Open | C::Reload | C::Quit | C::Preferences | C::Cancel | C::Fit | C::View(_) | C::Projection => true,
            C::Workspace(_) | C::Save | C::SaveAs | C::Undo | C::Redo => true,
            C::Screenshot | C::Theme | C::Palette | C::Log | C::About => true,
            _ => workspace == Workspace::Blisk,
        }
    }

    /// Why it is disabled, where that is not plain to see.
    pub fn needs(self) -> Option<&'static str> {
        match self {
            Self::SaveJob => Some("The demonstration blisk has no mesh file for a job: open a mesh"),
            Self::MillFlanks => Some("Select an electrode that is up to date"),
            Self::CompareCutters => Some("Find the rest material of the present cutters first"),
            Self::Keep => Some("Needs a finished plan that is up to date and not kept yet; six at most"),
            _ => None,
        }
    }

    /// The commands whose keys were pressed; `taken` tells that someone else takes keys without Ctrl.
    pub fn pressed(ctx: &egui::Context, taken: bool) -> Vec<Self> {
        let typing = taken || ctx.egui_wants_keyboard_input() || egui::Popup::is_any_open(ctx);
        // More modifiers first: Ctrl+Shift+S must not be taken for Ctrl+S.
        let mut commands = Self::all();
        commands.retain(|c| c.shortcut().is_some() && !(typing && c.yields_to_focus()));
        commands.sort_by_key(|c| c.shortcut().map(|s| std::cmp::Reverse(s.modifiers.shift)));
        ctx.input_mut(|input| {
            commands.into_iter().filter(|c| c.shortcut().is_some_and(|s| input.consume_shortcut(&s))).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_their_keys_or_their_name() {
        let all = Command::all();
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                assert!(a.shortcut().is_none() || a.shortcut() != b.shortcut(), "{a:?} and {b:?}");
                assert_ne!(a.name(), b.name());
            }
        }
    }
}
