//! Primitives: whether recorded ones can replace their parts.

use rkyv::rend::f64_le;

use crate::{
    archive::{ArchivedHullRecord, ArchivedPrimitiveRecord},
    primitive_kind::PrimitiveKind,
};

/// Difference of the square of a quaternion's length from 1 up to which it is a rotation.
const UNIT: f64 = 1e-9;

/// Why a record of a primitive is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages explain the fields")]
pub enum PrimitiveError {
    /// The hull was not measured, or has a record already.
    #[error("record {record}: its hull is {found} (expected a part that was measured, from hull {least} on)")]
    Hull { record: usize, found: u32, least: u32 },
    /// The kind is unknown.
    #[error("record {record}: its kind is {found} (expected 1 to 4)")]
    Kind { record: usize, found: u32 },
    /// A size is not positive, or one that the kind does not have is not 0.
    #[error("record {record}: its sizes are {found:?} (expected {count} positive numbers, then zeros)")]
    Sizes { record: usize, found: [f64; 3], count: usize },
    /// The rotation is not a unit quaternion, or the centre or the protrusion is not finite.
    #[error(
        "record {record}: its centre is {center:?}, its rotation {rotation:?} and its protrusion {protrusion} (expected \
         finite numbers, a unit quaternion, and 0 or more)"
    )]
    Frame { record: usize, center: [f64; 3], rotation: [f64; 4], protrusion: f64 },
}

/// The record of hull `hull`, in O(log n) for n records.
pub fn of_hull(records: &[ArchivedPrimitiveRecord], hull: u32) -> Option<&ArchivedPrimitiveRecord> {
    let index = records.binary_search_by_key(&hull, |record| record.hull.to_native()).ok()?;
    records.get(index)
}

pub(crate) fn check(records: &[ArchivedPrimitiveRecord], hulls: &[ArchivedHullRecord]) -> Result<(), PrimitiveError> {
    let mut least = 0;
    for (record, primitive) in records.iter().enumerate() {
        let found = primitive.hull.to_native();
        let is_measured = hulls.get(found as usize).is_some_and(|hull| hull.solid.to_native() > 0);
        if found < least || !is_measured {
            return Err(PrimitiveError::Hull { record, found, least });
        }
        least = found + 1;
        let found = primitive.kind.to_native();
        let Some(kind) = PrimitiveKind::from_code(found) else {
            return Err(PrimitiveError::Kind { record, found });
        };
        let (count, found) = (kind.size_count(), primitive.sizes.map(f64_le::to_native));
        // NaN is neither positive nor 0.
        let is_size = |(index, size): (usize, f64)| {
            if index < count { size > 0.0 && size < f64::INFINITY } else { size == 0.0 }
        };
        if !found.into_iter().enumerate().all(is_size) {
            return Err(PrimitiveError::Sizes { record, found, count });
        }
        let (center, rotation) = (primitive.center.map(f64_le::to_native), primitive.rotation.map(f64_le::to_native));
        let protrusion = primitive.protrusion.to_native();
        let length_sq: f64 = rotation.iter().map(|component| component * component).sum();
        let is_frame = center.iter().all(|c| c.is_finite()) && (length_sq - 1.0).abs() <= UNIT;
        if !(is_frame && (0.0..f64::INFINITY).contains(&protrusion)) {
            return Err(PrimitiveError::Frame { record, center, rotation, protrusion });
        }
    }
    Ok(())
}
