//! Measured sections given to `inspect`.

use std::fmt::Write;

use task::Task;
use wheel::find_channel::find_channel;
use wheel::options::BliskOptions;

use super::{COMES_OUT, NO_PICTURES, easy_blisk, mesh, part, sparkpath, text};

/// The walls of the easy blisk as a probe would have measured them, each point `off` mm from its wall into the channel.
fn table(off: f64) -> String {
    table_of(|_, _, _| off)
}

/// The same with an error into the channel for each section, side (0 low) and point.
fn table_of(off: impl Fn(usize, usize, usize) -> f64) -> String {
    let mesh = mesh(&easy_blisk());
    let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
    let mut table = "section,side,x,y,z\n".to_owned();
    for v in (0..channel.low.nv).step_by(4) {
        for (i, (side, wall)) in [("low", &channel.low), ("high", &channel.high)].into_iter().enumerate() {
            for u in 0..wall.nu {
                let p = wall.point(u, v);
                let moved = p + off(v, i, u) * wall.normal(u, v);
                writeln!(table, "{v},{side},{},{},{}", moved.x, moved.y, moved.z).unwrap();
            }
        }
    }
    table
}

#[test]
fn measured_walls_are_compared_with_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let (file, part) = (folder.path().join("sections.csv"), part(folder.path()));
    let inspected = |table: &str, limit: &str| {
        std::fs::write(&file, table).unwrap();
        sparkpath(&["inspect", &part, "--sections", file.to_str().unwrap(), "--limit", limit, "--json"])
    };
    let output = inspected(&table(0.0), "0.03");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let [grid, measured] = [&answer["blisk"]["centreline"], &answer["measured"]];
    let length = |of: &serde_json::Value| of["length_mm"].as_f64().unwrap();
    assert!((length(grid) - length(measured)).abs() < 0.05 && length(grid) > 10.0, "{grid} {measured}");
    for wall in 0..2 {
        let figure = |of: &str| measured["walls"][wall][of]["greatest_mm"].as_f64().unwrap();
        assert!(figure("points") < 1e-9, "the surface passes through its points");
        assert!(figure("mesh") < 0.05, "{measured}");
    }
    // Blades 0.05 mm too thick on both sides.
    for (limit, code) in [("0.03", 3), ("0.06", 0)] {
        let output = inspected(&table(0.05), limit);
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(answer["measured"]["within_limit"], code == 0);
        let sides = answer["measured"]["deviation"]["sections"][0]["sides"].as_array().unwrap();
        for side in sides {
            assert!((side["mean_mm"].as_f64().unwrap() - 0.05).abs() < 5e-3, "{side}");
        }
    }
    for (table, named) in [("section,side,x,y,z\na,low,1,2,drei\n", "line 2: z is"), ("", "heading line")] {
        let output = inspected(table, "0.03");
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(named), "{}", text(&output.stderr));
    }
}

/// The rings of the easy blisk, for a project of measured sections.
fn ring() -> String {
    let blisk = easy_blisk();
    let faces = blisk.faces_x();
    let [hub, shroud] = [faces.map(|x| blisk.radii(x).0), faces.map(|x| blisk.radii(x).1)];
    format!(
        "[blisk.sections.ring]\nblades = {}\nfaces_x_mm = {faces:?}\nhub_radius_mm = {hub:?}\nshroud_radius_mm = {shroud:?}\n\
         bore_radius_mm = {:?}\nouter_radius_mm = {:?}\n",
        blisk.blades,
        blisk.bore_radius_mm,
        blisk.outer_radius()
    )
}

/// A table with noise of some micrometres, one section of which is too thin by 0.06 mm at its high wall.
#[test]
fn a_plan_of_measured_sections_tells_what_they_are_off() {
    let folder = tempfile::tempdir().unwrap();
    let noise = |v: usize, side: usize, u: usize| {
        2.0 * ((200 * v + 100 * side + u) as f64 * 0.618_033_988_749_894_9).fract() - 1.0
    };
    let error =
        |v: usize, side: usize, u: usize| 0.004 * noise(v, side, u) + if (v, side) == (12, 1) { -0.06 } else { 0.0 };
    std::fs::write(folder.path().join("sections.csv"), table_of(error)).unwrap();
    let project = folder.path().join("blades.sparkpath");
    let text_of = |limit: f64| {
        format!(
            "kind = \"blisk\"\nversion = 1\n[blisk.sections]\nkind = \"measured\"\nfile = \"sections.csv\"\n\
             limit_mm = {limit}\n{}[electrode]\nenter = \"-x\"\n{COMES_OUT}\n[plan]\nstep_mm = 1.6\nfield_cell_mm = 0.5\n\
             [genetic]\npopulation = 16\ngenerations = 6\n{NO_PICTURES}",
            ring()
        )
    };
    let out = folder.path().join("out");
    std::fs::write(&project, text_of(0.03)).unwrap();
    let output = sparkpath(&["plan", project.to_str().unwrap(), "--out", out.to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let measured = &report["measured"];
    assert_eq!((&measured["holds"], &measured["others"]["limit_mm"]), (&false.into(), &0.03.into()));
    let worst = measured["others"]["sections"].as_array().unwrap().iter().find(|s| s["name"] == "12").unwrap();
    let mean = worst["sides"][1]["mean_mm"].as_f64().unwrap();
    assert!((mean + 0.06).abs() < 6e-3, "{worst}");
    assert!(report["verdict"]["sentence"].as_str().unwrap().contains("on the high wall of section 12"));
    // The walls that are planned for go through the points.
    for section in measured["planned"]["sections"].as_array().unwrap() {
        for side in section["sides"].as_array().unwrap() {
            assert!(side["spread_mm"].as_f64().unwrap() < 4e-3 && side["judged"].as_u64() > Some(60), "{section}");
        }
    }
    let csv = std::fs::read_to_string(out.join("section_deviations.csv")).unwrap();
    let of_worst: Vec<f64> = csv
        .lines()
        .filter(|line| line.starts_with("12,high,"))
        .filter_map(|line| line.rsplit(',').next()?.parse().ok())
        .collect();
    assert!(of_worst.len() > 60 && of_worst.iter().all(|d| (d + 0.06).abs() < 0.012), "{of_worst:?}");
    // Within a limit that is wider, as `inspect` says as well.
    for (limit, code) in [(0.03, 3), (0.08, 0)] {
        std::fs::write(&project, text_of(limit)).unwrap();
        let output = sparkpath(&["inspect", project.to_str().unwrap(), "--json"]);
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
    }
}

#[test]
fn a_project_of_measured_sections_or_of_a_profile_has_the_blades_of_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let blisk = easy_blisk();
    std::fs::write(folder.path().join("sections.csv"), table(0.0)).unwrap();
    let measured = format!("[blisk.sections]\nkind = \"measured\"\nfile = \"sections.csv\"\n{}", ring());
    let profile = format!("[blisk.sections]\nkind = \"profile\"\n{}", toml::to_string(&blisk).unwrap());
    let inspected = |sections: &str| -> serde_json::Value {
        let project = folder.path().join("blades.sparkpath");
        std::fs::write(&project, format!("kind = \"blisk\"\nversion = 1\n{sections}")).unwrap();
        let output = sparkpath(&["inspect", project.to_str().unwrap(), "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let throat = |answer: &serde_json::Value| answer["blisk"]["channel"]["throat"]["width_mm"].as_f64().unwrap();
    let [of_sections, of_profile] = [inspected(&measured), inspected(&profile)];
    for answer in [&of_sections, &of_profile] {
        assert_eq!(answer["blisk"]["repetition"]["blades"], blisk.blades, "{answer}");
    }
    assert!((throat(&of_sections) - throat(&of_profile)).abs() < 0.02);
}
