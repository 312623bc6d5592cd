//! What the cutters of a library leave of a mold.
//!
//! Flat cutters are followed exactly, layer by layer. Where a library has rounded cutters too, what all of them leave
//! is told by the field of heights. What flat cutters leave is always found both ways, and how far the two agree is
//! told.

mod closer_look;
mod layer_figures;
mod segments;
mod step;
#[cfg(test)]
mod tests;

use files::report::counted;
use files::{Invalid, Validate};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use closer_look::thin_regions;
use geometry::mesh::Mesh;
pub use layer_figures::LayerFound;
use layer_figures::{of_layers, of_surface};
use mold::ball_agreement::{BallAgreement, ball_agreement};
use mold::cutter::{Cutter, CutterKind, CutterLibrary};
use mold::exact_fit::{lower_to_layers, raise_to_layers};
use mold::height_field;
use mold::height_field::{Closing, Covered, FieldRegion, HeightField, HeightFieldError};
use mold::invert::{InvertFaces, LEAST_INVERT};
use mold::layers::LayerSettings;
use mold::opening::Opening;
use mold::piece::UncutPiece;
use mold::region::{LayerRegion, regions};
use mold::stack::{UncutLayer, UncutStack, uncut_stack};
use mold::surface::{SurfacePiece, segments_at, uncut_surface};
use mold::uncut_region::{Regions, UncutRegion};
use mold::unseen::{Unseen, undercuts};
use mold::warning::MoldWarning;
pub use segments::{ClassedRun, SegmentRun};
use step::usual_step;
use task::{Cancel, Cancelled, Task};

/// Step of the field of heights beyond which it is too coarse, as a share of a smallest radius.
const COARSEST: f64 = 0.1;

/// Share of a volume from which on it is warned of that two ways of finding it differ by as much.
const MUCH: f64 = 0.2;
/// What is left no thicker than this many times the tolerance, one way may find and the other not.
const THIN: f64 = 1.25;

/// What is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncutParams {
    /// The cutters.
    pub library: CutterLibrary,
    /// Direction that the cutters come from.
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
    /// [`UncutError::Params`], [`UncutError::CoarseStep`], [`UncutError::Field`].
    pub fn validate(&self) -> Result<(), UncutError> {
        self.library.validate()?;
        self.layers.validate().map_err(|problem| problem.within("layers"))?;
        Invalid::unless_within("tolerance_mm", self.tolerance_mm, [1e-4, 10.0], "mm")?;
        if let Some(step) = self.grid_step_mm.filter(|step| !(step.is_finite() && *step > 0.0)) {
            return Err(UncutError::Field(HeightFieldError::BadStep(step)));
        }
        let radius = self.library.least_radius();
        match self.grid_step_mm.filter(|step| *step > 0.5 * radius) {
            Some(step) => Err(UncutError::CoarseStep { step, radius }),
            None => Ok(()),
        }
    }
}

/// Reason why a mold has no answer.
#[derive(Debug, thiserror::Error)]
pub enum UncutError {
    /// A parameter is not possible.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// A step of the field of heights that shows nothing.
    #[error(
        "height map: step {step} mm is too coarse for a cutter of radius {radius} mm; give at most {} mm",
        0.5 * radius
    )]
    CoarseStep {
        /// The step (mm).
        step: f64,
        /// The smallest radius (mm).
        radius: f64,
    },
    /// The field of heights cannot be had.
    #[error("height map: {0}")]
    Field(HeightFieldError),
    /// The task was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<HeightFieldError> for UncutError {
    fn from(error: HeightFieldError) -> Self {
        match error {
            HeightFieldError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            HeightFieldError::Cutter(problem) => Self::Params(problem),
            other => Self::Field(other),
        }
    }
}

/// Number of regions and their volume (mm^3), by one way of finding them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Found {
    pub regions: usize,
    pub volume_mm3: f64,
}

/// Figures found by a coarser field of heights.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coarser {
    /// Step of the coarser field (mm).
    pub step: f64,
    /// Figures found with it.
    pub found: Found,
}

/// What is left of a mold. Everything stands upright: the opening looks along +Z.
#[derive(Debug, Clone, Serialize, Deserialize)]
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
    /// What a flat cutter as wide as the smallest rounded one leaves, in layers at floors and evenly between them; none
    /// where what flat cutters leave tells it.
    #[serde(default)]
    pub of_shaft: Vec<UncutLayer>,
    /// Middle of the largest undercut face (mm) and its outward unit normal, in the axes of the mesh.
    #[serde(default)]
    pub undercut_at: Option<[DVec3; 2]>,
    /// Step of the field of heights (mm).
    pub grid_step: f64,
    /// What a field twice as coarse finds; none where layers are the answer, and where that is too coarse to find it.
    pub coarser: Option<Coarser>,
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

    /// The segments of the layer nearest to a height that no cutter touches, as runs of points (mm): exact where only
    /// flat cutters count, else at that very height as fine as the surface is split.
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

    /// The pieces of a layer, by its place in the stack, that belong to regions; none where regions are those of the
    /// field of heights.
    pub fn pieces(&self, layer: usize) -> impl Iterator<Item = &UncutPiece> {
        let own = self.regions.iter().flat_map(|r| &r.pieces).filter(move |[k, _]| *k == layer);
        own.map(move |[_, i]| &self.stack.layers[layer].pieces[*i])
    }

    /// What is known exactly of the cutters in layers.
    pub(super) fn exact(&self) -> Exact<'_> {
        Exact { stack: &self.stack, of_shaft: &self.of_shaft }
    }

    /// Whether mesh and grid are such that the answer holds for all that looks to the cutters.
    pub fn is_sound(&self) -> bool {
        let breaks = |w: &MoldWarning| {
            let is_answered_by_grid = || !self.is_of_flats();
            w.is_of_surface() || matches!(w, MoldWarning::CoarseGrid { .. }) && is_answered_by_grid()
        };
        !self.stack.warnings.iter().any(breaks)
    }

    /// Faces that look away from the cutters, if there are more of them than rounding makes.
    pub fn undercut(&self) -> Option<&InvertFaces> {
        Some(&self.stack.invert).filter(|invert| invert.area > LEAST_INVERT)
    }

    /// What the answer does not tell, in sentences: the warnings, and faces that cutters from above do not reach.
    pub fn doubts(&self) -> Vec<String> {
        let undercut = self.undercut().map(|faces| {
            let (count, area) = (counted(faces.triangles.len(), "undercut face"), faces.area);
            let place = self.undercut_at.map_or_else(String::new, |[p, looks]| {
                let [p, n] = [p, looks].map(|v| v + 0.0);
                format!(
                    ", the largest about x = {:.3}, y = {:.3}, z = {:.3}, where the mold looks to ({:.3}, {:.3}, {:.3})",
                    p.x, p.y, p.z, n.x, n.y, n.z
                )
            });
            format!(
                "{count} ({area:.2} mm2) cannot be reached along the opening{place}: another set-up or a slide is needed"
            )
        });
        self.stack.warnings.iter().map(ToString::to_string).chain(undercut).collect()
    }

    /// Number of thin regions of which it is not known whether rounded cutters take them.
    pub fn unknown_regions(&self) -> usize {
        let unknown = |w: &MoldWarning| if let MoldWarning::ThinRegions { regions, .. } = w { *regions } else { 0 };
        self.stack.warnings.iter().map(unknown).sum()
    }

    /// Number of slivers that every cutter leaves and that are too thin to be regions.
    pub fn slivers(&self) -> usize {
        let left = |w: &MoldWarning| if let MoldWarning::SliversLeft { regions, .. } = w { *regions } else { 0 };
        self.stack.warnings.iter().map(left).sum()
    }

    /// Whether the answer holds, and the volume of what is left is known.
    pub fn is_certain(&self) -> bool {
        self.is_sound() && !self.stack.warnings.iter().any(|w| matches!(w, MoldWarning::Uncertain { .. }))
    }

    /// Whether the regions are all that is left of the mold: it is sound, what is left is known, nothing thin is left
    /// beside them, and no face looks away.
    pub fn is_whole(&self) -> bool {
        self.is_certain() && self.unknown_regions() + self.slivers() == 0 && self.undercut().is_none()
    }
}

fn found(volumes: impl ExactSizeIterator<Item = f64>) -> Found {
    Found { regions: volumes.len(), volume_mm3: volumes.fold(0.0, |sum, v| sum + v) }
}

/// What the cutters of `params` leave of `mesh`.
///
/// # Errors
/// [`UncutError`].
pub fn uncut(mesh: &Mesh, params: &UncutParams, task: &Task) -> Result<Uncut, UncutError> {
    params.validate()?;
    if mesh.triangles.is_empty() {
        return Err(UncutError::Field(HeightFieldError::NoMaterial));
    }
    let upright = params.opening.upright_mesh(mesh);
    let needed = params.library.needed();
    let flats: Vec<&Cutter> = needed.iter().copied().filter(|c| c.kind() == CutterKind::Flat).collect();
    let grid_step = params.grid_step_mm.unwrap_or_else(|| usual_step(&upright, &needed, params.tolerance_mm));
    task.report("height map", 0.0, "");
    let field = HeightField::raster(&upright, grid_step, &task.cancel)?;
    let mut stack = uncut_stack(&upright, &flats, None, &params.layers, task)?;
    doubt(&mut stack, mesh, &needed, grid_step);
    if let Some(warning) = Unseen::warning(&upright, &task.cancel)? {
        stack.warnings.push(warning.of_opening(mesh, params.opening, &task.cancel)?);
    }
    let flat_regions = regions(&stack.layers, params.tolerance_mm);
    task.report("height map", 0.2, "");
    let of_shaft = layers_of_shaft(&upright, &needed, &task.cancel)?;
    let exact = Exact { stack: &stack, of_shaft: &of_shaft };
    let (closing, of_field) = on_field(&field, &params.library, (exact, params.tolerance_mm), &task.cancel)?;
    task.report("height map", 0.5, "");
    let is_of_flats = flats.len() == needed.len();
    let (mut others_of_flats, mut thick_of_flats) = (None, None);
    let agreement = if flats.is_empty() {
        None
    } else {
        let only_flats = || CutterLibrary { cutter: flats.iter().copied().cloned().collect() };
        let other = if is_of_flats {
            None
        } else {
            Some(on_field(&field, &only_flats(), (exact, params.tolerance_mm), &task.cancel)?.1)
        };
        let with_flats = other.as_ref().unwrap_or(&of_field);
        others_of_flats = most_different(&flat_regions, with_flats);
        let is_thick = |residue: f64| residue > THIN * params.tolerance_mm;
        let of_layers = flat_regions.iter().filter(|r| is_thick(r.residue())).map(|r| r.volume);
        let of_grid = with_flats.iter().filter(|r| is_thick(r.normal_depth)).map(|r| r.volume);
        thick_of_flats = Some([of_layers.sum(), of_grid.sum()]);
        let volumes = [flat_regions.iter().map(|r| r.volume).collect(), with_flats.iter().map(|r| r.volume).collect()];
        Some(volumes.map(|v: Vec<f64>| found(v.into_iter())))
    };
    task.report("height map", 0.9, "");
    let coarser = if is_of_flats { None } else { coarser(&upright, params, (exact, grid_step), &task.cancel)? };
    // The exact search would let a ball go sideways under what looks down, where its shaft cannot follow.
    let has_undercuts = !stack.invert.triangles.is_empty() && stack.invert.area > 0.0;
    let ball_agreement = if has_undercuts {
        None
    } else {
        ball_agreement(&upright, &params.library, (&field, &closing), &of_field, &task.cancel)?
    };
    let volume = of_field.iter().map(|r| r.volume).sum::<f64>();
    let of_steps = coarser.map(|coarser| [volume, coarser.found.volume_mm3]);
    let place = others_of_flats.or_else(|| of_field.first().map(|r| r.bounds.center()));
    let radius = needed.iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    stack.warnings.extend(uncertain([thick_of_flats, of_steps], place.map(|p| params.opening.in_mesh(p)), radius));
    task.report("surface", 0.0, "");
    let surface = uncut_surface(&upright, &Covered::new(&field, &closing, &of_field), &task.cancel)?;
    if surface.is_coarse {
        stack.warnings.push(MoldWarning::CoarseSurface { fineness: surface.fineness });
    }
    let all = if is_of_flats {
        Regions::of_layers(&stack.layers, &flat_regions, (&field, &closing), &of_field)
    } else {
        let thin = thin_regions((&upright, &field), (&flat_regions, &of_field), params, &task.cancel)?;
        stack.warnings.extend(thin);
        Regions::of_field(&of_field)
    };
    let (regions, surface) = all.with_surface(surface.pieces);
    let layers = if is_of_flats {
        of_layers(&stack, &regions)
    } else {
        of_surface(&stack, (&field, &closing), &of_field, &surface)
    };
    stack.invert = undercuts(stack.invert, &upright, params.opening, &task.cancel)?;
    let undercut_at = stack.invert.largest(mesh);
    task.report("surface", 1.0, "");
    Ok(Uncut {
        params: params.clone(),
        stack,
        layers,
        regions,
        surface,
        of_shaft,
        undercut_at,
        grid_step,
        coarser,
        agreement,
        ball_agreement,
    })
}

/// Says where mesh and grid are not such that the answer holds.
fn doubt(stack: &mut UncutStack, mesh: &Mesh, needed: &[&Cutter], grid_step: f64) {
    // Where a whole wall is missing every section closes all the same.
    let edges = open_edges(mesh);
    if edges > 0 {
        stack.warnings.insert(0, MoldWarning::NotClosed { edges });
    }
    let radius = needed.iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    if grid_step > 1.001 * COARSEST * radius {
        stack.warnings.push(MoldWarning::CoarseGrid { step: grid_step, radius });
    }
}

/// What is known exactly of cutters in layers.
#[derive(Clone, Copy)]
pub(super) struct Exact<'a> {
    /// What the flat cutters leave.
    stack: &'a UncutStack,
    /// What a flat cutter as wide as the smallest rounded one leaves; none where what flat cutters leave tells it.
    of_shaft: &'a [UncutLayer],
}

/// Radius of the thinnest of cutters that reach to any depth (mm).
fn thinnest<'a>(cutters: impl Iterator<Item = &'a Cutter>) -> f64 {
    cutters.filter(|c| c.holder().is_none()).map(|c| c.radius()).fold(f64::INFINITY, f64::min)
}

/// What a flat cutter as wide as the smallest rounded one of `needed` leaves of `mesh`, in layers at floors and evenly
/// between them; none where a flat one without a holder is no wider.
fn layers_of_shaft(mesh: &Mesh, needed: &[&Cutter], cancel: &Cancel) -> Result<Vec<UncutLayer>, Cancelled> {
    let (flats, rounded): (Vec<&Cutter>, Vec<&Cutter>) =
        needed.iter().copied().partition(|cutter| cutter.kind() == CutterKind::Flat);
    let least = rounded.iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    if rounded.is_empty() || thinnest(flats.into_iter()) <= least {
        return Ok(Vec::new());
    }
    let settings = LayerSettings { is_fixed: true, ..LayerSettings::default() };
    Ok(uncut_stack(mesh, &[&Cutter::flat(least)], None, &settings, &Task::silent(cancel))?.layers)
}

/// What a library leaves of the heights, and its regions. Where cutters fit just so, or just do not, the layers tell it.
pub(super) fn on_field(
    field: &HeightField,
    library: &CutterLibrary,
    (exact, tolerance): (Exact, f64),
    cancel: &Cancel,
) -> Result<(Closing, Vec<FieldRegion>), UncutError> {
    let needed = library.needed();
    let is_flat = |cutter: &Cutter| cutter.kind() == CutterKind::Flat;
    if exact.stack.warnings.iter().any(MoldWarning::is_of_surface) {
        let closing = height_field::closing(field, library, cancel)?;
        let regions = height_field::regions(field, &closing, tolerance, cancel)?;
        return Ok((closing, regions));
    }
    let of_flats = &exact.stack.layers;
    let raise = |cutter: &Cutter, before: &Closing, closing: &mut Closing| {
        // Each of the flat cutters leaves at least what all of them do.
        let is_of_flats = is_flat(cutter) || exact.of_shaft.is_empty();
        let layers = if is_of_flats { of_flats } else { exact.of_shaft };
        raise_to_layers(field, (cutter, layers), before, closing);
    };
    let mut closing = height_field::closing_corrected(field, library, &raise, cancel)?;
    let mut regions = height_field::regions(field, &closing, tolerance, cancel)?;
    if needed.iter().any(|c| is_flat(c)) && lower_to_layers((field, &mut closing), &regions, of_flats) {
        regions = height_field::regions(field, &closing, tolerance, cancel)?;
    }
    Ok((closing, regions))
}

/// What is found by heights twice as far apart as `step` (mm); none where that is too coarse for the smallest cutter.
/// The error falls at least in proportion to the step, so that what this differs by is about as far as `step` is off.
fn coarser(
    mesh: &Mesh,
    params: &UncutParams,
    (exact, step): (Exact, f64),
    cancel: &Cancel,
) -> Result<Option<Coarser>, UncutError> {
    let coarse = UncutParams { grid_step_mm: Some(2.0 * step), ..params.clone() };
    if coarse.validate().is_err() {
        return Ok(None);
    }
    let field = HeightField::raster(mesh, 2.0 * step, cancel)?;
    let (_, regions) = on_field(&field, &params.library, (exact, params.tolerance_mm), cancel)?;
    Ok(Some(Coarser { step: 2.0 * step, found: found(regions.iter().map(|r| r.volume)) }))
}

/// A warning if two volumes of one thing (mm^3), found in two ways, differ by much, of which the most is about a place.
/// Less than what a cutter of the least `radius` (mm) fills is not much.
fn uncertain(found: [Option<[f64; 2]>; 2], place: Option<DVec3>, radius: f64) -> Option<MoldWarning> {
    let [a, b] = found.into_iter().flatten().max_by(|[a, b], [c, d]| (a - b).abs().total_cmp(&(c - d).abs()))?;
    let (off_mm3, most) = ((a - b).abs(), a.max(b));
    let is_much = off_mm3 > MUCH * most && off_mm3 > radius.powi(3);
    place
        .filter(|_| is_much)
        .map(|place| MoldWarning::Uncertain { volumes_mm3: [a.min(b), most], place: place.to_array() })
}

/// Middle of the region by whose volume the layers and the grid differ most.
fn most_different(flat: &[LayerRegion], of_field: &[FieldRegion]) -> Option<DVec3> {
    let layers_in =
        |r: &FieldRegion| flat.iter().filter(|l| l.bounds.intersects(&r.bounds)).map(|l| l.volume).sum::<f64>();
    let of_field_in = |l: &LayerRegion| !of_field.iter().any(|r| r.bounds.intersects(&l.bounds));
    let too_many = of_field.iter().map(|r| ((r.volume - layers_in(r)).abs(), r.bounds.center()));
    let missed = flat.iter().filter(|l| of_field_in(l)).map(|l| (l.volume, l.bounds.center()));
    too_many.chain(missed).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place)
}

/// Edges that have no face on one side, or more on one than on the other.
pub(super) fn open_edges(mesh: &Mesh) -> usize {
    let directed = mesh.directed_edges();
    directed.iter().filter(|((a, b), count)| directed.get(&(*b, *a)).copied().unwrap_or(0) < **count).count()
}
