//! Plans of one flank side by side: with each cutter of a list, or as the user keeps them.

use flank::FlankError;
use flank::cutter::FlankCutter;
use nc::flank_job::{FlankInput, FlankJobError, FlankResult, flank};
use serde::Serialize;
use task::{Cancelled, Task};

/// A plan beside others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The cutter.
    pub cutter: FlankCutter,
    /// Figures of the path that is milled, or the reason why there is none.
    pub figures: Result<Figures, String>,
}

/// Figures of the path that is milled, of the standing cutter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Mean of the absolute deviations (mm).
    pub mean_mm: f64,
    /// Sum of the absolute deviations as a share of that of the initial path; none where that is rounding.
    pub ratio: Option<f64>,
    /// Greatest depth below the surface (mm).
    pub overcut_mm: f64,
    /// Greatest stock left on the surface (mm).
    pub undercut_mm: f64,
    /// Names of the checks that fail.
    pub fails: Vec<String>,
}

impl Figures {
    /// The figures of a plan.
    pub fn of(result: &FlankResult) -> Self {
        let deviation = &result.path().deviation;
        Self {
            mean_mm: deviation.mean,
            ratio: result.plan.share(deviation.sum),
            overcut_mm: (-deviation.most_overcut).max(0.0),
            undercut_mm: deviation.most_undercut.max(0.0),
            fails: result.checks.iter().filter(|c| !c.holds).map(|c| c.kind.name().to_owned()).collect(),
        }
    }
}

impl Row {
    /// The row of a plan.
    pub fn of(result: &FlankResult) -> Self {
        Self { cutter: result.plan.cutter.clone(), figures: Ok(Figures::of(result)) }
    }

    /// The row in a sentence.
    pub fn sentence(&self) -> String {
        let words = self.cutter.words();
        match &self.figures {
            Err(why) => format!("{words}: no path: {why}"),
            Ok(Figures { mean_mm, ratio, overcut_mm, undercut_mm, fails }) => {
                let ratio = ratio.map_or_else(String::new, |ratio| format!(" (ratio {ratio:.3})"));
                let [mean, overcut, undercut] = [mean_mm, overcut_mm, undercut_mm].map(|mm| 1e3 * mm);
                let checks = if fails.is_empty() {
                    "every check holds".to_owned()
                } else {
                    format!("fails {}", fails.join(", "))
                };
                format!(
                    "{words}: mean {mean:.2} um{ratio}, overcut {overcut:.1} um, undercut {undercut:.1} um; {checks}"
                )
            }
        }
    }
}

/// Plans with each of `cutters` in turn.
///
/// # Errors
/// [`Cancelled`].
pub fn compare(input: &FlankInput, cutters: &[FlankCutter], task: &Task) -> Result<Vec<Row>, Cancelled> {
    let row = |(i, cutter): (usize, &FlankCutter)| {
        task.check()?;
        task.report("cutters", i as f64 / cutters.len() as f64, &cutter.name);
        let input = FlankInput { cutter: cutter.clone(), ..input.clone() };
        let figures = match flank(&input, &Task::silent(&task.cancel)) {
            Ok(result) => Ok(Figures::of(&result)),
            Err(FlankJobError::Flank(FlankError::Cancelled(cancelled))) => return Err(cancelled),
            Err(error) => Err(error.to_string()),
        };
        Ok(Row { cutter: cutter.clone(), figures })
    };
    cutters.iter().enumerate().map(row).collect()
}

/// The row of the best cutter: of those with which fewest checks fail the one with the least mean deviation.
pub fn best(rows: &[Row]) -> Option<usize> {
    let known = rows.iter().enumerate().filter_map(|(i, row)| Some((i, row.figures.as_ref().ok()?)));
    let order = |(_, a): &(usize, &Figures), (_, b): &(usize, &Figures)| {
        a.fails.len().cmp(&b.fails.len()).then(a.mean_mm.total_cmp(&b.mean_mm))
    };
    known.min_by(order).map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_cutter_is_the_most_exact_of_those_with_which_most_checks_hold() {
        let row = |mean_mm: f64, fails: &[&str]| Row {
            cutter: FlankCutter::cylinder(1.0, 20.0),
            figures: Ok(Figures {
                mean_mm,
                ratio: None,
                overcut_mm: 0.0,
                undercut_mm: 0.0,
                fails: fails.iter().map(|name| (*name).to_owned()).collect(),
            }),
        };
        let none = Row { figures: Err("too short".to_owned()), ..row(0.0, &[]) };
        assert_eq!(best(&[]), None);
        assert_eq!(best(std::slice::from_ref(&none)), None);
        assert_eq!(best(&[none.clone(), row(0.001, &["gouge"]), row(0.004, &[]), row(0.003, &[])]), Some(3));
        assert!(none.sentence().ends_with("no path: too short"));
    }
}
