//! `sparkpath flank --electrode`: an electrode of a mold, of a blisk or of a folder with exported ones.

use crate::workspaces::flank::electrode_part::fit_of;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::Session;
use super::project::open;
use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::job_file::{BladesFrom, PlanJob};
use crate::workspaces::blisk::job::stages;
use crate::workspaces::context::is_project;
use crate::workspaces::flank::document::kept_mesh::KeptMesh;
use crate::workspaces::flank::document::{FlankSource, MeshFlank};
use crate::workspaces::message::{BASE_OF_MOLDS, ElectrodePart, UP_OF_MOLDS};
use crate::workspaces::mold::document::{MoldParams, part_of};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::job::uncut::uncut;
use files::{Params as _, kind_of};
use flank::fit_ruled::{PartBase, RuledFitParams};
use import::Units;
use nc::electrode_files::is_file_of;

/// The largest burn table that is read (bytes).
const LARGEST_TABLE: u64 = 16 << 20;
/// What a folder with electrodes has.
const TABLE: &str = "burn_table.json";

/// An electrode as a surface's source, and whether it is clamped upside down.
pub(super) struct FoundElectrode {
    /// The largest flank of the electrode.
    pub source: FlankSource,
    /// Whether its base is on the table and its tips look to the spindle.
    pub is_upside_down: bool,
}

/// The part of a burn table that is read.
#[derive(Deserialize)]
struct BurnTable {
    electrodes: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    name: String,
    stage: String,
}

/// The electrode called `name` of what is at `of`.
pub(super) fn find(name: &str, of: &Path, session: &Session) -> anyhow::Result<FoundElectrode> {
    if is_project(of) && kind_of(of)? == PlanJob::KIND {
        kept(of_blisk(name, of, session)?)
    } else if is_project(of) {
        kept(of_mold(name, of, session)?)
    } else if of.join(TABLE).is_file() {
        // Exported STL and OBJ are in mm.
        let source = MeshFlank {
            units: Units::Mm,
            fit: RuledFitParams {
                up: UP_OF_MOLDS,
                base: Some(PartBase::at_end(BASE_OF_MOLDS)),
                ..RuledFitParams::default()
            },
            ..MeshFlank::of(&of_folder(name, of)?)
        };
        Ok(FoundElectrode { source: FlankSource::Mesh(source), is_upside_down: true })
    } else {
        anyhow::bail!(
            "{}: electrodes are in the project of a mold or a blisk (.sparkpath), or in a folder that `sparkpath \
             electrodes` has written, with {TABLE}; one in a file of its own is given with --mesh",
            of.display()
        )
    }
}

fn kept(electrode: ElectrodePart) -> anyhow::Result<FoundElectrode> {
    let ElectrodePart { name, of, mesh, is_upside_down, .. } = &electrode;
    let source = MeshFlank {
        fit: fit_of(&electrode),
        kept: Some(KeptMesh::new(name, of, mesh).map_err(anyhow::Error::msg)?),
        ..MeshFlank::default()
    };
    Ok(FoundElectrode { source: FlankSource::Mesh(source), is_upside_down: *is_upside_down })
}

/// The electrode called `name` that is designed for a mold as its file asks.
fn of_mold(name: &str, file: &Path, session: &Session) -> anyhow::Result<ElectrodePart> {
    let asked = open::<MoldParams>(file)?.params().clone();
    let Some(mesh) = &asked.mesh else { anyhow::bail!("{}: it names no mesh; choose one and save it", file.display()) };
    let imported = session.import(mesh, &asked.reading())?;
    let of_part = asked.of_part(&part_of(&imported));
    session.note_dropped(mesh, &asked, &of_part);
    let asked = of_part;
    let task = &session.task;
    let wrong = |e: String| anyhow::anyhow!("{}: {e}", file.display());
    let left = uncut(&imported.mesh, &asked.uncut(), task).map_err(|e| wrong(e.to_string()))?;
    let set = electrodes(&imported, &left, &asked.electrodes, task).map_err(|e| wrong(e.to_string()))?;
    let found = set.electrodes.iter().find(|e| e.name == name);
    let names = || set.electrodes.iter().map(|e| e.name.clone()).collect();
    Ok(ElectrodePart::of_mold(found.ok_or_else(|| unknown(name, file, names()))?, &asked.name()))
}

/// The electrode that is made for the channel of a blisk, by its number: 1, 2 and so on.
fn of_blisk(name: &str, file: &Path, session: &Session) -> anyhow::Result<ElectrodePart> {
    let document = open::<PlanJob>(file)?;
    let job = document.params();
    if job.blisk.mesh.is_none() && job.blisk.sections == BladesFrom::None {
        anyhow::bail!("{}: blisk.mesh is missing", file.display());
    }
    let task = &session.task;
    let part = stages::load(job, task).map_err(anyhow::Error::msg)?;
    let channel = stages::channel(&part, job, &|_| {}, task).map_err(anyhow::Error::msg)?;
    let made = stages::electrodes(&part, &channel, job, task).map_err(anyhow::Error::msg)?;
    let found = name.parse::<usize>().ok().and_then(|n| Some((n, made.electrodes.get(n.checked_sub(1)?)?)));
    let names = || (1..=made.electrodes.len()).map(|n| n.to_string()).collect();
    let (number, electrode) = found.ok_or_else(|| unknown(name, file, names()))?;
    let frame = (job.export.frame == MeshFrame::Mesh).then_some(&channel.channel.frame);
    Ok(ElectrodePart::of_blisk(electrode, (number, &part.name), frame))
}

/// The file of one that was exported.
fn of_folder(name: &str, folder: &Path) -> anyhow::Result<PathBuf> {
    let file = folder.join(TABLE);
    let wrong = |e: String| anyhow::anyhow!("{}: {e}", file.display());
    let size = std::fs::metadata(&file).map_err(|e| wrong(format!("cannot be read ({e})")))?.len();
    if size > LARGEST_TABLE {
        return Err(wrong(format!("it has {size} bytes; a burn table has at most {LARGEST_TABLE}")));
    }
    let text = std::fs::read(&file).map_err(|e| wrong(format!("cannot be read ({e}); check the path")))?;
    let table: BurnTable = serde_json::from_slice(&text).map_err(|e| wrong(format!("it is no burn table ({e})")))?;
    let names = || table.electrodes.iter().map(|e| e.name.clone()).collect();
    let entry = table.electrodes.iter().find(|e| e.name == name).ok_or_else(|| unknown(name, folder, names()))?;
    let entries = std::fs::read_dir(folder).map_err(|e| wrong(format!("its folder cannot be read ({e})")))?;
    let mut files: Vec<String> = entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect();
    // The exact one first. In glTF files another axis is up.
    let endings = [".obj", ".stl"];
    files.retain(|file| {
        is_file_of(file, &entry.name, &entry.stage) && endings.iter().any(|ending| file.ends_with(ending))
    });
    files.sort();
    let found = files.into_iter().next().map(|file| folder.join(file));
    found.ok_or_else(|| {
        anyhow::anyhow!(
            "{}: there is no file of {name} in it: its export was blocked, or it has another format; export it \
             as stl or obj",
            folder.display()
        )
    })
}

fn unknown(name: &str, of: &Path, mut names: Vec<String>) -> anyhow::Error {
    const MOST: usize = 20;
    let more = names.len().saturating_sub(MOST);
    names.truncate(MOST);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    anyhow::anyhow!("{}: there is no electrode {name:?}; there are {}{more}", of.display(), names.join(", "))
}
