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
            let Some(Triangle { rows: [first, last], .. }) = triangle else { continue };
            bands[first / BAND..=last / BAND].iter_mut().for_each(|band| band.push(i as u32));
        }
        let columns = self.columns;
        let filled = self.heights.par_chunks_mut(BAND * columns).zip(self.upness.par_chunks_mut(BAND * columns));
        filled.zip(&bands).enumerate().try_for_each(|(number, ((heights, upness), band))| {
            for triangle in band.iter().filter_map(|&i| triangles[i as usize].as_ref()) {
                cancel.check()?;
                let first = number * BAND;
                for row in triangle.rows[0].max(first)..=triangle.rows[1].min(first + heights.len() / columns - 1) {
                    let cells = (row - first) * columns..(row - first + 1) * columns;
                    triangle.fill_row(row, &mut heights[cells.clone()], &mut upness[cells]);
                }
            }
            Ok(())
        })
    }
}

/// A triangle in units of cells, its first cell's centre at the origin; heights (mm) above the base.
struct Triangle {
    corners: [DVec2; 3],
    /// Rows of cells whose centres it may cover.
    rows: [usize; 2],
    /// Height where x and y are those of the first corner.
    height: f64,
    /// Rise per cell along x and y.
    slope: DVec2,
    /// Least and greatest height.
    span: [f64; 2],
    upness: u16,
}

impl Triangle {
    /// Raster of a triangle; none for vertical ones and those that cover no row of centres.
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
        (first <= last).then(|| Self {
            corners: plan,
            rows: [first as usize, last as usize],
            height: heights[0],
            slope: normal.truncate() * (-field.step / normal.z),
            span: extremes(heights),
            upness: (normal.z.abs() * UPNESS_ONE).round() as u16,
        })
    }

    /// Raises the cells of a row to this triangle.
    fn fill_row(&self, row: usize, heights: &mut [f32], upness: &mut [u16]) {
        let [from, to] = self.crossing(row as f64);
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

    /// Where the line along x at `y`, or the nearest that meets the triangle, enters and leaves it.
    fn crossing(&self, y: f64) -> [f64; 2] {
        let [low, high] = extremes(self.corners.map(|p| p.y));
        let y = y.clamp(low, high);
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for i in 0..3 {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % 3]);
            if !(a.y.min(b.y)..=a.y.max(b.y)).contains(&y) {
                continue;
            }
            let rise = b.y - a.y;
            let xs = if rise == 0.0 { [a.x, b.x] } else { [a.x + (y - a.y) / rise * (b.x - a.x); 2] };
            found = [found[0].min(xs[0]).min(xs[1]), found[1].max(xs[0]).max(xs[1])];
        }
        found
    }
}

fn extremes(values: [f64; 3]) -> [f64; 2] {
    [values[0].min(values[1]).min(values[2]), values[0].max(values[1]).max(values[2])]
}
