//! Meshes for the screen, and quantities shown as colours on them, made once where the work is done and not where it is
//! shown.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::caps::close_holes;
use super::passage::PassageLines;
use feed::pose::Pose;
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use rayon::prelude::*;
use render::mesh::RenderMesh;
use task::{Cancel, Cancelled};
use wheel::channel::{Channel, ChannelWall};
use wheel::electrode::Electrode;

/// What is shown of a channel.
#[derive(Debug, Clone)]
pub struct ChannelShapes {
    /// The wall on the side of smaller theta, in W.
    pub low: Arc<RenderMesh>,
    /// The wall on the side of greater theta, in W.
    pub high: Arc<RenderMesh>,
    /// The blisk with its shroud taken off, so that one sees into the channels, in W.
    pub unshrouded: Arc<RenderMesh>,
    /// Points along the channel's centreline, in W; none where it was not looked for or not found.
    pub centreline: Vec<DVec3>,
    /// The passage as lines.
    pub passage: PassageLines,
}

/// The shapes of `channel` in `blisk`, which is in W, without its centreline; `prepare` makes them ready for drawing.
pub fn channel_shapes(blisk: &Mesh, channel: &Channel, prepare: fn(&Mesh) -> RenderMesh) -> ChannelShapes {
    ChannelShapes {
        low: Arc::new(prepare(&wall_mesh(&channel.low, true))),
        high: Arc::new(prepare(&wall_mesh(&channel.high, false))),
        unshrouded: Arc::new(prepare(&unshrouded(blisk, channel))),
        centreline: Vec::new(),
        passage: PassageLines::new(channel),
    }
}

/// The grid of a wall as triangles, seen from within the channel.
pub fn wall_mesh(wall: &ChannelWall, is_low: bool) -> Mesh {
    let index = |u: usize, v: usize| (u * wall.nv + v) as u32;
    let cells = (1..wall.nu).flat_map(|u| (1..wall.nv).map(move |v| (u, v)));
    let quads = cells.map(|(u, v)| [index(u - 1, v - 1), index(u, v - 1), index(u, v), index(u - 1, v)]);
    let triangles = quads.flat_map(|[a, b, c, d]| if is_low { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
    Mesh { triangles: triangles.collect(), vertices: wall.points.clone() }
}

/// Which triangles of `blisk`, which is in W, belong to its shroud; none without one.
pub(super) fn shroud_triangles(blisk: &Mesh, channel: &Channel) -> Vec<bool> {
    let at_shroud = |p: DVec3| {
        let place = Cylindrical::from_point(p);
        channel.below_shroud(DVec2::new(place.x, place.r)) < 0.05
    };
    // Facets of the shroud's inside dip below its radius between their corners; faces of blades only end there.
    let corners: Vec<bool> = blisk.vertices.par_iter().map(|p| channel.shrouded && at_shroud(*p)).collect();
    let is_shroud = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| blisk.vertices[v as usize]);
        triangle.iter().all(|v| corners[*v as usize]) || (channel.shrouded && at_shroud((a + b + c) / 3.0))
    };
    blisk.triangles.par_iter().map(is_shroud).collect()
}

/// The blisk without its shroud, its blades with flat tips.
fn unshrouded(blisk: &Mesh, channel: &Channel) -> Mesh {
    let is_shroud = shroud_triangles(blisk, channel);
    let kept = blisk.triangles.iter().zip(is_shroud).filter(|(_, is_shroud)| !is_shroud);
    let triangles = kept.map(|(triangle, _)| *triangle).collect();
    let mut bare = Mesh { vertices: blisk.vertices.clone(), triangles }.compacted();
    if channel.shrouded {
        close_holes(&mut bare);
    }
    bare
}

/// Vertices between two looks at the cancel flag.
const BLOCK: usize = 4096;

/// Distance (mm, negative in metal) from every vertex of `electrode` at `pose` to the finished `blisk`, in W.
///
/// # Errors
/// When told to stop.
pub fn clearance_at_vertices(
    electrode: &Electrode,
    blisk: &ExactMesh,
    pose: &Pose,
    cancel: &Cancel,
) -> Result<Vec<f32>, Cancelled> {
    let placement = pose.placement(electrode.reference_point);
    let distance = |p: &DVec3| blisk.nearest(placement.transform_point3(*p)).signed_distance as f32;
    let mut values = Vec::with_capacity(electrode.mesh.vertices.len());
    for block in electrode.mesh.vertices.chunks(BLOCK) {
        cancel.check()?;
        values.par_extend(block.par_iter().map(distance));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use task::Task;
    use wheel::find_channel::find_channel;
    use wheel::options::BliskOptions;
    use wheel::parametric::{MeshResolution, ParametricBlisk};

    #[test]
    fn without_its_shroud_a_blisk_keeps_its_disc_and_blades() {
        let part = ParametricBlisk::turbine();
        let mesh = part.mesh(&MeshResolution::default()).unwrap();
        let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
        let bare = unshrouded(&mesh.in_frame(&channel.frame), &channel);
        let radii: Vec<f64> = bare.vertices.iter().map(|p| p.y.hypot(p.z)).collect();
        let (least, most) = radii.iter().fold((f64::INFINITY, 0.0), |(a, b), r| (f64::min(a, *r), f64::max(b, *r)));
        assert!((least - part.bore_radius_mm).abs() < 1e-6, "{least}");
        // The blades end at the shroud, which grows along X; the ring around it is 5 mm thick.
        let tips = part.shroud_radius_mm + 0.5 * part.chord_mm * part.shroud_slope.abs();
        assert!((part.shroud_radius_mm..tips + 0.01).contains(&most), "{most}");
        assert!(bare.is_watertight(), "no blade is hollow");
        // The hub between the blades, the bore and the two faces of the disc are a good part of what is left.
        let disc = 2.0 * std::f64::consts::PI * (part.hub_radius_mm.powi(2) - part.bore_radius_mm.powi(2));
        assert!(bare.area() > disc && bare.area() < mesh.area());
    }
}
