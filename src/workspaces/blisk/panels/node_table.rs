//! The nodes of the track as a table; a click moves the cursor.

use crate::workspaces::blisk::desk::BliskDesk;
use egui::{Align, Color32, Layout, RichText, Role, Ui, WidgetInfo};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::scene::track::Station;
use feed::pose::Axis;

/// Draws the table.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    let track = desk.shared_track();
    let nodes: Vec<_> = track.nodes().copied().collect();
    let current = desk.feed_cursor().and_then(|s| track.nearest_node(s));
    let gap = desk.least_wanted();
    let colours = palette(ui);
    let axes = desk.document.params().machine.axes.axes();
    let head = |axis: &Axis| format!("{} {}", axis.letter(), if axis.is_rotary() { "deg" } else { "mm" });
    let mut heads = vec!["node".to_owned(), "s mm".to_owned()];
    heads.extend(axes.iter().map(head));
    heads.push("clearance mm".to_owned());
    let mut table = TableBuilder::new(ui)
        .id_salt("nodes")
        .striped(true)
        .sense(egui::Sense::click())
        .cell_layout(Layout::right_to_left(Align::Center))
        .column(Column::exact(44.0))
        .columns(Column::remainder().at_least(62.0), heads.len() - 2)
        .column(Column::remainder().at_least(84.0))
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
            let response = row.response();
            response.widget_info(|| {
                WidgetInfo::selected(Role::Row, true, current == Some(i), format!("Node {}", number_of(node, i)))
            });
            if response.clicked() {
                chosen = Some(node.s);
            }
        });
    });
    if let Some(s) = chosen {
        desk.go_to(s);
    }
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
