//! How long the stages of a job take.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use crate::{Progress, Task};

/// Time of a stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTime {
    /// Name of the stage, as the job reports it.
    pub stage: String,
    /// Time spent in it (s), summed over all its parts.
    pub seconds: f64,
}

#[derive(Debug, Default)]
struct Times {
    spent: Vec<StageTime>,
    /// Stage under way, and when it began or was counted last.
    now: Option<(String, Instant)>,
}

impl Times {
    /// Counts the stage under way up to `at`.
    fn count(&mut self, at: Instant) {
        let Some((stage, since)) = &mut self.now else { return };
        let seconds = at.saturating_duration_since(*since).as_secs_f64();
        *since = at;
        match self.spent.iter_mut().find(|known| known.stage == *stage) {
            Some(known) => known.seconds += seconds,
            None => self.spent.push(StageTime { stage: stage.clone(), seconds }),
        }
    }

    /// Enters a stage at `at`, unless it is under way.
    fn enter(&mut self, stage: &str, at: Instant) {
        if self.now.as_ref().is_none_or(|(now, _)| now != stage) {
            self.count(at);
            self.now = Some((stage.to_owned(), at));
        }
    }
}

/// Clock of a job: each stage lasts from its first report of progress to that of another stage.
#[derive(Debug, Clone, Default)]
pub struct StageClock(Arc<Mutex<Times>>);

impl StageClock {
    /// `task` with its stages timed by this clock.
    pub fn timed(&self, task: &Task) -> Task {
        let (clock, progress) = (self.clone(), task.progress.clone());
        let progress = Progress::new(move |update| {
            clock.lock(|times| times.enter(update.stage, Instant::now()));
            progress.report(update.stage, update.fraction, update.message);
        });
        Task { progress, cancel: task.cancel.clone() }
    }

    /// Times up to now, in the order in which the stages began.
    pub fn times(&self) -> Vec<StageTime> {
        self.lock(|times| {
            times.count(Instant::now());
            times.spent.clone()
        })
    }

    fn lock<T>(&self, work: impl FnOnce(&mut Times) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn stages_are_summed_by_name_in_the_order_of_their_beginning() {
        let (begin, mut times) = (Instant::now(), Times::default());
        let at = |ms: u64| begin + Duration::from_millis(ms);
        times.count(at(5));
        for (stage, ms) in [("a", 10), ("b", 20), ("b", 30), ("a", 50)] {
            times.enter(stage, at(ms));
        }
        times.count(at(51));
        times.count(at(52));
        let spent: Vec<_> = times.spent.iter().map(|t| (&*t.stage, (t.seconds * 1e3).round())).collect();
        assert_eq!(spent, [("a", 12.0), ("b", 30.0)]);
    }

    #[test]
    fn a_timed_task_reports_and_stops_as_before() {
        let told = Arc::new(Mutex::new(Vec::new()));
        let list = told.clone();
        let progress = Progress::new(move |u| list.lock().unwrap().push((u.stage.to_owned(), u.fraction)));
        let task = Task { progress, ..Task::default() };
        let clock = StageClock::default();
        let timed = clock.timed(&task);
        timed.report("a", 0.25, "");
        timed.report("b", 1.0, "");
        assert_eq!(*told.lock().unwrap(), [("a".to_owned(), 0.25), ("b".to_owned(), 1.0)]);
        let stages: Vec<String> = clock.times().into_iter().map(|t| t.stage).collect();
        assert_eq!(stages, ["a", "b"]);
        task.cancel.cancel();
        assert!(timed.check().is_err());
    }
}
