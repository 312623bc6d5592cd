//! The thread that long work runs on.
//!
//! One task runs at a time; the rest wait in a queue. A task that asks for what an earlier one was already asked for
//! takes its place, so that while a slider moves only the latest position is worked on (latest wins). A panic in a
//! task ends that task with an error and nothing else.

use std::panic::AssertUnwindSafe;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use task::{Cancel, Progress};

/// The number of a task, rising.
pub type TaskId = u64;

/// What the worker says about a task. `P` is a partial result, `T` the final one.
#[derive(Debug)]
pub enum Message<P, T> {
    /// It has begun.
    Started(TaskId),
    /// Where it stands.
    Progress {
        /// Which task.
        task: TaskId,
        /// What is being done.
        stage: String,
        /// How much of the stage is done, 0 to 1.
        fraction: f64,
        /// Detail, may be empty.
        message: String,
    },
    /// What it has found so far.
    Partial(TaskId, P),
    /// It has ended.
    Finished(TaskId, Ended<T>),
}

impl<P, T> Message<P, T> {
    /// The task that it is about.
    pub fn task(&self) -> TaskId {
        match self {
            Self::Started(task) | Self::Progress { task, .. } | Self::Partial(task, _) | Self::Finished(task, _) => {
                *task
            }
        }
    }
}

/// How a task ended.
#[derive(Debug)]
pub enum Ended<T> {
    /// With this result.
    Done(T),
    /// It stopped when told to, by the user or because a later task took its place.
    Cancelled,
    /// It could not be done: one line for the user.
    Failed(String),
    /// It broke: the program's own fault, in words.
    Panicked(String),
}

/// What a task reports to while it works.
pub struct Reporter<P, T> {
    task: TaskId,
    sender: Sender<Message<P, T>>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl<P: Send + 'static, T: Send + 'static> Reporter<P, T> {
    /// Says what has been found so far.
    pub fn partial(&self, found: P) {
        self.send(Message::Partial(self.task, found));
    }

    fn send(&self, message: Message<P, T>) {
        // Nobody listens any more only while the program ends.
        if self.sender.send(message).is_ok() {
            (self.wake)();
        }
    }
}

/// What a task does. An error is one line for the user.
pub type Work<P, T> = dyn FnOnce(&Reporter<P, T>, &task::Task) -> Result<T, String> + Send;

struct Task<P, T> {
    id: TaskId,
    slot: u32,
    work: Box<Work<P, T>>,
    cancel: Cancel,
}

struct Queue<P, T> {
    waiting: Vec<Task<P, T>>,
    running: Option<(TaskId, u32, Cancel)>,
    closed: bool,
}

struct Shared<P, T> {
    queue: Mutex<Queue<P, T>>,
    changed: Condvar,
}

impl<P, T> Shared<P, T> {
    fn lock(&self) -> MutexGuard<'_, Queue<P, T>> {
        // The queue is never left half changed: a poisoned lock is as good as any.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The worker thread with its queue. Dropping it cancels what runs and waits for its end.
pub struct Worker<P, T> {
    shared: Arc<Shared<P, T>>,
    messages: Receiver<Message<P, T>>,
    sender: Sender<Message<P, T>>,
    thread: Option<JoinHandle<()>>,
    next: TaskId,
}

impl<P: Send + 'static, T: Send + 'static> Worker<P, T> {
    /// Starts the thread. `wake` is called from it whenever there is a message.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let queue = Queue { waiting: Vec::new(), running: None, closed: false };
        let shared = Arc::new(Shared { queue: Mutex::new(queue), changed: Condvar::new() });
        let (sender, messages) = channel();
        let (theirs, to_us, wake) = (shared.clone(), sender.clone(), Arc::new(wake));
        let thread = std::thread::Builder::new()
            .name("worker".to_owned())
            .spawn(move || serve(&theirs, &to_us, &(wake as Arc<dyn Fn() + Send + Sync>)))?;
        Ok(Self { shared, messages, sender, thread: Some(thread), next: 1 })
    }

    /// Queues work. Whatever waits or runs in the same `slot` or a higher one is cancelled: its result would be
    /// out of date. Answers its number.
    pub fn submit(
        &mut self,
        slot: u32,
        work: impl FnOnce(&Reporter<P, T>, &task::Task) -> Result<T, String> + Send + 'static,
    ) -> TaskId {
        self.cancel_from(slot);
        let id = self.next;
        self.next += 1;
        let task = Task { id, slot, work: Box::new(work), cancel: Cancel::default() };
        self.shared.lock().waiting.push(task);
        self.shared.changed.notify_all();
        id
    }

    /// Cancels what waits or runs in `slot` or a higher one.
    pub fn cancel_from(&self, slot: u32) {
        let mut queue = self.shared.lock();
        let (gone, kept) = std::mem::take(&mut queue.waiting).into_iter().partition(|t: &Task<P, T>| t.slot >= slot);
        queue.waiting = kept;
        if let Some((_, running, cancel)) = &queue.running
            && *running >= slot
        {
            cancel.cancel();
        }
        drop(queue);
        for task in gone {
            let _ = self.sender.send(Message::Finished(task.id, Ended::Cancelled));
        }
    }

    /// What has been said since the last call, in order.
    pub fn messages(&self) -> Vec<Message<P, T>> {
        self.messages.try_iter().collect()
    }

    /// Whether anything waits or runs.
    pub fn is_busy(&self) -> bool {
        let queue = self.shared.lock();
        queue.running.is_some() || !queue.waiting.is_empty()
    }
}

impl<P, T> Drop for Worker<P, T> {
    fn drop(&mut self) {
        let mut queue = self.shared.lock();
        queue.closed = true;
        queue.waiting.clear();
        if let Some((.., cancel)) = &queue.running {
            cancel.cancel();
        }
        drop(queue);
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve<P: Send + 'static, T: Send + 'static>(
    shared: &Shared<P, T>,
    sender: &Sender<Message<P, T>>,
    wake: &Arc<dyn Fn() + Send + Sync>,
) {
    while let Some(task) = next_task(shared) {
        let reporter = Reporter { task: task.id, sender: sender.clone(), wake: wake.clone() };
        reporter.send(Message::Started(task.id));
        let ended = run(task, &reporter);
        shared.lock().running = None;
        reporter.send(Message::Finished(reporter.task, ended));
    }
}

fn next_task<P, T>(shared: &Shared<P, T>) -> Option<Task<P, T>> {
    let mut queue = shared.lock();
    loop {
        if queue.closed {
            return None;
        }
        if !queue.waiting.is_empty() {
            let task = queue.waiting.remove(0);
            queue.running = Some((task.id, task.slot, task.cancel.clone()));
            return Some(task);
        }
        queue = shared.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

fn run<P: Send + 'static, T: Send + 'static>(task: Task<P, T>, reporter: &Reporter<P, T>) -> Ended<T> {
    let Task { id, work, cancel, .. } = task;
    let (sender, wake) = (Mutex::new(reporter.sender.clone()), reporter.wake.clone());
    let progress = Progress::new(move |update| {
        let message = Message::Progress {
            task: id,
            stage: update.stage.to_owned(),
            fraction: update.fraction,
            message: update.message.to_owned(),
        };
        if sender.lock().unwrap_or_else(PoisonError::into_inner).send(message).is_ok() {
            wake();
        }
    });
    let given = task::Task { progress, cancel: cancel.clone() };
    match std::panic::catch_unwind(AssertUnwindSafe(|| work(reporter, &given))) {
        // Told to stop too late: what is done is done, and files may have been written.
        Ok(Ok(result)) => Ended::Done(result),
        // What else a computation answers once it was told to stop is that it stopped.
        Ok(Err(_)) if cancel.is_cancelled() => Ended::Cancelled,
        Ok(Err(message)) => Ended::Failed(message),
        Err(panic) => Ended::Panicked(panic_text(&*panic)),
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("internal error: {}; please report it with the files that led to it", text.unwrap_or("no reason given"))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    type Tested = Worker<u32, u32>;

    /// Everything said until task `last` has ended.
    fn until(worker: &Tested, last: TaskId) -> Vec<Message<u32, u32>> {
        let mut all = Vec::new();
        loop {
            let message = worker.messages.recv_timeout(Duration::from_secs(30)).unwrap();
            let over = matches!(message, Message::Finished(id, _) if id == last);
            all.push(message);
            if over {
                return all;
            }
        }
    }

    fn ending(messages: &[Message<u32, u32>], task: TaskId) -> Option<&Ended<u32>> {
        messages.iter().find_map(|m| match m {
            Message::Finished(id, ended) if *id == task => Some(ended),
            _ => None,
        })
    }

    fn wait_for_cancel(cancel: &Cancel) -> Result<u32, String> {
        while !cancel.is_cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Err("stopped".to_owned())
    }

    #[test]
    fn results_parts_and_progress_come_in_order() {
        let mut worker = Tested::start(|| ()).unwrap();
        let id = worker.submit(0, |reporter, task| {
            task.report("half", 0.5, "x");
            reporter.partial(1);
            Ok(2)
        });
        let said = until(&worker, id);
        assert!(matches!(said[0], Message::Started(_)));
        assert!(matches!(&said[1], Message::Progress { stage, fraction, .. } if stage == "half" && *fraction == 0.5));
        assert!(matches!(said[2], Message::Partial(_, 1)));
        assert!(matches!(said[3], Message::Finished(_, Ended::Done(2))));
    }

    #[test]
    fn the_latest_of_a_slot_wins() {
        let mut worker = Tested::start(|| ()).unwrap();
        let first = worker.submit(1, |_, task| wait_for_cancel(&task.cancel));
        let lower = worker.submit(0, |_, _| Ok(5));
        let second = worker.submit(1, |_, _| Ok(6));
        let third = worker.submit(1, |_, _| Ok(7));
        let said = until(&worker, third);
        assert!(matches!(ending(&said, first), Some(Ended::Cancelled)));
        assert!(matches!(ending(&said, lower), Some(Ended::Done(5))), "a later slot leaves earlier ones alone");
        assert!(matches!(ending(&said, second), Some(Ended::Cancelled)));
        assert!(matches!(ending(&said, third), Some(Ended::Done(7))));
    }

    #[test]
    fn a_result_that_was_finished_all_the_same_is_not_thrown_away() {
        let mut worker = Tested::start(|| ()).unwrap();
        let late = worker.submit(0, |reporter, task| {
            reporter.partial(1);
            wait_for_cancel(&task.cancel).or(Ok(3))
        });
        // It has to have begun, or it has no result.
        while !matches!(worker.messages.recv_timeout(Duration::from_secs(30)).unwrap(), Message::Partial(_, 1)) {}
        worker.cancel_from(0);
        assert!(matches!(ending(&until(&worker, late), late), Some(Ended::Done(3))));
    }

    #[test]
    fn a_panic_ends_its_task_and_no_other() {
        let mut worker = Tested::start(|| ()).unwrap();
        let bad = worker.submit(0, |_, _| panic!("on purpose"));
        let said = until(&worker, bad);
        assert!(matches!(ending(&said, bad), Some(Ended::Panicked(text)) if text.contains("on purpose")));
        let good = worker.submit(0, |_, _| Ok(1));
        assert!(matches!(ending(&until(&worker, good), good), Some(Ended::Done(1))));
        assert!(!worker.is_busy());
    }

    #[test]
    fn dropping_the_worker_stops_what_runs() {
        let mut worker = Tested::start(|| ()).unwrap();
        worker.submit(0, |_, task| wait_for_cancel(&task.cancel));
        drop(worker);
    }
}
