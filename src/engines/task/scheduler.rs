//! Two threads that all [memos](crate::Memo) of the program share; how they are shared is told at [`Scheduler`].

use std::cmp::Reverse;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::Cancel;

/// Which thread work is done on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// At most a few seconds: files that are read or written, a preview while a slider moves, colours.
    Quick,
    /// Anything longer: plans, simulations, searches for what is left uncut.
    Long,
}

/// What comes first among the work that waits in a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// Made before anybody asks for it. Gives way to all other work of its lane even while it runs, and begins again.
    Background,
    /// Wanted, but not seen at the moment, such as the plan of a workspace that is not shown.
    Normal,
    /// What the user looks at.
    Shown,
}

/// Work as the scheduler sees it.
pub(crate) trait Job: Send {
    /// Works. Answers false if it was told to stop before there was a result; it may be run again then.
    fn run(&mut self, cancel: &Cancel) -> bool;
    /// Takes note that there will be no result.
    fn give_up(&mut self);
}

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
    lane: Lane,
    priority: Priority,
    cancel: Cancel,
    /// Whether it is stopped for good, and not to begin again.
    is_given_up: bool,
}

#[derive(Default)]
struct Jobs {
    waiting: Vec<Waiting>,
    running: Vec<Running>,
    submitted: JobId,
    is_closed: bool,
}

impl Jobs {
    /// Takes out what the thread of `lane` does next.
    fn next(&mut self, lane: Lane) -> Option<(Waiting, Cancel)> {
        let can_take = |w: &Waiting| lane == Lane::Long || w.lane == Lane::Quick;
        let order = |w: &Waiting| (w.lane == lane, w.priority, Reverse(w.id));
        let (i, _) = self.waiting.iter().enumerate().filter(|(_, w)| can_take(w)).max_by_key(|(_, w)| order(w))?;
        let (taken, cancel) = (self.waiting.remove(i), Cancel::default());
        let Waiting { id, lane, priority, .. } = taken;
        self.running.push(Running { id, lane, priority, cancel: cancel.clone(), is_given_up: false });
        Some((taken, cancel))
    }

    /// Stops running work of the lowest priority in a lane where other work waits.
    fn make_way(&self) {
        for waiting in self.waiting.iter().filter(|w| w.priority > Priority::Background) {
            let gives_way = |r: &&Running| r.lane == waiting.lane && r.priority == Priority::Background;
            self.running.iter().filter(gives_way).for_each(|r| r.cancel.cancel());
        }
    }
}

/// What scheduler, threads and memos share.
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

    /// Tells the program that there is something new.
    pub(crate) fn wake(&self) {
        (self.wake)();
    }

    pub(crate) fn submit(&self, lane: Lane, priority: Priority, mut job: Box<dyn Job>) -> JobId {
        let mut jobs = self.lock();
        jobs.submitted += 1;
        let id = jobs.submitted;
        if jobs.is_closed {
            drop(jobs);
            job.give_up();
            return id;
        }
        jobs.waiting.push(Waiting { id, lane, priority, job });
        jobs.make_way();
        drop(jobs);
        self.changed.notify_all();
        id
    }

    /// Gives a job another priority.
    pub(crate) fn prioritise(&self, id: JobId, priority: Priority) {
        let mut jobs = self.lock();
        jobs.waiting.iter_mut().filter(|w| w.id == id).for_each(|w| w.priority = priority);
        jobs.running.iter_mut().filter(|r| r.id == id).for_each(|r| r.priority = priority);
        jobs.make_way();
    }

    /// Stops a job for good.
    pub(crate) fn cancel(&self, id: JobId) {
        let mut jobs = self.lock();
        let gone = jobs.waiting.iter().position(|w| w.id == id).map(|i| jobs.waiting.remove(i));
        for running in jobs.running.iter_mut().filter(|r| r.id == id) {
            running.is_given_up = true;
            running.cancel.cancel();
        }
        drop(jobs);
        if let Some(mut gone) = gone {
            gone.job.give_up();
        }
    }

    fn run(&self, mut taken: Waiting, cancel: &Cancel) {
        let has_ended = taken.job.run(cancel);
        let mut jobs = self.lock();
        let Some(i) = jobs.running.iter().position(|r| r.id == taken.id) else { return };
        let running = jobs.running.swap_remove(i);
        if has_ended {
            return;
        }
        if running.is_given_up || jobs.is_closed {
            drop(jobs);
            taken.job.give_up();
        } else {
            jobs.waiting.push(Waiting { priority: running.priority, ..taken });
            drop(jobs);
            self.changed.notify_all();
        }
    }

    fn serve(&self, lane: Lane) {
        let mut jobs = self.lock();
        while !jobs.is_closed {
            jobs = match jobs.next(lane) {
                Some((taken, cancel)) => {
                    drop(jobs);
                    self.run(taken, &cancel);
                    self.lock()
                }
                None => self.changed.wait(jobs).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }
}

/// Does the work of all memos. Dropping it stops what runs and waits for the end of its threads; what is asked of a memo
/// after that counts as cancelled.
///
/// **How many threads.** Heavy work is parallel inside, on the pool of rayon, which has one thread for each core. What
/// starts such work only waits for it, so that two more threads are enough: one for each [`Lane`]. Together cores + 2
/// threads stand, however many memos there are. Work is not started on rayon's own threads: one of them that waits for a
/// part of a preview could steal a whole plan and keep the preview until that is made.
///
/// **Who comes first.** Quick work never waits for long work: it has a thread of its own, and that of the long lane too
/// while no long work waits. Within a lane the higher [`Priority`] comes first, and of equals the one that was submitted
/// first. Running work of the lowest priority gives way: it is stopped when other work of its lane waits, and
/// begins again later.
pub struct Scheduler {
    queue: Arc<Queue>,
    threads: Vec<JoinHandle<()>>,
}

impl Scheduler {
    /// Starts a thread for each lane. `wake` is called from any thread whenever there is something for a memo to
    /// [take in](crate::Memo::take).
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let mut scheduler = Self::manual(wake);
        for (lane, name) in [(Lane::Quick, "quick work"), (Lane::Long, "long work")] {
            let queue = scheduler.queue.clone();
            let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || queue.serve(lane))?;
            scheduler.threads.push(thread);
        }
        Ok(scheduler)
    }

    /// Without threads, for tests: work is done by [`run_next`](Self::run_next).
    pub fn manual(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let queue = Queue { jobs: Mutex::default(), changed: Condvar::new(), wake: Box::new(wake) };
        Self { queue: Arc::new(queue), threads: Vec::new() }
    }

    /// Does here what the thread of `lane` would do next. Answers whether there was anything to do.
    pub fn run_next(&self, lane: Lane) -> bool {
        let next = self.queue.lock().next(lane);
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
        for running in &mut jobs.running {
            running.is_given_up = true;
            running.cancel.cancel();
        }
        let gone = std::mem::take(&mut jobs.waiting);
        drop(jobs);
        self.queue.changed.notify_all();
        gone.into_iter().for_each(|mut waiting| waiting.job.give_up());
        for thread in self.threads.drain(..) {
            // Panics of work are caught where it is run.
            let _ = thread.join();
        }
    }
}
