//! `sparkpath uncut`: what milling cutters leave of a mold.

use std::path::{Path, PathBuf};

use clap::Args;

use super::project::{Settings, of_kind};
use super::uncut_folder::uncut_folder;
use super::{Answer, POSITIVE, Session, mm, unit};
use crate::workspaces::context::is_project;
use crate::workspaces::mold::document::cutter_file::CUTTERS;
use crate::workspaces::mold::document::demonstration::DEMONSTRATION;
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::document::standard::{open_mold, standard_mold};
use crate::workspaces::mold::document::{MoldParams, part_of};
use crate::workspaces::mold::export::UncutFiles;
use crate::workspaces::mold::job::compare::compare;
use crate::workspaces::mold::job::uncut::{Uncut, UncutParams, uncut as find_uncut};
use crate::workspaces::mold::report::steps::steps;
use crate::workspaces::mold::report::uncut::{ComparisonReport, UncutPage, UncutReport};
use crate::workspaces::mold::scene::pictures::{draw, pictures_of};
use files::paths::user_folder;
use files::report::Picture;
use files::{Document, ExportFolder, Params, Validate};
use geometry::mesh::Mesh;
use glam::DVec3;
use import::{Imported, Units};
use mold::cutter::{Cutter, CutterLibrary};
use mold::opening::Opening;
use task::{StageClock, Task};

/// A mold and the cutters that mill it. What is not given is as in the project, or as usual.
#[derive(Debug, Clone, Args)]
pub(super) struct MoldArguments {
    /// A project (.sparkpath) of a mold, or a mold: STL, OBJ, glTF, GLB or STEP. With uncut also a folder of molds, of which
    /// each is one row of a table.
    #[arg(value_name = "PROJECT|MESH")]
    file: PathBuf,
    /// The mold, in the place of the project's.
    #[arg(long, value_name = "MESH")]
    mesh: Option<PathBuf>,
    /// The cutters, with commas between: kind:radius, or kind:radius/reach/holder radius, as in flat:1,ball:0.5/20/12;
    /// a bull-nose is bull:radius:corner [default: the built-in ones].
    #[arg(long, value_name = "CUTTERS", value_delimiter = ',', conflicts_with = "library")]
    cutters: Vec<Cutter>,
    /// A library of cutters (TOML).
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// The direction in which the mold's opening looks, from where the cutters come: +x, -x, +y, -y, +z, -z, three
    /// numbers as in 0,0.5,1, or auto for the one from which most of the part is seen [default: auto].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, value_parser = opening)]
    opening: Option<GivenOpening>,
    /// Origin of the work datum, to which positions of burns refer, in the axes of the mold's file (mm) [default: its
    /// origin].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = place)]
    datum: Option<DVec3>,
    /// Angle of the datum's X axis about the opening direction, counter-clockwise seen from where the cutters come
    /// (degrees) [default: 0, as the mold lies when its opening is turned upwards].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    datum_angle: Option<f64>,
    /// Thickness of the residue up to which it counts as cut (mm) [default: 0.02].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = |text: &str| mm(text, [1e-4, 10.0]))]
    tolerance: Option<f64>,
    /// Distance of layers (mm), no others between them [default: as it has to be].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = |text: &str| mm(text, POSITIVE))]
    layers: Option<f64>,
    /// Step of the field of heights (mm) [default: as fine as it has to be].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = |text: &str| mm(text, POSITIVE))]
    step: Option<f64>,
    /// Unit of the mesh: auto, mm, cm, m, inch [default: auto].
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    units: Option<Units>,
    /// Writes what was asked as a project.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
}

/// An opening direction that is given; none for the proposed one.
#[derive(Debug, Clone, Copy)]
struct GivenOpening(Option<Opening>);

fn opening(text: &str) -> Result<GivenOpening, String> {
    match text.trim() {
        "auto" => Ok(GivenOpening(None)),
        text => {
            text.parse().map(|opening| GivenOpening(Some(opening))).map_err(|wrong: String| format!("{wrong}, or auto"))
        }
    }
}

fn place(text: &str) -> Result<DVec3, String> {
    super::numbers(text).map(DVec3::from)
}

#[derive(Debug, Args)]
pub(super) struct UncutArguments {
    #[command(flatten)]
    pub(super) mold: MoldArguments,
    /// Other cutters to compare with, written as for --cutters: what they would leave less and more, and where.
    #[arg(long, value_name = "CUTTERS", value_delimiter = ',', conflicts_with = "compare_library")]
    compare: Vec<Cutter>,
    /// A library of other cutters (TOML) to compare with.
    #[arg(long, value_name = "FILE")]
    compare_library: Option<PathBuf>,
    /// No pictures on the page.
    #[arg(long)]
    no_pictures: bool,
    /// Folder for uncut.json, uncut.txt, uncut.ply, uncut_segments.csv and uncut.html, or corpus.csv and corpus.html of a
    /// folder of molds, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A mold that was read, and what is asked of it.
pub(super) struct AskedMold {
    /// What is asked.
    pub params: MoldParams,
    /// Mesh of the mold.
    pub imported: Imported,
    /// Path of the mesh.
    pub path: PathBuf,
}

impl MoldArguments {
    /// What is asked, and the mold; `more` are the values that are given beside these. What a project says of another
    /// part is not meant for this one.
    pub(super) fn read(
        &self,
        more: impl Fn(&mut MoldParams) -> anyhow::Result<()>,
        session: &Session,
    ) -> anyhow::Result<AskedMold> {
        let before = self.before()?;
        let demonstrated = before.demonstrated(&session.task).map_err(anyhow::Error::msg)?;
        let path = before.mesh.clone().or(demonstrated.as_ref().map(|_| PathBuf::from(DEMONSTRATION)));
        let Some(path) = path else { anyhow::bail!("{}: mesh is missing; give one with --mesh", self.file.display()) };
        // What is quick to find wrong comes first.
        let with_values = |params: MoldParams| self.with_values(params, &more);
        with_values(before.clone())?;
        let imported = demonstrated.map_or_else(|| session.import(&path, &before.reading()), Ok)?;
        let mut params = with_values(before.of_part(&part_of(&imported)))?;
        if let Some(proposal) = params.open(&imported.mesh, &session.task.cancel)? {
            session.note(&format!("{}: opening direction {}", path.display(), proposal.sentence()));
        }
        session.note_dropped(&path, &with_values(before)?, &params);
        if let Some(file) = &self.save {
            Document::new(params.clone()).export(file)?;
        }
        Ok(AskedMold { params, imported, path })
    }

    /// The folder of molds that is given in the place of one.
    pub(super) fn folder(&self) -> Option<&Path> {
        Some(&*self.file).filter(|file| file.is_dir())
    }

    /// Arguments for the mesh `file` of a folder that was given.
    ///
    /// # Errors
    /// Arguments that are for one mold only.
    pub(super) fn of_file(&self, file: &Path) -> anyhow::Result<Self> {
        let is_of_one = self.mesh.is_some() || self.save.is_some();
        anyhow::ensure!(!is_of_one, "{}: --mesh and --save are for one mold, not for a folder", self.file.display());
        Ok(Self { file: file.to_owned(), ..self.clone() })
    }

    /// Finds what is wrong with the values, without the mold.
    ///
    /// # Errors
    /// The first value that is.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        self.with_values(self.before()?, &|_| Ok(())).map(drop)
    }

    /// What the project or the user's standard says.
    fn before(&self) -> anyhow::Result<MoldParams> {
        let settings = user_folder();
        let mut before = if is_project(&self.file) {
            open_mold(&self.file, settings.as_deref()).map_err(|e| of_kind(&self.file, MoldParams::KIND, e))?
        } else {
            MoldParams { mesh: Some(self.file.clone()), ..standard_mold(settings.as_deref())? }
        };
        before.mesh = self.mesh.clone().or(before.mesh);
        before.units = self.units.unwrap_or(before.units);
        self.settings.apply(&FIELDS, &mut before)?;
        Ok(before)
    }

    /// The parameters with the values that are given.
    fn with_values(
        &self,
        mut params: MoldParams,
        more: &impl Fn(&mut MoldParams) -> anyhow::Result<()>,
    ) -> anyhow::Result<MoldParams> {
        // Options of their own count more.
        self.settings.apply(&FIELDS, &mut params)?;
        self.apply(&mut params)?;
        more(&mut params)?;
        params.validate()?;
        Ok(params)
    }

    fn apply(&self, params: &mut MoldParams) -> anyhow::Result<()> {
        if let Some(file) = &self.library {
            params.library = CUTTERS.read(file)?;
        } else if !self.cutters.is_empty() {
            params.library = CutterLibrary { cutter: self.cutters.clone() };
        }
        params.opening = self.opening.map_or(params.opening, |given| given.0);
        if let Some(origin) = self.datum {
            params.datum = params.datum.at(origin, "");
        }
        params.datum.angle_deg = self.datum_angle.unwrap_or(params.datum.angle_deg);
        params.tolerance_mm = self.tolerance.unwrap_or(params.tolerance_mm);
        params.grid_step_mm = self.step.or(params.grid_step_mm);
        if let Some(spacing) = self.layers {
            params.layers.is_fixed = true;
            params.layers.spacing_mm = spacing;
            params.layers.least_spacing_mm = params.layers.least_spacing_mm.min(spacing);
        }
        Ok(())
    }
}

/// Finds what the cutters leave, compares it with what others leave if these are given, prints it and writes it into the
/// folder if there is one. The answer is no where it is not known for all of the mold.
pub(super) fn uncut(arguments: &UncutArguments, session: &Session) -> anyhow::Result<Answer> {
    if let Some(folder) = arguments.mold.folder() {
        let is_compared = !arguments.compare.is_empty() || arguments.compare_library.is_some();
        anyhow::ensure!(!is_compared, "{}: other cutters are compared on one mold, not a folder", folder.display());
        return uncut_folder(folder, &arguments.mold, arguments.out.as_deref(), session);
    }
    let other = match &arguments.compare_library {
        Some(file) => Some(CUTTERS.read(file)?),
        None => Some(CutterLibrary { cutter: arguments.compare.clone() }).filter(|other| !other.cutter.is_empty()),
    };
    arguments.out.as_deref().map_or(Ok(()), ExportFolder::check)?;
    let AskedMold { params, imported, path } = arguments.mold.read(|_| Ok(()), session)?;
    let clock = StageClock::default();
    let task = clock.timed(&session.task);
    let wrong = |e| anyhow::anyhow!("{}: {e}", path.display());
    let found = find_uncut(&imported.mesh, &params.uncut(), &task).map_err(wrong)?;
    let report = UncutReport::of(&found, imported.faces.as_ref());
    let compared = |library: CutterLibrary| {
        let others = UncutParams { library, ..params.uncut() };
        let others = find_uncut(&imported.mesh, &others, &task.as_stage("comparison"))?;
        let comparison = compare(&imported.mesh, &found, &others, &task)?;
        Ok(ComparisonReport::of(&comparison, &others.params.library, params.opening()))
    };
    let comparison = other.map(compared).transpose().map_err(wrong)?;
    let notes: Vec<String> = imported.report.notes().collect();
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let pictures = if arguments.out.is_some() && !arguments.no_pictures {
        drawn(&imported.mesh, &found, &task).unwrap_or_else(|error| {
            session.note(&format!("no pictures on the page: {error}"));
            Vec::new()
        })
    } else {
        Vec::new()
    };
    let runs = found.classed_runs(&imported.mesh, &session.task.cancel)?;
    let (comparison, times) = (comparison.as_ref(), steps(&clock.times()));
    let files = UncutFiles {
        uncut: &found,
        runs: &runs,
        report: &report,
        sha256: &imported.sha256,
        import: &imported.report,
        page: UncutPage { mold: &name, notes: &notes, comparison, times: &times, pictures: &pictures },
    };
    arguments.out.as_deref().map(|folder| files.write(folder)).transpose()?;
    super::terminal::finish();
    say!("{}", if session.json { files.json()? } else { files.text().trim_end().to_owned() });
    Ok(if report.is_whole { Answer::Yes } else { Answer::No })
}

/// Pictures of what is left of a mold.
fn drawn(mesh: &Mesh, found: &Uncut, task: &Task) -> anyhow::Result<Vec<Picture>> {
    Ok(draw(pictures_of(mesh, found, &task.cancel)?, task)?)
}
