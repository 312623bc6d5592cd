//! Division left and right (P1): the channel's sections cut along its middle surface.

use super::boundary::{Polar, Section};
use super::{Column, ElectrodeParams};

/// What `column` burns of a section: the wall on the other side gives way to the surface between the columns, moved by
/// half of what the columns share. The whole section for no column.
pub(super) fn column_of(section: &Section, column: Option<Column>, params: &ElectrodeParams) -> Section {
    let mut divided = section.clone();
    let Some(column) = column else { return divided };
    let shared = params.column_overlap_mm - 2.0 * params.spark_gap_mm;
    let [low, high] = &section.walls;
    let (other, sense) = match column {
        Column::Low => (1, 1.0),
        Column::High => (0, -1.0),
    };
    let between = |(a, b): (&Polar, &Polar)| {
        let r = a.r + params.column_split * (b.r - a.r);
        let middle = a.theta + params.column_split * (b.theta - a.theta);
        // However much they overlap, no column is wider than the channel.
        let theta = middle + sense * 0.5 * shared / r;
        Polar { r, theta: theta.clamp(a.theta, b.theta) }
    };
    divided.walls[other] = low.iter().zip(high).map(between).collect();
    divided
}

/// Of the angles by which the low and the high wall are turned inwards those of `column`: the surface between the columns
/// stays (rad).
pub fn own_turns(column: Option<Column>, [low, high]: [f64; 2]) -> [f64; 2] {
    match column {
        None => [low, high],
        Some(Column::Low) => [low, 0.0],
        Some(Column::High) => [0.0, high],
    }
}
