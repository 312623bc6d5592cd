//! What radius, taper and number of control points do: the paper has one cone, one cylinder and ten control points.

use super::{CONE, PLOT, SURFACES, above_guide, cutter, line, params, strings, surface};
use crate::reproduce::{Outcome, ReproduceError, Table, Verdict};
use files::report::number;
use files::report::plot::Plot;
use flank::FlankError;
use flank::cutter::FlankCutter;
use flank::params::FlankParams;
use flank::plan::plan_flank;
use task::Task;

/// Samples along u and v.
const GRID: [usize; 2] = [50, 25];
/// Radii of the bottom (mm).
const RADII: [f64; 7] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0];
/// Angles from axis to flute (deg).
const TAPERS: [f64; 7] = [0.0, 2.0, 4.0, 5.0, 8.0, 12.0, 16.0];
/// Control points of each curve.
const CONTROL_POINTS: [usize; 7] = [4, 6, 8, 10, 14, 20, 30];

/// A parameter, its values, and cutter and parameters of the plan for each.
struct Swept {
    name: &'static str,
    values: Vec<(f64, FlankCutter, FlankParams)>,
}

fn all() -> [Swept; 3] {
    let params = FlankParams { grid: GRID, locations: 60, ..params() };
    let [radius, taper] = CONE;
    let of_cutter = |value, of: [f64; 2]| (value, cutter(of), params.clone());
    let of_count = |n: usize| (n as f64, cutter(CONE), FlankParams { control_points: n, ..params.clone() });
    [
        Swept { name: "radius r0 (mm)", values: RADII.map(|r| of_cutter(r, [r, taper])).to_vec() },
        Swept { name: "taper (deg)", values: TAPERS.map(|a| of_cutter(a, [radius, a])).to_vec() },
        Swept { name: "control points of each curve", values: CONTROL_POINTS.map(of_count).to_vec() },
    ]
}

/// Mean deviations over radius, taper and control points.
pub(super) fn sweep(task: &Task) -> Result<Outcome, ReproduceError> {
    let (mut tables, mut plots) = (Vec::new(), Vec::new());
    for swept in all() {
        let (mut rows, mut series) = (Vec::new(), Vec::new());
        for (which, [first, last]) in SURFACES.into_iter().zip([["faint", "c0"], ["mean", "c1"]]) {
            let surface = surface(which, "Sweep")?;
            let [mut initial, mut refined] = [Vec::new(), Vec::new()];
            for (value, cutter, params) in &swept.values {
                let mut row = vec![which.name().to_owned(), value.to_string()];
                match plan_flank(&surface, cutter, params, task) {
                    Ok(plan) => {
                        let [mean, chosen, least] =
                            [&plan.initial, &plan.chosen, &plan.refined].map(|path| 1e3 * path.deviation.mean);
                        initial.push([*value, mean]);
                        refined.push([*value, least]);
                        row.extend([mean, chosen, least].map(|mean| number(mean, 3)));
                        row.push(number(plan.ratio(&plan.refined), 3));
                        row.push(number(1e3 * plan.refined.deviation.most_undercut, 1));
                        row.push(number(1e3 * above_guide(&plan.refined), 1));
                        row.push(String::new());
                    }
                    Err(FlankError::Cancelled(cancelled)) => return Err(cancelled.into()),
                    Err(error) => {
                        row.extend((0..6).map(|_| String::new()));
                        row.push(error.to_string());
                    }
                }
                rows.push(row);
            }
            series.extend([line(initial, first), line(refined, last)]);
        }
        let head = [
            "surface",
            swept.name,
            "#initial µm",
            "#chosen µm",
            "#refined µm",
            "#ratio refined to initial",
            "#greatest undercut, refined, µm",
            "#flutes end above the lower guide, µm",
            "no path because",
        ];
        let caption = format!("Mean absolute deviation over the {}", swept.name);
        tables.push(Table { caption, head: strings(head), rows });
        plots.push(
            Plot {
                title: "Mean deviation (µm): refined A blue, B brown; initial A grey, B grey dashed".to_owned(),
                x_label: swept.name.to_owned(),
                size: PLOT,
                series,
                ..Plot::default()
            }
            .svg(),
        );
    }
    Ok(Outcome {
        name: "Sweep".to_owned(),
        title: "deviation over radius, taper and control points".to_owned(),
        part: format!(
            "surfaces A and B of the paper; around its cone r0 1 mm, 5°, 10 control points; 60 locations, {} x {} \
             samples (u, v)",
            GRID[0], GRID[1]
        ),
        verdict: Verdict::NotComparable,
        why: "the paper has no such sweep; ours tells how far its single cutters may be taken as typical. The taper \
              decides most. The radius does little on A and much on B, where a wide cutter finds no path. More than ten \
              control points gain little. A path that deviates by less than the tolerance is not refined: its ratio is 1. Checks of coverage fail where the bottom stands on the lower guide (Extend below 0), \
              as in the paper: the command answers 3 then"
            .to_owned(),
        by_hand: "sparkpath flank --demo a --below 0 --grid 50x25 --locations 60 --sweep taper:0:16:9 (or \
                  radius:0.5:5:10, points:4:30:14). Window: workspace Flank, Path {Extend below 0, Grid 50 x \
                  25, Locations 60}; in the results, under Side by side, the quantity, its first and last value, and \
                  Sweep; the plot is in the tab Sweep."
            .to_owned(),
        tables,
        plots,
        pictures: Vec::new(),
        files: Vec::new(),
    })
}
