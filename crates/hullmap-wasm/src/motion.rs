//! Two bodies of which B moves and turns: when they first meet.

use hullmap::{MotionSettings, Pose, RigidMotion};
use js_sys::Float64Array;
use wasm_bindgen::prelude::*;

use crate::input::error;
use crate::object::Plain;
use crate::pair::{QueryPair, pose_of, query};

#[wasm_bindgen]
extern "C" {
    /// See the TypeScript section.
    #[wasm_bindgen(typescript_type = "TimeOfImpact")]
    pub type ImpactAnswer;
}

/// The motion from one pose to another.
fn motion_between(start: &[f64], end: &[f64]) -> Result<RigidMotion, JsError> {
    RigidMotion::between(pose_of(start)?, pose_of(end)?).map_err(error)
}

/// The pose at time `t`, from 0 to 1, of a motion from `start` to `end`: the origin moves along a
/// straight line, and the rotation is interpolated by slerp, the shorter way.
///
/// # Errors
/// A pose is not seven finite numbers, or `t` is NaN.
#[wasm_bindgen(js_name = interpolatePoses)]
pub fn interpolate_poses(
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] start: &[f64],
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] end: &[f64],
    t: f64,
) -> Result<Float64Array, JsError> {
    if t.is_nan() {
        return Err(error("t: expected a number from 0 to 1"));
    }
    Ok(numbers_of(motion_between(start, end)?.pose_at(t)))
}

/// The pose of B in A's frame, which queries take, from the poses of A and of B in the world.
///
/// # Errors
/// A pose is not seven finite numbers, or the bodies are too far apart.
#[wasm_bindgen(js_name = relativePose)]
pub fn relative_pose(
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>", js_name = aInWorld)] a_in_world: &[f64],
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>", js_name = bInWorld)] b_in_world: &[f64],
) -> Result<Float64Array, JsError> {
    Pose::relative(pose_of(a_in_world)?, pose_of(b_in_world)?).map(numbers_of).map_err(error)
}

fn numbers_of(pose: Pose) -> Float64Array {
    let (place, turn) = (pose.translation().to_array(), pose.rotation().to_array());
    Float64Array::from([place.as_slice(), turn.as_slice()].concat().as_slice())
}

#[wasm_bindgen(js_class = Pair)]
impl QueryPair {
    /// When B, which moves from the pose `start` to the pose `end` as in `interpolatePoses`, first
    /// meets A, which rests.
    ///
    /// # Errors
    /// A pose is not seven finite numbers.
    #[wasm_bindgen(js_name = castMotion)]
    pub fn cast_motion(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] start: &[f64],
        #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] end: &[f64],
    ) -> Result<ImpactAnswer, JsError> {
        let motion = motion_between(start, end)?;
        let (still, settings) = (RigidMotion::still(Pose::IDENTITY), MotionSettings::default());
        let cache = &mut self.cache;
        let found = query!(&self.a, &self.b, |a, b| hullmap::cast_motion(&a, &still, &b, &motion, &settings, cache));
        Ok(Plain::from_answer(&found).done())
    }
}
