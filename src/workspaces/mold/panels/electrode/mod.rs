//! Electrodes in the workspace of molds: what is asked of them, which there are, what was checked, and how they burn.

mod arrangement;
mod checks;
pub(super) mod desk;
mod division;
mod form;
mod list;
mod strip;

pub(super) use form::show as form;
pub(super) use list::show as list;
pub(super) use strip::show as strip;
