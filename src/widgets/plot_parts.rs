//! Parts of plots: legends, and round values on axes.

use egui::{Color32, RichText, Ui, Vec2, Vec2b};
use egui_plot::{GridInput, GridMark, Plot};

use super::theme::palette;

/// Legend of the lines of a plot, above the plot, where it hides no line.
pub fn legend<'a>(ui: &mut Ui, entries: impl IntoIterator<Item = (Color32, &'a str)>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(4.0, 0.0);
        ui.add_space(4.0);
        for (colour, name) in entries {
            let (rect, _) = ui.allocate_exact_size(egui::vec2(12.0, 14.0), egui::Sense::hover());
            ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(2.0, colour));
            ui.label(RichText::new(name).small());
            ui.add_space(10.0);
        }
    });
}

/// A fixed plot with grid lines at round values, and this share of its range free at its edges.
pub fn still(ui: &Ui, name: &str, margin: Vec2) -> Plot<'static> {
    Plot::new(name.to_owned())
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(Vec2b::new(false, false))
        .allow_boxed_zoom(false)
        .show_background(false)
        .grid_color(palette(ui).faint.gamma_multiply(0.35))
        .set_margin_fraction(margin)
        .x_grid_spacer(|input| round_steps(input, 10.0))
        .y_grid_spacer(|input| round_steps(input, 4.0))
        .x_axis_formatter(|mark, _| round_text(mark))
        .y_axis_formatter(|mark, _| round_text(mark))
        .y_axis_min_width(44.0)
}

/// Shows in place of a plot why there is none.
pub fn says(ui: &mut Ui, text: &str) {
    ui.centered_and_justified(|ui| ui.add(egui::Label::new(RichText::new(text).color(palette(ui).faint)).wrap()));
}

/// Label of a grid line, with as many decimals as the step has.
pub fn round_text(mark: GridMark) -> String {
    let decimals = (-mark.step_size.log10()).ceil().clamp(0.0, 9.0) as usize;
    // `+ 0.0` takes the sign from a zero.
    format!("{:.decimals$}", (mark.value / mark.step_size).round() * mark.step_size + 0.0)
}

/// About `count` grid lines at round values, each with its label.
pub fn round_steps(input: GridInput, count: f64) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let rough = (high - low) / count;
    if !(rough > 0.0 && rough.is_finite()) {
        return Vec::new();
    }
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| GridMark { value: i as f64 * step, step_size: step }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_at_round_values_and_say_them_in_full() {
        let texts = |low: f64, high: f64, count| {
            let input = GridInput { bounds: (low, high), base_step_size: 1.0 };
            round_steps(input, count).into_iter().map(round_text).collect::<Vec<_>>()
        };
        assert_eq!(texts(-0.1, 4.4, 10.0), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0", "3.5", "4.0"]);
        assert_eq!(texts(0.0, 29.0, 10.0), ["0", "5", "10", "15", "20", "25"]);
        assert_eq!(texts(-0.02, 0.021, 4.0), ["-0.02", "0.00", "0.02"]);
        assert!(texts(1.0, 1.0, 4.0).is_empty() && texts(f64::NAN, 1.0, 4.0).is_empty());
    }
}
