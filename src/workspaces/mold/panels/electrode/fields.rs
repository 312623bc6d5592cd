//! Fields of the form of electrodes: figures, lengths with their unit, lists of sizes.

use std::ops::RangeInclusive;

use egui::{DragValue, Response, RichText, TextEdit, Ui, vec2};

use crate::widgets::panel_parts::named;
use crate::widgets::theme::palette;

/// Height of a row (points).
pub const HEIGHT: f32 = 22.0;
/// Width of a number in a row of its own (points).
const WIDTH: f32 = 74.0;
/// As many sizes as a list may hold, and letters as its text may have.
const MOST_SIZES: usize = 256;
const LONGEST_TEXT: usize = 4000;
/// The longest of them (mm).
const LONGEST: f64 = 1e4;

/// What a number may be, and how it is dragged and explained.
#[derive(Debug, Clone)]
pub struct Figure<'a> {
    /// From the least to the greatest that makes sense.
    pub range: RangeInclusive<f64>,
    /// Change per point of dragging.
    pub speed: f64,
    /// Width of the field (points).
    pub width: f32,
    /// What stands behind the number in the field.
    pub suffix: &'a str,
    /// Decimals that it has at most.
    pub decimals: usize,
    /// What it is, in a line.
    pub hint: &'a str,
}

/// A number alone, which is called `name` where nothing is written before it.
pub fn figure(ui: &mut Ui, value: &mut f64, name: &str, of: &Figure) -> Response {
    // What a file says stays until it is changed.
    let field = DragValue::new(value).speed(of.speed).range(of.range.clone()).clamp_existing_to_range(false);
    let field = field.max_decimals(of.decimals).suffix(of.suffix).update_while_editing(false);
    let response = ui.add_sized(vec2(of.width, HEIGHT), field);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
    if of.hint.is_empty() { response } else { response.on_hover_text(of.hint) }
}

/// A number in a row of its own, with its unit.
pub fn measure(
    ui: &mut Ui,
    name: &str,
    value: &mut f64,
    (range, unit, hint): (RangeInclusive<f64>, &str, &str),
) -> Response {
    named(ui, name, |ui, _| {
        // The smaller what it may be, the finer the hand.
        let speed = (range.end() / 2000.0).clamp(0.001, 0.05);
        let response = figure(ui, value, name, &Figure { range, speed, width: WIDTH, suffix: "", decimals: 4, hint });
        ui.label(RichText::new(unit).color(palette(ui).faint));
        response
    })
}

/// Sizes as text, rising; what is typed is taken once the field is left, if it is sizes. Else it stays and says why not.
pub fn sizes(ui: &mut Ui, name: &str, values: &mut Vec<f64>, hint: &str) {
    let id = ui.scope_id().with(("sizes", name));
    // Of other values what was typed is of no use: these were undone, or loaded.
    let typed = ui.data_mut(|d| d.get_temp::<(Vec<f64>, String)>(id)).filter(|(of, _)| of == values);
    let mut text = typed.map_or_else(|| sizes_text(values), |(_, text)| text);
    let response = named(ui, name, |ui, _| {
        let width = (ui.available_width() - 30.0).max(WIDTH);
        let field = TextEdit::singleline(&mut text).desired_width(width).char_limit(LONGEST_TEXT).hint_text("none");
        let response = ui.add_sized(vec2(width, HEIGHT), field).on_hover_text(hint);
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        ui.label(RichText::new("mm").color(palette(ui).faint));
        response
    });
    let read = read_sizes(&text);
    if let Err(problem) = &read {
        ui.add(egui::Label::new(RichText::new(problem).small().color(palette(ui).bad)).wrap());
    }
    match read {
        Ok(read) if !response.has_focus() => {
            *values = read;
            ui.data_mut(|d| d.remove::<(Vec<f64>, String)>(id));
        }
        _ => drop(ui.data_mut(|d| d.insert_temp(id, (values.clone(), text)))),
    }
}

fn sizes_text(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// The sizes in `text`, rising, each once. Between them stand commas or blanks; beside semicolons commas are decimal ones.
///
/// # Errors
/// A line saying what is no size.
fn read_sizes(text: &str) -> Result<Vec<f64>, String> {
    let is_between = |c: char| c.is_whitespace() || if text.contains(';') { c == ';' } else { c == ',' };
    let read = |word: &str| {
        let size = word.replace(',', ".").parse::<f64>().ok().filter(|size| *size > 0.0 && *size <= LONGEST);
        size.ok_or_else(|| format!("{word:?} is no size: lengths above 0 up to {LONGEST} mm, with commas between"))
    };
    let mut sizes = text.split(is_between).filter(|word| !word.is_empty()).map(read).collect::<Result<Vec<_>, _>>()?;
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    if sizes.len() > MOST_SIZES { Err(format!("These are more than {MOST_SIZES} sizes.")) } else { Ok(sizes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_in_any_order_with_either_comma() {
        for text in ["12, 8,10.5", "8 10.5  12 12", "10,5; 8; 12;", "\t8,10.5,\n12"] {
            assert_eq!(read_sizes(text), Ok(vec![8.0, 10.5, 12.0]), "{text:?}");
        }
        assert_eq!(read_sizes(" , "), Ok(Vec::new()));
        let sizes = vec![5.0, 7.25, 100.0];
        assert_eq!(read_sizes(&sizes_text(&sizes)), Ok(sizes));
    }

    #[test]
    fn what_is_no_size_is_named() {
        for (text, word) in [("8, x", "\"x\""), ("0", "\"0\""), ("8 -3", "\"-3\""), ("nan", "nan"), ("1e9", "1e9")] {
            assert!(read_sizes(text).unwrap_err().contains(word), "{text:?}");
        }
        let many: Vec<f64> = (1..=257).map(f64::from).collect();
        assert!(read_sizes(&sizes_text(&many)).is_err());
    }
}
