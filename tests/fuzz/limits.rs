//! Limits of time and memory that every input is held to.

use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Longest time that an input of a campaign may take.
const LONGEST: Duration = Duration::from_secs(10);
/// Most memory that an input may take beyond what was taken before (bytes).
const MOST: usize = 512 << 20;

static TAKEN: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The allocator of the system, which keeps count of what is taken.
pub struct Memory;

fn grow(size: usize) {
    PEAK.fetch_max(TAKEN.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: every call is passed on unchanged to the allocator of the system; counting touches no memory that it manages.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller keeps the contract of this function, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        grow(size);
        TAKEN.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        TAKEN.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Runs `work`; an error says which limit it broke, or that it panicked. Time is judged where `is_timed`. The memory is that of the
/// whole program: one test at a time runs in it.
pub fn within(is_timed: bool, work: impl FnOnce()) -> Result<(), String> {
    let before = TAKEN.load(Relaxed);
    PEAK.store(before, Relaxed);
    let started = Instant::now();
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| "it panics".to_owned())?;
    let (took, most) = (started.elapsed(), PEAK.load(Relaxed).saturating_sub(before));
    if is_timed && took > LONGEST {
        return Err(format!("it takes {:.1} s", took.as_secs_f64()));
    }
    if most > MOST {
        return Err(format!("it takes {} MiB", most >> 20));
    }
    Ok(())
}
