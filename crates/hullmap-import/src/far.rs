//! Points so far from the origin that f32 costs them digits: a ratio, so that nothing changes where a mesh is scaled.

/// Distance from the origin, in sizes of the set, beyond which precision is lost: f32 then steps by more than 6e-5 of
/// the size, four digits.
const FAR: f64 = 1000.0;

/// Warns of points whose distance from the origin costs them digits.
pub fn far_away(name: &str, positions: &[[f32; 3]]) -> Option<String> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in positions {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(position.map(f64::from)) {
            *low = low.min(x);
            *high = high.max(x);
        }
    }
    let size = low.iter().zip(high).map(|(low, high)| high - low).fold(0.0, f64::max);
    let far = low.iter().zip(high).map(|(low, high)| low.abs().max(high.abs())).fold(0.0, f64::max);
    // A single point has no size to lose digits of, but several that came out as one may have lost all.
    if size == 0.0 && positions.len() > 1 && far > 0.0 {
        return Some(format!(
            "object {name}: its {} points have the same 32-bit coordinates, {far:.3e} from the origin; if they differ in the file, --recentre keeps them apart",
            positions.len()
        ));
    }
    (size > 0.0 && far > FAR * size).then(|| {
        format!(
            "object {name}: {far:.3e} from the origin, with a size of {size:.3e}, so that 32-bit coordinates step by {:.1e} of the size; --recentre keeps the file's digits",
            far * f64::from(f32::EPSILON) / size
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_is_far_at_any_scale() {
        for scale in [1e-20, 1e-3, 1.0, 1e3, 1e20] {
            let at = |x: f32| [[x * scale, 0.0, 0.0], [(x + 1.0) * scale, scale, 0.0]];
            assert_eq!(far_away("a", &at(-500.0)), None, "{scale}");
            assert!(far_away("a", &at(2000.0)).unwrap().contains("object a: "), "{scale}");
            assert!(far_away("a", &at(-2000.0)).is_some(), "{scale}");
        }
        assert_eq!(far_away("a", &[[1e30; 3]]), None);
        assert_eq!(far_away("a", &[[0.0; 3]; 2]), None);
        assert!(far_away("a", &[[1e6; 3]; 2]).unwrap().contains("--recentre"));
        assert_eq!(far_away("a", &[]), None);
    }
}
