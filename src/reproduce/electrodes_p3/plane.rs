//! Figures of P3 on the curves of one layer (section 4.1): the paper shows shapes without dimensions, so that ours have
//! dimensions of which the exact answer is known.

use glam::DVec2;

use super::{Outcome, Table, Verdict, blank, same_if};
use files::report::number;
use mold::interference::{Interference, LayerInterference};
use mold::outline::Outline;
use mold::random_mold::{polygon, rectangle};
use mold::uncut_layer::uncut_pieces;

/// Corners of a round island.
const CORNERS: usize = 720;
/// Radius of a round island and of the cutter (mm).
const ISLAND: f64 = 3.0;
const CUTTER: f64 = 2.0;
/// Depth up to which the curves count as cut (mm).
const TOLERANCE: f64 = 1e-3;
/// Share of a length up to which it is the exact one: the depth tolerance shortens segments.
const SAME: f64 = 0.02;

/// A pocket of this outline in a block.
fn pocket(outline: Vec<DVec2>) -> Vec<Outline> {
    [rectangle(60.0, 60.0), outline.into_iter().rev().collect()].into_iter().filter_map(Outline::new).collect()
}

/// Round islands at these places (mm).
fn islands(places: &[DVec2]) -> Vec<Outline> {
    let at = |place: &DVec2| Outline::new(polygon(CORNERS, ISLAND).into_iter().map(|p| p + *place).collect());
    places.iter().filter_map(at).collect()
}

/// Length of an island's outline that another one `apart` (mm), between the centres, keeps a cutter off: where the cutter
/// touches both are the critical points.
fn arc(apart: f64) -> f64 {
    2.0 * ISLAND * (0.5 * apart / (ISLAND + CUTTER)).min(1.0).acos()
}

/// Uncut lengths of a layer: of each class in the order of [`Interference::ALL`], and the runs with what is on the first
/// outline.
struct Found {
    lengths: [f64; 4],
    on_first: Vec<f64>,
}

fn found(outlines: &[Outline], radius: f64) -> Found {
    let of = LayerInterference::new(outlines, radius);
    let pieces = uncut_pieces(outlines, radius, TOLERANCE);
    let runs: Vec<&Vec<DVec2>> = pieces.iter().flat_map(|piece| &piece.segments).collect();
    let length = |run: &[DVec2]| run.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
    let is_on_first = |run: &&&Vec<DVec2>| run.iter().all(|p| p.length() < ISLAND + TOLERANCE);
    Found {
        lengths: runs
            .iter()
            .map(|run| of.lengths(run))
            .fold([0.0; 4], |sum, of| std::array::from_fn(|k| sum[k] + of[k])),
        on_first: runs.iter().filter(is_on_first).map(|run| length(run)).collect(),
    }
}

fn is_near(ours: f64, exact: f64) -> bool {
    (ours - exact).abs() <= SAME * exact.abs().max(1.0)
}

pub(super) fn outcomes() -> Vec<Outcome> {
    let corners = found(&pocket(rectangle(20.0, 12.0)), 1.5);
    let slot = found(&pocket(rectangle(20.0, 1.6)), 1.0);
    let near = 7.0;
    let two = found(&islands(&[DVec2::new(-0.5 * near, 0.0), DVec2::new(0.5 * near, 0.0)]), CUTTER);
    let class = |of: &Found, class: Interference| of.lengths[class as usize];
    let local = [("corners of a pocket, cutter 1.5 mm", "self, local", 12.0, class(&corners, Interference::Local))];
    let global = [(
        "sides of a slot of 20 x 1.6 mm, but a radius from its ends, cutter 1 mm",
        "self, global",
        36.0,
        class(&slot, Interference::Global),
    )];
    let other = [("two round islands, cutter 2 mm", "other", 2.0 * arc(near), class(&two, Interference::Other))];
    let compared = |name: &str, title: &str, rows: &[(&str, &str, f64, f64)]| {
        Outcome {
        verdict: same_if(rows.iter().all(|(_, _, exact, ours)| is_near(*ours, *exact))),
        why: "The paper's curves have no dimensions; on ours the exact lengths are known, and what is found of each class \
              is compared with them."
            .to_owned(),
        by_hand: "sparkpath uncut MESH --out DIR, with any mesh of this folder: column interference of uncut_segments.csv, table in uncut.html; \
                  src/engines/mold/interference.rs"
            .to_owned(),
        tables: vec![Table::new(
            "Uncut length",
            &["curve", "class in the paper", "#exact mm", "#ours mm"],
            rows.iter()
                .map(|(part, class, exact, ours)| {
                    vec![(*part).to_owned(), (*class).to_owned(), number(*exact, 3), number(*ours, 3)]
                })
                .collect(),
        )],
        ..blank(name, title, "curves of one layer with dimensions of our own")
    }
    };
    vec![
        compared("Figure 8", "Self-interference and other-interference", &[local[0], other[0]]),
        compared("Figure 10", "Local and global self-interference", &[local[0], global[0]]),
        minimum_distance(),
        compared("Figure 14", "I-region and critical points of two curves", &other),
        around(),
    ]
}

/// The minimum-distance algorithm of figures 12 and 13 asks whether curves come nearer than the cutter's radius.
fn minimum_distance() -> Outcome {
    let row = |gap: f64| {
        let apart = 2.0 * ISLAND + gap;
        let both = islands(&[DVec2::new(-0.5 * apart, 0.0), DVec2::new(0.5 * apart, 0.0)]);
        let ours = found(&both, CUTTER).lengths[Interference::Other as usize];
        (gap, gap <= CUTTER, 2.0 * arc(apart), ours)
    };
    let rows: Vec<_> = [1.0, 1.9, 2.5, 3.5, 4.5].map(row).to_vec();
    let word = |is_so: bool| if is_so { "yes" } else { "no" }.to_owned();
    let is_missed = rows.iter().any(|(_, of_paper, exact, _)| !of_paper && *exact > 0.0);
    let is_right = rows.iter().all(|(_, _, exact, ours)| is_near(*ours, *exact));
    Outcome {
        verdict: if is_right && is_missed { Verdict::Better } else { same_if(is_right) },
        why: "As printed, the algorithm rejects curves whose distance is greater than the radius R. A cutter between two \
              curves interferes up to a distance of 2 R; R is right only for one curve and the offset of the other."
            .to_owned(),
        by_hand: "src/engines/mold/centre_path.rs".to_owned(),
        tables: vec![Table::new(
            "Two round islands of radius 3 mm, cutter of radius 2 mm",
            &["#distance mm", "interference by the listing", "#exact uncut mm", "#ours mm"],
            rows.iter()
                .map(|(gap, of_paper, exact, ours)| {
                    vec![number(*gap, 1), word(*of_paper), number(*exact, 3), number(*ours, 3)]
                })
                .collect(),
        )],
        ..blank("Figure 12", "Minimum distance of two curves", "two round islands")
    }
}

/// A curve with four curves around it: each leaves one uncut segment on it.
fn around() -> Outcome {
    let apart = 8.5;
    let around = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].map(|d| d * apart);
    let found = found(&islands(&[&[DVec2::ZERO], &around[..]].concat()), CUTTER);
    let is_exact = found.on_first.len() == 4 && found.on_first.iter().all(|length| is_near(*length, arc(apart)));
    Outcome {
        verdict: same_if(is_exact),
        why: "The paper's curve has four interferential curves and five critical points, which leave four uncut segments; \
              dimensions are not given. Ours has four as well; their length is known from the critical points."
            .to_owned(),
        by_hand: "sparkpath uncut MESH --out DIR, with any mesh of this folder: uncut_segments.csv".to_owned(),
        tables: vec![Table::new(
            "Uncut segments of the curve in the middle",
            &["", "#segments", "#length of each mm"],
            vec![
                vec!["paper".to_owned(), "4".to_owned(), "–".to_owned()],
                vec!["exact".to_owned(), "4".to_owned(), number(arc(apart), 3)],
                vec![
                    "ours".to_owned(),
                    found.on_first.len().to_string(),
                    number(found.on_first.iter().sum::<f64>() / found.on_first.len().max(1) as f64, 3),
                ],
            ],
        )],
        ..blank("Figure 15", "Uncut segments by several curves", "a round island among four others")
    }
}
