//! Spark gap and removal rate of the steps of a technology over the charge of a pulse.

use burning::technology::Step;
use egui::{Color32, RichText, Ui, Vec2};
use egui_plot::{GridInput, GridMark, PlotPoint, PlotPoints, Points, Text};

use crate::widgets::plot_parts::{legend, says, still};
use crate::widgets::theme::palette;

/// Height of the plots (points).
const HEIGHT: f32 = 190.0;

/// Curve of a plot: its name, and the figure of a step.
type Curve = (&'static str, fn(&Step) -> Option<f64>);

/// Name of a step, and its point: decimal logarithms of its charge and of a figure.
type StepPoint<'a> = (&'a str, [f64; 2]);

const GAPS: [Curve; 2] =
    [("gap at the sides, mm", |step| step.gap_side_mm), ("gap at the front, mm", |step| step.gap_front_mm)];
const RATES: [Curve; 1] = [("rate, mm³/min", |step| step.rate_mm3_min)];

/// Charge of a pulse (µC): its energy by the voltage of the spark, which tables do not give.
fn charge(step: &Step) -> Option<f64> {
    step.ip_a.zip(step.on_us).map(|(current, time)| current * time).filter(|charge| *charge > 0.0)
}

/// Draws the plots side by side.
pub(super) fn show(ui: &mut Ui, steps: &[Step]) {
    ui.columns(2, |columns| {
        plot(&mut columns[0], "Spark gap", &GAPS, steps);
        plot(&mut columns[1], "Removal rate", &RATES, steps);
    });
}

fn plot(ui: &mut Ui, name: &str, curves: &[Curve], steps: &[Step]) {
    let colours = palette(ui).axes;
    let of = |(_, figure): &Curve| -> Vec<StepPoint> {
        let at = |step: &'_ Step| Some([charge(step)?.log10(), figure(step).filter(|y| *y > 0.0)?.log10()]);
        steps.iter().filter_map(|step| Some((step.name.as_str(), at(step)?))).collect()
    };
    let all: Vec<(Color32, &str, Vec<StepPoint>)> =
        curves.iter().zip([2, 3]).map(|(curve, colour)| (colours[colour], curve.0, of(curve))).collect();
    let given = || all.iter().filter(|(.., points)| !points.is_empty());
    let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), HEIGHT), egui::Sense::hover());
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(rect));
    let ui = &mut ui;
    if given().next().is_none() {
        return says(ui, &format!("{name}: no step has it together with current and pulse duration."));
    }
    legend(ui, given().map(|(colour, name, _)| (*colour, *name)));
    let ink = ui.visuals().text_color();
    let spot = |mark: GridMark, _: &std::ops::RangeInclusive<f64>| power_text(mark.value);
    let response = still(ui, name, Vec2::splat(0.12))
        .x_grid_spacer(powers)
        .y_grid_spacer(powers)
        .x_axis_formatter(spot)
        .y_axis_formatter(spot)
        .x_axis_label("charge of a pulse, IP × on (µC)")
        .show(ui, |plot| {
            for (colour, curve, points) in given() {
                for (name, [x, y]) in points {
                    let text = Text::new(*curve, PlotPoint::new(*x, *y), RichText::new(*name).small().color(ink));
                    plot.text(text.anchor(egui::Align2::LEFT_BOTTOM));
                }
                let points: Vec<[f64; 2]> = points.iter().map(|(_, point)| *point).collect();
                plot.points(Points::new(*curve, PlotPoints::from(points)).radius(3.5).color(*colour));
            }
        });
    response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Plot {name}")));
}

/// Grid lines at 1, 2 and 5 times powers of ten, of an axis of decimal logarithms.
fn powers(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(low.is_finite() && high.is_finite() && high - low < 40.0) {
        return Vec::new();
    }
    let decades = (low.floor() as i32)..=(high.ceil() as i32);
    let marks = decades.flat_map(|decade| [1.0_f64, 2.0, 5.0].map(|m| (f64::from(decade) + m.log10(), m == 1.0)));
    let within = marks.filter(|(value, is_power)| (low..=high).contains(value) && (*is_power || high - low < 3.0));
    within.map(|(value, is_power)| GridMark { value, step_size: if is_power { 1.0 } else { 0.5 } }).collect()
}

/// The number of which this is the decimal logarithm.
fn power_text(log: f64) -> String {
    let decimals = (-log.floor()).clamp(0.0, 9.0) as usize;
    format!("{:.decimals$}", 10f64.powf(log))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_of_logarithms_say_the_numbers_themselves() {
        let texts = |bounds| {
            let marks = powers(GridInput { bounds, base_step_size: 1.0 });
            marks.into_iter().map(|mark| power_text(mark.value)).collect::<Vec<_>>()
        };
        assert_eq!(texts((-2.1, -0.9)), ["0.01", "0.02", "0.05", "0.1"]);
        assert_eq!(texts((0.5, 2.1)), ["5", "10", "20", "50", "100"]);
        assert_eq!(texts((-1.0, 4.0)), ["0.1", "1", "10", "100", "1000", "10000"]);
        assert!(texts((f64::NEG_INFINITY, 1.0)).is_empty());
    }

    #[test]
    fn a_step_without_current_has_no_charge() {
        let step = Step { ip_a: Some(20.0), on_us: Some(56.0), ..Step::default() };
        assert_eq!(charge(&step), Some(1120.0));
        assert_eq!(charge(&Step { ip_a: None, ..step }), None);
    }
}
