//! What is known of a blisk while its parameters change, with work that is done here, one piece after the other.

use files::AnyDocument as _;

use super::*;

struct Bench {
    scheduler: Scheduler,
    work: BliskWork,
    document: Document,
}

impl Bench {
    fn new() -> Self {
        let scheduler = Scheduler::manual(|| ());
        let (work, document) = (BliskWork::new(&scheduler), Document::new(PlanJob::demonstration()));
        Self { scheduler, work, document }
    }

    fn follow(&mut self) -> Vec<String> {
        let events = self.work.follow(&mut self.document, Priority::Shown);
        events.into_iter().map(|(_, event)| event.text).collect()
    }

    /// Does all work that there is. Returns what was said.
    fn settle(&mut self) -> Vec<String> {
        let mut said = self.follow();
        while self.scheduler.run_next(Lane::Long) {
            said.extend(self.follow());
        }
        said
    }

    fn edit(&mut self, change: impl FnOnce(&mut PlanJob)) {
        let mut job = self.document.params().clone();
        change(&mut job);
        self.document.edit("Job", job, false);
    }

    fn states(&self) -> [State; 3] {
        [Stage::Part, Stage::Channel, Stage::Electrode].map(|stage| self.work.state(stage))
    }
}

#[test]
fn what_was_made_is_there_at_once_when_its_parameters_are_there_again() {
    use State::{Missing, Ready, Running, Stale};
    let mut bench = Bench::new();
    assert_eq!(bench.states(), [Missing, Missing, Missing]);
    let said = bench.settle();
    assert_eq!(bench.states(), [Ready, Ready, Ready], "{said:?}");
    let begins = |i: usize, start: &str| said[i].starts_with(start);
    assert!(said.len() == 3 && begins(0, "Part: ") && begins(1, "Channel: ") && begins(2, "Electrode: "), "{said:?}");
    let made = bench.work.electrodes().unwrap().clone();

    bench.edit(|job| job.electrode.radial_reduction_mm += 0.1);
    assert_eq!((bench.follow(), bench.states()), (Vec::new(), [Ready, Ready, Running]));
    assert!(Arc::ptr_eq(bench.work.electrodes().unwrap(), &made), "the last ones are shown meanwhile");
    assert_eq!(bench.settle().len(), 1);
    bench.edit(|job| job.blisk.options.channel = 1);
    bench.follow();
    assert_eq!(bench.states(), [Ready, Running, Stale]);
    bench.settle();
    assert_eq!(bench.states(), [Ready, Ready, Ready]);

    assert!(bench.document.undo(false) && bench.document.undo(false));
    assert_eq!((bench.follow(), bench.states()), (Vec::new(), [Ready, Ready, Ready]));
    assert!(!bench.scheduler.run_next(Lane::Long) && Arc::ptr_eq(bench.work.electrodes().unwrap(), &made));
}

#[test]
fn what_is_cancelled_rests_until_the_files_are_read_again() {
    let mut bench = Bench::new();
    bench.follow();
    assert!(bench.work.is_busy() && bench.work.doing().is_some_and(|doing| doing.what == "Part"));
    bench.work.cancel();
    assert_eq!(bench.settle(), ["Part: cancelled"]);
    let State::Failed(why) = bench.work.state(Stage::Part) else { panic!("{:?}", bench.states()) };
    assert!(why.contains("load the part again") && !bench.work.is_busy(), "{why}");
    bench.work.reload();
    assert_eq!(bench.settle().len(), 3);
    // A plan that was given up before it began is as if it had not been asked for.
    bench.work.start_plan().unwrap();
    assert_eq!(bench.work.state(Stage::Plan), State::Running);
    bench.work.cancel();
    assert_eq!(bench.follow(), ["Plan: cancelled"]);
    bench.settle();
    assert_eq!((bench.work.state(Stage::Plan), bench.work.is_busy()), (State::Missing, false));
}
