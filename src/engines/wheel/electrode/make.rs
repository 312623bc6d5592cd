//! Making the electrodes of a channel: its division into parts and columns (P1), and the junctions between them.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::body::{self, Plan};
use super::boundary::{BladeEnd, Boundary, Section, Spot, blade_ends};
use super::params::COLUMN_SPLIT;
use super::ring::Finisher;
use super::{Column, Electrode, ElectrodeError, ElectrodeParams, EntrySide};
use crate::channel::Channel;
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use task::Task;

/// What is built may miss the gap between its points by this much (mm); else it is built again, by that and [`SPARE`]
/// smaller, at most by [`MOST_ROOM`].
const SHORTFALL: f64 = 1e-3;
const SPARE: f64 = 2e-4;
const MOST_ROOM: f64 = 0.02;
const MOST_ATTEMPTS: usize = 4;
/// How much an electrode may miss the gap by where building it smaller does not help (mm): still within what a
/// certificate tolerates.
pub(super) const MOST_SHORTFALL: f64 = 2e-3;

/// Makes the electrodes of the first stage of `channel` that enter from `side`, in the order of burning: the part next to that
/// side first, and of each part the low column first.
///
/// # Errors
/// Every error of [`make_electrode`].
pub fn make_electrodes(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    side: EntrySide,
    task: &Task,
) -> Result<Vec<Electrode>, ElectrodeError> {
    let mut parts: Vec<usize> = (0..params.parts).collect();
    if side.mouth(channel)? {
        parts.reverse();
    }
    let numbers = parts.into_iter().flat_map(|part| (0..params.columns).map(move |k| part * params.columns + k));
    numbers.map(|number| make_electrode(channel, blisk, params, (number, side), task)).collect()
}

/// Makes electrode number `number` of `channel`, counted through the stages and in each along the passage from its first
/// station, the columns of one part low to high, to enter from `side`.
///
/// `blisk` is the finished blisk in W. The result does not depend on the number of threads.
///
/// # Errors
/// An [`ElectrodeError`] that says where the channel leaves no room for the wanted gap and reductions.
pub fn make_electrode(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    (number, side): (usize, EntrySide),
    task: &Task,
) -> Result<Electrode, ElectrodeError> {
    params.validate()?;
    let (stage, number) = params.in_stage(number);
    let params = params.of_stage(stage);
    let (part, column) = params.place_of(number);
    let which = Which { part, column, side, at_last: side.mouth(channel)? };
    let params = params.of_part(part);
    let mut room = 0.0;
    for _ in 1..MOST_ATTEMPTS {
        let made = with_room(channel, blisk, &params, (which, room), task);
        let clearance = match &made {
            Ok(electrode) => electrode.clearance_mm,
            Err(ElectrodeError::TooClose { clearance, .. }) => *clearance,
            Err(_) => return made,
        };
        let more = params.spark_gap_mm - clearance + SPARE;
        if clearance >= params.spark_gap_mm - SHORTFALL || room + more >= MOST_ROOM {
            return made;
        }
        room += more;
    }
    with_room(channel, blisk, &params, (which, room), task)
}

/// One electrode of a channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Which {
    pub part: usize,
    pub column: Option<Column>,
    pub side: EntrySide,
    /// Whether the side of entry is that of the passage's last station.
    pub at_last: bool,
}

/// The electrode, built `room` (mm) farther from the blisk than the gap wants.
fn with_room(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    (which, room): (Which, f64),
    task: &Task,
) -> Result<Electrode, ElectrodeError> {
    task.report("electrode", 0.0, "boundary of the channel");
    let boundary = Boundary::new(channel, blisk, params, room)?;
    let whole = burning_extent(channel, params);
    let range = part_ranges(channel, whole, params)?[which.part];
    // The burning part, and the way of the shank through the passage.
    let extent = if which.at_last { [range[0], whole[1]] } else { [whole[0], range[1]] };
    let mut planes: Vec<f64> = range.to_vec();
    planes.extend(edge_planes(channel, params, extent));
    planes.extend(runout(channel, extent, which.at_last));
    let mut sections = boundary.sections(extent, &planes, &task.cancel)?;
    let finisher = Finisher::new(&boundary, &sections);
    if let Some(column) = which.column {
        let split = column_split(channel, params);
        sections.iter_mut().for_each(|section| *section = column_of(section, (column, split), params));
    }
    task.report("electrode", 0.5, "surfaces");
    let plan = Plan { channel, params, which, range, sections: &sections };
    let mut electrode = body::build(&plan, &finisher, &task.cancel)?;
    if room > 0.0 {
        electrode.assumed.push(format!(
            "It is {room:.4} mm smaller than the gap wants, all round, so that it keeps the gap between the points \
             that it is made from as well."
        ));
    }
    if electrode.clearance_mm < params.spark_gap_mm - SHORTFALL {
        electrode.assumed.push(format!(
            "It comes within {:.4} mm of the finished blisk: nearer than the gap, by less than a certificate tolerates.",
            electrode.clearance_mm
        ));
    }
    task.report("electrode", 1.0, "");
    Ok(electrode)
}

/// The span along the passage that is burned: that of the blades and the overrun, at most to the faces; past blades that
/// end bluntly or flush with the passage by the spark gap.
fn burning_extent(channel: &Channel, params: &ElectrodeParams) -> [f64; 2] {
    let [from, to] = channel.span_along();
    let [front, back] = channel.ends_along();
    let mut extent = [(from - params.overrun_mm).max(front.min(from)), (to + params.overrun_mm).min(back.max(to))];
    let ends = blade_ends(channel, params);
    for end in (0..2).filter(|&end| ends[end] != BladeEnd::Edge) {
        extent[end] = [from - params.spark_gap_mm, to + params.spark_gap_mm][end];
    }
    extent
}

/// The span along the passage of each part: from division to division, and at each by half of what its two parts share
/// themselves, which is their overlap less the gap that each burns beyond itself.
fn part_ranges(
    channel: &Channel,
    [first, last]: [f64; 2],
    params: &ElectrodeParams,
) -> Result<Vec<[f64; 2]>, ElectrodeError> {
    let shared = |overlap: f64| overlap - 2.0 * params.spark_gap_mm;
    let mut divisions = params.divisions(last - first, shared(params.overlap_mm));
    balance_parts(&mut divisions, channel, [first, last], params);
    let end = |part: usize, sense: f64| first + divisions[part] + sense * 0.5 * shared(params.overlap_after(part));
    let ranges: Vec<[f64; 2]> = (0..params.parts)
        .map(|part| {
            let from = if part == 0 { first } else { end(part - 1, -1.0) };
            [from, if part + 1 == params.parts { last } else { end(part, 1.0) }]
        })
        .collect();
    for (part, [from, to]) in ranges.iter().enumerate() {
        let neighbours = part.saturating_sub(1)..(part + 1).min(params.parts - 1);
        let overlap = neighbours.map(|before| params.overlap_after(before)).fold(0.0, f64::max);
        if params.parts > 1 && to - from < 2.0 * overlap {
            return Err(ElectrodeError::PartTooShort { part: part + 1, length: to - from, overlap });
        }
    }
    Ok(ranges)
}

/// Junctions where the burns of parts or columns share so little that stock may be left between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Junctions {
    /// Planes across X, or positions along a passage that is not axial (mm).
    pub planes: Vec<f64>,
    /// The share of the channel's width where two columns meet.
    pub split: Option<f64>,
}

impl Junctions {
    /// Junctions of electrodes made with `params`; none where the burns share more than the spark gap, so that each
    /// covers the other's rounded edge.
    ///
    /// # Errors
    /// If the parts are too short.
    pub fn of(channel: &Channel, params: &ElectrodeParams) -> Result<Self, ElectrodeError> {
        let gap = params.spark_gap_mm;
        let ranges = part_ranges(channel, burning_extent(channel, params), params)?;
        let meet = |part: usize| 0.5 * (ranges[part][1] + ranges[part + 1][0]);
        Ok(Self {
            planes: (1..params.parts).filter(|&k| params.overlap_after(k - 1) < gap).map(|k| meet(k - 1)).collect(),
            split: (params.columns > 1 && params.column_overlap_mm < gap).then(|| column_split(channel, params)),
        })
    }
}

/// Planes where the boundary stops following the edges of the blades.
fn edge_planes(channel: &Channel, params: &ElectrodeParams, extent: [f64; 2]) -> Vec<f64> {
    let ([from, to], gap) = (channel.span_along(), params.spark_gap_mm);
    let planes = [from - gap, from - 0.5 * gap, from, to, to + 0.5 * gap, to + gap];
    planes.into_iter().filter(|along| (extent[0]..=extent[1]).contains(along)).collect()
}

/// Planes between the burning part and the face on the side of entry, the face included.
fn runout(channel: &Channel, extent: [f64; 2], at_last: bool) -> Vec<f64> {
    let (end, sign) = if at_last { (1, 1.0) } else { (0, -1.0) };
    let (from, to) = (extent[end], channel.ends_along()[end]);
    if (to - from) * sign <= 1e-9 {
        return Vec::new();
    }
    let steps = (to - from).abs().ceil().clamp(1.0, 50.0) as usize;
    (1..=steps).map(|i| from + (to - from) * i as f64 / steps as f64).collect()
}

/// The share of the channel's width that belongs to the low column.
fn column_split(channel: &Channel, params: &ElectrodeParams) -> f64 {
    params.column_split.given().unwrap_or_else(|| balanced_split(channel))
}

/// The value within `range` up to which `is_too_great` denies, by halving. P1's first principle of division: two electrodes
/// that a value divides are as thick as each other, where each is thinnest and before any reduction. One gets thinner there
/// as the value rises, or the other as it falls.
fn balanced(mut range: [f64; 2], is_too_great: impl Fn(f64) -> bool) -> f64 {
    const HALVINGS: usize = 12;
    for _ in 0..HALVINGS {
        let value = 0.5 * (range[0] + range[1]);
        range[usize::from(is_too_great(value))] = value;
    }
    0.5 * (range[0] + range[1])
}

/// Points of both walls, those that face each other side by side.
struct Facing {
    pairs: Vec<[Cylindrical; 2]>,
    walls: [Vec<DVec3>; 2],
}

impl Facing {
    /// Points of a wall along the chord and across it, at most.
    const MOST: [usize; 2] = [61, 9];

    fn of(channel: &Channel) -> Self {
        let (low, high) = (&channel.low, &channel.high);
        let every = |count: usize, most: usize| (0..count).step_by((count - 1).div_ceil(most - 1).max(1));
        let grid = every(low.nu, Self::MOST[0]).flat_map(|u| every(low.nv, Self::MOST[1]).map(move |v| (u, v)));
        let pairs: Vec<[Cylindrical; 2]> = grid.map(|(u, v)| [low.cylindrical(u, v), high.cylindrical(u, v)]).collect();
        let walls = [0, 1].map(|wall| pairs.iter().map(|pair| pair[wall].point()).collect::<Vec<_>>());
        Self { pairs, walls }
    }

    /// The surface between the columns.
    fn middle(&self, split: f64) -> Vec<DVec3> {
        let between = |[a, b]: &[Cylindrical; 2]| {
            let mixed = |a: f64, b: f64| a + split * (b - a);
            Cylindrical { x: mixed(a.x, b.x), r: mixed(a.r, b.r), theta: mixed(a.theta, b.theta) }.point()
        };
        self.pairs.iter().map(between).collect()
    }
}

/// Distance of each point of `wall` from the points of another surface (mm).
fn thicknesses(wall: &[DVec3], other: &[DVec3]) -> impl Iterator<Item = f64> {
    let nearest = |p: &DVec3| other.iter().map(|q| p.distance_squared(*q)).fold(f64::INFINITY, f64::min).sqrt();
    wall.iter().map(nearest)
}

/// The share at which the columns are as thick as each other: electrodes of other reductions have the same surface between
/// them.
fn balanced_split(channel: &Channel) -> f64 {
    let facing = Facing::of(channel);
    balanced(COLUMN_SPLIT, |split| {
        let middle = facing.middle(split);
        let [low, high] = facing.walls.each_ref().map(|wall| thicknesses(wall, &middle).fold(f64::INFINITY, f64::min));
        low > high
    })
}

/// Moves those of the `divisions` that are not given, in mm from the first end of the burned `extent`, to where the parts on
/// both sides of them are as thick as each other, or as nearly as a place that leaves each of them a third of their length
/// makes them: the thinner part gets shorter.
fn balance_parts(divisions: &mut [f64], channel: &Channel, [first, last]: [f64; 2], params: &ElectrodeParams) {
    const LEAST: f64 = 1.0 / 3.0;
    let is_given = |i: usize| params.part.get(i).is_some_and(|part| part.until.is_some());
    if (0..divisions.len()).all(is_given) {
        return;
    }
    let facing = Facing::of(channel);
    let other = match params.columns {
        1 => [facing.walls[1].clone(), facing.walls[0].clone()],
        _ => [0, 1].map(|_| facing.middle(column_split(channel, params))),
    };
    let place = |p: &DVec3| channel.along_and_height(DVec2::new(p.x, p.y.hypot(p.z)))[0] - first;
    let of_wall = |i: usize| {
        let places = facing.walls[i].iter().map(place);
        places.zip(thicknesses(&facing.walls[i], &other[i])).collect::<Vec<_>>()
    };
    let all = [of_wall(0), of_wall(1)].concat();
    let least = |from: f64, to: f64| {
        let within = all.iter().filter(|(place, _)| (from..=to).contains(place));
        within.map(|(_, thickness)| *thickness).fold(f64::INFINITY, f64::min)
    };
    for i in (0..divisions.len()).filter(|i| !is_given(*i)) {
        let from = if i == 0 { 0.0 } else { divisions[i - 1] };
        let to = divisions.get(i + 1).copied().unwrap_or(last - first);
        let [least_place, most_place] = [LEAST, 1.0 - LEAST].map(|share| from + share * (to - from));
        let place = divisions[i].clamp(least_place, most_place);
        let [before, after] = [least(from, place), least(place, to)];
        divisions[i] = match before.total_cmp(&after) {
            Ordering::Equal => place,
            Ordering::Greater => balanced([place, most_place], |at| least(from, at) <= least(at, to)),
            Ordering::Less => balanced([least_place, place], |at| least(from, at) < least(at, to)),
        };
    }
}

/// Section that `column` burns: the wall on the other side gives way to the surface between the columns, moved by half
/// of what the columns share.
fn column_of(section: &Section, (column, split): (Column, f64), params: &ElectrodeParams) -> Section {
    let mut divided = section.clone();
    let shared = params.column_overlap_mm - 2.0 * params.spark_gap_mm;
    let [low, high] = &section.walls;
    let (other, sense) = match column {
        Column::Low => (1, 1.0),
        Column::High => (0, -1.0),
    };
    let between = |(a, b): (&Spot, &Spot)| {
        let height = a.height + split * (b.height - a.height);
        let middle = a.theta + split * (b.theta - a.theta);
        // However much they overlap, no column is wider than the channel.
        let theta = middle + sense * 0.5 * shared / section.line.radius(height);
        Spot { height, theta: theta.clamp(a.theta, b.theta) }
    };
    divided.walls[other] = low.iter().zip(high).map(between).collect();
    divided
}
