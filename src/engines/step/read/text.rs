//! Texts and comments of a STEP file, looked at before it is read.
//!
//! The reader takes stack for each doubled apostrophe of a text and each asterisk of a comment. A text that lacks its end
//! runs through all later texts of the file, whose ends then count as doubled apostrophes.

use std::borrow::Cow;

use crate::error::StepError;

/// Doubled apostrophes of a text, and asterisks of a comment, that the reader is left with.
const MOST: usize = 1000;

/// The file, without comments that have many asterisks.
///
/// # Errors
/// [`StepError::Syntax`] for a text that has no end.
pub(super) fn checked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, StepError> {
    let mut kept = Cow::Borrowed(bytes);
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], bytes.get(at + 1)) {
            (b'\'', _) => at = end_of_text(bytes, at)?,
            (b'/', Some(b'*')) => {
                let close = bytes[at + 2..].windows(2).position(|w| w == b"*/");
                let end = close.map_or(bytes.len(), |n| at + n + 4);
                if bytes[at..end].iter().filter(|b| **b == b'*').count() > MOST {
                    kept.to_mut()[at..end].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
                }
                at = end;
            }
            _ => at += 1,
        }
    }
    Ok(kept)
}

/// The place behind the text that begins at `start`.
fn end_of_text(bytes: &[u8], start: usize) -> Result<usize, StepError> {
    let (mut at, mut doubled) = (start + 1, 0);
    while let Some(next) = bytes[at.min(bytes.len())..].iter().position(|b| *b == b'\'') {
        at += next + 1;
        if bytes.get(at) != Some(&b'\'') {
            return Ok(at);
        }
        at += 1;
        doubled += 1;
        if doubled > MOST {
            let line = bytes[..start].iter().filter(|b| **b == b'\n').count() + 1;
            let problem = format!("the text that begins at line {line} does not end");
            return Err(StepError::Syntax { problem });
        }
    }
    Ok(bytes.len())
}
