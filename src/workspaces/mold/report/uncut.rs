//! What cutters leave of a mold, as figures of a report and as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::segments::ClassTotal;
use super::steps::StepTime;
use crate::workspaces::mold::job::compare::{Comparison, Difference};
use crate::workspaces::mold::job::uncut::{Coarser, Found, LayerFound, Uncut};
use files::report::{PageError, Picture, Template, counted};
use geometry::mesh::Bounds;
use geometry::segmentation::CadFaces;
use mold::ball_agreement::BallAgreement;
use mold::cutter::CutterLibrary;
use mold::opening::Opening;
use mold::surface::SurfacePiece;
use mold::uncut_region::UncutRegion;

/// What `uncut.json` holds. Places are in the axes of the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncutReport {
    /// What was found, in a sentence.
    pub sentence: String,
    /// Whether the answer is known for all of the mold.
    pub is_whole: bool,
    /// The cutters, as they are called.
    pub cutters: Vec<String>,
    /// The direction in which the opening looks.
    pub opening: String,
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
    /// How far the volume may be off; none where it is that of the layers, and where it is not known.
    pub grid: Option<GridReport>,
    /// What flat cutters leave by layers and by the field of heights; none without flat cutters.
    pub agreement: Option<AgreementReport>,
    /// How far the field of heights and the exact search agree on what balls leave; none where they count nowhere.
    pub ball_agreement: Option<BallAgreement>,
    /// What the cutters leave in each layer, from the bottom.
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
    /// Number of the region, counted from 1.
    pub index: usize,
    /// Volume (mm^3).
    pub volume_mm3: f64,
    /// Area seen from the cutter (mm^2).
    pub plan_area_mm2: f64,
    /// Area of the mold's surface that bounds it, walls and floors (mm^2).
    pub surface_area_mm2: f64,
    /// Greatest height (mm).
    pub height_mm: f64,
    /// Greatest thickness across the mold's surface (mm).
    pub thickness_mm: f64,
    /// Corners of the box around it (mm).
    pub bounds_mm: [[f64; 3]; 2],
    /// The faces of the mesh that bound it, wholly or in part, counted from 0.
    pub faces: Vec<u32>,
    /// The faces of the CAD program that bound it, the largest area first; none where the file has none.
    pub cad_faces: Vec<CadFaceReport>,
    /// The cutter that comes nearest.
    pub nearest_cutter: Option<String>,
}

/// Part of a face of the CAD program that bounds a region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CadFaceReport {
    /// Number of the face, counted from 1, as the window shows it.
    pub number: u32,
    /// Form, sizes and name in the file.
    pub face: String,
    /// Area of the part (mm^2).
    pub area_mm2: f64,
}

/// Comparison of the answer with that of a field of heights twice as coarse.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GridReport {
    /// Step of the field that answers (mm).
    pub step_mm: f64,
    /// Step of the coarser one (mm).
    pub coarser_step_mm: f64,
    /// Figures found by the coarser field.
    pub coarser: Found,
    /// By how much the volumes differ (mm^3): the answer's is off by about as much.
    pub off_mm3: f64,
}

/// Comparison of the answers of layers and of a field of heights.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct AgreementReport {
    pub layers: Found,
    pub field: Found,
    /// Step of the field (mm).
    pub field_step_mm: f64,
}

/// What the cutters leave in a layer.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct LayerReport {
    pub z_mm: f64,
    pub area_mm2: f64,
    /// Length of the outline that no cutter touches (mm).
    pub segment_length_mm: f64,
}

/// What other cutters would leave, compared with these. Places are in the axes of the mesh; the first of two figures is
/// that of these cutters, the second that of the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonReport {
    /// The comparison in two sentences.
    pub sentence: String,
    /// The other cutters.
    pub cutters: Vec<String>,
    /// Numbers of regions.
    pub regions: [usize; 2],
    /// Volumes (mm^3).
    pub volumes_mm3: [f64; 2],
    /// Number of regions that the other cutters remove.
    pub vanishing: usize,
    /// Number of regions of the other cutters where these leave nothing.
    pub new_regions: usize,
    /// For each region of these cutters the volume that the others leave of it (mm^3).
    pub remains_mm3: Vec<f64>,
    /// Places where the other cutters leave less, the largest first.
    pub taken: Vec<PlaceReport>,
    /// Places where the other cutters leave more.
    pub added: Vec<PlaceReport>,
    /// Step of the height map on which places are compared (mm).
    pub step_mm: f64,
}

/// A place that one library leaves and another one cuts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlaceReport {
    /// Volume (mm^3).
    pub volume_mm3: f64,
    /// Area seen from the cutter (mm^2).
    pub plan_area_mm2: f64,
    /// Greatest height (mm).
    pub height_mm: f64,
    /// Greatest thickness across the mold's surface (mm).
    pub thickness_mm: f64,
    /// Corners of the box around it (mm).
    pub bounds_mm: [[f64; 3]; 2],
    /// Region of these cutters that it is part of, counted from 1; none if of none.
    pub region: Option<usize>,
}

impl ComparisonReport {
    /// The report of `comparison` with the cutters `other` of a mold with this opening.
    pub fn of(comparison: &Comparison, other: &CutterLibrary, opening: Opening) -> Self {
        let place = |d: &Difference| PlaceReport {
            volume_mm3: d.volume,
            plan_area_mm2: d.plan_area,
            height_mm: d.depth,
            thickness_mm: d.thickness,
            bounds_mm: corners(&d.bounds, opening),
            region: d.region.map(|r| r + 1),
        };
        Self {
            sentence: comparison.sentence(),
            cutters: other.cutter.iter().map(|c| c.label()).collect(),
            regions: comparison.regions,
            volumes_mm3: comparison.volumes,
            vanishing: comparison.vanishing(),
            new_regions: comparison.new_regions,
            remains_mm3: comparison.remains.clone(),
            taken: comparison.taken.iter().map(place).collect(),
            added: comparison.added.iter().map(place).collect(),
            step_mm: comparison.step,
        }
    }

    /// The comparison in lines for a terminal.
    pub fn text(&self) -> String {
        let mut text = format!("Compared with {}: {}\n", self.cutters.join(", "), self.sentence);
        for (change, places) in [("less is left", &self.taken), ("more is left", &self.added)] {
            for d in places {
                let [low, high] = d.bounds_mm;
                let at: Vec<String> = (0..3).map(|k| format!("{:.2}..{:.2}", low[k], high[k])).collect();
                let region = d.region.map_or_else(String::new, |r| format!(", region {r}"));
                let (volume, at) = (d.volume_mm3, at.join(" "));
                let _ = writeln!(text, "    {change}: {volume:>10.4} mm3 at {at}{region}");
            }
        }
        text
    }
}

/// What a page on uncut regions shows beside the report.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct UncutPage<'a> {
    /// Name of the mold.
    pub mold: &'a str,
    /// Notes on the mold.
    pub notes: &'a [String],
    /// Comparison with other cutters.
    pub comparison: Option<&'a ComparisonReport>,
    /// Times of the steps; none where they are not known.
    pub times: &'a [StepTime],
    /// Pictures.
    pub pictures: &'a [Picture],
}

impl UncutReport {
    /// The report as one self-contained page, with the uncut segments of each class of interference.
    ///
    /// # Errors
    /// [`PageError`], which a test of the template keeps from happening.
    pub fn html(&self, interference: &[ClassTotal], shown: &UncutPage) -> Result<String, PageError> {
        const TEMPLATE: Template = Template { name: "uncut.html.jinja", text: include_str!("uncut.html.jinja") };
        #[derive(Serialize)]
        struct Page<'a> {
            report: &'a UncutReport,
            interference: &'a [ClassTotal],
            version: &'static str,
            #[serde(flatten)]
            shown: &'a UncutPage<'a>,
        }
        files::report::page(&TEMPLATE, &Page { report: self, interference, version: env!("CARGO_PKG_VERSION"), shown })
    }

    /// The report of `uncut`, with the CAD faces of the mold's triangles where its file has them.
    pub fn of(uncut: &Uncut, faces: Option<&CadFaces>) -> Self {
        let library = &uncut.params.library;
        let agreement =
            uncut.agreement.map(|[layers, field]| AgreementReport { layers, field, field_step_mm: uncut.grid_step });
        let layer = |l: &LayerFound| LayerReport { z_mm: l.z, area_mm2: l.area, segment_length_mm: l.segment_length };
        let grid = |coarser: Coarser| GridReport {
            step_mm: uncut.grid_step,
            coarser_step_mm: coarser.step,
            coarser: coarser.found,
            off_mm3: (coarser.found.volume_mm3 - uncut.found().volume_mm3).abs(),
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
            regions: regions(uncut, faces),
            grid: uncut.coarser.map(grid),
            agreement,
            ball_agreement: uncut.ball_agreement,
            layers: uncut.layers.iter().map(layer).collect(),
        }
    }

    /// The report in lines for a terminal, with `notes` on the mold.
    pub fn text(&self, notes: &[String]) -> String {
        let mut text = format!("{}\n", self.sentence);
        for note in notes {
            let _ = writeln!(text, "note: {note}");
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        if self.invert.faces > 0 {
            let InvertReport { faces, area_mm2 } = self.invert;
            let _ = writeln!(
                text,
                "{faces} undercut faces ({area_mm2:.2} mm2) are not reachable: they need another set-up or a slide."
            );
        }
        if let Some(AgreementReport { layers, field, field_step_mm }) = &self.agreement {
            let _ = writeln!(
                text,
                "Flat cutters by layers: {} regions, {:.3} mm3; by height map, step {field_step_mm:.4} mm: {} \
                 regions, {:.3} mm3.",
                layers.regions, layers.volume_mm3, field.regions, field.volume_mm3
            );
        }
        if let Some(GridReport { step_mm, coarser_step_mm, coarser, off_mm3 }) = &self.grid {
            let volume = self.regions.iter().fold(0.0, |sum, r| sum + r.volume_mm3);
            let share = if volume > 0.0 { format!(" ({:.1} %)", 100.0 * off_mm3 / volume) } else { String::new() };
            let _ = writeln!(
                text,
                "All cutters by height map, step {step_mm:.4} mm; with step {coarser_step_mm:.4} mm: {} regions, \
                 {:.3} mm3. Estimated error of the volume {off_mm3:.3} mm3{share}.",
                coarser.regions, coarser.volume_mm3
            );
        }
        if let Some(BallAgreement { places, median_mm, ninetieth_mm }) = self.ball_agreement {
            let _ = writeln!(
                text,
                "Ball cutters, height map against exact search at {places} points: median {median_mm:.4} mm, 90 % \
                 within {ninetieth_mm:.4} mm."
            );
        }
        if !self.regions.is_empty() {
            let _ = writeln!(
                text,
                "{:>4} {:>12} {:>12} {:>12} {:>10} {:>12} {:>6}   {:<40} nearest",
                "", "volume mm3", "plan mm2", "surface mm2", "height mm", "thickness mm", "faces", "at"
            );
        }
        for r in &self.regions {
            let [low, high] = r.bounds_mm;
            let at: Vec<String> = (0..3).map(|k| format!("{:.2}..{:.2}", low[k], high[k])).collect();
            let nearest = r.nearest_cutter.as_deref().unwrap_or("-");
            let (index, volume, plan, surface) = (r.index, r.volume_mm3, r.plan_area_mm2, r.surface_area_mm2);
            let (height, thickness, faces) = (r.height_mm, r.thickness_mm, r.faces.len());
            let _ = writeln!(
                text,
                "{index:>4} {volume:>12.4} {plan:>12.4} {surface:>12.3} {height:>10.3} {thickness:>12.3} \
                 {faces:>6}   {:<40} {nearest}",
                at.join(" ")
            );
            for CadFaceReport { number, face, area_mm2 } in &r.cad_faces {
                let _ = writeln!(text, "     on face {number}: {face}, {area_mm2:.3} mm2");
            }
        }
        text
    }
}

/// Regions up to so many tolerances thick are at the tolerance.
const AT_TOLERANCE: f64 = 1.5;

fn sentence(uncut: &Uncut) -> String {
    let Found { regions, volume_mm3 } = uncut.found();
    let doubt = if uncut.is_sound() { "" } else { "; see the warnings: the rest material may be larger" };
    let limit = AT_TOLERANCE * uncut.params.tolerance_mm;
    let thin = match uncut.regions.iter().filter(|r| r.thickness <= limit).count() {
        0 => String::new(),
        thin => format!(", {thin} of them no thicker than {limit:.3} mm, about the tolerance"),
    };
    let undercut = uncut.undercut().map(|faces| (counted(faces.triangles.len(), "undercut face"), faces.area));
    let undercut = undercut.map(|(faces, area)| format!("{faces} of {area:.2} mm2"));
    let found = match (regions, &undercut) {
        (0, None) => "The cutters reach everything".to_owned(),
        (0, Some(faces)) => format!("The cutters reach everything but {faces}"),
        (1, _) => format!("The cutters leave 1 region of {volume_mm3:.3} mm3{thin}"),
        _ => format!("The cutters leave {regions} regions of {volume_mm3:.3} mm3 together{thin}"),
    };
    let unreached =
        undercut.filter(|_| regions > 0).map_or_else(String::new, |faces| format!(", and do not reach {faces}"));
    let unknown = match uncut.unknown_regions() {
        0 => String::new(),
        count => format!("; whether they take {} more is not known", counted(count, "thin region")),
    };
    let slivers = match uncut.slivers() {
        0 => String::new(),
        count => format!("; slivers too thin for regions are left in {}", counted(count, "place")),
    };
    format!("{found}{unreached}{slivers}{unknown}{doubt}.")
}

fn regions(uncut: &Uncut, faces: Option<&CadFaces>) -> Vec<RegionReport> {
    let mut on_faces = on_cad_faces(uncut, faces).into_iter();
    let cutters = &uncut.params.library.cutter;
    let mut report = |(i, r): (usize, &UncutRegion)| RegionReport {
        index: i + 1,
        volume_mm3: r.volume,
        plan_area_mm2: r.plan_area,
        surface_area_mm2: r.surface_area,
        height_mm: r.depth,
        thickness_mm: r.thickness,
        bounds_mm: corners(&r.bounds, uncut.params.opening),
        faces: r.faces.clone(),
        cad_faces: on_faces.next().unwrap_or_default(),
        nearest_cutter: r.nearest_cutter.and_then(|k| cutters.get(k)).map(|c| c.label()),
    };
    uncut.regions.iter().enumerate().map(&mut report).collect()
}

/// The CAD faces that bound each region.
fn on_cad_faces(uncut: &Uncut, faces: Option<&CadFaces>) -> Vec<Vec<CadFaceReport>> {
    let Some(faces) = faces else { return Vec::new() };
    let mut areas: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); uncut.regions.len()];
    for piece in &uncut.surface {
        let (Some(areas), Some(face)) = (areas.get_mut(piece.region as usize), faces.face_of.get(piece.face as usize))
        else {
            continue;
        };
        *areas.entry(*face).or_default() += piece.area();
    }
    let report = |(face, area_mm2): (u32, f64)| {
        let words = faces.faces.get(face as usize)?.words();
        Some(CadFaceReport { number: face + 1, face: words, area_mm2 })
    };
    let listed = |areas: BTreeMap<u32, f64>| {
        let mut all: Vec<CadFaceReport> = areas.into_iter().filter_map(report).collect();
        all.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
        all
    };
    areas.into_iter().map(listed).collect()
}

/// Corners of an upright box in the axes of the mesh (mm).
fn corners(bounds: &Bounds, opening: Opening) -> [[f64; 3]; 2] {
    // To a nanometre, so that no zero has a sign.
    let ends = [bounds.min, bounds.max].map(|p| (opening.in_mesh(p) * 1e6).round() / 1e6 + 0.0);
    [ends[0].min(ends[1]).to_array(), ends[0].max(ends[1]).to_array()]
}

/// The pieces of the surface as PLY, in the axes of the mesh: every corner with the height of what is left above it
/// (`depth`, mm), every triangle with its region, counted from 1, and the triangle of the mesh that it is of, counted
/// from 0.
pub fn surface_as_ply(pieces: &[SurfacePiece], opening: Opening) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment sparkpath: what cutters leave uncut, mm\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nproperty float depth\n\
         element face {}\nproperty list uchar int vertex_indices\nproperty int region\nproperty int face\nend_header\n",
        3 * pieces.len(),
        pieces.len()
    )
    .into_bytes();
    for piece in pieces {
        for (p, depth) in piece.corners.iter().zip(piece.depth) {
            let [x, y, z] = opening.in_mesh(*p).as_vec3().to_array();
            [x, y, z, depth].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
    }
    for (i, piece) in pieces.iter().enumerate() {
        let first = 3 * i as i32;
        bytes.push(3);
        let numbers = [first, first + 1, first + 2, piece.region as i32 + 1, piece.face as i32];
        numbers.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn every_piece_has_its_corners_its_region_and_its_face() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let pieces = [SurfacePiece { corners, face: 7, region: 2, depth: [0.5, 1.0, 1.5] }];
        let bytes = surface_as_ply(&pieces, Opening::PlusX);
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.contains("element vertex 3\n") && header.contains("element face 1\n"), "{header}");
        let body = &bytes[end..];
        assert_eq!(body.len(), 3 * 16 + 1 + 5 * 4);
        let vertex: Vec<f32> = body[..16].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        let in_mesh = Opening::PlusX.in_mesh(DVec3::X).as_vec3();
        assert_eq!(vertex, [in_mesh.x, in_mesh.y, in_mesh.z, 0.5]);
        let numbers: Vec<i32> = body[49..].chunks(4).map(|b| i32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!((body[48], numbers), (3, vec![0, 1, 2, 3, 7]));
    }
}
