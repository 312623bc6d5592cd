//! The bodies of a machine: what may collide besides electrode and blisk.
//!
//! Bodies are given where they stand in the final pose, in directions of the machine that turn with the way in which the
//! blisk is mounted: +x points from the table along the blisk's axis, +z is the machine's Z, which at the channel
//! points away from the blisk's axis, and y makes them right-handed. An electrode that is withdrawn along X is withdrawn
//! to +x of the machine. A blisk that is mounted the other way round finds the same machine turned by half a turn about
//! Z. Where x, y and z are counted from is the carrier's matter:
//!
//! | carrier | goes with | counted from |
//! | --- | --- | --- |
//! | `electrode` | X Y Z C B | the middle of the electrode's end face on the side of entry, the holder's interface |
//! | `head` | X Y Z | the C axis, which goes through the reference point O: at O, or, for an electrode that is withdrawn along Z, at the height of the interface |
//! | `table` | the blisk, which A turns | the blisk's axis at the face that the table holds |
//! | `cradle` | A and all that it carries, which C turns on a tilting table | the same point |
//! | `bed` | nothing | the same point |
//!
//! How they move is told by [`Chain`].

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::chain::Chain;
use super::machine::Mounting;
use super::preset::Preset;
use geometry::mesh::Mesh;
use wheel::electrode::EntrySide;

/// Part of the machine that carries a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Carrier {
    /// The electrode: slides with X, Y, Z and turns with C and B.
    Electrode,
    /// The head: slides with X, Y, Z.
    Head,
    /// The table: turns with A, so that it keeps its place at the blisk.
    Table,
    /// The cradle between bed and table: turns with C on a machine whose C turns the table; otherwise it stands still.
    Cradle,
    /// The bed: stands still.
    Bed,
}

impl Carrier {
    /// Whether the axes X, Y and Z move it.
    pub fn slides(self) -> bool {
        matches!(self, Self::Electrode | Self::Head)
    }
}

/// A body in the coordinates of its carrier.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the body.
    pub name: String,
    /// Part of the machine that carries the body.
    pub carrier: Carrier,
    /// Closed surface of the body (mm). A cylinder is a prism around it, never smaller than the cylinder.
    pub mesh: Mesh,
}

/// The bodies of a machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MachineModel {
    /// The bodies in the order of the file.
    pub bodies: Vec<Body>,
}

impl MachineModel {
    /// SHA-256 (lower-case hex) over names, carriers and meshes: two models with the same digest are the same machine.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for Body { name, carrier, mesh } in &self.bodies {
            // With its length no name can pass for the end of one body and the start of another.
            hash.update(format!("{}\0{name}\0{carrier:?}\0{}\0", name.len(), mesh.digest()));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Position of a machine relative to an electrode and a blisk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    mounting: Mounting,
    interface: DVec3,
    reference_point: DVec3,
    on_c_axis: DVec3,
    seat: DVec3,
    preset: Option<Preset>,
}

impl Station {
    /// The machine about `electrode`, in its final pose with its reference point O, and `blisk`, all in W (mm).
    pub fn new(electrode: &Mesh, reference_point: DVec3, side: EntrySide, mounting: Mounting, blisk: &Mesh) -> Self {
        let out = |p: &DVec3| p.dot(side.direction());
        let outermost = electrode.vertices.iter().map(out).fold(f64::NEG_INFINITY, f64::max);
        let at_end = |p: &&DVec3| out(p) > outermost - 1e-3;
        let end = geometry::mesh::Bounds::of(electrode.vertices.iter().filter(at_end).copied());
        let interface = end.center();
        let on_c_axis = match side {
            EntrySide::MinusX | EntrySide::PlusX => reference_point,
            EntrySide::Outward | EntrySide::Inward => reference_point.with_z(interface.z),
        };
        let blisk = blisk.bounds();
        let seat = if mounting.is_turned { blisk.max.x } else { blisk.min.x };
        let seat = DVec3::new(seat, 0.0, 0.0);
        Self { mounting, interface, reference_point, on_c_axis, seat, preset: None }
    }

    /// The machine about an electrode that stands on its holder as `preset` says: its own parts stand about a nominal one.
    #[must_use]
    pub fn holding(self, preset: &Preset) -> Self {
        let (advance, nominal) = (DVec3::from(preset.advance_mm), preset.nominal(self.reference_point));
        let on_c_axis = match self.on_c_axis == self.reference_point {
            true => nominal,
            false => nominal.with_z(self.on_c_axis.z - advance.z),
        };
        Self { interface: self.interface - advance, on_c_axis, preset: Some(*preset), ..self }
    }

    /// The kinematic chain of the machine.
    pub fn chain(&self) -> Chain {
        let to_w = self.nominal(Carrier::Bed);
        let table_c = self.mounting.table_c.map(|[x, y]| to_w.transform_point3(DVec3::new(x, y, 0.0)).truncate());
        let turned = self.preset.map_or(0.0, |preset| preset.turned());
        Chain::new(self.reference_point, table_c).turned(turned)
    }

    /// From the coordinates of `carrier` to W, where its bodies are in the final pose.
    pub fn placement(&self, carrier: Carrier) -> DAffine3 {
        let nominal = self.nominal(carrier);
        let Some(preset) = self.preset else { return nominal };
        let of_head = |turns| preset.of_head(preset.nominal(self.reference_point), turns) * nominal;
        match carrier {
            Carrier::Electrode => of_head(true),
            Carrier::Head => of_head(false),
            Carrier::Bed => preset.of_bed(self.chain().on_table_c().unwrap_or_default()) * nominal,
            Carrier::Table | Carrier::Cradle => nominal,
        }
    }

    /// The placement about a nominal electrode.
    fn nominal(&self, carrier: Carrier) -> DAffine3 {
        let translation = match carrier {
            Carrier::Electrode => self.interface,
            Carrier::Head => self.on_c_axis,
            Carrier::Table | Carrier::Cradle | Carrier::Bed => self.seat,
        };
        let matrix3 = match self.mounting.is_turned {
            true => DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)),
            false => DMat3::IDENTITY,
        };
        DAffine3 { matrix3, translation }
    }

    /// A body in W, where it is in the final pose (mm).
    pub fn placed(&self, body: &Body) -> Mesh {
        let DAffine3 { matrix3, translation } = self.placement(body.carrier);
        body.mesh.mapped(|p| translation + matrix3 * p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_stands_where_the_electrode_comes_from() {
        let electrode = Mesh::cuboid(DVec3::new(40.0, 4.0, 10.0)).mapped(|p| p + DVec3::new(-20.0, -2.0, 95.0));
        let blisk = Mesh::cuboid(DVec3::new(26.0, 200.0, 200.0)).mapped(|p| p - DVec3::new(10.0, 100.0, 100.0));
        let o = DVec3::new(0.0, 0.5, 100.0);
        let body = |carrier| Body { name: String::new(), carrier, mesh: Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)) };
        let placed = |side, is_turned, carrier| {
            let mounting = Mounting { is_turned, table_c: Some([2.0, -3.0]) };
            let station = Station::new(&electrode, o, side, mounting, &blisk);
            let q = if is_turned { DVec3::new(14.0, 3.0, 0.0) } else { DVec3::new(-8.0, -3.0, 0.0) };
            assert_eq!(station.chain().on_table_c(), Some(q));
            station.placed(&body(carrier)).bounds()
        };
        for (side, is_turned, carrier, min, max) in [
            (EntrySide::PlusX, false, Carrier::Electrode, [20.0, 0.0, 100.0], [22.0, 3.0, 104.0]),
            (EntrySide::MinusX, true, Carrier::Electrode, [-22.0, -3.0, 100.0], [-20.0, 0.0, 104.0]),
            (EntrySide::MinusX, true, Carrier::Head, [-2.0, -2.5, 100.0], [0.0, 0.5, 104.0]),
            (EntrySide::PlusX, false, Carrier::Table, [-10.0, 0.0, 0.0], [-8.0, 3.0, 4.0]),
            (EntrySide::MinusX, true, Carrier::Bed, [14.0, -3.0, 0.0], [16.0, 0.0, 4.0]),
            // The top of the bar is the interface, and the head stands above the C axis at its height.
            (EntrySide::Outward, false, Carrier::Electrode, [0.0, 0.0, 105.0], [2.0, 3.0, 109.0]),
            (EntrySide::Outward, false, Carrier::Head, [0.0, 0.5, 105.0], [2.0, 3.5, 109.0]),
            (EntrySide::Outward, true, Carrier::Head, [-2.0, -2.5, 105.0], [0.0, 0.5, 109.0]),
            (EntrySide::Outward, false, Carrier::Table, [-10.0, 0.0, 0.0], [-8.0, 3.0, 4.0]),
            (EntrySide::Outward, true, Carrier::Table, [14.0, -3.0, 0.0], [16.0, 0.0, 4.0]),
        ] {
            let bounds = placed(side, is_turned, carrier);
            let off = (bounds.min - DVec3::from_array(min)).length() + (bounds.max - DVec3::from_array(max)).length();
            assert!(off < 1e-12, "{side:?} {carrier:?}: {bounds:?}");
        }
    }

    #[test]
    fn a_body_that_has_moved_makes_another_machine() {
        let machine = |x: f64| {
            let mesh = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::X * x);
            MachineModel { bodies: vec![Body { name: "stop".to_owned(), carrier: Carrier::Bed, mesh }] }
        };
        assert_eq!(machine(1.0).digest(), machine(1.0).digest());
        assert_ne!(machine(1.0).digest(), machine(1.000001).digest());
        // A name that reads like the end of one body and the start of another.
        let [first, second] = ["a", "b"].map(|name| Body { name: name.to_owned(), ..machine(1.0).bodies[0].clone() });
        let name = format!("a\0Bed\0{}\0b", first.mesh.digest());
        let one = MachineModel { bodies: vec![Body { name, ..first.clone() }] };
        assert_ne!(one.digest(), MachineModel { bodies: vec![first, second] }.digest());
    }
}
