//! Rotates, scales and recentres source coordinates, and rounds them to `f32` once.

use crate::fault::Fault;
use crate::mesh::Positions;
use crate::options::{ImportOptions, UpAxis};

/// A list of positions is shortened when an eighth of it is unused, so that all copies amount to at
/// most eight times the list.
const FREED_FRACTION: usize = 8;

/// Transform from the frame of a source file to the frame of its hulls.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    up_axis: UpAxis,
    scale: f64,
    /// Origin of the hulls' frame in the source frame, after rotation and scale.
    pub origin: [f64; 3],
    is_recentred: bool,
}

pub fn requires_double(options: &ImportOptions) -> bool {
    options.recentre || options.unit_scale != 1.0
}

impl Placement {
    /// The placement for `options`. With `recentre`, the origin is the centre of the bounds of
    /// `vertices`; otherwise 0. Complexity: O(vertices).
    pub fn new(positions: &Positions, vertices: impl Iterator<Item = u32>, options: &ImportOptions) -> Self {
        let mut placement = Self {
            up_axis: options.up_axis,
            scale: options.unit_scale,
            origin: [0.0; 3],
            is_recentred: options.recentre,
        };
        if options.recentre {
            let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for vertex in vertices {
                let point = placement.in_source(positions.get(vertex));
                for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
                    *low = low.min(x);
                    *high = high.max(x);
                }
            }
            for (origin, (low, high)) in placement.origin.iter_mut().zip(low.into_iter().zip(high)) {
                // Halved before the addition, which could overflow. Adding +0 turns -0 into +0.
                *origin = low / 2.0 + high / 2.0 + 0.0;
            }
        }
        placement
    }

    fn in_source(&self, point: [f64; 3]) -> [f64; 3] {
        self.rotate(point).map(|x| x * self.scale)
    }

    fn rotate<T: Copy + std::ops::Neg<Output = T>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self.up_axis {
            UpAxis::Keep => [x, y, z],
            UpAxis::YToZ => [x, -z, y],
            UpAxis::ZToY => [x, z, -y],
        }
    }

    /// Position of a vertex in the hulls' frame. Fails if a coordinate is too large for `f32`.
    #[expect(clippy::indexing_slicing, reason = "callers pass vertices of the mesh")]
    pub fn place(&self, positions: &Positions, vertex: u32) -> Result<[f32; 3], Fault> {
        if let (Positions::Single(singles), false) = (positions, self.is_recentred || self.scale != 1.0) {
            return Ok(self.rotate(singles[vertex as usize]));
        }
        self.place_point(positions.get(vertex), vertex)
    }

    /// Positions in the hulls' frame. Frees the memory of `f64` positions on the way: both lists
    /// would be the peak of an import. Fails if a coordinate is too large for `f32`.
    #[expect(
        clippy::indexing_slicing,
        reason = "`placed` is as long as `doubles` was at first, and `vertex` is below that"
    )]
    pub fn place_all(&self, positions: &mut Positions) -> Result<Vec<[f32; 3]>, Fault> {
        let mut placed = vec![[0.0; 3]; positions.len()];
        match positions {
            Positions::Double(doubles) => {
                // In reverse order, since a list can only be shortened at its end.
                while let Some(point) = doubles.pop() {
                    let vertex = doubles.len();
                    placed[vertex] = self.place_point(point, vertex as u32)?;
                    if doubles.capacity() - vertex > doubles.capacity() / FREED_FRACTION {
                        doubles.shrink_to_fit();
                    }
                }
            }
            Positions::Single(_) => {
                for (vertex, placed) in placed.iter_mut().enumerate() {
                    *placed = self.place(positions, vertex as u32)?;
                }
            }
        }
        Ok(placed)
    }

    fn place_point(&self, point: [f64; 3], vertex: u32) -> Result<[f32; 3], Fault> {
        let point = self.in_source(point);
        let ([x, y, z], [a, b, c]) = (point, self.origin);
        let moved = [x - a, y - b, z - c];
        let placed = moved.map(|x| x as f32);
        match moved.into_iter().zip(placed).find(|(_, placed)| !placed.is_finite()) {
            None => Ok(placed),
            Some((coordinate, _)) => Err(Fault::Unplaceable {
                vertex,
                coordinate,
                after: if self.scale == 1.0 { "after its transform" } else { "after scaling" },
                remedy: "use a smaller --unit-scale, or correct the transforms in the file",
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: ImportOptions = ImportOptions::DEFAULT;

    fn placed(positions: &Positions, options: ImportOptions) -> (Vec<[f32; 3]>, [f64; 3]) {
        let count = positions.len() as u32;
        let placement = Placement::new(positions, 0..count, &options);
        let one_by_one: Vec<[f32; 3]> = (0..count).map(|vertex| placement.place(positions, vertex).unwrap()).collect();
        let mut copy = match positions {
            Positions::Single(all) => Positions::Single(all.clone()),
            Positions::Double(all) => Positions::Double(all.clone()),
        };
        assert_eq!(placement.place_all(&mut copy).unwrap(), one_by_one);
        (one_by_one, placement.origin)
    }

    #[test]
    fn rotations_are_exact_and_inverse() {
        let point = [1.1_f32, 2.7, -3.3];
        for positions in [Positions::Single(vec![point]), Positions::Double(vec![point.map(f64::from)])] {
            let rotated = |up_axis| placed(&positions, ImportOptions { up_axis, ..PLAIN }).0[0];
            assert_eq!(rotated(UpAxis::Keep), point);
            assert_eq!(rotated(UpAxis::YToZ), [1.1, 3.3, 2.7]);
            assert_eq!(rotated(UpAxis::ZToY), [1.1, -3.3, -2.7]);
            let back = Positions::Single(vec![rotated(UpAxis::YToZ)]);
            assert_eq!(placed(&back, ImportOptions { up_axis: UpAxis::ZToY, ..PLAIN }).0[0], point);
        }
    }

    #[test]
    fn positions_are_scaled_before_they_are_rounded() {
        // f32 cannot hold 16777217. Rounding before scaling would give another result.
        let exact = 16_777_217.0_f64;
        let options = ImportOptions { unit_scale: 0.1, ..PLAIN };
        let got = placed(&Positions::Double(vec![[exact; 3]]), options).0[0][0];
        assert_eq!(got, (exact * 0.1) as f32);
        assert_ne!(got, (f64::from(exact as f32) * 0.1) as f32);
    }

    #[test]
    fn recentring_keeps_the_precision_of_distant_points() {
        let far = |x: f64| [1e6 + x, -2e6 - x, 3e9 + 2.0 * x];
        let points = [0.0, 0.001, 0.002, 0.5, 1.0].map(far);
        let options = ImportOptions { recentre: true, ..PLAIN };
        let (got, origin) = placed(&Positions::Double(points.to_vec()), options);
        assert_eq!(origin, [1e6 + 0.5, -2e6 - 0.5, 3e9 + 1.0]);
        for (got, point) in got.iter().zip(points) {
            for axis in 0..3 {
                // The rounding error of 3e9 in f64 is 5e-7. In f32 it would be 128.
                assert!((f64::from(got[axis]) + origin[axis] - point[axis]).abs() < 1e-6);
            }
        }
        assert_eq!(got[0][2], -got[4][2]);
    }

    #[test]
    fn coordinates_beyond_f32_are_reported() {
        let positions = Positions::Double(vec![[0.0; 3], [0.0, 1e30, 0.0]]);
        let options = ImportOptions { unit_scale: 1e10, ..PLAIN };
        let placement = Placement::new(&positions, 0..2, &options);
        let error = placement.place(&positions, 1).unwrap_err().to_string();
        assert!(error.contains("vertex 1 has the coordinate 1e40 after scaling"), "{error}");
    }
}
