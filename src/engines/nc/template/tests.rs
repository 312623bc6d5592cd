//! Tests of templates.

use super::*;
use crate::electrode_fixtures::set;
use mold::datum::Datum;
use mold::electrode::params::Shape;
use mold::opening::Opening;

fn table() -> BurnTable {
    BurnTable::of(&set(), "shell", Opening::PlusZ, &Datum::default())
}

fn render(table: &BurnTable, template: &str, name: &str) -> Result<String, TemplateError> {
    BurnSheet::new(name.to_owned(), template.to_owned()).of(table)
}

#[test]
fn the_standard_sheet_says_positions_and_what_is_blocked() {
    let text = render(&table(), BurnTable::STANDARD, "standard").unwrap();
    let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
    assert!(line(&["SHEET", "shell"]) && line(&["opening", "+z"]), "{text}");
    assert!(line(&["3 electrodes", "4 burns", "25 min"]), "{text}");
    assert!(line(&["12.3457", "-4.5000", "20.0000", "90.0000"]), "{text}");
    assert!(line(&["Files hold the electrodes as they are milled"]) && line(&["NOTE: no holder"]), "{text}");
    assert!(line(&["E03", "BLOCKED"]), "{text}");
    assert!(line(&["E02", "OVERRIDDEN"]), "{text}");
    assert!(line(&["gouge", "failed", "too deep a burn"]), "{text}");
    assert!(!text.contains("none") && !text.contains("{"), "{text}");
    assert!(text.lines().all(|l| l == l.trim_end()), "{text}");
    let mut one = set();
    (one.params.shape, one.electrodes) = (Shape::Net, one.electrodes.drain(2..).collect());
    one.checks.drain(..2);
    let text =
        render(&BurnTable::of(&one, "shell", Opening::PlusZ, &Datum::default()), BurnTable::STANDARD, "standard")
            .unwrap();
    let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
    assert!(line(&["1 electrode, 1 burn,"]) && line(&["FILES HOLD THE SHAPE OF THE CAVITY"]), "{text}");
    assert!(line(&["TO BE MILLED SMALLER by wall 0.0500 floor 0.0500"]), "{text}");
}

#[test]
fn a_users_template_makes_a_format_of_its_own() {
    let template = "{% for e in electrodes if e.state != 'blocked' %}\n{% for b in e.burns %}\n\
        ({{ e.name|left(5) }})X{{ b.x_mm|fixed(3) }} C{{ b.c_deg|fixed(1)|right(6) }} \
        H{{ e.holder.name if e.holder }}\n\
        {% endfor %}\n{% endfor %}\nM30\n";
    let expected = "(E01  )X12.346 C  90.0 Hholder 25\n(E01  )X-1.000 C-135.0 Hholder 25\n\
                    (E02-finish)X0.000 C   0.0 H\nM30\n";
    assert_eq!(render(&table(), template, "mine").unwrap(), expected);
}

#[test]
fn text_is_not_escaped_and_nothing_is_dropped_at_the_end() {
    let mut table = table();
    table.mold = "<a> & \"b\"".to_owned();
    assert_eq!(render(&table, "{{ mold }}\n\n", "x.html").unwrap(), "<a> & \"b\"\n\n");
    assert_eq!(render(&table, "{{ -0.0001|fixed(2) }} {{ none|fixed }} {{ 3|fixed(1) }}", "x").unwrap(), "0.00 - 3.0");
}

#[test]
fn a_wrong_template_is_answered_with_the_line_and_the_remedy() {
    for (template, line, words) in [
        ("a\n{% for e in electrodes %}\n{{ e.naem }}\n{% endfor %}", 3, "naem"),
        ("a\n{{ mold|fixt }}", 2, "fixt"),
        ("\n\n{{ mold|fixed(2) }}", 3, "fixed is for numbers"),
        ("{{ missing|fixed(2) }}", 1, "undefined value: `missing|fixed(2)`"),
        ("a{{ mold }}\n{% for e in electrodes %}{{ e.name }}{{ e.naem }}{% endfor %}", 2, "undefined value: `e.naem`"),
        ("a\nb\n{% if mold %}\n", 3, "syntax"),
        ("a\n{{ mold", 2, "syntax"),
        ("{% for e in electrode %}{% endfor %}", 1, "undefined value: `electrode`"),
        ("{% include 'other' %}", 1, "include"),
        ("\n{% for a in range(9999) %}{% for b in range(9999) %}{% endfor %}{% endfor %}", 2, "too many steps"),
    ] {
        let sheet = BurnSheet::new("mine.jinja".to_owned(), template.to_owned());
        let error = sheet.render(10_000, &Value::from(Serde(table()))).unwrap_err();
        let said = error.to_string();
        let TemplateError::Wrong { line: Some(found), .. } = error else { panic!("{template:?}: {said}") };
        // The end of a text counts as the line of its last character or as the next.
        assert!(found == line || found == template.lines().count(), "{template:?}: {said}");
        assert!(said.starts_with(&format!("mine.jinja: line {found}: ")) && said.contains(words), "{said}");
        assert_eq!(said.lines().count(), 1);
    }
}

fn job_sheet(template: &str) -> JobSheet {
    JobSheet::new("mine.jinja".to_owned(), template.to_owned())
}

fn jobs() -> [JobFile; 2] {
    JobFile::examples().try_into().unwrap()
}

#[test]
fn the_standard_job_sheet_says_what_is_known_and_what_is_not() {
    let [full, sparse] = jobs();
    let text = JobSheet::standard().of(&full).unwrap();
    let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
    assert!(line(&["JOB SHEET", "example"]) && line(&["Wheel with 60 channels"]), "{text}");
    assert!(line(&["copper, 2 x"]) && line(&["orbit circular 0.1000"]) && line(&["to step S1"]), "{text}");
    assert!(line(&["E1.L1", "12.3457", "-4.5000", "6.0000", "62.5", "feed path_1.csv, copying path_1.csv"]), "{text}");
    assert!(line(&["base", "1.0000", "2.0000", "3.0000", "0.00000", "1.00000"]), "{text}");
    let text = JobSheet::standard().of(&sparse).unwrap();
    let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
    assert!(line(&["Mold."]) && line(&["material not given; electrodes needed"]), "{text}");
    assert!(line(&["technology not given; end wear not considered"]), "{text}");
    assert!(text.lines().all(|l| l == l.trim_end()) && !text.contains("none,"), "{text}");
}

/// Two templates as a cell and a tool room would have them.
#[test]
fn users_templates_map_values_and_format_numbers() {
    let [full, _] = jobs();
    let cell = "{% for e in electrodes %}{% for l in e.locations %}{% for o in l.operations %}\n\
        JOB={{ o.id }};TYPE={{ o.kind|mapped({'sink': 1, 'feed': 2, 'copying': 3}) }};X={{ l.position.x_mm|fixed(2, \
        point=',', plus=true) }};Y={{ l.position.y_mm|fixed(2, point=',', plus=true) }};MAT={{ e.material|mapped({'copper': \
        'CU'}, 'UNKNOWN') }}\n{% endfor %}{% endfor %}{% endfor %}";
    let expected = "JOB=E1.L1.O1;TYPE=2;X=+12,35;Y=-4,50;MAT=CU\nJOB=E1.L1.O2;TYPE=3;X=+12,35;Y=-4,50;MAT=CU\n";
    assert_eq!(job_sheet(cell).of(&full).unwrap().replace("\n\n", "\n").trim_start(), expected);
    let room = "{% for e in electrodes %}{{ e.name }}: {{ e.quantity|required('quantity of ' ~ e.name) }} of \
        {{ e.material|required('material of ' ~ e.name)|upper }}\n{% endfor %}";
    assert_eq!(job_sheet(room).of(&full).unwrap(), "E01: 2 of COPPER\n");
}

#[test]
fn all_required_values_that_are_missing_are_named_together() {
    let [full, sparse] = jobs();
    let template = "{% for e in electrodes %}{{ e.material|required('material of ' ~ e.name) }}\
        {{ e.material|required('material of ' ~ e.name) }}{{ e.stage|required('stage of ' ~ e.name) }}\
        {{ workpiece.kind|mapped({'wheel': 'W'}) }}{% endfor %}";
    assert_eq!(job_sheet(template).of(&full).unwrap(), "coppercopperfinishW");
    let error = job_sheet(template).of(&sparse).unwrap_err();
    let TemplateError::Missing { missing, .. } = &error else { panic!("{error}") };
    assert_eq!(missing[..], ["material of E01", "stage of E01", "a value for mold in a map"]);
    assert!(error.to_string().contains("mine.jinja: required values are missing: material of E01, stage"), "{error}");
    // A template with wrong words is wrong whatever is missing.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.jinja");
    for (text, is_right) in [(template, true), ("{{ none|required }}", false), ("{{ 1|mapped(2) }}", false)] {
        std::fs::write(&file, text).unwrap();
        assert_eq!(JobSheet::read(&file).is_ok(), is_right, "{text}");
    }
}

#[test]
fn a_text_that_doubles_itself_is_given_up() {
    let [full, _] = jobs();
    let template =
        "{% set ns = namespace(x='aaaaaaaaaa') %}{% for i in range(24) %}{% set ns.x = ns.x ~ ns.x %}{% endfor %}";
    let error = job_sheet(template).within(Duration::ZERO, MOST_STEPS, &full).unwrap_err().to_string();
    assert!(error.contains("mine.jinja: it takes longer than 0 s; does it make ever longer texts"), "{error}");
}

#[test]
fn a_filter_that_is_asked_for_too_much_is_refused() {
    for filter in [
        "'a'|indent(999999999999)",
        "'a'|indent(width=999999999999)",
        "'a'|indent(none, true, width=999999999999)",
        "'%999999999999d'|format(1)",
        "'%.999999999999f'|format(1)",
        "'%99999999999999999999d'|format(1)",
        "[1]|slice(999999999999, 0)",
        "[1]|batch(999999999999, 0)",
    ] {
        let error = render(&table(), &format!("{{{{ {filter} }}}}"), "mine").unwrap_err().to_string();
        assert!(error.contains("is too many, at most 1000 are written"), "{filter}: {error}");
    }
    for (usual, text) in [
        ("{{ '2000\\n3000'|indent(width=2) }}", "2000\n  3000"),
        ("{{ '%5.1f|%d'|format(1.25, 123456) }}", "  1.2|123456"),
        ("{{ [1, 2, 3]|batch(2, 5000)|list }}", "[[1, 2], [3, 5000]]"),
    ] {
        assert_eq!(render(&table(), usual, "mine").unwrap(), text);
    }
}

/// The keys of values and of what is in them.
fn keys(value: &serde_json::Value, at: &str, found: &mut std::collections::BTreeSet<String>) {
    match value {
        serde_json::Value::Object(map) => map.iter().for_each(|(key, value)| {
            found.insert(format!("{at}.{key}"));
            keys(value, &format!("{at}.{key}"), found);
        }),
        serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, at, found)),
        _ => {}
    }
}

#[test]
fn a_template_is_tried_on_all_that_a_table_may_hold_before_there_is_one() {
    let of = |table: &BurnTable| {
        let mut found = Default::default();
        keys(&serde_json::to_value(table).unwrap(), "", &mut found);
        found
    };
    let [full, several] = <[BurnTable; 2]>::try_from(BurnTable::examples()).unwrap();
    assert!(of(&full).is_superset(&of(&table())), "an example knows every key");
    for state in ["ok", "overridden", "blocked"] {
        assert!(several.electrodes.iter().any(|e| e.state.name() == state));
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.jinja");
    let read = |text: &str| {
        std::fs::write(&file, text).unwrap();
        BurnSheet::read(&file).map(drop).map_err(|e| e.to_string())
    };
    assert_eq!(read(BurnTable::STANDARD), Ok(()));
    assert_eq!(read("{% for e in electrodes %}{{ e.holder.name if e.holder else '-' }}{% endfor %}"), Ok(()));
    for (text, words) in [
        ("\n{% for e in electrodes %}{{ e.holder.name }}{% endfor %}", "line 2: undefined value: `e.holder.name`"),
        (
            "{% for e in electrodes if e.state == 'blocked' %}\n{{ e.stat }}{% endfor %}",
            "line 2: undefined value: `e.stat`",
        ),
        ("{% for e in electrodes %}", "syntax"),
    ] {
        let said = read(text).unwrap_err();
        assert!(said.contains("mine.jinja") && said.contains(words), "{said}");
    }
}

#[test]
fn a_template_is_read_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.jinja");
    std::fs::write(&file, "{{ burns }} burns\n").unwrap();
    assert_eq!(BurnSheet::read(&file).unwrap().of(&table()).unwrap(), "4 burns\n");
    std::fs::write(&file, [0xff, 0xfe]).unwrap();
    for wrong in [file, folder.path().join("none")] {
        assert!(matches!(BurnSheet::read(&wrong), Err(TemplateError::File(_))));
    }
}
