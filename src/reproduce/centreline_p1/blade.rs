//! The section of a blade by its parameters, and the blade rebuilt as NURBS: tables 1 to 3, figures 3 and 4.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::{NO_CELLS, POINTS, Part, SECTIONS, cells, drawn, outcome, sections};
use crate::reproduce::{Outcome, ReproduceError, Table, Verdict};
use crate::widgets::camera::PICTURE_SIZE;
use crate::widgets::theme::STEEL;
use crate::workspaces::mold::scene::pictures::MoldPicture;
use files::report::plot::{Plot, Series};
use files::report::small;
use geometry::mesh::Mesh;
use geometry::nurbs::FitError;
use rayon::prelude::*;
use render::camera::Camera;
use render::colour::Theme;
use render::mesh::RenderMesh;
use render::scene::{LineSet, Object, ObjectId, Scene};
use render::view::looking;
use task::Task;
use wheel::profile::{BladeProfile, Quintic, SectionCircle};

const BY_HAND: &str = "A project with [blisk.sections] is planned for blades of a profile (kind = \"profile\") or through \
                       measured sections (kind = \"measured\", file = \"p1_sections.csv\"); in the window: step Part, \
                       Blades, Blisk from. sparkpath inspect p1_blisk.stl --sections p1_sections.csv compares a mesh.";

pub(super) fn outcomes(part: &Part, task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let profile = part.blisk.profile(part.mean_radius());
    let conditions = conditions(&profile);
    let mut all = vec![
        Outcome {
            tables: vec![parameters()],
            ..outcome("Table 1", "Parameters that a section is solved from", Verdict::NotComparable, NO_CELLS, BY_HAND)
        },
        Outcome {
            tables: vec![conditions],
            ..outcome(
                "Table 2",
                "Conditions at the four tangent points, put into the polynomials",
                Verdict::NotComparable,
                NO_CELLS,
                BY_HAND,
            )
        },
        Outcome {
            tables: values(part, &profile),
            ..outcome("Table 3", "Initial values, and the coefficients", Verdict::NotComparable, NO_CELLS, BY_HAND)
        },
        Outcome {
            plots: vec![section_plot(&profile)],
            ..outcome(
                "Figure 3",
                "Section of a blade by its parameters",
                Verdict::Same,
                "The same construction: two circles and two polynomials of fifth order that meet position, slope and second \
                 derivative at the four tangent points (table 2 shows by how much they miss them). The paper's own values are \
                 not stated in its text.",
                BY_HAND,
            )
        },
    ];
    all.push(figure_4(part, task)?);
    Ok(all)
}

fn parameters() -> Table {
    let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
    let rows = vec![
        row(["chord", "chord_mm", "axial distance between the tips of the edges"]),
        row(["inlet and outlet angle", "beta_in_deg, beta_out_deg", "of the camber line, from the axis"]),
        row(["wedge angles", "wedge_in_deg, wedge_out_deg", "between the sides at the edges"]),
        row(["edge circles", "leading_radius_mm, trailing_radius_mm", "radii; their centres lie on the camber line"]),
        row(["thickness", "max_thickness_mm", "at mid-chord; gives the second derivatives at the tangent points"]),
    ];
    Table::new("Parameters of a section", &["parameter", "name here", "meaning"], rows)
}

/// The two sides with their names: the pressure side (P1's y_s, coefficients a) is the lower one of a blade that turns the
/// flow to smaller angles.
fn sides(profile: &BladeProfile) -> [(&'static str, &Quintic, f64); 2] {
    [("pressure side", &profile.lower, -1.0), ("suction side", &profile.upper, 1.0)]
}

fn edges(profile: &BladeProfile) -> [(&'static str, &SectionCircle); 2] {
    [("leading", &profile.leading), ("trailing", &profile.trailing)]
}

fn conditions(profile: &BladeProfile) -> Table {
    let rows = sides(profile).into_iter().flat_map(|(name, side, _)| {
        let ends = [side.start, side.end].into_iter().zip(edges(profile));
        ends.map(move |(x, (edge, circle))| {
            let [y, slope, second] = side.at(x);
            let spoke = DVec2::new(x, y) - circle.center;
            let off_circle = (spoke.length() - circle.radius).abs();
            let off_square = spoke.dot(DVec2::new(1.0, slope).normalize()).abs();
            let numbers = cells(&[x, y, slope, second], 5);
            let misses = [off_circle, off_square].map(small).to_vec();
            [vec![format!("{name}, {edge} edge")], numbers, misses].concat()
        })
    });
    let head =
        ["tangent point", "#x (mm)", "#y (mm)", "#y'", "#y'' (1/mm)", "#off the circle (mm)", "#off its tangent (mm)"];
    Table::new("Position, slope and second derivative of the solved polynomials", &head, rows.collect())
}

fn values(part: &Part, profile: &BladeProfile) -> Vec<Table> {
    let blisk = &part.blisk;
    let value =
        |name: &str, unit: &str, value: f64| vec![name.to_owned(), cells(&[value], 3).concat(), unit.to_owned()];
    let initial = vec![
        value("chord_mm", "mm", blisk.chord_mm),
        value("beta_in_deg", "deg", blisk.beta_in_deg),
        value("beta_out_deg", "deg", blisk.beta_out_deg),
        value("wedge_in_deg", "deg", blisk.wedge_in_deg),
        value("wedge_out_deg", "deg", blisk.wedge_out_deg),
        value("leading_radius_mm", "mm", blisk.leading_radius_mm),
        value("trailing_radius_mm", "mm", blisk.trailing_radius_mm),
        value("max_thickness_mm", "mm", blisk.max_thickness_mm),
    ];
    let coefficients = sides(profile).into_iter().map(|(name, side, _)| {
        let letter = if name.starts_with('p') { "a" } else { "b" };
        let numbers = side.in_powers_of_x().map(small).to_vec();
        [vec![format!("{name}, {letter}0 to {letter}5")], numbers].concat()
    });
    vec![
        Table::new("Initial values", &["name here", "#value", "unit"], initial),
        Table::new(
            "Coefficients of the powers of x (mm) at mid-height, equations 3 to 5",
            &["side", "#0", "#1", "#2", "#3", "#4", "#5"],
            coefficients.collect(),
        ),
    ]
}

/// A circle as a closed line.
pub(super) fn circle_line(circle: &SectionCircle) -> Vec<[f64; 2]> {
    let point = |i: usize| circle.center + circle.radius * DVec2::from_angle(i as f64 * std::f64::consts::TAU / 72.0);
    (0..=72).map(|i| point(i).to_array()).collect()
}

/// Upper and lower side of a section from edge to edge.
pub(super) fn outline(profile: &BladeProfile, chord: f64) -> Vec<[f64; 2]> {
    // Closer together at the round edges.
    let x = |i: usize| 0.5 * chord * (1.0 - (std::f64::consts::PI * i as f64 / 160.0).cos());
    let upper = (0..=160).map(|i| [x(i), profile.upper_y(x(i))]);
    upper.chain((0..=160).rev().map(|i| [x(i), profile.lower_y(x(i))])).collect()
}

fn section_plot(profile: &BladeProfile) -> String {
    let line = |side: &Quintic| {
        let x = |i: usize| side.start + (side.end - side.start) * i as f64 / 120.0;
        (0..=120).map(|i| [x(i), side.value(x(i))]).collect()
    };
    let mut series: Vec<Series> =
        edges(profile).map(|(_, c)| Series { points: circle_line(c), class: "faint", dots: false }).into();
    let classes = ["c0", "c1"];
    series.extend(sides(profile).iter().zip(classes).map(|((_, s, _), class)| Series {
        points: line(s),
        class,
        dots: false,
    }));
    let ends = sides(profile).map(|(_, side, _)| [side.start, side.end].map(|x| [x, side.value(x)]));
    series.push(Series { points: ends.concat(), class: "n", dots: true });
    let plot = Plot {
        title: "Section at mid-height: pressure side blue, suction side brown, edge circles grey (y over x, mm)"
            .to_owned(),
        x_label: "x (mm)".to_owned(),
        size: [760.0, 0.0],
        series,
        ..Plot::default()
    };
    plot.with_equal_scales().svg()
}

/// Rows of points as triangles that are seen from the side that the product of row and column directions points to.
pub(super) fn grid_mesh(rows: &[Vec<DVec3>], turned: bool) -> Mesh {
    let count = rows.first().map_or(0, Vec::len);
    let index = |k: usize, i: usize| (k * count + i) as u32;
    let cells = (1..rows.len()).flat_map(|k| (1..count).map(move |i| (k, i)));
    let quads = cells.map(|(k, i)| [index(k - 1, i - 1), index(k - 1, i), index(k, i), index(k, i - 1)]);
    let triangles = quads.flat_map(|[a, b, c, d]| if turned { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
    Mesh { triangles: triangles.collect(), vertices: rows.concat() }
}

/// The turn that takes the low wall of a channel to the blade whose other side is the channel's high wall.
pub(super) fn to_next_blade(part: &Part) -> DMat3 {
    DMat3::from_rotation_x(part.blisk.pitch())
}

/// A camera on a blade, from the leading edge and outside.
pub(super) fn blade_camera(scene: &Scene, towards: DVec3) -> Camera {
    let mut camera = Camera { orientation: looking(towards, DVec3::Z), ..Camera::default() };
    camera.fit(&scene.bounds(), f64::from(PICTURE_SIZE[0]) / f64::from(PICTURE_SIZE[1]));
    camera
}

fn figure_4(part: &Part, task: &Task) -> Result<Outcome, ReproduceError> {
    // Between the points and the sections that the walls were made from.
    let heights: Vec<f64> = (0..SECTIONS - 1).map(|k| (k as f64 + 0.5) / (SECTIONS - 1) as f64).collect();
    let between = sections(&part.blisk, &heights, 2 * POINTS - 1, &|_| DVec3::ZERO);
    let mut rows = Vec::new();
    for (i, (name, wall)) in ["suction side", "pressure side"].iter().zip(&part.walls).enumerate() {
        task.check()?;
        let points: Vec<DVec3> = between.iter().flat_map(|s| [&s.low, &s.high][i].iter().copied()).collect();
        let feet = wall.feet();
        let off = FitError::of(points.par_iter().map(|p| feet.foot(*p).height).collect::<Vec<f64>>());
        let figures = [wall.off_points.greatest_mm, off.greatest_mm, off.rms_mm].map(small);
        rows.push([vec![(*name).to_owned(), format!("{SECTIONS} x {POINTS}")], figures.to_vec()].concat());
    }
    let head = ["side", "#points", "#greatest at them (mm)", "#greatest between (mm)", "#RMS between (mm)"];
    let tables = vec![Table::new("The surface against the exact blade", &head, rows)];
    let line = |wall: usize, v: f64| {
        let point = |i: usize| part.walls[wall].surface.point(i as f64 / 200.0, v);
        (0..=200).map(point).map(|p| if wall == 0 { to_next_blade(part) * p } else { p }).collect::<Vec<DVec3>>()
    };
    let surface = |wall: usize| {
        let rows: Vec<Vec<DVec3>> = (0..=40).map(|k| line(wall, f64::from(k) / 40.0)).collect();
        let mesh = RenderMesh::for_pictures(&grid_mesh(&rows, wall == 1));
        Object { edges: false, ..Object::new(ObjectId(wall as u32), Arc::new(mesh), STEEL) }
    };
    let mut scene = Scene { objects: vec![surface(0), surface(1)], ..Scene::new(Theme::LIGHT) };
    let section_lines = (0..2).flat_map(|wall| part.walls[wall].v.iter().map(move |v| line(wall, *v)));
    scene.lines.push(LineSet::new(section_lines.collect(), Theme::LIGHT.edge));
    let picture = MoldPicture {
        title: "Blade as a NURBS surface".to_owned(),
        caption: format!("Two surfaces skinned over the {SECTIONS} sections that are drawn as lines."),
        legend: Vec::new(),
        camera: blade_camera(&scene, DVec3::new(-0.5, -0.8, 0.35)),
        scene,
    };
    Ok(Outcome {
        tables,
        pictures: drawn(vec![picture], task)?,
        ..outcome(
            "Figure 4",
            "Blade rebuilt as a NURBS surface from its sections",
            Verdict::Same,
            "The same method: chord-length parameters, averaged knots, cubic interpolation with end tangents, skinned over \
             sections. The paper tells no distance of its surface from what it was rebuilt from; ours stands in the table.",
            "sparkpath inspect p1_blisk.stl --sections p1_sections.csv prints how far the rebuilt walls are off the triangles of \
             the mesh; the table is against the exact blade, so that its figures are less by the chords of the triangles.",
        )
    })
}
