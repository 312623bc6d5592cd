//! What another library of cutters would take away of what the present one leaves.
//!
//! Both are told by the same method: by layers where only flat cutters count in either, else by one field of heights
//! for both. Where the one leaves what the other takes is always told by that field.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::uncut::{Found, Uncut, UncutError, on_field};
use files::report::counted;
use geometry::exact::ExactMesh;
use geometry::mesh::{Bounds, Mesh};
use mold::height_field::{Closing, FieldRegion, HeightField, difference};
use mold::surface::SurfacePiece;
use mold::uncut_region::UncutRegion;
use task::{Cancel, Cancelled, Task};

/// Most cells of a region of the field whose owners among the other regions are looked up.
const LOOKS: usize = 256;
/// Most cells that are looked up where they belong to several regions.
const CLOSE_LOOKS: usize = 4096;
/// The part of a region that counts for nothing: where a boundary lies is as coarse as the grid.
const NEARLY_NONE: f64 = 0.03;
/// How far apart two surfaces of the same mold may lie and still be one, in parts of the diagonal.
const SAME: f64 = 1e-3;
/// The step of the common field, in parts of the smallest radius and in tolerances, where the two differ in theirs.
const FINE: (f64, f64) = (0.1, 2.0);

/// A connected part of the mold that one library leaves and the other one takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Volume (mm^3).
    pub volume: f64,
    /// Area seen from the cutter (mm^2).
    pub plan_area: f64,
    /// Greatest height (mm).
    pub depth: f64,
    /// Greatest thickness across the mold's surface (mm).
    pub thickness: f64,
    /// The box around it (mm), upright.
    pub bounds: Bounds,
    /// The region of the present library in which most of it lies; none if that is none.
    pub region: Option<usize>,
}

/// What becomes of the regions that the present library leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// For each region of the present library the volume that the other one leaves of it (mm^3).
    pub remains: Vec<f64>,
    /// Volume that the present library leaves, and the other one (mm^3).
    pub volumes: [f64; 2],
    /// Number of regions that either library leaves.
    pub regions: [usize; 2],
    /// Number of regions of the other library that lie where the present one leaves nothing.
    pub new_regions: usize,
    /// What the present library leaves and the other one takes, thicker than the tolerance, the largest first.
    pub taken: Vec<Difference>,
    /// What the other library leaves and the present one takes.
    pub added: Vec<Difference>,
    /// Whether volumes and numbers of regions are those of layers, else of the field of heights.
    pub by_layers: bool,
    /// Step of the field that both are compared on (mm).
    pub step: f64,
}

impl Comparison {
    /// Whether the other library leaves (nearly) nothing of region number `i` of the present one.
    pub fn vanishes(&self, i: usize) -> bool {
        self.remains.get(i).is_some_and(|volume| *volume <= 0.0)
    }

    /// Number of regions that vanish.
    pub fn vanishing(&self) -> usize {
        (0..self.remains.len()).filter(|i| self.vanishes(*i)).count()
    }

    /// What the other library would do, in two sentences.
    pub fn sentence(&self) -> String {
        let ([now, other], gone) = (self.volumes, self.vanishing());
        let regions = if gone == 1 { "1 region vanishes".to_owned() } else { format!("{gone} regions vanish") };
        let change = now - other;
        let volume = if change >= 0.0 {
            format!("{change:.3} mm³ of {now:.3} mm³ would be cut")
        } else {
            format!("{:.3} mm³ more than {now:.3} mm³ would be left", -change)
        };
        let new = match self.new_regions {
            0 => String::new(),
            1 => ", and 1 region is new".to_owned(),
            n => format!(", and {n} regions are new"),
        };
        format!("{volume}; {regions}{new}. {}", self.places())
    }

    /// Where the two differ, in a sentence.
    fn places(&self) -> String {
        let sum = |all: &[Difference]| all.iter().fold(0.0, |sum, d| sum + d.volume);
        let part = |all: &[Difference], change: &str| {
            let places = counted(all.len(), "place");
            (!all.is_empty()).then(|| format!("in {places} {:.3} mm³ {change}", sum(all)))
        };
        let parts = [part(&self.taken, "less is left"), part(&self.added, "more is left")];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if parts.is_empty() {
            return "They differ nowhere by more than the tolerance.".to_owned();
        }
        format!("By height map, step {:.4} mm: {}.", self.step, parts.join(", "))
    }
}

/// Compares what two libraries leave of `mesh` by the answers `now` and `other`, which differ in nothing else.
///
/// # Errors
/// [`UncutError`].
pub fn compare(mesh: &Mesh, now: &Uncut, other: &Uncut, task: &Task) -> Result<Comparison, UncutError> {
    let params = &now.params;
    let step = common_step(now, other);
    task.report("comparison", 0.0, "");
    let field = HeightField::raster(&params.opening.upright_mesh(mesh), step, &task.cancel)?;
    let present = Side::of(&field, now, &task.cancel)?;
    task.report("comparison", 0.4, "");
    let others = Side::of(&field, other, &task.cancel)?;
    task.report("comparison", 0.8, "");
    let places = Places::new(now);
    let between = |more: &Side, less: &Side| -> Result<Vec<Difference>, UncutError> {
        let found = difference(&field, &more.closing, &less.closing, params.tolerance_mm, &task.cancel)?;
        let of = |region: &FieldRegion| Ok(places.difference(&field, region, &task.cancel)?);
        found.par_iter().map(of).collect()
    };
    let by_layers = now.is_of_flats() && other.is_of_flats();
    let found = |uncut: &Uncut, side: &Side| if by_layers { uncut.found() } else { side.found() };
    let all = [found(now, &present), found(other, &others)];
    let both = Both { field: &field, present: &present, others: &others, places: &places };
    let (remains, new_regions) = remains(now, other, &both, &task.cancel)?;
    let comparison = Comparison {
        remains,
        volumes: all.map(|f| f.volume_mm3),
        regions: all.map(|f| f.regions),
        new_regions,
        taken: between(&present, &others)?,
        added: between(&others, &present)?,
        by_layers,
        step,
    };
    task.report("comparison", 1.0, "");
    Ok(comparison)
}

/// The step of a field for both (mm). A step as fine as the smallest cutter alone asks for would take too long with a
/// large rounded one: of the two the coarser, unless what the smallest cutter leaves would not be seen.
fn common_step(now: &Uncut, other: &Uncut) -> f64 {
    let (fine, coarse) = (now.grid_step.min(other.grid_step), now.grid_step.max(other.grid_step));
    let all = [now, other].into_iter().flat_map(|uncut| uncut.params.library.needed());
    let radius = all.map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    (FINE.0 * radius).max(FINE.1 * now.params.tolerance_mm).clamp(fine, coarse)
}

/// What a library leaves on the common field.
struct Side {
    closing: Closing,
    regions: Vec<FieldRegion>,
    /// The region of each cell.
    numbers: Vec<u32>,
}

/// The number of no region.
const NONE: u32 = u32::MAX;

impl Side {
    fn of(field: &HeightField, uncut: &Uncut, cancel: &Cancel) -> Result<Self, UncutError> {
        let params = &uncut.params;
        let (closing, regions) = on_field(field, &params.library, (uncut.exact(), params.tolerance_mm), cancel)?;
        let mut numbers = vec![NONE; field.size()[0] * field.size()[1]];
        for (region, number) in regions.iter().zip(0..) {
            region.cells.iter().for_each(|cell| numbers[*cell as usize] = number);
        }
        Ok(Self { closing, regions, numbers })
    }

    fn found(&self) -> Found {
        Found { regions: self.regions.len(), volume_mm3: self.regions.iter().fold(0.0, |sum, r| sum + r.volume) }
    }
}

/// What a part of the present library's residue has in common with the regions of the other one.
#[derive(Debug, Clone, Default)]
struct Overlap {
    /// Volume of the part (mm^3).
    volume: f64,
    /// Volume that it shares with those that share any (mm^3).
    shared: BTreeMap<u32, f64>,
}

impl Overlap {
    fn add(&mut self, other: &Self) {
        self.volume += other.volume;
        other.shared.iter().for_each(|(k, volume)| *self.shared.entry(*k).or_default() += volume);
    }

    /// What counts of the shared volumes: not where boundaries of two neighbours are a cell off.
    fn counted<'a>(&'a self, others: &'a Side) -> impl Iterator<Item = (u32, f64)> + 'a {
        let counts =
            |(k, volume): &(u32, f64)| *volume > NEARLY_NONE * self.volume.min(others.regions[*k as usize].volume);
        self.shared.iter().map(|(k, volume)| (*k, *volume)).filter(counts)
    }
}

/// The present library's residue and the other one's on the common field.
struct Both<'a> {
    field: &'a HeightField,
    present: &'a Side,
    others: &'a Side,
    places: &'a Places<'a>,
}

impl Both<'_> {
    /// What `cells`, each of which stands for so many, have in common with the other library's regions.
    fn overlap(&self, cells: impl Iterator<Item = usize>, each: usize) -> Overlap {
        let area = each as f64 * self.field.step() * self.field.step();
        let mut overlap = Overlap::default();
        for cell in cells {
            let own = self.present.closing.residue(self.field, cell);
            overlap.volume += own * area;
            if self.others.numbers[cell] != NONE {
                let shared = own.min(self.others.closing.residue(self.field, cell));
                *overlap.shared.entry(self.others.numbers[cell]).or_default() += shared * area;
            }
        }
        overlap
    }

    /// The overlap of a region of the present library's on the field, and the parts of that which lie in regions of its
    /// answer.
    fn of_region(&self, region: &FieldRegion, cancel: &Cancel) -> Result<(Overlap, Vec<(usize, Overlap)>), Cancelled> {
        cancel.check()?;
        let whole = self.overlap(region.cells.iter().map(|cell| *cell as usize), 1);
        let owned = |looks: usize| {
            let each = region.cells.len().div_ceil(looks).max(1);
            let cells = region.cells.iter().step_by(each).map(|cell| *cell as usize);
            let mut of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            for (owner, cell) in cells.filter_map(|cell| Some((self.places.owner(self.field, cell)?, cell))) {
                of.entry(owner).or_default().push(cell);
            }
            (each, of)
        };
        let (_, owners) = owned(LOOKS);
        if let (1, Some(owner)) = (owners.len(), owners.keys().next()) {
            let part = whole.clone();
            return Ok((whole, vec![(*owner, part)]));
        }
        // The field joins what the layers keep apart.
        let (each, owners) = owned(CLOSE_LOOKS);
        let part = |(owner, cells): (usize, Vec<usize>)| (owner, self.overlap(cells.into_iter(), each));
        Ok((whole, owners.into_iter().map(part).collect()))
    }
}

/// For each region of `now` the volume that the other library leaves of it (mm^3), and how many regions of the other
/// one lie where nothing of `now` is.
fn remains(now: &Uncut, other: &Uncut, both: &Both, cancel: &Cancel) -> Result<(Vec<f64>, usize), Cancelled> {
    let overlaps: Vec<_> =
        both.present.regions.par_iter().map(|r| both.of_region(r, cancel)).collect::<Result<_, _>>()?;
    let mut is_new = vec![true; both.others.regions.len()];
    let mut own = vec![Overlap::default(); now.regions.len()];
    for (whole, parts) in &overlaps {
        whole.counted(both.others).for_each(|(k, _)| is_new[k as usize] = false);
        parts.iter().for_each(|(owner, part)| own[*owner].add(part));
    }
    let by_layers = now.is_of_flats() && other.is_of_flats();
    let of_region = |(region, own): (&UncutRegion, &Overlap)| {
        if own.volume > 0.0 {
            let shared = own.counted(both.others).fold(0.0, |sum, (_, volume)| sum + volume);
            return region.volume * (shared / own.volume).min(1.0);
        }
        // Too thin for the field. Layers know all the same; without them nothing is promised.
        if !by_layers {
            return region.volume;
        }
        around(&other.regions, region).map_or(0.0, |around| around.volume.min(region.volume))
    };
    let of_field = is_new.into_iter().filter(|is_new| *is_new).count();
    // What is too thin for the field has no surface.
    let is_thin = |r: &&UncutRegion| by_layers && r.faces.is_empty() && around(&now.regions, r).is_none();
    let new = of_field + other.regions.iter().filter(is_thin).count();
    Ok((now.regions.iter().zip(&own).map(of_region).collect(), new))
}

/// The smallest of `regions` whose box holds the middle of that of a region that the field does not know.
fn around<'a>(regions: &'a [UncutRegion], region: &UncutRegion) -> Option<&'a UncutRegion> {
    let middle = region.bounds.center();
    let holds = |r: &&UncutRegion| r.bounds.min.cmple(middle).all() && middle.cmple(r.bounds.max).all();
    let size = |r: &UncutRegion| r.bounds.size().element_product();
    regions.iter().filter(holds).min_by(|a, b| size(a).total_cmp(&size(b)))
}

/// The surface under what the present library leaves, to be asked whose a place is.
struct Places<'a> {
    pieces: &'a [SurfacePiece],
    /// None without any surface, or with none that can be asked.
    surface: Option<ExactMesh>,
    reach: f64,
}

impl<'a> Places<'a> {
    fn new(uncut: &'a Uncut) -> Self {
        let pieces = &uncut.surface;
        let vertices: Vec<_> = pieces.iter().flat_map(|p| p.corners).collect();
        let reach = (SAME * Bounds::of(vertices.iter().copied()).size().length()).max(2.0 * uncut.grid_step);
        let triangles = (0..pieces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self { pieces, surface: ExactMesh::new(&Mesh { vertices, triangles }).ok(), reach }
    }

    /// The region on whose surface a cell lies.
    fn owner(&self, field: &HeightField, cell: usize) -> Option<usize> {
        let nearest = self.surface.as_ref()?.nearest(field.surface_point(cell)?);
        let piece = self.pieces.get(nearest.triangle as usize)?;
        (nearest.signed_distance.abs() <= self.reach).then_some(piece.region as usize)
    }

    fn difference(&self, field: &HeightField, region: &FieldRegion, cancel: &Cancel) -> Result<Difference, Cancelled> {
        cancel.check()?;
        let cells = region.cells.iter().step_by(region.cells.len().div_ceil(LOOKS).max(1));
        let mut owners: Vec<Option<usize>> = cells.map(|cell| self.owner(field, *cell as usize)).collect();
        owners.sort_unstable();
        // Of equals the first.
        let most = owners.chunk_by(|a, b| a == b).rev().max_by_key(|same| same.len());
        let FieldRegion { volume, plan_area, depth, normal_depth: thickness, bounds, .. } = *region;
        Ok(Difference { volume, plan_area, depth, thickness, bounds, region: most.and_then(|same| same[0]) })
    }
}
