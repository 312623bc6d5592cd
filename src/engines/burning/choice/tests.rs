//! Tests of the choice of steps.

use proptest::prelude::*;

use super::*;
use crate::technology::{Basis, ElectrodeMaterial};

/// Steps R, S, F with every figure that choice, time and wear need.
pub(crate) fn complete() -> Technology {
    let step = |name: &str, vdi, ip_a, gap, rate, wear, stock| Step {
        name: name.to_owned(),
        vdi: Some(vdi),
        ip_a: Some(ip_a),
        gap_side_mm: Some(gap),
        rate_mm3_min: Some(rate),
        at_area_mm2: Some(100.0),
        max_density_a_cm2: Some(20.0),
        wear_percent: Some(wear),
        corner_wear_mm: Some(0.02),
        orbit_mm: Some(0.0),
        stock_next_mm: stock,
        jump_mm: Some(2.0),
        jump_every_s: Some(1.0),
        jump_speed: Some(4800.0),
        ..Step::default()
    };
    Technology {
        id: "complete".to_owned(),
        title: String::new(),
        machine: None,
        generator: None,
        source: "test".to_owned(),
        licence: None,
        basis: Basis::Measured,
        date: None,
        electrode_material: ElectrodeMaterial::Copper,
        electrode_grade: None,
        workpiece: "steel".to_owned(),
        polarity: None,
        dielectric: None,
        flushing: None,
        area_range_mm2: Some([10.0, 1000.0]),
        greatest_depth_to_width: Some(5.0),
        step: vec![
            step("R", 36.0, 20.0, 0.2, 40.0, 1.0, Some(0.1)),
            step("S", 28.0, 10.0, 0.1, 10.0, 5.0, Some(0.05)),
            step("F", 20.0, 4.0, 0.05, 2.0, 20.0, None),
        ],
    }
}

/// A burn of which all that steps R, S and F need is known.
pub(crate) fn burn(volume_mm3: f64, frontal_area_mm2: f64, until: Until) -> Burn {
    let burned_area_mm2 = Some(frontal_area_mm2);
    Burn { burned_area_mm2, depth_to_width: Some(1.0), ..Burn::single(volume_mm3, frontal_area_mm2, until) }
}

fn names(choice: &Choice) -> String {
    choice.steps.iter().map(|chosen| chosen.step.name.as_str()).collect()
}

fn until(technology: &Technology, until: Until) -> String {
    names(&choose(technology, &burn(1000.0, 100.0, until)).unwrap())
}

#[test]
fn steps_end_at_the_finish_that_is_wanted() {
    let technology = complete();
    for (vdi, steps) in [(40.0, "R"), (36.0, "R"), (35.0, "RS"), (28.0, "RS"), (24.0, "RSF"), (20.0, "RSF")] {
        assert_eq!(until(&technology, Until::Vdi(vdi)), steps, "{vdi}");
    }
    // Ra 1.0 µm is VDI 20, Ra 2.5 is VDI 27.96.
    assert_eq!(until(&technology, Until::RaUm(1.0)), "RSF");
    assert_eq!(until(&technology, Until::RaUm(2.5)), "RS");
    assert_eq!(until(&technology, Until::Step("S".to_owned())), "RS");
    let error = choose(&technology, &burn(1.0, 100.0, Until::Vdi(15.0))).unwrap_err();
    let is = BurningError::FinishNotReached { technology: "complete".into(), wanted_vdi: 15.0, finest_vdi: 20.0 };
    assert_eq!(error, is);
    let error = choose(&technology, &burn(1.0, 100.0, Until::Step("X".to_owned()))).unwrap_err().to_string();
    assert_eq!(error, "technology complete: there is no step X; its steps are R, S, F");
}

/// 20 A/cm² are allowed: 20 A need 100 mm², 10 A need 50 mm², 4 A need 20 mm².
#[test]
fn a_small_area_takes_less_current() {
    let technology = complete();
    let on = |area| choose(&technology, &burn(1000.0, area, Until::Vdi(20.0))).map(|choice| names(&choice));
    assert_eq!([100.0, 99.0, 50.0, 49.0, 20.0].map(|area| on(area).unwrap()), ["RSF", "SF", "SF", "F", "F"]);
    let error = on(16.0).unwrap_err();
    assert!(error.to_string().contains("step F has 25.00 A/cm² on this area, 20.00 are allowed"), "{error}");
    // A rough finish on a small area is burned with a finer step, unless the step is named.
    let rough = burn(1000.0, 50.0, Until::Vdi(36.0));
    assert_eq!(names(&choose(&technology, &rough).unwrap()), "S");
    assert!(choose(&technology, &burn(1000.0, 50.0, Until::Step("R".to_owned()))).is_err());
}

fn with_undersize(undersize: f64) -> Burn {
    Burn { undersize_mm: Some(undersize), ..burn(1000.0, 100.0, Until::Vdi(20.0)) }
}

#[test]
fn gap_and_orbit_stay_within_the_undersize() {
    let mut technology = complete();
    let with = |technology: &Technology, undersize| {
        let asked = with_undersize(undersize);
        choose(technology, &asked).map(|choice| (names(&choice), choice.wall_stock_mm.unwrap()))
    };
    for (undersize, steps, stock) in [(0.2, "RSF", 0.15), (0.15, "SF", 0.1), (0.05, "F", 0.0)] {
        let (taken, left) = with(&technology, undersize).unwrap();
        assert_eq!(taken, steps);
        assert!((left - stock).abs() < 1e-12, "{left}");
    }
    assert!(matches!(with(&technology, 0.04), Err(BurningError::ReachBeyondUndersize { .. })));
    // With an orbit of 0.1 mm the steps reach 0.3, 0.2 and 0.15 mm beyond the electrode.
    technology.step.iter_mut().for_each(|step| step.orbit_mm = Some(0.1));
    for (undersize, steps, stock) in [(0.35, "RSF", 0.2), (0.3, "RSF", 0.15), (0.2, "SF", 0.05), (0.15, "F", 0.0)] {
        let (taken, left) = with(&technology, undersize).unwrap();
        assert_eq!(taken, steps);
        assert!((left - stock).abs() < 1e-12, "{left}");
    }
    let said = with(&technology, 0.14).unwrap_err().to_string();
    assert!(said.contains("step F reaches 0.1500 mm beyond the electrode (side gap 0.05 mm, orbit 0.1 mm)"), "{said}");
    // An orbit alone may reach too far.
    technology.step[0].gap_side_mm = None;
    assert_eq!(choose(&technology, &with_undersize(0.09)).unwrap_err().to_string().matches("step F").count(), 1);
    technology.step[0].orbit_mm = Some(0.5);
    assert_eq!(with(&technology, 0.3).unwrap().0, "SF");
    // Without an orbit in the table the gap alone counts, and the result says so.
    technology = complete();
    technology.step.iter_mut().for_each(|step| step.orbit_mm = None);
    let asked = with_undersize(0.2);
    let choice = choose(&technology, &asked).unwrap();
    assert_eq!(
        choice.not_considered,
        [Missing { figure: Figure::Orbit, steps: ["R", "S", "F"].map(Into::into).into() }]
    );
    let open = burn(1000.0, 100.0, Until::Vdi(20.0));
    assert_eq!(choose(&technology, &open).unwrap().wall_stock_mm, None);
}

#[test]
fn burning_starts_at_a_step() {
    let technology = complete();
    let from = |from: &str, until| Burn { from: Some(from.to_owned()), ..burn(4.0, 100.0, until) };
    let taken = |burn: Burn| choose(&technology, &burn).map(|choice| names(&choice)).map_err(|e| e.to_string());
    // The finishing electrode removes all of its volume with F, although S would do for the first of it.
    assert_eq!(taken(from("F", Until::Vdi(20.0))), Ok("F".to_owned()));
    assert_eq!(
        taken(Burn { pieces: burn(100.0, 100.0, Until::Vdi(20.0)).pieces, ..from("S", Until::Vdi(20.0)) }),
        Ok("SF".to_owned())
    );
    // A finish that a step before the start has is reached at the start.
    assert_eq!(taken(from("S", Until::Vdi(36.0))), Ok("S".to_owned()));
    assert_eq!(taken(from("S", Until::Step("S".to_owned()))), Ok("S".to_owned()));
    assert!(taken(from("X", Until::Vdi(20.0))).unwrap_err().contains("there is no step X"));
    let said = taken(from("F", Until::Step("S".to_owned()))).unwrap_err();
    assert_eq!(said, "from is F: burning ends at step S, before it; start at that step or at one before it");
}

#[test]
fn layers_go_to_the_finest_steps_first() {
    let technology = complete();
    let volumes = |volume, burned| {
        let burn = Burn { burned_area_mm2: burned, ..burn(volume, 100.0, Until::Vdi(20.0)) };
        let choice = choose(&technology, &burn).unwrap();
        let without_area = Missing { figure: Figure::BurnedArea, steps: Vec::new() };
        assert_eq!(choice.not_considered.contains(&without_area), burned.is_none() && volume > 0.0);
        choice.steps.iter().map(|chosen| chosen.volume_mm3.unwrap()).collect::<Vec<_>>()
    };
    // S gets 0.1 mm over the area, F 0.05 mm.
    assert_eq!(volumes(1000.0, None), [985.0, 10.0, 5.0]);
    assert_eq!(volumes(1000.0, Some(300.0)), [955.0, 30.0, 15.0]);
    assert_eq!(volumes(12.0, None), [7.0, 5.0]);
    assert_eq!(volumes(4.0, None), [4.0]);
    assert_eq!(volumes(0.0, None), [0.0]);
}

/// Without S the step F removes what R leaves for S and what S would leave for F: 0.15 mm.
#[test]
fn layers_of_steps_that_are_not_taken_are_left() {
    let mut technology = complete();
    technology.step[1].ip_a = Some(2000.0);
    let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
    let volumes = |technology: &Technology| {
        let choice = choose(technology, &asked).unwrap();
        let missing: Vec<String> = choice.missing.iter().map(ToString::to_string).collect();
        (names(&choice), choice.steps.iter().map(|chosen| chosen.volume_mm3).collect::<Vec<_>>(), missing.join("; "))
    };
    let (steps, of_steps, missing) = volumes(&technology);
    assert_eq!((steps.as_str(), missing.as_str()), ("RF", ""));
    assert!((of_steps[0].unwrap() - 985.0).abs() < 1e-9 && (of_steps[1].unwrap() - 15.0).abs() < 1e-9);
    technology.step[1].stock_next_mm = None;
    let missing = "stock left for the next step of step S is not given".to_owned();
    assert_eq!(volumes(&technology), ("RF".to_owned(), vec![None, None], missing));
}

#[test]
fn what_is_missing_is_named() {
    let text = |list: &[Missing]| list.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    let asked = Burn { undersize_mm: Some(1.0), ..burn(1000.0, 100.0, Until::Vdi(20.0)) };
    let without = |change: fn(&mut Step)| {
        let mut technology = complete();
        technology.step.iter_mut().take(2).for_each(change);
        let choice = choose(&technology, &asked).unwrap();
        let volumes: Vec<_> = choice.steps.iter().map(|chosen| chosen.volume_mm3).collect();
        (volumes, text(&choice.missing), text(&choice.not_considered))
    };
    let all = [Some(985.0), Some(10.0), Some(5.0)].to_vec();
    assert_eq!(without(|_| {}), (all.clone(), String::new(), String::new()));
    let of_both = |figure: &str| format!("{figure} of steps R, S is not given");
    assert_eq!(without(|s| s.vdi = None), (all.clone(), String::new(), of_both("finish")));
    assert_eq!(without(|s| s.ip_a = None), (all.clone(), String::new(), of_both("peak current")));
    let density = of_both("greatest current density");
    assert_eq!(without(|s| s.max_density_a_cm2 = None), (all.clone(), String::new(), density));
    assert_eq!(without(|s| s.gap_side_mm = None), (all, String::new(), of_both("side gap")));
    let stock = of_both("stock left for the next step");
    assert_eq!(without(|s| s.stock_next_mm = None), ([None; 3].to_vec(), stock, String::new()));
}

/// Neither a density nor a range of areas nor the area of the rate: 80 A on 1 mm² would pass.
#[test]
fn a_current_that_nothing_bounds_is_missing() {
    let open = Technology { area_range_mm2: None, ..complete() };
    let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
    let without = |change: fn(&mut Step)| {
        let mut technology = open.clone();
        technology.step.iter_mut().for_each(change);
        let choice = choose(&technology, &asked).unwrap();
        let figures = |list: &[Missing]| list.iter().map(|missing| missing.figure).collect::<Vec<_>>();
        (figures(&choice.missing), figures(&choice.not_considered))
    };
    let none = || Vec::<Figure>::new();
    assert_eq!(without(|s| s.at_area_mm2 = None), (none(), none()));
    assert_eq!(without(|s| s.max_density_a_cm2 = None), (none(), vec![Figure::Density]));
    assert_eq!(without(|s| [s.max_density_a_cm2, s.at_area_mm2] = [None; 2]), (vec![Figure::Density], none()));
    assert_eq!(without(|s| [s.ip_a, s.at_area_mm2] = [None; 2]), (vec![Figure::PeakCurrent], none()));
}

#[test]
fn a_burn_is_read_and_written() {
    let text = "from = \"S\"\n\n[until]\nra_um = 1.6\n\n[[pieces]]\nvolume_mm3 = 10.0\nfrontal_area_mm2 = 5.0\n";
    let read: Burn = toml::from_str(text).unwrap();
    assert_eq!(read, Burn { from: Some("S".to_owned()), ..Burn::single(10.0, 5.0, Until::RaUm(1.6)) });
    assert_eq!(toml::to_string(&read).unwrap(), text, "what is not given is not written");
    assert!(toml::from_str::<Burn>(&text.replace("ra_um", "shine")).is_err());
}

#[test]
fn without_any_finish_there_is_no_choice() {
    let mut technology = complete();
    technology.step.iter_mut().for_each(|step| step.vdi = None);
    let asked = burn(1.0, 100.0, Until::Vdi(30.0));
    let choice = choose(&technology, &asked).unwrap();
    assert!(choice.steps.is_empty());
    assert_eq!(
        choice.missing.iter().map(ToString::to_string).collect::<String>(),
        "finish of steps R, S, F is not given"
    );
    // The roughness does for the class.
    technology.step[2].ra_um = Some(1.0);
    assert_eq!(until(&technology, Until::Vdi(30.0)), "RSF");
}

#[test]
fn a_burn_outside_the_technology_is_reported() {
    let technology = complete();
    let deep = Burn { depth_to_width: Some(6.0), ..burn(1000.0, 2000.0, Until::Vdi(20.0)) };
    let said: Vec<_> = choose(&technology, &deep).unwrap().outside.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 2);
    assert!(said[0].contains("2000.00 mm²; the technology is valid from 10 to 1000 mm²"), "{said:?}");
    assert!(said[1].contains("depth to width 6.00; the technology is valid up to 5"), "{said:?}");
    // Without a range nothing is outside, and without a depth nothing is too deep.
    let open = Technology { area_range_mm2: None, greatest_depth_to_width: None, ..complete() };
    let unlimited = choose(&open, &deep).unwrap();
    let depth = [Missing { figure: Figure::Depth, steps: Vec::new() }];
    assert!(unlimited.outside.is_empty());
    assert_eq!(unlimited.not_considered, depth, "a depth without a limit");
    let flat = Burn { depth_to_width: None, ..deep };
    let unknown = choose(&technology, &flat).unwrap();
    assert_eq!((unknown.outside.len(), unknown.not_considered.as_slice()), (1, depth.as_slice()));
    // The entry with little area is outside as well.
    let small = Piece { volume_mm3: 1.0, frontal_area_mm2: 2.0 };
    let mut entry = burn(1000.0, 900.0, Until::Vdi(20.0));
    entry.pieces.push(small);
    let said = choose(&technology, &entry).unwrap().outside[0].to_string();
    assert_eq!(said, "frontal area 2.00 to 900.00 mm²; the technology is valid from 10 to 1000 mm²");
    let shallow = Burn { depth_to_width: Some(5.0), ..burn(1000.0, 1000.0, Until::Vdi(20.0)) };
    assert!(choose(&technology, &shallow).unwrap().outside.is_empty());
    for wrong in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(choose(&technology, &burn(wrong, 100.0, Until::Vdi(20.0))).is_err());
        assert!(choose(&technology, &burn(1.0, wrong, Until::Vdi(20.0))).is_err());
        assert!(choose(&technology, &burn(1.0, 100.0, Until::RaUm(wrong))).is_err());
    }
    let empty = Burn { pieces: Vec::new(), ..shallow };
    let said = choose(&technology, &empty).unwrap_err().to_string();
    assert_eq!(said, "pieces: there are 0; from 1 to 100000 are possible");
}

proptest! {
    /// The volumes of the steps add up to the volume of the burn.
    #[test]
    fn volume_is_conserved(volume in 0.0..1e6, area in 100.0..1e4, burned in prop::option::of(1.0..1e5)) {
        let technology = complete();
        let burn = Burn { burned_area_mm2: burned, ..burn(volume, area, Until::Vdi(20.0)) };
        let choice = choose(&technology, &burn).unwrap();
        let sum: f64 = choice.steps.iter().map(|chosen| chosen.volume_mm3.unwrap()).sum();
        prop_assert!((sum - volume).abs() <= 1e-12 * volume);
    }
}

/// Heads of 10 mm² with 3 mm of stock, 20 mm² with 1 mm and 5 mm² with 1 mm: 2 mm of the first alone, 1 mm of all.
#[test]
fn heads_that_go_down_together_begin_with_the_deepest() {
    let head = |volume_mm3, frontal_area_mm2| Piece { volume_mm3, frontal_area_mm2 };
    let heads = [head(20.0, 20.0), head(30.0, 10.0), head(0.0, 0.0), head(5.0, 5.0)];
    let pieces = Piece::together(&heads).unwrap();
    assert_eq!(pieces, [head(20.0, 10.0), head(35.0, 35.0)]);
    assert_eq!(Piece::together(&heads[..1]).unwrap(), heads[..1]);
    assert_eq!(Piece::together(&[head(8.0, 2.0), head(8.0, 2.0)]).unwrap(), [head(16.0, 4.0)]);
    assert_eq!(Piece::together(&[]), Some(Vec::new()));
    assert_eq!(Piece::together(&[head(1.0, 0.0), head(8.0, 2.0)]), None, "stock without an area is not left out");
}

proptest! {
    /// All of the stock is burned, and no burn of several heads is faster than that of one of them.
    #[test]
    fn several_heads_take_all_of_their_stock(sizes in prop::collection::vec((0.1..50.0f64, 0.1..50.0f64), 1..8)) {
        let heads: Vec<Piece> =
            sizes.iter().map(|(volume_mm3, area)| Piece { volume_mm3: *volume_mm3, frontal_area_mm2: *area }).collect();
        let pieces = Piece::together(&heads).unwrap();
        let sum = |pieces: &[Piece]| pieces.iter().map(|piece| piece.volume_mm3).sum::<f64>();
        prop_assert!((sum(&pieces) - sum(&heads)).abs() < 1e-9 * sum(&heads));
        let slowest = |pieces: &[Piece]| {
            pieces.iter().map(|p| p.volume_mm3 / rules::area_factor(p.frontal_area_mm2, 20.0).unwrap()).sum::<f64>()
        };
        let one = heads.iter().map(|head| slowest(std::slice::from_ref(head))).fold(0.0, f64::max);
        prop_assert!(slowest(&pieces) >= one * (1.0 - 1e-9));
    }
}
