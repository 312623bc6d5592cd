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
use glam::DVec3;
use measured::MeasuredError;
use measured::points::{PointLimits, read_points};
use task::{Lane, Memo, Priority, Refusal, Same, Scheduler, State, Task};

/// Key of the points of a scan: the part with its channel, the file of the scan, and how often files were read.
type ReadKey = (Same<Part>, Same<FoundChannel>, String, u64);
/// Key of a comparison: the points, and how they are judged.
type ScanKey = (Same<ScanRead>, ScanSection);

/// Points of a scan with the surfaces of the part.
pub struct ScanRead {
    part: Arc<Part>,
    found: Arc<FoundChannel>,
    surfaces: Surfaces,
    points: Vec<DVec3>,
}

/// A scan against the part, with its map for the screen.
#[derive(Debug)]
pub struct ScanShown {
    /// Fit, deviations and verdict.
    pub part: ScannedPart,
    /// The points in the colours of their deviations.
    pub shape: MapShape,
}

/// The memos of scans: what is read, and what is compared.
pub(super) struct Scanned {
    read: Memo<ReadKey, ScanRead>,
    compared: Memo<ScanKey, ScanShown>,
}

impl Scanned {
    pub(super) fn new(scheduler: &Scheduler) -> Self {
        Self {
            read: Memo::new(scheduler, Lane::Quick, "Scan").remembering(1),
            compared: Memo::new(scheduler, Lane::Quick, "Scan").letting_finish().remembering(2),
        }
    }

    pub(super) fn is_busy(&self) -> bool {
        self.read.is_busy() || self.compared.is_busy()
    }
}

impl BliskDesk {
    fn read_key(&self) -> Option<ReadKey> {
        let file = self.document.params().scan.file.clone()?;
        let is_ready = self.work.state(Stage::Channel) == State::Ready;
        let (part, found) = self.work.part().zip(self.work.channel()).filter(|_| is_ready)?;
        Some((Same(part.clone()), Same(found.clone()), file, self.work.reloads()))
    }

    fn scan_key(&self) -> Option<ScanKey> {
        let read = self.scanned.read.get(&self.read_key()?)?;
        Some((Same(read.clone()), self.document.params().scan.clone()))
    }

    /// Compares the scan of the document with the part, if there is one.
    pub(super) fn follow_scan(&mut self, cx: &mut Context) {
        while let Some(ended) = self.scanned.read.take() {
            if let Err(Refusal::Failed(why)) = ended.result {
                cx.say(EventKind::Failed, format!("the scan: {why}"));
            }
        }
        while let Some(ended) = self.scanned.compared.take() {
            match ended.result {
                Ok(shown) => cx.say(EventKind::Done, format!("the scan is {}", shown.part.verdict)),
                Err(Refusal::Failed(why)) => cx.say(EventKind::Failed, format!("the scan: {why}")),
                Err(_) => {}
            }
        }
        let Some(key) = self.read_key() else { return };
        let (part, found, file) = (key.0.0.clone(), key.1.0.clone(), key.2.clone());
        self.scanned.read.ask(&key, Priority::Shown, move |work| read(part, found, &file, &work.task));
        let Some(key) = self.scan_key() else { return };
        if !self.scanned.compared.wants(&key) {
            return self.scanned.compared.turn_to(&key);
        }
        let (read, scan) = (key.0.0.clone(), key.1.clone());
        self.scanned.compared.ask(&key, Priority::Shown, move |work| compared(&read, &scan, &work.task));
    }

    /// The scan against the part, once compared.
    pub fn scan(&self) -> Option<&Arc<ScanShown>> {
        self.scanned.compared.get(&self.scan_key()?)
    }

    /// State of the comparison with the scan; missing without a scan or a channel.
    pub fn scan_state(&self) -> State {
        match (self.read_key(), self.scan_key()) {
            (_, Some(key)) => self.scanned.compared.state(&key),
            (Some(key), None) => self.scanned.read.state(&key),
            (None, None) => State::Missing,
        }
    }
}

fn read(part: Arc<Part>, found: Arc<FoundChannel>, file: &str, task: &Task) -> Result<ScanRead, String> {
    let points = read_points(Path::new(file), &PointLimits::default(), task).map_err(|e| e.to_string())?.points;
    let face_of = part.faces.as_ref().map_or(&[][..], |cad| &cad.face_of);
    let surfaces = Surfaces::of_wheel(&part.mesh, &found.channel, face_of, task).map_err(|e| e.to_string())?;
    Ok(ScanRead { part, found, surfaces, points })
}

fn compared(read: &ScanRead, scan: &ScanSection, task: &Task) -> Result<ScanShown, String> {
    let words = |error: MeasuredError| error.to_string();
    let judgement = Judgement {
        tolerance: scan.tolerance().map_err(words)?,
        freedoms: scan.freedoms()?,
        reach_mm: scan.reach_mm.unwrap_or(f64::INFINITY),
    };
    let ScanRead { part, found, surfaces, points } = read;
    let compared = ScannedPart::of(part.mesh.clone(), surfaces, points, &judgement, task).map_err(words)?;
    let shape = MapShape::of_points(&compared.map, &part.mesh, &found.channel.frame, |t| surfaces.is_open(t));
    Ok(ScanShown { part: compared, shape })
}
