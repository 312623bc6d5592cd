//! What a library of flat cutters leaves of a mold, layer by layer.

use std::collections::HashMap;

use rayon::prelude::*;

use super::cutter::{Cutter, CutterKind};
use super::invert::{InvertFaces, Shadows};
use super::layers::{FirstLayers, LayerFigures, LayerSettings, first_layers, is_bent};
use super::outline::Outline;
use super::piece::{UncutPiece, intersected};
use super::plane;
use super::region::have_partners;
use super::section::{Section, sections};
use super::uncut_layer::uncut_with_holder;
use super::warning::MoldWarning;
use super::way::Obstacle;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled, Progress};

/// Share of an outline set's extent in area up to which two ways to reckon its area agree.
const SAME_AREA: f64 = 1e-9;

/// What is left just above one height.
#[derive(Debug, Clone, PartialEq)]
pub struct UncutLayer {
    /// The height (mm).
    pub z: f64,
    /// The pieces.
    pub pieces: Vec<UncutPiece>,
}

/// What is left of a mold in all layers.
#[derive(Debug, Clone, PartialEq)]
pub struct UncutStack {
    /// Layers, rising.
    pub layers: Vec<UncutLayer>,
    /// The faces that no cutter from above reaches.
    pub invert: InvertFaces,
    /// What is not as it should be.
    pub warnings: Vec<MoldWarning>,
}

/// What further cutters leave of a layer, from what is in their way there.
pub type Others<'a> = &'a (dyn Fn(&Section) -> Vec<UncutPiece> + Sync);

/// What every one of the flat cutters among `cutters`, and of `others` where there are any, leaves of `mesh`, whose
/// opening looks along +Z. Without any cutter nothing is found. The settings must have been validated.
///
/// # Errors
/// [`Cancelled`].
pub fn uncut_stack(
    mesh: &Mesh,
    cutters: &[&Cutter],
    others: Option<Others>,
    settings: &LayerSettings,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<UncutStack, Cancelled> {
    let flats: Vec<&Cutter> = cutters.iter().copied().filter(|c| c.kind() == CutterKind::Flat).collect();
    let reaches: Vec<f64> = flats.iter().filter_map(|c| wide_holder(c)).map(|(_, reach)| reach).collect();
    let mut work = Work { mesh, flats, others, settings, shadows: Shadows::new(mesh), seen: Seen::default() };
    let FirstLayers { heights, floors } = first_layers(mesh, &reaches, settings);
    let mut layers: Vec<UncutLayer> = Vec::new();
    let mut wanted = heights;
    let mut round = 0;
    while !wanted.is_empty() {
        progress.report("layers", 1.0 - 0.5f64.powi(round), &format!("{} layers", layers.len() + wanted.len()));
        layers.extend(work.layers(&wanted, cancel)?);
        layers.sort_by(|a, b| a.z.total_cmp(&b.z));
        round += 1;
        wanted = if settings.is_fixed { Vec::new() } else { halves(&layers, &floors, settings) };
        if layers.len() + wanted.len() > settings.most_layers {
            work.seen.warnings.push(MoldWarning::TooFewLayers { layers: layers.len() });
            break;
        }
    }
    progress.report("layers", 1.0, &format!("{} layers", layers.len()));
    let Work { shadows, seen, .. } = work;
    Ok(UncutStack { warnings: seen.warnings(&layers), layers, invert: shadows.faces().clone() })
}

/// The holder of a cutter if it can meet what the cutter does not: its radius and the reach (mm).
fn wide_holder(cutter: &Cutter) -> Option<(f64, f64)> {
    cutter.holder().filter(|(radius, _)| *radius > cutter.radius())
}

/// Middles of slabs that are not what the layers around them predict.
fn halves(layers: &[UncutLayer], floors: &[f64], settings: &LayerSettings) -> Vec<f64> {
    let figures: Vec<LayerFigures> = layers.iter().map(UncutLayer::figures).collect();
    let n = layers.len();
    // Slabs across a horizontal face have nothing in them.
    let spans = |i: usize| {
        let at = floors.partition_point(|f| *f <= layers[i].z);
        floors.get(at).is_none_or(|f| *f > layers[i + 1].z)
    };
    let slabs: Vec<bool> = (0..n.saturating_sub(1)).map(spans).collect();
    let is_wide = |i: usize| figures[i + 1].z - figures[i].z > 2.0 * settings.least_spacing_mm;
    let bent: Vec<bool> = (0..n)
        .map(|i| i > 0 && i + 1 < n && slabs[i - 1] && slabs[i])
        .enumerate()
        .map(|(i, inner)| inner && is_bent([figures[i - 1], figures[i], figures[i + 1]], settings))
        .collect();
    let is_halved = |&i: &usize| {
        slabs[i] && is_wide(i) && (bent[i] || bent[i + 1] || !have_partners(&layers[i], &layers[i + 1], settings))
    };
    let chosen: Vec<usize> = (0..slabs.len()).into_par_iter().filter(is_halved).collect();
    chosen.into_iter().map(|i| 0.5 * (figures[i].z + figures[i + 1].z)).collect()
}

impl UncutLayer {
    /// Figures of the pieces, but for those between facets, which come and go from layer to layer.
    fn figures(&self) -> LayerFigures {
        let pieces = || self.pieces.iter().filter(|p| !p.is_shallow());
        LayerFigures {
            z: self.z,
            count: pieces().count(),
            area: pieces().map(|p| p.area).sum(),
            length: pieces().map(UncutPiece::segment_length).sum(),
        }
    }
}

struct Work<'a> {
    mesh: &'a Mesh,
    flats: Vec<&'a Cutter>,
    others: Option<Others<'a>>,
    settings: &'a LayerSettings,
    shadows: Shadows<'a>,
    seen: Seen,
}

impl Work<'_> {
    fn layers(&mut self, heights: &[f64], cancel: &Cancel) -> Result<Vec<UncutLayer>, Cancelled> {
        let raised = self.flats.iter().filter_map(|c| wide_holder(c)).map(|(_, reach)| reach);
        let mut all = heights.to_vec();
        raised.for_each(|reach| all.extend(heights.iter().map(|z| z + reach)));
        all.sort_by(f64::total_cmp);
        all.dedup();
        let mut sections = sections(self.mesh, &all, cancel)?;
        let crossing: Vec<bool> = sections.par_iter_mut().map(uncross).collect();
        self.seen.note(&sections, &crossing, heights);
        self.shadows.cast(&mut sections, cancel)?;
        let at: HashMap<u64, usize> = all.iter().enumerate().map(|(i, z)| (z.to_bits(), i)).collect();
        let section = |z: f64| at.get(&z.to_bits()).map(|&i| &sections[i]);
        let left = |z: &f64| {
            cancel.check()?;
            let pieces = section(*z).map(|own| self.left(own, &section)).unwrap_or_default();
            Ok(UncutLayer { z: *z, pieces })
        };
        heights.par_iter().map(left).collect()
    }

    /// What all cutters leave of a layer.
    fn left<'s>(&self, own: &Section, section: &(impl Fn(f64) -> Option<&'s Section> + Sync)) -> Vec<UncutPiece> {
        let tolerance = self.settings.depth_tolerance_mm;
        let by_flat = |cutter: &&Cutter| {
            let high = wide_holder(cutter).and_then(|(radius, reach)| Some((radius, section(own.z + reach)?)));
            let holder = high.map(|(distance, high)| Obstacle { outlines: &high.outlines, distance });
            uncut_with_holder(&own.outlines, cutter.radius(), holder, tolerance)
        };
        let others = self.others.map(|others| others(own));
        let mut left = intersected(self.flats.iter().map(by_flat).chain(others));
        left.retain(|piece| piece.depth > tolerance);
        left
    }
}

/// Makes outlines that cross each other the boundary of all that they enclose; whether they did.
fn uncross(section: &mut Section) -> bool {
    if section.outlines.is_empty() {
        return false;
    }
    let [low, high] = plane::extent(&section.outlines);
    let covered = plane::union(&section.outlines, &[]);
    let area: f64 = covered.iter().map(|shape| plane::area(shape)).sum();
    if (area - plane::area(&section.outlines)).abs() <= SAME_AREA * (high - low).element_product() + 1e-6 {
        return false;
    }
    section.outlines = covered.into_iter().flatten().collect();
    true
}

/// What was seen of the mold on the way.
#[derive(Default)]
struct Seen {
    warnings: Vec<MoldWarning>,
    has_material: bool,
    /// The openings of the lowest section: its height and their area.
    openings: Option<(f64, f64)>,
    open: Vec<(f64, [f64; 2])>,
    crossing: Vec<f64>,
}

impl Seen {
    fn note(&mut self, sections: &[Section], crossing: &[bool], heights: &[f64]) {
        for (section, crosses) in sections.iter().zip(crossing).filter(|(s, _)| heights.contains(&s.z)) {
            let z = section.z;
            self.has_material |= !section.outlines.is_empty();
            self.open.extend(section.open.first().map(|[end, _]| (z, end.to_array())));
            self.crossing.extend(crosses.then_some(z));
            if self.openings.is_none_or(|(lowest, _)| z < lowest) {
                let holes = section.outlines.iter().map(Outline::area).filter(|a| *a < 0.0);
                self.openings = Some((z, -holes.sum::<f64>()));
            }
        }
    }

    fn warnings(self, layers: &[UncutLayer]) -> Vec<MoldWarning> {
        let Self { mut warnings, has_material, openings, mut open, mut crossing } = self;
        if !has_material {
            warnings.push(MoldWarning::Empty);
        }
        open.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some((from, place)), Some((to, _))) = (open.first(), open.last()) {
            warnings.push(MoldWarning::Open { layers: open.len(), from: *from, to: *to, place: *place });
        }
        crossing.sort_by(f64::total_cmp);
        if let (Some(&from), Some(&to)) = (crossing.first(), crossing.last()) {
            warnings.push(MoldWarning::Crossing { layers: crossing.len(), from, to });
        }
        warnings.extend(openings.filter(|(_, area)| *area > 0.0).map(|(_, area)| MoldWarning::NoFloor { area }));
        let shallow = || layers.iter().flat_map(|l| &l.pieces).filter(|p| p.is_shallow());
        let depth = shallow().map(|p| p.depth).fold(0.0, f64::max);
        warnings.extend((depth > 0.0).then(|| MoldWarning::ShallowCorners { pieces: shallow().count(), depth }));
        warnings
    }
}
