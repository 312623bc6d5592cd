//! The scene: bodies, lines, markers, and how they are cut and coloured. All positions are in one frame, the scene's,
//! in millimetres; +Z is up.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::colour::{Colour, Theme};
use super::colour_map::ColourMap;
use super::mesh::RenderMesh;
use geometry::mesh::Bounds;

/// Everything in one picture.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Bodies and surfaces.
    pub objects: Vec<Object>,
    /// Polylines: paths, centre lines, vectors.
    pub lines: Vec<LineSet>,
    /// Points worth a dot.
    pub markers: Vec<Marker>,
    /// Cuts away half of every object.
    pub section: Option<SectionPlane>,
    /// A grid below the objects.
    pub grid: Option<Grid>,
    /// Whether the axes are shown in the lower left corner: X red, Y green, Z blue.
    pub triad: bool,
    /// Colours of background, edges and selection.
    pub theme: Theme,
}

/// The name of an object within its scene; the caller chooses it, and picking returns it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(pub u32);

/// One body in one place. Many may share a mesh, such as ghosts of an electrode along its path.
#[derive(Debug, Clone)]
pub struct Object {
    /// Name.
    pub id: ObjectId,
    /// Shape.
    pub mesh: Arc<RenderMesh>,
    /// From the mesh's frame to the scene's; must not be singular.
    pub transform: DAffine3,
    /// Colour where `values` has none.
    pub colour: Colour,
    /// 1 is solid; at 0 or less it is neither drawn nor picked; between, its nearest surface is blended over
    /// what is behind.
    pub opacity: f32,
    /// Whether its feature edges are drawn.
    pub edges: bool,
    /// Colours from a quantity on the surface.
    pub values: Option<SurfaceValues>,
    /// Whether it is tinted with the theme's accent.
    pub selected: bool,
}

/// A quantity on a surface, shown by a colour map.
#[derive(Debug, Clone)]
pub struct SurfaceValues {
    /// One value for each vertex of the [`Mesh`](geometry::mesh::Mesh) that the [`RenderMesh`] was made
    /// of, in its order. NaN and missing values show the object's own colour. The allocation is the key of
    /// the copy on the GPU: give the same `Arc` as long as the values are the same.
    pub values: Arc<Vec<f32>>,
    /// Colours.
    pub map: ColourMap,
    /// The value at the start of the map and the one at its end; values beyond are shown as these.
    pub range: [f32; 2],
}

impl SurfaceValues {
    /// The value at a vertex of the mesh; none where it is missing.
    pub fn at(&self, vertex: u32) -> Option<f32> {
        self.values.get(vertex as usize).copied().filter(|value| value.is_finite())
    }

    /// What a difference of values is multiplied with to give a share of the map.
    pub fn scale(&self) -> f32 {
        let span = self.range[1] - self.range[0];
        if span > 0.0 { 1.0 / span } else { 0.0 }
    }
}

/// Lines of one look.
#[derive(Debug, Clone)]
pub struct LineSet {
    /// Polylines, each through at least two points.
    pub polylines: Vec<Vec<DVec3>>,
    /// Colour.
    pub colour: Colour,
    /// Width on the screen (pixels).
    pub width_px: f32,
    /// Whether what lies behind other things is seen as well, faintly.
    pub on_top: bool,
}

/// A round dot of constant size, seen through everything, more faintly where something is before it.
#[derive(Debug, Clone, Copy)]
pub struct Marker {
    /// Place of the dot.
    pub at: DVec3,
    /// Colour.
    pub colour: Colour,
    /// Radius on the screen (pixels).
    pub radius_px: f32,
}

/// A plane that cuts the objects; what lies on the side its normal points to is taken away. Closed bodies show
/// hatched cut faces, open surfaces only the line of the cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionPlane {
    /// A point of the plane.
    pub point: DVec3,
    /// Normal, of any length but zero.
    pub normal: DVec3,
}

/// A square grid parallel to the XY plane, fading out from its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Middle.
    pub center: DVec3,
    /// Distance of its lines (mm); every tenth is stronger.
    pub spacing: f64,
    /// Radius at which it has faded out (mm).
    pub radius: f64,
}

impl Scene {
    /// An empty scene with the axes in the corner.
    pub fn new(theme: Theme) -> Self {
        Self { triad: true, theme, ..Self::default() }
    }

    /// The box around the objects that can be seen, before any section, and around lines and markers; empty
    /// ([`Bounds::EMPTY`]) if there is nothing.
    pub fn bounds(&self) -> Bounds {
        union(self.bounds_of_points(), self.bounds_of_objects())
    }

    /// The box around lines and markers.
    pub(super) fn bounds_of_points(&self) -> Bounds {
        let lines = self.lines.iter().flat_map(|l| l.polylines.iter().flatten().copied());
        Bounds::of(lines.chain(self.markers.iter().map(|m| m.at)).filter(|p| p.is_finite()))
    }

    /// The box around the objects that can be seen, before any section.
    pub(super) fn bounds_of_objects(&self) -> Bounds {
        self.objects.iter().filter(|o| o.is_visible()).map(Object::bounds).fold(Bounds::EMPTY, union)
    }
}

/// The box around two boxes.
pub(super) fn union(a: Bounds, b: Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}

impl Object {
    /// A solid object with edges, in place.
    pub fn new(id: ObjectId, mesh: Arc<RenderMesh>, colour: Colour) -> Self {
        Self {
            id,
            mesh,
            transform: DAffine3::IDENTITY,
            colour,
            opacity: 1.0,
            edges: true,
            values: None,
            selected: false,
        }
    }

    /// Object placed by `transform`.
    pub fn at(self, transform: DAffine3) -> Self {
        Self { transform, ..self }
    }

    /// Object with this opacity.
    pub fn with_opacity(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }

    /// Whether it is drawn at all: it has triangles, is not fully transparent, and its place is a finite one.
    pub fn is_visible(&self) -> bool {
        self.opacity > 0.0 && !self.mesh.is_empty() && self.transform.is_finite()
    }

    /// Whether it hides what is behind.
    pub fn is_opaque(&self) -> bool {
        self.opacity >= 1.0
    }

    /// Share of the accent colour in its own.
    pub(super) fn accent(&self) -> f32 {
        if self.selected { 0.42 } else { 0.0 }
    }

    /// A box around it in the scene's frame, not always the smallest.
    pub fn bounds(&self) -> Bounds {
        let Bounds { min, max } = self.mesh.bounds();
        if self.mesh.is_empty() || self.transform == DAffine3::IDENTITY {
            return self.mesh.bounds();
        }
        Bounds::of((0..8).map(|i| {
            let corner = DVec3::new(
                if i & 1 == 0 { min.x } else { max.x },
                if i & 2 == 0 { min.y } else { max.y },
                if i & 4 == 0 { min.z } else { max.z },
            );
            self.transform.transform_point3(corner)
        }))
    }
}

impl SectionPlane {
    /// The unit normal; `None` if the plane is not one (zero or non-finite normal, non-finite point), which
    /// then cuts nothing.
    pub fn unit_normal(&self) -> Option<DVec3> {
        if self.point.is_finite() { self.normal.try_normalize() } else { None }
    }

    /// Distance of `p` on the removed side (mm), negative on the side that stays.
    pub fn height(&self, p: DVec3) -> Option<f64> {
        self.unit_normal().map(|n| n.dot(p - self.point))
    }
}

impl LineSet {
    /// Thin lines that objects hide.
    pub fn new(polylines: Vec<Vec<DVec3>>, colour: Colour) -> Self {
        Self { polylines, colour, width_px: 2.0, on_top: false }
    }
}

impl Grid {
    /// A grid just below `bounds`, wide enough to stand on, with lines at 1, 2 or 5 times a power of ten.
    pub fn below(bounds: &Bounds) -> Option<Self> {
        let size = bounds.size();
        let radius = size.truncate().length() * 1.1;
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let center = bounds.center().with_z(bounds.min.z - 0.01 * size.length());
        let decade = 10f64.powf((radius / 20.0).log10().floor());
        let spacing = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|&s| s >= radius / 20.0);
        Some(Self { center, spacing: spacing.unwrap_or(decade), radius })
    }
}
