//! What moves and what it may meet.

use super::Scenario;
use crate::feed::machine_model::{Body, Carrier, Station};
use crate::feed::pose::Pose;
use crate::feed::verify::pair::Solid;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled};
use glam::DVec3;

/// A body that the axes X, Y and Z move.
pub(super) struct Mover {
    pub name: String,
    /// Whether it is the electrode itself.
    pub is_electrode: bool,
    /// Whether it turns with C and B.
    pub turns: bool,
    pub solid: Solid,
}

/// A body that they may meet.
pub(super) struct Obstacle {
    pub name: String,
    /// What it is carried by; none for the blisk.
    pub carrier: Option<Carrier>,
    /// A table's surface in W; it may be needed in every channel.
    pub table: Option<Mesh>,
    pub solid: Solid,
}

impl Obstacle {
    pub fn is_blisk(&self) -> bool {
        self.carrier.is_none()
    }
}

/// All bodies of a scenario, those that move about the reference point O.
pub(super) struct Bodies {
    pub movers: Vec<Mover>,
    pub obstacles: Vec<Obstacle>,
}

impl Bodies {
    pub fn new(scenario: &Scenario, cancel: &Cancel) -> Result<Self, Cancelled> {
        let electrode = scenario.electrode;
        let o = electrode.reference_point;
        let solid = Solid::new(&electrode.mesh, o, cancel)?;
        let mut movers = vec![Mover { name: "electrode".to_owned(), is_electrode: true, turns: true, solid }];
        let solid = Solid::new(scenario.blisk, DVec3::ZERO, cancel)?;
        let mut obstacles = vec![Obstacle { name: "blisk".to_owned(), carrier: None, table: None, solid }];
        for body in placed(scenario) {
            let Body { name, carrier, mesh } = body;
            if carrier.slides() {
                let turns = carrier == Carrier::Electrode;
                movers.push(Mover { name, is_electrode: false, turns, solid: Solid::new(&mesh, o, cancel)? });
            } else {
                let solid = Solid::new(&mesh, DVec3::ZERO, cancel)?;
                let table = (carrier == Carrier::Table).then_some(mesh);
                obstacles.push(Obstacle { name, carrier: Some(carrier), table, solid });
            }
        }
        Ok(Self { movers, obstacles })
    }
}

/// The bodies of the machine in W, where they are in the final pose.
pub(super) fn placed(scenario: &Scenario) -> Vec<Body> {
    let electrode = scenario.electrode;
    let station = Station::new(&electrode.mesh, electrode.reference_point, electrode.enters_from, scenario.blisk);
    let in_w = |body: &Body| Body { mesh: station.placed(body), ..body.clone() };
    scenario.model.bodies.iter().map(in_w).collect()
}

/// The poses that move `moving` as seen from `fixed`: C and B do not turn the head, and A, which turns the table, does
/// not move the tool against the bed.
pub(super) fn relative(poses: &[Pose], moving: &Mover, fixed: &Obstacle) -> Vec<Pose> {
    let stands = fixed.carrier == Some(Carrier::Bed);
    let seen = |pose: &Pose| {
        let (b, c) = if moving.turns { (pose.b, pose.c) } else { (0.0, 0.0) };
        Pose { a: if stands { 0.0 } else { pose.a }, b, c, ..*pose }
    };
    poses.iter().map(seen).collect()
}
