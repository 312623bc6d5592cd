//! Colour maps of quantities on surfaces, and what a legend of one must say.

use std::sync::OnceLock;

use super::colour::Colour;

/// Number of colours in the table of a map.
pub const TABLE_SIZE: usize = 256;

/// A map from numbers to colours. The maps are our own: a few control points in Oklab (B. Ottosson, A
/// perceptual color space for image processing, 2020), between which lightness runs straight, so that equal
/// steps of the quantity look like equal steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ColourMap {
    /// Dark blue over green to light yellow: for quantities that only grow, such as a clearance. Readable in
    /// grey and by the colour-blind, because lightness rises all the way.
    Sequential,
    /// Blue over near white to red: for quantities with a middle, such as a deviation; the middle of the
    /// range is the light colour.
    Diverging,
    /// Red below the middle of the range, amber to green above: for a quantity with a required value in the
    /// middle, such as a clearance against its gap.
    Threshold,
    /// Blue over green to light yellow, none of it dark: for quantities on surfaces that lie in the shade or are seen
    /// edge on, such as what is left in the corners of a mold. Lightness rises all the way.
    Light,
}

/// Content of a legend beside its bar of colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// Name of the quantity.
    pub title: String,
    /// Unit.
    pub unit: String,
    /// The colours.
    pub map: ColourMap,
    /// Value at the start of the map.
    pub min: f64,
    /// Value at its end.
    pub max: f64,
    /// A value to be marked, such as the required gap.
    pub threshold: Option<f64>,
}

/// A control point: place along the map, then Oklab lightness, green-red and blue-yellow.
type Control = [f64; 4];

/// Lightness runs straight from 0.25 to 0.93 while the hue turns from violet blue to yellow.
const SEQUENTIAL: &[Control] = &[
    [0.00, 0.25, 0.030, -0.110],
    [0.25, 0.42, -0.045, -0.085],
    [0.50, 0.59, -0.100, 0.000],
    [0.75, 0.76, -0.095, 0.115],
    [1.00, 0.93, -0.030, 0.155],
];

/// The arms are equally long in lightness and in chroma.
const DIVERGING: &[Control] = &[
    [0.00, 0.40, -0.020, -0.140],
    [0.25, 0.67, -0.035, -0.090],
    [0.50, 0.94, 0.000, 0.005],
    [0.75, 0.67, 0.120, 0.065],
    [1.00, 0.40, 0.130, 0.070],
];

/// Two reds end at the threshold; amber begins there.
const THRESHOLD: &[Control] = &[
    [0.000, 0.38, 0.140, 0.075],
    [0.499, 0.60, 0.185, 0.100],
    [0.501, 0.80, 0.040, 0.140],
    [0.750, 0.74, -0.100, 0.115],
    [1.000, 0.60, -0.085, 0.020],
];

/// Lightness runs straight from 0.58 to 0.95; the hue turns as that of the sequential map does.
const LIGHT: &[Control] = &[
    [0.00, 0.580, 0.005, -0.140],
    [0.25, 0.672, -0.055, -0.080],
    [0.50, 0.765, -0.110, 0.010],
    [0.75, 0.857, -0.100, 0.110],
    [1.00, 0.950, -0.030, 0.150],
];

impl ColourMap {
    /// Every map, in the order of [`index`](Self::index).
    pub const ALL: [Self; 4] = [Self::Sequential, Self::Diverging, Self::Threshold, Self::Light];

    /// The colour at `t`, 0 to 1; beyond, that of the nearer end. NaN counts as 0.
    pub fn at(self, t: f64) -> Colour {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        self.table()[(t * (TABLE_SIZE - 1) as f64).round() as usize]
    }

    /// The colours at equal steps from 0 to 1.
    pub fn table(self) -> &'static [Colour; TABLE_SIZE] {
        static TABLES: [OnceLock<[Colour; TABLE_SIZE]>; ColourMap::ALL.len()] =
            [const { OnceLock::new() }; ColourMap::ALL.len()];
        TABLES[self.index()]
            .get_or_init(|| std::array::from_fn(|i| interpolated(self.controls(), i as f64 / (TABLE_SIZE - 1) as f64)))
    }

    /// Place in [`ALL`](Self::ALL).
    pub fn index(self) -> usize {
        self as usize
    }

    fn controls(self) -> &'static [Control] {
        match self {
            Self::Sequential => SEQUENTIAL,
            Self::Diverging => DIVERGING,
            Self::Threshold => THRESHOLD,
            Self::Light => LIGHT,
        }
    }
}

impl Legend {
    /// The colour of `value`.
    pub fn colour(&self, value: f64) -> Colour {
        self.map.at((value - self.min) / (self.max - self.min))
    }

    /// Position of `value` along the bar, 0 at `min` and 1 at `max`, clipped.
    pub fn place(&self, value: f64) -> f64 {
        let t = (value - self.min) / (self.max - self.min);
        if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
    }

    /// Round values to write beside the bar, from `min` to `max`, about `count` of them; of a map with a middle its
    /// ends, the middle and, where there is room, what lies half way.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        let span = self.max - self.min;
        if !(span > 0.0 && span.is_finite()) || count == 0 {
            return vec![self.min];
        }
        if self.map == ColourMap::Diverging {
            let parts = if count < 4 { 2u32 } else { 4 };
            return (0..=parts).map(|i| self.min + span * f64::from(i) / f64::from(parts)).collect();
        }
        let rough = span / count as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|&s| s >= rough * 0.999);
        let step = step.unwrap_or(10.0 * decade);
        let first = (self.min / step - 1e-9).ceil() as i64;
        let last = (self.max / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

fn interpolated(controls: &[Control], t: f64) -> Colour {
    let after = controls.iter().position(|c| c[0] >= t).unwrap_or(controls.len() - 1).max(1);
    let (a, b) = (&controls[after - 1], &controls[after]);
    let s = ((t - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
    Colour::from_linear(oklab_to_linear([1, 2, 3].map(|i| a[i] + (b[i] - a[i]) * s)))
}

/// Oklab to linear sRGB.
fn oklab_to_linear([l, a, b]: [f64; 3]) -> [f64; 3] {
    let long = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightness after CIE 1976, 0 to 100: another scale than the one the maps are made in.
    fn lightness(colour: Colour) -> f64 {
        let [r, g, b] = colour.to_linear();
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn maps_of_what_only_grows_rise_evenly_in_lightness() {
        for (map, start, least_rise) in [(ColourMap::Sequential, 0.0, 60.0), (ColourMap::Light, 48.0, 40.0)] {
            let table = map.table().map(lightness);
            let rise = table[255] - table[0];
            assert!(rise > least_rise && table[0] > start, "{map:?}: {rise} from {}", table[0]);
            // Every sixteenth of the way is a like step, within what 8 bits and the two scales allow.
            for pair in table.chunks(16).map(|c| c[0]).collect::<Vec<_>>().windows(2) {
                assert!((pair[1] - pair[0] - rise / 16.0).abs() < 0.45 * rise / 16.0, "{map:?} {pair:?}");
            }
        }
    }

    #[test]
    fn the_diverging_map_is_lightest_in_the_middle_and_its_arms_are_blue_and_red() {
        let map = ColourMap::Diverging;
        for i in 0..100 {
            let t = f64::from(i) / 200.0;
            assert!(lightness(map.at(t)) <= lightness(map.at(0.5)) && lightness(map.at(1.0 - t)) <= 95.5);
            assert!((lightness(map.at(t)) - lightness(map.at(1.0 - t))).abs() < 14.0, "{t}");
        }
        assert!(map.at(0.1).b > map.at(0.1).r && map.at(0.9).r > map.at(0.9).b);
    }

    #[test]
    fn the_threshold_is_where_red_ends() {
        let map = ColourMap::Threshold;
        assert!(map.at(0.49).r > 2 * map.at(0.49).g);
        assert!(map.at(0.51).g > 120 && map.at(0.9).g > map.at(0.9).r);
    }

    #[test]
    fn beyond_the_range_the_ends_hold() {
        for map in ColourMap::ALL {
            assert_eq!((map.at(-3.0), map.at(7.0)), (map.at(0.0), map.at(1.0)));
            assert_eq!(map.at(f64::NAN), map.at(0.0));
            assert_eq!(ColourMap::ALL[map.index()], map);
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        let legend = Legend {
            title: "Clearance".into(),
            unit: "mm".into(),
            map: ColourMap::Sequential,
            min: 0.07,
            max: 1.03,
            threshold: None,
        };
        let ticks = legend.ticks(5);
        assert_eq!(ticks.len(), 5);
        for (tick, expected) in ticks.iter().zip([0.2, 0.4, 0.6, 0.8, 1.0]) {
            assert!((tick - expected).abs() < 1e-12);
        }
        let both = Legend { map: ColourMap::Diverging, min: -0.5, max: 0.5, ..legend.clone() };
        assert_eq!((both.ticks(5), both.ticks(2)), (vec![-0.5, -0.25, 0.0, 0.25, 0.5], vec![-0.5, 0.0, 0.5]));
        assert_eq!(Legend { max: 0.07, ..legend }.ticks(5), vec![0.07]);
    }
}
