//! From triangles to heights.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{HeightField, HeightFieldError, UPNESS_ONE, check_size};
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use task::{Cancel, Cancelled};

/// Rows of cells that are filled together.
const BAND: usize = 32;
/// By how much of a cell a centre may lie outside a triangle and still be its own, so that none falls between two.
const EDGE_SLACK: f64 = 1e-7;
/// Steps by which what lies between two centres rises above both to be a wall: a ridge of gentle slopes is none.
const RISE: f64 = 1.0;
/// The z component of the unit normal below which a face is a vertical wall and has no height.
const VERTICAL: f64 = 1e-9;

impl HeightField {
    /// The heights of `mesh` on a grid of side `step` (mm), whose first cell begins at the least corner of its bounds.
    ///
    /// # Errors
    /// [`HeightFieldError::BadStep`], [`HeightFieldError::NoMaterial`], [`HeightFieldError::TooManyCells`],
    /// [`HeightFieldError::Cancelled`].
    pub fn raster(mesh: &Mesh, step: f64, cancel: &Cancel) -> Result<Self, HeightFieldError> {
        let bounds = mesh.bounds();
        let mut field = Self::over(&bounds, step)?;
        field.fill(mesh, cancel)?;
        if field.heights.par_iter().all(|h| !h.is_finite()) {
            return Err(HeightFieldError::NoMaterial);
        }
        field.open_through((bounds.min.z - field.base) as f32, cancel)?;
        Ok(field)
    }

    /// The heights of `mesh`, of which this is the field, on a finer grid of side `step` (mm) over a part of it, `plan`
    /// (mm). Openings through the material are where this field has them.
    ///
    /// # Errors
    /// [`HeightFieldError`], as of [`raster`](Self::raster).
    pub fn closer(&self, mesh: &Mesh, plan: [DVec2; 2], step: f64, cancel: &Cancel) -> Result<Self, HeightFieldError> {
        let bounds = mesh.bounds();
        let [low, high] = [plan[0].max(bounds.min.truncate()), plan[1].min(bounds.max.truncate())];
        let part = Bounds { min: low.extend(bounds.min.z), max: high.extend(bounds.max.z) };
        let mut field = Self::over(&part, step)?;
        field.fill(mesh, cancel)?;
        let underside = (bounds.min.z - field.base) as f32;
        let is_through = |cell: &usize| {
            let place = ((field.center(*cell) - self.corner) / self.step).floor().max(DVec2::ZERO);
            let [column, row] = [place.x as usize, place.y as usize];
            let own = row.min(self.rows - 1) * self.columns + column.min(self.columns - 1);
            !field.heights[*cell].is_finite() && self.through.binary_search(&(own as u32)).is_ok()
        };
        field.through = (0..field.heights.len()).filter(is_through).map(|cell| cell as u32).collect();
        field.open_below(underside);
        Ok(field)
    }

    /// A field without material over the plan of a box.
    fn over(bounds: &Bounds, step: f64) -> Result<Self, HeightFieldError> {
        if !(step.is_finite() && step > 0.0) {
            return Err(HeightFieldError::BadStep(step));
        }
        let size = bounds.size();
        if !(size.is_finite() && bounds.min.is_finite() && size.x > 0.0 && size.y > 0.0) {
            return Err(HeightFieldError::NoMaterial);
        }
        let [columns, rows] = [size.x, size.y].map(|length| (length / step - EDGE_SLACK).ceil().max(1.0));
        check_size(step, columns, rows)?;
        let (columns, rows) = (columns as usize, rows as usize);
        Ok(Self {
            corner: bounds.min.truncate(),
            step,
            columns,
            rows,
            base: 0.5 * (bounds.min.z + bounds.max.z),
            heights: vec![f32::NEG_INFINITY; columns * rows],
            upness: vec![0; columns * rows],
            through: Vec::new(),
        })
    }

    /// Gives the cells without material that others enclose the height of the underside: the block was whole there.
    fn open_through(&mut self, underside: f32, cancel: &Cancel) -> Result<(), Cancelled> {
        let (columns, rows) = (self.columns, self.rows);
        let mut is_outside = vec![false; self.heights.len()];
        let borders = (0..columns).flat_map(|i| [i, (rows - 1) * columns + i]);
        let mut reached: Vec<usize> =
            borders.chain((0..rows).flat_map(|j| [j * columns, (j + 1) * columns - 1])).collect();
        while let Some(cell) = reached.pop() {
            if is_outside[cell] || self.heights[cell].is_finite() {
                continue;
            }
            is_outside[cell] = true;
            let column = cell % columns;
            reached.extend((column > 0).then(|| cell - 1));
            reached.extend((column + 1 < columns).then_some(cell + 1));
            reached.extend(cell.checked_sub(columns));
            reached.extend(Some(cell + columns).filter(|below| *below < is_outside.len()));
        }
        cancel.check()?;
        let is_through = |cell: &usize| !is_outside[*cell] && !self.heights[*cell].is_finite();
        self.through = (0..self.heights.len()).filter(is_through).map(|cell| cell as u32).collect();
        self.open_below(underside);
        Ok(())
    }

    /// Gives the cells of openings through the material the height of the underside.
    fn open_below(&mut self, underside: f32) {
        for cell in self.through.iter().map(|cell| *cell as usize) {
            (self.heights[cell], self.upness[cell]) = (underside, u16::MAX);
        }
    }

    fn fill(&mut self, mesh: &Mesh, cancel: &Cancel) -> Result<(), HeightFieldError> {
        let triangles: Vec<Option<Triangle>> =
            (0..mesh.triangles.len()).into_par_iter().map(|i| Triangle::new(mesh.corners(i), self)).collect();
        let mut bands: Vec<Vec<u32>> = vec![Vec::new(); self.rows.div_ceil(BAND)];
        for (i, triangle) in triangles.iter().enumerate() {
            let Some(Triangle { rows: Some([first, last]), .. }) = triangle else { continue };
            bands[first / BAND..=last / BAND].iter_mut().for_each(|band| band.push(i as u32));
        }
        let columns = self.columns;
        let filled = self.heights.par_chunks_mut(BAND * columns).zip(self.upness.par_chunks_mut(BAND * columns));
        filled.zip(&bands).enumerate().try_for_each(|(number, ((heights, upness), band))| {
            for triangle in band.iter().filter_map(|&i| triangles[i as usize].as_ref()) {
                cancel.check()?;
                let (first, [from, to]) = (number * BAND, triangle.rows.unwrap_or_default());
                for row in from.max(first)..=to.min(first + heights.len() / columns - 1) {
                    let cells = (row - first) * columns..(row - first + 1) * columns;
                    triangle.fill_row(row, &mut heights[cells.clone()], &mut upness[cells]);
                }
            }
            Ok::<(), HeightFieldError>(())
        })?;
        self.keep_thin_walls(&triangles, cancel)
    }

    /// Raises the cells over walls so thin that they lie between two centres, along X or along Y: cutters do not pass
    /// through them.
    fn keep_thin_walls(&mut self, triangles: &[Option<Triangle>], cancel: &Cancel) -> Result<(), HeightFieldError> {
        let (columns, rows) = (self.columns, self.rows);
        let cell = |along: Along, line: usize, at: usize| match along {
            Along::X => line * columns + at,
            Along::Y => at * columns + line,
        };
        let heights = &self.heights;
        let walls = |triangle: &Triangle| {
            let of = |along: Along| {
                let counts = match along {
                    Along::X => [rows, columns],
                    Along::Y => [columns, rows],
                };
                let rise = (RISE * self.step) as f32;
                triangle.between_centres(along, counts[0]).filter_map(move |(line, [from, to])| {
                    let before = from.floor();
                    let beside = [before, before + 1.0].map(|at| {
                        let is_on = (0.0..counts[1] as f64).contains(&at);
                        is_on.then(|| cell(along, line, at as usize))
                    });
                    let height = triangle.highest(along, line, [from, to]) as f32;
                    let is_wall = beside.iter().flatten().all(|cell| height > heights[*cell] + rise);
                    let nearer = usize::from(0.5 * (from + to) - before > 0.5);
                    Some((beside[nearer]?, height, triangle.upness)).filter(|_| is_wall)
                })
            };
            of(Along::X).chain(of(Along::Y)).collect::<Vec<_>>()
        };
        let found = triangles.par_iter().flatten().flat_map_iter(walls).collect::<Vec<_>>();
        cancel.check()?;
        for (cell, height, upness) in found {
            if height > self.heights[cell] {
                (self.heights[cell], self.upness[cell]) = (height, upness);
            }
        }
        Ok(())
    }
}

/// Direction of a line through centres of cells.
#[derive(Debug, Clone, Copy)]
enum Along {
    X,
    Y,
}

impl Along {
    /// A point's place along the line, and which line it is on.
    fn of(self, p: DVec2) -> [f64; 2] {
        match self {
            Self::X => [p.x, p.y],
            Self::Y => [p.y, p.x],
        }
    }
}

/// A triangle in units of cells, its first cell's centre at the origin; heights (mm) above the base.
struct Triangle {
    corners: [DVec2; 3],
    /// Rows of cells whose centres it may cover; none if it lies between two.
    rows: Option<[usize; 2]>,
    /// Height where x and y are those of the first corner.
    height: f64,
    /// Rise per cell along x and y.
    slope: DVec2,
    /// Least and greatest height.
    span: [f64; 2],
    upness: u16,
}

impl Triangle {
    /// Raster of a triangle; none for vertical ones.
    fn new(corners: [DVec3; 3], field: &HeightField) -> Option<Self> {
        let normal = normal_times_two_areas(corners).normalize_or_zero();
        if normal.z.abs() < VERTICAL {
            return None;
        }
        let plan = corners.map(|p| (p.truncate() - field.corner) / field.step - 0.5);
        let heights = corners.map(|p| p.z - field.base);
        let [low, high] = extremes(plan.map(|p| p.y));
        let (first, last) =
            ((low - EDGE_SLACK).ceil().max(0.0), (high + EDGE_SLACK).floor().min(field.rows as f64 - 1.0));
        Some(Self {
            corners: plan,
            rows: (first <= last).then_some([first as usize, last as usize]),
            height: heights[0],
            slope: normal.truncate() * (-field.step / normal.z),
            span: extremes(heights),
            upness: (normal.z.abs() * UPNESS_ONE).round() as u16,
        })
    }

    /// Raises the cells of a row to this triangle.
    fn fill_row(&self, row: usize, heights: &mut [f32], upness: &mut [u16]) {
        let [from, to] = self.crossing(Along::X, row as f64);
        let (first, last) = ((from - EDGE_SLACK).ceil().max(0.0), (to + EDGE_SLACK).floor());
        if first > last {
            return;
        }
        let at_row = self.height + (row as f64 - self.corners[0].y) * self.slope.y;
        for column in first as usize..heights.len().min(last as usize + 1) {
            let height = at_row + (column as f64 - self.corners[0].x) * self.slope.x;
            // A steep triangle's plane runs far off within rounding of its edge.
            let height = height.clamp(self.span[0], self.span[1]) as f32;
            if height > heights[column] {
                heights[column] = height;
                upness[column] = self.upness;
            }
        }
    }

    /// The lines of so many that cross the triangle between two centres, with where they do.
    fn between_centres(&self, along: Along, lines: usize) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let [low, high] = extremes(self.corners.map(|p| along.of(p)[1]));
        let (first, last) = (low.ceil().max(0.0), high.floor().min(lines as f64 - 1.0));
        let lines = if first <= last { first as usize..last as usize + 1 } else { 0..0 };
        let crossings = lines.map(move |line| (line, self.crossing(along, line as f64)));
        crossings.filter(|(_, [from, to])| from <= to && from.floor() < *from && to.floor() == from.floor())
    }

    /// Greatest height on a part of a line.
    fn highest(&self, along: Along, line: usize, ends: [f64; 2]) -> f64 {
        let height = |at: f64| {
            let off = DVec2::from(along.of(DVec2::new(at, line as f64))) - self.corners[0];
            (self.height + off.dot(self.slope)).clamp(self.span[0], self.span[1])
        };
        height(ends[0]).max(height(ends[1]))
    }

    /// Where a line, or the nearest to it that meets the triangle, enters and leaves it.
    fn crossing(&self, along: Along, line: f64) -> [f64; 2] {
        let corners = self.corners.map(|p| along.of(p));
        let [low, high] = extremes(corners.map(|[_, line]| line));
        let line = line.clamp(low, high);
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for i in 0..3 {
            let ([a, on_a], [b, on_b]) = (corners[i], corners[(i + 1) % 3]);
            if !(on_a.min(on_b)..=on_a.max(on_b)).contains(&line) {
                continue;
            }
            let rise = on_b - on_a;
            let ats = if rise == 0.0 { [a, b] } else { [a + (line - on_a) / rise * (b - a); 2] };
            found = [found[0].min(ats[0]).min(ats[1]), found[1].max(ats[0]).max(ats[1])];
        }
        found
    }
}

fn extremes(values: [f64; 3]) -> [f64; 2] {
    [values[0].min(values[1]).min(values[2]), values[0].max(values[1]).max(values[2])]
}
