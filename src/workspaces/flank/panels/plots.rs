//! Plots of a flank: the sum of deviations over the rank, deviations along the guides and where the cutter stands, and
//! the axes of the machine.

use crate::workspaces::flank::panels::desk::{FlankDesk, Tab};
use egui::{Align2, Color32, FontId, Rect, RichText, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use egui_plot::{GridInput, GridMark, HLine, Line, LineStyle, MarkerShape, PlotPoint, PlotPoints, Points, VLine};

use crate::widgets::panel_parts::file_name;
use crate::widgets::plot_parts::{legend, round_steps, says, still};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::comparison::{Quantity, SERIES, points};
use crate::workspaces::flank::document::PathChoice;
use crate::workspaces::flank::scene::contact_line;
use crate::workspaces::flank::work::{AxisCurve, MachineCurves, Planned};
use flank::params::SumOver;
use flank::plan::FlankPlan;
use nc::flank_job::path_of;

impl Tab {
    const ALL: [Self; 4] = [Self::Ranks, Self::Deviation, Self::Machine, Self::Sweep];

    fn name(self) -> &'static str {
        ["Ranks", "Deviation", "Machine", "Sweep"][self as usize]
    }

    fn note(self) -> &'static str {
        [
            "total absolute deviation (mm) over the rank",
            "left: least, greatest and mean (mm) along the guides; right: along the line of contact, up the ruling",
            "over the cut; spindle nose in machine coordinates",
            "plans side by side: mean and greatest deviations (um)",
        ][self as usize]
    }
}

/// Draws the tabs and the chosen plot.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk) {
    ui.horizontal(|ui| {
        for tab in Tab::ALL {
            ui.selectable_value(&mut desk.tab, tab, tab.name());
        }
        if desk.tab == Tab::Machine {
            tick(ui, &mut desk.shows_limits, "limits").on_hover_text("Draw each axis with all of its travel");
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let note = RichText::new(desk.tab.note()).small().color(palette(ui).faint);
            ui.add(egui::Label::new(note).truncate());
        });
    });
    let Some(planned) = desk.planned().cloned() else {
        return says(ui, "Plan the flank's path to see its curves.");
    };
    match desk.tab {
        Tab::Ranks => ranks(ui, desk, &planned.result.plan),
        Tab::Deviation => deviation(ui, desk, &planned),
        Tab::Machine => machine(ui, desk, &planned),
        Tab::Sweep => sweep(ui, desk),
    }
}

/// The colours of the three paths.
fn colours(ui: &Ui) -> [Color32; 3] {
    let colours = palette(ui);
    [colours.faint, colours.axes[3], colours.accent]
}

/// Free edges of a plot.
const MARGIN: egui::Vec2 = vec2(0.015, 0.07);

/// Lines at 1, 2 and 5 of every decade of an axis that holds decimal logarithms; at whole decades only where there are
/// many.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(high - low).is_finite() || high <= low || high - low > 40.0 {
        return Vec::new();
    }
    let parts: &[f64] = if high - low > 2.2 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let all =
        (low.floor() as i32..=high.ceil() as i32).flat_map(|n| parts.iter().map(move |p| f64::from(n) + p.log10()));
    all.filter(|v| (low..=high).contains(v)).map(|value| GridMark { value, step_size: 1.0 }).collect()
}

/// A number whose logarithm this is.
fn of_decade(mark: GridMark) -> String {
    let value = 10f64.powf(mark.value);
    if (0.1..1e4).contains(&value) {
        let decimals = usize::from(value < 0.95);
        format!("{value:.decimals$}")
    } else {
        format!("{value:.0e}")
    }
}

/// The sum that each rank leads to, on a scale that shows the ranks which lead nowhere as well; a click tells one.
fn ranks(ui: &mut Ui, desk: &mut FlankDesk, plan: &FlankPlan) {
    let ranks = &plan.ranks;
    let known: Vec<(usize, f64)> =
        ranks.sums.iter().enumerate().filter_map(|(i, sum)| Some((i + 1, (*sum)?))).filter(|(_, s)| *s > 0.0).collect();
    let [initial, chosen, refined] = colours(ui);
    let sums = PathChoice::ALL.map(|choice| path_of(plan, choice).deviation.sum);
    let names = [
        (initial, format!("initial {:.3}", sums[0])),
        (chosen, format!("best rank {}: {:.3}", ranks.best, sums[1])),
        (refined, format!("refined {:.3}", sums[2])),
    ];
    let unknown = ranks.sums.len() - known.len();
    ui.horizontal(|ui| {
        legend(ui, names.iter().map(|(colour, name)| (*colour, name.as_str())));
        if unknown > 0 {
            let text = format!("{unknown} of {} ranks not shown", ranks.sums.len());
            let hint = "Their paths are too far from the surface to measure a deviation";
            // What is wider than the plot would widen it.
            let text = RichText::new(text).small().color(palette(ui).faint);
            ui.add(egui::Label::new(text).truncate()).on_hover_text(hint);
        }
        if let Some(text) = desk.rank.and_then(|rank| rank_words(plan, rank)) {
            ui.add(egui::Label::new(RichText::new(text).strong()).truncate());
        }
    });
    let line: Vec<PlotPoint> = known.iter().map(|(k, sum)| PlotPoint::new(*k as f64, sum.log10())).collect();
    let at = |rank: usize| known.iter().find(|(k, _)| *k == rank).map(|(k, sum)| [*k as f64, sum.log10()]);
    let (best, selected) = (at(ranks.best), desk.rank.and_then(at));
    let (text, accent) = (ui.visuals().text_color(), palette(ui).accent);
    let plot = still(ui, "ranks", MARGIN).y_grid_spacer(decades).y_axis_formatter(|mark, _| of_decade(mark));
    let response = plot.show(ui, |plot| {
        let level = |name: &str, sum: f64, colour: Color32| {
            HLine::new(name.to_owned(), sum.max(1e-9).log10()).color(colour).width(1.0).style(LineStyle::dashed_loose())
        };
        plot.hline(level("initial", ranks.start_sum, initial));
        // Over the axis surface only the ranks are summed.
        if plan.params.sum == SumOver::Surface {
            plot.hline(level("refined", sums[2], refined));
        }
        plot.line(Line::new("sum", PlotPoints::Owned(line.clone())).color(text.gamma_multiply(0.6)).width(1.2));
        plot.points(Points::new("rank", PlotPoints::Owned(line)).color(text).radius(2.0));
        let mark = |name: &str, at: [f64; 2], colour: Color32, radius: f32| {
            Points::new(name.to_owned(), vec![at]).color(colour).radius(radius).shape(MarkerShape::Circle)
        };
        best.into_iter().for_each(|best| plot.points(mark("best", best, chosen, 5.0)));
        selected.into_iter().for_each(|one| plot.points(mark("selected", one, accent, 4.0)));
        plot.pointer_coordinate()
    });
    let plotted = response.response;
    plotted.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Plot of ranks"));
    if let (true, Some(point)) = (plotted.clicked(), response.inner) {
        let nearest = known.iter().min_by(|a, b| (a.0 as f64 - point.x).abs().total_cmp(&(b.0 as f64 - point.x).abs()));
        desk.rank = nearest.map(|(rank, _)| *rank).filter(|rank| desk.rank != Some(*rank));
    }
}

/// Facts about a rank.
fn rank_words(plan: &FlankPlan, rank: usize) -> Option<String> {
    let index = rank.checked_sub(1)?;
    let value = plan.ranks.singular_values.get(index)?;
    let text = match plan.ranks.sums.get(index)? {
        Some(sum) => format!("sum {sum:.3} mm, ratio {:.3}", sum / plan.ranks.start_sum.max(f64::MIN_POSITIVE)),
        None => "too far from the surface to be measured".to_owned(),
    };
    Some(format!("rank {rank}: {text}, singular value {value:.3e}"))
}

/// On the left least and greatest deviation along the guides, on the right all along the line where the cutter stands.
fn deviation(ui: &mut Ui, desk: &mut FlankDesk, planned: &Planned) {
    let colours = colours(ui);
    let names = PathChoice::ALL.map(PathChoice::name);
    let plan = &planned.result.plan;
    let lines = PathChoice::ALL.map(|choice| contact_line(path_of(plan, choice), desk.t));
    let u = lines[desk.path as usize].iter().map(|[u, ..]| *u).collect::<Vec<_>>();
    let mean_u = (!u.is_empty()).then(|| u.iter().sum::<f64>() / u.len() as f64);
    ui.horizontal(|ui| {
        legend(ui, colours.into_iter().zip(names));
    });
    let (accent, shown) = (palette(ui).accent, desk.path as usize);
    let (mut clicked, height) = (None, ui.available_height());
    ui.columns(2, |columns| {
        let [left, right] = columns else { return };
        let plot = still(left, "along the guides", MARGIN)
            .x_grid_spacer(|input| round_steps(input, 3.0))
            .height(height)
            .include_x(0.0)
            .include_x(1.0);
        let response = plot.show(left, |plot| {
            for (i, profile) in planned.profiles.iter().enumerate() {
                let width = if i == shown { 1.8 } else { 1.0 };
                for (values, strength) in [(&profile.least, 1.0), (&profile.greatest, 1.0), (&profile.mean, 0.55)] {
                    let points = profile.u.iter().zip(values).map(|(u, v)| [*u, *v]).collect::<PlotPoints>();
                    let colour = colours[i].gamma_multiply(strength);
                    plot.line(Line::new(names[i], points).color(colour).width(width));
                }
            }
            mean_u.into_iter().for_each(|u| plot.vline(VLine::new("", u).color(accent).width(1.5).allow_hover(false)));
            plot.pointer_coordinate()
        });
        response.response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Plot along the guides"));
        let pressed = response.response.clicked() || response.response.is_pointer_button_down_on();
        clicked = response.inner.filter(|_| pressed).map(|point| point.x);
        let plot = still(right, "along the ruling", MARGIN)
            .x_grid_spacer(|input| round_steps(input, 3.0))
            .height(height)
            .include_x(0.0)
            .include_x(1.0);
        let response = plot.show(right, |plot| {
            plot.hline(HLine::new("", 0.0).color(accent.gamma_multiply(0.5)).width(1.0).allow_hover(false));
            for (i, line) in lines.iter().enumerate() {
                let points = line.iter().map(|[_, v, d]| [*v, *d]).collect::<PlotPoints>();
                let width = if i == shown { 1.8 } else { 1.0 };
                plot.line(Line::new(names[i], points).color(colours[i]).width(width));
            }
        });
        response.response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Plot along the ruling"));
    });
    if let (Some(u), Some(path)) = (clicked, desk.shown_path()) {
        let [from, to] = path.axis.u0_range;
        let t = (u - from) / (to - from);
        desk.go_to(t);
    }
}

/// Figures of the plans side by side over the quantity of the sweep, and where the present plan stands.
fn sweep(ui: &mut Ui, desk: &FlankDesk) {
    let of = desk.sweep.of;
    let [faint, second, accent] = colours(ui);
    // What the user keeps may differ in more than the quantity.
    let lines = SERIES.map(|(name, _, figure)| (name, points(of, &desk.compared, figure)));
    if lines[0].1.len() < 2 {
        return says(ui, "Start a sweep in the results, under Side by side, to see its curves.");
    }
    let colours = [accent, second, faint];
    ui.horizontal(|ui| {
        legend(ui, lines.iter().zip(colours).map(|((name, _), colour)| (colour, *name)));
        ui.label(RichText::new(format!("over the {}", of.label())).small().color(palette(ui).faint));
    });
    let here = Quantity::of(of, &desk.variant());
    let response = still(ui, "sweep", MARGIN).include_y(0.0).show(ui, |plot| {
        plot.vline(VLine::new("now", here).color(accent.gamma_multiply(0.6)).width(1.0));
        for ((name, points), colour) in lines.into_iter().zip(colours) {
            let dots: PlotPoints = points.clone().into();
            plot.line(Line::new(name, PlotPoints::from(points)).color(colour).width(1.4));
            plot.points(Points::new(name, dots).color(colour).radius(2.5));
        }
    });
    response.response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Plot of the sweep"));
}

/// The machine's axes below each other, each on a scale of its own, over the cut.
fn machine(ui: &mut Ui, desk: &mut FlankDesk, planned: &Planned) {
    let why = planned.result.milled.as_ref().and_then(|milled| milled.as_ref().err());
    let Some(curves) = &planned.machine else {
        let text = match why {
            Some(why) => format!("The machine cannot follow the path: {why}"),
            None if desk.document.params().milling.machine.is_empty() => {
                "Choose a machine and plan to see its axes.".to_owned()
            }
            None => format!("Plan to see the axes of {}.", file_name(&desk.document.params().milling.machine)),
        };
        return says(ui, &text);
    };
    let room = ui.available_rect_before_wrap();
    let (rect, response) = ui.allocate_exact_size(room.size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Plot of the machine's axes"));
    let height = rect.height() / curves.axes.len().max(1) as f32;
    let inner = Rect::from_min_max(pos2(rect.left() + 64.0, rect.top()), pos2(rect.right() - 150.0, rect.bottom()));
    if inner.width() < 60.0 {
        return;
    }
    let painter = ui.painter_at(rect);
    let x_of = |t: f64| inner.left() + inner.width() * t as f32;
    for (i, axis) in curves.axes.iter().enumerate() {
        let top = rect.top() + height * i as f32;
        let row = Rect::from_min_max(pos2(inner.left(), top + 2.0), pos2(inner.right(), top + height - 2.0));
        axis_row(ui, &painter, row, (curves, axis, i), desk.shows_limits);
    }
    let colours = palette(ui);
    for (t, words) in &curves.singular {
        let x = x_of(*t);
        painter.vline(x, rect.y_range(), Stroke::new(1.0, colours.warning));
        if response.hover_pos().is_some_and(|p| (p.x - x).abs() < 5.0) {
            response.clone().on_hover_text(words);
        }
    }
    painter.vline(x_of(desk.t), rect.y_range(), Stroke::new(1.5, colours.accent));
    if let Some(pointer) = response.interact_pointer_pos() {
        desk.go_to(f64::from((pointer.x - inner.left()) / inner.width()));
    }
}

/// One axis: its letter and values on the left, its curve, and how far its limit is on the right.
fn axis_row(
    ui: &Ui,
    painter: &egui::Painter,
    row: Rect,
    (curves, axis, i): (&MachineCurves, &AxisCurve, usize),
    shows_limits: bool,
) {
    let colours = palette(ui);
    let is_linear = axis.unit == "mm";
    let letters = ['X', 'Y', 'Z', 'A', 'B', 'C'];
    let colour = colours.axes[letters.iter().position(|l| *l == axis.letter).unwrap_or(i)];
    painter.rect_filled(row, 3.0, ui.visuals().extreme_bg_color.gamma_multiply(0.7));
    let ([least, greatest], [from, to]) = (axis.range(), axis.limits);
    // What does not move is a straight line in the middle.
    let spare = 0.08 * (greatest - least).max(1e-3);
    let [low, high] =
        if shows_limits { [least.min(from), greatest.max(to)] } else { [least - spare, greatest + spare] };
    let y_of = |v: f64| row.bottom() - row.height() * ((v - low) / (high - low)) as f32;
    for limit in [from, to].into_iter().filter(|limit| (low..=high).contains(limit)) {
        let y = y_of(limit).clamp(row.top() + 1.0, row.bottom() - 1.0);
        painter.extend(egui::Shape::dashed_line(
            &[pos2(row.left(), y), pos2(row.right(), y)],
            Stroke::new(1.0, colours.bad),
            6.0,
            4.0,
        ));
    }
    let points = curves.t.iter().zip(&axis.values).map(|(t, v)| pos2(row.left() + row.width() * *t as f32, y_of(*v)));
    painter.line(points.collect(), Stroke::new(1.6, colour));
    let font = FontId::proportional(12.0);
    let name = format!("{} {}", axis.letter, axis.unit);
    painter.text(pos2(row.left() - 8.0, row.center().y), Align2::RIGHT_CENTER, name, font, colour);
    let decimals = if is_linear { 2 } else { 3 };
    let words = format!("{least:.decimals$} to {greatest:.decimals$}");
    let small = FontId::monospace(10.5);
    let (upper, lower) = (pos2(row.right() + 8.0, row.center().y - 7.0), pos2(row.right() + 8.0, row.center().y + 7.0));
    let is_tall = row.height() > 26.0;
    let at = if is_tall { upper } else { pos2(upper.x, row.center().y) };
    painter.text(at, Align2::LEFT_CENTER, words, small.clone(), ui.visuals().text_color());
    if is_tall {
        let room = format!("{:.1} {} from its limit", axis.room(), axis.unit);
        let colour = if axis.room() < 0.0 { colours.bad } else { colours.faint };
        painter.text(lower, Align2::LEFT_CENTER, room, FontId::proportional(10.5), colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_have_lines_at_round_numbers() {
        let texts = |low: f64, high: f64| {
            let input = GridInput { bounds: (low.log10(), high.log10()), base_step_size: 1.0 };
            decades(input).into_iter().map(of_decade).collect::<Vec<_>>()
        };
        assert_eq!(texts(9.0, 60.0), ["10", "20", "50"]);
        assert_eq!(texts(9.0, 20000.0), ["10", "100", "1000", "1e4"]);
        assert_eq!(texts(0.09, 1.5), ["0.1", "0.2", "0.5", "1"]);
        assert!(decades(GridInput { bounds: (f64::NEG_INFINITY, 1.0), base_step_size: 1.0 }).is_empty());
    }
}
