//! The slab of the slides, cut into convex parts in several ways.

use hullmap::glam::DVec3;
use hullmap_random::SplitMix64;
use hullmap_testkit::polytope::cut;

/// Half of the side of the square slab, in metres.
pub const HALF: f64 = 4.0;

/// Thickness of the slab, in metres.
pub const THICKNESS: f64 = 0.5;

/// How the slab is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// One hull.
    Whole,
    /// 8 × 8 cuboids.
    Grid,
    /// 64 convex parts, cut by random planes that lean by up to 30°.
    Random,
    /// The grid, with gaps of 1 µm.
    Gaps,
    /// The grid, with tops that differ by up to 1 µm.
    Steps,
    /// The grid, with parts that extend into their neighbours by 0.2 m, as the parts of a cover do.
    Overlap,
}

impl Cut {
    /// All cuts, in the order of the table.
    pub const CUTS: [Self; 5] = [Self::Grid, Self::Random, Self::Gaps, Self::Steps, Self::Overlap];

    /// Corners of the parts of the slab, whose top is the plane y = 0.
    pub fn parts(self) -> Vec<Vec<DVec3>> {
        let slab = [DVec3::new(-HALF, -THICKNESS, -HALF), DVec3::new(HALF, 0.0, HALF)];
        let mut rng = SplitMix64::new(16);
        match self {
            Self::Whole => vec![corners(slab)],
            Self::Grid => grid(|_| (0.0, 0.0)),
            Self::Gaps => grid(|_| (-0.5e-6, 0.0)),
            Self::Steps => grid(|_| (0.0, rng.between(-1e-6, 1e-6))),
            Self::Overlap => grid(|_| (0.2, 0.0)),
            Self::Random => {
                let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                let sides = |axis: DVec3| [(axis, slab[1].dot(axis)), (-axis, -slab[0].dot(axis))];
                let slab: Vec<_> = axes.into_iter().flat_map(sides).collect();
                cut(&slab, 64, 0.0, || {
                    let angle = rng.between(0.0, std::f64::consts::PI);
                    DVec3::new(angle.cos(), rng.between(-0.577, 0.577), angle.sin()).normalize()
                })
            }
        }
    }
}

/// Corners of a box.
pub fn corners([low, high]: [DVec3; 2]) -> Vec<DVec3> {
    let pick = |i: usize, k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
    (0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect()
}

/// 8 × 8 cuboids. `change` returns how far the sides of one are moved outwards, and its top up.
fn grid(mut change: impl FnMut(usize) -> (f64, f64)) -> Vec<Vec<DVec3>> {
    let cell = 2.0 * HALF / 8.0;
    let part = |i: usize| {
        let (grow, rise) = change(i);
        let low = DVec3::new((i % 8) as f64 * cell - HALF, -THICKNESS, (i / 8) as f64 * cell - HALF);
        let high = low + DVec3::new(cell, THICKNESS, cell);
        let sideways = DVec3::new(grow, 0.0, grow);
        let within = |p: DVec3| p.clamp(DVec3::splat(-HALF), DVec3::splat(HALF));
        corners([within(low - sideways), within(high + sideways) + DVec3::new(0.0, rise, 0.0)])
    };
    (0..64).map(part).collect()
}
