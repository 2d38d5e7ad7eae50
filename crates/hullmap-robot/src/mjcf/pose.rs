//! Frames of MJCF: `pos`, and an orientation in one of five ways.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/modeling.html#frame-orientations>

use glam::{DMat3, DQuat, DVec3};

use crate::description::{numbers, triple};
use crate::frame::Frame;

#[derive(Clone, Copy, Debug)]
pub struct Angles<'a> {
    pub are_degrees: bool,
    /// The axes of Euler angles, in order. Lower-case axes rotate with the frame.
    pub sequence: &'a str,
}

impl Angles<'_> {
    pub fn radians(&self, angle: f64) -> f64 {
        if self.are_degrees { angle.to_radians() } else { angle }
    }

    /// The frame that attributes state; `None` if one is invalid.
    pub fn frame<'t>(&self, get: impl Fn(&str) -> Option<&'t str>) -> Option<Frame> {
        let translation = get("pos").map_or(Some([0.0; 3]), triple)?;
        Some(Frame { rotation: self.rotation(get)?, translation: DVec3::from_array(translation) })
    }

    /// The orientation that attributes state: a quaternion only if no other is stated.
    fn rotation<'t>(&self, get: impl Fn(&str) -> Option<&'t str>) -> Option<DQuat> {
        let stated = |name: &str| get(name).map(numbers);
        if let Some(axis_angle) = stated("axisangle") {
            let [x, y, z, angle] = axis_angle?.try_into().ok()?;
            return Some(DQuat::from_axis_angle(DVec3::new(x, y, z).try_normalize()?, self.radians(angle)));
        }
        if let Some(axes) = stated("xyaxes") {
            let [a, b, c, d, e, f] = axes?.try_into().ok()?;
            let x = DVec3::new(a, b, c).try_normalize()?;
            let y = DVec3::new(d, e, f);
            let y = (y - x * x.dot(y)).try_normalize()?;
            return Some(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize());
        }
        if let Some(z) = get("zaxis") {
            return turn_to(DVec3::from_array(triple(z)?));
        }
        if let Some(euler) = get("euler") {
            let turns = self.sequence.chars().zip(triple(euler)?);
            return Some(turns.fold(DQuat::IDENTITY, |rotation, (axis, angle)| {
                let turn = DQuat::from_axis_angle(unit(axis), self.radians(angle));
                if axis.is_ascii_lowercase() { rotation * turn } else { turn * rotation }
            }));
        }
        let Some(quaternion) = stated("quat") else { return Some(DQuat::IDENTITY) };
        let [w, x, y, z] = quaternion?.try_into().ok()?;
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        (quaternion.length_squared() > 0.0).then(|| quaternion.normalize())
    }
}

fn unit(axis: char) -> DVec3 {
    match axis.to_ascii_lowercase() {
        'x' => DVec3::X,
        'y' => DVec3::Y,
        _ => DVec3::Z,
    }
}

/// The smallest rotation of z to a direction.
fn turn_to(direction: DVec3) -> Option<DQuat> {
    let to = direction.try_normalize()?;
    let axis = DVec3::Z.cross(to);
    // Opposite to z, MuJoCo turns about x.
    Some(DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::X), axis.length().atan2(to.z)))
}

/// The frame of a geom between two points, with z along them, and half of their distance.
pub fn between(text: &str) -> Option<(Frame, f64)> {
    let [a, b, c, d, e, f] = numbers(text)?.try_into().ok()?;
    let (from, to) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
    let rotation = turn_to(from - to)?;
    Some((Frame { rotation, translation: (from + to) / 2.0 }, from.distance(to) / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotation(name: &str, value: &str, sequence: &str) -> DQuat {
        let angles = Angles { are_degrees: true, sequence };
        angles.frame(|own| (own == name).then_some(value)).unwrap().rotation
    }

    /// A quarter turn about z, then a quarter turn about the new x.
    #[test]
    fn orientations_in_every_way_agree() {
        let expected = rotation("quat", "0.5 0.5 0.5 0.5", "xyz");
        for (name, value, sequence) in [
            ("quat", "-1 -1 -1 -1", "xyz"),
            ("axisangle", "2 2 2 120", "xyz"),
            ("xyaxes", "0 3 0  0 1 1", "xyz"),
            ("euler", "90 90 0", "zxy"),
            ("euler", "90 0 90", "XYZ"),
        ] {
            let found = rotation(name, value, sequence);
            assert!(found.dot(expected).abs() > 1.0 - 1e-12, "{name} {value}: {found}, {expected}");
        }
        for direction in [DVec3::X, DVec3::new(1.0, -2.0, 0.5), DVec3::NEG_Z, DVec3::Z] {
            let turned = turn_to(direction).unwrap() * DVec3::Z;
            assert!(turned.abs_diff_eq(direction.normalize(), 1e-12), "{turned}");
        }
        let (frame, half) = between("1 0 0 1 0 4").unwrap();
        assert_eq!((frame.translation, half), (DVec3::new(1.0, 0.0, 2.0), 2.0));
    }
}
