//! The threads that all [memos](crate::Memo) of the program share; [`Scheduler`] explains how.

use std::cell::Cell;
use std::cmp::Reverse;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use crate::Cancel;

/// Thread that work runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Work of at most a few seconds: reading and writing files, previews, colours.
    Quick,
    /// Longer work: plans, simulations, searches for uncut regions.
    Long,
}

impl Lane {
    fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick work",
            Self::Long => "long work",
        }
    }
}

/// Time for which work may go on after it was told to stop, before its thread is left behind.
const PATIENCE: Duration = Duration::from_millis(100);

/// Priority of work within a lane, over waiting and running work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// Work in the background, such as a table of sizes.
    Background,
    /// Work for what is not visible at the moment, such as the plan of a workspace that is not shown.
    Normal,
    /// Work for what the user looks at.
    Shown,
}

/// A piece of work.
pub(crate) trait Job: Send {
    /// Runs until the work is done or cancelled.
    fn run(self: Box<Self>, cancel: &Cancel);
    /// Notes that there will be no result.
    fn give_up(self: Box<Self>);
    /// What notes that there will be no result of work that does not stop when it is told to; none of work that must not
    /// be left behind.
    fn leave(&self) -> Option<Leave>;
}

/// Notes that work is left behind.
pub(crate) type Leave = Box<dyn FnOnce() + Send>;

/// The number of a job, rising.
pub(crate) type JobId = u64;

struct Waiting {
    id: JobId,
    lane: Lane,
    priority: Priority,
    job: Box<dyn Job>,
}

struct Running {
    id: JobId,
    /// Number of the thread that it runs on.
    thread: u64,
    priority: Priority,
    cancel: Cancel,
    leave: Option<Leave>,
    /// When it is left behind, of work that was told to stop.
    due: Option<Instant>,
}

/// A thread that serves a lane.
struct Serving {
    number: u64,
    lane: Lane,
    thread: JoinHandle<()>,
}

thread_local! {
    /// The lane of this thread and the job that it is in the midst of.
    static HERE: Cell<Option<(Lane, JobId)>> = const { Cell::new(None) };
    /// Number of this thread; 0 of one that serves no lane.
    static NUMBER: Cell<u64> = const { Cell::new(0) };
}

#[derive(Default)]
struct Jobs {
    waiting: Vec<Waiting>,
    running: Vec<Running>,
    submitted: JobId,
    serving: Vec<Serving>,
    /// Threads that were left behind in the midst of work, and their lanes.
    left: Vec<(u64, Lane)>,
    threads: u64,
    /// Whether the thread of long work is at work; none without threads.
    is_long_busy: Option<bool>,
    is_closed: bool,
}

impl Jobs {
    /// Takes out the next job of `lane`, if its priority is higher than `than`.
    fn next(&mut self, lane: Lane, than: Option<Priority>) -> Option<(Waiting, Cancel)> {
        let is_shown = |w: &Waiting| w.priority == Priority::Shown;
        let is_mine = |w: &Waiting| match (w.lane, lane) {
            (Lane::Long, _) => lane == Lane::Long,
            // While the thread of long work is free, it does what the user looks at, and nothing else that is quick.
            (Lane::Quick, Lane::Long) => self.is_long_busy.is_none() || is_shown(w),
            (Lane::Quick, Lane::Quick) => self.is_long_busy != Some(false) || !is_shown(w),
        };
        let can_take = |w: &Waiting| is_mine(w) && Some(w.priority) > than;
        let order = |w: &Waiting| (w.lane == lane, w.priority, Reverse(w.id));
        let (i, _) = self.waiting.iter().enumerate().filter(|(_, w)| can_take(w)).max_by_key(|(_, w)| order(w))?;
        let (taken, cancel) = (self.waiting.remove(i), Cancel::default());
        self.running.push(Running {
            id: taken.id,
            thread: NUMBER.get(),
            priority: taken.priority,
            cancel: cancel.clone(),
            leave: taken.job.leave(),
            due: None,
        });
        Some((taken, cancel))
    }

    /// Whether the thread with this number was left behind.
    fn is_left(&self, number: u64) -> bool {
        self.left.iter().any(|(left, _)| *left == number)
    }

    /// The lane of work that is due to be left behind. There is at most one thread of each lane that was, so that work
    /// which is told to stop again and again does not take up the machine.
    fn lane_left_by(&self, work: &Running) -> Option<Lane> {
        let lane = self.serving.iter().find(|serving| serving.number == work.thread)?.lane;
        (work.leave.is_some() && self.left.iter().all(|(_, left)| *left != lane)).then_some(lane)
    }
}

/// Shared state of scheduler, threads and memos.
pub(crate) struct Queue {
    jobs: Mutex<Jobs>,
    changed: Condvar,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Jobs> {
        // No work is done under the lock, so that what it guards is never half changed.
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes the program to take in news.
    pub(crate) fn wake(&self) {
        (self.wake)();
    }

    pub(crate) fn submit(&self, lane: Lane, priority: Priority, job: Box<dyn Job>) -> JobId {
        let mut jobs = self.lock();
        jobs.submitted += 1;
        let id = jobs.submitted;
        if jobs.is_closed {
            drop(jobs);
            job.give_up();
            return id;
        }
        jobs.waiting.push(Waiting { id, lane, priority, job });
        drop(jobs);
        self.changed.notify_all();
        id
    }

    /// Gives a job another priority.
    pub(crate) fn prioritise(&self, id: JobId, priority: Priority) {
        let mut jobs = self.lock();
        jobs.waiting.iter_mut().filter(|w| w.id == id).for_each(|w| w.priority = priority);
        jobs.running.iter_mut().filter(|r| r.id == id).for_each(|r| r.priority = priority);
        drop(jobs);
        self.changed.notify_all();
    }

    /// Stops a job for good.
    pub(crate) fn cancel(&self, id: JobId) {
        let mut jobs = self.lock();
        let gone = jobs.waiting.iter().position(|w| w.id == id).map(|i| jobs.waiting.remove(i));
        for running in jobs.running.iter_mut().filter(|r| r.id == id) {
            running.cancel.cancel();
            running.due.get_or_insert_with(|| Instant::now() + PATIENCE);
        }
        drop(jobs);
        self.changed.notify_all();
        if let Some(gone) = gone {
            gone.job.give_up();
        }
    }

    /// Runs waiting work of a higher priority within the present work of this thread.
    pub(crate) fn let_pass(&self) {
        let Some((lane, id)) = HERE.get() else { return };
        loop {
            let mut jobs = self.lock();
            if jobs.is_left(NUMBER.get()) {
                return;
            }
            let here = jobs.running.iter().find(|r| r.id == id && !r.cancel.is_cancelled());
            let Some(than) = here.map(|r| r.priority) else { return };
            let Some((taken, cancel)) = jobs.next(lane, Some(than)) else { return };
            drop(jobs);
            self.run(taken, &cancel);
        }
    }

    fn run(&self, taken: Waiting, cancel: &Cancel) {
        // By its own lane: no long work is done in the midst of quick work.
        let before = HERE.replace(Some((taken.lane, taken.id)));
        taken.job.run(cancel);
        HERE.set(before);
        self.lock().running.retain(|r| r.id != taken.id);
        self.changed.notify_all();
    }

    /// Starts a thread that serves `lane`.
    fn start(self: &Arc<Self>, jobs: &mut Jobs, lane: Lane) -> io::Result<()> {
        jobs.threads += 1;
        let (queue, number) = (self.clone(), jobs.threads);
        let serve = move || {
            NUMBER.set(number);
            // A pool of this thread alone: parallel loops of quick work run here, one after the other.
            let _alone = (lane == Lane::Quick)
                .then(|| rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build());
            queue.serve(lane);
            queue.lock().left.retain(|(left, _)| *left != number);
            queue.changed.notify_all();
        };
        let thread = Builder::new().name(lane.name().to_owned()).spawn(serve)?;
        jobs.serving.push(Serving { number, lane, thread });
        Ok(())
    }

    /// Leaves threads behind whose work does not stop although it was told to, and has others serve their lanes.
    fn watch(self: &Arc<Self>) {
        let mut jobs = self.lock();
        while !jobs.is_closed {
            let due = |(i, work): (usize, &Running)| Some((work.due?, i, jobs.lane_left_by(work)?));
            let first = jobs.running.iter().enumerate().filter_map(due).min_by_key(|(due, ..)| *due);
            let Some((due, i, lane)) = first else {
                jobs = self.changed.wait(jobs).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let time = due.saturating_duration_since(Instant::now());
            if !time.is_zero() {
                jobs = self.changed.wait_timeout(jobs, time).unwrap_or_else(PoisonError::into_inner).0;
                continue;
            }
            if self.start(&mut jobs, lane).is_err() {
                // Without another thread the lane waits for this one.
                jobs.running[i].due = None;
                continue;
            }
            let work = jobs.running.remove(i);
            jobs.serving.retain(|serving| serving.number != work.thread);
            jobs.left.push((work.thread, lane));
            if lane == Lane::Long {
                jobs.is_long_busy = Some(false);
            }
            drop(jobs);
            work.leave.into_iter().for_each(|leave| leave());
            jobs = self.lock();
        }
    }

    fn serve(&self, lane: Lane) {
        let mut jobs = self.lock();
        while !jobs.is_closed && !jobs.is_left(NUMBER.get()) {
            jobs = match jobs.next(lane, None) {
                Some((taken, cancel)) => {
                    if lane == Lane::Long {
                        jobs.is_long_busy = Some(true);
                    }
                    drop(jobs);
                    self.changed.notify_all();
                    self.run(taken, &cancel);
                    let mut jobs = self.lock();
                    if lane == Lane::Long && !jobs.is_left(NUMBER.get()) {
                        jobs.is_long_busy = Some(false);
                    }
                    jobs
                }
                None => self.changed.wait(jobs).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }
}

/// Runs the work of all memos. Dropping the scheduler stops the work and waits for the end of its threads, but for work
/// that does not stop; later requests to a memo count as cancelled.
///
/// **How many threads.** Heavy work is parallel inside, on rayon's pool, which has one thread for each core. The code
/// that starts such work only waits for the pool, so two more threads suffice: one for each [`Lane`]. A third one, which
/// sleeps, watches over them: work that goes on for 0.1 s after it was told to stop, as in a library that looks at no flag
/// or on a drive that does not answer, counts as cancelled, and another thread takes the place of its own. The program has
/// cores + 3 threads, however many memos there are, and at most one for each lane that was left behind. Work does not start on rayon's own threads: a thread of the pool
/// that waits for a part of a preview could take up a whole plan and delay the preview until the plan is done.
///
/// **Which work comes first.** Quick work never waits for long work. While the thread of long work is free, this thread
/// does the quick work that the user looks at, on all cores. All other quick work is done by its own thread, without
/// rayon's pool: work given to the pool waits until long work leaves a thread free, which may take seconds. Within a
/// lane the higher [`Priority`] comes first, and among equals the work submitted first. Running work lets work of a
/// higher priority pass whenever it reports [`Progress`](crate::Progress) on the thread of its lane, which happens
/// between parallel stages. Work must therefore hold no lock while it reports.
pub struct Scheduler {
    queue: Arc<Queue>,
    watching: Option<JoinHandle<()>>,
}

impl Scheduler {
    /// Starts a thread for each lane, and names the threads of rayon's pool ("pool 0") unless the pool exists already.
    /// `wake` is called from any thread whenever a memo has news to [take in](crate::Memo::take).
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> io::Result<Self> {
        let mut scheduler = Self::manual(wake);
        // A pool that stands already does as well.
        let _ = rayon::ThreadPoolBuilder::new().thread_name(|i| format!("pool {i}")).build_global();
        let queue = scheduler.queue.clone();
        let mut jobs = queue.lock();
        jobs.is_long_busy = Some(false);
        for lane in [Lane::Quick, Lane::Long] {
            queue.start(&mut jobs, lane)?;
        }
        drop(jobs);
        scheduler.watching = Some(Builder::new().name("watch over work".to_owned()).spawn(move || queue.watch())?);
        Ok(scheduler)
    }

    /// A scheduler without threads, for tests: [`run_next`](Self::run_next) does the work.
    pub fn manual(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let queue = Queue { jobs: Mutex::default(), changed: Condvar::new(), wake: Box::new(wake) };
        Self { queue: Arc::new(queue), watching: None }
    }

    /// Runs the next job of `lane` here. Returns whether there was one.
    pub fn run_next(&self, lane: Lane) -> bool {
        let next = self.queue.lock().next(lane, None);
        let is_any = next.is_some();
        if let Some((taken, cancel)) = next {
            self.queue.run(taken, &cancel);
        }
        is_any
    }

    pub(crate) fn queue(&self) -> Arc<Queue> {
        self.queue.clone()
    }
}

impl Drop for Scheduler {
    fn drop(&mut self) {
        let mut jobs = self.queue.lock();
        jobs.is_closed = true;
        jobs.running.iter().for_each(|running| running.cancel.cancel());
        let gone = std::mem::take(&mut jobs.waiting);
        drop(jobs);
        self.queue.changed.notify_all();
        gone.into_iter().for_each(|waiting| waiting.job.give_up());
        // Panics of work are caught where it is run.
        self.watching.take().map(JoinHandle::join);
        let jobs = self.queue.lock();
        let goes_on = |jobs: &mut Jobs| jobs.running.iter().any(|work| work.leave.is_some());
        let waited = self.queue.changed.wait_timeout_while(jobs, PATIENCE, goes_on);
        let mut jobs = waited.unwrap_or_else(PoisonError::into_inner).0;
        let stuck: Vec<u64> = jobs.running.iter().filter(|w| w.leave.is_some()).map(|work| work.thread).collect();
        let serving = std::mem::take(&mut jobs.serving);
        drop(jobs);
        for serving in serving.into_iter().filter(|serving| !stuck.contains(&serving.number)) {
            let _ = serving.thread.join();
        }
    }
}
