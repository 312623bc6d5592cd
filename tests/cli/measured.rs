//! Scanned parts from the command line.

use std::fmt::Write;
use std::path::Path;

use geometry::mesh::Mesh;
use glam::DVec3;
use import::write_stl;

use super::{sparkpath, text};

/// Writes a box of 40 x 30 x 20 mm, and a scan of it that lies 0.2 mm off along X, with a bump of `bump` (mm) on its top.
fn box_and_scan(folder: &Path, bump: f64) -> [String; 2] {
    let size = DVec3::new(40.0, 30.0, 20.0);
    let [nominal, scan] = ["box.stl", "scan.csv"].map(|name| folder.join(name));
    write_stl(&nominal, &Mesh::cuboid(size)).unwrap();
    let mut lines = "x;y;z\n".to_owned();
    for (i, k) in (1..20).flat_map(|i| (1..20).map(move |k| (f64::from(i) / 20.0, f64::from(k) / 20.0))) {
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let mut share = DVec3::splat(side);
                (share[(axis + 1) % 3], share[(axis + 2) % 3]) = (i, k);
                let is_bump = axis == 2 && side == 1.0 && (i - 0.5).abs() + (k - 0.5).abs() < 0.12;
                let p = share * size + DVec3::new(0.2, 0.0, if is_bump { bump } else { 0.0 });
                writeln!(lines, "{};{};{}", p.x, p.y, p.z).unwrap();
            }
        }
    }
    std::fs::write(&scan, lines).unwrap();
    [nominal, scan].map(|file| file.to_str().unwrap().to_owned())
}

#[test]
fn a_scan_is_fitted_and_judged() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let [nominal, scan] = box_and_scan(folder.path(), 0.0);
    let measured = |more: &[&str]| sparkpath(&[&["measured", &nominal, &scan, "--units", "mm"], more].concat());
    let good = measured(&["--tolerance", "0.001", "--no-pictures", "--out", out.to_str().unwrap()]);
    assert_eq!(good.status.code(), Some(0), "{} {}", text(&good.stdout), text(&good.stderr));
    assert!(text(&good.stdout).contains("X -0.20000"), "{}", text(&good.stdout));
    let read = |name: &str| std::fs::read(out.join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&read("measured.json")).unwrap();
    assert!(json["within"] == true && json["points"] == 19 * 19 * 6);
    assert_eq!(text(&read("deviations.csv")).lines().count(), 1 + 19 * 19 * 6);
    assert!(read("deviations.ply").starts_with(b"ply\nformat binary_little_endian"));
    let page = String::from_utf8(read("measured.html")).unwrap();
    for word in ["Scanned part: box.stl", "The part is within the tolerance", "The scan was moved by X ", "scan.csv"] {
        assert!(page.contains(word), "{word}: {page}");
    }
    assert!(page.contains("Share of the points, %") && !page.contains("<img") && !page.contains("http"), "{page}");
    let files = std::fs::read_dir(&out).unwrap().count();
    assert_eq!(files, 5, "four files and the manifest");
    // Where it may not move along X, nor at all, the offset stays.
    for free in ["y,z", "none"] {
        let held = measured(&["--free", free, "--json"]);
        assert_eq!(held.status.code(), Some(3), "{}", text(&held.stderr));
        let json: serde_json::Value = serde_json::from_slice(&held.stdout).unwrap();
        assert!((json["all"]["greatest_mm"].as_f64().unwrap() - 0.2).abs() < 1e-3, "{json}");
    }
    let wrong = measured(&["--free", "x,w"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong.stderr).contains("x, y, z, a, b, c"), "{}", text(&wrong.stderr));
}

#[test]
fn a_bump_is_found_with_its_place_and_height() {
    let folder = tempfile::tempdir().unwrap();
    let [nominal, scan] = box_and_scan(folder.path(), 0.08);
    let output = sparkpath(&["measured", &nominal, &scan, "--units", "mm", "--json"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let worst = &json["worst"][0];
    assert!((worst["deviation_mm"].as_f64().unwrap() - 0.08).abs() < 0.002, "{worst}");
    let at = |i: usize| worst["at_mm"][i].as_f64().unwrap();
    assert!((at(0) - 20.0).abs() < 5.0 && (at(1) - 15.0).abs() < 4.0 && (at(2) - 20.08).abs() < 0.01, "{worst}");
}
