//! The nodes of the track as a table, those of a plan with their distances and objectives; a click moves the cursor.

use crate::workspaces::blisk::desk::BliskDesk;
use egui::{Align, Color32, Layout, RichText, Role, Ui, WidgetInfo};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::job::node_distances::NodeDistances;
use crate::workspaces::blisk::scene::track::Station;
use feed::pose::Axis;
use feed::problem::Node;

/// Draws the table.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    let track = desk.shared_track();
    let nodes: Vec<_> = track.nodes().copied().collect();
    let current = desk.feed_cursor().and_then(|s| track.nearest_node(s));
    let gap = desk.least_wanted();
    let axes = desk.document.params().machine.axes.axes();
    let head = |axis: &Axis| format!("{} {}", axis.letter(), if axis.is_rotary() { "deg" } else { "mm" });
    let mut heads = vec!["node".to_owned(), "s mm".to_owned()];
    heads.extend(axes.iter().map(head));
    heads.push("clearance mm".to_owned());
    let figures = figures(desk);
    heads.extend(FIGURES.iter().filter(|_| !figures.is_empty()).map(|head| (*head).to_owned()));
    let scrolled =
        egui::ScrollArea::horizontal().show(ui, |ui| table(ui, (&heads, &nodes, &figures), axes, (current, gap)));
    if let Some(s) = scrolled.inner {
        desk.go_to(s);
    }
}

/// Heads of the columns that the nodes of a plan have beside those of every track: P0's distances and objectives, and P1's
/// distances from hub and shroud.
const FIGURES: [&str; 9] = ["D_L mm", "D_R mm", "S_L mm", "S_R mm", "hub mm", "shroud mm", "Obj1", "Obj2", "objective"];

/// Values of these columns at a node.
type Figures = [Option<f64>; FIGURES.len()];

/// The distances and objectives of every node of the plan; nothing where the nodes are those of a search or of a preview.
fn figures(desk: &BliskDesk) -> Vec<Figures> {
    let Some(outcome) = desk.outcome_of_track() else { return Vec::new() };
    let of = |(node, at): (&Node, &NodeDistances)| {
        let ([d_l, d_r], [s_l, s_r]) = (at.spread.least, at.spread.deviation.map(Some));
        let (hub, shroud, objective) = (at.clearances.hub, at.clearances.shroud, node.objective);
        let [obj1, obj2, total] = [objective.smoothness, objective.centring, objective.total].map(Some);
        [d_l, d_r, s_l, s_r, hub, shroud, obj1, obj2, total]
    };
    outcome.plan.nodes.iter().zip(&outcome.distances).map(of).collect()
}

/// Draws the table; the withdrawn distance of the node that is clicked on.
fn table(
    ui: &mut Ui,
    (heads, nodes, figures): (&[String], &[Station], &[Figures]),
    axes: &[Axis],
    (current, gap): (Option<usize>, f64),
) -> Option<f64> {
    let colours = palette(ui);
    let mut table = TableBuilder::new(ui)
        .id_salt("nodes")
        .striped(true)
        .sense(egui::Sense::click())
        .cell_layout(Layout::right_to_left(Align::Center))
        .column(Column::exact(44.0))
        .columns(Column::remainder().at_least(62.0), axes.len() + 1)
        .column(Column::remainder().at_least(84.0))
        .columns(Column::remainder().at_least(68.0), heads.len() - axes.len() - 3)
        .min_scrolled_height(0.0)
        .auto_shrink([false, false]);
    if let Some(row) = current {
        table = table.scroll_to_row(row, None);
    }
    let table = table.header(20.0, |mut header| {
        for head in heads {
            header.col(|ui| {
                ui.add(egui::Label::new(RichText::new(head).small().color(colours.faint)).truncate());
            });
        }
    });
    let mut chosen = None;
    table.body(|body| {
        body.rows(18.0, nodes.len(), |mut row| {
            let i = row.index();
            let node = &nodes[i];
            row.set_selected(current == Some(i));
            cells(&mut row, node, i, axes, (node.clearance < gap).then_some(colours.bad));
            let own = node.node.and_then(|node| figures.get(node));
            for value in own.copied().unwrap_or_default().iter().filter(|_| !figures.is_empty()) {
                row.col(|ui| {
                    let text = value.map_or_else(String::new, |value| format!("{value:.4}"));
                    ui.label(RichText::new(text).monospace());
                });
            }
            let response = row.response();
            response.widget_info(|| {
                WidgetInfo::selected(Role::Row, true, current == Some(i), format!("Node {}", number_of(node, i)))
            });
            if response.clicked() {
                chosen = Some(node.s);
            }
        });
    });
    chosen
}

/// The cells of the node in this place; its clearance in `alarm` if there is one.
fn cells(row: &mut TableRow, node: &Station, place: usize, axes: &[Axis], alarm: Option<Color32>) {
    let number = |v: f64| RichText::new(format!("{v:.4}")).monospace();
    row.col(|ui| {
        ui.label(RichText::new(number_of(node, place).to_string()).monospace());
    });
    row.col(|ui| {
        ui.label(number(node.s));
    });
    for axis in axes {
        let value = node.pose.get(*axis);
        row.col(|ui| {
            ui.label(number(if axis.is_rotary() { value.to_degrees() } else { value }));
        });
    }
    row.col(|ui| {
        let colour = alarm.unwrap_or(ui.visuals().text_color());
        ui.label(number(node.clearance).color(colour));
    });
}

/// Number of a node as verdicts, reports and path files give it: counted from the final pose.
fn number_of(node: &Station, place: usize) -> usize {
    node.node.unwrap_or(place)
}
