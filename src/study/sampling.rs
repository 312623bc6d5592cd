//! Points of a study: which values its parameters have.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::definition::{MOST_POINTS, Method, Sampling};
use files::Invalid;

/// A parameter with its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Key of the parameter.
    pub key: String,
    /// Values of the parameter.
    pub values: Values,
}

/// Values of a parameter, as the command line would give them.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// A list.
    List(Vec<String>),
    /// The numbers between two.
    Range {
        /// Least.
        from: f64,
        /// Greatest.
        to: f64,
        /// Number of values that a grid or a list takes, both ends included.
        steps: Option<usize>,
        /// Whether only whole numbers are meant.
        is_whole: bool,
    },
}

/// Digits of a range that a value in it has: enough for any machine, and short to read.
const DIGITS: f64 = 9.0;

impl Values {
    /// Every value.
    ///
    /// # Errors
    /// A range whose number of values is not known or too large.
    fn all(&self) -> Result<Vec<String>, Invalid> {
        let (from, to, steps, is_whole) = match self {
            Self::List(values) => return Ok(values.clone()),
            Self::Range { from, to, steps, is_whole } => (*from, *to, *steps, *is_whole),
        };
        let count = match steps {
            Some(steps) => steps,
            None if is_whole && to - from < MOST_POINTS as f64 => (to - from) as usize + 1,
            None if is_whole => return Err(Invalid::of("to", format!("at most {MOST_POINTS} values are possible"))),
            None => return Err(Invalid::of("steps", "it is missing; give the number of values, both ends included")),
        };
        let at = |i: usize| from + (to - from) * (i as f64 / (count - 1).max(1) as f64);
        let values: Vec<String> = (0..count).map(|i| tidy(at(i), [from, to]).to_string()).collect();
        let is_broken = |text: &&String| is_whole && text.contains('.');
        match values.iter().find(is_broken) {
            Some(value) => Err(Invalid::new(
                "steps",
                count,
                format!("gives {value}, which is no whole number; leave steps out for every whole number"),
            )),
            None => Ok(values),
        }
    }

    /// The value at a share of the whole, from 0 to below 1.
    fn at(&self, share: f64) -> String {
        match self {
            Self::List(values) => {
                values[((share * values.len() as f64) as usize).min(values.len().saturating_sub(1))].clone()
            }
            Self::Range { from, to, is_whole: true, .. } => {
                (from + (share * (to - from + 1.0)).floor()).min(*to).to_string()
            }
            Self::Range { from, to, .. } => tidy(from + share * (to - from), [*from, *to]).to_string(),
        }
    }
}

/// `value` with no more digits than the range has any use for.
fn tidy(value: f64, [from, to]: [f64; 2]) -> f64 {
    let places = (DIGITS - (to - from).log10().floor()).clamp(0.0, 15.0);
    let scale = 10f64.powf(places);
    let rounded = (value * scale).round() / scale;
    // A negative zero is no other value than zero.
    if rounded.is_finite() { rounded.clamp(from, to) + 0.0 } else { value }
}

/// The points: for each the values of the parameters in their order.
///
/// # Errors
/// [`Invalid`] if there are too many, or if the parameters of a list do not have equally many values.
pub fn points(axes: &[Axis], sampling: &Sampling) -> Result<Vec<Vec<String>>, Invalid> {
    let all = || -> Result<Vec<Vec<String>>, Invalid> {
        let of = |(i, axis): (usize, &Axis)| axis.values.all().map_err(|e| e.within(&format!("parameter[{i}]")));
        axes.iter().enumerate().map(of).collect()
    };
    match (sampling.method, sampling.count) {
        (Method::Grid, _) => grid(&all()?),
        (Method::List, _) => list(&all()?),
        (Method::Random, count) => Ok(random(axes, count.unwrap_or_default(), sampling.seed)),
        (Method::Latin, count) => Ok(latin(axes, count.unwrap_or_default(), sampling.seed)),
    }
}

fn grid(all: &[Vec<String>]) -> Result<Vec<Vec<String>>, Invalid> {
    let count = all.iter().try_fold(1_usize, |count, values| count.checked_mul(values.len()));
    let Some(count) = count.filter(|count| (1..=MOST_POINTS).contains(count)) else {
        let sizes: Vec<String> = all.iter().map(|values| values.len().to_string()).collect();
        let remedy = format!("a grid may have from 1 to {MOST_POINTS} points; give fewer values, or draw samples");
        return Err(Invalid::new("parameter", sizes.join(" x "), remedy));
    };
    let point = |number: usize| {
        let mut rest = number;
        let mut point: Vec<String> = all
            .iter()
            .rev()
            .map(|values| {
                let value = values[rest % values.len()].clone();
                rest /= values.len();
                value
            })
            .collect();
        point.reverse();
        point
    };
    Ok((0..count).map(point).collect())
}

fn list(all: &[Vec<String>]) -> Result<Vec<Vec<String>>, Invalid> {
    let count = all.first().map_or(0, Vec::len);
    if let Some(i) = all.iter().position(|values| values.len() != count) {
        let remedy = format!("a list needs as many values of each parameter: the first one has {count}");
        return Err(Invalid::new(format!("parameter[{i}]"), format!("{} values", all[i].len()), remedy));
    }
    Ok((0..count).map(|i| all.iter().map(|values| values[i].clone()).collect()).collect())
}

/// A generator for each parameter, so that one more of them changes nothing of the others.
fn generator(seed: u64, parameter: usize) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(parameter as u64);
    generator
}

fn random(axes: &[Axis], count: usize, seed: u64) -> Vec<Vec<String>> {
    let mut generators: Vec<ChaCha8Rng> = (0..axes.len()).map(|j| generator(seed, j)).collect();
    let mut point = || axes.iter().zip(&mut generators).map(|(axis, random)| axis.values.at(random.random())).collect();
    (0..count).map(|_| point()).collect()
}

fn latin(axes: &[Axis], count: usize, seed: u64) -> Vec<Vec<String>> {
    let of = |(j, axis): (usize, &Axis)| -> Vec<String> {
        let mut random = generator(seed, j);
        let mut parts: Vec<usize> = (0..count).collect();
        // Each order is as likely as any other.
        for last in (1..count).rev() {
            parts.swap(last, random.random_range(0..=last));
        }
        let within = |part: usize| (part as f64 + random.random::<f64>()) / count as f64;
        parts.into_iter().map(within).map(|share| axis.values.at(share)).collect()
    };
    let columns: Vec<Vec<String>> = axes.iter().enumerate().map(of).collect();
    (0..count).map(|i| columns.iter().map(|column| column[i].clone()).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn axis(values: Values) -> Axis {
        Axis { key: "a".to_owned(), values }
    }

    fn range(from: f64, to: f64, steps: Option<usize>, is_whole: bool) -> Axis {
        axis(Values::Range { from, to, steps, is_whole })
    }

    fn words(words: &[&str]) -> Axis {
        axis(Values::List(words.iter().map(|&word| word.to_owned()).collect()))
    }

    fn sampling(method: Method, count: Option<usize>, seed: u64) -> Sampling {
        Sampling { method, count, seed }
    }

    fn numbers(points: &[Vec<String>], axis: usize) -> Vec<f64> {
        points.iter().map(|point| point[axis].parse().unwrap()).collect()
    }

    #[test]
    fn a_grid_has_every_combination_and_the_last_parameter_changes_first() {
        let axes = [words(&["x", "y"]), range(0.1, 0.3, Some(3), false), range(4.0, 5.0, None, true)];
        let points = points(&axes, &Sampling::default()).unwrap();
        let lines: Vec<String> = points.iter().map(|point| point.join(" ")).collect();
        assert_eq!(lines[..4], ["x 0.1 4", "x 0.1 5", "x 0.2 4", "x 0.2 5"]);
        assert_eq!((lines.len(), lines[11].as_str()), (12, "y 0.3 5"));
    }

    #[test]
    fn a_list_takes_the_values_side_by_side() {
        let list = sampling(Method::List, None, 1);
        let axes = [words(&["x", "y", "z"]), range(1.0, 3.0, None, true)];
        let lines: Vec<String> = points(&axes, &list).unwrap().iter().map(|point| point.join(" ")).collect();
        assert_eq!(lines, ["x 1", "y 2", "z 3"]);
        let said = points(&[words(&["x"]), words(&["y", "z"])], &list).unwrap_err().to_string();
        assert_eq!(
            said,
            "parameter[1] is 2 values: a list needs as many values of each parameter: the first one has 1"
        );
    }

    #[test]
    fn too_many_points_and_values_that_cannot_be_are_refused() {
        for (axes, words) in [
            (vec![range(1.0, 1000.0, None, true), range(1.0, 101.0, None, true)], "parameter is 1000 x 101: a grid"),
            (vec![range(0.0, 1.0, None, false)], "parameter[0].steps: it is missing"),
            (vec![range(0.0, 1e9, None, true)], "parameter[0].to: at most 100000 values"),
            (vec![range(0.0, 5.0, Some(3), true)], "parameter[0].steps is 3: gives 2.5, which is no whole number"),
        ] {
            let said = points(&axes, &Sampling::default()).unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
    }

    proptest! {
        #[test]
        fn a_latin_hypercube_has_one_point_in_each_part_of_every_range(count in 1_usize..200, seed: u64, from in -1e3..1e3f64, wide in 1e-3..1e4f64) {
            let letters: Vec<String> = (0..count).map(|i| i.to_string()).collect();
            let axes = [range(from, from + wide, None, false), axis(Values::List(letters)), range(1.0, count as f64, None, true)];
            let points = points(&axes, &sampling(Method::Latin, Some(count), seed)).unwrap();
            prop_assert_eq!(points.len(), count);
            let mut parts: Vec<usize> = Vec::new();
            for value in numbers(&points, 0) {
                prop_assert!((from..=from + wide).contains(&value));
                parts.push((((value - from) / wide * count as f64) as usize).min(count - 1));
            }
            parts.sort_unstable();
            prop_assert_eq!(parts, (0..count).collect::<Vec<_>>());
            // As many values as points: each once.
            for (j, first) in [(1, 0.0), (2, 1.0)] {
                let mut all = numbers(&points, j);
                all.sort_by(f64::total_cmp);
                prop_assert_eq!(all, (0..count).map(|i| first + i as f64).collect::<Vec<_>>());
            }
        }

        #[test]
        fn random_points_lie_within_and_more_of_them_begin_with_the_same(count in 1_usize..100, seed: u64) {
            let axes = [range(-0.25, 0.75, None, false), words(&["x", "y", "z"]), range(-2.0, 2.0, None, true)];
            let drawn = |count| points(&axes, &sampling(Method::Random, Some(count), seed)).unwrap();
            let points = drawn(count);
            prop_assert!(numbers(&points, 0).iter().all(|v| (-0.25..=0.75).contains(v)));
            prop_assert!(points.iter().all(|point| ["x", "y", "z"].contains(&point[1].as_str())));
            prop_assert!(numbers(&points, 2).iter().all(|v| (-2.0..=2.0).contains(v) && v.fract() == 0.0));
            prop_assert_eq!(&drawn(count + 10)[..count], &points[..]);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_points_and_another_one_others() {
        let axes = [range(0.0, 1.0, None, false), range(0.0, 1.0, None, false)];
        for method in [Method::Random, Method::Latin] {
            let of = |seed| points(&axes, &sampling(method, Some(50), seed)).unwrap();
            assert_eq!(of(7), of(7));
            assert_ne!(of(7), of(8));
            assert!(of(7).iter().any(|point| point[0] != point[1]), "parameters are drawn apart");
        }
    }
}
