//! The burn table: what is burned with which electrode, where, how deep, and what was checked, as CSV and JSON.
//!
//! Positions are in the axes of the work datum, whose Z is the opening direction; `to_file` takes them to the axes of the
//! mold's file. Text of any other form is made from the same table by [`template`](super::template).

use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;

use files::Override;
use mold::datum::Datum;
use mold::electrode::base::round_blank;
use mold::electrode::design::Family;
use mold::electrode::design::{Burn, Electrode, ElectrodeSet};
use mold::electrode::finding::CheckKind;
use mold::electrode::params::{Method, Orbit, Shape};
use mold::electrode::setting::to_burn_frame;
use mold::opening::Opening;

/// Version of the keys of `burn_table.json`, which templates use too.
pub const SCHEMA: u32 = 4;
/// Positions and angles are rounded to as many decimals.
const DECIMALS: i32 = 4;

/// A motion: three rows of a rotation with the shift in the fourth column (mm), and a row that is always 0 0 0 1.
pub type Pose = [[f64; 4]; 4];

/// All electrodes of a mold with their burns. Regions and their parts count from 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurnTable {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// Name of the mold.
    pub mold: String,
    /// The direction in which the mold's opening looks in the axes of its file; along +Z in this table.
    pub opening: String,
    /// The work datum, to which all positions refer.
    pub datum: DatumEntry,
    /// From the axes of this table to those of the mold's file.
    pub to_file: Pose,
    /// Shape that electrode files hold.
    pub shape: Shape,
    /// Material of the electrodes.
    pub material: String,
    /// Retract distance (mm).
    pub lift_mm: f64,
    /// Minutes that all burns take, with set-up and changing; none if they are not known.
    pub minutes: Option<f64>,
    /// Number of burns.
    pub burns: usize,
    /// The electrodes; those for the first stage first.
    pub electrodes: Vec<ElectrodeEntry>,
    /// Regions that are not burned, or not wholly.
    pub not_burned: Vec<NotBurned>,
    /// Notes on the mold, in words.
    pub notes: Vec<String>,
}

/// The work datum, in the axes of the mold's file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DatumEntry {
    /// Name: how it was found.
    pub name: String,
    /// Origin (mm).
    pub origin_mm: [f64; 3],
    /// Unit vector of its X axis; its Z axis is the opening direction.
    pub x_axis: [f64; 3],
    /// Angle of its X axis from that of the upright mold, counter-clockwise seen from where cutters come (degrees).
    pub angle_deg: f64,
}

/// A region that is not burned, or not wholly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotBurned {
    /// The region, counted from 1.
    pub region: usize,
    /// Reason, in words.
    pub why: String,
}

/// An electrode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElectrodeEntry {
    /// Name.
    pub name: String,
    /// State of the electrode.
    pub state: ElectrodeState,
    /// Burn: rough, finish.
    pub stage: String,
    /// Material of the electrode.
    pub material: String,
    /// Shape in the electrode's file.
    pub shape: Shape,
    /// Spark gap (mm).
    pub gap_mm: f64,
    /// The orbit.
    pub orbit: OrbitEntry,
    /// Undersize across an upright wall along X or Y (mm): gap and orbit.
    pub undersize_wall_mm: f64,
    /// Undersize across a level floor (mm).
    pub undersize_floor_mm: f64,
    /// Number of pieces.
    pub quantity: u32,
    /// Surface finish to be reached (VDI 3400).
    pub finish_vdi: f64,
    /// Surface finish as roughness (Ra, micrometres).
    pub roughness_um: f64,
    /// Method of making its tips.
    pub method: Method,
    /// The blank that it is milled from.
    pub blank: BlankEntry,
    /// The holder that takes the blank; none if none is large enough.
    pub holder: Option<HolderEntry>,
    /// The body that it shares with electrodes of other stages; none if it has its own.
    pub family: Option<FamilyEntry>,
    /// Unit vector along which it is lifted.
    pub lift: [f64; 3],
    /// Area of its tips seen along the burn (mm^2).
    pub front_area_mm2: f64,
    /// Area of its tips that burns, walls and floors, at one burn (mm^2).
    pub burn_area_mm2: f64,
    /// Height of its base (mm).
    pub base_height_mm: f64,
    /// Volume that all its burns take away (mm^3).
    pub volume_mm3: f64,
    /// Minutes that all its burns take, without set-up and changing; none if they are not known.
    pub minutes: Option<f64>,
    /// Length that its front loses in all its burns (mm); none if the wear is not considered.
    pub end_wear_mm: Option<f64>,
    /// Wear of its edges in all its burns (mm); none if it is not considered.
    pub corner_wear_mm: Option<f64>,
    /// Number of electrodes that its burns need, in words.
    pub needed: String,
    /// What minutes and wear rest on, and what is missing.
    pub rests_on: Vec<String>,
    /// Warnings before the electrode is used, in words.
    pub warnings: Vec<String>,
    /// Burns.
    pub burns: Vec<BurnEntry>,
    /// Each kind of check.
    pub checks: Vec<CheckEntry>,
}

/// State of an electrode: exported or blocked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElectrodeState {
    /// Every check holds.
    Ok,
    /// A check fails, and the user decided by name to use it nevertheless.
    Overridden,
    /// A check fails: it has no file.
    Blocked,
}

impl ElectrodeState {
    /// State of an electrode of a set with these overrides.
    pub fn of(set: &ElectrodeSet, electrode: usize, overrides: &[Override]) -> Self {
        match (set.fails(electrode), set.is_blocked_with(electrode, overrides)) {
            (false, _) => Self::Ok,
            (true, false) => Self::Overridden,
            (true, true) => Self::Blocked,
        }
    }

    /// Name of the state.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Overridden => "overridden",
            Self::Blocked => "blocked",
        }
    }
}

/// An orbit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrbitEntry {
    /// none, circular or square.
    pub pattern: &'static str,
    /// Radius or half side (mm).
    pub radius_mm: f64,
    /// Unit vectors in whose plane it goes, and along which the sides of a square lie. They do not turn with C.
    pub x_axis: [f64; 3],
    /// The other.
    pub y_axis: [f64; 3],
}

/// A blank.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlankEntry {
    /// Whether it is round, as the base in the file then is.
    pub is_round: bool,
    /// Sides along X and Y (mm); the diameter twice if it is round.
    pub sides_mm: [f64; 2],
    /// Length along Z (mm).
    pub length_mm: f64,
    /// Diameter if it is round, else that of the least round blank that would do (mm).
    pub diameter_mm: Option<f64>,
}

impl BlankEntry {
    /// Lengths with a sign between them: `10 x 12 x 25`, or `round 16 x 25`.
    pub fn text(&self, times: &str) -> String {
        let ([x, y], z) = (self.sides_mm, self.length_mm);
        if self.is_round { format!("round {x}{times}{z}") } else { format!("{x}{times}{y}{times}{z}") }
    }
}

/// A body that electrodes of several stages share, a family.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FamilyEntry {
    /// Name of the holder.
    pub name: String,
    /// The electrodes of the other stages.
    pub others: Vec<String>,
    /// Where the middle of this stage's tips is, from the middle of the base, which is the datum: X and Y in the
    /// electrode's own axes (mm).
    pub offset_mm: [f64; 2],
}

/// A holder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HolderEntry {
    /// Name.
    pub name: String,
    /// Largest blank that it holds (mm).
    pub size_mm: [f64; 2],
    /// Height (mm).
    pub height_mm: f64,
}

/// A burn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurnEntry {
    /// Counted from 1 for each electrode.
    pub number: usize,
    /// Where the electrode's origin is, the middle of the underside of its base: X (mm).
    pub x_mm: f64,
    /// Y (mm).
    pub y_mm: f64,
    /// Z (mm).
    pub z_mm: f64,
    /// C angle, counter-clockwise seen from the machine's head, along the burn (degrees, above -180 up to 180).
    pub c_deg: f64,
    /// Unit vector along which the electrode's own X axis looks: with the direction of the lift, its own Z axis, it
    /// says how the electrode stands wherever it burns from.
    pub x_axis: [f64; 3],
    /// From the axes of the electrode's file to those of this table.
    pub pose: Pose,
    /// Depth of its lowest point below the mold's top (mm).
    pub depth_mm: f64,
    /// Volume that is burned away (mm^3).
    pub volume_mm3: f64,
    /// Minutes that it takes; none if they are not known.
    pub minutes: Option<f64>,
    /// Parts of regions that it burns: `R3.2` is part 2 of region 3. Without the letter spreadsheets would read
    /// numbers.
    pub parts: Vec<String>,
    /// The regions that these belong to, rising.
    pub regions: Vec<usize>,
}

/// State of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckState {
    /// The check holds.
    Ok,
    /// The check fails, and the electrode is released despite it.
    Overridden,
    /// The check fails.
    Failed,
    /// The check could not be made, because another one fails.
    NotMade,
}

impl CheckState {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Overridden => "overridden",
            Self::Failed => "failed",
            Self::NotMade => "not-made",
        }
    }
}

/// A check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckEntry {
    /// Subject of the check.
    pub kind: CheckKind,
    /// State of the check.
    pub state: CheckState,
    /// The finding in words.
    pub text: String,
    /// Place (mm).
    pub place_mm: Option<[f64; 3]>,
}

impl BurnTable {
    /// The table for electrodes of a mold that is called `mold`, with positions from `datum`.
    pub fn of(set: &ElectrodeSet, mold: &str, opening: Opening, datum: &Datum) -> Self {
        let axes = datum.of_upright(opening);
        let electrodes: Vec<ElectrodeEntry> = (0..set.electrodes.len()).map(|e| entry(set, e, &axes)).collect();
        let [x, y, z] = datum.axes(opening);
        Self {
            schema: SCHEMA,
            program_version: env!("CARGO_PKG_VERSION"),
            mold: mold.to_owned(),
            opening: opening.name(),
            datum: DatumEntry {
                name: datum.label().to_owned(),
                origin_mm: datum.origin_mm.to_array().map(|v| v + 0.0),
                x_axis: unit(x),
                angle_deg: datum.angle_deg + 0.0,
            },
            to_file: pose(DMat3::from_cols(x, y, z), datum.origin_mm.to_array()),
            shape: set.params.shape,
            material: set.params.material.clone(),
            lift_mm: set.retract(),
            minutes: set.minutes().map(|minutes| minutes.mean),
            burns: electrodes.iter().map(|e| e.burns.len()).sum(),
            electrodes,
            not_burned: not_burned(set, &axes),
            notes: Vec::new(),
        }
    }

    /// The table as JSON; a number that is not finite becomes null.
    ///
    /// # Errors
    /// None that is known; the writer's own.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

fn not_burned(set: &ElectrodeSet, axes: &DAffine3) -> Vec<NotBurned> {
    let regions = (0..set.regions.len()).filter_map(|r| Some((r, set.why_not_burned(r, axes)?)));
    regions.map(|(r, why)| NotBurned { region: r + 1, why }).collect()
}

/// Name of a shape.
pub fn shape_name(shape: Shape) -> &'static str {
    match shape {
        Shape::Undersized => "undersized",
        Shape::Net => "net",
    }
}

/// Name of a method.
pub fn method_name(method: Method) -> &'static str {
    match method {
        Method::Extruding => "extruding",
        Method::Cutting => "cutting",
    }
}

fn entry(set: &ElectrodeSet, e: usize, axes: &DAffine3) -> ElectrodeEntry {
    let (electrode, params) = (&set.electrodes[e], &set.params);
    let stage = &params.stages[electrode.stage];
    let orbit = axes.matrix3 * to_burn_frame(electrode.direction).transpose();
    let pattern = match stage.orbit {
        Orbit::None => "none",
        Orbit::Circular { .. } => "circular",
        Orbit::Square { .. } => "square",
    };
    let DVec3 { x, y, z } = electrode.blank;
    let diameter_mm = round_blank(&electrode.base, &params.blanks);
    let holder = electrode.holder.and_then(|h| params.holders.get(h));
    let burns =
        electrode.burns.iter().enumerate().map(|(i, burn)| BurnEntry::of(i + 1, burn, electrode.direction, axes));
    ElectrodeEntry {
        name: electrode.name.clone(),
        state: ElectrodeState::of(set, e, &params.overrides),
        stage: stage.name.clone(),
        material: electrode.material(params).to_owned(),
        shape: params.shape,
        gap_mm: stage.gap_mm,
        orbit: OrbitEntry {
            pattern,
            radius_mm: stage.orbit.radius_mm(),
            x_axis: unit(orbit.x_axis),
            y_axis: unit(orbit.y_axis),
        },
        undersize_wall_mm: stage.undersize(DVec3::X),
        undersize_floor_mm: stage.undersize(DVec3::Z),
        quantity: stage.quantity,
        finish_vdi: stage.finish_vdi,
        roughness_um: stage.roughness_um(),
        method: electrode.method,
        blank: BlankEntry { is_round: electrode.base.is_round, sides_mm: [x, y], length_mm: z, diameter_mm },
        holder: holder.map(|h| HolderEntry { name: h.name.clone(), size_mm: h.size_mm, height_mm: h.height_mm }),
        family: family(set, e),
        lift: unit(axes.transform_vector3(-electrode.direction)),
        front_area_mm2: electrode.front_area,
        burn_area_mm2: electrode.burn_area,
        base_height_mm: electrode.base.height,
        warnings: warnings(set, electrode),
        volume_mm3: electrode.burns.iter().map(|b| b.volume).sum(),
        minutes: electrode.figures.minutes.map(|minutes| minutes.mean),
        end_wear_mm: electrode.figures.end_wear_mm,
        corner_wear_mm: electrode.figures.corner_wear_mm,
        needed: electrode.needed_text(),
        rests_on: electrode.figures.explanation(),
        burns: burns.collect(),
        checks: CheckKind::ALL.map(|kind| check(set, e, kind, axes)).to_vec(),
    }
}

fn family(set: &ElectrodeSet, e: usize) -> Option<FamilyEntry> {
    let Family::Member { name, offset } = &set.electrodes[e].family else { return None };
    let others = set.body_of(e).into_iter().filter(|other| *other != e);
    Some(FamilyEntry {
        name: name.clone(),
        others: others.map(|other| set.electrodes[other].name.clone()).collect(),
        offset_mm: offset.to_array().map(rounded),
    })
}

/// Warnings that are no checks, as the electrode itself is right.
fn warnings(set: &ElectrodeSet, electrode: &Electrode) -> Vec<String> {
    let mut warnings = Vec::new();
    if electrode.holder.is_none() {
        let DVec3 { x, y, .. } = electrode.blank;
        warnings.push(format!("no holder is large enough for a blank of {x} x {y} mm: add one to the list of holders"));
    }
    warnings.extend(electrode.unmet.iter().cloned());
    if electrode.burns.iter().all(|b| b.volume <= 0.0) {
        warnings.push(
            "it removes nothing: the rest material there is thinner than the stock of its stage; leave it out".into(),
        );
    }
    if let Family::Apart { why } = &electrode.family {
        warnings.push(format!("it has its own base, not shared with other stages: {why}"));
    }
    let mut alone: Vec<usize> = electrode.burns.iter().flat_map(|b| &b.parts).map(|p| p.region).collect();
    alone.sort_unstable();
    alone.dedup();
    for region in alone {
        let left_out = set.regions.get(region).map_or(&[][..], |plan| &plan.left_out);
        let before = left_out.iter().filter(|left| left.stage < electrode.stage);
        warnings.extend(before.map(|left| format!("region {}, {}", region + 1, left.text)));
    }
    if set.params.shape == Shape::Net {
        let stage = &set.params.stages[electrode.stage];
        let [wall, floor] = [DVec3::X, DVec3::Z].map(|n| stage.undersize(n));
        warnings.push(format!(
            "the file has the net shape: mill the electrode smaller by {wall:.4} mm at the sides and {floor:.4} mm \
             at the bottom"
        ));
    }
    warnings
}

/// A part of a unit vector without what rounding makes of it.
fn plain(v: f64) -> f64 {
    (v * 1e12).round() / 1e12 + 0.0
}

fn unit(v: DVec3) -> [f64; 3] {
    v.to_array().map(plain)
}

fn pose(turned: DMat3, shift: [f64; 3]) -> Pose {
    let row = |i: usize| {
        let [x, y, z] = unit(turned.row(i));
        [x, y, z, shift[i] + 0.0]
    };
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

impl BurnEntry {
    /// The burn number `number` of an electrode along `direction` in the upright mold; `axes` are from there to those of
    /// the datum.
    pub fn of(number: usize, burn: &Burn, direction: DVec3, axes: &DAffine3) -> Self {
        let [x_mm, y_mm, z_mm] = axes.transform_point3(burn.position).to_array().map(rounded);
        let mut regions: Vec<usize> = burn.parts.iter().map(|p| p.region + 1).collect();
        regions.sort_unstable();
        regions.dedup();
        let turned = axes.matrix3 * to_burn_frame(direction).transpose();
        // C is counted from the burn frame in the axes of the datum.
        let x = to_burn_frame(axes.transform_vector3(direction)) * turned.x_axis;
        let stands = turned * DMat3::from_rotation_z(burn.turn);
        Self {
            number,
            x_mm,
            y_mm,
            z_mm,
            c_deg: c_deg(burn.turn + x.y.atan2(x.x)),
            x_axis: unit(stands.x_axis),
            pose: pose(stands, [x_mm, y_mm, z_mm]),
            depth_mm: burn.depth,
            volume_mm3: burn.volume,
            minutes: burn.minutes.map(|minutes| minutes.mean),
            parts: burn.parts.iter().map(ToString::to_string).collect(),
            regions,
        }
    }
}

/// To the decimals of the table, and no zero with a sign.
fn rounded(value: f64) -> f64 {
    let scale = 10f64.powi(DECIMALS);
    (value * scale).round() / scale + 0.0
}

/// A turn as the machine's C (degrees, above -180 up to 180).
fn c_deg(turn: f64) -> f64 {
    let c = rounded(turn.to_degrees().rem_euclid(360.0));
    if c > 180.0 { rounded(c - 360.0) } else { c }
}

fn check(set: &ElectrodeSet, e: usize, kind: CheckKind, axes: &DAffine3) -> CheckEntry {
    let made: Vec<_> = set.checks[e].iter().filter(|finding| finding.kind == kind).collect();
    let fails = made.iter().any(|finding| !finding.holds);
    // What holds is of no interest beside what does not.
    let told: Vec<_> = made.iter().filter(|finding| finding.holds != fails).collect();
    let state = match (made.is_empty(), fails) {
        (true, _) => CheckState::NotMade,
        (_, false) => CheckState::Ok,
        _ if set.is_overridden(e, kind, &set.params.overrides) => CheckState::Overridden,
        _ => CheckState::Failed,
    };
    CheckEntry {
        kind,
        state,
        text: told.iter().map(|finding| finding.text.as_str()).collect::<Vec<_>>().join("; "),
        place_mm: told
            .iter()
            .find_map(|finding| finding.place)
            .map(|p| axes.transform_point3(p).to_array().map(rounded)),
    }
}

#[cfg(test)]
mod tests;
