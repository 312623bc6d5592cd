//! The closed surface of one electrode: burning part, shoulder, shank and holder joined from rings.

use glam::DVec3;

use super::boundary::Section;
use super::holder::Block;
use super::make::{MOST_SHORTFALL, Which};
use super::measure::{self, Measures};
use super::ring::{Finisher, Layout, Reduction, Ring};
use super::{Column, Electrode, ElectrodeError, ElectrodeFace, ElectrodeParams, ElectrodePatch, EntrySide};
use crate::channel::Channel;
use geometry::exact::ExactMesh;
use geometry::mesh::{Mesh, normal_times_two_areas};
use geometry::patch::Patch;
use task::Cancel;

/// Rings of a shank inside the channel are at least this far apart (mm).
const SHANK_STEP: f64 = 0.45;

/// Everything one electrode is made from.
pub(super) struct Plan<'a> {
    pub channel: &'a Channel,
    /// Those of its part.
    pub params: &'a ElectrodeParams,
    pub which: Which,
    /// The span along the passage that it burns.
    pub range: [f64; 2],
    /// The boundary over that span and the way of the shank.
    pub sections: &'a [Section],
}

impl Plan<'_> {
    /// Sections in the order in which they leave the blisk.
    fn outwards(&self) -> Vec<&Section> {
        if self.which.at_last { self.sections.iter().collect() } else { self.sections.iter().rev().collect() }
    }

    /// The end of the burning part on the side of entry.
    fn entry_end(&self) -> f64 {
        if self.which.at_last { self.range[1] } else { self.range[0] }
    }

    fn burning_sections(&self) -> Vec<&Section> {
        let [from, to] = self.range;
        self.outwards().into_iter().filter(|s| (from - 1e-9..=to + 1e-9).contains(&s.line.along)).collect()
    }

    fn shank_sections(&self) -> Vec<&Section> {
        let sign = if self.which.at_last { 1.0 } else { -1.0 };
        let along = |section: &Section| section.line.along;
        let mut kept: Vec<&Section> = Vec::new();
        let mut beyond =
            self.outwards().into_iter().filter(|s| (along(s) - self.entry_end()) * sign >= -1e-9).peekable();
        while let Some(section) = beyond.next() {
            let is_last = beyond.peek().is_none();
            if is_last || kept.last().is_none_or(|k| (along(section) - along(k)).abs() >= SHANK_STEP) {
                kept.push(section);
            }
        }
        kept
    }
}

/// Makes the electrode of `plan` and measures it.
pub(super) fn build(plan: &Plan, finisher: &Finisher, cancel: &Cancel) -> Result<Electrode, ElectrodeError> {
    let params = plan.params;
    let Which { part, column, side, at_last } = plan.which;
    let is_deep = part != if at_last { params.parts - 1 } else { 0 };
    let inset = if is_deep { params.channel_shank_inset_mm } else { params.shank_inset_mm };
    let turns = super::own_turns(column, params.turns());
    let burning = finisher.rings(&plan.burning_sections(), Reduction { turns, inset: 0.0 }, cancel)?;
    let shank = finisher.rings(&plan.shank_sections(), Reduction { turns, inset }, cancel)?;
    let points = |ring: &Ring| (0..ring.points.len()).map(|k| ring.point(k)).collect::<Vec<_>>();
    let mut skin = Skin::new(finisher.layout);
    skin.add(burning.iter().map(points), |k| divided_face(finisher.layout.face(k), column));
    skin.add(shank.iter().take(1).map(points), |_| ElectrodeFace::EntryEnd);
    skin.add(shank.iter().skip(1).map(points), |_| ElectrodeFace::Shank);
    let mut assumed = Vec::new();
    if let Some(last) = shank.last() {
        let direction = side.direction();
        let last = points(last);
        // The shank goes on straight, to a plane beyond the face, or to where the whole holder is beyond the rim.
        let furthest = last.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
        let outline: Vec<DVec3> = last.iter().map(|p| p.reject_from_normalized(direction)).collect();
        let block = Block::around(&outline, (side, finisher.layout), params, &mut assumed);
        let end = furthest.max(outermost(plan, &block)) + params.shank_length_mm;
        let moved = |ring: &[DVec3], by: f64| ring.iter().map(|p| p + by * direction).collect::<Vec<_>>();
        skin.add([moved(&outline, end)], |_| ElectrodeFace::Shank);
        let block = moved(&block.ring(), end);
        skin.add([block.clone()], |_| ElectrodeFace::Holder);
        skin.add([moved(&block, params.holder_mm[0])], |_| ElectrodeFace::Holder);
    }
    let Skin { mesh, faces, patches, .. } = skin.closed();
    let measures = measure::measure(&mesh, &faces, finisher.boundary.blisk, cancel)?;
    let gap = params.spark_gap_mm;
    if measures.clearance < gap - MOST_SHORTFALL {
        let (clearance, at) = (measures.clearance, measures.closest);
        let nearest = ExactMesh::new(&mesh)?.nearest(at).triangle as usize;
        let is_of_shank = matches!(faces[nearest], ElectrodeFace::Shank | ElectrodeFace::Holder);
        if is_of_shank {
            return Err(ElectrodeError::ShankMeets { side, clearance, gap, at });
        }
        return Err(ElectrodeError::TooClose { clearance, gap, at });
    }
    Ok(finish(plan, (mesh, faces, patches), measures, assumed))
}

/// Face that a face of a burning ring becomes in a column: the wall that the column does not burn is the division.
fn divided_face(face: ElectrodeFace, column: Option<Column>) -> ElectrodeFace {
    match (column, face) {
        (Some(Column::Low), ElectrodeFace::HighWall) | (Some(Column::High), ElectrodeFace::LowWall) => {
            ElectrodeFace::Division
        }
        _ => face,
    }
}

fn finish(
    plan: &Plan,
    (mesh, faces, patches): (Mesh, Vec<ElectrodeFace>, Vec<ElectrodePatch>),
    m: Measures,
    mut assumed: Vec<String>,
) -> Electrode {
    if !plan.channel.shrouded {
        assumed.push("The blisk has no shroud: the electrode ends at the radius of the blade tips.".to_owned());
    }
    Electrode {
        enters_from: plan.which.side,
        reference_point: measure::reference_point(&mesh, &faces, plan.which.side, plan.channel.flow),
        stage: None,
        part: plan.which.part,
        parts: plan.params.parts,
        column: plan.which.column,
        least_thickness_mm: m.thickness,
        volume_mm3: mesh.volume(),
        burn_area_mm2: m.burn_area,
        undersize_mm: plan.params.spark_gap_mm,
        clearance_mm: m.clearance,
        assumed,
        mesh,
        faces,
        patches,
    }
}

/// Position along the direction of withdrawal at which the holder block is out of the blisk (mm).
fn outermost(plan: &Plan, block: &Block) -> f64 {
    let channel = plan.channel;
    let (middle, half_width) = (block.center().y.abs(), block.reach(DVec3::Y));
    match plan.which.side {
        EntrySide::MinusX => -channel.faces_x[0],
        EntrySide::PlusX => channel.faces_x[1],
        EntrySide::Outward => {
            let rim = channel.meridian.iter().map(|s| s.hub.y.max(s.shroud.y)).fold(0.0, f64::max);
            let nearest = (middle - half_width).max(0.0);
            (rim * rim - nearest * nearest).max(0.0).sqrt()
        }
        EntrySide::Inward => {
            let bore = channel.meridian.iter().map(|s| s.hub.y.min(s.shroud.y)).fold(f64::INFINITY, f64::min);
            let farthest = middle + half_width;
            -(bore * bore - farthest * farthest).max(0.0).sqrt()
        }
    }
}

/// A growing tube of rings, from the far end outwards; oriented when it is closed.
struct Skin {
    layout: Layout,
    mesh: Mesh,
    faces: Vec<ElectrodeFace>,
    patches: Vec<ElectrodePatch>,
}

impl Skin {
    fn new(layout: Layout) -> Self {
        Self { layout, mesh: Mesh::default(), faces: Vec::new(), patches: Vec::new() }
    }

    fn quad(&mut self, corners: [u32; 4], face: ElectrodeFace) {
        let [a, b, c, d] = if face == ElectrodeFace::Holder { self.unfolded(corners) } else { corners };
        self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
        self.faces.extend([face; 2]);
    }

    /// The corners of a flat face, begun so that both its triangles look the same way.
    fn unfolded(&self, corners: [u32; 4]) -> [u32; 4] {
        let [a, b, c, d] = corners;
        let normal = |t: [u32; 3]| normal_times_two_areas(t.map(|v| self.mesh.vertices[v as usize]));
        let is_folded = normal([a, b, c]).dot(normal([a, c, d])) < 0.0;
        if is_folded { [b, c, d, a] } else { corners }
    }

    /// Joins rings to the last one: a patch on each of the four sides.
    fn add(&mut self, rings: impl IntoIterator<Item = Vec<DVec3>>, face: impl Fn(usize) -> ElectrodeFace) {
        let n = self.layout.len() as u32;
        let first = (self.mesh.vertices.len() as u32).saturating_sub(n);
        for ring in rings {
            let start = self.mesh.vertices.len() as u32;
            self.mesh.vertices.extend(ring);
            for k in (0..n).filter(|_| start > 0) {
                let (a, b) = (start - n + k, start - n + (k + 1) % n);
                self.quad([a, b, b + n, a + n], face(k as usize));
            }
        }
        let starts: Vec<u32> = (first..self.mesh.vertices.len() as u32).step_by(n as usize).collect();
        if starts.len() < 2 {
            return;
        }
        for corners in self.layout.corners().windows(2) {
            let along = |start: &u32| (corners[0]..=corners[1]).map(|k| start + k as u32 % n).collect::<Vec<_>>();
            // The columns run along the rings and the rows from ring to ring, against the order in quads.
            let grid = Patch::new(corners[1] - corners[0] + 1, starts.iter().flat_map(along).collect());
            let turned = grid.map(|grid| ElectrodePatch { face: face(corners[0]), grid: grid.turned_over() });
            self.patches.extend(turned);
        }
    }

    /// The tube with both ends capped and its triangles turned outwards.
    fn closed(mut self) -> Self {
        let last = self.mesh.vertices.len() - self.layout.len();
        self.cap(0, true, ElectrodeFace::FarEnd);
        self.cap(last, false, ElectrodeFace::Holder);
        if self.mesh.volume() < 0.0 {
            self.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            self.patches.iter_mut().for_each(|patch| patch.grid = patch.grid.turned_over());
        }
        self
    }

    /// Fills the plane ring that starts at vertex `start` with a grid blended from its four sides (Coons).
    fn cap(&mut self, start: usize, is_first: bool, face: ElectrodeFace) {
        let layout = self.layout;
        let Layout { rows, columns } = layout;
        let ring = self.mesh.vertices[start..start + layout.len()].to_vec();
        let mut grid = vec![vec![0u32; columns + 1]; rows + 1];
        for (v, row) in grid.iter_mut().enumerate() {
            for (j, id) in row.iter_mut().enumerate() {
                let on_ring = match (v, j) {
                    (0, j) => Some(layout.hub(j)),
                    (v, j) if v == rows => Some(layout.shroud(j)),
                    (v, 0) => Some(layout.low(v)),
                    (v, j) if j == columns => Some(layout.high(v)),
                    _ => None,
                };
                *id = match on_ring {
                    Some(k) => (start + k) as u32,
                    None => {
                        self.mesh.vertices.push(blended(&ring, layout, v, j));
                        self.mesh.vertices.len() as u32 - 1
                    }
                };
            }
        }
        for v in 0..rows {
            for j in 0..columns {
                let (a, b, c, d) = (grid[v][j], grid[v][j + 1], grid[v + 1][j + 1], grid[v + 1][j]);
                self.quad(if is_first { [a, d, c, b] } else { [a, b, c, d] }, face);
            }
        }
        let grid = Patch::new(columns + 1, grid.concat());
        let outwards = |grid: Patch| if is_first { grid } else { grid.turned_over() };
        self.patches.extend(grid.map(|grid| ElectrodePatch { face, grid: outwards(grid) }));
    }
}

fn blended(ring: &[DVec3], layout: Layout, v: usize, j: usize) -> DVec3 {
    let (s, t) = (j as f64 / layout.columns as f64, v as f64 / layout.rows as f64);
    let rise = ring[layout.hub(j)].lerp(ring[layout.shroud(j)], t);
    let across = ring[layout.low(v)].lerp(ring[layout.high(v)], s);
    let bottom = ring[layout.hub(0)].lerp(ring[layout.hub(layout.columns)], s);
    let top = ring[layout.shroud(0)].lerp(ring[layout.shroud(layout.columns)], s);
    rise + across - bottom.lerp(top, t)
}
