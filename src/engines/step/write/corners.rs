//! Choice of the four corners of a free form.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use super::piece::Piece;

/// Corners that are looked at, at most, in the order of their turns, and further places along the line.
const MOST: [usize; 2] = [16, 16];
/// Weight of unequal lengths of opposite sides against the turn of one corner.
const UNEVEN: f64 = 0.2;
/// Worth of a corner where chains end anyway.
const END: f64 = 0.15;

/// The places in the line around a disc where its four sides begin, rising; none if it has fewer than four vertices.
///
/// Best are four places where the line turns by a quarter, with opposite sides of equal lengths.
pub(super) fn corners(piece: &Piece, ends: &BTreeSet<u32>) -> Option<[usize; 4]> {
    let line = piece.loops.first()?;
    let n = line.len();
    if n < 4 {
        return None;
    }
    let point = |k: usize| piece.points[line[k % n] as usize];
    let mut along = vec![0.0];
    for k in 0..n {
        along.push(along[k] + point(k).distance(point(k + 1)));
    }
    let turns = piece.turns();
    let worth: Vec<f64> = (0..n)
        .map(|k| {
            let turn = turns[line[k] as usize];
            let is_end = ends.contains(&piece.of_skin[line[k] as usize]);
            (1.0 - (turn - FRAC_PI_2).abs() / FRAC_PI_2).max(-1.0) + if is_end { END } else { 0.0 }
        })
        .collect();
    let places = candidates(&worth, &along);
    best(&places, &worth, &along)
}

/// Places that may become corners, rising.
fn candidates(worth: &[f64], along: &[f64]) -> Vec<usize> {
    let n = worth.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| worth[b].total_cmp(&worth[a]).then(a.cmp(&b)));
    let mut places: Vec<usize> = order.into_iter().take(MOST[0]).collect();
    for k in 0..MOST[1] {
        let length = along[n] * k as f64 / MOST[1] as f64;
        places.push(along.partition_point(|&s| s < length).min(n - 1));
    }
    places.sort_unstable();
    places.dedup();
    places
}

fn best(places: &[usize], worth: &[f64], along: &[f64]) -> Option<[usize; 4]> {
    let whole = along[worth.len()];
    let mut best: Option<(f64, [usize; 4])> = None;
    for (i, &a) in places.iter().enumerate() {
        for (j, &b) in places.iter().enumerate().skip(i + 1) {
            for (k, &c) in places.iter().enumerate().skip(j + 1) {
                for &d in &places[k + 1..] {
                    let sides =
                        [along[b] - along[a], along[c] - along[b], along[d] - along[c], whole - along[d] + along[a]];
                    let uneven = (sides[0] / sides[2]).ln().abs() + (sides[1] / sides[3]).ln().abs();
                    let score = worth[a] + worth[b] + worth[c] + worth[d] - UNEVEN * uneven;
                    if !score.is_nan() && best.is_none_or(|b| score > b.0) {
                        best = Some((score, [a, b, c, d]));
                    }
                }
            }
        }
    }
    best.map(|b| b.1)
}
