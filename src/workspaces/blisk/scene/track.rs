//! The poses of one electrode in feed order, to be stepped through: the rows of a path, or the nodes found where
//! there is no path.

use feed::jam::Jam;
use feed::plan::FeedPlan;
use feed::pose::Pose;
use feed::problem::Node;

/// A pose of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Distance still withdrawn (mm).
    pub s: f64,
    /// Axis values.
    pub pose: Pose,
    /// The node that it is, counted from the final pose, if it is one.
    pub node: Option<usize>,
    /// Exact clearance, or that of the search's samples where there is no path (mm).
    pub clearance: f64,
}

/// Poses in feed order: outside first, the final pose last.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Track {
    stations: Vec<Station>,
    /// Whether the stations are rows of a path, between which the motion is linear and was verified.
    pub is_path: bool,
}

impl Track {
    /// The rows of the plan's path, or its nodes and where it jams if it has none.
    pub fn of_plan(plan: &FeedPlan) -> Self {
        let Some(planned) = &plan.path else {
            let nodes = Self::of_nodes(&plan.nodes);
            return match &plan.jam {
                Some(jam) => nodes.with_jam(jam),
                None => nodes,
            };
        };
        let rows = &planned.path.rows;
        let clearances = planned.certificate.row_clearance().iter().copied();
        let stations = rows.iter().zip(clearances).enumerate().map(|(i, (row, clearance))| {
            // The rows on the way to a node carry its number as well; the node itself is the last of them.
            let is_node = rows.get(i + 1).is_none_or(|next| next.node != row.node);
            Station { s: row.s, pose: row.pose, node: is_node.then_some(row.node), clearance }
        });
        Self { stations: stations.collect(), is_path: true }
    }

    /// A track with `station` as its only pose.
    pub fn standing(station: Station) -> Self {
        Self { stations: vec![station], is_path: false }
    }

    /// Nodes, which are counted from the final pose, turned round.
    pub fn of_nodes(nodes: &[Node]) -> Self {
        let station = |(i, n): (usize, &Node)| Station { s: n.s, pose: n.pose, node: Some(i), clearance: n.clearance };
        Self { stations: nodes.iter().enumerate().rev().map(station).collect(), is_path: false }
    }

    /// The track with one pose more before its first: that in which the electrode jams, further out by nature. What
    /// clearance it lacks there counts as negative.
    pub fn with_jam(mut self, jam: &Jam) -> Self {
        let clearance = -jam.contact().map_or(0.0, |c| c.lack);
        let station = Station { s: jam.s, pose: jam.pose, node: Some(jam.node), clearance };
        if jam.s > self.length() || self.is_empty() {
            self.stations.insert(0, station);
        }
        self
    }

    /// The stations in feed order.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Whether there is nothing to step through.
    pub fn is_empty(&self) -> bool {
        self.stations.is_empty()
    }

    /// Greatest withdrawn distance (mm).
    pub fn length(&self) -> f64 {
        self.stations.first().map_or(0.0, |s| s.s)
    }

    /// The station with withdrawn distance `s`, between the two beside it by linear motion of all axes.
    pub fn at(&self, s: f64) -> Option<Station> {
        let after = self.stations.partition_point(|p| p.s > s);
        let b = self.stations.get(after).or(self.stations.last())?;
        let a = self.stations.get(after.wrapping_sub(1)).unwrap_or(b);
        let span = a.s - b.s;
        let t = if span > 0.0 { ((a.s - s) / span).clamp(0.0, 1.0) } else { 1.0 };
        if t >= 1.0 {
            return Some(*b);
        }
        if t <= 0.0 {
            return Some(*a);
        }
        Some(Station {
            s: a.s - t * span,
            pose: a.pose.lerp(&b.pose, t),
            node: None,
            clearance: a.clearance + t * (b.clearance - a.clearance),
        })
    }

    /// The stations that are nodes, in feed order.
    pub fn nodes(&self) -> impl DoubleEndedIterator<Item = &Station> {
        self.stations.iter().filter(|s| s.node.is_some())
    }

    /// Withdrawn distance of the next node towards the final pose from `s`, or of the last.
    pub fn next_node(&self, s: f64) -> f64 {
        self.nodes().find(|n| n.s < s - 1e-9).map_or(0.0, |n| n.s)
    }

    /// Withdrawn distance of the node before `s` in feed order, or of the first.
    pub fn previous_node(&self, s: f64) -> f64 {
        self.nodes().rev().find(|n| n.s > s + 1e-9).map_or(self.length(), |n| n.s)
    }

    /// The node nearest to `s`: its place among [`nodes`](Self::nodes).
    pub fn nearest_node(&self, s: f64) -> Option<usize> {
        let distance = |n: &Station| (n.s - s).abs();
        self.nodes().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map(|(i, _)| i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feed::jam::JamCause;
    use feed::objective::ObjectiveValue;

    fn track() -> Track {
        let node = |i: u32| {
            let s = 0.5 * f64::from(i);
            let pose = Pose { x: -s, c: 0.1 * s, ..Pose::FINAL };
            Node { s, pose, h: 0.0, clearance: 0.1 + s, objective: ObjectiveValue::default() }
        };
        Track::of_nodes(&[0, 1, 2, 3].map(node))
    }

    #[test]
    fn stations_run_from_outside_to_the_final_pose() {
        let track = track();
        assert_eq!(track.length(), 1.5);
        assert_eq!(track.stations().last().unwrap().pose, Pose::FINAL);
        assert_eq!(track.at(0.0).unwrap().pose, Pose::FINAL);
        assert_eq!(track.at(9.0).unwrap().s, 1.5, "beyond the ends are the ends");
        assert_eq!(track.at(-1.0).unwrap().s, 0.0);
    }

    #[test]
    fn a_jam_lies_beyond_the_last_node_that_was_reached() {
        let pose = Pose { x: -2.0, ..Pose::FINAL };
        let jam = Jam { node: 4, s: 2.0, pose, cause: JamCause::Unknown, opening: None };
        let jammed = track().with_jam(&jam);
        assert_eq!((jammed.length(), jammed.at(2.0).unwrap().pose), (2.0, pose));
        assert_eq!(jammed.at(1.5), track().at(1.5), "what was reached stays as it was");
        assert_eq!(track().with_jam(&Jam { s: 1.0, ..jam }), track(), "a place that was passed is no end");
    }

    #[test]
    fn between_stations_every_axis_moves_in_proportion() {
        let middle = track().at(0.75).unwrap();
        assert!((middle.pose.x + 0.75).abs() < 1e-12 && (middle.pose.c - 0.075).abs() < 1e-12);
        assert!((middle.clearance - 0.85).abs() < 1e-12);
        assert_eq!(middle.node, None);
    }

    #[test]
    fn stepping_goes_from_node_to_node_and_stops_at_the_ends() {
        let track = track();
        assert_eq!(track.next_node(1.5), 1.0);
        assert_eq!(track.next_node(1.2), 1.0);
        assert_eq!(track.next_node(0.0), 0.0);
        assert_eq!(track.previous_node(0.0), 0.5);
        assert_eq!(track.previous_node(1.5), 1.5);
        assert_eq!(track.nearest_node(0.6), Some(2));
        assert_eq!(Track::default().at(1.0), None);
    }
}
