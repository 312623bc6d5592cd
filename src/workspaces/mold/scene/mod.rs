//! The scene of a mold: what is left on it, layer by layer, by region or by depth.

pub mod division;
pub mod electrodes;
pub mod pictures;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::widgets::theme::{BAD, STEEL};
use crate::workspaces::mold::scene::electrodes::BurnOf;
use geometry::circle::Circle;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use mold::datum::Datum;
use mold::opening::Opening;
use mold::piece::UncutPiece;
use mold::surface::SurfacePiece;
use render::colour::{Colour, Theme};
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::{Grid, LineSet, Object, ObjectId, Scene, SectionPlane, SurfaceValues};

/// Faces that look away from the cutters.
const INVERT: Colour = Colour::rgb(0x9a, 0x78, 0xb8);
/// How far before the mold's own surface something is shown on it, in parts of the mold's diagonal, so that the one
/// does not shine through the other.
const BEFORE: f64 = 3e-4;
/// How far from a layer the mold is cut, in the same parts: layers lie on horizontal faces, or just below them.
const OFF: f64 = 1e-6;
/// Length of the axes of the work datum, in parts of the mold's diagonal.
const CROSS: f64 = 0.12;
/// Colours of the axes X, Y and Z.
const AXES: [Colour; 3] = [Colour::rgb(0xe5, 0x48, 0x4d), Colour::rgb(0x46, 0xa7, 0x58), Colour::rgb(0x3b, 0x82, 0xf6)];
/// Opacity of the mold where it would hide what is looked at.
const FAINT: f32 = 0.3;

const MOLD: u32 = 0;
const INVERT_FACES: u32 = 1;
const GLANCE: u32 = 2;
const FIRST_REGION: u32 = 16;

/// A region made for the screen.
#[derive(Debug, Clone)]
pub struct RegionShape {
    /// The mold's surface under it, in the axes of the mesh.
    pub shape: Arc<RenderMesh>,
    /// Height of what is left above its vertices (mm).
    pub depths: Arc<Vec<f32>>,
}

/// How far before the surface of `mesh` something on it is shown (mm).
fn before(mesh: &Mesh) -> f64 {
    BEFORE * mesh.bounds().size().length()
}

/// The shapes of `count` regions on `mesh` from the pieces of their surface, which look along +Z.
pub fn region_shapes(mesh: &Mesh, pieces: &[SurfacePiece], count: usize, opening: Opening) -> Vec<RegionShape> {
    let mut of_region: Vec<Vec<&SurfacePiece>> = vec![Vec::new(); count];
    for piece in pieces {
        if let Some(own) = of_region.get_mut(piece.region as usize) {
            own.push(piece);
        }
    }
    let lift = before(mesh);
    of_region.par_iter().map(|own| region_shape(own, opening, lift)).collect()
}

fn region_shape(pieces: &[&SurfacePiece], opening: Opening, lift: f64) -> RegionShape {
    let (mut mesh, mut depths, mut known) = (Mesh::default(), Vec::<f32>::new(), HashMap::new());
    for piece in pieces {
        mesh.triangles.push(std::array::from_fn(|k| {
            let p = piece.corners[k];
            let v = *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                mesh.vertices.push(opening.in_mesh(p));
                depths.push(0.0);
                depths.len() as u32 - 1
            });
            let depth = &mut depths[v as usize];
            *depth = depth.max(piece.depth[k]);
            v
        }));
    }
    RegionShape { shape: Arc::new(RenderMesh::new(&lifted(mesh, lift))), depths: Arc::new(depths) }
}

/// `mesh` moved by `lift` (mm) along its normals.
fn lifted(mesh: Mesh, lift: f64) -> Mesh {
    let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().zip(mesh.iter_corners()) {
        triangle.iter().for_each(|&v| normals[v as usize] += normal_times_two_areas(corners));
    }
    let vertices = mesh.vertices.iter().zip(&normals).map(|(p, n)| p + lift * n.normalize_or_zero()).collect();
    Mesh { vertices, triangles: mesh.triangles }
}

/// The triangles `faces` of `mesh` as a shape of their own; none if there are none.
pub fn faces_shape(mesh: &Mesh, faces: &[u32]) -> Option<Arc<RenderMesh>> {
    if faces.is_empty() {
        return None;
    }
    let triangles = faces.iter().filter_map(|&f| mesh.triangles.get(f as usize)).copied().collect();
    let part = Mesh { vertices: mesh.vertices.clone(), triangles };
    Some(Arc::new(RenderMesh::new(&lifted(part, before(mesh)))))
}

/// The colour of region or electrode number `i` from 0. Neighbours in the list differ most, all of them are told apart
/// from one another as far as there are colours, and none is like what is selected.
pub fn region_colour(i: usize) -> Colour {
    COLOURS[i % COLOURS.len()]
}

const fn hex(rgb: u32) -> Colour {
    Colour::rgb((rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8)
}

/// How many regions or electrodes have a colour of their own.
pub const REGION_COLOURS: usize = COLOURS.len();

/// Colours of regions: each the one furthest from those before it in OKLab, far from both themes' accents and failures.
#[rustfmt::skip]
const COLOURS: [Colour; 32] = [
    hex(0x2da99d), hex(0x792079), hex(0xdb76db), hex(0xc8d45e), hex(0x376237), hex(0x5e6ad4), hex(0xab6f69), hex(0x8ed0e1),
    hex(0x33c133), hex(0xc13397), hex(0x913127), hex(0xe7a6ad), hex(0x3333c1), hex(0x919127), hex(0x9090c1), hex(0x424c76),
    hex(0x277c91), hex(0x8933c1), hex(0x5ed499), hex(0x279127), hex(0x894d77), hex(0xdb7694), hex(0xa55ed4), hex(0x797020),
    hex(0xc0a6e7), hex(0xaab67c), hex(0x5eb1d4), hex(0x4d8965), hex(0x2d5fa9), hex(0x468ace), hex(0x97c133), hex(0xab699d),
];

/// What the colours by depth mean, up to the `deepest` (mm).
pub fn depth_legend(deepest: f64) -> Legend {
    let (title, unit) = ("Residual height".to_owned(), "mm".to_owned());
    let max = if deepest > 0.0 { deepest } else { 1.0 };
    Legend { title, unit, map: ColourMap::Light, min: 0.0, max, threshold: None }
}

/// Meaning of the regions' colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RegionColours {
    /// A colour for each region.
    #[default]
    ByRegion,
    /// The height that is left above a place.
    ByDepth,
}

/// How a mold is shown beside what is looked at on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)]
pub enum MoldLook {
    #[default]
    Solid,
    Faint,
    Hidden,
}

impl MoldLook {
    /// All looks.
    pub const ALL: [Self; 3] = [Self::Solid, Self::Faint, Self::Hidden];

    /// Name of the look.
    pub fn name(self) -> &'static str {
        ["Solid", "Transparent", "Hidden"][self as usize]
    }

    fn opacity(self) -> f32 {
        [1.0, FAINT, 0.0][self as usize]
    }
}

/// What a scene of a mold is made from.
#[derive(Clone, Copy)]
pub struct MoldScene<'a> {
    /// The mold.
    pub mold: &'a Arc<RenderMesh>,
    /// The regions.
    pub regions: &'a [RegionShape],
    /// Whether each is shown.
    pub shown: &'a [bool],
    /// Meaning of the regions' colours.
    pub colours: RegionColours,
    /// The greatest height of what is left (mm).
    pub deepest: f64,
    /// The one that is selected.
    pub selected: Option<usize>,
    /// How the mold itself is shown.
    pub look: MoldLook,
    /// The faces that look away from the cutters, if they are shown.
    pub invert: Option<&'a Arc<RenderMesh>>,
    /// What a quick look found, in place of the regions.
    pub glance: Option<&'a Arc<RenderMesh>>,
    /// A layer.
    pub layer: Option<MoldLayer<'a>>,
    /// Colours of the surroundings.
    pub theme: Theme,
}

/// A layer of a mold. All of it stands upright, the opening looking along +Z.
#[derive(Debug, Clone, Copy)]
pub struct MoldLayer<'a> {
    /// Height of the layer (mm).
    pub z: f64,
    /// Height of the next layer above, if there is one (mm).
    pub next: Option<f64>,
    /// What is left in it, as far as that is known.
    pub pieces: &'a [&'a UncutPiece],
    /// What no cutter touches of the mold's outline (mm).
    pub segments: &'a [Vec<DVec3>],
    /// Where the mold opens to.
    pub opening: Opening,
}

/// What a click met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoldPart {
    /// The mold, or something else on it.
    Mold,
    /// A region.
    Region(usize),
    /// An electrode where it burns.
    Burn(BurnOf),
}

/// What an object of a scene of a mold is.
pub fn mold_part(id: ObjectId) -> MoldPart {
    match (BurnOf::of(id), id.0.checked_sub(FIRST_REGION)) {
        (Some(burn), _) => MoldPart::Burn(burn),
        (None, Some(i)) => MoldPart::Region(i as usize),
        (None, None) => MoldPart::Mold,
    }
}

/// The scene, in the coordinates of the loaded mesh.
pub fn build_mold(inputs: &MoldScene) -> Scene {
    let mut scene = Scene { triad: false, ..Scene::new(inputs.theme) };
    let mold = Object::new(ObjectId(MOLD), inputs.mold.clone(), STEEL);
    scene.objects.push(mold.with_opacity(inputs.look.opacity()));
    let flat = |id: u32, shape: &Arc<RenderMesh>, colour| {
        let object = Object::new(ObjectId(id), shape.clone(), colour);
        Object { edges: false, ..object }
    };
    scene.objects.extend(inputs.invert.map(|shape| flat(INVERT_FACES, shape, INVERT)));
    if let Some(shape) = inputs.glance {
        scene.objects.push(flat(GLANCE, shape, BAD));
    } else {
        let legend = depth_legend(inputs.deepest);
        for (i, region) in inputs.regions.iter().enumerate().filter(|(i, _)| inputs.shown.get(*i) == Some(&true)) {
            let mut object = flat(FIRST_REGION + i as u32, &region.shape, region_colour(i));
            object.selected = inputs.selected == Some(i);
            let range = [legend.min as f32, legend.max as f32];
            object.values = (inputs.colours == RegionColours::ByDepth && !object.selected).then(|| SurfaceValues {
                values: region.depths.clone(),
                map: legend.map,
                range,
            });
            scene.objects.push(object);
        }
    }
    if let Some(layer) = &inputs.layer {
        let off = OFF * inputs.mold.bounds().size().length();
        let is_below_face = layer.next.is_some_and(|next| next - layer.z < 2.0 * off);
        let z = if is_below_face { layer.z - off } else { layer.z + off };
        let normal = layer.opening.in_mesh(DVec3::Z);
        scene.section = Some(SectionPlane { point: z * normal, normal });
        scene.lines.extend(layer_lines(layer, z, inputs.theme));
    }
    scene.grid = Grid::below(&inputs.mold.bounds());
    scene
}

/// The axes of the work datum of a mold in this box, as a cross: X red, Y green, Z blue.
pub fn datum_lines(datum: &Datum, opening: Opening, mold: &Bounds) -> [LineSet; 3] {
    let length = CROSS * mold.size().length();
    let axes = datum.axes(opening);
    std::array::from_fn(|i| {
        let ends = [-0.25, 1.0].map(|share| datum.origin_mm + share * length * axes[i]);
        LineSet { width_px: 2.5, on_top: true, ..LineSet::new(vec![ends.to_vec()], AXES[i]) }
    })
}

/// Circles, as they can be picked.
pub fn rim_lines(rims: &[Circle], theme: Theme) -> LineSet {
    let round = |rim: &Circle| {
        let (x, y) = rim.normal.any_orthonormal_pair();
        let at = |angle: f64| rim.centre + rim.radius * (angle.cos() * x + angle.sin() * y);
        (0..=48).map(|i| at(f64::from(i) / 48.0 * std::f64::consts::TAU)).collect()
    };
    LineSet { width_px: 3.0, on_top: true, ..LineSet::new(rims.iter().map(round).collect(), theme.accent) }
}

/// The bounds of what is left in a layer, thin, and what no cutter touches of the mold's outline, in red.
fn layer_lines(layer: &MoldLayer, z: f64, theme: Theme) -> [LineSet; 2] {
    let at = |p: DVec2| layer.opening.in_mesh(p.extend(z));
    let closed = |points: &[DVec2]| points.iter().chain(points.first()).map(|p| at(*p)).collect::<Vec<_>>();
    let bounds = layer.pieces.iter().flat_map(|p| &p.boundary).map(|o| closed(o.points())).collect();
    let line = |points: &Vec<DVec3>| points.iter().map(|p| at(p.truncate())).collect::<Vec<_>>();
    let segments = layer.segments.iter().filter(|points| points.len() > 1).map(line).collect();
    let thin = LineSet { width_px: 1.0, on_top: true, ..LineSet::new(bounds, theme.section) };
    [thin, LineSet { width_px: 3.5, on_top: true, ..LineSet::new(segments, BAD) }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use mold::outline::Outline;
    use mold::piece::UncutPiece;

    fn piece(region: u32, off: f64, depth: f32) -> SurfacePiece {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p + off * DVec3::X + 2.0 * DVec3::Z);
        SurfacePiece { corners, face: 0, region, depth: [depth, 0.5 * depth, 0.0] }
    }

    /// Coordinates in OKLab (Ottosson 2020), in which a distance of 0.02 is just seen.
    fn oklab(colour: Colour) -> DVec3 {
        let [r, g, b] = colour.to_linear();
        let cones = [
            0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b,
            0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b,
            0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b,
        ];
        let [l, m, s] = cones.map(f64::cbrt);
        DVec3::new(
            0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
            1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
            0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
        )
    }

    #[test]
    fn thirty_two_regions_are_told_apart_and_from_what_is_selected() {
        let colours: Vec<DVec3> = (0..32).map(|i| oklab(region_colour(i))).collect();
        for (i, colour) in colours.iter().enumerate() {
            for other in &colours[..i] {
                assert!(colour.distance(*other) > 0.08, "{i}");
            }
            for theme in [Theme::DARK, Theme::LIGHT] {
                assert!(colour.distance(oklab(theme.accent)) > 0.12, "{i} is like what is selected");
            }
        }
    }

    #[test]
    fn regions_lie_just_before_the_surface_with_the_depth_of_their_corners() {
        let opening = Opening::PlusX;
        let mesh = Mesh::cuboid(DVec3::new(2.0, 4.0, 4.0));
        let pieces = [piece(1, 0.0, 3.0), piece(1, 1.0, 1.0), piece(7, 0.0, 1.0)];
        let shapes = region_shapes(&mesh, &pieces, 2, opening);
        assert!(shapes[0].shape.is_empty(), "no piece of it, and none of a region that there is not");
        // The corner that both have is one vertex, as deep as the deeper says.
        assert_eq!(*shapes[1].depths, [3.0, 1.5, 0.0, 0.5, 0.0]);
        let bounds = shapes[1].shape.bounds();
        let lift = BEFORE * 6.0;
        assert!((bounds.min.x - (2.0 + lift)).abs() < 1e-6 && (bounds.max.x - (2.0 + lift)).abs() < 1e-6);
        assert!((bounds.max.y - 2.0).abs() < 1e-6, "x of the upright mold is y of the mesh");
    }

    #[test]
    fn a_layer_cuts_the_mold_across_its_opening_and_shows_what_is_not_touched() {
        let mold = Arc::new(RenderMesh::new(&Mesh::cuboid(DVec3::new(2.0, 4.0, 4.0))));
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let boundary = vec![Outline::new(square.clone()).unwrap()];
        let segments = [square.iter().map(|p| p.extend(1.4)).collect(), Vec::new()];
        let pieces = [UncutPiece { boundary, area: 0.5, segments: Vec::new(), depth: 0.2 }];
        let layer =
            MoldLayer { z: 1.5, next: Some(1.6), pieces: &[&pieces[0]], segments: &segments, opening: Opening::PlusX };
        let shapes = region_shapes(mold.source(), &[piece(0, 0.0, 3.0), piece(1, 1.0, 1.0)], 2, Opening::PlusX);
        let inputs = MoldScene {
            mold: &mold,
            regions: &shapes,
            shown: &[false, true],
            colours: RegionColours::ByDepth,
            deepest: 3.0,
            selected: Some(0),
            look: MoldLook::Solid,
            invert: None,
            glance: None,
            layer: Some(layer),
            theme: Theme::DARK,
        };
        let scene = build_mold(&inputs);
        let parts: Vec<MoldPart> = scene.objects.iter().map(|o| mold_part(o.id)).collect();
        assert_eq!(parts, [MoldPart::Mold, MoldPart::Region(1)], "the first is hidden");
        assert!(scene.objects[1].values.is_some());
        let section = scene.section.unwrap();
        assert_eq!(section.normal, DVec3::X);
        assert!(section.point.x > 1.5 && section.point.x < 1.5001);
        let below = MoldLayer { next: Some(1.500_001), ..layer };
        let section = build_mold(&MoldScene { layer: Some(below), ..inputs }).section.unwrap();
        assert!(section.point.x < 1.5, "what lies on the face is not of the layer below it");
        let section = scene.section.unwrap();
        let [bounds, segments] = &scene.lines[..] else { panic!("two sets of lines") };
        assert_eq!((bounds.polylines[0].len(), segments.polylines.len()), (4, 1), "closed, and no line without points");
        assert!(segments.polylines[0].iter().all(|p| (p.x - section.point.x).abs() < 1e-12) && segments.colour == BAD);
    }
}
