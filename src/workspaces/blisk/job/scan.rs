//! A finished part that was scanned: its best fit to the nominal part, deviations and verdict, by surface and by channel.

use std::collections::BTreeMap;
use std::sync::Arc;

use geometry::mesh::{Bounds, Mesh};
use glam::DVec3;
use measured::deviation::{Deviation, DeviationMap, Statistics, Tolerance, Verdict, Worst, deviations};
use measured::fit::{BestFit, FitSettings, Freedoms, best_fit};
use measured::{MeasuredError, Nominal};
use rayon::prelude::*;
use task::{Cancelled, Task};
use wheel::channel::Channel;
use wheel::surfaces::{SurfaceClass, classify};

/// Triangles between two looks at whether to stop.
const BLOCK: usize = 256;
/// Worst places that are listed.
const WORST: usize = 10;
/// Surface of a part that is no wheel.
pub const PART: &str = "part";

/// Surfaces of a part, by the triangles of its mesh.
#[derive(Debug, Clone, Default)]
pub struct Surfaces {
    /// Name of the surface of each triangle; empty for a part that is no wheel.
    names: Vec<String>,
    /// Number of the channel that each triangle bounds; none of one that bounds none.
    channels: Vec<Option<usize>>,
    /// Whether each triangle is in a channel and not of the shroud.
    open: Vec<bool>,
}

impl Surfaces {
    /// Surfaces of a wheel with this channel, and the channels that they bound. `face_of` is the CAD face of each triangle of
    /// `mesh`; empty where it has none.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of_wheel(mesh: &Mesh, channel: &Channel, face_of: &[u32], task: &Task) -> Result<Self, Cancelled> {
        let found = classify(mesh, channel, face_of, task)?;
        let name = |class| found.areas.iter().find(|area| area.class == class).map_or(PART, |area| area.name.as_str());
        let numbers = channel.numbers();
        let number = |(triangle, class): (usize, &SurfaceClass)| {
            let wall = match class {
                SurfaceClass::Elsewhere | SurfaceClass::Tip | SurfaceClass::Edge => return Ok(None),
                SurfaceClass::MainLow | SurfaceClass::SplitterLow => Some(0),
                SurfaceClass::MainHigh | SurfaceClass::SplitterHigh => Some(1),
                SurfaceClass::Hub | SurfaceClass::Shroud | SurfaceClass::HubFillet | SurfaceClass::ShroudFillet => None,
            };
            if triangle.is_multiple_of(BLOCK) {
                task.check()?;
            }
            let middle = mesh.corners(triangle).iter().sum::<DVec3>() / 3.0;
            Ok(Some(numbers.at(channel.frame.from_parent(middle), wall)))
        };
        let names = found.classes.iter().map(|class| name(*class).to_owned()).collect();
        let is_open = |class: &SurfaceClass| !matches!(class, SurfaceClass::Elsewhere | SurfaceClass::Shroud);
        let open = found.classes.iter().map(is_open).collect();
        let channels = found.classes.par_iter().enumerate().map(number).collect::<Result<_, Cancelled>>()?;
        Ok(Self { names, channels, open })
    }

    /// Whether a triangle is seen by who looks into a channel without its shroud.
    pub fn is_open(&self, triangle: u32) -> bool {
        self.open.get(triangle as usize).copied().unwrap_or(false)
    }

    /// Name of the surface of a triangle.
    pub fn name(&self, triangle: u32) -> &str {
        self.names.get(triangle as usize).map_or(PART, String::as_str)
    }

    fn channel(&self, triangle: u32) -> Option<usize> {
        self.channels.get(triangle as usize).copied().flatten()
    }
}

/// How a scan is fitted and judged.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Greatest deviation, and the share of the points that must keep it.
    pub tolerance: Tolerance,
    /// Axes that the scan may be moved along and about; none for a scan that lies as it is to be.
    pub freedoms: Option<Freedoms>,
    /// Distance from the part beyond which points do not count (mm); infinite if all count.
    pub reach_mm: f64,
}

/// A scanned part against the nominal one.
#[derive(Debug)]
pub struct ScannedPart {
    /// The motion of the scan; none of one that was not moved.
    pub fit: Option<BestFit>,
    /// Deviation of every point within reach.
    pub map: DeviationMap,
    /// Points beyond reach.
    pub beyond_reach: usize,
    /// Distance from the part beyond which points do not count (mm); infinite if all count.
    pub reach_mm: f64,
    /// Unit that the scan may be in instead of mm, in a sentence.
    pub unit_doubt: Option<String>,
    /// Whether the part keeps the tolerance.
    pub verdict: Verdict,
    /// Statistics of all points.
    pub all: Statistics,
    /// Statistics by surface.
    pub by_surface: BTreeMap<String, Statistics>,
    /// Statistics by the channel that the points bound; empty for a part that is no wheel.
    pub by_channel: BTreeMap<usize, Statistics>,
    /// Worst places, the worst first.
    pub worst: Vec<Worst<String>>,
}

impl ScannedPart {
    /// The points of a `scan` (mm) against `mesh`, which has these surfaces.
    ///
    /// # Errors
    /// [`MeasuredError`].
    pub fn of(
        mesh: Arc<Mesh>,
        surfaces: &Surfaces,
        scan: &[DVec3],
        Judgement { tolerance, freedoms, reach_mm }: &Judgement,
        task: &Task,
    ) -> Result<Self, MeasuredError> {
        let [_, allowed_mm] = tolerance.range_mm().map(f64::abs);
        if *reach_mm <= allowed_mm {
            return Err(MeasuredError::BadSetting {
                name: "reach",
                value: format!("{reach_mm} mm"),
                rule: "it must be beyond the tolerance, or no point could be out of it",
            });
        }
        let nominal = Nominal::new(mesh, task)?;
        let fitted = |freedoms: &Freedoms| {
            let settings = FitSettings { freedoms: freedoms.clone(), reach_mm: *reach_mm, ..Default::default() };
            best_fit(&nominal, scan, &settings, task)
        };
        let fit = freedoms.as_ref().map(fitted).transpose()?;
        let motion = fit.as_ref().map_or_else(Default::default, |fit| fit.motion);
        let (map, beyond_reach) = deviations(&nominal, scan, &motion, task)?.within_reach(*reach_mm);
        let name = |deviation: &Deviation| surfaces.name(deviation.triangle).to_owned();
        let by_channel = map.statistics_by(tolerance, |deviation| surfaces.channel(deviation.triangle));
        let spacing = 0.01 * nominal.mesh().bounds().size().length();
        Ok(Self {
            verdict: map.verdict(tolerance),
            all: map.statistics(tolerance),
            by_surface: map.statistics_by(tolerance, name),
            by_channel: by_channel.into_iter().filter_map(|(channel, of)| Some((channel?, of))).collect(),
            worst: map.worst(WORST, spacing, tolerance, name),
            fit,
            map,
            beyond_reach,
            reach_mm: *reach_mm,
            unit_doubt: unit_doubt(nominal.mesh(), scan),
        })
    }

    /// How the scan was moved, what it does not determine, and how much of it does not count, in sentences.
    pub fn fit_sentences(&self) -> Vec<String> {
        let all = self.map.list().len() + self.beyond_reach;
        let beyond = (self.beyond_reach > 0).then(|| {
            let (beyond, reach) = (self.beyond_reach, self.reach_mm);
            format!(
                "{beyond} of {all} points lie farther than {reach} mm from the part and do not count in the verdict."
            )
        });
        let fit = self.fit.as_ref().map_or_else(|| vec!["The scan was not moved.".to_owned()], fit_sentences);
        self.unit_doubt.iter().cloned().chain(fit).chain(beyond).collect()
    }
}

/// How a scan was moved, and what it does not determine, in sentences.
fn fit_sentences(fit: &BestFit) -> Vec<String> {
    let values = fit.values.iter().map(|of| {
        let letter = of.freedom.letter();
        match of.freedom.is_rotation() {
            true => format!("{letter} {:+.5}±{:.5} deg", of.value.to_degrees(), of.standard_deviation.to_degrees()),
            false => format!("{letter} {:+.5}±{:.5} mm", of.value, of.standard_deviation),
        }
    });
    let values = values.collect::<Vec<_>>().join(", ");
    let end = if fit.has_converged { "" } else { ", which did not settle" };
    let moved =
        format!("The scan was moved by {values}: rms {:.5} mm after {} iterations{end}.", fit.rms_mm, fit.iterations);
    let open = fit.undetermined.iter().map(|of| format!("The scan does not determine a {of}: it was left as it is."));
    std::iter::once(moved).chain(open).collect()
}

/// A sentence where a scan is as large against the part as one in inches, or as one in mm of a part in inches.
fn unit_doubt(mesh: &Mesh, scan: &[DVec3]) -> Option<String> {
    const INCH_MM: f64 = 25.4;
    const ALIKE: f64 = 0.03;
    let [of_part, of_scan] = [mesh.bounds(), Bounds::of(scan.iter().copied())].map(|b| b.size().length());
    let ratio = (of_scan / of_part).max(of_part / of_scan);
    ((ratio / INCH_MM - 1.0).abs() < ALIKE)
        .then(|| format!("The scan is {of_scan:.1} mm across and the part {of_part:.1} mm: is one of them in inches?"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::{MeshResolution, ParametricBlisk};

    /// One wall of channel 3 of an exact wheel is burnt 0.05 mm too deep: the only surface and the only channel outside of the
    /// tolerance.
    #[test]
    fn an_overcut_wall_is_found_by_surface_and_by_channel() {
        let blisk = ParametricBlisk::default();
        let mesh = Arc::new(blisk.mesh(&MeshResolution::default()).unwrap());
        let channel = exact_channel(&blisk);
        let task = Task::default();
        let surfaces = Surfaces::of_wheel(&mesh, &channel, &[], &task).unwrap();
        let (turn, wanted) = (std::f64::consts::TAU / blisk.blades as f64, 3);
        let mut scan = Vec::new();
        for number in 0..blisk.blades {
            let at = glam::DMat3::from_rotation_x(number as f64 * turn);
            for (wall, depth) in [(&channel.low, 0.05), (&channel.high, 0.0)] {
                let depth = if number == wanted { depth } else { 0.0 };
                for (p, n) in wall.points.iter().zip(&wall.normals).step_by(7) {
                    scan.push(channel.frame.to_parent(at * (*p - depth * *n)));
                }
            }
        }
        let judgement =
            Judgement { tolerance: Tolerance::symmetric(0.03).unwrap(), freedoms: None, reach_mm: f64::INFINITY };
        let found = ScannedPart::of(mesh, &surfaces, &scan, &judgement, &task).unwrap();
        assert!(!found.verdict.is_within);
        let outside: Vec<usize> =
            found.by_channel.iter().filter(|(_, of)| of.within < of.points).map(|(number, _)| *number).collect();
        assert_eq!(outside, [wanted], "{:?}", found.by_channel);
        assert_eq!(found.by_channel.len(), blisk.blades);
        // The ends of the walls lie on hub, shroud and edges as well.
        let mut outside: Vec<(usize, &String)> =
            found.by_surface.iter().map(|(name, of)| (of.points - of.within, name)).collect();
        outside.sort_unstable();
        let (most, wall) = outside.pop().unwrap();
        let others: usize = outside.iter().map(|(count, _)| count).sum();
        assert!(most > 2 * others && wall.contains("sides"), "{:?}", found.by_surface);
        assert!(outside.iter().all(|(count, name)| *count == 0 || !name.contains("sides")), "{outside:?}");
        assert!(found.worst[0].deviation.distance < -0.03);
    }
}
