//! Families: the electrodes of several stages for the same places, in a row on one base and one holder. The machine
//! goes from one burn to the next by the place of each stage's tips on the base; while one stage burns the tips of the
//! others must keep clear of the mold too.

use glam::{DVec2, DVec3};

use super::base::{Base, placed};
use super::clearance::Obstacle;
pub use super::design::{Burn, Electrode, Family, PartId};
use super::net_shape::burned;
use super::params::{ElectrodeParams, Shape, Stage};
use super::setting::{ElectrodeError, to_burn_frame};
use super::tip::joined;
use crate::cutter::CutterLibrary;
use geometry::mesh::{Bounds, Mesh};
use task::Cancel;

/// By how much tips of a row are moved further apart until none is in the way (mm).
const FURTHER: f64 = 1.0;
/// How long a row is tried where there are no holders to say (mm).
const LONGEST: f64 = 200.0;

/// A row of electrodes: which, and where the middle of the tips of each is from that of the base (mm).
type Row = Vec<(usize, DVec2)>;

/// Sets electrodes of several stages that burn the same places on one base, as far as they fit. `like` are electrodes
/// of which these are the net shapes: they get the same places.
pub(super) fn into_families(
    mold: &Mesh,
    electrodes: &mut [Electrode],
    like: Option<&[Electrode]>,
    (cutters, params, stages): (&CutterLibrary, &ElectrodeParams, &[Stage]),
    cancel: &Cancel,
) -> Result<(), ElectrodeError> {
    if !params.family || stages.len() < 2 {
        return Ok(());
    }
    let is_same = |like: &&[Electrode]| {
        let same = |(a, b): (&Electrode, &Electrode)| a.stage == b.stage && burned(a) == burned(b);
        like.len() == electrodes.len() && like.iter().zip(electrodes.iter()).all(same)
    };
    if let Some(like) = like.filter(is_same) {
        return rows_of(like).into_iter().try_for_each(|row| set(electrodes, &row, params));
    }
    let radius = cutters.least_radius();
    // A cutter has to pass between two tips, also between those that are milled smaller than the net shape.
    let clear = params.family_spacing_mm.max(if radius.is_finite() { 2.2 * radius } else { 0.0 });
    for members in forms(electrodes) {
        cancel.check()?;
        let found = if members.len() < 2 {
            Err("no other stage has an electrode for just the same places".to_owned())
        } else {
            let turned = to_burn_frame(electrodes[members[0]].direction);
            let obstacle = Obstacle::new(&mold.mapped(|p| turned * p))?.stopped_by(cancel);
            row(electrodes, &members, (&obstacle, clear), (params, stages), cancel)?
        };
        let apart = match found.map(|row| set(electrodes, &row, params)) {
            Ok(Ok(())) => continue,
            Ok(Err(ElectrodeError::Solid(_))) => "the heads of all stages do not join into one body".to_owned(),
            Ok(Err(error)) => return Err(error),
            Err(why) => why,
        };
        members.iter().for_each(|e| electrodes[*e].family = Family::Apart { why: apart.clone() });
    }
    Ok(())
}

/// Electrodes that burn the same places from the same side, those of the first stage first.
fn forms(electrodes: &[Electrode]) -> Vec<Vec<usize>> {
    let mut forms: Vec<Vec<usize>> = Vec::new();
    for (e, electrode) in electrodes.iter().enumerate() {
        let is_same = |form: &&mut Vec<usize>| {
            let first = &electrodes[form[0]];
            first.direction == electrode.direction && first.parts() == electrode.parts()
        };
        match forms.iter_mut().find(is_same) {
            Some(form) => form.push(e),
            None => forms.push(vec![e]),
        }
    }
    forms
}

/// The rows in which electrodes stand already.
fn rows_of(electrodes: &[Electrode]) -> Vec<Row> {
    let mut rows: Vec<(&str, Row)> = Vec::new();
    for (e, electrode) in electrodes.iter().enumerate() {
        let Family::Member { name, offset } = &electrode.family else { continue };
        match rows.iter_mut().find(|(known, _)| known == name) {
            Some((_, row)) => row.push((e, *offset)),
            None => rows.push((name, vec![(e, *offset)])),
        }
    }
    rows.into_iter().map(|(_, row)| row).collect()
}

/// The shortest row in which no tip is in the way of a burn, along X or Y, either way round; else why there is none.
fn row(
    electrodes: &[Electrode],
    members: &[usize],
    (obstacle, clear): (&Obstacle, f64),
    (params, stages): (&ElectrodeParams, &[Stage]),
    cancel: &Cancel,
) -> Result<Result<Row, String>, ElectrodeError> {
    let mut is_held = false;
    for further in (0..).map(|k| f64::from(k) * FURTHER) {
        let mut fits_one = false;
        for way in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y] {
            cancel.check()?;
            let row = in_a_row(electrodes, members, way, clear + further + undersizes(params, stages));
            let (base, _) = Base::under(&around(electrodes, &row), params);
            let fits = match params.holders.is_empty() {
                true => base.sides.max_element() <= LONGEST,
                false => base.holder(params).is_some(),
            };
            if !fits {
                continue;
            }
            fits_one = true;
            if is_clear(electrodes, &row, obstacle, stages, params)? {
                return Ok(Ok(row));
            }
        }
        if !fits_one {
            break;
        }
        is_held = true;
    }
    Ok(Err(if is_held {
        "the heads of one stage would enter the mold while another stage burns, at any position on a base that fits \
         a holder"
            .to_owned()
    } else {
        "no holder is large enough for a base with the heads of all stages".to_owned()
    }))
}

/// By how much two net shapes come nearer than the tips that are made of them (mm).
fn undersizes(params: &ElectrodeParams, stages: &[Stage]) -> f64 {
    let most = stages.iter().map(|stage| stage.undersize(DVec3::X)).fold(0.0, f64::max);
    if params.shape == Shape::Net { 2.0 * most } else { 0.0 }
}

/// Tips one after another with room between them, the middle of them all on the datum.
fn in_a_row(electrodes: &[Electrode], members: &[usize], way: DVec2, clear: f64) -> Row {
    let mut row = Row::new();
    let mut end = 0.0;
    for &e in members {
        let tips = electrodes[e].tips.bounds();
        let (middle, half) = (tips.center().truncate(), 0.5 * tips.size().truncate().dot(way.abs()));
        let from = if row.is_empty() { 0.0 } else { end + clear };
        // The tips' own middle is near the origin, not always on it.
        row.push((e, way * (from + half) - middle));
        end = from + 2.0 * half;
    }
    row.iter_mut().for_each(|(_, at)| *at -= way * 0.5 * end);
    row
}

/// A box around the tips of a row below the base, its middle on the datum.
fn around(electrodes: &[Electrode], row: &Row) -> Bounds {
    let boxes = row.iter().map(|(e, at)| (electrodes[*e].tips.bounds(), at.extend(0.0)));
    let all = Bounds::of(boxes.flat_map(|(tips, at)| [tips.min + at, tips.max + at]));
    let half = all.min.abs().max(all.max.abs());
    Bounds { min: (-half).with_z(all.min.z), max: half.with_z(0.0) }
}

/// Where a burn has the electrode's origin once its tips are moved on the base, in the burn frame (mm).
fn origin(electrode: &Electrode, burn: &Burn, offset: DVec2) -> DVec3 {
    to_burn_frame(electrode.direction) * burn.position - DVec2::from_angle(burn.turn).rotate(offset).extend(0.0)
}

/// Whether the tips of each stage keep clear of the mold while another one burns.
fn is_clear(
    electrodes: &[Electrode],
    row: &Row,
    obstacle: &Obstacle,
    stages: &[Stage],
    params: &ElectrodeParams,
) -> Result<bool, ElectrodeError> {
    for (e, at) in row {
        let (electrode, stage) = (&electrodes[*e], &stages[electrodes[*e].stage]);
        for burn in &electrode.burns {
            let origin = origin(electrode, burn, *at);
            for (other, other_at) in row.iter().filter(|(other, _)| other != e) {
                let tips = electrodes[*other].tips.mapped(|p| p + other_at.extend(0.0));
                let moved = placed(&tips, burn.turn, origin);
                if !obstacle.keeps_clear(&moved, stage, burn.retract(params.lift_mm))? {
                    return Ok(false);
                }
            }
        }
    }
    Ok(true)
}

/// Sets electrodes on one base.
fn set(electrodes: &mut [Electrode], row: &Row, params: &ElectrodeParams) -> Result<(), ElectrodeError> {
    let (base, length) = Base::under(&around(electrodes, row), params);
    let tips: Vec<Mesh> = row.iter().map(|(e, at)| electrodes[*e].tips.mapped(|p| p + at.extend(0.0))).collect();
    let mesh = base.with_tips(&tips)?;
    for (k, (e, offset)) in row.iter().enumerate() {
        let electrode = &mut electrodes[*e];
        let back = to_burn_frame(electrode.direction).transpose();
        for i in 0..electrode.burns.len() {
            electrode.burns[i].position = back * origin(electrode, &electrode.burns[i], *offset);
        }
        let others = tips.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, tips)| tips.clone());
        electrode.others = others.fold(Mesh::default(), joined);
        electrode.tips = tips[k].clone();
        electrode.mesh = mesh.clone();
        electrode.base = base;
        electrode.blank = base.sides.extend(length);
        electrode.holder = base.holder(params);
        electrode.family = Family::Member { name: format!("family {}", row[0].0), offset: *offset };
    }
    Ok(())
}
