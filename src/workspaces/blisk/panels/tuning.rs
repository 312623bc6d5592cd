//! What follows while an electrode is tuned: a quick look for its way out at every change, and the table of sizes when
//! asked for. Both work on threads of their own, so that a plan does not wait for them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::workspaces::blisk::document::stage::Fingerprint;
use crate::workspaces::blisk::job::preview::{LiveWay, live_way};
use crate::workspaces::blisk::job::sizing::{SizeRow, SizingRange, size};
use crate::workspaces::blisk::pipeline::TuningInputs;
use crate::workspaces::worker::{Ended, Message, Worker};
use render::mesh::RenderMesh;
use wheel::channel::Channel;
use wheel::electrode::Electrode;

/// Parts up to which electrodes are sized.
const MOST_PARTS: usize = 3;
/// How long nothing may change before what was looked at quickly is planned and verified.
const REST: Duration = Duration::from_millis(700);

/// The parameters that are looked at, and the number of the electrode.
type Place = (Fingerprint, usize);

/// What a look found, for which parameters.
struct Looked {
    at: Place,
    channel: Arc<Channel>,
    way: LiveWay,
    /// The electrode that it is the way of, where that is not the one that is tuned.
    other: Option<(Arc<Electrode>, Arc<RenderMesh>)>,
    took: Duration,
}

/// See the module's page.
pub struct Tuning {
    looker: Worker<(), Looked>,
    asked: Option<Place>,
    /// Why the last look could not be made.
    blind: Option<String>,
    looked: Option<(Looked, Instant)>,
    /// Counts the looks: another number, another way.
    number: u64,
    /// Parameters for which a plan was asked for already.
    planned: Option<Place>,
    sizer: Worker<SizeRow, ()>,
    /// The table, what its parameters are told by, and what is being worked on.
    rows: Vec<SizeRow>,
    sized: Option<Fingerprint>,
    sizing: Option<String>,
    failure: Option<String>,
}

impl Tuning {
    /// Nothing yet; `wake` is called whenever there is something new.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            looker: Worker::start(wake.clone())?,
            asked: None,
            blind: None,
            looked: None,
            number: 0,
            planned: None,
            sizer: Worker::start(wake)?,
            rows: Vec::new(),
            sized: None,
            sizing: None,
            failure: None,
        })
    }

    /// Takes in what was found, and looks at `inputs` for electrode number `part` if they are others than before; at
    /// nothing if there are none.
    pub fn follow(&mut self, inputs: Option<TuningInputs>, part: usize) {
        self.take();
        let Some(inputs) = inputs else {
            if self.asked.take().is_some() {
                self.looker.cancel_from(0);
            }
            self.looked = None;
            return;
        };
        let at = (inputs.of, part);
        if self.asked == Some(at) {
            return;
        }
        self.asked = Some(at);
        self.blind = None;
        self.looker.submit(0, move |_, task| {
            let ready = inputs.prepared(task)?;
            let began = Instant::now();
            let way = live_way(&ready, &inputs.inputs, part, task).map_err(|e| e.to_string())?;
            let took = began.elapsed();
            let other = way.other.as_ref().map(|e| (e.clone(), Arc::new(RenderMesh::new(&e.mesh))));
            Ok(Looked { at, channel: inputs.channel(), way, other, took })
        });
    }

    fn take(&mut self) {
        for message in self.looker.messages() {
            let Message::Finished(_, ended) = message else { continue };
            match ended {
                Ended::Done(looked) => {
                    self.number += 1;
                    self.looked = Some((looked, Instant::now()));
                }
                Ended::Failed(why) | Ended::Panicked(why) => self.blind = Some(why),
                Ended::Cancelled => {}
            }
        }
        for message in self.sizer.messages() {
            match message {
                Message::Partial(_, row) if self.sized.is_some() => self.rows.push(row),
                Message::Partial(..) => {}
                Message::Progress { stage, message, .. } => self.sizing = Some(format!("{stage} {message}")),
                Message::Started(_) => self.sizing = Some("sizing".to_owned()),
                Message::Finished(_, ended) => {
                    self.sizing = None;
                    if let Ended::Failed(why) | Ended::Panicked(why) = ended {
                        self.failure = Some(why);
                    }
                }
            }
        }
    }

    /// The way that was found for the parameters last looked at, with its number.
    pub fn way(&self) -> Option<(u64, &LiveWay)> {
        let (looked, _) = self.looked.as_ref()?;
        (self.asked == Some(looked.at)).then_some((self.number, &looked.way))
    }

    /// The electrode that this is the way of, and its shape, where that is not the one that is tuned.
    pub fn other_electrode(&self) -> Option<&(Arc<Electrode>, Arc<RenderMesh>)> {
        self.way()?;
        self.looked.as_ref()?.0.other.as_ref()
    }

    /// Why the last look could not be made.
    pub fn blind(&self) -> Option<&str> {
        self.blind.as_deref()
    }

    /// What it found in one sentence, and how long it took.
    pub fn sentence(&self) -> Option<(String, Duration)> {
        let (looked, _) = self.looked.as_ref().filter(|(looked, _)| self.asked == Some(looked.at))?;
        Some((looked.way.sentence(&looked.channel), looked.took))
    }

    /// Whether a look is under way.
    pub fn is_looking(&self) -> bool {
        self.asked.is_some() && self.blind.is_none() && self.way().is_none()
    }

    /// Whether it is time to plan and verify what was looked at: it comes out, and nothing has changed for a while. True
    /// once for the same parameters. If it is not time yet, tells how long to wait.
    pub fn is_at_rest(&mut self) -> Result<(), Option<Duration>> {
        let Some((looked, since)) = self.looked.as_ref().filter(|(l, _)| self.asked == Some(l.at)) else {
            return Err(None);
        };
        if looked.way.way.margin.is_none() || self.planned == Some(looked.at) {
            return Err(None);
        }
        let rested = since.elapsed();
        if rested < REST {
            return Err(Some(REST - rested));
        }
        self.planned = Some(looked.at);
        Ok(())
    }

    /// Begins the table of sizes.
    pub fn size(&mut self, inputs: TuningInputs) {
        self.rows.clear();
        self.failure = None;
        self.sized = Some(inputs.of_size);
        self.sizing = Some("sizing".to_owned());
        self.sizer.submit(0, move |reporter, task| {
            let ready = inputs.prepared(task)?;
            let (range, found) =
                (SizingRange { from: 1, to: MOST_PARTS }, |row: &SizeRow| reporter.partial(row.clone()));
            let rows = size(&ready, &inputs.inputs, range, &found, task).map_err(|e| e.to_string())?;
            if rows.is_empty() {
                Err("not feasible: no electrode has an extraction path at the reductions tried".to_owned())
            } else {
                Ok(())
            }
        });
    }

    /// Whether the table is of parameters that are told by `now`.
    pub fn sizes_are_of(&self, now: Option<Fingerprint>) -> bool {
        self.sized.is_some() && self.sized == now
    }

    /// Forgets the table: another document is there.
    pub fn forget_sizes(&mut self) {
        self.sizer.cancel_from(0);
        // What was on its way is of the document before.
        let _ = self.sizer.messages();
        self.rows.clear();
        (self.sized, self.sizing, self.failure) = (None, None, None);
    }

    /// Stops sizing; the rows found so far stay.
    pub fn stop_sizing(&mut self) {
        self.sizer.cancel_from(0);
    }

    /// What is being sized.
    pub fn sizing(&self) -> Option<&str> {
        self.sizing.as_deref()
    }

    /// The table so far, and why it ended early.
    pub fn sizes(&self) -> (&[SizeRow], Option<&str>) {
        (&self.rows, self.failure.as_deref())
    }
}
