//! The surface of a cutter over the cells of a grid.

use crate::cutter::{Cutter, CutterKind};

/// Cells along the side of a patch.
pub(super) const PATCH: usize = 8;
/// Rounding of distances, as a share of a cell.
const SLACK: f64 = 1e-6;

/// A cutter's surface at the points of a grid, whose first point at or beyond its axis is number 0.
pub(super) struct Element {
    /// The part at the height of the tip: one stretch of columns per row, rows in order without a gap.
    pub chords: Vec<Chord>,
    /// The part above, the lowest patches first.
    pub patches: Vec<Patch>,
    /// The first and last of its rows.
    pub rows: [isize; 2],
    /// The first and last of its columns.
    pub columns: [isize; 2],
}

/// A stretch of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chord {
    pub row: isize,
    /// First and last column.
    pub columns: [isize; 2],
}

/// Points within a square.
pub(super) struct Patch {
    pub row: isize,
    pub column: isize,
    /// Height of the lowest (mm).
    pub least: f32,
    /// Row and column within the square, and height above the tip (mm).
    pub points: Vec<(u8, u8, f32)>,
}

impl Element {
    /// The surface of `cutter` on a grid of side `step` (mm) whose point 0 lies `offset` of a cell (rows, columns)
    /// beyond the axis.
    pub fn of(cutter: &Cutter, radius: f64, step: f64, offset: [f64; 2]) -> Self {
        let kind = cutter.kind();
        let level = (kind != CutterKind::Ball).then(|| cutter.radius() - cutter.corner_mm);
        let chords = level.map_or(Vec::new(), |level| disc(level.min(radius) / step, offset));
        let all = disc(radius / step, offset);
        let rows = [all.first().map_or(0, |c| c.row), all.last().map_or(0, |c| c.row)];
        let columns = [0, 1].map(|end| {
            let ends = all.iter().map(|c| c.columns[end]);
            if end == 0 { ends.min().unwrap_or(0) } else { ends.max().unwrap_or(0) }
        });
        let mut element = Self { chords, patches: Vec::new(), rows, columns };
        if kind != CutterKind::Flat {
            element.patches = element.patches_of(cutter, step, offset, &all);
        }
        element
    }
    /// The points within `all` that are not within the chords, with the height of the surface.
    fn patches_of(&self, cutter: &Cutter, step: f64, offset: [f64; 2], all: &[Chord]) -> Vec<Patch> {
        let origin = [self.rows[0], self.columns[0]];
        let down = (self.rows[1] - origin[0]) as usize / PATCH + 1;
        let across = (self.columns[1] - origin[1]) as usize / PATCH + 1;
        let mut found: Vec<Patch> = (0..down * across)
            .map(|i| Patch {
                row: origin[0] + (i / across * PATCH) as isize,
                column: origin[1] + (i % across * PATCH) as isize,
                least: f32::INFINITY,
                points: Vec::new(),
            })
            .collect();
        for chord in all {
            let flat = self.chords.iter().find(|c| c.row == chord.row).map_or([0, -1], |c| c.columns);
            for column in (chord.columns[0]..=chord.columns[1]).filter(|c| !(flat[0]..=flat[1]).contains(c)) {
                let off_axis = (chord.row as f64 + offset[0]).hypot(column as f64 + offset[1]) * step;
                let height = cutter.height(off_axis.min(cutter.radius())).unwrap_or(cutter.corner_mm) as f32;
                let (row, column) = ((chord.row - origin[0]) as usize, (column - origin[1]) as usize);
                let patch = &mut found[row / PATCH * across + column / PATCH];
                patch.points.push(((row % PATCH) as u8, (column % PATCH) as u8, height));
                patch.least = patch.least.min(height);
            }
        }
        found.retain(|patch| !patch.points.is_empty());
        // The sort is stable: among equals the order stays that of the rows.
        found.sort_by(|a, b| a.least.total_cmp(&b.least));
        found
    }
}

/// The points of a disc of `radius` (cells) around the axis.
fn disc(radius: f64, offset: [f64; 2]) -> Vec<Chord> {
    let within =
        |half: f64, offset: f64| [(-half - offset - SLACK).ceil() as isize, (half - offset + SLACK).floor() as isize];
    let [first, last] = within(radius, offset[0]);
    (first..=last)
        .map(|row| {
            let off = row as f64 + offset[0];
            Chord { row, columns: within((radius * radius - off * off).max(0.0).sqrt(), offset[1]) }
        })
        .filter(|chord| chord.columns[0] <= chord.columns[1])
        .collect()
}
