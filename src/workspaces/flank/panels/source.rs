//! Where the surface comes from: the program itself, two guide curves, or a face of a part.

use crate::workspaces::flank::panels::FlankDesk;
use egui::{Align, ComboBox, Label, Layout, RichText, Role, Sense, Ui, WidgetInfo, vec2};
use egui_extras::{Column, TableBuilder};

use super::fields::{self, Number};
use super::form;
use crate::widgets::panel_parts::fact;
use crate::widgets::panel_parts::file_name;
use crate::widgets::panel_parts::named;
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::document::{DemonstrationSurface, FlankDocument, FlankSource, GuideSource, MeshFlank};
use crate::workspaces::flank::paths::FlankPath;
use flank::fit_ruled::{Candidate, CandidateFit};
use import::Units;
use nc::flank_job::LoadedSurface;

/// Height of the list of faces (points).
const LIST: f32 = 150.0;

/// What the list of sources offers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    A,
    B,
    Guides,
    Mesh,
}

impl Kind {
    const ALL: [Self; 4] = [Self::A, Self::B, Self::Guides, Self::Mesh];

    fn of(source: &FlankSource) -> Self {
        match source {
            FlankSource::Demonstration { surface: DemonstrationSurface::A } => Self::A,
            FlankSource::Demonstration { surface: DemonstrationSurface::B } => Self::B,
            FlankSource::Guides { .. } => Self::Guides,
            FlankSource::Mesh(_) => Self::Mesh,
        }
    }

    fn name(self) -> &'static str {
        ["demonstration, surface A", "demonstration, surface B", "two guide curves", "face of a part"][self as usize]
    }
}

/// Draws it. Answers what a path is wanted for.
pub fn show(
    ui: &mut Ui,
    desk: &FlankDesk,
    params: &mut FlankDocument,
    wrong: &mut Option<String>,
) -> Option<FlankPath> {
    let mut asked = None;
    let now = Kind::of(&params.source);
    named(ui, "From", |ui, label| {
        let combo = ComboBox::from_id_salt("flank source").selected_text(now.name()).width(176.0);
        let shown = combo.show_ui(ui, |ui| {
            for kind in Kind::ALL {
                if ui.selectable_label(kind == now, kind.name()).clicked() && kind != now {
                    asked = take(params, kind);
                }
            }
        });
        shown.response.labelled_by(label);
    });
    match &mut params.source {
        FlankSource::Demonstration { .. } => {}
        FlankSource::Guides { lower, upper } => {
            for (name, guide, what) in [("Lower", lower, FlankPath::Lower), ("Upper", upper, FlankPath::Upper)] {
                named(ui, name, |ui, _| {
                    let text = match guide {
                        GuideSource::File(file) => file_name(&file.to_string_lossy()),
                        GuideSource::Curve(_) => "from the project file".to_owned(),
                    };
                    let response = ui.add_sized(vec2(176.0, 22.0), egui::Button::new(text).truncate());
                    if response.on_hover_text("Points of the curve: x, y, z in mm on each line of a CSV file").clicked()
                    {
                        asked = Some(what);
                    }
                });
            }
        }
        FlankSource::Mesh(mesh) => asked = face(ui, desk, mesh, wrong).or(asked),
    }
    form::side(ui, &params.source, &mut params.side);
    asked
}

/// Changes the source. Answers what a path is wanted for: what needs files is only taken once they are named.
fn take(params: &mut FlankDocument, kind: Kind) -> Option<FlankPath> {
    let surface = match kind {
        Kind::A => DemonstrationSurface::A,
        Kind::B => DemonstrationSurface::B,
        Kind::Guides => return Some(FlankPath::Lower),
        Kind::Mesh => return Some(FlankPath::Mesh),
    };
    *params = params.of_another(FlankSource::Demonstration { surface });
    None
}

fn face(ui: &mut Ui, desk: &FlankDesk, mesh: &mut MeshFlank, wrong: &mut Option<String>) -> Option<FlankPath> {
    let mut asked = None;
    named(ui, "Part", |ui, _| {
        let text = mesh.part();
        let response = ui.add_sized(vec2(110.0, 22.0), egui::Button::new(text).truncate());
        if response.on_hover_text("Another mesh with the flank").clicked() {
            asked = Some(FlankPath::Mesh);
        }
        if mesh.kept.is_some() {
            // An electrode of ours is in mm.
            return;
        }
        let combo = ComboBox::from_id_salt("flank unit").selected_text(unit_name(mesh.units)).width(56.0);
        let shown = combo.show_ui(ui, |ui| {
            for units in [Units::Auto, Units::Mm, Units::Cm, Units::M, Units::Um, Units::Inch] {
                ui.selectable_value(&mut mesh.units, units, unit_name(units));
            }
        });
        ui.ctx().accesskit_node_builder(shown.response.id, |node| node.set_label("Unit of the part"));
    });
    let up = "Along the cutter's axis to the spindle, in the axes of the part: from the lower guide to the upper";
    fields::direction(ui, &mut mesh.fit.up, "Up", up, wrong);
    let hint = "Greatest distance between the face and the ruled surface that it is said to be";
    let tolerance = Number { speed: 0.001, ..Number::mm("Ruled to", hint) };
    fields::number(ui, &mut mesh.fit.tolerance_mm, tolerance, wrong);
    tick(ui, &mut mesh.is_own_wall, "the rest of the part must not be cut")
        .on_hover_text("Flutes and holder are checked against the part's other faces");
    let loaded = desk.work.loaded(desk.document.params());
    for doubt in loaded.iter().flat_map(|loaded| &loaded.doubts) {
        ui.add(Label::new(RichText::new(doubt).small().color(palette(ui).warning)).wrap());
    }
    if let Some(LoadedSurface::Face { candidates, .. }) = loaded.map(|loaded| &loaded.surface) {
        list(ui, mesh, candidates);
        if let Some(candidate) = mesh.candidate.checked_sub(1).and_then(|i| candidates.get(i)) {
            words(ui, candidate);
        }
    }
    asked
}

fn unit_name(units: Units) -> &'static str {
    match units {
        Units::Auto => "auto",
        Units::Mm => "mm",
        Units::Cm => "cm",
        Units::M => "m",
        Units::Inch => "inch",
        Units::Um => "µm",
    }
}

/// The faces that could be milled, the largest first.
fn list(ui: &mut Ui, mesh: &mut MeshFlank, candidates: &[Candidate]) {
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
        if let Some(number) = clicked {
            mesh.candidate = number;
        }
    });
}

/// How far a face is off a ruled surface, in the colour that says whether it is one.
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

/// What is known of the chosen face.
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
