//! The points that no other point is better than.

/// Membership of `costs` in the Pareto front: no other is as good in each cost, and better in one. Less is better. Points
/// without costs, or with other than finite ones, are not compared.
pub fn front(costs: &[Option<Vec<f64>>]) -> Vec<bool> {
    let is_known = |costs: &&[f64]| !costs.is_empty() && costs.iter().all(|cost| cost.is_finite());
    let of = |i: usize| costs[i].as_deref().filter(is_known);
    let mut order: Vec<(usize, &[f64])> = (0..costs.len()).filter_map(|i| Some((i, of(i)?))).collect();
    // By the first cost, then by the next: whoever is better than a point comes before it.
    order.sort_by(|(_, a), (_, b)| {
        a.iter().zip(*b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    let is_better = |a: &[f64], b: &[f64]| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
    let mut best: Vec<&[f64]> = Vec::new();
    let mut is_best = vec![false; costs.len()];
    for (i, own) in order {
        if best.iter().any(|other| is_better(other, own)) {
            continue;
        }
        is_best[i] = true;
        // Equal points need to be compared with once.
        if best.last() != Some(&own) {
            best.push(own);
        }
    }
    is_best
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn equal_points_are_best_together_and_unknown_ones_never() {
        let points =
            [Some(vec![1.0, 2.0]), Some(vec![1.0, 2.0]), Some(vec![1.0, 3.0]), None, Some(vec![f64::NAN, 0.0])];
        assert_eq!(front(&points), [true, true, false, false, false]);
        assert_eq!(front(&[Some(vec![])]), [false]);
    }

    proptest! {
        #[test]
        fn a_point_is_best_if_and_only_if_no_other_is_better(
            points in prop::collection::vec(prop::collection::vec(0..5_u8, 3), 0..40)
        ) {
            let costs: Vec<Vec<f64>> = points.iter().map(|p| p.iter().map(|&c| f64::from(c)).collect()).collect();
            let all: Vec<Option<Vec<f64>>> = costs.iter().cloned().map(Some).collect();
            let is_better = |a: &Vec<f64>, b: &Vec<f64>| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
            let expected: Vec<bool> = costs.iter().map(|b| !costs.iter().any(|a| is_better(a, b))).collect();
            prop_assert_eq!(front(&all), expected);
        }
    }
}
