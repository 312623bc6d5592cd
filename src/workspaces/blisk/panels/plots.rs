//! Plots over the withdrawn distance, all with the cursor of the 3-D view: axes, their derivatives, clearance, distances
//! from the single surfaces, and how the search converged.

use crate::widgets::plot_parts::{legend, says, still};
use crate::workspaces::blisk::desk::BliskDesk;
use std::sync::Arc;

use egui::{Color32, RichText, Ui};
use egui_plot::{Bar, BarChart, HLine, Line, LineStyle, PlotPoint, PlotPoints, VLine};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::desk::kept_runs::KeptRun;
use crate::workspaces::blisk::job::figures::{Histogram, centroid_way};
use crate::workspaces::blisk::job::node_distances::NodeDistances;
use crate::workspaces::blisk::scene::track::Track;
use feed::pose::Axis;
use feed::problem::Convergence;

/// A plot of the panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tab {
    /// Positions of all axes.
    Positions,
    /// First derivatives of all axes by the withdrawn distance.
    Velocities,
    /// Second derivatives of all axes by the withdrawn distance.
    Accelerations,
    /// Exact clearance at every row.
    Clearance,
    /// Distances from the single surfaces of the channel at every node, P1's four.
    Distances,
    /// Place of the electrode's centroid, P0's figure 7.
    Centroid,
    /// Histogram of the distances of the electrode's walls, P0's figure 4.
    Histogram,
    /// Objective over the generations.
    Convergence,
    /// The nodes as a table.
    Table,
    /// The figures of runs that are kept.
    Comparison,
}

impl Tab {
    /// Every tab in order.
    pub const ALL: [Self; 10] = [
        Self::Positions,
        Self::Velocities,
        Self::Accelerations,
        Self::Clearance,
        Self::Distances,
        Self::Centroid,
        Self::Histogram,
        Self::Convergence,
        Self::Table,
        Self::Comparison,
    ];

    /// Name of the plot.
    pub fn name(self) -> &'static str {
        let names = ["Axes", "Speed", "Second derivative", "Clearance", "Distances", "Centroid", "Histogram"];
        names.into_iter().chain(["Convergence", "Nodes", "Comparison"]).nth(self as usize).unwrap_or_default()
    }
}

/// The curves of a track, sampled once.
#[derive(Default)]
pub struct Curves {
    of: Option<Arc<Track>>,
    /// For each derivative (none, first, second) and axis.
    axes: [[Vec<PlotPoint>; 6]; 3],
    clearance: Vec<PlotPoint>,
    /// Retract distance and place of the centroid (mm).
    centroid: Vec<[f64; 4]>,
}

impl Curves {
    /// Samples `core`'s track anew if it is another than before.
    pub fn follow(&mut self, desk: &BliskDesk) {
        let track = desk.shared_track();
        if self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, &track)) {
            return;
        }
        self.clearance = track.stations().iter().map(|p| PlotPoint::new(p.s, p.clearance)).collect();
        let shown = |axis: Axis, v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
        let curves = desk.outcome().filter(|_| track.is_path).and_then(|o| o.plan.path.as_ref()).map(|p| &p.curves);
        self.axes = std::array::from_fn(|order| {
            std::array::from_fn(|i| {
                let axis = Axis::ALL[i];
                match curves {
                    Some(curves) => {
                        let steps = 400;
                        let at = |k: usize| track.length() * k as f64 / f64::from(steps as u32);
                        let value = |s: f64| shown(axis, curves.axis(axis).at(s)[order]);
                        (0..=steps).map(|k| PlotPoint::new(at(k), value(at(k)))).collect()
                    }
                    None if order == 0 => {
                        track.stations().iter().map(|p| PlotPoint::new(p.s, shown(axis, p.pose.get(axis)))).collect()
                    }
                    None => Vec::new(),
                }
            })
        });
        self.centroid = desk.outcome_of_track().map_or(Vec::new(), centroid_way);
        self.of = Some(track);
    }
}

/// Least width of the plots that have the table of nodes beside them (points).
const BESIDE_TABLE: f32 = 600.0;

/// Draws the table of nodes on the right where there is room for it and the plots, and tells whether there is.
pub fn table_beside(ui: &mut Ui, desk: &mut BliskDesk) -> bool {
    let width = 170.0 + 70.0 * desk.document.params().machine.axes.axes().len() as f32 + 70.0;
    let is_beside = ui.available_width() > width + BESIDE_TABLE && !desk.track().is_empty();
    if is_beside {
        let panel = egui::Panel::right("nodes").exact_size(width).resizable(false);
        panel.show(ui, |ui| super::node_table::show(ui, desk));
    }
    is_beside
}

/// Below this width (points) the tabs take two rows.
const NARROW: f32 = 860.0;

/// Draws tabs and the chosen plot; `is_beside` tells that the table of nodes is shown already.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, tab: &mut Tab, curves: &mut Curves, is_beside: bool) {
    curves.follow(desk);
    let is_there = |tab: Tab| match tab {
        Tab::Table => !is_beside,
        Tab::Comparison => desk.document.kept("runs").is_some(),
        _ => true,
    };
    if !is_there(*tab) {
        *tab = Tab::Positions;
    }
    let is_narrow = ui.available_width() < NARROW;
    let row = egui::Layout::left_to_right(egui::Align::Center).with_main_wrap(is_narrow);
    let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, row, |ui| {
        for other in Tab::ALL.into_iter().filter(|tab| is_there(*tab)) {
            ui.selectable_value(tab, other, other.name());
        }
        if is_narrow {
            return;
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Label::new(RichText::new(unit_note(*tab)).small().color(palette(ui).faint)).truncate());
        });
    });
    match *tab {
        Tab::Table => super::node_table::show(ui, desk),
        Tab::Comparison => super::kept_runs::show(ui, desk),
        Tab::Convergence => convergence(ui, desk),
        Tab::Clearance => clearance(ui, desk, curves),
        Tab::Distances => distances(ui, desk),
        Tab::Centroid => centroid(ui, desk, curves),
        Tab::Histogram => histogram(ui, desk),
        Tab::Positions => axes(ui, desk, curves, 0),
        Tab::Velocities => axes(ui, desk, curves, 1),
        Tab::Accelerations => axes(ui, desk, curves, 2),
    }
}

fn unit_note(tab: Tab) -> &'static str {
    match tab {
        Tab::Positions | Tab::Velocities | Tab::Accelerations | Tab::Clearance | Tab::Distances => "over mm retracted",
        Tab::Centroid => "from its final place, over mm retracted",
        Tab::Histogram => "% of the wall's samples over mm",
        Tab::Convergence => "objective over generations",
        Tab::Table | Tab::Comparison => "",
    }
}

/// A plot over the withdrawn distance; outside is on the left, as in the timeline.
fn over_distance<'a>(
    ui: &mut Ui,
    desk: &mut BliskDesk,
    name: &'static str,
    build: impl FnOnce(&mut egui_plot::PlotUi<'a>) + 'a,
) {
    let colour = palette(ui).accent;
    let (cursor, length) = (desk.feed_cursor(), desk.track().length());
    let plot = still(ui, name, egui::vec2(0.012, 0.06)).invert_x(true);
    let response = plot.show(ui, move |plot| {
        build(plot);
        if length <= 0.0 {
            // A single pose has no range of its own, and the marks of none would stand one on another.
            plot.set_plot_bounds_x(0.0..=1.0);
        }
        if let Some(cursor) = cursor {
            plot.vline(VLine::new("", cursor).color(colour).width(1.5).allow_hover(false));
        }
        plot.pointer_coordinate()
    });
    response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Plot {name}")));
    let place = |s: f64| response.transform.position_from_point_x(s);
    desk.span = Some([place(desk.track().length()), place(0.0)]);
    let pressed = response.response.dragged() || response.response.clicked();
    if let (true, Some(point)) = (pressed || response.response.is_pointer_button_down_on(), response.inner) {
        desk.cursor.playing = false;
        desk.cursor.s = point.x.clamp(0.0, desk.track().length());
        desk.machine.go_to(None);
    }
}

fn axes(ui: &mut Ui, desk: &mut BliskDesk, curves: &Curves, order: usize) {
    if nothing(ui, desk) {
        return;
    }
    let colours = palette(ui).axes;
    let name = ["axes", "speed", "acceleration"][order];
    // The axis of withdrawal runs far beyond the others and says nothing that the abscissa does not.
    let withdrawn = desk.shown_electrode().map_or(Axis::X, |(shown, _)| Axis::of_withdrawal(shown.enters_from));
    let moving = || desk.document.params().machine.axes.axes().iter().filter(|axis| **axis != withdrawn);
    let names: Vec<(Axis, String)> = moving().map(|axis| (*axis, axis_name(*axis, order))).collect();
    let others = if order == 0 { kept_lines(ui, desk, moving()) } else { Vec::new() };
    let kept: Vec<(Color32, String)> = desk.kept.all().into_iter().map(|run| (run.colour(ui), run.name())).collect();
    let of_axes = names.iter().map(|(axis, name)| (colours[*axis as usize], name.as_str()));
    let of_runs = kept.iter().filter(|_| order == 0).map(|(colour, name)| (*colour, name.as_str()));
    legend(ui, of_axes.chain(of_runs));
    over_distance(ui, desk, name, |plot| {
        others.into_iter().for_each(|line| plot.line(line));
        for (axis, name) in names {
            let points = &curves.axes[order][axis as usize];
            plot.line(Line::new(name, PlotPoints::Borrowed(points)).color(colours[axis as usize]).width(1.6));
        }
    });
}

/// Letter and unit of an axis, or of its derivatives by the withdrawn distance.
fn axis_name(axis: Axis, order: usize) -> String {
    let unit = if axis.is_rotary() { "deg" } else { "mm" };
    format!("{} {unit}{}", axis.letter(), ["", "/mm", "/mm²"][order])
}

/// The axes of kept runs as thin lines, below those of the track.
fn kept_lines<'a>(ui: &Ui, desk: &BliskDesk, axes: impl Iterator<Item = &'a Axis> + Clone) -> Vec<Line<'static>> {
    let line = |run: &KeptRun, axis: &Axis| {
        let course = run.course(desk.cursor.electrode, *axis)?;
        let name = format!("{}, {}", run.name(), axis_name(*axis, 0));
        Some(Line::new(name, PlotPoints::from(course.curve.clone())).color(run.colour(ui)).width(1.0))
    };
    let of = |run: &'_ KeptRun| axes.clone().filter_map(|axis| line(run, axis)).collect::<Vec<_>>();
    desk.kept.all().into_iter().flat_map(of).collect()
}

fn clearance(ui: &mut Ui, desk: &mut BliskDesk, curves: &Curves) {
    if nothing(ui, desk) {
        return;
    }
    let ([gap, _], least) = (desk.required(), desk.least_wanted());
    let (line, required) = (palette(ui).good, palette(ui).bad);
    let wanted = format!("required {gap:.4} mm, dashed with tolerance");
    legend(ui, [(line, "clearance mm"), (required, wanted.as_str())]);
    // Far out everything is free: what is looked for lies near the gap.
    let top = 6.0 * gap;
    over_distance(ui, desk, "clearance", |plot| {
        plot.line(Line::new("clearance", PlotPoints::Borrowed(&curves.clearance)).color(line).width(1.6));
        plot.hline(HLine::new("required", gap).color(required).width(1.0));
        plot.hline(HLine::new("with tolerance", least).color(required).style(LineStyle::dashed_loose()).width(1.0));
        plot.set_plot_bounds_y(0.0..=top);
    });
}

/// Names of the surfaces whose distances are plotted.
const SURFACES: [&str; 4] = ["low wall", "high wall", "hub", "shroud"];

fn distances(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some(outcome) = desk.outcome_of_track() else {
        says(ui, "Plan a feed path to see the distances of its nodes.");
        return;
    };
    let nodes = outcome.plan.nodes.iter().zip(&outcome.distances);
    let of = |i: usize| -> Vec<[f64; 2]> {
        let value = |d: &NodeDistances| match i {
            0 | 1 => Some(d.clearances.walls[i]).filter(|d| d.is_finite()),
            2 => d.clearances.hub,
            _ => d.clearances.shroud,
        };
        nodes.clone().filter_map(|(node, d)| Some([node.s, value(d)?])).collect()
    };
    let curves: [Vec<[f64; 2]>; 4] = std::array::from_fn(of);
    // Those of the plan that is shown, not of parameters that have changed since.
    let job = desk.work.planned().map_or(desk.document.params(), |planned| &planned.inputs.job);
    let (job, _) = job.of_electrode(desk.cursor.electrode);
    let (gap, asked) = (job.electrode.spark_gap_mm + job.plan.margin_mm, job.plan.thresholds);
    let thresholds = [asked.low_wall_mm, asked.high_wall_mm, asked.hub_mm, asked.shroud_mm];
    let colours: [Color32; 4] = std::array::from_fn(|i| palette(ui).axes[i]);
    let names: Vec<String> = SURFACES.iter().map(|name| format!("{name} mm")).collect();
    let dashed = [(palette(ui).faint, "dashed: threshold")];
    legend(ui, colours.into_iter().zip(names.iter().map(String::as_str)).chain(dashed));
    let most = thresholds.into_iter().fold(gap, f64::max);
    over_distance(ui, desk, "distances", move |plot| {
        for (i, curve) in curves.into_iter().enumerate() {
            plot.line(Line::new(SURFACES[i], PlotPoints::from(curve)).color(colours[i]).width(1.6));
            let threshold = HLine::new(format!("threshold {}", SURFACES[i]), thresholds[i].max(gap));
            plot.hline(threshold.color(colours[i]).style(LineStyle::dashed_loose()).width(1.0));
        }
        plot.set_plot_bounds_y(0.0..=6.0 * most);
    });
}

/// How far the centroid is off its final place across the withdrawal; along it the centroid only goes with the abscissa.
fn centroid(ui: &mut Ui, desk: &mut BliskDesk, curves: &Curves) {
    let Some(last) = curves.centroid.first() else {
        says(ui, "Plan a feed path to see the way of the electrode's centroid.");
        return;
    };
    let withdrawn = desk.shown_electrode().map_or(Axis::X, |(shown, _)| Axis::of_withdrawal(shown.enters_from));
    let shown: Vec<Axis> = [Axis::X, Axis::Y, Axis::Z].into_iter().filter(|axis| *axis != withdrawn).collect();
    let colours = palette(ui).axes;
    let names: Vec<String> = shown.iter().map(|axis| format!("{} mm, centroid", axis.letter())).collect();
    legend(ui, shown.iter().zip(&names).map(|(axis, name)| (colours[*axis as usize], name.as_str())));
    let lines = shown.iter().zip(&names).map(|(axis, name)| {
        let i = 1 + *axis as usize;
        let points = curves.centroid.iter().map(|p| [p[0], p[i] - last[i]]).collect::<Vec<_>>();
        Line::new(name.clone(), PlotPoints::from(points)).color(colours[*axis as usize]).width(1.6)
    });
    let lines: Vec<Line> = lines.collect();
    over_distance(ui, desk, "centroid", |plot| lines.into_iter().for_each(|line| plot.line(line)));
}

/// The distances of the electrode's walls at the node nearest to the cursor.
fn histogram(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some(outcome) = desk.outcome_of_track() else {
        says(ui, "Plan a feed path to see the distances of the electrode's walls.");
        return;
    };
    let nodes = outcome.plan.nodes.iter().zip(&outcome.distances);
    let off = |s: f64| (s - desk.cursor.s).abs();
    let Some((node, at)) = nodes.min_by(|a, b| off(a.0.s).total_cmp(&off(b.0.s))) else {
        says(ui, "The distances were not measured: plan again (F5) to see them.");
        return;
    };
    if at.walls.iter().all(Vec::is_empty) {
        says(
            ui,
            "At this node the electrode's walls are no longer between the blades: go back towards the final pose.",
        );
        return;
    }
    let found = Histogram::of(&at.walls);
    let sides = [0, 1].map(|i| (palette(ui).axes[i], SURFACES[i], found.outline(i), at.walls[i].len()));
    let names = sides
        .each_ref()
        .map(|(colour, name, _, samples)| (*colour, format!("{name}, {samples} samples, node at {:.2} mm", node.s)));
    legend(ui, names.iter().map(|(colour, name)| (*colour, name.as_str())));
    let response = still(ui, "histogram", egui::vec2(0.02, 0.06)).show(ui, |plot| {
        // A column has one wall alone.
        for (wall, (colour, name, outline, _)) in sides.into_iter().enumerate().filter(|(_, side)| side.3 > 0) {
            // The bars of both walls stand side by side in each bin.
            let place = |from: f64| from + (0.25 + 0.5 * wall as f64) * found.width;
            let bars = outline.chunks(2).map(|bin| Bar::new(place(bin[0][0]), bin[0][1]).width(0.5 * found.width));
            plot.bar_chart(BarChart::new(name, bars.collect()).color(colour));
        }
    });
    response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Plot histogram"));
}

fn convergence(ui: &mut Ui, desk: &mut BliskDesk) {
    let running = desk.work.partial_plan().map(|p| &p.convergence);
    let Some(traces) = running.filter(|t| !t.is_empty()).or(desk.outcome().map(|o| &o.plan.convergence)) else {
        nothing(ui, desk);
        return;
    };
    let nearest = |t: &&Convergence| (t.s - desk.cursor.s).abs();
    let Some(trace) = traces.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b))) else {
        says(ui, "A plan that was opened has no convergence data: plan again (F5) to see it.");
        return;
    };
    if trace.best.is_empty() {
        says(ui, "This node was not searched: it was added by path repair, or the axes come to rest there.");
        return;
    }
    let colours = palette(ui);
    let points =
        |values: &[f64]| -> PlotPoints<'static> { values.iter().enumerate().map(|(i, v)| [i as f64, *v]).collect() };
    let lines: [(&str, &[f64], Color32); 2] =
        [("best", &trace.best, colours.accent), ("mean", &trace.mean, colours.faint)];
    let names = lines.map(|(name, _, colour)| (colour, format!("{name}, node at {:.2} mm", trace.s)));
    legend(ui, names.iter().map(|(colour, name)| (*colour, name.as_str())));
    let plot = still(ui, "convergence", egui::Vec2::splat(0.05));
    let response = plot.show(ui, |plot| {
        for (name, values, colour) in lines {
            plot.line(Line::new(name, points(values)).color(colour).width(1.6));
        }
    });
    response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Plot convergence"));
}

/// Shows that there is nothing to plot, if so.
fn nothing(ui: &mut Ui, desk: &BliskDesk) -> bool {
    let empty = desk.track().is_empty();
    if empty {
        says(ui, "Plan a feed path to see its curves.");
    }
    empty
}
