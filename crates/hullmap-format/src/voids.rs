//! Voids: whether recorded shares of solids in no part can be true.

use crate::archive::{ArchivedHullRecord, ArchivedSpan, ArchivedVoidsRecord};

/// Why a record of voids is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum VoidsError {
    /// The hull is not the first part of an object, or has a record already.
    #[error(
        "record {record}: its hull is {found} (expected the first part of an object whose mass is recorded, from hull {least} on)"
    )]
    Hull { record: usize, found: u32, least: u32 },
    /// The share, or its error, is not between 0 and 1.
    #[error(
        "record {record}: its share of the solid is {share} with an error of {error} (expected numbers from 0 to 1)"
    )]
    Share { record: usize, share: f32, error: f32 },
}

/// The record of the object whose first part is hull `first`, in O(log n) for n records.
pub fn of_object(records: &[ArchivedVoidsRecord], first: u32) -> Option<&ArchivedVoidsRecord> {
    let index = records.binary_search_by_key(&first, |record| record.hull.to_native()).ok()?;
    records.get(index)
}

pub(crate) fn check(
    records: &[ArchivedVoidsRecord],
    hulls: &[ArchivedHullRecord],
    spans: &[ArchivedSpan],
) -> Result<(), VoidsError> {
    let mut least = 0;
    for (record, voids) in records.iter().enumerate() {
        let (found, share, error) = (voids.hull.to_native(), voids.share.to_native(), voids.error.to_native());
        let is_measured = |hull: usize| {
            let (start, end) = (spans.get(hull)?, spans.get(hull + 1)?);
            let of_hull = hulls.get(hull)?;
            let is_first_part = of_hull.part.to_native() == 0 && of_hull.part_count.to_native() > 0;
            Some(is_first_part && start.mass < end.mass)
        };
        if found < least || is_measured(found as usize) != Some(true) {
            return Err(VoidsError::Hull { record, found, least });
        }
        // NaN is in no range.
        if ![share, error].iter().all(|number| (0.0..=1.0).contains(number)) {
            return Err(VoidsError::Share { record, share, error });
        }
        least = found + 1;
    }
    Ok(())
}
