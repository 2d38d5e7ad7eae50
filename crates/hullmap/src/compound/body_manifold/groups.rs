//! Groups of manifolds with nearly the same normal, and the number of points that each gets.

#![forbid(unsafe_code)]

use glam::DVec3;

/// Cosine of the angle up to which manifolds are in the group of a deeper one: 5 degrees.
const SAME_NORMAL: f64 = 0.9961946980917455;

/// Maximum number of points of a [`BodyManifold`](super::BodyManifold).
pub const MAX_BODY_POINTS: usize = 8;

/// Maximum number of groups. Directions that are more than 80 degrees apart are at most seven, so
/// the angle is doubled at most four times.
const MAX_GROUPS: usize = MAX_BODY_POINTS;

/// The data of a manifold that grouping needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// Unit normal.
    pub(super) normal: DVec3,
    /// Depth of the deepest point.
    pub(super) depth: f64,
    /// Index of its group, the deepest group first.
    pub(super) group: usize,
}

/// Assigns every member to a group, and returns how many there are: at most
/// [`MAX_GROUPS`].
///
/// The deepest member without a group leads the next one, which all others without a group join
/// whose normals are within five degrees of its normal. If there are too many groups, the angle is
/// doubled.
///
/// # Complexity
/// O(n) for n members.
pub(super) fn group(members: &mut [Member]) -> usize {
    let mut cosine = SAME_NORMAL;
    loop {
        if let Some(count) = group_within(members, cosine) {
            return count;
        }
        // The cosine of twice the angle.
        cosine = 2.0 * cosine * cosine - 1.0;
    }
}

fn group_within(members: &mut [Member], cosine: f64) -> Option<usize> {
    members.iter_mut().for_each(|member| member.group = MAX_GROUPS);
    for group in 0..=MAX_GROUPS {
        let free = members.iter().filter(|member| member.group == MAX_GROUPS);
        // The first one of equally deep ones.
        let Some(leader) = free.reduce(|p, q| if q.depth > p.depth { q } else { p }).map(|leader| leader.normal) else {
            return Some(group);
        };
        // Groups of at least a right angle: NaN must not lead to a loop without end.
        let joins = |member: &Member| !(member.normal.dot(leader) < cosine) || cosine < 0.0;
        members.iter_mut().filter(|m| m.group == MAX_GROUPS && joins(m)).for_each(|m| m.group = group);
    }
    None
}

/// Number of points of each group, at most its number `wanted`: first one for each group, then the
/// others in turn.
pub(super) fn shares(wanted: &[usize; MAX_GROUPS], most: usize) -> [usize; MAX_GROUPS] {
    let mut shares = [0; MAX_GROUPS];
    let mut left = most;
    while left > 0 {
        let before = left;
        for (share, wanted) in shares.iter_mut().zip(wanted) {
            if *share < *wanted && left > 0 {
                *share += 1;
                left -= 1;
            }
        }
        if left == before {
            break;
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    fn members(normals: &[DVec3]) -> Vec<Member> {
        let member = |(i, normal): (usize, &DVec3)| Member { normal: *normal, depth: -(i as f64), group: 0 };
        normals.iter().enumerate().map(member).collect()
    }

    #[test]
    fn normals_within_five_degrees_of_a_deeper_one_are_one_group() {
        let tilted = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let mut found = members(&[tilted(0.0), tilted(4.9), tilted(5.1), tilted(9.0), tilted(-4.9), tilted(90.0)]);
        assert_eq!(group(&mut found), 3);
        assert_eq!(found.iter().map(|m| m.group).collect::<Vec<_>>(), [0, 0, 1, 1, 0, 2]);
    }

    /// All directions of a grid on the sphere: many more than eight groups of five degrees.
    #[test]
    fn there_are_at_most_eight_groups() {
        let mut normals = Vec::new();
        for i in 0..40 {
            for k in 0..80 {
                let (z, turn) = (f64::from(i) / 19.5 - 1.0, f64::from(k) * 0.0785);
                let around = (1.0 - z * z).max(0.0).sqrt();
                normals.push(DVec3::new(around * turn.cos(), around * turn.sin(), z));
            }
        }
        let mut found = members(&normals);
        let count = group(&mut found);
        assert!((4..=MAX_GROUPS).contains(&count), "{count}");
        assert!(found.iter().all(|member| member.group < count));
    }

    #[test]
    fn shares_are_given_in_turn() {
        assert_eq!(shares(&[20, 0, 0, 0, 0, 0, 0, 0], 8), [8, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(shares(&[20, 2, 0, 0, 0, 0, 0, 0], 8), [6, 2, 0, 0, 0, 0, 0, 0]);
        assert_eq!(shares(&[5, 5, 5, 0, 0, 0, 0, 0], 8), [3, 3, 2, 0, 0, 0, 0, 0]);
        assert_eq!(shares(&[9; 8], 8), [1; 8]);
        assert_eq!(shares(&[1, 1, 0, 0, 0, 0, 0, 0], 8), [1, 1, 0, 0, 0, 0, 0, 0]);
    }
}
