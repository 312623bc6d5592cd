//! The command palette: finds commands by a few letters of their names.

use egui::{Align2, Key, RichText, Ui, vec2};

use crate::widgets::theme::palette;
use crate::workspaces::commands::Command;
use crate::workspaces::context::Context;

/// The state of the palette: the typed text and the chosen command.
#[derive(Debug, Default)]
pub struct CommandPalette {
    open: bool,
    text: String,
    chosen: usize,
}

impl CommandPalette {
    /// Opens or closes the palette.
    pub fn toggle(&mut self) {
        *self = Self { open: !self.open, ..Self::default() };
    }

    /// Whether the palette is open and takes the keys.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Draws the palette with `commands` if it is open.
    pub fn show(
        &mut self,
        ctx: &egui::Context,
        cx: &mut Context,
        commands: Vec<Command>,
        is_enabled: impl Fn(Command) -> bool,
    ) {
        if !self.open {
            return;
        }
        let mut found = commands;
        found.retain(|c| matches(c.info.name, &self.text));
        // What can be done comes first, and of that what holds the letters as one word.
        found.sort_by_key(|c| (!is_enabled(*c), !holds(c.info.name, &self.text)));
        self.chosen = self.chosen.min(found.len().saturating_sub(1));
        let [up, down, enter, escape] = [Key::ArrowUp, Key::ArrowDown, Key::Enter, Key::Escape]
            .map(|key| ctx.input_mut(|i| i.consume_key(egui::Modifiers::NONE, key)));
        self.chosen = (self.chosen + usize::from(down)).min(found.len().saturating_sub(1));
        self.chosen = self.chosen.saturating_sub(usize::from(up));
        let mut run = if enter { found.get(self.chosen).copied() } else { None };
        let window = egui::Window::new("Commands")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, vec2(0.0, 90.0))
            .fixed_size(vec2(440.0, 340.0));
        let shown = window.show(ctx, |ui| self.list(ui, &found, &is_enabled).or(run.take()));
        let run = shown.and_then(|s| s.inner.flatten());
        if let Some(command) = run.filter(|c| is_enabled(*c)) {
            cx.push(command);
            self.open = false;
        }
        if escape {
            self.open = false;
        }
    }

    fn list(&mut self, ui: &mut Ui, found: &[Command], is_enabled: &impl Fn(Command) -> bool) -> Option<Command> {
        let field = egui::TextEdit::singleline(&mut self.text).hint_text("Type a command").desired_width(f32::INFINITY);
        let typed = ui.add(field);
        typed.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Command"));
        typed.request_focus();
        if typed.changed() {
            self.chosen = 0;
        }
        ui.add_space(4.0);
        let mut run = None;
        egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            for (i, command) in found.iter().enumerate() {
                let enabled = is_enabled(*command);
                ui.horizontal(|ui| {
                    let response =
                        ui.add_enabled(enabled, egui::Button::selectable(i == self.chosen, command.info.name));
                    if response.clicked() {
                        run = Some(*command);
                    }
                    if i == self.chosen {
                        response.scroll_to_me(None);
                    }
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        if let Some(keys) = command.info.keys {
                            let text = ui.ctx().format_shortcut(&keys);
                            ui.label(RichText::new(text).small().color(palette(ui).faint));
                        }
                    });
                });
            }
            if found.is_empty() {
                ui.label(RichText::new("No such command").color(palette(ui).faint));
            }
        });
        run
    }
}

/// Whether the letters of `typed` occur in `name` in this order, case and spaces apart.
fn matches(name: &str, typed: &str) -> bool {
    let mut letters = name.chars().flat_map(char::to_lowercase);
    typed.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).all(|c| letters.any(|l| l == c))
}

/// Whether `name` contains the text `typed`, ignoring case.
fn holds(name: &str, typed: &str) -> bool {
    name.to_lowercase().contains(&typed.trim().to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::{holds, matches};

    #[test]
    fn letters_in_order_are_enough() {
        assert!(matches("Plan feed path", "pfp") && matches("Undo", "") && matches("Save as…", "save AS"));
        assert!(!matches("Undo", "od"));
        assert!(holds("Find rest material", " find") && !holds("To the final pose", "find"));
    }
}
