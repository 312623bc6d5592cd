//! The axis and the period of a blisk, from its mesh alone.
//!
//! Candidate axes come from `axis`; about each, circles are cut with the mesh (`slices`) and the part of the
//! meridional plane is sought where every circle passes the same number of even gaps whose walls face each
//! other (`period`). The axis is then moved until the walls repeat best: every blade against the mean blade.

pub(crate) mod axis;
pub(crate) mod lattice;
mod period;
mod search_grid;
pub(crate) mod sector;
pub(crate) mod slices;

use std::borrow::Cow;

use glam::{DVec2, DVec3};

pub use axis::Axis;
pub(crate) use period::MOST_KINDS;
pub use period::Repetition;

use self::period::{Blades, Region};
use self::sector::SectorError;
use self::slices::Slices;
use super::by_hand::ByHand;
use super::error::{BliskError, NotChannels};
use super::options::{AxisChoice, AxisLine, AxisName, BliskOptions};
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use task::{Cancel, Task};

/// A wall repeats where it misses the mean one by less than this share of the pitch.
const TOLERANCE: f64 = 0.005;
/// Points that are given lie within so many cells of the bladed region.
const NEAR_CELLS: f64 = 4.0;
/// Share of the walls that repeat, at least, where blades are alike or of few kinds.
const LEAST_REPEAT: f64 = 0.5;
/// RMS distance within which walls repeat well enough about a given line (mm).
const LEAST_RMS: f64 = 1e-3;
/// Share of the RMS distance about a given line that walls repeat within where another axis is clearly better.
const CLEARLY_BETTER: f64 = 0.5;
/// Share of the walls by which more kinds of blades must explain more than fewer.
const CLEARLY: f64 = 0.2;

/// The axis and period of a blisk.
#[derive(Debug, Clone, PartialEq)]
pub struct BliskFrame {
    /// The axis in the coordinates of the mesh.
    pub axis: Axis,
    /// X along the axis, origin at the foot of the mesh's origin, Z as near as possible to the mesh's reference
    /// direction: its +Z, or its +X when the axis is nearest to Z.
    pub frame: Frame,
    /// The blade count and how exactly the blades repeat.
    pub repetition: Repetition,
    /// Position along X and radius of a circle through the middle of the bladed passage (mm).
    pub middle: DVec2,
    /// The axis about which the walls repeat clearly better, where a line was given that they do not repeat so well about.
    pub repeats_about: Option<Axis>,
    /// Assumptions made, in plain sentences.
    pub assumed: Vec<String>,
}

/// Whether the mesh is inside out; [`BliskError::Mesh`] if nothing can be said of it at all.
pub(super) fn is_inside_out(mesh: &Mesh) -> Result<bool, BliskError> {
    if mesh.triangles.is_empty() {
        return Err(BliskError::Mesh("it has no triangles".into()));
    }
    // A kilometre is no blisk, and figures beyond all measure would drown the rest in rounding.
    if let Some(bad) = mesh.vertices.iter().position(|v| !v.is_finite() || v.abs().max_element() > 1e6) {
        return Err(BliskError::Mesh(format!(
            "vertex {bad} is no finite point within 1 km of the origin; check the file and its units"
        )));
    }
    if let Some(bad) = mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= mesh.vertices.len())) {
        return Err(BliskError::Mesh(format!("triangle {bad} names a vertex that does not exist")));
    }
    Ok(mesh.volume() < 0.0)
}

/// A wheel with its axis and blade count.
#[derive(Clone)]
pub(super) struct Wheel<'a> {
    /// Mesh: the given one, or the whole wheel that it is a sector of.
    pub mesh: Cow<'a, Mesh>,
    /// Whether a sector was given.
    pub is_of_sector: bool,
    /// Axis and blade count.
    pub blisk: BliskFrame,
    /// Reason why none was found about a line that is likelier to be the axis, where one was tried before.
    pub likelier: Option<BliskError>,
}

/// Finds the axis and the blade count of `mesh`, which must be oriented outwards, and the whole wheel if it is a sector
/// of one.
///
/// # Errors
/// Every error of [`find_frame`], and [`SectorError`] if the part is a sector that makes no wheel.
pub(super) fn find_wheel<'a>(mesh: &'a Mesh, options: &BliskOptions, task: &Task) -> Result<Wheel<'a>, BliskError> {
    let error = match find_frame(mesh, options, task) {
        Ok((mut blisk, likelier)) => {
            let told = || axis::of_turned_surfaces(mesh, blisk.axis).filter(|turned| *turned != blisk.axis);
            let turned = || told().map(|turned| ("turned surfaces", turned));
            let of_blades = blisk.repeats_about.map(|axis| ("blades", axis));
            if let (AxisChoice::Line(_), Some((what, other))) = (options.axis, of_blades.or_else(turned)) {
                blisk.assumed.push(format!(
                    "The {what} of the mesh have another axis than the one that is given: {other}. Figures and paths are \
                     about the given one."
                ));
            }
            return Ok(Wheel { mesh: Cow::Borrowed(mesh), is_of_sector: false, blisk, likelier });
        }
        Err(BliskError::Cancelled(cancelled)) => return Err(cancelled.into()),
        // Holes all the way round an axis are in no sector.
        Err(error) if has_holes(&error) => return Err(error),
        Err(error) => error,
    };
    match whole_of_sector(mesh, error.axis(), &error, options, &task.cancel)? {
        Some(whole) => wheel_of_sector(mesh, whole, error, options, task),
        None => Err(error),
    }
}

/// Whether `mesh`, refused as a whole wheel for `error` about `axis`, is rather a sector of one about the axis `of_sector`: it
/// does not go all the way round the first one, or more of its surface turns about the other.
fn is_rather_sector(mesh: &Mesh, of_sector: Option<Axis>, axis: Option<Axis>, error: &BliskError) -> bool {
    let turning = axis::Turning::new(mesh);
    let share = |axis: Option<Axis>| axis.map_or(0.0, |axis| turning.share(&axis));
    matches!(error, BliskError::Partial { .. }) || share(of_sector) > share(axis)
}

/// The whole wheel if `mesh` is a sector of one, although as a whole wheel, about `axis`, it is refused for `error`.
///
/// # Errors
/// [`BliskError::Cancelled`], and [`SectorError`] where it is rather a sector.
fn whole_of_sector(
    mesh: &Mesh,
    axis: Option<Axis>,
    error: &BliskError,
    options: &BliskOptions,
    cancel: &Cancel,
) -> Result<Option<sector::Whole>, BliskError> {
    match sector::whole_wheel(mesh, options, cancel) {
        Err(SectorError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(of_sector) if is_rather_sector(mesh, of_sector.axis(), axis, error) => Err(of_sector.into()),
        Err(_) => Ok(None),
        Ok(whole) => Ok(whole),
    }
}

/// The whole wheel if `mesh` is a sector of one, although it was taken for a wheel about `axis`, as a blade alone may be:
/// what was found there was refused for `error`.
///
/// # Errors
/// Those of [`whole_of_sector`].
pub(super) fn find_sector(
    mesh: &Mesh,
    axis: &Axis,
    error: BliskError,
    options: &BliskOptions,
    task: &Task,
) -> Result<Option<Wheel<'static>>, BliskError> {
    let whole = whole_of_sector(mesh, Some(*axis), &error, options, &task.cancel)?;
    match whole.map(|whole| wheel_of_sector(mesh, whole, error, options, task)) {
        Some(Err(BliskError::Cancelled(cancelled))) => Err(cancelled.into()),
        found => Ok(found.and_then(Result::ok)),
    }
}

/// The wheel that was made of the sector `mesh`, which as a whole wheel is refused for `error`.
fn wheel_of_sector(
    mesh: &Mesh,
    whole: sector::Whole,
    error: BliskError,
    options: &BliskOptions,
    task: &Task,
) -> Result<Wheel<'static>, BliskError> {
    let line = AxisLine { direction: whole.axis.direction.into(), point: whole.axis.point.into() };
    let about_line = BliskOptions { axis: AxisChoice::Line(line), ..options.clone() };
    // What only looks like a sector is what it was before.
    let mut blisk = match find_frame(&whole.mesh, &about_line, task).map(|(blisk, _)| blisk) {
        Err(BliskError::Cancelled(cancelled)) => return Err(cancelled.into()),
        // Its copies are as many as its own symmetry allows.
        Ok(blisk) if blisk.repetition.blades.is_multiple_of(whole.copies) => blisk,
        // The surface of a whole wheel goes all the way round.
        Ok(blisk) if matches!(error, BliskError::Partial { .. }) => {
            let (made, counted) = (whole.blades, blisk.repetition.blades);
            return Err(SectorError::Count { made, counted, axis: whole.axis }.into());
        }
        Err(of_whole) if matches!(error, BliskError::Partial { .. }) => return Err(of_whole),
        _ => return Err(error),
    };
    let Repetition { blades, kinds, .. } = blisk.repetition;
    // Its pitch may have been told by every other blade.
    let pitches_held = whole.pitches_held * blades / whole.blades;
    if kinds > 1 && pitches_held < 2 * kinds && options.blades.given().is_none() {
        if !is_rather_sector(mesh, Some(whole.axis), error.axis(), &error) {
            return Err(error);
        }
        return Err(SectorError::Kinds { kinds, seen: pitches_held, axis: whole.axis }.into());
    }
    // Channel 0 is one of those that the sector holds.
    blisk.frame = Frame::from_x_and_z_hint(blisk.axis.point, blisk.axis.direction, whole.middle);
    blisk.assumed.insert(0, whole.assumed(blades));
    Ok(Wheel { mesh: Cow::Owned(whole.mesh), is_of_sector: true, blisk, likelier: None })
}

/// Finds the axis and the blade count of `mesh`, which must be oriented outwards; with them, why nothing was found about
/// the likeliest line, where they are about another.
///
/// # Errors
/// Says what is missing: the part covers no full turn, nothing repeats around any likely axis, or what repeats
/// is no channel between blades. The error is that of the likeliest axis.
fn find_frame(
    mesh: &Mesh,
    options: &BliskOptions,
    task: &Task,
) -> Result<(BliskFrame, Option<BliskError>), BliskError> {
    let mut first_error = None;
    let candidates = candidate_axes(mesh, options);
    for (i, axis) in candidates.iter().enumerate() {
        task.report("axis and blades", i as f64 / candidates.len() as f64, "");
        match about_axis(mesh, *axis, options, &task.cancel) {
            Err(BliskError::Cancelled(c)) => return Err(c.into()),
            // Of what has as many holes as blades are asked for, other axes would tell of something else.
            Err(error) if has_holes(&error) && options.blades.given().is_some() => return Err(error),
            Err(error) => first_error = first_error.or(Some(error)),
            Ok(found) => return Ok((found, first_error)),
        }
    }
    Err(first_error.unwrap_or_else(|| BliskError::Mesh("its surface has no area".into())))
}

/// Whether what repeats around the axis are round holes.
fn has_holes(error: &BliskError) -> bool {
    matches!(error, BliskError::NoChannels { reason: NotChannels::RoundHoles, .. })
}

fn candidate_axes(mesh: &Mesh, options: &BliskOptions) -> Vec<Axis> {
    match options.axis {
        AxisChoice::Line(AxisLine { direction, point }) => vec![Axis::new(point.into(), direction.into())],
        AxisChoice::Named(name) => axis::candidates(mesh, name.direction()),
    }
}

/// The frame along `axis` with its Z near the mesh's reference direction.
pub(super) fn frame_along(axis: &Axis) -> Frame {
    let reference = if axis.major() == 2 { DVec3::X } else { DVec3::Z };
    Frame::from_x_and_z_hint(axis.point, axis.direction, reference)
}

/// The axis of the turned surfaces near `axis`, where they tell one and it has the direction that is asked for.
fn turned_axis(mesh: &Mesh, axis: Axis, name: AxisName) -> Option<Axis> {
    let asked = name.direction();
    axis::of_turned_surfaces(mesh, axis).filter(|turned| asked.is_none_or(|asked| turned.direction == asked))
}

/// Looks for blades about one axis and moves the axis to where they repeat best.
fn about_axis(mesh: &Mesh, axis: Axis, options: &BliskOptions, cancel: &Cancel) -> Result<BliskFrame, BliskError> {
    let covered_deg = axis::covered_angle(mesh, &axis).to_degrees();
    if covered_deg < 350.0 {
        let given = options.axis != AxisChoice::Named(AxisName::Auto);
        return Err(BliskError::Partial { covered_deg, axis, given });
    }
    let slices = Slices::new(mesh.in_frame(&frame_along(&axis)));
    let (region, least_kinds, others) = bladed_region(&slices, mesh, axis, options, cancel)?;
    let middle = region.middle(&slices);
    let circles = region.circles(&slices, 160);
    let count = region.count;
    let tolerance = TOLERANCE * std::f64::consts::TAU * middle.y / count as f64;
    let mut best: Option<(Axis, Repetition)> = None;
    for kinds in period::kinds(count).filter(|kinds| kinds % least_kinds == 0) {
        cancel.check()?;
        let blades = Blades { count, kinds, may_lack: options.blades.given().is_some() };
        let axis = placed(mesh, axis, &circles, blades, options, cancel)?;
        let slices = Slices::new(mesh.in_frame(&frame_along(&axis)));
        let repetition = period::repetition(&slices, &circles, blades, tolerance);
        // More kinds have more freedom: one damaged blade does not make splitters of the others.
        if best.is_none_or(|(_, known)| repetition.matched > known.matched + CLEARLY) {
            best = Some((axis, repetition));
        }
        if repetition.matched >= period::MOST_REPEAT {
            break;
        }
    }
    // Blades of a given number that do not repeat are each of a kind, and tell no axis.
    if options.blades.given().is_some() && best.is_none_or(|(_, known)| known.matched < LEAST_REPEAT) {
        let known = match options.axis {
            AxisChoice::Line(_) => Some(axis),
            AxisChoice::Named(name) => turned_axis(mesh, axis, name),
        };
        let slices = |axis: &Axis| Slices::new(mesh.in_frame(&frame_along(axis)));
        let blades = Blades { count, kinds: count, may_lack: false };
        best = known.map(|axis| (axis, period::repetition(&slices(&axis), &circles, blades, tolerance))).or(best);
    }
    // A wheel is clamped by its turned surfaces: where blades were set aslant they do not tell the axis.
    if let Some((axis, known)) = best
        && let AxisChoice::Named(name) = options.axis
        && let Some(turned) = turned_axis(mesh, axis, name).filter(|turned| *turned != axis)
    {
        let blades = Blades { count, kinds: known.kinds, may_lack: options.blades.given().is_some() };
        let slices = Slices::new(mesh.in_frame(&frame_along(&turned)));
        let repetition = period::repetition(&slices, &circles, blades, tolerance);
        if repetition.matched >= period::MOST_REPEAT {
            best = Some((turned, repetition));
        }
    }
    // What the given line costs: one that is off by little is accepted, but not unsaid.
    let repeats_about = match (options.axis, best) {
        (AxisChoice::Line(_), Some((axis, known))) if known.rms_mm > LEAST_RMS => {
            let blades = Blades { count, kinds: known.kinds, may_lack: options.blades.given().is_some() };
            let free = BliskOptions { axis: AxisChoice::Named(AxisName::Auto), ..options.clone() };
            let free = placed(mesh, axis, &circles, blades, &free, cancel)?;
            let slices = Slices::new(mesh.in_frame(&frame_along(&free)));
            let repetition = period::repetition(&slices, &circles, blades, tolerance);
            (repetition.rms_mm < CLEARLY_BETTER * known.rms_mm).then_some(free)
        }
        _ => None,
    };
    let Some((axis, repetition)) = best.filter(|(_, repetition)| repetition.matched >= LEAST_REPEAT) else {
        return Err(BliskError::NoChannels {
            axis: best.map_or(axis, |(axis, _)| axis),
            count,
            reason: NotChannels::DoNotRepeat,
        });
    };
    let mut assumed = assumptions(&axis, &repetition, options);
    assumed.extend(others.iter().map(|other| {
        let (count, DVec2 { x, y: r }) = (other.count, other.middle(&slices));
        format!(
            "Another row of {count} blades stands about x {x:.1}, r {r:.1} mm: give a point on one of them with \
             blisk.blade_points_mm to plan there."
        )
    }));
    Ok(BliskFrame { axis, frame: frame_along(&axis), repetition, middle, repeats_about, assumed })
}

/// The region whose gaps are channels between blades and have the most wall, with splitters where there are some, how
/// many kinds of blades there are at least, and the regions of other rows of blades.
fn bladed_region(
    slices: &Slices,
    mesh: &Mesh,
    axis: Axis,
    options: &BliskOptions,
    cancel: &Cancel,
) -> Result<(Region, usize, Vec<Region>), BliskError> {
    let wanted = options.blades.given();
    let places = ByHand::new(options, &frame_along(&axis)).places();
    let mut first_objection = None;
    let mut regions = period::regions(slices, wanted, cancel)?;
    let mut tried = regions.len();
    if !places.is_empty() {
        let far = |region: &Region| places.iter().map(|p| region.cells_from(slices, *p)).sum::<f64>();
        regions.sort_by(|a, b| far(a).total_cmp(&far(b)));
        tried = regions.partition_point(|region| far(region) <= NEAR_CELLS * places.len() as f64);
    } else if wanted.is_some() {
        // What may be something else is taken where nothing else is of the number that is given.
        regions.sort_by_key(|region| region.objection.is_some());
    }
    for i in 0..tried {
        // Whoever names points of the passage has seen that there are blades, and so has who names their number where it
        // is not that of holes.
        let may_object =
            |reason: &NotChannels| places.is_empty() && (wanted.is_none() || *reason == NotChannels::RoundHoles);
        match regions[i].objection.filter(may_object) {
            None => {
                let has_more = |other: &Region| {
                    let goes_on = || other.goes_on_into(&regions).into_iter();
                    other.count > regions[i].count
                        && other.is_good_part_of(&regions[i])
                        && goes_on().any(|into| std::ptr::eq(into, &regions[i]))
                        && other.least_kinds(&regions) > 1
                };
                let more = (0..regions.len()).rev().filter(|&k| has_more(&regions[k]));
                let i = more.max_by_key(|&k| regions[k].count).unwrap_or(i);
                let region = regions.swap_remove(i);
                let mut others = if wanted.is_some() { period::regions(slices, None, cancel)? } else { regions };
                let least_kinds = region.least_kinds(&others);
                let is_row = |other: &Region| other.objection.is_none() && other.is_other_row_than(&region, slices);
                others.retain(|other| places.is_empty() && wanted.is_none() && is_row(other));
                return Ok((region, least_kinds, others));
            }
            Some(reason) => first_objection = first_objection.or(Some((regions[i].count, reason))),
        }
    }
    Err(match first_objection {
        Some((count, reason)) => BliskError::NoChannels { axis, count, reason },
        None => BliskError::NoBlades { axis, wanted, closed: mesh.is_watertight() },
    })
}

/// The axis about which the walls along `circles` repeat best, or the one that is given.
fn placed(
    mesh: &Mesh,
    mut axis: Axis,
    circles: &[DVec2],
    blades: Blades,
    options: &BliskOptions,
    cancel: &Cancel,
) -> Result<Axis, BliskError> {
    const MOST_STEPS: usize = 6;
    let AxisChoice::Named(name) = options.axis else { return Ok(axis) };
    let x_mid = circles.iter().map(|c| c.x).sum::<f64>() / circles.len().max(1) as f64;
    let reach = circles.iter().map(|c| c.y).fold(0.0, f64::max);
    for _ in 0..MOST_STEPS {
        cancel.check()?;
        let slices = Slices::new(mesh.in_frame(&frame_along(&axis)));
        let keep_direction = name != AxisName::Auto;
        let Some((point, direction)) = period::better_axis(&slices, circles, blades, x_mid, keep_direction) else {
            break;
        };
        let frame = frame_along(&axis);
        axis = Axis::new(frame.to_parent(point), frame.direction_to_parent(direction));
        if point.y.hypot(point.z) + reach * (direction - DVec3::X).length() < 1e-10 * reach {
            break;
        }
    }
    Ok(axis.snapped(mesh.bounds().size().length()))
}

fn assumptions(axis: &Axis, repetition: &Repetition, options: &BliskOptions) -> Vec<String> {
    let mut assumed = Vec::new();
    match options.axis {
        AxisChoice::Named(AxisName::Auto) => assumed.push(format!("The axis was found from the mesh: {axis}.")),
        AxisChoice::Named(_) => assumed.push(format!("The place of the axis was found from the mesh: {axis}.")),
        AxisChoice::Line(_) => {}
    }
    let Repetition { blades, kinds, tolerance_mm, matched, greatest_mm, .. } = *repetition;
    if options.blades.given().is_none() {
        assumed.push(format!("{blades} blades were counted around the axis."));
    }
    if kinds > 1 && kinds == blades {
        assumed.push(format!("The {blades} blades do not repeat around the axis: every channel is of its own kind."));
    } else if kinds > 1 {
        assumed.push(format!(
            "The blades repeat after every {kinds}, as where splitters stand between main blades: there are {kinds} kinds \
             of channels. Channels whose numbers differ by a multiple of {kinds} are of one kind."
        ));
    }
    // Points beside edges and fillets miss on many meshes; which channels differ is measured by itself.
    if matched < 0.95 {
        assumed.push(format!(
            "Only {:.1} % of the blade walls repeat within {tolerance_mm:.3} mm (greatest miss {greatest_mm:.3} mm): \
             the blades are not all alike.",
            100.0 * matched
        ));
    }
    assumed
}
