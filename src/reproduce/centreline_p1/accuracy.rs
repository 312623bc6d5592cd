//! Measured sections judged against the rebuilt walls, and what the paper measured on its machine: table 5, figures 9
//! and 10.

use std::fmt::Write;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::blade::{blade_camera, grid_mesh, to_next_blade};
use super::{Part, Place, cells, drawn, outcome, places, sections};
use crate::reproduce::{Outcome, ReproduceError, Table, Verdict};
use crate::widgets::theme::STEEL;
use crate::workspaces::mold::scene::pictures::MoldPicture;
use files::report::number;
use geometry::frame::Frame;
use render::colour::Theme;
use render::colour_map::ColourMap;
use render::mesh::RenderMesh;
use render::scene::{Object, ObjectId, Scene, SurfaceValues};
use task::Task;
use wheel::section_deviation::{P1_LIMIT_MM, SectionsDeviation};
use wheel::sections::MeasuredSection;

/// Hours of the fastest and of the slowest channel, of all 60, and their mean (text on figure 10).
const HOURS: [f64; 4] = [4.07, 4.25, 249.3, 4.16];
/// Heights of the measured sections: none of those that the walls were made from.
const HEIGHTS: [f64; 7] = [0.06, 0.2, 0.32, 0.44, 0.57, 0.7, 0.94];
/// Points of a measured section on each wall.
const MEASURED: usize = 58;
/// Deviation at the ends of the map's colours (mm).
const MAP_END_MM: f64 = 0.06;
const BY_HAND: &str = "sparkpath inspect p1_blisk.stl --sections p1_sections.csv, with the table and the mesh of this folder; \
     one of its sections has an error put in on purpose, so that the answer is no. A project with [blisk.sections], kind = \
     \"measured\" and this table is planned for, and its report has list, verdict and map; in the window: step Channel, Show \
     the deviations.";

/// An error put into measured sections.
struct Case {
    name: &'static str,
    error: fn(&Place) -> DVec3,
}

/// From -1 to 1, evenly spread over the points of all sections.
fn noise(place: &Place) -> f64 {
    let n = (place.section * 2 + place.wall) * MEASURED + place.index;
    2.0 * (n as f64 * 0.618_033_988_749_895).fract() - 1.0
}

/// What is put into the sections. Angles and lengths are chosen on both sides of the limit.
const CASES: [Case; 7] = [
    Case { name: "none", error: |_| DVec3::ZERO },
    Case { name: "all 0.020 mm too thick", error: |p| 0.02 * p.normal },
    Case { name: "all 0.040 mm too thick", error: |p| 0.04 * p.normal },
    Case { name: "noise within 0.020 mm", error: |p| 0.02 * noise(p) * p.normal },
    Case { name: "noise within 0.050 mm", error: |p| 0.05 * noise(p) * p.normal },
    Case {
        name: "blades turned by 0.03 deg about the axis",
        error: |p| DMat3::from_rotation_x(0.03_f64.to_radians()) * p.at - p.at,
    },
    Case {
        name: "section 5, high wall 0.045 mm too thin; noise within 0.005 mm",
        error: |p| {
            let off = if (p.section, p.wall) == (4, 1) { -0.045 } else { 0.0 };
            (off + 0.005 * noise(p)) * p.normal
        },
    },
];

pub(super) fn outcomes(part: &Part, frame: &Frame, task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let judged = CASES.iter().map(|case| Judged::new(part, case, task)).collect::<Result<Vec<_>, _>>()?;
    let right = judged.iter().filter(|j| j.is_right()).count();
    let last = judged.last();
    let why = format!(
        "The paper eroded a blisk, measured it, and tells that its blades are within {P1_LIMIT_MM} mm; we have eroded none. Ours \
         is the judgement itself: {right} of {} sets of sections with a known error are judged right.",
        judged.len()
    );
    let hours = [
        ("fastest channel", HOURS[0]),
        ("slowest channel", HOURS[1]),
        ("all channels", HOURS[2]),
        ("mean of a channel", HOURS[3]),
        ("mean, from all and 60 channels", HOURS[2] / super::CHANNELS as f64),
    ];
    let hours = hours.map(|(name, h)| vec![name.to_owned(), number(h, 3)]).to_vec();
    let mut tables = vec![summary(&judged)];
    tables.extend(last.map(|j| list(&j.found)));
    tables.push(Table::new("The paper's times; erosion is not simulated here", &["", "#hours"], hours));
    let map = last.map(|j| map(part, j));
    Ok(vec![
        outcome(
            "Table 5",
            "Discharge parameters of the experiment",
            Verdict::NotComparable,
            "Current, pulse and flushing are set on the machine and are no part of a feed path.",
            "None: the generator is set at the machine.",
        ),
        outcome(
            "Figure 9",
            "Machine and process of the experiment",
            Verdict::NotComparable,
            "Photographs of the paper's machine. The machines that are simulated here are listed in the manual.",
            "sparkpath simulate, with machine.name: the motion with the bodies of a machine.",
        ),
        Outcome {
            tables,
            pictures: drawn(map.into_iter().collect(), task)?,
            files: files(part, frame, last)?,
            ..outcome(
                "Figure 10",
                "Result of the experiment: times and accuracy of the blades",
                Verdict::NotComparable,
                why,
                BY_HAND,
            )
        },
    ])
}

struct Judged {
    name: &'static str,
    measured: Vec<MeasuredSection>,
    /// Greatest part of the errors along the walls' normals (mm).
    introduced: f64,
    /// Greatest difference between what was put in and what was found, of any point (mm).
    miss: f64,
    found: SectionsDeviation,
}

impl Judged {
    fn new(part: &Part, case: &Case, task: &Task) -> Result<Self, ReproduceError> {
        let measured = sections(&part.blisk, &HEIGHTS, MEASURED, &case.error);
        let found = SectionsDeviation::new(&measured, &part.walls, P1_LIMIT_MM, &task.cancel)?;
        let (mut introduced, mut miss) = (0.0f64, 0.0f64);
        for place in places(&part.blisk, &HEIGHTS, MEASURED) {
            let error = (case.error)(&place).dot(place.normal);
            introduced = if error.abs() > introduced.abs() { error } else { introduced };
            let found = found.sections[place.section].sides[place.wall].of_points[place.index];
            miss = found.map_or(miss, |found| miss.max((found - error).abs()));
        }
        Ok(Self { name: case.name, introduced, miss, measured, found })
    }

    fn is_right(&self) -> bool {
        self.found.holds() == (self.introduced.abs() <= self.found.limit_mm)
    }
}

fn summary(judged: &[Judged]) -> Table {
    let rows = judged.iter().map(|j| {
        let greatest = j.found.greatest().map_or(f64::NAN, |g| g.2);
        let word = |holds| if holds { "within" } else { "not within" }.to_owned();
        let figures = cells(&[j.introduced, greatest, j.miss], 4);
        let verdicts = vec![word(j.found.holds()), if j.is_right() { "yes" } else { "no" }.to_owned()];
        [vec![j.name.to_owned()], figures, verdicts].concat()
    });
    let head = [
        "error put into the sections",
        "#greatest of it along the normal (mm)",
        "#greatest deviation found (mm)",
        "#greatest miss of a point (mm)",
        "verdict",
        "right",
    ];
    let caption = format!("Measured sections with a known error, judged against {P1_LIMIT_MM} mm");
    Table::new(&caption, &head, rows.collect())
}

fn list(found: &SectionsDeviation) -> Table {
    let rows = found.sections.iter().flat_map(|section| {
        ["low", "high"].iter().zip(&section.sides).map(move |(wall, side)| {
            let figures = cells(&[side.greatest_mm.unwrap_or(f64::NAN), side.mean_mm, side.spread_mm], 4);
            let counts = vec![side.judged.to_string(), side.beyond.to_string()];
            [vec![section.name.clone(), (*wall).to_owned()], figures, counts].concat()
        })
    });
    let head =
        ["section", "wall", "#greatest (mm)", "#mean (mm)", "#spread (mm)", "#points judged", "#beyond the wall"];
    Table::new(&format!("List of the last set: {}", found.verdict()), &head, rows.collect())
}

/// The last set on the blade, each point in the colour of its deviation.
fn map(part: &Part, judged: &Judged) -> MoldPicture {
    let surface = |wall: usize| {
        let turn = if wall == 0 { to_next_blade(part) } else { DMat3::IDENTITY };
        let row = |s: &MeasuredSection| [&s.low, &s.high][wall].iter().map(|p| turn * *p).collect::<Vec<DVec3>>();
        let rows: Vec<Vec<DVec3>> = judged.measured.iter().map(row).collect();
        let of_points = judged.found.sections.iter().flat_map(|s| &s.sides[wall].of_points);
        let values: Vec<f32> = of_points.map(|d| d.map_or(f32::NAN, |d| d as f32)).collect();
        let range = [-MAP_END_MM as f32, MAP_END_MM as f32];
        let mesh = RenderMesh::for_pictures(&grid_mesh(&rows, wall == 1));
        Object {
            edges: false,
            values: Some(SurfaceValues { values: Arc::new(values), map: ColourMap::Diverging, range }),
            ..Object::new(ObjectId(wall as u32), Arc::new(mesh), STEEL)
        }
    };
    let scene = Scene { objects: vec![surface(0), surface(1)], ..Scene::new(Theme::LIGHT) };
    let shades = [-MAP_END_MM, 0.0, MAP_END_MM];
    MoldPicture {
        title: "Map of the deviations of the last set".to_owned(),
        caption: "The pressure side of the blade, which is the channel's high wall, hub below, X to the left as the axes in the \
                  corner show; negative, blue, where the blade is too thin. The section that is too thin by 0.045 mm is the band."
            .to_owned(),
        legend: shades.map(|d| (ColourMap::Diverging.at(0.5 + 0.5 * d / MAP_END_MM), format!("{} mm", number(d, 2)))).to_vec(),
        camera: blade_camera(&scene, DVec3::new(-0.3, 0.9, 0.3)),
        scene,
    }
}

/// The part, and the last set in the workpiece frame W of the channel that is found in it, for doing the same by hand.
fn files(part: &Part, frame: &Frame, last: Option<&Judged>) -> Result<Vec<(String, Vec<u8>)>, ReproduceError> {
    let mesh = import::stl_bytes(&part.mesh).map_err(|e| ReproduceError::Result {
        paper: super::PAPER,
        name: "Figure 10",
        problem: e.to_string(),
    })?;
    let mut files = vec![("p1_blisk.stl".to_owned(), mesh)];
    let mut csv = "section,side,x,y,z\n".to_owned();
    for section in last.iter().flat_map(|j| &j.measured) {
        for (side, points) in [("low", &section.low), ("high", &section.high)] {
            for p in points.iter().map(|p| frame.from_parent(*p)) {
                // Writing into a string does not fail.
                let _ = writeln!(csv, "{},{side},{:.6},{:.6},{:.6}", section.name, p.x, p.y, p.z);
            }
        }
    }
    files.push(("p1_sections.csv".to_owned(), csv.into_bytes()));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_with_a_known_error_is_judged_right() {
        let (task, limit) = (Task::default(), P1_LIMIT_MM);
        let part = Part::new(&task).unwrap();
        let judged: Vec<Judged> = CASES.iter().map(|case| Judged::new(&part, case, &task).unwrap()).collect();
        for set in &judged {
            // Blades that are turned move by 0.062 mm along their round edges of 0.3 mm, which depart from their tangents
            // by 0.0064 mm there.
            assert!(set.is_right() && set.miss < 8e-3, "{}: miss {}, {}", set.name, set.miss, set.found);
        }
        let within = judged.iter().filter(|set| set.introduced.abs() <= limit).count();
        assert!(within >= 3 && judged.len() - within >= 3, "sets on both sides of the limit");
        assert_eq!(judged[6].found.greatest().map(|(name, wall, _)| (name, wall)), Some(("5", 1)));
    }
}
