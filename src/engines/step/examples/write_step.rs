//! Writes an STL as STEP and prints the report.

use std::time::Instant;

use geometry::mesh::Mesh;
use glam::DVec3;
use step::write::{StepPart, StepSettings, write_step};
use task::Task;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let bytes = std::fs::read(&arguments[1]).unwrap();
    let tolerance = arguments.get(3).and_then(|t| t.parse().ok()).unwrap_or(0.005);
    let mut weld = geometry::weld::Weld::with_capacity(1000);
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let count = (bytes.len() - 84) / 50;
    let triangles: Vec<[u32; 3]> = (0..count)
        .map(|i| {
            [0, 1, 2].map(|k| {
                let at = 84 + 50 * i + 12 + 12 * k;
                weld.add(DVec3::new(number(at), number(at + 4), number(at + 8)))
            })
        })
        .collect();
    let mesh = Mesh { vertices: weld.into_points(), triangles };
    let start = Instant::now();
    let part = StepPart { name: "E", mesh: &mesh, roles: &[], role_of: &[], properties: &[] };
    match write_step(&part, &StepSettings { tolerance, ..Default::default() }, &Task::default()) {
        Ok(file) => {
            let r = &file.report;
            println!(
                "faces {} (planes {} cylinders {} cones {} free {}) edges {} deviation m2f {:.4} out {:.4} in {:.4} gap {:.5} volume {:+.4} % {} kB {:.1} s",
                r.faces(),
                r.planes,
                r.cylinders,
                r.cones,
                r.free_forms,
                r.edges,
                r.mesh_to_file_mm,
                r.outside_mm,
                r.inside_mm,
                r.edge_gap_mm,
                100.0 * (r.volume_mm3 / r.mesh_volume_mm3 - 1.0),
                file.bytes.len() / 1000,
                start.elapsed().as_secs_f64()
            );
            std::fs::write(&arguments[2], &file.bytes).unwrap();
        }
        Err(error) => println!("{error} ({:.1} s)", start.elapsed().as_secs_f64()),
    }
}
