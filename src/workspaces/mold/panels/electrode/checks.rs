//! Checks of the selected electrode, in words.

use crate::workspaces::context::Context;
use crate::workspaces::mold::panels::desk::MoldDesk;
use std::collections::BTreeSet;

use egui::{RichText, Ui};

use crate::widgets::theme::{palette, tick};
use crate::workspaces::mold::work::Designed;
use crate::workspaces::news::EventKind;
use mold::electrode::design::IdleOverride;
use mold::electrode::finding::{CheckKind, Finding};

/// Draws the checks.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, made: &Designed, electrode: usize) {
    let Some(findings) = made.set.checks.get(electrode) else { return };
    for finding in findings {
        let colours = palette(ui);
        let overrides = &desk.document.params().electrodes.overrides;
        let is_decided = !finding.holds && made.set.is_overridden(electrode, finding.kind, overrides);
        let (sign, colour) = match (finding.holds, is_decided) {
            (true, _) => ("\u{2714}", colours.good),
            (false, true) => ("\u{2716}", colours.warning),
            (false, false) => ("\u{2716}", colours.bad),
        };
        ui.horizontal_top(|ui| {
            ui.label(RichText::new(sign).color(colour));
            if let Some(place) = finding.place.filter(|_| !finding.holds) {
                let name = format!("Show where: {}", finding.kind.name());
                if show_button(ui, &name).clicked()
                    && let Some(mold) = desk.work.mold()
                {
                    let (bounds, text) = (mold.shape.bounds(), in_words(finding));
                    desk.electrodes.point_at_burn(electrode, (place, text), &bounds);
                }
            }
            let text = RichText::new(in_words(finding)).small();
            let text = text.color(if finding.holds { colours.faint } else { colour });
            ui.add(egui::Label::new(text).wrap());
        });
    }
    let mut failing: Vec<CheckKind> = findings.iter().filter(|f| !f.holds).map(|f| f.kind).collect();
    if failing.is_empty() {
        return;
    }
    let of = &made.set.electrodes[electrode];
    let mut params = desk.document.params().clone();
    let overrides = &mut params.electrodes.overrides;
    let mut passes = !made.set.is_blocked_with(electrode, overrides);
    let idle = made.set.idle_overrides(overrides).into_iter().filter(|(o, _)| o.of == of.name);
    let lapsed = idle.filter(|(_, why)| matches!(why, IdleOverride::Lapsed(_)));
    let lapsed: Vec<String> = lapsed.map(|(o, why)| format!("Override of {o}: {why}.")).collect();
    let names: BTreeSet<&str> = failing.iter().map(|kind| kind.name()).collect();
    let plural = if names.len() == 1 { "fails" } else { "fail" };
    let names = names.into_iter().collect::<Vec<_>>().join(", ");
    if tick(ui, &mut passes, format!("Release despite failed check: {names} {plural}")).changed() {
        // What was decided for other parts is over with a new decision.
        overrides.retain(|other| other.of != of.name);
        if passes {
            failing.dedup();
            overrides.extend(failing.iter().map(|kind| made.set.override_of(electrode, *kind)));
        }
        // What was said last speaks of decisions too.
        let said = made.sentence(overrides);
        desk.edit(params);
        cx.say(EventKind::Done, format!("Electrodes: {said}"));
    } else {
        for text in lapsed {
            ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).warning)).wrap());
        }
    }
}

/// A check and what it found.
fn in_words(finding: &Finding) -> String {
    format!("{}: {}", finding.kind.name(), finding.text.replace("mm^3", "mm³").replace("mm^2", "mm²"))
}

/// A button that points at a place, called `name`.
pub(super) fn show_button(ui: &mut Ui, name: &str) -> egui::Response {
    let button = ui.small_button("Show").on_hover_text(name);
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(name));
    button
}
