//! The scan of the finished part: verdict, how it was moved, and its deviations by surface and by channel.

use egui::{RichText, Ui};

use crate::widgets::panel_parts::{grouped, notice, sentence};
use crate::widgets::theme::palette;
use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::context::Context;
use measured::deviation::Statistics;
use task::State;

/// Draws what is known of the scan of the document, if it has one.
pub fn show(ui: &mut Ui, desk: &BliskDesk, cx: &mut Context) {
    match desk.scan_state() {
        State::Missing => return,
        State::Failed(why) => return notice(ui, palette(ui).bad, &format!("Scan: {why}")),
        State::Running => return notice(ui, palette(ui).faint, "Comparing the scan with the part\u{2026}"),
        _ => {}
    }
    let Some(shown) = desk.scan() else { return };
    let part = &shown.part;
    ui.add_space(6.0);
    ui.strong("Scanned part");
    let colour = if part.verdict.is_within { palette(ui).good } else { palette(ui).bad };
    notice(ui, colour, &sentence(&format!("{}.", part.verdict)));
    for text in part.fit_sentences() {
        notice(ui, palette(ui).faint, &text);
    }
    if part.beyond_reach > 0 {
        notice(
            ui,
            palette(ui).faint,
            &format!("{} points lie beyond reach and do not count.", grouped(part.beyond_reach)),
        );
    }
    let text = if desk.deviations { "Show the electrode" } else { "Show the deviations" };
    cx.button(ui, desk, BliskCommand::Deviations, text, false);
    ui.add_space(4.0);
    table(ui, "Surface", part.by_surface.iter().map(|(name, of)| (name.clone(), of)));
    if !part.by_channel.is_empty() {
        ui.add_space(4.0);
        table(ui, "Channel", part.by_channel.iter().map(|(number, of)| (number.to_string(), of)));
    }
    ui.add_space(4.0);
    ui.label(RichText::new("Worst places, mm").small().color(palette(ui).faint));
    for worst in &part.worst {
        let (p, surface) = (worst.deviation.point, &worst.surface);
        let text = format!("{:+.4}", worst.deviation.distance);
        ui.horizontal(|ui| {
            ui.label(RichText::new(text).monospace());
            let place = format!("{surface} at {:.2}, {:.2}, {:.2}", p.x, p.y, p.z);
            ui.add(egui::Label::new(RichText::new(place).color(palette(ui).faint)).truncate());
        });
    }
}

/// A row for each of the parts of a scan: least and greatest deviation, and the share within the tolerance.
fn table<'a>(ui: &mut Ui, head: &str, rows: impl Iterator<Item = (String, &'a Statistics)>) {
    /// Room for the figures beside the names (points).
    const FIGURES: f32 = 185.0;
    let faint = palette(ui).faint;
    let names = (ui.available_width() - FIGURES).clamp(60.0, 180.0);
    egui::Grid::new(head).num_columns(4).min_col_width(0.0).spacing([8.0, 3.0]).striped(true).show(ui, |ui| {
        for head in [head, "least mm", "greatest", "within"] {
            ui.label(RichText::new(head).small().color(faint));
        }
        ui.end_row();
        for (name, of) in rows {
            let colour = if of.within < of.points { palette(ui).warning } else { ui.visuals().text_color() };
            ui.scope(|ui| {
                ui.set_max_width(names);
                let hint = format!("{name}: {} points, mean {:+.4} mm", grouped(of.points), of.mean_mm);
                ui.add(egui::Label::new(name).truncate()).on_hover_text(hint);
            });
            for value in [of.least_mm, of.greatest_mm] {
                ui.label(RichText::new(format!("{value:+.3}")).monospace());
            }
            ui.label(RichText::new(format!("{:.1} %", 100.0 * of.share_within)).monospace().color(colour));
            ui.end_row();
        }
    });
}
