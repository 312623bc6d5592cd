use super::*;
use files::report::Picture;
use nc::electrode_fixtures::set;

fn report() -> ElectrodesReport {
    ElectrodesReport::of(&set(), "<shell>", Opening::MinusX, &Datum::default(), true)
}

#[test]
fn the_sentence_names_what_is_blocked_overridden_and_not_burned() {
    let report = report();
    for words in [
        "3 electrodes with 4 burns for 3 regions: 25 minutes.",
        "Blocked by a failed check: E03.",
        "Released despite a failed check: E02-finish.",
        "enough: E02-finish.",
        "wholly: 3.",
    ] {
        assert!(report.sentence.contains(words), "{}", report.sentence);
    }
    assert!(!report.holds && !report.sentence.contains("Every check holds"));
    let idle = |r: &ElectrodesReport| r.idle_overrides.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    assert_eq!(idle(&report), ["E99:leftover"]);
    let mut good = set();
    good.regions.pop();
    good.checks.iter_mut().flatten().for_each(|finding| finding.holds = true);
    let whole = good;
    let good = ElectrodesReport::of(&whole, "", Opening::PlusZ, &Datum::default(), true);
    assert!(
        good.holds && good.blocked.is_empty() && good.sentence.ends_with("Every check holds."),
        "{}",
        good.sentence
    );
    let uncertain = ElectrodesReport::of(&whole, "", Opening::PlusZ, &Datum::default(), false);
    for said in [&uncertain.sentence, &uncertain.sentence_with(&whole, &[])] {
        assert!(!said.contains("Every check holds") && said.contains("see the warnings"), "{said}");
    }
    assert_eq!(idle(&good), ["E02-finish:leftover", "E99:leftover"], "an override of what holds does nothing");
    let mut none = set();
    (none.electrodes, none.checks, none.regions) = Default::default();
    assert!(
        ElectrodesReport::of(&none, "", Opening::PlusZ, &Datum::default(), true)
            .sentence
            .contains("no electrode is made")
    );
    none.regions = set().regions;
    let sentence = ElectrodesReport::of(&none, "", Opening::PlusZ, &Datum::default(), true).sentence;
    assert!(sentence.starts_with("0 electrodes with 0 burns for 3 regions: 0 minutes."), "{sentence}");
}

#[test]
fn regions_know_their_electrodes_their_division_and_their_trouble() {
    let report = report();
    let electrodes: Vec<Vec<String>> = report.regions.iter().map(|r| r.electrodes.clone()).collect();
    assert_eq!(electrodes, [vec!["E01", "E02-finish", "E03"], vec!["E01", "E02-finish"], vec![]]);
    assert_eq!(report.regions.iter().map(|r| r.parts).collect::<Vec<_>>(), [2, 1, 0]);
    let tree = report.regions[0].division.as_ref().unwrap();
    // The normal is along Y, the cut along X.
    assert_eq!(
        tree.text,
        "cut through 1.500, -2.000 along 0.0\u{b0}, parts overlap by 0.3 mm, 2 H-edges in 1 chain, 3.0 mm"
    );
    assert_eq!(tree.parts.iter().map(|p| p.text.as_str()).collect::<Vec<_>>(), ["part R1.1", "part R1.2"]);
    assert_eq!(report.regions[2].trouble.as_deref(), Some("no room for a tip <of 0.3 mm>"));
    let json: serde_json::Value = serde_json::from_str(&report.json().unwrap()).unwrap();
    assert_eq!(json["regions"][0]["left_thickness_mm"], 0.03);
    assert_eq!(json["table"]["electrodes"][2]["state"], "blocked");
    assert_eq!(json["parameters"]["stages"][1]["gap_mm"], 0.05);
}

#[test]
fn a_cut_that_leads_to_one_part_says_why() {
    let text = |lacks_thin: bool| {
        let mut set = set();
        let tree = set.regions[0].tree.as_mut().unwrap();
        tree.parts.truncate(1);
        tree.lacks_thin = lacks_thin;
        ElectrodesReport::of(&set, "", Opening::PlusZ, &Datum::default(), true).regions[0]
            .division
            .as_ref()
            .unwrap()
            .text
            .clone()
    };
    assert!(
        text(false).ends_with("2 H-edges in 1 chain, 3.0 mm: beyond it nothing is to be burned"),
        "{}",
        text(false)
    );
    assert!(text(true).ends_with("thinner than the least size beyond it is left to later stages"), "{}", text(true));
}

#[test]
fn parts_that_only_an_earlier_stage_has_are_told_with_its_division() {
    let mut set = set();
    let last = set.regions[0].tree.clone().unwrap();
    set.regions[0].earlier = vec![(0, last.clone())];
    let divisions = |set: &ElectrodeSet| {
        let report = ElectrodesReport::of(set, "", Opening::PlusZ, &Datum::default(), true);
        (report.regions[0].earlier_divisions.clone(), report.html(&ElectrodesPage::default()).unwrap())
    };
    assert!(divisions(&set).0.is_empty(), "the same parts are told once");
    set.regions[0].earlier[0].1.parts[1].part = Some(2);
    let (told, page) = divisions(&set);
    let [earlier] = &told[..] else { panic!("{told:?}") };
    assert_eq!((earlier.stage.as_str(), earlier.division.parts[1].text.as_str()), ("rough", "part R1.3"));
    assert!(page.contains("rough stage: ") && page.contains("part R1.3"));
}

#[test]
fn the_page_stands_alone_and_holds_everything() {
    let pictures = [Picture {
        file: String::new(),
        title: "All <electrodes>".to_owned(),
        caption: String::new(),
        legend: Vec::new(),
        png: vec![0x89, b'P', b'N', b'G'],
    }];
    let times = [steps::StepTime { step: "Electrode <design>".to_owned(), stages: Vec::new(), seconds: 90.0 }];
    let page = report().html(&ElectrodesPage { times: &times, pictures: &pictures }).unwrap();
    for words in [
        "&lt;shell&gt;",
        "E03 is blocked.",
        "gouge: it comes to 0.0100 mm of the mold: too deep a burn",
        "E02-finish is overridden.",
        "Override of E99:leftover: there is no electrode",
        "<b>E02-finish.</b> no holder is large enough for a blank of 10 x 12 mm",
        "A stage leaves a layer for the next one",
        "no room for a tip &lt;of 0.3 mm&gt;",
        "12.3457",
        "\u{2212}135.0000",
        "cut through 1.500, -2.000",
        "0.0300",
        "data:image/png;base64,iVBORw==",
        "All &lt;electrodes&gt;",
        "Electrode &lt;design&gt;",
        "<td class=\"num\">90.00</td>",
        "<td class=\"num\">1.500</td>",
        "\u{2212}X of the file",
        "Positions are from the work datum: origin of the file, at 0.000, 0.000, 0.000 of",
        "not made",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("<script") && !page.contains("http:") && !page.contains("https:"));
    for tag in ["section", "table", "div", "ul", "li", "figure", "p", "dl"] {
        let count = |text: &str| page.matches(text).count();
        let opened = count(&format!("<{tag}>")) + count(&format!("<{tag} "));
        assert!(opened > 0 && opened == count(&format!("</{tag}>")), "{tag}");
    }
}
