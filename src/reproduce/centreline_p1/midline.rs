//! The centreline as the paper constructs it: figure 6.

use std::fmt::Write;

use glam::{DVec2, DVec3};

use super::blade::{circle_line, outline};
use super::{Part, Table, cells, failed, outcome};
use crate::reproduce::{Outcome, ReproduceError, Verdict};
use files::report::number;
use files::report::plot::{Plot, Series};
use geometry::frame::Cylindrical;
use geometry::nurbs::NurbsCurve;
use task::Task;
use wheel::centreline::Centreline;
use wheel::profile::SectionCircle;

/// Places along a line at which it is compared.
const PLACES: usize = 200;

/// Place of `p` on the cylinder of radius `r`, unrolled: x and arc length (mm).
fn unrolled(p: DVec3, r: f64) -> [f64; 2] {
    let Cylindrical { x, theta, .. } = Cylindrical::from_point(p);
    [x, r * theta]
}

pub(super) fn figure_6(part: &Part, task: &Task) -> Result<Outcome, ReproduceError> {
    let failed_nurbs = failed("Figure 6", task);
    let (blisk, r) = (&part.blisk, part.mean_radius());
    let profile = blisk.profile(r);
    let half = 0.5 * blisk.pitch();
    // The section stands at mid-height, where the lean of the blades is 0.
    let x0 = blisk.x_le(r);
    let circles = profile.inscribed_circles().map_err(failed_nurbs)?;
    let in_space = |center: DVec2, turn: f64| Cylindrical { x: x0 + center.x, r, theta: center.y / r + turn }.point();
    // L_i from blade to blade, and M_i, its middle.
    let joined: Vec<[DVec3; 2]> =
        circles.iter().map(|c| [in_space(c.center, -half), in_space(c.center, half)]).collect();
    let middles: Vec<DVec3> = joined.iter().map(|[a, b]| 0.5 * (*a + *b)).collect();
    let theirs = NurbsCurve::cubic(&middles, None).map_err(failed("Figure 6", task))?;
    let ours = Centreline::between(&part.walls[0], &part.walls[1], &task.cancel).map_err(failed("Figure 6", task))?;
    task.check()?;

    let sampled = |curve: &NurbsCurve| -> Vec<DVec3> {
        let [start, end] = curve.domain();
        (0..=PLACES).map(|i| curve.point(start + (end - start) * i as f64 / PLACES as f64)).collect()
    };
    let lines = [sampled(&theirs), sampled(ours.curve())];
    let apart = lines[0].iter().map(|p| {
        let [_, y] = unrolled(*p, r);
        (y - unrolled(ours.at_length(ours.length_at_x(p.x))[0], r)[1]).abs()
    });
    let apart = apart.fold(0.0, f64::max);
    // How far a line is from the middle: half the difference of its distances to both walls.
    let feet = part.walls.each_ref().map(|wall| wall.feet());
    let off_middle = |line: &[DVec3]| {
        let off = |p: &DVec3| {
            let [low, high] = feet.each_ref().map(|feet| feet.foot(*p).point.distance(*p));
            0.5 * (low - high).abs()
        };
        // Beyond the edges there is a wall on one side only.
        let covered = &line[line.len() / 5..line.len() - line.len() / 5];
        covered.iter().map(off).fold(0.0, f64::max)
    };
    let off = [off_middle(&lines[0]), off_middle(&lines[1])];
    let length = |line: &[DVec3]| line.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
    let rows = [
        ("paper's: middles M_i of the lines L_i", &lines[0], circles.len(), off[0]),
        ("ours: circles between the two walls", &lines[1], ours.sections.iter().map(Vec::len).sum(), off[1]),
    ];
    let rows = rows.map(|(name, line, count, off)| {
        [vec![name.to_owned(), count.to_string()], cells(&[length(line), off], 3)].concat()
    });
    let head = ["construction", "#circles", "#length (mm)", "#greatest distance from the middle (mm)"];
    let caption = format!("Two centrelines of one channel, at most {apart:.3} mm apart along the circumference");
    let touching = circles.windows(2).map(|w| (w[0].center.distance(w[1].center) - w[0].radius - w[1].radius).abs());
    let why = format!(
        "The paper inscribes circles in the two blades, each circle touching its neighbours, and takes the middles of the \
         lines between them; that is built here as it stands (neighbours touch to {:.0e} mm). Our planner inscribes circles \
         in the channel itself. Over the middle three fifths of the channel the paper's line lies up to {:.3} mm beside the \
         middle of the walls, ours {:.3} mm. The paper states neither coordinates nor such a distance.",
        touching.fold(1e-16, f64::max),
        off[0],
        off[1]
    );
    let csv = csv(&circles, &joined, &middles);
    Ok(Outcome {
        tables: vec![Table::new(&caption, &head, rows.to_vec())],
        plots: vec![plot(part, &circles, &joined, &lines)],
        files: vec![("p1_centreline.csv".to_owned(), csv.into_bytes())],
        ..outcome(
            "Figure 6",
            "Centreline of the channel: inscribed circles, L_i, M_i",
            Verdict::NotComparable,
            why,
            "sparkpath plan writes C_i, L_i and M_i of any blisk, and the circles of its channel, into inscribed_circles.csv; \
             inspect prints length and circles of the centreline; the window draws it in the Blisk workspace (scene tree, \
             Centreline). Coordinates of this figure: p1_centreline.csv.",
        )
    })
}

fn csv(circles: &[SectionCircle], joined: &[[DVec3; 2]], middles: &[DVec3]) -> String {
    let mut csv = "i,radius_mm,c_low_x,c_low_y,c_low_z,c_high_x,c_high_y,c_high_z,m_x,m_y,m_z\n".to_owned();
    for (i, ((circle, [low, high]), middle)) in circles.iter().zip(joined).zip(middles).enumerate() {
        let places = [low, high, middle].map(|p| format!("{:.5},{:.5},{:.5}", p.x, p.y, p.z)).join(",");
        // Writing into a string does not fail.
        let _ = writeln!(csv, "{},{:.5},{places}", i + 1, circle.radius);
    }
    csv
}

fn plot(part: &Part, circles: &[SectionCircle], joined: &[[DVec3; 2]], lines: &[Vec<DVec3>; 2]) -> String {
    let (blisk, r) = (&part.blisk, part.mean_radius());
    let profile = blisk.profile(r);
    let mut series = Vec::new();
    for turn in [-0.5, 0.5].map(|share| share * blisk.pitch()) {
        let moved = |[x, y]: [f64; 2]| [x + blisk.x_le(r), y + r * turn];
        let blade = outline(&profile, blisk.x_te(r) - blisk.x_le(r));
        series.push(Series { points: blade.into_iter().map(moved).collect(), class: "faint", dots: false });
        for circle in circles {
            series.push(Series {
                points: circle_line(circle).into_iter().map(moved).collect(),
                class: "c2",
                dots: false,
            });
        }
    }
    for ends in joined {
        series.push(Series { points: ends.map(|p| unrolled(p, r)).to_vec(), class: "mean", dots: false });
    }
    for (line, class) in lines.iter().zip(["c1", "c0"]) {
        series.push(Series { points: line.iter().map(|p| unrolled(*p, r)).collect(), class, dots: false });
    }
    let middle = joined.iter().map(|[a, b]| unrolled(0.5 * (*a + *b), r));
    series.push(Series { points: middle.collect(), class: "n", dots: true });
    let plot = Plot {
        title: format!(
            "Section at radius {} mm, unrolled (mm): circles green, L_i dashed, M_i dots; paper's line brown, ours blue",
            number(r, 1)
        ),
        x_label: "x (mm)".to_owned(),
        size: [760.0, 0.0],
        series,
        ..Plot::default()
    };
    plot.with_equal_scales().svg()
}
