//! Files of points: every format, and whatever is broken.

use geometry::mesh::Mesh;
use glam::DVec3;
use import::{ImportLimits, stl_bytes};
use proptest::prelude::*;
use task::Task;

use crate::MeasuredError;
use crate::points::{PointFormat, PointLimits, ScanPoints, points_from_bytes, read_points};

fn read(bytes: &[u8]) -> Result<ScanPoints, MeasuredError> {
    points_from_bytes("scan.dat", bytes, &PointLimits::default(), &Task::default())
}

fn refused(bytes: &[u8]) -> String {
    let text = read(bytes).unwrap_err().to_string();
    assert!(text.starts_with("scan.dat: ") && !text.contains('\n'), "{text}");
    text
}

fn three() -> Vec<DVec3> {
    vec![DVec3::new(1.5, -2.0, 3.0), DVec3::new(0.25, 4.0, -1e-3), DVec3::new(100.0, 0.0, 7.0)]
}

#[test]
fn text_is_read_however_its_columns_are_separated() {
    for text in [
        "1.5 -2 3\n0.25 4 -1e-3\n100 0 7\n",
        "  1.5   -2 3 0 0 1\r\n0.25 4 -1e-3 0 0 1\r\n\r\n100 0 7 0 0 1",
        "1.5,-2,3\r0.25, 4, -1e-3\r100,0,7",
        "x;y;z\n1,5;-2;3,0\n0,25;4;-0,001\n100;0;7;\n",
        "X [mm]\tY [mm]\tZ [mm]\n1,5\t-2\t3\n0,25\t4\t-0,001\n100\t0\t7\n",
        "# made by a scanner\n// twice\n3\n1.5 -2 3\n0.25 4 -1e-3\n100 0 7",
        "\"id\",\"nx\",\"z\",\"y_mm\",\"X(mm)\"\n1,0,3,-2,1.5\n2,0,-1e-3,4,0.25\n3,0,7,0,\"100\"\n",
        "\u{feff}px py pz\n1.5 -2 3\n0.25 4 -1e-3\n100 0 7",
    ] {
        let scan = read(text.as_bytes()).unwrap();
        assert_eq!((scan.points, scan.format), (three(), PointFormat::Text), "{text}");
    }
}

#[test]
fn broken_text_is_refused_with_its_line() {
    for (text, words) in [
        ("1 2 3\n4 5\n", "line 2: 2 columns found where 3 are needed"),
        ("1 2 3\n4 5 six\n", "line 2: column 3 is \"six\""),
        ("1 2 3\n\n4 nan 5\n", "line 3: (4, NaN, 5) is no point"),
        ("1 2 1e9\n", "line 1: (1, 2, 1000000000) is no point"),
        ("1,5 2,0 3,0\n", "line 1: column 2 is \"5 2\""),
        ("1.000,5;2;3\n", "line 1: column 1 is"),
        ("x [inch],y [inch],z [inch]\n1,2,3\n", "line 1: column 1 is in inch"),
        ("a b c d\n1 2 3 4\n", "line 1: the header does not name"),
        ("x_nominal;x_measured;y;z\n1;2;3;4\n", "line 1: the header does not name"),
        ("x y z\n", "holds no points"),
        ("# nothing\n", "holds no points"),
        ("", "the file is empty"),
        ("1 2 3\0\0", "unknown content"),
    ] {
        let refused = refused(text.as_bytes());
        assert!(refused.contains(words), "{text:?}: {refused}");
    }
}

fn ply(format: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment by a scanner\nelement camera 1\nproperty list uchar short view\nelement vertex \
         3\nproperty double x\nproperty float nx\nproperty double y\nproperty double z\nelement face 1\nproperty list \
         uchar int vertex_indices\nend_header\n"
    );
    [header.as_bytes(), body].concat()
}

fn binary(is_big: bool) -> Vec<u8> {
    let order = |mut bytes: Vec<u8>| {
        if is_big {
            bytes.reverse();
        }
        bytes
    };
    let mut body = vec![2];
    body.extend([order(7i16.to_le_bytes().to_vec()), order((-7i16).to_le_bytes().to_vec())].concat());
    for p in three() {
        body.extend(order(p.x.to_le_bytes().to_vec()));
        body.extend(order(0.5f32.to_le_bytes().to_vec()));
        body.extend(order(p.y.to_le_bytes().to_vec()));
        body.extend(order(p.z.to_le_bytes().to_vec()));
    }
    ply(if is_big { "binary_big_endian" } else { "binary_little_endian" }, &body)
}

fn ascii() -> Vec<u8> {
    ply("ascii", b"2 7 -7\n1.5 0.5 -2 3\n0.25 0.5 4 -1e-3\n100 0.5 0 7\n3 0 1 2\n")
}

#[test]
fn ply_is_read_in_all_three_encodings() {
    let returns: Vec<u8> =
        ascii().iter().flat_map(|b| if *b == b'\n' { vec![b'\r', b'\n'] } else { vec![*b] }).collect();
    for bytes in [ascii(), returns, binary(false), binary(true)] {
        let scan = read(&bytes).unwrap();
        assert_eq!((scan.points, scan.format), (three(), PointFormat::Ply));
    }
}

#[test]
fn broken_ply_is_refused() {
    let with = |from: &str, to: &str| String::from_utf8(ascii()).unwrap().replace(from, to).into_bytes();
    for (bytes, words) in [
        (with("end_header", "end"), "line 13: the header has a line that cannot be read: \"end\""),
        (with("vertex 3", "vertex 4000000000"), "4000000000 points exceed the limit of 20000000"),
        (with("vertex 3", "vertex 300"), "the file ends before all vertices"),
        (with("double x", "double w"), "the element vertex has no x, y and z"),
        (with("double x", "number x"), "line 7: a property cannot be read"),
        (with("ascii", "text"), "the header has a line that cannot be read"),
        (with("format ascii 1.0\n", ""), "there is no format"),
        (with("element vertex 3", "element point 3"), "there is no element vertex"),
        (with("1.5 0.5 -2", "1.5 0.5 wide"), "is not a number"),
        (with("2 7 -7", "-2 7 -7"), "a list has -2 items"),
        (with("0.25", "inf"), "is no point of a part"),
        (ascii()[..60].to_vec(), "there is no end_header"),
        (binary(false)[..binary(false).len() - 9].to_vec(), "the file ends before all vertices"),
    ] {
        let refused = refused(&bytes);
        assert!(refused.contains(words), "{words}: {refused}");
    }
}

#[test]
fn meshes_give_their_vertices() {
    let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
    let scan = read(&stl_bytes(&mesh).unwrap()).unwrap();
    assert_eq!((scan.points.len(), scan.format), (8, PointFormat::Mesh));
    assert!(mesh.vertices.iter().all(|v| scan.points.contains(v)), "in mm however small");
}

#[test]
fn limits_hold_and_files_that_are_not_there_are_told() {
    let two = PointLimits { max_points: 2, ..PointLimits::default() };
    for bytes in [ascii(), b"1 2 3\n4 5 6\n7 8 9".to_vec(), stl_bytes(&Mesh::cuboid(DVec3::ONE)).unwrap()] {
        let refused = points_from_bytes("scan", &bytes, &two, &Task::default()).unwrap_err();
        assert!(matches!(refused, MeasuredError::TooManyPoints { limit: 2, .. }), "{refused}");
    }
    let missing = read_points("/nowhere/scan.xyz".as_ref(), &two, &Task::default()).unwrap_err().to_string();
    assert!(missing.starts_with("/nowhere/scan.xyz: cannot be read"), "{missing}");
    let folder = read_points(&std::env::temp_dir(), &two, &Task::default()).unwrap_err().to_string();
    assert!(folder.contains("is a folder"), "{folder}");
    let own = file!().rsplit('/').next().map(|name| format!("{}/tests/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let small = PointLimits { import: ImportLimits { max_file_bytes: 10, ..ImportLimits::default() }, ..two };
    let large = read_points(own.as_ref(), &small, &Task::default()).unwrap_err().to_string();
    assert!(large.contains("exceed the limit of 10"), "{large}");
}

/// Whatever is read is a list of finite points, or one line that names the file.
fn is_sound(bytes: &[u8]) -> Result<(), TestCaseError> {
    let limits = PointLimits { max_points: 100, ..PointLimits::default() };
    match points_from_bytes("scan.dat", bytes, &limits, &Task::default()) {
        Ok(scan) => {
            prop_assert!(!scan.points.is_empty() && scan.points.len() <= 100);
            prop_assert!(scan.points.iter().all(|p| p.is_finite()));
        }
        Err(e) => {
            let text = e.to_string();
            prop_assert!(text.contains("scan.dat") && !text.contains('\n'), "{}", text);
        }
    }
    Ok(())
}

fn examples() -> Vec<Vec<u8>> {
    let text = b"x;y;z\n1,5;-2;3,0\n0,25;4;-0,001\n100;0;7;\n".to_vec();
    let stl = stl_bytes(&Mesh::cuboid(DVec3::ONE)).unwrap();
    vec![ascii(), binary(false), binary(true), text, b"1 2 3\n4 5 6\n".to_vec(), stl]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn files_with_changed_bytes_are_read_or_refused(
        which in 0usize..6,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let mut bytes = examples().swap_remove(which);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if is_cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        is_sound(&bytes)?;
    }

    #[test]
    fn words_in_any_order_are_read_or_refused(
        words in prop::collection::vec(prop::sample::select(WORDS.to_vec()), 0..60),
        tail in prop::collection::vec(any::<u8>(), 0..40),
    ) {
        is_sound(&[words.concat().as_bytes(), &tail].concat())?;
        is_sound(&[b"ply\nformat binary_big_endian 1.0\n", words.concat().as_bytes(), &tail].concat())?;
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        is_sound(&bytes)?;
    }
}

/// Pieces of files.
const WORDS: [&str; 24] = [
    "ply\n",
    "format ascii 1.0\n",
    "format binary_little_endian 1.0\n",
    "element vertex 3\n",
    "element face 18446744073709551615\n",
    "element vertex 99999999999999999999\n",
    "property float x\n",
    "property double y\n",
    "property char z\n",
    "property list uchar int a\n",
    "property list double double b\n",
    "end_header\n",
    "1 ",
    "-2.5 ",
    "1e300 ",
    "nan ",
    "\n",
    ";",
    ",",
    "\t",
    "\"",
    "x",
    "solid ",
    "# ",
];
