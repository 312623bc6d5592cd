//! What `sparkpath flank` is asked.

use std::path::PathBuf;
use std::str::FromStr as _;

use clap::Args;

use super::project::{Settings, open};
use super::{Session, flank_electrode, unit};
use crate::workspaces::context::is_project;
use crate::workspaces::flank::comparison::Sweep;
use crate::workspaces::flank::document::cutter_list::{CUTTERS, CutterList, user_cutters};
use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank, WallsFile};
use crate::workspaces::flank::electrode_part::{keep_off_base, turn_over};
use crate::workspaces::flank::inputs::load_machine;
use files::Override;
use files::Validate;
use files::paths::user_folder;
use flank::cutter::HolderPart;
use flank::params::{FlankParams, Objective};
use import::Units;
use nc::flank_job::CheckKind;

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
    #[command(flatten)]
    settings: Settings,
    /// Writes what was asked as a file that can be given again.
    #[arg(long, value_name = "FILE")]
    pub(super) save: Option<PathBuf>,
    /// Folder for report.html, flank.json, and, where no check fails, path.csv, flank.cl and the NC program; made if it
    /// is not there.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

/// Where the surface comes from.
#[derive(Debug, Args)]
pub(super) struct SurfaceArguments {
    /// A project (.sparkpath) of a flank, which the other arguments change, or a mesh as with --mesh.
    #[arg(value_name = "PROJECT|MESH")]
    file: Option<PathBuf>,
    /// The guide curve that the cutter's bottom follows: a CSV file with x, y, z (mm) of a point on each line. Points
    /// are joined by one smooth curve (a cubic spline): what is straight needs points along it, and at a corner the
    /// flank ends.
    #[arg(long, value_name = "CSV", requires = "upper", conflicts_with_all = ["mesh", "demo"])]
    lower: Option<PathBuf>,
    /// The other guide curve, in the same direction.
    #[arg(long, value_name = "CSV", requires = "lower", conflicts_with_all = ["mesh", "demo"])]
    upper: Option<PathBuf>,
    /// A mesh with a flank to be milled, such as an electrode: STL, OBJ, glTF, GLB or STEP.
    #[arg(long, value_name = "MESH", conflicts_with = "demo")]
    mesh: Option<PathBuf>,
    /// An electrode with a flank to be milled, by its name: one of a mold, of a blisk or of a folder with exported
    /// ones, which --of names. Those of a mold stand upside down, tips to the spindle.
    #[arg(long, value_name = "NAME", requires = "of", conflicts_with_all = ["mesh", "demo", "lower"])]
    electrode: Option<String>,
    /// Where the electrode is from: the project of a mold or a blisk (.sparkpath), for which it is made anew, or a
    /// folder that `electrodes` has written.
    #[arg(long, value_name = "PATH", requires = "electrode")]
    of: Option<PathBuf>,
    /// Number of the flank of the mesh, from 1 as --list has them: the largest first, planes that lie last, and of an
    /// electrode of a mold those of its tips before those of its base [default: 1].
    #[arg(long, value_name = "N", value_parser = flank_number)]
    flank: Option<u32>,
    /// Lists the flanks of the mesh and ends.
    #[arg(long)]
    pub(super) list: bool,
    /// How far a flank of the mesh may be off its ruled surface (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    fit_tolerance: Option<String>,
    /// Direction upwards on the mesh, from the lower guide to the upper: +z, -x, or three numbers with commas between
    /// [default: +z].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    up: Option<String>,
    /// Unit of the mesh and of the walls: auto, mm, cm, m, inch. With auto their files tell it; a mesh that says none
    /// is taken in mm, or refused if it is small or large for that, and such walls are taken in mm [default: auto].
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    units: Option<Units>,
    /// A surface that comes with the program: a or b, those of the paper that the method is from.
    #[arg(long, value_name = "NAME")]
    demo: Option<String>,
    /// The side of the surface that the cutter stands on: positive (where R_u x R_v points) or negative; of a mesh also
    /// automatic, outside of it. Two guides need one of the former: without it the answer says where each is.
    #[arg(long, value_name = "SIDE")]
    side: Option<String>,
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
    radius: Option<String>,
    /// Angle between the cutter's axis and its flute; 0 for a cylinder [default: 5].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    taper_deg: Option<String>,
    /// Length of the flutes (mm) [default: 30].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    length: Option<String>,
    /// What is above the flutes, from below, with commas between: length:radius or length:lower radius:upper radius
    /// (mm), as in 30:3,20:10:15.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', value_parser = holder_part)]
    holder: Vec<HolderPart>,
    /// Plans with each cutter of this list, a TOML file of [[cutter]] tables, or of the user's own list where no file is
    /// given, tells the figures, and takes the best one: of those with which fewest checks fail the one with the least mean
    /// deviation.
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with_all = ["radius", "taper_deg", "length", "holder"])]
    cutters: Option<Option<PathBuf>>,
    /// Plans at equal steps of one quantity of cutter or path beside the plan itself: radius, taper or points, first and
    /// last value, and number of values, as in radius:0.5:5:10. They stand in the report with plots, and as a table in
    /// compared.csv.
    #[arg(long, value_name = "QUANTITY:FIRST:LAST:COUNT", value_parser = Sweep::from_str)]
    sweep: Option<Sweep>,
}

impl FlankArguments {
    /// The sweep that was asked for.
    pub(super) fn sweep(&self) -> Option<Sweep> {
        self.cutter.sweep
    }

    /// The list of cutters to choose the best of, if that was asked for.
    pub(super) fn cutters(&self) -> anyhow::Result<Option<CutterList>> {
        let read = |file: &Option<PathBuf>| match file {
            Some(file) => CUTTERS.read(file),
            None => user_cutters(user_folder().as_deref()),
        };
        Ok(self.cutter.cutters.as_ref().map(read).transpose()?)
    }
}

/// How the path is planned.
#[derive(Debug, Args)]
struct PlanArguments {
    /// How the cutter is placed first: two-point or three-point [default: three-point].
    #[arg(long, value_name = "NAME")]
    offset: Option<String>,
    /// Places along u and v of the surface at which deviations are taken [default: 100x50].
    #[arg(long, value_name = "UxV")]
    grid: Option<String>,
    /// Control points of each curve of the axis surface; around a ring the least [default: 10].
    #[arg(long, value_name = "N")]
    points: Option<String>,
    /// Locations of the cutter that the first path goes through [default: 50].
    #[arg(long, value_name = "N")]
    locations: Option<String>,
    /// What the refined path is made best in: sum, rms or bounded [default: sum].
    #[arg(long, value_name = "NAME")]
    objective: Option<String>,
    /// Greatest overcut (mm) of the bounded objective, as 0 for none.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    max_overcut: Option<String>,
    /// Greatest undercut (mm) of the bounded objective.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    max_undercut: Option<String>,
    /// How deep the path may cut into the surface before the check of deviations fails (mm) [default: 0.1].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    overcut_tolerance: Option<String>,
    /// How much stock it may leave before that check fails (mm) [default: 0.15].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    undercut_tolerance: Option<String>,
    /// How far the cutter's bottom reaches below the lower guide (mm) [default: 0.1; 0 for --electrode of a mold, whose
    /// base goes on there].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    below: Option<String>,
    /// Path that is milled: initial, chosen or refined [default: refined].
    #[arg(long, value_name = "NAME")]
    path: Option<String>,
}

/// Machine, post, clearances and motions of the milling.
#[derive(Debug, Args)]
pub(super) struct MillingArguments {
    /// The machine: trunnion-ac, fork-cb, swivel-bc, a TOML file with one, FILE.toml#NAME of one with several, or none
    /// [default: trunnion-ac].
    #[arg(long, value_name = "NAME")]
    machine: Option<String>,
    /// Where the workpiece's zero is on the machine (mm), three numbers with commas between [default: the machine's].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    zero: Option<String>,
    /// The machine's direction along which the workpiece's Z points, as -z for one that is clamped upside down
    /// [default: the machine's].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    clamp_z: Option<String>,
    /// The machine's direction along which the workpiece's X points [default: the machine's].
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    clamp_x: Option<String>,
    /// Length from the spindle nose to the tip (mm) [default: the machine's].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    gauge_length: Option<String>,
    /// Direction of cutting along the surface, with the spindle clockwise: climb or conventional [default: climb].
    #[arg(long, value_name = "NAME")]
    cut: Option<String>,
    /// The post: milling, milling-tcp (an example for controls that follow the tip), iso, beckhoff-edm, or a TOML file
    /// [default: milling].
    #[arg(long, value_name = "NAME")]
    post: Option<String>,
    /// The furthest that tip and flutes' top may leave the path between programmed points (mm) [default: 0.002].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    tolerance: Option<String>,
    /// Feed along the flank (mm/min) [default: 500].
    #[arg(long, value_name = "MM/MIN", allow_negative_numbers = true)]
    feed: Option<String>,
    /// Spindle speed (1/min) [default: 12000].
    #[arg(long, value_name = "RPM", allow_negative_numbers = true)]
    spindle: Option<String>,
    /// How far the cutter comes from the side at both ends (mm) [default: 3].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    aside: Option<String>,
    /// How far it is lifted along its axis there (mm) [default: 30].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    retract: Option<String>,
    /// What X Y Z of the program mean: off (positions of the axes), angles (the tip, with the rotary axes: G43.4) or
    /// vector (the tip, with the tool's direction: G43.5) [default: off].
    #[arg(long, value_name = "NAME")]
    tip_control: Option<String>,
    /// Exports although this check fails: ruled, guides, cutter, coverage, deviation, bounds, envelope, surface, gouge,
    /// holder, leads, machine. With a figure, as in gouge:0.12, only while none of the check's figures is greater. May
    /// be given more than once.
    #[arg(long = "override", value_name = "CHECK[:FIGURE]", value_parser = check_override)]
    overrides: Vec<Override>,
}

/// Sets the parameters under these keys to what options give, if they do.
fn set(document: &mut FlankDocument, given: &[(&str, &str, &Option<String>)]) -> anyhow::Result<()> {
    for (option, key, text) in given {
        if let Some(text) = text {
            *document = FIELDS.set(document, key, text).map_err(|problem| anyhow::anyhow!("{option}: {problem}"))?;
        }
    }
    Ok(())
}

/// The flank that is asked for, and notes on it for the user.
pub(super) struct Asked {
    pub document: FlankDocument,
    /// Notes for the user, in words.
    pub notes: Vec<String>,
}

impl FlankArguments {
    /// What is asked.
    pub(super) fn asked(&self, session: &Session) -> anyhow::Result<Asked> {
        let mut document = match &self.surface.file {
            Some(file) if is_project(file) => open::<FlankDocument>(file)?.params().clone(),
            _ => FlankDocument::default(),
        };
        // Options of their own count more.
        self.settings.apply(&FIELDS, &mut document)?;
        let surface = &self.surface;
        if surface.mesh.is_some() || surface.lower.is_some() || surface.demo.is_some() {
            // What a project says of its own part is not meant for the one that takes its place.
            document = document.of_another(document.source.clone());
        }
        self.cutter.apply(&mut document)?;
        self.plan.apply(&mut document)?;
        let notes = self.milling.apply(&mut document)?.into_iter().collect();
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
        let named = self.file.as_ref().filter(|file| !is_project(file));
        if let Some(file) = named
            .filter(|_| self.mesh.is_some() || self.lower.is_some() || self.demo.is_some() || self.electrode.is_some())
        {
            anyhow::bail!(
                "{}: no project (.sparkpath), and another surface is given; name one of them",
                file.display()
            );
        }
        match (&self.lower, &self.upper, self.mesh.as_ref().or(named), &self.demo) {
            (Some(lower), Some(upper), ..) => document.source = FlankSource::guides([lower.clone(), upper.clone()]),
            // What else a file says of its mesh is meant for the one that takes its place.
            (_, _, Some(mesh), _) => {
                document.source = FlankSource::Mesh(match &document.source {
                    FlankSource::Mesh(before) => MeshFlank { file: mesh.clone(), kept: None, ..before.clone() },
                    _ => MeshFlank::of(mesh),
                });
            }
            (_, _, _, Some(_)) => document.source = FlankSource::default(),
            _ if self.file.is_none() && self.electrode.is_none() => anyhow::bail!(
                "no surface was given; name a .sparkpath file, --lower and --upper guide curves, a --mesh, an \
                 --electrode, or --demo a"
            ),
            _ => {}
        }
        set(document, &[("--demo", "source.surface", &self.demo)])?;
        match &mut document.source {
            FlankSource::Mesh(mesh) => {
                mesh.candidate = self.flank.map_or(mesh.candidate, |number| number as usize);
                mesh.units = self.units.unwrap_or(mesh.units);
            }
            _ if self.flank.is_some() || self.list || self.fit_tolerance.is_some() || self.up.is_some() => {
                anyhow::bail!(
                    "--flank, --list, --up and --fit-tolerance are for the flanks of a mesh; give one with --mesh"
                )
            }
            _ => {}
        }
        set(
            document,
            &[
                ("--fit-tolerance", "source.fit.tolerance_mm", &self.fit_tolerance),
                ("--up", "source.fit.up", &self.up),
                ("--side", "side", &self.side),
            ],
        )?;
        if let Some(file) = &self.walls {
            let units = document.walls.as_ref().map_or_else(Units::default, |walls| walls.units);
            document.walls = Some(WallsFile { file: file.clone(), units });
        }
        match &mut document.walls {
            Some(walls) => walls.units = self.units.unwrap_or(walls.units),
            None if self.units.is_some() && !matches!(document.source, FlankSource::Mesh(_)) => anyhow::bail!(
                "--units is for a mesh and for walls, and there is neither: guide curves are in mm; scale them before"
            ),
            None => {}
        }
        Ok(())
    }
}

impl CutterArguments {
    fn apply(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        let before = document.cutter.clone();
        set(
            document,
            &[
                ("--radius", "cutter.radius_mm", &self.radius),
                ("--taper-deg", "cutter.taper_deg", &self.taper_deg),
                ("--length", "cutter.length_mm", &self.length),
            ],
        )?;
        if !self.holder.is_empty() {
            document.cutter.holder.clone_from(&self.holder);
        }
        document.cutter.forget_stale_name(&before);
        Ok(())
    }
}

impl PlanArguments {
    fn apply(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        let is_bounded = matches!(document.plan.objective, Objective::Bounded { .. });
        let has_bounds = self.max_overcut.is_some() || self.max_undercut.is_some();
        match self.objective.as_deref() {
            Some("bounded") if !has_bounds && !is_bounded => {
                anyhow::bail!("--objective bounded needs a bound: give --max-overcut or --max-undercut")
            }
            Some("sum" | "rms") if has_bounds => {
                anyhow::bail!("--max-overcut and --max-undercut are for --objective bounded")
            }
            Some("bounded") | None if has_bounds && !is_bounded => {
                document.plan.objective = Objective::Bounded { overcut_mm: None, undercut_mm: None };
            }
            Some("bounded") | None => {}
            _ => set(document, &[("--objective", "plan.objective", &self.objective)])?,
        }
        set(
            document,
            &[
                ("--max-overcut", "plan.objective.overcut_mm", &self.max_overcut),
                ("--max-undercut", "plan.objective.undercut_mm", &self.max_undercut),
                ("--overcut-tolerance", "overcut_tolerance_mm", &self.overcut_tolerance),
                ("--undercut-tolerance", "undercut_tolerance_mm", &self.undercut_tolerance),
                ("--offset", "plan.offset", &self.offset),
                ("--points", "plan.control_points", &self.points),
                ("--below", "plan.below_mm", &self.below),
                ("--path", "path", &self.path),
            ],
        )?;
        self.apply_samples(document)
    }

    /// Sets what has to suit the number of control points.
    fn apply_samples(&self, document: &mut FlankDocument) -> anyhow::Result<()> {
        let points = document.plan.control_points;
        let [least, most] = [FlankParams::PLACES_EACH * points, FlankParams::MOST_PLACES];
        let fits = |document: &FlankDocument| {
            let [u, v] = document.plan.grid;
            u.min(v) > 1 && (least..=most).contains(&u.saturating_mul(v))
        };
        if let Some(text) = &self.grid {
            *document = FIELDS.set(document, "plan.grid", text).ok().filter(fits).ok_or_else(|| {
                anyhow::anyhow!(
                    "--grid {text}: expected UxV, as in 100x50: two whole numbers of at least 2, from {least} (6 for \
                     each of {points} control points) to {most} samples in all"
                )
            })?;
        }
        if let Some(text) = &self.locations {
            let fits = |document: &FlankDocument| document.plan.locations >= points;
            *document = FIELDS.set(document, "plan.locations", text).ok().filter(fits).ok_or_else(|| {
                anyhow::anyhow!(
                    "--locations {text}: expected a whole number from {points}, the number of control points, to 10000"
                )
            })?;
        }
        Ok(())
    }
}

impl MillingArguments {
    /// Answers what of a former machine was forgotten and is not given anew, in words.
    fn apply(&self, document: &mut FlankDocument) -> anyhow::Result<Option<String>> {
        let milling = &mut document.milling;
        let machine = self.machine.as_deref().map(|name| if name == "none" { "" } else { name });
        let forgotten = machine.filter(|machine| *machine != milling.machine).and_then(|machine| {
            // What is given anew is not missed.
            milling.gauge_length_mm = milling.gauge_length_mm.filter(|_| self.gauge_length.is_none());
            milling.workpiece = milling.workpiece.take().filter(|_| !self.is_clamped_anew());
            milling.take_machine(machine)
        });
        set(
            document,
            &[
                ("--cut", "milling.cut", &self.cut),
                ("--gauge-length", "milling.gauge_length_mm", &self.gauge_length),
                ("--post", "milling.post", &self.post),
                ("--tolerance", "milling.linearisation_mm", &self.tolerance),
                ("--feed", "milling.program.feed_mm_per_min", &self.feed),
                ("--spindle", "milling.program.spindle_rpm", &self.spindle),
                ("--aside", "milling.aside_mm", &self.aside),
                ("--retract", "milling.retract_mm", &self.retract),
                ("--tip-control", "milling.program.tip_control", &self.tip_control),
            ],
        )?;
        document.overrides.extend(self.overrides.iter().cloned());
        Ok(forgotten)
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
        document.milling.workpiece = Some(machine.workpiece);
        set(
            document,
            &[
                ("--zero", "milling.workpiece.zero_mm", &self.zero),
                ("--clamp-z", "milling.workpiece.z_axis", &self.clamp_z),
                ("--clamp-x", "milling.workpiece.x_axis", &self.clamp_x),
            ],
        )
    }
}

/// A part of a holder, as `length:radius` or `length:lower radius:upper radius` (mm).
fn holder_part(text: &str) -> Result<HolderPart, String> {
    let wrong = || "expected length:radius or length:lower radius:upper radius in mm, as in 20:10:15".to_owned();
    let numbers: Result<Vec<f64>, _> = text.split(':').map(|n| n.trim().parse::<f64>()).collect();
    match numbers.map_err(|_| wrong())?[..] {
        [length_mm, radius] => Ok(HolderPart { length_mm, lower_radius_mm: radius, upper_radius_mm: radius }),
        [length_mm, lower_radius_mm, upper_radius_mm] => Ok(HolderPart { length_mm, lower_radius_mm, upper_radius_mm }),
        _ => Err(wrong()),
    }
}

/// The number of a flank of a mesh, from 1.
fn flank_number(text: &str) -> Result<u32, String> {
    match text.trim().parse::<u32>() {
        Ok(number) if number > 0 => Ok(number),
        _ => {
            Err("expected one number from 1, as --list has them; faces that go over into each other smoothly are one \
                  flank together there, others are milled one after the other"
                .to_owned())
        }
    }
}

/// The name of a check that is let pass, with the greatest figure if one is given.
fn check_override(text: &str) -> Result<Override, String> {
    let given: Override = text.parse()?;
    given.validate(&CheckKind::ALL.map(CheckKind::name), false).map_err(|e| e.to_string())?;
    Ok(given)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holders_faces_and_overrides_are_read_or_refused() {
        let part = holder_part("20:10:15").unwrap();
        assert_eq!((part.length_mm, part.lower_radius_mm, part.upper_radius_mm), (20.0, 10.0, 15.0));
        assert_eq!(holder_part("30:3").unwrap().upper_radius_mm, 3.0);
        for text in ["", "20", "20:a", "1:2:3:4"] {
            assert!(holder_part(text).is_err(), "{text}");
        }
        assert_eq!(check_override("gouge:0.2").unwrap().most, Some(0.2));
        let why = check_override("nonsense").unwrap_err();
        assert!(why.contains("nonsense") && why.contains("ruled, guides, cutter, coverage"), "{why}");
        assert_eq!(flank_number("3"), Ok(3));
        for text in ["0", "3,4", "-1", "a", ""] {
            assert!(flank_number(text).unwrap_err().contains("one number from 1"), "{text}");
        }
    }

    #[test]
    fn grids_and_locations_that_do_not_suit_are_answered_in_the_form_of_their_options() {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            plan: PlanArguments,
        }
        let apply = |line: &[&str]| {
            let plan = <Line as clap::Parser>::parse_from([&["flank"], line].concat()).plan;
            let mut document = FlankDocument::default();
            plan.apply(&mut document).map(|()| document).map_err(|e| e.to_string())
        };
        for text in ["10", "2x2", "1x100", "axb", "2000x2000"] {
            let said = apply(&["--grid", text]).unwrap_err();
            assert!(said.contains(&format!("--grid {text}: expected UxV, as in 100x50")), "{said}");
            assert!(said.contains("from 60 (6 for each of 10 control points) to 1000000 samples"), "{said}");
        }
        for text in ["5", "none", "20000"] {
            let said = apply(&["--locations", text]).unwrap_err();
            assert!(said.contains(&format!("--locations {text}: expected a whole number from 10,")), "{said}");
        }
        let fewer = apply(&["--points", "5", "--grid", "6x5", "--locations", "5"]).unwrap().plan;
        assert_eq!((fewer.control_points, fewer.grid, fewer.locations), (5, [6, 5], 5));
        let said = check_override("gouge:abc").unwrap_err();
        assert!(said.contains("gouge:abc: expected CHECK or CHECK:FIGURE with a number"), "{said}");
    }

    #[test]
    fn options_name_parameters_and_say_what_is_wrong() {
        let document = |key: &str, text: &str| {
            let mut document = FlankDocument::default();
            set(&mut document, &[("--option", key, &Some(text.to_owned()))]).map(|()| document)
        };
        assert_eq!(document("plan.grid", "100x50").unwrap().plan.grid, [100, 50]);
        let z_axis =
            |text: &str| document("milling.workpiece.z_axis", text).map(|d| d.milling.workpiece.unwrap().z_axis);
        assert_eq!(z_axis("-Z").unwrap(), glam::DVec3::NEG_Z);
        assert_eq!(z_axis("0,1,-2.5").unwrap(), glam::DVec3::new(0.0, 1.0, -2.5));
        for text in ["w", "1,2", "nan,0,0"] {
            assert!(z_axis(text).unwrap_err().to_string().starts_with("--option: milling.workpiece.z_axis"), "{text}");
        }
        for text in ["", "100", "100x", "-1x5", "1x2x3"] {
            assert!(document("plan.grid", text).is_err(), "{text}");
        }
    }
}
