//! Ways of dividing regions into heads, compared: not at all, by whole faces as the H-edge-based algorithm does, at every
//! inner edge, and at those that no cutter mills.

use glam::DVec2;
use serde::Serialize;

use super::electrodes::{ElectrodesError, MoldBody, on_milled, timed, to_burn};
use super::uncut::Uncut;
use mold::electrode::design::{ElectrodeSet, PartNode};
use mold::electrode::finding::CheckKind;
use mold::electrode::params::{DividedAt, Edit, ElectrodeParams};
use mold::electrode::plan::plan;
use task::Task;

/// A way of dividing regions into heads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// A head for each region, as found.
    Undivided,
    /// Regions of whole faces, divided at every inner edge: a face that is partly uncut counts as uncut.
    WholeFaces,
    /// Regions as found, divided at every inner edge.
    EveryEdge,
    /// Regions as found, divided at inner edges that no cutter mills.
    HEdges,
}

impl Way {
    /// All ways.
    pub const ALL: [Self; 4] = [Self::Undivided, Self::WholeFaces, Self::EveryEdge, Self::HEdges];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        ["undivided", "whole faces", "every inner edge", "H-edges"][self as usize]
    }

    /// Inner edges at which the way divides.
    pub fn divided_at(self) -> DividedAt {
        match self {
            Self::Undivided => DividedAt::Nothing,
            Self::WholeFaces | Self::EveryEdge => DividedAt::EveryEdge,
            Self::HEdges => DividedAt::HEdges,
        }
    }
}

/// Result of a way of dividing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WayResult {
    /// The way.
    pub way: Way,
    /// Whether the electrodes are made by this way.
    pub is_own: bool,
    /// Reason why there are no electrodes this way; the figures are then 0.
    pub failure: Option<String>,
    /// Number of regions.
    pub regions: usize,
    /// Number of inner edges at which the way divides, before any division.
    pub edges: usize,
    /// Number of those that remain on heads.
    pub edges_left: usize,
    /// Number of heads on all electrodes.
    pub heads: usize,
    /// Number of electrodes.
    pub electrodes: usize,
    /// Number of burns.
    pub burns: usize,
    /// All burns with set-up and changing (minutes); none if they are not known.
    pub minutes: Option<f64>,
    /// Longest side of a head in plan (mm).
    pub largest_mm: f64,
    /// Number of electrodes that the cutters do not mill.
    pub not_millable: usize,
    /// Number of regions that are not burned, or not wholly.
    pub not_burned: usize,
}

impl WayResult {
    fn of(way: Way, set: &ElectrodeSet, is_own: bool) -> Self {
        let trees = || set.regions.iter().filter_map(|plan| plan.tree.as_ref());
        let mut leaves = Vec::new();
        trees().for_each(|tree| leaves_of(tree, &mut leaves));
        let fails = |e: &usize| set.checks[*e].iter().any(|f| f.kind == CheckKind::Machinable && !f.holds);
        Self {
            way,
            is_own,
            failure: None,
            regions: set.regions.len(),
            edges: trees().map(PartNode::h_edge_count).sum(),
            edges_left: leaves.iter().map(|leaf| leaf.h_edge_count()).sum(),
            heads: set.electrodes.iter().filter_map(|e| e.burns.first()).map(|burn| burn.parts.len()).sum(),
            electrodes: set.electrodes.len(),
            burns: set.electrodes.iter().map(|e| e.burns.len()).sum(),
            minutes: set.minutes().map(|minutes| minutes.mean),
            largest_mm: leaves.iter().map(|leaf| longest(leaf)).fold(0.0, f64::max),
            not_millable: (0..set.electrodes.len()).filter(fails).count(),
            not_burned: set.without_electrode().len(),
        }
    }

    fn failed(way: Way, failure: String) -> Self {
        Self {
            way,
            is_own: false,
            failure: Some(failure),
            regions: 0,
            edges: 0,
            edges_left: 0,
            heads: 0,
            electrodes: 0,
            burns: 0,
            minutes: None,
            largest_mm: 0.0,
            not_millable: 0,
            not_burned: 0,
        }
    }
}

fn leaves_of<'a>(tree: &'a PartNode, leaves: &mut Vec<&'a PartNode>) {
    if tree.parts.is_empty() { leaves.push(tree) } else { tree.parts.iter().for_each(|part| leaves_of(part, leaves)) }
}

/// Longest side of the box around a part in plan (mm).
fn longest(part: &PartNode) -> f64 {
    let points = part.outlines.iter().flatten();
    let [low, high] = points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[l, h], p| [l.min(*p), h.max(*p)]);
    (high - low).max_element().max(0.0)
}

/// Results of all ways of dividing what `uncut` found left of `mold`, with the parameters of `own`, the electrodes that
/// are made. Divisions by hand are those of `own` alone.
///
/// # Errors
/// [`ElectrodesError`] if there are no electrodes whichever way.
pub fn compare_divisions<'a>(
    mold: impl Into<MoldBody<'a>>,
    uncut: &Uncut,
    own: &ElectrodeSet,
    task: &Task,
) -> Result<Vec<WayResult>, ElectrodesError> {
    let task = &task.as_stage("divisions");
    let mold = mold.into();
    on_milled(mold.mesh, uncut, task, |upright, milled| {
        let faces = mold.segmentation(upright, uncut.params.opening, &task.cancel)?;
        let in_the_way = mold.in_the_way(upright, uncut.params.opening);
        let of_way = |way: Way| -> Result<WayResult, ElectrodesError> {
            task.check()?;
            if way != Way::WholeFaces && way.divided_at() == own.params.divided_at {
                return Ok(WayResult::of(way, own, true));
            }
            let is_by_hand = |e: &Edit| matches!(e, Edit::Merge { .. } | Edit::Split { .. } | Edit::SplitAlong { .. });
            let edits = own.params.edits.iter().filter(|e| !is_by_hand(e));
            let params = ElectrodeParams {
                divided_at: way.divided_at(),
                edits: edits.copied().collect(),
                overrides: Vec::new(),
                names: Vec::new(),
                ..own.params.clone()
            };
            let regions = to_burn(upright, &faces, uncut, way == Way::WholeFaces);
            match plan(&in_the_way, &regions, (&uncut.params.library, milled), &params, task) {
                Ok(set) => Ok(WayResult::of(way, &timed(set), false)),
                Err(error) => {
                    task.check()?;
                    Ok(WayResult::failed(way, error.to_string()))
                }
            }
        };
        Way::ALL.into_iter().map(of_way).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::mold::job::electrodes::electrodes;
    use crate::workspaces::mold::job::uncut::{UncutParams, uncut};
    use geometry::mesh::Mesh;
    use geometry::solid::{difference, prism};
    use mold::cutter::{Cutter, CutterLibrary};
    use mold::fixtures::rectangle;

    /// A block with a hollow of this outline, so many mm deep.
    fn mold(outline: &[DVec2], depth: f64) -> Mesh {
        let block = prism(&[&rectangle(40.0, 30.0)], -12.0, 0.0).unwrap();
        difference(&block, &prism(&[outline], -depth, 1.0).unwrap()).unwrap()
    }

    fn compared(mesh: &Mesh, cutters: &[Cutter]) -> Vec<WayResult> {
        let library = CutterLibrary { cutter: cutters.to_vec() };
        let found = uncut(mesh, &UncutParams::of(library), &Task::default()).unwrap();
        let params =
            ElectrodeParams { cutters: Some(CutterLibrary { cutter: vec![Cutter::flat(0.5)] }), ..Default::default() };
        let own = electrodes(mesh, &found, &params, &Task::default()).unwrap();
        let ways = compare_divisions(mesh, &found, &own, &Task::default()).unwrap();
        assert_eq!(ways.iter().map(|w| w.way).collect::<Vec<_>>(), Way::ALL);
        assert!(ways.iter().all(|w| w.failure.is_none()) && ways[3].is_own, "{ways:?}");
        ways
    }

    #[test]
    fn an_angle_of_slots_is_divided_where_no_cutter_mills_its_head() {
        let ring = [(-6.0, -6.0), (6.0, -6.0), (6.0, -4.8), (-4.8, -4.8), (-4.8, 6.0), (-6.0, 6.0)];
        let ways = compared(&mold(&ring.map(|(x, y)| DVec2::new(x, y)), 4.0), &[Cutter::flat(2.0)]);
        let [undivided, .., own] = &ways[..] else { panic!("{ways:?}") };
        assert_eq!((undivided.heads, undivided.edges, undivided.edges_left, undivided.not_millable), (1, 1, 1, 1));
        assert_eq!((own.heads, own.edges, own.edges_left, own.not_millable), (2, 1, 0, 0), "{own:?}");
        assert!(own.largest_mm <= undivided.largest_mm);
    }

    /// A face of which a corner is uncut counts as uncut: the head fills the pocket (P3, figures 19 and 21).
    #[test]
    fn heads_of_whole_faces_are_as_large_as_the_faces() {
        let ways = compared(&mold(&rectangle(20.0, 14.0), 4.0), &[Cutter::flat(1.0)]);
        let [_, whole, _, own] = &ways[..] else { panic!("{ways:?}") };
        assert_eq!((whole.regions, own.regions), (1, 4));
        assert!(whole.largest_mm > 19.0 && own.largest_mm < 3.0, "{ways:?}");
        assert_eq!((own.electrodes, own.burns), (1, 4));
    }
}
