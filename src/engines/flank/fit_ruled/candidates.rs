//! Faces of an electrode that the flank of a cutter could mill.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::patch::mean_normal;
use super::{RuledFit, RuledFitError, RuledFitParams, fit_ruled, known_ruled};
use geometry::mesh::Mesh;
use geometry::segmentation::{EdgeKind, FaceKind, Segmentation, SegmentationSettings};
use task::Task;

/// Faces that are fitted at most, the largest.
const MOST_FITTED: usize = 40;
/// Share of the mesh's area below which a face is not fitted.
const LEAST_SHARE: f64 = 2e-3;
/// How much the normal of what stands may point up or down (cosine).
const STANDS: f64 = 0.7;

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
/// fitted to them; the largest first, planes that lie last. Of a part with a base ([`RuledFitParams::base`]) those that are
/// clear of it come first.
///
/// # Errors
/// If a parameter has no meaning, or it was told to stop.
pub fn flank_candidates(mesh: &Mesh, params: &RuledFitParams, task: &Task) -> Result<Vec<Candidate>, RuledFitError> {
    task.check()?;
    let faces = Segmentation::find(mesh, &SegmentationSettings::default(), &task.cancel)?;
    candidates_among(mesh, &faces, params, task)
}

/// [`flank_candidates`] among faces that are known, those of a CAD program for instance.
///
/// # Errors
/// If a parameter has no meaning, or it was told to stop.
pub fn candidates_among(
    mesh: &Mesh,
    segmentation: &Segmentation,
    params: &RuledFitParams,
    task: &Task,
) -> Result<Vec<Candidate>, RuledFitError> {
    const STAGE: &str = "faces that could be milled";
    params.validate()?;
    task.check()?;
    task.report(STAGE, 0.0, "");
    let up = params.up.normalize_or_zero();
    let single = (0..segmentation.faces.len() as u32).map(|f| vec![f]);
    let groups = joined(mesh, segmentation, up);
    let total: f64 = segmentation.faces.iter().map(|f| f.area).sum();
    let mut found: Vec<Candidate> =
        single.chain(groups).map(|faces| candidate(mesh, segmentation, faces, up)).collect();
    found.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2).then_with(|| a.faces.cmp(&b.faces)));
    let tried = found.iter().take(MOST_FITTED).take_while(|c| c.area_mm2 >= LEAST_SHARE * total).count();
    let fitted = AtomicUsize::new(0);
    found[..tried].par_iter_mut().for_each(|c| {
        let known = match &c.faces[..] {
            [face] => segmentation.faces[*face as usize].known.as_ref(),
            _ => None,
        };
        let guides = known.map_or(&[][..], |known| &known.guides);
        let known = known_ruled(mesh, &c.triangles, guides, params, &task.cancel).ok().flatten();
        let fit = known.map_or_else(|| fit_ruled(mesh, &c.triangles, params, &task.cancel), Ok);
        c.fit = match fit {
            Ok(fit) => CandidateFit::Fitted(Box::new(fit)),
            Err(error) => CandidateFit::Refused(error),
        };
        let count = fitted.fetch_add(1, Ordering::Relaxed) + 1;
        task.report(STAGE, count as f64 / tried as f64, &format!("{count} of {tried}"));
    });
    task.check()?;
    let standing = Standing::of(mesh, params);
    found.sort_by_key(|candidate| standing.rank(candidate));
    Ok(found)
}

/// Order of candidates, whatever their size.
struct Standing<'a> {
    mesh: &'a Mesh,
    up: DVec3,
    /// Direction to the base of the part, and the coordinate along it up to which a face is clear of the base (mm).
    base: Option<(DVec3, f64)>,
}

impl<'a> Standing<'a> {
    /// Share of the part's length within which a face ends at a place.
    const NEAR: f64 = 1e-3;
    /// How nearly a plane's normal points up or down, or to the base (cosine), if the plane lies or is an end: the side of
    /// a cutter mills none such.
    const LIES: f64 = 0.99;

    fn of(mesh: &'a Mesh, params: &RuledFitParams) -> Self {
        let base = params.base.map(|base| {
            let towards = base.towards.normalize_or_zero();
            let along = mesh.vertices.iter().map(|p| p.dot(towards)).filter(|x| x.is_finite());
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let near = Self::NEAR * (high - low);
            (towards, base.from_mm.map_or(high - near, |from| from + near))
        });
        Self { mesh, up: params.up.normalize_or_zero(), base }
    }

    /// The less the earlier: of a part with a base the standing flanks clear of it that can be milled, then its other
    /// flanks that stand, those that lean, and the base; what lies comes last.
    fn rank(&self, candidate: &Candidate) -> u8 {
        let is_along = |direction: DVec3| candidate.outwards.dot(direction).abs() > Self::LIES;
        let is_end = is_along(self.up) || self.base.is_some_and(|(towards, _)| is_along(towards));
        if candidate.kind == CandidateKind::Plane && is_end {
            return 4;
        }
        let Some((towards, clear)) = self.base else { return 0 };
        let corners = candidate.triangles.iter().filter_map(|&t| self.mesh.triangles.get(t as usize)).flatten();
        let along = corners.filter_map(|&v| self.mesh.vertices.get(v as usize)).map(|p| p.dot(towards));
        let is_clear = along.fold(f64::NEG_INFINITY, f64::max) < clear;
        let stands = candidate.outwards.dot(self.up).abs() < STANDS;
        match (is_clear, stands, candidate.is_millable()) {
            (true, true, true) => 0,
            (true, true, false) => 1,
            (true, false, _) => 2,
            (false, ..) => 3,
        }
    }
}

/// Groups of two faces or more that stand up, joined over smooth edges.
fn joined(mesh: &Mesh, segmentation: &Segmentation, up: DVec3) -> Vec<Vec<u32>> {
    let count = segmentation.faces.len();
    let stands = |f: usize| {
        let face = &segmentation.faces[f];
        match face.kind {
            FaceKind::Plane { normal, .. } => normal.dot(up).abs() < STANDS,
            FaceKind::Cylinder { direction, .. } => direction.dot(up).abs() > 0.7,
            FaceKind::Cone { axis, half_angle, .. } => axis.dot(up).abs() > 0.7 && half_angle < 0.8,
            FaceKind::Sphere { .. } | FaceKind::Torus { .. } | FaceKind::FreeForm => {
                mean_normal(mesh, &face.triangles).dot(up).abs() < STANDS
            }
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
