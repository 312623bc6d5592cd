//! What the cutters of a library leave of a mold.
//!
//! Flat cutters are followed exactly, layer by layer. Where a library has rounded cutters too, what all of them leave is
//! told by the field of heights. What flat cutters leave is always found both ways, and how far the two agree is told.

use glam::DVec3;
use serde::Serialize;

use crate::geometry::mesh::Mesh;
use crate::mold::ball_agreement::{BallAgreement, ball_agreement};
use crate::mold::cutter::{Cutter, CutterError, CutterKind, CutterLibrary};
use crate::mold::height_field::{self, Closing, Covered, FieldRegion, HeightField, HeightFieldError};
use crate::mold::layers::{LayerSettings, LayerSettingsError};
use crate::mold::opening::Opening;
use crate::mold::piece::UncutPiece;
use crate::mold::region::{LayerRegion, regions};
use crate::mold::stack::{UncutStack, uncut_stack};
use crate::mold::surface::{SurfacePiece, segments_at, uncut_surface};
use crate::mold::uncut_region::{Regions, UncutRegion};
use crate::mold::warning::MoldWarning;
use crate::progress::{Cancel, Cancelled, Progress};

/// Cells of the field of heights that a smallest radius is divided into, where memory allows.
const CELLS_PER_RADIUS: f64 = 40.0;
/// Step of the field of heights beyond which it is too coarse, as a share of a smallest radius.
const COARSEST: f64 = 0.1;
/// How far heights of the grid may be off: single precision, and a rounded cutter that sags between two places (mm).
const ROUNDING: f64 = 3e-4;
/// Tolerances that the field's step is wide, and steps across a mold, at most, that are made for that.
const STEPS: (f64, f64) = (2.0, 2500.0);
/// Cells of a smallest diameter at most: time grows with them, for rounded cutters with their square.
const MOST_ACROSS: [f64; 2] = [400.0, 160.0];
/// Cells that a region is thick from which on the field of heights cannot miss it.
const THIN: f64 = 3.0;
/// Cells of the field of heights, at most, unless its step is given: some 20 bytes each.
const MOST_CELLS: f64 = 36e6;

/// What is asked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncutParams {
    /// The cutters.
    pub library: CutterLibrary,
    /// From where they come.
    pub opening: Opening,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// Step of the field of heights (mm); none for as fine as it has to be and can be.
    pub grid_step_mm: Option<f64>,
    /// How finely the mold is cut into layers.
    pub layers: LayerSettings,
}

impl UncutParams {
    /// The usual parameters for a library.
    pub fn of(library: CutterLibrary) -> Self {
        let (opening, layers) = (Opening::default(), LayerSettings::default());
        Self { library, opening, tolerance_mm: 0.02, grid_step_mm: None, layers }
    }

    /// Whether they can be asked.
    ///
    /// # Errors
    /// [`UncutError::Cutters`], [`UncutError::Layers`], [`UncutError::Tolerance`], [`UncutError::CoarseStep`],
    /// [`UncutError::Field`].
    pub fn validate(&self) -> Result<(), UncutError> {
        self.library.validate()?;
        self.layers.validate()?;
        if !(1e-4..=10.0).contains(&self.tolerance_mm) {
            return Err(UncutError::Tolerance(self.tolerance_mm));
        }
        if let Some(step) = self.grid_step_mm.filter(|step| !(step.is_finite() && *step > 0.0)) {
            return Err(UncutError::Field(HeightFieldError::BadStep(step)));
        }
        let radius = self.library.needed().iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
        match self.grid_step_mm.filter(|step| *step > 0.5 * radius) {
            Some(step) => Err(UncutError::CoarseStep { step, radius }),
            None => Ok(()),
        }
    }
}

/// Why a mold has no answer.
#[derive(Debug, thiserror::Error)]
pub enum UncutError {
    /// The library is not one.
    #[error("cutters: {0}")]
    Cutters(#[from] CutterError),
    /// The settings are not possible.
    #[error("layers: {0}")]
    Layers(#[from] LayerSettingsError),
    /// The tolerance is not possible.
    #[error("tolerance_mm is {0}: it must be finite and from 0.0001 to 10 mm")]
    Tolerance(f64),
    /// A step of the field of heights that shows nothing.
    #[error("the field of heights: a step of {step} mm is too coarse for a cutter of radius {radius} mm; give at most {} mm", 0.5 * radius)]
    CoarseStep {
        /// The step (mm).
        step: f64,
        /// The smallest radius (mm).
        radius: f64,
    },
    /// The field of heights cannot be had.
    #[error("field of heights: {0}")]
    Field(HeightFieldError),
    /// It was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<HeightFieldError> for UncutError {
    fn from(error: HeightFieldError) -> Self {
        match error {
            HeightFieldError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            HeightFieldError::Cutter(cutter) => Self::Cutters(cutter),
            other => Self::Field(other),
        }
    }
}

/// How many regions, and their volume (mm^3), by one way of finding them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct Found {
    pub regions: usize,
    pub volume_mm3: f64,
}

/// What is left in one layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerFound {
    /// Its height (mm).
    pub z: f64,
    /// Area of what is left (mm^2).
    pub area: f64,
    /// Length of the mold's outline that no cutter touches (mm).
    pub segment_length: f64,
}

/// What is left of a mold. Everything stands upright: the opening looks along +Z.
#[derive(Debug, Clone)]
pub struct Uncut {
    /// What was asked.
    pub params: UncutParams,
    /// What the flat cutters leave, layer by layer, with the invert faces.
    pub stack: UncutStack,
    /// What all cutters leave in the same layers.
    pub layers: Vec<LayerFound>,
    /// The regions that all cutters leave, the largest first.
    pub regions: Vec<UncutRegion>,
    /// The parts of the surface that bound them.
    pub surface: Vec<SurfacePiece>,
    /// Step of the field of heights (mm).
    pub grid_step: f64,
    /// What flat cutters leave by layers and by the field of heights; none without flat cutters.
    pub agreement: Option<[Found; 2]>,
    /// How far the field of heights and the exact search agree on what balls leave; none where they count nowhere, and
    /// where faces look down.
    pub ball_agreement: Option<BallAgreement>,
}

impl Uncut {
    /// Whether only flat cutters count, so that the layers are the answer.
    pub fn is_of_flats(&self) -> bool {
        self.params.library.needed().iter().all(|c| c.kind() == CutterKind::Flat)
    }

    /// Regions and volume of what the whole library leaves.
    pub fn found(&self) -> Found {
        found(self.regions.iter().map(|r| r.volume))
    }

    /// The segments of the layer nearest to a height that no cutter touches, as runs of points (mm): exact where only flat
    /// cutters count, else at that very height as fine as the surface is split.
    pub fn segments(&self, z: f64) -> Vec<Vec<DVec3>> {
        if !self.is_of_flats() {
            return segments_at(&self.surface, z).into_iter().map(|(_, ends)| ends.to_vec()).collect();
        }
        let layers = &self.stack.layers;
        let off = |k: &usize| (layers[*k].z - z).abs();
        let nearest = (0..layers.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let of_layer = |k: usize| {
            let runs = self.pieces(k).flat_map(|piece| &piece.segments);
            runs.map(|run| run.iter().map(|p| p.extend(layers[k].z)).collect()).collect()
        };
        nearest.map_or_else(Vec::new, of_layer)
    }

    /// The pieces of a layer, by its place in the stack, that belong to regions; none where regions are those of the field
    /// of heights.
    pub fn pieces(&self, layer: usize) -> impl Iterator<Item = &UncutPiece> {
        let own = self.regions.iter().flat_map(|r| &r.pieces).filter(move |[k, _]| *k == layer);
        own.map(move |[_, i]| &self.stack.layers[layer].pieces[*i])
    }

    /// Whether mesh and grid are such that the answer holds for all of the mold.
    pub fn is_whole(&self) -> bool {
        let breaks = |w: &MoldWarning| {
            use MoldWarning::{Crossing, Empty, NotClosed, Open};
            let is_answered_by_grid = || !self.is_of_flats();
            matches!(w, Empty | NotClosed { .. } | Open { .. } | Crossing { .. })
                || matches!(w, MoldWarning::CoarseGrid { .. }) && is_answered_by_grid()
        };
        !self.stack.warnings.iter().any(breaks)
    }
}

fn found(volumes: impl ExactSizeIterator<Item = f64>) -> Found {
    Found { regions: volumes.len(), volume_mm3: volumes.fold(0.0, |sum, v| sum + v) }
}

/// What the cutters of `params` leave of `mesh`.
///
/// # Errors
/// [`UncutError`].
pub fn uncut(mesh: &Mesh, params: &UncutParams, progress: &Progress, cancel: &Cancel) -> Result<Uncut, UncutError> {
    params.validate()?;
    if mesh.triangles.is_empty() {
        return Err(UncutError::Field(HeightFieldError::NoMaterial));
    }
    let upright = params.opening.upright_mesh(mesh);
    let needed = params.library.needed();
    let flats: Vec<&Cutter> = needed.iter().copied().filter(|c| c.kind() == CutterKind::Flat).collect();
    let grid_step = params.grid_step_mm.unwrap_or_else(|| usual_step(&upright, &needed, params.tolerance_mm));
    progress.report("field of heights", 0.0, "");
    let field = HeightField::raster(&upright, grid_step, cancel)?;
    let mut stack = uncut_stack(&upright, &flats, None, &params.layers, progress, cancel)?;
    // Where a whole wall is missing every section closes all the same.
    let edges = open_edges(mesh);
    if edges > 0 {
        stack.warnings.insert(0, MoldWarning::NotClosed { edges });
    }
    let flat_regions = regions(&stack.layers, params.tolerance_mm);
    let least_radius = needed.iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    if grid_step > 1.001 * COARSEST * least_radius {
        stack.warnings.push(MoldWarning::CoarseGrid { step: grid_step, radius: least_radius });
    }
    progress.report("field of heights", 0.2, "");
    let of = |library: &CutterLibrary| -> Result<(Closing, Vec<FieldRegion>), UncutError> {
        let closing = height_field::closing(&field, library, cancel)?;
        let regions = height_field::regions(&field, &closing, params.tolerance_mm, cancel)?;
        Ok((closing, regions))
    };
    let (closing, of_field) = of(&params.library)?;
    progress.report("field of heights", 0.6, "");
    let is_of_flats = flats.len() == needed.len();
    let agreement = if flats.is_empty() {
        None
    } else {
        let volumes = |regions: &[FieldRegion]| found(regions.iter().map(|r| r.volume));
        let only_flats = || CutterLibrary { cutter: flats.iter().copied().cloned().collect() };
        let with_flats = if is_of_flats { volumes(&of_field) } else { volumes(&of(&only_flats())?.1) };
        Some([found(flat_regions.iter().map(|r| r.volume)), with_flats])
    };
    // The exact search would let a ball go sideways under what looks down, where its shaft cannot follow.
    let has_undercuts = !stack.invert.triangles.is_empty() && stack.invert.area > 0.0;
    let ball_agreement = if has_undercuts {
        None
    } else {
        ball_agreement(&upright, &params.library, (&field, &closing), &of_field, cancel)?
    };
    progress.report("surface", 0.0, "");
    let pieces = uncut_surface(&upright, &Covered::new(&field, &closing, &of_field), cancel)?;
    let all = if is_of_flats {
        Regions::of_layers(&stack.layers, &flat_regions, (&field, &closing), &of_field)
    } else {
        stack.warnings.extend(too_thin(&flat_regions, &of_field, grid_step));
        Regions::of_field(&of_field)
    };
    let (regions, surface) = all.with_surface(pieces);
    let layers = if is_of_flats {
        of_layers(&stack, &regions)
    } else {
        of_surface(&stack, (&field, &closing), &of_field, &surface)
    };
    progress.report("surface", 1.0, "");
    Ok(Uncut { params: params.clone(), stack, layers, regions, surface, grid_step, agreement, ball_agreement })
}

/// Thin regions that flat cutters leave where the grid finds nothing: it cannot tell whether rounded cutters take them.
fn too_thin(flat: &[LayerRegion], of_field: &[FieldRegion], step: f64) -> Option<MoldWarning> {
    let is_found = |r: &LayerRegion| of_field.iter().any(|f| f.bounds.grown(step).intersects(&r.bounds));
    let thin = flat.iter().filter(|r| r.residue() < THIN * step && !is_found(r));
    let (regions, thickness) = thin.fold((0, 0.0f64), |(count, most), r| (count + 1, most.max(r.residue())));
    (regions > 0).then_some(MoldWarning::ThinRegions { regions, thickness })
}

/// What the regions of flat cutters have in each layer.
fn of_layers(stack: &UncutStack, regions: &[UncutRegion]) -> Vec<LayerFound> {
    let mut layers: Vec<LayerFound> =
        stack.layers.iter().map(|l| LayerFound { z: l.z, area: 0.0, segment_length: 0.0 }).collect();
    for &[k, i] in regions.iter().flat_map(|r| &r.pieces) {
        let piece = &stack.layers[k].pieces[i];
        layers[k].area += piece.area;
        layers[k].segment_length += piece.segment_length();
    }
    layers
}

/// What all cutters leave in each layer, by cells and by the surface.
fn of_surface(
    stack: &UncutStack,
    (field, closing): (&HeightField, &Closing),
    regions: &[FieldRegion],
    surface: &[SurfacePiece],
) -> Vec<LayerFound> {
    let heights: Vec<f64> = stack.layers.iter().map(|l| l.z).collect();
    // Cells that begin and end below each layer: what is left between layers adds up to what is left in each.
    let mut change = vec![0i64; heights.len() + 1];
    for cell in regions.iter().flat_map(|r| &r.cells).map(|c| *c as usize) {
        let Some(low) = field.height(cell) else { continue };
        let high = low + closing.residue(field, cell);
        change[first_above(&heights, low)] += 1;
        change[first_above(&heights, high)] -= 1;
    }
    let counts = change.iter().scan(0i64, |sum, by| {
        *sum += by;
        Some(*sum)
    });
    let mut lengths = vec![0.0; heights.len()];
    for piece in surface {
        let own = std::slice::from_ref(piece);
        let [low, high] = piece.span();
        for k in heights.partition_point(|z| *z < low)..heights.partition_point(|z| *z <= high) {
            lengths[k] += segments_at(own, heights[k]).iter().map(|(_, [a, b])| a.distance(*b)).sum::<f64>();
        }
    }
    let area = |count: i64| count as f64 * field.step() * field.step();
    let figures = heights.iter().zip(counts).zip(lengths);
    figures.map(|((z, count), segment_length)| LayerFound { z: *z, area: area(count), segment_length }).collect()
}

/// The first of the layers that lies above a height of the grid. Layers lie closely below and on horizontal faces, and
/// heights are a little off: one near such a pair is that of the face.
fn first_above(layers: &[f64], height: f64) -> usize {
    let after = layers.partition_point(|z| *z <= height);
    let is_pair = |k: &usize| {
        let [below, above] = [layers[*k - 1], layers[*k]];
        above - below < 0.1 * ROUNDING && (below - ROUNDING..=above + ROUNDING).contains(&height)
    };
    let near = after.saturating_sub(1).max(1)..(after + 2).min(layers.len());
    near.clone().find(is_pair).unwrap_or(after)
}

/// Edges that have no face on one side, or more on one than on the other.
fn open_edges(mesh: &Mesh) -> usize {
    let directed = mesh.directed_edges();
    directed.iter().filter(|((a, b), count)| directed.get(&(*b, *a)).copied().unwrap_or(0) < **count).count()
}

/// As fine as the smallest cutter and the tolerance ask for, but with no more cells than a computer holds with ease, and such that every
/// cutter is close to a whole number of cells wide: the grid takes it for that.
fn usual_step(mesh: &Mesh, cutters: &[&Cutter], tolerance: f64) -> f64 {
    let least = cutters.iter().map(|c| c.diameter_mm).fold(f64::INFINITY, f64::min);
    let widest = cutters.iter().map(|c| c.holder().map_or(c.radius(), |(holder, _)| holder)).fold(0.0, f64::max);
    let size = mesh.bounds().size().truncate() + 2.0 * widest;
    let coarsest = (size.x * size.y / MOST_CELLS).sqrt();
    let fine = (STEPS.0 * tolerance).max(mesh.bounds().size().truncate().max_element() / STEPS.1);
    let is_rounded = cutters.iter().any(|c| c.kind() != CutterKind::Flat);
    let across = (least / fine).min(MOST_ACROSS[usize::from(is_rounded)]).max(2.0 * CELLS_PER_RADIUS);
    let most = across.min(least / coarsest).floor();
    if most < 2.0 {
        return coarsest;
    }
    // Off a whole number, in shares of a cell, at worst.
    let off = |count: f64| {
        let widths = cutters.iter().map(|c| c.diameter_mm / least * count);
        widths.map(|w| (w - w.round()).abs()).fold(0.0, f64::max)
    };
    let counts = (0..=(most / 5.0) as usize).map(|k| most - k as f64).filter(|count| *count >= 2.0);
    least / counts.fold(most, |best, count| if off(count) < off(best) - 0.02 { count } else { best })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::mesh::tests::cuboid;
    use crate::mold::test_molds::{pocket, polygon, rectangle};

    fn answer(mesh: &Mesh, cutters: Vec<Cutter>) -> Result<Uncut, UncutError> {
        let params = UncutParams::of(CutterLibrary { cutter: cutters });
        uncut(mesh, &params, &Progress::silent(), &Cancel::default())
    }

    #[test]
    fn nothing_is_left_of_a_plain_block() {
        let mesh = cuboid(DVec3::new(10.0, 8.0, 3.0));
        let left = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(1.0)]).unwrap();
        assert_eq!(left.found(), Found::default());
        assert!(left.is_whole() && !left.is_of_flats());
        assert_eq!(left.agreement, Some([Found::default(); 2]));
    }

    #[test]
    fn a_pocket_keeps_its_corners_with_the_walls_and_the_floor_beside_them() {
        let sides = rectangle(12.0, 9.0);
        let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 8.0]);
        let corner = 1.0 - std::f64::consts::FRAC_PI_4;
        let by_flat = answer(&mesh, vec![Cutter::flat(1.0)]).unwrap();
        assert!(by_flat.is_of_flats());
        let by_both = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(2.0)]).unwrap();
        for (left, share) in [(&by_flat, 1e-3), (&by_both, 0.03)] {
            assert_eq!(left.regions.len(), 4);
            for region in &left.regions {
                assert!((region.volume - 8.0 * corner).abs() < share * 8.0 * corner, "{region:?}");
                assert!((region.plan_area - corner).abs() < 0.05 * corner, "{region:?}");
                assert!((region.depth - 8.0).abs() < 0.01, "{region:?}");
                // Two walls, and the floor by one triangle or both.
                assert!((3..=6).contains(&region.faces.len()), "{region:?}");
                assert!((1.5 * 8.0..=2.0 * 8.0 + 2.0 * corner).contains(&region.surface_area), "{region:?}");
                assert!(region.nearest_cutter.is_some_and(|k| k < left.params.library.cutter.len()));
            }
            let layer = left.layers.iter().find(|l| (5.0..7.0).contains(&l.z)).unwrap();
            assert!((layer.area - 4.0 * corner).abs() < share.max(0.01) * 4.0 * corner, "{layer:?}");
            assert!((5.0..=8.001).contains(&layer.segment_length), "{layer:?}");
            let drawn: f64 =
                left.segments(layer.z).iter().flat_map(|run| run.windows(2)).map(|w| w[0].distance(w[1])).sum();
            assert!((drawn - layer.segment_length).abs() < 1e-9);
        }
        let middle = by_flat.layers.iter().find(|l| (5.0..7.0).contains(&l.z)).unwrap();
        assert!((middle.segment_length - 8.0).abs() < 1e-6, "two radii at each corner: {middle:?}");
    }

    #[test]
    fn heights_of_faces_lie_between_the_layers_below_and_above_them() {
        let layers = [0.0, 1.0 - 1e-6, 1.0 + 1e-6, 3.0];
        let at = |height: f64| first_above(&layers, height);
        assert_eq!([-1.0, 0.5, 2.0, 4.0].map(at), [0, 1, 3, 4]);
        assert_eq!([1.0 - 1e-4, 1.0 - 5e-7, 1.0, 1.0 + 1e-4].map(at), [2; 4]);
        assert_eq!(first_above(&[], 1.0), 0);
    }

    #[test]
    fn corners_too_thin_for_the_grid_are_left_all_the_same() {
        // Twelve corners of 150 degrees: R (1 / cos 15 degrees - 1) = 0.035 mm deep.
        let round = polygon(12, 8.0);
        let mesh = pocket(&polygon(12, 12.0), &round, &round, [10.0, 6.0]);
        for step in [None, Some(0.5)] {
            let params = UncutParams {
                grid_step_mm: step,
                ..UncutParams::of(CutterLibrary { cutter: vec![Cutter::flat(1.0)] })
            };
            let left = uncut(&mesh, &params, &Progress::silent(), &Cancel::default()).unwrap();
            assert_eq!(left.regions.len(), 12, "{step:?}");
            let (half, deep) = (15f64.to_radians(), 1.0 / 15f64.to_radians().cos() - 1.0);
            for region in &left.regions {
                // Where the grid sees a corner it looks up along the walls.
                assert!(region.thickness > 0.999 * deep, "{region:?}");
                assert!((region.volume - 6.0 * (half.tan() - half)).abs() < 1e-4, "{region:?}");
                assert!(region.plan_area > 0.0, "{region:?}");
            }
            let is_coarse = left.stack.warnings.iter().any(|w| matches!(w, MoldWarning::CoarseGrid { .. }));
            assert_eq!(is_coarse, step.is_some());
        }
        let both = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(2.0)]).unwrap();
        let thin = both.stack.warnings.iter().any(|w| matches!(w, MoldWarning::ThinRegions { regions: 12, .. }));
        assert!(thin || both.regions.len() == 12, "{:?}", both.stack.warnings);
    }

    #[test]
    fn what_balls_leave_is_found_twice() {
        let sides = rectangle(12.0, 9.0);
        let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 4.0]);
        let left = answer(&mesh, vec![Cutter::ball(1.0)]).unwrap();
        let agreement = left.ball_agreement.unwrap();
        assert!(agreement.places > 300, "{agreement:?}");
        // Over the fillet along the walls; a cell at the wall's foot may take the wall for half a cell off.
        assert!(agreement.median_mm < 0.2 * left.grid_step, "{agreement:?}");
        assert!(agreement.ninetieth_mm < 2.0 * left.grid_step, "{agreement:?}");
    }

    #[test]
    fn the_grid_fits_the_cutters() {
        let mesh = cuboid(DVec3::new(100.0, 80.0, 3.0));
        let step = |cutters: &[Cutter]| usual_step(&mesh, &cutters.iter().collect::<Vec<_>>(), 0.02);
        assert_eq!(step(&[Cutter::flat(1.0)]), 0.025);
        for cutters in [vec![Cutter::ball(0.5)], vec![Cutter::flat(1.3), Cutter::ball(1.0)], vec![Cutter::flat(1e-2)]] {
            let step = step(&cutters);
            assert!(8000.0 / (step * step) <= 1.1 * MOST_CELLS, "{step}");
        }
        let step = step(&[Cutter::flat(1.3), Cutter::ball(1.0)]);
        for diameter in [2.6, 2.0] {
            let cells = diameter / step;
            assert!((cells - f64::round(cells)).abs() < 0.05, "{cells} cells");
        }
    }

    #[test]
    fn what_cannot_be_asked_is_answered_in_words() {
        let mesh = cuboid(DVec3::new(10.0, 8.0, 3.0));
        let refused = |mesh: &Mesh, cutters| answer(mesh, cutters).unwrap_err().to_string();
        assert!(refused(&mesh, Vec::new()).contains("no cutter"));
        let coarse = UncutParams {
            grid_step_mm: Some(0.6),
            ..UncutParams::of(CutterLibrary { cutter: vec![Cutter::flat(1.0)] })
        };
        assert!(coarse.validate().unwrap_err().to_string().contains("give at most 0.5 mm"));
        assert!(refused(&mesh, vec![Cutter::flat(-1.0)]).contains("diameter_mm is -2 mm"));
        assert!(refused(&Mesh::default(), vec![Cutter::flat(1.0)]).contains("nothing to cut"));
    }
}
