//! The user's changes to the division of a region.

use glam::{DVec2, DVec3};

use super::division::{Cut, DivisionSettings, Part, cut_along, whole};
use super::params::Edit;
use super::tip::{Burned, SKIN, TipError};
use crate::mold::outline::Outline;
use crate::mold::plane;

/// What a cut leaves between two parts at most (mm).
const HAIR: f64 = 1e-3;

/// Makes a change to the parts of a region; whether it meets them. `plan` takes a place of the upright mold to the plan of
/// the burn frame.
///
/// # Errors
/// [`TipError`].
pub(super) fn apply(
    burned: &Burned,
    tree: &mut Part,
    edit: &Edit,
    plan: impl Fn(DVec3) -> DVec2,
    settings: &DivisionSettings,
) -> Result<bool, TipError> {
    match edit {
        Edit::Split { line } => {
            let [a, b] = line.map(plan);
            split(burned, tree, [a, b], settings)
        }
        Edit::Merge { places } => {
            let [a, b] = places.map(plan);
            merge(burned, tree, [a, b])
        }
        Edit::Make { .. } | Edit::Burn { .. } => Ok(false),
    }
}

/// Cuts the part that holds the middle of a line along it.
fn split(burned: &Burned, tree: &mut Part, [a, b]: [DVec2; 2], settings: &DivisionSettings) -> Result<bool, TipError> {
    let (through, outward) = (a.midpoint(b), (b - a).perp().normalize_or_zero());
    let held = holder(tree, through).filter(|_| outward != DVec2::ZERO);
    let Some(part) = held.and_then(|way| at(tree, &way)) else { return Ok(false) };
    let cut = Cut { through, outward, overlaps: true };
    let (halves, _) = cut_along(&part.footprint, &cut, settings);
    if halves.len() < 2 {
        return Ok(false);
    }
    let halves = halves.into_iter().map(|f| whole(burned, f)).collect::<Result<Vec<_>, _>>()?;
    part.divided = Some((cut, halves));
    Ok(true)
}

/// Makes the parts that hold two places one, which stands where the first of them stood.
fn merge(burned: &Burned, tree: &mut Part, places: [DVec2; 2]) -> Result<bool, TipError> {
    let [Some(a), Some(b)] = places.map(|p| holder(tree, p)) else { return Ok(false) };
    if a == b {
        return Ok(false);
    }
    let (first, second) = if a < b { (a, b) } else { (b, a) };
    let Some(other) = at(tree, &second).map(|part| part.footprint.clone()) else { return Ok(false) };
    let Some(one) = at(tree, &first) else { return Ok(false) };
    let flat = |shapes: Vec<plane::Shape>| shapes.into_iter().flatten().collect::<Vec<Outline>>();
    let joined = |x: &[Outline], y: &[Outline]| flat(plane::union(x, y));
    let mut footprint = one.footprint.clone();
    // A hair between the two, which a cut leaves, is closed.
    let free = joined(&footprint.free, &other.free);
    footprint.free = flat(plane::grown(&flat(plane::grown(&free, HAIR)), -HAIR));
    footprint.outlines = flat(plane::grown(&footprint.free, SKIN));
    footprint.region = joined(&footprint.region, &other.region);
    *one = whole(burned, footprint)?;
    remove(tree, &second);
    Ok(true)
}

/// The way to the undivided part that holds a point of the region itself: a neighbour's margin may reach there too.
fn holder(tree: &Part, p: DVec2) -> Option<Vec<usize>> {
    let Some((_, parts)) = &tree.divided else {
        let is_held = plane::holds(&tree.footprint.free, p) && plane::holds(&tree.footprint.region, p);
        return is_held.then(Vec::new);
    };
    parts.iter().enumerate().find_map(|(i, part)| {
        let mut way = holder(part, p)?;
        way.insert(0, i);
        Some(way)
    })
}

/// The part at the end of a way that [`holder`] found.
fn at<'a>(tree: &'a mut Part, way: &[usize]) -> Option<&'a mut Part> {
    way.iter().try_fold(tree, |part, i| part.divided.as_mut()?.1.get_mut(*i))
}

/// Takes a part out of the tree; a part that is left with one only is that one.
fn remove(tree: &mut Part, way: &[usize]) {
    let Some((_, parts)) = &mut tree.divided else { return };
    match way {
        [i] => drop(parts.remove(*i)),
        [i, rest @ ..] => remove(&mut parts[*i], rest),
        [] => return,
    }
    if parts.len() == 1 {
        *tree = parts.remove(0);
    }
}
