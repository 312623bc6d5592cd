//! Faces of an electrode that the flank of a cutter could mill.

use glam::DVec3;
use rayon::prelude::*;

use super::patch::mean_normal;
use super::{RuledFit, RuledFitError, RuledFitParams, fit_ruled};
use geometry::mesh::Mesh;
use geometry::segmentation::{EdgeKind, FaceKind, Segmentation, SegmentationSettings};
use task::Cancel;

/// Faces that are fitted at most, the largest.
const MOST_FITTED: usize = 40;
/// Share of the mesh's area below which a face is not fitted.
const LEAST_SHARE: f64 = 2e-3;

/// The form of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CandidateKind {
    /// One plane.
    Plane,
    /// One circular cylinder.
    Cylinder,
    /// One circular cone.
    Cone,
    /// One face of any other form.
    FreeForm,
    /// Faces that go over into each other smoothly.
    Joined,
}

impl CandidateKind {
    /// Name in lists.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::FreeForm => "free form",
            Self::Joined => "joined faces",
        }
    }
}

/// Result of the fit of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum CandidateFit {
    /// The surface, ruled within the tolerance or not.
    Fitted(Box<RuledFit>),
    /// Reason why there is none.
    Refused(RuledFitError),
    /// Too small a face to be looked at.
    NotTried,
}

/// A face, or several that were joined, which a flank could mill.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Numbers of its faces in the segmentation.
    pub faces: Vec<u32>,
    /// Triangles, rising.
    pub triangles: Vec<u32>,
    /// Form.
    pub kind: CandidateKind,
    /// Area (mm^2).
    pub area_mm2: f64,
    /// Extent along the direction that is up (mm).
    pub height_mm: f64,
    /// Mean of its normals, outwards: where the tool stands; zero all around a ring.
    pub outwards: DVec3,
    /// The fit.
    pub fit: CandidateFit,
}

impl Candidate {
    /// Whether it is ruled within the tolerance.
    pub fn is_ruled(&self) -> bool {
        matches!(&self.fit, CandidateFit::Fitted(fit) if fit.is_ruled)
    }

    /// Whether it is ruled within the tolerance and the surface covers all of it.
    pub fn is_millable(&self) -> bool {
        matches!(&self.fit, CandidateFit::Fitted(fit) if fit.is_ruled && fit.covers)
    }

    /// One line for a list.
    pub fn summary(&self) -> String {
        let fit = match &self.fit {
            CandidateFit::Fitted(fit) => {
                let words = fit.words.first().cloned().unwrap_or_default();
                if fit.covers { words } else { format!("{words}; the surface does not cover all of it") }
            }
            CandidateFit::Refused(error) => error.to_string(),
            CandidateFit::NotTried => "too small to be tried".to_owned(),
        };
        format!("{}, {:.2} mm2, {:.2} mm high: {fit}", self.kind.name(), self.area_mm2, self.height_mm)
    }
}

/// The faces of `mesh`, and groups of those that stand up and go over into each other smoothly, with the ruled surfaces
/// fitted to them; the largest first, planes that lie last. Of a part on a base
/// ([`RuledFitParams::stands_on_base`]) those above it come first.
///
/// # Errors
/// If a parameter has no meaning, or it was told to stop.
pub fn flank_candidates(
    mesh: &Mesh,
    params: &RuledFitParams,
    cancel: &Cancel,
) -> Result<Vec<Candidate>, RuledFitError> {
    params.validate()?;
    cancel.check()?;
    let up = params.up.normalize_or_zero();
    let segmentation = Segmentation::of(mesh, &SegmentationSettings::default());
    let single = (0..segmentation.faces.len() as u32).map(|f| vec![f]);
    let groups = joined(mesh, &segmentation, up);
    let total: f64 = segmentation.faces.iter().map(|f| f.area).sum();
    let mut found: Vec<Candidate> =
        single.chain(groups).map(|faces| candidate(mesh, &segmentation, faces, up)).collect();
    found.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2).then_with(|| a.faces.cmp(&b.faces)));
    let tried = found.iter().take(MOST_FITTED).take_while(|c| c.area_mm2 >= LEAST_SHARE * total).count();
    found[..tried].par_iter_mut().for_each(|c| {
        c.fit = match fit_ruled(mesh, &c.triangles, params, cancel) {
            Ok(fit) => CandidateFit::Fitted(Box::new(fit)),
            Err(error) => CandidateFit::Refused(error),
        };
    });
    cancel.check()?;
    let standing = Standing::of(mesh, params);
    found.sort_by_key(|candidate| standing.rank(candidate));
    Ok(found)
}

/// Order of candidates, whatever their size.
struct Standing<'a> {
    mesh: &'a Mesh,
    up: DVec3,
    /// Height up to which a face begins at the bottom of the part (mm); none if that does not matter.
    bottom_mm: Option<f64>,
}

impl<'a> Standing<'a> {
    /// Share of the part's height within which a face begins at its bottom.
    const NEAR: f64 = 1e-3;
    /// How nearly a plane's normal points up or down (cosine) if the plane lies: the side of a cutter mills none such.
    const LIES: f64 = 0.99;

    fn of(mesh: &'a Mesh, params: &RuledFitParams) -> Self {
        let up = params.up.normalize_or_zero();
        let heights = mesh.vertices.iter().map(|p| p.dot(up)).filter(|h| h.is_finite());
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        Self { mesh, up, bottom_mm: params.stands_on_base.then_some(low + Self::NEAR * (high - low)) }
    }

    /// The less the earlier: of a part on a base the flanks above it that can be milled, then its others; what lies
    /// comes last.
    fn rank(&self, candidate: &Candidate) -> u8 {
        if candidate.kind == CandidateKind::Plane && candidate.outwards.dot(self.up).abs() > Self::LIES {
            return 3;
        }
        let Some(bottom_mm) = self.bottom_mm else { return 0 };
        let corners = candidate.triangles.iter().filter_map(|&t| self.mesh.triangles.get(t as usize)).flatten();
        let heights = corners.filter_map(|&v| self.mesh.vertices.get(v as usize)).map(|p| p.dot(self.up));
        let is_above = heights.fold(f64::INFINITY, f64::min) > bottom_mm;
        match (is_above, candidate.is_millable()) {
            (true, true) => 0,
            (true, false) => 1,
            (false, _) => 2,
        }
    }
}

/// Groups of two faces or more that stand up, joined over smooth edges.
fn joined(mesh: &Mesh, segmentation: &Segmentation, up: DVec3) -> Vec<Vec<u32>> {
    let count = segmentation.faces.len();
    let stands = |f: usize| {
        let face = &segmentation.faces[f];
        match face.kind {
            FaceKind::Plane { normal, .. } => normal.dot(up).abs() < 0.7,
            FaceKind::Cylinder { direction, .. } => direction.dot(up).abs() > 0.7,
            FaceKind::Cone { axis, half_angle, .. } => axis.dot(up).abs() > 0.7 && half_angle < 0.8,
            FaceKind::FreeForm => mean_normal(mesh, &face.triangles).dot(up).abs() < 0.7,
        }
    };
    let stands: Vec<bool> = (0..count).map(stands).collect();
    let mut group: Vec<usize> = (0..count).collect();
    let root = |group: &[usize], mut f: usize| {
        while group[f] != f {
            f = group[f];
        }
        f
    };
    for edge in segmentation.edges.iter().filter(|e| e.kind == EdgeKind::Smooth) {
        let [a, b] = edge.faces.map(|f| f as usize);
        if stands[a] && stands[b] {
            let (a, b) = (root(&group, a), root(&group, b));
            group[a.max(b)] = a.min(b);
        }
    }
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); count];
    (0..count).for_each(|f| members[root(&group, f)].push(f as u32));
    members.retain(|m| m.len() >= 2);
    members
}

fn candidate(mesh: &Mesh, segmentation: &Segmentation, faces: Vec<u32>, up: DVec3) -> Candidate {
    let of = |f: &u32| &segmentation.faces[*f as usize];
    let mut triangles: Vec<u32> = faces.iter().flat_map(|f| of(f).triangles.iter().copied()).collect();
    triangles.sort_unstable();
    let kind = match (&faces[..], faces.first().map(|f| of(f).kind)) {
        ([_], Some(FaceKind::Plane { .. })) => CandidateKind::Plane,
        ([_], Some(FaceKind::Cylinder { .. })) => CandidateKind::Cylinder,
        ([_], Some(FaceKind::Cone { .. })) => CandidateKind::Cone,
        ([_], _) => CandidateKind::FreeForm,
        _ => CandidateKind::Joined,
    };
    let corners = triangles.iter().filter_map(|&t| mesh.triangles.get(t as usize)).flatten();
    let heights = corners.filter_map(|&v| mesh.vertices.get(v as usize)).map(|p| p.dot(up)).filter(|h| h.is_finite());
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    Candidate {
        area_mm2: faces.iter().map(|f| of(f).area).sum(),
        height_mm: (high - low).max(0.0),
        outwards: mean_normal(mesh, &triangles),
        faces,
        triangles,
        kind,
        fit: CandidateFit::NotTried,
    }
}
