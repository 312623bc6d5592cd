//! The laws of a memo, with work that is done here, one piece after the other, and on threads that are met at their own
//! messages. Nothing waits for a time.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::*;

type Numbers = Memo<u32, u32, u32>;

fn by_hand() -> Scheduler {
    Scheduler::manual(|| ())
}

fn numbers(scheduler: &Scheduler) -> Numbers {
    Memo::new(scheduler, Lane::Long, "numbers")
}

/// Asks for ten times the key.
fn ask(memo: &mut Numbers, key: u32) -> State {
    memo.ask(&key, Priority::Shown, move |_| Ok(10 * key))
}

fn run_all(scheduler: &Scheduler) {
    while scheduler.run_next(Lane::Long) {}
}

/// Asks for a key and has it made.
fn make(scheduler: &Scheduler, memo: &mut Numbers, key: u32) {
    ask(memo, key);
    run_all(scheduler);
    memo.turn_to(&key);
}

fn values(memo: &Numbers) -> Vec<u32> {
    (0..20).filter_map(|key| memo.get(&key).map(|v| **v)).collect()
}

/// A scheduler with threads, and what tells that something is new.
fn with_threads() -> (Scheduler, Receiver<()>) {
    let (sender, woken) = channel();
    (Scheduler::start(move || sender.send(()).unwrap_or(())).unwrap(), woken)
}

/// Waits until work has ended.
fn wait<K: Clone + PartialEq, V: Send + 'static>(memo: &mut Memo<K, V, u32>, woken: &Receiver<()>) -> Ended<K, V> {
    loop {
        match memo.take() {
            Some(ended) => return ended,
            None => woken.recv().unwrap(),
        }
    }
}

/// Goes on until it is told to stop; says that it has begun.
fn until_cancelled(begun: Sender<()>) -> impl Fn(&Work<u32>) -> Result<u32, String> + Send {
    move |work| {
        begun.send(()).unwrap();
        while !work.task.cancel.is_cancelled() {
            std::thread::yield_now();
        }
        Err("stopped".to_owned())
    }
}

#[test]
fn a_value_is_missing_running_and_ready_and_of_another_key_stale() {
    let scheduler = by_hand();
    let memo = &mut numbers(&scheduler);
    assert_eq!((memo.state(&1), memo.is_busy()), (State::Missing, false));
    assert_eq!(ask(memo, 1), State::Running);
    assert!(memo.is_busy() && memo.doing().is_some_and(|d| d.is_waiting && d.what == "numbers"));
    run_all(&scheduler);
    assert_eq!(memo.state(&1), State::Running, "nothing changes before it is taken in");
    let ended = memo.take().unwrap();
    assert_eq!((ended.key, ended.result.map(|v| *v)), (1, Ok(10)));
    assert!(memo.take().is_none() && !memo.is_busy() && memo.doing().is_none());
    assert_eq!((memo.state(&1), memo.state(&2)), (State::Ready, State::Stale));
    assert_eq!((memo.get(&2), memo.last().map(|(of, v)| (*of, **v))), (None, Some((1, 10))));
    // The value of the other key stays while that of this one is made.
    assert_eq!(ask(memo, 2), State::Running);
    assert_eq!((memo.get(&2), memo.last().map(|(of, _)| *of)), (None, Some(1)));
}

#[test]
fn the_latest_key_wins() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler);
    (1..=3).for_each(|key| drop(ask(&mut memo, key)));
    run_all(&scheduler);
    assert_eq!(memo.take().unwrap().key, 3);
    assert!(memo.take().is_none(), "what was superseded says nothing");
    assert_eq!((values(&memo), memo.state(&1)), (vec![30], State::Stale));
    // Whoever turns to another key needs no work of an earlier one any more, and may ask for it again.
    ask(&mut memo, 4);
    memo.turn_to(&3);
    assert_eq!((memo.is_busy(), memo.state(&4), scheduler.run_next(Lane::Long)), (false, State::Stale, false));
    ask(&mut memo, 4);
    memo.stop();
    assert_eq!((memo.under_way(), memo.wants(&4), scheduler.run_next(Lane::Long)), (None, true, false));
    make(&scheduler, &mut memo, 4);
    assert_eq!((values(&memo), memo.wants(&4)), (vec![30, 40], false));
}

/// Goes on, whatever it is told, until it is let go; says that it has begun.
fn until_let_go(begun: Sender<()>) -> (impl Fn(&Work<u32>) -> Result<u32, String> + Send, Sender<()>) {
    let (let_go, held) = channel();
    let work = move |_: &Work<u32>| {
        begun.send(()).unwrap();
        held.recv().map(|()| 1).map_err(|e| e.to_string())
    };
    (work, let_go)
}

#[test]
fn work_that_does_not_stop_is_left_behind_once_for_each_lane() {
    let (scheduler, woken) = with_threads();
    let (mut first, mut second) = (numbers(&scheduler), numbers(&scheduler));
    let (begun, has_begun) = channel();
    let (work, let_go) = until_let_go(begun.clone());
    first.restart(&1, Priority::Shown, work);
    has_begun.recv().unwrap();
    first.cancel();
    assert_eq!(wait(&mut first, &woken).result, Err(Refusal::Cancelled));
    // Another thread does the work of its lane.
    ask(&mut second, 2);
    assert_eq!(*wait(&mut second, &woken).result.unwrap(), 20);
    // The next is awaited for as long as the first goes on.
    let (work, _held) = until_let_go(begun);
    second.restart(&3, Priority::Shown, work);
    has_begun.recv().unwrap();
    second.cancel();
    let mut quick: Numbers = Memo::new(&scheduler, Lane::Quick, "quick numbers");
    let (begun, quick_has_begun) = channel();
    let (work, _held_too) = until_let_go(begun);
    quick.restart(&4, Priority::Normal, work);
    quick_has_begun.recv().unwrap();
    quick.cancel();
    assert_eq!(wait(&mut quick, &woken).result, Err(Refusal::Cancelled));
    assert!(second.take().is_none() && second.state(&3) == State::Running);
    let_go.send(()).unwrap();
    assert_eq!(wait(&mut second, &woken).result, Err(Refusal::Cancelled));
    assert!(first.take().is_none() && first.state(&1) == State::Cancelled, "what it answers in the end is dropped");
    // Here two threads are still held: the scheduler does not wait for them.
    drop(scheduler);
}

#[test]
fn work_that_writes_is_awaited() {
    let (scheduler, woken) = with_threads();
    let mut writing = numbers(&scheduler).awaiting_the_end();
    let mut quick: Numbers = Memo::new(&scheduler, Lane::Quick, "quick numbers");
    let (begun, has_begun) = channel();
    let (work, let_go) = until_let_go(begun.clone());
    writing.restart(&1, Priority::Shown, work);
    has_begun.recv().unwrap();
    writing.cancel();
    let (work, _held) = until_let_go(begun);
    quick.restart(&2, Priority::Normal, work);
    has_begun.recv().unwrap();
    quick.cancel();
    // This was told later, and is left behind.
    assert_eq!(wait(&mut quick, &woken).result, Err(Refusal::Cancelled));
    assert!(writing.take().is_none() && writing.state(&1) == State::Running);
    let_go.send(()).unwrap();
    assert_eq!(*wait(&mut writing, &woken).result.unwrap(), 1);
}

#[test]
fn running_work_for_an_earlier_key_is_stopped() {
    let (scheduler, woken) = with_threads();
    let mut memo = numbers(&scheduler);
    let (begun, has_begun) = channel();
    memo.ask(&1, Priority::Shown, until_cancelled(begun));
    has_begun.recv().unwrap();
    ask(&mut memo, 2);
    // The one thread of the lane would never come to this if the first work went on.
    assert_eq!(wait(&mut memo, &woken).key, 2);
    assert_eq!(memo.state(&1), State::Stale);
}

#[test]
fn a_preview_comes_to_its_end_and_the_latest_follows_it() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler).letting_finish();
    (1..=3).for_each(|key| drop(ask(&mut memo, key)));
    assert_eq!([1, 2, 3].map(|key| memo.state(&key)), [State::Running, State::Missing, State::Running]);
    run_all(&scheduler);
    assert_eq!(memo.take().unwrap().key, 1);
    run_all(&scheduler);
    assert_eq!(memo.take().unwrap().key, 3);
    assert_eq!((values(&memo), memo.is_busy()), (vec![10, 30], false));
    // Who turns back wants the later one no more.
    (4..=5).for_each(|key| drop(ask(&mut memo, key)));
    memo.turn_to(&4);
    run_all(&scheduler);
    assert!(memo.take().is_some_and(|ended| ended.key == 4) && !memo.is_busy());
}

#[test]
fn a_failure_is_told_once_stays_and_takes_no_value_away() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler);
    make(&scheduler, &mut memo, 1);
    memo.take();
    let fails = |_: &Work<u32>| Err("no room".to_owned());
    memo.ask(&2, Priority::Shown, fails);
    run_all(&scheduler);
    assert_eq!(memo.take().unwrap().result, Err(Refusal::Failed("no room".to_owned())));
    assert_eq!(memo.state(&2), State::Failed("no room".to_owned()));
    assert_eq!((memo.get(&2), memo.last().map(|(of, _)| *of), memo.state(&1)), (None, Some(1), State::Ready));
    // It is not tried again by asking, but after it was resumed.
    assert_eq!(ask(&mut memo, 2), State::Failed("no room".to_owned()));
    assert!(!scheduler.run_next(Lane::Long));
    memo.resume(&2);
    assert_eq!(memo.state(&2), State::Stale);
    make(&scheduler, &mut memo, 2);
    assert_eq!(memo.state(&2), State::Ready);
    memo.take();
    // What is known stays known, whatever became of making it once more; while that runs, it runs.
    memo.restart(&2, Priority::Shown, fails);
    assert_eq!((memo.state(&2), memo.get(&2).map(|v| **v)), (State::Running, Some(20)));
    run_all(&scheduler);
    assert!(memo.take().unwrap().result.is_err());
    assert_eq!(memo.state(&2), State::Ready);
}

#[test]
fn what_the_user_cancels_does_not_begin_again_by_itself() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler);
    ask(&mut memo, 1);
    memo.cancel();
    assert_eq!(memo.take().unwrap().result, Err(Refusal::Cancelled));
    assert_eq!((memo.state(&1), ask(&mut memo, 1)), (State::Cancelled, State::Cancelled));
    assert!(!scheduler.run_next(Lane::Long));
    // Not even after another key was asked for.
    make(&scheduler, &mut memo, 2);
    memo.take();
    assert_eq!(ask(&mut memo, 1), State::Cancelled);
    memo.restart(&1, Priority::Shown, |_| Ok(10));
    run_all(&scheduler);
    assert!(memo.take().is_some() && memo.state(&1) == State::Ready);
    memo.cancel();
    assert_eq!((memo.state(&1), memo.take().is_none()), (State::Ready, true), "nothing ran");
}

#[test]
fn running_work_ends_when_it_is_cancelled_unless_it_had_a_result() {
    let (scheduler, woken) = with_threads();
    let mut memo = numbers(&scheduler);
    let (begun, has_begun) = channel();
    memo.ask(&1, Priority::Shown, until_cancelled(begun.clone()));
    has_begun.recv().unwrap();
    memo.cancel();
    assert_eq!(memo.state(&1), State::Running, "it runs until it has ended");
    assert_eq!(wait(&mut memo, &woken).result, Err(Refusal::Cancelled));
    assert_eq!(memo.state(&1), State::Cancelled);
    let stop = until_cancelled(begun);
    memo.restart(&1, Priority::Shown, move |work| stop(work).or(Ok(7)));
    has_begun.recv().unwrap();
    memo.cancel();
    assert_eq!(wait(&mut memo, &woken).result.map(|v| *v), Ok(7));
    assert_eq!(memo.state(&1), State::Ready);
}

#[test]
fn what_was_found_so_far_is_of_its_own_key_and_ends_with_the_value() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler);
    let finds = |result: Result<u32, String>| {
        move |work: &Work<u32>| {
            work.partial(1);
            work.task.report("half", 0.5, "x");
            work.partial(2);
            result.clone()
        }
    };
    memo.ask(&1, Priority::Shown, finds(Err("lost".to_owned())));
    run_all(&scheduler);
    memo.take();
    assert_eq!((memo.partial(&1), memo.partial(&2)), (Some(&2), None), "how far it came before it failed is known");
    memo.restart(&1, Priority::Shown, finds(Ok(3)));
    assert_eq!(memo.partial(&1), None, "it begins anew");
    run_all(&scheduler);
    memo.take();
    assert_eq!((memo.partial(&1), memo.get(&1).map(|v| **v)), (None, Some(3)));
}

#[test]
fn how_far_work_is_is_told_while_it_runs() {
    let (scheduler, woken) = with_threads();
    let mut memo = numbers(&scheduler);
    let ((go_on, may_go_on), mut said) = (channel(), Vec::new());
    let may_go_on = Mutex::new(may_go_on);
    memo.ask(&1, Priority::Shown, move |work| {
        for (stage, fraction) in [("field", 0.25), ("search", 0.75)] {
            work.task.report(stage, fraction, "");
            work.partial((100.0 * fraction) as u32);
            may_go_on.lock().unwrap().recv().unwrap();
        }
        Ok(1)
    });
    for _ in 0..2 {
        while memo.partial(&1).is_none_or(|found| said.last().is_some_and(|(_, _, last)| last == found)) {
            woken.recv().unwrap();
            memo.turn_to(&1);
        }
        let doing = memo.doing().unwrap();
        assert!(!doing.is_waiting && doing.stage_since >= doing.since);
        said.push((doing.stage.clone(), doing.fraction, *memo.partial(&1).unwrap()));
        go_on.send(()).unwrap();
    }
    assert_eq!(said, [("field".to_owned(), 0.25, 25), ("search".to_owned(), 0.75, 75)]);
    assert!(wait(&mut memo, &woken).result.is_ok());
}

#[test]
fn thousands_of_reports_are_few_wakes() {
    let (scheduler, woken) = with_threads();
    let mut memo = numbers(&scheduler);
    let before = Instant::now();
    memo.ask(&1, Priority::Shown, |work| {
        (0..10_000).for_each(|i| work.task.report("search", f64::from(i) / 1e4, ""));
        Ok(1)
    });
    let mut wakes = 0;
    while memo.take().is_none() {
        woken.recv().unwrap();
        wakes += 1;
    }
    wakes += woken.try_iter().count() as u128;
    // Its begin, its end and its first report, and 20 a second.
    let most = 3 + before.elapsed().as_millis() / 50;
    assert!(wakes <= most, "{wakes} wakes, {most} expected");
}

#[test]
fn so_many_values_are_remembered_and_the_one_asked_for_the_longest_ago_is_forgotten() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler).remembering(2);
    (1..=3).for_each(|key| make(&scheduler, &mut memo, key));
    assert_eq!(values(&memo), [20, 30]);
    // Undo is instant: nothing is worked on. The value is the last one again, and outlives the other.
    assert_eq!((ask(&mut memo, 2), scheduler.run_next(Lane::Long)), (State::Ready, false));
    assert_eq!(memo.last().map(|(of, _)| *of), Some(2));
    make(&scheduler, &mut memo, 4);
    assert_eq!(values(&memo), [20, 40]);
    // Failures take no place of values.
    for key in 5..15 {
        memo.ask(&key, Priority::Shown, |_| Err(String::new()));
        run_all(&scheduler);
    }
    memo.turn_to(&4);
    assert_eq!((values(&memo), memo.state(&14)), (vec![20, 40], State::Failed(String::new())));
    assert_eq!(memo.state(&5), State::Stale, "of failures too there is an end");
}

#[test]
fn a_value_that_was_saved_is_put_back_and_all_is_forgotten_at_once() {
    let scheduler = by_hand();
    let mut memo = numbers(&scheduler);
    memo.put(&1, Arc::new(11));
    assert_eq!((ask(&mut memo, 1), memo.get(&1).map(|v| **v)), (State::Ready, Some(11)));
    ask(&mut memo, 2);
    memo.clear();
    run_all(&scheduler);
    assert!(memo.take().is_none() && !memo.is_busy());
    assert_eq!((memo.state(&1), memo.state(&2)), (State::Missing, State::Missing));
}

#[test]
fn a_panic_fails_its_own_work_and_the_thread_goes_on() {
    let (scheduler, woken) = with_threads();
    let mut memo = numbers(&scheduler);
    memo.ask(&1, Priority::Shown, |_| panic!("on purpose"));
    let Err(Refusal::Failed(why)) = wait(&mut memo, &woken).result else { panic!("it did not fail") };
    assert!(why.starts_with("internal error: on purpose; please report it"), "{why}");
    ask(&mut memo, 2);
    assert_eq!(wait(&mut memo, &woken).result.map(|v| *v), Ok(20));
}

#[test]
fn the_higher_priority_comes_first_and_of_equals_the_earlier() {
    const PRIORITIES: [Priority; 3] = [Priority::Background, Priority::Normal, Priority::Shown];
    for code in 0..81 {
        let given = [1, 3, 9, 27].map(|place| PRIORITIES[code / place % 3]);
        let (scheduler, order) = (by_hand(), Arc::new(Mutex::new(Vec::new())));
        let mut memos: Vec<Numbers> = given.iter().map(|_| numbers(&scheduler)).collect();
        for (i, memo) in memos.iter_mut().enumerate() {
            let order = order.clone();
            // Half of them are given their priority afterwards.
            let first = if i % 2 == 0 { given[i] } else { Priority::Normal };
            memo.ask(&0, first, move |_| {
                order.lock().unwrap().push(i);
                Ok(0)
            });
            memo.prioritise(given[i]);
        }
        run_all(&scheduler);
        let mut expected = vec![0, 1, 2, 3];
        expected.sort_by_key(|&i| std::cmp::Reverse(given[i]));
        assert_eq!(*order.lock().unwrap(), expected, "{given:?}");
    }
}

#[test]
fn quick_work_does_not_wait_for_long_work() {
    let scheduler = by_hand();
    let (mut long, mut quick) = (numbers(&scheduler), Memo::new(&scheduler, Lane::Quick, "preview"));
    ask(&mut quick, 1);
    ask(&mut long, 1);
    // The thread of quick work does nothing else; that of long work helps when it has nothing else to do.
    assert!(scheduler.run_next(Lane::Quick) && quick.take().is_some() && !scheduler.run_next(Lane::Quick));
    ask(&mut quick, 2);
    assert!(scheduler.run_next(Lane::Long) && quick.take().is_none() && long.take().is_some());
    assert!(scheduler.run_next(Lane::Long) && quick.take().is_some());

    let (scheduler, woken) = with_threads();
    let (mut long, mut quick) = (numbers(&scheduler), Memo::new(&scheduler, Lane::Quick, "preview"));
    let (begun, has_begun) = channel();
    long.ask(&1, Priority::Shown, until_cancelled(begun));
    has_begun.recv().unwrap();
    ask(&mut quick, 1);
    assert!(wait(&mut quick, &woken).result.is_ok() && long.state(&1) == State::Running);
}

#[test]
fn what_is_more_wanted_is_done_in_the_midst_of_other_work_where_that_reports() {
    let (scheduler, woken) = with_threads();
    let (mut ahead, mut wanted, mut later) = (numbers(&scheduler), numbers(&scheduler), numbers(&scheduler));
    let (begun, has_begun) = channel();
    let (go_on, may_go_on) = channel::<()>();
    let order = Arc::new(Mutex::new(Vec::new()));
    let noted = |order: &Arc<Mutex<Vec<u32>>>| {
        let order = order.clone();
        move |step: u32| order.lock().unwrap().push(step)
    };
    let note = noted(&order);
    ahead.ask(&1, Priority::Normal, move |work| {
        note(1);
        begun.send(()).unwrap();
        may_go_on.recv().unwrap();
        // What is asked of a thread of the pool is answered there: nothing is done in its midst.
        rayon::scope(|scope| scope.spawn(|_| work.task.report("pool", 0.2, "")));
        note(2);
        work.task.report("half", 0.5, "");
        note(4);
        Ok(1)
    });
    has_begun.recv().unwrap();
    let (note_wanted, note_later) = (noted(&order), noted(&order));
    later.ask(&1, Priority::Normal, move |_| {
        note_later(5);
        Ok(3)
    });
    wanted.ask(&1, Priority::Shown, move |work| {
        // What is of the same priority, or of a lower one, waits.
        work.task.report("all", 1.0, "");
        note_wanted(3);
        Ok(2)
    });
    go_on.send(()).unwrap();
    assert_eq!(wait(&mut wanted, &woken).result.map(|v| *v), Ok(2));
    assert_eq!(wait(&mut ahead, &woken).result.map(|v| *v), Ok(1), "nothing of it was lost");
    assert_eq!(wait(&mut later, &woken).result.map(|v| *v), Ok(3));
    assert_eq!(*order.lock().unwrap(), [1, 2, 3, 4, 5]);
}

#[test]
fn what_is_cancelled_in_the_midst_of_other_work_leaves_that_alone_and_the_other_way_round() {
    let (scheduler, woken) = with_threads();
    for is_outer in [false, true] {
        let (mut outer, mut inner) = (numbers(&scheduler), numbers(&scheduler));
        let (begun, has_begun) = channel();
        let (go_on, may_go_on) = channel::<()>();
        let begins = begun.clone();
        outer.ask(&1, Priority::Normal, move |work| {
            begins.send(()).unwrap();
            may_go_on.recv().unwrap();
            work.task.report("half", 0.5, "");
            work.task.check().map(|()| 1).map_err(|e| e.to_string())
        });
        has_begun.recv().unwrap();
        inner.ask(&1, Priority::Shown, until_cancelled(begun));
        go_on.send(()).unwrap();
        has_begun.recv().unwrap();
        if is_outer {
            outer.cancel();
        }
        inner.cancel();
        assert_eq!(wait(&mut inner, &woken).result, Err(Refusal::Cancelled));
        let expected = if is_outer { Err(Refusal::Cancelled) } else { Ok(1) };
        assert_eq!(wait(&mut outer, &woken).result.map(|v| *v), expected);
    }
}

struct Leaves(Arc<AtomicUsize>);

impl Drop for Leaves {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }
}

thread_local! {
    static MARK: RefCell<Option<Leaves>> = const { RefCell::new(None) };
}

#[test]
fn dropping_stops_the_work_and_ends_the_threads() {
    let (scheduler, _) = with_threads();
    let left = Arc::new(AtomicUsize::new(0));
    let (begun, has_begun) = channel();
    let mut memos = Vec::new();
    for lane in [Lane::Long, Lane::Quick] {
        for i in 0..20 {
            let (left, until) = (left.clone(), until_cancelled(begun.clone()));
            let mut memo: Numbers = Memo::new(&scheduler, lane, "numbers");
            memo.ask(&i, Priority::Shown, move |work| {
                MARK.with(|mark| drop(mark.replace(Some(Leaves(left.clone())))));
                until(work)
            });
            memos.push(memo);
        }
    }
    // Two run, whatever is asked.
    (0..2).for_each(|_| has_begun.recv().unwrap());
    assert!(has_begun.try_recv().is_err() && left.load(Ordering::SeqCst) == 0);
    drop(scheduler);
    assert_eq!(left.load(Ordering::SeqCst), 2, "both threads have ended");
    for memo in &mut memos {
        assert_eq!(memo.take().unwrap().result, Err(Refusal::Cancelled));
    }
    // Nobody is there to do what is asked from now on.
    memos[0].restart(&50, Priority::Shown, |_| Ok(1));
    assert_eq!(memos[0].take().unwrap().result, Err(Refusal::Cancelled));
}

#[test]
fn a_memo_that_is_dropped_leaves_its_thread_to_others() {
    let (scheduler, woken) = with_threads();
    let (mut first, mut second) = (numbers(&scheduler), numbers(&scheduler));
    let (begun, has_begun) = channel();
    first.ask(&1, Priority::Shown, until_cancelled(begun));
    has_begun.recv().unwrap();
    ask(&mut second, 1);
    drop(first);
    assert!(wait(&mut second, &woken).result.is_ok());
}

#[test]
fn a_shared_value_is_the_same_as_itself_alone() {
    let (a, b) = (Arc::new(1), Arc::new(1));
    assert!(Same(a.clone()) == Same(a.clone()) && Same(a) != Same(b));
}

/// Whatever is asked, cancelled and run in whatever order: a value is that of its key, no more are remembered than may
/// be, one piece of work at most is under way, and in the end nothing is.
#[test]
fn laws_that_hold_after_any_history() {
    let mut seed = 1_u64;
    let mut below = move |n: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % n
    };
    for history in 0..300 {
        let (scheduler, is_preview) = (by_hand(), history % 2 == 1);
        let mut memo = numbers(&scheduler).remembering(3);
        if is_preview {
            memo = memo.letting_finish();
        }
        for _ in 0..60 {
            let key = below(6) as u32;
            let work = move |_: &Work<u32>| if key == 5 { Err("five".to_owned()) } else { Ok(10 * key) };
            match below(9) {
                8 => memo.stop(),
                0 | 1 => drop(memo.ask(&key, Priority::Normal, work)),
                2 => memo.restart(&key, Priority::Shown, work),
                3 => memo.cancel(),
                4 => memo.turn_to(&key),
                5 => memo.resume(&key),
                _ => drop(scheduler.run_next(Lane::Long)),
            }
            let running = (0..6).filter(|key| memo.state(key) == State::Running).count();
            assert!(running <= 1 + usize::from(is_preview) && (running > 0) == memo.is_busy());
            for key in 0..6 {
                let value = memo.get(&key).map(|v| **v);
                assert!(value.is_none_or(|v| v == 10 * key && key != 5));
                let state = memo.state(&key);
                assert!(state != State::Ready || value.is_some());
                assert!(value.is_none() || matches!(state, State::Ready | State::Running));
                assert!(state != State::Missing || memo.last().is_none());
                assert!(state != State::Stale || memo.last().is_some_and(|(of, _)| *of != key));
            }
            assert!(values(&memo).len() <= 3);
        }
        while memo.take().is_some() || scheduler.run_next(Lane::Long) {}
        assert!(!memo.is_busy() && (0..6).all(|key| memo.state(&key) != State::Running));
    }
}

/// Long work that keeps every thread of the pool busy must not keep the parallel loops of quick work waiting.
#[test]
fn quick_work_ends_while_long_work_has_the_whole_pool() {
    use rayon::prelude::*;
    use std::sync::atomic::AtomicBool;

    /// Looks at a flag before a thread gives up: far more than quick work takes.
    const MOST: usize = 1 << 31;
    let (scheduler, woken) = with_threads();
    let mut long: Memo<u32, bool, u32> = Memo::new(&scheduler, Lane::Long, "long");
    let mut quick: Memo<u32, u32, u32> = Memo::new(&scheduler, Lane::Quick, "quick");
    let is_over = Arc::new(AtomicBool::new(false));
    let (begun, begins) = channel();
    let seen = is_over.clone();
    long.ask(&1, Priority::Normal, move |_| {
        let begun = Mutex::new(begun);
        let until_over = |_| {
            begun.lock().unwrap().send(()).unwrap_or(());
            (0..MOST).any(|_| seen.load(Ordering::Acquire))
        };
        Ok((0..rayon::current_num_threads()).into_par_iter().with_max_len(1).all(until_over))
    });
    (0..rayon::current_num_threads()).for_each(|_| begins.recv().unwrap());
    quick.ask(&1, Priority::Shown, |_| Ok((0..1000u32).into_par_iter().sum()));
    assert_eq!(wait(&mut quick, &woken).result.map(|sum| *sum), Ok(499_500));
    is_over.store(true, Ordering::Release);
    assert_eq!(wait(&mut long, &woken).result.map(|is_met| *is_met), Ok(true), "the quick work ended first");
}

/// A thread that does quick work must not begin a plan in its midst: the quick work would wait for all of that.
#[test]
fn no_long_work_is_done_in_the_midst_of_quick_work() {
    let scheduler = by_hand();
    let mut quick: Memo<u32, u32, u32> = Memo::new(&scheduler, Lane::Quick, "quick");
    let mut long = numbers(&scheduler);
    let order = Arc::new(Mutex::new(Vec::new()));
    let [first, last, other] = [order.clone(), order.clone(), order.clone()];
    quick.ask(&1, Priority::Background, move |work| {
        first.lock().unwrap().push("quick begins");
        work.task.report("half", 0.5, "");
        last.lock().unwrap().push("quick ends");
        Ok(1)
    });
    assert!(scheduler.run_next(Lane::Quick) && quick.take().is_some());
    quick.restart(&2, Priority::Background, |work| {
        work.task.report("half", 0.5, "");
        Ok(2)
    });
    long.ask(&1, Priority::Shown, move |_| {
        other.lock().unwrap().push("long");
        Ok(1)
    });
    assert!(scheduler.run_next(Lane::Quick), "the quick work ends by itself");
    assert_eq!(*order.lock().unwrap(), ["quick begins", "quick ends"]);
    run_all(&scheduler);
    assert_eq!(order.lock().unwrap().last(), Some(&"long"));
}
