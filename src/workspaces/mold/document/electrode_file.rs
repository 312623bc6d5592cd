//! Files of what is asked of electrodes.

use std::path::Path;

use super::holder_files::load_holders;
use files::{FileError, TomlFile};
use mold::electrode::params::ElectrodeParams;

/// The file that says what holds without one, with remarks: to be copied and changed.
pub const STANDARD_FILE: &str = include_str!("../../../../assets/electrodes.toml");
/// What this file is called in a user's folder.
pub const FILE_NAME: &str = "electrodes.toml";
/// What is asked of electrodes; see [`STANDARD_FILE`].
pub const ELECTRODES: TomlFile<ElectrodeParams> = TomlFile::new("electrodes");

/// What is asked of electrodes: `electrodes.toml` in `user_folder` if it is there, else what holds without a file. Where it
/// names no holder they are those of [`load_holders`].
///
/// # Errors
/// [`FileError`].
pub fn load_electrodes(user_folder: Option<&Path>) -> Result<ElectrodeParams, FileError> {
    let own = user_folder.map(|folder| ELECTRODES.read_if_there(&folder.join(FILE_NAME))).transpose()?;
    with_holders(own.flatten().unwrap_or_default(), user_folder)
}

/// What is asked of electrodes by the TOML file `file`. Where it names no holder they are those of [`load_holders`].
///
/// # Errors
/// [`FileError`].
pub fn read_electrodes(file: &Path, user_folder: Option<&Path>) -> Result<ElectrodeParams, FileError> {
    with_holders(ELECTRODES.read(file)?, user_folder)
}

/// The parameters with the user's holders if they name none.
fn with_holders(params: ElectrodeParams, user_folder: Option<&Path>) -> Result<ElectrodeParams, FileError> {
    let holders = if params.holders.is_empty() { load_holders(user_folder)? } else { params.holders };
    Ok(ElectrodeParams { holders, ..params })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::workspaces::mold::document::holder_files::{HOLDERS, HOLDERS_FILE_NAME, HolderLibrary};
    use files::Override;
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::electrode::check::CheckKind;
    use mold::electrode::params::{Blanks, Edit, Holder, Method, Orbit, Shape, Stage};

    #[test]
    fn the_standard_file_names_everything_and_says_what_holds_without_it() {
        assert_eq!(ELECTRODES.parse(STANDARD_FILE, Path::new("standard")).unwrap(), ElectrodeParams::default());
        let written: toml::Table = toml::from_str(STANDARD_FILE).unwrap();
        let all = toml::Table::try_from(ElectrodeParams::default()).unwrap();
        let keys = |table: &toml::Table| table.keys().cloned().collect::<Vec<String>>();
        assert_eq!(keys(&all), keys(&written));
        for key in ["blanks", "removal"] {
            assert_eq!(keys(all[key].as_table().unwrap()), keys(written[key].as_table().unwrap()));
        }
        // There is one list of holders: without a file the program's own.
        let with = ElectrodeParams { holders: load_holders(None).unwrap(), ..ElectrodeParams::default() };
        assert_eq!(load_electrodes(None).unwrap(), with);
        assert_eq!(ELECTRODES.parse("", Path::new("empty")).unwrap(), ElectrodeParams::default());
    }

    #[test]
    fn what_is_asked_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(FILE_NAME);
        let orbits = [Orbit::Square { radius_mm: 1.0 / 3.0 }, Orbit::Circular { radius_mm: 0.1 }, Orbit::None];
        let stage = |(i, orbit)| Stage { name: format!("s_{i}"), orbit, quantity: 3, ..Stage::finish(0.2) };
        let place = DVec3::new(0.1, -2.0, 1e-7);
        let library = CutterLibrary { cutter: vec![Cutter::bull_nose(3.0, 0.5), Cutter::ball(0.25)] };
        let params = ElectrodeParams {
            stages: orbits.into_iter().enumerate().map(stage).collect(),
            shape: Shape::Net,
            cutters: Some(library),
            material: "copper \"soft\"".to_owned(),
            edits: vec![
                Edit::Merge { places: [place, DVec3::X] },
                Edit::Split { line: [DVec3::X, DVec3::Y] },
                Edit::Make { place, method: Method::Cutting },
                Edit::Burn { place, direction: DVec3::NEG_X },
            ],
            overrides: vec![
                "E03:approach:0.25".parse().unwrap(),
                "E04-rough:gouge".parse().unwrap(),
                Override { parts: vec!["R1.2 3.25 mm2".to_owned()], .."E05:leftover".parse().unwrap() },
            ],
            holders: vec![Holder { name: "h".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }],
            ..ElectrodeParams::default()
        };
        ELECTRODES.write(&file, &params).unwrap();
        assert_eq!(read_electrodes(&file, None).unwrap(), params);
        assert_eq!(load_electrodes(Some(folder.path())).unwrap(), params, "a user's file comes first");
        let broken = ElectrodeParams { stages: Vec::new(), ..params.clone() };
        assert!(ELECTRODES.write(&file, &broken).is_err());
        assert_eq!(read_electrodes(&file, None).unwrap(), params, "what cannot be written takes nothing away");
    }

    #[test]
    fn a_file_without_holders_has_those_of_the_user_and_one_with_some_has_them() {
        let folder = tempfile::tempdir().unwrap();
        let own = [Holder { name: "mine".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }];
        HOLDERS.write(&folder.path().join(HOLDERS_FILE_NAME), &HolderLibrary { holder: own.to_vec() }).unwrap();
        let file = folder.path().join(FILE_NAME);
        // A table may leave out what stays as it is.
        let round = ELECTRODES.parse("[blanks]\ndiameters_mm = [20.0]", &file).unwrap().blanks;
        assert_eq!(round, Blanks { diameters_mm: vec![20.0], ..Blanks::default() });
        std::fs::write(&file, "margin_mm = 0.5\noverrides = [\"E03:machinable:0.5\", \"E04:gouge\"]").unwrap();
        for read in [load_electrodes(Some(folder.path())), read_electrodes(&file, Some(folder.path()))] {
            let read = read.unwrap();
            assert_eq!((read.margin_mm, &read.holders[..]), (0.5, &own[..]));
            assert_eq!((&*read.overrides[0].of, read.overrides[0].most), ("E03", Some(0.5)));
            assert_eq!(read.overrides[1].check, CheckKind::Gouge.name());
        }
        let named = "[[holders]]\nname = \"other\"\nsize_mm = [1.0, 2.0]\nheight_mm = 2.0";
        std::fs::write(&file, named).unwrap();
        assert_eq!(load_electrodes(Some(folder.path())).unwrap().holders[0].name, "other");
        assert_eq!(read_electrodes(&file, None).unwrap().holders.len(), 1);
    }

    #[test]
    fn what_is_wrong_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.toml");
        for (text, words) in [
            ("margin_mm = -1.0", "line 1: margin_mm is -1: must be from"),
            ("margin_mm = nan", "margin_mm is NaN"),
            ("\nmargin = 1.0", "line 2: margin: unknown field"),
            ("shape = \"big\"", "line 1: shape: unknown variant"),
            ("stages = []", "no stage"),
            (
                "[[stages]]\nname = \"a\"\ngap_mm = 0.1\norbit = { pattern = \"square\", radius_mm = 0.1, turned_deg = 30.0 }",
                "unknown field",
            ),
            ("[[stages]]\nname = \"a b\"\ngap_mm = 0.1\nfinish_vdi = 20.0", "\"a b\""),
            ("[[stages]]\nname = \"a\"\ngap_mm = 9.0\nfinish_vdi = 20.0", "line 3: stages[0].gap_mm is 9"),
            ("[cutters]\n[[cutters.cutter]]\ndiameter_mm = 0.0", "cutters.cutter[0].diameter_mm is 0"),
            ("overrides = [\"E03:gouges\"]", "watertight, gouge, approach, leftover, machinable"),
            ("overrides = [3]", "NAME:CHECK"),
            ("overrides = [\"E03\"]", "names no check of an electrode"),
            ("[[holders]]\nname = \"flat\"\nsize_mm = [1.0, 0.0]\nheight_mm = 2.0", "holder \"flat\": size_mm"),
            ("[blanks]\nsides_mm = [2.0, 1.0]\nincrement_mm = 5.0", "sides must rise"),
            ("[[edits]\n", "line 1"),
        ] {
            std::fs::write(&file, text).unwrap();
            let said = read_electrodes(&file, None).unwrap_err().to_string();
            assert!(said.contains("wrong.toml") && said.contains(words), "{text:?}: {said}");
            assert_eq!(said.lines().count(), 1);
        }
        let none = folder.path().join("none.toml");
        assert!(read_electrodes(&none, None).unwrap_err().is_not_found());
    }
}
