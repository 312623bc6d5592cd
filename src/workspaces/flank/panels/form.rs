//! The left panel: the surface, the cutter, how its path is planned, what must not be cut, and the machine.

use crate::workspaces::commands::{CommandSet, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::flank::commands::FlankCommand;
use crate::workspaces::flank::panels::FlankDesk;
use egui::{ComboBox, ProgressBar, RichText, Ui, vec2};

use super::desk::Standing;
use super::fields::{self, Number};
use super::{clamping, results, source};
use crate::widgets::panel_parts::file_name;
use crate::widgets::panel_parts::{named, section};
use crate::widgets::panel_parts::{notice, sentence};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::document::{CutDirection, FlankDocument, FlankSource, PathChoice};
use crate::workspaces::flank::paths::FlankPath;
use files::Validate;
use flank::cutter::{FlankCutter, HolderPart};
use flank::params::{Objective, OffsetMethod};
use flank::ruled_surface::Side;
use task::State;

/// Height of the line that says how the plan stands (points).
const ROW: f32 = 22.0;
/// Bound that a path begins with when it is to be bounded (mm).
const FIRST_BOUND: f64 = 0.01;

/// Draws it, `with_results` also what came out. Answers what a path is wanted for.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context, with_results: bool) -> Option<FlankPath> {
    let mut asked = None;
    ui.add_space(2.0);
    plan(ui, desk, cx);
    if with_results {
        ui.horizontal(|ui| {
            ui.selectable_value(&mut desk.shows_figures, false, "Parameters");
            ui.selectable_value(&mut desk.shows_figures, true, "Results");
        });
    }
    if with_results && desk.shows_figures {
        results::show(ui, desk);
        return None;
    }
    egui::ScrollArea::vertical().id_salt("flank form").auto_shrink([false, false]).show(ui, |ui| {
        let mut params = desk.document.params().clone();
        let mut wrong = None;
        section(ui, "Surface", true, |ui| asked = source::show(ui, desk, &mut params, &mut wrong));
        section(ui, "Cutter", true, |ui| cutter(ui, &mut params.cutter, &mut wrong));
        section(ui, "Path", true, |ui| path(ui, &mut params, &mut wrong));
        section(ui, "Walls", false, |ui| asked = walls(ui, desk, &mut params).or(asked.take()));
        section(ui, "Checks", false, |ui| checks(ui, &mut params, &mut wrong));
        section(ui, "Machine", false, |ui| asked = machine(ui, desk, &mut params, &mut wrong).or(asked.take()));
        desk.edit(params);
        if let Some(wrong) = wrong {
            cx.say_in_passing(wrong);
        }
    });
    asked
}

/// The button that plans, and what is being done.
fn plan(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    let state = desk.state();
    ui.horizontal(|ui| {
        cx.button(ui, desk, FlankCommand::PlanFlank, "Plan", state != State::Ready);
        cx.button(ui, desk, FrameCommand::Export, "Export\u{2026}", false);
        tick(ui, &mut desk.follows, "update automatically").on_hover_text("After the first plan");
    });
    // Always as high: the fields below must not move away from the hand that drags them.
    ui.allocate_ui(vec2(ui.available_width(), ROW), |ui| {
        ui.set_min_height(ROW);
        ui.horizontal(|ui| standing(ui, desk, cx));
    });
}

/// What is being done, what is wrong, or what is known, in one line.
fn standing(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    let colours = palette(ui);
    let is_possible = desk.document.params().validate().is_ok();
    if let Some(doing) = desk.work.doing().filter(|_| is_possible).cloned() {
        let bar = ui.add(ProgressBar::new(doing.fraction as f32).desired_width(110.0).desired_height(8.0));
        let percent = format!("{} {:.0} %", doing.stage, 100.0 * doing.fraction);
        bar.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &percent));
        if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            cx.push(FrameCommand::Cancel);
        }
        ui.add(egui::Label::new(RichText::new(&doing.stage).color(palette(ui).faint)).truncate());
        return;
    }
    let (colour, text) = match (desk.why_not(), desk.standing()) {
        _ if desk.open_side().is_some() => (colours.accent, CHOOSE_SIDE.to_owned()),
        (Some(why), _) => (colours.bad, labelled(&sentence(&why))),
        (None, Standing::Planned) => (colours.faint, "Planned".to_owned()),
        (None, Standing::Sketch) => (colours.accent, "Preview on a coarse grid, not yet planned".to_owned()),
        (None, Standing::Stale) => (colours.warning, "Out of date".to_owned()),
        (None, Standing::Nothing) => (colours.faint, "Not yet planned".to_owned()),
    };
    ui.add(egui::Label::new(RichText::new(&text).small().color(colour)).truncate()).on_hover_text(text);
}

/// Keys of files, and what the form calls them.
const LABELS: [(&str, &str); 20] = [
    ("cutter radius_mm", "Radius"),
    ("cutter taper_deg", "Taper"),
    ("cutter length_mm", "Flutes"),
    ("holder length_mm", "Shank and holder, length"),
    ("holder lower_radius_mm", "Shank and holder, R below"),
    ("holder upper_radius_mm", "Shank and holder, R above"),
    ("below_mm", "Extend below"),
    ("locations", "Locations"),
    ("control_points", "Points"),
    ("grid", "Grid"),
    ("rounds", "Iterations"),
    ("gouge_tolerance_mm", "Gouge to"),
    ("envelope_tolerance_mm", "Envelope to"),
    ("overcut_tolerance_mm", "Overcut to"),
    ("undercut_tolerance_mm", "Undercut to"),
    ("linearisation_mm", "Tolerance"),
    ("feed_mm_per_min", "Feed"),
    ("lead_mm_per_min", "Lead feed"),
    ("aside_mm", "Lead-in"),
    ("retract_mm", "Retract distance"),
];

/// What is wrong with a value, in the words of the form: `Extend below is -1: ...`.
pub fn labelled(why: &str) -> String {
    // Of a value it is said what it is.
    let found = LABELS.iter().find_map(|(key, label)| {
        let at = why.to_ascii_lowercase().find(&format!("{key} is "))?;
        let is_whole = !why[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        is_whole.then(|| format!("{}{label}{}", &why[..at], &why[at + key.len()..]))
    });
    found.unwrap_or_else(|| why.to_owned())
}

/// Words of which one is chosen, in a row.
fn choice<T: PartialEq + Copy>(ui: &mut Ui, name: &str, value: &mut T, all: &[(T, &str, &str)]) {
    named(ui, name, |ui, _| {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            for (one, text, hint) in all {
                ui.selectable_value(value, *one, *text).on_hover_text(*hint);
            }
        });
    });
}

/// Both sides of a surface, what they are called, and what that means.
pub const SIDES: [(Side, &str, &str); 2] = [
    (Side::Positive, "+1", "Where the lower guide crossed with the ruling points to"),
    (Side::Negative, "\u{2212}1", "The other side"),
];
/// What is said while nobody but the user can know the side.
pub const CHOOSE_SIDE: &str = "Choose the side of the cutter, away from the part: +1 or \u{2212}1";

/// On which side of the surface the cutter stands. Guides alone do not tell.
pub fn side(ui: &mut Ui, source: &FlankSource, side: &mut Side) {
    let automatic = (Side::Automatic, "auto", "Outside of the part; of a demonstration the side of its paper");
    let all: Vec<_> = std::iter::once(automatic).chain(SIDES).collect();
    match source {
        FlankSource::Guides { .. } => {
            choice(ui, "Side", side, &SIDES);
            if *side == Side::Automatic {
                notice(ui, palette(ui).accent, CHOOSE_SIDE);
            }
        }
        _ => choice(ui, "Side", side, &all),
    }
}

fn cutter(ui: &mut Ui, cutter: &mut FlankCutter, wrong: &mut Option<String>) {
    fields::text(ui, &mut cutter.name, "Name", "What the cutter is called in programs and reports; may be empty");
    let radius = Number::mm("Radius", "Radius of the cutter's bottom circle, r0");
    fields::slider(ui, &mut cutter.radius_mm, 0.1..=6.0, radius, wrong);
    let taper = Number {
        name: "Taper",
        unit: "deg",
        hint: "Angle between axis and flute, alpha: 0 for a cylinder",
        speed: 0.05,
        decimals: 3,
    };
    fields::slider(ui, &mut cutter.taper_deg, 0.0..=20.0, taper, wrong);
    let length = Number::mm("Flutes", "Length of the flutes along the axis");
    fields::slider(ui, &mut cutter.length_mm, 2.0..=80.0, Number { speed: 0.1, ..length }, wrong);
    holder(ui, &mut cutter.holder, wrong);
}

/// Cylinders and cones above the flutes, from below upwards.
fn holder(ui: &mut Ui, parts: &mut Vec<HolderPart>, wrong: &mut Option<String>) {
    let mut removed = None;
    ui.horizontal(|ui| {
        ui.label(RichText::new("Shank and holder").color(palette(ui).faint))
            .on_hover_text("What is above the flutes, from below upwards: checked against walls");
        let add = ui.small_button("Add").on_hover_text("Another part above the others");
        if add.clicked() {
            let below = parts.last().map_or(4.0, |part| part.upper_radius_mm);
            let is_first = parts.is_empty();
            let (length_mm, radius) = if is_first { (20.0, below) } else { (40.0, below + 8.0) };
            parts.push(HolderPart { length_mm, lower_radius_mm: radius, upper_radius_mm: radius });
        }
    });
    if parts.is_empty() {
        return;
    }
    egui::Grid::new("holder").num_columns(5).spacing([4.0, 2.0]).min_col_width(0.0).show(ui, |ui| {
        for head in ["", "length mm", "R below", "R above", ""] {
            ui.label(RichText::new(head).small().color(palette(ui).faint));
        }
        ui.end_row();
        for (i, part) in parts.iter_mut().enumerate() {
            ui.label(RichText::new((i + 1).to_string()).color(palette(ui).faint));
            let values = [
                ("Length of part", &mut part.length_mm),
                ("Lower radius of part", &mut part.lower_radius_mm),
                ("Upper radius of part", &mut part.upper_radius_mm),
            ];
            for (name, value) in values {
                let name = format!("{name} {}", i + 1);
                let response = fields::field(ui, value, Number::mm(&name, "mm"), wrong);
                ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
            }
            if ui.small_button("\u{00d7}").on_hover_text("Remove this part").clicked() {
                removed = Some(i);
            }
            ui.end_row();
        }
    });
    if let Some(i) = removed {
        parts.remove(i);
    }
}

fn path(ui: &mut Ui, params: &mut FlankDocument, wrong: &mut Option<String>) {
    let plan = &mut params.plan;
    let all = [
        (OffsetMethod::TwoPoint, "two-point", "The cutter touches both guides at the same u"),
        (OffsetMethod::ThreePoint, "three-point", "It touches both guides and the middle of the surface"),
    ];
    choice(ui, "Offset", &mut plan.offset, &all);
    fields::count(ui, &mut plan.locations, Number::count("Locations", "Cutter locations of the initial path"), wrong);
    let hint = "Control points of each of the two curves of the axis surface; around a ring as many more as it needs";
    fields::count(ui, &mut plan.control_points, Number::count("Points", hint), wrong);
    grid(ui, &mut plan.grid, wrong);
    objective(ui, &mut plan.objective, wrong);
    fields::count(
        ui,
        &mut plan.rounds,
        Number::count("Iterations", "Greatest number of iterations of the refinement; 0 for none"),
        wrong,
    );
    let hint = "Distance by which the cutter's bottom extends below the lower guide, along its axis";
    fields::number(ui, &mut plan.below_mm, Number::mm("Extend below", hint), wrong);
    named(ui, "Coverage", |ui, _| {
        let hint = "Extend the path past the ends of the guides until the whole surface is covered";
        tick(ui, &mut plan.is_covering, "cover the whole surface").on_hover_text(hint);
    });
    let all = [
        (PathChoice::Initial, "initial", "Mill the initial path (offset)"),
        (PathChoice::Chosen, "chosen", "Mill the chosen path (best rank)"),
        (PathChoice::Refined, "refined", "Mill the refined path"),
    ];
    choice(ui, "Path", &mut params.path, &all);
}

/// Places where deviations are taken.
fn grid(ui: &mut Ui, grid: &mut [usize; 2], wrong: &mut Option<String>) {
    named(ui, "Grid", |ui, _| {
        let hint = "Samples along the guides and along the rulings; all sums are over these";
        for (i, name) in ["Grid along the guides", "Grid along the rulings"].into_iter().enumerate() {
            let mut value = grid[i] as f64;
            let response = fields::field(ui, &mut value, Number::count(name, hint), wrong);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
            grid[i] = fields::whole(value);
            if i == 0 {
                ui.label(RichText::new("×").color(palette(ui).faint));
            }
        }
    });
}

/// What is made least, and within which bounds.
fn objective(ui: &mut Ui, objective: &mut Objective, wrong: &mut Option<String>) {
    let bounded = match *objective {
        Objective::Bounded { .. } => *objective,
        _ => Objective::Bounded { overcut_mm: Some(FIRST_BOUND), undercut_mm: None },
    };
    let all = [
        (Objective::Sum, "sum", "Total absolute deviation; the greatest deviations may grow"),
        (Objective::Rms, "rms", "Root mean square of the deviations"),
        (bounded, "bounded", "Total absolute deviation, with bounds of overcut and undercut"),
    ];
    choice(ui, "Minimise", objective, &all);
    let Objective::Bounded { overcut_mm, undercut_mm } = objective else { return };
    bound(ui, "Overcut to", overcut_mm, "Greatest depth that may be cut below the surface; 0 for none", wrong);
    bound(ui, "Undercut to", undercut_mm, "Greatest stock that may be left on the surface", wrong);
}

fn bound(ui: &mut Ui, name: &str, bound: &mut Option<f64>, hint: &str, wrong: &mut Option<String>) {
    named(ui, name, |ui, label| {
        let mut is_on = bound.is_some();
        let ticked = tick(ui, &mut is_on, "").on_hover_text(hint);
        ui.ctx().accesskit_node_builder(ticked.id, |node| node.set_label(format!("Bound {name}")));
        if is_on != bound.is_some() {
            *bound = is_on.then_some(FIRST_BOUND);
        }
        if let Some(value) = bound {
            fields::field(ui, value, Number { speed: 0.001, ..Number::mm(name, hint) }, wrong).labelled_by(label);
            fields::unit(ui, "mm");
        } else {
            ui.label(RichText::new("any").color(palette(ui).faint));
        }
    });
}

/// What must not be cut.
fn walls(ui: &mut Ui, desk: &FlankDesk, params: &mut FlankDocument) -> Option<FlankPath> {
    let mut asked = None;
    named(ui, "Mesh", |ui, _| {
        let name = params.walls.as_ref().map(|walls| file_name(&walls.file.to_string_lossy()));
        let button = egui::Button::new(name.as_deref().unwrap_or("Choose\u{2026}")).truncate();
        let response = ui.add_sized(vec2(130.0, 22.0), button);
        let hint = "Walls beside the flank that neither flutes nor holder may touch";
        if response.on_hover_text(hint).clicked() {
            asked = Some(FlankPath::Walls);
        }
        if params.walls.is_some() && ui.button("None").on_hover_text("No walls besides the part itself").clicked() {
            params.walls = None;
        }
    });
    if let Some(why) = desk.work.walls_state(desk.document.params()).why_not() {
        notice(ui, palette(ui).bad, why);
    }
    for doubt in desk.work.walls(desk.document.params()).iter().flat_map(|walls| &walls.doubts) {
        notice(ui, palette(ui).warning, doubt);
    }
    asked
}

/// How much of what the checks find is let pass.
fn checks(ui: &mut Ui, params: &mut FlankDocument, wrong: &mut Option<String>) {
    let gouge = Number::mm("Gouge to", "Depth in neighbouring walls that does not count as a gouge");
    fields::number(ui, &mut params.plan.gouge_tolerance_mm, Number { speed: 0.001, ..gouge }, wrong);
    let hint = "Greatest difference of swept envelope and static deviation at any sample";
    let envelope = Number { speed: 0.0005, decimals: 5, ..Number::mm("Envelope to", hint) };
    fields::number(ui, &mut params.envelope_tolerance_mm, envelope, wrong);
    let overcut = Number::mm("Overcut to", "Greatest overcut, static or of the swept envelope");
    fields::number(ui, &mut params.overcut_tolerance_mm, Number { speed: 0.001, ..overcut }, wrong);
    let undercut = Number::mm("Undercut to", "Greatest undercut, static or of the swept envelope");
    fields::number(ui, &mut params.undercut_tolerance_mm, Number { speed: 0.001, ..undercut }, wrong);
}

fn machine(ui: &mut Ui, desk: &FlankDesk, params: &mut FlankDocument, wrong: &mut Option<String>) -> Option<FlankPath> {
    let mut asked = None;
    let milling = &mut params.milling;
    named(ui, "Machine", |ui, label| {
        let now = if milling.machine.is_empty() { "none".to_owned() } else { file_name(&milling.machine) };
        let combo = ComboBox::from_id_salt("milling machine").selected_text(now).width(160.0);
        let shown = combo.show_ui(ui, |ui| {
            let mut chosen = milling.machine.clone();
            ui.selectable_value(&mut chosen, String::new(), "none").on_hover_text("Cutter locations only");
            for [name, title] in &desk.machines {
                ui.selectable_value(&mut chosen, name.clone(), file_name(name)).on_hover_text(title);
            }
            if let Some(forgotten) = milling.take_machine(&chosen) {
                *wrong = Some(forgotten);
            }
            if ui.selectable_label(false, "Own file\u{2026}").clicked() {
                asked = Some(FlankPath::Machine);
            }
        });
        shown.response.labelled_by(label);
    });
    clamping::workpiece(ui, desk, milling, wrong);
    asked = clamping::program(ui, milling, wrong).or(asked);
    if !milling.machine.is_empty() {
        let hint = "From the spindle nose to the tip; otherwise as the machine's file says";
        bound(ui, "Gauge length", &mut milling.gauge_length_mm, hint, wrong);
    }
    let ways = [
        (CutDirection::Climb, "climb", "The surface to the right of the travel, with the spindle clockwise"),
        (
            CutDirection::Conventional,
            "conventional",
            "The surface to the left of the travel, with the spindle clockwise",
        ),
    ];
    choice(ui, "Cut", &mut milling.cut, &ways);
    let hint = "Chordal deviation of tip and flutes' top between programmed points";
    let tolerance = Number { speed: 0.0005, decimals: 5, ..Number::mm("Tolerance", hint) };
    fields::number(ui, &mut milling.linearisation_mm, tolerance, wrong);
    let feed = Number { unit: "mm/min", speed: 5.0, decimals: 1, ..Number::mm("Feed", "Of the cut along the flank") };
    fields::number(ui, &mut milling.program.feed_mm_per_min, feed, wrong);
    let lead = Number { name: "Lead feed", hint: "Of approach and retraction", ..feed };
    fields::number(ui, &mut milling.program.lead_mm_per_min, lead, wrong);
    let spindle = Number { name: "Spindle", unit: "1/min", hint: "Speed of the spindle", speed: 50.0, decimals: 0 };
    fields::number(ui, &mut milling.program.spindle_rpm, spindle, wrong);
    let aside = Number::mm("Lead-in", "Length of lead-in and lead-out from the side, at both ends of the path");
    fields::number(ui, &mut milling.aside_mm, aside, wrong);
    let retract = Number::mm("Retract distance", "Retract distance along the cutter axis at both ends");
    fields::number(ui, &mut milling.retract_mm, Number { speed: 0.2, ..retract }, wrong);
    asked
}

#[cfg(test)]
mod tests {
    use super::labelled;

    #[test]
    fn what_is_wrong_is_said_in_the_words_of_the_form() {
        for (why, said) in [
            ("plan: below_mm is -1: it must be", "plan: Extend below is -1: it must be"),
            ("Cutter length_mm is -3; give", "Flutes is -3; give"),
            ("Undercut_tolerance_mm is 9", "Undercut to is 9"),
            ("gauge_length_mm is 1 and below_mm matters", "gauge_length_mm is 1 and below_mm matters"),
            ("\u{130}below_mm is 2", "\u{130}below_mm is 2"),
        ] {
            assert_eq!(labelled(why), said);
        }
    }
}
