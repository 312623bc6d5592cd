//! Floor 5: the parameters of a whole job, as job files give them.

pub mod job_file;

pub use job_file::{JobFileError, PlanJob};
