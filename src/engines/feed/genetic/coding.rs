//! Binary coding of axis motions, P0's equations (8) and (9).

/// Coding of a variable as a binary number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coding {
    /// L: least value (mm or rad).
    pub lower: f64,
    /// U: greatest value (mm or rad).
    pub upper: f64,
    /// N: number of bits.
    pub bits: u32,
}

impl Coding {
    /// The coding of values from `lower` to `upper` to `precision`: (8), the least N with
    /// `D = (U - L) / precision < 2^N`, at most 30.
    pub fn new(lower: f64, upper: f64, precision: f64) -> Self {
        let d = (upper - lower) / precision;
        let bits = (1..30).find(|&n| d < f64::from(1u32 << n)).unwrap_or(30);
        Self { lower, upper, bits }
    }

    /// The greatest code, `2^N - 1`.
    pub fn greatest(&self) -> u32 {
        (1 << self.bits) - 1
    }

    /// (9): `S = L + Dec (U - L) / (2^N - 1)`.
    pub fn decode(&self, code: u32) -> f64 {
        self.lower + f64::from(code) * (self.upper - self.lower) / f64::from(self.greatest())
    }

    /// The code whose value is nearest to `value`.
    pub fn encode(&self, value: f64) -> u32 {
        let width = self.upper - self.lower;
        let share = if width > 0.0 { ((value - self.lower) / width).clamp(0.0, 1.0) } else { 0.0 };
        (share * f64::from(self.greatest())).round() as u32
    }
}

/// An individual: one code for each variable. Its chromosome is their bits, one after the other.
pub type Genes = Vec<u32>;

/// Exchanges everything from bit `cut` of the chromosome on between two individuals (one-point crossover).
pub fn cross(codings: &[Coding], a: &Genes, b: &Genes, cut: u32) -> (Genes, Genes) {
    let (mut left, mut right) = (a.clone(), b.clone());
    let mut first = 0;
    for (i, coding) in codings.iter().enumerate() {
        // How many of this gene's bits, counted from the most significant, lie before the cut.
        let kept = cut.saturating_sub(first).min(coding.bits);
        let tail = ((1u64 << (coding.bits - kept)) - 1) as u32;
        left[i] = a[i] & !tail | b[i] & tail;
        right[i] = b[i] & !tail | a[i] & tail;
        first += coding.bits;
    }
    (left, right)
}

/// Length of the chromosome (bits).
pub fn chromosome_bits(codings: &[Coding]) -> u32 {
    codings.iter().map(|c| c.bits).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_number_of_bits_is_that_of_equation_8() {
        // D = 30000: 2^14 < D < 2^15.
        assert_eq!(Coding::new(-15.0, 15.0, 0.001).bits, 15);
        assert_eq!(Coding::new(0.0, 1023.0, 1.0).bits, 10);
        assert_eq!(Coding::new(0.0, 1024.0, 1.0).bits, 11, "D must be less than 2^N");
    }

    proptest! {
        #[test]
        fn coding_and_decoding_agree_to_the_precision(
            lower in -50.0..0.0f64, width in 0.01..60.0f64, share in 0.0..1.0f64,
        ) {
            let coding = Coding::new(lower, lower + width, 0.001);
            let value = lower + share * width;
            let code = coding.encode(value);
            prop_assert!((coding.decode(code) - value).abs() <= 0.0005 + 1e-12);
            prop_assert_eq!(coding.encode(coding.decode(code)), code);
            prop_assert_eq!(coding.decode(0), lower);
            prop_assert!((coding.decode(coding.greatest()) - (lower + width)).abs() < 1e-12);
        }

        #[test]
        fn crossing_only_exchanges_bits_behind_the_cut(a in any::<[u16; 3]>(), b in any::<[u16; 3]>(), cut in 0..=48u32) {
            let codings = [Coding { lower: 0.0, upper: 1.0, bits: 16 }; 3];
            let [ga, gb] = [a, b].map(|g| g.map(u32::from).to_vec());
            let chromosome = |g: &Genes| g.iter().fold(0u64, |c, &v| c << 16 | u64::from(v));
            let (left, right) = cross(&codings, &ga, &gb, cut);
            let tail = (1u64 << (48 - cut)) - 1;
            prop_assert_eq!(chromosome(&left), chromosome(&ga) & !tail | chromosome(&gb) & tail);
            prop_assert_eq!(chromosome(&right), chromosome(&gb) & !tail | chromosome(&ga) & tail);
        }
    }
}
