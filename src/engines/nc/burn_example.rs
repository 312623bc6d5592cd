//! Tables that templates are tried on before there are electrodes.

use super::burn_table::{
    BlankEntry, BurnEntry, BurnTable, CheckEntry, CheckState, DatumEntry, ElectrodeEntry, ElectrodeState, FamilyEntry,
    HolderEntry, NotBurned, OrbitEntry, Pose, SCHEMA,
};
use super::template::Templated;
use mold::electrode::finding::CheckKind;
use mold::electrode::params::{Method, Shape};

const AS_IT_IS: Pose = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl Templated for BurnTable {
    const FILE: &'static str = "burn_table.json";
    const SHEET: &'static str = "burn sheet";
    const STANDARD: &'static str = include_str!("../../../assets/burn_table.jinja");

    /// A table where all is there that can be, and one with an electrode in each state, of which two lack what may be
    /// missing.
    fn examples() -> Vec<Self> {
        let all = [ElectrodeState::Ok, ElectrodeState::Overridden, ElectrodeState::Blocked];
        let several = all.map(|state| electrode(state, state == ElectrodeState::Ok)).to_vec();
        let tables = [vec![electrode(ElectrodeState::Ok, true)], several].map(|electrodes| Self {
            schema: SCHEMA,
            program_version: env!("CARGO_PKG_VERSION"),
            mold: "example".to_owned(),
            opening: "+z".to_owned(),
            datum: DatumEntry {
                name: "corner".to_owned(),
                origin_mm: [0.0; 3],
                x_axis: [1.0, 0.0, 0.0],
                angle_deg: 0.0,
            },
            to_file: AS_IT_IS,
            shape: Shape::Undersized,
            material: "copper".to_owned(),
            lift_mm: 30.0,
            // Not every technology tells them: a template has to ask.
            minutes: None,
            burns: electrodes.len(),
            electrodes,
            not_burned: vec![NotBurned { region: 2, why: "there is nothing to burn".to_owned() }],
            notes: vec!["to be seen to".to_owned()],
        });
        tables.into()
    }
}

fn electrode(state: ElectrodeState, has_all: bool) -> ElectrodeEntry {
    let holder = HolderEntry { name: "holder".to_owned(), size_mm: [25.0; 2], height_mm: 20.0 };
    let of_check = match state {
        ElectrodeState::Ok => CheckState::Ok,
        ElectrodeState::Overridden => CheckState::Overridden,
        ElectrodeState::Blocked => CheckState::Failed,
    };
    let not_made = state == ElectrodeState::Blocked;
    let check = |kind: CheckKind| CheckEntry {
        kind,
        state: if not_made && kind == CheckKind::Machinable { CheckState::NotMade } else { of_check },
        text: if has_all { "found".to_owned() } else { String::new() },
        place_mm: has_all.then_some([1.0, 2.0, -3.0]),
    };
    ElectrodeEntry {
        name: "E01".to_owned(),
        state,
        stage: "finish".to_owned(),
        material: "copper".to_owned(),
        shape: Shape::Undersized,
        gap_mm: 0.05,
        orbit: OrbitEntry {
            pattern: if has_all { "circular" } else { "none" },
            radius_mm: if has_all { 0.1 } else { 0.0 },
            x_axis: [1.0, 0.0, 0.0],
            y_axis: [0.0, 1.0, 0.0],
        },
        undersize_wall_mm: 0.15,
        undersize_floor_mm: 0.05,
        quantity: 1,
        finish_vdi: 24.0,
        roughness_um: 1.585,
        method: Method::Cutting,
        blank: BlankEntry {
            is_round: false,
            sides_mm: [10.0, 12.0],
            length_mm: 25.0,
            diameter_mm: has_all.then_some(16.0),
        },
        holder: has_all.then_some(holder),
        family: has_all.then(|| FamilyEntry {
            name: "E01".to_owned(),
            others: vec!["E01-rough".to_owned()],
            offset_mm: [7.5, 0.0],
        }),
        lift: [0.0, 0.0, 1.0],
        front_area_mm2: 4.0,
        burn_area_mm2: 10.0,
        base_height_mm: 12.0,
        volume_mm3: 3.5,
        minutes: has_all.then_some(12.5),
        end_wear_mm: has_all.then_some(0.01),
        corner_wear_mm: has_all.then_some(0.02),
        needed: "1".to_owned(),
        rests_on: if has_all { vec!["steel, copper (assumed): test".to_owned()] } else { Vec::new() },
        warnings: if has_all { vec!["to be seen to".to_owned()] } else { Vec::new() },
        burns: vec![BurnEntry {
            number: 1,
            x_mm: 12.3457,
            y_mm: -4.5,
            z_mm: 20.0,
            c_deg: 90.0,
            x_axis: [0.0, 1.0, 0.0],
            pose: AS_IT_IS,
            depth_mm: 7.25,
            volume_mm3: 3.5,
            minutes: has_all.then_some(12.5),
            parts: vec!["R1.1".to_owned()],
            regions: vec![1],
        }],
        checks: CheckKind::ALL.map(check).to_vec(),
    }
}
