//! Quantised directions of a hull's edges: they certify a support vertex without its neighbours.
//!
//! Vertex v is the support point in direction d if (w − v)·d < 0 for all its neighbours w. The unit
//! vector from v to w is stored as three i16, times [`SCALE`] and rounded. For a stored edge q, q·d
//! differs from its exact value by at most [`DOUBT`]·|d|₁. If q·d is below −[`DOUBT`]·|d|₁ for all
//! edges, v is certainly the support point, in spite of all rounding errors.

/// Stored value of the coordinate 1.
pub const SCALE: f64 = 32767.0;

/// Maximum error of q·d in f32, relative to |d|₁: half a unit for the rounded edge, 0.008 for four
/// more roundings (of the direction, a product and two sums) by 2⁻²⁴ of at most 32,767, and margin.
pub const DOUBT: f32 = 0.52;

/// The edge from `v` to `w`, which must differ. Every operation is rounded once by IEEE 754, the
/// same everywhere.
#[expect(clippy::indexing_slicing, reason = "an array of three is made of two arrays of three")]
pub fn quantise(v: [f32; 3], w: [f32; 3]) -> [i16; 3] {
    let edge: [f64; 3] = std::array::from_fn(|i| f64::from(w[i]) - f64::from(v[i]));
    let length = (edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]).sqrt();
    // Casts saturate, and turn NaN into 0.
    edge.map(|c| (c / length * SCALE).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_off_by_half_a_unit_at_most() {
        let v = [0.25, -3.0, 1e-3];
        for w in [[0.25, -2.0, 1e-3], [7.0, 5.0, -2.0], [0.25, -3.000001, 0.001001], [f32::MAX, 0.0, 0.0]] {
            let edge: [f64; 3] = std::array::from_fn(|i| f64::from(w[i]) - f64::from(v[i]));
            let length = edge.iter().map(|c| c * c).sum::<f64>().sqrt();
            let stored = quantise(v, w);
            for i in 0..3 {
                assert!((f64::from(stored[i]) - edge[i] / length * SCALE).abs() <= 0.5 + 1e-9, "{w:?}");
            }
        }
        assert_eq!(quantise(v, v), [0; 3]);
    }
}
