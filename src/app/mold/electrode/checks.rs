//! What was checked of the selected electrode, in words.

use egui::{RichText, Ui};

use super::super::super::core::Core;
use super::super::super::theme::{palette, tick};
use crate::jobs::mold::Designed;

/// Draws it.
pub fn show(ui: &mut Ui, core: &mut Core, made: &Designed, electrode: usize) {
    let Some(findings) = made.set.checks.get(electrode) else { return };
    for finding in findings {
        let colours = palette(ui);
        let (sign, colour) = if finding.holds { ("\u{2714}", colours.good) } else { ("\u{2716}", colours.bad) };
        ui.horizontal_top(|ui| {
            ui.label(RichText::new(sign).color(colour));
            if let Some(place) = finding.place.filter(|_| !finding.holds) {
                let name = format!("Show where: {}", finding.kind.name());
                let button = ui.small_button("Show").on_hover_text(&name);
                if button.clicked()
                    && let Some(mold) = core.mold.work.mold()
                {
                    let bounds = mold.shape.bounds();
                    // Others would hide it.
                    core.mold.electrodes.is_alone = true;
                    core.mold.electrodes.point_at(place, &bounds);
                }
            }
            let text = format!("{}: {}", finding.kind.name(), finding.text.replace("mm^3", "mm³"));
            let text = RichText::new(text).small();
            let text = if finding.holds { text.color(colours.faint) } else { text.color(colours.bad) };
            ui.add(egui::Label::new(text).wrap());
        });
    }
    let failing: Vec<&str> = findings.iter().filter(|f| !f.holds).map(|f| f.kind.name()).collect();
    if failing.is_empty() {
        return;
    }
    let name = &made.set.electrodes[electrode].name;
    let mut params = core.mold.params.clone();
    let overrides = &mut params.electrodes.overrides;
    let mut passes = overrides.contains(name);
    let plural = if failing.len() == 1 { "fails" } else { "fail" };
    if tick(ui, &mut passes, format!("Export although {} {plural}", failing.join(", "))).changed() {
        if passes {
            overrides.push(name.clone());
        } else {
            overrides.retain(|other| other != name);
        }
        core.mold.edit(params);
    }
}
