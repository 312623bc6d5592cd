//! The net of borders between regions: vertices, chains of sides between them, and the corners of free forms.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;

use super::corners;
use super::piece::Piece;
use super::regions::Region;
use super::skin::{Skin, sides_of};
use super::surface::{Surface, meet};

/// Turns (rad) at which a chain is divided: of any chain, and of one between two faces that are no free forms, which may
/// have coarse facets.
const SHARP: [f64; 2] = [0.5, 1.0];
/// Tolerances over which a turn is measured, at least.
const REACH: f64 = 4.0;
/// Tolerances by which a vertex may be moved to the surfaces around it.
const MOST_MOVED: f64 = 4.0;

/// A border between two regions from one vertex of the solid to another.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    /// The region on its left, and the one on its right.
    pub(super) regions: [u32; 2],
    /// Vertices of the skin.
    pub(super) vertices: Vec<u32>,
}

/// A chain as a part of the line around a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Use {
    /// Number of the chain.
    pub(super) chain: usize,
    /// Whether the line runs along it.
    pub(super) is_forward: bool,
    /// Place of its first vertex in the line.
    pub(super) start: usize,
}

/// The borders of all regions.
#[derive(Debug, Clone, Default)]
pub(super) struct Net {
    /// Vertices of the skin, those on borders moved onto the surfaces that meet there (mm).
    pub(super) points: Vec<DVec3>,
    /// Mesh of each region.
    pub(super) pieces: Vec<Piece>,
    /// Chains of sides between two regions, each once.
    pub(super) chains: Vec<Chain>,
    /// The chains of every line around every region.
    pub(super) uses: Vec<Vec<Vec<Use>>>,
    /// Of a free form the places in its line where its four sides begin.
    pub(super) corners: Vec<Option<[usize; 4]>>,
}

/// Builds the net; chains end at `splits` too.
pub(super) fn net(skin: &Skin, regions: &[Region], splits: &BTreeSet<u32>, tolerance: f64) -> Net {
    let around = around(skin);
    let points = placed(skin, regions, &around, tolerance);
    let pieces: Vec<Piece> = skin.members().iter().map(|members| Piece::of(skin, members, &points)).collect();
    let mut ends: BTreeSet<u32> =
        around.iter().filter(|(_, (n, r))| *n != 2 || r.len() != 2).map(|(v, _)| *v).collect();
    ends.extend(splits);
    let mut net = Net { points, pieces, ..Default::default() };
    close_rings(&net.pieces, &mut ends);
    net.lay(skin, &ends);
    for chain in &net.chains {
        ends.extend(net.sharp(chain, regions, tolerance));
    }
    for (piece, region) in net.pieces.iter().zip(regions) {
        let corners = if region.surface.is_none() { corners::corners(piece, &ends) } else { None };
        ends.extend(corners.iter().flatten().map(|&k| piece.of_skin[piece.loops[0][k] as usize]));
        net.corners.push(corners);
    }
    net.lay(skin, &ends);
    net
}

/// Of every vertex on a border the number of border sides that leave it, and the regions around it, rising.
fn around(skin: &Skin) -> BTreeMap<u32, (usize, Vec<u32>)> {
    let mut around: BTreeMap<u32, (usize, Vec<u32>)> = BTreeMap::new();
    for (&t, &region) in skin.triangles.iter().zip(&skin.region) {
        for (a, b) in sides_of(t) {
            let other = skin.region_across(a, b);
            if other != region {
                around.entry(a).or_default().0 += 1;
                [a, b].iter().for_each(|v| around.entry(*v).or_default().1.extend([region, other]));
            }
        }
    }
    for (_, regions) in around.values_mut() {
        regions.sort_unstable();
        regions.dedup();
    }
    around
}

/// The vertices of the skin, those on borders moved to where the planes, cylinders and cones around them meet.
fn placed(skin: &Skin, regions: &[Region], around: &BTreeMap<u32, (usize, Vec<u32>)>, tolerance: f64) -> Vec<DVec3> {
    let mut points = skin.points.clone();
    let mut shortest: HashMap<u32, f64> = HashMap::new();
    for (&t, &region) in skin.triangles.iter().zip(&skin.region) {
        for (a, b) in sides_of(t).into_iter().filter(|&(a, b)| skin.region_across(a, b) != region) {
            let length = skin.points[a as usize].distance(skin.points[b as usize]);
            for v in [a, b] {
                let known = shortest.entry(v).or_insert(length);
                *known = known.min(length);
            }
        }
    }
    for (&v, (_, beside)) in around {
        let surfaces: Vec<&Surface> = beside.iter().filter_map(|&r| regions[r as usize].surface.as_ref()).collect();
        let p = skin.points[v as usize];
        let q = meet(&surfaces, p);
        // Of short sides no end may pass the other.
        let most = (MOST_MOVED * tolerance).min(0.4 * shortest.get(&v).copied().unwrap_or(f64::INFINITY));
        if q.is_finite() && q.distance(p) <= most {
            points[v as usize] = q;
        }
    }
    points
}

/// Gives lines with fewer than two ends of chains further ones, so that no chain ends where it starts.
fn close_rings(pieces: &[Piece], ends: &mut BTreeSet<u32>) {
    for piece in pieces {
        for line in &piece.loops {
            let vertices: Vec<u32> = line.iter().map(|&v| piece.of_skin[v as usize]).collect();
            let known = (0..vertices.len()).find(|&k| ends.contains(&vertices[k]));
            let first = known.or_else(|| (0..vertices.len()).min_by_key(|&k| vertices[k])).unwrap_or(0);
            ends.insert(vertices[first]);
            if vertices.iter().filter(|v| ends.contains(v)).count() < 2 {
                ends.insert(vertices[(first + vertices.len() / 2) % vertices.len()]);
            }
        }
    }
}

impl Net {
    /// Divides the lines around all pieces at `ends`.
    fn lay(&mut self, skin: &Skin, ends: &BTreeSet<u32>) {
        let (mut known, mut chains, mut uses) = (HashMap::new(), Vec::new(), Vec::new());
        for (r, piece) in (0u32..).zip(&self.pieces) {
            let mut lines = Vec::new();
            for line in &piece.loops {
                let vertices: Vec<u32> = line.iter().map(|&v| piece.of_skin[v as usize]).collect();
                let mut of_line = Vec::new();
                for (start, vertices) in divided(&vertices, ends) {
                    let last = vertices.len() - 1;
                    if let Some(&chain) = known.get(&(vertices[last], vertices[last - 1])) {
                        of_line.push(Use { chain, is_forward: false, start });
                        continue;
                    }
                    known.insert((vertices[0], vertices[1]), chains.len());
                    of_line.push(Use { chain: chains.len(), is_forward: true, start });
                    let other = skin.region_across(vertices[0], vertices[1]);
                    chains.push(Chain { regions: [r, other], vertices });
                }
                lines.push(of_line);
            }
            uses.push(lines);
        }
        (self.chains, self.uses) = (chains, uses);
    }

    /// Points along a chain (mm).
    pub(super) fn line(&self, chain: &Chain) -> Vec<DVec3> {
        chain.vertices.iter().map(|&v| self.points[v as usize]).collect()
    }

    /// Vertices at which a chain turns sharply.
    fn sharp(&self, chain: &Chain, regions: &[Region], tolerance: f64) -> Vec<u32> {
        let is_free = |r: u32| regions[r as usize].surface.is_none();
        let limit = SHARP[usize::from(!chain.regions.iter().any(|&r| is_free(r)))];
        let line = self.line(chain);
        let towards = |k: usize, step: isize| {
            let mut at = k.wrapping_add_signed(step);
            while let Some(&p) = line.get(at) {
                if p.distance(line[k]) >= REACH * tolerance {
                    return p - line[k];
                }
                at = at.wrapping_add_signed(step);
            }
            if step < 0 { line[0] - line[k] } else { line[line.len() - 1] - line[k] }
        };
        let turn = |k: usize| {
            let (d, e) = (-towards(k, -1), towards(k, 1));
            d.cross(e).length().atan2(d.dot(e))
        };
        let turns: Vec<f64> =
            (0..line.len()).map(|k| if k == 0 || k + 1 == line.len() { 0.0 } else { turn(k) }).collect();
        // Of vertices side by side the one that turns most.
        let is_peak = |k: usize| {
            (0..line.len()).all(|j| {
                let is_beside = j != k && line[j].distance(line[k]) < REACH * tolerance;
                !is_beside || turns[j] < turns[k] || (turns[j] == turns[k] && j > k)
            })
        };
        let sharp = (1..line.len().saturating_sub(1)).filter(|&k| turns[k] > limit && is_peak(k));
        sharp.map(|k| chain.vertices[k]).collect()
    }
}

/// The stretches of a closed line between ends of chains, each with the place of its first vertex.
fn divided(vertices: &[u32], ends: &BTreeSet<u32>) -> Vec<(usize, Vec<u32>)> {
    let n = vertices.len();
    let starts: Vec<usize> = (0..n).filter(|&k| ends.contains(&vertices[k])).collect();
    let next = |k: usize| starts.get(k + 1).copied().unwrap_or(starts[0] + n);
    let stretch = |k: usize| (starts[k], (starts[k]..=next(k)).map(|i| vertices[i % n]).collect());
    (0..starts.len()).map(stretch).collect()
}
