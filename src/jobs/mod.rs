//! Floor 5: whole jobs as pure functions of their inputs, a [`Progress`](task::Progress) and a
//! [`Cancel`](task::Cancel). They read and write no file, except where a module says so.

pub mod auto_size;
pub mod compare;
pub mod electrodes;
pub mod finish;
pub mod flank;
pub mod flank_electrode;
pub mod flank_export;
pub mod flank_files;
pub mod flank_maps;
pub mod flank_report;
pub mod flank_work;
pub mod live;
pub mod mold;
pub mod news;
pub mod pipeline;
pub mod plan;
pub mod plan_files;
pub mod plan_pictures;
pub mod plan_report;
pub mod prepared_blisk;
pub mod simulate;
pub mod sizing;
pub mod stages;
pub mod uncut;
pub mod uncut_compare;
pub mod uncut_preview;
pub mod uncut_report;
pub mod worker;
