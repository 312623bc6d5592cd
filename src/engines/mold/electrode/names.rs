//! Names of electrodes. A name, once given, belongs to what the electrode burned then: when regions are divided
//! otherwise, or other parts share an electrode, an electrode that burns most of the same places keeps it, a name that
//! no electrode has any more stays free, and what is new gets a number after all that were ever given.

use std::cmp::Reverse;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::design::{Electrode, Family, PartId, RegionPlan};
use super::edits::TOUCHES;
use super::edits::off_in_plan;
use super::given::{Given, GivenName, numbered};
use super::params::ElectrodeParams;
use super::part_numbers::{Numbered, Parts};
use super::setting::{RegionToBurn, to_burn_frame};
use crate::outline::Outline;
use crate::plane;
use geometry::solid::SolidError;

/// What is burned: the regions, how, and their parts.
pub(super) type Burned<'a> = (&'a [RegionToBurn], &'a [RegionPlan], &'a Parts);

/// Names electrodes: the same number for all stages where they burn the same parts. Returns all numbers that were
/// given, those of `params` first.
///
/// # Errors
/// [`SolidError`], where a blank that the user gave cannot be joined with its heads.
pub(super) fn named(
    electrodes: &mut [Electrode],
    params: &ElectrodeParams,
    burned: Burned,
) -> Result<Vec<GivenName>, SolidError> {
    let mut forms: Vec<Vec<PartId>> = Vec::new();
    let mut form_of = Vec::new();
    for electrode in electrodes.iter() {
        let own = electrode.parts();
        form_of.push(forms.iter().position(|form| *form == own).unwrap_or(forms.len()));
        if form_of.last() == Some(&forms.len()) {
            forms.push(own);
        }
    }
    let known = numbers(&forms, &params.names, burned);
    let mut given = params.names.clone();
    let mut last = given.iter().map(|name| name.number).max().unwrap_or(0);
    let mut number_of = Vec::new();
    for (form, known) in forms.iter().zip(known) {
        number_of.push(known.unwrap_or_else(|| {
            last = last.saturating_add(1);
            let places = form.iter().filter_map(|part| place_of(*part, burned)).collect();
            given.push(GivenName { number: last, places, ..GivenName::default() });
            last
        }));
    }
    let shorts = short_names(&number_of, &given, params);
    for (electrode, form) in electrodes.iter_mut().zip(form_of) {
        let (number, stage) = (number_of[form], &params.stages[electrode.stage].name);
        let (short, unmet) = shorts[form].clone();
        electrode.number = number;
        electrode.unmet.extend(unmet);
        if let Some(own) = given.iter().find(|name| name.number == number) {
            electrode.as_given(&own.given, params)?;
        }
        electrode.name = if params.stages.len() == 1 { short.clone() } else { format!("{short}-{stage}") };
        if let Family::Member { name, .. } = &mut electrode.family {
            *name = short;
        }
    }
    Ok(given)
}

/// The name of each of these numbers without its stage, and why it is not the one that the user gave, if so. No two are
/// the same, also where case does not count.
fn short_names(numbers: &[usize], given: &[GivenName], params: &ElectrodeParams) -> Vec<(String, Option<String>)> {
    let own = |number: usize| given.iter().find(|name| name.number == number).map(|name| &name.given);
    // File names tell neither case nor hyphens from underscores.
    let in_files = |name: &str| name.to_ascii_lowercase().replace('_', "-");
    let is_free = |given: &Given| given.number.is_none() && given.name.is_none();
    let mut taken: Vec<String> = Vec::new();
    let mut names: Vec<Option<(String, Option<String>)>> = vec![None; numbers.len()];
    // Those without a name of their own first.
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by_key(|i| !own(numbers[*i]).is_none_or(is_free));
    for i in order {
        let number = numbers[i];
        let asked = own(number).and_then(|own| own.name.clone().or(own.number.map(numbered)));
        let ends_with_stage =
            |name: &str| params.stages.iter().any(|stage| name.ends_with(&format!("-{}", stage.name)));
        let is_taken = |name: &str| taken.contains(&in_files(name)) || ends_with_stage(name);
        names[i] = Some(match asked {
            Some(name) if is_taken(&name) => {
                let unmet =
                    format!("the name {name} is that of another electrode, or ends with a stage: choose another one");
                // A number of its own is free but where it was given to another.
                let mut own = numbered(number);
                while taken.contains(&in_files(&own)) {
                    own.push('b');
                }
                (own, Some(unmet))
            }
            Some(name) => (name, None),
            None => (numbered(number), None),
        });
        taken.extend(names[i].iter().map(|(name, _)| in_files(name)));
    }
    names.into_iter().flatten().collect()
}

/// For each of these sets of parts the number that was given to most of it, each number once.
fn numbers(forms: &[Vec<PartId>], given: &[GivenName], burned: Burned) -> Vec<Option<usize>> {
    let of = |name: &GivenName| -> Vec<PartId> {
        let mut parts: Vec<PartId> = name.places.iter().filter_map(|place| part_at(*place, burned)).collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    };
    let known: Vec<Vec<PartId>> = given.par_iter().map(of).collect();
    let mut same = Vec::new();
    for (name, known) in given.iter().zip(&known) {
        for (f, form) in forms.iter().enumerate() {
            let both = known.iter().filter(|part| form.contains(part)).count();
            if both > 0 {
                same.push((Reverse(both), form.len() + known.len() - both, name.number, f));
            }
        }
    }
    same.sort_unstable();
    let mut found: Vec<Option<usize>> = vec![None; forms.len()];
    for (.., number, form) in same {
        if found[form].is_none() && !found.contains(&Some(number)) {
            found[form] = Some(number);
        }
    }
    found
}

/// The part at a place: of the region that is nearest to it in plan, and of several the one that is nearest to it in
/// space.
pub(super) fn part_at(place: DVec3, (regions, plans, parts): Burned) -> Option<PartId> {
    let near = regions.iter().enumerate().filter_map(|(r, region)| {
        let turned = to_burn_frame(plans[r].direction);
        let plan = |p: DVec3| (turned * p).truncate();
        let p = plan(place);
        let [low, high] = region.corners.iter().flatten().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[l, h], c| {
            let c = plan(*c);
            [l.min(c), h.max(c)]
        });
        let is_far = (low - p).max(p - high).max_element() > TOUCHES;
        let off = if is_far { f64::INFINITY } else { off_in_plan(region, plan, p) };
        (off <= TOUCHES).then(|| {
            let away = region.corners.iter().flatten().map(|c| c.distance_squared(place)).fold(f64::INFINITY, f64::min);
            (off, away, r, p)
        })
    });
    let (.., region, p) = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    let offs = parts[region].iter().map(|part| (plane::off(&part.shape, p), part.number));
    let (off, part) = offs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (off <= TOUCHES).then_some(PartId { region, part })
}

/// A place of a part that is in no other one where there is such a place, at the height of what is left there.
fn place_of(id: PartId, (regions, plans, parts): Burned) -> Option<DVec3> {
    let part = parts[id.region].iter().find(|part| part.number == id.part)?;
    let others = |other: &&Numbered| other.stage == part.stage && other.number != part.number;
    let others: Vec<Outline> = parts[id.region].iter().filter(others).flat_map(|o| o.shape.iter().cloned()).collect();
    let own = plane::outlines(plane::difference(&part.shape, &others));
    let p = plane::inside(&own).or_else(|| plane::inside(&part.shape))?;
    let turned = to_burn_frame(plans[id.region].direction);
    let middles = regions[id.region].corners.iter().map(|c| turned * ((c[0] + c[1] + c[2]) / 3.0));
    let nearest = middles.min_by(|a, b| a.truncate().distance(p).total_cmp(&b.truncate().distance(p)))?;
    Some(turned.transpose() * p.extend(nearest.z))
}
