//! What all plans on one channel share.

use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::time::Duration;

use crate::workspaces::blisk::job::plan::PlanJobError;
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::stages::FoundChannel;
use task::{Cancel, Cancelled, Task};

/// The blisk that was made ready for planning last, kept between plans.
#[derive(Clone, Default)]
pub(super) struct Prepared(Arc<Mutex<Option<Kept>>>);

/// The channel it is for, and what was made ready.
type Kept = (Arc<FoundChannel>, Arc<PreparedBlisk>);

impl Prepared {
    /// Waits while another thread makes one ready, unless told to stop.
    fn lock(&self, cancel: &Cancel) -> Result<MutexGuard<'_, Option<Kept>>, Cancelled> {
        loop {
            match self.0.try_lock() {
                Ok(kept) => return Ok(kept),
                Err(TryLockError::Poisoned(poisoned)) => return Ok(poisoned.into_inner()),
                Err(TryLockError::WouldBlock) => {
                    cancel.check()?;
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
        }
    }

    /// The one for `found`, made now if it is not that of the last time.
    pub(super) fn get(
        &self,
        found: &Arc<FoundChannel>,
        cell: f64,
        task: &Task,
    ) -> Result<Arc<PreparedBlisk>, PlanJobError> {
        let mut kept = self.lock(&task.cancel)?;
        if let Some((of, ready)) = &*kept
            && Arc::ptr_eq(of, found)
            && ready.has_cell(cell)
        {
            return Ok(ready.clone());
        }
        // Two fields at a time would take twice the memory.
        *kept = None;
        let (blisk, exact, channel) = (found.blisk.clone(), found.exact.clone(), found.channel.clone());
        let ready = Arc::new(PreparedBlisk::new(blisk, exact, channel, cell, task)?);
        *kept = Some((found.clone(), ready.clone()));
        Ok(ready)
    }
}
