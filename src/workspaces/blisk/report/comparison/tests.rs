use super::*;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;

fn electrode(certified: bool) -> RunElectrode {
    let smoothness = |axis, unit, rms| Smoothness {
        axis,
        unit,
        total_variation: 7.0,
        rms_second_difference: rms,
        max_second_difference: 0.5,
        sign_changes_first_difference: 3,
    };
    let course = AxisCourse {
        axis: 'C',
        unit: "deg",
        nodes: vec![[0.0, 0.0], [10.0, 5.0]],
        curve: if certified { vec![[0.0, 0.0], [5.0, 3.0], [10.0, 5.0]] } else { Vec::new() },
    };
    RunElectrode {
        index: 1,
        share: String::new(),
        enters_from: "-x",
        withdrawn: Axis::X,
        verdict: "jams <here>, at node 2".to_owned(),
        certified,
        certified_clearance_mm: certified.then_some(0.0995),
        least_clearance_mm: certified.then_some(0.1),
        nodes: 2,
        rows: if certified { 12 } else { 0 },
        search_seconds: 1.5,
        certificate_seconds: 0.25,
        objective_sums: ObjectiveReport { smoothness: 0.5, centring: 1.5, total: 1.0 },
        smoothness: if certified { vec![smoothness('Y', "mm", 0.25), smoothness('C', "deg", 0.125)] } else { vec![] },
        curves: vec![course],
    }
}

fn comparison() -> Comparison {
    let run = |strategy, electrodes| Run { strategy, failure: None, electrodes };
    let failed =
        Run { strategy: Strategy::Centreline, failure: Some("no <centreline>".to_owned()), electrodes: Vec::new() };
    Comparison {
        schema: SCHEMA,
        program_version: "0",
        inputs: Vec::new(),
        step_mm: 0.8,
        parameters: FIELDS.list(&PlanJob::demonstration()).without("plan.strategy"),
        runs: vec![
            run(Strategy::Genetic, vec![electrode(true)]),
            run(Strategy::FreeTravel, vec![electrode(false)]),
            failed,
        ],
    }
}

#[test]
fn a_row_stands_for_each_strategy_electrode_and_axis() {
    let csv = comparison().csv();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let named: Vec<[&str; 3]> =
        rows[1..].iter().map(|row| ["strategy", "certified", "axis"].map(|name| row[column(name)])).collect();
    let expected =
        [["genetic", "true", "Y"], ["genetic", "true", "C"], ["free-travel", "false", ""], ["centreline", "false", ""]];
    assert_eq!(named, expected);
    assert_eq!((rows[2][column("rms_second_difference")], rows[2][column("unit")]), ("0.125", "deg"));
    assert_eq!((rows[1][column("certified_clearance_mm")], rows[3][column("certified_clearance_mm")]), ("0.0995", ""));
    assert_eq!((rows[1][column("search_s")], rows[1][column("objective_total_sum")]), ("1.5", "1"));
}

#[test]
fn the_page_shows_every_run_escapes_and_closes_what_it_opens() {
    let html = comparison().html().unwrap();
    for strategy in ["</i>genetic", "</i>free\u{2011}travel", "centreline"] {
        assert!(html.contains(strategy), "{strategy}");
    }
    assert!(html.contains("jams &lt;here&gt;") && html.contains("no &lt;centreline&gt;") && !html.contains("http"));
    for tag in ["section", "table", "tr", "td", "svg", "div", "p", "main", "i", "span"] {
        let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    // A curve of the run with a path, none of the one without, and two nodes of each, in their colours.
    let count = |what: &str| html.matches(what).count();
    assert_eq!(["path class=\"c0\"", "circle class=\"c0\"", "circle class=\"c2\""].map(count), [1, 2, 2]);
    assert!(html.contains("Certified: genetic."));
    assert!(html.contains("<td>Spark gap") && !html.contains("<td>Strategy</td>"), "each run has its own strategy");
}

#[test]
fn a_run_is_certified_if_all_its_electrodes_are() {
    let run = |electrodes| Run { strategy: Strategy::Global, failure: None, electrodes };
    assert!(run(vec![electrode(true), electrode(true)]).is_certified());
    assert!(!run(vec![electrode(true), electrode(false)]).is_certified() && !run(vec![]).is_certified());
    let none = Comparison { runs: vec![run(vec![electrode(false)])], ..comparison() };
    assert!(comparison().has_certified() && !none.has_certified());
    assert!(none.html().unwrap().contains("No strategy has a certified path."));
}
