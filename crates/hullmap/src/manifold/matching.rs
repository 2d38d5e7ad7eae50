//! Contact points of this frame and of the last one that are the same point.

/// A pair of points that may be the same: of this frame and of the last one, by index.
pub(crate) trait Likeness {
    /// Whether both are on the same features.
    fn has_same_features(&self, point: usize, other: usize) -> bool;

    /// Distance between both, on the body on which they are nearer.
    fn distance(&self, point: usize, other: usize) -> f64;
}

/// The other point that each of `matches.len()` points is, if it is one of `taken.len()` others:
/// one on the same features, or else one that is at most `same_place` away, the nearest of several.
/// Each of the others is at most one of the points. `taken` and `matches` are overwritten.
pub(crate) fn match_points(
    likeness: &impl Likeness,
    same_place: f64,
    taken: &mut [bool],
    matches: &mut [Option<usize>],
) {
    taken.fill(false);
    matches.fill(None);
    for by_features in [true, false] {
        for (point, matched) in matches.iter_mut().enumerate().filter(|(_, matched)| matched.is_none()) {
            let is_same = |other: usize| {
                if by_features {
                    likeness.has_same_features(point, other)
                } else {
                    likeness.distance(point, other) <= same_place
                }
            };
            *matched = (0..taken.len())
                .filter(|other| !taken[*other] && is_same(*other))
                .min_by(|p, q| likeness.distance(point, *p).total_cmp(&likeness.distance(point, *q)));
            if let Some(other) = *matched {
                taken[other] = true;
            }
        }
    }
}
