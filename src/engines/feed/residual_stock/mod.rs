//! Residual stock that the electrodes leave in their channel, and where they cut too deep (our own method).
//!
//! Material within the spark gap of a moving electrode is eroded. So at every point of the finished surface of the
//! channel the deviation is the least distance to any electrode, over its whole copying motion and feed, less the spark
//! gap: positive where stock of that thickness is left, negative where the cut is too deep. Rays across the channel
//! from wall to wall give the volume left between the walls, such as at the junction of two parts.
//!
//! **Accuracy:** motions are taken as continuous, the least distance to within 2 um, or a hundredth of the stock left, and the error of a distance
//! field (5 um near the surface); where it comes within 10 um of what the certificates prove it is not searched any further.
//! Stock thicker than some 3 mm is told as that much or more. A figure of the surface is that of points some 0.4 mm
//! apart, and 0.05 mm where two electrodes only just meet; one of the volume that of rays 0.3 mm apart along the passage, and
//! from 0.05 mm apart at hub and shroud to 0.4 mm apart between, in a large channel a 150th of its length and a 40th of its
//! height.
//!
//! **What counts as the channel:** between the walls, hub and shroud, over the span of the blades along the
//! passage. Beside it the
//! rings are taken to be turned before. What is left between the shank and a ring is therefore not counted.

mod blank;
mod cutter;
mod removed;
mod surface;
mod volume;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

use super::pose::Pose;
pub use blank::Blank;
use blank::Stocked;
use burning::choice::Piece;
use cutter::{Cutter, CutterError, REACH};
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMeshError;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};
use wheel::channel::{Channel, Surface};
use wheel::electrode::{Electrode, Junctions};
use wheel::passage::Passage;
use wheel::surface_finder::SurfaceFinder;

/// Deviations up to this are good (mm): the form accuracy that P1 measures.
pub const TOLERANCE: f64 = 0.03;

/// An electrode with all that it does.
pub struct Burn<'a> {
    /// The electrode.
    pub electrode: &'a Electrode,
    /// Spark gap that it burns in (mm).
    pub spark_gap: f64,
    /// Poses of its feed towards the final pose, which is the last of them; empty to leave it out.
    pub feed: Vec<Pose>,
    /// Poses of its copying motion; empty if there is none.
    pub copying: Vec<Pose>,
}

/// Where the electrodes burn.
pub struct Site<'a> {
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    /// The channel.
    pub channel: &'a Channel,
    /// The surfaces of the channel.
    pub finder: &'a SurfaceFinder,
    /// Spark gap of the last burns, which make the surface (mm).
    pub spark_gap: f64,
    /// Where electrodes meet: the surface is looked at more closely there.
    pub junctions: Junctions,
    /// Distance to the finished surface that all the motions are proven to keep, each less the spark gap that it burns in (mm);
    /// none if nothing is proven.
    pub proven: Option<f64>,
    /// The wheel before it is burned.
    pub blank: Blank<'a>,
}

/// A layer of stock left, or of metal cut too deep, on one surface: all that exceeds the tolerance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Layer {
    /// Area (mm^2).
    pub area_mm2: f64,
    /// Volume (mm^3).
    pub volume_mm3: f64,
    /// Greatest thickness (mm).
    pub depth_mm: f64,
    /// Where that is, in W (mm).
    pub at: Option<DVec3>,
    /// Whether it is thicker than can be told: further away from all electrodes than their distances are known.
    pub or_more: bool,
}

/// Result for one surface of the channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SurfaceFigures {
    /// The surface.
    pub surface: Surface,
    /// Area of the surface (mm^2).
    pub area_mm2: f64,
    /// Stock left on it.
    pub left: Layer,
    /// Layer that is cut too deep.
    pub overcut: Layer,
}

/// Volume left within the channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stock {
    /// Volume of the channel (mm^3).
    pub channel_mm3: f64,
    /// Volume that no electrode erodes (mm^3).
    pub left_mm3: f64,
    /// How deep in the stock a point is at most, from what is eroded (mm).
    pub depth_mm: f64,
    /// Where, in W (mm).
    pub at: Option<DVec3>,
}

/// The finished surface of the channel with the deviation of every vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviationMap {
    /// The surface, in W.
    pub mesh: Arc<Mesh>,
    /// Surface of the channel that each triangle belongs to.
    pub surfaces: Vec<Surface>,
    /// Thickness of the stock left on each vertex, negative where it is cut too deep (mm).
    pub deviation: Arc<Vec<f32>>,
}

/// Residual stock that the electrodes of a channel leave.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualStock {
    /// The map.
    pub map: DeviationMap,
    /// Figures of each surface.
    pub surfaces: Vec<SurfaceFigures>,
    /// Figures of the volume.
    pub stock: Stock,
    /// Volume that each of the burns removes of the channel, and its frontal area, along its motion. An electrode removes
    /// what those before it have left; without a feed and a copying motion it has no pieces.
    pub removed: Vec<Vec<Piece>>,
}

impl ResidualStock {
    /// The surface with the thickest stock left above the tolerance, and that layer.
    pub fn thickest(&self) -> Option<(Surface, Layer)> {
        worst(self.surfaces.iter().map(|s| (s.surface, s.left)))
    }

    /// The surface with the deepest overcut beyond the tolerance, and that layer.
    pub fn deepest(&self) -> Option<(Surface, Layer)> {
        worst(self.surfaces.iter().map(|s| (s.surface, s.overcut)))
    }

    /// The answer in a sentence.
    pub fn sentence(&self, channel: &Channel) -> String {
        let layer = |found: Option<(Surface, Layer)>| {
            found.map(|(surface, layer)| {
                let more = if layer.or_more { " or more" } else { "" };
                format!("{:.3} mm{more} on the {}", layer.depth_mm, channel.surface_name(surface))
            })
        };
        let left =
            layer(self.thickest()).map_or("no residual stock".to_owned(), |l| format!("residual stock up to {l}"));
        let cut = layer(self.deepest()).map_or("no overcut".to_owned(), |l| format!("overcut up to {l}"));
        format!(
            "Beyond {TOLERANCE:.2} mm {left}, and {cut}; {:.1} of {:.1} mm\u{b3} remain in the channel.",
            self.stock.left_mm3, self.stock.channel_mm3
        )
    }
}

fn worst(layers: impl Iterator<Item = (Surface, Layer)>) -> Option<(Surface, Layer)> {
    layers.filter(|(_, l)| l.at.is_some()).max_by(|a, b| a.1.depth_mm.total_cmp(&b.1.depth_mm))
}

/// Reason why it cannot be told.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ResidualStockError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// An electrode cannot be searched.
    #[error("{0}")]
    Cutter(CutterError),
    /// The blisk's mesh cannot be searched.
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
    /// The walls of the channel have too few points.
    #[error("the walls of the channel have fewer than 2 x 2 points")]
    NoWalls,
    /// No triangle of the blisk lies on the surfaces of the channel.
    #[error("no triangle of the blisk lies on the surfaces of the channel; look at the channel step")]
    NoSurface,
}

impl From<CutterError> for ResidualStockError {
    fn from(error: CutterError) -> Self {
        use geometry::distance_field::FieldError;
        match error {
            CutterError::Field(FieldError::Cancelled(cancelled)) => cancelled.into(),
            other => Self::Cutter(other),
        }
    }
}

/// Residual stock of the channel after `burns`. Takes some seconds.
///
/// # Errors
/// If an electrode or the channel cannot be searched, or when cancelled.
pub fn residual_stock(site: &Site, burns: &[Burn], task: &Task) -> Result<ResidualStock, ResidualStockError> {
    let task = task.as_stage("residual stock");
    let mut cutters = Vec::with_capacity(burns.len());
    let gaps: Vec<f64> = burns.iter().map(|burn| burn.spark_gap).collect();
    let [from, to] = site.channel.span_x();
    let span = [from - 1.0, to + 1.0];
    for burn in burns {
        let motions = vec![[&[Pose::FINAL], &burn.copying[..]].concat(), burn.feed.clone()];
        let electrode = burn.electrode;
        cutters.push(Cutter::new(&electrode.mesh, electrode.reference_point, span, motions, &task)?);
    }
    let removal = Removal { cutters, gaps, blank: Stocked::new(site.blank, site.blisk)? };
    let passage = Passage::new(site.channel).ok_or(ResidualStockError::NoWalls)?;
    let patch = surface::patch(site, &passage, &task.cancel)?;
    let deviation = surface::deviations(&patch, &removal, least_deviation(site), &task)?;
    let surfaces = surface::figures(&patch, &deviation, removal.most());
    let stock = volume::stock(&passage, &removal, &task)?;
    let removed = removed::removed(&passage, &removal, burns, &task)?;
    let deviation = Arc::new(deviation.into_iter().map(|d| d as f32).collect());
    let map = DeviationMap { mesh: Arc::new(patch.mesh), surfaces: patch.surfaces, deviation };
    Ok(ResidualStock { map, surfaces, stock, removed })
}

/// A deviation that no motion can make much less (mm): what is proven, and twice the error of the field.
fn least_deviation(site: &Site) -> f64 {
    site.proven.map_or(f64::NEG_INFINITY, |proven| proven + 2.0 * DistanceField::ACCURACY)
}

/// All electrodes together.
struct Removal {
    cutters: Vec<Cutter>,
    /// Spark gaps of the cutters (mm).
    gaps: Vec<f64>,
    blank: Stocked,
}

impl Removal {
    /// The greatest deviation that can be told (mm).
    fn most(&self) -> f64 {
        REACH - self.gaps.iter().copied().fold(0.0, f64::max)
    }

    /// Thickness of the stock left at `p` (mm), negative where `p` is eroded; at most [`most`](Self::most). Once it is
    /// known to be `enough` or less the rest is not looked at.
    fn deviation(&self, p: DVec3, enough: f64) -> f64 {
        let cutters = || self.cutters.iter().zip(&self.gaps);
        let in_final_pose = cutters().filter_map(|(c, gap)| Some(c.in_final_pose(p)? - gap));
        let mut least = in_final_pose.fold(self.most(), f64::min);
        // What costs least comes first: few points need all of it.
        for (cutter, gap) in cutters() {
            if least > enough {
                least = cutter.at_rows(p, least + gap) - gap;
            }
        }
        for (cutter, gap) in cutters() {
            if least > enough {
                least = cutter.least(p, least + gap, enough + gap) - gap;
            }
        }
        least
    }
}
