//! The page of a report on electrodes: what its template needs beside the report's figures.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::steps::StepTime;
use crate::workspaces::mold::report::ElectrodesReport;
use files::Entry;
use files::report::{PageError, Picture, Template};

/// What a page on electrodes shows beside the report.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct ElectrodesPage<'a> {
    /// Times of the steps; none where they are not known.
    pub times: &'a [StepTime],
    /// Pictures.
    pub pictures: &'a [Picture],
}

/// The page of `report`.
pub(super) fn page(report: &ElectrodesReport, shown: &ElectrodesPage) -> Result<String, PageError> {
    const TEMPLATE: Template = Template { name: "report.html.jinja", text: include_str!("report.html.jinja") };
    #[derive(Serialize)]
    struct Page<'a> {
        report: &'a ElectrodesReport,
        parameters: &'a [Entry],
        #[serde(flatten)]
        shown: &'a ElectrodesPage<'a>,
        /// Electrodes to make; a body that several stages share is one piece.
        pieces: u32,
        /// Whether volumes and minutes of stages or of tips on one base need an explanation.
        needs_model: bool,
        /// What minutes and wear rest on, and what is missing.
        rests_on: Vec<&'a String>,
    }
    let electrodes = &report.table.electrodes;
    let mut bodies = BTreeMap::new();
    for e in electrodes {
        let body = bodies.entry(e.family.as_ref().map_or(&e.name, |family| &family.name)).or_insert(0);
        *body = e.quantity.max(*body);
    }
    let mut rests_on: Vec<&String> = Vec::new();
    for line in electrodes.iter().flat_map(|e| &e.rests_on) {
        if !rests_on.contains(&line) {
            rests_on.push(line);
        }
    }
    let stages = electrodes.iter().map(|e| e.stage.as_str()).collect::<BTreeSet<_>>().len();
    let page = Page {
        report,
        parameters: &report.parameters.entries,
        shown,
        pieces: bodies.into_values().fold(0, u32::saturating_add),
        rests_on,
        needs_model: stages > 1 || electrodes.iter().flat_map(|e| &e.burns).any(|burn| burn.parts.len() > 1),
    };
    files::report::page(&TEMPLATE, &page)
}
