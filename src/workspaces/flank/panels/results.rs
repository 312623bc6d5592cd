//! The right panel: the figures of the three paths, what was checked, and what the reader must know.

use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{ComboBox, DragValue, Grid, Label, RichText, Role, Sense, Ui, WidgetInfo, vec2};

use super::desk::Standing;
use crate::widgets::panel_parts::{fact, notice, sentence, short};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::comparison::{Quantity, Sweep, Variant, best};
use crate::workspaces::flank::document::PathChoice;
use crate::workspaces::flank::work::Planned;
use flank::deviation::Deviation;
use flank::plan::WITHIN_ROUNDING;
use nc::flank_job::{FlankCheck, FlankResult, path_of};

/// Width of the column of a path (points).
const COLUMN: f32 = 56.0;

/// Draws the panel.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk) {
    ui.add_space(4.0);
    egui::ScrollArea::vertical().id_salt("flank results").auto_shrink([false, false]).show(ui, |ui| body(ui, desk));
}

/// Draws the content of the panel, without scroll area.
pub fn body(ui: &mut Ui, desk: &mut FlankDesk) {
    let Some(planned) = desk.planned().cloned() else {
        let text = "No path yet: plan one (F8) to see its figures.";
        ui.add(Label::new(RichText::new(text).color(palette(ui).faint)).wrap());
        return;
    };
    heading(ui, desk);
    ui.scope(|ui| {
        if desk.standing() == Standing::Stale {
            ui.multiply_opacity(0.55);
        }
        figures(ui, desk, &planned);
        comparison(ui, desk);
        ui.add_space(6.0);
        if desk.standing() == Standing::Sketch {
            let text = "Checks follow with the plan.";
            ui.add(Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
            return;
        }
        ui.strong("Checks");
        ui.label(RichText::new(format!("of the {} path", planned.result.path.name())).small().color(palette(ui).faint));
        checks(ui, desk, &planned);
        warnings(ui, &planned);
    });
}

fn heading(ui: &mut Ui, desk: &FlankDesk) {
    let colours = palette(ui);
    let (text, colour) = match desk.standing() {
        Standing::Sketch => ("preview", colours.accent),
        Standing::Stale => ("out of date", colours.warning),
        _ => return drop(ui.strong("Deviations")),
    };
    ui.horizontal(|ui| {
        ui.strong("Deviations");
        ui.label(RichText::new(text).small().color(colour));
    });
}

/// A figure of deviations: its name, what it means, and it.
type Figure = (&'static str, &'static str, fn(&Deviation) -> f64);

const FIGURES: [Figure; 5] = [
    ("sum", "Sum of the absolute deviations over the grid (mm)", |d| d.sum),
    ("mean", "Mean of the absolute deviations (mm)", |d| d.mean),
    ("rms", "Root mean square (mm)", |d| d.rms),
    ("overcut", "Greatest depth below the surface (mm)", |d| (-d.most_overcut).max(0.0)),
    ("undercut", "Greatest stock left on the surface (mm)", |d| d.most_undercut.max(0.0)),
];

/// Sums and extremes of the three paths, of the standing cutter and of the moving one.
fn figures(ui: &mut Ui, desk: &mut FlankDesk, planned: &Planned) {
    let plan = &planned.result.plan;
    let [nu, nv] = plan.initial.deviation.counted_grid();
    let text = format!("mm, over {nu} × {nv} samples");
    ui.label(RichText::new(text).small().color(palette(ui).faint));
    let paths = PathChoice::ALL.map(|choice| path_of(plan, choice));
    Grid::new("flank figures").num_columns(4).striped(true).spacing([8.0, 2.0]).min_col_width(40.0).show(ui, |ui| {
        ui.label("");
        for choice in PathChoice::ALL {
            head(ui, desk, choice);
        }
        ui.end_row();
        for moving in [false, true] {
            let what = if moving { "swept envelope" } else { "static" };
            ui.label(RichText::new(what).small().color(palette(ui).faint));
            ui.end_row();
            for (name, hint, of) in FIGURES {
                ui.label(name).on_hover_text(hint);
                for path in paths {
                    let value = of(if moving { &path.envelope.deviation } else { &path.deviation });
                    number(ui, value);
                }
                ui.end_row();
            }
            ui.label("ratio").on_hover_text("Ratio to initial: of the total absolute deviation");
            for path in paths {
                let share = if moving { plan.moving_share(path) } else { plan.share(path.deviation.sum) };
                cell(ui, share.map_or_else(|| "\u{2013}".to_owned(), |share| format!("{share:.3}")));
            }
            ui.end_row();
        }
    });
    let text = "Ratio to initial: static to static, swept envelope to swept envelope.";
    ui.add(Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
    if !plan.has_deviation() {
        let text = format!("The initial path {WITHIN_ROUNDING}: ratios mean nothing.");
        ui.add(Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
    }
    fact(ui, "Best rank", format!("{} of {}", plan.ranks.best, plan.ranks.sums.len()));
    if let Some(machine) = &planned.machine {
        fact(ui, "Time on the machine", format!("{:.2} min", machine.minutes));
    }
}

/// Plans side by side, each with its cutter, which a click takes.
fn comparison(ui: &mut Ui, desk: &mut FlankDesk) {
    ui.add_space(6.0);
    let rows = desk.rows();
    ui.horizontal(|ui| {
        ui.strong("Side by side");
        let keep = ui.add_enabled(desk.is_planned(), egui::Button::new("Keep").small());
        if keep.on_hover_text("Keeps the figures of this plan beside those of others").clicked() {
            desk.keep();
        }
        if !rows.is_empty() && ui.small_button("Clear").clicked() {
            desk.clear_rows();
        }
    });
    sweep(ui, desk);
    if rows.is_empty() {
        return;
    }
    let has_points = rows.windows(2).any(|w| w[0].variant.control_points != w[1].variant.control_points);
    let best = best(&rows);
    let mut taken = None;
    Grid::new("flank comparison").num_columns(4).striped(true).spacing([8.0, 2.0]).show(ui, |ui| {
        for head in ["cutter", "mean um", "over um", "under um"] {
            ui.label(RichText::new(head).small().color(palette(ui).faint));
        }
        ui.end_row();
        for (i, row) in rows.iter().enumerate() {
            let sentence = row.sentence();
            let Variant { cutter, control_points } = &row.variant;
            // Short, since the column is narrow; the hint has it in words.
            let name = match (&*cutter.name, has_points) {
                (_, true) => format!("{control_points} points"),
                ("", _) => format!("R{} {}\u{b0}", short(cutter.radius_mm, 0..=2), short(cutter.taper_deg, 0..=2)),
                (name, _) => name.to_owned(),
            };
            let text = RichText::new(name).small();
            let text = if best == Some(i) { text.strong().color(palette(ui).good) } else { text };
            if ui.add(egui::Button::new(text).small().frame(false).truncate()).on_hover_text(&sentence).clicked() {
                taken = Some(row.variant.clone());
            }
            match &row.figures {
                Ok(found) => {
                    let colour = if found.fails.is_empty() { ui.visuals().text_color() } else { palette(ui).bad };
                    for mm in [found.mean_mm, found.overcut_mm, found.undercut_mm] {
                        ui.label(RichText::new(format!("{:.2}", 1e3 * mm)).monospace().color(colour))
                            .on_hover_text(&sentence);
                    }
                }
                Err(why) => drop(ui.label(RichText::new("no path").small().color(palette(ui).bad)).on_hover_text(why)),
            }
            ui.end_row();
        }
    });
    if let Some(variant) = taken {
        desk.take(variant);
    }
}

/// The sweep of a quantity: which, from where to where, in how many steps.
fn sweep(ui: &mut Ui, desk: &mut FlankDesk) {
    let before = desk.sweep.of;
    ui.horizontal(|ui| {
        let combo = ComboBox::from_id_salt("flank sweep").selected_text(desk.sweep.of.name()).width(70.0);
        let shown = combo.show_ui(ui, |ui| {
            for of in Quantity::ALL {
                ui.selectable_value(&mut desk.sweep.of, of, of.name());
            }
        });
        shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "Quantity of the sweep"));
        if desk.sweep.of != before {
            desk.sweep = desk.sweep.of.usual();
        }
        let [least, most] = desk.sweep.of.range();
        for (name, end) in ["First value", "Last value"].into_iter().zip(&mut desk.sweep.ends) {
            let value = ui.add(DragValue::new(end).range(least..=most).speed(0.05).max_decimals(2));
            value.on_hover_text(format!("{name}: {}", before.label()));
        }
        ui.add(DragValue::new(&mut desk.sweep.count).range(2..=Sweep::MOST)).on_hover_text("Number of values");
        let is_possible = desk.document.problem().is_none() && !desk.work.is_busy();
        let start = ui.add_enabled(is_possible, egui::Button::new("Sweep").small());
        if start.on_hover_text("Plans at equal steps of the quantity, and plots the deviations").clicked() {
            desk.wants_sweep = true;
        }
    });
}

/// A number with as many decimals as it is worth.
fn number(ui: &mut Ui, value: f64) {
    let decimals = if value.abs() >= 100.0 {
        1
    } else if value.abs() >= 1.0 {
        3
    } else {
        5
    };
    cell(ui, format!("{value:.decimals$}"));
}

/// A number in its column, below the others.
fn cell(ui: &mut Ui, text: String) {
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(COLUMN, 18.0), layout, |ui| {
        ui.set_min_width(COLUMN);
        ui.label(RichText::new(text).monospace());
    });
}

/// The head of a path's column, which shows it.
fn head(ui: &mut Ui, desk: &mut FlankDesk, choice: PathChoice) {
    let is_on = desk.path == choice;
    let hint = match choice {
        PathChoice::Initial => "The path of the offset",
        PathChoice::Chosen => "The path of the best rank",
        PathChoice::Refined => "The refined path",
    };
    let button = egui::Button::selectable(is_on, RichText::new(choice.name()).small());
    let response = ui.add_sized(vec2(COLUMN, 20.0), button).on_hover_text(hint);
    response.widget_info(|| WidgetInfo::selected(Role::Tab, true, is_on, format!("Path {}", choice.name())));
    if response.clicked() {
        desk.path = choice;
    }
}

/// Checks in words. Failed checks can be shown, and overridden by name.
fn checks(ui: &mut Ui, desk: &mut FlankDesk, planned: &Planned) {
    for check in &planned.result.checks {
        let mut check = check.clone();
        check.decide(std::slice::from_ref(&planned.result.part), &desk.document.params().overrides);
        let (check, is_overridden) = (&check, check.is_overridden);
        let colours = palette(ui);
        let (sign, colour) = match (check.holds, is_overridden) {
            (true, _) => ("\u{2714}", colours.good),
            (false, true) => ("\u{2716}", colours.warning),
            (false, false) => ("\u{2716}", colours.bad),
        };
        ui.horizontal_top(|ui| {
            ui.label(RichText::new(sign).color(colour));
            let is_shown = !check.holds || check.t.is_some();
            if let Some(place) = check.place.filter(|_| is_shown) {
                let hint = format!("Show where: {}", check.kind.name());
                let response = ui.small_button("Show").on_hover_text(&hint);
                response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &hint));
                if response.clicked() {
                    desk.point_at(place, check.t);
                }
            }
            let text = RichText::new(format!("{}: {}", check.kind.name(), check.text)).small();
            let text = text.color(if check.holds { colours.faint } else { colour });
            ui.add(Label::new(text).wrap());
        });
        if !check.holds {
            let_pass(ui, desk, (&planned.result, check), is_overridden);
        }
    }
}

/// Lets what fails be exported all the same.
pub fn let_pass(ui: &mut Ui, desk: &mut FlankDesk, (result, check): (&FlankResult, &FlankCheck), is_overridden: bool) {
    let mut passes = is_overridden;
    if tick(ui, &mut passes, format!("Release despite failed check: {}", check.kind.name())).changed() {
        let mut params = desk.document.params().clone();
        // What was decided for other figures is over with a new decision.
        params.overrides.retain(|other| other.check != check.kind.name());
        if passes {
            params.overrides.push(result.let_pass(check));
        }
        desk.edit(params);
    } else if let Some(why) = &check.lapsed {
        let text = format!("Override of {}: {why}.", check.kind.name());
        ui.add(Label::new(RichText::new(text).small().color(palette(ui).warning)).wrap());
    }
}

fn warnings(ui: &mut Ui, planned: &Planned) {
    let warnings = &planned.result.warnings;
    if warnings.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.strong("Notes");
    for warning in warnings {
        let text = RichText::new(sentence(warning)).small();
        let response = ui.add(Label::new(text).wrap().sense(Sense::hover()));
        response.on_hover_text("Does not block the export");
        ui.add_space(2.0);
    }
    if let Some(fit) = planned.result.fit.as_ref().filter(|fit| !fit.is_ruled) {
        notice(ui, palette(ui).warning, &format!("The face is not ruled within {} mm", fit.tolerance_mm));
    }
}
