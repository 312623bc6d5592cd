//! Plots of a study: parallel coordinates, goals against each other, and the response over two parameters.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::answer::BAD;
use super::table::{Goal, Row, Table};
use files::report::plot::{Plot, Series};
use files::report::{escape, small};

/// Most points of a plot; beyond, every so many-th is drawn beside the best ones.
const MOST: usize = 1500;
/// Most axes of parallel coordinates.
const AXES: usize = 9;
const WIDTH: f64 = 1100.0;

/// A plot with its heading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TitledPlot {
    /// Heading.
    pub title: String,
    /// Content of the picture, in a clause.
    pub note: String,
    /// The picture.
    pub svg: String,
}

/// Something of each point that can be drawn along an axis.
struct Quantity {
    name: String,
    /// Value of each row; none where there is none.
    values: Vec<Option<f64>>,
    /// Names of the values of a parameter that has words.
    words: Vec<String>,
    goal: Option<Goal>,
    is_parameter: bool,
}

impl Quantity {
    /// Least and greatest value; none if all are the same or there are none.
    fn range(&self) -> Option<[f64; 2]> {
        let known = self.values.iter().flatten().filter(|value| value.is_finite());
        let [least, greatest] =
            known.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], v| [least.min(*v), greatest.max(*v)]);
        (greatest > least).then_some([least, greatest])
    }

    fn text(&self, value: f64) -> String {
        match self.words.get(value.max(0.0) as usize) {
            Some(word) => word.clone(),
            None if value.fract() == 0.0 && value.abs() < 1e9 => format!("{value}"),
            None => small(value),
        }
    }
}

/// The parameters that vary and the numeric results that do, goals first.
fn quantities(table: &Table) -> (Vec<Quantity>, Vec<Quantity>) {
    let parameter = |j: usize| {
        let texts: Vec<&str> = table.rows.iter().map(|row| row.settings[j].as_str()).collect();
        let numbers: Vec<Option<f64>> =
            texts.iter().map(|text| text.parse().ok().filter(|n: &f64| n.is_finite())).collect();
        let mut words: Vec<String> = Vec::new();
        let mut values = numbers;
        if values.iter().any(Option::is_none) {
            let mut places: BTreeMap<&str, usize> = BTreeMap::new();
            values.clear();
            for text in texts {
                let place = *places.entry(text).or_insert_with(|| {
                    words.push(text.to_owned());
                    words.len() - 1
                });
                values.push(Some(place as f64));
            }
        }
        Quantity { name: table.keys[j].clone(), values, words, goal: None, is_parameter: true }
    };
    let result = |j: usize| Quantity {
        name: table.columns[j].name.clone(),
        values: table.rows.iter().map(|row| row.number(j).filter(|n| n.is_finite())).collect(),
        words: Vec::new(),
        goal: table.columns[j].goal,
        is_parameter: false,
    };
    let varies = |quantity: &Quantity| quantity.range().is_some();
    let parameters = (0..table.keys.len()).map(parameter).filter(varies).collect();
    let mut results: Vec<Quantity> = (0..table.columns.len()).map(result).filter(varies).collect();
    results.sort_by_key(|quantity| quantity.goal.is_none());
    (parameters, results)
}

/// The rows that are drawn: the best, and of the others so many that a page can show them.
fn drawn(table: &Table) -> Vec<usize> {
    let step = table.rows.len().div_ceil(MOST).max(1);
    let is_drawn = |(i, row): &(usize, &Row)| row.exit_code != BAD && (row.is_best || i % step == 0);
    table.rows.iter().enumerate().filter(is_drawn).map(|(i, _)| i).collect()
}

/// Every plot that the table has points for.
pub fn all(table: &Table) -> Vec<TitledPlot> {
    let (parameters, results) = quantities(table);
    let rows = drawn(table);
    let left_out = match table.rows.iter().filter(|row| row.exit_code != BAD).count() - rows.len() {
        0 => String::new(),
        n => format!("; {n} of the points are not drawn"),
    };
    let best = if table.has_goals() { ", those of the best points in the first colour" } else { "" };
    let mut plots = Vec::new();
    let axes: Vec<&Quantity> = parameters.iter().chain(&results).take(AXES).collect();
    if axes.len() >= 2 {
        plots.push(TitledPlot {
            title: "Parallel coordinates".to_owned(),
            note: format!("a line for each point{best}{left_out}"),
            svg: parallel(table, &axes, &rows),
        });
    }
    if let Some((x, y)) = scatter_axes(&parameters, &results) {
        let front =
            if table.has_goals() { "the best points joined, in the first colour" } else { "a dot for each point" };
        plots.push(TitledPlot {
            title: format!("{} against {}", y.name, x.name),
            note: format!("{front}{left_out}"),
            svg: scatter(table, x, y, &rows),
        });
    }
    if let ([a, b, ..], [response, ..]) = (&parameters[..], &results[..]) {
        plots.push(TitledPlot {
            title: format!("{} over {} and {}", response.name, a.name, b.name),
            note: format!("the mean where several points have the same two values, the darker the greater{left_out}"),
            svg: response_map(a, b, response, &rows),
        });
    }
    plots
}

/// The first two goals, or else the first parameter with the first result.
fn scatter_axes<'a>(parameters: &'a [Quantity], results: &'a [Quantity]) -> Option<(&'a Quantity, &'a Quantity)> {
    match (results, parameters) {
        ([first, second, ..], _) if first.goal.is_some() && second.goal.is_some() => Some((first, second)),
        ([first, ..], [parameter, ..]) => Some((parameter, first)),
        _ => None,
    }
}

/// Points of a study along two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// Names of the axes.
    pub names: [String; 2],
    /// Words along the first axis, which stand at 0, 1 and so on; none where it has numbers.
    pub words: Vec<String>,
    /// The best points.
    pub best: Vec<[f64; 2]>,
    /// The others.
    pub others: Vec<[f64; 2]>,
}

/// The first two goals against each other, or else the first result over the first parameter; none where nothing varies.
pub fn scatter_of(table: &Table) -> Option<Scatter> {
    let (parameters, results) = quantities(table);
    let (x, y) = scatter_axes(&parameters, &results)?;
    Some(scattered(table, x, y, &drawn(table)))
}

fn scattered(table: &Table, x: &Quantity, y: &Quantity, rows: &[usize]) -> Scatter {
    let points = |is_best: bool| -> Vec<[f64; 2]> {
        rows.iter().filter(|&&i| table.rows[i].is_best == is_best).filter_map(|&i| place(x, y, i)).collect()
    };
    Scatter {
        names: [x.name.clone(), y.name.clone()],
        words: x.words.clone(),
        best: points(true),
        others: points(false),
    }
}

/// Place of a row along both axes.
fn place(x: &Quantity, y: &Quantity, row: usize) -> Option<[f64; 2]> {
    Some([x.values[row]?, y.values[row]?])
}

fn scatter(table: &Table, x: &Quantity, y: &Quantity, rows: &[usize]) -> String {
    let Scatter { names: [x_label, title], best, others, .. } = scattered(table, x, y, rows);
    let mut front = best.clone();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let is_front = !x.is_parameter && table.columns.iter().filter(|column| column.goal.is_some()).count() == 2;
    let marks = rows.iter().filter(|&&i| table.rows[i].is_best).take(20);
    let marks = marks.filter_map(|&i| Some((place(x, y, i)?, table.rows[i].point.to_string()))).collect();
    Plot {
        title,
        x_label,
        size: [WIDTH, 340.0],
        series: vec![
            Series { points: others, class: "c1", dots: true },
            Series { points: if is_front { front } else { Vec::new() }, class: "c0", dots: false },
            Series { points: best, class: "c0", dots: true },
        ],
        marks,
        ..Plot::default()
    }
    .svg()
}

/// Margins of the plots that are drawn here.
const LEFT: f64 = 70.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 30.0;

fn opened(height: f64, title: &str) -> String {
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" style=\"--w:{WIDTH}px\" role=\"img\" aria-label=\"{}\">",
        escape(title)
    )
}

fn label(out: &mut String, class: &str, [x, y]: [f64; 2], anchor: &str, text: &str) {
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
        escape(text)
    );
}

fn parallel(table: &Table, axes: &[&Quantity], rows: &[usize]) -> String {
    let height = 340.0;
    let mut out = opened(height, "parallel coordinates");
    let x_of = |k: usize| LEFT + k as f64 * (WIDTH - 2.0 * LEFT) / (axes.len() - 1).max(1) as f64;
    let [top, bottom] = [TOP, height - BOTTOM];
    let at = |axis: &Quantity, row: usize| {
        let [least, greatest] = axis.range()?;
        Some(bottom - (axis.values[row]? - least) / (greatest - least) * (bottom - top))
    };
    for is_best in [false, true] {
        for &row in rows.iter().filter(|&&i| table.rows[i].is_best == is_best) {
            let mut path = String::new();
            let mut pen_down = false;
            for (k, axis) in axes.iter().enumerate() {
                match at(axis, row) {
                    Some(y) => {
                        let _ = write!(path, "{}{:.1} {y:.1}", if pen_down { 'L' } else { 'M' }, x_of(k));
                        pen_down = true;
                    }
                    None => pen_down = false,
                }
            }
            let (class, opacity) = if is_best { ("c0", 1.0) } else { ("faint", 0.4) };
            let _ = write!(out, "<path class=\"{class}\" opacity=\"{opacity}\" d=\"{path}\"/>");
        }
    }
    for (k, axis) in axes.iter().enumerate() {
        let x = x_of(k);
        let _ = write!(out, "<line class=\"a\" x1=\"{x:.1}\" y1=\"{top:.1}\" x2=\"{x:.1}\" y2=\"{bottom:.1}\"/>");
        let [least, greatest] = axis.range().unwrap_or_default();
        // Names of neighbours stand at two heights, so that they have room.
        label(&mut out, "t", [x, if k % 2 == 0 { 12.0 } else { 26.0 }], "middle", &short(&axis.name));
        label(&mut out, "l", [x + 5.0, top + 10.0], "start", &axis.text(greatest));
        label(&mut out, "l", [x + 5.0, bottom - 3.0], "start", &axis.text(least));
        let better = match axis.goal {
            Some(Goal::Less) => "less is better",
            Some(Goal::More) => "more is better",
            None => "",
        };
        label(&mut out, "l", [x, height - 10.0], "middle", better);
    }
    out + "</svg>"
}

/// A key without what its end tells as well.
fn short(name: &str) -> String {
    const LONGEST: usize = 34;
    let letters = name.chars().count();
    if letters <= LONGEST {
        name.to_owned()
    } else {
        format!("…{}", name.chars().skip(letters - LONGEST).collect::<String>())
    }
}

fn response_map(a: &Quantity, b: &Quantity, response: &Quantity, rows: &[usize]) -> String {
    let height = 380.0;
    let mut out = opened(height, "response over two parameters");
    let [left, right, top, bottom] = [LEFT + 60.0, WIDTH - LEFT - 60.0, TOP, height - BOTTOM - 16.0];
    // Sums and numbers of the points at each pair of values.
    let mut cells: BTreeMap<[u64; 2], ([f64; 2], f64, usize)> = BTreeMap::new();
    for &row in rows {
        let (Some(at), Some(value)) = (place(a, b, row), response.values[row]) else { continue };
        let (_, sum, count) = cells.entry(at.map(f64::to_bits)).or_insert((at, 0.0, 0));
        (*sum, *count) = (*sum + value, *count + 1);
    }
    let means: Vec<([f64; 2], f64)> = cells.values().map(|(at, sum, count)| (*at, sum / *count as f64)).collect();
    let [least, greatest] = means
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], (_, v)| [least.min(*v), greatest.max(*v)]);
    let distinct = |k: usize| {
        let mut values: Vec<f64> = means.iter().map(|(at, _)| at[k]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (xs, ys) = (distinct(0), distinct(1));
    // A grid is drawn as fields, samples as dots at their places.
    let is_grid = 3 * xs.len() * ys.len() <= 5 * means.len() && xs.len() <= 200 && ys.len() <= 200;
    let along = |value: f64, values: &[f64], ends: [f64; 2]| {
        let share = match is_grid {
            true => (values.partition_point(|v| *v < value) as f64 + 0.5) / values.len() as f64,
            false => {
                let [first, last] = [values[0], values[values.len() - 1]];
                if last > first { (value - first) / (last - first) } else { 0.5 }
            }
        };
        ends[0] + share * (ends[1] - ends[0])
    };
    for ([x, y], value) in &means {
        let share = if greatest > least { (value - least) / (greatest - least) } else { 0.5 };
        let opacity = 0.08 + 0.92 * share;
        let (x, y) = (along(*x, &xs, [left, right]), along(*y, &ys, [bottom, top]));
        let _ = if is_grid {
            let (w, h) = ((right - left) / xs.len() as f64, (bottom - top) / ys.len() as f64);
            let (x, y) = (x - 0.5 * w, y - 0.5 * h);
            write!(
                out,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" style=\"fill:var(--c0);fill-opacity:{opacity:.3}\"/>"
            )
        } else {
            write!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" style=\"fill:var(--c0);fill-opacity:{opacity:.3};stroke:var(--rule)\"/>"
            )
        };
    }
    let _ = write!(
        out,
        "<line class=\"a\" x1=\"{left}\" y1=\"{bottom}\" x2=\"{right}\" y2=\"{bottom}\"/>\
         <line class=\"a\" x1=\"{left}\" y1=\"{top}\" x2=\"{left}\" y2=\"{bottom}\"/>"
    );
    for (k, values, quantity) in [(0, &xs, a), (1, &ys, b)] {
        let every = values.len().div_ceil(if k == 0 { 12 } else { 14 }).max(1);
        for value in values.iter().step_by(every) {
            let text = quantity.text(*value);
            match k {
                0 => label(&mut out, "l", [along(*value, &xs, [left, right]), bottom + 14.0], "middle", &short(&text)),
                _ => label(&mut out, "l", [left - 5.0, along(*value, &ys, [bottom, top]) + 3.5], "end", &short(&text)),
            }
        }
    }
    label(&mut out, "l", [right, height - 6.0], "end", &a.name);
    label(&mut out, "t", [LEFT, 14.0], "start", &b.name);
    if least <= greatest {
        for (k, value) in [least, 0.5 * (least + greatest), greatest].into_iter().enumerate() {
            let (y, opacity) = (bottom - 20.0 - k as f64 * 22.0, 0.08 + 0.46 * k as f64);
            let x = right + 14.0;
            let _ = write!(
                out,
                "<rect x=\"{x}\" y=\"{y:.1}\" width=\"14\" height=\"14\" style=\"fill:var(--c0);fill-opacity:{opacity:.2}\"/>"
            );
            label(&mut out, "l", [x + 20.0, y + 11.0], "start", &response.text(value));
        }
        label(&mut out, "l", [right + 14.0, bottom - 76.0], "start", &short(&response.name));
    }
    out + "</svg>"
}
