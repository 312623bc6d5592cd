//! The figures of P0 and P1 of a plan, as window, report, files and the reproduction show them: the way of the electrode's
//! centroid, the histogram of wall distances, and the tables of nodes and inscribed circles.

use std::fmt::Write;

use glam::DVec3;
use task::{Cancel, Cancelled};
use wheel::centreline::{CentrelineError, blade_circles};

use super::node_distances::NodeDistances;
use super::outcome::{ElectrodeOutcome, PlanOutcome};

/// Intervals of the way of a centroid.
const INTERVALS: usize = 240;

/// Retract distance, and place of the middle of the electrode's burning faces in W (mm): P0's centroid, along the path from
/// the final pose outwards; at the nodes where there is no path.
pub fn centroid_way(outcome: &ElectrodeOutcome) -> Vec<[f64; 4]> {
    let (electrode, plan) = (&outcome.electrode, &outcome.plan);
    let middle = electrode.middle();
    let at = |s: f64, pose: &feed::pose::Pose| {
        let p = pose.placement(electrode.reference_point).transform_point3(middle);
        [s, p.x, p.y, p.z]
    };
    let Some(planned) = &plan.path else { return plan.nodes.iter().map(|n| at(n.s, &n.pose)).collect() };
    let length = plan.nodes.last().map_or(0.0, |n| n.s);
    let s = |i: usize| length * i as f64 / INTERVALS as f64;
    (0..=INTERVALS).map(|i| at(s(i), &planned.curves.pose(s(i)))).collect()
}

/// How many samples of an electrode's low and high wall are how far from the wall of the channel beside them: P0's figure 4.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Width of a bin (mm); the first begins at 0.
    pub width: f64,
    /// Samples in each bin, of the low and of the high wall.
    pub counts: [[usize; Histogram::BINS]; 2],
}

impl Histogram {
    /// Bins.
    pub const BINS: usize = 24;

    /// The histogram of the distances (mm) of the low and the high wall from 0 to the greatest of them.
    pub fn of(distances: &[Vec<f64>; 2]) -> Self {
        Self::up_to(distances.iter().flatten().copied().fold(1e-3, f64::max), distances)
    }

    /// The histogram from 0 to `most` (mm); what is beyond counts in the first or in the last bin.
    pub fn up_to(most: f64, distances: &[Vec<f64>; 2]) -> Self {
        let counts = |values: &Vec<f64>| {
            let mut counts = [0; Self::BINS];
            for value in values {
                counts[((value / most * Self::BINS as f64) as usize).min(Self::BINS - 1)] += 1;
            }
            counts
        };
        Self { width: most / Self::BINS as f64, counts: distances.each_ref().map(counts) }
    }

    /// The outline of the bins of a wall (0 low, 1 high): distance (mm), and share of the wall's samples (%).
    pub fn outline(&self, wall: usize) -> Vec<[f64; 2]> {
        let counts = &self.counts[wall];
        let all = counts.iter().sum::<usize>().max(1) as f64;
        let corner = |i: usize, k: usize| [(i + k) as f64 * self.width, 100.0 * counts[i] as f64 / all];
        (0..Self::BINS).flat_map(|i| [corner(i, 0), corner(i, 1)]).collect()
    }
}

/// Tables of a plan as files: name and text.
///
/// # Errors
/// [`Cancelled`].
pub fn tables(outcome: &PlanOutcome, cancel: &Cancel) -> Result<Vec<(String, String)>, Cancelled> {
    let mut files = Vec::new();
    if let Some(text) = circles_csv(outcome, cancel)? {
        files.push(("inscribed_circles.csv".to_owned(), text));
    }
    Ok(files)
}

/// Tables of electrode `k`, counted from 1, as files.
pub fn electrode_tables(k: usize, outcome: &ElectrodeOutcome) -> Vec<(String, String)> {
    let mut files = vec![(format!("centroid_{k}.csv"), centroid_csv(outcome))];
    if !outcome.distances.is_empty() {
        files.push((format!("nodes_{k}.csv"), nodes_csv(outcome)));
        files.push((format!("wall_distances_{k}.csv"), wall_distances_csv(outcome)));
    }
    files
}

fn cells(values: &[f64]) -> String {
    let cell = |v: &f64| if v.is_finite() { format!("{v:.5}") } else { String::new() };
    values.iter().map(cell).collect::<Vec<_>>().join(",")
}

fn centroid_csv(outcome: &ElectrodeOutcome) -> String {
    let mut csv = "s_mm,x_mm,y_mm,z_mm\n".to_owned();
    centroid_way(outcome).iter().for_each(|row| csv += &(cells(row) + "\n"));
    csv
}

/// Every node: pose, what P0 and P1 say of it, and the core point.
fn nodes_csv(outcome: &ElectrodeOutcome) -> String {
    let mut csv =
        "node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,clearance_mm,objective_1,objective_2,objective,D_L_mm,D_R_mm,\
                   S_L_mm,S_R_mm,low_wall_mm,high_wall_mm,hub_mm,shroud_mm,core_x_mm,core_y_mm,core_z_mm,core_arc_mm\n"
            .to_owned();
    for (i, (node, at)) in outcome.plan.nodes.iter().zip(&outcome.distances).enumerate() {
        let NodeDistances { spread, clearances, core, .. } = at;
        let [x, y, z, a, b, c] = node.pose.to_array();
        let [a, b, c] = [a, b, c].map(f64::to_degrees);
        let or_none = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let [d_l, d_r] = spread.least.map(or_none);
        let [s_l, s_r] = spread.deviation;
        let [low, high] = clearances.walls;
        let [hub, shroud] = [clearances.hub, clearances.shroud].map(or_none);
        let (core, arc) = core.unwrap_or((DVec3::NAN, f64::NAN));
        let o = &node.objective;
        let pose = [node.s, x, y, z, a, b, c, node.clearance];
        let of_p0 = [o.smoothness, o.centring, o.total, d_l, d_r, s_l, s_r];
        let of_p1 = [low, high, hub, shroud, core.x, core.y, core.z, arc];
        // Writing into a string does not fail.
        let _ = writeln!(csv, "{i},{},{},{}", cells(&pose), cells(&of_p0), cells(&of_p1));
    }
    csv
}

/// The histogram of every node, all with the same bins.
fn wall_distances_csv(outcome: &ElectrodeOutcome) -> String {
    let mut csv = "node,s_mm,from_mm,to_mm,low_wall_samples,high_wall_samples\n".to_owned();
    let most = outcome.distances.iter().flat_map(|at| at.walls.iter().flatten()).copied().fold(1e-3, f64::max);
    for (i, (node, at)) in outcome.plan.nodes.iter().zip(&outcome.distances).enumerate() {
        let Histogram { width, counts: [low, high] } = Histogram::up_to(most, &at.walls);
        for (bin, (low, high)) in low.iter().zip(high).enumerate() {
            let ends = [bin, bin + 1].map(|k| k as f64 * width);
            // Writing into a string does not fail.
            let _ = writeln!(csv, "{i},{},{low},{high}", cells(&[node.s, ends[0], ends[1]]));
        }
    }
    csv
}

/// The circles inscribed in the channel, which its centreline is made from, and P1's circles C_i in the blades with their
/// lines L_i and middles M_i.
fn circles_csv(outcome: &PlanOutcome, cancel: &Cancel) -> Result<Option<String>, Cancelled> {
    let Some(line) = &outcome.centreline else { return Ok(None) };
    let mut csv =
        "inscribed_in,section,i,radius_mm,low_x_mm,low_y_mm,low_z_mm,high_x_mm,high_y_mm,high_z_mm,middle_x_mm,\
                   middle_y_mm,middle_z_mm\n"
            .to_owned();
    let mut add = |of: &str, [section, i]: [usize; 2], radius: f64, [low, high, middle]: [DVec3; 3]| {
        let places = [low, high, middle].map(|p| cells(&p.to_array())).join(",");
        // Writing into a string does not fail.
        let _ = writeln!(csv, "{of},{},{},{},{places}", section + 1, i + 1, cells(&[radius]));
    };
    for (k, section) in line.sections.iter().enumerate() {
        for (i, circle) in section.iter().enumerate() {
            let [low, high] = circle.contacts;
            add("channel", [k, i], circle.radius, [low, high, circle.center]);
        }
    }
    match blade_circles(&outcome.channel, cancel) {
        Err(CentrelineError::Cancelled(cancelled)) => return Err(cancelled),
        // The centreline does without.
        Err(_) => {}
        Ok(sections) => {
            for (k, section) in sections.iter().enumerate() {
                for (i, circle) in section.iter().enumerate() {
                    let [low, high] = circle.centers;
                    add("blades", [k, i], circle.radius, [low, high, circle.middle()]);
                }
            }
        }
    }
    Ok(Some(csv))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bin_the_greatest_in_the_last() {
        let found = Histogram::of(&[vec![0.0, 0.5, 1.0, 1.0], vec![0.25]]);
        let counts = found.counts[0];
        assert_eq!((counts[0], counts[Histogram::BINS / 2], counts[Histogram::BINS - 1]), (1, 1, 2));
        assert_eq!((counts.iter().sum::<usize>(), found.counts[1][6]), (4, 1));
        let outline = found.outline(1);
        assert_eq!((outline[12], outline[13][1]), ([0.25, 100.0], 100.0));
        assert!((outline[13][0] - 7.0 / 24.0).abs() < 1e-12);
    }
}
