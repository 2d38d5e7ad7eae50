//! Numbers, points and poses, read from arbitrary bytes. After the last byte, zeros are read.

use glam::{DQuat, DVec3};

/// Bytes that are read in order.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// Starts at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether all bytes have been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        let count = N.min(self.0.len());
        let (taken, rest) = self.0.split_at(count);
        out[..count].copy_from_slice(taken);
        self.0 = rest;
        out
    }

    /// One byte.
    pub fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    /// A byte below `count`, which is at most 256.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    /// A signed byte.
    pub fn signed(&mut self) -> f64 {
        f64::from(self.byte() as i8)
    }

    /// From −1 to 1, in steps of 2⁻¹⁵.
    pub fn share(&mut self) -> f64 {
        f64::from(i16::from_le_bytes(self.take())) / 32768.0
    }

    /// Any f32, finite or not.
    pub fn float(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    /// A nonzero vector of signed bytes.
    pub fn axis(&mut self) -> DVec3 {
        let axis = DVec3::new(self.signed(), self.signed(), self.signed());
        axis.try_normalize().unwrap_or(DVec3::Z)
    }

    /// A rotation: the identity, quarter turns, a tiny angle, or any.
    pub fn rotation(&mut self) -> DQuat {
        let turn = [self.signed(), self.signed(), self.signed(), self.signed()];
        match self.below(4) {
            0 => DQuat::IDENTITY,
            1 => {
                let axis = DVec3::AXES[turn[0].abs() as usize % 3];
                DQuat::from_axis_angle(axis, std::f64::consts::FRAC_PI_2 * (turn[1].abs() % 4.0))
            }
            2 => DQuat::from_xyzw(turn[0] * 1e-10, turn[1] * 1e-8, turn[2] * 1e-6, 1.0).normalize(),
            _ => {
                let turn = DQuat::from_array(turn);
                if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY }
            }
        }
    }

    /// One to `max_count` finite points: on a coarse grid, on a grid disturbed in the last digits,
    /// on a sphere, or, if `wild` allows it, anywhere.
    pub fn points(&mut self, max_count: usize, wild: bool) -> Vec<[f32; 3]> {
        let kind = self.below(if wild { 4 } else { 3 });
        let count = 1 + self.below(max_count);
        (0..count).map(|_| self.point(kind)).collect()
    }

    fn point(&mut self, kind: usize) -> [f32; 3] {
        const COARSE: f64 = 1.0 / 16.0;
        let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
        match kind {
            0 => [(); 3].map(|()| (self.signed() * COARSE) as f32),
            1 => [(); 3].map(|()| {
                let (coarse, fine) = ((self.signed() * COARSE) as f32, self.signed() as f32);
                coarse + coarse * fine * f32::EPSILON
            }),
            2 => {
                let axis = DVec3::new(self.share(), self.share(), self.share());
                axis.try_normalize().unwrap_or(DVec3::X).as_vec3().to_array()
            }
            _ => [(); 3].map(|()| finite(self.float())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_yield_numbers_and_no_bytes_yield_zeros() {
        let mut bytes = Bytes::new(&[200, 0x80, 0, 0x80]);
        assert_eq!((bytes.below(100), bytes.signed(), bytes.share()), (0, -128.0, -1.0));
        assert!(bytes.is_empty());
        assert_eq!((bytes.byte(), bytes.float(), bytes.axis()), (0, 0.0, DVec3::Z));
        assert_eq!(bytes.points(9, true), [[0.0; 3]]);
        for kind in 0..4 {
            let pattern: Vec<u8> = (0..200_u32).map(|i| (i * i * 37 + i) as u8).collect();
            let mut bytes = Bytes::new(&pattern);
            for _ in 0..20 {
                assert!(bytes.point(kind).iter().all(|c| c.is_finite()), "{kind}");
                assert!((bytes.rotation().length() - 1.0).abs() < 1e-12);
            }
        }
    }
}
