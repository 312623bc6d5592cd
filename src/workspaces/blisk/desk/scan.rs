//! The scan of the finished part against the part, on a worker.

use std::path::Path;
use std::sync::Arc;

use super::BliskDesk;
use crate::workspaces::blisk::document::scan::ScanSection;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::scan::{Judgement, ScannedPart, Surfaces};
use crate::workspaces::blisk::job::stages::{FoundChannel, Part};
use crate::workspaces::blisk::scene::residual_stock::MapShape;
use crate::workspaces::context::Context;
use crate::workspaces::news::EventKind;
use measured::points::{PointLimits, read_points};
use task::{Lane, Memo, Priority, Refusal, Same, Scheduler, State, Task};

/// Key of a scan: the part with its channel, the file of the scan with its tolerance, and how often files were read.
type ScanKey = (Same<Part>, Same<FoundChannel>, ScanSection, u64);

/// A scan against the part, with its map for the screen.
#[derive(Debug)]
pub struct ScanShown {
    /// Fit, deviations and verdict.
    pub part: ScannedPart,
    /// The points in the colours of their deviations.
    pub shape: MapShape,
}

/// The memo of scans.
pub(super) type Scanned = Memo<ScanKey, ScanShown>;

pub(super) fn scanned(scheduler: &Scheduler) -> Scanned {
    Memo::new(scheduler, Lane::Quick, "Scan").remembering(2)
}

impl BliskDesk {
    fn scan_key(&self) -> Option<ScanKey> {
        let scan = &self.document.params().scan;
        let is_ready = scan.file.is_some() && self.work.state(Stage::Channel) == State::Ready;
        let (part, found) = self.work.part().zip(self.work.channel()).filter(|_| is_ready)?;
        Some((Same(part.clone()), Same(found.clone()), scan.clone(), self.work.reloads()))
    }

    /// Compares the scan of the document with the part, if there is one.
    pub(super) fn follow_scan(&mut self, cx: &mut Context) {
        while let Some(ended) = self.scanned.take() {
            match ended.result {
                Ok(shown) => cx.say(EventKind::Done, format!("the scan is {}", shown.part.verdict)),
                Err(Refusal::Failed(why)) => cx.say(EventKind::Failed, format!("the scan: {why}")),
                Err(_) => {}
            }
        }
        let Some(key) = self.scan_key() else { return };
        if !self.scanned.wants(&key) {
            return self.scanned.turn_to(&key);
        }
        let (part, found, scan) = (key.0.0.clone(), key.1.0.clone(), key.2.clone());
        self.scanned.ask(&key, Priority::Shown, move |work| compared(&part, &found, &scan, &work.task));
    }

    /// The scan against the part, once compared.
    pub fn scan(&self) -> Option<&Arc<ScanShown>> {
        self.scanned.get(&self.scan_key()?)
    }

    /// State of the comparison with the scan; missing without a scan or a channel.
    pub fn scan_state(&self) -> State {
        self.scan_key().map_or(State::Missing, |key| self.scanned.state(&key))
    }
}

fn compared(part: &Part, found: &FoundChannel, scan: &ScanSection, task: &Task) -> Result<ScanShown, String> {
    let words = |error: measured::MeasuredError| error.to_string();
    let file = Path::new(scan.file.as_deref().unwrap_or_default());
    let judgement = Judgement {
        tolerance: scan.tolerance().map_err(words)?,
        freedoms: scan.freedoms()?,
        reach_mm: scan.reach_mm.unwrap_or(f64::INFINITY),
    };
    let points = read_points(file, &PointLimits::default(), task).map_err(words)?.points;
    let face_of = part.faces.as_ref().map_or(&[][..], |cad| &cad.face_of);
    let surfaces = Surfaces::of_wheel(&part.mesh, &found.channel, face_of, task).map_err(|e| e.to_string())?;
    let compared = ScannedPart::of(part.mesh.clone(), &surfaces, &points, &judgement, task).map_err(words)?;
    let shape = MapShape::of_points(&compared.map, &part.mesh, &found.channel.frame, |t| surfaces.is_open(t));
    Ok(ScanShown { part: compared, shape })
}
