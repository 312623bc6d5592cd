//! Files of holders: a user's own list, and a folder with a file for each supplier.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use files::{FileError, Invalid, TomlFile, Validate};
use mold::electrode::params::{ElectrodeParams, Holder};

/// The built-in list with comments, to be copied and changed.
pub const STANDARD_HOLDERS: &str = include_str!("../../../../assets/holders.toml");
/// Name of the user's list in the user's folder.
pub const HOLDERS_FILE_NAME: &str = "holders.toml";
/// Name of the folder beside it, with a file for each supplier.
pub const SUPPLIERS_FOLDER: &str = "holders";
/// Greatest number of suppliers' files.
const MOST_SUPPLIERS: usize = 256;

/// A file of holders: a list `[[holder]]` with the keys of [`Holder`].
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HolderLibrary {
    pub(super) holder: Vec<Holder>,
}

/// Files of holders; see [`STANDARD_HOLDERS`].
pub(super) const HOLDERS: TomlFile<HolderLibrary> = TomlFile::new("list of holders");

impl Validate for HolderLibrary {
    fn validate(&self) -> Result<(), Invalid> {
        if self.holder.is_empty() {
            return Err(Invalid::of("holder", "there is none; list at least one, or take the file away"));
        }
        for (i, holder) in self.holder.iter().enumerate() {
            if self.holder[..i].iter().any(|other| other.name == holder.name) {
                let (key, name) = (format!("holder[{i}].name"), format!("{:?}", holder.name));
                return Err(Invalid::new(key, name, "another holder is called so; rename one"));
            }
        }
        // Holders are possible where parameters with them are.
        let with = ElectrodeParams { holders: self.holder.clone(), ..ElectrodeParams::default() };
        Validate::validate(&with).map_err(|problem| Invalid { key: "holder".to_owned(), ..problem })
    }
}

/// The user's holders: those of `holders.toml` in `user_folder` in their order, and those of each file
/// `holders/SUPPLIER.toml`, named `SUPPLIER: name`. If there are suppliers, all holders are sorted by size, so that the
/// first large enough is the smallest. Without any file, the built-in holders.
///
/// # Errors
/// [`FileError`], also where two holders would have the same name.
pub fn load_holders(user_folder: Option<&Path>) -> Result<Vec<Holder>, FileError> {
    let own = match user_folder.map(|folder| folder.join(HOLDERS_FILE_NAME)) {
        Some(file) => HOLDERS.read_if_there(&file)?.map(|library| (file, library.holder)),
        None => None,
    };
    let suppliers = match user_folder {
        Some(folder) => suppliers(&folder.join(SUPPLIERS_FOLDER))?,
        None => Vec::new(),
    };
    if suppliers.is_empty() {
        let standard = || HOLDERS.parse(STANDARD_HOLDERS, Path::new(HOLDERS_FILE_NAME)).map(|library| library.holder);
        return own.map_or_else(standard, |(_, holders)| Ok(holders));
    }
    let mut all: Vec<(PathBuf, Holder)> = Vec::new();
    for (file, holders) in own.into_iter().chain(suppliers) {
        for holder in holders {
            if let Some((other, _)) = all.iter().find(|(_, known)| known.name == holder.name) {
                let remedy = format!("is there already, in {}; rename one", other.display());
                return Err(FileError::invalid(
                    &file,
                    Invalid::new("holder.name", format!("{:?}", holder.name), remedy),
                ));
            }
            all.push((file.clone(), holder));
        }
    }
    let mut holders: Vec<Holder> = all.into_iter().map(|(_, holder)| holder).collect();
    let area = |h: &Holder| h.size_mm[0] * h.size_mm[1];
    // Stable, so that equal ones stay in the order of the files.
    holders.sort_by(|a, b| area(a).total_cmp(&area(b)));
    let (folder, library) = (user_folder.unwrap_or(Path::new(SUPPLIERS_FOLDER)), HolderLibrary { holder: holders });
    library.validate().map_err(|problem| FileError::invalid(folder, problem))?;
    Ok(library.holder)
}

/// The holders of each file in a folder of suppliers, in the order of the names; none if there is no such folder.
fn suppliers(folder: &Path) -> Result<Vec<(PathBuf, Vec<Holder>)>, FileError> {
    let unreadable = |source| FileError::unreadable(folder, source);
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(unreadable(error)),
    };
    let mut files: Vec<PathBuf> = entries.map(|e| Ok(e?.path())).collect::<Result<_, _>>().map_err(unreadable)?;
    files.retain(|file| file.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")));
    files.sort();
    if files.len() > MOST_SUPPLIERS {
        let problem = format!("there are {} files; at most {MOST_SUPPLIERS} are possible", files.len());
        return Err(FileError::invalid(folder, Invalid::of("", problem)));
    }
    let of = |file: PathBuf| {
        let supplier = file.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let mut holders = read_holders(&file)?;
        holders.iter_mut().for_each(|holder| holder.name = format!("{supplier}: {}", holder.name));
        Ok((file, holders))
    };
    files.into_iter().map(of).collect()
}

/// The holders in a TOML file: a list `[[holder]]` with the keys of [`Holder`]; see [`STANDARD_HOLDERS`].
///
/// # Errors
/// [`FileError`].
pub fn read_holders(file: &Path) -> Result<Vec<Holder>, FileError> {
    Ok(HOLDERS.read(file)?.holder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holder(name: &str, side: f64) -> Holder {
        Holder { name: name.to_owned(), size_mm: [side, side + 1.5], height_mm: 12.0 }
    }

    fn write_holders(file: &Path, holders: &[Holder]) -> Result<(), FileError> {
        HOLDERS.write(file, &HolderLibrary { holder: holders.to_vec() })
    }

    #[test]
    fn the_standard_holders_rise_and_a_users_file_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let standard = load_holders(Some(folder.path())).unwrap();
        assert_eq!(standard, load_holders(None).unwrap());
        assert!(standard.len() >= 4);
        let area = |h: &Holder| h.size_mm[0] * h.size_mm[1];
        assert!(standard.windows(2).all(|w| area(&w[0]) < area(&w[1])), "the smallest that fits comes first");
        let own = vec![holder("mine", 30.0)];
        let file = folder.path().join(HOLDERS_FILE_NAME);
        write_holders(&file, &own).unwrap();
        assert_eq!(load_holders(Some(folder.path())).unwrap(), own);
        assert_eq!(read_holders(&file).unwrap(), own);
        assert!(write_holders(&file, &[]).is_err());
        assert_eq!(load_holders(Some(folder.path())).unwrap(), own);
    }

    #[test]
    fn suppliers_are_read_beside_the_users_own_and_the_smallest_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let suppliers = folder.path().join(SUPPLIERS_FOLDER);
        std::fs::create_dir(&suppliers).unwrap();
        std::fs::write(suppliers.join("remarks.txt"), "no holders").unwrap();
        write_holders(&suppliers.join("Beta.toml"), &[holder("20", 20.0), holder("50", 50.0)]).unwrap();
        write_holders(&suppliers.join("Acme.toml"), &[holder("20", 20.0)]).unwrap();
        let names = || load_holders(Some(folder.path())).map(|all| all.into_iter().map(|h| h.name).collect::<Vec<_>>());
        assert_eq!(names().unwrap(), ["Acme: 20", "Beta: 20", "Beta: 50"], "what a shop has, not what it might have");
        let own = folder.path().join(HOLDERS_FILE_NAME);
        write_holders(&own, &[holder("large", 60.0), holder("middle", 30.0)]).unwrap();
        assert_eq!(names().unwrap(), ["Acme: 20", "Beta: 20", "middle", "Beta: 50", "large"]);
        write_holders(&own, &[holder("Acme: 20", 5.0)]).unwrap();
        let said = names().unwrap_err().to_string();
        assert!(
            ["Acme.toml", "holder.name", "\"Acme: 20\"", "holders.toml"].iter().all(|w| said.contains(w)),
            "{said}"
        );
        std::fs::write(suppliers.join("Beta.toml"), "[[holder]]\nname = \"a\"\nsize = 3\n").unwrap();
        std::fs::remove_file(own).unwrap();
        let said = names().unwrap_err().to_string();
        assert!(said.contains("Beta.toml") && said.contains("line 3") && said.contains("size"), "{said}");
    }

    #[test]
    fn what_is_wrong_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.toml");
        for (text, words) in [
            ("[[holder]]\nname = \"a\"\nsize_mm = [1.0]\nheight_mm = 2.0", "line 3"),
            ("[[holder]]\nname = \"a\"\nsize_mm = [1.0, -1.0]\nheight_mm = 2.0", "\"a\""),
            ("holders = []", "unknown field"),
            ("holder = []", "there is none"),
        ] {
            std::fs::write(&file, text).unwrap();
            let said = read_holders(&file).unwrap_err().to_string();
            assert!(said.contains("wrong.toml") && said.contains(words), "{text:?}: {said}");
        }
        assert!(write_holders(&file, &[holder("a", 1.0), holder("a", 2.0)]).is_err(), "one name for two");
    }
}
