//! What a command works on: a project file or the mesh of a part, and parameters that are set on the command line.

use std::path::{Path, PathBuf};

use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::context::is_project;
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::mold::document::MoldParams;
use clap::Args;
use files::{Document, FieldTable, FileError, Params, kind_of, paths};

/// The part of the arguments that says what a command works on.
#[derive(Debug, Args)]
pub(super) struct ProjectArguments {
    /// A project (.sparkpath), or the mesh of a part, for which all else is at its default.
    #[arg(value_name = "PROJECT|MESH")]
    pub file: PathBuf,
    #[command(flatten)]
    pub settings: Settings,
}

/// Parameters in place of the project's.
#[derive(Debug, Clone, Args)]
pub(super) struct Settings {
    /// A parameter in place of the project's: a key of the file, an equals sign and the value; once for each.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
}

fn setting(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected a key and its value, as in electrode.parts=2")?;
    Ok((key.trim().to_owned(), value.to_owned()))
}

impl ProjectArguments {
    /// The parameters, set as asked for and checked; `of_mesh` makes those of a mesh.
    pub fn read<P: Params>(&self, table: &FieldTable<P>, of_mesh: impl FnOnce(&Path) -> P) -> anyhow::Result<P> {
        let file = self.file.display();
        let mut params = if is_project(&self.file) {
            read_project(&self.file)?
        } else {
            let is_toml = paths::has_ending(&self.file, ".toml");
            let kind = P::KIND;
            anyhow::ensure!(
                !is_toml,
                "{file}: a project ends with .sparkpath; rename it, and write kind = \"{kind}\" in its first line"
            );
            of_mesh(&self.file)
        };
        self.settings.apply(table, &mut params)?;
        params.validate().map_err(|problem| anyhow::anyhow!("{file}: {problem}"))?;
        Ok(params)
    }
}

impl Settings {
    /// Whether nothing is set.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// Sets the parameters that are given.
    pub fn apply<P: Params>(&self, table: &FieldTable<P>, params: &mut P) -> anyhow::Result<()> {
        let wrong = |problem| anyhow::anyhow!("--set {problem}");
        for (key, value) in &self.set {
            *params = table.set(params, key, value).map_err(wrong)?;
        }
        let is_set = |key: &str| self.set.iter().any(|(set, _)| set == key);
        params.complete(&is_set).map_err(wrong)
    }
}

/// Opens the project `file`. An error of one of another kind names the commands that take it.
pub(super) fn open<P: Params>(file: &Path) -> anyhow::Result<Document<P>> {
    Document::open(file).map_err(|error| of_kind(file, P::KIND, error))
}

/// `error` of reading the project `file`, of which `kind` is wanted, with the commands that take its own kind.
pub(super) fn of_kind(file: &Path, kind: &str, error: FileError) -> anyhow::Error {
    let commands = match kind_of(file).ok().filter(|own| own != kind).as_deref() {
        Some(PlanJob::KIND) => "one of a blisk is for plan, size, compare, simulate, inspect and render",
        Some(MoldParams::KIND) => "one of a mold is for uncut, electrodes and render",
        Some(FlankDocument::KIND) => "one of a flank is for flank and render",
        Some(_) => "the kinds are blisk, mold and flank",
        None => return error.into(),
    };
    anyhow::anyhow!("{error}; {commands}")
}

/// The parameters of a project, with a note about files that have changed since it was saved.
fn read_project<P: Params>(file: &Path) -> anyhow::Result<P> {
    let document = open::<P>(file)?;
    for moved in document.moved_files().iter().filter(|moved| moved.is_changed) {
        super::terminal::print_error(&format!(
            "note: {} has changed since the project was saved",
            moved.path.display()
        ));
    }
    let mut params = document.params().clone();
    if file.is_relative() {
        // Reports name files as the command line does.
        let here = paths::absolute(Path::new(""));
        params.change_paths(&mut |path| paths::relative(path, &here));
    }
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::blisk::document::job_file::field_table::FIELDS;

    fn read(file: &Path, set: &[&str]) -> anyhow::Result<PlanJob> {
        let set = set.iter().map(|text| setting(text).map_err(anyhow::Error::msg)).collect::<Result<_, _>>()?;
        ProjectArguments { file: file.to_owned(), settings: Settings { set } }.read(&FIELDS, PlanJob::for_mesh)
    }

    #[test]
    fn a_mesh_is_a_project_at_its_defaults_and_what_is_set_counts_more_than_the_project() {
        let mesh = Path::new("part.stl");
        assert_eq!(read(mesh, &[]).unwrap(), PlanJob::for_mesh(mesh));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.sparkpath");
        std::fs::write(&file, "kind = \"blisk\"\n[blisk]\nmesh = \"part.stl\"\n[electrode]\nparts = 3\n").unwrap();
        let job =
            read(&file, &["electrode.parts=2", "electrode.enter=+x", "electrode.circumferential_reduction_deg[0]=1,5"]);
        let electrode = job.unwrap().electrode;
        assert_eq!((electrode.parts, electrode.enter.name()), (2, "+x"));
        assert_eq!(electrode.circumferential_reduction_deg, [1.5, 0.8]);
        let machine = read(&file, &["machine.name=xyzc", "machine.speed_mm_min=7"]).unwrap().machine;
        assert_eq!((machine.axes, machine.speed_mm_min), (feed::machine::AxisSet::XYZC, 7.0));
        // What the file of a machine does not say is as the project says.
        let own = folder.path().join("own.toml");
        std::fs::write(&own, "axes = \"XYZC\"\nspeed_deg_min = 90.0\n").unwrap();
        let machine = "[machine]\naxes = \"XYZABC\"\nspeed_mm_min = 70.0\nspeed_deg_min = 80.0\n";
        std::fs::write(&file, format!("kind = \"blisk\"\n{machine}")).unwrap();
        let machine = read(&file, &[&format!("machine.name={}", own.display())]).unwrap().machine;
        assert_eq!(machine.axes, feed::machine::AxisSet::XYZC);
        assert_eq!((machine.speed_mm_min, machine.speed_deg_min), (70.0, 90.0));
    }

    #[test]
    fn mistakes_name_the_key_and_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.sparkpath");
        for (text, set, words) in [
            ("[blisk]\nmesh = \"a.stl\"", "", "kind: it is missing; write the workspace in the first line"),
            (
                "kind = \"mold\"",
                "",
                "line 1: kind is \"mold\": must be \"blisk\" here; one of a mold is for uncut, electrodes and render",
            ),
            (
                "kind = \"turbine\"",
                "",
                "kind is \"turbine\": must be \"blisk\" here; the kinds are blisk, mold and flank",
            ),
            ("kind = \"blisk\"", "electrode.parts", "expected a key and its value"),
            (
                "kind = \"blisk\"",
                "electrode.pats=2",
                "--set electrode.pats: there is no such parameter; did you mean electrode.parts?",
            ),
            ("kind = \"blisk\"", "electrode.parts=99", "--set electrode.parts is 99: must be from 1 to 20"),
            ("kind = \"blisk\"", "genetic.h=variable", "a.sparkpath: genetic.h is variable: only the strategy"),
            ("kind = \"blisk\"", "machine.name=mill", "--set machine.name: name = \"mill\": there is no such machine"),
        ] {
            std::fs::write(&file, text).unwrap();
            let set: Vec<&str> = Some(set).filter(|set| !set.is_empty()).into_iter().collect();
            let said = read(&file, &set).unwrap_err().to_string();
            assert!(said.contains(words) && !said.contains('\n'), "{said}");
        }
        let said = read(Path::new("job.toml"), &[]).unwrap_err().to_string();
        assert!(said.contains("rename it, and write kind = \"blisk\""), "{said}");
    }
}
