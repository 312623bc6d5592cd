//! Progress of the tests of a simulation.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::tour::{Leg, Visit};
use task::Task;

/// Counts the legs of all tests, which are done in parallel.
pub(super) struct Pace<'a> {
    task: &'a Task,
    visits: &'a [Visit],
    legs: usize,
    done: AtomicUsize,
}

impl<'a> Pace<'a> {
    /// Counter of `legs` tests, none of which is done.
    pub fn new(task: &'a Task, visits: &'a [Visit], legs: usize) -> Self {
        Self { task, visits, legs: legs.max(1), done: AtomicUsize::new(0) }
    }

    /// `body` is about to be tested on one of `legs`; says in which channel, if there are several.
    pub fn begin(&self, body: &str, leg: &Leg, legs: &[&Leg]) {
        let done = self.done.load(Ordering::Relaxed);
        self.task.report("simulation", done as f64 / self.legs as f64, &self.message(body, leg, legs));
    }

    /// A leg is done.
    pub fn end(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    fn message(&self, body: &str, leg: &Leg, legs: &[&Leg]) -> String {
        let place = self.visits.iter().position(|visit| visit.channel == leg.channel);
        let doing = leg.phase.name();
        match place {
            // What is tested in one channel stands for all of them, or there is no other.
            Some(place) if legs.iter().any(|other| other.channel != leg.channel) => {
                format!("{body}, {doing}, channel {} of {}", place + 1, self.visits.len())
            }
            _ => format!("{body}, {doing}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::super::Phase;
    use super::*;
    use task::Progress;

    #[test]
    fn the_channel_is_told_by_its_place_in_the_tour() {
        let leg = |channel| Leg { phase: Phase::Feed, channel, poses: Vec::new() };
        let visits = [7, 9, 0].map(|channel| Visit { channel, turn: 0.0 });
        let (legs, said) = (visits.map(|v| leg(v.channel)), Arc::new(Mutex::new(Vec::new())));
        let sink = said.clone();
        let progress = Progress::new(move |u| sink.lock().unwrap().push((u.fraction, u.message.to_owned())));
        let task = Task { progress, ..Task::default() };
        let (all, pace) = (legs.each_ref(), Pace::new(&task, &visits, 4));
        pace.begin("chuck", &legs[1], &all);
        pace.end();
        pace.begin("chuck", &legs[2], &all);
        pace.begin("arm", &legs[0], &all[..1]);
        let expected =
            [(0.0, "chuck, feed, channel 2 of 3"), (0.25, "chuck, feed, channel 3 of 3"), (0.25, "arm, feed")];
        assert_eq!(*said.lock().unwrap(), expected.map(|(done, text)| (done, text.to_owned())));
    }
}
