//! Files of five-axis milling machines.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use files::atomic::atomic_write;
use flank::machine::milling_machine::{MachineError, MillingMachine};

/// The file that holds without one, with remarks: to be copied and changed.
pub const STANDARD_FILE: &str = include_str!("../../../../assets/milling_machines.toml");
/// What this file is called in a user's folder.
pub const FILE_NAME: &str = "milling_machines.toml";
/// The largest file that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// The most machines.
const MOST_MACHINES: usize = 256;

/// Why a file of milling machines cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum MillingMachineFileError {
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
    /// A machine that is not possible.
    #[error("{file}: {source}")]
    Machine {
        /// The file.
        file: PathBuf,
        /// Which, and why.
        source: MachineError,
    },
    /// A file with more than one machine.
    #[error("{file}: it has {} machines; say which, as {file}#{}: {}", known.len(), known[0], known.join(", "))]
    Several {
        /// The file.
        file: PathBuf,
        /// Those that it has.
        known: Vec<String>,
    },
    /// No machine of that name.
    #[error("there is no milling machine {name:?}; there are {}", known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineLibrary {
    machine: Vec<MillingMachine>,
}

/// Milling machines: `milling_machines.toml` in `user_folder` if it is there, else those that the program brings along.
///
/// # Errors
/// [`MillingMachineFileError`].
pub fn load_milling_machines(user_folder: Option<&Path>) -> Result<Vec<MillingMachine>, MillingMachineFileError> {
    let standard = || machines_of(Path::new(FILE_NAME), STANDARD_FILE);
    let Some(folder) = user_folder else { return standard() };
    match read_milling_machines(&folder.join(FILE_NAME)) {
        Err(MillingMachineFileError::Unreadable { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            standard()
        }
        other => other,
    }
}

/// The machines in a TOML file: a list `[[machine]]` with the keys of [`MillingMachine`]; see [`STANDARD_FILE`].
///
/// # Errors
/// [`MillingMachineFileError`].
pub fn read_milling_machines(file: &Path) -> Result<Vec<MillingMachine>, MillingMachineFileError> {
    let unreadable = |source| MillingMachineFileError::Unreadable { file: file.to_owned(), source };
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        return Err(invalid(file, format!("it has {size} bytes; such a file has at most {LARGEST_FILE}")));
    }
    machines_of(file, &std::fs::read_to_string(file).map_err(unreadable)?)
}

/// Writes `machines` as a TOML file that [`read_milling_machines`] reads.
///
/// # Errors
/// [`MillingMachineFileError`], also of machines that could not be read again; a file already there is then untouched.
pub fn write_milling_machines(file: &Path, machines: &[MillingMachine]) -> Result<(), MillingMachineFileError> {
    check(file, machines)?;
    let library = MachineLibrary { machine: machines.to_vec() };
    let text = toml::to_string_pretty(&library).map_err(|e| invalid(file, e.to_string()))?;
    let unwritable = |source| MillingMachineFileError::Unwritable { file: file.to_owned(), source };
    atomic_write(file, |out| out.write_all(text.as_bytes())).map_err(unwritable)
}

/// The file of a machine that is given as `FILE.toml` or as `FILE.toml#NAME`, and its name; none of a machine that is
/// given by its name alone.
pub fn file_of_machine(machine: &str) -> Option<(&str, Option<&str>)> {
    const ENDING: &str = ".toml";
    if machine.ends_with(ENDING) {
        return Some((machine, None));
    }
    let (file, name) = machine.rsplit_once('#')?;
    file.ends_with(ENDING).then_some((file, Some(name)))
}

/// The machine called `name`; or the one of the file `name`, which ends in `.toml` and has no other machine; or one of
/// such a file that has more, as `FILE.toml#NAME`.
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
            return Err(MillingMachineFileError::Several { file: name.into(), known: known() });
        }
        return Ok(machines.remove(0));
    };
    let found = machines.iter().position(|m| m.name == wanted);
    let unknown = || MillingMachineFileError::Unknown { name: wanted.to_owned(), known: known() };
    Ok(machines.swap_remove(found.ok_or_else(unknown)?))
}

fn invalid(file: &Path, problem: String) -> MillingMachineFileError {
    MillingMachineFileError::Invalid { file: file.to_owned(), line: None, problem }
}

fn machines_of(file: &Path, text: &str) -> Result<Vec<MillingMachine>, MillingMachineFileError> {
    let parsed: Result<MachineLibrary, toml::de::Error> = toml::from_str(text);
    let library = parsed.map_err(|e| {
        let line = |span: std::ops::Range<usize>| text.bytes().take(span.start).filter(|b| *b == b'\n').count() + 1;
        let problem = e.message().replace('\n', " ");
        MillingMachineFileError::Invalid { file: file.to_owned(), line: e.span().map(line), problem }
    })?;
    check(file, &library.machine)?;
    Ok(library.machine)
}

fn check(file: &Path, machines: &[MillingMachine]) -> Result<(), MillingMachineFileError> {
    if !(1..=MOST_MACHINES).contains(&machines.len()) {
        let found = machines.len();
        return Err(invalid(file, format!("it has {found} machines; give 1 to {MOST_MACHINES} as [[machine]]")));
    }
    for (i, machine) in machines.iter().enumerate() {
        let impossible = |source| MillingMachineFileError::Machine { file: file.to_owned(), source };
        machine.kinematics().map_err(impossible)?;
        if machines[..i].iter().any(|m| m.name == machine.name) {
            return Err(invalid(file, format!("two machines are called {:?}; name each once", machine.name)));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use flank::machine::kinematics::MachineKind;

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
            ("gauge_length_mm = 120.0", "gauge_length = 120.0", "line 26: unknown field `gauge_length`"),
            ("x_mm = [-400.0, 400.0]", "x_mm = [400.0, -400.0]", "linear.x_mm is [400.0, -400.0]; give the least"),
            ("x_mm = [-400.0, 400.0]", "x_mm = [nan, 400.0]", "linear.x_mm"),
            ("limits_deg = [-120.0, 120.0]", "limits_deg = [120.0, -120.0]", "rotary A: limits_deg is [120, -120]"),
            ("speed_deg_min = 9000.0", "speed_deg_min = 0.0", "rotary A: speed_deg_min is 0"),
            ("direction = [-1.0, 0.0, 0.0]", "direction = [0.0, 0.0, 0.0]", "rotary A: direction"),
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
