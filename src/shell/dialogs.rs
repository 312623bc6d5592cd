//! Dialogs of the window: unsaved work, recovery, preferences, paths, errors, log, about.

use std::path::{Path, PathBuf};

use egui::{Align2, Id, Modal, RichText, Ui};

use super::files::Purpose;
use super::status::colour_of;
use crate::widgets::panel_parts::{from_right, sentence};
use crate::widgets::theme::palette;
use crate::workspaces::context::Context;
use crate::workspaces::preferences::{LengthUnit, Navigation, Preferences, ThemeChoice};
use crate::workspaces::workspace::Workspace;
use files::{Recovery, Saving};

/// The question to the user, one at a time.
#[derive(Default)]
pub enum Dialog {
    /// No question.
    #[default]
    None,
    /// Unsaved work of this workspace would be lost by the intent.
    Unsaved(usize, Intent),
    /// An earlier run of the program left unsaved work.
    Recover(Vec<Recovery>),
    /// Preferences.
    Preferences,
    /// The dialog of this workspace.
    Workspace(usize),
    /// A path to type, because the system has no file dialogs or the user prefers typing.
    Path(Purpose, String),
    /// A chosen file exists already.
    Overwrite(Purpose, PathBuf),
    /// Another program has changed the file in which the document of this workspace was to be saved.
    Changed(usize, Saving),
    /// About the program.
    About,
    /// An error: title and text.
    Error(String, String),
}

impl Dialog {
    /// Whether both ask the same.
    pub fn is_alike(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Path(a, _), Self::Path(b, _)) | (Self::Overwrite(a, _), Self::Overwrite(b, _)) => a == b,
            (Self::Workspace(a), Self::Workspace(b)) => a == b,
            (Self::Changed(a, _), Self::Changed(b, _)) => a == b,
            // Each has its own to tell.
            (Self::Error(..), Self::Error(..)) => false,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

/// Action that follows once unsaved work is dealt with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Intent {
    /// Ends the program.
    Quit,
    /// Replaces the document of this workspace.
    Replace(usize),
}

impl Intent {
    /// Whether the document of this workspace would be lost.
    pub fn endangers(self, workspace: usize) -> bool {
        match self {
            Self::Quit => true,
            Self::Replace(replaced) => replaced == workspace,
        }
    }
}

/// Answer of the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// Save, then carry out the intent.
    SaveThen(Intent),
    /// Carry out the intent without saving.
    Discard(Intent),
    /// Recover the work of this copy.
    Recover(usize),
    /// Remove the copies.
    ForgetCopies,
    /// Take this path.
    Path(Purpose, PathBuf),
    /// Overwrite the file.
    Overwrite,
    /// Save under another name.
    SaveCopy,
    /// Read the file again in place of the document.
    ReadAgain,
    /// Close the dialog.
    Close,
}

/// Draws the dialog. Returns the answer of the user.
pub fn show(
    ctx: &egui::Context,
    (workspaces, cx): (&mut [Box<dyn Workspace>], &mut Context),
    dialog: &mut Dialog,
    adapter: &str,
) -> Option<Answer> {
    let title = match dialog {
        Dialog::None => return None,
        Dialog::Unsaved(..) => "Unsaved work",
        Dialog::Recover(_) => "Recovered work",
        Dialog::Preferences => "Preferences",
        Dialog::Workspace(i) => workspaces[*i].dialog_title(),
        Dialog::Path(purpose, _) => purpose.info.title,
        Dialog::Overwrite(..) => "Replace this file?",
        Dialog::Changed(..) => "The file has changed",
        Dialog::About => "About Sparkpath",
        Dialog::Error(title, _) => title,
    }
    .to_owned();
    let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(16);
    // Each dialog has a size of its own.
    let response = Modal::new(Id::unique("dialog").with(&title)).frame(frame).show(ctx, |ui| {
        // A small window, or one drawn large, shows as much as it can and scrolls.
        let room = ctx.content_rect().size() - egui::vec2(64.0, 80.0);
        ui.set_width(room.x.min(440.0));
        ui.heading(title);
        ui.add_space(6.0);
        let height = room.y.max(120.0);
        let scroll = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        scroll.show(ui, |ui| contents(ui, (workspaces, cx), dialog, adapter)).inner
    });
    let closes = response.should_close();
    let answer = response.inner;
    if answer.is_none() && closes && !matches!(dialog, Dialog::Recover(_)) {
        return Some(Answer::Close);
    }
    answer
}

fn contents(
    ui: &mut Ui,
    (workspaces, cx): (&mut [Box<dyn Workspace>], &mut Context),
    dialog: &mut Dialog,
    adapter: &str,
) -> Option<Answer> {
    match dialog {
        Dialog::None => None,
        Dialog::Unsaved(work, intent) => unsaved(ui, &*workspaces[*work], *intent),
        Dialog::Recover(copies) => recover(ui, copies),
        Dialog::Preferences => preferences(ui, &mut cx.preferences),
        Dialog::Workspace(i) => {
            cx.take_turn(*i);
            workspaces[*i].dialog(ui, cx).then_some(Answer::Close)
        }
        Dialog::Path(purpose, text) => path(ui, purpose, text, cx.preferences.types_paths),
        Dialog::Overwrite(_, path) => {
            ui.label(format!("{} exists already and would be replaced.", path.display()));
            buttons(ui, &[("Replace", Answer::Overwrite), ("Cancel", Answer::Close)])
        }
        Dialog::Changed(_, saving) => changed(ui, saving.file()),
        Dialog::About => about(ui, adapter),
        Dialog::Error(_, text) => {
            ui.label(&*text);
            let closed = ui.input(|i| i.key_pressed(egui::Key::Enter)).then_some(Answer::Close);
            buttons(ui, &[("Close", Answer::Close)]).or(closed)
        }
    }
}

/// Buttons from right to left; the first one confirms.
fn buttons(ui: &mut Ui, all: &[(&str, Answer)]) -> Option<Answer> {
    ui.add_space(10.0);
    let mut answer = None;
    from_right(ui, |ui| {
        for (name, means) in all {
            if ui.button(*name).clicked() {
                answer = Some(means.clone());
            }
        }
    });
    answer
}

fn unsaved(ui: &mut Ui, workspace: &dyn Workspace, intent: Intent) -> Option<Answer> {
    ui.label(format!("{}: {} has unsaved changes.", workspace.about().name, workspace.document().name()));
    buttons(
        ui,
        &[("Save", Answer::SaveThen(intent)), ("Don't save", Answer::Discard(intent)), ("Cancel", Answer::Close)],
    )
}

fn changed(ui: &mut Ui, file: &Path) -> Option<Answer> {
    ui.label(format!("{} was changed by another program since it was read. Nothing was saved yet.", file.display()));
    let copy = ui.button("Save under another name…").on_hover_text("Both stay").clicked();
    let again =
        ui.button("Read it again").on_hover_text("The file's content takes the place of what is open").clicked();
    let answer = buttons(ui, &[("Replace it", Answer::Overwrite), ("Cancel", Answer::Close)]);
    let answer = answer.or(again.then_some(Answer::ReadAgain));
    if copy { Some(Answer::SaveCopy) } else { answer }
}

fn recover(ui: &mut Ui, copies: &[Recovery]) -> Option<Answer> {
    ui.label("The program ended without saving. Recovered work:");
    let mut answer = None;
    for (i, copy) in copies.iter().enumerate() {
        ui.horizontal(|ui| {
            let age = copy.written().and_then(|t| t.elapsed().ok()).map(|d| d.as_secs() / 60);
            let age = age.map(|m| format!("{m} min ago")).unwrap_or_default();
            if ui.button("Recover").clicked() {
                answer = Some(Answer::Recover(i));
            }
            let label = ui.label(copy.title());
            copy.file.iter().for_each(|file| drop(label.clone().on_hover_text(file.display().to_string())));
            ui.label(RichText::new(age).color(palette(ui).faint));
        });
    }
    answer.or(buttons(ui, &[("Later", Answer::Close), ("Discard", Answer::ForgetCopies)]))
}

fn preferences(ui: &mut Ui, p: &mut Preferences) -> Option<Answer> {
    egui::Grid::new("preferences").num_columns(2).spacing([18.0, 8.0]).show(ui, |ui| {
        let faint = palette(ui).faint;
        ui.label(RichText::new("Theme").color(faint));
        ui.horizontal(|ui| {
            for (value, name) in
                [(ThemeChoice::Dark, "Dark"), (ThemeChoice::Light, "Light"), (ThemeChoice::System, "System")]
            {
                ui.selectable_value(&mut p.theme, value, name);
            }
        });
        ui.end_row();
        ui.label(RichText::new("Scale").color(faint));
        ui.horizontal(|ui| {
            for scale in Preferences::SCALES {
                ui.selectable_value(&mut p.scale, scale, format!("{:.0} %", 100.0 * scale));
            }
        });
        ui.end_row();
        ui.label(RichText::new("Lengths shown in").color(faint));
        ui.horizontal(|ui| {
            ui.selectable_value(&mut p.length, LengthUnit::Millimetre, "mm");
            ui.selectable_value(&mut p.length, LengthUnit::Inch, "inch");
        });
        ui.end_row();
        ui.label(RichText::new("Navigation").color(faint));
        ui.horizontal(|ui| {
            ui.selectable_value(&mut p.navigation, Navigation::Cad, "CAD");
            ui.selectable_value(&mut p.navigation, Navigation::Blender, "Blender");
        });
        ui.end_row();
        ui.label("");
        ui.label(RichText::new(p.navigation.describe()).small().color(faint));
        ui.end_row();
        ui.label(RichText::new("While a slider moves").color(faint));
        let live = ui.checkbox(&mut p.live, "preview the extraction path");
        live.on_hover_text("Global strategy: a preview at every change, a certified plan when the slider rests");
        ui.end_row();
        ui.label(RichText::new("File dialogs").color(faint));
        ui.horizontal(|ui| {
            for (value, name, hint) in [
                (false, "choose", "Dialogs of the system, where available"),
                (true, "type", "Type paths in this window"),
            ] {
                ui.selectable_value(&mut p.types_paths, value, name).on_hover_text(hint);
            }
        });
        ui.end_row();
        let label = ui.label(RichText::new("Threads").color(faint));
        ui.horizontal(|ui| {
            ui.add(egui::DragValue::new(&mut p.threads).range(0..=1024)).labelled_by(label.id);
            ui.label(RichText::new("0: one for each core; takes effect at the next start").small().color(faint));
        });
        ui.end_row();
    });
    buttons(ui, &[("Close", Answer::Close)])
}

fn path(ui: &mut Ui, purpose: &Purpose, text: &mut String, is_preferred: bool) -> Option<Answer> {
    let why = if is_preferred {
        ""
    } else {
        "This system has no file dialogs (no portal that chooses files, and no zenity). "
    };
    let label = ui.label(format!("{why}Type or paste the path:"));
    let mut edited = egui::TextEdit::singleline(text).desired_width(f32::INFINITY).show(ui);
    let field = edited.response.response.clone().labelled_by(label.id);
    if !field.has_focus() && !field.lost_focus() {
        field.request_focus();
        // What is proposed is replaced by what is typed.
        let all =
            egui::text::CCursorRange::two(egui::text::CCursor::new(0), egui::text::CCursor::new(text.chars().count()));
        edited.state.cursor.set_char_range(Some(all));
        edited.state.store(ui.ctx(), field.id);
    }
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
    let chosen = Answer::Path(*purpose, PathBuf::from(text.trim()));
    let answer = buttons(ui, &[("OK", chosen.clone()), ("Cancel", Answer::Close)]);
    let answer = if entered { Some(chosen) } else { answer };
    answer.filter(|a| !matches!(a, Answer::Path(_, path) if path.as_os_str().is_empty()))
}

fn about(ui: &mut Ui, adapter: &str) -> Option<Answer> {
    ui.label(format!("Sparkpath {}", env!("CARGO_PKG_VERSION")));
    ui.label("Feed paths for EDM electrodes, electrodes for molds, five-axis flank milling. MIT or Apache-2.0.");
    ui.label(RichText::new(adapter).small().color(palette(ui).faint));
    buttons(ui, &[("Close", Answer::Close)])
}

/// Draws the log in a window of its own.
pub fn log(ctx: &egui::Context, cx: &Context, open: &mut bool) {
    let window =
        egui::Window::new("Log").open(open).default_size([560.0, 260.0]).anchor(Align2::LEFT_BOTTOM, [12.0, -40.0]);
    window.show(ctx, |ui| {
        egui::ScrollArea::vertical().stick_to_bottom(true).auto_shrink([false, false]).show(ui, |ui| {
            for line in &cx.log {
                let ago = line.at.elapsed().map(|d| d.as_secs()).unwrap_or_default();
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(format!("{ago:>4} s ago")).monospace().color(palette(ui).faint));
                    ui.label(RichText::new(sentence(&line.text)).color(colour_of(ui, line.kind)));
                    if let Some(took) = line.took {
                        ui.label(RichText::new(format!("{:.1} s", took.as_secs_f64())).color(palette(ui).faint));
                    }
                });
            }
            if cx.log.is_empty() {
                ui.weak("No messages yet.");
            }
        });
    });
}
