//! What `sparkpath flank` is asked.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;

use super::flank_values::{
    CutName, Demo, ObjectiveName, OffsetName, PathName, SideName, TipName, check_override, direction, flank_number,
    grid, holder_part, vector,
};
use super::{Session, flank_electrode, unit};
use crate::workspaces::context::is_project;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, MeshFlank, WallsFile};
use crate::workspaces::flank::electrode_part::{keep_off_base, turn_over};
use crate::workspaces::flank::inputs::load_machine;
use files::user_folder::user_folder;
use files::{Document, Validate};
use flank::cutter::HolderPart;
use flank::params::Objective;
use import::Units;
use nc::flank_job::overrides::FlankOverride;

#[derive(Debug, Args)]
pub(super) struct FlankArguments {
    #[command(flatten)]
    pub(super) surface: SurfaceArguments,
    #[command(flatten)]
    cutter: CutterArguments,
    #[command(flatten)]
    plan: PlanArguments,
    #[command(flatten)]
    pub(super) milling: MillingArguments,
    /// Writes what was asked as a file that can be given again.
    #[arg(long, value_name = "FILE")]
    pub(super) save: Option<PathBuf>,
    /// Folder for report.html, flank.json, and, where no check fails, path.csv, flank.cl and the NC program; made if it is
    /// not there.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

/// Where the surface comes from.
#[derive(Debug, Args)]
pub(super) struct SurfaceArguments {
    /// A project (.sparkpath); the other arguments then change it.
    file: Option<PathBuf>,
    /// The guide curve that the cutter's bottom follows: a CSV file with x, y, z (mm) of a point on each line. Points are
    /// joined by one smooth curve (a cubic spline): what is straight needs points along it, and at a corner the flank ends.
    #[arg(long, value_name = "CSV", requires = "upper", conflicts_with_all = ["mesh", "demo"])]
    lower: Option<PathBuf>,
    /// The other guide curve, in the same direction.
    #[arg(long, value_name = "CSV", requires = "lower", conflicts_with_all = ["mesh", "demo"])]
    upper: Option<PathBuf>,
    /// A mesh with a flank to be milled, such as an electrode: STL, OBJ, glTF or GLB.
    #[arg(long, value_name = "MESH", conflicts_with = "demo")]
    mesh: Option<PathBuf>,
    /// An electrode with a flank to be milled, by its name: one of a mold, of a blisk or of a folder with exported ones, which
    /// --of names. Those of a mold stand upside down, tips to the spindle.
    #[arg(long, value_name = "NAME", requires = "of", conflicts_with_all = ["mesh", "demo", "lower"])]
    electrode: Option<String>,
    /// Where the electrode is from: the project of a mold or a blisk (.sparkpath), for which it is made anew, or a folder that
    /// `electrodes` has written.
    #[arg(long, value_name = "PATH", requires = "electrode")]
    of: Option<PathBuf>,
    /// Which flank of the mesh, one number from 1 as --list has them: the largest first, planes that lie last, and of an
    /// electrode of a mold those of its tips before those of its base [default: 1].
    #[arg(long, value_name = "N", value_parser = flank_number)]
    flank: Option<u32>,
    /// Lists the flanks of the mesh and ends.
    #[arg(long)]
    pub(super) list: bool,
    /// How far a flank of the mesh may be off its ruled surface (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    fit_tolerance: Option<f64>,
    /// Which way is up, from the lower guide to the upper, on the mesh: +z, -x, or three numbers with commas between
    /// [default: +z].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, value_parser = direction)]
    up: Option<DVec3>,
    /// Unit of the mesh and of the walls: auto, mm, cm, m, inch. With auto their files tell it; a mesh that says none is
    /// taken in mm, or refused if it is small or large for that, and such walls are taken in mm [default: auto].
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    units: Option<Units>,
    /// A surface that comes with the program: a or b, those of the paper that the method is from.
    #[arg(long, value_name = "NAME")]
    demo: Option<Demo>,
    /// The side of the surface that the cutter stands on: positive (where R_u x R_v points) or negative; of a mesh also
    /// automatic, outside of it. Two guides need one of the former: without it the answer says where each is.
    #[arg(long, value_name = "SIDE")]
    side: Option<SideName>,
    /// A mesh of neighbouring walls that must not be cut. Of a mesh with the flank its other faces count without being
    /// named.
    #[arg(long, value_name = "MESH")]
    walls: Option<PathBuf>,
}

/// The cutter.
#[derive(Debug, Args)]
struct CutterArguments {
    /// Radius of the cutter's bottom (mm) [default: 1].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    radius: Option<f64>,
    /// Angle between the cutter's axis and its flute; 0 for a cylinder [default: 5].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    taper_deg: Option<f64>,
    /// Length of the flutes (mm) [default: 30].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    length: Option<f64>,
    /// What is above the flutes, from below, with commas between: length:radius or length:lower radius:upper radius (mm),
    /// as in 30:3,20:10:15.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', value_parser = holder_part)]
    holder: Vec<HolderPart>,
}

/// How the path is planned.
#[derive(Debug, Args)]
struct PlanArguments {
    /// How the cutter is placed first: two-point or three-point [default: three-point].
    #[arg(long, value_name = "NAME")]
    offset: Option<OffsetName>,
    /// Places along u and v of the surface at which deviations are taken [default: 100x50].
    #[arg(long, value_name = "UxV", value_parser = grid)]
    grid: Option<[usize; 2]>,
    /// Control points of each curve of the axis surface; around a ring the least [default: 10].
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Locations of the cutter that the first path goes through [default: 50].
    #[arg(long, value_name = "N")]
    locations: Option<usize>,
    /// What the refined path is made best in: sum, rms or bounded [default: sum].
    #[arg(long, value_name = "NAME")]
    objective: Option<ObjectiveName>,
    /// Greatest overcut (mm) of the bounded objective, as 0 for none.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    max_overcut: Option<f64>,
    /// Greatest undercut (mm) of the bounded objective.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    max_undercut: Option<f64>,
    /// How deep the path may cut into the surface before the check of deviations fails (mm) [default: 0.1].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    overcut_tolerance: Option<f64>,
    /// How much stock it may leave before that check fails (mm) [default: 0.15].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    undercut_tolerance: Option<f64>,
    /// How far the cutter's bottom reaches below the lower guide (mm) [default: 0.1; 0 for --electrode of a mold, whose
    /// base goes on there].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    below: Option<f64>,
    /// Which path is milled: initial, chosen or refined [default: refined].
    #[arg(long, value_name = "NAME")]
    path: Option<PathName>,
}

/// How it is milled.
#[derive(Debug, Args)]
pub(super) struct MillingArguments {
    /// The machine: trunnion-ac, fork-cb, swivel-bc, a TOML file with one, FILE.toml#NAME of one with several, or none
    /// [default: trunnion-ac].
    #[arg(long, value_name = "NAME")]
    machine: Option<String>,
    /// Where the workpiece's zero is on the machine (mm), three numbers with commas between [default: the machine's].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    zero: Option<DVec3>,
    /// The machine's direction along which the workpiece's Z points, as -z for one that is clamped upside down [default: the
    /// machine's].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, value_parser = direction)]
    clamp_z: Option<DVec3>,
    /// The same of its X.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, value_parser = direction)]
    clamp_x: Option<DVec3>,
    /// From the spindle nose to the tip (mm) [default: the machine's].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    gauge_length: Option<f64>,
    /// Which way along the surface, with the spindle clockwise: climb or conventional [default: climb].
    #[arg(long, value_name = "NAME")]
    cut: Option<CutName>,
    /// The post: milling, milling-tcp (an example for controls that follow the tip), iso, beckhoff-edm, or a TOML file
    /// [default: milling].
    #[arg(long, value_name = "NAME")]
    post: Option<String>,
    /// The furthest that tip and flutes' top may leave the path between programmed points (mm) [default: 0.002].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Feed along the flank (mm/min) [default: 500].
    #[arg(long, value_name = "MM/MIN", allow_negative_numbers = true)]
    feed: Option<f64>,
    /// Spindle speed (1/min) [default: 12000].
    #[arg(long, value_name = "RPM", allow_negative_numbers = true)]
    spindle: Option<f64>,
    /// How far the cutter comes from the side at both ends (mm) [default: 3].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    aside: Option<f64>,
    /// How far it is lifted along its axis there (mm) [default: 30].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    retract: Option<f64>,
    /// What X Y Z of the program mean: off (positions of the axes), angles (the tip, with the rotary axes: G43.4) or vector
    /// (the tip, with the tool's direction: G43.5) [default: off].
    #[arg(long, value_name = "NAME")]
    tip_control: Option<TipName>,
    /// Exports although this check fails: ruled, guides, cutter, coverage, deviation, bounds, envelope, surface, gouge, holder,
    /// leads, machine. With a figure, as in gouge:0.12, only while none of the check's figures is greater. May be given more
    /// than once.
    #[arg(long = "override", value_name = "CHECK[:FIGURE]", value_parser = check_override)]
    overrides: Vec<FlankOverride>,
}

/// Puts a value in the place of another if it was given.
fn set<T>(place: &mut T, given: Option<impl Into<T>>) {
    if let Some(given) = given {
        *place = given.into();
    }
}

/// What is asked, and what its user is to be told of it.
pub(super) struct Asked {
    pub document: FlankDocument,
    /// In words.
    pub notes: Vec<String>,
}

impl FlankArguments {
    /// What is asked.
    pub(super) fn asked(&self, session: &Session) -> anyhow::Result<Asked> {
        let mut document = match &self.surface.file {
            Some(file) if is_project(file) => Document::<FlankDocument>::open(file)?.params().clone(),
            Some(file) => anyhow::bail!(
                "{}: a project ends in .sparkpath; give a mesh with --mesh and guide curves with --lower and --upper",
                file.display()
            ),
            None => FlankDocument::default(),
        };
        self.cutter.apply(&mut document);
        self.plan.apply(&mut document)?;
        let notes = self.milling.apply(&mut document).into_iter().collect();
        document.validate()?;
        if let (Some(name), Some(of)) = (&self.surface.electrode, &self.surface.of) {
            let found = flank_electrode::find(name, of, session)?;
            // What a file says of another part is not meant for this one, what is asked now is.
            document = document.of_another(found.source);
            document.overrides.clone_from(&self.milling.overrides);
            if found.is_upside_down {
                if self.plan.below.is_none() {
                    keep_off_base(&mut document);
                }
                turn_over(&mut document)?;
            }
        }
        self.surface.apply(&mut document)?;
        document.validate()?;
        self.milling.clamp(&mut document)?;
        Ok(Asked { document, notes })
    }
}

impl SurfaceArguments {
    fn apply(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        let given = match (&self.lower, &self.upper, &self.mesh, self.demo) {
            (Some(lower), Some(upper), _, _) => {
                let [lower, upper] = [lower, upper].map(|file| GuideSource::File(file.clone()));
                Some(FlankSource::Guides { lower, upper })
            }
            // What else a file says of its mesh is meant for the one that takes its place.
            (_, _, Some(mesh), _) => Some(FlankSource::Mesh(match &document.source {
                FlankSource::Mesh(before) => MeshFlank { file: mesh.clone(), kept: None, ..before.clone() },
                _ => MeshFlank::of(mesh),
            })),
            (_, _, _, Some(demo)) => Some(FlankSource::Demonstration { surface: demo.into() }),
            _ if self.file.is_none() && self.electrode.is_none() => anyhow::bail!(
                "no surface was given; name a .sparkpath file, --lower and --upper guide curves, a --mesh, an --electrode, or \
                 --demo a"
            ),
            _ => None,
        };
        set(&mut document.source, given);
        match &mut document.source {
            FlankSource::Mesh(mesh) => {
                set(&mut mesh.candidate, self.flank.map(|n| n as usize));
                set(&mut mesh.fit.tolerance_mm, self.fit_tolerance);
                set(&mut mesh.fit.up, self.up);
                set(&mut mesh.units, self.units);
            }
            _ if self.flank.is_some() || self.list || self.fit_tolerance.is_some() || self.up.is_some() => {
                anyhow::bail!(
                    "--flank, --list, --up and --fit-tolerance are for the flanks of a mesh; give one with --mesh"
                )
            }
            _ => {}
        }
        set(&mut document.side, self.side);
        if let Some(file) = &self.walls {
            let units = document.walls.as_ref().map_or_else(Units::default, |walls| walls.units);
            document.walls = Some(WallsFile { file: file.clone(), units });
        }
        match &mut document.walls {
            Some(walls) => set(&mut walls.units, self.units),
            None if self.units.is_some() && !matches!(document.source, FlankSource::Mesh(_)) => anyhow::bail!(
                "--units is for a mesh and for walls, and there is neither: guide curves are in mm; scale them before"
            ),
            None => {}
        }
        Ok(())
    }
}

impl CutterArguments {
    fn apply(&self, document: &mut FlankDocument) {
        let cutter = &mut document.cutter;
        let before = cutter.clone();
        set(&mut cutter.radius_mm, self.radius);
        set(&mut cutter.taper_deg, self.taper_deg);
        set(&mut cutter.length_mm, self.length);
        set(&mut cutter.holder, (!self.holder.is_empty()).then(|| self.holder.clone()));
        cutter.forget_stale_name(&before);
    }
}

impl PlanArguments {
    fn apply(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        set(&mut document.overcut_tolerance_mm, self.overcut_tolerance);
        set(&mut document.undercut_tolerance_mm, self.undercut_tolerance);
        let plan = &mut document.plan;
        set(&mut plan.offset, self.offset);
        set(&mut plan.grid, self.grid);
        set(&mut plan.control_points, self.points);
        set(&mut plan.locations, self.locations);
        set(&mut plan.below_mm, self.below);
        let (overcut_mm, undercut_mm) = (self.max_overcut, self.max_undercut);
        let has_bounds = overcut_mm.is_some() || undercut_mm.is_some();
        match self.objective {
            Some(ObjectiveName::Bounded) if !has_bounds && !matches!(plan.objective, Objective::Bounded { .. }) => {
                anyhow::bail!("--objective bounded needs a bound: give --max-overcut or --max-undercut")
            }
            Some(ObjectiveName::Sum | ObjectiveName::Rms) if has_bounds => {
                anyhow::bail!("--max-overcut and --max-undercut are for --objective bounded")
            }
            Some(ObjectiveName::Sum) => plan.objective = Objective::Sum,
            Some(ObjectiveName::Rms) => plan.objective = Objective::Rms,
            Some(ObjectiveName::Bounded) | None if has_bounds => {
                let before = match plan.objective {
                    Objective::Bounded { overcut_mm, undercut_mm } => [overcut_mm, undercut_mm],
                    _ => [None; 2],
                };
                let (overcut_mm, undercut_mm) = (overcut_mm.or(before[0]), undercut_mm.or(before[1]));
                plan.objective = Objective::Bounded { overcut_mm, undercut_mm };
            }
            Some(ObjectiveName::Bounded) | None => {}
        }
        set(&mut document.path, self.path);
        Ok(())
    }
}

impl MillingArguments {
    /// Answers what of a former machine was forgotten and is not given anew, in words.
    fn apply(&self, document: &mut FlankDocument) -> Option<String> {
        let milling = &mut document.milling;
        let machine = self.machine.as_deref().map(|name| if name == "none" { "" } else { name });
        let forgotten = machine.filter(|machine| *machine != milling.machine).and_then(|machine| {
            // What is given anew is not missed.
            milling.gauge_length_mm = milling.gauge_length_mm.filter(|_| self.gauge_length.is_none());
            milling.workpiece = milling.workpiece.take().filter(|_| !self.is_clamped_anew());
            milling.take_machine(machine)
        });
        set(&mut milling.cut, self.cut);
        milling.gauge_length_mm = self.gauge_length.or(milling.gauge_length_mm);
        set(&mut milling.post, self.post.clone());
        set(&mut milling.linearisation_mm, self.tolerance);
        set(&mut milling.program.feed_mm_per_min, self.feed);
        set(&mut milling.program.spindle_rpm, self.spindle);
        set(&mut milling.aside_mm, self.aside);
        set(&mut milling.retract_mm, self.retract);
        set(&mut milling.program.tip_control, self.tip_control);
        document.overrides.extend(self.overrides.iter().cloned());
        forgotten
    }

    fn is_clamped_anew(&self) -> bool {
        self.zero.is_some() || self.clamp_z.is_some() || self.clamp_x.is_some()
    }

    /// Puts the workpiece where it was asked for; what was not said stays where the machine's file has it.
    fn clamp(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        if !self.is_clamped_anew() {
            return Ok(());
        }
        let Some(machine) = load_machine(document, user_folder().as_deref())? else {
            anyhow::bail!("--zero, --clamp-x and --clamp-z are for a machine; give one with --machine")
        };
        let mut place = machine.workpiece;
        set(&mut place.zero_mm, self.zero);
        set(&mut place.z_axis, self.clamp_z);
        set(&mut place.x_axis, self.clamp_x);
        document.milling.workpiece = Some(place);
        Ok(())
    }
}
