//! Files of molds: the mesh, the question about it and the cutters.

use std::path::{Path, PathBuf};

use super::MoldParams;
use super::paths::{absolute, relative, without_detours};
use crate::mesh_io::atomic_write;

/// How the name of such a file ends.
pub const ENDING: &str = ".sparkmold";
/// The largest file that is written or read (bytes).
const LARGEST_FILE: u64 = 1 << 20;

/// Why the file of a mold cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct MoldFileError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong and what to do, in one line.
    pub problem: String,
}

/// Whether `path` is named as a file of a mold.
pub fn is_mold_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(&ENDING[1..]))
}

/// Writes `params` as a TOML file, with the mesh as seen from the file's folder.
///
/// # Errors
/// [`MoldFileError`], also of parameters that could not be read again.
pub fn write_mold(file: &Path, params: &MoldParams) -> Result<(), MoldFileError> {
    let wrong = |problem: String| MoldFileError { file: file.to_owned(), problem };
    params.validate().map_err(wrong)?;
    let folder = absolute(file.parent().unwrap_or(Path::new("")));
    let mesh = params.mesh.as_deref().map(|mesh| relative(mesh, &folder));
    let text = toml::to_string_pretty(&MoldParams { mesh, ..params.clone() }).map_err(|e| wrong(e.to_string()))?;
    let size = text.len() as u64;
    if size > LARGEST_FILE {
        return Err(wrong(format!(
            "not written: it would have {size} bytes and at most {LARGEST_FILE} are read again"
        )));
    }
    atomic_write(file, |out| out.write_all(text.as_bytes()))
        .map_err(|e| wrong(format!("cannot be written ({e}); choose another place")))
}

/// The parameters in a file that [`write_mold`] has written.
///
/// # Errors
/// [`MoldFileError`].
pub fn read_mold(file: &Path) -> Result<MoldParams, MoldFileError> {
    let wrong = |problem: String| MoldFileError { file: file.to_owned(), problem };
    let unreadable = |e: std::io::Error| wrong(format!("cannot be read ({e}); check the path"));
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        return Err(wrong(format!("it has {size} bytes; the file of a mold has at most {LARGEST_FILE}")));
    }
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    let mut params: MoldParams = toml::from_str(&text).map_err(|e| wrong(e.message().replace('\n', " ")))?;
    params.validate().map_err(wrong)?;
    let folder = absolute(file.parent().unwrap_or(Path::new("")));
    params.mesh = params.mesh.map(|mesh| without_detours(&folder.join(mesh)));
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mold::cutter::Cutter;
    use crate::mold::electrode::params::Edit;
    use crate::mold::opening::Opening;

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
            ("tolerance_mm = -1", "tolerance_mm is -1"),
            ("tolerance_mm = nan", "tolerance_mm is NaN"),
            ("opening = \"up\"", "unknown variant"),
            ("[[library.cutter]]\ndiameter_mm = 0", "diameter_mm is 0 mm"),
            ("library = {}", "no cutter"),
            ("tolerance = 1", "unknown field"),
            ("[electrodes]\nmargin_mm = -1", "margin_mm is -1 mm"),
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
