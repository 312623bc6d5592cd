//! Errors of setting up that a path bears: every axis may be off by a constant amount while the electrode feeds.
//!
//! Blisk and electrode are never set up exactly: where the blisk's axis and zero angle are taken, where the electrode sits
//! in its holder, and where the machine finds both adds to the axes what stays the same all along the path. The box of
//! errors is scaled until the clearance is just proven for every error within it, by the same bounds as the certificate's.

use std::fmt;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::interval::{Answer, Question};
use super::{INTERVALS_IN_TURN, Run, Verifier, VerifyError, VerifyOptions};
use crate::path::FeedPath;
use crate::pose::Axis;
use task::{Cancelled, Task};
use wheel::channel::Surface;

/// Part of the spark gap that setting errors may take up where nothing else is said: the accuracy of P1's channels (mm).
pub const ACCURACY_MM: f64 = 0.03;

/// How close the proven bound comes to what errors make of the clearance (mm).
const RESOLUTION: f64 = 1e-4;
/// Least clearance that has to be left with every error (mm).
pub const LEAST_LEFT_MM: f64 = 10.0 * RESOLUTION;
/// Ratio of a box that is too large to the largest one that holds, at most.
const RATIO: f64 = 1.005;
/// Multiple of the box up to which a larger one is looked for.
const MOST_SCALE: f64 = 64.0;
/// Multiple of the box below which none holds.
const LEAST_SCALE: f64 = 1e-6;

/// Looks, each at a box larger by [`RATIO`], at which errors that leave less are searched beyond where the proof ends.
const STEPS_OUT: i32 = 4;
/// Boxes that are usually looked at.
const USUAL_LOOKS: f64 = 12.0;

/// Greatest error of each axis, in either sense.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SettingErrors {
    /// Along the blisk axis (mm).
    pub x_mm: f64,
    /// Across the channel (mm).
    pub y_mm: f64,
    /// Radially (mm).
    pub z_mm: f64,
    /// Of the blisk about its axis (degrees).
    pub a_deg: f64,
    /// Of the electrode's tilt about its Y (degrees).
    pub b_deg: f64,
    /// Of the electrode about its Z (degrees).
    pub c_deg: f64,
}

impl Default for SettingErrors {
    /// About what a preset gauge, a ball and good axes leave (P1: contributions of 3 to 5 um each, at radii about 100 mm).
    fn default() -> Self {
        Self { x_mm: 0.005, y_mm: 0.005, z_mm: 0.005, a_deg: 0.002, b_deg: 0.002, c_deg: 0.002 }
    }
}

impl SettingErrors {
    /// The errors as values of the axes (mm, rad).
    pub fn of_axes(&self) -> [f64; 6] {
        let Self { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg } = *self;
        [x_mm, y_mm, z_mm, a_deg.to_radians(), b_deg.to_radians(), c_deg.to_radians()]
    }

    /// The errors with these values of the axes (mm, rad).
    pub fn from_axes([x_mm, y_mm, z_mm, a, b, c]: [f64; 6]) -> Self {
        Self { x_mm, y_mm, z_mm, a_deg: a.to_degrees(), b_deg: b.to_degrees(), c_deg: c.to_degrees() }
    }

    /// All errors times `by`.
    pub fn scaled(&self, by: f64) -> Self {
        Self::from_axes(self.of_axes().map(|error| error * by))
    }

    /// Checks the range of every error.
    ///
    /// # Errors
    /// [`VerifyError`] that names the error.
    pub fn validate(&self) -> Result<(), VerifyError> {
        let values = [self.x_mm, self.y_mm, self.z_mm, self.a_deg, self.b_deg, self.c_deg];
        let names = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"];
        for (name, value) in names.into_iter().zip(values) {
            if !(0.0..=1.0).contains(&value) {
                return Err(VerifyError::Parameter { name, value, must_be: "from 0 to 1 (mm or degrees)" });
            }
        }
        if values == [0.0; 6] {
            let must_be = "more than 0 for at least one axis";
            return Err(VerifyError::Parameter { name: "the greatest setting error", value: 0.0, must_be });
        }
        Ok(())
    }
}

impl fmt::Display for SettingErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = [self.x_mm, self.y_mm, self.z_mm, self.a_deg, self.b_deg, self.c_deg];
        for (i, (axis, value)) in Axis::ALL.into_iter().zip(values).enumerate() {
            let (unit, between) = (if axis.is_rotary() { "deg" } else { "mm" }, if i == 0 { "" } else { ", " });
            write!(f, "{between}{} {value:.4} {unit}", axis.letter())?;
        }
        Ok(())
    }
}

/// Errors with which the clearance is too small.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TooFar {
    /// The errors, with their signs.
    pub errors: SettingErrors,
    /// Distance that is left (mm).
    pub distance_mm: f64,
    /// Position on the path: `3.25` is a quarter of the way from row 3 to row 4.
    pub row: f64,
    /// Surface of the blisk that the electrode comes too near to.
    pub surface: Surface,
}

/// The setting errors that a path bears.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SettingRoom {
    /// The errors that were asked about.
    pub asked: SettingErrors,
    /// Clearance that has to be left with every error (mm).
    pub least_mm: f64,
    /// Greatest multiple of the errors asked about within which the clearance is proven; 0 where it is with none.
    pub scale: f64,
    /// Errors at most a few per cent beyond that leave less; none where none were found, as of the largest box looked at.
    pub beyond: Option<TooFar>,
}

impl SettingRoom {
    /// The largest box of errors, of the shape asked for, within which the clearance is proven.
    pub fn largest(&self) -> SettingErrors {
        self.asked.scaled(self.scale)
    }

    /// Whether the clearance is proven with the errors asked about.
    pub fn holds(&self) -> bool {
        self.scale >= 1.0
    }

    /// The answer in a sentence.
    pub fn sentence(&self) -> String {
        let verdict = if self.holds() { "setting errors hold" } else { "setting errors do NOT hold" };
        let largest = match self.scale {
            0.0 => "not even without any".to_owned(),
            MOST_SCALE.. => format!("{} at least", self.largest()),
            _ => self.largest().to_string(),
        };
        format!(
            "{verdict}: {:.4} mm of clearance with errors up to {}; the largest errors of this shape: {largest}",
            self.least_mm, self.asked
        )
    }
}

/// Answer for a box of errors.
enum Verdict {
    Holds,
    /// Not proven; with errors that leave less where some were found.
    Fails(Option<TooFar>),
}

impl Verifier {
    /// The largest box of setting errors, of the shape of `errors`, with all of which at least `least_mm` of clearance is
    /// left all along `path`, to within half a per cent. `surface_of` names the surface that a point of the blisk lies on.
    ///
    /// # Errors
    /// [`VerifyError`]: a path or errors that cannot be judged, or the task was cancelled.
    pub fn setting_room(
        &self,
        path: &FeedPath,
        errors: &SettingErrors,
        least_mm: f64,
        surface_of: &(dyn Fn(glam::DVec3) -> Surface + Sync),
        task: &Task,
    ) -> Result<SettingRoom, VerifyError> {
        let options = VerifyOptions::default();
        let run = Run { body: self, path, surface_of, options: &options, task };
        run.check_path()?;
        errors.validate()?;
        if !(least_mm > LEAST_LEFT_MM && least_mm.is_finite()) {
            let must_be = "a length of more than 0.001 mm";
            return Err(VerifyError::Parameter { name: "the clearance to be left", value: least_mm, must_be });
        }
        let room = |scale: f64, beyond: Option<TooFar>| SettingRoom { asked: *errors, least_mm, scale, beyond };
        let is_inside = self.pair().one_inside_the_other(&path.rows[0].pose, &task.cancel)?.is_some();
        if is_inside {
            return Ok(room(0.0, None));
        }
        let (mut good, mut bad, mut beyond) = (0.0, f64::INFINITY, None);
        let (mut scale, mut looks) = (1.0, 0);
        while bad > RATIO * good {
            task.report("setting errors", (f64::from(looks) / USUAL_LOOKS).min(1.0), "");
            looks += 1;
            match run.within(&errors.scaled(scale), least_mm)? {
                Verdict::Holds => good = scale,
                Verdict::Fails(found) => (bad, beyond) = (scale, found),
            }
            if good >= MOST_SCALE || bad <= LEAST_SCALE {
                break;
            }
            scale = match (good, bad) {
                (_, f64::INFINITY) => 2.0 * good,
                (0.0, _) => 0.5 * bad,
                _ => (good * bad).sqrt(),
            };
        }
        // Where only the proof ends, errors that do leave less are a little further out.
        for step in 1..=STEPS_OUT {
            if beyond.is_some() || bad == f64::INFINITY {
                break;
            }
            if let Verdict::Fails(found) = run.within(&errors.scaled(bad * RATIO.powi(step)), least_mm)? {
                beyond = found;
            }
        }
        Ok(room(good, beyond))
    }
}

impl Run<'_> {
    /// Whether every error within the box leaves `least_mm` of clearance all along the path.
    fn within(&self, errors: &SettingErrors, least_mm: f64) -> Result<Verdict, VerifyError> {
        let question = Question {
            known: least_mm + RESOLUTION,
            resolution: RESOLUTION,
            stop_below: least_mm,
            errors: errors.of_axes(),
        };
        let rows = &self.path.rows;
        // A path of one row stands still.
        let intervals: Vec<[usize; 2]> =
            if rows.len() == 1 { vec![[0, 0]] } else { (1..rows.len()).map(|i| [i - 1, i]).collect() };
        let mut holds = true;
        for part in intervals.chunks(INTERVALS_IN_TURN) {
            let bound = |&[from, to]: &[usize; 2]| {
                self.body.pair().bound(&rows[from].pose, &rows[to].pose, &question, &self.task.cancel)
            };
            let answers: Result<Vec<Answer>, Cancelled> = part.par_iter().map(bound).collect();
            for (&[from, to], answer) in part.iter().zip(answers?) {
                if let Some((points, t)) = answer.found.filter(|(points, _)| points.distance < least_mm) {
                    return Ok(Verdict::Fails(Some(TooFar {
                        errors: SettingErrors::from_axes(answer.with_errors),
                        distance_mm: points.distance,
                        row: from as f64 + if from == to { 0.0 } else { t },
                        surface: (self.surface_of)(points.second),
                    })));
                }
                holds &= answer.lower >= least_mm;
            }
        }
        Ok(if holds { Verdict::Holds } else { Verdict::Fails(None) })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::path::PathRow;
    use crate::pose::Pose;
    use geometry::frame::Frame;
    use geometry::mesh::Mesh;

    /// Where the bar stands in its final pose (mm).
    const O: DVec3 = DVec3::new(0.0, 0.0, 50.0);
    /// Of the bar, half (mm), and its distance from each wall.
    const HALF: DVec3 = DVec3::new(10.0, 2.0, 5.0);
    const GAP: f64 = 0.1;

    /// A bar that is withdrawn from between two walls, straight or in a curve.
    fn withdrawn(pose: impl Fn(f64) -> Pose) -> (Verifier, FeedPath) {
        let block = |half: DVec3, at: DVec3| Mesh::cuboid(2.0 * half).mapped(|p| p - half + at);
        let bar = block(HALF, O);
        let wall = |side: f64| block(DVec3::new(12.0, 1.0, 8.0), O + DVec3::Y * side * (HALF.y + GAP + 1.0));
        let mut walls = wall(1.0);
        walls.append(&wall(-1.0));
        let row = |i: u32| {
            let s = f64::from(16 - i);
            PathRow { node: i as usize, s, pose: pose(s) }
        };
        let path =
            FeedPath { frame: Frame::IDENTITY, reference_point: O, spark_gap: GAP, rows: (0..=16).map(row).collect() };
        (Verifier::new(&walls, &bar, O, &task::Cancel::default()).unwrap(), path)
    }

    /// The pose with these errors of the axes.
    fn with_errors(pose: &Pose, errors: [f64; 6]) -> Pose {
        let axes = pose.to_array();
        Pose::from_array(std::array::from_fn(|i| axes[i] + errors[i]))
    }

    fn room(scene: &(Verifier, FeedPath), errors: &SettingErrors, least: f64) -> SettingRoom {
        scene.0.setting_room(&scene.1, errors, least, &|_| Surface::LowWall, &Task::default()).unwrap()
    }

    const NONE: SettingErrors = SettingErrors { x_mm: 0.0, y_mm: 0.0, z_mm: 0.0, a_deg: 0.0, b_deg: 0.0, c_deg: 0.0 };

    #[test]
    fn a_bar_between_walls_bears_what_is_worked_out_by_hand() {
        let straight = withdrawn(|s| Pose { x: -2.0 * s, ..Pose::FINAL });
        let least = 0.07;
        // Across the slot it may be off by the gap less what has to be left.
        let across = room(&straight, &SettingErrors { y_mm: 0.005, ..NONE }, least);
        let ratio = across.largest().y_mm / (GAP - least);
        assert!((1.0 / RATIO - 1e-3..=1.0).contains(&ratio) && across.holds(), "{across:?}");
        let beyond = across.beyond.unwrap();
        assert!(beyond.distance_mm < least && beyond.errors.y_mm.abs() <= RATIO * across.largest().y_mm + 1e-12);
        // About its Z the corner that lies 10 mm along and 2 mm across comes nearer by 10 sin c - 2 (1 - cos c).
        let turned = room(&straight, &SettingErrors { c_deg: 0.01, ..NONE }, least).largest().c_deg.to_radians();
        let nearer = HALF.x * turned.sin() - HALF.y * (1.0 - turned.cos());
        assert!((1.0 / RATIO - 5e-3..=1.0).contains(&(nearer / (GAP - least))), "{nearer}");
        // Both together share the room.
        let both = SettingErrors { y_mm: 0.01, c_deg: (0.001_f64).to_degrees(), ..NONE };
        let share = room(&straight, &both, least).scale * (0.01 + HALF.x * 0.001) / (GAP - least);
        assert!((1.0 / RATIO - 5e-3..=1.0).contains(&share), "{share}");
        // However large the errors asked about, the largest that hold are found.
        let far = room(&straight, &SettingErrors { y_mm: 1.0, ..NONE }, least);
        assert!((far.largest().y_mm / across.largest().y_mm - 1.0).abs() < 0.01 && !far.holds(), "{far:?}");
        // Along the slot nothing comes nearer, and with too much to be left nothing holds.
        assert_eq!(room(&straight, &SettingErrors { x_mm: 0.001, ..NONE }, least).scale, MOST_SCALE);
        let none = room(&straight, &both, 0.11);
        assert!(none.scale == 0.0 && none.beyond.is_some() && !none.holds(), "{none:?}");
        assert!(none.sentence().contains("do NOT hold") && none.sentence().contains("not even without any"));
    }

    /// 10,000 random errors within the largest box of all six, at instants all along a curved way, against distances that
    /// are exact; just outside it one that leaves less.
    #[test]
    fn no_errors_within_the_largest_box_leave_less_and_some_just_outside_do() {
        let curved = withdrawn(|s| Pose { x: -1.5 * s, y: 1e-3 * s, c: 2e-5 * s * s, a: 1e-5 * s, ..Pose::FINAL });
        let asked = SettingErrors { x_mm: 0.01, y_mm: 0.005, z_mm: 0.01, a_deg: 0.004, b_deg: 0.02, c_deg: 0.01 };
        let least = 0.03;
        let found = room(&curved, &asked, least);
        assert!(found.scale > 0.0 && found.scale < MOST_SCALE, "{found:?}");
        let (verifier, path) = &curved;
        let at = |row: f64| {
            let from = (row.floor() as usize).min(path.rows.len() - 2);
            path.rows[from].pose.lerp(&path.rows[from + 1].pose, row - from as f64)
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let largest = found.largest().of_axes();
        let mut nearest = f64::INFINITY;
        for i in 0..10_000 {
            // Half of them at corners of the box, where the worst are.
            let share = |rng: &mut ChaCha8Rng| {
                let share: f64 = rng.random_range(-1.0..=1.0);
                if i % 2 == 0 { share.signum() } else { share }
            };
            let errors = largest.map(|error| error * share(&mut rng));
            let row = rng.random_range(0.0..=(path.rows.len() - 1) as f64);
            nearest = nearest.min(verifier.distance(&with_errors(&at(row), errors)).distance);
        }
        assert!(nearest >= least, "{nearest}");
        assert!(nearest < least + 2e-3, "the box could be larger: {nearest}");
        let beyond = found.beyond.unwrap();
        let errors = beyond.errors.of_axes();
        let ratio = RATIO.powi(1 + STEPS_OUT) * (1.0 + 1e-9);
        assert!(errors.iter().zip(largest).all(|(error, most)| error.abs() <= ratio * most), "{found:?}");
        let distance = verifier.distance(&with_errors(&at(beyond.row), errors)).distance;
        assert!(distance < least && (distance - beyond.distance_mm).abs() < 1e-7, "{distance} {beyond:?}");
    }

    #[test]
    fn errors_that_cannot_be_judged_are_named() {
        let scene = withdrawn(|s| Pose { x: -s, ..Pose::FINAL });
        let refused = |errors: SettingErrors, least: f64| {
            let room = scene.0.setting_room(&scene.1, &errors, least, &|_| Surface::LowWall, &Task::default());
            room.unwrap_err().to_string()
        };
        assert!(refused(SettingErrors { b_deg: f64::NAN, ..NONE }, 0.05).contains("b_deg"));
        assert!(refused(SettingErrors { y_mm: -0.1, ..NONE }, 0.05).contains("y_mm is -0.1"));
        assert!(refused(NONE, 0.05).contains("at least one axis"));
        assert!(refused(SettingErrors::default(), 0.0).contains("the clearance to be left is 0"));
    }
}
