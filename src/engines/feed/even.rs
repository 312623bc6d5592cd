//! Numbers that fill a space evenly, the same every time.

/// Number `n` of a sequence that fills a cube of five dimensions evenly, along dimension `k`, from 0 to 1: an additive
/// recurrence by powers of the generalised golden ratio, the root of `x^6 = x + 1`.
pub(super) fn even(n: f64, k: usize) -> f64 {
    const RATIO: f64 = 1.134_724_138_401_519_4;
    (0.5 + n * RATIO.powi(-(k as i32 + 1))).fract()
}

#[cfg(test)]
mod tests {
    use super::even;

    #[test]
    fn every_part_of_the_space_gets_its_share() {
        for k in 0..5 {
            let mut parts = [0; 8];
            (0..800).for_each(|n| parts[(even(f64::from(n), k) * 8.0) as usize] += 1);
            assert!(parts.iter().all(|&n| (85..=115).contains(&n)), "{k}: {parts:?}");
        }
        let ratio: f64 = 1.134_724_138_401_519_4;
        assert!((ratio.powi(6) - ratio - 1.0).abs() < 1e-12);
    }
}
