//! The right panel: the pose at the cursor, the closest place, and what is selected or was clicked.

use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::context::Context;
use egui::{RichText, Ui};

use super::view::{BliskView, Probe};
use crate::widgets::panel_parts::fact;
use crate::widgets::panel_parts::grouped;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::scene::Layer;
use feed::pose::Axis;
use geometry::frame::Cylindrical;

/// Draws the inspector.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, view: &mut BliskView) {
    egui::ScrollArea::vertical().id_salt("inspector").auto_shrink([false, false]).show(ui, |ui| {
        super::scene_tree::show(ui, desk);
        selected(ui, desk, cx);
        pose(ui, desk, cx);
        contact(ui, desk, cx);
        whole_motion(ui, desk);
        probe(ui, desk, cx, view);
    });
}

fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.separator();
    ui.label(RichText::new(text).small().color(palette(ui).faint));
}

/// Facts about the selected body.
fn selected(ui: &mut Ui, desk: &BliskDesk, cx: &mut Context) {
    let Some(layer) = desk.selected else { return };
    let (length, size) = (cx.preferences.length, |ui: &mut Ui, size: glam::DVec3, frame: &str| {
        for (axis, extent) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(size.to_array()) {
            fact(ui, &format!("Along {}{frame}", axis.letter()), cx.preferences.length.show(extent, 3));
        }
    });
    match layer {
        Layer::Blisk => {
            let Some(part) = desk.work.part() else { return };
            heading(ui, layer.name());
            fact(ui, "Triangles", grouped(part.mesh.triangles.len()));
            size(ui, part.shape.bounds().size(), "");
        }
        Layer::Electrode => {
            let Some((electrode, _)) = desk.shown_electrode() else { return };
            heading(ui, layer.name());
            size(ui, electrode.mesh.bounds().size(), " of W");
            fact(ui, "Volume", format!("{:.1} mm³", electrode.volume_mm3));
            fact(ui, "Burn area", format!("{:.1} mm²", electrode.burn_area_mm2));
            fact(ui, "Least thickness", length.show(electrode.least_thickness_mm, 3));
            fact(ui, "Triangles", grouped(electrode.mesh.triangles.len()));
            super::burning::of_shown(ui, desk);
        }
        Layer::LowWall | Layer::HighWall => {
            use wheel::channel::Surface;
            let Some(found) = desk.work.channel() else { return };
            let surface = if layer == Layer::LowWall { Surface::LowWall } else { Surface::HighWall };
            heading(ui, layer.name());
            fact(ui, "Surface", found.channel.surface_name(surface));
        }
        Layer::Centreline => {
            let Some(line) = desk.work.channel().and_then(|found| found.centreline.as_ref()) else { return };
            heading(ui, layer.name());
            fact(ui, "Length", length.show(line.length(), 3));
            match line.diameters() {
                Some([least, greatest]) => {
                    fact(ui, "Least circle", length.show(least, 3));
                    fact(ui, "Greatest circle", length.show(greatest, 3));
                }
                None => fact(ui, "Made of", "middles between the walls"),
            }
        }
        _ => {}
    }
}

fn pose(ui: &mut Ui, desk: &BliskDesk, cx: &mut Context) {
    let moment = desk.moment();
    let station = desk.feed_cursor().and_then(|s| desk.track().at(s));
    let Some(pose) = moment.map(|moment| moment.pose).or(station.map(|station| station.pose)) else { return };
    let length = cx.preferences.length;
    heading(ui, "Pose of the electrode");
    if desk.is_live() {
        ui.label(RichText::new("of a preview with these parameters").small().color(palette(ui).accent));
    } else if desk.plan_is_stale() {
        ui.label(RichText::new("of a plan that is out of date").small().color(palette(ui).warning));
    }
    if let Some(moment) = moment {
        fact(ui, "Phase", moment.name());
    }
    if let Some(station) = station {
        let what = station.node.map_or("between nodes".to_owned(), |n| format!("node {n} from the final pose"));
        fact(ui, "Position", what);
        fact(ui, "Retracted", length.show(station.s, 3));
    }
    // A table turns to other channels even where the feed does not need it.
    let moves = desk.document.params().machine.axes.axes();
    let shown = |axis: &Axis| moves.contains(axis) || pose.get(*axis) != 0.0;
    for axis in Axis::ALL.into_iter().filter(shown) {
        let value = pose.get(axis);
        let text = if axis.is_rotary() { format!("{:.4} deg", value.to_degrees()) } else { length.show(value, 4) };
        fact(ui, &axis.letter().to_string(), text);
    }
    if let Some(station) = station {
        let name = if desk.track().is_path { "Clearance" } else { "Clearance (search)" };
        fact(ui, name, length.show(station.clearance, 4));
    }
}

fn contact(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let (Some([_, on_blisk]), Some(s)) = (desk.contact(), desk.contact_s()) else { return };
    let Some(outcome) = desk.outcome() else { return };
    let Some(plan) = desk.work.plan() else { return };
    let jammed = outcome.plan.jam.as_ref().and_then(|jam| Some((jam.node, jam.contact()?)));
    let (title, surface) = match (jammed, &outcome.plan.path) {
        (Some((node, contact)), _) => (format!("Jams at node {node}"), contact.surface),
        (None, Some(path)) => ("Closest point of the path".to_owned(), path.certificate.least().surface),
        (None, None) => return,
    };
    let lack = jammed.map(|(_, contact)| contact.lack);
    let against = plan.channel.surface_name(surface);
    let length = cx.preferences.length;
    heading(ui, &title);
    if desk.plan_is_stale() {
        ui.label(RichText::new("of a plan that is out of date").small().color(palette(ui).warning));
    }
    fact(ui, "Against", against);
    fact(ui, "Retracted", length.show(s, 3));
    if let Some(lack) = lack {
        fact(ui, "Short by", length.show(lack, 4));
    }
    point(ui, cx, on_blisk);
    if ui.button("Go there").clicked() {
        desk.go_to(s);
    }
}

/// A point of W in both its coordinates.
fn point(ui: &mut Ui, cx: &Context, p: glam::DVec3) {
    let (length, c) = (cx.preferences.length, Cylindrical::from_point(p));
    for (axis, value) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(p.to_array()) {
        fact(ui, &format!("{} in W", axis.letter()), length.show(value, 3));
    }
    fact(ui, "Radius", length.show(c.r, 3));
    fact(ui, "Angle about X", format!("{:.3} deg", c.theta.to_degrees()));
}

fn probe(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, view: &mut BliskView) {
    let to_w = |p: glam::DVec3| desk.work.channel().map_or(p, |f| f.channel.frame.from_parent(p));
    let length = cx.preferences.length;
    match view.probe().cloned() {
        None if desk.measuring => {
            heading(ui, "Measure");
            ui.label("Click two points in the view.");
        }
        None => {}
        Some(Probe::Point { layer, at, normal, face }) => {
            heading(ui, "Picked");
            fact(ui, "On", layer.map_or("part", crate::workspaces::blisk::scene::Layer::name));
            if let Some(face) = face {
                ui.add(egui::Label::new(RichText::new(face)).wrap());
            }
            point(ui, cx, to_w(at));
            let n = desk.work.channel().map_or(normal, |f| f.channel.frame.direction_from_parent(normal));
            fact(ui, "Normal", format!("{:.3}  {:.3}  {:.3}", n.x, n.y, n.z));
        }
        Some(Probe::Distance { from, to }) => {
            heading(ui, "Measured");
            fact(ui, "Distance", length.show((to - from).length(), 4));
            let d = to_w(to) - to_w(from);
            for (axis, value) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(d.to_array()) {
                fact(ui, &format!("{} in W", axis.letter()), length.show(value, 4));
            }
            if ui.button("Clear").clicked() {
                view.clear_probe();
            }
        }
    }
}

/// Result of the simulation of the whole motion.
fn whole_motion(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some(simulation) = desk.machine.simulation() else { return };
    heading(ui, "Whole motion on the machine");
    let colour = if simulation.holds() { ui.visuals().text_color() } else { palette(ui).bad };
    ui.add(egui::Label::new(RichText::new(simulation.sentence()).color(colour)).wrap());
    if let Some(way) = desk.machine.trouble().map(|trouble| trouble.way)
        && ui.button("Go to the collision").clicked()
    {
        desk.go_to_moment(way);
    }
}
