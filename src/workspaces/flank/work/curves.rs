//! Curves over a flank's path for plots, computed in the background.

use flank::deviation::Deviation;
use flank::machine::tool_path::Section;
use nc::flank_job::FlankResult;

/// Deviations of a path along the guides: for each u the least, the greatest and the mean absolute deviation over v.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile {
    /// Parameter u along the guides.
    pub u: Vec<f64>,
    /// Least deviation (mm).
    pub least: Vec<f64>,
    /// Greatest (mm).
    pub greatest: Vec<f64>,
    /// Mean of the absolute values (mm).
    pub mean: Vec<f64>,
}

impl Profile {
    /// Profile of the deviations over a grid.
    pub fn of(deviation: &Deviation) -> Self {
        let [n, m] = deviation.grid;
        let mut profile = Self::default();
        for (i, row) in deviation.values.chunks(m.max(1)).take(n).enumerate() {
            profile.u.push(i as f64 / (n.max(2) - 1) as f64);
            profile.least.push(row.iter().copied().fold(f64::INFINITY, f64::min));
            profile.greatest.push(row.iter().copied().fold(f64::NEG_INFINITY, f64::max));
            profile.mean.push(row.iter().map(|v| v.abs()).sum::<f64>() / row.len().max(1) as f64);
        }
        profile
    }
}

/// An axis of a machine over the cut.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisCurve {
    /// Letter of the axis.
    pub letter: char,
    /// "mm" or "deg".
    pub unit: &'static str,
    /// Values of the axis; for X, Y, Z those of the spindle nose in machine coordinates, which the limits hold for.
    pub values: Vec<f64>,
    /// Limits of the axis.
    pub limits: [f64; 2],
}

impl AxisCurve {
    /// Least and greatest value.
    pub fn range(&self) -> [f64; 2] {
        self.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)])
    }

    /// Distance to the nearer limit.
    pub fn room(&self) -> f64 {
        let ([least, greatest], [from, to]) = (self.range(), self.limits);
        (least - from).min(to - greatest)
    }
}

/// The axes of a machine over the cut.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineCurves {
    /// Path parameter of each position.
    pub t: Vec<f64>,
    /// X, Y, Z and both rotary axes.
    pub axes: Vec<AxisCurve>,
    /// Places where the path passes near the machine's pole, with a sentence on each.
    pub singular: Vec<(f64, String)>,
    /// Time from the first position to the last (min).
    pub minutes: f64,
}

impl MachineCurves {
    /// Curves of a flank's path on its machine, if there is one.
    pub fn of(result: &FlankResult) -> Option<Self> {
        let (milled, path) = (result.milled()?, result.tool_path().ok()?);
        let machine = milled.machine.machine();
        let linear = [machine.linear.x_mm, machine.linear.y_mm, machine.linear.z_mm];
        let curve = |letter, unit, limits| AxisCurve { letter, unit, values: Vec::new(), limits };
        let mut axes: Vec<AxisCurve> =
            ['X', 'Y', 'Z'].into_iter().zip(linear).map(|(letter, limits)| curve(letter, "mm", limits)).collect();
        axes.extend(
            machine.rotary.iter().map(|axis| curve(axis.letter.letter(), "deg", axis.limits().map(f64::to_degrees))),
        );
        let mut t = Vec::new();
        for point in &milled.line.points {
            let place = path.place(point.s);
            let Some(u) = place.u.filter(|_| place.section == Section::Cut) else { continue };
            t.push(u);
            let slides = milled.machine.slides(&point.joints).to_array();
            let rotary = point.joints.rotary.map(f64::to_degrees);
            axes.iter_mut().zip(slides.into_iter().chain(rotary)).for_each(|(axis, value)| axis.values.push(value));
        }
        let singular = milled.line.singular.iter();
        let singular = singular.filter_map(|passage| Some((passage.at.u?, passage.to_string()))).collect();
        (t.len() > 1).then_some(Self { t, axes, singular, minutes: milled.minutes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_says_for_each_u_what_is_over_v() {
        let deviation = Deviation::of([3, 2], vec![0.1, -0.3, 0.0, 0.2, -0.1, -0.2]);
        let profile = Profile::of(&deviation);
        assert_eq!(profile.u, [0.0, 0.5, 1.0]);
        assert_eq!((profile.least, profile.greatest), (vec![-0.3, 0.0, -0.2], vec![0.1, 0.2, -0.1]));
        assert!((profile.mean[0] - 0.2).abs() < 1e-12 && (profile.mean[2] - 0.15).abs() < 1e-12);
    }

    #[test]
    fn an_axis_says_how_far_its_nearer_limit_is() {
        let axis = AxisCurve { letter: 'A', unit: "deg", values: vec![-10.0, 5.0, 30.0], limits: [-25.0, 90.0] };
        assert_eq!((axis.range(), axis.room()), ([-10.0, 30.0], 15.0));
    }
}
