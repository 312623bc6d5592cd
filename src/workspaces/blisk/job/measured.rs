//! The measured sections of a blisk that is made from them, against the walls of the channel that is planned for.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::workspaces::blisk::scene::shapes::wall_mesh;
use feed::residual_stock::DeviationMap;
use geometry::frame::{Cylindrical, Frame};
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};
use wheel::channel::{Channel, Surface};
use wheel::nurbs_wall::{MeasuredError, NurbsWall};
use wheel::section_deviation::SectionsDeviation;
use wheel::sections::MeasuredSection;

/// Measured sections and what their points are off.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredWalls {
    /// The sections in W, at the channel that is planned for.
    pub sections: Vec<MeasuredSection>,
    /// The sections against the walls of the channel that is planned for.
    pub planned: SectionsDeviation,
    /// Each inner section against walls through the others; without one where there are fewer than four.
    pub others: SectionsDeviation,
    /// Deviation at the points of the walls' grids, positive into the channel: of inner sections from walls through the others,
    /// and else from the walls that are planned for.
    pub map: DeviationMap,
}

impl MeasuredWalls {
    /// Least number of sections of which each is compared with the others: through fewer a wall is hardly known.
    const LEAST_OTHERS: usize = 4;

    /// `sections` in the coordinates of the mesh that `channel` was found in, of whichever of its channels, judged against
    /// `limit` (mm); none where there are none, or no surfaces through the walls.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(
        sections: &[MeasuredSection],
        channel: &Channel,
        limit: f64,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Cancelled> {
        if sections.is_empty() {
            return Ok(None);
        }
        let sections = at_channel(sections, &channel.frame, channel.blades);
        let Ok(walls) = NurbsWall::of_channel(channel) else { return Ok(None) };
        let planned = SectionsDeviation::new(&sections, &walls, limit, cancel)?;
        let compared = if sections.len() < Self::LEAST_OTHERS { &[] } else { &sections[..] };
        let others = match SectionsDeviation::of_each(compared, limit, cancel) {
            Err(MeasuredError::Cancelled(cancelled)) => return Err(cancelled),
            // What cannot be joined is no wall either, and was refused before.
            found => found.unwrap_or(SectionsDeviation { limit_mm: limit, sections: Vec::new() }),
        };
        let map = map(channel, &walls, [&planned, &others]);
        Ok(Some(Self { sections, planned, others, map }))
    }

    /// The verdicts in sentences.
    pub fn sentence(&self) -> String {
        let planned =
            format!("The measured points against the walls that are planned for: {}.", self.planned.verdict());
        match self.others.sections.is_empty() {
            true => planned,
            false => format!("{planned} Each section against the wall through the others: {}.", self.others.verdict()),
        }
    }

    /// Whether both verdicts are good.
    pub fn holds(&self) -> bool {
        self.planned.holds() && (self.others.sections.is_empty() || self.others.holds())
    }

    /// Every measured point with its deviations, as a table.
    pub fn csv(&self) -> String {
        let mut csv = "section,wall,point,x_mm,y_mm,z_mm,deviation_mm,from_others_mm\n".to_owned();
        let cell = |value: Option<f64>| value.map_or(String::new(), |d| format!("{d:.5}"));
        for (section, planned) in self.sections.iter().zip(&self.planned.sections) {
            let others = self.others.sections.iter().find(|other| other.name == section.name);
            for (wall, points) in [&section.low, &section.high].into_iter().enumerate() {
                for (i, p) in points.iter().enumerate() {
                    let of = |side: &wheel::section_deviation::SectionDeviation| {
                        side.sides[wall].of_points.get(i).copied().flatten()
                    };
                    // Writing into a string does not fail.
                    let _ = writeln!(
                        csv,
                        "{},{},{},{:.5},{:.5},{:.5},{},{}",
                        section.name.replace(',', ";"),
                        ["low", "high"][wall],
                        i + 1,
                        p.x,
                        p.y,
                        p.z,
                        cell(of(planned)),
                        cell(others.and_then(of))
                    );
                }
            }
        }
        csv
    }
}

/// `sections` of a wheel of so many `blades` in its frame W, turned about the axis by as many pitches as bring them to the
/// channel that W has on +Z.
pub fn at_channel(sections: &[MeasuredSection], frame: &Frame, blades: usize) -> Vec<MeasuredSection> {
    let in_w = |p: &DVec3| frame.from_parent(*p);
    let all = sections.iter().flat_map(|s| s.low.iter().chain(&s.high)).map(in_w);
    // The walls of a channel stand on both sides of its middle.
    let middle = Cylindrical::from_point(all.map(|p| p.with_x(0.0).normalize_or_zero()).sum()).theta;
    let pitch = TAU / blades as f64;
    let turn = DMat3::from_rotation_x(-(middle / pitch).round() * pitch);
    let moved = |points: &[DVec3]| points.iter().map(|p| turn * in_w(p)).collect();
    let section = |s: &MeasuredSection| MeasuredSection {
        name: s.name.clone(),
        low: moved(&s.low),
        high: moved(&s.high),
        shapes: s.shapes.clone().map(|mut shape| {
            let turned = |direction: DVec3| turn * frame.direction_from_parent(direction);
            shape.ends = shape.ends.map(|end| end.map(turned));
            shape
        }),
    };
    sections.iter().map(section).collect()
}

/// The deviations over the grids of the walls of `channel`, those from the others where there are any.
fn map(channel: &Channel, walls: &[NurbsWall; 2], [planned, others]: [&SectionsDeviation; 2]) -> DeviationMap {
    let (mut mesh, mut surfaces, mut deviation) = (Mesh::default(), Vec::new(), Vec::new());
    let both = [(&channel.low, Surface::LowWall), (&channel.high, Surface::HighWall)];
    for (wall, (grid, surface)) in both.into_iter().enumerate() {
        let own = wall_mesh(grid, surface == Surface::LowWall);
        let before = mesh.vertices.len() as u32;
        surfaces.extend(own.triangles.iter().map(|_| surface));
        mesh.triangles.extend(own.triangles.iter().map(|t| t.map(|v| v + before)));
        mesh.vertices.extend(own.vertices);
        let values = planned.over_wall(others, wall, [&walls[wall].u, &walls[wall].v]);
        deviation.extend(values.into_iter().map(|d| d as f32));
    }
    DeviationMap { mesh: Arc::new(mesh), surfaces, deviation: Arc::new(deviation) }
}
