//! Wheels at random, of all kinds in turn, as parts for tests.

use std::f64::consts::TAU;

use glam::DVec2;

use super::wheel::{MeridianCurve, ParametricWheel, Splitters};
use crate::channel::Flow;

/// Numbers from 0 to 1 at random, always the same after one seed (SplitMix64).
pub fn shares(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Curves of hub and shroud of a wheel whose size is about 100 mm.
fn curves(flow: Flow, share: &mut dyn FnMut() -> f64) -> [MeridianCurve; 2] {
    let [a, b, c, d, e]: [f64; 5] = std::array::from_fn(|_| share());
    let at = DVec2::new;
    // Straight from end to end, but bowed by up to a tenth of the length.
    let bowed = |from: DVec2, to: DVec2, bow: [f64; 2]| {
        let MeridianCurve([p, mut q, mut s, t]) = MeridianCurve::line(from, to);
        q += 0.2 * (bow[0] - 0.5) * (to - from).perp();
        s += 0.2 * (bow[1] - 0.5) * (to - from).perp();
        MeridianCurve([p, q, s, t])
    };
    match flow {
        Flow::Axial => {
            let (length, r, height) = (15.0 + 25.0 * a, 30.0 + 30.0 * b, 9.0 + 10.0 * c);
            let hub = bowed(at(0.0, r), at(length, r * (0.95 + 0.2 * d)), [e, a]);
            let end = hub.0[3] + at(0.0, height * (0.7 + 0.6 * b));
            [hub, bowed(at(0.0, r + height), end, [c, d])]
        }
        Flow::Mixed => {
            let (eye, height, rim) = (12.0 + 10.0 * a, 12.0 + 8.0 * b, 60.0 + 20.0 * c);
            let (length, width) = (30.0 + 20.0 * d, 7.0 + 5.0 * e);
            let hub = MeridianCurve::quarter(at(0.0, eye), DVec2::X, at(length, rim));
            [hub, MeridianCurve::quarter(at(0.0, eye + height), DVec2::X, at(length - width, rim))]
        }
        Flow::Radial => {
            let (from, to) = (35.0 + 15.0 * a, 65.0 + 20.0 * b);
            let widths = [8.0 + 6.0 * c, 8.0 + 6.0 * d];
            let hub = bowed(at(0.0, from), at(4.0 * e - 2.0, to), [0.5, 0.5 + 0.3 * (a - 0.5)]);
            [hub, bowed(at(widths[0], from), at(hub.0[3].x + widths[1], to), [0.5, 0.5])]
        }
    }
}

/// Wheel number `number` and its direction of flow. Kinds come in turn: directions of flow, with and without a shroud,
/// without splitters, with splitters in the middle between the blades and off it, outward and inward. All else is at
/// random, as how thick the splitters are and whether they are of two kinds.
pub fn random_wheel(number: usize, share: &mut dyn FnMut() -> f64) -> (ParametricWheel, Flow) {
    let flow = [Flow::Axial, Flow::Mixed, Flow::Radial][number % 3];
    let shrouded = number % 6 < 3;
    let splitting = (number + number / 3) % 3;
    let [hub, shroud] = curves(flow, share);
    let least = (0..=40).map(|i| hub.at(f64::from(i) / 40.0).y.min(shroud.at(f64::from(i) / 40.0).y));
    let least = least.fold(f64::INFINITY, f64::min);
    // Passages at least 4 mm wide, with splitters between blades twice as far apart.
    let most = ((TAU * least / 7.0) as usize).max(5);
    let blades = ((5.0 + 25.0 * share()) as usize).min(most);
    let blades = if splitting > 0 { (2 * (blades / 2)).max(6) } else { blades };
    let pitch = TAU / blades as f64;
    let thickness_mm = (pitch * least) * (0.08 + 0.2 * share());
    let middle = [hub.at(0.5), shroud.at(0.5)];
    let length = (0..20).map(|i| f64::from(i) / 20.0).map(|t| hub.at(t).distance(hub.at(t + 0.05))).sum::<f64>();
    // Blades lean by up to 50 degrees off the meridional plane.
    let steep = (50.0 * share()).to_radians().tan() * if share() < 0.5 { 1.0 } else { -1.0 };
    let wrap = steep * length / (0.5 * (middle[0].y + middle[1].y));
    let height = hub.at(1.0).distance(shroud.at(1.0)).min(hub.at(0.0).distance(shroud.at(0.0)));
    let passage = pitch * least - thickness_mm;
    let rounding = share();
    let fillet_mm = if rounding < 0.4 { 0.0 } else { (rounding * 0.15 * height).min(0.15 * passage) };
    let off_middle = if splitting == 2 { 0.08 * pitch } else { 0.0 };
    let splitters = (splitting > 0).then(|| Splitters { off_middle, ..Splitters::over([0.35 + 0.2 * share(), 0.92]) });
    let lean = 0.3 * (share() - 0.5);
    let edge = share();
    // Of some the flow runs inwards, and splitters stand at the end of smaller radius.
    let inward = (number / 18) % 2 == 1;
    let reversed = |[from, to]: [f64; 2]| if inward { [1.0 - to, 1.0 - from] } else { [from, to] };
    let splitters = splitters.map(|s| Splitters { span: reversed(s.span), ..s }).into_iter().collect();
    let mut wheel = ParametricWheel {
        blades,
        hub,
        shroud,
        shrouded,
        span: reversed([0.1, 0.92]),
        splitters,
        wrap: [wrap; 2],
        lean,
        thickness_mm,
        nose: if edge < 0.3 { 0.0 } else { 0.06 * edge },
        fillet_mm,
        fillets_round_edges: rounding > 0.7,
        wall_mm: 4.0,
        teeth: (8.0 * share()) as usize,
        holes: if share() < 0.33 { 6 } else { 0 },
        pieces: [180, 64, 8],
        ..ParametricWheel::nozzle_ring()
    };
    // Splitters may be thinner, and of two kinds in an even pitch.
    let is_of_two = share() < 0.5 && blades.is_multiple_of(3) && blades >= 9;
    if let [first] = &mut wheel.splitters[..] {
        first.thickness = 0.3 + 0.7 * share();
        if is_of_two {
            let second =
                Splitters { thickness: first.thickness, ..Splitters::over(reversed([0.55 + 0.1 * share(), 0.92])) };
            first.off_middle = 0.0;
            wheel.splitters.push(second);
        }
    }
    (wheel, flow)
}
