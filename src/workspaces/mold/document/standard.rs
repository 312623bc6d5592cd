//! Parameters of a new mold: the user's standard, a project without a mesh.

use std::path::Path;

use super::MoldParams;
use super::holder_files::load_holders;
use files::{Document, FileError};

/// The built-in standard with comments, to be copied and changed.
pub const STANDARD: &str = include_str!("../../../../assets/mold.sparkpath");
/// Name of the user's standard in the user's folder.
pub const STANDARD_FILE: &str = "mold.sparkpath";

/// Parameters of a new mold: `mold.sparkpath` in `user_folder` if it exists, without its mesh and decisions for that;
/// else the built-in standard. Without holders it gets those of [`load_holders`].
///
/// # Errors
/// [`FileError`].
pub fn standard_mold(user_folder: Option<&Path>) -> Result<MoldParams, FileError> {
    let own = user_folder.map(|folder| folder.join(STANDARD_FILE)).filter(|file| file.exists());
    let params = match own {
        Some(file) => {
            let own = Document::<MoldParams>::open(&file)?;
            MoldParams { mesh: None, part: None, solids: Vec::new(), obstacles: Vec::new(), ..own.params().undecided() }
        }
        None => MoldParams::default(),
    };
    with_holders(params, user_folder)
}

/// The parameters in a project. Without holders they get those of [`load_holders`].
///
/// # Errors
/// [`FileError`].
pub fn open_mold(project: &Path, user_folder: Option<&Path>) -> Result<MoldParams, FileError> {
    with_holders(Document::<MoldParams>::open(project)?.params().clone(), user_folder)
}

/// The parameters with the user's holders, if they name none.
fn with_holders(mut params: MoldParams, user_folder: Option<&Path>) -> Result<MoldParams, FileError> {
    if params.electrodes.holders.is_empty() {
        params.electrodes.holders = load_holders(user_folder)?;
    }
    Ok(params)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use glam::DVec3;

    use super::*;
    use crate::workspaces::mold::document::holder_files::{HOLDERS, HOLDERS_FILE_NAME, HolderLibrary};
    use files::Override;
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::electrode::finding::CheckKind;
    use mold::electrode::params::{Blanks, Edit, ElectrodeParams, Holder, Method, Orbit, Shape, Stage};

    /// The electrodes asked for in a project with this text after its kind.
    fn parsed(text: &str) -> ElectrodeParams {
        let text = format!("kind = \"mold\"\n{text}");
        Document::<MoldParams>::parse(&text, Path::new("")).unwrap().params().electrodes.clone()
    }

    #[test]
    fn the_standard_names_everything_and_says_what_holds_without_it() {
        let standard = Document::<MoldParams>::parse(STANDARD, Path::new("")).unwrap();
        assert_eq!(*standard.params(), MoldParams::default());
        let written: toml::Table = toml::from_str(STANDARD).unwrap();
        let all = toml::Table::try_from(MoldParams::default()).unwrap();
        let keys = |table: &toml::Table| table.keys().cloned().collect::<Vec<String>>();
        let own = keys(&written).into_iter().filter(|key| key != "kind");
        // The cutters are in a file of their own.
        assert!(own.eq(keys(&all).into_iter().filter(|key| key != "library")));
        assert_eq!(keys(written["layers"].as_table().unwrap()), keys(all["layers"].as_table().unwrap()));
        let [all, written] = [&all, &written].map(|table| table["electrodes"].as_table().unwrap());
        assert_eq!(keys(all), keys(written));
        for key in ["blanks", "technology"] {
            assert_eq!(keys(all[key].as_table().unwrap()), keys(written[key].as_table().unwrap()));
        }
        // There is one list of holders: without a file the program's own.
        let mut with = MoldParams::default();
        with.electrodes.holders = load_holders(None).unwrap();
        assert_eq!(standard_mold(None).unwrap(), with);
    }

    #[test]
    fn what_is_asked_of_electrodes_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(STANDARD_FILE);
        let orbits = [Orbit::Square { radius_mm: 1.0 / 3.0 }, Orbit::Circular { radius_mm: 0.1 }, Orbit::None];
        let stage = |(i, orbit)| Stage { name: format!("s_{i}"), orbit, quantity: 3, ..Stage::finish(0.2) };
        let place = DVec3::new(0.1, -2.0, 1e-7);
        let library = CutterLibrary { cutter: vec![Cutter::bull_nose(3.0, 0.5), Cutter::ball(0.25)] };
        let electrodes = ElectrodeParams {
            stages: orbits.into_iter().enumerate().map(stage).collect(),
            shape: Shape::Net,
            cutters: Some(library),
            material: "copper \"soft\"".to_owned(),
            edits: vec![
                Edit::Merge { places: [place, DVec3::X] },
                Edit::Split { line: [DVec3::X, DVec3::Y] },
                Edit::SplitAlong { place },
                Edit::Make { place, method: Method::Cutting },
                Edit::Burn { place, direction: DVec3::NEG_X },
                Edit::SetAside { place },
                Edit::Join { places: [place, DVec3::X] },
                Edit::TakeApart { place },
                Edit::Copy { places: [place, DVec3::X] },
            ],
            overrides: vec![
                "E03:approach:0.25".parse().unwrap(),
                "E04-rough:gouge".parse().unwrap(),
                Override { parts: vec!["R1.2 3.25 mm2".to_owned()], .."E05:leftover".parse().unwrap() },
            ],
            holders: vec![Holder { name: "h".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }],
            ..ElectrodeParams::default()
        };
        let mesh: PathBuf = folder.path().join("part.stl");
        let params = MoldParams { mesh: Some(mesh), electrodes, tolerance_mm: 0.07, ..MoldParams::default() };
        Document::new(params.clone()).export(&file).unwrap();
        assert_eq!(open_mold(&file, None).unwrap(), params);
        // As a standard it says nothing of the mold that it was saved for.
        let standard = standard_mold(Some(folder.path())).unwrap();
        assert_eq!(standard, MoldParams { mesh: None, ..params.undecided() });
        let mut broken = params.clone();
        broken.electrodes.stages.clear();
        assert!(Document::new(broken).export(&file).is_err());
        assert_eq!(open_mold(&file, None).unwrap(), params, "what cannot be written takes nothing away");
    }

    #[test]
    fn a_project_without_holders_has_those_of_the_user_and_one_with_some_has_them() {
        let folder = tempfile::tempdir().unwrap();
        let own = [Holder { name: "mine".to_owned(), size_mm: [30.0, 31.5], height_mm: 12.0 }];
        HOLDERS.write(&folder.path().join(HOLDERS_FILE_NAME), &HolderLibrary { holder: own.to_vec() }).unwrap();
        let file = folder.path().join(STANDARD_FILE);
        // A table may leave out what stays as it is.
        let round = parsed("[electrodes.blanks]\ndiameters_mm = [20.0]").blanks;
        assert_eq!(round, Blanks { diameters_mm: vec![20.0], ..Blanks::default() });
        let text =
            "kind = \"mold\"\n[electrodes]\nmargin_mm = 0.5\noverrides = [\"E03:machinable:0.5\", \"E04:gouge\"]";
        std::fs::write(&file, text).unwrap();
        let read = open_mold(&file, Some(folder.path())).unwrap().electrodes;
        assert_eq!((read.margin_mm, &read.holders[..]), (0.5, &own[..]));
        assert_eq!((&*read.overrides[0].of, read.overrides[0].most), ("E03", Some(0.5)));
        assert_eq!(read.overrides[1].check, CheckKind::Gouge.name());
        let standard = standard_mold(Some(folder.path())).unwrap().electrodes;
        assert!(standard.margin_mm == 0.5 && standard.overrides.is_empty());
        let named = "kind = \"mold\"\n[[electrodes.holders]]\nname = \"other\"\nsize_mm = [1.0, 2.0]\nheight_mm = 2.0";
        std::fs::write(&file, named).unwrap();
        assert_eq!(standard_mold(Some(folder.path())).unwrap().electrodes.holders[0].name, "other");
        assert_eq!(open_mold(&file, Some(folder.path())).unwrap().electrodes.holders.len(), 1);
    }

    #[test]
    fn what_is_wrong_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.sparkpath");
        let stages = "[[electrodes.stages]]\nname = \"a\"\n";
        for (text, words) in [
            ("[electrodes]\nmargin_mm = -1.0".to_owned(), "line 3: electrodes.margin_mm is -1: must be from"),
            ("[electrodes]\nmargin_mm = nan".to_owned(), "margin_mm is nan"),
            ("\n[electrodes]\nmargin = 1.0".to_owned(), "line 4: electrodes.margin: unknown field"),
            ("[electrodes]\nshape = \"big\"".to_owned(), "line 3: electrodes.shape: unknown variant"),
            ("[electrodes]\nstages = []".to_owned(), "no stage"),
            (
                format!("{stages}gap_mm = 0.1\norbit = {{ pattern = \"square\", radius_mm = 0.1, turned_deg = 30.0 }}"),
                "unknown field",
            ),
            ("[[electrodes.stages]]\nname = \"a b\"\ngap_mm = 0.1\nfinish_vdi = 20.0".to_owned(), "\"a b\""),
            (format!("{stages}gap_mm = 9.0"), "line 4: electrodes.stages[0].gap_mm is 9"),
            ("[[electrodes.cutters.cutter]]\ndiameter_mm = 0.0".to_owned(), "cutters.cutter[0].diameter_mm is 0"),
            (
                "[electrodes]\noverrides = [\"E03:gouges\"]".to_owned(),
                "watertight, gouge, approach, leftover, machinable",
            ),
            ("[electrodes]\noverrides = [3]".to_owned(), "NAME:CHECK"),
            (
                "[[electrodes.holders]]\nname = \"flat\"\nsize_mm = [1.0, 0.0]\nheight_mm = 2.0".to_owned(),
                "holders[0].size_mm",
            ),
            ("[electrodes.blanks]\nsides_mm = [2.0, 1.0]\nincrement_mm = 5.0".to_owned(), "sides must rise"),
            ("[layers]\nspacing_mm = 0.0".to_owned(), "line 3: layers.spacing_mm is 0"),
            ("grid_step_mm = 5.0".to_owned(), "line 2: grid_step_mm is 5: must be from"),
            ("[[edits]\n".to_owned(), "line 2"),
        ] {
            std::fs::write(&file, format!("kind = \"mold\"\n{text}")).unwrap();
            let said = open_mold(&file, None).unwrap_err().to_string();
            assert!(said.contains("wrong.sparkpath") && said.contains(words), "{text:?}: {said}");
            assert_eq!(said.lines().count(), 1);
        }
        assert!(open_mold(&folder.path().join("none.sparkpath"), None).unwrap_err().is_not_found());
    }
}
