//! Finds a channel of a blisk, with its walls, in a bare mesh.

mod agreement;
#[cfg(test)]
mod agreement_tests;
mod bodies;
mod doubt;
mod flow;
mod hand_lines;
#[cfg(test)]
mod hand_tests;
#[cfg(test)]
mod hole_tests;
mod measure;
mod meridian;
mod obstruction;
#[cfg(test)]
mod random_wheels;
mod retry;
#[cfg(test)]
mod sectors;
mod sentences;
#[cfg(test)]
mod splitter_tests;
#[cfg(test)]
mod spoilt_tests;
#[cfg(test)]
mod tests;
mod tips;
mod tube;
mod walls;

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec2;

use self::agreement::Measured;
use self::flow::{LEANING, Lines, STEEP};
use self::meridian::{Meridian, Place, Tracer};
use self::retry::{counted, misleading, recount};
use self::sentences::{
    end_wall_assumptions, given_by_hand, holes_sentence, left_sentence, tip_gap_sentence, unlike_sentence,
};
use self::walls::{BEYOND_EDGE, WallFinder, Walls};
use super::by_hand::ByHand;
use super::channel::{Agreement, Channel, ChannelWall, Flow, OPENS, Surface, station_at, ways_out};
use super::error::{BliskError, Misleading, NotChannels, Refused};
use super::frame::slices::{Gap, Slices};
use super::frame::{BliskFrame, Repetition, Wheel, find_sector, find_wheel, is_inside_out};
use super::options::{AxisChoice, AxisName, BliskOptions, EndWalls, ZAt};
use geometry::frame::{Cylindrical, Frame};
use geometry::mesh::Mesh;
use task::{Cancel, Task};

/// The hub of an axial channel may be steeper than 45 degrees over this share of the blades' width, as at a step beside
/// their edges.
const MOST_STEEP_HUB: f64 = 0.15;

/// Share of the walls that repeat where blades are mostly alike and evenly spaced.
const MOSTLY_ALIKE: f64 = 0.75;

/// A shroud that covers less than this share of the passage's length is named as the reason where hub or shroud disagree.
const MOST_COVERED: f64 = 0.9;

/// Where the direction of a passage at its mouth is measured: distances from the edge of its blades in lengths of the
/// passage. Not beside the edges: within their noses a gap says more of the rounding, and of how finely it was cut into
/// triangles, than of the passage.
const FROM_MOUTH: std::ops::Range<f64> = 0.05..0.15;

/// Finds the axis, the blades and the chosen channel of `mesh` (mm, closed, in any attitude).
///
/// W's X runs along the blisk axis, towards the positive side of the mesh axis it is nearest to; its origin is
/// the foot of the mesh's origin on the axis, and the middle of the channel (half way between the blades'
/// edges, half way up, half way across) lies on +Z; a passage that opens at the rim runs out there along +Z instead.
///
/// # Errors
/// [`BliskError`] says what could not be found, why, and which key of the project gives it by hand.
pub fn find_channel(mesh: &Mesh, options: &BliskOptions, task: &Task) -> Result<Channel, BliskError> {
    find_or_refuse(mesh, options, task).map_err(|refused| refused.error)
}

/// [`find_channel`], with the place where it fails.
///
/// # Errors
/// [`Refused`] with the error of [`find_channel`] and its place.
pub fn find_or_refuse(mesh: &Mesh, options: &BliskOptions, task: &Task) -> Result<Channel, Refused> {
    let (mesh, assumed) = prepared(mesh, options)?;
    Ok(wheel_and_channel(&mesh, options, &assumed, task, &mut |_| ())?.1)
}

/// The wheel in `mesh`, which is oriented outwards, and its chosen channel. `assumed` is carried on; `found` is called with
/// each wheel whose channel is looked for.
pub(super) fn wheel_and_channel<'a>(
    mesh: &'a Mesh,
    options: &BliskOptions,
    assumed: &[String],
    task: &Task,
    found: &mut dyn FnMut(&Wheel),
) -> Result<(Wheel<'a>, Channel), Refused> {
    let mut axis = None;
    let mut found = |wheel: &Wheel| {
        axis = Some(wheel.blisk.axis);
        found(wheel);
    };
    match in_all_bodies(mesh, options, assumed, task, &mut found) {
        Ok((wheel, mut channel)) => {
            channel.assumed.extend(bodies::others(mesh, &channel));
            Ok((wheel, channel))
        }
        Err(Refused { error, at }) => match (&error, options.axis) {
            (BliskError::Cancelled(_), _) | (_, AxisChoice::Line(_)) => Err(Refused { error, at }),
            _ => Err(bodies::refused(mesh, axis, options, task)?.map_or(Refused { error, at }, Refused::from)),
        },
    }
}

/// [`wheel_and_channel`] of all that the mesh holds.
fn in_all_bodies<'a>(
    mesh: &'a Mesh,
    options: &BliskOptions,
    assumed: &[String],
    task: &Task,
    found: &mut dyn FnMut(&Wheel),
) -> Result<(Wheel<'a>, Channel), Refused> {
    let mut channel = |wheel: &Wheel| {
        found(wheel);
        let assumed = [assumed, &wheel.blisk.assumed].concat();
        channel_of(wheel.clone(), options, assumed, task)
    };
    let wheel = match find_wheel(mesh, options, task) {
        Ok(wheel) => wheel,
        Err(BliskError::Cancelled(cancelled)) => return Err(BliskError::from(cancelled).into()),
        Err(error) => return Err(misleading(mesh, options, &Misleading::ALL, task)?.unwrap_or(error).into()),
    };
    let unlike_walls = wheel.blisk.repetition.matched < MOSTLY_ALIKE;
    let whole = channel(&wheel).map_err(|refused| match refused.error {
        // Unequal walls are the cause, what they lead to is not.
        BliskError::Disagrees(Agreement { surface: Surface::LowWall | Surface::HighWall, .. }) if unlike_walls => {
            let (axis, count) = (wheel.blisk.axis, wheel.blisk.repetition.blades);
            Refused { error: BliskError::NoChannels { axis, count, reason: NotChannels::DoNotRepeat }, ..refused }
        }
        _ => refused,
    });
    // A blade alone may look like a wheel of a few: no two of its channels are alike.
    let error = match &whole {
        Ok(of) if !of.unlike.is_empty() && of.unlike.len() + 1 == of.blades / of.kinds => {
            BliskError::NoChannels { axis: wheel.blisk.axis, count: of.blades, reason: NotChannels::NoneAlike }
        }
        Ok(_) | Err(Refused { error: BliskError::Cancelled(_), .. }) => return whole.map(|channel| (wheel, channel)),
        Err(refused) => refused.error.clone(),
    };
    if !wheel.is_of_sector && options.axis == AxisChoice::Named(AxisName::Auto) {
        let sector = find_sector(mesh, &wheel.blisk.axis, error, options, task)?;
        if let Some(Ok(found)) = sector.map(|wheel| channel(&wheel).map(|channel| (wheel, channel))) {
            return Ok(found);
        }
        found(&wheel);
    }
    if let Err(refused) = &whole
        && let Some((count, what)) = recount(&refused.error, &wheel.blisk.repetition, options)
    {
        let is_hollow = count < wheel.blisk.repetition.blades;
        let counted = counted(mesh, (count, what, options), assumed, task, found)?;
        if let Some(counted) = counted.filter(|(_, channel)| is_hollow || !channel.unlike.is_empty()) {
            return Ok(counted);
        }
        found(&wheel);
    }
    if let (Err(_), AxisChoice::Line(_)) = (&whole, options.axis)
        && let Some(error) = misleading(mesh, options, &[Misleading::Axis], task)?
    {
        return Err(error.into());
    }
    if whole.is_err()
        && let Some(error @ (BliskError::PointOff { .. } | BliskError::BladePoint { .. })) =
            misleading(mesh, options, &[Misleading::Points], task)?
    {
        return Err(error.into());
    }
    let Err(refused) = whole else { return whole.map(|channel| (wheel, channel)) };
    let is_own = matches!(
        refused.error,
        BliskError::LostWall { .. }
            | BliskError::Disagrees(_)
            | BliskError::NoThroat { .. }
            | BliskError::NoEndWall { .. }
            | BliskError::Turns { .. }
            | BliskError::Unbounded { .. }
    );
    let other = if is_own { other_channel(&wheel, options, task)? } else { None };
    // Without any passage what repeats about a less likely line is no wheel.
    if let (None, Some(error)) = (other, wheel.likelier) {
        return Err(error.into());
    }
    let closed = !is_own || wheel.mesh.is_watertight();
    if closed && other.is_none() {
        return Err(refused);
    }
    Err(Refused { error: BliskError::Spoilt { error: Box::new(refused.error), closed, other }, ..refused })
}

/// A channel of the kind of the chosen one that is found, where the chosen one is refused for what may be its own.
fn other_channel(wheel: &Wheel, options: &BliskOptions, task: &Task) -> Result<Option<usize>, Refused> {
    let is_by_hand = options.radii().iter().any(|(_, radius)| radius.given().is_some())
        || options.points().iter().any(|(_, points, _)| !points.is_empty());
    if is_by_hand {
        return Ok(None);
    }
    let Repetition { blades, kinds, .. } = wheel.blisk.repetition;
    let alike = blades / kinds;
    // Across the wheel, and a third of the way round it.
    let mut others = [alike / 2, alike / 3].map(|turns| (options.channel + turns * kinds) % blades).to_vec();
    others.dedup();
    for other in others.into_iter().filter(|other| *other != options.channel) {
        match channel_of(wheel.clone(), &BliskOptions { channel: other, ..options.clone() }, Vec::new(), task) {
            Ok(_) => return Ok(Some(other)),
            Err(stopped @ Refused { error: BliskError::Cancelled(_), .. }) => return Err(stopped),
            Err(_) => {}
        }
    }
    Ok(None)
}

/// The mesh with its normals outwards, and what was assumed for that.
pub(super) fn prepared<'a>(mesh: &'a Mesh, options: &BliskOptions) -> Result<(Cow<'a, Mesh>, Vec<String>), BliskError> {
    options.validate().map_err(BliskError::Options)?;
    if !is_inside_out(mesh)? {
        return Ok((Cow::Borrowed(mesh), Vec::new()));
    }
    Ok((Cow::Owned(mesh.turned_over()), vec!["The mesh is inside out; its triangles were turned over.".into()]))
}

/// The chosen channel of a wheel whose axis and period are known. `assumed` is carried on. Where none is found along the
/// axis, and the passage leans from it, it is looked for across its own direction.
fn channel_of(wheel: Wheel, options: &BliskOptions, assumed: Vec<String>, task: &Task) -> Result<Channel, Refused> {
    let blades = wheel.blisk.repetition.blades;
    if options.channel >= blades {
        return Err(BliskError::NoSuchChannel { index: options.channel, blades }.into());
    }
    let refused = |error, frame: &Frame| Refused::new(error, frame, options);
    let placed = |slope: f64| {
        task.report("channel", 0.0, "place");
        place_channel(&wheel, options, slope, &task.cancel).map_err(|error| refused(error, &wheel.blisk.frame))
    };
    let measured = |placed: Placed| {
        let frame = placed.frame;
        measured_channel(wheel.clone(), placed, options, assumed.clone(), task).map_err(|error| refused(error, &frame))
    };
    let first = placed(STEEP);
    let is_axial = first.as_ref().map_or(true, |placed| placed.lines.is_none());
    let is_given = options.radii().iter().any(|(_, radius)| radius.given().is_some());
    let refused = match first.and_then(measured) {
        Err(refused) if is_axial && !is_given => refused,
        found => return found,
    };
    let is_stopped = |refused: &Refused| matches!(refused.error, BliskError::Cancelled(_));
    let across = match placed(LEANING) {
        Ok(across) if across.lines.is_some() && !is_stopped(&refused) => measured(across),
        Ok(_) => return Err(refused),
        Err(other) => Err(other),
    };
    // What stands in the way along the axis is what is told.
    across.map_err(|other| if is_stopped(&other) { other } else { refused })
}

/// The channel at a place that is known.
fn measured_channel(
    Wheel { mesh, is_of_sector, blisk, .. }: Wheel,
    Placed { frame, start, lines }: Placed,
    options: &BliskOptions,
    mut assumed: Vec<String>,
    task: &Task,
) -> Result<Channel, BliskError> {
    let blades = blisk.repetition.blades;
    task.report("channel", 0.3, "end walls");
    let slices = Slices::new(mesh.in_frame(&frame));
    let by_hand = ByHand::new(options, &frame);
    let tracer =
        Tracer { slices: &slices, pitch: TAU / blades as f64, options, by_hand: &by_hand, cancel: &task.cancel };
    let lost = BliskError::LostWall { x: start.x, r: start.r };
    let gap = tracer.bladed_gap(start.x, start.r, &start.gap).ok_or(lost)?;
    let start = Place { gap, ..start };
    let (meridian, start) = meridian_of(&tracer, start, lines.as_ref())?;
    if options.end_walls == EndWalls::Measured {
        hand_lines::check_points(&by_hand, &meridian.stations, meridian.shrouded)?;
    }

    task.report("channel", 0.6, "walls");
    let finder = WallFinder { tracer: &tracer, meridian: &meridian, start };
    let walls = finder.walls(options.wall_points_chord, options.wall_points_span);
    let walls = walls.map_err(|error| reason(error, lines.as_ref()))?;
    if meridian.flow == Flow::Axial {
        check_axial(&meridian, [&walls.low, &walls.high])?;
    }
    let throat = match blisk.repetition.kinds {
        1 => measure::throat([&walls.low, &walls.high], walls.rows.beyond(), 0, &task.cancel)?,
        // Beside splitters the narrowest place may be where a main blade stands ahead of one, or goes on behind it.
        _ => {
            let [low, high] = finder.beyond_edges(&walls)?;
            measure::throat([&low, &high], walls.rows.beyond(), BEYOND_EDGE, &task.cancel)?
        }
    };
    let Walls { mut low, mut high, rows } = walls;
    let (turning, sides) = measure::turning(&low, &high, meridian.flow);
    [low.side, high.side] = sides;
    let faces_x = measure::faces_x(slices.mesh(), &meridian.stations);
    assumed.extend(end_wall_assumptions(options, &meridian, rows.inset));
    assumed.extend(given_by_hand(options));
    let mut channel = Channel {
        frame,
        blades,
        index: options.channel,
        shrouded: meridian.shrouded,
        flow: meridian.flow,
        meridian: meridian.stations.clone(),
        low,
        high,
        throat,
        turning,
        faces_x,
        agreement: Vec::new(),
        kinds: blisk.repetition.kinds,
        unlike: Vec::new(),
        whole: is_of_sector.then(|| Arc::new(mesh.into_owned())),
        obstacles: None,
        assumed,
    };
    let measured = Measured { tracer: &tracer, meridian: &meridian, walls: [&channel.low, &channel.high], rows };
    let agreement = measured.agreement(&channel.throat).map_err(|error| part_covered(&channel, error))?;
    if !meridian.shrouded {
        walls::check_rows(&channel.low, &channel.high)?;
        measured.check_tips()?;
    }
    // Whoever points at blades has seen them.
    if options.blade_points_mm.is_empty() {
        channel.assumed.extend(doubt::doubt(&channel).map(str::to_owned));
    }
    if options.blades.given().is_none() {
        channel.assumed.extend(doubt::uncounted(&channel, tracer.slices));
    }
    let unlike = measured.unlike(blades, blisk.repetition.kinds)?;
    let obstructed = obstruction::obstructed(&channel, slices.mesh(), &task.cancel)?;
    channel.assumed.extend(agreement.iter().filter_map(holes_sentence));
    channel.assumed.extend(agreement.iter().filter_map(left_sentence));
    channel.assumed.extend(measured.tip_gap().map(tip_gap_sentence));
    (channel.agreement, channel.unlike) = (agreement, unlike);
    // Metal in a passage is reported rather than a wall of it that differs.
    channel.unlike.splice(0..0, obstructed);
    channel.unlike.sort_by_key(|unlike| unlike.number);
    channel.unlike.dedup_by_key(|unlike| unlike.number);
    let is_alone = channel.unlike.len() + 1 == blades / channel.kinds;
    let is_odd = is_alone && measured.is_odd(&channel.unlike)?;
    channel.unlike.iter_mut().for_each(|unlike| unlike.number = (options.channel + unlike.number) % blades);
    channel.assumed.extend(unlike_sentence(&channel.unlike, is_odd, (blades, channel.kinds), options.channel));
    task.report("channel", 1.0, "");
    Ok(channel)
}

/// Hub and shroud of the channel through `start`, along `lines` where it is not axial, and `start` with its position
/// along them.
fn meridian_of(tracer: &Tracer, start: Place, lines: Option<&Lines>) -> Result<(Meridian, Place), BliskError> {
    let Some(lines) = lines else { return Ok((tracer.meridian(start)?, start)) };
    if let Some((key, _)) = tracer.options.radii().into_iter().find(|(_, radius)| radius.given().is_some()) {
        return Err(BliskError::NotAxial { key });
    }
    tracer.tube(start, lines).map_err(|error| reason(error, Some(lines)))
}

/// The reason why the passage along `lines` was not found, which `error` may hide.
fn reason(error: BliskError, lines: Option<&Lines>) -> BliskError {
    match lines {
        Some(lines) => lines.reason(error),
        None => error,
    }
}

/// Refuses an axial channel whose hub runs along the radius between the blades: its passage turns, and the curves along
/// it were not found.
fn check_axial(meridian: &Meridian, walls: [&ChannelWall; 2]) -> Result<(), BliskError> {
    let xs = || walls.into_iter().flat_map(|wall| wall.points.iter().map(|p| p.x));
    let (first, last) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
    let hub = meridian.stations.iter().map(|s| s.hub).filter(|p| (first..=last).contains(&p.x));
    let hub: Vec<DVec2> = hub.collect();
    let steps = hub.windows(2).map(|w| (w[1] - w[0]).abs());
    let steep: f64 = steps.filter(|step| step.y > step.x).map(|step| step.x).sum();
    if steep <= MOST_STEEP_HUB * (last - first) {
        return Ok(());
    }
    let rise = |w: &&[DVec2]| ((w[1].y - w[0].y) / (w[1].x - w[0].x)).abs();
    let steepest = hub.windows(2).max_by(|a, b| rise(a).total_cmp(&rise(b))).map_or(DVec2::NAN, |w| w[0]);
    Err(BliskError::Turns { x: steepest.x, r: steepest.y })
}

/// The reason for `error`: where hub or shroud disagree and one of them was met over a part of the blades only, that.
fn part_covered(channel: &Channel, error: BliskError) -> BliskError {
    let xs = || channel.low.points.iter().map(|p| p.x);
    let (first, last) = (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
    let (BliskError::Disagrees(Agreement { surface: Surface::Hub | Surface::Shroud, .. }), Flow::Axial, [from, .., to]) =
        (&error, channel.flow, &channel.meridian[..])
    else {
        return error;
    };
    let share = (to.along.min(last) - from.along.max(first)) / (last - first);
    let at = station_at(&channel.meridian, 0.5 * (from.along + to.along)).shroud;
    if share < MOST_COVERED { BliskError::PartShroud { share, x: at.x, r: at.y, joined: true } } else { error }
}

/// The chosen channel's place.
struct Placed {
    /// W of the channel.
    frame: Frame,
    /// The channel's middle, in W.
    start: Place,
    /// The lines across it, where it is not axial.
    lines: Option<Lines>,
}

/// Finds W of the chosen channel, and the channel's middle in it. A passage steeper than `slope` is not axial.
fn place_channel(
    Wheel { mesh, blisk, .. }: &Wheel,
    options: &BliskOptions,
    slope: f64,
    cancel: &Cancel,
) -> Result<Placed, BliskError> {
    let slices = Slices::new(mesh.in_frame(&blisk.frame));
    let pitch = TAU / blisk.repetition.blades as f64;
    let by_hand = ByHand::new(options, &blisk.frame);
    let tracer = Tracer { slices: &slices, pitch, options, by_hand: &by_hand, cancel };
    let (x, r) = (blisk.middle.x, blisk.middle.y);
    let picked = tracer.picked()?;
    let gaps = || slices.gaps(x, r).into_iter().filter(|g| g.width() < 1.5 * pitch);
    let starts = picked.map_or_else(|| gaps().map(|gap| Place { along: x, x, r, gap }).collect(), |place| vec![place]);
    let (lines, mut place) = first_middle(&tracer, &starts, blisk, slope)?;

    // The same again from the chosen channel, since facets differ a little from channel to channel.
    let (x, r) = (place.x, place.r);
    let theta = place.gap.middle();
    // Channels are counted from the picked one, or from the one nearest to theta = 0; of two equally near ones, the
    // one of greater theta.
    let nearest = if picked.is_some() { theta } else { theta - pitch * ((theta / pitch - 0.5) - 1e-6).ceil() };
    let turn = nearest + pitch * options.channel as f64 - theta;
    // Beside splitters off the middle it may be much wider than the one that it is counted from.
    let chosen = slices.gap_near(x, r, &turned(place.gap, turn)).filter(|gap| gap.width() < 1.5 * pitch);
    let chosen = chosen.ok_or(BliskError::LostWall { x, r })?;
    let chosen = Place { gap: chosen, ..place };
    // Tips tell no more of a passage than its blades reach, and of another kind it may be longer.
    let own = match &lines {
        Some(known) if !known.shrouded && blisk.repetition.kinds > 1 => {
            flow::lines(&tracer, chosen, blisk.repetition.kinds, slope)?
        }
        _ => None,
    };
    let lines = own.or(lines);
    let theta;
    (place, theta) = middle_of(&tracer, chosen, lines.as_ref())?;
    place.gap = turned(place.gap, -theta);
    Ok(Placed { frame: blisk.frame.turned_about_x(theta), start: place, lines })
}

/// The lines across the channels and the middle of the first channel that has them: of those at `starts` some around the
/// wheel are tried, since one may hold what keeps it from being found.
fn first_middle(
    tracer: &Tracer,
    starts: &[Place],
    blisk: &BliskFrame,
    slope: f64,
) -> Result<(Option<Lines>, Place), BliskError> {
    const TRIED: usize = 4;
    let kinds = blisk.repetition.kinds;
    let step = kinds * (starts.len() / kinds / TRIED).max(1);
    let mut first_error = BliskError::LostWall { x: blisk.middle.x, r: blisk.middle.y };
    for (i, start) in starts.iter().step_by(step).take(TRIED).enumerate() {
        let lines = flow::lines(tracer, *start, kinds, slope);
        match lines.and_then(|lines| Ok((middle_of(tracer, *start, lines.as_ref())?.0, lines))) {
            Ok((place, lines)) => return Ok((lines, place)),
            Err(BliskError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) if i == 0 => first_error = error,
            Err(_) => {}
        }
    }
    Err(first_error)
}

/// The middle of the channel through a place, half way between the edges and half way up, and the angle about X that
/// becomes W's +Z: that of the direction in which the passage runs out at the rim, since electrodes leave it there along
/// +Z; that of its mouth in the bore, where it may run far off the radius; otherwise that of its middle (rad).
fn middle_of(tracer: &Tracer, start: Place, lines: Option<&Lines>) -> Result<(Place, f64), BliskError> {
    let (meridian, start) = meridian_of(tracer, start, lines)?;
    let finder = WallFinder { tracer, meridian: &meridian, start };
    let row = finder.row(0.5).map_err(|error| reason(error, lines))?;
    let (front, back) = (row.front.along, row.back.along);
    let middle = finder.place(&row, 0.5 * (front + back))?;
    let ways = if meridian.flow == Flow::Axial { [DVec2::ZERO; 2] } else { ways_out(&meridian.stations) };
    let [far, near] = [FROM_MOUTH.end, FROM_MOUTH.start].map(|share| share * (back - front));
    let ends = [[front + far, front + near], [back - far, back - near]].into_iter().zip(ways);
    let z_at = tracer.options.z_at;
    let outwards = if z_at == ZAt::Bore { -1.0 } else { 1.0 };
    let mouth = ends.max_by(|a, b| (outwards * a.1.y).total_cmp(&(outwards * b.1.y)));
    let mouth = mouth.filter(|(_, way)| outwards * way.y >= OPENS && z_at != ZAt::Middle);
    let Some(([inside, mouth], _)) = mouth else { return Ok((middle, middle.gap.middle())) };
    let [from, to] = [finder.place(&row, inside)?, finder.place(&row, mouth)?].map(|place| {
        let theta = place.gap.middle();
        Cylindrical { x: place.x, r: place.r, theta }.point()
    });
    Ok((middle, Cylindrical::from_point(if z_at == ZAt::Bore { to } else { to - from }).theta))
}

fn turned(mut gap: Gap, angle: f64) -> Gap {
    gap.low.theta += angle;
    gap.high.theta += angle;
    gap
}
