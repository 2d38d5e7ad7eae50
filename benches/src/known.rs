//! Two boxes whose depths and distances are known, in `benches/peers/known.txt`. Every engine in a
//! program of its own answers them before it is measured: one that gets its input in another layout
//! than it expects still has figures.

use glam::{DQuat, DVec3};
use hullmap::Pose;

/// Allowed difference of a depth, for boxes of some metres, and of a unit normal. Engines in single
/// precision stay far below it; input in a wrong layout does not.
const TOLERANCE: f64 = 1e-3;

/// The boxes, and poses of B in A's frame.
#[derive(Clone, Debug)]
pub struct Known {
    /// Corners of A and B.
    pub corners: [[[f32; 3]; 8]; 2],
    /// The poses.
    pub poses: Vec<KnownPose>,
}

/// A pose with a known answer.
#[derive(Clone, Debug)]
pub struct KnownPose {
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
    /// Distance of the boxes, or their depth if negative.
    pub gap: f64,
    /// Direction of the gap, from A to B.
    pub direction: DVec3,
}

/// An engine's contact: its depth, and the unit normal from A to B.
pub type Found = (f64, DVec3);

impl Known {
    /// The boxes of `known.txt`. Panics if it cannot be read; tests read it.
    pub fn boxes() -> Self {
        Self::parse(include_str!("../peers/known.txt")).unwrap_or_else(|error| panic!("known.txt: {error}"))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let (mut corners, mut poses) = (Vec::new(), Vec::<KnownPose>::new());
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let mut words = line.split_whitespace();
            let kind = (words.next(), words.next()).0;
            let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
            match (kind, numbers.as_deref()) {
                (Some("box"), Ok(half @ &[_, _, _])) => corners.push(std::array::from_fn(|i| {
                    std::array::from_fn(|k| if i >> k & 1 == 1 { half[k] as f32 } else { -half[k] as f32 })
                })),
                (Some("pose"), Ok(&[x, y, z, qx, qy, qz, qw, gap, dx, dy, dz])) => {
                    let b_in_a = Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(qx, qy, qz, qw));
                    let b_in_a = b_in_a.map_err(|error| format!("{line:?}: {error}"))?;
                    poses.push(KnownPose { b_in_a, gap, direction: DVec3::new(dx, dy, dz) });
                }
                _ => return Err(format!("{line:?}: expected a box with 3 numbers, or a pose with 11")),
            }
        }
        let corners = corners.try_into().map_err(|_| "expected two boxes".to_owned())?;
        let has_both = poses.iter().any(|pose| pose.gap < 0.0) && poses.iter().any(|pose| pose.gap > 0.0);
        if has_both { Ok(Self { corners, poses }) } else { Err("expected both kinds of poses".to_owned()) }
    }

    /// The line that proves an engine, from its answer to each pose; `None` without a contact.
    /// Fails if an answer is wrong or missing.
    pub fn prove(
        &self,
        engine: &str,
        mut answer: impl FnMut(&KnownPose) -> Result<Option<Found>, String>,
    ) -> Result<String, String> {
        let mut shown = Vec::new();
        for pose in &self.poses {
            let found = answer(pose).map_err(|error| format!("{engine}: two known boxes: {error}"))?;
            let what = match found {
                None => "no contact".to_owned(),
                Some((depth, n)) => format!("depth {depth:.6} along ({:.3}, {:.3}, {:.3})", n.x, n.y, n.z),
            };
            // NaN is wrong.
            let is_right = found.map_or(pose.gap > 0.0, |(depth, normal)| {
                (depth + pose.gap).abs() <= TOLERANCE && normal.distance(pose.direction) <= TOLERANCE
            });
            if !is_right {
                return Err(format!(
                    "{engine}: two known boxes with a gap of {}: {what}. Its figures would mean nothing: check how its \
                     program gets shapes and poses",
                    pose.gap
                ));
            }
            shown.push(format!("gap {}: {what}", pose.gap));
        }
        Ok(format!("{engine}, two known boxes: {}", shown.join("; ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_right_answers_are_a_proof() {
        let known = Known::boxes();
        let answer = |error: f64, normal: DVec3| {
            known.prove("engine 1.0", |pose| Ok((pose.gap < 0.0).then_some((error - pose.gap, normal))))
        };
        let expected = "gap -0.25: depth 0.250001 along (0.000, 0.000, 1.000); gap 0.5: no contact";
        assert_eq!(answer(1e-6, DVec3::Z).unwrap(), format!("engine 1.0, two known boxes: {expected}"));
        // B stands upright if the numbers of its rotation are in another order, and is 1 deeper.
        let wrong_depths = [1.0, -0.002, f64::NAN].map(|error| (error, DVec3::Z));
        for (error, normal) in wrong_depths.into_iter().chain([DVec3::NEG_Z, DVec3::X, DVec3::NAN].map(|n| (0.0, n))) {
            let refusal = answer(error, normal).unwrap_err();
            assert!(refusal.starts_with("engine 1.0: two known boxes with a gap of -0.25: depth "), "{refusal}");
        }
        let refusal = known.prove("engine", |_| Ok(Some((0.25, DVec3::Z)))).unwrap_err();
        assert!(refusal.contains("gap of 0.5: depth 0.25"), "{refusal}");
        assert!(known.prove("engine", |_| Ok(None)).unwrap_err().contains("gap of -0.25: no contact"));
        assert!(known.prove("engine", |_| Err("it has ended".to_owned())).unwrap_err().ends_with("it has ended"));
    }

    /// The file's answers, by the boxes' extents along the axes.
    #[test]
    fn the_known_answers_are_right() {
        let known = Known::boxes();
        for pose in &known.poses {
            let [a, b] = known.corners.map(|corners| corners.map(|corner| DVec3::from(corner.map(f64::from))));
            let b = b.map(|corner| pose.b_in_a.transform_point(corner));
            let most = |corners: [DVec3; 8]| corners.into_iter().reduce(DVec3::max).unwrap();
            let least = |corners: [DVec3; 8]| corners.into_iter().reduce(DVec3::min).unwrap();
            // B is beyond A along the axis of the largest gap, in its positive direction.
            let gaps = least(b) - most(a);
            assert!((gaps.max_element() - pose.gap).abs() < 1e-9, "{pose:?}: {gaps}");
            assert!((gaps.dot(pose.direction) - pose.gap).abs() < 1e-9, "{pose:?}: {gaps}");
            assert!((least(a) - most(b)).max_element() < gaps.max_element() - 1.0, "the other sides are farther");
        }
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let text = include_str!("../peers/known.txt");
        for (damaged, expected) in [
            (text.replace("box A 2 2 1", "box A 2 2"), "a box with 3 numbers"),
            (text.replace("box A 2 2 1\n", ""), "two boxes"),
            (text.replace(" -0.25 0 0 1", ""), "a pose with 11"),
            (text.replace("-0.25", "0.25"), "both kinds"),
            (text.replace("0.5 1.5", "0.5 x"), "a box with 3 numbers"),
        ] {
            let error = Known::parse(&damaged).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
