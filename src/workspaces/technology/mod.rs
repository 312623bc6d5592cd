//! The technology of a project: its table as a file, its fields in forms, and the window in which the table is edited.

mod editor;
mod fields;
mod plots;

use std::path::Path;

use burning::defaults;
use burning::project::ProjectTechnology;
use burning::technology::{TECHNOLOGY_FILE, TechnologyFile};
use files::{FileError, Word, word};

pub use editor::{TableChange, TechnologyWindow};

/// Tables that can be chosen.
pub const TABLES: &[Word] =
    &[word(burning::project::BUILT_IN, "built-in", "Made from default rules; no figures of a machine")];

/// Fields of a [`ProjectTechnology`] under a key: the table, the technology, what is allowed and the time beside burning.
macro_rules! technology_fields {
    ($at:literal) => {
        &[
            files::Field::choice_or_file(
                concat!($at, ".table"),
                "Technology table",
                $crate::workspaces::technology::TABLES,
            )
            .help(
                "Steps of a generator with current, spark gap, removal rate and wear. The built-in table is assumed; a TOML \
                 file of your own can be chosen.",
            ),
            files::Field::text(concat!($at, ".id"), "Technology").help(
                "Identifier of the technology in the table. Built in: steel-graphite, steel-copper, titanium-copper, \
                 nickel-copper.",
            ),
            files::Field::number(concat!($at, ".allowed_wear.end_mm"), "Allowed end wear", "mm", 1e-4, 1000.0)
                .or_nothing(0.05)
                .help("Length that the front of an electrode may lose before it is replaced; none for any."),
            files::Field::number(concat!($at, ".allowed_wear.corner_mm"), "Allowed corner wear", "mm", 1e-4, 1000.0)
                .or_nothing(0.05)
                .help("Wear of the edges at which an electrode is replaced; none for any."),
            files::Field::number(concat!($at, ".redress.length_mm"), "Length to redress", "mm", 1e-3, 10_000.0)
                .or_nothing(12.0)
                .help(
                    "Length of a new electrode along which its section is that of its front: worn fronts are cut off. None \
                     where electrodes are not redressed.",
                ),
            files::Field::number(concat!($at, ".redress.least_length_mm"), "Least length", "mm", 0.0, 10_000.0)
                .or_nothing(8.0)
                .help("Length with which a redressed electrode still burns."),
            files::Field::number(concat!($at, ".redress.allowance_mm"), "Redressed beyond", "mm", 1e-3, 100.0)
                .or_nothing(0.1)
                .help("Length that is cut off beyond the wear of front and edges."),
            files::Field::number(concat!($at, ".overhead.setup_min"), "Set-up", "min", 0.0, 1e6)
                .decimals(1)
                .help("Setting up the workpiece and the first electrode, once."),
            files::Field::number(concat!($at, ".overhead.change_min"), "Change", "min", 0.0, 1e6)
                .decimals(1)
                .help("Changing to the next electrode, with positioning and measuring it."),
        ]
    };
}
pub(crate) use technology_fields;

/// The technology table of a project.
///
/// # Errors
/// [`FileError`] if it is a file that cannot be read or is no technology table.
pub fn read_table(project: &ProjectTechnology) -> Result<TechnologyFile, FileError> {
    if project.is_file() { TECHNOLOGY_FILE.read(Path::new(&project.table)) } else { defaults::standard() }
}

/// Whether the table of a project is the file `table`, however its path is written.
fn is_table(project: &ProjectTechnology, table: &Path) -> bool {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    project.is_file() && whole(Path::new(&project.table)) == whole(table)
}

/// Takes the first technology of `table`, unless it has the one of the project.
pub fn take_first_unless_known(project: &mut ProjectTechnology, table: &TechnologyFile) {
    if let (None, Some(first)) = (table.get(&project.id), table.technology.first()) {
        project.id.clone_from(&first.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_built_in_one_or_a_file() {
        let mut project = ProjectTechnology::default();
        assert_eq!(read_table(&project).unwrap(), defaults::standard().unwrap());
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.toml");
        project.table = file.to_string_lossy().into_owned();
        assert!(read_table(&project).unwrap_err().is_not_found());
        let table =
            TechnologyFile { technology: defaults::standard().unwrap().technology[..1].to_vec(), ..Default::default() };
        TECHNOLOGY_FILE.write(&file, &table).unwrap();
        assert_eq!(read_table(&project).unwrap(), table);
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        assert!(is_table(&project, &folder.path().join("sub/../own.toml")));
        assert!(!is_table(&project, &folder.path().join("other.toml")));
        assert!(!is_table(&ProjectTechnology::default(), Path::new(burning::project::BUILT_IN)));
        project.id = "none".to_owned();
        take_first_unless_known(&mut project, &table);
        assert_eq!(project.id, table.technology[0].id);
    }
}
