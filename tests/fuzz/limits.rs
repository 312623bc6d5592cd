//! Limit of memory that every input is held to. Time is limited by libFuzzer.

use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

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

/// Runs `work`; an error says that it took too much, or that it panicked. The memory is that of the whole program: one test at a
/// time runs in it.
pub fn within(work: impl FnOnce()) -> Result<(), String> {
    let before = TAKEN.load(Relaxed);
    PEAK.store(before, Relaxed);
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| "it panics".to_owned())?;
    let most = PEAK.load(Relaxed).saturating_sub(before);
    if most > MOST { Err(format!("it takes {} MiB", most >> 20)) } else { Ok(()) }
}
