//! The meridional section of the passage, (x, r), in the panel of the step Channel.

use egui::{Color32, Role, Ui, WidgetInfo, vec2};
use egui_plot::{Line, PlotPoints};
use glam::DVec2;

use crate::widgets::plot_parts::{legend, still};
use crate::widgets::theme::{HUB, PASSAGE, SHROUD, color32};
use crate::workspaces::blisk::scene::passage::between_edges;
use wheel::channel::{Channel, ChannelWall};

/// Height of the picture (points).
const HEIGHT: f32 = 170.0;

/// Draws hub, shroud, stations and the edges of the blades.
pub fn show(ui: &mut Ui, channel: &Channel) {
    let outer = if channel.shrouded { "shroud" } else { "blade tips" };
    let [hub, shroud, passage] = [HUB, SHROUD, PASSAGE].map(color32);
    legend(ui, [(hub, "hub"), (shroud, outer), (passage, "inlet, outlet, stations")]);
    let line = |name: &str, points: Vec<DVec2>, colour: Color32, width: f32| {
        let points: PlotPoints = points.into_iter().map(|p| [p.x, p.y]).collect();
        Line::new(name.to_owned(), points).color(colour).width(width)
    };
    let plot =
        still(ui, "meridional section", vec2(0.06, 0.08)).data_aspect(1.0).height(HEIGHT).show_x(false).show_y(false);
    let response = plot.show(ui, |plot| {
        for station in between_edges(channel) {
            plot.line(line("station", vec![station.hub, station.shroud], passage.gamma_multiply(0.6), 1.0));
        }
        for u in [0, channel.low.nu - 1] {
            plot.line(line("edge", edge(&channel.low, u), passage, 2.0));
        }
        let along = |share: f64| channel.meridian.iter().map(|station| station.place(share)).collect();
        plot.line(line("hub", along(0.0), hub, 2.0));
        plot.line(line(outer, along(1.0), shroud, 2.0));
    });
    let name = "Meridional section: radius over x, in mm";
    response.response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    response.response.on_hover_text(name);
}

/// Places (x, r) of a wall's edge.
fn edge(wall: &ChannelWall, u: usize) -> Vec<DVec2> {
    let place = |v| wall.cylindrical(u, v);
    (0..wall.nv).map(|v| DVec2::new(place(v).x, place(v).r)).collect()
}
