//! Plans of one flank side by side: with each cutter of a list, at equal steps of a quantity, or as the user keeps them.

use std::str::FromStr;

use crate::workspaces::flank::document::fields::FIELDS;
use files::{Kind, Range};
use flank::FlankError;
use flank::cutter::FlankCutter;
use flank::params::FlankParams;
use nc::flank_job::{FlankInput, FlankJobError, FlankResult, flank};
use serde::Serialize;
use task::{Cancelled, Task};

/// What differs between plans that are compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variant {
    /// The cutter.
    pub cutter: FlankCutter,
    /// Control points of each curve of the axis surface.
    pub control_points: usize,
}

/// A plan beside others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What it was planned with.
    #[serde(flatten)]
    pub variant: Variant,
    /// Figures of the path that is milled, or the reason why there is none.
    pub figures: Result<Figures, String>,
}

/// A quantity that plans are compared over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// Radius of the cutter's bottom (mm).
    Radius,
    /// Angle between the cutter's axis and its flute (deg).
    Taper,
    /// Control points of each curve of the axis surface.
    Points,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Radius, Self::Taper, Self::Points];

    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        ["radius", "taper", "points"][self as usize]
    }

    /// Name with its unit, for an axis of a plot.
    pub fn label(self) -> &'static str {
        ["radius (mm)", "taper (deg)", "control points of each curve"][self as usize]
    }

    /// The least and the greatest value, those of the parameter's field.
    pub fn range(self) -> [f64; 2] {
        let key = ["cutter.radius_mm", "cutter.taper_deg", "plan.control_points"][self as usize];
        match FIELDS.find(key).map(|place| place.field.kind) {
            Ok(Kind::Number { range: Range(least, greatest), .. }) => [least, greatest],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// A sweep over usual values.
    pub fn usual(self) -> Sweep {
        Sweep { of: self, ends: [[0.5, 5.0], [0.0, 16.0], [4.0, 20.0]][self as usize], count: 9 }
    }

    /// The value in a plan.
    pub fn of(self, variant: &Variant) -> f64 {
        match self {
            Self::Radius => variant.cutter.radius_mm,
            Self::Taper => variant.cutter.taper_deg,
            Self::Points => variant.control_points as f64,
        }
    }

    fn set(self, variant: &mut Variant, value: f64) {
        let before = variant.cutter.clone();
        match self {
            Self::Radius => variant.cutter.radius_mm = value,
            Self::Taper => variant.cutter.taper_deg = value,
            Self::Points => variant.control_points = value.round() as usize,
        }
        variant.cutter.forget_stale_name(&before);
    }
}

/// Plans at equal steps of one quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// The quantity.
    pub of: Quantity,
    /// First and last value of the quantity.
    pub ends: [f64; 2],
    /// Number of values, both ends included.
    pub count: usize,
}

impl Sweep {
    /// Most values.
    pub const MOST: usize = 50;

    /// The plans, which differ from `base` in the quantity.
    pub fn variants(&self, base: &Variant) -> Vec<Variant> {
        let [from, to] = self.ends;
        let value = |i: usize| from + (to - from) * i as f64 / (self.count.max(2) - 1) as f64;
        let variant = |i: usize| {
            let mut variant = base.clone();
            self.of.set(&mut variant, value(i));
            variant
        };
        let mut all: Vec<Variant> = (0..self.count).map(variant).collect();
        // Steps of less than a control point are none.
        all.dedup();
        all
    }
}

impl FromStr for Sweep {
    type Err = String;

    /// A sweep as `radius:0.5:5:10`: quantity, first and last value, and number of values.
    fn from_str(text: &str) -> Result<Self, String> {
        let names = Quantity::ALL.map(Quantity::name).join(", ");
        let wrong = || {
            format!(
                "expected quantity:first:last:count, as in radius:0.5:5:10, the quantity one of {names}, and 2 to {} values",
                Self::MOST
            )
        };
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let [name, first, last, count] = parts[..] else { return Err(wrong()) };
        let of = Quantity::ALL.into_iter().find(|of| of.name() == name).ok_or_else(wrong)?;
        let [Ok(first), Ok(last)] = [first, last].map(str::parse::<f64>) else { return Err(wrong()) };
        let count = count.parse().ok().filter(|count| (2..=Self::MOST).contains(count)).ok_or_else(wrong)?;
        let [least, most] = of.range();
        if ![first, last].iter().all(|value| (least..=most).contains(value)) {
            return Err(format!("{} must lie between {least} and {most}", of.label()));
        }
        Ok(Self { of, ends: [first, last], count })
    }
}

/// A figure over a quantity: its name, the class of its line in pictures, and its value (mm).
type Line = (&'static str, &'static str, fn(&Figures) -> f64);

/// The figures that are plotted over a quantity.
pub const SERIES: [Line; 3] =
    [("mean", "c0", |f| f.mean_mm), ("undercut", "c1", |f| f.undercut_mm), ("overcut", "faint", |f| f.overcut_mm)];

/// A figure (um) of each plan that has a path over a quantity, in order: of those that differ from the last in nothing else.
pub fn points(of: Quantity, rows: &[Row], figure: fn(&Figures) -> f64) -> Vec<[f64; 2]> {
    let rest = |row: &Row| {
        let mut rest = row.variant.clone();
        of.set(&mut rest, of.range()[0]);
        rest.cutter.name.clear();
        rest
    };
    let alike = rows.iter().filter(|row| rows.last().is_some_and(|last| rest(last) == rest(row)));
    let known = alike.filter_map(|row| Some([of.of(&row.variant), 1e3 * figure(row.figures.as_ref().ok()?)]));
    let mut points: Vec<[f64; 2]> = known.collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// The rows as a table (CSV).
pub fn csv(rows: &[Row]) -> String {
    let mut text = "cutter,radius_mm,taper_deg,control_points,mean_mm,ratio,overcut_mm,undercut_mm,fails\n".to_owned();
    for Row { variant, figures } in rows {
        let cells = match figures {
            Ok(Figures { mean_mm, ratio, overcut_mm, undercut_mm, fails }) => {
                let ratio = ratio.map(|ratio| ratio.to_string()).unwrap_or_default();
                format!("{mean_mm},{ratio},{overcut_mm},{undercut_mm},{}", fails.join(" "))
            }
            Err(why) => format!(",,,,\"no path: {}\"", why.replace('"', "'")),
        };
        let Variant { cutter, control_points } = variant;
        let name = cutter.name.replace('"', "'");
        text += &format!("\"{name}\",{},{},{control_points},{cells}\n", cutter.radius_mm, cutter.taper_deg);
    }
    text
}

/// Figures of the path that is milled, of the standing cutter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Mean of the absolute deviations (mm).
    pub mean_mm: f64,
    /// Sum of the absolute deviations as a share of that of the initial path; none where that is rounding.
    pub ratio: Option<f64>,
    /// Greatest depth below the surface (mm).
    pub overcut_mm: f64,
    /// Greatest stock left on the surface (mm).
    pub undercut_mm: f64,
    /// Names of the checks that fail.
    pub fails: Vec<String>,
}

impl Figures {
    /// The figures of a plan.
    pub fn of(result: &FlankResult) -> Self {
        let deviation = &result.path().deviation;
        Self {
            mean_mm: deviation.mean,
            ratio: result.plan.share(deviation.sum),
            overcut_mm: (-deviation.most_overcut).max(0.0),
            undercut_mm: deviation.most_undercut.max(0.0),
            fails: result.checks.iter().filter(|c| !c.holds).map(|c| c.kind.name().to_owned()).collect(),
        }
    }
}

impl Row {
    /// The row of a plan.
    pub fn of(result: &FlankResult) -> Self {
        let control_points = result.plan.params.control_points;
        let variant = Variant { cutter: result.plan.cutter.clone(), control_points };
        Self { variant, figures: Ok(Figures::of(result)) }
    }

    /// The row in a sentence.
    pub fn sentence(&self) -> String {
        let words = format!("{}, {} points", self.variant.cutter.words(), self.variant.control_points);
        match &self.figures {
            Err(why) => format!("{words}: no path: {why}"),
            Ok(Figures { mean_mm, ratio, overcut_mm, undercut_mm, fails }) => {
                let ratio = ratio.map_or_else(String::new, |ratio| format!(" (ratio {ratio:.3})"));
                let [mean, overcut, undercut] = [mean_mm, overcut_mm, undercut_mm].map(|mm| 1e3 * mm);
                let checks = if fails.is_empty() {
                    "every check holds".to_owned()
                } else {
                    format!("fails {}", fails.join(", "))
                };
                format!(
                    "{words}: mean {mean:.2} um{ratio}, overcut {overcut:.1} um, undercut {undercut:.1} um; {checks}"
                )
            }
        }
    }
}

/// Plans with each of `variants` in turn.
///
/// # Errors
/// [`Cancelled`].
pub fn compare(input: &FlankInput, variants: &[Variant], task: &Task) -> Result<Vec<Row>, Cancelled> {
    let row = |(i, variant): (usize, &Variant)| {
        task.check()?;
        task.report("comparison", i as f64 / variants.len() as f64, &variant.cutter.name);
        let params = FlankParams { control_points: variant.control_points, ..input.params.clone() };
        let input = FlankInput { cutter: variant.cutter.clone(), params, ..input.clone() };
        let figures = match flank(&input, &Task::silent(&task.cancel)) {
            Ok(result) => Ok(Figures::of(&result)),
            Err(FlankJobError::Flank(FlankError::Cancelled(cancelled))) => return Err(cancelled),
            Err(error) => Err(error.to_string()),
        };
        Ok(Row { variant: variant.clone(), figures })
    };
    variants.iter().enumerate().map(row).collect()
}

/// The row of the best cutter: of those with which fewest checks fail the one with the least mean deviation.
pub fn best(rows: &[Row]) -> Option<usize> {
    let known = rows.iter().enumerate().filter_map(|(i, row)| Some((i, row.figures.as_ref().ok()?)));
    let order = |(_, a): &(usize, &Figures), (_, b): &(usize, &Figures)| {
        a.fails.len().cmp(&b.fails.len()).then(a.mean_mm.total_cmp(&b.mean_mm))
    };
    known.min_by(order).map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cylinder() -> Variant {
        Variant { cutter: FlankCutter::cylinder(1.0, 20.0), control_points: 10 }
    }

    #[test]
    fn a_sweep_varies_one_quantity_in_equal_steps() {
        let base = cylinder();
        let taper: Sweep = "taper:0:8:5".parse().unwrap();
        let all = taper.variants(&base);
        assert_eq!(all.iter().map(|v| Quantity::Taper.of(v)).collect::<Vec<_>>(), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert!(all.iter().all(|v| v.cutter.radius_mm == 1.0 && v.control_points == 10));
        let points: Sweep = "points:4:6:9".parse().unwrap();
        let counts: Vec<usize> = points.variants(&base).iter().map(|v| v.control_points).collect();
        assert_eq!(counts, [4, 5, 6], "each number once");
        // What a row holds may be taken: no value is beyond what its field takes.
        assert_eq!(Quantity::ALL.map(Quantity::range), [[1e-3, 1e4], [0.0, 45.0], [4.0, 100.0]]);
        for text in
            ["", "radius", "radius:1:2", "radius:1:2:1", "radius:0:2:3", "width:1:2:3", "points:4:200:3", "taper:a:1:2"]
        {
            assert!(text.parse::<Sweep>().is_err(), "{text}");
        }
    }

    #[test]
    fn what_has_no_path_is_left_out_of_a_plot_and_told_in_the_table() {
        let figures =
            Figures { mean_mm: 0.002, ratio: Some(0.5), overcut_mm: 0.01, undercut_mm: 0.02, fails: Vec::new() };
        let of = |radius_mm: f64, figures: Result<Figures, String>| {
            let mut variant = cylinder();
            Quantity::Radius.set(&mut variant, radius_mm);
            Row { variant, figures }
        };
        let rows = [of(3.0, Ok(figures.clone())), of(2.0, Err("too \"wide\"".to_owned())), of(1.0, Ok(figures))];
        assert_eq!(points(Quantity::Radius, &rows, |f| f.undercut_mm), [[1.0, 20.0], [3.0, 20.0]]);
        let mut mixed = rows.to_vec();
        Quantity::Taper.set(&mut mixed[0].variant, 4.0);
        assert_eq!(points(Quantity::Radius, &mixed, |f| f.undercut_mm), [[1.0, 20.0]], "another cone is another curve");
        let table = csv(&rows);
        let lines: Vec<&str> = table.lines().collect();
        let name = |i: usize| &rows[i].variant.cutter.name;
        assert_eq!(lines[1], format!("\"{}\",3,0,10,0.002,0.5,0.01,0.02,", name(0)));
        assert_eq!(lines[2], format!("\"{}\",2,0,10,,,,,\"no path: too 'wide'\"", name(1)));
        let columns = |line: &str| line.matches(',').count();
        assert!(lines.iter().all(|line| columns(line) == 8), "{table}");
    }

    #[test]
    fn the_best_cutter_is_the_most_exact_of_those_with_which_most_checks_hold() {
        let row = |mean_mm: f64, fails: &[&str]| Row {
            variant: cylinder(),
            figures: Ok(Figures {
                mean_mm,
                ratio: None,
                overcut_mm: 0.0,
                undercut_mm: 0.0,
                fails: fails.iter().map(|name| (*name).to_owned()).collect(),
            }),
        };
        let none = Row { figures: Err("too short".to_owned()), ..row(0.0, &[]) };
        assert_eq!(best(&[]), None);
        assert_eq!(best(std::slice::from_ref(&none)), None);
        assert_eq!(best(&[none.clone(), row(0.001, &["gouge"]), row(0.004, &[]), row(0.003, &[])]), Some(3));
        assert!(none.sentence().ends_with("no path: too short"));
    }
}
