//! Progress of work under way.

use std::time::{Duration, Instant};

/// Work under way.
#[derive(Debug, Clone, PartialEq)]
pub struct Doing {
    /// Name of the memo that the work is for.
    pub what: &'static str,
    /// Stage of the computation: "waiting" before the work begins, then empty at first.
    pub stage: String,
    /// Share of the stage that is done, 0 to 1.
    pub fraction: f64,
    /// Detail, may be empty.
    pub message: String,
    /// Whether the work has not begun yet.
    pub is_waiting: bool,
    /// Time when the work was asked for.
    pub asked: Instant,
    /// Time when the work began, or was asked for.
    pub since: Instant,
    /// Time when the stage began.
    pub stage_since: Instant,
    /// Time when the share that is done last moved.
    pub moved: Instant,
}

/// How long the share that is done may stand still before the time left counts as unknown.
const STANDSTILL: Duration = Duration::from_secs(4);

impl Doing {
    pub(super) fn new(what: &'static str, is_waiting: bool, now: Instant) -> Self {
        let stage = if is_waiting { "waiting".to_owned() } else { String::new() };
        let message = String::new();
        Self { what, stage, fraction: 0.0, message, is_waiting, asked: now, since: now, stage_since: now, moved: now }
    }

    /// Time that the stage will still take at `now`, at its pace up to when its share last moved; none while that is
    /// unknown, and where the share has stood still too long to go by that pace.
    pub fn time_left(&self, now: Instant) -> Option<Duration> {
        let (spent, stood) = (self.moved - self.stage_since, now.saturating_duration_since(self.moved));
        let is_known = self.fraction > 0.03 && self.fraction < 1.0 && spent > Duration::from_millis(500);
        if !is_known || stood >= STANDSTILL {
            return None;
        }
        spent.mul_f64((1.0 - self.fraction) / self.fraction).checked_sub(stood)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_left_counts_down_and_is_not_told_of_a_share_that_stands_still() {
        let began = Instant::now();
        let after = |seconds| began + Duration::from_secs(seconds);
        let doing = |fraction, moved| Doing {
            what: "numbers",
            stage: "search".to_owned(),
            fraction,
            message: String::new(),
            is_waiting: false,
            asked: began,
            since: began,
            stage_since: began,
            moved: after(moved),
        };
        let left =
            |fraction, moved, now| doing(fraction, moved).time_left(after(now)).map(|left| left.as_secs_f64().round());
        // A half in 10 s: the other half takes as long.
        assert_eq!((left(0.5, 10, 10), left(0.5, 10, 12)), (Some(10.0), Some(8.0)));
        assert_eq!((left(0.25, 10, 13), left(0.25, 10, 14)), (Some(27.0), None), "it stands still");
        // A share that came with the stage itself tells of no pace, and one that is over is over.
        assert_eq!((left(0.5, 0, 2), left(0.8, 2, 3), left(1.0, 10, 10)), (None, None, None));
        assert_eq!((left(f64::NAN, 10, 10), left(0.0, 10, 10)), (None, None));
    }
}
