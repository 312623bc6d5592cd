//! The only door to an NC program: a path together with a certificate that holds for exactly this path and
//! exactly the meshes it is exported with.

use feed::certificate::{Certificate, TravelVerdict};
use feed::copying::CopyingMotion;
use feed::machine::BeyondTravel;
use feed::machine_model::MachineModel;
use feed::path::FeedPath;
use feed::pose::Pose;
use feed::preset::Preset;
use feed::quantise::first_unquantised_row;
use feed::simulation::Simulation;
use geometry::mesh::{Bounds, Mesh};
use wheel::electrode::EntrySide;

/// A path that may be exported as NC. It can only be made by [`Approved::new`], and nobody can change it.
///
/// ```compile_fail,E0616
/// use wheel::electrode::EntrySide;
/// fn flipped(mut approved: nc::approved::Approved) {
///     approved.enters_from = EntrySide::PlusX;
/// }
/// ```
///
/// Nor does a program let its caller say how the machine is turned:
///
/// ```compile_fail,E0560
/// use nc::program::NcJob;
/// fn flipped<'a>(machine: &'a feed::machine::MachineParams) -> NcJob<'a> {
///     NcJob { program: "path_1", electrode_file: "electrode_1.stl", machine, notes: &[], is_turned: true }
/// }
/// ```
///
/// ```compile_fail,E0308
/// use nc::program::{NcJob, NcProgram, NcSettings};
/// use nc::post::Post;
/// fn unapproved(path: &feed::path::FeedPath, post: &Post, job: &NcJob) {
///     let _ = NcProgram::new(path, post, &NcSettings::default(), job);
/// }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Approved {
    path: FeedPath,
    certificate: Certificate,
    enters_from: EntrySide,
    electrode: Bounds,
    preset: Option<Preset>,
    copying: Option<CopyingMotion>,
    simulation: Option<Simulation>,
}

/// Reason why a path cannot be exported as NC.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotApproved {
    /// The certificate belongs to another path.
    #[error("the certificate belongs to another path; verify this path")]
    OtherPath,
    /// The certificate belongs to another blisk.
    #[error("the certificate belongs to another blisk than the one at hand; verify the path against this blisk")]
    OtherBlisk,
    /// The certificate belongs to another electrode.
    #[error(
        "the certificate belongs to another electrode than the one to be exported; verify the path with this electrode"
    )]
    OtherElectrode,
    /// The certificate was made for another spark gap.
    #[error(
        "the certificate asks for {required} mm of clearance but the path for a spark gap of {spark_gap} mm; \
             verify the path with its own gap"
    )]
    OtherGap {
        /// Clearance of the certificate (mm).
        required: f64,
        /// Spark gap of the path (mm).
        spark_gap: f64,
    },
    /// The path does not lead from outside the blisk to the final pose.
    #[error("the path does not lead from wholly outside the blisk to the final pose")]
    WrongEnds,
    /// The proven clearance is too small.
    #[error(
        "the clearance is proven to be at least {certified:.5} mm only, where {required:.5} mm less {tolerance:.5} mm \
             are needed; the least clearance is near row {row:.2} (s = {s:.3} mm)"
    )]
    TooClose {
        /// Proven clearance (mm).
        certified: f64,
        /// Clearance required (mm).
        required: f64,
        /// Tolerance of the verification (mm).
        tolerance: f64,
        /// Row of the least clearance; a fraction is a share of the motion to the next row.
        row: f64,
        /// Withdrawn distance of the least clearance (mm).
        s: f64,
    },
    /// The path leaves the travel of an axis.
    #[error("{0}; plan for the machine's travel, or correct its limits, and verify again")]
    BeyondTravel(BeyondTravel),
    /// The simulation of the whole motion found a collision.
    #[error("{0}")]
    Collides(String),
    /// The simulation was made with another object, which is named.
    #[error("the whole motion was simulated with another {0} than the one at hand; plan and simulate again")]
    OtherSimulated(&'static str),
    /// The travel of the axes was not judged.
    #[error("the travel of the axes was not judged; verify the path for the machine that it is exported for")]
    TravelNotJudged,
    /// A row is not rounded to the decimals of files.
    #[error(
        "row {row} was not rounded to the decimals of files before it was verified; round the path and verify again"
    )]
    NotQuantised {
        /// Row, from 0.
        row: usize,
    },
}

impl Approved {
    /// Approves `path` on the strength of `certificate`, for the `blisk` at hand and the `electrode` that it is
    /// exported with, in its final pose; both meshes in W.
    ///
    /// # Errors
    /// [`NotApproved`] unless the certificate holds, proves a clearance above zero and axes within their travel, and
    /// was made for this very path with this path's spark gap and for these very meshes, and the path is rounded as
    /// files are.
    pub fn new(path: FeedPath, certificate: Certificate, blisk: &Mesh, electrode: &Mesh) -> Result<Self, NotApproved> {
        let c = &certificate;
        if c.path_digest() != path.digest() || c.row_clearance().len() != path.rows.len() {
            return Err(NotApproved::OtherPath);
        }
        if c.blisk_digest() != blisk.digest() {
            return Err(NotApproved::OtherBlisk);
        }
        if c.electrode_digest() != electrode.digest() {
            return Err(NotApproved::OtherElectrode);
        }
        if c.required().is_nan() || c.required() < path.spark_gap {
            return Err(NotApproved::OtherGap { required: c.required(), spark_gap: path.spark_gap });
        }
        let enters_from = c.enters_from().ok_or(NotApproved::WrongEnds)?;
        if !c.ends_right() || path.rows.len() < 2 || path.rows.last().map(|r| r.pose) != Some(Pose::FINAL) {
            return Err(NotApproved::WrongEnds);
        }
        if !c.keeps_clearance() {
            let (row, s) = (c.least().row, c.least().s);
            let (certified, required, tolerance) = (c.certified(), c.required(), c.tolerance());
            return Err(NotApproved::TooClose { certified, required, tolerance, row, s });
        }
        match c.travel() {
            TravelVerdict::Within => {}
            TravelVerdict::Beyond(beyond) => return Err(NotApproved::BeyondTravel(beyond)),
            TravelVerdict::NotJudged => return Err(NotApproved::TravelNotJudged),
        }
        if let Some(row) = first_unquantised_row(&path) {
            return Err(NotApproved::NotQuantised { row });
        }
        let electrode = electrode.bounds();
        Ok(Self { path, certificate, enters_from, electrode, preset: None, copying: None, simulation: None })
    }

    /// Approval with the copying motion that is to follow the feed, and without a simulation: one with this motion is
    /// to be given afterwards.
    ///
    /// # Errors
    /// [`NotApproved`] unless it is certified from the final pose back to the final pose, for the very meshes, the
    /// reference point and the spark gap of the path, with axes within their travel, and is rounded as files are.
    pub fn with_copying(self, motion: &CopyingMotion) -> Result<Self, NotApproved> {
        let (c, mine, copying) = (&motion.certificate, &self.certificate, &motion.path);
        let same_place = copying.reference_point == self.path.reference_point && copying.frame == self.path.frame;
        if c.path_digest() != copying.digest() || !same_place {
            return Err(NotApproved::OtherPath);
        }
        if c.blisk_digest() != mine.blisk_digest() {
            return Err(NotApproved::OtherBlisk);
        }
        if c.electrode_digest() != mine.electrode_digest() {
            return Err(NotApproved::OtherElectrode);
        }
        if c.required().is_nan() || c.required() < self.path.spark_gap {
            return Err(NotApproved::OtherGap { required: c.required(), spark_gap: self.path.spark_gap });
        }
        if let TravelVerdict::Beyond(beyond) = c.travel() {
            return Err(NotApproved::BeyondTravel(beyond));
        }
        if c.travel() == TravelVerdict::NotJudged {
            return Err(NotApproved::TravelNotJudged);
        }
        if !c.keeps_clearance() {
            let (row, s) = (c.least().row, c.least().s);
            let (certified, required, tolerance) = (c.certified(), c.required(), c.tolerance());
            return Err(NotApproved::TooClose { certified, required, tolerance, row, s });
        }
        if !motion.holds() {
            return Err(NotApproved::WrongEnds);
        }
        if let Some(row) = first_unquantised_row(copying) {
            return Err(NotApproved::NotQuantised { row });
        }
        // What was simulated before knows nothing of it.
        Ok(Self { copying: Some(motion.clone()), simulation: None, ..self })
    }

    /// Approval of the feed of an electrode that stands on its holder as `preset` says.
    #[must_use]
    pub fn with_preset(self, preset: Option<&Preset>) -> Self {
        // What was simulated before may stand otherwise.
        Self { preset: preset.copied(), simulation: None, ..self }
    }

    /// Approval with the whole motion on the machine `model`, approach and retraction and the other channels included.
    ///
    /// # Errors
    /// [`NotApproved`] unless it is that of this very feed and copying motion, of these very meshes, and of these very
    /// bodies of the machine, and nothing comes too close or goes beyond the travel of the axes.
    pub fn with_simulation(self, simulation: &Simulation, model: &MachineModel) -> Result<Self, NotApproved> {
        let (s, c) = (simulation, &self.certificate);
        let copying = self.copying.as_ref().map(|motion| motion.path.digest());
        let same = [
            ("path", s.path_digest() == c.path_digest()),
            ("copying motion", s.copying_digest() == copying.as_deref()),
            ("blisk", s.blisk_digest() == c.blisk_digest()),
            ("electrode", s.electrode_digest() == c.electrode_digest()),
            ("machine", s.model_digest() == model.digest()),
            ("preset", s.preset() == self.preset.as_ref()),
            ("side of entry", s.enters_from() == self.enters_from),
        ];
        if let Some((what, _)) = same.into_iter().find(|(_, is_same)| !is_same) {
            return Err(NotApproved::OtherSimulated(what));
        }
        if !simulation.holds() {
            return Err(NotApproved::Collides(simulation.sentence()));
        }
        Ok(Self { simulation: Some(simulation.clone()), ..self })
    }

    /// The whole motion on the machine, if it was simulated.
    pub fn simulation(&self) -> Option<&Simulation> {
        self.simulation.as_ref()
    }

    /// The approved copying motion, from the final pose back to it, if there is one.
    pub fn copying(&self) -> Option<&CopyingMotion> {
        self.copying.as_ref()
    }

    /// The box around the electrode in its final pose, in W (mm).
    pub fn electrode_bounds(&self) -> &Bounds {
        &self.electrode
    }

    /// The approved path.
    pub fn path(&self) -> &FeedPath {
        &self.path
    }

    /// The side of the blisk, in W, that the electrode enters from, as the verifier found it: what the machine is
    /// turned by.
    pub fn enters_from(&self) -> EntrySide {
        self.enters_from
    }

    /// The certificate it was approved on.
    pub fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;
    use crate::fixtures::Scene;
    use feed::machine::TravelLimits;
    use feed::pose::Axis;
    use feed::verify::VerifyOptions;

    /// Reason why `path` is not approved on the strength of `certificate`, for the meshes of the scene.
    fn refused(scene: &Scene, path: &FeedPath, certificate: Certificate) -> NotApproved {
        Approved::new(path.clone(), certificate, &scene.blisk, &scene.electrode).unwrap_err()
    }

    fn changed(change: impl Fn(&mut FeedPath)) -> FeedPath {
        let mut path = fixtures::path();
        change(&mut path);
        path
    }

    #[test]
    fn a_certificate_that_holds_approves_its_own_path_only() {
        let path = fixtures::path();
        assert_eq!(fixtures::approved().path(), &path);
        let refused = |change: &dyn Fn(&mut FeedPath)| {
            refused(&Scene::new(EntrySide::MinusX), &changed(change), fixtures::certificate(&path))
        };
        let one_bit = |x: f64| f64::from_bits(x.to_bits() + 1);
        assert_eq!(refused(&|p| p.rows[3].pose.y = one_bit(p.rows[3].pose.y)), NotApproved::OtherPath);
        assert_eq!(refused(&|p| p.reference_point.z += 1e-9), NotApproved::OtherPath);
        assert_eq!(refused(&|p| p.rows.truncate(5)), NotApproved::OtherPath);
        assert_eq!(refused(&|p| p.rows.swap(5, 6)), NotApproved::OtherPath);
        assert_eq!(refused(&|p| p.spark_gap = 0.05), NotApproved::OtherPath, "its gap is part of a path");
    }

    #[test]
    fn a_certificate_approves_for_its_own_meshes_only() {
        let path = fixtures::path();
        let (blisk, electrode) = (fixtures::blisk_mesh(), fixtures::electrode_mesh());
        let approve = |blisk: &Mesh, electrode: &Mesh| {
            Approved::new(path.clone(), fixtures::certificate(&path), blisk, electrode).map(|_| ())
        };
        let other = |mesh: &Mesh| {
            let mut mesh = mesh.clone();
            mesh.vertices[0].x = f64::from_bits(mesh.vertices[0].x.to_bits() + 1);
            mesh
        };
        assert_eq!(approve(&blisk, &electrode), Ok(()));
        assert_eq!(approve(&other(&blisk), &electrode), Err(NotApproved::OtherBlisk));
        assert_eq!(approve(&blisk, &other(&electrode)), Err(NotApproved::OtherElectrode));
        assert_eq!(approve(&electrode, &blisk), Err(NotApproved::OtherBlisk));
    }

    #[test]
    fn a_certificate_that_does_not_hold_approves_nothing() {
        let (scene, path) = (Scene::new(EntrySide::MinusX), fixtures::path());
        // The wall 6 micrometres nearer, where 5 are allowed, and through the electrode.
        for (nearer, certified) in [(0.006, 0.0972), (5.0, 0.0)] {
            let close = scene.with_wall_nearer_by(nearer);
            let error = refused(&close, &path, close.certificate(&path));
            let NotApproved::TooClose { certified: found, required, tolerance, .. } = error else { panic!("{error}") };
            assert!((found - certified).abs() < 0.0006 && (required, tolerance) == (0.1, 0.002), "{found}");
        }
        // A tolerance that would make it good is none that a certificate is made with.
        let generous = VerifyOptions { tolerance_mm: 0.05, ..VerifyOptions::default() };
        assert!(scene.verified(&path, &generous, Some(TravelLimits::UNLIMITED)).is_err());

        let inside = changed(|p| drop(p.rows.drain(..60)));
        assert_eq!(refused(&scene, &inside, scene.certificate(&inside)), NotApproved::WrongEnds);
        let short = changed(|p| p.rows.truncate(120));
        assert_eq!(refused(&scene, &short, scene.certificate(&short)), NotApproved::WrongEnds);

        let judged = |travel| scene.verified(&path, &VerifyOptions::default(), travel).unwrap();
        assert_eq!(refused(&scene, &path, judged(None)), NotApproved::TravelNotJudged);
        let beyond = judged(Some(TravelLimits::UNLIMITED.with(Axis::C, [-1.0, 0.3])));
        let TravelVerdict::Beyond(first) = beyond.travel() else { panic!("{beyond:?}") };
        assert_eq!((first.axis, first.limit), (Axis::C, 0.3));
        assert_eq!(refused(&scene, &path, beyond), NotApproved::BeyondTravel(first));
    }

    #[test]
    fn a_path_must_be_rounded_before_it_is_verified() {
        let scene = Scene::new(EntrySide::MinusX);
        let path = changed(|p| p.rows[9].pose.a += 1e-10);
        assert_eq!(refused(&scene, &path, scene.certificate(&path)), NotApproved::NotQuantised { row: 9 });
    }

    #[test]
    fn the_side_of_entry_is_the_one_that_was_verified() {
        for side in [EntrySide::MinusX, EntrySide::PlusX] {
            assert_eq!(Scene::new(side).approved().enters_from(), side);
        }
    }
}
