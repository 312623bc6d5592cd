//! Files of the program: whole or absent, TOML tables, export folders, parts of reports.

pub mod atomic;
pub mod export_folder;
pub mod history;
pub mod paths;
pub mod svg_plot;
pub mod toml_file;
pub mod user_folder;
pub mod whole_file;
pub mod word_or_table;
