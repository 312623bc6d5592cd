use proptest::prelude::*;
use serde::Deserialize;

use super::*;
use crate::{Validate, Variant, Word, word};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Params {
    name: String,
    mesh: Option<std::path::PathBuf>,
    seed: u64,
    grid: [usize; 2],
    sides_mm: Vec<f64>,
    blades: Value,
    channels: Value,
    plan: Plan,
    stages: Vec<Stage>,
    unlisted_mm: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Plan {
    strategy: Strategy,
    population: u32,
    step_mm: f64,
    objective: Objective,
    #[serde(skip_serializing_if = "Option::is_none")]
    bound_mm: Option<f64>,
    is_covering: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Strategy {
    Global,
    Genetic,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "least", deny_unknown_fields)]
enum Objective {
    Sum,
    Bounded { overcut_mm: Option<f64> },
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stage {
    name: String,
    gap_mm: f64,
}

impl Default for Plan {
    fn default() -> Self {
        let (strategy, objective) = (Strategy::Global, Objective::Sum);
        Self { strategy, population: 40, step_mm: 1.0, objective, bound_mm: None, is_covering: false }
    }
}

impl Default for Params {
    fn default() -> Self {
        Self {
            name: "part".to_owned(),
            mesh: None,
            seed: 1,
            grid: [100, 50],
            sides_mm: vec![10.0, 12.5],
            blades: "auto".into(),
            channels: "own".into(),
            plan: Plan::default(),
            stages: vec![Stage { name: "rough".to_owned(), gap_mm: 0.2 }],
            unlisted_mm: 3.0,
        }
    }
}

const CHANNELS: &[Word] = &[word("own", "planned one", "")];
const STRATEGIES: &[Word] = &[word("global", "global search", ""), word("genetic", "genetic search", "")];
const OBJECTIVES: &[Variant] = &[
    Variant { word: word("sum", "sum", ""), new: "{ least = \"sum\" }" },
    Variant { word: word("bounded", "bounded", ""), new: "{ least = \"bounded\", overcut_mm = 0.01 }" },
];
const STAGE: &[Field] = &[
    Field::text("name", "Name").help("What it is called."),
    Field::number("gap_mm", "Spark gap", "mm", 0.0, 5.0).help("How far material is taken."),
];
const TABLE: FieldTable<Params> = FieldTable::new(&[
    Group {
        section: "Part",
        name: "Mesh",
        is_folded: false,
        fields: &[
            Field::text("name", "Name").help("What it is called."),
            Field::file("mesh", "Mesh").help("The part."),
            Field::integer("blades", "Blades", 2.0, 1000.0).or_word("auto", 60.0).help("How many there are."),
            Field::choice_or("channels", "Channels", CHANNELS, "numbers as in [0, 1]").help("Which of them."),
        ],
    },
    Group {
        section: "Plan",
        name: "Path",
        is_folded: false,
        fields: &[
            Field::choice("plan.strategy", "Strategy", STRATEGIES).help("How the path is searched for."),
            Field::integer("plan.population", "Population", 4.0, 1e4)
                .when(When::Is("plan.strategy", &["genetic"]))
                .help("Individuals."),
            Field::number("plan.step_mm", "Step", "mm", 0.01, 10.0).symbol("k").slider(0.1, 2.0).help("Between nodes."),
            Field::variant("plan.objective", "Least", "least", OBJECTIVES).help("What is made least."),
            Field::number("plan.objective.overcut_mm", "Overcut to", "mm", 0.0, 1.0)
                .or_nothing(0.01)
                .when(When::Is("plan.objective.least", &["bounded"]))
                .help("Greatest overcut."),
            Field::number("plan.bound_mm", "Bound", "mm", 0.0, 1.0).or_nothing(0.5).help("A bound."),
            Field::flag("plan.is_covering", "Cover all").help("Go past the ends."),
            Field::integer("seed", "Seed", 0.0, f64::INFINITY).help("The same seed gives the same path."),
        ],
    },
    Group {
        section: "Plan",
        name: "Fine points",
        is_folded: true,
        fields: &[
            Field::numbers("grid", "Grid", "", 2.0, 1000.0).whole().count(2).help("Samples along u and v."),
            Field::numbers("sides_mm", "Sides", "mm", 0.1, 1e4).help("Sides of blanks."),
            Field::rows("stages", "Stages", STAGE, "{ name = \"finish\", gap_mm = 0.05 }").help("The burns."),
        ],
    },
]);

impl Validate for Params {
    fn validate(&self) -> Result<(), Invalid> {
        TABLE.check(self)
    }
}

fn set(key: &str, text: &str) -> Result<Params, Invalid> {
    TABLE.set(&Params::default(), key, text)
}

#[test]
fn the_table_is_sound_and_an_unsound_one_is_found_out() {
    assert_eq!(TABLE.audit(&Params::default(), |p| p.validate().is_ok()), Vec::<String>::new());
    const WRONG: FieldTable<Params> = FieldTable::new(&[Group {
        section: "",
        name: "",
        is_folded: false,
        fields: &[
            Field::number("plan.stp_mm", "Step", "mm", 0.0, 1.0).help("Misspelt."),
            Field::number("plan.step_mm", "Step", "mm", 2.0, 3.0).help("The default is beyond."),
            Field::choice("plan.strategy", "Strategy", &[word("other", "", "")]).help("No such word."),
            Field::number("unlisted_mm", "Unlisted", "mm", 0.0, 5.0).help("Validation knows no range."),
        ],
    }]);
    let faults = WRONG.audit(&Params::default(), |p| p.validate().is_ok());
    for words in ["plan.stp_mm", "plan.step_mm is 1", "other", "unlisted_mm = 5.005 is taken"] {
        assert!(faults.iter().any(|fault| fault.contains(words)), "{words}: {faults:?}");
    }
}

#[test]
fn values_are_set_by_key_and_read_again() {
    assert_eq!(set("plan.step_mm", "0,5").unwrap().plan.step_mm, 0.5);
    assert_eq!(set("plan.strategy", "genetic").unwrap().plan.strategy, Strategy::Genetic);
    assert_eq!(set("plan.strategy", "\"genetic\"").unwrap().plan.strategy, Strategy::Genetic);
    assert_eq!(set("seed", "18446744073709551615").unwrap().seed, u64::MAX);
    assert_eq!(set("grid", "60x40").unwrap().grid, [60, 40]);
    assert_eq!(set("sides_mm", "12,5; 8").unwrap().sides_mm, [12.5, 8.0]);
    assert_eq!(set("blades", "23").unwrap().blades, Value::from(23));
    assert_eq!(set("blades", "auto").unwrap().blades, Value::from("auto"));
    assert_eq!(set("channels", "own").unwrap().channels, Value::from("own"));
    assert_eq!(set("channels", "0,1").unwrap().channels, Value::from("0,1"), "what it means is the struct's affair");
    let list = set("channels", "[0, 1]").unwrap();
    assert_eq!((&list.channels, TABLE.get(&list, "channels")), (&Value::from(vec![0, 1]), Ok("[0, 1]".to_owned())));
    assert!(set("channels", " ").unwrap_err().to_string().contains("must be one of own, or numbers as in [0, 1]"));
    assert_eq!(set("mesh", "a/b.stl").unwrap().mesh, Some("a/b.stl".into()));
    assert_eq!(set("plan.bound_mm", "0.25").unwrap().plan.bound_mm, Some(0.25), "a key that the file would not have");
    assert_eq!(set("plan.objective", "bounded").unwrap().plan.objective, Objective::Bounded { overcut_mm: Some(0.01) });
    assert_eq!(set("stages[0].gap_mm", "0.3").unwrap().stages[0].gap_mm, 0.3);
    let two = set("stages", "[{ name = \"a\", gap_mm = 0.1 }, { name = \"b\", gap_mm = 0.05 }]").unwrap();
    assert_eq!(two.stages[1], Stage { name: "b".to_owned(), gap_mm: 0.05 });
    assert_eq!(TABLE.reset(&two, "stages").unwrap(), Params::default());
    let bounded = TABLE.set(&set("plan.objective", "bounded").unwrap(), "plan.objective.overcut_mm", "none").unwrap();
    assert_eq!(bounded.plan.objective, Objective::Bounded { overcut_mm: None });
}

#[test]
fn the_command_line_is_told_keys_and_the_window_labels() {
    for (key, text, command_line, window) in [
        (
            "plan.step_mm",
            "20",
            "plan.step_mm is 20: must be from 0.01 to 10 mm",
            "Step is 20 mm: must be from 0.01 to 10 mm",
        ),
        ("plan.step_mm", "wide", "plan.step_mm is wide: must be", "Step is wide: must be"),
        ("plan.step_mm", "nan", "plan.step_mm is nan: must be", "Step is nan"),
        ("seed", "-1", "seed is -1: must be at least 0, a whole number", "Seed is -1"),
        ("seed", "1.5", "seed is 1.5: must be at least 0, a whole number", "Seed is 1.5"),
        ("plan.strategy", "best", "plan.strategy is best: must be one of global, genetic", "Strategy is best"),
        ("grid", "100", "grid is 100: 2 numbers", "Grid is 100"),
        ("plan.is_covering", "2", "must be true or false", "Cover all is 2"),
        ("stages[0].gap_mm", "9", "stages[0].gap_mm is 9: must be from 0 to 5 mm", "Stages 1, Spark gap is 9 mm"),
        ("stages[3].gap_mm", "1", "add the row", "Stages 4, Spark gap: there is no such"),
        ("stages", "[{ name = \"a\", gap_mm = -1.0 }]", "stages[0].gap_mm is -1", "Stages 1, Spark gap is -1 mm"),
        ("plan.objective.overcut_mm", "0.5", "plan.objective.overcut_mm", "Overcut to"),
        ("plan.stp_mm", "1", "plan.stp_mm: there is no such parameter; did you mean plan.step_mm?", "stp: there is no"),
        ("gap_mm", "1", "there is no such parameter; did you mean stages[0].gap_mm?", "gap: there is no"),
        ("plan.gap", "1", "did you mean stages[0].gap_mm?", "gap: there is no"),
    ] {
        let problem = set(key, text).unwrap_err();
        assert!(problem.to_string().contains(command_line), "{key} = {text}: {problem}");
        let shown = TABLE.in_window(&problem);
        assert!(shown.starts_with(window) && !shown.contains(&format!("{key} is")), "{key} = {text}: {shown}");
    }
    let message = "too coarse: change plan.strategy, [stages[1].gap_mm] or step_mm, e.g. 1.5.";
    let labelled = "too coarse: change \"Strategy\", [\"Stages 2, Spark gap\"] or \"Step\", e.g. 1.5.";
    assert_eq!(TABLE.labelled(message), labelled);
    let plain = "both stages of the plan have one name";
    assert_eq!(TABLE.labelled(plain), plain, "keys of one word are words");
    // What is like no key is not guessed at.
    assert!(set("foobar", "1").unwrap_err().to_string().ends_with("there is no such parameter"));
    // Validation speaks of parameters that no form shows, too.
    let hidden = Invalid::new("milling.workpiece.zero_mm", 9, "must be on the table");
    assert_eq!(TABLE.in_window(&hidden), "zero is 9: must be on the table");
}

#[test]
fn what_a_form_types_beyond_a_range_is_kept_and_shown_as_wrong() {
    let values = TABLE.values(&Params::default());
    let typed = TABLE.put(&values, "plan.step_mm", 50.0.into()).unwrap();
    assert_eq!(typed.plan.step_mm, 50.0);
    assert_eq!(typed.validate().unwrap_err().key, "plan.step_mm");
    assert!(TABLE.put(&values, "plan.step_mm", "wide".into()).is_err(), "the struct cannot hold it");
    let genetic = set("plan.strategy", "genetic").unwrap();
    let population = TABLE.find("plan.population").unwrap().field;
    assert!(!population.is_shown(&values) && population.is_shown(&TABLE.values(&genetic)));
    let mut hidden = Params::default();
    hidden.plan.population = 1;
    assert!(hidden.validate().is_ok(), "it does not count");
    hidden.plan.strategy = Strategy::Genetic;
    assert!(hidden.validate().is_err());
}

#[test]
fn a_change_is_called_after_its_parameter() {
    let start = Params::default();
    let change = |edit: fn(&mut Params)| {
        let mut now = start.clone();
        edit(&mut now);
        TABLE.change(&start, &now)
    };
    assert_eq!(change(|_| ()), "");
    assert_eq!(change(|p| p.plan.step_mm = 2.0), "Step");
    assert_eq!(change(|p| p.stages[0].gap_mm = 2.0), "Stages 1, Spark gap");
    assert_eq!(change(|p| p.stages.push(p.stages[0].clone())), "Stages: row added");
    assert_eq!(change(|p| p.stages.clear()), "Stages: row removed");
    assert_eq!(change(|p| p.unlisted_mm = 1.0), "Unlisted");
    assert_eq!(change(|p| (p.seed, p.name) = (5, String::new())), "Several parameters");
}

#[test]
fn reports_and_the_manual_have_every_parameter() {
    let genetic = set("plan.strategy", "genetic").unwrap();
    let entries = TABLE.list(&genetic).entries;
    let entry = |key: &str| entries.iter().find(|e| e.key == key).unwrap();
    assert_eq!((&*entry("plan.strategy").value, entry("plan.strategy").is_default), ("genetic search", false));
    assert_eq!(
        (&*entry("plan.step_mm").value, entry("plan.step_mm").unit, entry("plan.step_mm").symbol),
        ("1", "mm", "k")
    );
    assert_eq!(entry("stages[0].gap_mm").label, "Stages 1, Spark gap");
    assert!(!entries.iter().any(|e| e.key == "plan.objective.overcut_mm"), "it does not count");
    let unlisted = entry("unlisted_mm");
    assert_eq!((&*unlisted.label, &*unlisted.value, unlisted.unit), ("Unlisted", "3.0", "mm"), "no field describes it");
    assert_eq!(entries.last(), Some(unlisted), "what has a field is not told twice");
    let manual = TABLE.markdown(&Params::default());
    for field in TABLE.fields() {
        assert!(manual.contains(&format!("| `{}` |", field.key)) && manual.contains(field.help), "{}", field.key);
    }
    assert!(manual.contains("`stages[N].gap_mm`"), "{manual}");
}

#[test]
fn hostile_keys_and_texts_are_refused() {
    let deep = "[".repeat(100_000);
    for key in
        ["", ".", "[0]", "stages[", "stages[99999999999].gap_mm", "stages[-1].gap_mm", "plan", "stages[0]", &deep]
    {
        assert!(set(key, "1").is_err(), "{key:.30}");
    }
    for text in ["1 }, {", "{}", "1\nb = 2", &deep, "[{ name = \"a\", gap_mm = 1e999 }]"] {
        assert!(set("stages", text).is_err(), "{text:.30}");
    }
}

proptest! {
    #[test]
    fn every_value_is_set_from_the_text_that_it_is_shown_as(
        step in 0.01..10.0_f64, seed: u64, grid in [2..1000_usize, 2..1000], bound in prop::option::of(0.0..1.0_f64),
        sides in prop::collection::vec(0.1..1e4_f64, 0..5), name in "[a-z]{1,9}",
        gaps in prop::collection::vec(0.0..5.0_f64, 0..4),
    ) {
        let stages = gaps.into_iter().map(|gap_mm| Stage { name: name.clone(), gap_mm }).collect();
        let plan = Plan { step_mm: step, bound_mm: bound, ..Plan::default() };
        let wanted = Params { seed, grid, sides_mm: sides, name, plan, stages, ..Params::default() };
        let mut made = Params::default();
        for field in TABLE.fields().filter(|field| field.is_shown(&TABLE.values(&wanted))) {
            made = TABLE.set(&made, field.key, &TABLE.get(&wanted, field.key).unwrap()).unwrap();
        }
        prop_assert_eq!(&made, &wanted);
        prop_assert!(made.validate().is_ok());
    }

    #[test]
    fn no_text_for_any_key_breaks_anything(key in "[a-z_.\\[\\]0-9]{0,24}", text in "\\PC{0,24}") {
        for key in TABLE.fields().map(|f| f.key).chain([&*key]) {
            if let Ok(params) = set(key, &text) {
                prop_assert!(params.validate().is_ok(), "{key} = {text}");
            }
        }
    }
}
