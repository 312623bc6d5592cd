//! What cutters leave of a mold, as figures of a report and as text.

use std::fmt::Write;

use serde::Serialize;

use super::uncut::{Found, Uncut};
use crate::geometry::mesh::Bounds;
use crate::mold::piece::UncutPiece;

/// What `uncut.json` holds. Places are in the axes of the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncutReport {
    /// What was found, in a sentence.
    pub sentence: String,
    /// Whether the mesh is such that the answer holds for all of it.
    pub is_whole: bool,
    /// The cutters, as they are called.
    pub cutters: Vec<String>,
    /// The direction in which the opening looks.
    pub opening: &'static str,
    /// Thickness of the residue up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// Whether the regions are those of the layers (exact, only flat cutters count) or of the field of heights.
    pub by_layers: bool,
    /// What is not as it should be, in words.
    pub warnings: Vec<String>,
    /// Faces that look away from the cutters.
    pub invert: InvertReport,
    /// All regions, the largest volume first.
    pub regions: Vec<RegionReport>,
    /// What flat cutters leave by layers and by the field of heights; none without flat cutters.
    pub agreement: Option<AgreementReport>,
    /// What flat cutters leave in each layer, from the bottom.
    pub layers: Vec<LayerReport>,
}

/// Faces that no cutter from this side reaches.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct InvertReport {
    pub faces: usize,
    pub area_mm2: f64,
}

/// A connected piece of what is left.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RegionReport {
    /// Counted from 1.
    pub index: usize,
    /// Volume (mm^3).
    pub volume_mm3: f64,
    /// Area seen from the cutter (mm^2); of the largest layer where the regions are those of layers.
    pub plan_area_mm2: f64,
    /// Greatest height (mm).
    pub height_mm: f64,
    /// Corners of the box around it (mm).
    pub bounds_mm: [[f64; 3]; 2],
    /// The cutter that comes nearest.
    pub nearest_cutter: Option<String>,
}

/// The same found twice.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct AgreementReport {
    pub layers: Found,
    pub field: Found,
    /// Step of the field (mm).
    pub field_step_mm: f64,
}

/// What flat cutters leave in a layer.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct LayerReport {
    pub z_mm: f64,
    pub pieces: usize,
    pub area_mm2: f64,
    /// Length of the outline that no cutter touches (mm).
    pub segment_length_mm: f64,
}

impl UncutReport {
    /// The report of `uncut`.
    pub fn of(uncut: &Uncut) -> Self {
        let library = &uncut.params.library;
        let agreement =
            uncut.agreement.map(|[layers, field]| AgreementReport { layers, field, field_step_mm: uncut.grid_step });
        let layer = |layer: &crate::mold::stack::UncutLayer| LayerReport {
            z_mm: layer.z,
            pieces: layer.pieces.len(),
            area_mm2: layer.pieces.iter().map(|p| p.area).sum(),
            segment_length_mm: layer.pieces.iter().map(UncutPiece::segment_length).sum(),
        };
        Self {
            sentence: sentence(uncut),
            is_whole: uncut.is_whole(),
            cutters: library.cutter.iter().map(|c| c.label()).collect(),
            opening: uncut.params.opening.name(),
            tolerance_mm: uncut.params.tolerance_mm,
            by_layers: uncut.is_of_flats(),
            warnings: uncut.stack.warnings.iter().map(ToString::to_string).collect(),
            invert: InvertReport { faces: uncut.stack.invert.triangles.len(), area_mm2: uncut.stack.invert.area },
            regions: regions(uncut),
            agreement,
            layers: uncut.stack.layers.iter().map(layer).collect(),
        }
    }

    /// The report in lines for a terminal.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", self.sentence);
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        if self.invert.faces > 0 {
            let InvertReport { faces, area_mm2 } = self.invert;
            let _ = writeln!(
                text,
                "{faces} faces ({area_mm2:.2} mm2) look away from the cutters: for another set-up or a slide."
            );
        }
        if let Some(AgreementReport { layers, field, field_step_mm }) = &self.agreement {
            let _ = writeln!(
                text,
                "Flat cutters by layers: {} regions, {:.3} mm3; by heights {field_step_mm} mm apart: {} regions, {:.3} mm3.",
                layers.regions, layers.volume_mm3, field.regions, field.volume_mm3
            );
        }
        if !self.regions.is_empty() {
            let _ = writeln!(
                text,
                "{:>4} {:>12} {:>12} {:>10}   {:<40} nearest",
                "", "volume mm3", "area mm2", "height mm", "at"
            );
        }
        for r in &self.regions {
            let [low, high] = r.bounds_mm;
            let at: Vec<String> = (0..3).map(|k| format!("{:.2}..{:.2}", low[k], high[k])).collect();
            let nearest = r.nearest_cutter.as_deref().unwrap_or("-");
            let (index, volume, area, height) = (r.index, r.volume_mm3, r.plan_area_mm2, r.height_mm);
            let _ = writeln!(
                text,
                "{index:>4} {volume:>12.4} {area:>12.4} {height:>10.3}   {:<40} {nearest}",
                at.join(" ")
            );
        }
        text
    }
}

fn sentence(uncut: &Uncut) -> String {
    let Found { regions, volume_mm3 } = uncut.found();
    let doubt = if uncut.is_whole() { "" } else { "; the mesh is not whole, so that more may be left than is said" };
    match regions {
        0 => format!("The cutters reach everything{doubt}."),
        1 => format!("The cutters leave 1 region of {volume_mm3:.3} mm3{doubt}."),
        _ => format!("The cutters leave {regions} regions of {volume_mm3:.3} mm3 together{doubt}."),
    }
}

/// What is known of a region by either way.
struct Figures<'a> {
    volume: f64,
    plan_area: f64,
    height: f64,
    bounds: &'a Bounds,
    nearest: Option<usize>,
}

fn regions(uncut: &Uncut) -> Vec<RegionReport> {
    let of_layers = uncut.flat_regions.iter().map(|r| Figures {
        volume: r.volume,
        plan_area: r.plan_area,
        height: r.height,
        bounds: &r.bounds,
        nearest: None,
    });
    let of_field = uncut.field_regions.iter().map(|r| Figures {
        volume: r.volume,
        plan_area: r.plan_area,
        height: r.depth,
        bounds: &r.bounds,
        nearest: Some(r.nearest_cutter),
    });
    let mut all: Vec<Figures> = if uncut.is_of_flats() { of_layers.collect() } else { of_field.collect() };
    all.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    let cutters = &uncut.params.library.cutter;
    let report = |(i, r): (usize, &Figures)| {
        let ends = [r.bounds.min, r.bounds.max].map(|p| uncut.params.opening.in_mesh(p));
        RegionReport {
            index: i + 1,
            volume_mm3: r.volume,
            plan_area_mm2: r.plan_area,
            height_mm: r.height,
            bounds_mm: [ends[0].min(ends[1]).to_array(), ends[0].max(ends[1]).to_array()],
            nearest_cutter: r.nearest.and_then(|k| cutters.get(k)).map(|c| c.label()),
        }
    };
    all.iter().enumerate().map(report).collect()
}
