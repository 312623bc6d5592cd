use glam::DVec2;

use super::*;
use crate::electrode_fixtures::set;
use mold::electrode::base::Base;

fn table() -> BurnTable {
    BurnTable::of(&set(), "shell, upper", Opening::MinusX, &Datum::default())
}

/// The records of a CSV text, by the rules of RFC 4180.
fn records(text: &str) -> Vec<Vec<String>> {
    let (mut records, mut record, mut field, mut inside) = (Vec::new(), Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match (inside, c) {
            (true, '"') if rest.peek() == Some(&'"') => field.extend(rest.next()),
            (_, '"') => inside = !inside,
            (false, ',') => record.push(std::mem::take(&mut field)),
            (false, '\n') => {
                record.push(std::mem::take(&mut field));
                records.push(std::mem::take(&mut record));
            }
            (_, c) => field.push(c),
        }
    }
    assert!(!inside && field.is_empty() && record.is_empty());
    records
}

#[test]
fn the_csv_has_a_row_for_each_burn_and_says_what_the_set_says() {
    let text = table().csv();
    let records = records(&text);
    let (head, rows) = records.split_first().unwrap();
    assert!(rows.iter().all(|row| row.len() == head.len()), "{text}");
    let at = |row: usize, name: &str| rows[row][head.iter().position(|h| h == name).unwrap()].as_str();
    let names = ["E01", "E01", "E02-finish", "E03"];
    assert_eq!(rows.len(), names.len());
    names.iter().enumerate().for_each(|(i, name)| assert_eq!(at(i, "electrode"), *name));
    let place = |row| ["x_mm", "y_mm", "z_mm", "c_deg"].map(|name| at(row, name));
    assert_eq!(place(0), ["12.3457", "-4.5000", "20.0000", "90.0000"]);
    assert_eq!(place(1), ["-1.0000", "0.0000", "0.0000", "-135.0000"], "225 degrees are -135");
    assert_eq!(place(2), ["0.0000", "0.0000", "3.0000", "0.0000"], "a full turn is none, and no zero has a sign");
    assert_eq!(at(3, "c_deg"), "180.0000", "half a turn is written one way only");
    let stage = ["gap_mm", "orbit", "orbit_radius_mm", "undersize_wall_mm", "undersize_floor_mm", "quantity"];
    assert_eq!(stage.map(|name| at(0, name)), ["0.2000", "circular", "0.1000", "0.3000", "0.2000", "2"]);
    assert_eq!(stage.map(|name| at(2, name)), ["0.0500", "none", "0.0000", "0.0500", "0.0500", "1"]);
    // VDI 30 is Ra 3.2 micrometres, as the scale has it.
    assert_eq!([at(0, "finish_vdi"), at(0, "roughness_um")], ["30.0", "3.162"]);
    assert_eq!([at(1, "burn"), at(2, "parts"), at(3, "parts")], ["2", "R2.1 R1.1", "R1.2"]);
    assert_eq!([at(0, "material"), at(0, "holder"), at(2, "holder")], ["Cu, \"soft\"", "holder 25", ""]);
    assert_eq!(["lift_x", "lift_y", "lift_z"].map(|name| at(2, name)), ["-1.000000", "0.000000", "0.000000"]);
    // Turned by 90 degrees about the burn it stands along Y; the axes of the orbit stay.
    assert_eq!(["x_axis_x", "x_axis_y", "x_axis_z"].map(|name| at(0, name)), ["0.000000", "1.000000", "0.000000"]);
    assert_eq!(["orbit_x_axis_x", "orbit_y_axis_y"].map(|name| at(0, name)), ["1.000000", "1.000000"]);
    assert_eq!(["opening", "base_height_mm", "burn_area_mm2"].map(|name| at(0, name)), ["-x", "15.0000", "11.0000"]);
    assert!(at(2, "warnings").contains("no holder is large enough") && at(0, "warnings").is_empty());
    let checks = ["watertight", "gouge", "approach", "leftover", "machinable", "state"];
    assert_eq!(checks.map(|name| at(0, name)), ["ok", "ok", "ok", "ok", "ok", "ok"]);
    assert_eq!(checks.map(|name| at(2, name)), ["ok", "ok", "ok", "overridden", "ok", "overridden"]);
    assert_eq!(checks.map(|name| at(3, name)), ["failed", "failed", "ok", "ok", "not-made", "blocked"]);
}

#[test]
fn the_json_has_the_keys_that_templates_name() {
    let json: serde_json::Value = serde_json::from_str(&table().json().unwrap()).unwrap();
    let keys = |value: &serde_json::Value| {
        let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys.join(" ")
    };
    assert_eq!(
        keys(&json),
        "burns datum electrodes lift_mm material minutes mold not_burned notes opening program_version schema shape to_file"
    );
    let electrode = &json["electrodes"][2];
    assert_eq!(
        keys(electrode),
        "base_height_mm blank burn_area_mm2 burns checks corner_wear_mm end_wear_mm family finish_vdi front_area_mm2 gap_mm \
         holder lift material method minutes name needed orbit quantity rests_on roughness_um shape stage state \
         undersize_floor_mm undersize_wall_mm volume_mm3 warnings"
    );
    assert_eq!(
        keys(&electrode["burns"][0]),
        "c_deg depth_mm minutes number parts pose regions volume_mm3 x_axis x_mm y_mm z_mm"
    );
    assert_eq!(keys(&electrode["checks"][0]), "kind place_mm state text");
    assert_eq!(json["opening"], "-x");
    assert_eq!(json["electrodes"][1]["burns"][0]["regions"], serde_json::json!([1, 2]));
    let gouge = &electrode["checks"][1];
    assert_eq!(gouge["text"], "it comes to 0.0100 mm of the mold: too deep a burn");
    assert_eq!(gouge["place_mm"], serde_json::json!([1.0, 2.0, -3.0]));
    assert_eq!(json["electrodes"][0]["checks"][0]["place_mm"], serde_json::Value::Null);
}

#[test]
fn minutes_are_those_of_the_burns_and_none_where_they_are_not_known() {
    let mut set = set();
    let table = |set: &ElectrodeSet| BurnTable::of(set, "", Opening::PlusZ, &Datum::default());
    let burns: usize = set.electrodes.iter().map(|e| e.burns.len()).sum();
    assert_eq!(table(&set).minutes, Some(6.25 * burns as f64));
    assert_eq!((table(&set).electrodes[0].minutes, table(&set).electrodes[0].volume_mm3), (Some(12.5), 7.0));
    // Set up once, and changed before each burn but the first.
    set.params.technology.overhead = burning::duration::Overhead { setup_min: 20.0, change_min: 3.0 };
    assert_eq!(table(&set).minutes, Some(20.0 + 9.25 * burns as f64 - 3.0));
    set.electrodes[0].burns[0].minutes = None;
    set.electrodes[0].figures = burning::figures::BurnFigures::unknown("rate of step S is not given");
    let unknown = table(&set);
    assert_eq!(
        (unknown.minutes, unknown.electrodes[0].minutes, unknown.electrodes[0].burns[0].minutes),
        (None, None, None)
    );
    assert_eq!((unknown.electrodes[0].end_wear_mm, unknown.electrodes[0].corner_wear_mm), (None, None));
    assert_eq!(unknown.electrodes[0].needed, "at least 1: wear not considered");
    assert!(unknown.electrodes[0].rests_on[0].contains("rate of step S is not given"));
    // Without the comma in the name of the material a cell ends at every comma.
    let csv = unknown.csv().replace("\"Cu, \"\"soft\"\"\"", "Cu");
    let column = csv.lines().next().unwrap().split(',').position(|head| head == "minutes").unwrap();
    assert_eq!(csv.lines().nth(1).unwrap().split(',').nth(column), Some(""), "{csv}");
}

#[test]
fn a_net_shape_is_said_and_keeps_what_it_is_to_be_milled_smaller_by() {
    let mut set = set();
    set.params.shape = Shape::Net;
    set.params.blanks.diameters_mm = vec![12.0, 15.0, 16.0];
    let table = BurnTable::of(&set, "", Opening::PlusZ, &Datum::default());
    assert_eq!(table.electrodes[0].shape, Shape::Net);
    assert!((table.electrodes[0].undersize_wall_mm - 0.3).abs() < 1e-12);
    // The diagonal of 10 by 12 is 15.6.
    assert_eq!(table.electrodes[0].blank.diameter_mm, Some(16.0));
    set.electrodes[0].base = Base { sides: DVec2::splat(12.0), is_round: true, ..set.electrodes[0].base };
    set.electrodes[0].blank = DVec3::new(12.0, 12.0, 25.0);
    let round = BurnTable::of(&set, "", Opening::PlusZ, &Datum::default()).electrodes[0].blank.clone();
    assert_eq!((round.diameter_mm, round.text(" x ").as_str()), (Some(12.0), "round 12 x 25"));
    assert!(table.csv().contains(",net,"));
    let told = table.electrodes[0].warnings.join(" ");
    assert!(told.contains("smaller by 0.3000 mm at the sides and 0.2000 mm at the bottom"), "{told}");
}

/// A point moved by a pose, as whoever reads the table moves it.
fn moved(pose: &Pose, p: DVec3) -> DVec3 {
    let row = |i: usize| pose[i][0] * p.x + pose[i][1] * p.y + pose[i][2] * p.z + pose[i][3];
    DVec3::new(row(0), row(1), row(2))
}

#[test]
fn poses_put_an_electrode_where_its_burn_does_whatever_the_direction() {
    let set = set();
    let table = BurnTable::of(&set, "", Opening::MinusY, &Datum::default());
    let points = [DVec3::ZERO, DVec3::new(1.0, 2.0, -5.0), DVec3::new(-3.0, 0.5, 1.0)];
    for (electrode, entry) in set.electrodes.iter().zip(&table.electrodes) {
        let turned = to_burn_frame(electrode.direction);
        for (burn, told) in electrode.burns.iter().zip(&entry.burns) {
            let mesh = geometry::mesh::Mesh { vertices: points.to_vec(), triangles: Vec::new() };
            let placed = electrode.burning(&mesh, burn, &turned);
            for (p, in_frame) in points.iter().zip(&placed.vertices) {
                let expected = turned.transpose() * *in_frame;
                let found = moved(&told.pose, *p);
                assert!(found.distance(expected) < 2e-4, "{}: {found} {expected}", entry.name);
                let in_file = moved(&table.to_file, found);
                assert!(Opening::MinusY.upright(in_file).distance(found) < 1e-9);
            }
            // The two unit vectors that the CSV has are the pose's own columns.
            let column = |i: usize| [told.pose[0][i], told.pose[1][i], told.pose[2][i]];
            assert_eq!((column(0), column(2)), (told.x_axis, entry.lift));
        }
    }
}

/// The datum changes positions, and nothing else: what is told leads to the same places of the mold's file.
#[test]
fn a_datum_moves_every_position_and_no_electrode() {
    let opening = Opening::along(DVec3::new(0.3, -0.5, 0.8)).unwrap();
    let datum = Datum { name: "corner".to_owned(), origin_mm: DVec3::new(12.5, -40.0, 7.0), angle_deg: 25.0 };
    let set = set();
    let [plain, table] = [Datum::default(), datum.clone()].map(|datum| BurnTable::of(&set, "", opening, &datum));
    assert_eq!((table.datum.name.as_str(), table.datum.origin_mm), ("corner", [12.5, -40.0, 7.0]));
    let axes = datum.axes(opening);
    let in_file = |table: &BurnTable, p: [f64; 3]| moved(&table.to_file, p.into());
    let turned = |table: &BurnTable, v: [f64; 3]| in_file(table, v) - in_file(table, [0.0; 3]);
    for (a, b) in plain.electrodes.iter().zip(&table.electrodes) {
        for (v, w) in [(a.lift, b.lift), (a.orbit.x_axis, b.orbit.x_axis), (a.orbit.y_axis, b.orbit.y_axis)] {
            assert!(turned(&plain, v).distance(turned(&table, w)) < 1e-9);
        }
        for (a, b) in a.burns.iter().zip(&b.burns) {
            let [p, q] = [(&plain, a), (&table, b)].map(|(table, b)| in_file(table, [b.x_mm, b.y_mm, b.z_mm]));
            assert!(p.distance(q) < 3e-4, "{p} {q}");
            // By the definition of coordinates: distances from the datum along its axes.
            let own = axes.map(|axis| axis.dot(p - datum.origin_mm));
            assert!(DVec3::from(own).distance(DVec3::new(b.x_mm, b.y_mm, b.z_mm)) < 3e-4);
            let tip = DVec3::new(3.0, -1.0, -20.0);
            let [p, q] = [(&plain, a), (&table, b)].map(|(table, b)| in_file(table, moved(&b.pose, tip).to_array()));
            assert!(p.distance(q) < 3e-4, "{p} {q}");
            assert_eq!((a.depth_mm, a.volume_mm3, &a.parts), (b.depth_mm, b.volume_mm3, &b.parts));
        }
        for (a, b) in a.checks.iter().zip(&b.checks) {
            let [p, q] = [(&plain, a), (&table, b)].map(|(table, c)| c.place_mm.map(|place| in_file(table, place)));
            assert!(p.zip(q).map_or(p == q, |(p, q)| p.distance(q) < 3e-4));
            assert_eq!((a.state, &a.text), (b.state, &b.text));
        }
    }
    // Straight down C is counted from the datum's X axis, which lies 25 degrees further on.
    let [a, b] = [&plain, &table].map(|table| table.electrodes[0].burns[0].c_deg);
    assert_eq!((a, b), (90.0, 65.0));
    let row = table.csv().lines().nth(1).unwrap().to_owned();
    assert!(row.ends_with(",corner,12.5000,-40.0000,7.0000,25.0000") && row.contains("\"0.3,-0.5,0.8\""), "{row}");
}
