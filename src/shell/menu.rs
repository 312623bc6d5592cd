//! The menu bar and the workspace switch.

use egui::{RichText, Role, Ui, WidgetInfo};

use crate::workspaces::commands::{Command, CommandSet, FrameCommand, Groups};
use crate::workspaces::context::Context;
use crate::workspaces::workspace::{Menu, Workspace};
use render::view::StandardView;

/// Draws the menu bar for the workspace that is shown. Returns a file chosen among the recent ones.
pub fn show(
    ui: &mut Ui,
    (workspaces, shown): (&[Box<dyn Workspace>], usize),
    cx: &mut Context,
) -> Option<std::path::PathBuf> {
    use FrameCommand as F;
    let mut open = None;
    let here = &*workspaces[shown];
    let of = |all: &[F]| all.iter().map(|command| command.command()).collect::<Vec<_>>();
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            item(ui, here, cx, F::Open.command());
            recent(ui, cx, &mut open);
            let new = [here.menu(Menu::New).concat(), of(&[F::Reload])].concat();
            let save = [of(&[F::Save, F::SaveAs]), here.menu(Menu::Save).concat()].concat();
            groups(ui, here, cx, &vec![new, save, of(&[F::Export, F::Screenshot, F::Study]), of(&[F::Quit])]);
        });
        ui.menu_button("Edit", |ui| edit(ui, here, cx));
        ui.menu_button(here.about().menu, |ui| groups(ui, here, cx, &here.menu(Menu::Own)));
        ui.menu_button("View", |ui| {
            item(ui, here, cx, F::Fit.command());
            for view in StandardView::ALL {
                item(ui, here, cx, F::View(view).command());
            }
            ui.separator();
            item(ui, here, cx, F::Projection.command());
            groups(ui, here, cx, &here.menu(Menu::View));
            item(ui, here, cx, F::Theme.command());
        });
        ui.menu_button("Help", |ui| groups(ui, here, cx, &vec![of(&[F::Palette, F::Log, F::About])]));
        let layout = egui::Layout::right_to_left(egui::Align::Center);
        ui.with_layout(layout, |ui| title(ui, (workspaces, shown), cx));
    });
    open
}

fn groups(ui: &mut Ui, here: &dyn Workspace, cx: &mut Context, groups: &Groups) {
    for (i, group) in groups.iter().enumerate() {
        if i > 0 {
            ui.separator();
        }
        group.iter().for_each(|command| item(ui, here, cx, *command));
    }
}

/// Undo and redo with the names of their steps.
fn edit(ui: &mut Ui, here: &dyn Workspace, cx: &mut Context) {
    let [undo, redo] = [false, true].map(|again| here.document().undo_label(again));
    named(ui, here, cx, FrameCommand::Undo.command(), undo.map(|l| format!("Undo {l}")));
    named(ui, here, cx, FrameCommand::Redo.command(), redo.map(|l| format!("Redo {l}")));
    ui.separator();
    item(ui, here, cx, FrameCommand::Preferences.command());
}

/// The switch between the workspaces, always in the same place, and before it the title.
fn title(ui: &mut Ui, (workspaces, shown): (&[Box<dyn Workspace>], usize), cx: &mut Context) {
    // From right to left.
    for (i, workspace) in workspaces.iter().enumerate().rev() {
        let (about, on) = (workspace.about(), i == shown);
        let response = ui.selectable_label(on, about.name).on_hover_text(about.switch.hint(ui.ctx()));
        response.widget_info(|| WidgetInfo::selected(Role::Tab, true, on, format!("{} workspace", about.name)));
        if response.clicked() {
            cx.push(Command::switch(i, &about.switch));
        }
    }
    ui.separator();
    let shown = workspaces[shown].document();
    document(ui, shown.name(), shown.is_unsaved());
}

fn document(ui: &mut Ui, name: String, is_unsaved: bool) {
    let dot = if is_unsaved { " •" } else { "" };
    let label = egui::Label::new(RichText::new(format!("{name}{dot}")).strong()).truncate();
    ui.add(label).on_hover_text(if is_unsaved { "There is unsaved work" } else { "Saved" });
}

fn recent(ui: &mut Ui, cx: &mut Context, open: &mut Option<std::path::PathBuf>) {
    ui.menu_button("Open recent", |ui| {
        for path in cx.preferences.recent.iter() {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                *open = Some(path.to_owned());
            }
        }
        if cx.preferences.recent.iter().len() == 0 {
            ui.weak("None yet");
        } else {
            ui.separator();
            if ui.button("Forget these").clicked() {
                cx.preferences.recent.clear();
            }
        }
    });
}

fn item(ui: &mut Ui, here: &dyn Workspace, cx: &mut Context, command: Command) {
    named(ui, here, cx, command, None);
}

fn named(ui: &mut Ui, here: &dyn Workspace, cx: &mut Context, command: Command, name: Option<String>) {
    let mut button = egui::Button::new(name.unwrap_or_else(|| command.info.name.to_owned()));
    if let Some(keys) = command.info.keys {
        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
    }
    let mut response = ui.add_enabled(here.is_enabled(command), button);
    if let Some(why) = command.info.needs {
        response = response.on_disabled_hover_text(why);
    }
    if response.clicked() {
        cx.push(command);
        ui.close();
    }
}
