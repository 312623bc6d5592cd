//! Edges: chains of triangle sides between two faces.

use glam::DVec3;

use super::topology::{NONE, Topology};
use super::{Edge, EdgeKind};

/// Cosine of the turn of a chain that ends it: no curve is tessellated as coarsely.
const CORNER: f64 = 0.75;

/// A triangle side between two faces, in the direction of the first face's triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// The faces, the lower number first.
    pub(super) faces: [u32; 2],
    pub(super) kind: EdgeKind,
    /// Angle between the outward normals (rad), positive where convex.
    pub(super) angle: f64,
    /// Points from and to.
    pub(super) ends: [u32; 2],
}

/// Joins segments to chains. `borders` are points on sides without a neighbour: a chain ends there.
pub(super) fn chains(topology: &Topology, segments: &[Segment], borders: &[u32], straight: f64) -> Vec<Edge> {
    let joints = Joints::of(topology, segments, borders);
    let mut is_used = vec![false; segments.len()];
    let starts = (0..segments.len()).filter(|&s| joints.before[s] == NONE);
    // What is left after the open chains are closed ones: they start at their first segment.
    let mut found = Vec::new();
    for start in starts.chain(0..segments.len()) {
        if is_used[start] {
            continue;
        }
        let mut members = Vec::new();
        let mut next = start as u32;
        while next != NONE && !is_used[next as usize] {
            is_used[next as usize] = true;
            members.push(segments[next as usize]);
            next = joints.after[next as usize];
        }
        found.push(edge(topology, &members, straight));
    }
    found.sort_by_key(|e| e.faces);
    found
}

/// The segment before and after each; [`NONE`] where a chain ends.
struct Joints {
    before: Vec<u32>,
    after: Vec<u32>,
}

impl Joints {
    fn of(topology: &Topology, segments: &[Segment], borders: &[u32]) -> Self {
        let mut ends: Vec<(u32, bool, u32)> = Vec::with_capacity(segments.len() * 2 + borders.len());
        for (i, segment) in (0u32..).zip(segments) {
            ends.extend([(segment.ends[1], false, i), (segment.ends[0], true, i)]);
        }
        ends.extend(borders.iter().map(|&v| (v, true, NONE)));
        ends.sort_unstable();
        let mut joints = Self { before: vec![NONE; segments.len()], after: vec![NONE; segments.len()] };
        for group in ends.chunk_by(|a, b| a.0 == b.0) {
            let [(_, false, i), (_, true, j)] = *group else { continue };
            if j == NONE || i == j {
                continue;
            }
            let (a, b) = (&segments[i as usize], &segments[j as usize]);
            let [d, e] = [a, b].map(|s| direction(topology, s));
            if a.faces == b.faces && a.kind == b.kind && d.dot(e) >= CORNER {
                joints.after[i as usize] = j;
                joints.before[j as usize] = i;
            }
        }
        joints
    }
}

fn direction(topology: &Topology, segment: &Segment) -> DVec3 {
    let [a, b] = segment.ends.map(|v| topology.points[v as usize]);
    (b - a).normalize_or_zero()
}

fn edge(topology: &Topology, members: &[Segment], straight: f64) -> Edge {
    let point = |v: u32| topology.points[v as usize];
    let vertices: Vec<u32> = members.iter().map(|s| s.ends[0]).chain(members.last().map(|last| last.ends[1])).collect();
    let (mut length, mut turned) = (0.0, 0.0);
    for segment in members {
        let size = point(segment.ends[0]).distance(point(segment.ends[1]));
        length += size;
        turned += size * segment.angle;
    }
    let first = point(vertices[0]);
    let chord = point(vertices[vertices.len() - 1]) - first;
    let along = chord.normalize_or_zero();
    let off = |v: u32| (point(v) - first) - along * (point(v) - first).dot(along);
    let bend = vertices.iter().map(|&v| off(v).length()).fold(0.0, f64::max);
    let is_straight = along != DVec3::ZERO && bend <= straight;
    Edge { faces: members[0].faces, kind: members[0].kind, angle: turned / length, is_straight, bend, length, vertices }
}
