//! Line plots as small SVG pictures. Colours and fonts come from the classes in the stylesheet of reports, so one
//! picture serves light, dark and paper.

use std::fmt::Write;

use super::escape;

/// A curve.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// Data points; a point that is not finite interrupts the line.
    pub points: Vec<[f64; 2]>,
    /// CSS class of the line, e.g. `"c0"`.
    pub class: &'static str,
    /// Whether the points are marked instead of joined.
    pub dots: bool,
}

/// A plot with linear x and linear or logarithmic y.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// What is plotted, top left.
    pub title: String,
    /// Under the x axis.
    pub x_label: String,
    /// Whether y is logarithmic; values below a thousandth are then drawn at a thousandth.
    pub log_y: bool,
    /// Least range of a linear y axis, so that noise below it is not blown up.
    pub least_range: f64,
    /// Size in CSS pixels.
    pub size: [f64; 2],
    /// The curves, later ones on top.
    pub series: Vec<Series>,
    /// Horizontal lines: value and label.
    pub levels: Vec<(f64, String)>,
    /// Marked points: place and label.
    pub marks: Vec<([f64; 2], String)>,
}

const LEFT: f64 = 54.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 24.0;
/// Least distance of a title from either end, and the room that a letter of it takes.
const LEAST_LEFT: f64 = 4.0;
const LETTER: f64 = 6.7;
const BOTTOM: f64 = 34.0;
/// Values beyond this are no measurement of anything and interrupt a line, as what is not finite does.
const BEYOND: f64 = 1e12;
/// Least y of a logarithmic plot.
const LOG_FLOOR: f64 = 1e-3;

/// Round values from `lo` to `hi`, about `count` of them: steps of 1, 2 or 5 times a power of ten.
pub fn nice_ticks(lo: f64, hi: f64, count: usize) -> Vec<f64> {
    let range = hi - lo;
    if !(range > 0.0 && range.is_finite()) {
        return vec![lo];
    }
    let raw = range / count.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let steps = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2].map(|m| m * power);
    let ends = |step: f64| [(lo / step - 1e-9).ceil(), (hi / step + 1e-9).floor()];
    // The finest step that is coarse enough, or a finer one when that leaves less than two ticks.
    let coarse = steps.iter().filter(|s| **s >= raw * 0.999).count().max(1) - 1;
    let two = steps[coarse..].iter().copied().find(|s| ends(*s)[1] > ends(*s)[0]);
    let step = two.unwrap_or(steps[coarse]);
    let [first, last] = ends(step);
    (0..=(last - first).max(0.0) as usize).map(|i| (first + i as f64) * step + 0.0).collect()
}

/// 1, 2 and 5 times the powers of ten from `lo` to `hi`.
fn log_ticks(lo: f64, hi: f64) -> Vec<f64> {
    let decades = lo.log10().floor() as i32..=hi.log10().ceil() as i32;
    let all = decades.flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(d)));
    all.filter(|t| *t >= lo * 0.999 && *t <= hi * 1.001).collect()
}

/// A number as an axis shows it: as many digits as tell ticks of `step` apart.
fn tick_text(value: f64, step: f64) -> String {
    let largest = value.abs().max(step.abs());
    if largest != 0.0 && !(1e-4..1e6).contains(&largest) {
        return format!("{value:.0e}").replace('-', "\u{2212}");
    }
    let decimals = if step > 0.0 { (-step.log10().floor()).clamp(0.0, 9.0) as usize } else { 3 };
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

fn drawable(place: &[f64; 2]) -> bool {
    place.iter().all(|v| v.abs() < BEYOND)
}

/// Data ranges and where they lie on the picture.
struct Scale {
    x: [f64; 2],
    y: [f64; 2],
    log: bool,
    size: [f64; 2],
}

impl Scale {
    fn of(plot: &Plot) -> Option<Self> {
        let log = plot.log_y;
        let marks = plot.marks.iter().map(|(p, _)| p);
        let points = plot.series.iter().flat_map(|s| &s.points).chain(marks).filter(|p| drawable(p));
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
        };
        let x = range(&mut points.clone().map(|p| p[0]));
        let levels = plot.levels.iter().map(|l| l.0).filter(|l| drawable(&[0.0, *l]));
        let y = range(&mut points.map(|p| p[1]).chain(levels).map(|v| if log { v.max(LOG_FLOOR) } else { v }));
        if !(x[0] <= x[1] && y[0] <= y[1]) {
            return None;
        }
        let y = if log {
            // Room under the least value, where its label stands.
            [y[0] * 0.5, y[1] * 1.25]
        } else {
            // A curve that stays put is drawn as a straight line in the middle, not as magnified rounding.
            let magnitude = y[0].abs().max(y[1].abs());
            let least = if magnitude > 0.0 { (1e-6 * magnitude).max(plot.least_range) } else { 1.0 };
            let half = (0.56 * (y[1] - y[0])).max(0.5 * least);
            let middle = y[0] + 0.5 * (y[1] - y[0]);
            [middle - half, middle + half]
        };
        let x = if x[1] > x[0] { x } else { [x[0] - 0.5, x[1] + 0.5] };
        Some(Self { x, y, log, size: plot.size })
    }

    fn px(&self, x: f64) -> f64 {
        LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]) * (self.size[0] - LEFT - RIGHT)
    }

    fn py(&self, y: f64) -> f64 {
        let f = |v: f64| if self.log { v.max(LOG_FLOOR).ln() } else { v };
        let t = (f(y) - f(self.y[0])) / (f(self.y[1]) - f(self.y[0]));
        self.size[1] - BOTTOM - t * (self.size[1] - TOP - BOTTOM)
    }

    fn y_ticks(&self) -> Vec<f64> {
        if self.log {
            log_ticks(self.y[0], self.y[1])
        } else {
            nice_ticks(self.y[0], self.y[1], ((self.size[1] - TOP - BOTTOM) / 26.0) as usize)
        }
    }
}

impl Plot {
    /// The plot as high as makes a length along y look as long as along x.
    pub fn with_equal_scales(mut self) -> Self {
        self.size[1] = self.size[0];
        if let Some(Scale { x, y, .. }) = Scale::of(&self) {
            let width = self.size[0] - LEFT - RIGHT;
            self.size[1] = TOP + BOTTOM + (width * (y[1] - y[0]) / (x[1] - x[0])).round();
        }
        self
    }

    /// The picture as an `<svg>` element.
    pub fn svg(&self) -> String {
        let ([w, h], title) = (self.size, escape(&self.title));
        let needed = LETTER * self.title.chars().count() as f64;
        let room = w - 2.0 * LEAST_LEFT;
        let left = LEFT.min(w - RIGHT - needed).max(LEAST_LEFT);
        // A longer one is set closer.
        let fitted = if needed > room {
            format!(" textLength=\"{room}\" lengthAdjust=\"spacingAndGlyphs\"")
        } else {
            String::new()
        };
        let mut out = format!(
            "<svg viewBox=\"0 0 {w} {h}\" style=\"--w:{w}px\" role=\"img\" aria-label=\"{title}\">\
             <text class=\"t\" x=\"{left}\" y=\"14\"{fitted}>{title}</text>"
        );
        match Scale::of(self) {
            Some(scale) => self.draw(&mut out, &scale),
            None => text(&mut out, "l", [w / 2.0, h / 2.0], "middle", "nothing to show"),
        }
        out.push_str("</svg>");
        out
    }

    fn draw(&self, out: &mut String, scale: &Scale) {
        let [w, h] = self.size;
        let (x_end, y_end) = (w - RIGHT, h - BOTTOM);
        let xs = nice_ticks(scale.x[0], scale.x[1], ((w - LEFT - RIGHT) / 70.0) as usize);
        let ys = scale.y_ticks();
        let step = |ticks: &[f64]| if let [a, b, ..] = ticks { b - a } else { 0.0 };
        for &x in &xs {
            let px = scale.px(x);
            line(out, "g", [px, TOP, px, y_end]);
            text(out, "l", [px, y_end + 14.0], "middle", &tick_text(x, step(&xs)));
        }
        for &y in &ys {
            let py = scale.py(y);
            line(out, "g", [LEFT, py, x_end, py]);
            let label = if scale.log { tick_text(y, y) } else { tick_text(y, step(&ys)) };
            text(out, "l", [LEFT - 5.0, py + 3.5], "end", &label);
        }
        line(out, "a", [LEFT, y_end, x_end, y_end]);
        text(out, "l", [x_end, h - 5.0], "end", &escape(&self.x_label));
        for (value, label) in self.levels.iter().filter(|l| drawable(&[0.0, l.0])) {
            let py = scale.py(*value);
            line(out, "lim", [LEFT, py, x_end, py]);
            text(out, "limt", [x_end - 3.0, py - 4.0], "end", &escape(label));
        }
        self.series.iter().for_each(|s| draw_series(out, scale, s));
        for (place, label) in &self.marks {
            if drawable(place) {
                draw_mark(out, [scale.px(place[0]), scale.py(place[1])], x_end, &escape(label));
            }
        }
    }
}

fn draw_series(out: &mut String, scale: &Scale, series: &Series) {
    let places = series.points.iter().map(|p| drawable(p).then(|| [scale.px(p[0]), scale.py(p[1])]));
    if series.dots {
        for [x, y] in places.flatten() {
            let _ = write!(out, "<circle class=\"{}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.9\"/>", series.class);
        }
        return;
    }
    let (mut path, mut pen_down, mut last) = (String::new(), false, String::new());
    for place in places {
        let Some([x, y]) = place else {
            pen_down = false;
            continue;
        };
        let here = format!("{x:.1} {y:.1}");
        // Rows are denser than pixels: a point that does not move the pen adds nothing.
        if !pen_down || here != last {
            let _ = write!(path, "{}{here}", if pen_down { 'L' } else { 'M' });
        }
        (pen_down, last) = (true, here);
    }
    let _ = write!(out, "<path class=\"{}\" d=\"{path}\"/>", series.class);
}

fn draw_mark(out: &mut String, [x, y]: [f64; 2], x_end: f64, label: &str) {
    let _ = write!(out, "<circle class=\"m\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
    let (anchor, dx) = if x > x_end * 0.6 { ("end", -8.0) } else { ("start", 8.0) };
    text(out, "mt", [x + dx, y + 18.0], anchor, label);
}

fn line(out: &mut String, class: &str, [x1, y1, x2, y2]: [f64; 4]) {
    let _ = write!(out, "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>");
}

fn text(out: &mut String, class: &str, [x, y]: [f64; 2], anchor: &str, content: &str) {
    let _ = write!(out, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_title_stays_within_its_plot() {
        let titled =
            |letters: usize| Plot { title: "m".repeat(letters), size: [360.0, 220.0], ..Plot::default() }.svg();
        assert!(titled(20).contains("x=\"54\" y=\"14\">mm"), "above the axis");
        assert!(titled(50).contains("x=\"13\" y=\"14\">mm"), "as far left as needed: 360 - 12 - 50 * 6.7");
        assert!(titled(60).contains("x=\"4\" y=\"14\" textLength=\"352\""), "set closer");
    }

    proptest! {
        #[test]
        fn ticks_are_round_inside_and_about_as_many_as_asked(lo in -1e3..1e3f64, range in 1e-3..1e4f64, n in 2usize..9) {
            let ticks = nice_ticks(lo, lo + range, n);
            prop_assert!(ticks.len() >= 2 && ticks.len() <= n.max(5) + 1 && ticks.len() * 3 + 3 >= n, "{ticks:?}");
            prop_assert!(ticks.iter().all(|t| *t >= lo - 1e-6 * range && *t <= lo + range * (1.0 + 1e-6)));
            for pair in ticks.windows(2) {
                let mantissa = (pair[1] - pair[0]) / 10f64.powf((pair[1] - pair[0]).log10().floor());
                prop_assert!([1.0, 2.0, 5.0, 10.0].iter().any(|m| (m - mantissa).abs() < 1e-5), "{mantissa}");
            }
        }

        #[test]
        fn any_numbers_make_a_picture_without_nan(points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..20), log_y: bool) {
            let points = points.into_iter().map(|(x, y)| [x, y]).collect();
            let series = vec![Series { points, class: "c0", dots: false }];
            let svg = Plot { size: [300.0, 200.0], series, log_y, ..Plot::default() }.svg();
            prop_assert!(svg.ends_with("</svg>") && !svg.contains("NaN") && !svg.contains("inf"));
            prop_assert!(svg.len() < 20_000, "{}", svg.len());
        }
    }

    #[test]
    fn the_curve_spans_the_frame_and_gaps_interrupt_it() {
        let points = vec![[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 0.0]];
        let plot =
            Plot { size: [400.0, 200.0], series: vec![Series { points, class: "c0", dots: false }], ..Plot::default() };
        let svg = plot.svg();
        let path = svg.split("d=\"").nth(1).unwrap().split('"').next().unwrap();
        assert_eq!(path.matches('M').count(), 2, "{path}");
        assert!(path.starts_with("M54.0 ") && path.contains("L388.0 "), "{path}");
    }

    #[test]
    fn what_comes_from_outside_is_escaped() {
        let title = "<script>alert('x')</script>\"&\u{0}".to_owned();
        let levels = vec![(1.0, "<b>".to_owned())];
        let svg = Plot { title, levels, size: [300.0, 200.0], ..Plot::default() }.svg();
        assert!(!svg.contains("<script") && !svg.contains("<b>") && !svg.contains('\u{0}'));
        assert_eq!(escape("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
    }

    #[test]
    fn tick_labels_tell_ticks_apart() {
        assert_eq!(tick_text(0.25, 0.05), "0.25");
        assert_eq!(tick_text(-20.0, 20.0), "\u{2212}20");
        assert_eq!(tick_text(0.0, 1e-7), "0e0");
        assert_eq!(log_ticks(0.09, 1.1), vec![0.1, 0.2, 0.5, 1.0]);
    }

    #[test]
    fn with_equal_scales_a_square_is_drawn_as_one() {
        let points = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let series = vec![Series { points, class: "c0", dots: false }];
        let plot = Plot { size: [500.0, 0.0], series, ..Plot::default() }.with_equal_scales();
        let scale = Scale::of(&plot).unwrap();
        let [across, up] = [scale.px(2.0) - scale.px(0.0), scale.py(0.0) - scale.py(2.0)];
        assert!((across / up - 1.0).abs() < 0.01, "{across} {up}");
    }
}
