//! Values that are computed for keys, and what is known of them.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use crate::scheduler::{Job, JobId, Lane, Priority, Queue, Scheduler};
use crate::{Cancel, Progress, Task};

/// What is known of a key: the first of these that holds.
///
/// 1. **Running**: work for the key waits or runs.
/// 2. **Ready**: the value of the key is remembered. A value is a fact: an attempt to make it once more that failed or was
///    cancelled does not take it away.
/// 3. **Failed** or **Cancelled**: the last attempt ended so. It does not begin again by itself, only by
///    [`Memo::restart`], or by [`Memo::resume`] and asking again.
/// 4. **Stale**: nothing is known of the key, but a value of another key is.
/// 5. **Missing**: nothing is known at all.
///
/// The state does not choose what is shown. In every state [`Memo::get`] answers the key's own value and nothing else,
/// [`Memo::last`] the value that was made or asked for last, whatever its key, and [`Memo::partial`] what the latest work for
/// the key has found so far. Whoever shows the value of another key has asked for just that.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// Nothing, and no value of another key either.
    Missing,
    /// Work for it waits or runs.
    Running,
    /// Value.
    Ready,
    /// Nothing; there is a value of another key.
    Stale,
    /// There is no value: one line why.
    Failed(String),
    /// The user cancelled its work.
    Cancelled,
}

impl State {
    /// Why there is no value although work for it has ended: in one line.
    pub fn why_not(&self) -> Option<&str> {
        match self {
            Self::Failed(why) => Some(why),
            Self::Cancelled => Some("cancelled"),
            _ => None,
        }
    }
}

/// Why work ended without a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// Work that could not be done: one line for the user.
    Failed(String),
    /// The user cancelled it.
    Cancelled,
}

/// How work has ended.
#[derive(Debug)]
pub struct Ended<K, V> {
    /// Key that the work was done for.
    pub key: K,
    /// What came out.
    pub result: Result<Arc<V>, Refusal>,
    /// How long it ran.
    pub took: Duration,
}

/// What is being worked on.
#[derive(Debug, Clone, PartialEq)]
pub struct Doing {
    /// Name of the memo that the work is for.
    pub what: &'static str,
    /// What is being done, in the words of the computation: "waiting" before it begins, and then empty at first.
    pub stage: String,
    /// How much of the stage is done, 0 to 1.
    pub fraction: f64,
    /// Detail, may be empty.
    pub message: String,
    /// Whether it has not begun yet.
    pub is_waiting: bool,
    /// When it began, or was asked for.
    pub since: Instant,
    /// When the stage began.
    pub stage_since: Instant,
}

impl Doing {
    fn new(what: &'static str, is_waiting: bool, now: Instant) -> Self {
        let stage = if is_waiting { "waiting".to_owned() } else { String::new() };
        Self { what, stage, fraction: 0.0, message: String::new(), is_waiting, since: now, stage_since: now }
    }

    /// Time that the stage will still take if it goes on as it did; none while that cannot be told.
    pub fn time_left(&self) -> Option<Duration> {
        let spent = self.stage_since.elapsed();
        let is_known = self.fraction > 0.03 && self.fraction < 1.0 && spent > Duration::from_millis(500);
        is_known.then(|| spent.mul_f64((1.0 - self.fraction) / self.fraction))
    }
}

/// What work reports to, and what tells it to stop.
pub struct Work<P> {
    /// What the job is given.
    pub task: Task,
    partial: Box<dyn Fn(P) + Send + Sync>,
}

impl<P> Work<P> {
    /// Says what has been found so far; takes the place of what was said before.
    pub fn partial(&self, found: P) {
        (self.partial)(found);
    }
}

enum Said<V, P> {
    Started(Instant),
    Progress { stage: String, fraction: f64, message: String },
    Partial(P),
    Ended(Result<V, Refusal>, Instant),
}

/// What is said of the run with this number.
type Message<V, P> = (u64, Said<V, P>);

/// Makes a value. An error is one line for the user.
type Making<V, P> = Box<dyn FnOnce(&Work<P>) -> Result<V, String> + Send>;

struct Attempt<V, P> {
    run: u64,
    work: Making<V, P>,
    sender: Sender<Message<V, P>>,
    queue: Arc<Queue>,
}

fn say<V, P>(sender: &Sender<Message<V, P>>, queue: &Queue, message: Message<V, P>) {
    // Nobody listens any more once the memo is dropped.
    if sender.send(message).is_ok() {
        queue.wake();
    }
}

impl<V: Send + 'static, P: Send + 'static> Job for Attempt<V, P> {
    fn run(self: Box<Self>, cancel: &Cancel) {
        let Self { run, work: make, sender, queue } = *self;
        say(&sender, &queue, (run, Said::Started(Instant::now())));
        let (to_us, theirs) = (sender.clone(), queue.clone());
        let progress = Progress::new(move |update| {
            let (stage, message) = (update.stage.to_owned(), update.message.to_owned());
            say(&to_us, &theirs, (run, Said::Progress { stage, fraction: update.fraction, message }));
            theirs.let_pass();
        });
        let (to_us, theirs) = (sender.clone(), queue.clone());
        let partial = Box::new(move |found| say(&to_us, &theirs, (run, Said::Partial(found))));
        let work = Work { task: Task { progress, cancel: cancel.clone() }, partial };
        let result = match std::panic::catch_unwind(AssertUnwindSafe(|| make(&work))) {
            // Told to stop too late: what is done is done, and files may have been written.
            Ok(Ok(value)) => Ok(value),
            // What else a computation answers once it was told to stop is that it stopped.
            Ok(Err(_)) if cancel.is_cancelled() => Err(Refusal::Cancelled),
            Ok(Err(why)) => Err(Refusal::Failed(why)),
            Err(panic) => Err(Refusal::Failed(panic_text(&*panic))),
        };
        say(&sender, &queue, (run, Said::Ended(result, Instant::now())));
    }

    fn give_up(self: Box<Self>) {
        say(&self.sender, &self.queue, (self.run, Said::Ended(Err(Refusal::Cancelled), Instant::now())));
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("internal error: {}; please report it with the files that led to it", text.unwrap_or("no reason given"))
}

/// The work that was asked for last.
struct Run<K> {
    number: u64,
    key: K,
    job: JobId,
    priority: Priority,
    doing: Doing,
    is_cancelled: bool,
}

/// Work that begins when what runs has ended.
struct Next<K, V, P> {
    priority: Priority,
    key: K,
    work: Attempt<V, P>,
}

/// Values by their keys: those that are remembered, and one that is being made.
///
/// A key holds all that the value depends on. What depends on the value of another memo has in its key what tells that value
/// from any other: a fingerprint, or the value itself as [`Same`].
///
/// Work is a function of what it has captured, and must not wait for another memo.
/// The latest key wins: work for another one is cancelled. What has happened since is taken in by [`take`](Self::take), to be
/// called once a frame; nothing else changes what the memo answers, but for asking and cancelling.
pub struct Memo<K, V, P = ()> {
    queue: Arc<Queue>,
    lane: Lane,
    what: &'static str,
    remembered: usize,
    lets_finish: bool,
    /// Remembered values; the one that was made or asked for last comes last.
    values: Vec<(K, Arc<V>)>,
    refusals: Vec<(K, Refusal)>,
    run: Option<Run<K>>,
    next: Option<Next<K, V, P>>,
    partial: Option<(K, P)>,
    runs: u64,
    ended: VecDeque<Ended<K, V>>,
    sender: Sender<Message<V, P>>,
    messages: Receiver<Message<V, P>>,
}

impl<K: Clone + PartialEq, V: Send + 'static, P: Send + 'static> Memo<K, V, P> {
    /// Knows nothing yet. `what` names it to the user.
    pub fn new(scheduler: &Scheduler, lane: Lane, what: &'static str) -> Self {
        let (sender, messages) = channel();
        Self {
            queue: scheduler.queue(),
            lane,
            what,
            remembered: 8,
            lets_finish: false,
            values: Vec::new(),
            refusals: Vec::new(),
            run: None,
            next: None,
            partial: None,
            runs: 0,
            ended: VecDeque::new(),
            sender,
            messages,
        }
    }

    /// Remembers so many values, at least one, and forgets first what was not asked for the longest.
    pub fn remembering(mut self, values: usize) -> Self {
        self.remembered = values.max(1);
        self
    }

    /// Lets work for an earlier key come to its end; that for the latest key begins after it. For previews, of which none
    /// would ever be seen while a slider moves if each change cancelled the last.
    pub fn letting_finish(mut self) -> Self {
        self.lets_finish = true;
        self
    }

    /// What is known of `key`.
    pub fn state(&self, key: &K) -> State {
        let is_next = self.next.as_ref().is_some_and(|next| next.key == *key);
        if is_next || self.run.as_ref().is_some_and(|run| run.key == *key) {
            State::Running
        } else if self.get(key).is_some() {
            State::Ready
        } else {
            match self.refusals.iter().find(|(of, _)| of == key) {
                Some((_, Refusal::Failed(why))) => State::Failed(why.clone()),
                Some((_, Refusal::Cancelled)) => State::Cancelled,
                None if self.values.is_empty() => State::Missing,
                None => State::Stale,
            }
        }
    }

    /// The value of `key`.
    pub fn get(&self, key: &K) -> Option<&Arc<V>> {
        self.values.iter().find(|(of, _)| of == key).map(|(_, value)| value)
    }

    /// The value that was made or asked for last, and its key.
    pub fn last(&self) -> Option<(&K, &Arc<V>)> {
        self.values.last().map(|(of, value)| (of, value))
    }

    /// What the latest work has found so far, if it is for `key`: while it runs, and after it failed or was cancelled.
    pub fn partial(&self, key: &K) -> Option<&P> {
        self.partial.as_ref().filter(|(of, _)| of == key).map(|(_, found)| found)
    }

    /// What is being worked on.
    pub fn doing(&self) -> Option<&Doing> {
        self.run.as_ref().map(|run| &run.doing)
    }

    /// The key that work waits or runs for.
    pub fn under_way(&self) -> Option<&K> {
        self.run.as_ref().map(|run| &run.key)
    }

    /// Whether [`ask`](Self::ask) would begin work for `key`: worth asking where what the work captures is large.
    pub fn wants(&self, key: &K) -> bool {
        matches!(self.state(key), State::Missing | State::Stale)
    }

    /// Whether anything waits or runs.
    pub fn is_busy(&self) -> bool {
        self.run.is_some()
    }

    /// Wants the value of `key`: `work` makes it unless it is known, is being made, could not be made or was cancelled.
    pub fn ask(
        &mut self,
        key: &K,
        priority: Priority,
        work: impl FnOnce(&Work<P>) -> Result<V, String> + Send + 'static,
    ) -> State {
        self.turn_to(key);
        if self.wants(key) {
            self.begin(key, priority, Box::new(work));
        }
        self.prioritise(priority);
        self.state(key)
    }

    /// Has `work` make the value of `key` at the user's wish, whatever is known of it.
    pub fn restart(
        &mut self,
        key: &K,
        priority: Priority,
        work: impl FnOnce(&Work<P>) -> Result<V, String> + Send + 'static,
    ) {
        self.receive();
        self.begin(key, priority, Box::new(work));
    }

    /// Forgets that work for `key` failed or was cancelled: it begins when it is asked for again.
    pub fn resume(&mut self, key: &K) {
        self.refusals.retain(|(of, _)| of != key);
    }

    /// Turns to `key` without asking for work: work for any other is of no use any more, and the value of this one, if it is
    /// remembered, becomes the last one.
    pub fn turn_to(&mut self, key: &K) {
        self.receive();
        self.next.take_if(|next| next.key != *key);
        if !self.lets_finish && self.under_way().is_some_and(|of| of != key) {
            self.stop();
        }
        if let Some(i) = self.values.iter().position(|(of, _)| of == key) {
            self.values[i..].rotate_left(1);
        }
    }

    /// Gives what waits or runs another priority.
    pub fn prioritise(&mut self, priority: Priority) {
        if let Some(next) = &mut self.next {
            next.priority = priority;
        }
        if let Some(run) = self.run.as_mut().filter(|run| run.priority != priority) {
            run.priority = priority;
            self.queue.prioritise(run.job, priority);
        }
    }

    /// Cancels what waits or runs, at the user's wish: it does not begin again by itself.
    pub fn cancel(&mut self) {
        if let Some(next) = self.next.take() {
            self.refuse(next.key, Refusal::Cancelled);
        }
        if let Some(run) = self.run.as_mut().filter(|run| !run.is_cancelled) {
            (run.is_cancelled, run.doing.message) = (true, "stopping".to_owned());
            self.queue.cancel(run.job);
        }
    }

    /// Takes `value` for that of `key`, such as one that was saved.
    pub fn put(&mut self, key: &K, value: Arc<V>) {
        self.receive();
        self.remember(key.clone(), value);
    }

    /// Cancels what waits or runs because nobody wants it any more. It may be asked for again, unless the user had
    /// cancelled it already.
    pub fn stop(&mut self) {
        self.next = None;
        let Some(run) = self.run.take() else { return };
        self.queue.cancel(run.job);
        if run.is_cancelled {
            self.refuse(run.key, Refusal::Cancelled);
        }
    }

    /// Forgets everything, and cancels what runs.
    pub fn clear(&mut self) {
        self.stop();
        self.partial = None;
        self.values.clear();
        self.refusals.clear();
        self.ended.clear();
    }

    /// Takes in what has happened. Answers, one after the other, how work has ended that was not superseded.
    pub fn take(&mut self) -> Option<Ended<K, V>> {
        self.receive();
        self.ended.pop_front()
    }

    fn receive(&mut self) {
        while let Ok((number, said)) = self.messages.try_recv() {
            let Some(run) = self.run.as_mut().filter(|run| run.number == number) else { continue };
            match said {
                Said::Started(now) => {
                    run.doing = Doing::new(self.what, false, now);
                    self.partial = None;
                }
                Said::Progress { stage, fraction, message } => {
                    if run.doing.stage != stage {
                        run.doing.stage_since = Instant::now();
                    }
                    (run.doing.stage, run.doing.fraction) = (stage, fraction);
                    if !run.is_cancelled {
                        run.doing.message = message;
                    }
                }
                Said::Partial(found) => self.partial = Some((run.key.clone(), found)),
                Said::Ended(result, at) => self.end(result, at),
            }
        }
    }

    fn end(&mut self, result: Result<V, Refusal>, at: Instant) {
        let Some(Run { key, doing, .. }) = self.run.take() else { return };
        let took = if doing.is_waiting { Duration::ZERO } else { at.saturating_duration_since(doing.since) };
        let result = result.map(Arc::new);
        match &result {
            Ok(value) => {
                self.partial = None;
                self.remember(key.clone(), value.clone());
            }
            Err(refusal) => self.refuse(key.clone(), refusal.clone()),
        }
        self.ended.push_back(Ended { key, result, took });
        if let Some(Next { key, priority, work }) = self.next.take() {
            self.submit(key, priority, work);
        }
    }

    fn begin(&mut self, key: &K, priority: Priority, work: Making<V, P>) {
        self.resume(key);
        self.runs += 1;
        let work = Attempt { run: self.runs, work, sender: self.sender.clone(), queue: self.queue.clone() };
        if self.lets_finish && self.run.is_some() {
            self.next = Some(Next { priority, key: key.clone(), work });
            return;
        }
        self.stop();
        self.submit(key.clone(), priority, work);
    }

    fn submit(&mut self, key: K, priority: Priority, work: Attempt<V, P>) {
        let number = work.run;
        let doing = Doing::new(self.what, true, Instant::now());
        let job = self.queue.submit(self.lane, priority, Box::new(work));
        self.partial = None;
        self.run = Some(Run { number, key, job, priority, doing, is_cancelled: false });
    }

    fn remember(&mut self, key: K, value: Arc<V>) {
        self.resume(&key);
        self.values.retain(|(of, _)| *of != key);
        self.values.push((key, value));
        let surplus = self.values.len().saturating_sub(self.remembered);
        self.values.drain(..surplus);
    }

    fn refuse(&mut self, key: K, refusal: Refusal) {
        self.resume(&key);
        self.refusals.push((key, refusal));
        let surplus = self.refusals.len().saturating_sub(self.remembered);
        self.refusals.drain(..surplus);
    }
}

impl<K, V, P> Drop for Memo<K, V, P> {
    fn drop(&mut self) {
        if let Some(run) = &self.run {
            self.queue.cancel(run.job);
        }
    }
}

/// A shared value as a part of a key: two are the same if they are one, not if they are alike.
#[derive(Debug)]
pub struct Same<T>(pub Arc<T>);

impl<T> Clone for Same<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T> Eq for Same<T> {}
