//! A box that is fed past a wall, with its certificate, copying motion and simulation, all of them really verified, and
//! a made-up report: for the tests of this floor.

use std::sync::OnceLock;

use glam::DVec3;
use task::{Cancel, Task};

use super::approved::Approved;
use feed::certificate::Certificate;
use feed::copying::{CopyingExtent, CopyingMotion, Turn};
use feed::machine::{MachineParams, TravelLimits};
use feed::machine_model::MachineModel;
use feed::path::{FeedPath, PathRow};
use feed::pose::Pose;
use feed::preset::Preset;
use feed::quantise::quantise_path;
use feed::simulation::{Scenario, Simulation, SimulationOptions, simulate};
use feed::verify::{Verifier, VerifyError, VerifyOptions};
use geometry::frame::Frame;
use geometry::mesh::{Bounds, Mesh};
use wheel::channel::Surface;
use wheel::electrode::{Electrode, ElectrodeFace, EntrySide};

/// A five-axis path of 121 rows over 60 mm, rounded, in a turned and shifted frame. It enters from -X.
pub fn path() -> FeedPath {
    Scene::new(EntrySide::MinusX).path
}

/// The certificate of `path` in the scene from -X: of [`path`] it holds, and its least clearance of 0.1032 mm is 3 mm
/// before the final pose.
pub fn certificate(path: &FeedPath) -> Certificate {
    static OF_PATH: OnceLock<Certificate> = OnceLock::new();
    let scene = Scene::new(EntrySide::MinusX);
    if *path == scene.path {
        return OF_PATH.get_or_init(|| scene.certificate(&scene.path)).clone();
    }
    scene.certificate(path)
}

/// The box around the electrode of [`path`], in W.
pub fn electrode_bounds() -> Bounds {
    Bounds { min: DVec3::new(-18.0, -9.0, 88.0), max: DVec3::new(20.0, 11.0, 131.0) }
}

/// The wall that the electrode is fed past.
pub fn blisk_mesh() -> Mesh {
    Scene::new(EntrySide::MinusX).blisk
}

/// An electrode that fills [`electrode_bounds`].
pub fn electrode_mesh() -> Mesh {
    Scene::new(EntrySide::MinusX).electrode
}

/// [`path`] approved on its [`certificate`].
pub fn approved() -> Approved {
    let path = path();
    let certificate = certificate(&path);
    Approved::new(path, certificate, &blisk_mesh(), &electrode_mesh()).unwrap()
}

/// A wall, a box and the path of the box past it; from +X all of it is turned by half a turn about Z.
#[derive(Clone)]
pub struct Scene {
    /// The side that the electrode enters from.
    pub side: EntrySide,
    /// The wall, in W.
    pub blisk: Mesh,
    /// The box in its final pose, in W.
    pub electrode: Mesh,
    /// The path of the box.
    pub path: FeedPath,
}

/// Number of channels.
pub const CHANNELS: usize = 12;
/// The channel of the path.
pub const OWN_CHANNEL: usize = 3;
/// Angle from one channel to the next (deg).
pub const PITCH_DEG: f64 = 30.0;

/// Where the wall's face is (mm): the box comes to 0.1032 mm from it, 3 mm before the final pose.
const WALL_Y: f64 = -9.2186;

fn row(pose: Pose) -> PathRow {
    PathRow { node: 0, s: 0.0, pose }
}

impl Scene {
    /// The scene entered from `side`.
    pub fn new(side: EntrySide) -> Self {
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
        let wall = Mesh::cuboid(DVec3::new(60.0, 5.0, 60.0)).mapped(|p| p + DVec3::new(-30.0, WALL_Y - 5.0, 80.0));
        let electrode = Mesh::cuboid(max - min).mapped(|p| p + min);
        let from_minus = Self { side: EntrySide::MinusX, blisk: wall, electrode, path: quantise_path(&path) };
        if side == EntrySide::MinusX { from_minus } else { from_minus.turned() }
    }

    /// Scene turned by half a turn about Z.
    fn turned(self) -> Self {
        let turned = |p: DVec3| DVec3::new(-p.x, -p.y, p.z);
        let pose = |p: Pose| Pose { x: -p.x, y: -p.y, a: -p.a, b: -p.b, ..p };
        let rows = self.path.rows.iter().map(|row| PathRow { pose: pose(row.pose), ..*row }).collect();
        let path = FeedPath { reference_point: turned(self.path.reference_point), rows, ..self.path };
        let [blisk, electrode] = [self.blisk, self.electrode].map(|mesh| mesh.mapped(turned));
        // Zeros are without a sign in files.
        Self { side: EntrySide::PlusX, blisk, electrode, path: quantise_path(&path) }
    }

    /// Scene with the wall nearer to the electrode by `by` (mm).
    pub fn with_wall_nearer_by(&self, by: f64) -> Self {
        let by = if self.side == EntrySide::MinusX { by } else { -by };
        Self { blisk: self.blisk.mapped(|p| p + by * DVec3::Y), ..self.clone() }
    }

    /// Certificate of `path` in this scene.
    pub fn verified(
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
        verifier.verify(path, &|_| Surface::HighWall, options, &Task::default())
    }

    /// The usual certificate of `path` on a machine without ends of travel.
    pub fn certificate(&self, path: &FeedPath) -> Certificate {
        self.verified(path, &VerifyOptions::default(), Some(TravelLimits::UNLIMITED)).unwrap()
    }

    /// The approved path.
    pub fn approved(&self) -> Approved {
        let certificate = self.certificate(&self.path);
        Approved::new(self.path.clone(), certificate, &self.blisk, &self.electrode).unwrap()
    }

    /// The rows of a copying motion that turns A by `turn_deg` away from the wall and back, and goes 0.5 mm outwards.
    pub fn copying_path(&self, turn_deg: f64) -> FeedPath {
        let away = if self.side == EntrySide::MinusX { -turn_deg } else { turn_deg };
        let at = |a_deg: f64, z: f64| row(Pose { a: a_deg.to_radians(), z, ..Pose::FINAL });
        let rows = vec![at(0.0, 0.0), at(away, 0.0), at(0.0, 0.0), at(0.0, 0.5), at(0.0, 0.0)];
        quantise_path(&FeedPath { rows, ..self.path.clone() })
    }

    /// A copying motion at the end of the path, certified.
    pub fn copying(&self) -> CopyingMotion {
        let path = self.copying_path(1.2);
        let certificate = self.certificate(&path);
        copying_of(path, certificate)
    }

    /// The whole motion in `channels` on `machine`, with its `bodies`.
    pub fn simulation(
        &self,
        copying: Option<&CopyingMotion>,
        (machine, bodies): (&MachineParams, &MachineModel),
        channels: &[usize],
    ) -> Simulation {
        self.simulation_of(None, copying, (machine, bodies), channels)
    }

    /// Simulation of an electrode that stands on its holder as `preset` says.
    pub fn simulation_of(
        &self,
        preset: Option<&Preset>,
        copying: Option<&CopyingMotion>,
        (machine, bodies): (&MachineParams, &MachineModel),
        channels: &[usize],
    ) -> Simulation {
        let electrode = Electrode {
            faces: vec![ElectrodeFace::Shank; self.electrode.triangles.len()],
            mesh: self.electrode.clone(),
            enters_from: self.side,
            reference_point: self.path.reference_point,
            stage: None,
            part: 0,
            parts: 1,
            column: None,
            least_thickness_mm: 20.0,
            volume_mm3: self.electrode.volume(),
            burn_area_mm2: 1.0,
            undersize_mm: 0.1,
            clearance_mm: 0.1,
            assumed: Vec::new(),
            patches: Vec::new(),
        };
        let scenario = Scenario {
            blisk: &self.blisk,
            channels: CHANNELS,
            own_channel: OWN_CHANNEL,
            electrode: &electrode,
            preset,
            feed: (&self.path, &self.certificate(&self.path)),
            copying: copying.map(|copying| (&copying.path, &copying.certificate)),
            machine: &machine.seen_from_w(self.side),
            model: bodies,
        };
        let options = SimulationOptions::of(channels.to_vec());
        simulate(&scenario, &options, &Task::default()).unwrap()
    }
}

/// A copying motion of this path and certificate, whether it goes with them or not.
pub fn copying_of(path: FeedPath, certificate: Certificate) -> CopyingMotion {
    let turn = 1.2f64.to_radians();
    let wanted = CopyingExtent { low: turn, high: 0.0, outwards: 0.5 };
    CopyingMotion { path, certificate, wanted, reached: wanted, turns: vec![Turn { outwards: 0.0, a: -turn }] }
}

/// A machine with bodies, in that it has a name; which ones is told to the simulation.
pub fn machine_with_bodies() -> MachineParams {
    MachineParams { name: "xyzac".to_owned(), ..MachineParams::default() }
}

/// The whole motion of [`path`] in its channel and the next one on a machine with bodies.
pub fn simulation() -> Simulation {
    let machine = (&machine_with_bodies(), &MachineModel::default());
    Scene::new(EntrySide::MinusX).simulation(None, machine, &[OWN_CHANNEL, OWN_CHANNEL + 1])
}
