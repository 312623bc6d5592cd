//! Files of what is asked of electrodes.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::holder_files::load_holders;
use files::atomic::atomic_write;
use mold::cutter::CutterError;
use mold::electrode::params::{ElectrodeParams, ElectrodeParamsError, Holder};

/// The file that says what holds without one, with remarks: to be copied and changed.
pub const STANDARD_FILE: &str = include_str!("../../../../assets/electrodes.toml");
/// What this file is called in a user's folder.
pub const FILE_NAME: &str = "electrodes.toml";
/// The largest file that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// The most holders, and the most of any other list.
const MOST_HOLDERS: usize = 256;
const MOST_STAGES: usize = 16;
const MOST_CUTTERS: usize = 256;

/// Why a file of electrodes or holders cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum ElectrodeFileError {
    /// It cannot be read.
    #[error("{file}: cannot be read ({source}); check the path")]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It cannot be written.
    #[error("{file}: cannot be written ({source}); choose another place")]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not what it has to be.
    #[error("{file}: {}{problem}", line.map_or(String::new(), |n| format!("line {n}: ")))]
    Invalid {
        /// The file.
        file: PathBuf,
        /// Where, counted from 1.
        line: Option<usize>,
        /// What is wrong.
        problem: String,
    },
    /// Values that cannot be used.
    #[error("{file}: {source}")]
    Params {
        /// The file.
        file: PathBuf,
        /// Which, and why.
        source: ElectrodeParamsError,
    },
    /// A cutter that is not possible.
    #[error("{file}: cutters: {source}")]
    Cutter {
        /// The file.
        file: PathBuf,
        /// Which, and why.
        source: CutterError,
    },
}

/// What is asked of electrodes: `electrodes.toml` in `user_folder` if it is there, else what holds without a file. Where it
/// names no holder they are those of [`load_holders`].
///
/// # Errors
/// [`ElectrodeFileError`].
pub fn load_electrodes(user_folder: Option<&Path>) -> Result<ElectrodeParams, ElectrodeFileError> {
    let params = match user_file(user_folder, FILE_NAME)? {
        Some((file, text)) => electrodes_of(&file, &text)?,
        None => ElectrodeParams::default(),
    };
    with_holders(params, user_folder)
}

/// What is asked of electrodes by the TOML file `file`; see [`STANDARD_FILE`]. Where it names no holder they are those of
/// [`load_holders`].
///
/// # Errors
/// [`ElectrodeFileError`].
pub fn read_electrodes(file: &Path, user_folder: Option<&Path>) -> Result<ElectrodeParams, ElectrodeFileError> {
    with_holders(electrodes_of(file, &text_of(file)?)?, user_folder)
}

/// The parameters with the user's holders if they name none.
fn with_holders(params: ElectrodeParams, user_folder: Option<&Path>) -> Result<ElectrodeParams, ElectrodeFileError> {
    let holders = if params.holders.is_empty() { load_holders(user_folder)? } else { params.holders };
    Ok(ElectrodeParams { holders, ..params })
}

/// Writes `params` as a TOML file that [`read_electrodes`] reads.
///
/// # Errors
/// [`ElectrodeFileError`], also of parameters that could not be read again; a file already there is then untouched.
pub fn write_electrodes(file: &Path, params: &ElectrodeParams) -> Result<(), ElectrodeFileError> {
    check_electrodes(file, params)?;
    write(file, params)
}

/// The text of a file in a user's folder; none if there is no such file.
pub(super) fn user_file(folder: Option<&Path>, name: &str) -> Result<Option<(PathBuf, String)>, ElectrodeFileError> {
    let Some(file) = folder.map(|f| f.join(name)) else { return Ok(None) };
    match text_of(&file) {
        Ok(text) => Ok(Some((file, text))),
        Err(ElectrodeFileError::Unreadable { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

pub(super) fn text_of(file: &Path) -> Result<String, ElectrodeFileError> {
    let unreadable = |source| ElectrodeFileError::Unreadable { file: file.to_owned(), source };
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        return Err(invalid(file, format!("it has {size} bytes; such a file has at most {LARGEST_FILE}")));
    }
    std::fs::read_to_string(file).map_err(unreadable)
}

pub(super) fn invalid(file: &Path, problem: String) -> ElectrodeFileError {
    ElectrodeFileError::Invalid { file: file.to_owned(), line: None, problem }
}

pub(super) fn parsed<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T, ElectrodeFileError> {
    toml::from_str(text).map_err(|e| {
        let line = |span: std::ops::Range<usize>| text.bytes().take(span.start).filter(|b| *b == b'\n').count() + 1;
        let problem = e.message().replace('\n', " ");
        ElectrodeFileError::Invalid { file: file.to_owned(), line: e.span().map(line), problem }
    })
}

fn electrodes_of(file: &Path, text: &str) -> Result<ElectrodeParams, ElectrodeFileError> {
    let params = parsed(file, text)?;
    check_electrodes(file, &params)?;
    Ok(params)
}

fn check_electrodes(file: &Path, params: &ElectrodeParams) -> Result<(), ElectrodeFileError> {
    params.validate().map_err(|source| ElectrodeFileError::Params { file: file.to_owned(), source })?;
    let cutters = params.cutters.as_ref().map_or(0, |library| library.cutter.len());
    let counts = [
        ("stages", params.stages.len(), MOST_STAGES),
        ("holders", params.holders.len(), MOST_HOLDERS),
        ("cutters", cutters, MOST_CUTTERS),
    ];
    if let Some((what, found, most)) = counts.into_iter().find(|(_, found, most)| found > most) {
        return Err(invalid(file, format!("it has {found} {what}; at most {most} are possible")));
    }
    let Some(library) = &params.cutters else { return Ok(()) };
    library.validate().map_err(|source| ElectrodeFileError::Cutter { file: file.to_owned(), source })
}

/// Holders are possible where parameters with them are.
pub(super) fn check_holders(file: &Path, holders: &[Holder]) -> Result<(), ElectrodeFileError> {
    check_electrodes(file, &ElectrodeParams { holders: holders.to_vec(), ..ElectrodeParams::default() })
}

pub(super) fn write(file: &Path, content: &impl Serialize) -> Result<(), ElectrodeFileError> {
    let text = toml::to_string_pretty(content).map_err(|e| invalid(file, e.to_string()))?;
    let unwritable = |source| ElectrodeFileError::Unwritable { file: file.to_owned(), source };
    atomic_write(file, |out| out.write_all(text.as_bytes())).map_err(unwritable)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::workspaces::mold::document::holder_files::{HOLDERS_FILE_NAME, write_holders};
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::electrode::check::CheckKind;
    use mold::electrode::overrides::Override;
    use mold::electrode::params::{Blanks, Edit, Method, Orbit, Shape, Stage};

    #[test]
    fn the_standard_file_names_everything_and_says_what_holds_without_it() {
        assert_eq!(electrodes_of(Path::new("standard"), STANDARD_FILE).unwrap(), ElectrodeParams::default());
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
        assert_eq!(electrodes_of(Path::new("empty"), "").unwrap(), ElectrodeParams::default());
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
                "E03".parse().unwrap(),
                "E04-rough:gouge".parse().unwrap(),
                Override { parts: vec!["R1.2".to_owned()], .."E05:leftover".parse().unwrap() },
            ],
            holders: vec![Holder { name: "h".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }],
            ..ElectrodeParams::default()
        };
        write_electrodes(&file, &params).unwrap();
        assert_eq!(read_electrodes(&file, None).unwrap(), params);
        assert_eq!(load_electrodes(Some(folder.path())).unwrap(), params, "a user's file comes first");
        let broken = ElectrodeParams { stages: Vec::new(), ..params.clone() };
        assert!(write_electrodes(&file, &broken).is_err());
        assert_eq!(read_electrodes(&file, None).unwrap(), params, "what cannot be written takes nothing away");
    }

    #[test]
    fn a_file_without_holders_has_those_of_the_user_and_one_with_some_has_them() {
        let folder = tempfile::tempdir().unwrap();
        let own = [Holder { name: "mine".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }];
        write_holders(&folder.path().join(HOLDERS_FILE_NAME), &own).unwrap();
        let file = folder.path().join(FILE_NAME);
        // A table may leave out what stays as it is.
        let round = electrodes_of(&file, "[blanks]\ndiameters_mm = [20.0]").unwrap().blanks;
        assert_eq!(round, Blanks { diameters_mm: vec![20.0], ..Blanks::default() });
        std::fs::write(&file, "margin_mm = 0.5\noverrides = [\"E03\", \"E04:gouge\"]").unwrap();
        for read in [load_electrodes(Some(folder.path())), read_electrodes(&file, Some(folder.path()))] {
            let read = read.unwrap();
            assert_eq!((read.margin_mm, &read.holders[..]), (0.5, &own[..]));
            assert_eq!(read.overrides[0], Override { electrode: "E03".to_owned(), check: None, parts: Vec::new() });
            assert_eq!(read.overrides[1].check, Some(CheckKind::Gouge));
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
            ("margin_mm = -1.0", "margin_mm is -1 mm"),
            ("margin_mm = nan", "margin_mm is NaN mm"),
            ("\nmargin = 1.0", "line 2: unknown field"),
            ("shape = \"big\"", "line 1: unknown variant"),
            ("stages = []", "no stage"),
            (
                "[[stages]]\nname = \"a\"\ngap_mm = 0.1\norbit = { pattern = \"square\", radius_mm = 0.1, turned_deg = 30.0 }",
                "unknown field",
            ),
            ("[[stages]]\nname = \"a b\"\ngap_mm = 0.1\nfinish_vdi = 20.0", "\"a b\""),
            ("[[stages]]\nname = \"a\"\ngap_mm = 9.0\nfinish_vdi = 20.0", "gap_mm of stage a is 9 mm"),
            ("[cutters]\n[[cutters.cutter]]\ndiameter_mm = 0.0", "diameter_mm is 0 mm"),
            ("overrides = [\"E03:gouges\"]", "watertight, gouge, approach, leftover, machinable"),
            ("overrides = [3]", "NAME:check"),
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
        assert!(matches!(read_electrodes(&none, None), Err(ElectrodeFileError::Unreadable { .. })));
    }
}
