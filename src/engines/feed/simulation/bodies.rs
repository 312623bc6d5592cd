//! Moving bodies and the obstacles they may meet.

use super::Scenario;
use crate::chain::Chain;
use crate::machine_model::{Body, Carrier, Station};
use crate::pose::Pose;
use crate::verify::pair::Solid;
use geometry::mesh::Mesh;
use glam::DVec3;
use task::{Cancel, Cancelled};

/// A body that the axes move.
pub(super) struct Mover {
    pub name: String,
    /// Whether A turns the body, rather than X, Y and Z moving it: the blisk, and bodies that the table carries.
    pub on_table: bool,
    /// Whether it stands on the bed and moves as seen from the cradle, which C turns, and from the blisk.
    pub on_bed: bool,
    /// Whether the body is the electrode itself.
    pub is_electrode: bool,
    /// Whether the body turns with C and B.
    pub turns: bool,
    pub solid: Solid,
}

/// A body that moving bodies may meet.
pub(super) struct Obstacle {
    pub name: String,
    /// Part of the machine that carries the obstacle; none for the blisk.
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

impl Mover {
    /// Whether the body could meet `fixed`: bodies that move together stand still against each other.
    pub fn could_meet(&self, fixed: &Obstacle, chain: &Chain) -> bool {
        match fixed.carrier {
            // C and B turn the electrode against the head.
            Some(Carrier::Head) => self.turns,
            // Where C turns the table, the bed is what moves.
            Some(Carrier::Bed) => !(self.on_bed || self.on_table && chain.on_table_c().is_some()),
            Some(Carrier::Cradle) => true,
            _ => !self.on_table,
        }
    }
}

/// All bodies of a scenario, those that move about the reference point O.
pub(super) struct Bodies {
    pub chain: Chain,
    pub movers: Vec<Mover>,
    pub obstacles: Vec<Obstacle>,
}

impl Bodies {
    pub fn new(scenario: &Scenario, cancel: &Cancel) -> Result<Self, Cancelled> {
        let electrode = scenario.electrode;
        let o = electrode.reference_point;
        let solid = Solid::new(&electrode.mesh, o, cancel)?;
        let chain = station(scenario).chain();
        let tool =
            |name, turns, solid| Mover { name, on_table: false, on_bed: false, is_electrode: false, turns, solid };
        let on_table = |name, solid| Mover { on_table: true, ..tool(name, false, solid) };
        let electrode = Mover { is_electrode: true, ..tool("electrode".to_owned(), true, solid) };
        let mut movers = vec![electrode];
        let bodies = placed(scenario);
        if bodies.iter().any(|body| matches!(body.carrier, Carrier::Cradle | Carrier::Bed)) {
            movers.push(on_table("blisk".to_owned(), Solid::new(scenario.blisk, DVec3::ZERO, cancel)?));
        }
        let solid = Solid::new(scenario.blisk, DVec3::ZERO, cancel)?;
        let mut obstacles = vec![Obstacle { name: "blisk".to_owned(), carrier: None, table: None, solid }];
        for Body { name, carrier, mesh } in bodies {
            if carrier.slides() {
                if carrier == Carrier::Head {
                    let solid = Solid::new(&mesh, DVec3::ZERO, cancel)?;
                    obstacles.push(Obstacle { name: name.clone(), carrier: Some(carrier), table: None, solid });
                }
                movers.push(tool(name, carrier == Carrier::Electrode, Solid::new(&mesh, o, cancel)?));
            } else {
                if carrier == Carrier::Table {
                    movers.push(on_table(name.clone(), Solid::new(&mesh, DVec3::ZERO, cancel)?));
                }
                if let Some(q) = chain.on_table_c().filter(|_| carrier == Carrier::Bed) {
                    let solid = Solid::new(&mesh, q, cancel)?;
                    movers.push(Mover { on_bed: true, ..tool(name.clone(), false, solid) });
                }
                let solid = Solid::new(&mesh, DVec3::ZERO, cancel)?;
                let table = (carrier == Carrier::Table).then_some(mesh);
                obstacles.push(Obstacle { name, carrier: Some(carrier), table, solid });
            }
        }
        Ok(Self { chain, movers, obstacles })
    }
}

fn station(scenario: &Scenario) -> Station {
    let electrode = scenario.electrode;
    let (o, side) = (electrode.reference_point, electrode.enters_from);
    let station = Station::new(&electrode.mesh, o, side, scenario.machine.mounting(side), scenario.blisk);
    scenario.preset.map_or(station, |preset| station.holding(preset))
}

/// The bodies of the machine in W, where they are in the final pose.
pub(super) fn placed(scenario: &Scenario) -> Vec<Body> {
    let station = station(scenario);
    let in_w = |body: &Body| Body { mesh: station.placed(body), ..body.clone() };
    scenario.model.bodies.iter().map(in_w).collect()
}

/// `poses` with only the axes that move `moving` against `fixed`. Blisk and table turn against A, and nothing else
/// moves them against cradle and, where C turns the electrode, bed. Of a tool's axes X, Y and Z do not count against the
/// head, which they carry too, and A not against cradle and bed, which it does not turn; B turns what the electrode
/// carries, and not the head, and so does C, unless it turns the table: then the bed turns with C as seen from the
/// cradle, with C and A as seen from the blisk, and a tool only slides against it.
pub(super) fn relative(chain: &Chain, poses: &[Pose], moving: &Mover, fixed: &Obstacle) -> Vec<Pose> {
    let c_turns_table = chain.on_table_c().is_some();
    let seen = |pose: &Pose| {
        if moving.on_table {
            return Pose { a: -pose.a, ..Pose::FINAL };
        }
        let a = if matches!(fixed.carrier, Some(Carrier::Cradle | Carrier::Bed)) { 0.0 } else { pose.a };
        if moving.on_bed {
            return Pose { a, c: pose.c, ..Pose::FINAL };
        }
        let b = if moving.turns { pose.b } else { 0.0 };
        match fixed.carrier {
            Some(Carrier::Head) if c_turns_table => Pose { b, ..Pose::FINAL },
            Some(Carrier::Head) => Pose { b, c: pose.c, ..Pose::FINAL },
            Some(Carrier::Bed) if c_turns_table => Pose { a, b, c: 0.0, ..chain.slid(pose) },
            _ => Pose { a, b, c: if moving.turns || c_turns_table { pose.c } else { 0.0 }, ..*pose },
        }
    };
    poses.iter().map(seen).collect()
}
