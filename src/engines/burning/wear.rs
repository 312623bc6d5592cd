//! Wear of electrodes: how much they lose, how many are needed, which channels each of them burns, and redressing.
//!
//! Wear is that of the technology and the model, before burning. A technology without wear gives none: wear is then not
//! considered.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::choice::{Choice, Figure, Missing};
use crate::technology::within;
use crate::{BurningError, MOST_ROWS};

/// Share of the allowed wear that is taken for rounding.
const ROUNDING: f64 = 1e-9;
/// Greatest lengths of electrodes (mm).
const LENGTH_MM: [f64; 2] = [1e-3, 10_000.0];

/// Wear of an electrode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wear {
    /// Length that the front loses (mm), where it burns along all of the path; none if it is not considered.
    pub end_mm: Option<f64>,
    /// Wear of the edges (mm), beyond the wear of the front; none if it is not considered.
    pub corner_mm: Option<f64>,
    /// Figures without which a wear is not known.
    pub missing: Vec<Missing>,
}

impl Wear {
    /// Wear of an electrode in one burn with these steps: the sums of the end wear and of the corner wear of the steps.
    ///
    /// End wear is the wear share (percent / 100) times the sum over the pieces of removed volume / frontal area: all of
    /// the wear is taken from the front, and the part of the front that enters first burns in every piece. One step
    /// without a figure leaves the sum unknown. Steps that remove nothing wear nothing.
    pub(crate) fn of_burn(choice: &Choice) -> Self {
        let burned = || choice.steps.iter().filter(|chosen| chosen.volume_mm3 != Some(0.0));
        let mut missing = choice.missing.clone();
        // A current that nothing bounds may wear the electrode away on a small area.
        let is_bounded = |missing: &Missing| !matches!(missing.figure, Figure::Density | Figure::PeakCurrent);
        let is_known = !choice.steps.is_empty() && missing.iter().all(is_bounded);
        let volume = choice.burn.volume_mm3();
        let pieces = choice.burn.pieces.iter();
        let length: f64 = pieces.map(|piece| piece.volume_mm3 / piece.frontal_area_mm2).sum();
        let [mut end, mut corner] = [is_known.then_some(0.0); 2];
        for chosen in burned() {
            // A step that removes something is one of a burn with a volume.
            let share = chosen.volume_mm3.map(|of_step| of_step / volume);
            let one = chosen.step.wear_percent.zip(share).map(|(percent, share)| 0.01 * percent * share * length);
            end = end.zip(one).map(|(sum, one)| sum + one);
            corner = corner.zip(chosen.step.corner_wear_mm).map(|(sum, one)| sum + one);
        }
        for chosen in burned() {
            if chosen.step.wear_percent.is_none() {
                Missing::add(&mut missing, Figure::Wear, chosen.step);
            }
            if chosen.step.corner_wear_mm.is_none() {
                Missing::add(&mut missing, Figure::CornerWear, chosen.step);
            }
        }
        Self { end_mm: end, corner_mm: corner, missing }
    }

    /// Wear after this many of the same burns.
    #[must_use]
    pub fn after(&self, burns: usize) -> Self {
        let times = |wear: Option<f64>| wear.map(|wear| wear * burns as f64);
        Self { end_mm: times(self.end_mm), corner_mm: times(self.corner_mm), missing: self.missing.clone() }
    }

    /// Share of the allowed wear that is used up; the greater one of front and edges.
    ///
    /// # Errors
    /// [`BurningError::Invalid`] for limits that are not possible.
    pub fn share_of(&self, allowed: AllowedWear) -> Result<WearShare, BurningError> {
        allowed.validate()?;
        let pairs = [(self.end_mm, allowed.end_mm), (self.corner_mm, allowed.corner_mm)];
        let (mut greatest, mut is_limited, mut is_known) = (0.0_f64, false, true);
        for (wear, allowed) in pairs {
            let Some(allowed) = allowed else { continue };
            is_limited = true;
            match wear {
                Some(wear) => greatest = greatest.max(wear / allowed),
                None => is_known = false,
            }
        }
        Ok(match (is_limited, is_known) {
            (false, _) => WearShare::Unlimited,
            (true, true) => WearShare::Known(greatest),
            (true, false) => WearShare::Unknown { at_least: greatest },
        })
    }
}

/// Share of the allowed wear that one burn uses up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum WearShare {
    /// Any wear is allowed: one electrode does for all burns.
    Unlimited,
    /// A wear that is limited is not known.
    Unknown {
        /// Share of the wear that is known; 0 if none is.
        at_least: f64,
    },
    /// The share is known.
    Known(f64),
}

impl Default for WearShare {
    fn default() -> Self {
        Self::Unknown { at_least: 0.0 }
    }
}

impl WearShare {
    /// Share that is used up at least.
    pub const fn at_least(self) -> f64 {
        match self {
            Self::Unlimited => 0.0,
            Self::Unknown { at_least } | Self::Known(at_least) => at_least,
        }
    }

    /// Whether electrodes may wear faster than known.
    pub const fn is_unknown(self) -> bool {
        matches!(self, Self::Unknown { .. })
    }
}

/// Wear at which an electrode is replaced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AllowedWear {
    /// Greatest wear of the front (mm); none for any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_mm: Option<f64>,
    /// Greatest wear of the edges (mm); none for any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corner_mm: Option<f64>,
}

impl Validate for AllowedWear {
    fn validate(&self) -> Result<(), Invalid> {
        within("end_mm", self.end_mm, [1e-4, 1000.0], "mm")?;
        within("corner_mm", self.corner_mm, [1e-4, 1000.0], "mm")
    }
}

/// Number of whole electrodes in a wear that is given in allowed wears, at least one.
pub(crate) fn whole_electrodes(share: f64) -> Result<usize, BurningError> {
    // Exact below 2^53, saturated above, where it is refused.
    let rows = (share * (1.0 - ROUNDING)).ceil().max(1.0) as usize;
    if rows > MOST_ROWS {
        return Err(BurningError::TooManyRows { what: "electrodes", rows, most: MOST_ROWS });
    }
    Ok(rows)
}

/// A part of a channel's burn with one copy of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Assignment {
    /// Channel, from 0 in the order of indexing.
    pub channel: usize,
    /// Copy of the electrode, from 0.
    pub copy: usize,
    /// Part of the channel's burn, above 0 up to 1; below 1 only where one electrode does not last for a channel.
    pub part: f64,
    /// Share of the allowed wear that the copy has used up after this burn.
    pub used: f64,
}

/// The copies of an electrode and the channels that each of them burns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Copies {
    /// Number of copies.
    pub count: usize,
    /// Least number: the ceiling of all wear in allowed wears.
    pub least: usize,
    /// The burns, in the order of indexing.
    pub assignments: Vec<Assignment>,
}

/// Shares out channels among copies of an electrode, given the share of the allowed wear that each channel uses up, in
/// the order of indexing.
///
/// A copy burns whole channels as long as its wear allows. A channel that wears more than one electrode away is burned
/// with as many fresh copies as it needs; the last of them goes on to the next channel if its wear allows.
///
/// # Errors
/// [`BurningError`] for shares that are not possible, and for more than [`MOST_ROWS`] burns.
pub fn share_out(shares: &[f64]) -> Result<Copies, BurningError> {
    let too_many = |rows| BurningError::TooManyRows { what: "burns of an electrode", rows, most: MOST_ROWS };
    if shares.len() > MOST_ROWS {
        return Err(too_many(shares.len()));
    }
    let (mut copy, mut used, mut sum) = (0, 0.0, 0.0);
    let mut assignments: Vec<Assignment> = Vec::with_capacity(shares.len());
    for (channel, share) in shares.iter().copied().enumerate() {
        Invalid::unless_within(&format!("wear of channel {}", channel + 1), share, [0.0, f64::INFINITY], "")?;
        sum += share;
        if used > 0.0 && used + share > 1.0 + ROUNDING {
            (copy, used) = (copy + 1, 0.0);
        }
        let parts = if used > 0.0 { 1 } else { whole_electrodes(share)? };
        if assignments.len() + parts > MOST_ROWS {
            return Err(too_many(assignments.len() + parts));
        }
        let first = assignments.len();
        let whole = parts - 1;
        // Each copy but the last is worn down to what is allowed.
        assignments.extend((0..whole).map(|i| Assignment { channel, copy: copy + i, part: share.recip(), used: 1.0 }));
        copy += whole;
        used += share - whole as f64;
        let burned: f64 = assignments.iter().skip(first).map(|assignment| assignment.part).sum();
        assignments.push(Assignment { channel, copy, part: 1.0 - burned, used });
    }
    let count = assignments.last().map_or(0, |last| last.copy + 1);
    let least = if shares.is_empty() { 0 } else { whole_electrodes(sum)? };
    Ok(Copies { count, least, assignments })
}

/// Redressing of an electrode by cutting its front off; considered where all of these figures are given.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Redress {
    /// Length of a new electrode along which its section is that of its front (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Least length with which it still burns (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_length_mm: Option<f64>,
    /// Length that is cut off beyond the wear (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowance_mm: Option<f64>,
}

impl Redress {
    /// Whether electrodes are not redressed.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Name of a figure that is not given where another one is.
    pub fn missing(&self) -> Option<&'static str> {
        let figures = [
            ("length_mm", self.length_mm),
            ("least_length_mm", self.least_length_mm),
            ("allowance_mm", self.allowance_mm),
        ];
        figures.into_iter().find(|(_, figure)| figure.is_none()).map(|(name, _)| name).filter(|_| !self.is_none())
    }
}

impl Validate for Redress {
    fn validate(&self) -> Result<(), Invalid> {
        within("length_mm", self.length_mm, LENGTH_MM, "mm")?;
        within("least_length_mm", self.least_length_mm, [0.0, self.length_mm.unwrap_or(LENGTH_MM[1])], "mm")?;
        within("allowance_mm", self.allowance_mm, [1e-3, 100.0], "mm")
    }
}

/// Lengths and number of redressings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Redressing {
    /// Length that is cut off each time (mm): end wear, corner wear and the allowance.
    pub cut_off_mm: f64,
    /// Number of times that the burning length allows.
    pub times: usize,
    /// Length that is left after them (mm).
    pub length_left_mm: f64,
}

impl Redress {
    /// Redressing after this wear. None without redressing, and if the end wear or the corner wear is not known: wear is then not
    /// considered.
    ///
    /// # Errors
    /// [`BurningError::Invalid`] for lengths that are not possible.
    pub fn after(&self, wear: &Wear) -> Result<Option<Redressing>, BurningError> {
        self.validate()?;
        let Self { length_mm: Some(length), least_length_mm: Some(least), allowance_mm: Some(allowance) } = *self
        else {
            return Ok(None);
        };
        let Some((end, corner)) = wear.end_mm.zip(wear.corner_mm) else { return Ok(None) };
        let cut_off_mm = end + corner + allowance;
        Invalid::unless_within("length to cut off", cut_off_mm, [allowance, f64::INFINITY], "mm")?;
        let times = ((length - least) / cut_off_mm * (1.0 + ROUNDING)).floor();
        let length_left_mm = (length - times * cut_off_mm).max(least);
        Ok(Some(Redressing { cut_off_mm, times: times as usize, length_left_mm }))
    }
}

impl Redressing {
    /// Number of electrodes to make for this many copies: each is used once and after every redressing.
    pub const fn electrodes_for(&self, copies: usize) -> usize {
        copies.div_ceil(self.times.saturating_add(1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::choice::tests::{burn, complete};
    use crate::choice::{Piece, Until, choose};
    use crate::technology::{Step, Technology};

    fn wear(technology: &Technology, volume: f64, area: f64) -> Wear {
        Wear::of_burn(&choose(technology, &burn(volume, area, Until::Vdi(20.0))).unwrap())
    }

    fn known(end: f64, corner: f64) -> Wear {
        Wear { end_mm: Some(end), corner_mm: Some(corner), missing: Vec::new() }
    }

    /// R removes 985 mm³ at 1 %, S 10 mm³ at 5 %, F 5 mm³ at 20 %: 11.35 mm³ from 100 mm².
    #[test]
    fn the_front_loses_the_worn_volume() {
        let all = wear(&complete(), 1000.0, 100.0);
        assert!((all.end_mm.unwrap() - 0.1135).abs() < 1e-12);
        assert!((all.corner_mm.unwrap() - 0.06).abs() < 1e-12);
        assert!(all.missing.is_empty());
        let three = all.after(3);
        assert!((three.end_mm.unwrap() - 0.3405).abs() < 1e-12 && (three.corner_mm.unwrap() - 0.18).abs() < 1e-12);
        // The same path of 10 mm, entered with 10 mm²: the front wears along its length, not by its volume.
        let mut entry = burn(900.0, 100.0, Until::Step("R".to_owned()));
        let along = |burn: &_| Wear::of_burn(&choose(&complete(), burn).unwrap()).end_mm.unwrap();
        assert!((along(&entry) - 0.09).abs() < 1e-12);
        entry.pieces.insert(0, Piece { volume_mm3: 10.0, frontal_area_mm2: 10.0 });
        assert!((along(&entry) - 0.1).abs() < 1e-12);
        assert_eq!(wear(&complete(), 0.0, 100.0), known(0.0, 0.0));
    }

    #[test]
    fn without_wear_in_the_table_none_is_considered() {
        let without = |change: fn(&mut Step)| {
            let mut technology = complete();
            change(&mut technology.step[1]);
            let wear = wear(&technology, 1000.0, 100.0);
            let said: Vec<String> = wear.missing.iter().map(ToString::to_string).collect();
            (wear.end_mm.is_some(), wear.corner_mm.is_some(), said.join("; "))
        };
        assert_eq!(without(|_| {}), (true, true, String::new()));
        assert_eq!(without(|s| s.wear_percent = None), (false, true, "wear of step S is not given".to_owned()));
        assert_eq!(
            without(|s| s.corner_wear_mm = None),
            (true, false, "corner wear of step S is not given".to_owned())
        );
        let stock = "stock left for the next step of step S is not given".to_owned();
        assert_eq!(without(|s| s.stock_next_mm = None), (false, true, stock));
        let mut nameless = complete();
        nameless.step.iter_mut().for_each(|step| step.vdi = None);
        let none = wear(&nameless, 1000.0, 100.0);
        assert_eq!((none.end_mm, none.corner_mm, none.missing.len()), (None, None, 1));
        let allowed = AllowedWear { end_mm: Some(0.1), corner_mm: None };
        let redress = Redress { length_mm: Some(20.0), least_length_mm: Some(10.0), allowance_mm: Some(0.1) };
        assert_eq!(none.share_of(allowed), Ok(WearShare::Unknown { at_least: 0.0 }));
        assert_eq!(redress.after(&none), Ok(None));
        assert_eq!(redress.after(&Wear { corner_mm: None, ..known(0.1, 0.1) }), Ok(None));
        // A current that nothing bounds.
        let mut open = Technology { area_range_mm2: None, ..complete() };
        open.step.iter_mut().for_each(|step| [step.max_density_a_cm2, step.at_area_mm2] = [None; 2]);
        let unbounded = super::tests::wear(&open, 1000.0, 100.0);
        assert_eq!((unbounded.end_mm, unbounded.corner_mm, unbounded.missing.len()), (None, None, 1));
    }

    #[test]
    fn the_greater_share_decides() {
        let share = |end_mm, corner_mm| known(0.1, 0.06).share_of(AllowedWear { end_mm, corner_mm }).unwrap();
        assert_eq!(share(None, None), WearShare::Unlimited);
        assert_eq!(share(Some(0.2), None), WearShare::Known(0.5));
        assert_eq!(share(Some(0.2), Some(0.06)), WearShare::Known(1.0));
        let half_known = Wear { corner_mm: None, ..known(0.1, 0.06) };
        let both = AllowedWear { end_mm: Some(0.2), corner_mm: Some(0.2) };
        assert_eq!(half_known.share_of(both), Ok(WearShare::Unknown { at_least: 0.5 }), "the end wear is kept");
        let end = AllowedWear { corner_mm: None, ..both };
        assert_eq!(half_known.share_of(end), Ok(WearShare::Known(0.5)), "no limit for the corners");
        assert!(half_known.share_of(AllowedWear { end_mm: Some(0.0), corner_mm: None }).is_err());
    }

    #[test]
    fn electrodes_are_the_ceiling_of_wear_over_allowed() {
        for (wear, count) in [(0.0, 1), (0.1, 1), (0.11, 2), (0.3, 3), (0.95, 10)] {
            assert_eq!(whole_electrodes(wear / 0.1), Ok(count), "{wear}");
        }
        assert!(matches!(whole_electrodes(1e10), Err(BurningError::TooManyRows { .. })));
    }

    #[test]
    fn copies_burn_whole_channels_in_order() {
        let copies = |shares: &[f64]| {
            let copies = share_out(shares).unwrap();
            let of: Vec<usize> = copies.assignments.iter().map(|assignment| assignment.copy).collect();
            (copies.count, copies.least, of)
        };
        // 0.4 of the allowed wear a channel: two channels each, although 2.4 electrodes would do.
        assert_eq!(copies(&[0.4; 6]), (3, 3, vec![0, 0, 1, 1, 2, 2]));
        assert_eq!(copies(&[0.6; 4]), (4, 3, vec![0, 1, 2, 3]));
        // A tenth each, ten times, is one electrode in spite of rounding.
        assert_eq!(copies(&[0.1; 20]).0, 2);
        assert_eq!(copies(&[0.0; 3]), (1, 1, vec![0, 0, 0]));
        assert_eq!(copies(&[]), (0, 0, vec![]));
        // Two and a half electrodes a channel: the halves meet in the third channel or not.
        assert_eq!(copies(&[2.5, 0.5, 0.5]), (4, 4, vec![0, 1, 2, 2, 3]));
        let parts = share_out(&[2.5]).unwrap().assignments;
        assert_eq!(parts.iter().map(|a| a.part).collect::<Vec<_>>(), [0.4, 0.4, 1.0 - 0.8]);
        assert!(share_out(&[f64::NAN]).is_err() && share_out(&[-0.1]).is_err());
        assert!(matches!(share_out(&[1e300]), Err(BurningError::TooManyRows { .. })));
        assert!(matches!(share_out(&vec![0.0; MOST_ROWS + 1]), Err(BurningError::TooManyRows { .. })));
    }

    /// 20 mm of section, at least 10 mm: 10 mm to lose, 0.1 + 0.2 + 0.2 mm each time.
    #[test]
    fn redressing_uses_up_the_burning_length() {
        let redress = Redress { length_mm: Some(20.0), least_length_mm: Some(10.0), allowance_mm: Some(0.2) };
        let done = redress.after(&known(0.1, 0.2)).unwrap().unwrap();
        assert!((done.cut_off_mm - 0.5).abs() < 1e-12 && done.times == 20 && (done.length_left_mm - 10.0).abs() < 1e-9);
        assert_eq!([1, 21, 22, 42].map(|copies| done.electrodes_for(copies)), [1, 1, 2, 2]);
        let much = redress.after(&known(10.0, 0.0)).unwrap().unwrap();
        assert_eq!((much.times, much.length_left_mm, much.electrodes_for(3)), (0, 20.0, 3));
        assert!(Redress { least_length_mm: Some(30.0), ..redress }.after(&known(0.1, 0.1)).is_err());
        assert!(Redress { allowance_mm: Some(0.0), ..redress }.after(&known(0.0, 0.0)).is_err());
    }

    proptest! {
        /// Every channel is burned whole, no copy wears beyond what is allowed, and the wear adds up.
        #[test]
        fn wear_is_shared_out_whole(shares in prop::collection::vec(0.0..3.0, 1..40)) {
            let copies = share_out(&shares).unwrap();
            prop_assert!(copies.count >= copies.least);
            let mut of_copy = vec![0.0; copies.count];
            for (channel, share) in shares.iter().enumerate() {
                let of_channel = copies.assignments.iter().filter(|a| a.channel == channel);
                let part: f64 = of_channel.map(|a| a.part).sum();
                prop_assert!((part - 1.0).abs() < 1e-9, "channel {channel}: {part} of {share}");
            }
            for assignment in &copies.assignments {
                of_copy[assignment.copy] += assignment.part * shares[assignment.channel];
                prop_assert!(assignment.part > 0.0 && assignment.used <= 1.0 + 1e-6);
                prop_assert!((of_copy[assignment.copy] - assignment.used).abs() < 1e-6);
            }
            let order: Vec<_> = copies.assignments.iter().map(|a| (a.channel, a.copy)).collect();
            prop_assert!(order.is_sorted());
        }

        #[test]
        fn more_volume_never_wears_less(volume in 0.0..1e5, more in 0.0..1e5) {
            let [less, more] = [volume, volume + more].map(|volume| wear(&complete(), volume, 100.0).end_mm.unwrap());
            prop_assert!(more >= less - 1e-12);
        }
    }
}
