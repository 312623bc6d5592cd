//! Deviations as files: a table and coloured points.

use std::fmt::{Display, Write};

use crate::deviation::{Deviation, DeviationMap};

/// The deviations as CSV, a point to a line in the order of the scan: x, y, z after the fit and the deviation (mm), then
/// the surface, as `surface` names it.
pub fn deviations_csv<L: Display>(map: &DeviationMap, surface: impl Fn(&Deviation) -> L) -> String {
    let mut csv = String::from("x_mm,y_mm,z_mm,deviation_mm,surface\n");
    for deviation in map.list() {
        let (p, name) = (deviation.point, surface(deviation).to_string());
        let name =
            if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name };
        // Writing to a string never fails.
        let _ = writeln!(csv, "{:.6},{:.6},{:.6},{:.6},{name}", p.x, p.y, p.z, deviation.distance);
    }
    csv
}

/// The points after the fit (mm) as binary PLY, each with its deviation (mm) and the colour that `colour` gives to it
/// (red, green, blue).
pub fn deviations_ply(map: &DeviationMap, colour: impl Fn(f64) -> [u8; 3]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment deviations in mm, positive outside of the metal\nelement vertex \
         {}\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar \
         green\nproperty uchar blue\nproperty float deviation\nend_header\n",
        map.list().len()
    );
    let mut bytes = header.into_bytes();
    for deviation in map.list() {
        bytes.extend(deviation.point.to_array().map(f64::to_le_bytes).as_flattened());
        bytes.extend(colour(deviation.distance));
        bytes.extend((deviation.distance as f32).to_le_bytes());
    }
    bytes
}
