//! The burn table as CSV.

use super::burn_table::{BurnEntry, BurnTable, ElectrodeEntry, method_name, shape_name};
use files::report::quoted;
use mold::electrode::finding::CheckKind;

impl BurnTable {
    /// The table as CSV: a row for each burn, with commas between and points as decimal marks. Text with a comma, a
    /// quote or a line's end stands in quotes.
    pub fn csv(&self) -> String {
        // What came later stands behind: readers that count columns find what they know.
        let kinds = CheckKind::ALL.map(CheckKind::name);
        let kinds = [&kinds[..], &MORE_COLUMNS].concat();
        let mut text = [&COLUMNS[..], &kinds].concat().join(",") + "\n";
        for electrode in &self.electrodes {
            for burn in &electrode.burns {
                text += &csv_row(self, electrode, burn).join(",");
                text.push('\n');
            }
        }
        text
    }
}

/// The columns of the CSV before those of the checks.
const COLUMNS: [&str; 31] = [
    "electrode",
    "burn",
    "x_mm",
    "y_mm",
    "z_mm",
    "c_deg",
    "depth_mm",
    "parts",
    "stage",
    "material",
    "shape",
    "gap_mm",
    "orbit",
    "orbit_radius_mm",
    "undersize_wall_mm",
    "undersize_floor_mm",
    "quantity",
    "finish_vdi",
    "roughness_um",
    "method",
    "blank_x_mm",
    "blank_y_mm",
    "blank_length_mm",
    "holder",
    "lift_x",
    "lift_y",
    "lift_z",
    "lift_mm",
    "volume_mm3",
    "minutes",
    "state",
];

/// Columns after the checks.
const MORE_COLUMNS: [&str; 23] = [
    "opening",
    "x_axis_x",
    "x_axis_y",
    "x_axis_z",
    "orbit_x_axis_x",
    "orbit_x_axis_y",
    "orbit_x_axis_z",
    "orbit_y_axis_x",
    "orbit_y_axis_y",
    "orbit_y_axis_z",
    "blank_diameter_mm",
    "base_height_mm",
    "front_area_mm2",
    "burn_area_mm2",
    "warnings",
    "family",
    "offset_x_mm",
    "offset_y_mm",
    "datum",
    "datum_x_mm",
    "datum_y_mm",
    "datum_z_mm",
    "datum_angle_deg",
];

fn csv_row(table: &BurnTable, e: &ElectrodeEntry, burn: &BurnEntry) -> Vec<String> {
    let lift = e.lift.map(|v| number(v, 6));
    let [lift_x, lift_y, lift_z] = lift;
    let mut row = vec![
        quoted(&e.name),
        burn.number.to_string(),
        number(burn.x_mm, 4),
        number(burn.y_mm, 4),
        number(burn.z_mm, 4),
        number(burn.c_deg, 4),
        number(burn.depth_mm, 4),
        quoted(&burn.parts.join(" ")),
        quoted(&e.stage),
        quoted(&e.material),
        shape_name(e.shape).to_owned(),
        number(e.gap_mm, 4),
        e.orbit.pattern.to_owned(),
        number(e.orbit.radius_mm, 4),
        number(e.undersize_wall_mm, 4),
        number(e.undersize_floor_mm, 4),
        e.quantity.to_string(),
        number(e.finish_vdi, 1),
        number(e.roughness_um, 3),
        method_name(e.method).to_owned(),
        number(e.blank.sides_mm[0], 3),
        number(e.blank.sides_mm[1], 3),
        number(e.blank.length_mm, 3),
        e.holder.as_ref().map_or(String::new(), |h| quoted(&h.name)),
        lift_x,
        lift_y,
        lift_z,
        number(table.lift_mm, 3),
        number(burn.volume_mm3, 4),
        burn.minutes.map_or(String::new(), |minutes| number(minutes, 2)),
        e.state.name().to_owned(),
    ];
    row.extend(e.checks.iter().map(|c| c.state.name().to_owned()));
    row.push(quoted(&table.opening));
    row.extend([burn.x_axis, e.orbit.x_axis, e.orbit.y_axis].as_flattened().iter().map(|v| number(*v, 6)));
    // Only of a round one, or else it would be read as what is to be taken.
    row.push(e.blank.diameter_mm.filter(|_| e.blank.is_round).map_or(String::new(), |d| number(d, 3)));
    row.extend([e.base_height_mm, e.front_area_mm2, e.burn_area_mm2].map(|v| number(v, 4)));
    row.push(quoted(&e.warnings.join("; ")));
    row.push(e.family.as_ref().map_or(String::new(), |f| quoted(&f.name)));
    row.extend([0, 1].map(|i| e.family.as_ref().map_or(String::new(), |f| number(f.offset_mm[i], 4))));
    row.push(quoted(&table.datum.name));
    row.extend(table.datum.origin_mm.map(|v| number(v, 4)));
    row.push(number(table.datum.angle_deg, 4));
    row
}

/// A number of a CSV file; nothing where there is none.
fn number(value: f64, decimals: usize) -> String {
    let text = if value.is_finite() { format!("{value:.decimals$}") } else { String::new() };
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        _ => text,
    }
}
