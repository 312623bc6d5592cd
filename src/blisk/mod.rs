//! Floor 2: what a blisk is. Finds its axis, period and channels in a bare mesh, makes electrodes for a
//! channel, and makes parametric blisks.

pub mod channel;
pub mod electrode;
pub mod parametric;
pub mod profile;
