//! NC programs: an approved path in the words of a control.
//!
//! The program feeds along the path to the final pose, stops there for the burn, copies along the walls where there is
//! a certified motion for that, and retracts along the same path. Every coordinate is the number of the path file,
//! digit for digit. What is not verified, and so stands in the program's own comments: the way to the first position,
//! and anything that a generator's servo adds.

mod tour;

use std::io::Read as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::approved::Approved;
use crate::block_feed::{BlockFeed, Pace, Slowed, fastest_point_travel, programmed_length};
use crate::lines::{Lines, NcError};
use crate::post::{FeedMode, Post};
use feed::chain::Chain;
use feed::machine::MachineParams;
use feed::path::{FeedPath, PathRow};
use feed::pose::{Axis, Pose};
use feed::quantise::{MM_DECIMALS, deg_text, floor_mm_text, mm_text};
use tour::TourFeeds;
use wheel::electrode::EntrySide;

/// Digits of a digest that a program shows; `report.json` has them all.
const DIGEST_DIGITS: usize = 16;

/// How much of a file is looked at to see what it is (bytes).
const HEAD_BYTES: u64 = 64 << 10;

/// Whether a file begins as our programs for `what` do, as in `feed path path_`.
pub fn is_program_for(file: &Path, what: &str) -> bool {
    let mut head = Vec::new();
    // Pipes and devices may never answer.
    let is_read = file.is_file()
        && std::fs::File::open(file).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head)).is_ok();
    // Some controls have capitals alone.
    let (text, what) = (String::from_utf8_lossy(&head).to_ascii_lowercase(), what.to_ascii_lowercase());
    is_read && text.lines().any(|line| line.contains("sparkpath ") && line.contains(&format!(": {what}")))
}

/// Speeds and times of a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NcSettings {
    /// Feed towards the final pose (mm/min). While eroding, the generator's servo sets the pace; this is its limit.
    pub feed_mm_per_min: f64,
    /// Feed of the approach and of the retraction (mm/min).
    pub retract_mm_per_min: f64,
    /// Dwell in the final pose after the stop for the burn (s); 0 for none.
    pub burn_dwell_s: f64,
}

impl Default for NcSettings {
    fn default() -> Self {
        Self { feed_mm_per_min: 5.0, retract_mm_per_min: 50.0, burn_dwell_s: 0.0 }
    }
}

impl NcSettings {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`NcError::Setting`] naming the setting.
    pub fn validate(&self) -> Result<(), NcError> {
        let speeds = [("feed_mm_per_min", self.feed_mm_per_min), ("retract_mm_per_min", self.retract_mm_per_min)];
        if let Some((name, value)) = speeds.into_iter().find(|(_, v)| !(0.001..=100_000.0).contains(v)) {
            return Err(NcError::Setting { name, value, range: "0.001 to 100000 mm/min" });
        }
        if !(0.0..=1e6).contains(&self.burn_dwell_s) {
            return Err(NcError::Setting { name: "burn_dwell_s", value: self.burn_dwell_s, range: "0 to 1000000 s" });
        }
        Ok(())
    }
}

/// Input of a program.
#[derive(Debug, Clone, PartialEq)]
pub struct NcJob<'a> {
    /// Name of the program, e.g. `path_1`.
    pub program: &'a str,
    /// File of the electrode that it moves.
    pub electrode_file: &'a str,
    /// The machine, its travels in its own directions.
    pub machine: &'a MachineParams,
    /// Sentences on the path for the head of the program.
    pub notes: &'a [String],
}

/// A job as the side of entry of an approved path has it.
struct TurnedJob<'a> {
    program: &'a str,
    electrode_file: &'a str,
    notes: &'a [String],
    /// The machine, its travels in the directions of W.
    machine: MachineParams,
    /// Whether the directions of the machine are turned by half a turn about Z against W.
    is_turned: bool,
    /// What makes axis values of the machine from poses: that of the simulation.
    chain: Chain,
}

impl<'a> TurnedJob<'a> {
    fn new(job: &NcJob<'a>, approved: &Approved) -> Self {
        let NcJob { program, electrode_file, machine, notes } = *job;
        let side = approved.enters_from();
        let plain = || Chain::new(approved.path().reference_point, None);
        let chain = approved.simulation().map_or_else(plain, |simulation| *simulation.chain());
        let (machine, is_turned) = (machine.seen_from_w(side), machine.is_turned(side));
        Self { program, electrode_file, notes, machine, is_turned, chain }
    }
}

/// An NC program.
#[derive(Debug, Clone, PartialEq)]
pub struct NcProgram {
    text: String,
    extension: String,
    slowed: Option<Slowed>,
}

impl NcProgram {
    /// Writes the program of `approved` in the words of `post`.
    ///
    /// # Errors
    /// [`NcError`] when the machine or the post lacks a moving axis, the path leaves the machine's travel, a setting is
    /// out of range, or a line gets longer than the control takes.
    pub fn new(approved: &Approved, post: &Post, settings: &NcSettings, job: &NcJob) -> Result<Self, NcError> {
        settings.validate()?;
        let job = &TurnedJob::new(job, approved);
        check_axes(&job.chain, &approved.path().rows, post, &job.machine)?;
        check_axes(&job.chain, copying_rows(approved), post, &job.machine)?;
        tour::check(approved, post, job)?;
        let feeds = Feeds::new(approved, post, settings, job)?;
        let in_channel = feeds.inwards.iter().chain(&feeds.copying).chain(&feeds.outwards);
        let slowed = Slowed::of(in_channel.chain(feeds.tour.all()));
        let mut w = Writer::new(post, job, settings);
        post.program_start.iter().for_each(|line| w.raw(line));
        header(&mut w, approved);
        speed_comments(&mut w, slowed);
        motion(&mut w, approved, &feeds);
        post.program_end.iter().for_each(|line| w.raw(line));
        Ok(Self { text: w.finish()?, extension: post.extension.clone(), slowed })
    }

    /// Blocks slowed so that no axis exceeds its speed; none if there are none.
    pub fn slowed(&self) -> Option<&Slowed> {
        self.slowed.as_ref()
    }

    /// The program, line ends included.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// File name extension that the control expects, without the dot.
    pub fn extension(&self) -> &str {
        &self.extension
    }
}

/// The F words of a program.
struct Feeds {
    approach: String,
    inwards: Vec<BlockFeed>,
    copying: Vec<BlockFeed>,
    outwards: Vec<BlockFeed>,
    tour: TourFeeds,
}

impl Feeds {
    fn new(approved: &Approved, post: &Post, settings: &NcSettings, job: &TurnedJob) -> Result<Self, NcError> {
        let (mode, decimals) = (post.feed.mode, post.feed.decimals);
        let path = approved.path();
        let (reference_point, electrode) = (path.reference_point, approved.electrode_bounds());
        let (machine, chain) = (&job.machine, &job.chain);
        let pace = Pace { mode, decimals, machine, reference_point, electrode, chain };
        let too_slow = |block| NcError::FeedTooSlow { block, decimals };
        let (rows, copying) = (chain.refined(&path.rows), chain.refined(copying_rows(approved)));
        let back: Vec<PathRow> = rows.iter().rev().copied().collect();
        Ok(Self {
            approach: pace.approach(settings.retract_mm_per_min).ok_or(too_slow(0))?,
            inwards: pace.blocks(&rows, settings.feed_mm_per_min).map_err(too_slow)?,
            copying: pace.blocks(&copying, settings.feed_mm_per_min).map_err(too_slow)?,
            outwards: pace.blocks(&back, settings.retract_mm_per_min).map_err(too_slow)?,
            tour: TourFeeds::new(approved, &pace, settings.retract_mm_per_min).map_err(too_slow)?,
        })
    }
}

fn check_axes(chain: &Chain, rows: &[PathRow], post: &Post, machine: &MachineParams) -> Result<(), NcError> {
    let rows: Vec<PathRow> = rows.iter().map(|row| PathRow { pose: chain.machine_pose(&row.pose), ..*row }).collect();
    for axis in Axis::ALL {
        if let Some(row) = rows.iter().position(|r| r.pose.get(axis) != 0.0) {
            if !machine.axes.axes().contains(&axis) {
                return Err(NcError::AxisNotOnMachine { axis: axis.letter(), row });
            }
            if !post.axes.iter().any(|a| a.axis == axis) {
                return Err(NcError::AxisNotInPost { axis: axis.letter() });
            }
        }
    }
    machine.limits().first_beyond(&rows).map_or(Ok(()), |beyond| Err(NcError::BeyondTravel(beyond)))
}

/// The rows of the copying motion; none if there is none.
fn copying_rows(approved: &Approved) -> &[PathRow] {
    approved.copying().map_or(&[], |copying| &copying.path.rows)
}

/// Comments on the feed as limited by the machine's speeds.
fn speed_comments(w: &mut Writer, slowed: Option<Slowed>) {
    let MachineParams { speed_mm_min, speed_deg_min, .. } = &w.job.machine;
    w.comment(&format!("Greatest speeds of the machine: X Y Z {speed_mm_min} mm/min, A B C {speed_deg_min} deg/min"));
    match slowed {
        None => w.comment("No axis would exceed them: the feed is as asked for throughout."),
        Some(Slowed { blocks, of, least_share, axis }) => w.comment(&format!(
            "LOWERED FEED: {blocks} of {of} blocks are slower than asked for, so that no axis exceeds them, at most \
             down to {:.1} percent, for axis {}",
            100.0 * least_share,
            axis.letter()
        )),
    }
}

/// The comments that make the program understandable without any other file.
fn header(w: &mut Writer, approved: &Approved) {
    let (path, c) = (approved.path(), approved.certificate());
    let mm = |v| mm_text(v, MM_DECIMALS);
    let vector = |v: glam::DVec3| format!("{} {} {}", v.x, v.y, v.z);
    w.comment(&format!("Sparkpath {}: feed path {}", env!("CARGO_PKG_VERSION"), w.job.program));
    w.comment(&format!("Electrode file: {}", w.job.electrode_file));
    w.comment(&format!("Required clearance {} mm, tolerance {} mm", mm(c.required()), mm(c.tolerance())));
    w.comment(&format!("Certified clearance over the whole motion: {} mm or more", floor_mm_text(c.certified())));
    let least = (floor_mm_text(c.least().distance), mm(c.least().s));
    w.comment(&format!("Least clearance found: {} mm, {} mm before the final pose", least.0, least.1));
    if let Some(copying) = approved.copying() {
        let certified = floor_mm_text(copying.certificate.certified());
        w.comment(&format!("Certified clearance over the copying motion: {certified} mm or more"));
    }
    w.comment(&format!(
        "Jumps: up to {} mm back along the feed path the motion is verified, and nowhere off it",
        floor_mm_text(longest_jump(path))
    ));
    w.job.notes.iter().for_each(|note| w.comment(note));
    w.comment(&format!(
        "Path: {} rows. First {DIGEST_DIGITS} digits of the SHA-256 of what was verified:",
        path.rows.len()
    ));
    for (name, digest) in [("path", c.path_digest()), ("blisk", c.blisk_digest()), ("electrode", c.electrode_digest())]
    {
        w.comment(&format!("{name} {}", &digest[..DIGEST_DIGITS.min(digest.len())]));
    }
    w.comment("Work zero: ALL AXES ARE ZERO IN THE FINAL POSE. Set the zero with the electrode there.");
    w.comment("Workpiece frame W in the coordinates of the loaded mesh, mm:");
    w.comment(&format!("origin {}", vector(path.frame.origin)));
    for (name, axis) in [("x", path.frame.x), ("y", path.frame.y), ("z", path.frame.z)] {
        w.comment(&format!("{name} axis {}", vector(axis)));
    }
    w.comment(&format!("Electrode reference point O in W: {}", vector(path.reference_point)));
    match w.job.chain.on_table_c() {
        None => w.comment(
            "A point p of the electrode goes to Rx[A] * [ O + [X Y Z] + Rz[C] * Ry[B] * [p - O] ]: values are of the \
             electrode relative to the workpiece, right-handed. A table that carries the workpiece turns the other way.",
        ),
        Some(q) => {
            let turned = w.job.chain.turn().to_degrees();
            let slides = if turned == 0.0 { "[X Y Z]".to_owned() } else { format!("Rz[{:.6}] * [X Y Z]", -turned) };
            w.comment(&format!(
                "C TURNS THE TABLE THAT CARRIES A, about a line along Z of W through Q, where Q in W is {}. A point p of the \
                 electrode goes to Rx[A] * [ Q + Rz[C] * [ O + {slides} + Ry[B] * [p - O] - Q ] ]: values are of the electrode \
                 relative to the workpiece, right-handed. The tables turn the other way. Between two blocks all axes are \
                 linear; the electrode then stays within {} mm of the verified motion, which is taken off its clearance.",
                vector(q),
                mm(w.job.chain.deviation())
            ));
        }
    }
    let reversed = w.post.axes.iter().filter(|a| a.reversed).map(|a| a.axis.letter().to_string());
    let reversed: Vec<String> = reversed.collect();
    if !reversed.is_empty() {
        w.comment(&format!("This post counts the other way round: {}", reversed.join(" ")));
    }
    let other_words = w.post.axes.iter().filter(|a| a.word != a.axis.letter().to_string());
    let other_words: Vec<String> = other_words.map(|a| format!("{} is {}", a.axis.letter(), a.word)).collect();
    if !other_words.is_empty() {
        w.comment(&format!("Words of this post for the axes above: {}", other_words.join(", ")));
    }
    let is_from_bore = approved.enters_from() == EntrySide::Inward;
    let is_along_z = is_from_bore || approved.enters_from() == EntrySide::Outward;
    if w.job.is_turned {
        let mounted = match is_along_z {
            true => "the blisk is mounted on its face at the greatest x of W, which is that towards -X of the machine",
            false => {
                "the electrode enters from -X of W, and the blisk is mounted with that side towards +X of the machine"
            }
        };
        w.comment(&format!(
            "THE MACHINE IS TURNED BY HALF A TURN ABOUT Z AGAINST W: {mounted}. X Y A B of this program are those of the \
             machine, opposite to those of W."
        ));
    }
    if is_along_z {
        let simulated = match w.job.machine.has_bodies() {
            true => "",
            false => " No head and no table were simulated.",
        };
        w.comment(&match is_from_bore {
            true => format!(
                "THE ELECTRODE ENTERS FROM THE BORE: it is fed and retracted along Z of W, and must stand within the bore \
                 before this program and after it.{simulated}"
            ),
            false => format!("THE ELECTRODE ENTERS FROM THE RIM: it is fed and retracted along Z of W.{simulated}"),
        });
    }
    tour::header(w, approved);
    feed_comments(w, approved);
}

fn feed_comments(w: &mut Writer, approved: &Approved) {
    let (feed, back) = (w.settings.feed_mm_per_min, w.settings.retract_mm_per_min);
    w.comment(&format!("Feed {feed} mm/min, approach and retraction {back} mm/min, where no axis is too fast"));
    match w.post.feed.mode {
        FeedMode::PerMinute => {
            let (path, chain) = (approved.path(), w.job.chain);
            let [feed_rows, copying] = [&path.rows[..], copying_rows(approved)].map(|rows| chain.refined(rows));
            let inside = feed_rows.windows(2).chain(copying.windows(2));
            let inside = inside.map(|pair| [pair[0].pose, pair[1].pose]);
            let simulated = approved.simulation().map(|s| s.legs(path, approved.copying().map(|c| &c.path)));
            let outside =
                simulated.iter().flatten().flat_map(|leg| leg.poses.windows(2)).map(|pair| [pair[0], pair[1]]);
            let ratios = inside.chain(outside).map(|[from, to]| {
                let (from, to) = (&from, &to);
                let length = programmed_length(&chain.machine_pose(from), &chain.machine_pose(to));
                let travel = fastest_point_travel(from, to, path.reference_point, approved.electrode_bounds());
                if length > 0.0 { travel / length } else { 0.0 }
            });
            let fastest = ratios.fold(0.0, f64::max);
            w.comment(
                "F is the speed along X Y Z in blocks where any of them moves, and degrees per minute in blocks \
                 where only rotary axes move.",
            );
            let speeds =
                format!("{:.1} mm/min at this feed and {:.1} mm/min retracting", feed * fastest, back * fastest);
            w.comment(&format!("Taken so, the fastest electrode point moves at up to {speeds}."));
        }
        FeedMode::InverseTime => {
            w.comment("F is 1 / minutes of the block, from the way of the fastest electrode point.")
        }
        FeedMode::Seconds => w.comment("F is the seconds of the block, from the way of the fastest electrode point."),
    }
}

/// Longest jump back along a feed path, whose motion is verified both ways: to its first row (mm along the direction of
/// withdrawal).
pub fn longest_jump(path: &FeedPath) -> f64 {
    path.rows.first().map_or(0.0, |row| row.s)
}

/// Approach, feed, burn, retraction, in every channel that was simulated.
fn motion(w: &mut Writer, approved: &Approved, feeds: &Feeds) {
    let post = w.post;
    w.block(&post.modes);
    w.block(&post.exact_path);
    w.comment(
        "The way to the first position is NOT verified: have the electrode clear of the blisk, on its entry side.",
    );
    post.safe_start.iter().for_each(|line| w.block(line));
    w.block(&post.feed.approach_word);
    match approved.simulation() {
        Some(simulation) => tour::motion(w, approved, simulation, feeds),
        None => {
            if let Some(first) = approved.path().rows.first() {
                first_position(w, &first.pose, feeds);
            }
            in_channel(w, approved, feeds);
        }
    }
    w.comment("Verified motion ends: electrode outside");
    post.safe_end.iter().for_each(|line| w.block(line));
}

/// The move to the first position, and the word for the feed after it.
fn first_position(w: &mut Writer, first: &Pose, feeds: &Feeds) {
    w.block(&format!("{} {} F{}", w.post.linear, w.axis_words(first), feeds.approach));
    if w.post.feed.word != w.post.feed.approach_word {
        w.block(&w.post.feed.word);
    }
}

/// Feed, burn, copying motion and retraction, from the first row back to it.
fn in_channel(w: &mut Writer, approved: &Approved, feeds: &Feeds) {
    let (post, rows) = (w.post, w.job.chain.refined(&approved.path().rows));
    let jump = floor_mm_text(longest_jump(approved.path()));
    post.jump.iter().for_each(|line| w.block(&line.replace("{jump_mm}", &jump)));
    w.comment("Verified motion begins: feed to the final pose");
    w.moves(rows.iter().skip(1), &feeds.inwards);
    w.comment(if approved.copying().is_some() {
        "Final pose. Put the burn here: generator and flushing are not part of this program."
    } else {
        "Final pose. Put the burn here: generator, flushing and finishing motions are not part of this program."
    });
    post.burn.iter().for_each(|line| w.block(line));
    if w.settings.burn_dwell_s > 0.0 {
        w.block(&post.dwell);
    }
    if let Some(copying) = approved.copying() {
        w.comment("Section COPYING begins: verified motion from the final pose along the walls and back to it");
        w.moves(w.job.chain.refined(&copying.path.rows).iter().skip(1), &feeds.copying);
        w.comment("Section COPYING ends: final pose");
    }
    w.comment("Retraction along the same verified path");
    w.moves(rows.iter().rev().skip(1), &feeds.outwards);
}

struct Writer<'a> {
    post: &'a Post,
    job: &'a TurnedJob<'a>,
    settings: &'a NcSettings,
    lines: Lines<'a>,
    /// Angle added to A: the turn to the channel (rad).
    turn: f64,
}

impl<'a> Writer<'a> {
    fn new(post: &'a Post, job: &'a TurnedJob<'a>, settings: &'a NcSettings) -> Self {
        Self { post, job, settings, lines: Lines::new(post, job.program, settings.burn_dwell_s), turn: 0.0 }
    }

    fn raw(&mut self, line: &str) {
        self.lines.raw(line);
    }

    fn block(&mut self, words: &str) {
        self.lines.block(words);
    }

    fn comment(&mut self, text: &str) {
        self.lines.comment(text);
    }

    /// Linear motion through `rows`, in the pace of `feeds`. A feed per minute stays until another is given.
    fn moves<'r>(&mut self, rows: impl Iterator<Item = &'r PathRow>, feeds: &[BlockFeed]) {
        let mut given = "";
        for (row, feed) in rows.zip(feeds) {
            let words = format!("{} {}", self.post.linear, self.axis_words(&row.pose));
            if self.post.feed.mode == FeedMode::PerMinute && given == feed.text {
                self.block(&words);
            } else {
                self.block(&format!("{words} F{}", feed.text));
            }
            given = &feed.text;
        }
    }

    /// Whether the words of `axis` count the other way round than in W.
    fn counts_backwards(&self, axis: Axis) -> bool {
        let is_turned = self.job.is_turned && MachineParams::TURNED.contains(&axis);
        self.post.axes.iter().any(|a| a.axis == axis && a.reversed) != is_turned
    }

    /// The words of every axis that the machine has.
    fn axis_words(&self, pose: &Pose) -> String {
        let pose = &self.job.chain.machine_pose(pose);
        let of_machine = self.post.axes.iter().filter(|a| self.job.machine.axes.axes().contains(&a.axis));
        let word = of_machine.map(|a| {
            // `+ 0.0` keeps a reversed zero without a sign.
            let value = pose.get(a.axis) + if a.axis == Axis::A { self.turn } else { 0.0 };
            let value = if self.counts_backwards(a.axis) { -value } else { value } + 0.0;
            let decimals = self.post.decimals;
            let text = if a.axis.is_rotary() { deg_text(value, decimals.deg) } else { mm_text(value, decimals.mm) };
            format!("{}{text}", a.word)
        });
        word.collect::<Vec<_>>().join(" ")
    }

    fn finish(self) -> Result<String, NcError> {
        self.lines.finish()
    }
}

#[cfg(test)]
mod tests;
