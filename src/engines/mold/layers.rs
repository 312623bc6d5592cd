//! Heights of the layers of a mold.
//!
//! Layers lie just above every horizontal face and just below the next one up, so that both ends of what is between
//! are seen; just above every place that is lower than all around it, in steps that grow, since a flat cutter of radius
//! R leaves only a disc of height R^2 / (2 rho) there if the floor has a radius rho; and so far apart that none is
//! further from the next than asked for. Then a slab is halved while its middle is not what its ends predict.

use files::Invalid;
use serde::{Deserialize, Serialize};

use geometry::mesh::{Mesh, unit_normal};

/// Horizontal up to this tilt (1 less cosine) and this rise from corner to corner (mm).
const LEVEL: (f64, f64) = (1e-6, 2e-5);
/// Heights nearer to each other than this are one (mm): what single precision makes of a height.
const SAME_HEIGHT: f64 = 2e-5;
/// How far below a horizontal face the layer under it lies (mm).
const BELOW: f64 = 1e-6;

/// Share of the spacing up to which a slab is halved for the number and the places of pieces alone.
pub(super) const COUNTED: f64 = 0.25;

/// Share of what is left in a layer up to which it is as predicted, however much is left.
const PREDICTED: f64 = 1e-3;

/// Share of all that is left by which the middle of a slab may miss what its ends predict. The trapezoids over both
/// halves then miss a sixth of it at most, so that the errors of all slabs are far below 1 %.
const SHARE: f64 = 5e-4;

/// How finely a mold is cut into layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayerSettings {
    /// Greatest distance between layers before any slab is halved (mm).
    pub spacing_mm: f64,
    /// Only these: layers this far apart, beside those at horizontal faces and in hollows.
    pub is_fixed: bool,
    /// No slab thinner than this is halved (mm).
    pub least_spacing_mm: f64,
    /// Least volume by which the middle of a slab may miss what its ends predict (mm^3).
    pub volume_tolerance_mm3: f64,
    /// Least area of untouched wall by which it may (mm^2).
    pub wall_tolerance_mm2: f64,
    /// Depth up to which what is left counts as cut (mm).
    pub depth_tolerance_mm: f64,
    /// Most layers.
    pub most_layers: usize,
}

impl Default for LayerSettings {
    fn default() -> Self {
        Self {
            spacing_mm: 0.5,
            is_fixed: false,
            least_spacing_mm: 0.0005,
            volume_tolerance_mm3: 0.005,
            wall_tolerance_mm2: 0.05,
            depth_tolerance_mm: 0.002,
            most_layers: 4000,
        }
    }
}

impl LayerSettings {
    /// Whether every setting is possible.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), Invalid> {
        [
            ("spacing_mm", self.spacing_mm, [1e-3, 1e3], "mm"),
            ("least_spacing_mm", self.least_spacing_mm, [1e-4, self.spacing_mm], "mm"),
            ("volume_tolerance_mm3", self.volume_tolerance_mm3, [1e-9, 1e9], "mm3"),
            ("wall_tolerance_mm2", self.wall_tolerance_mm2, [1e-9, 1e9], "mm2"),
            ("depth_tolerance_mm", self.depth_tolerance_mm, [0.0, 10.0], "mm"),
            ("most_layers", self.most_layers as f64, [2.0, 1e5], ""),
        ]
        .into_iter()
        .try_for_each(|(key, value, range, unit)| Invalid::unless_within(key, value, range, unit))
    }
}

/// The layers to begin with, and what they were made from.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstLayers {
    /// Heights (mm), rising.
    pub heights: Vec<f64>,
    /// Heights of horizontal faces (mm), rising: no slab between layers reaches over one.
    pub floors: Vec<f64>,
}

/// The first layers of `mesh`, also at horizontal faces less each of `reaches` (mm): there the holder's obstacles
/// change.
pub fn first_layers(mesh: &Mesh, reaches: &[f64], settings: &LayerSettings) -> FirstLayers {
    let bounds = mesh.bounds();
    let (bottom, top) = (bounds.min.z, bounds.max.z);
    if mesh.triangles.is_empty() || !(bottom.is_finite() && top.is_finite()) {
        return FirstLayers { heights: Vec::new(), floors: Vec::new() };
    }
    let faces = horizontal(mesh);
    let lowered = reaches.iter().flat_map(|reach| faces.iter().map(move |f| f.map(|z| z - reach)));
    let mut floors: Vec<[f64; 2]> = faces.iter().copied().chain(lowered).chain([[bottom; 2], [top; 2]]).collect();
    floors.retain(|[low, high]| *low >= bottom && *high <= top);
    let floors = joined(floors);
    let mut heights = Vec::new();
    for pair in floors.windows(2) {
        let [from, to] = [pair[0][1], pair[1][0] - BELOW];
        if to <= from {
            heights.push(from);
            continue;
        }
        let steps = ((to - from) / settings.spacing_mm).ceil().max(2.0) as usize;
        let steps = steps.min(settings.most_layers);
        heights.extend((0..=steps).map(|k| from + (to - from) * k as f64 / steps as f64));
    }
    // A hollow at a floor begins above all of the floor's rounding.
    let at_floor = |z: f64| floors.iter().find(|[low, high]| low - SAME_HEIGHT <= z && z <= high + SAME_HEIGHT);
    let hollows = hollows(mesh);
    let room = settings.most_layers.saturating_sub(heights.len()).max(1);
    // Of more than there may be layers some are left out, evenly.
    for hollow in hollows.iter().step_by(hollows.len().div_ceil(room).max(1)) {
        let hollow = at_floor(*hollow).map_or(*hollow, |floor| floor[1]);
        add_steps(&mut heights, hollow, &floors, settings);
    }
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    FirstLayers { heights, floors: floors.iter().map(|f| f[1]).collect() }
}

/// Adds layers above a hollow at distances that double, where there is none about there yet.
fn add_steps(heights: &mut Vec<f64>, hollow: f64, floors: &[[f64; 2]], settings: &LayerSettings) {
    let next = floors.iter().map(|f| f[0]).find(|z| *z > hollow + SAME_HEIGHT).unwrap_or(hollow) - BELOW;
    let mut step = settings.least_spacing_mm.min(0.002);
    heights.push(hollow);
    while step < settings.spacing_mm && hollow + step < next && heights.len() < settings.most_layers {
        let at = hollow + step;
        if !heights.iter().any(|z| *z > hollow && (z - at).abs() < 0.4 * step) {
            heights.push(at);
        }
        step *= 2.0;
    }
}

/// Heights of horizontal faces as least and greatest, rising.
fn horizontal(mesh: &Mesh) -> Vec<[f64; 2]> {
    let rise = |corners: [glam::DVec3; 3]| {
        let [a, b, c] = corners.map(|p| p.z);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let is_level = high - low <= LEVEL.1 && unit_normal(corners).z.abs() >= 1.0 - LEVEL.0;
        is_level.then_some([low, high])
    };
    joined(mesh.iter_corners().filter_map(rise).collect())
}

fn joined(mut spans: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for span in spans {
        match joined.last_mut() {
            // A chain of steps does not become one height.
            Some(last) if span[0] - last[1] <= SAME_HEIGHT && span[1] - last[0] <= 4.0 * SAME_HEIGHT => {
                last[1] = last[1].max(span[1]);
            }
            _ => joined.push(span),
        }
    }
    joined
}

/// Heights of vertices that have none lower beside them, above the bottom and in a surface that looks upwards, in
/// order.
fn hollows(mesh: &Mesh) -> Vec<f64> {
    let bottom = mesh.bounds().min.z;
    let mut is_lowest = vec![true; mesh.vertices.len()];
    let mut looks_up = vec![false; mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().zip(mesh.iter_corners()) {
        let low = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let normal = unit_normal(corners).z;
        for (&v, p) in triangle.iter().zip(corners) {
            is_lowest[v as usize] &= p.z <= low + LEVEL.1;
            // A flat floor is a layer of its own.
            looks_up[v as usize] |= normal > 0.1 && normal < 1.0 - LEVEL.0;
        }
    }
    let is_hollow = |i: &usize| is_lowest[*i] && looks_up[*i] && mesh.vertices[*i].z > bottom + SAME_HEIGHT;
    let heights = (0..mesh.vertices.len()).filter(is_hollow).map(|i| [mesh.vertices[i].z; 2]);
    joined(heights.collect()).into_iter().map(|span| span[1]).collect()
}

/// Figures of the residual stock in a layer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LayerFigures {
    /// The height (mm).
    pub z: f64,
    /// Pieces.
    pub count: usize,
    /// Area (mm^2).
    pub area: f64,
    /// Length of untouched outline (mm).
    pub length: f64,
}

/// By how much the middle of a slab may miss what its ends predict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Volume (mm^3).
    pub volume: f64,
    /// Area of untouched wall (mm^2).
    pub wall: f64,
    /// Thickness of a slab up to which the number of its pieces counts (mm).
    pub counted: f64,
}

impl Tolerance {
    /// The tolerance for rising layers: as set, and no less than a share of all that they have.
    pub fn of(layers: &[LayerFigures], settings: &LayerSettings) -> Self {
        let sum = |of: fn(&LayerFigures) -> f64| -> f64 {
            layers.windows(2).map(|pair| 0.5 * (of(&pair[0]) + of(&pair[1])) * (pair[1].z - pair[0].z)).sum()
        };
        Self {
            volume: settings.volume_tolerance_mm3.max(SHARE * sum(|f| f.area)),
            wall: settings.wall_tolerance_mm2.max(SHARE * sum(|f| f.length)),
            counted: COUNTED * settings.spacing_mm,
        }
    }
}

/// Whether the slabs beside a layer need layers in their own middles: it is not what the layers beside it predict.
pub fn is_bent([low, middle, high]: [LayerFigures; 3], tolerance: &Tolerance) -> bool {
    let share = (middle.z - low.z) / (high.z - low.z);
    let off = |of: fn(&LayerFigures) -> f64| {
        let off = (of(&middle) - (of(&low) + (of(&high) - of(&low)) * share)).abs();
        if off > PREDICTED * of(&low).max(of(&high)) { off } else { 0.0 }
    };
    let thickness = high.z - low.z;
    let counts = low.count.min(high.count)..=low.count.max(high.count);
    off(|f| f.area) * thickness > tolerance.volume
        || off(|f| f.length) * thickness > tolerance.wall
        || (!counts.contains(&middle.count) && thickness > tolerance.counted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A box with a pit in the shape of a pyramid whose tip lies at half its height.
    fn pit() -> Mesh {
        let mut mesh = Mesh::cuboid(DVec3::new(10.0, 10.0, 4.0));
        let top: Vec<usize> =
            (0..mesh.triangles.len()).filter(|&i| mesh.corners(i).iter().all(|p| p.z == 4.0)).collect();
        let tip = mesh.vertices.len() as u32;
        mesh.vertices.push(DVec3::new(5.0, 5.0, 2.0));
        mesh.triangles.retain({
            let mut i = 0;
            move |_| {
                i += 1;
                !top.contains(&(i - 1))
            }
        });
        mesh.triangles.extend([[4, 5], [5, 7], [7, 6], [6, 4]].map(|[a, b]| [a, b, tip]));
        mesh
    }

    #[test]
    fn layers_lie_above_floors_below_tops_and_close_above_hollows() {
        let settings = LayerSettings::default();
        let mesh = pit();
        assert!(mesh.is_watertight());
        let FirstLayers { heights, floors } = first_layers(&mesh, &[], &settings);
        assert_eq!(floors, [0.0, 4.0]);
        assert!(heights.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] < 0.5 + 1e-9), "{heights:?}");
        assert!(heights[0] == 0.0 && heights.last().unwrap() + BELOW == 4.0);
        let above = heights.iter().filter(|z| **z > 2.0 && **z < 2.1).count();
        assert!(above >= 4, "{heights:?}");
        // A holder 1.5 mm above the tip meets the top where the tip is 1.5 mm below it.
        let block = Mesh::cuboid(DVec3::new(10.0, 10.0, 4.0));
        assert_eq!(first_layers(&block, &[1.5, 9.0], &settings).floors, [0.0, 2.5, 4.0]);
        assert!(first_layers(&Mesh::default(), &[], &settings).heights.is_empty());
    }

    #[test]
    fn a_layer_that_its_neighbours_predict_is_not_bent() {
        let settings = LayerSettings::default();
        let at = |z: f64, count: usize, area: f64| LayerFigures { z, count, area, length: 1.0 };
        let tolerance = Tolerance::of(&[at(0.0, 2, 1.0), at(0.4, 2, 5.0)], &settings);
        assert!((tolerance.volume, tolerance.wall) == (0.005, 0.05), "{tolerance:?}");
        assert!(!is_bent([at(0.0, 2, 1.0), at(0.1, 2, 2.0), at(0.4, 2, 5.0)], &tolerance));
        assert!(is_bent([at(0.0, 2, 1.0), at(0.1, 2, 2.1), at(0.4, 2, 5.0)], &tolerance));
        assert!(is_bent([at(0.0, 2, 1.0), at(0.2, 3, 1.0), at(0.4, 2, 1.0)], &tolerance));
        assert!(!is_bent([at(0.0, 2, 1.0), at(0.2, 3, 1.0), at(0.4, 3, 1.0)], &tolerance));
        // Of 1200 mm^3 in 12 mm no slab has to be known to a hundredth of a cubic millimetre.
        let much = Tolerance::of(&[at(0.0, 2, 100.0), at(4.0, 2, 100.0), at(12.0, 2, 100.0)], &settings);
        assert!((much.volume - 0.6).abs() < 1e-12 && much.wall == 0.05, "{much:?}");
    }

    #[test]
    fn impossible_settings_are_refused() {
        assert_eq!(LayerSettings::default().validate(), Ok(()));
        for (spacing_mm, least_spacing_mm) in [(f64::NAN, 0.001), (0.0, 0.001), (0.5, 0.6), (0.5, -1.0)] {
            let settings = LayerSettings { spacing_mm, least_spacing_mm, ..LayerSettings::default() };
            assert!(settings.validate().is_err());
        }
    }
}
