//! Two bodies of which B moves and turns: when they first meet.

use hullmap::{MotionSettings, Pose, RigidMotion, TimeOfImpact};
use js_sys::Float64Array;
use wasm_bindgen::prelude::*;

use crate::object::{Field, Fields, Plain, error};
use crate::pair::{QueryPair, pose_of};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** When two bodies first meet. Points and directions are in A's frame. */
export interface TimeOfImpact {
    /** False only if it is certain that the bodies do not meet until time 1. */
    hit: boolean;
    status: Status;
    /** The time, from 0 to 1; infinite if there is no hit. */
    t: number;
    /** Until then, the bodies certainly are separated. */
    tLower: number;
    /** At this time, they certainly have met; infinite if no such time was found. */
    tUpper: number;
    /** Unit vector from A to B at `tLower`. */
    normal: Float64Array;
    /** The point of A closest to B at `tLower`. */
    pointA: Float64Array;
    /** The point of B closest to A at `tLower`. */
    pointB: Float64Array;
    iterations: number;
    supportCalls: number;
    /** Indices of the hulls of A and B that meet first; 0 for a body that is not a pack. */
    parts: Uint32Array;
}
"#;

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

fn fields(found: &TimeOfImpact) -> Fields {
    vec![
        ("hit", Field::Flag(found.hit)),
        ("status", Field::Word(found.status.as_str())),
        ("t", Field::Number(found.t)),
        ("tLower", Field::Number(found.t_lower)),
        ("tUpper", Field::Number(found.t_upper)),
        ("normal", Field::Vector(found.normal)),
        ("pointA", Field::Vector(found.point_a)),
        ("pointB", Field::Vector(found.point_b)),
        ("iterations", Field::Count(found.iterations)),
        ("supportCalls", Field::Count(found.support_calls)),
        ("parts", Field::Parts(found.parts)),
    ]
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
        let found = hullmap::cast_motion(&self.a, &still, &self.b, &motion, &settings, &mut self.cache);
        Ok(Plain::from_fields(&fields(&found)).done())
    }
}
