//! Values that are computed for keys in the background, and their state.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::doing::Doing;
use crate::scheduler::{Job, JobId, Lane, Leave, Priority, Queue, Scheduler};
use crate::{Cancel, Progress, Task};

/// State of a key: the first of these that holds.
///
/// 1. **Running**: work for the key waits or runs.
/// 2. **Ready**: the value of the key is remembered. A value is a fact: an attempt to make it once more that failed or
///    was cancelled does not take it away.
/// 3. **Failed** or **Cancelled**: the last attempt ended so. It does not begin again by itself, only by
///    [`Memo::restart`], or by [`Memo::resume`] and asking again.
/// 4. **Stale**: nothing is known of the key, but a value of another key is.
/// 5. **Missing**: nothing is known at all.
///
/// The state does not choose what is shown. In every state [`Memo::get`] answers the key's own value and nothing else,
/// [`Memo::last`] the value that was made or asked for last, whatever its key, and [`Memo::partial`] what the latest
/// work for the key has found so far. Whoever shows the value of another key has asked for just that.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// No value of any key is known.
    Missing,
    /// Work for the key waits or runs.
    Running,
    /// The value of the key is remembered.
    Ready,
    /// A value of another key is remembered, none of this key.
    Stale,
    /// Work for the key failed: one line with the reason.
    Failed(String),
    /// The user cancelled work for the key.
    Cancelled,
}

impl State {
    /// One line with the reason why work ended without a value.
    pub fn why_not(&self) -> Option<&str> {
        match self {
            Self::Failed(why) => Some(why),
            Self::Cancelled => Some("cancelled"),
            _ => None,
        }
    }
}

/// Reason why work ended without a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// The work failed: one line for the user.
    Failed(String),
    /// The user cancelled the work.
    Cancelled,
}

/// The end of a piece of work.
#[derive(Debug)]
pub struct Ended<K, V> {
    /// Key that the work was done for.
    pub key: K,
    /// Value, or reason why there is none.
    pub result: Result<Arc<V>, Refusal>,
    /// Time that the work ran.
    pub took: Duration,
}

/// What a piece of work is given: its task and a receiver of partial results.
pub struct Work<P> {
    /// Progress and cancelling.
    pub task: Task,
    partial: Box<dyn Fn(P) + Send + Sync>,
}

impl<P> Work<P> {
    /// Reports a partial result, which replaces the one before.
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

/// Least time between two wakes for progress in one stage: it may report thousands of times a second, each of which
/// would be a frame of the window.
const BETWEEN_WAKES: Duration = Duration::from_millis(50);

/// What is said of the run with this number.
type Message<V, P> = (u64, Said<V, P>);

/// Makes a value. An error is one line for the user.
type Making<V, P> = Box<dyn FnOnce(&Work<P>) -> Result<V, String> + Send>;

struct Attempt<V, P> {
    run: u64,
    work: Making<V, P>,
    sender: Sender<Message<V, P>>,
    queue: Arc<Queue>,
    is_awaited: bool,
}

fn say<V, P>(sender: &Sender<Message<V, P>>, queue: &Queue, message: Message<V, P>) {
    // Nobody listens any more once the memo is dropped.
    if sender.send(message).is_ok() {
        queue.wake();
    }
}

impl<V: Send + 'static, P: Send + 'static> Job for Attempt<V, P> {
    fn run(self: Box<Self>, cancel: &Cancel) {
        let Self { run, work: make, sender, queue, .. } = *self;
        say(&sender, &queue, (run, Said::Started(Instant::now())));
        let (to_us, theirs) = (sender.clone(), queue.clone());
        let woken = Mutex::new(None::<(Instant, String)>);
        let progress = Progress::new(move |update| {
            let (stage, message) = (update.stage.to_owned(), update.message.to_owned());
            let progress = Said::Progress { stage, fraction: update.fraction, message };
            let mut woken = woken.lock().unwrap_or_else(PoisonError::into_inner);
            let is_known = |(at, stage): &(Instant, String)| at.elapsed() < BETWEEN_WAKES && *stage == update.stage;
            if !woken.as_ref().is_some_and(is_known) {
                *woken = Some((Instant::now(), update.stage.to_owned()));
                say(&to_us, &theirs, (run, progress));
            } else {
                // Taken in with what comes next.
                to_us.send((run, progress)).unwrap_or(());
            }
            drop(woken);
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
        cancelled(&self.sender, &self.queue, self.run);
    }

    fn leave(&self) -> Option<Leave> {
        let (sender, queue, run) = (self.sender.clone(), self.queue.clone(), self.run);
        (!self.is_awaited).then(|| Box::new(move || cancelled(&sender, &queue, run)) as Leave)
    }
}

fn cancelled<V, P>(sender: &Sender<Message<V, P>>, queue: &Queue, run: u64) {
    say(sender, queue, (run, Said::Ended(Err(Refusal::Cancelled), Instant::now())));
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

/// Values by their keys: remembered values, and one that is being computed.
///
/// A key holds everything that its value depends on. A value that depends on another memo's value has a fingerprint of
/// that value in its key, or the value itself as [`Same`].
///
/// Work is a function of what it has captured, and must not wait for another memo. The latest key wins: work for
/// another key is cancelled. The memo changes its answers only in [`take`](Self::take), which is called once a frame,
/// and where values are asked for or cancelled.
pub struct Memo<K, V, P = ()> {
    queue: Arc<Queue>,
    lane: Lane,
    what: &'static str,
    remembered: usize,
    lets_finish: bool,
    is_awaited: bool,
    /// Remembered values; the one computed or asked for last comes last.
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
    /// An empty memo. `what` is the name shown to the user.
    pub fn new(scheduler: &Scheduler, lane: Lane, what: &'static str) -> Self {
        let (sender, messages) = channel();
        Self {
            queue: scheduler.queue(),
            lane,
            what,
            remembered: 8,
            lets_finish: false,
            is_awaited: false,
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

    /// Sets the number of remembered values, at least 1. The value that was not asked for the longest is forgotten
    /// first.
    pub fn remembering(mut self, values: usize) -> Self {
        self.remembered = values.max(1);
        self
    }

    /// Lets work for an earlier key finish before work for the latest key begins. This is for previews: if each change
    /// of a slider cancelled the last preview, none would ever be seen.
    pub fn letting_finish(mut self) -> Self {
        self.lets_finish = true;
        self
    }

    /// Never leaves work behind that does not stop when it is told to. This is for work that writes files: what it has
    /// written is told.
    pub fn awaiting_the_end(mut self) -> Self {
        self.is_awaited = true;
        self
    }

    /// State of `key`.
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

    /// The value that was computed or asked for last, with its key.
    pub fn last(&self) -> Option<(&K, &Arc<V>)> {
        self.values.last().map(|(of, value)| (of, value))
    }

    /// Partial result of the latest work, if that is for `key`. The result stays after the work failed or was
    /// cancelled.
    pub fn partial(&self, key: &K) -> Option<&P> {
        self.partial.as_ref().filter(|(of, _)| of == key).map(|(_, found)| found)
    }

    /// Work under way.
    pub fn doing(&self) -> Option<&Doing> {
        self.run.as_ref().map(|run| &run.doing)
    }

    /// Key that work waits or runs for.
    pub fn under_way(&self) -> Option<&K> {
        self.run.as_ref().map(|run| &run.key)
    }

    /// Whether [`ask`](Self::ask) would begin work for `key`. Check this first where the work captures large values.
    pub fn wants(&self, key: &K) -> bool {
        matches!(self.state(key), State::Missing | State::Stale)
    }

    /// Whether anything waits or runs.
    pub fn is_busy(&self) -> bool {
        self.run.is_some()
    }

    /// Asks for the value of `key`. `work` computes the value unless the value is known, is being computed, or the last
    /// attempt failed or was cancelled.
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

    /// Computes the value of `key` by `work` at the user's wish, whatever the state of the key.
    pub fn restart(
        &mut self,
        key: &K,
        priority: Priority,
        work: impl FnOnce(&Work<P>) -> Result<V, String> + Send + 'static,
    ) {
        self.receive();
        self.begin(key, priority, Box::new(work));
    }

    /// Forgets that work for `key` failed or was cancelled, so that the work begins when the key is asked for again.
    pub fn resume(&mut self, key: &K) {
        self.refusals.retain(|(of, _)| of != key);
    }

    /// Turns to `key` without asking for work: cancels work for other keys, and makes the value of `key`, if
    /// remembered, the last one.
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

    /// Changes the priority of the work that waits or runs.
    pub fn prioritise(&mut self, priority: Priority) {
        if let Some(next) = &mut self.next {
            next.priority = priority;
        }
        if let Some(run) = self.run.as_mut().filter(|run| run.priority != priority) {
            run.priority = priority;
            self.queue.prioritise(run.job, priority);
        }
    }

    /// Cancels the work that waits or runs at the user's wish. The work does not begin again by itself.
    pub fn cancel(&mut self) {
        if let Some(next) = self.next.take() {
            self.refuse(next.key, Refusal::Cancelled);
        }
        if let Some(run) = self.run.as_mut().filter(|run| !run.is_cancelled) {
            (run.is_cancelled, run.doing.message) = (true, "stopping".to_owned());
            self.queue.cancel(run.job);
        }
    }

    /// Remembers `value` as the value of `key`, for example one that was saved.
    pub fn put(&mut self, key: &K, value: Arc<V>) {
        self.receive();
        self.remember(key.clone(), value);
    }

    /// Cancels the work that waits or runs because its value is not needed any more. The work may be asked for again,
    /// unless the user has cancelled it before.
    pub fn stop(&mut self) {
        self.next = None;
        let Some(run) = self.run.take() else { return };
        self.queue.cancel(run.job);
        if run.is_cancelled {
            self.refuse(run.key, Refusal::Cancelled);
        }
    }

    /// Forgets all values and cancels the work that runs.
    pub fn clear(&mut self) {
        self.stop();
        self.partial = None;
        self.values.clear();
        self.refusals.clear();
        self.ended.clear();
    }

    /// Takes in finished work. Returns the ends of work that was not superseded, one for each call.
    pub fn take(&mut self) -> Option<Ended<K, V>> {
        self.receive();
        self.ended.pop_front()
    }

    fn receive(&mut self) {
        while let Ok((number, said)) = self.messages.try_recv() {
            let Some(run) = self.run.as_mut().filter(|run| run.number == number) else { continue };
            match said {
                Said::Started(now) => {
                    run.doing = Doing { asked: run.doing.asked, ..Doing::new(self.what, false, now) };
                    self.partial = None;
                }
                Said::Progress { stage, fraction, message } => {
                    let (doing, now) = (&mut run.doing, Instant::now());
                    if doing.stage != stage {
                        (doing.stage_since, doing.moved) = (now, now);
                    } else if doing.fraction != fraction {
                        doing.moved = now;
                    }
                    (doing.stage, doing.fraction) = (stage, fraction);
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
        let (sender, queue) = (self.sender.clone(), self.queue.clone());
        let work = Attempt { run: self.runs, work, sender, queue, is_awaited: self.is_awaited };
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

/// A shared value as a part of a key: two are equal if they are the same object, not if their contents are equal.
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
