//! What stock is left, and the copying motion, as figures of a report and as a mesh with a value at every vertex.

use glam::DVec3;
use serde::Serialize;

use feed::copying::{Copying, CopyingExtent};
use feed::residual_stock::{DeviationMap, Layer, ResidualStock, TOLERANCE};
use geometry::mesh::Mesh;
use wheel::channel::Channel;

/// What the electrodes leave of their channel.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ResidualStockReport {
    /// The answer in a sentence.
    pub sentence: String,
    /// Deviations up to this count as none (mm).
    pub tolerance_mm: f64,
    /// Volume of the channel over the span of the blades along the passage (mm^3).
    pub channel_volume_mm3: f64,
    /// Volume of the channel that no electrode erodes (mm^3).
    pub left_volume_mm3: f64,
    /// Greatest depth of a point in that stock (mm).
    pub left_depth_mm: f64,
    /// Place of the greatest depth, in W (mm).
    pub left_at: Option<[f64; 3]>,
    /// Figures of each surface of the channel.
    pub surfaces: Vec<SurfaceReport>,
    /// The map as a file, if it was written.
    pub file: Option<String>,
}

/// Stock and overcut on one surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct SurfaceReport {
    /// Name of the surface for a reader.
    pub surface: String,
    pub area_mm2: f64,
    pub left: LayerReport,
    pub overcut: LayerReport,
}

/// All that exceeds the tolerance on one side of a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct LayerReport {
    pub area_mm2: f64,
    pub volume_mm3: f64,
    pub depth_mm: f64,
    /// Whether the layer is thicker than can be told.
    pub or_more: bool,
    /// Thickest place of the layer, in W (mm).
    pub at: Option<[f64; 3]>,
}

impl From<&Layer> for LayerReport {
    fn from(l: &Layer) -> Self {
        let at = l.at.map(|p| p.to_array());
        Self { area_mm2: l.area_mm2, volume_mm3: l.volume_mm3, depth_mm: l.depth_mm, or_more: l.or_more, at }
    }
}

impl ResidualStockReport {
    /// The figures of `residual_stock` in `channel`.
    pub fn of(residual_stock: &ResidualStock, channel: &Channel) -> Self {
        let surfaces = residual_stock.surfaces.iter().map(|s| SurfaceReport {
            surface: channel.surface_name(s.surface).to_owned(),
            area_mm2: s.area_mm2,
            left: (&s.left).into(),
            overcut: (&s.overcut).into(),
        });
        let stock = &residual_stock.stock;
        Self {
            sentence: residual_stock.sentence(channel),
            tolerance_mm: TOLERANCE,
            channel_volume_mm3: stock.channel_mm3,
            left_volume_mm3: stock.left_mm3,
            left_depth_mm: stock.depth_mm,
            left_at: stock.at.map(|p| p.to_array()),
            surfaces: surfaces.collect(),
            file: None,
        }
    }
}

/// The copying motion of an electrode.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CopyingReport {
    /// What became of it, in a sentence.
    pub sentence: String,
    /// Whether its clearance is proven, so that it is a part of the program.
    pub certified: bool,
    /// Proven lower bound of its clearance (mm).
    pub certified_clearance_mm: Option<f64>,
    /// Turn of A to the low and to the high wall that would undo the reductions (deg).
    pub wanted_turns_deg: [f64; 2],
    /// Turn that is reached (deg).
    pub reached_turns_deg: [f64; 2],
    /// Move outwards that would undo the radial reduction (mm).
    pub wanted_outwards_mm: f64,
    /// Move that is reached (mm).
    pub reached_outwards_mm: f64,
    /// Rows of the motion.
    pub rows: usize,
}

impl From<&Copying> for CopyingReport {
    fn from(copying: &Copying) -> Self {
        let sentence = copying.sentence();
        let Copying::Made(motion) = copying else { return Self { sentence, ..Self::default() } };
        let turns = |e: &CopyingExtent| [e.low, e.high].map(f64::to_degrees);
        Self {
            sentence,
            certified: motion.holds(),
            certified_clearance_mm: Some(motion.certificate.certified()),
            wanted_turns_deg: turns(&motion.wanted),
            reached_turns_deg: turns(&motion.reached),
            wanted_outwards_mm: motion.wanted.outwards,
            reached_outwards_mm: motion.reached.outwards,
            rows: motion.path.rows.len(),
        }
    }
}

/// The map as a binary PLY file: vertices with `x`, `y`, `z` (mm) and `deviation` (mm), the thickness of the stock left
/// and negative where it is cut too deep. `mesh` is the map's own, in the coordinates that the file shall have.
pub fn map_as_ply(map: &DeviationMap, mesh: &Mesh) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment sparkpath: stock left, mm\nelement vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\nproperty float deviation\n\
         element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let deviation = map.deviation.iter().copied().chain(std::iter::repeat(f32::NAN));
    for (p, deviation) in mesh.vertices.iter().zip(deviation) {
        let DVec3 { x, y, z } = *p;
        [x as f32, y as f32, z as f32, deviation].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|v| bytes.extend((*v as i32).to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn a_map_has_every_vertex_with_its_value_and_every_triangle() {
        let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
        let deviation: Vec<f32> = (0..8).map(|i| i as f32 * 0.01).collect();
        let map = DeviationMap { mesh: Arc::new(mesh.clone()), surfaces: Vec::new(), deviation: Arc::new(deviation) };
        let bytes = map_as_ply(&map, &mesh);
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        assert!(String::from_utf8_lossy(&bytes[..start]).contains("element vertex 8\n"));
        assert_eq!(bytes.len() - start, 8 * 16 + 12 * 13);
        let float = |i: usize| f32::from_le_bytes(bytes[start + 4 * i..start + 4 * i + 4].try_into().unwrap());
        assert_eq!([float(28), float(29), float(30), float(31)], [2.0, 3.0, 4.0, 0.07]);
        assert_eq!(bytes[start + 128], 3);
    }
}
