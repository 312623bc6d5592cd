//! A finished part that was scanned, and how it is judged.

use files::{Invalid, Validate};
use geometry::frame::Frame;
use measured::MeasuredError;
use measured::deviation::Tolerance;
use measured::fit::{Freedom, Freedoms};
use serde::{Deserialize, Serialize};

/// `[scan]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScanSection {
    /// Points of the scan; none for no scan.
    pub file: Option<String>,
    /// Greatest deviation, either way (mm).
    pub tolerance_mm: f64,
    /// Least share of the points that must lie within it.
    pub least_share: f64,
    /// Axes that the fit may move the scan along and about: letters of x, y, z, a, b, c with commas between; or none.
    pub free: String,
    /// Distance from the part beyond which points do not count (mm); none if all count.
    pub reach_mm: Option<f64>,
}

impl Default for ScanSection {
    fn default() -> Self {
        Self { file: None, tolerance_mm: 0.03, least_share: 1.0, free: ALL_FREE.to_owned(), reach_mm: None }
    }
}

/// Word for a scan that is moved in no way.
const NOT_MOVED: &str = "none";
/// Every axis.
pub const ALL_FREE: &str = "x,y,z,a,b,c";

/// Ranges of the tolerance, the share, and the reach (mm, 1, mm).
pub const RANGES: [[f64; 2]; 3] = [[1e-4, 10.0], [0.0, 1.0], [1e-3, 1000.0]];

impl ScanSection {
    /// The tolerance with the share of the points that must lie within it.
    ///
    /// # Errors
    /// [`MeasuredError`] for one that is not possible.
    pub fn tolerance(&self) -> Result<Tolerance, MeasuredError> {
        Tolerance::symmetric(self.tolerance_mm)?.for_share(self.least_share)
    }

    /// The axes that the scan may be moved along and about; none for a scan that is not moved.
    ///
    /// # Errors
    /// The letter that is none of an axis, in words.
    pub fn freedoms(&self) -> Result<Option<Freedoms>, String> {
        freedoms(&self.free)
    }
}

/// The free axes that `text` names with commas between; none for `none`.
///
/// # Errors
/// The letter that is none of an axis, in words.
pub fn freedoms(text: &str) -> Result<Option<Freedoms>, String> {
    if text.trim().eq_ignore_ascii_case(NOT_MOVED) {
        return Ok(None);
    }
    let axis = |part: &str| {
        let letter = part.trim();
        let axis = Freedom::ALL.into_iter().find(|axis| letter.eq_ignore_ascii_case(&axis.letter().to_string()));
        axis.ok_or_else(|| format!("{letter:?}: give axes of x, y, z, a, b, c with commas between, or {NOT_MOVED}"))
    };
    let free = text.split(',').map(axis).collect::<Result<Vec<_>, _>>()?;
    Freedoms::of(Frame::IDENTITY, &free).map(Some).map_err(|error| error.to_string())
}

impl Validate for ScanSection {
    fn validate(&self) -> Result<(), Invalid> {
        let [tolerance, share, reach] = RANGES;
        Invalid::unless_within("tolerance_mm", self.tolerance_mm, tolerance, "mm")?;
        Invalid::unless_within("least_share", self.least_share, share, "")?;
        self.reach_mm.map_or(Ok(()), |mm| Invalid::unless_within("reach_mm", mm, reach, "mm"))?;
        self.freedoms().map(drop).map_err(|problem| Invalid::of("free", problem))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read_and_wrong_ones_named() {
        let list = |text: &str| freedoms(text).map(|free| free.map(|free| free.list().to_vec()));
        assert_eq!(list("x, C"), Ok(Some(vec![Freedom::X, Freedom::C])));
        assert_eq!(list(ALL_FREE), Ok(Some(Freedom::ALL.to_vec())));
        assert_eq!(list("none"), Ok(None));
        assert!(list("x,q").unwrap_err().contains("\"q\""));
        let wrong = |section: ScanSection| section.validate().unwrap_err().key;
        assert_eq!(wrong(ScanSection { free: "w".to_owned(), ..Default::default() }), "free");
        assert_eq!(wrong(ScanSection { tolerance_mm: 0.0, ..Default::default() }), "tolerance_mm");
        assert_eq!(wrong(ScanSection { least_share: 1.5, ..Default::default() }), "least_share");
        assert!(ScanSection::default().validate().is_ok());
    }
}
