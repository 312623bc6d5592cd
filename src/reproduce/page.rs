//! The page of the reproduction, and its figures for programs.

use serde::Serialize;

use super::{Reproduced, SCHEMA};
use files::report::{PageError, Template, page};

const TEMPLATE: Template = Template { name: "reproduce.html.jinja", text: include_str!("reproduce.html.jinja") };

/// What the template is given.
#[derive(Serialize)]
struct Page<'a> {
    papers: Vec<OfPaper<'a>>,
    version: &'static str,
}

#[derive(Serialize)]
struct OfPaper<'a> {
    name: &'static str,
    title: &'static str,
    /// Words and what they mean.
    words: &'static [(&'static str, &'static str)],
    /// Verdicts in words, in the order of the outcomes.
    verdicts: Vec<&'static str>,
    #[serde(flatten)]
    of: &'a Reproduced,
}

/// The page.
pub(super) fn html(results: &[Reproduced]) -> Result<String, PageError> {
    let papers = results.iter().map(OfPaper::of).collect();
    page(&TEMPLATE, &Page { papers, version: env!("CARGO_PKG_VERSION") })
}

impl<'a> OfPaper<'a> {
    fn of(of: &'a Reproduced) -> Self {
        let verdicts = of.outcomes.iter().map(|outcome| outcome.verdict.words()).collect();
        Self { name: of.paper.name(), title: of.paper.title(), words: of.paper.words(), verdicts, of }
    }
}

/// The figures; pictures stand in the page.
pub(super) fn json(results: &[Reproduced]) -> String {
    let mut value = serde_json::json!({ "schema": SCHEMA, "papers": results });
    let outcomes = value["papers"].as_array_mut().into_iter().flatten().flat_map(|of| of["outcomes"].as_array_mut());
    for outcome in outcomes.flatten().filter_map(|outcome| outcome.as_object_mut()) {
        outcome.remove("pictures");
        outcome.remove("plots");
    }
    format!("{value:#}\n")
}
