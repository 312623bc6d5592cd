//! Making the electrodes of a channel: its division into parts and columns (P1), and the junctions between them.

use super::body::{self, Plan};
use super::boundary::{Boundary, Section, Spot, flush_ends};
use super::ring::Finisher;
use super::{Column, Electrode, ElectrodeError, ElectrodeParams, EntrySide};
use crate::channel::Channel;
use geometry::exact::ExactMesh;
use task::Task;

/// What is built may miss the gap between its points; then it is built again, by that and [`SPARE`] smaller, at most by
/// this (mm).
const MOST_ROOM: f64 = 0.02;
const SPARE: f64 = 2e-4;
const MOST_ATTEMPTS: usize = 3;

/// Makes the electrodes of `channel`, in the order of burning: the part next to the side of entry first, and of each
/// part the low column first.
///
/// `blisk` is the finished blisk in W. The result does not depend on the number of threads.
///
/// # Errors
/// An [`ElectrodeError`] that says where the channel leaves no room for the wanted gap and reductions.
pub fn make_electrodes(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    side: EntrySide,
    task: &Task,
) -> Result<Vec<Electrode>, ElectrodeError> {
    params.validate()?;
    let mut room = 0.0;
    for _ in 0..MOST_ATTEMPTS {
        match with_room(channel, blisk, params, (side, room), task) {
            Err(ElectrodeError::TooClose { clearance, gap, .. }) if room + gap - clearance + SPARE < MOST_ROOM => {
                room += gap - clearance + SPARE;
            }
            made => return made,
        }
    }
    with_room(channel, blisk, params, (side, room), task)
}

/// The electrodes, built `room` (mm) farther from the blisk than the gap wants.
fn with_room(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    (side, room): (EntrySide, f64),
    task: &Task,
) -> Result<Vec<Electrode>, ElectrodeError> {
    let at_last = side.mouth(channel)?;
    task.report("electrode", 0.0, "boundary of the channel");
    let boundary = Boundary::new(channel, blisk, params, room)?;
    let extent = burning_extent(channel, params);
    let ranges = part_ranges(extent, params, at_last)?;
    let mut planes: Vec<f64> = ranges.iter().flatten().copied().collect();
    planes.extend(edge_planes(channel, params, extent));
    planes.extend(runout(channel, extent, at_last));
    let sections = boundary.sections(extent, &planes, &task.cancel)?;
    let finisher = Finisher::new(&boundary, &sections);
    let mut electrodes = Vec::with_capacity(params.count());
    let columns: &[Option<Column>] =
        if params.columns > 1 { &[Some(Column::Low), Some(Column::High)] } else { &[None] };
    for &column in columns {
        let sections: Vec<_> = sections.iter().map(|s| column_of(s, column, params)).collect();
        for (part, &range) in ranges.iter().enumerate() {
            task.report("electrode", (electrodes.len() + 1) as f64 / (params.count() + 1) as f64, "surfaces");
            let plan = Plan { channel, params, side, at_last, part, column, range, sections: &sections };
            let mut electrode = body::build(&plan, &finisher, &task.cancel)?;
            if room > 0.0 {
                electrode.assumed.push(format!(
                    "It is {room:.4} mm smaller than the gap wants, all round, so that it keeps the gap between the points \
                     that it is made from as well."
                ));
            }
            electrodes.push(electrode);
        }
    }
    electrodes.sort_by_key(|e| e.part);
    task.report("electrode", 1.0, "");
    Ok(electrodes)
}

/// The span along the passage that is burned: that of the blades and the overrun, at most to the faces; past blades that
/// end flush with the passage by the spark gap, where the electrode is out of the blisk.
fn burning_extent(channel: &Channel, params: &ElectrodeParams) -> [f64; 2] {
    let [from, to] = channel.span_along();
    let [front, back] = channel.ends_along();
    let mut extent = [(from - params.overrun_mm).max(front.min(from)), (to + params.overrun_mm).min(back.max(to))];
    for end in flush_ends(channel, params) {
        extent[end] = [from - params.spark_gap_mm, to + params.spark_gap_mm][end];
    }
    extent
}

/// The span along the passage of each part, counted from the side of entry, which is that of the last station or not.
fn part_ranges(extent: [f64; 2], params: &ElectrodeParams, at_last: bool) -> Result<Vec<[f64; 2]>, ElectrodeError> {
    let (parts, shared) = (params.parts, params.shared_length());
    let length = (extent[1] - extent[0] + (parts - 1) as f64 * shared) / parts as f64;
    if parts > 1 && length < 2.0 * params.overlap_mm {
        return Err(ElectrodeError::PartsTooShort { parts, length, overlap: params.overlap_mm });
    }
    let mut ranges: Vec<_> = (0..parts)
        .map(|k| extent[0] + k as f64 * (length - shared))
        .map(|from| [from, (from + length).min(extent[1])])
        .collect();
    if let Some(last) = ranges.last_mut() {
        last[1] = extent[1];
    }
    if at_last {
        ranges.reverse();
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
        let ranges = part_ranges(burning_extent(channel, params), params, false)?;
        let meet = ranges.windows(2).map(|pair| 0.5 * (pair[0][1] + pair[1][0]));
        Ok(Self {
            planes: if params.overlap_mm < gap { meet.collect() } else { Vec::new() },
            split: (params.columns > 1 && params.column_overlap_mm < gap).then_some(params.column_split),
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

/// Section that `column` burns: the wall on the other side gives way to the surface between the columns, moved by half
/// of what the columns share. The whole section where there are no columns.
fn column_of(section: &Section, column: Option<Column>, params: &ElectrodeParams) -> Section {
    let mut divided = section.clone();
    let Some(column) = column else { return divided };
    let shared = params.column_overlap_mm - 2.0 * params.spark_gap_mm;
    let [low, high] = &section.walls;
    let (other, sense) = match column {
        Column::Low => (1, 1.0),
        Column::High => (0, -1.0),
    };
    let between = |(a, b): (&Spot, &Spot)| {
        let height = a.height + params.column_split * (b.height - a.height);
        let middle = a.theta + params.column_split * (b.theta - a.theta);
        // However much they overlap, no column is wider than the channel.
        let theta = middle + sense * 0.5 * shared / section.line.radius(height);
        Spot { height, theta: theta.clamp(a.theta, b.theta) }
    };
    divided.walls[other] = low.iter().zip(high).map(between).collect();
    divided
}
