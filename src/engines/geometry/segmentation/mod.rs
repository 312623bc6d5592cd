//! Faces and edges of a triangle mesh, as the solid had them that was tessellated.
//!
//! First triangles are joined to facets, each in one plane. Strips of facets that turn by equal steps are grown into
//! cylinders and cones as far as all corners lie on the fitted surface. Of what is left, facets that can be chords of
//! one curved surface make patches of free form, bounded by sharp edges; the others are planes.
//!
//! Faces side by side on one surface come out as one, the two halves of a bore for instance. Spheres, tori and all
//! other forms are free. A row of a sphere or torus can never be told from a short cone by itself; it is taken for what
//! it is if such rows go on beside it.

mod chains;
mod facets;
mod patches;
mod revolved;
mod strips;
mod topology;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DMat4, DVec3};
use serde::{Deserialize, Serialize};
use task::{Cancel, Cancelled};

use self::chains::Segment;
use self::facets::{Facets, Flat};
use self::revolved::Revolved;
use self::topology::{NONE, Topology};
use super::mesh::Mesh;
use super::nurbs::NurbsCurve;

/// Settings that decide which triangles make one face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SegmentationSettings {
    /// Greatest distance of a triangle's corners from the plane that it belongs to (mm). Never less than what the
    /// rounding of coordinates to 24 bits makes.
    pub plane_tolerance: f64,
    /// Greatest angle between a triangle and the plane that it belongs to (degrees).
    pub plane_angle_deg: f64,
    /// Greatest distance of a corner from its cylinder or cone (mm). Corners must be about four times as exact, or the
    /// face is taken for one of another form.
    pub fit_tolerance: f64,
    /// Greatest angle between neighbouring facets of a cylinder or cone (degrees).
    pub strip_angle_deg: f64,
    /// Angle between neighbouring facets from which on the edge between them bounds a patch of free form (degrees).
    pub sharp_angle_deg: f64,
    /// Greatest distance between a surface of free form and its facets (mm): larger facets are planes.
    pub chord_tolerance: f64,
    /// Angle between the normals of two faces up to which an edge is smooth (degrees). At a free form, whose normals
    /// are known as those of its facets only, it is `sharp_angle_deg`.
    pub smooth_angle_deg: f64,
}

impl Default for SegmentationSettings {
    fn default() -> Self {
        Self {
            plane_tolerance: 1e-4,
            plane_angle_deg: 0.1,
            fit_tolerance: 2e-3,
            strip_angle_deg: 25.0,
            sharp_angle_deg: 20.0,
            chord_tolerance: 0.1,
            smooth_angle_deg: 2.0,
        }
    }
}

/// The form of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaceKind {
    /// The points `p` with `normal . p = offset`.
    Plane {
        /// Unit normal, outwards.
        normal: DVec3,
        /// Distance from the origin along the normal (mm).
        offset: f64,
    },
    /// A circular cylinder.
    Cylinder {
        /// The point of the axis beside the middle of the face (mm).
        point: DVec3,
        /// Unit direction of the axis; either of the two.
        direction: DVec3,
        /// Radius (mm).
        radius: f64,
        /// Whether the axis lies outside the material, as that of a bore: concave seen from outside.
        is_hollow: bool,
    },
    /// A circular cone.
    Cone {
        /// Tip (mm).
        apex: DVec3,
        /// Unit direction of the axis, from the tip to the face.
        axis: DVec3,
        /// Angle between the axis and the surface (rad).
        half_angle: f64,
        /// Whether the axis lies outside the material, as that of a countersink.
        is_hollow: bool,
    },
    /// A sphere; only of a face that a CAD program knows.
    Sphere {
        /// Centre (mm).
        centre: DVec3,
        /// Radius (mm).
        radius: f64,
        /// Whether the centre lies outside the material.
        is_hollow: bool,
    },
    /// A torus; only of a face that a CAD program knows.
    Torus {
        /// Centre (mm).
        centre: DVec3,
        /// Unit direction of the axis; either of the two.
        axis: DVec3,
        /// Radius of the circle through the middle of the tube (mm).
        major: f64,
        /// Radius of the tube (mm).
        minor: f64,
        /// Whether the middle of the tube lies outside the material, as that of a rounded corner of a pocket.
        is_hollow: bool,
    },
    /// Any other form.
    FreeForm,
}

impl FaceKind {
    /// The form with its sizes, in words.
    pub fn words(&self) -> String {
        let side = |is_hollow: bool| if is_hollow { "hollow " } else { "" };
        match *self {
            Self::Plane { .. } => "plane".to_owned(),
            Self::Cylinder { radius, is_hollow, .. } => {
                format!("{}cylinder, radius {radius:.4} mm", side(is_hollow))
            }
            Self::Cone { half_angle, is_hollow, .. } => {
                format!("{}cone, half angle {:.3} deg", side(is_hollow), half_angle.to_degrees())
            }
            Self::Sphere { radius, is_hollow, .. } => format!("{}sphere, radius {radius:.4} mm", side(is_hollow)),
            Self::Torus { major, minor, is_hollow, .. } => {
                format!("{}torus, radii {major:.4} and {minor:.4} mm", side(is_hollow))
            }
            Self::FreeForm => "free form".to_owned(),
        }
    }
}

/// Triangles of one surface that hang together.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Form.
    pub kind: FaceKind,
    /// Triangles, rising.
    pub triangles: Vec<u32>,
    /// Area (mm^2).
    pub area: f64,
    /// The greatest distance of a corner from the surface (mm); 0 for a free form, which is fitted with none.
    pub deviation: f64,
    /// The face of the CAD program, where the file of the part has it.
    pub known: Option<Arc<KnownFace>>,
}

/// A face of a CAD program.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownFace {
    /// Form.
    pub kind: FaceKind,
    /// Name in the file; often empty.
    pub name: String,
    /// Red, green and blue from 0 to 1, where the face has a colour of its own.
    pub color: Option<[f32; 3]>,
    /// Both guides of a ruled B-spline surface over the face: rulings join equal parameters. Two pairs where it is ruled
    /// both ways; none where it is not ruled.
    pub guides: Vec<[NurbsCurve; 2]>,
}

impl KnownFace {
    /// Form, sizes and name, in words.
    pub fn words(&self) -> String {
        let form = match self.kind {
            FaceKind::FreeForm if !self.guides.is_empty() => "ruled B-spline surface".to_owned(),
            kind => kind.words(),
        };
        if self.name.is_empty() { form } else { format!("{form}, \u{201c}{}\u{201d}", self.name) }
    }

    /// A face of this form, without a name.
    pub fn of(kind: FaceKind) -> Self {
        Self { kind, name: String::new(), color: None, guides: Vec::new() }
    }

    /// The face at another place: `placement` turns, moves and scales by `scale`, evenly.
    pub fn placed(&self, placement: &DMat4, scale: f64) -> Self {
        let point = |p: DVec3| placement.transform_point3(p);
        let turn = |v: DVec3| placement.transform_vector3(v) / scale;
        let kind = match self.kind {
            FaceKind::Plane { normal, offset } => {
                let turned = turn(normal);
                FaceKind::Plane { normal: turned, offset: turned.dot(point(normal * offset)) }
            }
            FaceKind::Cylinder { point: on, direction, radius, is_hollow } => {
                FaceKind::Cylinder { point: point(on), direction: turn(direction), radius: radius * scale, is_hollow }
            }
            FaceKind::Cone { apex, axis, half_angle, is_hollow } => {
                FaceKind::Cone { apex: point(apex), axis: turn(axis), half_angle, is_hollow }
            }
            FaceKind::Sphere { centre, radius, is_hollow } => {
                FaceKind::Sphere { centre: point(centre), radius: radius * scale, is_hollow }
            }
            FaceKind::Torus { centre, axis, major, minor, is_hollow } => {
                let [major, minor] = [major, minor].map(|r| r * scale);
                FaceKind::Torus { centre: point(centre), axis: turn(axis), major, minor, is_hollow }
            }
            FaceKind::FreeForm => FaceKind::FreeForm,
        };
        let guides = self.guides.iter().map(|pair| [&pair[0], &pair[1]].map(|g| g.mapped(point))).collect();
        Self { kind, guides, ..self.clone() }
    }
}

/// Faces of a CAD program that the triangles of a mesh belong to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CadFaces {
    /// Faces.
    pub faces: Vec<KnownFace>,
    /// Number of the face of each triangle.
    pub face_of: Vec<u32>,
}

impl CadFaces {
    /// Number, from 1, and face of a triangle.
    pub fn at(&self, triangle: u32) -> Option<(u32, &KnownFace)> {
        let number = *self.face_of.get(triangle as usize)?;
        Some((number + 1, self.faces.get(number as usize)?))
    }

    /// The face of a triangle in words, with its number.
    pub fn words_at(&self, triangle: u32) -> Option<String> {
        self.at(triangle).map(|(number, face)| format!("face {number}: {}", face.words()))
    }

    /// The faces of the part scaled by `by`.
    pub fn scaled(mut self, by: f64) -> Self {
        if by != 1.0 {
            let scale = DMat4::from_scale(DVec3::splat(by));
            self.faces.iter_mut().for_each(|face| *face = face.placed(&scale, by));
        }
        self
    }
}

/// How two faces meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EdgeKind {
    /// The material is a wedge.
    Convex,
    /// The material is more than half of what is around the edge.
    Concave,
    /// The faces are tangent.
    Smooth,
}

/// A chain of triangle sides between two faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Numbers of the faces, the lower first.
    pub faces: [u32; 2],
    /// How they meet.
    pub kind: EdgeKind,
    /// The mean angle between their outward normals (rad): positive where convex, negative where concave.
    pub angle: f64,
    /// Whether it is a straight line.
    pub is_straight: bool,
    /// The greatest distance of a vertex from the line through the ends, or from the first vertex of a closed chain
    /// (mm).
    pub bend: f64,
    /// Length (mm).
    pub length: f64,
    /// Vertices in order, counter-clockwise around the first face; a closed chain ends where it starts. Of vertices at
    /// the same place the first is named.
    pub vertices: Vec<u32>,
}

impl Edge {
    /// Whether it ends where it starts.
    pub fn is_closed(&self) -> bool {
        self.vertices.first() == self.vertices.last()
    }
}

/// The faces and edges of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Segmentation {
    /// In the order of their first triangles.
    pub faces: Vec<Face>,
    /// The number of the face of each triangle.
    pub face_of: Vec<u32>,
    /// In the order of their faces. Sides of triangles without exactly one neighbour that agrees which way is out, at
    /// the border of an open mesh for instance, belong to none.
    pub edges: Vec<Edge>,
}

/// The surface of a face, counted from the origin of the topology.
#[derive(Debug, Clone, Copy)]
enum Surface {
    Flat(Flat),
    Revolved(Revolved, bool),
    Free,
}

impl Segmentation {
    /// Finds the faces and edges of `mesh`, vertices at the same place taken as one. Triangles without area go to a
    /// face beside them; those with corners that are no points make a face of free form together.
    pub fn of(mesh: &Mesh, settings: &SegmentationSettings) -> Self {
        // Nobody can cancel it.
        Self::find(mesh, settings, &Cancel::default()).unwrap_or_default()
    }

    /// [`of`](Self::of), which can be cancelled.
    ///
    /// # Errors
    /// When cancelled.
    pub fn find(mesh: &Mesh, settings: &SegmentationSettings, cancel: &Cancel) -> Result<Self, Cancelled> {
        let topology = Topology::of(mesh);
        cancel.check()?;
        let plane_tolerance = settings.plane_tolerance.max(4.0 * topology.rounding);
        let fit_tolerance = settings.fit_tolerance.max(16.0 * topology.rounding);
        let facets = Facets::of(&topology, settings.plane_angle_deg.to_radians(), plane_tolerance);
        let strip_turn = settings.strip_angle_deg.to_radians();
        let limits = strips::Limits {
            tolerance: fit_tolerance,
            least_tolerance: 4.0 * topology.rounding,
            turn: strip_turn,
            least_cosine: (0.6 * strip_turn).cos(),
        };
        cancel.check()?;
        let mut regions = strips::find(&topology, &facets, limits, cancel)?;
        let turns = [settings.plane_angle_deg.to_radians(), strip_turn];
        let mut is_row = strips::rows(&topology, &facets, &regions, turns).into_iter();
        regions.retain(|_| is_row.next() != Some(true));
        let mut is_stray = strips::strays(&facets, &regions, strip_turn).into_iter();
        regions.retain(|_| is_stray.next() != Some(true));
        let mut surfaces = Vec::new();
        let mut label = vec![NONE; facets.all.len()];
        for region in &regions {
            region.facets.iter().for_each(|&f| label[f as usize] = surfaces.len() as u32);
            surfaces.push(Surface::Revolved(region.surface, region.is_hollow));
        }
        cancel.check()?;
        label_rest(&facets, &mut label, &mut surfaces, settings);
        join_slivers(&topology, &facets, &mut label, plane_tolerance);
        let of_triangle = labels_of_triangles(&topology, &facets, &label, &mut surfaces);
        cancel.check()?;
        Ok(Self::labelled(&topology, &of_triangle, &surfaces, settings))
    }

    /// The faces of a mesh whose faces are known by number, with the number of the face of each triangle. A face without
    /// a triangle is left out, a triangle with a number beyond the `known` ones belongs to a face of free form.
    pub fn of_faces(mesh: &Mesh, known: &[KnownFace], face_of: &[u32], settings: &SegmentationSettings) -> Self {
        let topology = Topology::of(mesh);
        let mut surfaces: Vec<Surface> = known.iter().map(|face| Surface::of(&face.kind, topology.origin)).collect();
        let free = surfaces.len() as u32;
        surfaces.push(Surface::Free);
        let label = |t: usize| face_of.get(t).copied().filter(|f| *f < free).unwrap_or(free);
        let of_triangle: Vec<u32> = (0..mesh.triangles.len()).map(label).collect();
        let mut found = Self::labelled(&topology, &of_triangle, &surfaces, settings);
        for face in &mut found.faces {
            let number = face.triangles.first().and_then(|t| of_triangle.get(*t as usize));
            face.known = number.and_then(|n| known.get(*n as usize)).cloned().map(Arc::new);
            if let Some(known) = &face.known {
                face.kind = known.kind;
            }
        }
        found
    }

    /// The faces of triangles with these labels, and the edges between them.
    fn labelled(
        topology: &Topology,
        of_triangle: &[u32],
        surfaces: &[Surface],
        settings: &SegmentationSettings,
    ) -> Self {
        let straight = settings.plane_tolerance.max(4.0 * topology.rounding);
        let (faces, face_of, surfaces) = faces(topology, of_triangle, surfaces);
        let edges = edges(topology, &face_of, &surfaces, settings, straight);
        Self { faces, face_of, edges }
    }
}

/// Labels patches of free form and planes.
fn label_rest(facets: &Facets, label: &mut [u32], surfaces: &mut Vec<Surface>, settings: &SegmentationSettings) {
    let is_taken: Vec<bool> = label.iter().map(|&l| l != NONE).collect();
    let limits = patches::Limits { turn: settings.sharp_angle_deg.to_radians(), chord: settings.chord_tolerance };
    let patches = patches::patches(facets, &is_taken, limits);
    let first_patch = surfaces.len() as u32;
    let count = patches.iter().filter(|p| **p != NONE).max().map_or(0, |&p| p + 1);
    surfaces.extend((0..count).map(|_| Surface::Free));
    for (i, facet) in facets.all.iter().enumerate().filter(|(i, _)| !is_taken[*i]) {
        label[i] = if patches[i] == NONE { surfaces.len() as u32 } else { first_patch + patches[i] };
        if patches[i] == NONE {
            surfaces.push(Surface::Flat(facet.flat));
        }
    }
}

/// Gives facets of mere slivers, which have no plane of their own, to the face with which they share most.
fn join_slivers(topology: &Topology, facets: &Facets, label: &mut [u32], tolerance: f64) {
    let is_sliver = |f: usize| facets.all[f].triangles.iter().all(|&t| topology.heights[t as usize] <= tolerance);
    let mut open: Vec<usize> = (0..facets.all.len()).filter(|&f| is_sliver(f)).collect();
    let mut is_open = vec![false; facets.all.len()];
    open.iter().for_each(|&f| is_open[f] = true);
    loop {
        let before = open.len();
        open.retain(|&f| {
            let links = facets.links(f as u32).iter().filter(|link| !is_open[link.to as usize]);
            let best = links.reduce(|a, b| if b.length > a.length { b } else { a });
            if let Some(best) = best {
                label[f] = label[best.to as usize];
                is_open[f] = false;
            }
            best.is_none()
        });
        if open.len() == before {
            return;
        }
    }
}

/// The label of each triangle. One outside all facets is given that of a triangle at one of its corners.
fn labels_of_triangles(topology: &Topology, facets: &Facets, label: &[u32], surfaces: &mut Vec<Surface>) -> Vec<u32> {
    let mut found: Vec<u32> =
        facets.of_triangle.iter().map(|&f| if f == NONE { NONE } else { label[f as usize] }).collect();
    let mut at_point = vec![NONE; topology.points.len()];
    for (corners, &l) in topology.corners.iter().zip(&found).filter(|(_, l)| **l != NONE) {
        corners.iter().for_each(|&v| at_point[v as usize] = l);
    }
    let lost = surfaces.len() as u32;
    for (corners, l) in topology.corners.iter().zip(&mut found).filter(|(_, l)| **l == NONE) {
        let near = corners.iter().filter_map(|&v| at_point.get(v as usize)).find(|l| **l != NONE);
        *l = near.copied().unwrap_or(lost);
    }
    surfaces.push(Surface::Free);
    found
}

/// The faces in the order of their first triangles, the face of each triangle and the surfaces of the faces.
fn faces(topology: &Topology, of_triangle: &[u32], surfaces: &[Surface]) -> (Vec<Face>, Vec<u32>, Vec<Surface>) {
    let mut number = vec![NONE; surfaces.len()];
    let (mut faces, mut face_of, mut found) = (Vec::<Face>::new(), Vec::new(), Vec::new());
    for (i, &label) in (0u32..).zip(of_triangle) {
        if number[label as usize] == NONE {
            number[label as usize] = faces.len() as u32;
            let surface = surfaces[label as usize];
            found.push(surface);
            let kind = surface.kind(topology.origin);
            faces.push(Face { kind, triangles: Vec::new(), area: 0.0, deviation: 0.0, known: None });
        }
        let n = number[label as usize];
        face_of.push(n);
        let face = &mut faces[n as usize];
        face.triangles.push(i);
        face.area += topology.areas[i as usize];
        let off = |v: &u32| topology.points.get(*v as usize).map_or(0.0, |&p| surfaces[label as usize].distance(p));
        face.deviation = topology.corners[i as usize].iter().map(off).fold(face.deviation, f64::max);
    }
    (faces, face_of, found)
}

fn edges(
    topology: &Topology,
    face_of: &[u32],
    surfaces: &[Surface],
    settings: &SegmentationSettings,
    straight: f64,
) -> Vec<Edge> {
    let (mut segments, mut borders) = (Vec::new(), Vec::new());
    for (i, neighbours) in topology.neighbours.iter().enumerate() {
        for (k, &j) in neighbours.iter().enumerate() {
            let ends = topology.side(i, k);
            if j == NONE {
                borders.extend(ends);
                continue;
            }
            let faces = [face_of[i], face_of[j as usize]];
            if faces[0] >= faces[1] {
                continue;
            }
            let along = topology.along_side(i, k);
            let middle = topology.points[ends[0] as usize] + 0.5 * along;
            let pair = faces.map(|f| &surfaces[f as usize]);
            let n = pair[0].normal(middle).unwrap_or(topology.normals[i]);
            let m = pair[1].normal(middle).unwrap_or(topology.normals[j as usize]);
            let angle = n.cross(m).length().atan2(n.dot(m)) * n.cross(m).dot(along).signum();
            let is_free = pair.iter().any(|s| matches!(s, Surface::Free));
            let smooth = if is_free { settings.sharp_angle_deg } else { settings.smooth_angle_deg };
            let kind = match angle {
                _ if angle.abs() <= smooth.to_radians() => EdgeKind::Smooth,
                _ if angle > 0.0 => EdgeKind::Convex,
                _ => EdgeKind::Concave,
            };
            segments.push(Segment { faces, kind, angle, ends });
        }
    }
    chains::chains(topology, &segments, &borders, straight)
}

impl Surface {
    /// The surface of a face, counted from `from`.
    fn of(kind: &FaceKind, from: DVec3) -> Self {
        match *kind {
            FaceKind::Plane { normal, offset } => Self::Flat(Flat { normal, offset: offset - normal.dot(from) }),
            FaceKind::Cylinder { point, direction, radius, is_hollow } => {
                Self::Revolved(Revolved { origin: point - from, axis: direction, radius, slope: 0.0 }, is_hollow)
            }
            FaceKind::Cone { apex, axis, half_angle, is_hollow } => {
                let slope = half_angle.tan();
                Self::Revolved(Revolved { origin: apex + axis - from, axis, radius: slope, slope }, is_hollow)
            }
            FaceKind::Sphere { .. } | FaceKind::Torus { .. } | FaceKind::FreeForm => Self::Free,
        }
    }

    fn kind(&self, from: DVec3) -> FaceKind {
        match *self {
            Self::Flat(flat) => FaceKind::Plane { normal: flat.normal, offset: flat.offset + flat.normal.dot(from) },
            Self::Revolved(s, is_hollow) if s.slope == 0.0 => {
                FaceKind::Cylinder { point: s.origin + from, direction: s.axis, radius: s.radius, is_hollow }
            }
            Self::Revolved(s, is_hollow) => FaceKind::Cone {
                apex: s.origin + from - s.axis * (s.radius / s.slope),
                axis: s.axis * s.slope.signum(),
                half_angle: s.slope.abs().atan(),
                is_hollow,
            },
            Self::Free => FaceKind::FreeForm,
        }
    }

    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Flat(flat) => flat.distance(p),
            Self::Revolved(s, _) => s.signed_distance(p).abs(),
            Self::Free => 0.0,
        }
    }

    /// The outward unit normal beside `p`; none where only the facets know it.
    fn normal(&self, p: DVec3) -> Option<DVec3> {
        match self {
            Self::Flat(flat) => Some(flat.normal),
            Self::Revolved(s, is_hollow) => Some(s.normal(p) * if *is_hollow { -1.0 } else { 1.0 }),
            Self::Free => None,
        }
    }
}
