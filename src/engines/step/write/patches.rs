//! The boundary of a solid whose faces are known: patches of its mesh.
//!
//! Patches share whole sides, so that every side is one edge. Opposite sides of a patch, and with them the sides of whole
//! strips of patches, have the same parameters and knots. A surface is the tensor product of fits along its rows and its
//! columns; as these keep the ends of what they fit, its border is the curves of its edges. Strips are cut where free
//! forms in them have a crease.
//!
//! Free forms are drawn in where they reach beyond the mesh, so that the solid stays inside of it. Flat patches stay where
//! they are, and those side by side in one plane become one face.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use geometry::exact::ExactMesh;
use geometry::groups::Groups;
use geometry::mesh::Mesh;
use geometry::patch::Patch;
use geometry::weld::Weld;
use glam::DVec3;
use rayon::prelude::*;
use task::Task;

use super::brep::{Brep, Edge, Face, FaceSurface, enclosed};
use super::curve::{EdgeCurve, Form, fitted_within, is_straight};
use super::spline::{Curve, Knots, SplineSurface};
use super::surface::{Axes, Surface, least_step, meet};
use super::{StepPart, StepPatch, StepWriteError};

/// Distance of the vertices of a flat patch from its plane at most (mm): coordinates may have single precision.
const FLAT: f64 = 1e-4;
/// Length of an interval of parameters against the mean at least.
const LEAST_INTERVAL: f64 = 1e-3;
/// Mean turn (rad) of the lines of a free form at a vertex from which on it has a crease there.
const CREASE: f64 = 0.5;

/// Places between two looks at the flag that cancels.
const BLOCK: usize = 4096;
/// Sine of the angle between a free form and the planes beside it from which on it is drawn in along them.
const LEAST_SLOPE: f64 = 0.2;
/// How much farther than it reaches beyond the mesh a free form is drawn in: neighbours that are not hold it back.
const MORE: f64 = 1.15;

/// A side of a patch.
#[derive(Debug, Clone, Copy)]
struct Use {
    chain: usize,
    /// Whether the side runs along its chain.
    is_forward: bool,
}

/// A side that two patches share.
#[derive(Debug, Clone)]
struct Chain {
    vertices: Vec<u32>,
    /// The patches on its left and right, each with the number of its side.
    beside: Vec<(usize, usize)>,
}

/// A patch over welded vertices.
#[derive(Debug, Clone)]
struct Cell {
    grid: Patch,
    role: u16,
    /// Plane of a flat patch.
    plane: Option<Surface>,
    uses: [Use; 4],
}

/// All patches of a part.
#[derive(Debug, Clone, Default)]
pub(super) struct Sheet {
    /// Vertices (mm).
    points: Vec<DVec3>,
    /// Places of the vertices in the mesh (mm).
    of_mesh: Vec<DVec3>,
    /// By how much each vertex is drawn in (mm).
    drawn_in: Vec<f64>,
    cells: Vec<Cell>,
    /// Cells of every face: one, or flat ones side by side.
    faces: Vec<Vec<usize>>,
    chains: Vec<Chain>,
    /// The strip of each chain, and whether it runs along it.
    strip_of: Vec<(usize, bool)>,
    strips: usize,
}

/// Parameters and knots that all lines of a strip have in common.
#[derive(Debug)]
struct Lay {
    /// Parameters of the vertices, from 0 to 1.
    parameters: Vec<f64>,
    /// Knots of the curves.
    knots: Knots,
}

impl Lay {
    fn reversed(&self) -> Self {
        Self { parameters: self.parameters.iter().rev().map(|t| 1.0 - t).collect(), knots: self.knots.reversed() }
    }

    /// The curve over these knots that is nearest to the straight sides of a line.
    fn curve(&self, line: &[DVec3]) -> Option<Curve> {
        Curve::along(self.knots.clone(), &self.parameters, line)
    }
}

impl Sheet {
    /// The boundary of the part.
    pub(super) fn brep(&self, tolerance: f64, task: &Task) -> Result<Brep, StepWriteError> {
        let lays: Result<Vec<Lay>, _> =
            (0..self.strips).into_par_iter().map(|strip| self.lay(strip, tolerance, task)).collect();
        let lays = lays?;
        let curves: Result<Vec<EdgeCurve>, _> =
            (0..self.chains.len()).into_par_iter().map(|k| self.curve(k, &lays, tolerance)).collect();
        let surfaces: Result<Vec<FaceSurface>, _> =
            (0..self.cells.len()).into_par_iter().map(|k| self.surface(k, &lays, task)).collect();
        self.assembled(curves?, surfaces?)
    }

    /// The patches of a part over welded vertices, cut along creases.
    pub(super) fn of(part: &StepPart) -> Result<Self, StepWriteError> {
        let mut weld = Weld::with_capacity(part.mesh.vertices.len());
        let number: Vec<u32> = part.mesh.vertices.iter().map(|&p| weld.add(p)).collect();
        let welded = |patch: &StepPatch| {
            let grid = patch.grid.renumbered(|v| number.get(v as usize).copied());
            Ok((grid.ok_or(StepWriteError::Unusable)?, patch.role))
        };
        let patches: Vec<(Patch, u16)> = part.patches.iter().map(welded).collect::<Result<_, StepWriteError>>()?;
        let whole = Self::with(weld.into_points(), patches)?;
        let creases = whole.creases();
        let cut = whole.cells.iter().flat_map(|cell| {
            let [rows, columns] = [0, 1].map(|k| whole.stretches(cell.uses[k], &creases));
            let within = move |rows: [usize; 2]| columns.clone().into_iter().map(move |columns| (rows, columns));
            let parts = rows.into_iter().flat_map(within);
            parts.filter_map(|(rows, columns)| Some((cell.grid.part(rows, columns)?, cell.role)))
        });
        let cut: Vec<(Patch, u16)> = cut.collect();
        Self::with(whole.of_mesh, cut)
    }

    /// Patches without width are left out.
    fn with(points: Vec<DVec3>, patches: impl IntoIterator<Item = (Patch, u16)>) -> Result<Self, StepWriteError> {
        let mut sheet =
            Self { drawn_in: vec![0.0; points.len()], of_mesh: points.clone(), points, ..Default::default() };
        let mut known: HashMap<(u32, u32), usize> = HashMap::new();
        for (grid, role) in patches {
            let sides = grid.sides();
            let is_narrow = |k: usize| sides[k].iter().rev().eq(&sides[k + 2]);
            if !is_narrow(0) && !is_narrow(1) {
                let cell = sheet.cells.len();
                let uses = [0, 1, 2, 3].map(|k| sheet.enter((cell, k), &sides[k], &mut known));
                let plane = plane(&grid, &sheet.points);
                sheet.cells.push(Cell { grid, role, plane, uses });
            }
        }
        if let Some(chain) = sheet.chains.iter().find(|chain| chain.beside.len() != 2) {
            return Err(StepWriteError::Patches { at: sheet.points[chain.vertices[0] as usize] });
        }
        sheet.find_strips()?;
        sheet.join_flat();
        sheet.place();
        Ok(sheet)
    }

    /// The chain of a side, a new one unless its neighbour has it already.
    fn enter(&mut self, beside: (usize, usize), side: &[u32], known: &mut HashMap<(u32, u32), usize>) -> Use {
        let last = side.len() - 1;
        let found = known.get(&(side[last], side[last - 1])).copied();
        if let Some(chain) = found.filter(|&c| self.chains[c].vertices.iter().rev().eq(side)) {
            self.chains[chain].beside.push(beside);
            return Use { chain, is_forward: false };
        }
        let chain = self.chains.len();
        known.insert((side[0], side[1]), chain);
        self.chains.push(Chain { vertices: side.to_vec(), beside: vec![beside] });
        Use { chain, is_forward: true }
    }

    /// Draws the vertices of free forms in around places that are outside of the mesh by their distances (mm); whether any
    /// was.
    pub(super) fn draw_in(&mut self, beyond: &[(f64, DVec3)], task: &Task) -> Result<bool, StepWriteError> {
        let free = self.cells.iter().filter(|cell| cell.plane.is_none());
        let triangles: Vec<[u32; 3]> =
            free.flat_map(|cell| cell.grid.quads()).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        if triangles.is_empty() {
            return Ok(false);
        }
        let mesh = Mesh { vertices: self.of_mesh.clone(), triangles };
        let exact = ExactMesh::new(&mesh).map_err(|_| StepWriteError::Unusable)?;
        let near = |&(distance, p): &(f64, DVec3)| {
            let nearest = exact.nearest(p);
            // Places of planes are none of the free forms'.
            let is_its = nearest.point.distance(p) <= 2.0 * distance + FLAT;
            is_its.then_some((distance, nearest.triangle as usize))
        };
        let mut more = vec![0.0f64; self.points.len()];
        for block in beyond.chunks(BLOCK) {
            task.check()?;
            let found: Vec<_> = block.par_iter().filter_map(near).collect();
            for (distance, triangle) in found {
                for v in mesh.triangles[triangle] {
                    more[v as usize] = more[v as usize].max(MORE * distance);
                }
            }
        }
        let is_any = more.iter().any(|more| *more > 0.0);
        self.drawn_in.iter_mut().zip(more).for_each(|(all, more)| *all += more);
        self.place();
        Ok(is_any)
    }

    /// Moves the vertices of free forms inwards by what they are drawn in, and those of planes onto them.
    fn place(&mut self) {
        let mut around: BTreeMap<u32, (Vec<&Surface>, Vec<DVec3>)> = BTreeMap::new();
        for cell in &self.cells {
            for (v, normal) in normals(&cell.grid, &self.of_mesh) {
                let (planes, free) = around.entry(v).or_default();
                match &cell.plane {
                    Some(plane) => planes.push(plane),
                    None => free.push(normal),
                }
            }
        }
        for (v, (planes, free)) in around {
            let p = meet(&planes, self.of_mesh[v as usize]);
            // What is drawn in stays on the planes.
            let mut held: Vec<DVec3> = Vec::new();
            for plane in planes {
                let left = held.iter().fold(plane.distance(p).1, |n, h| n.reject_from_normalized(*h));
                held.extend(left.try_normalize().filter(|_| left.length() > LEAST_SLOPE));
            }
            let along = free.iter().map(|n| held.iter().fold(*n, |n, h| n.reject_from_normalized(*h)));
            let steep: Vec<DVec3> = along.filter(|n| n.length() > LEAST_SLOPE).collect();
            let way = self.drawn_in[v as usize];
            // Along planes the way to the face is longer; at a sharp edge the place that meets both its sides is too far away.
            let most = steep.iter().map(|n| way / n.length()).fold(0.0, f64::max);
            let step = least_step(steep.iter().map(|&n| (way, n))).clamp_length_max(most);
            self.points[v as usize] = p - held.iter().fold(step, |step, h| step.reject_from_normalized(*h));
        }
    }

    fn line(&self, chain: usize) -> Vec<DVec3> {
        self.chains[chain].vertices.iter().map(|&v| self.points[v as usize]).collect()
    }

    /// Numbers the strips: chains that face each other across patches belong to one.
    fn find_strips(&mut self) -> Result<(), StepWriteError> {
        let mut found: Vec<Option<(usize, bool)>> = vec![None; self.chains.len()];
        for seed in 0..self.chains.len() {
            if found[seed].is_some() {
                continue;
            }
            found[seed] = Some((self.strips, true));
            let mut open = vec![(seed, true)];
            while let Some((chain, is_along)) = open.pop() {
                for &(cell, side) in &self.chains[chain].beside {
                    let uses = &self.cells[cell].uses;
                    let (here, across) = (uses[side], uses[(side + 2) % 4]);
                    // Opposite sides run round the patch against each other.
                    let is_along = is_along == (here.is_forward != across.is_forward);
                    match found[across.chain] {
                        None => {
                            found[across.chain] = Some((self.strips, is_along));
                            open.push((across.chain, is_along));
                        }
                        Some((_, known)) if known != is_along => {
                            let at = self.points[self.chains[chain].vertices[0] as usize];
                            return Err(StepWriteError::Patches { at });
                        }
                        Some(_) => {}
                    }
                }
            }
            self.strips += 1;
        }
        self.strip_of = found.into_iter().flatten().collect();
        Ok(())
    }

    /// The strip of a side of a patch, and whether the side runs along it.
    fn strip(&self, side: Use) -> (usize, bool) {
        let (strip, is_along) = self.strip_of[side.chain];
        (strip, is_along == side.is_forward)
    }

    /// The lines of the free forms of a strip, along it, patch by patch; those of all patches where there are none.
    fn lines(&self, strip: usize) -> Vec<Vec<Vec<DVec3>>> {
        let of = |is_any: bool| {
            let cells = self.cells.iter().filter(move |cell| is_any || cell.plane.is_none());
            let directed = cells.flat_map(|cell| [0, 1].map(|direction| (cell, direction)));
            let of_strip = directed.filter_map(|(cell, direction)| {
                let (own, is_along) = self.strip(cell.uses[direction]);
                (own == strip).then(|| {
                    let mut lines = lines_of(&cell.grid, direction, &self.points);
                    lines.iter_mut().filter(|_| !is_along).for_each(|line| line.reverse());
                    lines
                })
            });
            of_strip.collect::<Vec<_>>()
        };
        let of_free = of(false);
        if of_free.is_empty() { of(true) } else { of_free }
    }

    /// The creases of every strip: numbers of vertices along it.
    fn creases(&self) -> Vec<BTreeSet<usize>> {
        let of_strip = |strip: usize| {
            let mut creases = BTreeSet::new();
            for lines in self.lines(strip) {
                for k in 1..lines[0].len() - 1 {
                    let turn = |line: &Vec<DVec3>| {
                        let (d, e) = (line[k] - line[k - 1], line[k + 1] - line[k]);
                        d.cross(e).length().atan2(d.dot(e))
                    };
                    if lines.iter().map(turn).sum::<f64>() > CREASE * lines.len() as f64 {
                        creases.insert(k);
                    }
                }
            }
            creases
        };
        (0..self.strips).map(of_strip).collect()
    }

    /// The stretches of a side between creases, as first and last vertex.
    fn stretches(&self, side: Use, creases: &[BTreeSet<usize>]) -> Vec<[usize; 2]> {
        let last = self.chains[side.chain].vertices.len() - 1;
        let (strip, is_along) = self.strip(side);
        let own = |k: &usize| if is_along { *k } else { last - *k };
        let mut ends: Vec<usize> = [0, last].into_iter().chain(creases[strip].iter().map(own)).collect();
        ends.sort_unstable();
        ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// Parameters in the mean proportion of the chords of its lines, and knots so dense that a curve over them follows
    /// every line.
    fn lay(&self, strip: usize, tolerance: f64, task: &Task) -> Result<Lay, StepWriteError> {
        let lines = self.lines(strip).concat();
        let mut sums = vec![0.0; lines[0].len() - 1];
        for line in &lines {
            let chords: Vec<f64> = line.windows(2).map(|w| w[0].distance(w[1])).collect();
            let length = chords.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            sums.iter_mut().zip(chords).for_each(|(sum, chord)| *sum += chord / length);
        }
        let parameters = cumulated(&sums);
        let knots = fitted_within(&lines, &parameters, tolerance, task)?;
        Ok(Lay { parameters, knots })
    }

    fn curve(&self, chain: usize, lays: &[Lay], tolerance: f64) -> Result<EdgeCurve, StepWriteError> {
        let line = self.line(chain);
        let (strip, is_along) = self.strip_of[chain];
        let reversed;
        let lay = if is_along {
            &lays[strip]
        } else {
            reversed = lays[strip].reversed();
            &reversed
        };
        let spline = lay.curve(&line).ok_or(StepWriteError::Divide { at: line[0] })?;
        let planes = self.chains[chain].beside.iter().filter_map(|&(cell, _)| self.cells[cell].plane.as_ref());
        let off = |plane: &Surface| spline.controls.iter().map(|&p| plane.gap(p)).fold(0.0, f64::max);
        let gap = planes.map(off).fold(0.0, f64::max);
        let form = if is_straight(&line, tolerance) { Form::Line } else { Form::Spline };
        Ok(EdgeCurve { form, spline, parameters: lay.parameters.clone(), gap, split: None })
    }

    fn surface(&self, cell: usize, lays: &[Lay], task: &Task) -> Result<FaceSurface, StepWriteError> {
        task.check()?;
        let Cell { grid, plane, uses, .. } = &self.cells[cell];
        if let Some(plane) = plane {
            return Ok(FaceSurface::Exact(plane.clone()));
        }
        let lay = |direction: usize| {
            let (strip, is_along) = self.strip(uses[direction]);
            if is_along {
                Lay { parameters: lays[strip].parameters.clone(), knots: lays[strip].knots.clone() }
            } else {
                lays[strip].reversed()
            }
        };
        let [along_rows, along_columns] = [lay(0), lay(1)];
        let unfit = || StepWriteError::Divide { at: self.points[grid.at(0, 0) as usize] };
        // Control points along the rows for every column, then along the columns for each of these.
        let mut of_columns = Vec::with_capacity(grid.columns());
        for line in lines_of(grid, 0, &self.points) {
            of_columns.push(along_rows.curve(&line).ok_or_else(unfit)?.controls);
        }
        let mut controls = Vec::new();
        for i in 0..along_rows.knots.count() {
            let line: Vec<DVec3> = of_columns.iter().map(|column| column[i]).collect();
            controls.extend(along_columns.curve(&line).ok_or_else(unfit)?.controls);
        }
        Ok(FaceSurface::Free(SplineSurface { knots: [along_rows.knots, along_columns.knots], controls }))
    }

    fn assembled(&self, curves: Vec<EdgeCurve>, surfaces: Vec<FaceSurface>) -> Result<Brep, StepWriteError> {
        let mut brep = Brep { edge_gap: curves.iter().map(|c| c.gap).fold(0.0, f64::max), ..Default::default() };
        // Chains inside of a face are no edges.
        let mut face_of = vec![0; self.cells.len()];
        for (face, cells) in self.faces.iter().enumerate() {
            cells.iter().for_each(|&cell| face_of[cell] = face);
        }
        let (mut number, mut edge_of) = (HashMap::new(), vec![None; self.chains.len()]);
        for (k, (chain, curve)) in self.chains.iter().zip(curves).enumerate() {
            if face_of[chain.beside[0].0] == face_of[chain.beside[1].0] {
                continue;
            }
            let ends = [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]].map(|v| {
                *number.entry(v).or_insert_with(|| {
                    brep.vertices.push(self.points[v as usize]);
                    brep.vertices.len() - 1
                })
            });
            edge_of[k] = Some(brep.edges.len());
            brep.edges.push(Edge { ends, curve });
        }
        for cells in &self.faces {
            let first = &self.cells[cells[0]];
            let surface = surfaces[cells[0]].clone();
            let uses = cells.iter().flat_map(|&cell| self.cells[cell].uses);
            let uses: Vec<(usize, bool)> =
                uses.filter_map(|used| Some((edge_of[used.chain]?, used.is_forward))).collect();
            let at = self.points[first.grid.at(0, 0) as usize];
            let mut loops = loops(&uses, &brep.edges).ok_or(StepWriteError::Patches { at })?;
            if let FaceSurface::Exact(plane) = &surface {
                // The loop that goes around all others encloses most.
                let area = |edges: &Vec<(usize, bool)>| {
                    let ends = edges.iter().flat_map(|&(e, is_forward)| {
                        let mut controls = brep.edges[e].curve.spline.controls.clone();
                        if !is_forward {
                            controls.reverse();
                        }
                        controls
                    });
                    enclosed(plane, &ends.collect::<Vec<_>>())
                };
                loops.sort_by(|a, b| area(b).total_cmp(&area(a)));
            }
            brep.faces.push(Face { surface, role: first.role, loops });
        }
        Ok(brep)
    }

    /// Gathers flat patches of one role side by side in one plane, which is that of the largest.
    fn join_flat(&mut self) {
        let mut groups = Groups::of(self.cells.len());
        let is_on = |plane: &Surface, cell: &Cell| {
            cell.grid.sides().iter().flatten().all(|v| plane.gap(self.of_mesh[*v as usize]) <= FLAT)
        };
        for chain in &self.chains {
            let [a, b] = [0, 1].map(|k| chain.beside[k].0);
            let [here, there] = [a, b].map(|k| &self.cells[k]);
            let (Some(plane), Some(other)) = (&here.plane, &there.plane) else { continue };
            // Where a patch is folded onto itself its normal may point inwards.
            if here.role == there.role && is_on(plane, there) && is_on(other, here) {
                groups.join(a, b);
            }
        }
        let (numbers, count) = groups.numbers();
        let mut faces = vec![Vec::new(); count];
        numbers.into_iter().enumerate().for_each(|(cell, face)| faces[face as usize].push(cell));
        for cells in faces.iter().filter(|cells| cells.len() > 1) {
            let size = |cell: &usize| area(&self.cells[*cell].grid, &self.of_mesh).length();
            let sizes = cells.iter().map(|cell| (size(cell), *cell));
            let largest = sizes.reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, cell)| cell);
            let plane = largest.and_then(|cell| self.cells[cell].plane.clone());
            cells.iter().for_each(|&cell| self.cells[cell].plane.clone_from(&plane));
        }
        self.faces = faces;
    }
}

/// The plane of a patch, if it is flat.
fn plane(grid: &Patch, points: &[DVec3]) -> Option<Surface> {
    let normal = area(grid, points).try_normalize()?;
    let all: Vec<DVec3> = lines_of(grid, 1, points).concat();
    let origin = all.iter().sum::<DVec3>() / all.len() as f64;
    let is_flat = all.iter().all(|p| (p - origin).dot(normal).abs() <= FLAT);
    is_flat.then(|| Surface::Plane(Axes::along(origin, normal)))
}

/// The points of a patch line by line: from row to row in each column (0), or from column to column in each row (1).
fn lines_of(grid: &Patch, direction: usize, points: &[DVec3]) -> Vec<Vec<DVec3>> {
    grid.lines(direction).into_iter().map(|line| line.into_iter().map(|v| points[v as usize]).collect()).collect()
}

/// The area of a patch as a vector along its mean normal (mm^2).
fn area(grid: &Patch, points: &[DVec3]) -> DVec3 {
    let quads = grid.quads().map(|corners| corners.map(|v| points[v as usize]));
    0.5 * quads.map(|[a, b, c, d]| (c - a).cross(d - b)).sum::<DVec3>()
}

/// The vertices of a patch, rising, with the unit normals of the patch there.
fn normals(grid: &Patch, points: &[DVec3]) -> Vec<(u32, DVec3)> {
    let mut sums: BTreeMap<u32, DVec3> = BTreeMap::new();
    for corners in grid.quads() {
        let [a, b, c, d] = corners.map(|v| points[v as usize]);
        let normal = (c - a).cross(d - b);
        corners.iter().for_each(|v| *sums.entry(*v).or_default() += normal);
    }
    sums.into_iter().map(|(v, sum)| (v, sum.normalize_or_zero())).collect()
}

/// Parameters from 0 to 1 with intervals in the proportion of `lengths`.
fn cumulated(lengths: &[f64]) -> Vec<f64> {
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    let mut sums = vec![0.0];
    for length in lengths {
        sums.push(sums[sums.len() - 1] + length.max(LEAST_INTERVAL * mean).max(f64::MIN_POSITIVE));
    }
    let whole = sums[sums.len() - 1];
    sums.iter().map(|s| (s / whole).min(1.0)).collect()
}

/// Edges joined end to end; none where they do not close.
fn loops(uses: &[(usize, bool)], edges: &[Edge]) -> Option<Vec<Vec<(usize, bool)>>> {
    let start = |&(edge, is_forward): &(usize, bool)| edges[edge].ends[usize::from(!is_forward)];
    let end = |&(edge, is_forward): &(usize, bool)| edges[edge].ends[usize::from(is_forward)];
    let (mut left, mut found) = (uses.to_vec(), Vec::new());
    while let Some(first) = left.pop() {
        let mut around = vec![first];
        let mut at = end(&first);
        while at != start(&first) {
            let next = left.iter().position(|used| start(used) == at)?;
            at = end(&left[next]);
            around.push(left.remove(next));
        }
        found.push(around);
    }
    Some(found)
}
