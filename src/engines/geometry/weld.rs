//! One number for all points at the same place.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use glam::DVec3;

/// A place as it is compared, to the last bit; minus zero is zero.
pub fn place(p: DVec3) -> [u64; 3] {
    (p + 0.0).to_array().map(f64::to_bits)
}

/// Gives equal points the same number; numbers go up in the order in which points first come.
///
/// The map is only ever looked up, so that the result does not depend on its order.
#[derive(Debug, Default)]
pub struct Weld {
    numbers: HashMap<[u64; 3], u32, FixedState>,
    points: Vec<DVec3>,
}

impl Weld {
    /// An empty set with room for this number of points.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            numbers: HashMap::with_capacity_and_hasher(count, FixedState::default()),
            points: Vec::with_capacity(count),
        }
    }

    /// The number of point `p`, a new one if it has not come before.
    pub fn add(&mut self, p: DVec3) -> u32 {
        *self.numbers.entry(place(p)).or_insert_with(|| {
            self.points.push(p);
            (self.points.len() - 1) as u32
        })
    }

    /// The different points by number, each as it came first.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The different points by number, for the caller to keep.
    pub fn into_points(self) -> Vec<DVec3> {
        self.points
    }
}
