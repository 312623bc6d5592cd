//! Electrodes as mesh files. Those with a check that fails are left out, unless the user overrode it by name.
//!
//! A file holds an electrode in its own axes: the origin is the middle of its base's underside, the tips reach down
//! along -Z. Its name says what a shop needs to know of it, as in `E01_finish_g0.05_copper_x1.stl`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::burn_table::BurnTable;
use crate::measuring_points::{MeasuringPoint, measuring_points};
use crate::setup_sheet::SetUpError;
use crate::step_files::{WrittenStep, count, length, text, written_step};
use files::{ExportFolder, FileError};
use geometry::mesh::unit_normal;
use glam::DVec3;
use import::{glb_bytes, obj_bytes, stl_bytes};
use mold::electrode::design::{Electrode, ElectrodeSet};
use mold::electrode::params::{ElectrodeParams, Orbit, Shape};
use step::write::{Property, PropertyValue, Role, StepPart};
use task::{Cancelled, Task};

/// The longest that a part of a file's name may be (characters).
const LONGEST: usize = 40;

/// A format of electrode files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElectrodeFormat {
    /// Binary STL, mm.
    Stl,
    /// Wavefront OBJ, mm, exact to the last bit.
    Obj,
    /// Binary glTF 2.0.
    Glb,
    /// STEP AP242, with faces.
    Step,
}

impl ElectrodeFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Stl, Self::Obj, Self::Glb, Self::Step];

    /// Ending of file names, and name of the format.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Step => "step",
        }
    }

    /// The bytes of a file of electrode number `e` of `set`; the reason where it has none as STEP.
    fn bytes(
        self,
        (set, table): (&ElectrodeSet, &BurnTable),
        e: usize,
        task: &Task,
    ) -> Result<Result<Vec<u8>, LeftOut>, ElectrodeExportError> {
        let electrode = &set.electrodes[e];
        let made = match self {
            Self::Stl => stl_bytes(&electrode.mesh),
            Self::Obj => obj_bytes(&electrode.name, &electrode.mesh),
            Self::Glb => glb_bytes(&[(&electrode.name, &electrode.mesh)]),
            Self::Step => {
                let left_out = |why| LeftOut { electrode: electrode.name.clone(), format: Some(self), why };
                return Ok(step_of(set, table, e, task)?.map(|file| file.bytes).map_err(left_out));
            }
        };
        let wrong = |source| ElectrodeExportError::Mesh { electrode: electrode.name.clone(), format: self, source };
        made.map(Ok).map_err(wrong)
    }
}

/// Share of the spark gap by which the faces of a STEP file may reach beyond the mesh.
const TO_SPARE: f64 = 0.1;

/// Names of the faces of an electrode.
const FACES: [&str; 3] = ["burning", "base", "datum"];

/// Face of each triangle of an electrode, as its number in [`FACES`].
fn faces_of(electrode: &Electrode) -> Vec<usize> {
    let near = 1e-6 * (1.0 + electrode.base.height);
    let face = |corners: [DVec3; 3]| match corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min) {
        z if z > -near => 2,
        z if z > -electrode.base.height - near => 1,
        _ => 0,
    };
    electrode.mesh.iter_corners().map(face).collect()
}

/// Directions that faces are told apart by, as their normals are nearest to.
const DIRECTIONS: [&str; 6] = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];
/// Points of a face of one direction.
const POINTS: usize = 4;

/// Points of the base and of the burning faces of an electrode on its holder, by the direction of the face, in the axes of its
/// files, whose shape is `shape`. The top of the base lies on the holder. Files of a net shape tell nothing of the burning faces as
/// they are milled.
pub fn points_to_measure(electrode: &Electrode, shape: Shape) -> Vec<MeasuringPoint> {
    let near = 1e-6 * (1.0 + electrode.base.height);
    let names: Vec<String> =
        ["base", "burning"].iter().flat_map(|part| DIRECTIONS.map(|direction| format!("{part} {direction}"))).collect();
    let surface = |corners: [DVec3; 3]| {
        let normal = unit_normal(corners);
        let axis = normal.abs().max_position();
        let direction = 2 * axis + usize::from(normal[axis] < 0.0);
        // The base stands on the plane z = 0, and the tips reach down from it.
        match corners.iter().all(|p| p.z > -near) {
            true => Some(direction).filter(|direction| *direction != 4),
            false => Some(DIRECTIONS.len() + direction).filter(|_| shape == Shape::Undersized),
        }
    };
    let surface_of: Vec<Option<usize>> = electrode.mesh.iter_corners().map(surface).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    measuring_points(&electrode.mesh, &names, &surface_of, POINTS)
}

/// The body that electrode number `e` is of as STEP: burning faces, base and datum have names and colours, and the part has
/// what a shop needs to know of each electrode, with the positions of the burn table.
fn step_of(set: &ElectrodeSet, table: &BurnTable, e: usize, task: &Task) -> Result<WrittenStep, Cancelled> {
    let electrode = &set.electrodes[e];
    let role = |name: &str, colour: [f64; 3]| Role { name: name.to_owned(), colour: Some(colour) };
    let colours = [[0.85, 0.45, 0.20], [0.60, 0.62, 0.66], [0.20, 0.45, 0.80]];
    let roles: Vec<Role> = FACES.iter().zip(colours).map(|(name, colour)| role(name, colour)).collect();
    let role_of: Vec<u16> = faces_of(electrode).into_iter().map(|face| face as u16).collect();
    let (mut properties, mut least_gap, mut quantity) = (Vec::new(), f64::INFINITY, 1);
    for entry in set.body_of(e).into_iter().filter_map(|member| table.electrodes.get(member)) {
        let named = |what: &str| format!("{} {what}", entry.name);
        least_gap = entry.gap_mm.min(least_gap);
        quantity = entry.quantity.max(quantity);
        properties.extend([text(&named("stage"), &entry.stage), text(&named("material"), &entry.material)]);
        properties.push(length(&named("spark gap"), entry.gap_mm));
        for burn in &entry.burns {
            let axes = [("x", burn.x_mm), ("y", burn.y_mm), ("z", burn.z_mm)];
            let burn_named = |what: &str| named(&format!("burn {} {what}", burn.number));
            properties.extend(axes.map(|(axis, value)| length(&burn_named(axis), value)));
            properties.push(Property { name: burn_named("c"), value: PropertyValue::Angle(burn.c_deg.to_radians()) });
        }
    }
    properties.push(count("quantity", quantity));
    let name = &electrode.name;
    let part = StepPart {
        name,
        mesh: &electrode.mesh,
        roles: &roles,
        role_of: &role_of,
        patches: &[],
        properties: &properties,
    };
    written_step(&part, if least_gap.is_finite() { TO_SPARE * least_gap } else { 0.0 }, task)
}

/// Reason why electrodes cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodeExportError {
    /// Told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A mesh that a format cannot hold.
    #[error(
        "electrode {electrode} as {format}: {source}; choose another format, or plan the electrodes again",
        format = format.extension()
    )]
    Mesh {
        /// The electrode.
        electrode: String,
        /// The format.
        format: ElectrodeFormat,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file system's refusal.
    #[error(transparent)]
    Write(#[from] FileError),
    /// The figures have no JSON.
    #[error("the burn table as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// There is no set-up sheet.
    #[error("set-up sheet: {0}; correct the datums, or take them away")]
    SetUp(#[from] SetUpError),
    /// The report has no page.
    #[error(transparent)]
    Page(#[from] files::report::PageError),
}

/// Files written and electrodes left out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct WrittenElectrodes {
    /// The files, in the order of the electrodes.
    pub files: Vec<ElectrodeFile>,
    /// Electrodes without files.
    pub left_out: Vec<LeftOut>,
    /// Reason why there is no burn sheet, if there is none.
    pub no_sheet: Option<String>,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ElectrodeFile {
    /// The electrode.
    pub electrode: String,
    /// The file.
    pub path: PathBuf,
}

/// An electrode that was not written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The electrode.
    pub electrode: String,
    /// The format that it was not written in; none if in no format.
    pub format: Option<ElectrodeFormat>,
    /// Failing checks and the remedy, in words.
    pub why: String,
}

/// Writes all electrodes of a set that may be exported into `folder`, each in all `formats`, to be published. `table` is
/// the set's burn table.
///
/// # Errors
/// [`ElectrodeExportError`].
pub fn write_electrode_files(
    folder: &mut ExportFolder,
    (set, table): (&ElectrodeSet, &BurnTable),
    formats: &[ElectrodeFormat],
    task: &Task,
) -> Result<WrittenElectrodes, ElectrodeExportError> {
    let mut written = WrittenElectrodes::default();
    for (e, (electrode, stem)) in set.electrodes.iter().zip(file_stems(set)).enumerate() {
        let file = |format: ElectrodeFormat| format!("{stem}.{}", format.extension());
        let name = electrode.name.clone();
        if let Some(why) = why_blocked(set, e) {
            written.left_out.push(LeftOut { electrode: name, format: None, why });
            continue;
        }
        // A body of several is one file.
        let is_first = set.body_of(e).first() == Some(&e);
        for &format in formats {
            let path = if is_first {
                match format.bytes((set, table), e, task)? {
                    Ok(bytes) => folder.write(&file(format), &bytes)?,
                    Err(left_out) => {
                        written.left_out.push(left_out);
                        continue;
                    }
                }
            } else {
                folder.path(&file(format))
            };
            if !is_first && !written.files.iter().any(|known| known.path == path) {
                continue;
            }
            written.files.push(ElectrodeFile { electrode: name.clone(), path });
        }
    }
    Ok(written)
}

/// Reason why an electrode may not be exported; none if it may.
pub fn why_blocked(set: &ElectrodeSet, electrode: usize) -> Option<String> {
    if !set.is_blocked(electrode) {
        return None;
    }
    let fails = |e: usize| {
        let is_let_pass = move |kind| set.is_overridden(e, kind, &set.params.overrides);
        set.checks[e].iter().filter(move |finding| !finding.holds && !is_let_pass(finding.kind))
    };
    let told: Vec<String> =
        fails(electrode).map(|finding| format!("{}: {}", finding.kind.name(), finding.text)).collect();
    if told.is_empty() {
        let others = set.body_of(electrode).into_iter().filter(|e| fails(*e).next().is_some());
        let names: Vec<&str> = others.map(|e| set.electrodes[e].name.as_str()).collect();
        return Some(format!("it is one body with {}, of which a check fails", names.join(", ")));
    }
    let name = &set.electrodes[electrode].name;
    let releases: Vec<String> = fails(electrode).map(|finding| format!("{name}:{}", finding.kind.name())).collect();
    Some(format!("{}; correct it, or release it by the override {}", told.join("; "), releases.join(", ")))
}

/// Names of the electrodes' files without their endings, all different even where small and large letters are the same;
/// those of one body have one.
pub fn file_stems(set: &ElectrodeSet) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for e in 0..set.electrodes.len() {
        let body = set.body_of(e);
        if let Some(known) = body.first().and_then(|first| stems.get(*first)) {
            stems.push(known.clone());
            continue;
        }
        let plain = file_stem(&body.iter().map(|e| &set.electrodes[*e]).collect::<Vec<_>>(), &set.params);
        let is_new = |stem: &String| stems.iter().all(|known| !known.eq_ignore_ascii_case(stem));
        // One of so many names is not among those that are known.
        let numbered = (2..stems.len() + 3).map(|n| format!("{plain}_{n}"));
        let stem = std::iter::once(plain.clone()).chain(numbered).find(is_new);
        stems.push(stem.unwrap_or(plain));
    }
    stems
}

/// The name of a body: that of its form, and each stage with its gap and orbit.
fn file_stem(body: &[&Electrode], params: &ElectrodeParams) -> String {
    let mut parts: Vec<String> = Vec::new();
    for electrode in body {
        let stage = &params.stages[electrode.stage];
        if parts.is_empty() {
            parts.push(plain(form(&electrode.name, &stage.name)));
        }
        parts.extend([plain(&stage.name), format!("g{}", stage.gap_mm)]);
        match stage.orbit {
            Orbit::None => {}
            Orbit::Circular { radius_mm } => parts.push(format!("circular{radius_mm}")),
            Orbit::Square { radius_mm } => parts.push(format!("square{radius_mm}")),
        }
    }
    // Who mills it has to know that the gap is still to be taken off.
    if params.shape == Shape::Net {
        parts.push("net".to_owned());
    }
    let quantity = body.iter().map(|e| params.stages[e.stage].quantity).max().unwrap_or(1);
    let material = body.first().map_or(&params.material[..], |electrode| electrode.material(params));
    parts.extend([plain(material), format!("x{quantity}")]);
    parts.join("_")
}

/// The name that the stages of a form share: that of an electrode ends with its stage where there are several.
fn form<'a>(electrode: &'a str, stage: &str) -> &'a str {
    electrode.strip_suffix(&format!("-{stage}")).unwrap_or(electrode)
}

/// Whether a file of this name holds the body that an electrode is of, alone or with other stages of its form.
pub fn is_file_of(file: &str, electrode: &str, stage: &str) -> bool {
    let of_form = file.strip_prefix(&plain(form(electrode, stage)));
    of_form.is_some_and(|rest| rest.starts_with('_') && rest.contains(&format!("_{}_g", plain(stage))))
}

/// Whether a file is called as electrodes are, as in `E01_finish_g0.05_copper_x1.stl`: name, stage, gap, material and
/// quantity.
pub fn is_electrode_file(file: &str) -> bool {
    let stem = ElectrodeFormat::ALL.iter().find_map(|f| file.strip_suffix(f.extension())?.strip_suffix('.'));
    let parts: Vec<&str> = stem.unwrap_or_default().split('_').collect();
    let is_whole = |digits: &str| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    let is_gap = |part: &&str| part.strip_prefix('g').is_some_and(|gap| gap.parse::<f64>().is_ok());
    let is_quantity = |part: &&str| part.strip_prefix('x').is_some_and(is_whole);
    // At least two parts before the gap and one behind it; a number after the quantity tells equal names apart.
    let gap = parts.iter().skip(2).position(is_gap).map(|gap| gap + 2);
    let quantity = parts.iter().rposition(is_quantity);
    let is_last = |quantity: usize| parts.iter().skip(quantity + 1).all(|rest| is_whole(rest));
    gap.zip(quantity).is_some_and(|(gap, quantity)| gap + 1 < quantity && is_last(quantity))
}

/// Text as a part of a file's name on every system.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.chars() {
        let c = if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
        if c.is_ascii_alphanumeric() || !plain.ends_with(['-', '.']) {
            plain.push(c);
        }
    }
    let plain: String = plain.trim_matches(['-', '.']).chars().take(LONGEST).collect();
    if plain.is_empty() { "unnamed".to_owned() } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode_fixtures::set;
    use files::Override;
    use geometry::mesh::Mesh;
    use import::{ImportOptions, import_file};
    use mold::datum::Datum;
    use mold::electrode::design::IdleOverride;
    use mold::electrode::finding::CheckKind;
    use mold::opening::Opening;
    use task::Task;

    fn written(folder: &std::path::Path, set: &ElectrodeSet, formats: &[ElectrodeFormat]) -> WrittenElectrodes {
        let mut folder = ExportFolder::open(folder, "electrodes").unwrap();
        let table = BurnTable::of(set, "mold", Opening::PlusZ, &Datum::default());
        let written = write_electrode_files(&mut folder, (set, &table), formats, &Task::default()).unwrap();
        folder.publish().unwrap();
        written
    }

    #[test]
    fn faces_of_base_and_head_are_measured_in_every_direction_but_that_of_the_holder() {
        let mut electrode = set().electrodes[0].clone();
        let placed = |size: DVec3, at: DVec3| Mesh::cuboid(size).mapped(|p| p + at);
        electrode.mesh = placed(DVec3::new(20.0, 18.0, 10.0), DVec3::new(-10.0, -9.0, 0.0));
        electrode.mesh.append(&placed(DVec3::new(6.0, 5.0, 8.0), DVec3::new(-3.0, -2.5, -8.0)));
        let faces = |shape: Shape| -> Vec<String> {
            let points = points_to_measure(&electrode, shape);
            for point in &points {
                let [x, y, z] = point.point_mm;
                let outwards = point.normal.iter().zip([x, y, z - 1.0]).map(|(n, p)| n * p).sum::<f64>();
                assert!(
                    outwards > 0.0 && point.surface.starts_with(if z < 0.0 { "burning" } else { "base" }),
                    "{point:?}"
                );
            }
            let mut faces: Vec<String> = points.into_iter().map(|point| point.surface).collect();
            faces.dedup();
            faces
        };
        let sides = |part: &str| ["+X", "-X", "+Y", "-Y", "-Z"].map(|side| format!("{part} {side}")).to_vec();
        assert_eq!(faces(Shape::Undersized), [sides("base"), sides("burning")].concat());
        assert_eq!(faces(Shape::Net), sides("base"));
    }

    #[test]
    fn file_names_say_what_a_shop_needs_and_stay_in_their_folder() {
        let mut set = set();
        assert_eq!(
            file_stems(&set),
            ["E01_rough_g0.2_circular0.1_Cu-soft_x2", "E02_finish_g0.05_Cu-soft_x1", "E03_finish_g0.05_Cu-soft_x1"]
        );
        set.params.material = "copper".to_owned();
        set.params.shape = Shape::Net;
        set.electrodes[1].name = "../..\\E3".to_owned();
        set.electrodes[2].name = "e3-finish".to_owned();
        assert_eq!(file_stems(&set)[1..], ["E3_finish_g0.05_net_copper_x1", "e3_finish_g0.05_net_copper_x1_2"]);
        set.electrodes.iter_mut().for_each(|e| (e.name, e.stage) = ("\u{e9}/".to_owned(), 1));
        let stems = file_stems(&set);
        assert_eq!(stems[2], "unnamed_finish_g0.05_net_copper_x1_3");
    }

    #[test]
    fn what_is_blocked_has_no_file_not_even_an_older_one_and_the_reason_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let mut good = set();
        good.checks[2].iter_mut().for_each(|finding| finding.holds = true);
        assert_eq!(written(folder.path(), &good, &[ElectrodeFormat::Stl]).files.len(), 3);
        let old = folder.path().join("E03_finish_g0.05_Cu-soft_x1.stl");
        assert!(old.exists());
        let written = written(folder.path(), &set(), &[ElectrodeFormat::Stl]);
        let names: Vec<&str> = written.files.iter().map(|f| f.electrode.as_str()).collect();
        assert_eq!(names, ["E01", "E02-finish"], "what is overridden is written");
        let [left] = &written.left_out[..] else { panic!("{written:?}") };
        assert!(
            left.electrode == "E03" && left.why.contains("gouge: ") && left.why.contains("watertight: "),
            "{left:?}"
        );
        assert!(!left.why.contains("approach"), "what holds is no reason: {left:?}");
        assert!(!old.exists(), "the file of an earlier export is not taken for one of this");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "two electrodes and the manifest");
    }

    #[test]
    fn electrode_files_are_known_by_their_names() {
        let mut set = set();
        set.electrodes[0].name = "left rib".to_owned();
        set.electrodes[1].name = set.electrodes[2].name.to_lowercase();
        set.params.shape = Shape::Net;
        let ours = file_stems(&set).into_iter().map(|stem| format!("{stem}.stl"));
        let ours: Vec<String> =
            ours.chain(["E102_a_g1_b_x1.glb".to_owned(), "E4_a_g0.3_Cu_x1_2.obj".to_owned()]).collect();
        assert!(ours.iter().all(|file| is_electrode_file(file)), "{ours:?}");
        let others =
            ["Eiffel_g1.stl", "E04_finish_g0.05_Cu-soft_x1.txt", "mold.stl", "part_g1_x2.stl", "a_b_gap_c_x1.stl"];
        assert!(!others.into_iter().any(is_electrode_file));
    }

    #[test]
    fn every_format_is_read_back_as_the_same_solid() {
        let folder = tempfile::tempdir().unwrap();
        let set = set();
        let written = written(folder.path(), &set, &ElectrodeFormat::ALL);
        assert_eq!((written.files.len(), written.left_out.len()), (8, 1), "one is blocked: {:?}", written.left_out);
        for file in &written.files {
            let electrode = set.electrodes.iter().find(|e| e.name == file.electrode).unwrap();
            let read = import_file(&file.path, &ImportOptions::default(), &Task::default()).unwrap();
            assert!(read.report.watertight, "{file:?}");
            if file.path.extension().is_none_or(|e| e != "step") {
                assert_eq!(read.mesh.triangles.len(), electrode.mesh.triangles.len());
            }
            let expected = match file.path.extension().and_then(|e| e.to_str()) {
                // glTF has Y up.
                Some("glb") => electrode.mesh.mapped(|p| glam::DVec3::new(p.x, p.z, -p.y)),
                _ => electrode.mesh.clone(),
            };
            assert!((read.mesh.volume() / expected.volume() - 1.0).abs() < 1e-5, "{file:?}: {}", read.mesh.volume());
            let (found, wanted) = (read.mesh.bounds(), expected.bounds());
            assert!(found.min.distance(wanted.min) + found.max.distance(wanted.max) < 1e-4, "{file:?}: {found:?}");
        }
    }

    #[test]
    fn an_override_for_one_check_lets_only_that_one_pass_and_only_for_the_same_parts() {
        let mut set = set();
        let names = |texts: &[&str]| texts.iter().map(|t| t.parse().unwrap()).collect::<Vec<Override>>();
        set.params.overrides = names(&["E03:gouge"]);
        let why = why_blocked(&set, 2).unwrap();
        assert!(why.contains("watertight: ") && !why.contains("gouge: "), "{why}");
        set.params.overrides = names(&["E03:gouge", "E03:watertight"]);
        assert_eq!(why_blocked(&set, 2), None);
        // As the window decides: for what the electrode burns.
        set.params.overrides = [CheckKind::Gouge, CheckKind::Watertight].map(|kind| set.override_of(2, kind)).to_vec();
        assert!(set.params.overrides[0].parts[0].starts_with("R1.2 "), "{:?}", set.params.overrides[0]);
        assert_eq!(why_blocked(&set, 2), None);
        // What got worse is not what was decided.
        let mut worse = set.clone();
        let finding = worse.checks[2].iter_mut().find(|f| f.kind == CheckKind::Gouge).unwrap();
        finding.figures.insert("found_mm".to_owned(), 1.5);
        let why = why_blocked(&worse, 2).unwrap();
        assert!(why.contains("gouge: ") && !why.contains("watertight: "), "{why}");
        let idle = worse.idle_overrides(&worse.params.overrides);
        assert_eq!(idle.len(), 1);
        assert!(idle[0].1.to_string().contains("found mm is 1.5000, more than the 1.0000"), "{}", idle[0].1);
        // A part that was merged with its neighbour keeps its number and not its area.
        let mut merged = set.clone();
        let tree = merged.regions[0].tree.as_mut().unwrap();
        let square = [glam::DVec2::ZERO, glam::DVec2::X, glam::DVec2::ONE, glam::DVec2::Y].to_vec();
        tree.parts.iter_mut().for_each(|leaf| leaf.outlines.push(square.clone()));
        assert!(why_blocked(&merged, 2).is_some(), "a merged part inherits nothing");
        set.electrodes[2].burns[0].parts[0].part = 4;
        assert!(why_blocked(&set, 2).is_some(), "another plan gave the name to other parts");
        let idle = set.idle_overrides(&set.params.overrides);
        assert!(idle.iter().all(|(_, why)| matches!(why, IdleOverride::Lapsed(why) if why.contains("another part"))));
        assert_eq!(idle.len(), 2);
    }
}
