//! Warning about points so far from the origin that `f32` loses precision: by a ratio of lengths,
//! at any scale.

use hullmap_geometry::PointSet;
use hullmap_geometry::number::{percent, short};

use crate::fault::{counted, excerpt};

/// Largest coordinate, relative to the extent of the set, above which the warning is given: the
/// spacing of `f32` is then more than 6e-5 of the extent, which leaves about four digits.
const FAR: f64 = 1000.0;

/// Warning about a point set whose distance from the origin costs it precision. `name` is the name
/// of the object, for the message.
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
    // One point has no extent to lose precision of. Several that coincide may have lost all of it.
    if size == 0.0 && positions.len() > 1 && far > 0.0 {
        return Some(format!(
            "object {}: all {} points have the same 32-bit coordinates, {} from the origin; if they differ in the file, use --set recentre=true",
            excerpt(name),
            positions.len(),
            short(far)
        ));
    }
    (size > 0.0 && far > FAR * size).then(|| {
        format!(
            "object {}: {} from the origin with an extent of {}, so 32-bit coordinates have a spacing of {} of the extent; --set recentre=true keeps the precision of the file",
            excerpt(name),
            short(far),
            short(size),
            percent(far * f64::from(f32::EPSILON) / size)
        )
    })
}

/// One warning for a file: [`far_away`] of the first object, with the number of the others.
pub(crate) fn far_away_warning(sets: &[PointSet]) -> Option<String> {
    let mut warnings = sets.iter().filter_map(|set| far_away(&set.name, &set.positions));
    let first = warnings.next()?;
    Some(match warnings.count() {
        0 => first,
        others => format!("{first} (and {} like it)", counted(others, "object", "objects")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_many_objects_gets_one_warning() {
        let set = |x: f32| PointSet {
            name: "crate".to_owned(),
            positions: vec![[x, 0.0, 0.0], [x + 1.0, 1.0, 0.0]],
            ..PointSet::default()
        };
        assert_eq!(far_away_warning(&[set(0.0), set(1.0)]), None);
        let one = far_away_warning(&[set(0.0), set(1e6)]).unwrap();
        assert!(one.starts_with("object crate: ") && !one.contains("like it"), "{one}");
        let many = far_away_warning(&vec![set(1e6); 3]).unwrap();
        assert_eq!(many, format!("{one} (and 2 objects like it)"));
    }

    #[test]
    fn the_warning_does_not_depend_on_scale() {
        for scale in [1e-20, 1e-3, 1.0, 1e3, 1e20] {
            let at = |x: f32| [[x * scale, 0.0, 0.0], [(x + 1.0) * scale, scale, 0.0]];
            assert_eq!(far_away("a", &at(-500.0)), None, "{scale}");
            assert!(far_away("a", &at(2000.0)).unwrap().contains("object a: "), "{scale}");
            assert!(far_away("a", &at(-2000.0)).is_some(), "{scale}");
        }
        assert_eq!(far_away("a", &[[1e30; 3]]), None);
        assert_eq!(far_away("a", &[[0.0; 3]; 2]), None);
        assert!(far_away("a", &[[1e6; 3]; 2]).unwrap().contains("--set recentre=true"));
        assert_eq!(far_away("a", &[]), None);
    }
}
