//! The menu bar and the workspace switch.

use egui::{RichText, Role, Ui, WidgetInfo};

use super::commands::Command;
use super::core::Core;
use super::workspace::Workspace;
use crate::render::view::StandardView;

/// Draws it. Answers a file to be opened from the list of recent ones.
pub fn show(ui: &mut Ui, core: &mut Core) -> Option<std::path::PathBuf> {
    let mut open = None;
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            item(ui, core, Command::Open);
            recent(ui, core, &mut open);
            item(ui, core, Command::NewDemonstration);
            item(ui, core, Command::Reload);
            ui.separator();
            item(ui, core, Command::Save);
            item(ui, core, Command::SaveAs);
            item(ui, core, Command::SaveJob);
            ui.separator();
            item(ui, core, Command::Export);
            item(ui, core, Command::Screenshot);
            ui.separator();
            item(ui, core, Command::Quit);
        });
        ui.menu_button("Edit", |ui| {
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
        });
        if core.workspace == Workspace::Blisk {
            ui.menu_button("Plan", |ui| {
                for command in [Command::Plan, Command::Cancel, Command::Keep, Command::Approve, Command::Withdraw] {
                    item(ui, core, command);
                }
                ui.separator();
                item(ui, core, Command::MillFlanks);
            });
        }
        if core.workspace == Workspace::Mold {
            ui.menu_button("Mold", |ui| {
                for command in [Command::FindUncut, Command::DesignElectrodes, Command::CompareCutters, Command::Cancel]
                {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::Electrodes, Command::Layers, Command::DepthColours, Command::FaintMold] {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::FoldPanel, Command::FoldList] {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::FlyToRegion, Command::Isolate, Command::MillFlanks] {
                    item(ui, core, command);
                }
            });
        }
        if core.workspace == Workspace::Flank {
            ui.menu_button("Flank", |ui| {
                for command in [Command::PlanFlank, Command::Cancel] {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::NextPath, Command::SideBySide, Command::FaceFlank, Command::MovingCutter] {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::ShowCutter, Command::AxisSurface, Command::Rulings] {
                    item(ui, core, command);
                }
                ui.separator();
                for command in [Command::FoldPanel, Command::FoldList] {
                    item(ui, core, command);
                }
            });
        }
        ui.menu_button("View", |ui| {
            item(ui, core, Command::Fit);
            for view in StandardView::ALL {
                item(ui, core, Command::View(view));
            }
            ui.separator();
            for command in [Command::Projection, Command::Section, Command::IntoChannel, Command::WholeBlisk] {
                item(ui, core, command);
            }
            ui.separator();
            for command in [Command::Measure, Command::Colours, Command::Leftover, Command::Theme] {
                item(ui, core, command);
            }
        });
        ui.menu_button("Help", |ui| {
            for command in [Command::Palette, Command::Log, Command::About] {
                item(ui, core, command);
            }
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| title(ui, core));
    });
    open
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
