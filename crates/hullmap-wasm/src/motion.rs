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
/// A pose is not seven finite numbers.
#[wasm_bindgen(js_name = poseBetween)]
pub fn pose_between(
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] start: &[f64],
    #[wasm_bindgen(unchecked_param_type = "ArrayLike<number>")] end: &[f64],
    t: f64,
) -> Result<Float64Array, JsError> {
    let pose = motion_between(start, end)?.pose_at(t);
    let (place, turn) = (pose.translation().to_array(), pose.rotation().to_array());
    Ok(Float64Array::from([place.as_slice(), turn.as_slice()].concat().as_slice()))
}

#[wasm_bindgen(js_class = Pair)]
impl QueryPair {
    /// When B, which moves from the pose `start` to the pose `end` as in `poseBetween`, first meets
    /// A, which rests.
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
