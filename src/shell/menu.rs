//! The menu bar and the workspace switch.

use egui::{RichText, Role, Ui, WidgetInfo};

use super::commands::Command;
use super::core::Core;
use super::workspace::Workspace;
use render::view::StandardView;

/// Draws it. Answers a file to be opened from the list of recent ones.
pub fn show(ui: &mut Ui, core: &mut Core) -> Option<std::path::PathBuf> {
    let mut open = None;
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            item(ui, core, Command::Open);
            recent(ui, core, &mut open);
            groups(ui, core, FILE);
        });
        ui.menu_button("Edit", |ui| edit(ui, core));
        let (name, own) = match core.workspace {
            Workspace::Blisk => ("Plan", BLISK),
            Workspace::Mold => ("Mold", MOLD),
            Workspace::Flank => ("Flank", FLANK),
        };
        ui.menu_button(name, |ui| groups(ui, core, own));
        ui.menu_button("View", |ui| {
            item(ui, core, Command::Fit);
            for view in StandardView::ALL {
                item(ui, core, Command::View(view));
            }
            ui.separator();
            groups(ui, core, VIEW);
        });
        ui.menu_button("Help", |ui| groups(ui, core, HELP));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| title(ui, core));
    });
    open
}

/// Commands of a menu in groups, with a line between two of them.
type Groups = &'static [&'static [Command]];

const FILE: Groups = &[
    &[Command::NewDemonstration, Command::Reload],
    &[Command::Save, Command::SaveAs, Command::SaveJob],
    &[Command::Export, Command::Screenshot],
    &[Command::Quit],
];
const BLISK: Groups =
    &[&[Command::Plan, Command::Cancel, Command::Keep, Command::Release, Command::Withdraw], &[Command::MillFlanks]];
const MOLD: Groups = &[
    &[Command::FindUncut, Command::DesignElectrodes, Command::CompareCutters, Command::Cancel],
    &[Command::Electrodes, Command::Layers, Command::DepthColours, Command::FaintMold],
    &[Command::FoldPanel, Command::FoldList],
    &[Command::FlyToRegion, Command::Isolate, Command::MillFlanks],
];
const FLANK: Groups = &[
    &[Command::PlanFlank, Command::Cancel],
    &[Command::NextPath, Command::SideBySide, Command::FaceFlank, Command::MovingCutter],
    &[Command::ShowCutter, Command::AxisSurface, Command::Rulings],
    &[Command::FoldPanel, Command::FoldList],
];
const VIEW: Groups = &[
    &[Command::Projection, Command::Section, Command::IntoChannel, Command::WholeBlisk],
    &[Command::Measure, Command::Colours, Command::Leftover, Command::Theme],
];
const HELP: Groups = &[&[Command::Palette, Command::Log, Command::About]];

fn groups(ui: &mut Ui, core: &mut Core, groups: Groups) {
    for (i, group) in groups.iter().enumerate() {
        if i > 0 {
            ui.separator();
        }
        group.iter().for_each(|command| item(ui, core, *command));
    }
}

/// The steps that can be undone, by their names.
fn edit(ui: &mut Ui, core: &mut Core) {
    let [undo, redo] = match core.workspace {
        Workspace::Mold => [false, true].map(|again| core.mold.undo_label(again)),
        Workspace::Flank => [false, true].map(|again| core.flank.record.undo_label(again)),
        Workspace::Blisk => [core.document.undo_label(), core.document.redo_label()],
    };
    let [undo, redo] = [undo.map(|l| format!("Undo {l}")), redo.map(|l| format!("Redo {l}"))];
    named(ui, core, Command::Undo, undo);
    named(ui, core, Command::Redo, redo);
    ui.separator();
    item(ui, core, Command::Preferences);
}

/// The switch between the workspaces, always in the same place, and before it what the window is about.
fn title(ui: &mut Ui, core: &mut Core) {
    // From right to left.
    for workspace in Workspace::ALL.into_iter().rev() {
        let (name, command, on) = (workspace.name(), Command::Workspace(workspace), core.workspace == workspace);
        let response = ui.selectable_label(on, name).on_hover_text(command.hint(ui.ctx()));
        response.widget_info(|| WidgetInfo::selected(Role::Tab, true, on, format!("{name} workspace")));
        if response.clicked() {
            core.push(command);
        }
    }
    ui.separator();
    match core.workspace {
        Workspace::Blisk => document(ui, core.document.name(), core.document.is_unsaved()),
        Workspace::Mold => document(ui, core.mold.name(), core.mold.is_unsaved()),
        Workspace::Flank => document(ui, core.flank.name(), core.flank.is_unsaved()),
    }
}

fn document(ui: &mut Ui, name: String, is_unsaved: bool) {
    let dot = if is_unsaved { " •" } else { "" };
    let label = egui::Label::new(RichText::new(format!("{name}{dot}")).strong()).truncate();
    ui.add(label).on_hover_text(if is_unsaved { "There is unsaved work" } else { "Saved" });
}

fn recent(ui: &mut Ui, core: &mut Core, open: &mut Option<std::path::PathBuf>) {
    ui.menu_button("Open recent", |ui| {
        for path in core.preferences.recent.iter() {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                *open = Some(path.to_owned());
            }
        }
        if core.preferences.recent.iter().len() == 0 {
            ui.weak("None yet");
        } else {
            ui.separator();
            if ui.button("Forget these").clicked() {
                core.preferences.recent.clear();
            }
        }
    });
}

fn item(ui: &mut Ui, core: &mut Core, command: Command) {
    named(ui, core, command, None);
}

fn named(ui: &mut Ui, core: &mut Core, command: Command, name: Option<String>) {
    let mut button = egui::Button::new(name.unwrap_or_else(|| command.name()));
    if let Some(keys) = command.shortcut() {
        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
    }
    let mut response = ui.add_enabled(command.is_enabled(core), button);
    if let Some(why) = command.needs() {
        response = response.on_disabled_hover_text(why);
    }
    if response.clicked() {
        core.push(command);
        ui.close();
    }
}
