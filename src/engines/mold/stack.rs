//! Residual stock of a mold after a library of flat cutters, layer by layer.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;

use rayon::prelude::*;

use super::centre_path::Obstacle;
use super::contact::have_contacts;
use super::cutter::{Cutter, CutterKind};
use super::invert::{InvertFaces, Shadows, base, without_gaps};
use super::layers::{FirstLayers, LayerFigures, LayerSettings, Tolerance, first_layers, is_bent};
use super::outline::Outline;
use super::piece::{UncutPiece, clipped, intersected};
use super::plane::{self, Shape};
use super::region::have_partners;
use super::section::{Section, outline_error, sections};
use super::uncut_layer::uncut_with_holder;
use super::warning::MoldWarning;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled, Task};

/// Share of an outline set's extent in area up to which two ways to reckon its area agree.
const SAME_AREA: f64 = 1e-9;

/// Residual stock just above one height.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncutLayer {
    /// The height (mm).
    pub z: f64,
    /// The pieces.
    pub pieces: Vec<UncutPiece>,
}

/// Residual stock of a mold in all layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncutStack {
    /// Layers, rising.
    pub layers: Vec<UncutLayer>,
    /// The faces that no cutter from above reaches.
    pub invert: InvertFaces,
    /// Warnings on the mold.
    pub warnings: Vec<MoldWarning>,
}

/// Residual stock of a layer after further cutters, from the obstacles in their way there.
pub type Others<'a> = &'a (dyn Fn(&Section) -> Vec<UncutPiece> + Sync);

/// Residual stock of `mesh`, whose opening looks along +Z, after every one of the flat cutters among `cutters`, and of
/// `others` where there are any. Without any cutter nothing is found. The settings must have been validated.
///
/// Cutters are taken for smaller by [`outline_error`] on the radius, so that one that is as wide as a slot fits into it.
///
/// # Errors
/// [`Cancelled`].
pub fn uncut_stack(
    mesh: &Mesh,
    cutters: &[&Cutter],
    others: Option<Others>,
    settings: &LayerSettings,
    task: &Task,
) -> Result<UncutStack, Cancelled> {
    let flats: Vec<&Cutter> = cutters.iter().copied().filter(|c| c.kind() == CutterKind::Flat).collect();
    let reaches: Vec<f64> = flats.iter().filter_map(|c| wide_holder(c)).map(|(_, reach)| reach).collect();
    let mut shadows = Shadows::new(mesh);
    let silhouette = silhouette(mesh, &mut shadows, &task.cancel)?;
    let fit = outline_error(mesh);
    let has_contacts = have_contacts(mesh);
    let mut work =
        Work { mesh, flats, fit, has_contacts, others, settings, shadows, silhouette, seen: Seen::default() };
    let FirstLayers { heights, floors } = first_layers(mesh, &reaches, settings);
    let mut layers: Vec<UncutLayer> = Vec::new();
    let mut wanted = heights;
    let mut round = 0;
    while !wanted.is_empty() {
        task.report("layers", 1.0 - 0.5f64.powi(round), &format!("{} layers", layers.len() + wanted.len()));
        layers.extend(work.layers(&wanted, &task.cancel)?);
        layers.sort_by(|a, b| a.z.total_cmp(&b.z));
        round += 1;
        wanted = if settings.is_fixed { Vec::new() } else { halves(&layers, &floors, settings) };
        if layers.len() + wanted.len() > settings.most_layers {
            work.seen.warnings.push(MoldWarning::LayerLimit { most: settings.most_layers });
            break;
        }
    }
    task.report("layers", 1.0, &format!("{} layers", layers.len()));
    let Work { shadows, seen, .. } = work;
    Ok(UncutStack { warnings: seen.warnings(&layers), layers, invert: shadows.faces().clone() })
}

/// Silhouette of the mold seen from above, holes through it included; outside there is nothing to cut.
fn silhouette(mesh: &Mesh, shadows: &mut Shadows, cancel: &Cancel) -> Result<Vec<Outline>, Cancelled> {
    // Below the top of the base there is only a part of it where it lies aslant.
    let mut lowest = sections(mesh, &[base(mesh)], cancel)?;
    shadows.cast(&mut lowest, cancel)?;
    let outlines = lowest.into_iter().filter(|s| s.open.is_empty()).flat_map(|s| s.outlines);
    let outer: Vec<Outline> = outlines.filter(|o| o.area() > 0.0).collect();
    Ok(plane::outlines(plane::union(&outer, &[])))
}

/// The holder of a cutter if it can meet what the cutter does not: its radius and the reach (mm).
fn wide_holder(cutter: &Cutter) -> Option<(f64, f64)> {
    cutter.holder().filter(|(radius, _)| *radius > cutter.radius())
}

/// Middles of slabs that are not what the layers around them predict.
fn halves(layers: &[UncutLayer], floors: &[f64], settings: &LayerSettings) -> Vec<f64> {
    let figures: Vec<LayerFigures> = layers.iter().map(UncutLayer::figures).collect();
    let n = layers.len();
    // Slabs across a horizontal face have nothing in them.
    let spans = |i: usize| {
        let at = floors.partition_point(|f| *f <= layers[i].z);
        floors.get(at).is_none_or(|f| *f > layers[i + 1].z)
    };
    let slabs: Vec<bool> = (0..n.saturating_sub(1)).map(spans).collect();
    let tolerance = Tolerance::of(&figures, settings);
    let is_wide = |i: usize| figures[i + 1].z - figures[i].z > settings.least_spacing_mm;
    let bent: Vec<bool> = (0..n)
        .map(|i| i > 0 && i + 1 < n && slabs[i - 1] && slabs[i])
        .enumerate()
        .map(|(i, inner)| inner && is_bent([figures[i - 1], figures[i], figures[i + 1]], &tolerance))
        .collect();
    let is_halved = |&i: &usize| {
        slabs[i]
            && is_wide(i)
            && (bent[i] || bent[i + 1] || !have_partners(&layers[i], &layers[i + 1], tolerance.counted))
    };
    let chosen: Vec<usize> = (0..slabs.len()).into_par_iter().filter(is_halved).collect();
    chosen.into_iter().map(|i| 0.5 * (figures[i].z + figures[i + 1].z)).collect()
}

impl UncutLayer {
    /// Figures of the pieces, but for those between facets, which come and go from layer to layer.
    fn figures(&self) -> LayerFigures {
        let pieces = || self.pieces.iter().filter(|p| !p.is_shallow());
        LayerFigures {
            z: self.z,
            count: pieces().count(),
            area: pieces().map(|p| p.area).sum(),
            length: pieces().map(UncutPiece::segment_length).sum(),
        }
    }
}

struct Work<'a> {
    mesh: &'a Mesh,
    flats: Vec<&'a Cutter>,
    /// How much smaller than it is a radius is taken (mm).
    fit: f64,
    /// Whether solids of the mold may touch.
    has_contacts: bool,
    others: Option<Others<'a>>,
    settings: &'a LayerSettings,
    shadows: Shadows<'a>,
    silhouette: Vec<Outline>,
    seen: Seen,
}

impl Work<'_> {
    fn layers(&mut self, heights: &[f64], cancel: &Cancel) -> Result<Vec<UncutLayer>, Cancelled> {
        let raised = self.flats.iter().filter_map(|c| wide_holder(c)).map(|(_, reach)| reach);
        let mut all = heights.to_vec();
        raised.for_each(|reach| all.extend(heights.iter().map(|z| z + reach)));
        all.sort_by(f64::total_cmp);
        all.dedup();
        let mut sections = sections(self.mesh, &all, cancel)?;
        let inside_out: Vec<bool> =
            sections.par_iter_mut().map(|s| uncross(s, self.has_contacts.then_some(self.fit))).collect();
        self.seen.note(&sections, &inside_out, heights);
        self.shadows.cast(&mut sections, cancel)?;
        // Metal over an opening at the bottom is a floor: an opening is what is open all the way up.
        self.seen.note_openings(&sections, heights);
        let at: HashMap<u64, usize> = all.iter().enumerate().map(|(i, z)| (z.to_bits(), i)).collect();
        let section = |z: f64| at.get(&z.to_bits()).map(|&i| &sections[i]);
        let left = |z: &f64| {
            cancel.check()?;
            let pieces = section(*z).map(|own| self.left(own, &section)).unwrap_or_default();
            Ok(UncutLayer { z: *z, pieces })
        };
        heights.par_iter().map(left).collect()
    }

    /// Residual stock of a layer after all cutters.
    fn left<'s>(&self, own: &Section, section: &(impl Fn(f64) -> Option<&'s Section> + Sync)) -> Vec<UncutPiece> {
        let tolerance = self.settings.depth_tolerance_mm;
        // Never to nothing, however far from its origin a mold lies.
        let fitting = |radius: f64| (radius - self.fit).max(0.5 * radius);
        let by_flat = |cutter: &&Cutter| {
            let high = wide_holder(cutter).and_then(|(radius, reach)| Some((fitting(radius), section(own.z + reach)?)));
            let holder = high.map(|(distance, high)| Obstacle { outlines: &high.outlines, distance });
            uncut_with_holder(&own.outlines, fitting(cutter.radius()), holder, tolerance)
        };
        let others = self.others.map(|others| others(own));
        let left = intersected(self.flats.iter().map(by_flat).chain(others));
        if self.silhouette.is_empty() { left } else { clipped(left, &self.silhouette) }
    }
}

/// Makes outlines that cross each other, or may touch, the boundary of all that they enclose; whether some of them
/// enclose something from the wrong side, as a surface that is inside out does. Solids that reach into each other do
/// not: what both enclose is material as well. Those that may touch are off by `touching` (mm).
fn uncross(section: &mut Section, touching: Option<f64>) -> bool {
    // Where outlines are missing those that are there say no more than themselves.
    if section.outlines.is_empty() || !section.open.is_empty() {
        return false;
    }
    let [low, high] = plane::extent(&section.outlines);
    let area = |shapes: &[Shape]| shapes.iter().map(|shape| plane::area(shape)).sum::<f64>();
    let covered = plane::union(&section.outlines, &[]);
    // Along a contact they cross by rounding.
    let along = touching.map_or(0.0, |error| error * section.outlines.iter().map(Outline::length).sum::<f64>());
    let rounding = SAME_AREA * (high - low).element_product() + 1e-6 + along;
    let do_cross = (area(&covered) - plane::area(&section.outlines)).abs() > rounding;
    let is_inside_out = do_cross && {
        let turned: Vec<Outline> = section.outlines.iter().map(Outline::reversed).collect();
        area(&plane::union(&turned, &[])) > rounding
    };
    if do_cross || touching.is_some() {
        section.outlines = covered.into_iter().flatten().collect();
    }
    // Solids that touch are a hair apart in single precision.
    if touching.is_some() {
        section.outlines = without_gaps(&section.outlines);
    }
    is_inside_out
}

/// Observations of the mold on the way.
#[derive(Default)]
struct Seen {
    warnings: Vec<MoldWarning>,
    has_material: bool,
    /// The openings of the lowest section: its height and their area.
    openings: Option<(f64, f64)>,
    open: Vec<(f64, [f64; 2])>,
    inside_out: Vec<f64>,
}

impl Seen {
    fn note(&mut self, sections: &[Section], inside_out: &[bool], heights: &[f64]) {
        for (section, is_turned) in sections.iter().zip(inside_out).filter(|(s, _)| heights.contains(&s.z)) {
            let z = section.z;
            self.has_material |= !(section.outlines.is_empty() && section.open.is_empty());
            self.open.extend(section.open.first().map(|[end, _]| (z, end.to_array())));
            self.inside_out.extend(is_turned.then_some(z));
        }
    }

    /// Notes the openings of the lowest of `sections`, which have the shadow of what lies above them.
    fn note_openings(&mut self, sections: &[Section], heights: &[f64]) {
        for section in sections.iter().filter(|s| heights.contains(&s.z)) {
            if self.openings.is_none_or(|(lowest, _)| section.z < lowest) {
                let holes = section.outlines.iter().map(Outline::area).filter(|a| *a < 0.0);
                self.openings = Some((section.z, -holes.sum::<f64>()));
            }
        }
    }

    fn warnings(self, layers: &[UncutLayer]) -> Vec<MoldWarning> {
        let Self { mut warnings, has_material, openings, mut open, mut inside_out } = self;
        if !has_material {
            warnings.push(MoldWarning::Empty);
        }
        open.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some((from, place)), Some((to, _))) = (open.first(), open.last()) {
            warnings.push(MoldWarning::Open { layers: open.len(), from: *from, to: *to, place: *place });
        }
        inside_out.sort_by(f64::total_cmp);
        if let (Some(&from), Some(&to)) = (inside_out.first(), inside_out.last()) {
            warnings.push(MoldWarning::InsideOut { layers: inside_out.len(), from, to });
        }
        warnings.extend(openings.filter(|(_, area)| *area > 0.0).map(|(_, area)| MoldWarning::NoFloor { area }));
        let shallow = || layers.iter().flat_map(|l| &l.pieces).filter(|p| p.is_shallow());
        let depth = shallow().map(|p| p.depth).fold(0.0, f64::max);
        warnings.extend((depth > 0.0).then(|| MoldWarning::ShallowCorners { pieces: shallow().count(), depth }));
        warnings
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::{frame, pocket, polygon, rectangle, with};
    use crate::region::{LayerRegion, regions};

    fn stack(mesh: &Mesh, cutters: &[Cutter], settings: &LayerSettings) -> UncutStack {
        let cutters: Vec<&Cutter> = cutters.iter().collect();
        uncut_stack(mesh, &cutters, None, settings, &Task::default()).unwrap()
    }

    fn found(mesh: &Mesh, cutters: &[Cutter]) -> (Vec<LayerRegion>, f64) {
        let regions = regions(&stack(mesh, cutters, &LayerSettings::default()).layers, 1e-3);
        let volume = regions.iter().map(|r| r.volume).sum();
        (regions, volume)
    }

    fn is_near(value: f64, exact: f64) -> bool {
        (value / exact - 1.0).abs() < 1e-3
    }

    #[test]
    fn upright_corners_keep_the_square_less_the_quarter_disc_over_their_height() {
        let mesh = pocket(&rectangle(20.0, 16.0), &rectangle(12.0, 9.0), &rectangle(12.0, 9.0), [10.0, 8.0]);
        for radius in [0.5, 2.0] {
            let (regions, volume) = found(&mesh, &[Cutter::flat(radius)]);
            assert!(regions.len() == 4 && is_near(volume, (4.0 - PI) * radius * radius * 8.0), "{volume}");
            for region in regions {
                assert!((region.height - 8.0).abs() < 1e-5 && (region.bounds.max.z - 10.0).abs() < 1e-5);
                assert!(is_near(region.plan_area, (1.0 - PI / 4.0) * radius * radius));
                assert!(is_near(region.corner_depth, (2f64.sqrt() - 1.0) * radius));
            }
        }
    }

    /// The corners of a section do not change with the draft, they only wander.
    #[test]
    fn drafted_corners_keep_as_much_as_upright_ones() {
        for degrees in [1.0f64, 3.0, 40.0] {
            let wander = 2.0 * 6.0 * degrees.to_radians().tan();
            let mouth = rectangle(12.0 + wander, 12.0 + wander);
            let mesh = pocket(&rectangle(40.0, 40.0), &mouth, &rectangle(12.0, 12.0), [10.0, 6.0]);
            let (regions, volume) = found(&mesh, &[Cutter::flat(1.0)]);
            assert!(regions.len() == 4 && is_near(volume, (4.0 - PI) * 6.0), "{degrees}: {} {volume}", regions.len());
        }
    }

    #[test]
    fn a_groove_is_left_up_to_where_the_disc_fits_in() {
        let (long, deep, radius) = (10.0, 3.0, 1.0);
        for degrees in [30.0f64, 45.0] {
            let (tan, cot) = (degrees.to_radians().tan(), 1.0 / degrees.to_radians().tan());
            let mouth = rectangle(2.0 * deep * tan, long);
            let mesh = pocket(&rectangle(20.0, 20.0), &mouth, &rectangle(0.0, long), [5.0, deep]);
            let (regions, volume) = found(&mesh, &[Cutter::flat(radius)]);
            // Above that, the corners at both ends.
            let exact = long * radius * radius * cot + (4.0 - PI) * radius * radius * (deep - radius * cot);
            assert!(regions.len() == 1 && is_near(volume, exact), "{degrees}: {} {volume} {exact}", regions.len());
        }
    }

    /// A blind slot and a square hole as wide as the cutter keep their corners only, however they lie, as files in
    /// single precision have them.
    #[test]
    fn a_cutter_fits_into_what_is_as_wide_as_itself() {
        for (radius, long, far) in [(1.0, 20.0, 0.0), (1.0, 2.0, 0.0), (0.5, 7.0, 900.0), (6.0, 12.0, 40.0)] {
            let hole = rectangle(long, 2.0 * radius);
            let mesh = pocket(&rectangle(40.0, 40.0), &hole, &hole, [15.0, 6.0]);
            let exact = (4.0 - PI) * radius * radius * 6.0;
            for degrees in (0..180).step_by(7).map(f64::from) {
                let turn = DVec2::from_angle(degrees.to_radians());
                let turned = mesh.mapped(|p| {
                    let p = turn.rotate(p.truncate()).extend(p.z) + DVec3::new(far, -far, 0.3 * far);
                    DVec3::from(p.to_array().map(|v| f64::from(v as f32)))
                });
                let (regions, volume) = found(&turned, &[Cutter::flat(radius)]);
                assert!(is_near(volume, exact), "{radius} {degrees}: {volume} {exact}, {} regions", regions.len());
                // What is narrower by more than the file's rounding is left whole.
                let (_, whole) = found(&turned, &[Cutter::flat(radius + 2.0 * outline_error(&turned))]);
                assert!(is_near(whole, 2.0 * radius * long * 6.0), "{radius} {degrees}: {whole}");
            }
        }
    }

    /// Where solids touch there is no wall: a rib of three that stand side by side on a block is one.
    #[test]
    fn solids_that_touch_are_one() {
        let block = Mesh::cuboid(DVec3::new(30.0, 20.0, 5.0));
        let on = |size: [f64; 2], at: [f64; 2]| {
            let part = Mesh::cuboid(DVec3::new(size[0], size[1], 4.0));
            part.mapped(|p| p + DVec3::new(at[0], at[1], 5.0))
        };
        // An L: its inner corner is between two of the solids.
        let ribs = [on([4.0, 3.0], [5.0, 5.0]), on([8.0, 3.0], [9.0, 5.0]), on([4.0, 9.0], [5.0, 8.0])];
        let mesh = ribs.iter().fold(block, |all, rib| with(&all, rib));
        for degrees in [0.0f64, 33.7, 61.0] {
            let turn = DVec2::from_angle(degrees.to_radians());
            let turned = mesh.mapped(|p| turn.rotate(p.truncate()).extend(p.z).as_vec3().as_dvec3());
            let (regions, volume) = found(&turned, &[Cutter::flat(1.0)]);
            assert!(regions.len() == 1 && is_near(volume, (1.0 - PI / 4.0) * 4.0), "{degrees}: {volume} {regions:?}");
        }
    }

    /// A dish of radius rho keeps a disc of the cutter's radius at its bottom, R^2 / (2 rho) high.
    #[test]
    fn the_sag_of_a_hollow_floor_is_found() {
        let (n, rings, rho) = (96, 24, 60.0f64);
        let across = 6.0;
        let ring = |k: usize| polygon(n, across * k as f64 / rings as f64);
        let height = |k: usize| 5.0 + rho - (rho * rho - (across * k as f64 / rings as f64).powi(2)).sqrt();
        let levels: Vec<(Vec<DVec2>, f64)> = (1..=rings).rev().map(|k| (ring(k), height(k))).collect();
        let mesh = crate::fixtures::dish(&polygon(n, 10.0), &levels, 5.0);
        assert!(mesh.is_watertight());
        let (regions, volume) = found(&mesh, &[Cutter::flat(2.0)]);
        // Half of the cylinder around the paraboloid; chords between the rings take some of it.
        let exact = PI * 4.0 * (4.0 / (2.0 * rho)) / 2.0;
        let deep = regions.iter().find(|r| r.bounds.min.z < 5.01).unwrap();
        assert!((deep.volume / exact - 1.0).abs() < 0.05 && (volume / exact - 1.0).abs() < 0.05, "{volume} {exact}");
        assert!((deep.height - 4.0 / (2.0 * rho)).abs() < 3e-3, "{}", deep.height);
    }

    #[test]
    fn a_pocket_under_a_lid_is_what_is_seen_from_above() {
        let sides = rectangle(12.0, 12.0);
        let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 8.0]);
        let lid = Mesh::cuboid(DVec3::new(8.0, 16.0, 1.0)).mapped(|p| p + DVec3::new(-8.0, -8.0, 10.0));
        let mesh = with(&mesh, &lid);
        let stack = stack(&mesh, &[Cutter::flat(1.0)], &LayerSettings::default());
        assert!((stack.invert.area - 128.0).abs() < 1e-6);
        let regions = regions(&stack.layers, 1e-3);
        // What is open is 6 x 12 mm; the lid's own corners on the block's top are no corners of the pocket.
        let volume: f64 = regions.iter().map(|r| r.volume).sum();
        assert!(regions.len() == 4 && is_near(volume, (4.0 - PI) * 8.0), "{} {volume}", regions.len());
        assert!(regions.iter().all(|r| r.bounds.min.x > -1e-4 && r.bounds.max.x < 6.0 + 1e-4));
    }

    #[test]
    fn a_short_cutter_leaves_what_its_holder_cannot_come_near_to() {
        let (wide, long) = (24.0, 18.0);
        let sides = rectangle(wide, long);
        let mesh = pocket(&rectangle(40.0, 40.0), &sides, &sides, [10.0, 8.0]);
        let short = Cutter { reach_mm: Some(3.0), holder_diameter_mm: Some(8.0), ..Cutter::flat(1.0) };
        let (regions, volume) = found(&mesh, std::slice::from_ref(&short));
        // Above 7 mm the holder is over the block and only the corners stay; below the centre keeps 4 mm off the walls,
        // and the cutter comes to 3 mm from them.
        let (a, b) = (wide - 8.0, long - 8.0);
        let ring = wide * long - (a * b + 2.0 * (a + b) + PI);
        let exact = 5.0 * ring + 3.0 * (4.0 - PI);
        assert!(regions.len() == 1 && is_near(volume, exact), "{} {volume} {exact}", regions.len());
        // A longer but thicker cutter leaves the corners of its own down there.
        let (regions, both) = found(&mesh, &[short, Cutter::flat(2.0)]);
        let exact = 5.0 * 4.0 * (4.0 - PI) + 3.0 * (4.0 - PI);
        assert!(regions.len() == 4 && is_near(both, exact), "{} {both} {exact}", regions.len());
    }

    #[test]
    fn what_is_wrong_with_a_mold_is_said() {
        let settings = LayerSettings { is_fixed: true, spacing_mm: 2.0, ..LayerSettings::default() };
        let warnings = |mesh: &Mesh| stack(mesh, &[Cutter::flat(1.0)], &settings).warnings;
        let sides = rectangle(12.0, 12.0);
        let whole = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 8.0]);
        assert_eq!(warnings(&whole), []);
        assert_eq!(warnings(&Mesh::default()), [MoldWarning::Empty]);
        let open = Mesh { triangles: whole.triangles[2..].to_vec(), ..whole.clone() };
        assert!(matches!(warnings(&open)[..], [MoldWarning::Open { .. }]), "{:?}", warnings(&open));
        let second = Mesh::cuboid(DVec3::splat(6.0)).mapped(|p| p + DVec3::new(-9.0, -9.0, 1.0));
        assert_eq!(warnings(&with(&whole, &second)), [], "a solid that reaches into another");
        let inside_out = Mesh { triangles: second.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(), ..second };
        assert!(matches!(warnings(&with(&whole, &inside_out))[..], [MoldWarning::InsideOut { .. }]));
        let through = frame(&rectangle(20.0, 20.0), &sides, 5.0);
        assert!(matches!(warnings(&through)[..], [MoldWarning::NoFloor { area }] if (area - 144.0).abs() < 1e-6));
        // A pocket that opens downwards has metal over it: nothing passes through.
        assert_eq!(warnings(&whole.mapped(|p| DVec3::new(p.x, -p.y, -p.z))), []);
        // A round pocket of 24 facets: each corner is R (1 / cos 7.5 degrees - 1) deep.
        let round = polygon(24, 8.0);
        let faceted = warnings(&pocket(&polygon(24, 12.0), &round, &round, [10.0, 8.0]));
        let deep = 1.0 / 7.5f64.to_radians().cos() - 1.0;
        let [MoldWarning::ShallowCorners { depth, .. }] = faceted[..] else { panic!("{faceted:?}") };
        assert!((depth - deep).abs() < 1e-6, "{depth} {deep}");
    }

    #[test]
    fn as_many_threads_as_may_be_find_the_same() {
        let mesh = pocket(&rectangle(20.0, 20.0), &rectangle(12.0, 9.0), &rectangle(9.0, 5.0), [10.0, 8.0]);
        let short = Cutter { reach_mm: Some(4.0), holder_diameter_mm: Some(6.0), ..Cutter::flat(0.5) };
        let cutters = [Cutter::flat(2.0), short];
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| stack(&mesh, &cutters, &LayerSettings { is_fixed: true, ..LayerSettings::default() }))
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_raised_flag_stops_it() {
        let cancel = Cancel::default();
        cancel.cancel();
        let mesh = Mesh::cuboid(DVec3::ONE);
        let cutter = Cutter::flat(1.0);
        let settings = LayerSettings::default();
        assert_eq!(uncut_stack(&mesh, &[&cutter], None, &settings, &Task::silent(&cancel)), Err(Cancelled));
    }

    /// Every triangle in three, in another order.
    fn split(mesh: &Mesh) -> Mesh {
        let mut split = Mesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
        for (i, &[a, b, c]) in mesh.triangles.iter().enumerate().rev() {
            let middle = split.vertices.len() as u32;
            split.vertices.push(mesh.corners(i).iter().sum::<DVec3>() / 3.0);
            split.triangles.extend([[b, c, middle], [middle, a, b], [c, a, middle]]);
        }
        split
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn turning_moving_and_splitting_change_nothing_and_larger_cutters_leave_more(
            mouth in prop::array::uniform2(4.0..12.0f64), share in 0.4..1.0f64, deep in 1.0..6.0f64,
            angle in -3.0..3.0f64, shift in prop::array::uniform3(-100.0..100.0f64), radius in 0.3..2.5f64,
        ) {
            let settings = LayerSettings { is_fixed: true, spacing_mm: 1.0, ..LayerSettings::default() };
            let [x, y] = mouth;
            let mesh = pocket(&rectangle(20.0, 20.0), &rectangle(x, y), &rectangle(share * x, share * y), [8.0, deep]);
            let figures = |mesh: &Mesh, radius: f64| {
                let regions = regions(&stack(mesh, &[Cutter::flat(radius)], &settings).layers, 1e-3);
                let volume: f64 = regions.iter().map(|r| r.volume).sum();
                (regions.len(), volume)
            };
            let (count, volume) = figures(&mesh, radius);
            let turn = DVec2::from_angle(angle);
            let moved = mesh.mapped(|p| turn.rotate(p.truncate()).extend(p.z) + DVec3::from(shift));
            for other in [&moved, &split(&mesh), &split(&moved)] {
                let (same_count, same) = figures(other, radius);
                prop_assert_eq!(same_count, count);
                prop_assert!((same - volume).abs() < 1e-4 * volume + 1e-6, "{} {}", same, volume);
            }
            prop_assert!(figures(&mesh, 1.2 * radius).1 >= volume - 1e-9);
        }

        #[test]
        fn shorter_reaches_and_wider_holders_leave_more(
            mouth in prop::array::uniform2(8.0..16.0f64), share in 0.5..1.0f64, reach in 1.0..5.0f64,
            holder in 0.6..4.0f64, island in 1.0..3.0f64,
        ) {
            let settings = LayerSettings { is_fixed: true, spacing_mm: 1.5, ..LayerSettings::default() };
            let [x, y] = mouth;
            let mesh = pocket(&rectangle(24.0, 20.0), &rectangle(x, y), &rectangle(share * x, share * y), [8.0, 6.0]);
            // A post in the pocket, on its floor.
            let post = Mesh::cuboid(DVec3::new(island, island, 6.5)).mapped(|p| p + DVec3::new(-1.0, 0.0, 1.0));
            let mesh = with(&mesh, &post);
            let area = |reach: f64, holder: f64| {
                let diameter = Some(2.0 * holder);
                let cutter = Cutter { reach_mm: Some(reach), holder_diameter_mm: diameter, ..Cutter::flat(0.5) };
                let layers = stack(&mesh, &[cutter], &settings).layers;
                // Heights differ where the reach does: those that both have.
                let areas = layers.into_iter().map(|l| (l.z.to_bits(), l.pieces.iter().map(|p| p.area).sum::<f64>()));
                areas.collect::<HashMap<u64, f64>>()
            };
            let base = area(reach, holder);
            let free = area(20.0, 0.5);
            for (more, less) in [(&base, &free), (&area(reach, 1.3 * holder), &base), (&area(0.7 * reach, holder), &base)] {
                let both: Vec<(f64, f64)> = more.iter().filter_map(|(z, a)| Some((*a, *less.get(z)?))).collect();
                prop_assert!(both.len() > 4);
                prop_assert!(both.iter().all(|(more, less)| *more >= less - 1e-3 * less - 1e-6), "{:?}", both);
            }
        }
    }

    /// In single precision the base lies a hair aslant, and solids that touch are a hair apart or in each other.
    #[test]
    fn solids_in_a_turned_mold_touching_or_above_it_keep_what_the_pocket_does() {
        let sides = rectangle(20.0, 14.0);
        let base = pocket(&rectangle(40.0, 30.0), &sides, &sides, [15.0, 8.0]);
        let beside = |size: DVec3, low: DVec3| {
            let solid = Mesh::cuboid(size);
            with(&base, &solid.mapped(|p| p - solid.bounds().min + low))
        };
        // One fills a side of the pocket, so that the corners there begin and end at its top; another is in the air.
        let rib = beside(DVec3::new(3.0, 14.0, 5.0), DVec3::new(-10.0, -7.0, 7.0));
        let hanging = beside(DVec3::new(2.0, 3.0, 1.0), DVec3::new(-1.0, -1.0, 11.0));
        let exact = (4.0 - PI) * 8.0;
        let vectors = [[0.053228, -0.471453, 0.880283], [0.5, 0.3, 0.8], [-0.7, 0.2, 0.4]];
        for (mesh, count) in [(&rib, 6), (&hanging, 4)] {
            for (k, vector) in vectors.into_iter().enumerate() {
                let opening = crate::opening::Opening::along(vector.into()).unwrap();
                let turn = glam::DMat3::from_rotation_z(0.4 * k as f64);
                let filed = mesh.mapped(|p| (opening.in_mesh(turn * p) + DVec3::splat(7.3)).as_vec3().as_dvec3());
                let upright = opening.upright_mesh(&filed);
                let (regions, volume) = found(&upright, &[Cutter::flat(1.0)]);
                assert!(regions.len() == count && is_near(volume, exact), "{vector:?}: {} {volume}", regions.len());
                let warnings = stack(&upright, &[Cutter::flat(1.0)], &LayerSettings::default()).warnings;
                assert!(!warnings.iter().any(MoldWarning::is_of_surface), "{vector:?}: {warnings:?}");
            }
        }
    }
}
