//! The workspaces, each in a folder of its own, and what the window and all of them share: the trait
//! [`Workspace`](workspace::Workspace), commands as data, and the [`Context`](context::Context) through which a
//! workspace asks the window. [`registry`] is the one place that lists them.

pub mod blisk;
pub mod commands;
pub mod context;
pub mod flank;
pub mod hands;
pub mod message;
pub mod mold;
pub mod moved_files;
pub mod news;
pub mod opening;
pub mod preferences;
pub mod registry;
pub mod setup;
pub mod technology;
pub mod workspace;

/// Asserts that every one of `beyond`, parameters of which this key is wrong, is refused by the label of its field.
#[cfg(test)]
fn says_labels<P: files::Params>(fields: &files::FieldTable<P>, beyond: Vec<(String, P)>) {
    for (key, wrong) in beyond {
        let problem = wrong.validate().expect_err(&key);
        assert_eq!(problem.key, key);
        let said = fields.in_window(&problem);
        let label = fields.find(&key).unwrap().label;
        assert!(said.starts_with(&label) && !said.contains(&key) && !said.contains('_'), "{key}: {said}");
    }
}
