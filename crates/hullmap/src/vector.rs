//! Vector normalisation and perpendiculars, defined once for the whole crate.

#![forbid(unsafe_code)]

use glam::DVec3;

/// `v` normalised; `None` if its length is subnormal, zero or not finite.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let length = v.length();
    // NaN and infinity take the failing branch.
    (length > f64::MIN_POSITIVE && length < f64::INFINITY).then(|| v * (1.0 / length))
}

/// Unit vector perpendicular to the unit vector `n`: the normalised cross product with the axis
/// along which `n` is smallest.
pub(crate) fn perpendicular(n: DVec3) -> DVec3 {
    let m = n.abs();
    let axis = if m.x <= m.y && m.x <= m.z {
        DVec3::X
    } else if m.y <= m.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    unit(n.cross(axis)).unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perpendicular_has_unit_length() {
        for n in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.8, 0.0), DVec3::ONE.normalize()] {
            let p = perpendicular(n);
            assert!((p.length() - 1.0).abs() < 1e-15 && p.dot(n).abs() < 1e-15);
        }
    }

    #[test]
    fn unit_rejects_zero_and_non_finite_vectors() {
        assert_eq!(unit(DVec3::ZERO), None);
        assert_eq!(unit(DVec3::new(f64::NAN, 1.0, 0.0)), None);
        assert_eq!(unit(DVec3::new(f64::INFINITY, 1.0, 0.0)), None);
    }
}
