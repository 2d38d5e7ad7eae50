//! Squared distances of the cells of a grid from the nearest marked cell.
//!
//! # Reference
//! Felzenszwalb, Huttenlocher, "Distance transforms of sampled functions", 2012: the lower envelope
//! of parabolas, one axis after the other.

/// Stands for no marked cell. Its square root is far beyond any grid, and sums do not overflow.
pub const FAR: u32 = u32::MAX / 4;

/// The squared distance of each cell's centre from the nearest marked one, in cells; at least
/// [`FAR`] if there is none. The index of a cell is `(z * size[1] + y) * size[0] + x`.
///
/// # Complexity
/// O(cells).
pub fn squared_distances(is_marked: &[bool], size: [usize; 3]) -> Vec<u32> {
    let mut squares: Vec<u32> = is_marked.iter().map(|marked| if *marked { 0 } else { FAR }).collect();
    let longest = size.into_iter().max().unwrap_or(0);
    let (mut line, mut envelope) = (vec![0; longest], Envelope::new(longest));
    for axis in 0..3 {
        let stride = [1, size[0], size[0] * size[1]][axis];
        let count = size[axis];
        for start in (0..squares.len()).filter(|at| (at / stride).is_multiple_of(count)) {
            let line = &mut line[..count];
            line.iter_mut().enumerate().for_each(|(k, square)| *square = squares[start + k * stride]);
            envelope.replace(line);
            line.iter().enumerate().for_each(|(k, square)| squares[start + k * stride] = *square);
        }
    }
    squares
}

struct Envelope {
    lowest: Vec<(usize, u32)>,
    starts: Vec<f64>,
}

impl Envelope {
    fn new(count: usize) -> Self {
        Self { lowest: Vec::with_capacity(count), starts: Vec::with_capacity(count) }
    }

    /// Replaces each value by the least sum of a value and the squared distance from it.
    fn replace(&mut self, line: &mut [u32]) {
        self.lowest.clear();
        self.starts.clear();
        for (at, height) in line.iter().copied().enumerate().filter(|(_, height)| *height < FAR) {
            let mut start = f64::NEG_INFINITY;
            while let (Some(&(other, low)), Some(&begins)) = (self.lowest.last(), self.starts.last()) {
                let value = |at: usize, height: u32| f64::from(height) + (at * at) as f64;
                start = (value(at, height) - value(other, low)) / (2.0 * (at - other) as f64);
                if start > begins {
                    break;
                }
                self.lowest.pop();
                self.starts.pop();
                start = f64::NEG_INFINITY;
            }
            self.lowest.push((at, height));
            self.starts.push(start);
        }
        let mut next = 0;
        for (k, value) in line.iter_mut().enumerate() {
            while next + 1 < self.starts.len() && self.starts[next + 1] <= k as f64 {
                next += 1;
            }
            *value = self.lowest.get(next).map_or(FAR, |(at, height)| height + (at.abs_diff(k) as u32).pow(2));
        }
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    #[test]
    fn distances_match_all_pairs() {
        let mut rng = SplitMix64::new(1);
        let size = [9, 7, 5];
        let at = |i: usize| [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
        for round in 0..40 {
            let share = [0.0, 0.01, 0.1, 0.6][round % 4];
            let marked: Vec<bool> = (0..9 * 7 * 5).map(|_| rng.unit() < share).collect();
            let found = squared_distances(&marked, size);
            for (i, square) in found.into_iter().enumerate() {
                let to = |j: usize| (0..3).map(|axis| at(i)[axis].abs_diff(at(j)[axis]).pow(2) as u32).sum::<u32>();
                let truth = (0..marked.len()).filter(|j| marked[*j]).map(to).min().unwrap_or(FAR);
                assert_eq!(square, truth, "round {round}, cell {i}");
            }
        }
    }
}
