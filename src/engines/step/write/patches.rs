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
use super::{StepPart, StepWriteError};

/// Distance of the vertices of a flat patch from its plane at most (mm): coordinates may have single precision.
const FLAT: f64 = 1e-4;
/// Length of an interval of parameters against the mean at least.
const LEAST_INTERVAL: f64 = 1e-3;
/// Mean turn (rad) of the lines of a free form at a vertex from which on it has a crease there.
const CREASE: f64 = 0.5;

/// Sine of the angle between a free form and the planes beside it from which on it is drawn in along them.
const LEAST_SLOPE: f64 = 0.2;
/// How much farther than it reaches beyond the mesh a free form is drawn in: neighbours that are not hold it back.
const MORE: f64 = 1.3;

/// A side of a patch.
#[derive(Debug, Clone, Copy)]
struct Use {
    chain: usize,
    /// Whether the side runs along its chain.
    is_forward: bool,
}

/// A side that two patches share.
#[derive(Debug)]
struct Chain {
    vertices: Vec<u32>,
    /// The patches on its left and right, each with the number of its side.
    beside: Vec<(usize, usize)>,
}

/// A patch over welded vertices.
#[derive(Debug)]
struct Cell {
    grid: Patch,
    role: u16,
    /// Its plane, if it is flat.
    plane: Option<Surface>,
    uses: [Use; 4],
}

/// All patches of a part.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    /// Vertices (mm).
    points: Vec<DVec3>,
    /// The same where the mesh has them, and by how much each is drawn in (mm).
    of_mesh: Vec<DVec3>,
    drawn_in: Vec<f64>,
    cells: Vec<Cell>,
    chains: Vec<Chain>,
    /// The strip of each chain, and whether it runs along it.
    strip_of: Vec<(usize, bool)>,
    strips: usize,
}

/// What a strip's lines have in common.
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
        let lays: Vec<Lay> = (0..self.strips).into_par_iter().map(|strip| self.lay(strip, tolerance)).collect();
        task.check()?;
        let curves: Result<Vec<EdgeCurve>, _> =
            (0..self.chains.len()).into_par_iter().map(|k| self.curve(k, &lays, tolerance)).collect();
        let surfaces: Result<Vec<FaceSurface>, _> =
            (0..self.cells.len()).into_par_iter().map(|k| self.surface(k, &lays)).collect();
        Ok(self.assembled(curves?, surfaces?))
    }

    /// The patches of a part over welded vertices, cut along creases.
    pub(super) fn of(part: &StepPart) -> Result<Self, StepWriteError> {
        let mut weld = Weld::with_capacity(part.mesh.vertices.len());
        let number: Vec<u32> = part.mesh.vertices.iter().map(|&p| weld.add(p)).collect();
        let patches = part.patches.iter().map(|patch| {
            let vertices = patch.grid.vertices.iter().map(|&v| number[v as usize]).collect();
            (Patch { columns: patch.grid.columns, vertices }, patch.role)
        });
        let whole = Self::with(weld.into_points(), patches)?;
        let creases = whole.creases();
        let cut = whole.cells.iter().flat_map(|cell| {
            let [rows, columns] = [0, 1].map(|k| whole.stretches(cell.uses[k], &creases));
            let within = move |rows: [usize; 2]| columns.clone().into_iter().map(move |columns| (rows, columns));
            rows.into_iter().flat_map(within).map(|(rows, columns)| (part_of(&cell.grid, rows, columns), cell.role))
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
            return Err(StepWriteError::Divide { at: sheet.points[chain.vertices[0] as usize] });
        }
        sheet.find_strips()?;
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

    /// Draws vertices in around places that are outside of the mesh by their distances (mm).
    pub(super) fn draw_in(&mut self, beyond: &[(f64, DVec3)]) -> Result<(), StepWriteError> {
        let free = self.cells.iter().filter(|cell| cell.plane.is_none());
        let triangles = free.flat_map(|cell| quads_of(&cell.grid)).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let mesh = Mesh { vertices: self.of_mesh.clone(), triangles: triangles.collect() };
        let exact = ExactMesh::new(&mesh).map_err(|_| StepWriteError::Unusable)?;
        let mut more = vec![0.0f64; self.points.len()];
        let near: Vec<usize> = beyond.par_iter().map(|&(_, p)| exact.nearest(p).triangle as usize).collect();
        for (&(distance, _), triangle) in beyond.iter().zip(near) {
            for v in mesh.triangles[triangle] {
                more[v as usize] = more[v as usize].max(MORE * distance);
            }
        }
        self.drawn_in.iter_mut().zip(more).for_each(|(all, more)| *all += more);
        self.place();
        Ok(())
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
            let steep = along.filter(|n| n.length() > LEAST_SLOPE);
            let step = least_step(steep.map(|n| (self.drawn_in[v as usize], n)));
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
                            return Err(StepWriteError::Divide { at });
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
    fn lay(&self, strip: usize, tolerance: f64) -> Lay {
        let lines = self.lines(strip).concat();
        let mut sums = vec![0.0; lines[0].len() - 1];
        for line in &lines {
            let chords: Vec<f64> = line.windows(2).map(|w| w[0].distance(w[1])).collect();
            let length = chords.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            sums.iter_mut().zip(chords).for_each(|(sum, chord)| *sum += chord / length);
        }
        let parameters = cumulated(&sums);
        let knots = fitted_within(&lines, &parameters, tolerance);
        Lay { parameters, knots }
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

    fn surface(&self, cell: usize, lays: &[Lay]) -> Result<FaceSurface, StepWriteError> {
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
        let mut of_columns = Vec::with_capacity(grid.columns);
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

    fn assembled(&self, curves: Vec<EdgeCurve>, surfaces: Vec<FaceSurface>) -> Brep {
        let mut brep = Brep { edge_gap: curves.iter().map(|c| c.gap).fold(0.0, f64::max), ..Default::default() };
        let faces = self.faces();
        // Chains inside of a face are no edges.
        let face_of = |cell: usize| faces.iter().position(|cells| cells.contains(&cell));
        let (mut number, mut edge_of) = (HashMap::new(), vec![None; self.chains.len()]);
        for (k, (chain, curve)) in self.chains.iter().zip(curves).enumerate() {
            let [left, right] = [0, 1].map(|n| face_of(chain.beside[n].0));
            if left == right && left.is_some() {
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
        for cells in &faces {
            let first = &self.cells[cells[0]];
            let largest =
                cells.iter().copied().max_by(|a, b| self.area(*a).length().total_cmp(&self.area(*b).length()));
            let surface = surfaces[largest.unwrap_or(cells[0])].clone();
            let uses = cells.iter().flat_map(|&cell| self.cells[cell].uses);
            let uses: Vec<(usize, bool)> =
                uses.filter_map(|used| Some((edge_of[used.chain]?, used.is_forward))).collect();
            let mut loops = loops(&uses, &brep.edges);
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
        brep
    }

    /// The area of a patch as a vector (mm^2).
    fn area(&self, cell: usize) -> DVec3 {
        area(&self.cells[cell].grid, &self.points)
    }

    /// The patches of every face: one, or flat ones of one role side by side in one plane.
    fn faces(&self) -> Vec<Vec<usize>> {
        let mut groups = Groups::of(self.cells.len());
        for chain in &self.chains {
            let [(a, _), (b, _)] = [chain.beside[0], chain.beside[1]];
            let [here, there] = [a, b].map(|k| &self.cells[k]);
            let (Some(Surface::Plane(axes)), Some(plane @ Surface::Plane(other))) = (&here.plane, &there.plane) else {
                continue;
            };
            // Where a patch is folded onto itself its normal may point inwards.
            let is_same = axes.z.dot(other.z).abs() > 1.0 - 1e-9 && plane.gap(axes.origin) < FLAT;
            if is_same && here.role == there.role {
                groups.join(a, b);
            }
        }
        let (numbers, count) = groups.numbers();
        let mut faces = vec![Vec::new(); count];
        numbers.into_iter().enumerate().for_each(|(cell, face)| faces[face as usize].push(cell));
        faces
    }
}

/// The plane of a patch, if it is flat.
fn plane(grid: &Patch, points: &[DVec3]) -> Option<Surface> {
    let at = |v: &u32| points[*v as usize];
    let normal = area(grid, points).try_normalize()?;
    let count = grid.vertices.len() as f64;
    let origin = grid.vertices.iter().map(at).sum::<DVec3>() / count;
    let is_flat = grid.vertices.iter().all(|v| (at(v) - origin).dot(normal).abs() <= FLAT);
    is_flat.then(|| Surface::Plane(Axes::along(origin, normal)))
}

/// The quads of a patch, counter-clockwise seen from outside.
fn quads_of(grid: &Patch) -> impl Iterator<Item = [u32; 4]> {
    let rows = 0..grid.rows() - 1;
    rows.flat_map(move |i| {
        (0..grid.columns - 1).map(move |j| [grid.at(i, j), grid.at(i + 1, j), grid.at(i + 1, j + 1), grid.at(i, j + 1)])
    })
}

/// The points of a patch line by line: along the rows' numbers in each column (0), or along the columns' in each row (1).
fn lines_of(grid: &Patch, direction: usize, points: &[DVec3]) -> Vec<Vec<DVec3>> {
    let at = |i: usize, j: usize| points[grid.at(i, j) as usize];
    let (rows, columns) = (grid.rows(), grid.columns);
    if direction == 0 {
        (0..columns).map(|j| (0..rows).map(|i| at(i, j)).collect()).collect()
    } else {
        (0..rows).map(|i| (0..columns).map(|j| at(i, j)).collect()).collect()
    }
}

/// The part of a patch from the first to the last of these rows and columns.
fn part_of(grid: &Patch, rows: [usize; 2], columns: [usize; 2]) -> Patch {
    let row = |i: usize| (columns[0]..=columns[1]).map(move |j| grid.at(i, j));
    Patch { columns: columns[1] - columns[0] + 1, vertices: (rows[0]..=rows[1]).flat_map(row).collect() }
}

/// The area of a patch as a vector along its mean normal (mm^2).
fn area(grid: &Patch, points: &[DVec3]) -> DVec3 {
    let quads = quads_of(grid).map(|corners| corners.map(|v| points[v as usize]));
    0.5 * quads.map(|[a, b, c, d]| (c - a).cross(d - b)).sum::<DVec3>()
}

/// The vertices of a patch, rising, with the unit normals of the patch there.
fn normals(grid: &Patch, points: &[DVec3]) -> Vec<(u32, DVec3)> {
    let mut sums: BTreeMap<u32, DVec3> = BTreeMap::new();
    for corners in quads_of(grid) {
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

/// Edges joined end to end.
fn loops(uses: &[(usize, bool)], edges: &[Edge]) -> Vec<Vec<(usize, bool)>> {
    let start = |&(edge, is_forward): &(usize, bool)| edges[edge].ends[usize::from(!is_forward)];
    let end = |&(edge, is_forward): &(usize, bool)| edges[edge].ends[usize::from(is_forward)];
    let mut left = uses.to_vec();
    let mut found = Vec::new();
    while !left.is_empty() {
        let mut around = vec![left.remove(0)];
        while let Some(next) = left.iter().position(|used| start(used) == end(&around[around.len() - 1])) {
            around.push(left.remove(next));
        }
        found.push(around);
    }
    found
}
