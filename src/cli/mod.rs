//! The command line. Parses arguments, reads files, runs jobs, writes results, and answers with the exit
//! codes of the contract:
//!
//! | code | meaning |
//! | --- | --- |
//! | 0 | done and verified |
//! | 1 | internal error |
//! | 2 | bad usage, bad input or unreadable file: one line on standard error |
//! | 3 | the answer is no: no path, or a check failed; results are written all the same |
//! | 130 | cancelled: nothing is written, or what was certified by then, without a program |

/// Prints a line on standard output, like `println!`, but survives a closed one.
macro_rules! say {
    ($($argument:tt)*) => { $crate::cli::terminal::print(&format!($($argument)*)) };
}

mod compare;
mod design;
mod electrodes;
mod flank;
mod flank_arguments;
mod flank_electrode;
mod inspect;
mod job_sheet;
mod measured;
mod plan;
mod project;
mod reference;
mod render;
mod render_project;
mod reproduce;
mod setup_sheet;
mod simulate;
mod size;
mod study;
mod technology;
mod terminal;
mod uncut;
mod uncut_folder;
mod verify;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};

use crate::panic_text;
use crate::shell::run::Opening;
use crate::shell::startup::run_window;
use crate::widgets::camera::NamedView;
use crate::workspaces::blisk::document::choice::Channels;
use crate::workspaces::mold::document::MoldParams;
use ::render::colour::Theme;
use feed::plan_params::Strategy;
use feed::pose::Axis;
use feed::verify::setting::{ACCURACY_MM, SettingErrors};
use import::{ImportOptions, ImportReport, Imported, Reading, Units, import_file};
use project::{ProjectArguments, Settings};
use task::{Cancel, Task};
use wheel::section_deviation::P1_LIMIT_MM;

/// Plans and verifies feed paths of EDM electrodes, designs electrodes for molds, and plans flank milling.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Opens the window on this project or mesh; without it on the built-in demonstration blisk.
    file: Option<PathBuf>,
    /// Progress as one JSON object a line on standard error, and the answer as JSON on standard output.
    #[arg(long, global = true)]
    json: bool,
    /// Threads to work on; the results do not depend on it [default: one per core].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Seed of the genetic search, in place of the project's: the same seed gives the same bytes.
    #[arg(long, global = true, value_name = "N")]
    seed: Option<u64>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The whole journey on the built-in demonstration blisk: plan, verify, export.
    Demo {
        #[command(flatten)]
        settings: Settings,
        /// Folder for the results, made if it is not there.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Electrodes and their verified feed paths for a blisk.
    Plan {
        #[command(flatten)]
        project: ProjectArguments,
        /// Folder for the results, made if it is not there.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// Places of the electrodes on their holders (CSV: electrode, x_mm, y_mm, z_mm, c_deg, uncertainty_mm, date): paths and
        /// programs make up for them, and are certified so.
        #[arg(long, value_name = "CSV")]
        presets: Option<PathBuf>,
    },
    /// The thickest electrodes that come out: least reductions for one part and more, on either side, each certified,
    /// whatever the reductions of the project are.
    Size {
        #[command(flatten)]
        project: ProjectArguments,
        /// Up to how many parts.
        #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=20))]
        parts: u8,
    },
    /// The sets of electrodes that burn a wheel in the fewest hours: parts, planes between them, columns, sides and reductions
    /// together, each set certified.
    Design(design::DesignArguments),
    /// One of these commands on many variants of a project: a grid, a list or samples of its parameters, with one table and
    /// plots. On this machine, or on many with Snakemake.
    Study(study::StudyArguments),
    /// The paths of several strategies on the same electrodes, side by side: clearance, smoothness, times. The
    /// project's own strategy does not matter.
    Compare {
        #[command(flatten)]
        project: ProjectArguments,
        /// Folder for comparison.json, comparison.csv and comparison.html, made if it is not there.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// Strategies, with commas between [default: all].
        #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = compare::strategy())]
        strategies: Vec<Strategy>,
    },
    /// The whole motion of a plan on its machine: approach, feed, copying, retraction and the other channels, with
    /// every body of the machine.
    Simulate {
        #[command(flatten)]
        project: ProjectArguments,
        /// Channels: own, all, or numbers with commas between [default: those of the project].
        #[arg(long, value_name = "CHANNELS")]
        channels: Option<Channels>,
        /// Folder for simulation.json and simulation.txt, made if it is not there.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// What milling cutters that come from above leave of a mold, or of every mold in a folder.
    Uncut(uncut::UncutArguments),
    /// Electrodes for what milling cutters leave of a mold: files, burn table, burn sheet, report.
    Electrodes(electrodes::ElectrodesArguments),
    /// A ruled surface milled with the flank of a cutter on five axes: path, checks, report, cutter locations, NC
    /// program.
    Flank(Box<flank_arguments::FlankArguments>),
    /// Opens the window on a mold.
    Mold {
        /// Mesh of the mold: STL, OBJ, glTF, GLB or STEP.
        mesh: Option<PathBuf>,
    },
    /// Certifies a feed path file, whoever made it.
    Verify(VerifyArguments),
    /// A picture of a project or of meshes as a PNG file, without a window.
    Render(RenderArguments),
    /// The tables and figures of the papers that the program builds on, beside its own results, on parts of its own.
    Reproduce(reproduce::ReproduceArguments),
    /// What the importer and the channel finder make of a mesh.
    Inspect(InspectArguments),
    /// A finished part that was scanned: best fit to its nominal mesh, deviations surface by surface, and whether they are
    /// within a tolerance.
    Measured(measured::MeasuredArguments),
    /// Prints the JSON schema of job.json, the job file that plans and electrodes are exported with.
    JobSchema,
    /// Text of any form made of a job file through a template: a job sheet.
    JobSheet(job_sheet::JobSheetArguments),
    /// Where a job lies from the balls and corners that a machine touches, what a ball must read once A is turned, and where
    /// the electrodes are measured on their holders.
    SetupSheet(setup_sheet::SetUpSheetArguments),
    /// Prints and checks a technology table: source, basis, steps, and the figures that are missing.
    Technology {
        /// A technology table (TOML) [default: the built-in one].
        #[arg(value_name = "FILE")]
        table: Option<PathBuf>,
    },
    /// Prints a script by which a shell completes commands and options.
    Completions {
        /// The shell.
        #[arg(value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Writes a man page of the program and of each command.
    Man {
        /// Folder for the pages, made if it is not there.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

#[derive(Debug, Args)]
struct VerifyArguments {
    /// The finished blisk.
    #[arg(long, value_name = "MESH")]
    blisk: PathBuf,
    /// The electrode in its final pose, in the coordinates of the blisk's mesh (mm).
    #[arg(long, value_name = "MESH")]
    electrode: PathBuf,
    /// The feed path.
    #[arg(long, value_name = "CSV")]
    path: PathBuf,
    /// Spark gap to be kept (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    gap: f64,
    /// How far below the gap is still accepted (mm).
    #[arg(long, value_name = "MM", default_value_t = 0.002, allow_negative_numbers = true)]
    tolerance: f64,
    /// Unit of the blisk's mesh: auto, mm, cm, m, inch.
    #[arg(long, value_name = "UNIT", default_value = "auto", value_parser = unit)]
    units: Units,
    /// Numbers of the solids of a STEP file that make the blisk, with commas between, as in blisk.solids.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    solids: Vec<u32>,
    /// Numbers of the solids of the same file that are in the way, with commas between, as in blisk.obstacles.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    obstacles: Vec<u32>,
    /// Travel of an axis about the final pose in mm or degrees, such as X=-250,250; once for each axis that has limits.
    /// Without any, travel is not judged.
    #[arg(long, value_name = "AXIS=LEAST,GREATEST", value_parser = travel)]
    travel: Vec<(Axis, [f64; 2])>,
    /// Greatest setting errors of the axes, in either sense: X,Y,Z in mm and A,B,C in degrees. The largest errors of this
    /// shape that the path bears are told, and the answer is no where it does not bear these.
    #[arg(long, value_name = "X,Y,Z,A,B,C", value_parser = setting)]
    setting: Option<SettingErrors>,
    /// How far below the gap setting errors may bring the clearance (mm).
    #[arg(long, value_name = "MM", default_value_t = ACCURACY_MM, requires = "setting", allow_negative_numbers = true)]
    accuracy: f64,
    /// Folder for verify.json and verify.html, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct RenderArguments {
    /// A project (.sparkpath), or meshes, which are shown together, each in its own colour.
    #[arg(required = true, value_name = "PROJECT|MESH")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// The file for the picture.
    #[arg(long, value_name = "FILE")]
    png: PathBuf,
    /// Width and height (pixels).
    #[arg(long, value_name = "WxH", default_value = "1400x900", value_parser = render::size)]
    size: [u32; 2],
    /// Plans the project of a blisk and shows its electrode at this node, counted from the final pose.
    #[arg(long, value_name = "N")]
    node: Option<usize>,
    /// Number of the project's electrode that is shown, from 1 [default: 1; of a mold none, but what is left uncut].
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    electrode: Option<u32>,
    /// Plans the project of a blisk and shows the room that the electrode passes through on its way.
    #[arg(long)]
    swept: bool,
    /// Front, back, left, right, top, bottom, isometric, or of a blisk channel: into its channel, without the shroud
    /// [default: isometric, with --node or --swept channel].
    #[arg(long, value_name = "NAME", value_parser = render::view)]
    view: Option<NamedView>,
    /// Colours of the surroundings: light or dark.
    #[arg(long, value_name = "NAME", default_value = "light", value_parser = render::theme)]
    theme: Theme,
    /// Unit of the meshes: auto, mm, cm, m, inch.
    #[arg(long, value_name = "UNIT", default_value = "auto", value_parser = unit)]
    units: Units,
}

#[derive(Debug, Args)]
struct InspectArguments {
    #[command(flatten)]
    project: ProjectArguments,
    /// Measured sections of the channel's walls in W: a CSV file with the columns section, side (low or high), x, and
    /// y, z or r, theta_deg. Their points are judged against the walls, and their surfaces are compared with the mesh.
    #[arg(long, value_name = "CSV")]
    sections: Option<PathBuf>,
    /// Greatest deviation of a measured point from its wall, either way (mm).
    #[arg(long, value_name = "MM", default_value_t = P1_LIMIT_MM, value_parser = |text: &str| mm(text, POSITIVE), requires = "sections")]
    limit: f64,
}

fn unit(text: &str) -> Result<Units, String> {
    let value = toml::Value::String(text.to_owned());
    value.try_into().map_err(|_| "expected auto, mm, cm, m or inch".to_owned())
}

/// Allowed values of a length above zero (mm).
const POSITIVE: [f64; 2] = [1e-6, 1e4];

/// A length (mm) from the first to the second of `limits`, with a decimal point or comma.
fn mm(text: &str, limits: [f64; 2]) -> Result<f64, String> {
    let [least, most] = limits;
    let number = text.trim().replace(',', ".").parse::<f64>().ok().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| format!("expected a length in mm from {least} to {most}, as in 0.05"))
}

/// `N` numbers with commas between.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let example = || ["10", "-4.5", "0", "5", "0", "0"].iter().cycle().take(N).copied().collect::<Vec<_>>().join(",");
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|n| n.is_finite());
    let all: Option<Vec<f64>> = text.split(',').map(number).collect();
    all.and_then(|all| all.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers with commas between, as in {}", example()))
}

fn setting(text: &str) -> Result<SettingErrors, String> {
    let [x_mm, y_mm, z_mm, a_deg, b_deg, c_deg] = numbers(text)?;
    let errors = SettingErrors { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg };
    errors.validate().map(|()| errors).map_err(|e| e.to_string())
}

fn travel(text: &str) -> Result<(Axis, [f64; 2]), String> {
    let wrong = || "expected an axis and its limits, as in X=-250,250, that include 0, the final pose".to_owned();
    let (letter, limits) = text.split_once('=').ok_or_else(wrong)?;
    let (least, greatest) = limits.split_once(',').ok_or_else(wrong)?;
    let axis = Axis::ALL.into_iter().find(|a| letter.trim().eq_ignore_ascii_case(&a.letter().to_string()));
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
    let travel = [number(least)?, number(greatest)?];
    match axis {
        Some(axis) if travel[0] <= 0.0 && travel[1] >= 0.0 => Ok((axis, travel)),
        _ => Err(wrong()),
    }
}

/// How a command ended, short of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    /// Done and verified.
    Yes,
    /// The question has the answer no.
    No,
    /// Cancelled in a stage; what was done before is written or printed.
    Stopped {
        /// The stage.
        stage: &'static str,
        /// What there is of it, in words.
        written: &'static str,
    },
}

/// What a command works with.
struct Session {
    task: Task,
    json: bool,
    seed: Option<u64>,
}

impl Session {
    /// Imports a mesh file. Notes that its unit is a guess.
    fn import(&self, path: &Path, reading: &Reading) -> anyhow::Result<Imported> {
        let imported = self.import_silently(path, reading)?;
        self.note_unit(path, &imported.report);
        Ok(imported)
    }

    /// Notes on standard error a unit that was guessed.
    fn note_unit(&self, path: &Path, report: &ImportReport) {
        if let Some(doubt) = report.unit_doubt() {
            self.note(&format!("{}: {doubt}", path.display()));
        }
    }

    /// Imports a mesh file whose report is printed.
    fn import_silently(&self, path: &Path, reading: &Reading) -> anyhow::Result<Imported> {
        let options = ImportOptions { reading: reading.clone(), ..Default::default() };
        Ok(import_file(path, &options, &self.task)?)
    }

    /// Notes on standard error which decisions of `before`, for a former mesh, are not among `params` for `mesh`.
    fn note_dropped(&self, mesh: &Path, before: &MoldParams, params: &MoldParams) {
        if let Some(dropped) = params.dropped(before) {
            self.note(&format!("{}: {dropped}", mesh.display()));
        }
    }

    /// Prints a note on standard error.
    fn note(&self, text: &str) {
        terminal::finish();
        terminal::print_error(&if self.json {
            serde_json::json!({ "note": text }).to_string()
        } else {
            format!("note: {text}")
        });
    }
}

/// Refuses a mesh with holes: it has no inside, so nothing about its clearance can be proven.
fn require_closed(path: &Path, report: &ImportReport) -> anyhow::Result<()> {
    anyhow::ensure!(
        report.watertight,
        "{}: the surface is not closed ({} holes, {} edges of more than two triangles), so it has no inside and \
         nothing can be proven about it; close it in the program it came from",
        path.display(),
        report.hole_count,
        report.non_manifold_edges
    );
    Ok(())
}

impl Command {
    /// Whether what it has by the time it is interrupted is written.
    fn keeps_parts(&self) -> bool {
        match self {
            Self::Demo { .. } | Self::Plan { .. } | Self::Study(_) => true,
            Self::Uncut(arguments) => arguments.mold.folder().is_some(),
            _ => false,
        }
    }
}

/// A failure that is this program's own fault.
#[derive(Debug, thiserror::Error)]
#[error("internal error: {0}; please report it with the files that led to it")]
struct Internal(String);

/// Exit code of a command that was interrupted.
const CANCELLED: u8 = 130;
/// Time for which an interrupted command may go on if nothing of it is written, or if none of its work has looked at the flag
/// that cancels it. The system takes some more to give back the memory of the process.
const PATIENCE: Duration = Duration::from_millis(100);

/// Runs the program on the process's arguments.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Nothing is parsed yet, and the wish for JSON has to be honoured all the same.
        Err(error) => return usage(&error, std::env::args_os().any(|a| a == "--json")),
    };
    if let Some(threads) = arguments.threads {
        let built = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        if let Err(error) = built {
            return report(&anyhow::Error::new(Internal(error.to_string())), arguments.json);
        }
    }
    let cancel = Cancel::default();
    let (flag, cancelled) = (cancel.clone(), cancel.clone());
    // The window looks at no flag: it shall end as any window does, and its unsaved work is kept by autosave.
    let is_window = matches!(arguments.command, None | Some(Command::Mold { .. }));
    let (json, keeps_parts) = (arguments.json, arguments.command.as_ref().is_some_and(Command::keeps_parts));
    let interrupted = move || {
        flag.cancel();
        // What looks at the flag stops, and says how far it came. What does not, as work of a library, is left.
        std::thread::sleep(PATIENCE);
        if !(keeps_parts && flag.is_seen()) {
            terminal::finish();
            let _ = fail("cancelled; what was not yet written is dropped", CANCELLED, json);
            std::process::exit(CANCELLED.into());
        }
    };
    let handled = if is_window { Ok(()) } else { ctrlc::set_handler(interrupted) };
    if let Err(error) = handled {
        return report(&anyhow::Error::new(Internal(error.to_string())), arguments.json);
    }
    let task = Task { progress: terminal::progress(arguments.json), cancel };
    let session = Session { task, json: arguments.json, seed: arguments.seed };
    // A panic is a fault of the program: it ends as one line and exit code 1, like any other.
    std::panic::set_hook(Box::new(|_| {}));
    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| dispatch(&arguments, &session)));
    terminal::finish();
    match outcome {
        Ok(Ok(Answer::Yes)) => ExitCode::SUCCESS,
        Ok(Ok(Answer::No)) => ExitCode::from(3),
        Ok(Ok(Answer::Stopped { stage, written })) => {
            fail(&format!("cancelled: the {stage} was stopped; {written}"), CANCELLED, arguments.json)
        }
        // What a computation answers once it has been told to stop is that it stopped.
        Ok(Err(_)) if cancelled.is_cancelled() => fail("cancelled; nothing was written", CANCELLED, arguments.json),
        Ok(Err(error)) => report(&error, arguments.json),
        Err(panic) => report(&anyhow::Error::new(Internal(panic_text(&*panic))), arguments.json),
    }
}

fn dispatch(arguments: &Arguments, session: &Session) -> anyhow::Result<Answer> {
    let Some(command) = &arguments.command else {
        if let Some(file) = arguments.file.as_ref().filter(|f| !f.exists()) {
            anyhow::bail!("{}: there is neither a command nor a file of that name; see --help", file.display());
        }
        let opening = arguments.file.clone().map_or(Opening::Demonstration, Opening::File);
        return run_window(opening).map(|()| Answer::Yes).map_err(anyhow::Error::msg);
    };
    match command {
        Command::Demo { settings, out } => plan::demo(settings, out, session),
        Command::Plan { project, out, presets } => plan::plan(project, presets.as_deref(), out, session),
        Command::Size { project, parts } => size::size(project, usize::from(*parts), session),
        Command::Compare { project, out, strategies } => compare::compare(project, out, strategies, session),
        Command::Simulate { project, channels, out } => {
            simulate::simulate(project, channels.as_ref(), out.as_deref(), session)
        }
        Command::Design(arguments) => design::design(arguments, session),
        Command::Study(arguments) => study::study(arguments, session),
        Command::Uncut(arguments) => uncut::uncut(arguments, session),
        Command::Electrodes(arguments) => electrodes::electrodes(arguments, session),
        Command::Flank(arguments) => flank::flank(arguments, session),
        Command::Mold { mesh } => {
            if let Some(file) = mesh.as_ref().filter(|f| !f.exists()) {
                anyhow::bail!("{}: there is no file of that name", file.display());
            }
            run_window(Opening::In("mold", mesh.clone())).map(|()| Answer::Yes).map_err(anyhow::Error::msg)
        }
        Command::Verify(arguments) => verify::verify(arguments, session),
        Command::Render(arguments) => render::render(arguments, session),
        Command::Reproduce(arguments) => reproduce::reproduce(arguments, session),
        Command::Inspect(arguments) => inspect::inspect(arguments, session),
        Command::Measured(arguments) => measured::measured(arguments, session),
        Command::JobSchema => {
            say!("{}", nc::job_file::SCHEMA.trim_end());
            Ok(Answer::Yes)
        }
        Command::JobSheet(arguments) => job_sheet::job_sheet(arguments),
        Command::SetupSheet(arguments) => setup_sheet::set_up_sheet(arguments),
        Command::Technology { table } => technology::technology(table.as_deref(), session),
        Command::Completions { shell } => Ok(reference::completions(*shell)),
        Command::Man { out } => reference::man(out),
    }
}

/// Help and version go to standard output with exit code 0; wrong usage is one line and exit code 2.
fn usage(error: &clap::Error, json: bool) -> ExitCode {
    if !error.use_stderr() || error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let _ = error.print();
        return if error.use_stderr() { ExitCode::from(2) } else { ExitCode::SUCCESS };
    }
    let text = error.to_string();
    let said = text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:"));
    let is_said = |l: &&str| !l.is_empty() && !l.starts_with("tip:") && !l.starts_with("For more information");
    let said: Vec<&str> = said.filter(is_said).collect();
    fail(&format!("{}; see --help", said.join(" ")), 2, json)
}

/// Writes one line on standard error, and gives the exit code that tells whose fault it is.
fn report(error: &anyhow::Error, json: bool) -> ExitCode {
    let line = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    fail(&format!("error: {line}"), if error.is::<Internal>() { 1 } else { 2 }, json)
}

/// Says in one line why the program ends with `code`: in words, or as a JSON object.
fn fail(line: &str, code: u8, json: bool) -> ExitCode {
    if json {
        let message = line.strip_prefix("error: ").unwrap_or(line);
        terminal::print_error(&serde_json::json!({ "error": message, "exit_code": code }).to_string());
    } else {
        terminal::print_error(line);
    }
    ExitCode::from(code)
}
