//! Directions of a hull's edges, rounded: what tells that a vertex is the support point without asking its neighbours.
//!
//! Vertex v is the support point in direction d if (w − v)·d < 0 for all its neighbours w. The unit vector from v to w is
//! stored as three i16, times [`SCALE`] and rounded. For a stored edge q, q·d is off by at most [`DOUBT`]·|d|₁; where it is
//! below minus that for all edges, v is the support point for certain, whatever is rounded.

/// What a coordinate of 1 is stored as.
pub const SCALE: f64 = 32767.0;

/// By how much q·d, taken in f32, can be off, as a share of |d|₁: half a unit from rounding the edge, and 4 roundings by
/// 2⁻²⁴ of at most 32,767 each (of the direction, a product and two sums), 0.008, with as much again to spare.
pub const DOUBT: f32 = 0.52;

/// The edge from `v` to `w`, which differ.
///
/// Every operation is rounded once by IEEE 754, so that the result is the same everywhere.
#[expect(clippy::indexing_slicing, reason = "an array of three is made of two arrays of three")]
pub fn quantise(v: [f32; 3], w: [f32; 3]) -> [i16; 3] {
    let edge: [f64; 3] = std::array::from_fn(|i| f64::from(w[i]) - f64::from(v[i]));
    let length = (edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]).sqrt();
    // Casts saturate, and make 0 of NaN.
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
