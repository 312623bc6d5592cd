//! Bounds of the least clearance between two rows: conservative advancement, pair by pair of hierarchy nodes.
//!
//! A pair of nodes is done with when some direction keeps them far enough apart over the whole window of time.
//! Only if none is found the pair is halved, and two single triangles wait until the window itself is halved.
//! What is claimed rests on separating directions alone: an error in the distance of two triangles could make
//! the upper bound less sharp and the work longer, but not the lower bound wrong.

use super::motion::{Motion, Window};

use geometry::bvh::Bvh;
use geometry::nearest_pair::{NodePair, halves};
use geometry::triangle_distance::{ClosestPoints, triangle_distance};
use task::{Cancel, Cancelled};

/// Number of pairs between two checks of the cancel flag: well below 50 ms.
const PAIRS_PER_CHECK: u32 = 4096;
/// How often the worst errors of two triangles and the direction between them are sharpened, where the motion over the
/// window is no more than what errors make.
const ERROR_TURNS: usize = 12;

/// Question to an interval of motion, with its stopping criteria.
#[derive(Debug, Clone, Copy)]
pub(super) struct Question {
    /// A clearance met elsewhere on the path (mm).
    pub known: f64,
    /// Greatest gap between lower and upper bound (mm).
    pub resolution: f64,
    /// A clearance below this (mm) ends the search.
    pub stop_below: f64,
    /// Greatest error of each axis, in either sense, constant over the motion (mm, rad).
    pub errors: [f64; 6],
}

/// Bounds of the least clearance over the motion between two rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    /// The clearance is nowhere smaller (mm).
    pub lower: f64,
    /// A clearance below the one known that occurs: where (electrode first, both in W) and when.
    pub found: Option<(ClosestPoints, f64)>,
    /// The errors of the axes that it occurs with (mm, rad).
    pub with_errors: [f64; 6],
    /// Triangle pairs and windows bounded one by one.
    pub pairs: u64,
}

/// Bounds the clearance over `motion`.
pub(super) fn bound(
    electrode: &Bvh,
    blisk: &Bvh,
    motion: &Motion,
    question: &Question,
    cancel: &Cancel,
) -> Result<Answer, Cancelled> {
    let answer = Answer { lower: f64::INFINITY, found: None, with_errors: [0.0; 6], pairs: 0 };
    let mut search = Search { electrode, blisk, question, answer, upper: question.known };
    let mut windows = vec![(0.0, 1.0, vec![[0, 0]])];
    while let Some((from, to, pairs)) = windows.pop() {
        let open = search.look_at(&motion.window(from, to), pairs, cancel)?;
        if search.upper < question.stop_below || search.upper <= question.resolution {
            search.answer.lower = 0.0;
            break;
        }
        if !open.is_empty() {
            let middle = 0.5 * (from + to);
            windows.push((middle, to, open.clone()));
            windows.push((from, middle, open));
        }
    }
    Ok(search.answer)
}

struct Search<'a> {
    electrode: &'a Bvh,
    blisk: &'a Bvh,
    question: &'a Question,
    answer: Answer,
    /// The smallest clearance known (mm).
    upper: f64,
}

impl Search<'_> {
    /// Bounds `pairs` over `window` and returns the pairs that need shorter windows.
    fn look_at(
        &mut self,
        window: &Window,
        mut pairs: Vec<NodePair>,
        cancel: &Cancel,
    ) -> Result<Vec<NodePair>, Cancelled> {
        let mut open = Vec::new();
        let mut countdown = 0;
        while let Some(pair) = pairs.pop() {
            if countdown == 0 {
                cancel.check()?;
                countdown = PAIRS_PER_CHECK;
            }
            countdown -= 1;
            if self.nodes_stay_apart(window, pair) {
                continue;
            }
            match halves(self.electrode, self.blisk, pair) {
                Some(_) if self.moves_more_than_its_size(window, pair) => open.push(pair),
                Some(halves) => pairs.extend(halves),
                None if self.triangles_stay_apart(window, pair) => {}
                None => open.push(pair),
            }
            if self.upper < self.question.stop_below || self.upper <= self.question.resolution {
                break;
            }
        }
        Ok(open)
    }

    /// Accepts `bound` for a part of the motion if it is sharp enough; returns whether it was.
    fn accept(&mut self, bound: f64) -> bool {
        let enough = bound >= self.upper - self.question.resolution;
        if enough {
            self.answer.lower = self.answer.lower.min(bound);
        }
        enough
    }

    fn nodes_stay_apart(&mut self, window: &Window, [e, b]: NodePair) -> bool {
        let (e, b) = (self.electrode.node(e), self.blisk.node(b));
        let (rotation, shift) = window.placement();
        let centers = (*rotation * e.bounds.center + shift).distance(b.bounds.center);
        if self.accept(centers - e.radius - b.radius - window.travel - window.error_reach()) {
            return true;
        }
        let separation = e.bounds.placed(rotation, shift).separation(&b.bounds);
        let length = separation.length();
        if length == 0.0 || length < self.upper - self.question.resolution {
            return false;
        }
        let direction = separation / length;
        let most = -b.bounds.least_along(-direction);
        self.accept(window.least_of_box(direction, &e.bounds) - most)
    }

    /// Whether a shorter window promises more than smaller nodes.
    fn moves_more_than_its_size(&self, window: &Window, [e, b]: NodePair) -> bool {
        let size = self.electrode.node(e).radius + self.blisk.node(b).radius;
        // The resolution, so that nodes of no size are opened in the end.
        window.travel > 2.0 * size + self.question.resolution
    }

    fn triangles_stay_apart(&mut self, window: &Window, [e, b]: NodePair) -> bool {
        self.answer.pairs += 1;
        let triangle = self.electrode.corners(self.electrode.node(e).triangle);
        let fixed = self.blisk.corners(self.blisk.node(b).triangle);
        let mut closest = triangle_distance(&window.placed(triangle), fixed);
        let (mut errors, mut bound) = ([0.0; 6], f64::NEG_INFINITY);
        // With errors both are sharpened in turn: the errors that bring the triangles nearest along the direction between
        // them, and the direction between them with these errors.
        let turns = if window.travel > window.error_reach() { 2 } else { ERROR_TURNS };
        for _ in 0..turns {
            if closest.distance < self.upper {
                self.upper = closest.distance;
                self.answer.found = Some((closest, window.middle));
                self.answer.with_errors = errors;
            }
            if closest.distance == 0.0 {
                return false;
            }
            let direction = (closest.first - closest.second) / closest.distance;
            let most = fixed.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
            bound = bound.max(window.least_of_triangle(direction, triangle) - most);
            if self.accept(bound) {
                return true;
            }
            let (rotation, shift) = window.placement();
            let on_electrode = rotation.transpose() * (closest.first - shift);
            let Some(worst) = window.worst_errors(direction, on_electrode) else { break };
            // Towards the worst ones only as far as the two points come nearer.
            let change: [f64; 6] = std::array::from_fn(|i| worst[i] - errors[i]);
            let Some([from, to]) = window.moved(on_electrode, [errors, worst]) else { break };
            let (between, way) = (closest.first - closest.second, to - from);
            let share = (-between.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            errors = std::array::from_fn(|i| errors[i] + share * change[i]);
            let Some(placed) = window.placed_with(errors, triangle) else { break };
            closest = triangle_distance(&placed, fixed);
        }
        // A window this short adds nothing more; only rounding can have brought it here.
        let exhausted = window.is_exhausted(self.question.resolution);
        if exhausted {
            self.answer.lower = self.answer.lower.min(bound.max(0.0));
        }
        exhausted
    }
}
