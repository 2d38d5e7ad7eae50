//! Poses.
#![allow(unsafe_code)]

use crate::border::{self, Out, call};
use crate::failure::Failure;
use crate::types::{self, Result};

/// The pose of B in A, from the poses of both in a world. Bodies near each other keep their digits
/// however far they are from the origin.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pose_relative(
    a_in_world: *const types::Pose,
    b_in_world: *const types::Pose,
    b_in_a: *mut types::Pose,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (a, b, out) = unsafe {
            let (a, b) = (border::read("a_in_world", a_in_world)?, border::read("b_in_world", b_in_world)?);
            (a, b, Out::new("b_in_a", b_in_a)?)
        };
        let (a, b) = (super::pose("a_in_world", a)?, super::pose("b_in_world", b)?);
        let found = hullmap::Pose::relative(a, b).map_err(|error| Failure::argument("b_in_a", error))?;
        out.write(types::Pose { translation: found.translation(), rotation: found.rotation() });
        Ok(())
    })
}
