//! The picture of a scanned part: its points in the colours of their deviations.

use std::sync::Arc;

use super::pictures::PlanPicture;
use super::residual_stock::{MapShape, SCANNED, map_legend};
use crate::widgets::camera::{PICTURE_SIZE, standard};
use crate::widgets::theme::STEEL;
use crate::workspaces::blisk::job::scan::ScannedPart;
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use render::camera::Camera;
use render::colour::Theme;
use render::mesh::RenderMesh;
use render::scene::{Object, ObjectId, Scene};
use render::view::StandardView;

/// How solid a wheel is, whose channels are seen through its shroud.
const SEEN_THROUGH: f32 = 0.15;

/// The points of a scanned `part` on its nominal `mesh`, in the axes of the part's file. The colours end at twice the tolerance.
pub fn scan_picture(part: &ScannedPart, mesh: &Mesh) -> PlanPicture {
    let [below, above] = part.verdict.tolerance.range_mm();
    let limit = 2.0 * above.max(-below);
    let is_wheel = !part.by_channel.is_empty();
    let points = MapShape::of_points(&part.map, mesh, &Frame::IDENTITY, |_| true);
    let mut body = Object::new(ObjectId(0), Arc::new(RenderMesh::new(mesh)), STEEL);
    if is_wheel {
        (body.opacity, body.edges) = (SEEN_THROUGH, false);
    }
    let values = Some(points.values(limit));
    let points = Object { values, edges: false, ..Object::new(ObjectId(1), points.shape, STEEL) };
    let scene = Scene { objects: vec![body, points], triad: true, ..Scene::new(Theme::LIGHT) };
    let aspect = f64::from(PICTURE_SIZE[0]) / f64::from(PICTURE_SIZE[1]);
    let map = map_legend(SCANNED, limit).map;
    let names = ["material missing", "as it is to be", "material left"];
    PlanPicture {
        file: String::new(),
        title: "Deviations on the part".to_owned(),
        caption: format!(
            "The points of the scan on the nominal part{}. The colours end at {limit:.3} mm either way.",
            if is_wheel { ", which is drawn as glass" } else { "" }
        ),
        legend: [0.0, 0.5, 1.0].map(|t| map.at(t)).into_iter().zip(names).collect(),
        camera: standard(StandardView::Isometric, &scene, Camera::default(), aspect),
        scene,
    }
}
