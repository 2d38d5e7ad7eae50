//! From a file's coordinates to a hull's: turned, scaled, moved to the middle, and rounded to f32 once.

use crate::fault::Fault;
use crate::mesh::Positions;
use crate::options::{ImportOptions, UpAxis};

/// Vertices that are placed before their memory is given back: 6 MB.
const PLACED_AT_A_TIME: usize = 1 << 18;

/// How the vertices of one file are placed.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    up_axis: UpAxis,
    scale: f64,
    /// Origin of the hulls' frame in the source's frame, turned and scaled.
    pub origin: [f64; 3],
    is_recentred: bool,
}

/// Whether these options compute with more digits than f32 has.
pub fn wants_double(options: &ImportOptions) -> bool {
    options.recentre || options.unit_scale != 1.0
}

impl Placement {
    /// The placement that `options` ask for. The origin is the middle of the bounds of `vertices`, or 0.
    ///
    /// # Complexity
    /// O(vertices).
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
                // Halved first: the sum of two large numbers may overflow. Adding +0 makes the two zeros one.
                *origin = low / 2.0 + high / 2.0 + 0.0;
            }
        }
        placement
    }

    /// Turned and scaled, in f64.
    fn in_source(&self, point: [f64; 3]) -> [f64; 3] {
        self.turn(point).map(|x| x * self.scale)
    }

    fn turn<T: Copy + std::ops::Neg<Output = T>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self.up_axis {
            UpAxis::Keep => [x, y, z],
            UpAxis::YToZ => [x, -z, y],
            UpAxis::ZToY => [x, z, -y],
        }
    }

    /// A vertex in the hulls' frame.
    ///
    /// # Errors
    /// A coordinate that is too large for f32.
    #[expect(clippy::indexing_slicing, reason = "asked only of vertices that the mesh has")]
    pub fn place(&self, positions: &Positions, vertex: u32) -> Result<[f32; 3], Fault> {
        if let (Positions::Single(singles), false) = (positions, self.is_recentred || self.scale != 1.0) {
            return Ok(self.turn(singles[vertex as usize]));
        }
        self.place_point(positions.get(vertex), vertex)
    }

    /// All vertices in the hulls' frame. Those in f64 are given back to the system as they are placed: both lists as a
    /// whole would be the most that an import ever holds.
    ///
    /// # Errors
    /// A coordinate that is too large for f32.
    #[expect(
        clippy::indexing_slicing,
        reason = "`placed` is as long as `doubles` was at first, and `vertex` is below that"
    )]
    pub fn place_all(&self, positions: &mut Positions) -> Result<Vec<[f32; 3]>, Fault> {
        let mut placed = vec![[0.0; 3]; positions.len()];
        match positions {
            Positions::Double(doubles) => {
                // From the end, where a list can be shortened.
                while let Some(point) = doubles.pop() {
                    let vertex = doubles.len();
                    placed[vertex] = self.place_point(point, vertex as u32)?;
                    if vertex % PLACED_AT_A_TIME == 0 {
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
                after: if self.scale == 1.0 { "once transformed" } else { "once scaled" },
                remedy: "use a smaller --unit-scale, or mend the file's transforms",
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
    fn turns_are_exact_and_undo_each_other() {
        let point = [1.1_f32, 2.7, -3.3];
        for positions in [Positions::Single(vec![point]), Positions::Double(vec![point.map(f64::from)])] {
            let turned = |up_axis| placed(&positions, ImportOptions { up_axis, ..PLAIN }).0[0];
            assert_eq!(turned(UpAxis::Keep), point);
            assert_eq!(turned(UpAxis::YToZ), [1.1, 3.3, 2.7]);
            assert_eq!(turned(UpAxis::ZToY), [1.1, -3.3, -2.7]);
            let back = Positions::Single(vec![turned(UpAxis::YToZ)]);
            assert_eq!(placed(&back, ImportOptions { up_axis: UpAxis::ZToY, ..PLAIN }).0[0], point);
        }
    }

    #[test]
    fn scaled_once_and_rounded_once() {
        // 16777217 has a digit more than f32 keeps: rounded before it is scaled, the result would be another.
        let exact = 16_777_217.0_f64;
        let options = ImportOptions { unit_scale: 0.1, ..PLAIN };
        let got = placed(&Positions::Double(vec![[exact; 3]]), options).0[0][0];
        assert_eq!(got, (exact * 0.1) as f32);
        assert_ne!(got, (f64::from(exact as f32) * 0.1) as f32);
    }

    #[test]
    fn recentring_keeps_the_digits_of_what_is_far_away() {
        let far = |x: f64| [1e6 + x, -2e6 - x, 3e9 + 2.0 * x];
        let points = [0.0, 0.001, 0.002, 0.5, 1.0].map(far);
        let options = ImportOptions { recentre: true, ..PLAIN };
        let (got, origin) = placed(&Positions::Double(points.to_vec()), options);
        assert_eq!(origin, [1e6 + 0.5, -2e6 - 0.5, 3e9 + 1.0]);
        for (got, point) in got.iter().zip(points) {
            for axis in 0..3 {
                // What is left is the rounding of 3e9 in f64, 5e-7; f32 alone would step by 256.
                assert!((f64::from(got[axis]) + origin[axis] - point[axis]).abs() < 1e-6);
            }
        }
        assert_eq!(got[0][2], -got[4][2]);
    }

    #[test]
    fn what_f32_cannot_hold_is_named() {
        let positions = Positions::Double(vec![[0.0; 3], [0.0, 1e30, 0.0]]);
        let options = ImportOptions { unit_scale: 1e10, ..PLAIN };
        let placement = Placement::new(&positions, 0..2, &options);
        let error = placement.place(&positions, 1).unwrap_err().to_string();
        assert!(error.contains("vertex 1 is at 1e40 once scaled"), "{error}");
    }
}
