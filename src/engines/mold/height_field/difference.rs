//! Stock that one library of cutters leaves and another one removes.

use super::{Closing, FieldRegion, HeightField, HeightFieldError, regions};
use task::Cancel;

/// The connected pieces of what `more` leaves above what `less` leaves, where that is thicker than `tolerance` (mm) along
/// the normal of the material's surface, the largest first. Both are of `field`.
///
/// # Errors
/// [`HeightFieldError::OtherGrid`], [`HeightFieldError::Cancelled`].
pub fn difference(
    field: &HeightField,
    more: &Closing,
    less: &Closing,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Vec<FieldRegion>, HeightFieldError> {
    let (expected, found) = (field.heights.len(), less.heights.len());
    if expected != found {
        return Err(HeightFieldError::OtherGrid { expected, found });
    }
    // For this question what both leave is material.
    let filled = HeightField { heights: less.heights.clone(), upness: field.upness.clone(), ..*field };
    regions(&filled, more, tolerance, cancel)
}
