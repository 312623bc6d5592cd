//! STEP AP242 text of a solid.

use glam::DVec3;
use step_io::build::{CurveInput, Frame, StyleTarget};
use step_io::model as m;
use step_io::scene::{NurbsCurve, Rgb};
use step_io::{AuthorError, StepBuilder};

use super::brep::{Brep, Face, FaceSurface};
use super::curve::{EdgeCurve, Form};
use super::spline::{DEGREE, Knots, SplineSurface};
use super::surface::{Axes, Surface};
use super::{Property, PropertyValue, StepPart, StepSettings, StepWriteError};

/// The bytes of the file.
pub(super) fn file(
    part: &StepPart,
    settings: &StepSettings,
    brep: &Brep,
    shells: &[Vec<usize>],
) -> Result<Vec<u8>, StepWriteError> {
    let mut builder = StepBuilder::new();
    let header = builder.header_mut();
    header.file_name = format!("{}.step", part.name);
    header.time_stamp = settings.time_stamp.clone();
    header.originating_system = settings.originating_system.clone();
    let drawn_in = if part.patches.is_empty() { "" } else { ", drawn in where they would reach beyond it" };
    let tolerance = settings.tolerance;
    header.descriptions = vec![format!("Solid from a triangle mesh; free forms fitted to {tolerance} mm{drawn_in}")];
    let product = builder.part(part.name);
    let faces = faces(&mut builder, part, brep)?;
    for (k, shell) in shells.iter().enumerate() {
        let name = if k == 0 { part.name.to_owned() } else { format!("{} ({})", part.name, k + 1) };
        builder.solid(product, &name, shell.iter().map(|&f| faces[f]).collect())?;
    }
    for (&face, of) in faces.iter().zip(&brep.faces) {
        if let Some([red, green, blue]) = part.roles.get(usize::from(of.role)).and_then(|r| r.colour) {
            builder.style(StyleTarget::Face(face), Rgb { red, green, blue }, None)?;
        }
    }
    let definition = builder.part_ids(product).definition;
    properties(&mut builder, definition, part.properties)?;
    let mut bytes = Vec::new();
    step_io::write(&builder.finish(), &mut bytes).map_err(|error| StepWriteError::File(error.to_string()))?;
    Ok(bytes)
}

fn faces(builder: &mut StepBuilder, part: &StepPart, brep: &Brep) -> Result<Vec<m::AdvancedFaceId>, StepWriteError> {
    let mut vertices = Vec::with_capacity(brep.vertices.len());
    for p in &brep.vertices {
        vertices.push(builder.vertex(p.to_array())?);
    }
    let mut edges = Vec::with_capacity(brep.edges.len());
    for edge in &brep.edges {
        let [from, to] = edge.ends.map(|v| vertices[v]);
        edges.push(builder.edge(from, to, curve_input(&edge.curve))?);
    }
    let mut faces = Vec::with_capacity(brep.faces.len());
    for face in &brep.faces {
        let name = part.roles.get(usize::from(face.role)).map_or("", |role| role.name.as_str());
        faces.push(advanced_face(builder, name, face, &edges)?);
    }
    Ok(faces)
}

fn curve_input(curve: &EdgeCurve) -> CurveInput {
    match &curve.form {
        Form::Line => CurveInput::Line,
        Form::Circle { axes, radius } => CurveInput::Circle(frame(axes), *radius),
        Form::Spline => CurveInput::Nurbs(NurbsCurve {
            degree: DEGREE,
            control_points: curve.spline.controls.iter().map(DVec3::to_array).collect(),
            weights: vec![1.0; curve.spline.controls.len()],
            knots: curve.spline.knots.all().to_vec(),
        }),
    }
}

fn frame(axes: &Axes) -> Frame {
    Frame { origin: axes.origin.to_array(), axis: axes.z.to_array(), ref_dir: axes.x.to_array() }
}

fn advanced_face(
    builder: &mut StepBuilder,
    name: &str,
    face: &Face,
    edges: &[m::EdgeCurveId],
) -> Result<m::AdvancedFaceId, AuthorError> {
    let (geometry, is_along) = geometry(builder, &face.surface)?;
    let author = builder.author();
    let mut bounds = Vec::with_capacity(face.loops.len());
    for (k, side) in face.loops.iter().enumerate() {
        let mut oriented = Vec::with_capacity(side.len());
        for &(edge, is_forward) in side {
            let edge = author.add_oriented_edge("", m::EdgeRef::EdgeCurve(edges[edge]), is_forward)?;
            oriented.push(m::OrientedEdgeRef::OrientedEdge(edge));
        }
        let side = m::LoopRef::EdgeLoop(author.add_edge_loop("", oriented)?);
        bounds.push(if k == 0 {
            m::FaceBoundRef::FaceOuterBound(author.add_face_outer_bound("", side, true)?)
        } else {
            m::FaceBoundRef::FaceBound(author.add_face_bound("", side, true)?)
        });
    }
    author.add_advanced_face(name, bounds, geometry, is_along)
}

/// The entity of a surface and whether its own normal points outwards.
fn geometry(builder: &mut StepBuilder, surface: &FaceSurface) -> Result<(m::SurfaceRef, bool), AuthorError> {
    let author = builder.author();
    let placed = |author: &mut step_io::Ap242Author, axes: &Axes| {
        let origin = author.add_cartesian_point("", axes.origin.to_array().into())?;
        let [z, x] = [axes.z, axes.x].map(|d| author.add_direction("", d.to_array().into()));
        let id = author.add_axis2_placement3d(
            "",
            m::CartesianPointRef::CartesianPoint(origin),
            Some(m::DirectionRef::Direction(z?)),
            Some(m::DirectionRef::Direction(x?)),
        )?;
        Ok(m::Axis2Placement3dRef::Axis2Placement3d(id))
    };
    let surface = match surface {
        FaceSurface::Exact(surface) => surface,
        FaceSurface::Free(spline) => return Ok((b_spline(author, spline)?, true)),
    };
    Ok(match surface {
        Surface::Plane(axes) => {
            let at = placed(author, axes)?;
            (m::SurfaceRef::Plane(author.add_plane("", at)?), true)
        }
        Surface::Cylinder { axes, radius, is_hollow } => {
            let at = placed(author, axes)?;
            (m::SurfaceRef::CylindricalSurface(author.add_cylindrical_surface("", at, *radius)?), !is_hollow)
        }
        Surface::Cone { axes, half_angle, is_hollow } => {
            let at = placed(author, axes)?;
            (m::SurfaceRef::ConicalSurface(author.add_conical_surface("", at, 0.0, *half_angle)?), !is_hollow)
        }
    })
}

fn b_spline(author: &mut step_io::Ap242Author, spline: &SplineSurface) -> Result<m::SurfaceRef, AuthorError> {
    let mut rows = Vec::new();
    for row in spline.controls.chunks(spline.knots[1].count()) {
        let mut points = Vec::with_capacity(row.len());
        for p in row {
            let point = author.add_cartesian_point("", p.to_array().into())?;
            points.push(m::CartesianPointRef::CartesianPoint(point));
        }
        rows.push(points);
    }
    let repeated = |knots: &Knots| {
        let breaks = knots.breaks();
        let times: Vec<i64> = breaks.iter().map(|&k| knots.times(k) as i64).collect();
        (breaks, times)
    };
    let [(u, u_times), (v, v_times)] = [0, 1].map(|k| repeated(&spline.knots[k]));
    let id = author.add_b_spline_surface_with_knots(
        "",
        3,
        3,
        rows,
        m::BSplineSurfaceForm::Unspecified,
        m::Logical::False,
        m::Logical::False,
        m::Logical::False,
        u_times,
        v_times,
        u,
        v,
        m::KnotType::Unspecified,
    )?;
    Ok(m::SurfaceRef::BSplineSurfaceWithKnots(id))
}

/// Writes each property as a definition with a representation of one item.
fn properties(
    builder: &mut StepBuilder,
    product: m::ProductDefinitionId,
    properties: &[Property],
) -> Result<(), AuthorError> {
    if properties.is_empty() {
        return Ok(());
    }
    let author = builder.author();
    let context = author.add_representation_context("", "property values")?;
    let unit = |author: &mut step_io::Ap242Author, kind, prefix, name| {
        let parts =
            vec![kind, m::PartialEntity::NamedUnit { dimensions: None }, m::PartialEntity::SiUnit { prefix, name }];
        author.add_complex(parts).map(m::UnitRef::Complex)
    };
    let millimetre = unit(author, m::PartialEntity::LengthUnit, Some(m::SiPrefix::Milli), m::SiUnitName::Metre)?;
    let radian = unit(author, m::PartialEntity::PlaneAngleUnit, None, m::SiUnitName::Radian)?;
    for Property { name, value } in properties {
        let measure = |author: &mut step_io::Ap242Author, kind: &str, value| m::MeasureValue {
            type_name: Some(author.text(kind)),
            value: m::MeasureScalar::Real(value),
        };
        let item = match value {
            PropertyValue::Text(text) => m::RepresentationItemRef::DescriptiveRepresentationItem(
                author.add_descriptive_representation_item(name, text)?,
            ),
            PropertyValue::Length(mm) => {
                let value = measure(author, "LENGTH_MEASURE", *mm);
                let item = author.add_measure_representation_item(name, value, millimetre.clone())?;
                m::RepresentationItemRef::MeasureRepresentationItem(item)
            }
            PropertyValue::Angle(rad) => {
                let value = measure(author, "PLANE_ANGLE_MEASURE", *rad);
                let item = author.add_measure_representation_item(name, value, radian.clone())?;
                m::RepresentationItemRef::MeasureRepresentationItem(item)
            }
            PropertyValue::Count(count) => {
                let value = measure(author, "COUNT_MEASURE", f64::from(*count));
                m::RepresentationItemRef::ValueRepresentationItem(author.add_value_representation_item(name, value)?)
            }
        };
        let definition =
            author.add_property_definition(name, None, m::CharacterizedDefinitionRef::ProductDefinition(product))?;
        let values =
            author.add_representation(name, vec![item], m::RepresentationContextRef::RepresentationContext(context))?;
        author.add_property_definition_representation(
            m::RepresentedDefinitionRef::PropertyDefinition(definition),
            m::RepresentationRef::Representation(values),
        )?;
    }
    Ok(())
}
