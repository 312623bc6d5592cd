//! A box that is fed past a wall, with its certificate, copying motion and simulation, all of them really verified, and a
//! made-up report: for the tests of this floor.

use std::sync::OnceLock;

use glam::DVec3;
use task::{Cancel, Progress};

use super::approved::Approved;
use super::choice::MeshFrame;
use super::quantise::quantise_path;
use super::report::*;
use crate::blisk::channel::Surface;
use crate::blisk::electrode::{Electrode, ElectrodeFace, EntrySide};
use crate::feed::certificate::Certificate;
use crate::feed::copying::{CopyingExtent, CopyingMotion, Turn};
use crate::feed::machine::{MachineParams, TravelLimits};
use crate::feed::machine_model::MachineModel;
use crate::feed::path::{FeedPath, PathRow};
use crate::feed::pose::{Axis, Pose};
use crate::feed::simulation::{Scenario, Simulation, SimulationOptions, simulate};
use crate::feed::smoothness::AxisSmoothness;
use crate::feed::verify::{Verifier, VerifyError, VerifyOptions};
use crate::geometry::frame::Frame;
use crate::geometry::mesh::tests::cuboid;
use crate::geometry::mesh::{Bounds, Mesh};

/// A five-axis path of 121 rows over 60 mm, rounded, in a turned and shifted frame. It enters from -X.
pub(crate) fn path() -> FeedPath {
    Scene::new(EntrySide::MinusX).path
}

/// The certificate of `path` in the scene from -X: of [`path`] it holds, and its least clearance of 0.1032 mm is 3 mm before
/// the final pose.
pub(crate) fn certificate(path: &FeedPath) -> Certificate {
    static OF_PATH: OnceLock<Certificate> = OnceLock::new();
    let scene = Scene::new(EntrySide::MinusX);
    if *path == scene.path {
        return OF_PATH.get_or_init(|| scene.certificate(&scene.path)).clone();
    }
    scene.certificate(path)
}

/// The box around the electrode of [`path`], in W.
pub(crate) fn electrode_bounds() -> Bounds {
    Bounds { min: DVec3::new(-18.0, -9.0, 88.0), max: DVec3::new(20.0, 11.0, 131.0) }
}

/// The wall that the electrode is fed past.
pub(crate) fn blisk_mesh() -> Mesh {
    Scene::new(EntrySide::MinusX).blisk
}

/// An electrode that fills [`electrode_bounds`].
pub(crate) fn electrode_mesh() -> Mesh {
    Scene::new(EntrySide::MinusX).electrode
}

/// [`path`] approved on its [`certificate`].
pub(crate) fn approved() -> Approved {
    let path = path();
    let certificate = certificate(&path);
    Approved::new(path, certificate, &blisk_mesh(), &electrode_mesh()).unwrap()
}

/// A wall, a box and the path of the box past it; from +X all of it is turned by half a turn about Z.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) side: EntrySide,
    pub(crate) blisk: Mesh,
    pub(crate) electrode: Mesh,
    pub(crate) path: FeedPath,
}

/// Number of channels, the one of the path, and the turn from one to the next (deg).
pub(crate) const CHANNELS: usize = 12;
pub(crate) const OWN_CHANNEL: usize = 3;
pub(crate) const PITCH_DEG: f64 = 30.0;

/// Where the wall's face is (mm): the box comes to 0.1032 mm from it, 3 mm before the final pose.
const WALL_Y: f64 = -9.2186;

fn row(pose: Pose) -> PathRow {
    PathRow { node: 0, s: 0.0, pose }
}

impl Scene {
    pub(crate) fn new(side: EntrySide) -> Self {
        let rows = (0..=120).rev().map(|i| {
            let s = i as f64 * 0.5;
            let t = s / 60.0;
            let pose = Pose {
                x: -s,
                y: 6.0 * t * t * (1.0 - 0.4 * t),
                z: 1.3 * (2.2 * t).sin() * t,
                a: (0.11 * s).sin() * 0.004 - 0.21 * t * t,
                b: 0.0,
                c: 0.38 * t * t - 0.05 * t,
            };
            PathRow { node: i / 4, s, pose }
        });
        let path = FeedPath {
            frame: Frame::from_x_and_z_hint(DVec3::new(0.1, -2.0, 33.3), DVec3::new(0.3, 0.9, -0.2), DVec3::Z),
            reference_point: DVec3::new(1.25, 0.0, 117.0 / 7.0),
            spark_gap: 0.1,
            rows: rows.collect(),
        };
        let Bounds { min, max } = electrode_bounds();
        let wall = cuboid(DVec3::new(60.0, 5.0, 60.0)).mapped(|p| p + DVec3::new(-30.0, WALL_Y - 5.0, 80.0));
        let electrode = cuboid(max - min).mapped(|p| p + min);
        let from_minus = Self { side: EntrySide::MinusX, blisk: wall, electrode, path: quantise_path(&path) };
        if side == EntrySide::MinusX { from_minus } else { from_minus.turned() }
    }

    /// The same turned by half a turn about Z.
    fn turned(self) -> Self {
        let turned = |p: DVec3| DVec3::new(-p.x, -p.y, p.z);
        let pose = |p: Pose| Pose { x: -p.x, y: -p.y, a: -p.a, b: -p.b, ..p };
        let rows = self.path.rows.iter().map(|row| PathRow { pose: pose(row.pose), ..*row }).collect();
        let path = FeedPath { reference_point: turned(self.path.reference_point), rows, ..self.path };
        let [blisk, electrode] = [self.blisk, self.electrode].map(|mesh| mesh.mapped(turned));
        // Zeros are without a sign in files.
        Self { side: EntrySide::PlusX, blisk, electrode, path: quantise_path(&path) }
    }

    /// The same with the wall nearer to the electrode by `by` (mm).
    pub(crate) fn with_wall_nearer_by(&self, by: f64) -> Self {
        let by = if self.side == EntrySide::MinusX { by } else { -by };
        Self { blisk: self.blisk.mapped(|p| p + by * DVec3::Y), ..self.clone() }
    }

    /// What the verifier says of `path` in this scene.
    pub(crate) fn verified(
        &self,
        path: &FeedPath,
        options: &VerifyOptions,
        travel: Option<TravelLimits>,
    ) -> Result<Certificate, VerifyError> {
        let verifier = Verifier::new(&self.blisk, &self.electrode, path.reference_point, &Cancel::default())?;
        let verifier = match travel {
            Some(travel) => verifier.within(travel),
            None => verifier,
        };
        verifier.verify(path, &|_| Surface::HighWall, options, &Progress::silent(), &Cancel::default())
    }

    /// The usual certificate of `path` on a machine without ends of travel.
    pub(crate) fn certificate(&self, path: &FeedPath) -> Certificate {
        self.verified(path, &VerifyOptions::default(), Some(TravelLimits::UNLIMITED)).unwrap()
    }

    pub(crate) fn approved(&self) -> Approved {
        let certificate = self.certificate(&self.path);
        Approved::new(self.path.clone(), certificate, &self.blisk, &self.electrode).unwrap()
    }

    /// The rows of a copying motion that turns A by `turn_deg` away from the wall and back, and goes 0.5 mm outwards.
    pub(crate) fn copying_path(&self, turn_deg: f64) -> FeedPath {
        let away = if self.side == EntrySide::MinusX { -turn_deg } else { turn_deg };
        let at = |a_deg: f64, z: f64| row(Pose { a: a_deg.to_radians(), z, ..Pose::FINAL });
        let rows = vec![at(0.0, 0.0), at(away, 0.0), at(0.0, 0.0), at(0.0, 0.5), at(0.0, 0.0)];
        quantise_path(&FeedPath { rows, ..self.path.clone() })
    }

    /// A copying motion at the end of the path, certified.
    pub(crate) fn copying(&self) -> CopyingMotion {
        let path = self.copying_path(1.2);
        let certificate = self.certificate(&path);
        copying_of(path, certificate)
    }

    /// The whole motion in `channels` on `machine`, with its `bodies`.
    pub(crate) fn simulation(
        &self,
        copying: Option<&CopyingMotion>,
        (machine, bodies): (&MachineParams, &MachineModel),
        channels: &[usize],
    ) -> Simulation {
        let electrode = Electrode {
            faces: vec![ElectrodeFace::Shank; self.electrode.triangles.len()],
            mesh: self.electrode.clone(),
            enters_from: self.side,
            reference_point: self.path.reference_point,
            part: 0,
            parts: 1,
            column: None,
            least_thickness_mm: 20.0,
            volume_mm3: self.electrode.volume(),
            burn_area_mm2: 1.0,
            clearance_mm: 0.1,
            assumed: Vec::new(),
        };
        let scenario = Scenario {
            blisk: &self.blisk,
            channels: CHANNELS,
            own_channel: OWN_CHANNEL,
            electrode: &electrode,
            feed: (&self.path, &self.certificate(&self.path)),
            copying: copying.map(|copying| (&copying.path, &copying.certificate)),
            machine: &machine.seen_from_w(self.side),
            model: bodies,
        };
        let options = SimulationOptions::of(channels.to_vec());
        simulate(&scenario, &options, &Progress::silent(), &Cancel::default()).unwrap()
    }
}

/// A copying motion of this path and certificate, whether it goes with them or not.
pub(crate) fn copying_of(path: FeedPath, certificate: Certificate) -> CopyingMotion {
    let turn = 1.2f64.to_radians();
    let wanted = CopyingExtent { low: turn, high: 0.0, outwards: 0.5 };
    CopyingMotion { path, certificate, wanted, reached: wanted, turns: vec![Turn { z: 0.0, a: -turn }] }
}

/// A machine with bodies, in that it has a name; which ones is told to the simulation.
pub(crate) fn machine_with_bodies() -> MachineParams {
    MachineParams { name: "xyzac".to_owned(), ..MachineParams::default() }
}

/// The whole motion of [`path`] in its channel and the next one on a machine with bodies.
pub(crate) fn simulation() -> Simulation {
    let machine = (&machine_with_bodies(), &MachineModel::default());
    Scene::new(EntrySide::MinusX).simulation(None, machine, &[OWN_CHANNEL, OWN_CHANNEL + 1])
}

/// A report on one electrode that comes out and one that jams.
pub(crate) fn report() -> Report {
    let (path, stage) = (path(), |stage: &str, seconds| StageTime { stage: stage.to_owned(), seconds });
    Report {
        schema: SCHEMA,
        program_version: "0.1.0".to_owned(),
        verdict: Verdict {
            exit_code: 3,
            sentence: "1 of 2 electrodes has a verified path; electrode 2 jams.".to_owned(),
        },
        inputs: vec![InputFile {
            role: "blisk".to_owned(),
            path: "/home/eng/parts/turbine 60 <rev B>.stl".to_owned(),
            sha256: "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08".to_owned(),
            triangles: 184_320,
            unit: "mm".to_owned(),
            unit_reason: "a diameter of 268 is a blisk in mm, not in inches".to_owned(),
            repairs: vec!["merged 12 duplicate vertices".to_owned()],
        }],
        blisk: blisk(path.frame),
        parameters: serde_json::json!({
            "blisk": {"mesh": "turbine60.stl", "units": "mm", "axis": "auto"},
            "electrode": {"spark_gap_mm": 0.1, "circumferential_reduction_deg": [1.03, 1.03], "parts": 1},
            "genetic": {"population": 60, "generations": 80, "seed": 1},
        }),
        symbols: symbols(),
        electrodes: vec![verified(&path), jammed()],
        leftover: None,
        no_leftover: None,
        written: Written {
            electrode_frame: MeshFrame::W,
            post: "beckhoff-edm".to_owned(),
            files: ["electrode_1.stl", "path_1.csv", "report.json"].map(str::to_owned).to_vec(),
            not_asked_for: vec!["nc", "pictures"],
        },
        times: vec![
            stage("read and mend", 0.41),
            stage("channel", 1.62),
            stage("distance field", 9.83),
            stage("search", 41.7),
            stage("verification", 17.35),
            stage("export", 0.09),
        ],
        pictures: vec![],
        no_pictures: None,
    }
}

fn blisk(frame: Frame) -> BliskSummary {
    BliskSummary {
        blades: 60,
        channel: 0,
        shrouded: true,
        frame,
        hub_radius_mm: [96.0, 98.4],
        shroud_radius_mm: [128.0, 130.1],
        span_x_mm: [-17.2, 18.9],
        throat_mm: 4.318,
        turning_deg: 61.3,
        low_wall: "suction wall".to_owned(),
        high_wall: "pressure wall".to_owned(),
        assumed: vec!["The +X side is the one nearest to the mesh's +Z.".to_owned()],
    }
}

fn symbols() -> Vec<Symbol> {
    let rows = [
        ("δ", "spark gap", "0.10", "mm"),
        ("Δ1, Δ2", "circumferential reductions", "1.03, 1.03", "°"),
        ("a3 | b3", "weights of smoothness and centring", "0.80 | 0.20", ""),
        ("N", "bits per variable (8)", "11", ""),
    ];
    let symbol = |[symbol, meaning, value, unit]: [String; 4]| Symbol { symbol, meaning, value, unit };
    rows.map(|(a, b, c, d)| symbol([a, b, c, d].map(str::to_owned))).to_vec()
}

fn verified(path: &FeedPath) -> ElectrodeReport {
    let certificate = certificate(path);
    let nodes = path.rows.iter().enumerate().rev().step_by(4).map(|(i, r)| NodeReport {
        node: r.node,
        s_mm: r.s,
        pose: PoseReport::from(&r.pose),
        clearance_mm: certificate.row_clearance()[i],
        distances_mm: None,
        objective: Some(ObjectiveReport {
            smoothness: 0.02 + 0.001 * r.s,
            centring: 0.11,
            total: 0.038 + 0.0008 * r.s,
        }),
    });
    let falling = |node: usize, floor: f64| {
        (0..80).map(|g| floor + (0.5 + 0.01 * node as f64) * (-0.07 * g as f64).exp()).collect()
    };
    let nodes: Vec<_> = nodes.collect();
    ElectrodeReport {
        index: 1,
        share: "part 1 of 2".to_owned(),
        copying: None,
        simulation: None,
        enters_from: "-x".to_owned(),
        extractable: true,
        verified: true,
        required_clearance_mm: certificate.required(),
        tolerance_mm: certificate.tolerance(),
        certified_clearance_mm: Some(certificate.certified()),
        least_clearance_mm: Some(certificate.least().distance),
        least_clearance_at: Some(ClearancePlace::of(certificate.least(), "pressure wall")),
        smoothness: Smoothness::of(&Axis::ALL.map(|axis| {
            let in_file_units = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
            AxisSmoothness::of(&path.rows.iter().map(|r| in_file_units(r.pose.get(axis))).collect::<Vec<_>>())
        })),
        volume_mm3: 8431.7,
        least_thickness_mm: Some(1.84),
        burn_area_mm2: Some(3127.0),
        ga_convergence: nodes
            .iter()
            .map(|n| Convergence { node: n.node, best: falling(n.node, 0.04), mean: falling(n.node + 25, 0.09) })
            .collect(),
        nodes,
        failure: None,
        feed_lowered: Some(FeedLowered { blocks: 12, of_blocks: 240, least_share: 0.43, axis: 'A' }),
        sha256: Some(VerifiedDigests::of(&certificate)),
        files: ["electrode_1.stl", "path_1.csv", "path_1.nc"].map(str::to_owned).to_vec(),
        motion: Some(Motion { rows: path.rows.clone(), clearance: certificate.row_clearance().to_vec() }),
    }
}

fn jammed() -> ElectrodeReport {
    ElectrodeReport {
        index: 2,
        enters_from: "+x".to_owned(),
        required_clearance_mm: 0.1,
        tolerance_mm: 0.002,
        volume_mm3: 8790.2,
        failure: Some(Failure {
            node: 14,
            s_mm: 7.02,
            wall: Some("suction wall & hub".to_owned()),
            place: Some([-8.31, 1.442, 101.07]),
            sentence: "After 7.02 mm the electrode has no free pose: it is held between the suction wall and the hub. \
                       About 0.2° more circumferential reduction, or entering from -x, would open the way."
                .to_owned(),
        }),
        files: vec!["electrode_2.stl".to_owned()],
        ..ElectrodeReport::default()
    }
}
