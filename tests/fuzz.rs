//! Readers and engines on input that nobody would make on purpose: files that were cut, mixed and overwritten, and parts that are
//! valid but nasty. Whatever they are given, they answer, soon, and within their memory.
//!
//! The ordinary tests take a fixed number of inputs and those of `tests/data/fuzz`. `scripts/fuzz` has libFuzzer make inputs by the
//! coverage of the code; a file that it finds something with is tried again by the ordinary tests where it is put into
//! `tests/data/fuzz/NAME OF THE TEST`.
#![cfg_attr(fuzzing, no_main)]

#[cfg(fuzzing)]
#[path = "fuzz/guided.rs"]
mod guided;
#[path = "fuzz/limits.rs"]
mod limits;
#[path = "common/mesh_files.rs"]
mod mesh_files;
#[path = "fuzz/mutate.rs"]
mod mutate;
#[path = "fuzz/parts.rs"]
mod parts;
#[path = "fuzz/readers.rs"]
mod readers;
#[path = "fuzz/target.rs"]
mod target;

#[global_allocator]
static MEMORY: limits::Memory = limits::Memory;

/// A test of each target, and the list of them.
macro_rules! targets {
    ($($module:ident::$name:ident,)*) => {
        #[cfg(fuzzing)]
        const NAMED: &[(&str, fn() -> target::Target)] = &[$((stringify!($name), $module::$name)),*];
        $(#[test]
        fn $name() {
            $module::$name().test(stringify!($name));
        })*
    };
}

targets! {
    readers::meshes,
    readers::step_files,
    readers::points_of_scans,
    readers::guides_of_ruled_surfaces,
    readers::measured_sections,
    readers::path_tables,
    readers::projects_of_blisks,
    readers::projects_of_molds,
    readers::projects_of_flanks,
    readers::jobs,
    readers::machines,
    readers::machines_of_robots,
    readers::milling_machines,
    readers::posts,
    readers::templates_of_burn_tables,
    readers::templates_of_job_sheets,
    readers::libraries_of_cutters,
    readers::lists_of_flank_cutters,
    readers::words_for_cutters,
    readers::lists_of_holders,
    readers::technology_tables,
    readers::tables_of_presets,
    parts::wheels,
    parts::uncut_regions_and_electrodes,
    parts::ruled_surfaces,
    parts::certificates,
}
