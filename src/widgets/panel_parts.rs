//! Parts of panels that several workspaces use.

use std::cell::RefCell;

use egui::{CollapsingHeader, Color32, Rect, RichText, Sense, Ui, UiBuilder, pos2, vec2};

use super::theme::palette;

/// A section of a panel that folds.
pub fn section(ui: &mut Ui, name: &str, open: bool, body: impl FnOnce(&mut Ui)) {
    let title = RichText::new(name).strong();
    CollapsingHeader::new(title).id_salt(name).default_open(open).show_unindented(ui, |ui| {
        body(ui);
        ui.add_space(6.0);
    });
}

/// A label before a choice, as in forms.
pub fn named<R>(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui, egui::Id) -> R) -> R {
    let row = ui.horizontal(|ui| {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(vec2(84.0, 22.0), layout, |ui| {
            ui.set_min_width(84.0);
            ui.label(name).id
        });
        add(ui, label.inner)
    });
    row.inner
}

/// Row number `i` from below over the view in `rect`, at most so wide (points).
pub fn row(ui: &mut Ui, rect: Rect, (i, widest): (usize, f32), add: impl FnOnce(&mut Ui)) {
    let width = (rect.width() - 16.0).min(widest);
    let area = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -40.0 - 36.0 * i as f32), vec2(width, 32.0));
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut child = ui.new_child(UiBuilder::new().max_rect(area.shrink2(vec2(8.0, 0.0))).layout(layout));
    child.painter().rect_filled(area, 5.0, child.visuals().window_fill.gamma_multiply(0.92));
    add(&mut child);
}

/// A framed sentence with a coloured edge.
pub fn notice(ui: &mut Ui, colour: Color32, text: &str) {
    let fill = colour.gamma_multiply(0.14);
    egui::Frame::new()
        .fill(fill)
        .corner_radius(4)
        .inner_margin(8)
        .stroke(egui::Stroke::new(1.0, colour.gamma_multiply(0.6)))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.add(egui::Label::new(sentence(text).replace("mm^2", "mm²").replace("mm^3", "mm³")).wrap());
        });
    ui.add_space(4.0);
}

/// A name on the left and its value on the right. Words end at the edge; numbers stand below each other with their
/// units in their own column. A long value takes room from the name, but not all of it.
pub fn fact(ui: &mut Ui, name: &str, value: impl Into<String>) {
    const UNITS: f32 = 36.0;
    let width = ui.available_width();
    let (rect, _) = ui.allocate_exact_size(vec2(width, 18.0), Sense::hover());
    let value = value.into();
    let (value, unit) = number_and_unit(&value).map_or((value.as_str(), None), |(n, unit)| (n, Some(unit)));
    let end = rect.right() - unit.map_or(0.0, |_| UNITS);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let needed = ui.painter().layout_no_wrap(value.to_owned(), font, Color32::WHITE).size().x;
    let border = end - (needed + 8.0).clamp(0.0, 0.75 * width);
    let left = Rect::from_min_max(rect.min, pos2(border, rect.bottom()));
    let right = Rect::from_min_max(pos2(border, rect.top()), pos2(end, rect.bottom()));
    let faint = palette(ui).faint;
    let put = |ui: &mut Ui, at: Rect, text: RichText, layout: egui::Layout| {
        let mut child = ui.new_child(egui::UiBuilder::new().max_rect(at).layout(layout));
        child.add(egui::Label::new(text).truncate());
    };
    put(ui, left, RichText::new(name).color(faint), egui::Layout::left_to_right(egui::Align::Center));
    put(ui, right, RichText::new(value), egui::Layout::right_to_left(egui::Align::Center));
    if let Some(unit) = unit.filter(|unit| !unit.is_empty()) {
        let at = Rect::from_min_max(pos2(end + 4.0, rect.top()), rect.max);
        put(ui, at, RichText::new(unit).color(faint), egui::Layout::left_to_right(egui::Align::Center));
    }
}

/// The number in `value` and its unit, which may be empty; none if it is not a number.
fn number_and_unit(value: &str) -> Option<(&str, &str)> {
    let is_number = |text: &str| text.chars().all(|c| c.is_ascii_digit() || "+-. ".contains(c)) && !text.is_empty();
    if is_number(value) {
        return Some((value, ""));
    }
    let (number, unit) = value.rsplit_once(' ')?;
    (is_number(number) && ["mm", "in", "deg", "s", "mm²", "mm³"].contains(&unit)).then_some((number, unit))
}

/// A text with a capital at its beginning; names of files and keys stay unchanged.
pub fn sentence(text: &str) -> String {
    let first = text.split(' ').next().unwrap_or_default();
    if !first.chars().all(|c| c.is_ascii_lowercase() || ",:".contains(c)) {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The name of a file without its folders.
pub fn file_name(path: &str) -> String {
    std::path::Path::new(path).file_name().map_or(path.to_owned(), |n| n.to_string_lossy().into_owned())
}

/// A typed number; a wrong text is put into `wrong`.
pub fn parsed_or(text: &str, wrong: &RefCell<Option<String>>) -> Option<f64> {
    let number = parsed(text);
    if number.is_none() && !text.trim().is_empty() {
        *wrong.borrow_mut() = Some(text.to_owned());
    }
    number
}

/// A number for a field of limited width: one far out of every range is written with an exponent.
pub fn short(number: f64, decimals: std::ops::RangeInclusive<usize>) -> String {
    const LARGE: f64 = 1e6;
    if number.abs() < LARGE {
        egui::emath::format_with_decimals_in_range(number, decimals)
    } else {
        format!("{number:.2e}")
    }
}

/// A typed number, with a decimal point or comma.
fn parsed(text: &str) -> Option<f64> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    plain.replace(',', ".").replace('\u{2212}', "-").parse().ok().filter(|n: &f64| n.is_finite())
}

/// A number with thin spaces between thousands.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A row from right to left, no higher than a button.
pub fn from_right(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), add));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_told_from_its_unit_and_from_words() {
        assert_eq!(number_and_unit("-1.4874 deg"), Some(("-1.4874", "deg")));
        assert_eq!(number_and_unit("24 288"), Some(("24 288", "")));
        assert_eq!(number_and_unit("10788.4 mm³"), Some(("10788.4", "mm³")));
        for words in ["hub", "node 7 from the final pose", "part.stl", ""] {
            assert_eq!(number_and_unit(words), None, "{words}");
        }
    }

    #[test]
    fn a_sentence_begins_with_a_capital_and_a_name_stays_as_it_is() {
        assert_eq!(sentence("jams at node 7"), "Jams at node 7");
        for name in ["part.stl: not closed", "[plan] step_mm: too large", "x_1 is wrong", ""] {
            assert_eq!(sentence(name), name);
        }
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(grouped(12), "12");
    }

    #[test]
    fn a_comma_is_a_point_and_words_are_no_number() {
        for (text, number) in
            [("1,3", Some(1.3)), (" 0.25 ", Some(0.25)), ("\u{2212}2", Some(-2.0)), ("1e-3", Some(0.001))]
        {
            assert_eq!(parsed(text), number, "{text}");
        }
        for text in ["abc", "", "1,234.5", "inf", "1e999"] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }

    #[test]
    fn no_number_is_too_long_for_its_field() {
        for number in [1e9, -1e300, 123456.0, 0.000123] {
            assert!(short(number, 3..=6).len() <= 11, "{}", short(number, 3..=6));
        }
    }
}
