//! Files of five-axis milling machines.

use std::path::Path;

use serde::{Deserialize, Serialize};

use files::{FileError, Invalid, TomlFile, Validate};
use flank::machine::milling_machine::{MachineError, MillingMachine};

/// The built-in file with comments, to be copied and changed.
pub const STANDARD_FILE: &str = include_str!("../../../../assets/milling_machines.toml");
/// Name of the file in the user's folder.
pub const FILE_NAME: &str = "milling_machines.toml";
/// Greatest number of machines.
const MOST_MACHINES: usize = 256;

/// Reason why a milling machine cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MillingMachineFileError {
    /// The file cannot be read, or is no machine file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file has several machines.
    #[error("{file}: it has {} machines; say which, as {file}#{}: {}", known.len(), known[0], known.join(", "))]
    Several {
        /// The file.
        file: String,
        /// Names of the machines in the file.
        known: Vec<String>,
    },
    /// There is no machine of that name.
    #[error("there is no milling machine {name:?}; there are {}", known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// Names of the known machines.
        known: Vec<String>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineLibrary {
    machine: Vec<MillingMachine>,
}

/// Files of machines; see [`STANDARD_FILE`].
const MACHINES: TomlFile<MachineLibrary> = TomlFile::new("list of milling machines");

impl Validate for MachineLibrary {
    fn validate(&self) -> Result<(), Invalid> {
        let found = self.machine.len();
        if !(1..=MOST_MACHINES).contains(&found) {
            let remedy = format!("it has {found} machines; give 1 to {MOST_MACHINES} as [[machine]]");
            return Err(Invalid::of("machine", remedy));
        }
        for (i, machine) in self.machine.iter().enumerate() {
            let place = |problem: Invalid| problem.within(&format!("machine[{i}]"));
            let impossible = |error| match error {
                MachineError::Value { key, value, remedy, .. } => Invalid::new(key, value, remedy),
                other => Invalid::of("", other.to_string()),
            };
            machine.kinematics().map_err(|error| place(impossible(error)))?;
            if self.machine[..i].iter().any(|other| other.name == machine.name) {
                let name = format!("{:?}", machine.name);
                return Err(place(Invalid::new("name", name, "two machines are called so; name each once")));
            }
        }
        Ok(())
    }
}

/// Milling machines: those of `milling_machines.toml` in `user_folder` if it exists, else the built-in ones.
///
/// # Errors
/// [`FileError`].
pub fn load_milling_machines(user_folder: Option<&Path>) -> Result<Vec<MillingMachine>, FileError> {
    let own = user_folder.map(|folder| MACHINES.read_if_there(&folder.join(FILE_NAME))).transpose()?;
    let library = match own.flatten() {
        Some(own) => own,
        None => MACHINES.parse(STANDARD_FILE, Path::new(FILE_NAME))?,
    };
    Ok(library.machine)
}

/// The machines in a TOML file: a list `[[machine]]` with the keys of [`MillingMachine`]; see [`STANDARD_FILE`].
///
/// # Errors
/// [`FileError`].
pub fn read_milling_machines(file: &Path) -> Result<Vec<MillingMachine>, FileError> {
    Ok(MACHINES.read(file)?.machine)
}

/// File and name of a machine given as `FILE.toml` or `FILE.toml#NAME`; none of a machine given by name alone.
pub fn file_of_machine(machine: &str) -> Option<(&str, Option<&str>)> {
    const ENDING: &str = ".toml";
    if machine.ends_with(ENDING) {
        return Some((machine, None));
    }
    let (file, name) = machine.rsplit_once('#')?;
    file.ends_with(ENDING).then_some((file, Some(name)))
}

/// The machine called `name`; or the only machine of the file `name`, which ends in `.toml`; or a machine of a file
/// with several, as `FILE.toml#NAME`.
///
/// # Errors
/// [`MillingMachineFileError`].
pub fn milling_machine(name: &str, user_folder: Option<&Path>) -> Result<MillingMachine, MillingMachineFileError> {
    let (mut machines, wanted) = match file_of_machine(name) {
        Some((file, wanted)) => (read_milling_machines(Path::new(file))?, wanted),
        None => (load_milling_machines(user_folder)?, Some(name)),
    };
    let known = || machines.iter().map(|m| m.name.clone()).collect();
    let Some(wanted) = wanted else {
        if machines.len() > 1 {
            return Err(MillingMachineFileError::Several { file: name.to_owned(), known: known() });
        }
        return Ok(machines.remove(0));
    };
    let found = machines.iter().position(|m| m.name == wanted);
    let unknown = || MillingMachineFileError::Unknown { name: wanted.to_owned(), known: known() };
    Ok(machines.swap_remove(found.ok_or_else(unknown)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flank::machine::kinematics::MachineKind;

    fn write_milling_machines(file: &Path, machines: &[MillingMachine]) -> Result<(), FileError> {
        MACHINES.write(file, &MachineLibrary { machine: machines.to_vec() })
    }

    #[test]
    fn the_standard_file_holds_one_machine_of_each_kind_and_a_users_file_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let standard = load_milling_machines(Some(folder.path())).unwrap();
        let kinds: Vec<MachineKind> = standard.iter().map(|m| m.kinematics().unwrap().kind()).collect();
        assert_eq!(kinds, [MachineKind::TableTable, MachineKind::HeadHead, MachineKind::HeadTable]);
        let own = vec![MillingMachine { name: "mine".to_owned(), gauge_length_mm: 1.0 / 3.0, ..standard[1].clone() }];
        let file = folder.path().join(FILE_NAME);
        write_milling_machines(&file, &own).unwrap();
        assert_eq!(load_milling_machines(Some(folder.path())).unwrap(), own);
        assert_eq!(milling_machine("mine", Some(folder.path())).unwrap(), own[0]);
        assert_eq!(milling_machine(&file.display().to_string(), None).unwrap(), own[0]);
        let said = milling_machine("mine", None).unwrap_err().to_string();
        assert!(said.contains("mine") && said.contains("trunnion-ac, fork-cb, swivel-bc"), "{said}");
        let both = folder.path().join("two.toml");
        write_milling_machines(&both, &[own[0].clone(), standard[2].clone()]).unwrap();
        let both = both.display().to_string();
        let said = milling_machine(&both, None).unwrap_err().to_string();
        assert!(said.contains("two.toml#mine") && said.contains("mine, swivel-bc"), "{said}");
        assert_eq!(milling_machine(&format!("{both}#swivel-bc"), None).unwrap(), standard[2]);
        assert!(milling_machine(&format!("{both}#other"), None).unwrap_err().to_string().contains("mine, swivel-bc"));
        assert_eq!(file_of_machine("a#b"), None);
        assert!(write_milling_machines(&file, &[own[0].clone(), own[0].clone()]).is_err());
        assert_eq!(read_milling_machines(&file).unwrap(), own, "what cannot be written takes nothing away");
    }

    #[test]
    fn what_is_wrong_is_answered_with_file_key_and_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.toml");
        for (from, to, words) in [
            ("gauge_length_mm = 120.0", "gauge_length_mm = -1.0", "gauge_length_mm is -1 mm"),
            ("gauge_length_mm = 120.0", "gauge_length = 120.0", "line 26: machine[0].gauge_length: unknown field"),
            ("x_mm = [-400.0, 400.0]", "x_mm = [400.0, -400.0]", "linear.x_mm is [400.0, -400.0]: give the least"),
            ("x_mm = [-400.0, 400.0]", "x_mm = [nan, 400.0]", "linear.x_mm"),
            (
                "limits_deg = [-120.0, 120.0]",
                "limits_deg = [120.0, -120.0]",
                "machine[0].rotary[0].limits_deg is [120, -120]",
            ),
            ("speed_deg_min = 9000.0", "speed_deg_min = 0.0", "rotary[0].speed_deg_min is 0"),
            ("direction = [-1.0, 0.0, 0.0]", "direction = [0.0, 0.0, 0.0]", "rotary[0].direction"),
            ("direction = [-1.0, 0.0, 0.0]", "direction = [0.0, 0.0, 2.0]", "parallel"),
            ("spindle = [0.0, 0.0, 1.0]", "spindle = [1.0, 0.0, 0.0]", "lies along the spindle"),
            ("letter = \"A\"", "letter = \"U\"", "unknown variant"),
            ("letter = \"A\"", "letter = \"C\"", "letter of its own"),
            ("carried_by = \"table\"", "carried_by = \"bed\"", "unknown variant"),
            ("x_axis = [1.0, 0.0, 0.0]", "x_axis = [0.0, 0.0, 3.0]", "workpiece.x_axis"),
            ("name = \"trunnion-ac\"", "name = \"a b\"", "name is \"a b\""),
            ("name = \"trunnion-ac\"", "name = \"fork-cb\"", "two machines are called"),
        ] {
            assert!(STANDARD_FILE.contains(from), "{from}");
            std::fs::write(&file, STANDARD_FILE.replacen(from, to, 1)).unwrap();
            let said = read_milling_machines(&file).unwrap_err().to_string();
            assert!(said.contains("wrong.toml") && said.contains(words), "{to:?}: {said}");
            assert_eq!(said.lines().count(), 1);
        }
        std::fs::write(&file, "machine = []").unwrap();
        assert!(read_milling_machines(&file).unwrap_err().to_string().contains("it has 0 machines"));
    }
}
