//! Figures of P3 on molds that are made for them: the effect that each shows, with dimensions of our own.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Outcome, Table, Verdict, blank, electrode_params, params_of, part_file, same_if, wrong};
use crate::reproduce::ReproduceError;
use crate::workspaces::mold::job::divisions::{Way, WayResult, compare_divisions};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::job::uncut::{Uncut, uncut};
use files::report::{counted, number};
use geometry::mesh::Mesh;
use geometry::solid::{SolidError, difference, prism, union, union_of_hulls};
use mold::cutter::Cutter;
use mold::electrode::params::ElectrodeParams;
use mold::random_mold::rectangle;
use task::{Cancel, Task};

/// How far what is taken away reaches above the block (mm).
const ABOVE: f64 = 1.0;

pub(super) fn outcomes(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let mut outcomes = vec![undercut(task)?];
    outcomes.extend(flat_and_ball(task)?);
    outcomes.extend([whole_faces(task)?, straight_edges(task)?, oversize(task)?, leftovers(task)?]);
    Ok(outcomes)
}

/// A block below the height 0 with hollows: outline and depth of each (mm).
fn block(size: [f64; 2], height: f64, hollows: &[(Vec<DVec2>, f64)]) -> Result<Mesh, SolidError> {
    let mut mold = prism(&[&rectangle(size[0], size[1])], -height, 0.0)?;
    for (outline, depth) in hollows {
        mold = difference(&mold, &prism(&[outline], -depth, ABOVE)?)?;
    }
    Ok(mold)
}

fn moved(outline: Vec<DVec2>, x: f64, y: f64) -> Vec<DVec2> {
    outline.into_iter().map(|p| p + DVec2::new(x, y)).collect()
}

fn find(name: &'static str, mesh: &Mesh, cutters: &[Cutter], task: &Task) -> Result<Uncut, ReproduceError> {
    task.check()?;
    uncut(mesh, &params_of(cutters), &task.as_stage(name)).map_err(wrong(name, task))
}

/// Ways of dividing what a cutter of radius 1 mm leaves, in the order of [`Way::ALL`].
fn ways(name: &'static str, mesh: &Mesh, task: &Task) -> Result<Vec<WayResult>, ReproduceError> {
    let found = find(name, mesh, &[Cutter::flat(1.0)], task)?;
    let stage = task.as_stage(name);
    let set = electrodes(mesh, &found, &electrode_params(), &stage).map_err(wrong(name, task))?;
    compare_divisions(mesh, &found, &set, &stage).map_err(wrong(name, task))
}

/// Duration of burning what is uncut by whole faces and by regions as found, in a sentence: the paper does not compare it.
/// Nothing where it is not known.
pub(super) fn minutes(ways: &[WayResult]) -> String {
    let [whole, own] = [Way::WholeFaces, Way::HEdges].map(|way| &ways[way as usize]);
    let Some((of_whole, of_own)) = whole.minutes.zip(own.minutes) else { return String::new() };
    format!(
        " Burning is estimated to take {of_whole:.0} min in {} with whole faces, {of_own:.0} min in {} as found; the paper \
         does not compare that.",
        counted(whole.burns, "burn"),
        counted(own.burns, "burn")
    )
}

/// Command for the ways of dividing a part.
fn by_hand(part: &str) -> String {
    format!(
        "sparkpath electrodes p3_{part}.stl --units mm --cutters flat:1 --electrode-cutters flat:0.5 \
         --compare-divisions; window: division panel, comparison of ways"
    )
}

/// A row of a table on ways of dividing.
pub(super) fn way_row(way: &WayResult) -> Vec<String> {
    let counts = [way.regions, way.edges, way.edges_left, way.heads, way.electrodes, way.burns];
    let mut row = vec![way.failure.as_ref().map_or_else(|| way.way.name().to_owned(), |why| format!("failed: {why}"))];
    row.extend(counts.map(|count| count.to_string()));
    let minutes = way.minutes.map_or_else(|| "\u{2013}".to_owned(), |minutes| number(minutes, 0));
    row.extend([minutes, number(way.largest_mm, 2)]);
    row.extend([way.not_millable, way.not_burned].map(|count| count.to_string()));
    row
}

/// Titles of the columns of [`way_row`].
pub(super) const WAY_HEAD: [&str; 11] = [
    "divided at",
    "#regions",
    "#inner edges",
    "#of them left",
    "#heads",
    "#electrodes",
    "#burns",
    "#min",
    "#longest side of a head mm",
    "#not millable",
    "#not burned",
];

/// Figure 3: a slot that is wider below.
fn undercut(task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 3";
    let (neck, wide, long) = (3.0, 7.0, 16.0);
    let made = || {
        let low = prism(&[&rectangle(wide, long)], -8.0, -5.0)?;
        difference(&block([30.0, 24.0], 14.0, &[(rectangle(neck, long), 8.0)])?, &low)
    };
    let mesh = made().map_err(wrong(NAME, task))?;
    let found = find(NAME, &mesh, &[Cutter::flat(1.0)], task)?;
    let (exact, ours) = ((wide - neck) * long, found.undercut().map_or(0.0, |faces| faces.area));
    Ok(Outcome {
        verdict: same_if((ours / exact - 1.0).abs() < 1e-3),
        why: "The paper's mold has no dimensions; of ours the area is known. Undercut faces are recognised as in the \
              paper. They are no regions to burn, but what lies below them is told apart, and their shadow keeps cutters \
              out."
            .to_owned(),
        by_hand: "sparkpath uncut p3_figure_3.stl --units mm --cutters flat:1".to_owned(),
        tables: vec![Table::new(
            "Area of the faces that look down",
            &["#exact mm²", "#ours mm²"],
            vec![vec![number(exact, 3), number(ours, 3)]],
        )],
        files: part_file("figure_3", &mesh),
        ..blank(NAME, "Undercut (invert) faces of a mold", "a slot of 3 mm that is 7 mm wide below, 16 mm long")
    })
}

/// A spherical hollow of this radius and depth (mm) below the height 0, up to above it.
fn bowl(radius: f64, depth: f64) -> Result<Mesh, SolidError> {
    const RINGS: usize = 24;
    const ROUND: usize = 96;
    let most = ((radius - depth - ABOVE) / radius).acos();
    let at = |ring: usize, k: usize| {
        let angle = most * ring as f64 / RINGS as f64;
        let around = DVec2::from_angle(k as f64 / ROUND as f64 * 2.0 * PI);
        (around * radius * angle.sin()).extend(radius - depth - radius * angle.cos())
    };
    let mut points = vec![DVec3::new(0.0, 0.0, -depth)];
    points.extend((1..=RINGS).flat_map(|ring| (0..ROUND).map(move |k| (ring, k))).map(|(ring, k)| at(ring, k)));
    union_of_hulls(&[points], &Cancel::default())
}

/// Figures 16 and 17: five regions of a flat cutter, one of which a ball takes.
fn flat_and_ball(task: &Task) -> Result<[Outcome; 2], ReproduceError> {
    const NAME: &str = "Figure 17";
    let (radius, depth, flat, pocket) = (12.0f64, 3.0, 2.0f64, 4.0);
    let made = || {
        let bowl = bowl(radius, depth)?.mapped(|p| p - DVec3::X * 10.0);
        difference(&block([44.0, 24.0], 12.0, &[(moved(rectangle(8.0, 8.0), 14.0, 0.0), pocket)])?, &bowl)
    };
    let mesh = made().map_err(wrong(NAME, task))?;
    let flats = find(NAME, &mesh, &[Cutter::flat(flat)], task)?;
    let both = find(NAME, &mesh, &[Cutter::flat(flat), Cutter::ball(4.0)], task)?;
    // The disc rests on the sphere where that is as wide as itself; at corners the square less the quarter disc is left.
    let sag = radius - (radius * radius - flat * flat).sqrt();
    let (cap, corner) = (PI * sag * sag * (3.0 * radius - sag) / 3.0, (1.0 - PI / 4.0) * flat * flat * pocket);
    let outcome = |name: &str, title: &str, of: [(&str, &Uncut, usize, f64); 1], cutters: &str| {
        let [(words, found, regions, exact)] = of;
        let ours = found.found();
        Outcome {
            verdict: same_if(ours.regions == regions && (ours.volume_mm3 / exact - 1.0).abs() < 0.02),
            why: format!(
                "The paper's mold is not public: {words}. Ours has as many regions, and their volume is known exactly."
            ),
            by_hand: format!("sparkpath uncut p3_figure_16.stl --units mm --cutters {cutters}"),
            tables: vec![Table::new(
                "Uncut regions",
                &["", "#regions", "#volume mm³"],
                vec![
                    vec!["paper".to_owned(), regions.to_string(), "–".to_owned()],
                    vec!["exact".to_owned(), regions.to_string(), number(exact, 3)],
                    vec!["ours".to_owned(), ours.regions.to_string(), number(ours.volume_mm3, 3)],
                ],
            )],
            ..blank(name, title, "a spherical hollow of radius 12 mm, 3 mm deep, and a pocket with four sharp corners")
        }
    };
    let first = outcome(
        "Figure 16",
        "Uncut regions of the flat-end cutter",
        [("it has five regions", &flats, 5, cap + 4.0 * corner)],
        "flat:2",
    );
    let second = outcome(
        NAME,
        "Uncut regions of the flat-end and the ball-end cutter",
        [("the ball takes one of the five", &both, 4, 4.0 * corner)],
        "flat:2,ball:4",
    );
    Ok([Outcome { files: part_file("figure_16", &mesh), ..first }, second])
}

/// Figure 19: a pocket with four convex corners between eight concave ones.
fn whole_faces(task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 19";
    /// H-edges in the paper's region as found, and of whole faces.
    const PAPER: [usize; 2] = [0, 4];
    let arm = |x: DVec2| [(4.0, -12.0), (4.0, -4.0), (12.0, -4.0)].map(|(u, v)| x * u + x.perp() * v);
    let cross = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].into_iter().flat_map(arm).collect();
    let mesh = block([36.0, 36.0], 12.0, &[(cross, 5.0)]).map_err(wrong(NAME, task))?;
    let ways = ways(NAME, &mesh, task)?;
    let ours = [Way::EveryEdge, Way::WholeFaces].map(|way| ways[way as usize].edges);
    Ok(Outcome {
        verdict: if ours == PAPER { Verdict::Same } else { same_if(ours[0] < ours[1]) },
        why: format!(
            "Only the pieces of faces that no cutter reaches are burned, so that the convex corners between them are no \
             H-edges. The paper counts {} H-edges in the region as found and {} with whole faces, on a region without \
             dimensions; ours are {} and {}.{}",
            PAPER[0],
            PAPER[1],
            ours[0],
            ours[1],
            minutes(&ways)
        ),
        by_hand: by_hand("figure_19"),
        tables: vec![Table::new("Ways of dividing", &WAY_HEAD, ways.iter().map(way_row).collect())],
        files: part_file("figure_19", &mesh),
        ..blank(
            NAME,
            "H-edges of a region as found and of whole faces",
            "a cross of 24 mm with arms of 8 mm, 5 mm deep",
        )
    })
}

/// Figure 20: a slot in the shape of a T whose floor has four steps.
fn straight_edges(task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 20";
    /// H-edges of the paper's region, and those that are left without horizontal straight ones between planes.
    const PAPER: [usize; 2] = [6, 2];
    let bar = |x: [f64; 2], y: [f64; 2], depth: f64| {
        (moved(rectangle(x[1] - x[0], y[1] - y[0]), 0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])), depth)
    };
    let made = || {
        // The steps of the floor, from the ends inwards, and the foot of the T.
        let steps = [bar([-12.0, 12.0], [-0.8, 0.8], 2.0), bar([-8.0, 8.0], [-0.8, 0.8], 4.0)];
        let low = [bar([-4.0, 4.0], [-0.8, 0.8], 6.0), bar([-0.8, 0.8], [-0.8, 12.0], 6.0)];
        let mut hollow = Mesh::default();
        for (outline, depth) in steps.iter().chain(&low) {
            hollow = union(&hollow, &prism(&[outline], -depth, ABOVE)?)?;
        }
        difference(&block([36.0, 36.0], 12.0, &[])?, &hollow)
    };
    let mesh = made().map_err(wrong(NAME, task))?;
    let ways = ways(NAME, &mesh, task)?;
    let ours = [Way::EveryEdge, Way::HEdges].map(|way| ways[way as usize].edges);
    Ok(Outcome {
        verdict: if ours == PAPER { Verdict::Same } else { same_if(ours[1] < ours[0]) },
        why: format!(
            "Horizontal straight edges between planes are made by wire erosion in the paper, and by the flat end of a \
             cutter here: neither divides a region there. The paper counts {} edges before and {} after, on a region \
             without dimensions; ours are {} and {}.",
            PAPER[0], PAPER[1], ours[0], ours[1]
        ),
        by_hand: by_hand("figure_20"),
        tables: vec![Table::new("Ways of dividing", &WAY_HEAD, ways.iter().map(way_row).collect())],
        files: part_file("figure_20", &mesh),
        ..blank(NAME, "Reduction of H-edges", "a slot of 1.6 mm in the shape of a T whose floor has four steps")
    })
}

/// Figure 21: a region and the same enlarged.
fn oversize(task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 21";
    /// How many times larger the enlarged pocket is.
    const LARGER: f64 = 3.0;
    let made = |k: f64| block([40.0 * k, 30.0 * k], 12.0, &[(rectangle(20.0 * k, 14.0 * k), 4.0)]);
    let [normal, large] = [made(1.0), made(LARGER)];
    let (normal, large) = (normal.map_err(wrong(NAME, task))?, large.map_err(wrong(NAME, task))?);
    let (of_normal, of_large) = (ways(NAME, &normal, task)?, ways(NAME, &large, task)?);
    let grows = |way: Way| of_large[way as usize].largest_mm / of_normal[way as usize].largest_mm;
    let is_so = grows(Way::WholeFaces) > 0.9 * LARGER && grows(Way::HEdges) < 1.1;
    let mut rows = Vec::new();
    for (words, ways) in [("normal", &of_normal), ("enlarged", &of_large)] {
        rows.extend(ways.iter().map(|way| [vec![words.to_owned()], way_row(way)].concat()));
    }
    Ok(Outcome {
        verdict: same_if(is_so),
        why: format!(
            "The paper shows the effect without figures: with whole faces electrodes grow with the pocket until they \
             cannot be milled, with the regions as found they stay as large as the corners. Ours grow {:.2} times with \
             whole faces and {:.2} times as found. Of the grown ones {} cannot be milled here.{}",
            grows(Way::WholeFaces),
            grows(Way::HEdges),
            of_large[Way::WholeFaces as usize].not_millable,
            minutes(&of_large)
        ),
        by_hand: by_hand("figure_21"),
        tables: vec![Table::new("Ways of dividing", &[&["pocket"], &WAY_HEAD[..]].concat(), rows)],
        files: [part_file("figure_21", &normal), part_file("figure_21_enlarged", &large)].concat(),
        ..blank(
            NAME,
            "Oversize electrodes of whole faces",
            "a pocket of 20 x 14 x 4 mm, and one three times as long and wide",
        )
    })
}

/// Figure 22: what is left beside an electrode that is as large as its region.
fn leftovers(task: &Task) -> Result<Outcome, ReproduceError> {
    const NAME: &str = "Figure 22";
    let mesh = block([40.0, 30.0], 12.0, &[(rectangle(20.0, 14.0), 4.0)]).map_err(wrong(NAME, task))?;
    let found = find(NAME, &mesh, &[Cutter::flat(1.0)], task)?;
    let left = |margin_mm: f64| -> Result<[f64; 3], ReproduceError> {
        let params = ElectrodeParams { margin_mm, ..electrode_params() };
        let set = electrodes(&mesh, &found, &params, &task.as_stage(NAME)).map_err(wrong(NAME, task))?;
        let thickest = set.regions.iter().map(|region| region.left.thickness).fold(0.0, f64::max);
        Ok([margin_mm, set.regions.iter().fold(0.0, |sum, region| sum + region.left.volume), thickest])
    };
    let without = left(0.01)?;
    let with = left(ElectrodeParams::default().margin_mm)?;
    let row = |[margin, volume, thickest]: [f64; 3]| vec![number(margin, 2), number(volume, 4), number(thickest, 4)];
    Ok(Outcome {
        verdict: same_if(with[1] <= without[1]),
        why: "The paper shows the effect without figures: an electrode as large as its region leaves stock at the \
              region's border, a larger one does not. Ours are all made with the side extension; what each leaves is \
              computed and checked. In corners a spark gap leaves a fillet either way."
            .to_owned(),
        by_hand: "sparkpath electrodes p3_figure_21.stl --units mm --cutters flat:1 --set electrodes.margin_mm=0.01; \
                  window: electrode form, side extension"
            .to_owned(),
        tables: vec![Table::new(
            "Residual stock after burning",
            &["#side extension mm", "#volume mm³", "#thickest mm"],
            vec![row(without), row(with)],
        )],
        ..blank(NAME, "Leftovers beside an electrode as large as its region", "a pocket of 20 x 14 x 4 mm")
    })
}
