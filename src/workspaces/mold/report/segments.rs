//! Uncut segments of all layers as a table for programs.

use std::fmt::Write;

use serde::Serialize;

use crate::workspaces::mold::job::uncut::{ClassedRun, Uncut};
use mold::interference::Interference;

/// The uncut segments of a class of interference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClassTotal {
    /// The class.
    pub class: Interference,
    /// Name of the class.
    pub name: &'static str,
    /// Number of runs most of whose length is of the class.
    pub runs: usize,
    /// Length of the class along all runs of all layers (mm).
    pub length_mm: f64,
}

impl ClassTotal {
    /// Those of all classes, in the order of [`Interference::ALL`].
    pub fn of(runs: &[ClassedRun]) -> Vec<Self> {
        let of = |class: Interference| Self {
            class,
            name: class.name(),
            runs: runs.iter().filter(|run| run.class() == class).count(),
            length_mm: runs.iter().fold(0.0, |sum, run| sum + run.lengths[class as usize]),
        };
        Interference::ALL.map(of).to_vec()
    }
}

/// The uncut segments of a `mold` as CSV: a head of lines that begin with `#`, and a row for each of the `runs`. Lengths
/// are in mm; points are in the axes of the mesh, to a nanometre.
pub fn segments_as_csv(uncut: &Uncut, runs: &[ClassedRun], mold: &str) -> String {
    let opening = uncut.params.opening;
    let mut text = format!(
        "# Uncut segments of {}: what no cutter touches of the outline of each layer. Lengths in mm.\n\
         # layer: number from the bottom, from 1 of {}; height_mm: height of the layer along the opening direction {},\n\
         # from the origin of the mold's file; region: number as in uncut.json, from 1; points_mm: X Y Z of each point\n\
         # of the run in the axes of the mold's file, with ; between. A closed run ends where it begins. interference:\n\
         # class of most of the run: local and global with the same curve, other with another curve of the layer,\n\
         # off-layer with nothing in the layer.\n\
         # Segments are {}.\n\
         layer,height_mm,region,length_mm,points_mm,interference\n",
        mold.replace(['\n', '\r'], " "),
        uncut.layers.len(),
        opening.name(),
        if uncut.is_of_flats() { "exact for the flat cutters" } else { "as fine as the height map of all cutters" },
    );
    for classed in runs {
        let run = &classed.run;
        let number = |v: f64| format!("{}", (v * 1e6).round() / 1e6 + 0.0);
        let point = |p: &glam::DVec3| opening.in_mesh(*p).to_array().map(number).join(" ");
        let points: Vec<String> = run.points.iter().map(point).collect();
        let height = number(uncut.layers[run.layer].z);
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{},{height},{},{},{},{}",
            run.layer + 1,
            run.region + 1,
            number(run.length()),
            points.join(";"),
            classed.class().key()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::mold::job::uncut::{UncutParams, uncut};
    use glam::DVec3;
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::fixtures::{pocket, rectangle};
    use mold::opening::Opening;
    use task::Task;

    #[test]
    fn every_run_lies_on_the_walls_of_its_corner_in_the_axes_of_the_mesh() {
        let sides = rectangle(8.0, 6.0);
        let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 4.0]);
        for (cutters, slack) in [(vec![Cutter::flat(1.0)], 2e-5), (vec![Cutter::flat(1.0), Cutter::ball(2.0)], 0.35)] {
            let opening = Opening::MinusX;
            let params = UncutParams { opening, ..UncutParams::of(CutterLibrary { cutter: cutters }) };
            let found = uncut(&mesh.mapped(|p| opening.in_mesh(p)), &params, &Task::default()).unwrap();
            let runs = found.classed_runs(&mesh.mapped(|p| opening.in_mesh(p)), &task::Cancel::default()).unwrap();
            let text = segments_as_csv(&found, &runs, "a\nb");
            let rows: Vec<Vec<&str>> =
                text.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| l.split(',').collect()).collect();
            let mut lengths = vec![0.0; found.layers.len()];
            for row in &rows {
                let [layer, height, region, length, points, interference] = row[..] else { panic!("{row:?}") };
                let (layer, region) = (layer.parse::<usize>().unwrap() - 1, region.parse::<usize>().unwrap() - 1);
                let height: f64 = height.parse().unwrap();
                assert!((found.layers[layer].z - height).abs() < 1e-6);
                lengths[layer] += length.parse::<f64>().unwrap();
                assert_eq!(interference, "local", "corners of a pocket: {row:?}");
                let bounds = found.regions[region].bounds.grown(0.05);
                for point in points.split(';') {
                    let p: Vec<f64> = point.split(' ').map(|v| v.parse().unwrap()).collect();
                    // The opening looks along -X of the file.
                    assert!((p[0] + height).abs() < 1e-6, "{point} {height}");
                    let upright = opening.upright(DVec3::new(p[0], p[1], p[2]));
                    assert!(upright.clamp(bounds.min, bounds.max) == upright, "{upright}");
                    let off_walls = [upright.x.abs() - 4.0, upright.y.abs() - 3.0].map(f64::abs);
                    assert!(off_walls[0].min(off_walls[1]) < 1e-6, "{upright}");
                }
            }
            let in_pocket = found.layers.iter().zip(&lengths).filter(|(l, _)| (7.0..9.0).contains(&l.z));
            for (layer, length) in in_pocket {
                assert!((length - layer.segment_length).abs() < 1e-4, "{length} {layer:?}");
                assert!((length - 8.0).abs() <= 8.0 * slack, "two radii at each of four corners: {length}");
            }
            assert!(rows.len() >= 4 && lengths.iter().any(|length| *length > 1.0), "{text}");
        }
    }
}
