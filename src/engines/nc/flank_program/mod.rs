//! NC programs of flank paths: the positions of a five-axis milling machine in the words of a post.
//!
//! X Y Z A B C are positions of the machine's axes: the control needs no knowledge of the machine. For controls that
//! follow the tool's tip, X Y Z can be the tip on the workpiece, with the rotary axes or the tool's direction beside
//! it. What is not verified, and so stands in the program's comments: the way to the first position.

pub(crate) mod settings;

pub use settings::{BUILT_IN_POST, BUILT_IN_POSTS, FlankNcSettings, TipControl, milling_post, milling_posts};

use super::approved_flank::ApprovedFlank;
use super::post::{FeedMode, Post, PostError};
use crate::block_feed::{LEAST_BLOCK_MINUTES, slow_down, whole_seconds};
use crate::lines::Lines;
use crate::lines::NcError;
use feed::pose::Axis;
use feed::quantise;
use feed::quantise::{deg_text, mm_text};
use flank::machine::joint_feed::{Contact, Pace, Slowed, paces};
use flank::machine::kinematics::{Kinematics, MachineKind};
use flank::machine::linearise;
use flank::machine::linearise::{LinearisationParams, MachinePath, MachinePoint};
use flank::machine::tool_path::{Section, ToolPath};

/// Measured values have the decimals that are written.
const _: () =
    assert!(linearise::MM_DECIMALS == quantise::MM_DECIMALS && linearise::DEG_DECIMALS == quantise::DEG_DECIMALS);
/// Decimals of a tool's direction.
const DIRECTION_DECIMALS: usize = 9;
/// Input of a program.
struct FlankNcJob<'a> {
    /// Name of the program.
    program: &'a str,
    /// The cutter in words.
    cutter: &'a str,
    /// The machine.
    machine: &'a Kinematics,
    /// The path.
    path: &'a ToolPath<'a>,
    /// The machine's positions along it.
    line: &'a MachinePath,
    /// Parameters of the positions.
    params: &'a LinearisationParams,
    /// Where the flutes touch, for the feed; none where it is that of the tool's axis.
    contact: Option<Contact>,
    /// Notes for the operator: surface, tolerances, the deviation of the path.
    notes: &'a [String],
    /// Warnings.
    warnings: &'a [String],
}

/// An NC program.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankNc {
    /// The program, line ends included.
    pub text: String,
    /// File name extension that the control expects, without the dot.
    pub extension: String,
    /// Time from the first position to the last (min).
    pub minutes: f64,
    /// Where an axis would be too fast: how many moves are slower than asked for, the least share of the feed that is
    /// left, and the axis.
    pub slowed: Option<(usize, f64, char)>,
    /// Where a move would be shorter than the time that any block is given: how many moves take longer for it, and the
    /// least share of their speed that is left.
    pub stretched: Option<(usize, f64)>,
}

/// Reason why no program of a flank could be made.
#[derive(Debug, thiserror::Error)]
pub enum FlankNcError {
    /// No machine was given, or none can follow the path.
    #[error("no machine has this path: choose a machine that can follow it")]
    NoMachine,
    /// The post.
    #[error(transparent)]
    Post(#[from] PostError),
    /// The words of the program.
    #[error(transparent)]
    Nc(#[from] NcError),
}

impl FlankNc {
    /// Whether `post` has every word that programs for `machine` need.
    ///
    /// # Errors
    /// [`NcError`] that names what it lacks.
    pub fn check_words(machine: &Kinematics, post: &Post, settings: &FlankNcSettings) -> Result<(), NcError> {
        Words::new(machine, post, settings).map(|_| ())
    }

    /// Writes the program called `name` of the path that is milled, on the machine and in the words of the post that it
    /// was checked with.
    ///
    /// # Errors
    /// [`FlankNcError`] when no machine has the path, the post cannot be read or lacks an axis or a word, or a line
    /// gets longer than the control takes.
    pub fn new(approved: &ApprovedFlank, name: &str) -> Result<Self, FlankNcError> {
        let result = approved.result();
        let milled = result.milled().ok_or(FlankNcError::NoMachine)?;
        let post = milling_post(&result.milling.post)?;
        let (notes, warnings) = (approved.notes(), approved.warnings());
        let job = FlankNcJob {
            program: name,
            cutter: &result.plan.cutter.words(),
            machine: &milled.machine,
            path: approved.path(),
            line: &milled.line,
            params: &milled.params,
            contact: Some(milled.contact),
            notes: &notes,
            warnings: &warnings,
        };
        Ok(Self::of(&job, &post, &result.milling.program)?)
    }

    /// Writes the program of any path, approved or not: for [`FlankNc::new`] and its tests.
    ///
    /// # Errors
    /// [`NcError`] when the post lacks an axis or the word for what is asked, a setting is out of range, or a line gets
    /// longer than the control takes.
    fn of(job: &FlankNcJob, post: &Post, settings: &FlankNcSettings) -> Result<Self, NcError> {
        settings.validate()?;
        if settings.tip_control.interpolation() != job.params.interpolation {
            let range = "the one whose moves were measured: make the positions with the same interpolation";
            return Err(NcError::Setting { name: "tip_control", value: f64::from(settings.tip_control as u8), range });
        }
        let words = Words::new(job.machine, post, settings)?;
        let paces = paces(job.machine, job.path, job.line, &settings.feeds(job.params, post, job.contact));
        let all = Slowed::of(&paces);
        let (slowed, stretched) = (all.and_then(|s| s.by_axis), all.and_then(|s| s.short));
        let minutes = paces.iter().map(|p| p.minutes).sum();
        let mut lines = Lines::new(post, job.program, 0.0);
        post.program_start.iter().for_each(|line| lines.raw(line));
        header(&mut lines, job, settings);
        speed_comments(&mut lines, post, settings, slowed, stretched);
        motion(&mut lines, job, &words, &paces)?;
        post.program_end.iter().for_each(|line| lines.raw(line));
        Ok(Self { text: lines.finish()?, extension: post.extension.clone(), minutes, slowed, stretched })
    }
}

/// The comments that make the program understandable without any other file.
fn header(w: &mut Lines, job: &FlankNcJob, settings: &FlankNcSettings) {
    let (k, machine) = (job.machine, job.machine.machine());
    let kind = match k.kind() {
        MachineKind::HeadHead => "head-head",
        MachineKind::HeadTable => "head-table",
        MachineKind::TableTable => "table-table",
    };
    w.comment(&format!("Sparkpath {}: flank path {}", env!("CARGO_PKG_VERSION"), job.program));
    w.comment(&format!("Machine {}: {kind}, {} {}", machine.name, k.letter(0), k.letter(1)));
    w.comment(&format!("Cutter: {}, spindle {} 1/min", job.cutter, settings.spindle_rpm));
    w.comment(&format!(
        "Tool length {} mm from the spindle nose to the tip: THE PROGRAM HOLDS FOR THIS LENGTH AND THIS CLAMPING ONLY.",
        machine.gauge_length_mm
    ));
    let place = &machine.workpiece;
    let (zero, x, z) = (place.zero_mm, place.x_axis, place.z_axis);
    w.comment(&format!("Workpiece zero at {zero} mm of the machine, its x along {x}, its z along {z}"));
    w.comment(match settings.tip_control {
        TipControl::Off => {
            "X Y Z are positions of the axes: zero with the tip at the workpiece zero and both rotary axes at zero. No \
             tool length offset and no tool tip control may be active."
        }
        TipControl::Angles => {
            "X Y Z are the tip from the workpiece zero, along the machine's axes as they stand with both rotary axes \
             at zero; they turn with the table. Tool tip control is on."
        }
        TipControl::Vector => {
            "X Y Z are the tip from the workpiece zero and I J K the direction to the spindle, along the machine's \
             axes as they stand with both rotary axes at zero. The control chooses the rotary axes, so that the moves \
             between were measured for the ones that Sparkpath would choose."
        }
    });
    let (asked, bound) = (job.params.linearisation_mm, job.line.deviation_mm);
    w.comment(&format!(
        "Between the points the tool leaves the path by {:.5} mm at most, from the tip to {} mm above, asked for: \
         {asked} mm",
        (bound * 1e5).ceil() / 1e5,
        job.params.reach_mm
    ));
    job.notes.iter().for_each(|note| w.comment(note));
    job.warnings.iter().for_each(|warning| w.comment(&format!("WARNING: {warning}")));
    job.line.singular.iter().for_each(|passage| w.comment(&format!("SINGULAR: {passage}")));
}

fn speed_comments(
    w: &mut Lines,
    post: &Post,
    settings: &FlankNcSettings,
    slowed: Option<(usize, f64, char)>,
    stretched: Option<(usize, f64)>,
) {
    let FlankNcSettings { feed_mm_per_min: feed, lead_mm_per_min: lead, .. } = settings;
    w.comment(&format!(
        "Feed {feed} mm/min along the workpiece of what is fastest there of the flutes: either end of their axis, or \
         where they touch at its height; also onto the flank and off it. Other moves {lead} mm/min"
    ));
    w.comment(match post.feed.mode {
        FeedMode::PerMinute => {
            "F is the speed along X Y Z in blocks where any of them moves, and degrees per minute in blocks where only \
             rotary axes move."
        }
        FeedMode::InverseTime => "F is 1 / minutes of the block.",
        FeedMode::Seconds => "F is the seconds of the block.",
    });
    if let Some((blocks, share)) = stretched {
        w.comment(&format!(
            "SHORT MOVES: {blocks} moves are given {} s, the shortest time of a block, which leaves them {:.1} percent \
             of their speed at least",
            60.0 * LEAST_BLOCK_MINUTES,
            100.0 * share
        ));
    }
    match slowed {
        None if stretched.is_some() => w.comment("No axis would exceed its speed."),
        None => w.comment("No axis would exceed its speed: the feed is as asked for throughout."),
        Some((blocks, share, axis)) => w.comment(&format!(
            "LOWERED FEED: {blocks} moves are slower than asked for, so that no axis exceeds its speed, at most down \
             to {:.1} percent, for axis {axis}",
            100.0 * share
        )),
    }
}

fn motion(w: &mut Lines, job: &FlankNcJob, words: &Words, paces: &[Pace]) -> Result<(), NcError> {
    let (post, settings) = (words.post, words.settings);
    w.block(&post.modes);
    w.block(&post.exact_path);
    w.comment("The way to the first position is NOT verified: have the tool clear of the workpiece.");
    post.safe_start.iter().for_each(|line| w.block(line));
    w.block(&format!("S{:.0} M03", settings.spindle_rpm));
    if let Some([on, _]) = words.tip {
        w.block(&format!("{on} H{}", settings.tool_number));
    }
    w.block(&post.feed.approach_word);
    let Some(first) = job.line.points.first() else { return Ok(()) };
    let mut given = words.axes(first);
    w.block(&format!("{} {given} F{}", post.linear, words.first_feed(job.machine)?));
    if post.feed.word != post.feed.approach_word {
        w.block(&post.feed.word);
    }
    let (mut section, mut feed_given) = (None, String::new());
    for (i, (pace, pair)) in paces.iter().zip(job.line.points.windows(2)).enumerate() {
        if section != Some(pace.section) {
            section = Some(pace.section);
            w.comment(match pace.section {
                Section::Approach => "Section APPROACH",
                Section::Cut => "Section CUT",
                Section::Retract => "Section RETRACT",
            });
        }
        let axes = words.axes(&pair[1]);
        // A block that moves nothing has no feed.
        if axes == given {
            continue;
        }
        let feed = words.feed(pace, &pair[0], &pair[1]).ok_or(words.too_slow(i + 1))?;
        let is_kept = post.feed.mode == FeedMode::PerMinute && feed == feed_given;
        w.block(&if is_kept { format!("{} {axes}", post.linear) } else { format!("{} {axes} F{feed}", post.linear) });
        (given, feed_given) = (axes, feed);
    }
    if let Some([_, off]) = words.tip {
        w.block(off);
    }
    if post.feed.word != post.feed.approach_word {
        w.block(&post.feed.approach_word);
    }
    w.block("M05");
    post.safe_end.iter().for_each(|line| w.block(line));
    Ok(())
}

/// The words that switch following the tool's tip on and off; none where it is not asked for.
fn tip_words(post: &Post, asked: TipControl) -> Result<Option<[&str; 2]>, NcError> {
    let words = post.tip_control.as_ref();
    let (word, wanted) = match asked {
        TipControl::Off => return Ok(None),
        TipControl::Angles => (words.and_then(|w| w.angles.as_deref()), "angles"),
        TipControl::Vector => (words.and_then(|w| w.vector.as_deref()), "vector"),
    };
    let both = word.zip(words).map(|(on, words)| [on, words.off.as_str()]);
    both.map(Some).ok_or(NcError::NoTipControl { wanted })
}

struct Words<'a> {
    post: &'a Post,
    settings: &'a FlankNcSettings,
    machine: &'a Kinematics,
    linear: [(&'a str, f64); 3],
    rotary: [(&'a str, f64); 2],
    /// Words that switch tool centre point control on and off.
    tip: Option<[&'a str; 2]>,
}

impl<'a> Words<'a> {
    fn new(k: &'a Kinematics, post: &'a Post, settings: &'a FlankNcSettings) -> Result<Self, NcError> {
        let word = |axis: Axis| {
            let found = post.axes.iter().find(|a| a.axis == axis);
            let found = found.ok_or(NcError::AxisNotInPost { axis: axis.letter() })?;
            Ok::<_, NcError>((found.word.as_str(), if found.reversed { -1.0 } else { 1.0 }))
        };
        let rotary = |i: usize| match k.letter(i) {
            'A' => word(Axis::A),
            'B' => word(Axis::B),
            _ => word(Axis::C),
        };
        let linear = [word(Axis::X)?, word(Axis::Y)?, word(Axis::Z)?];
        let tip = tip_words(post, settings.tip_control)?;
        Ok(Self { post, settings, machine: k, linear, rotary: [rotary(0)?, rotary(1)?], tip })
    }

    fn too_slow(&self, block: usize) -> NcError {
        NcError::FeedTooSlow { block, decimals: self.post.feed.decimals }
    }

    fn xyz(&self, point: &MachinePoint) -> [f64; 3] {
        match self.settings.tip_control {
            TipControl::Off => point.joints.linear,
            _ => self.machine.in_machine(point.tip),
        }
        .to_array()
    }

    fn axes(&self, point: &MachinePoint) -> String {
        let decimals = self.post.decimals;
        // `+ 0.0` keeps a reversed zero without a sign.
        let length = |(word, sign): (&str, f64), v: f64| format!("{word}{}", mm_text(sign * v + 0.0, decimals.mm));
        let angle = |(word, sign): (&str, f64), v: f64| format!("{word}{}", deg_text(sign * v + 0.0, decimals.deg));
        let xyz = self.linear.into_iter().zip(self.xyz(point)).map(|(word, v)| length(word, v));
        let turned: Vec<String> = match self.settings.tip_control {
            TipControl::Vector => {
                // The direction is counted along the same axes as the tip.
                let signs = self.linear.map(|(_, sign)| sign);
                let axis = self.machine.in_machine(point.axis).to_array();
                let direction = ["I", "J", "K"].into_iter().zip(axis.into_iter().zip(signs));
                direction.map(|(word, (v, sign))| format!("{word}{:.DIRECTION_DECIMALS$}", sign * v + 0.0)).collect()
            }
            _ => self.rotary.into_iter().zip(point.joints.rotary).map(|(word, v)| angle(word, v)).collect(),
        };
        xyz.chain(turned).collect::<Vec<_>>().join(" ")
    }

    /// The F word of a move; none when its decimals cannot say anything so slow.
    fn feed(&self, pace: &Pace, from: &MachinePoint, to: &MachinePoint) -> Option<String> {
        let decimals = self.post.feed.decimals;
        let minutes = pace.minutes;
        let f = match self.post.feed.mode {
            FeedMode::PerMinute => {
                let by = |i: usize| self.xyz(to)[i] - self.xyz(from)[i];
                let linear = by(0).hypot(by(1)).hypot(by(2));
                let turn = |i: usize| to.joints.rotary[i] - from.joints.rotary[i];
                let length = if linear > 0.0 { linear } else { turn(0).hypot(turn(1)).to_degrees() };
                slow_down(length / minutes, decimals)
            }
            FeedMode::InverseTime => slow_down(1.0 / minutes, decimals),
            FeedMode::Seconds => Some(whole_seconds(minutes, decimals)),
        };
        f.map(|f| format!("{f:.decimals$}"))
    }

    /// F of the move to the first position (feed per minute), whose start is not known: no faster than any axis may go.
    fn first_feed(&self, k: &Kinematics) -> Result<String, NcError> {
        let machine = k.machine();
        let speeds = machine.linear.speed_mm_min.into_iter().chain(machine.rotary.iter().map(|r| r.speed_deg_min));
        let slowest = speeds.fold(self.settings.lead_mm_per_min, f64::min);
        let decimals = self.post.feed.decimals;
        slow_down(slowest, decimals).map(|f| format!("{f:.decimals$}")).ok_or(self.too_slow(0))
    }
}

#[cfg(test)]
mod tests;
