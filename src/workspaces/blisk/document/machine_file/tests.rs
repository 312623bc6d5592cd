use super::*;
use feed::machine::{AxisSet, HeadAxis};
use std::f64::consts::PI;
use task::Task;

fn read(name: &str) -> Result<MachineModel, MachineFileError> {
    read_machine(name, &Task::default())
}

/// What is wrong with a machine file of this text.
fn complaint(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    std::fs::write(&file, text).unwrap();
    let error = read(file.to_str().unwrap()).unwrap_err().to_string();
    assert!(error.contains("mine.toml") && !error.contains('\n'), "{error}");
    error
}

#[test]
fn the_built_in_machines_have_their_axes_and_bodies_of_every_kind() {
    use AxisSet::{XYZABC, XYZAC, XYZC};
    use HeadAxis::{X, Z};
    for (name, (axes, head)) in BUILT_IN.into_iter().zip([(XYZC, X), (XYZAC, X), (XYZABC, X), (XYZAC, Z)]) {
        let params: MachineParams = toml::Value::Table(machine_table(name).unwrap()).try_into().unwrap();
        assert_eq!((params.axes, params.head_along, params.validate()), (axes, head, Ok(())), "{name}");
        let model = read(name).unwrap();
        for carrier in [Carrier::Electrode, Carrier::Head, Carrier::Table, Carrier::Bed] {
            assert!(model.bodies.iter().any(|b| b.carrier == carrier), "{name} {carrier:?}");
        }
        assert!(model.bodies.iter().all(|b| b.mesh.is_watertight() && b.mesh.volume() > 0.0), "{name}");
    }
    assert!(read("xyzzy").unwrap_err().to_string().contains("xyzc, xyzac, xyzabc"));
}

#[test]
fn a_cylinder_is_never_smaller_than_it_is_given() {
    for axis in 0..3 {
        let centre = DVec3::new(3.0, -2.0, 7.0);
        let mesh = cylinder(40.0, 25.0, axis, centre);
        assert!(mesh.is_watertight());
        let round = PI * 40.0 * 40.0 * 25.0;
        assert!(mesh.volume() > round && mesh.volume() < 1.0004 * round, "{}", mesh.volume());
        let size = mesh.bounds().size();
        assert!((size[axis] - 25.0).abs() < 1e-12);
        let off = |p: DVec3| {
            let mut off = p - centre;
            off[axis] = 0.0;
            off.length()
        };
        // Where the sides are nearest to the axis they touch the cylinder.
        let sides =
            mesh.iter_corners().filter(|t| (t[0][axis] - t[1][axis]).abs() + (t[1][axis] - t[2][axis]).abs() > 1.0);
        let nearest = sides.flat_map(|[a, b, c]| [a.midpoint(b), b.midpoint(c), c.midpoint(a)]);
        let nearest = nearest.map(off).fold(f64::INFINITY, f64::min);
        assert!((nearest - 40.0).abs() < 1e-9, "{nearest}");
    }
}

#[test]
fn mistakes_are_told_in_words() {
    let body = |lines: &str| format!("axes = \"XYZC\"\n[[bodies]]\nname = \"block\"\n{lines}");
    let sized = "shape = \"box\"\nsize_mm = [1, 2, 3]";
    for (text, words) in [
        (body(&format!("carried_by = \"arm\"\n{sized}")), vec!["body block", "arm", "electrode", "bed"]),
        (body("carried_by = \"bed\"\nshape = \"ball\""), vec!["block", "ball", "cylinder"]),
        (body("carried_by = \"bed\"\nshape = \"box\""), vec!["size_mm is missing"]),
        (body("carried_by = \"bed\"\nshape = \"box\"\nsize_mm = [1, -2, 3]"), vec!["size_mm is -2", "greater than 0"]),
        (body("carried_by = \"bed\"\nshape = \"box\"\nsize_mm = [1, inf, 3]"), vec!["size_mm is inf"]),
        (body(&format!("carried_by = \"bed\"\n{sized}\ncentre_mm = [nan, 0, 0]")), vec!["centre_mm holds NaN"]),
        (body(&format!("carried_by = \"bed\"\n{sized}\nradius_mm = 3")), vec!["radius_mm", "cylinder"]),
        (body(&format!("carried_by = \"bed\"\n{sized}\ncolour = 3")), vec!["colour"]),
        (body("carried_by = \"bed\"\nshape = \"cylinder\"\nradius_mm = 3\nlength_mm = 4"), vec!["axis is missing"]),
        (body("carried_by = \"bed\"\nshape = \"mesh\""), vec!["file is missing"]),
        (body("carried_by = \"bed\"\nshape = \"mesh\"\nfile = \"none.stl\""), vec!["body block", "none.stl"]),
        ("[[bodies]\n".to_owned(), vec!["line 1"]),
        ("bodies = 3".to_owned(), vec!["[[bodies]]"]),
        (
            body(&format!("carried_by = \"bed\"\n{sized}\n")).repeat(2).replacen("axes = \"XYZC\"", "", 2),
            vec!["name of its own"],
        ),
        (
            (0..65).map(|i| format!("[[bodies]]\nname = \"{i}\"\ncarried_by = \"bed\"\n{sized}\n")).collect(),
            vec!["65 bodies"],
        ),
    ] {
        let error = complaint(&text);
        assert!(words.iter().all(|w| error.contains(w)), "{error} does not say {words:?}");
    }
    assert!(read("nowhere/mine.toml").unwrap_err().to_string().contains("cannot be read"));
}

#[test]
fn keys_that_a_machine_has_not_are_told_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    for (text, words) in [
        ("travel_q_mm = [-1, 1]", "travel_q_mm"),
        ("travel_x_mm = 3", "travel_x_mm"),
        ("axes = \"XYC\"", "XYC"),
        ("name = \"mine\"", "key of a project"),
    ] {
        std::fs::write(&file, text).unwrap();
        let error = machine_table(file.to_str().unwrap()).unwrap_err().to_string();
        assert!(error.contains("mine.toml: ") && error.contains(words) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn meshes_are_read_beside_the_machine_and_must_be_closed() {
    let folder = tempfile::tempdir().unwrap();
    let (file, ram) = (folder.path().join("mine.toml"), folder.path().join("ram.stl"));
    let text = "[[bodies]]\nname = \"ram\"\ncarried_by = \"head\"\nshape = \"mesh\"\nfile = \"ram.stl\"\n\
                units = \"cm\"\ncentre_mm = [0, 0, 100]";
    std::fs::write(&file, text).unwrap();
    let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
    import::write_stl(&ram, &mesh).unwrap();
    let bounds = read(file.to_str().unwrap()).unwrap().bodies[0].mesh.bounds();
    assert!((bounds.min - DVec3::new(0.0, 0.0, 100.0)).length() < 1e-6);
    assert!((bounds.size() - DVec3::new(20.0, 30.0, 40.0)).length() < 1e-5);
    import::write_stl(&ram, &Mesh { triangles: mesh.triangles[1..].to_vec(), ..mesh }).unwrap();
    assert!(read(file.to_str().unwrap()).unwrap_err().to_string().contains("not closed"));
}
