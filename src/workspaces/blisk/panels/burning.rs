//! Minutes and wear of electrodes, with what they rest on as hints.

use egui::{RichText, Ui};

use crate::widgets::panel_parts::fact;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::job::burning::BurningElectrode;
use burning::figures::{BurnFigures, hours_text, minutes_text};
use burning::schedule::Schedule;

/// A fact with a hint.
fn hinted(ui: &mut Ui, name: &str, value: String, hint: &str) {
    let shown = ui.scope(|ui| fact(ui, name, value));
    if !hint.is_empty() {
        shown.response.on_hover_text(hint);
    }
}

/// Minutes and wear of an electrode.
fn figures(ui: &mut Ui, figures: &BurnFigures) {
    let hint = figures.explanation().join("\n");
    hinted(ui, "Burning", figures.minutes_text(), &hint);
    if figures.end_wear_mm.is_none() && figures.corner_wear_mm.is_none() {
        return hinted(ui, "Wear", "not considered".to_owned(), &hint);
    }
    let wear = |wear: Option<f64>| wear.map_or_else(|| "not considered".to_owned(), |wear| format!("{wear:.4} mm"));
    hinted(ui, "End wear", wear(figures.end_wear_mm), &hint);
    hinted(ui, "Corner wear", wear(figures.corner_wear_mm), &hint);
}

/// Minutes and wear of the electrode that is shown, if its plan is up to date.
pub fn of_shown(ui: &mut Ui, desk: &BliskDesk) {
    if desk.plan_is_stale() || desk.is_live() {
        return;
    }
    let shown = desk.burned().and_then(|wheel| wheel.electrodes.get(desk.cursor.electrode));
    shown.into_iter().for_each(|electrode| figures(ui, &electrode.figures));
}

/// Minutes and wear of all electrodes, and the hours of the wheel.
pub fn show(ui: &mut Ui, desk: &BliskDesk) {
    let Some(wheel) = desk.burned() else { return };
    ui.add_space(6.0);
    ui.strong(if desk.plan_is_stale() { "Burning, out of date" } else { "Burning" });
    for electrode in &wheel.electrodes {
        let BurningElectrode { label, figures: own, .. } = electrode;
        if wheel.electrodes.len() > 1 {
            ui.label(RichText::new(format!("Electrode {label}")).color(palette(ui).faint));
        }
        if let Some(volume) = own.volume_mm3 {
            fact(ui, "Removes", format!("{volume:.1} mm³"));
        }
        figures(ui, own);
        fact(ui, &format!("For {} channels", wheel.channels), electrode.needed_text());
    }
    let hint = wheel.sentence();
    hinted(ui, "Channel", minutes_text(wheel.channel), &hint);
    hinted(ui, "Wheel", hours_text(wheel.schedule.as_ref().map(Schedule::total)), &hint);
}
