//! Files of molds: the mesh, the question about it and the cutters.

use std::path::Path;

use super::MoldParams;
use files::paths::{folder_of, has_ending, relative, without_detours};
use files::{FileError, TomlFile};

/// How the name of such a file ends.
pub const ENDING: &str = ".sparkmold";
const MOLD: TomlFile<MoldParams> = TomlFile::new("mold");

/// Whether `path` is named as a file of a mold.
pub fn is_mold_file(path: &Path) -> bool {
    has_ending(path, ENDING)
}

/// Writes `params` as a TOML file, with the mesh as seen from the file's folder.
///
/// # Errors
/// [`FileError`], also of parameters that could not be read again.
pub fn write_mold(file: &Path, params: &MoldParams) -> Result<(), FileError> {
    let folder = folder_of(file);
    let mesh = params.mesh.as_deref().map(|mesh| relative(mesh, &folder));
    MOLD.write(file, &MoldParams { mesh, ..params.clone() })
}

/// The parameters in a file that [`write_mold`] has written.
///
/// # Errors
/// [`FileError`].
pub fn read_mold(file: &Path) -> Result<MoldParams, FileError> {
    let mut params = MOLD.read(file)?;
    let folder = folder_of(file);
    params.mesh = params.mesh.map(|mesh| without_detours(&folder.join(mesh)));
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mold::cutter::Cutter;
    use mold::electrode::params::Edit;
    use mold::opening::Opening;

    #[test]
    fn a_mold_is_read_as_it_was_written_and_finds_its_mesh_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let [here, there] = ["here", "there"].map(|name| folder.path().join(name));
        [&here, &there].into_iter().for_each(|f| std::fs::create_dir(f).unwrap());
        let mut params = MoldParams { mesh: Some(here.join("part.stl")), ..MoldParams::default() };
        (params.opening, params.tolerance_mm) = (Opening::MinusX, 0.05);
        params.electrodes.edits.push(Edit::Split { line: [glam::DVec3::X, glam::DVec3::Y] });
        params.electrodes.overrides.push("E01:gouge".parse().unwrap());
        params.library.cutter.push(Cutter { reach_mm: Some(12.0), ..Cutter::bull_nose(3.0, 0.5) });
        let file = here.join("part.sparkmold");
        write_mold(&file, &params).unwrap();
        assert!(is_mold_file(&file) && read_mold(&file).unwrap() == params);
        // Files from before there were electrodes say nothing of them.
        let old = here.join("old.sparkmold");
        std::fs::write(&old, "tolerance_mm = 0.05").unwrap();
        assert_eq!(read_mold(&old).unwrap().electrodes, MoldParams::default().electrodes);
        std::fs::write(&old, "[electrodes]\noverrides = [\"E03\"]").unwrap();
        let read = read_mold(&old).unwrap().electrodes;
        assert!(read.overrides[0].electrode == "E03" && read.overrides[0].check.is_none());
        std::fs::copy(&file, there.join("copy.sparkmold")).unwrap();
        assert_eq!(read_mold(&there.join("copy.sparkmold")).unwrap().mesh, Some(there.join("part.stl")));
    }

    #[test]
    fn what_is_no_mold_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.sparkmold");
        for (text, words) in [
            ("tolerance_mm = -1", "line 1: tolerance_mm is -1"),
            ("tolerance_mm = nan", "tolerance_mm is NaN"),
            ("opening = \"up\"", "unknown variant"),
            ("[[library.cutter]]\ndiameter_mm = 0", "line 2: library.cutter[0].diameter_mm is 0"),
            ("library = {}", "no cutter"),
            ("tolerance = 1", "unknown field"),
            ("[electrodes]\nmargin_mm = -1", "line 2: electrodes.margin_mm is -1"),
        ] {
            std::fs::write(&file, text).unwrap();
            let said = read_mold(&file).unwrap_err().to_string();
            assert!(said.contains("wrong.sparkmold") && said.contains(words), "{text}: {said}");
        }
        let broken = MoldParams { tolerance_mm: 0.0, ..MoldParams::default() };
        assert!(write_mold(&file, &broken).is_err());
        assert!(read_mold(&folder.path().join("none")).unwrap_err().to_string().contains("cannot be read"));
    }
}
