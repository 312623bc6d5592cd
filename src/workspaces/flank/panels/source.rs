//! Source of the surface: built-in, two guide curves, or a face of a part.

use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{Align, Label, Layout, RichText, Role, Sense, Ui, WidgetInfo, vec2};
use egui_extras::{Column, TableBuilder};

use crate::widgets::form::Form;
use crate::widgets::panel_parts::{fact, notice};
use crate::widgets::theme::palette;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank};
use crate::workspaces::flank::paths::FlankPath;
use flank::fit_ruled::{Candidate, CandidateFit};
use flank::ruled_surface::Side;
use nc::flank_job::LoadedSurface;

/// Height of the list of faces (points).
const LIST: f32 = 150.0;

/// Both sides of a surface, what they are called, and what that means.
pub const SIDES: [(Side, &str, &str); 2] = [
    (Side::Positive, "+1", "Where the lower guide crossed with the ruling points to"),
    (Side::Negative, "\u{2212}1", "The other side"),
];
/// Hint while the user must choose the side.
pub const CHOOSE_SIDE: &str = "Choose the side of the cutter, away from the part: +1 or \u{2212}1";

/// Draws the fields of the source. Returns the path that the user is to choose.
pub fn show(ui: &mut Ui, desk: &FlankDesk, form: &mut Form<FlankDocument>) -> Option<FlankPath> {
    let before = form.params().clone();
    form.row(ui, "source");
    form.row(ui, "source.surface");
    let asked = take(form, &before);
    for key in ["source.lower.file", "source.upper.file", "source.file"] {
        form.row(ui, key);
    }
    if let FlankSource::Mesh(mesh) = &form.params().source.clone() {
        face(ui, desk, mesh, form);
    }
    form.row(ui, "side");
    if let (FlankSource::Guides { .. }, Side::Automatic) = (&form.params().source, form.params().side) {
        notice(ui, palette(ui).accent, CHOOSE_SIDE);
    }
    asked
}

/// Takes another source than that of `before`. Returns the purpose of the path to ask for: a source that needs files is
/// only taken once they are named.
fn take(form: &mut Form<FlankDocument>, before: &FlankDocument) -> Option<FlankPath> {
    let source = form.params().source.clone();
    if source == before.source {
        return None;
    }
    let asked = match source {
        FlankSource::Demonstration { .. } => None,
        FlankSource::Guides { .. } => Some(FlankPath::Lower),
        FlankSource::Mesh(_) => Some(FlankPath::Mesh),
    };
    form.change(|params| *params = if asked.is_some() { before.clone() } else { before.of_another(source) });
    asked
}

fn face(ui: &mut Ui, desk: &FlankDesk, mesh: &MeshFlank, form: &mut Form<FlankDocument>) {
    match &mesh.kept {
        // An electrode of ours is in mm.
        Some(kept) => fact(ui, "Electrode", kept.words()),
        None => form.row(ui, "source.units"),
    }
    for key in ["source.fit.up", "source.fit.tolerance_mm", "source.is_own_wall"] {
        form.row(ui, key);
    }
    let loaded = desk.work.loaded(desk.document.params());
    for doubt in loaded.iter().flat_map(|loaded| &loaded.doubts) {
        ui.add(Label::new(RichText::new(doubt).small().color(palette(ui).warning)).wrap());
    }
    if let Some(LoadedSurface::Face { candidates, .. }) = loaded.map(|loaded| &loaded.surface) {
        if let Some(number) = list(ui, mesh, candidates) {
            form.put("source.candidate", number.into());
        }
        if let Some(candidate) = mesh.candidate.checked_sub(1).and_then(|i| candidates.get(i)) {
            words(ui, candidate);
        }
    }
}

/// The faces that could be milled, the largest first. Returns the number of one that was clicked.
fn list(ui: &mut Ui, mesh: &MeshFlank, candidates: &[Candidate]) -> Option<usize> {
    let room = vec2(ui.available_width(), LIST.min(24.0 + 19.0 * (candidates.len() + 1) as f32));
    ui.allocate_ui(room, |ui| {
        ui.set_max_height(room.y);
        let faint = palette(ui).faint;
        let rest = (ui.available_width() - 28.0 - 66.0 - 58.0 - 72.0 - 18.0).max(20.0);
        let mut table = TableBuilder::new(ui)
            .id_salt("faces")
            .striped(true)
            .sense(Sense::click())
            .cell_layout(Layout::left_to_right(Align::Center))
            .min_scrolled_height(0.0)
            .auto_shrink([false, false]);
        for width in [28.0, 66.0 + rest, 58.0, 72.0] {
            table = table.column(Column::exact(width));
        }
        let table = table.header(18.0, |mut header| {
            for head in ["#", "form", "mm²", "error mm"] {
                header.col(|ui| drop(ui.label(RichText::new(head).small().color(faint))));
            }
        });
        let mut clicked = None;
        table.body(|body| {
            body.rows(19.0, candidates.len(), |mut row| {
                let i = row.index();
                let (candidate, is_selected) = (&candidates[i], mesh.candidate == i + 1);
                row.set_selected(is_selected);
                row.col(|ui| drop(ui.label(RichText::new((i + 1).to_string()).monospace())));
                row.col(|ui| drop(ui.add(Label::new(candidate.kind.name()).truncate())));
                row.col(|ui| drop(ui.label(RichText::new(format!("{:.1}", candidate.area_mm2)).monospace())));
                row.col(|ui| fit(ui, candidate));
                let response = row.response();
                let name = format!("Face {}", i + 1);
                response.widget_info(|| WidgetInfo::selected(Role::Row, true, is_selected, &name));
                if response.on_hover_text(candidate.summary()).clicked() {
                    clicked = Some(i + 1);
                }
            });
        });
        clicked
    })
    .inner
}

/// Distance of a face from its ruled surface, in the colour that tells whether it counts as ruled.
fn fit(ui: &mut Ui, candidate: &Candidate) {
    let colours = palette(ui);
    let (colour, text) = match &candidate.fit {
        CandidateFit::Fitted(fit) if fit.is_ruled => (colours.good, format!("{:.4}", fit.error.greatest_mm)),
        CandidateFit::Fitted(fit) => (colours.bad, format!("{:.4}", fit.error.greatest_mm)),
        CandidateFit::Refused(_) => (colours.faint, "not a strip".to_owned()),
        CandidateFit::NotTried => (colours.faint, "small".to_owned()),
    };
    ui.label(RichText::new(text).monospace().color(colour));
}

/// Facts about the chosen face.
fn words(ui: &mut Ui, candidate: &Candidate) {
    fact(ui, "Height", format!("{:.2} mm", candidate.height_mm));
    let text = match &candidate.fit {
        CandidateFit::Fitted(fit) => fit.words.join("; "),
        CandidateFit::Refused(why) => why.to_string(),
        CandidateFit::NotTried => "face too small".to_owned(),
    };
    let colour = if candidate.is_ruled() { palette(ui).faint } else { palette(ui).warning };
    ui.add(Label::new(RichText::new(crate::widgets::panel_parts::sentence(&text)).small().color(colour)).wrap());
}
