//! `sparkpath uncut`: what milling cutters leave of a mold.

use std::path::PathBuf;

use clap::Args;

use super::{Answer, Session, unit};
use crate::workspaces::mold::document::cutter_file::{CUTTERS, standard_cutters};
use crate::workspaces::mold::job::uncut::{UncutParams, uncut as find_uncut};
use crate::workspaces::mold::report::uncut::UncutReport;
use crate::workspaces::mold::report::uncut_ply::surface_as_ply;
use files::ExportFolder;
use import::Units;
use mold::cutter::{Cutter, CutterLibrary};
use mold::opening::Opening;

/// A mold and the cutters that mill it.
#[derive(Debug, Args)]
pub(super) struct MoldArguments {
    /// The mold: STL, OBJ, glTF or GLB.
    pub(super) mesh: PathBuf,
    /// The cutters, with commas between: kind:radius, or kind:radius/reach/holder radius, as in flat:1,ball:0.5/20/12; a
    /// bull-nose is bull:radius:corner.
    #[arg(long, value_name = "CUTTERS", value_delimiter = ',', conflicts_with = "library")]
    cutters: Vec<Cutter>,
    /// A library of cutters (TOML) [default: the built-in one].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// The direction in which the mold's opening looks, from where the cutters come: +x, -x, +y, -y, +z, -z.
    #[arg(long, value_name = "AXIS", default_value = "+z", allow_hyphen_values = true)]
    opening: Opening,
    /// Thickness of the residue up to which it counts as cut (mm).
    #[arg(long, value_name = "MM", default_value_t = 0.02, allow_negative_numbers = true)]
    tolerance: f64,
    /// Distance of layers (mm), no others between them [default: as it has to be].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    layers: Option<f64>,
    /// Step of the field of heights (mm) [default: as fine as it has to be].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Unit of the mesh: auto, mm, cm, m, inch.
    #[arg(long, value_name = "UNIT", default_value = "auto", value_parser = unit)]
    pub(super) units: Units,
}

#[derive(Debug, Args)]
pub(super) struct UncutArguments {
    #[command(flatten)]
    mold: MoldArguments,
    /// Folder for uncut.json, uncut.txt and uncut.ply, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl MoldArguments {
    /// What is asked.
    pub(super) fn params(&self) -> anyhow::Result<UncutParams> {
        let library = match &self.library {
            _ if !self.cutters.is_empty() => CutterLibrary { cutter: self.cutters.clone() },
            Some(file) => CUTTERS.read(file)?,
            None => standard_cutters()?,
        };
        let mut params = UncutParams { opening: self.opening, ..UncutParams::of(library) };
        (params.tolerance_mm, params.grid_step_mm) = (self.tolerance, self.step);
        if let Some(spacing) = self.layers {
            params.layers.is_fixed = true;
            params.layers.spacing_mm = spacing;
            params.layers.least_spacing_mm = params.layers.least_spacing_mm.min(spacing);
        }
        params.validate()?;
        Ok(params)
    }
}

/// Finds what the cutters leave, prints it and writes it into the folder if there is one. The answer is no where the mesh
/// is not whole.
pub(super) fn uncut(arguments: &UncutArguments, session: &Session) -> anyhow::Result<Answer> {
    let params = arguments.mold.params()?;
    let mesh = &arguments.mold.mesh;
    let imported = session.import(mesh, arguments.mold.units)?;
    let found =
        find_uncut(&imported.mesh, &params, &session.task).map_err(|e| anyhow::anyhow!("{}: {e}", mesh.display()))?;
    let report = UncutReport::of(&found);
    let text = report.text();
    let json = serde_json::to_string_pretty(&serde_json::json!({
        "sha256": imported.sha256, "import": imported.report, "uncut": report,
    }))?;
    if let Some(folder) = &arguments.out {
        let surface = surface_as_ply(&found.surface, params.opening);
        let files =
            [("uncut.json", json.as_bytes()), ("uncut.txt", text.as_bytes()), ("uncut.ply", surface.as_slice())];
        ExportFolder::write_all(folder, "uncut", &files)?;
    }
    super::terminal::finish();
    say!("{}", if session.json { &json } else { text.trim_end() });
    Ok(if report.is_whole { Answer::Yes } else { Answer::No })
}
