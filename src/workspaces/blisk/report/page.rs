//! The page of a report: what its template needs beside the report's figures, which is plots.

use serde::Serialize;

use crate::workspaces::blisk::job::burning::{BurningElectrode, WheelBurning};
use crate::workspaces::blisk::job::figures::Histogram;
use crate::workspaces::blisk::report::{Convergence, ElectrodeReport, Motion, Report};
use burning::figures::BurnFigures;
use burning::schedule::{Activity, Schedule};
use feed::pose::Axis;
use feed::quantise::MM_DECIMALS;
use files::Entry;
use files::report::plot::{Plot, Series};
use files::report::{PageError, Picture, Template, file_name};

/// The page of `report`.
pub(super) fn page(report: &Report) -> Result<String, PageError> {
    const TEMPLATE: Template = Template { name: "report.html.jinja", text: include_str!("report.html.jinja") };
    #[derive(Serialize)]
    struct Page<'a> {
        report: &'a Report,
        parameters: &'a [Entry],
        part: &'a str,
        pictures: &'a [Picture],
        no_pictures: Option<&'a str>,
        electrodes: Vec<(&'a ElectrodeReport, Plots)>,
        burning: Option<Burning<'a>>,
    }
    let page = Page {
        report,
        parameters: &report.parameters.entries,
        part: report.inputs.first().map_or("", |input| file_name(&input.path)),
        pictures: &report.pictures,
        no_pictures: report.no_pictures.as_deref(),
        electrodes: report.electrodes.iter().map(|e| (e, Plots::of(e))).collect(),
        burning: report.burning.as_ref().map(Burning::of),
    };
    files::report::page(&TEMPLATE, &page)
}

/// Minutes, wear and schedule in words.
#[derive(Serialize)]
struct Burning<'a> {
    wheel: &'a WheelBurning,
    sentence: String,
    /// Figures of each electrode with its minutes, its wear and the number of electrodes that are needed.
    electrodes: Vec<(&'a BurnFigures, [String; 3])>,
    /// What the figures rest on and what is missing.
    explanation: Vec<String>,
    /// All of the wheel (minutes).
    total_min: Option<f64>,
    /// Gantt chart of the schedule, as SVG.
    gantt: Option<String>,
}

impl<'a> Burning<'a> {
    fn of(wheel: &'a WheelBurning) -> Self {
        let mut explanation = Vec::new();
        for line in wheel.electrodes.iter().flat_map(|electrode| electrode.figures.explanation()) {
            if !explanation.contains(&line) {
                explanation.push(line);
            }
        }
        let electrode = |electrode: &'a BurningElectrode| {
            let figures = &electrode.figures;
            (figures, [figures.minutes_text(), figures.wear_text(), electrode.needed_text()])
        };
        Self {
            sentence: wheel.sentence(),
            electrodes: wheel.electrodes.iter().map(electrode).collect(),
            explanation,
            total_min: wheel.schedule.as_ref().map(|schedule| schedule.total().mean),
            gantt: wheel.schedule.as_ref().map(|schedule| gantt(schedule).svg()),
            wheel,
        }
    }
}

/// Gantt chart of the burns: a bar for each over the hours at its channel, in a colour for each electrode, with a mark where
/// the electrode is changed.
fn gantt(schedule: &Schedule) -> Plot {
    const COLOURS: [&str; 5] = ["c0", "c1", "c2", "c3", "c4"];
    let hours = |minutes: f64| minutes / 60.0;
    let electrodes = schedule.rows.iter().map(|row| row.electrode + 1).max().unwrap_or(0);
    let bars = |electrode: usize| {
        let burns = schedule.rows.iter().filter(|row| row.activity == Activity::Burn && row.electrode == electrode);
        let points = burns.flat_map(|row| {
            let (channel, end) = (row.channel as f64, row.start_min + row.minutes);
            [[hours(row.start_min), channel], [hours(end), channel], [f64::NAN; 2]]
        });
        Series { points: points.collect(), class: COLOURS[electrode % COLOURS.len()], dots: false }
    };
    let changes = schedule.rows.iter().filter(|row| row.is_change());
    let changes: Vec<[f64; 2]> = changes.map(|row| [hours(row.start_min), row.channel as f64]).collect();
    let changes = Series { points: changes, class: "c5", dots: true };
    Plot {
        title: "Channel; a bar for each burn, coloured by electrode, dots where it is changed".to_owned(),
        x_label: "hours after the beginning of the set-up".to_owned(),
        size: [1100.0, 360.0],
        series: (0..electrodes).map(bars).chain([changes]).collect(),
        ..Plot::default()
    }
}

/// Plots of an electrode, as SVG.
#[derive(Default, Serialize)]
struct Plots {
    /// Rows of the path.
    rows: Option<usize>,
    /// Clearance over the path.
    clearance: Option<String>,
    /// Position and derivatives of each axis that moves.
    axes: Vec<[String; 3]>,
    /// The way of the centroid, seen along each axis of W.
    centroid: Vec<String>,
    /// Histograms of the wall distances.
    walls: Vec<String>,
    /// The genetic search: the nodes, the first node, some others.
    search: Vec<String>,
}

impl Plots {
    fn of(e: &ElectrodeReport) -> Self {
        let rows = e.motion.as_ref().map(|m| m.rows.len());
        let search = convergence(&e.ga_convergence);
        let Some(motion) = e.motion.as_ref().filter(|m| m.rows.len() > 1) else {
            return Self { rows, search, walls: walls(e), ..Self::default() };
        };
        let nodes: Vec<f64> = e.nodes.iter().map(|n| n.s_mm).collect();
        let axes = moving_axes(motion).into_iter().map(|axis| axis_plots(motion, axis, &nodes).map(|p| p.svg()));
        Self {
            rows,
            clearance: Some(clearance_plot(e, motion).svg()),
            axes: axes.collect(),
            centroid: centroid(&e.centroid),
            walls: walls(e),
            search,
        }
    }
}

/// The way of the centroid in the planes XY, XZ and YZ of W.
fn centroid(way: &[[f64; 4]]) -> Vec<String> {
    let plot = |[across, up]: [usize; 2]| {
        let letters = ['X', 'Y', 'Z'];
        let points = way.iter().map(|p| [p[across + 1], p[up + 1]]).collect();
        Plot {
            title: format!("Centroid: {}, mm", letters[up]),
            x_label: format!("{}, mm", letters[across]),
            size: [360.0, 190.0],
            series: vec![Series { points, class: "c0", dots: false }],
            ..Plot::default()
        }
    };
    [[0, 1], [0, 2], [1, 2]].map(|plane| plot(plane).svg()).to_vec()
}

/// Wall distances as shares of the samples.
fn walls(e: &ElectrodeReport) -> Vec<String> {
    let plot = |(s, found): &(f64, Histogram)| {
        let place = if *s == 0.0 { "final pose".to_owned() } else { format!("{s:.2} mm out, most uneven") };
        // A column has one wall alone.
        let walls = [(0, "c0"), (1, "c1")].into_iter().filter(|(wall, _)| found.counts[*wall].iter().any(|n| *n > 0));
        Plot {
            title: format!("% of samples, {place}"),
            x_label: "distance, mm; blue low wall, brown high wall".to_owned(),
            size: [360.0, 190.0],
            series: walls.map(|(wall, class)| Series { points: found.outline(wall), class, dots: false }).collect(),
            ..Plot::default()
        }
    };
    e.wall_distances.iter().map(|at| plot(at).svg()).collect()
}

/// Nodes whose search is shown generation by generation, beside that of the first.
const CONVERGENCE_PLOTS: usize = 3;

fn clearance_plot(e: &ElectrodeReport, motion: &Motion) -> Plot {
    let points = motion.rows.iter().zip(&motion.clearance).map(|(r, &c)| [r.s, c]).collect();
    let least = e.least_clearance_at.as_ref().zip(e.least_clearance_mm);
    let mark = least.map(|(at, mm)| ([at.s_mm, mm], format!("{mm:.4} mm, {}", at.surface)));
    Plot { marks: mark.into_iter().collect(), ..clearances_plot(points, e.required_clearance_mm) }
}

/// A plot of clearances over the retracted distance (mm), with the `required` one.
pub(super) fn clearances_plot(mut points: Vec<[f64; 2]>, required: f64) -> Plot {
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    Plot {
        title: "Clearance to the finished blisk, mm".to_owned(),
        x_label: "s, mm retracted".to_owned(),
        log_y: true,
        size: [1100.0, 260.0],
        series: vec![Series { points, class: "c0", dots: false }],
        levels: vec![(required, "required gap".to_owned())],
        ..Plot::default()
    }
}

/// First and last best objective over the nodes, then a few nodes generation by generation.
fn convergence(all: &[Convergence]) -> Vec<String> {
    if all.is_empty() {
        return Vec::new();
    }
    let of = |value: fn(&Vec<f64>) -> Option<&f64>| -> Vec<[f64; 2]> {
        all.iter().filter_map(|c| value(&c.best).map(|v| [c.node as f64, *v])).collect()
    };
    let overview = Plot {
        title: "Best objective, first and last generation".to_owned(),
        x_label: "node".to_owned(),
        size: [720.0, 190.0],
        series: vec![
            Series { points: of(|b| b.first()), class: "faint", dots: false },
            Series { points: of(|b| b.last()), class: "c0", dots: false },
        ],
        ..Plot::default()
    };
    // A few nodes from the final pose outwards, evenly spread.
    let last = all.len() - 1;
    let mut shown: Vec<usize> = (0..=CONVERGENCE_PLOTS).map(|i| i * last / CONVERGENCE_PLOTS).collect();
    shown.dedup();
    std::iter::once(overview).chain(shown.into_iter().map(|i| generation_plot(&all[i]))).map(|p| p.svg()).collect()
}

fn generation_plot(c: &Convergence) -> Plot {
    let curve = |values: &[f64]| values.iter().enumerate().map(|(i, v)| [i as f64, *v]).collect();
    Plot {
        title: format!("Node {}", c.node),
        x_label: "generation".to_owned(),
        size: [360.0, 190.0],
        series: vec![
            Series { points: curve(&c.mean), class: "mean", dots: false },
            Series { points: curve(&c.best), class: "c0", dots: false },
        ],
        ..Plot::default()
    }
}

/// Most intervals that derivatives are taken over.
const INTERVALS: f64 = 60.0;

/// Values of one axis over `s`, s rising: mm, or degrees for a rotary axis.
fn axis_curve(motion: &Motion, axis: Axis) -> Vec<[f64; 2]> {
    let value = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
    let mut points: Vec<_> = motion.rows.iter().map(|r| [r.s, value(r.pose.get(axis))]).collect();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    points
}

/// First and second derivative of a curve, from the parabola through each three neighbours among points that
/// are far enough apart for the rounding of the values not to show.
fn derivatives(curve: &[[f64; 2]]) -> [Vec<[f64; 2]>; 2] {
    let (Some(first), Some(last)) = (curve.first(), curve.last()) else { return [vec![], vec![]] };
    let apart = (last[0] - first[0]) / INTERVALS;
    let mut points = vec![*first];
    for &p in &curve[1..] {
        // A hair less, so that even rows just that far apart all count.
        if points.last().is_some_and(|q| apart > 0.0 && p[0] - q[0] >= apart * (1.0 - 1e-6)) {
            points.push(p);
        }
    }
    let parabola = |w: &[[f64; 2]]| {
        let ([s0, v0], [s1, v1], [s2, v2]) = (w[0], w[1], w[2]);
        let (before, after) = ((v1 - v0) / (s1 - s0), (v2 - v1) / (s2 - s1));
        let slope = (before * (s2 - s1) + after * (s1 - s0)) / (s2 - s0);
        ([s1, slope], [s1, 2.0 * (after - before) / (s2 - s0)])
    };
    let (slope, bend) = points.windows(3).map(parabola).unzip();
    [slope, bend]
}

fn value_at(curve: &[[f64; 2]], s: f64) -> f64 {
    let i = curve.partition_point(|p| p[0] < s).clamp(1, curve.len() - 1);
    let ([s0, v0], [s1, v1]) = (curve[i - 1], curve[i]);
    if s1 > s0 { v0 + (v1 - v0) * ((s - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { v1 }
}

/// The axes that move.
fn moving_axes(motion: &Motion) -> Vec<Axis> {
    Axis::ALL.into_iter().filter(|&axis| motion.rows.iter().any(|r| r.pose.get(axis) != 0.0)).collect()
}

/// Position, first and second derivative of `axis` side by side; `nodes` are the s of the search nodes.
fn axis_plots(motion: &Motion, axis: Axis, nodes: &[f64]) -> [Plot; 3] {
    let curve = axis_curve(motion, axis);
    let [slope, bend] = derivatives(&curve);
    let (letter, unit) = (axis.letter(), if axis.is_rotary() { "\u{b0}" } else { "mm" });
    let at_nodes = if curve.len() > 1 { nodes.iter().map(|&s| [s, value_at(&curve, s)]).collect() } else { vec![] };
    let class = ["c0", "c1", "c2", "c3", "c4", "c5"][axis as usize];
    let line = |points| Series { points, class, dots: false };
    let span = curve.first().zip(curve.last()).map_or(0.0, |(p, q)| q[0] - p[0]);
    let (step, noise) = (span / INTERVALS, 0.5 * 10f64.powi(-(MM_DECIMALS as i32)));
    // What rounding alone can do to a derivative must look flat.
    let range = |order: i32| if step > 0.0 { 40.0 * noise * (2.0 / step).powi(order) } else { 0.0 };
    let plot = |title: String, order: i32, series| Plot {
        title,
        least_range: range(order),
        x_label: "s, mm retracted".to_owned(),
        size: [360.0, 190.0],
        series,
        ..Plot::default()
    };
    let dots = Series { points: at_nodes, class: "n", dots: true };
    [
        plot(format!("{letter}, {unit}"), 0, vec![line(curve), dots]),
        plot(format!("d{letter}/ds, {unit}/mm"), 1, vec![line(slope)]),
        plot(format!("d\u{b2}{letter}/ds\u{b2}, {unit}/mm\u{b2}"), 2, vec![line(bend)]),
    ]
}

#[cfg(test)]
mod tests {
    use burning::duration::Spread;
    use burning::schedule::{Order, ScheduledElectrode, WheelBurn, schedule};
    use burning::wear::WearShare;

    use super::*;
    use feed::path::PathRow;
    use feed::pose::Pose;

    #[test]
    fn derivatives_of_a_cubic_are_its_parabola_and_line() {
        let s = |i: usize| i as f64 * 0.1;
        let y = |s: f64| 2.0 + s - 0.5 * s * s + 0.1 * s * s * s;
        let rows = (0..=400).rev().map(|i| PathRow { node: 0, s: s(i), pose: Pose { y: y(s(i)), ..Pose::FINAL } });
        let motion = Motion { rows: rows.collect(), clearance: vec![] };
        let [slope, bend] = derivatives(&axis_curve(&motion, Axis::Y));
        assert!((50..60).contains(&slope.len()), "{}", slope.len());
        for ([s, d], [_, dd]) in slope.into_iter().zip(bend) {
            assert!((d - (1.0 - s + 0.3 * s * s)).abs() < 0.1, "{s} {d}");
            assert!((dd - (-1.0 + 0.6 * s)).abs() < 1e-6, "{s} {dd}");
        }
        assert_eq!(moving_axes(&motion), [Axis::Y]);
    }

    #[test]
    fn short_or_standing_paths_have_no_derivative() {
        assert!(derivatives(&[]).concat().is_empty());
        assert!(derivatives(&[[0.0, 1.0]; 30]).concat().is_empty());
    }

    /// Two electrodes of 20 and 10 minutes in three channels.
    #[test]
    fn the_bars_of_a_gantt_chart_are_the_burns() {
        let electrode = |name: &str, minutes: f64| ScheduledElectrode {
            name: name.to_owned(),
            burning: Spread::exactly(minutes),
            wear_share: WearShare::Unlimited,
        };
        let wheel = WheelBurn {
            channels: 3,
            electrodes: vec![electrode("1", 20.0), electrode("2", 10.0)],
            order: Order::ByElectrode,
            setup_min: 30.0,
            indexing_min: 1.0,
            change_min: 6.0,
        };
        let schedule = schedule(&wheel).unwrap();
        let plot = gantt(&schedule);
        let bars = |k: usize| plot.series[k].points.chunks(3).map(|bar| bar[1][0] - bar[0][0]).collect::<Vec<_>>();
        for (k, minutes) in [(0, 20.0), (1, 10.0)] {
            assert_eq!(bars(k).len(), 3);
            assert!(bars(k).iter().all(|hours| (hours * 60.0 - minutes).abs() < 1e-9), "{:?}", bars(k));
        }
        assert_eq!(plot.series[2].points.len(), schedule.changes);
        let points = plot.series.iter().flat_map(|series| &series.points).map(|p| p[0]).filter(|x| x.is_finite());
        let end = points.fold(0.0, f64::max);
        assert!((end * 60.0 - schedule.total().mean).abs() < 1e-9, "{end}");
    }
}
