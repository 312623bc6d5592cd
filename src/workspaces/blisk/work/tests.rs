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

#[test]
fn a_preview_that_is_cancelled_rests_until_it_is_wanted_or_something_changes() {
    let mut bench = Bench::new();
    bench.settle();
    let look = |bench: &mut Bench| {
        bench.work.look(0, true, 0.0);
        (bench.work.look_state(), bench.work.is_looking())
    };
    assert_eq!(look(&mut bench), (State::Running, true));
    bench.work.cancel();
    assert_eq!(look(&mut bench), (State::Cancelled, false));
    let said = bench.follow();
    assert!(said.len() == 1 && said[0].contains("preview of the extraction path was cancelled"), "{said:?}");
    bench.work.resume_look();
    assert_eq!(look(&mut bench), (State::Running, true), "wanted after all");
    bench.work.cancel();
    bench.edit(|job| job.electrode.radial_reduction_mm += 0.1);
    bench.settle();
    assert_eq!(look(&mut bench), (State::Running, true), "another electrode");
    // Neither the preview nor the plan that waits needs its preparation any more.
    bench.work.start_plan().unwrap();
    bench.follow();
    bench.work.cancel();
    assert!(!bench.work.is_looking() && !bench.work.is_busy());
}

#[test]
fn what_could_not_be_made_anew_is_of_earlier_parameters() {
    let mut bench = Bench::new();
    assert_eq!(bench.work.is_earlier(), [false, false], "nothing is known");
    bench.settle();
    assert_eq!(bench.work.is_earlier(), [false, false]);
    bench.edit(|job| job.electrode.radial_reduction_mm = 100.0);
    bench.settle();
    assert!(matches!(bench.work.state(Stage::Electrode), State::Failed(_)));
    assert_eq!(bench.work.is_earlier(), [false, true]);
    bench.edit(|job| job.blisk.options.hub_radius_mm = wheel::options::Auto::Given(1.0));
    bench.settle();
    assert!(matches!(bench.work.state(Stage::Channel), State::Failed(_)));
    assert_eq!(bench.work.is_earlier(), [true, true]);
    assert!(bench.document.undo(false) && bench.document.undo(false));
    bench.settle();
    assert_eq!(bench.work.is_earlier(), [false, false]);
    bench.work.reload();
    bench.follow();
    bench.work.cancel();
    bench.settle();
    assert!(matches!(bench.work.state(Stage::Part), State::Failed(_)));
    assert_eq!(bench.work.is_earlier(), [true, true], "the part could not be read again");
}
