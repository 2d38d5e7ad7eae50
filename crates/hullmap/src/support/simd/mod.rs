//! SIMD: dot products of eight candidates at once, dispatched at run time to the processor's
//! instruction set.
//!
//! One build contains every code path. A hull selects its path when it is taken from its pack; a
//! caller can override the choice for a hull ([`Instructions`]), a user for the whole process
//! ([`VARIABLE`]). All paths return the same answers: SIMD only filters candidates, with a margin
//! that exceeds the rounding error of every path (`best_candidate`).
//!
//! To add an instruction set, implement [`Simd`] for a type that only run-time detection can
//! construct (as `avx2` does), and add it to [`Instructions`] and [`Dispatch`]. On AArch64
//! `portable` is NEON already, through glam's `Vec4`.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod operations;
mod portable;

use std::sync::{
    Once,
    atomic::{AtomicBool, Ordering},
};

use hullmap_format::archive::LANES;

pub(crate) use operations::{Kernel, Pass, Simd};
pub(crate) use portable::Portable;

/// Environment variable that selects the instruction set of a process: `portable` or `avx2`.
const VARIABLE: &str = "HULLMAP_INSTRUCTIONS";

/// Bytes of a [`Hull`](crate::Hull) that support queries and the solver read. They come first.
pub(crate) const HOT_BYTES: usize = 128;

/// Whether the variable selects [`Instructions::Portable`].
static PORTABLE: AtomicBool = AtomicBool::new(false);

/// Reads the variable once per process. Called when a pack is opened, so that no query reads the
/// environment.
#[expect(clippy::disallowed_methods, reason = "the variable selects an instruction set, which never changes an answer")]
pub(crate) fn read_variable() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let portable = std::env::var_os(VARIABLE).is_some_and(|value| value == "portable");
        PORTABLE.store(portable, Ordering::Relaxed);
    });
}

/// Instruction set of support queries (SIMD).
///
/// Every hull uses the best instruction set of the processor. Two things override this:
/// [`Hull::with_instructions`](crate::Hull::with_instructions) for one hull, and the environment
/// variable `HULLMAP_INSTRUCTIONS` (`portable` or `avx2`) for the whole process. The variable is
/// read once, when the first pack is opened. Unknown values and instruction sets that the processor
/// lacks are ignored, because an environment variable must not keep an application from starting.
/// [`Hull::instructions`](crate::Hull::instructions) returns the choice. It never changes an
/// answer.
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/rock.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let pack = pack();
/// use hullmap::Instructions;
/// use hullmap::glam::Vec3;
///
/// let rock = pack.hull(0)?;
/// let portable = rock.with_instructions(Instructions::Portable).ok_or("always available")?;
/// assert_eq!(portable.instructions(), Instructions::Portable);
/// assert_eq!(portable.support(Vec3::Z), rock.support(Vec3::Z));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Instructions {
    /// Available on every processor of the target: SSE2 on x86-64, NEON on AArch64, scalar code
    /// elsewhere.
    Portable,
    /// AVX2 with fused multiply-add, on x86-64.
    Avx2,
}

/// The instruction set that a hull uses, with proof that the processor has it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Dispatch {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
}

impl Dispatch {
    /// The best instruction set of this processor, unless the environment variable overrides it.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if !PORTABLE.load(Ordering::Relaxed)
            && let Some(avx2) = avx2::Avx2::detect()
        {
            return Self::Avx2(avx2);
        }
        Self::Portable
    }

    /// The requested instruction set; `None` if this processor lacks it.
    pub(crate) fn detect(instructions: Instructions) -> Option<Self> {
        match instructions {
            Instructions::Portable => Some(Self::Portable),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => avx2::Avx2::detect().map(Self::Avx2),
            #[cfg(not(target_arch = "x86_64"))]
            Instructions::Avx2 => None,
        }
    }

    /// Index of the minimum of `values`, counted over the chunks as one slice; the lowest index
    /// among equals. 0 if there are no values, or only NaN.
    #[inline(always)]
    pub(crate) fn argmin(self, values: &[[f64; LANES]]) -> usize {
        match self {
            Self::Portable => portable::argmin(values),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.argmin(values),
        }
    }

    /// Runs `pass`, compiled for this instruction set.
    #[inline(always)]
    pub(crate) fn pass(self, pass: &mut impl Pass) {
        match self {
            Self::Portable => portable_pass(pass),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.pass(pass),
        }
    }

    pub(crate) fn instructions(self) -> Instructions {
        match self {
            Self::Portable => Instructions::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => Instructions::Avx2,
        }
    }

    /// Runs `kernel`, compiled for this instruction set.
    #[inline(always)]
    pub(crate) fn run<K: Kernel>(self, kernel: K, dir: [K::Scalar; 3]) -> K::Output {
        let [x, y, z] = dir;
        match self {
            Self::Portable => portable(kernel, x, y, z),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.run(kernel, [x, y, z]),
        }
    }
}

/// Tells the processor to fetch `value` into its caches, and does not wait. No effect on processors
/// other than x86-64.
#[inline(always)]
pub(crate) fn fetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    avx2::fetch(value);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// As [`fetch`], for what queries read first of a value of any type, as of a hull.
#[inline(always)]
pub(crate) fn fetch_start<T: ?Sized>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    avx2::fetch_bytes(std::ptr::from_ref(value).cast(), size_of_val(value).min(HOT_BYTES));
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// A function of its own, so that only the other path is inlined into the caller.
#[inline(never)]
fn portable<K: Kernel>(kernel: K, x: K::Scalar, y: K::Scalar, z: K::Scalar) -> K::Output {
    kernel.run(Portable, [x, y, z])
}

#[inline(never)]
fn portable_pass(pass: &mut impl Pass) {
    pass.run(Portable);
}

/// Every instruction set of this processor.
#[cfg(test)]
pub(crate) fn dispatches() -> impl Iterator<Item = Dispatch> {
    [Instructions::Portable, Instructions::Avx2].into_iter().filter_map(Dispatch::detect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::lane_set::LaneSet;
    use crate::facets::table::{NormalBlock, PointBlock};
    use shapes::rng::SplitMix64;

    /// All operations on `N` blocks of points and of faces, and what they return.
    struct Operations<'p, const N: usize> {
        points: &'p [PointBlock; N],
        faces: &'p [NormalBlock; N],
        dir: [f32; 3],
        turned: Vec<PointBlock>,
        /// For each block of faces, the heights of all points, and what `highest` returns.
        all_heights: Vec<Vec<[f32; LANES]>>,
        highest: Vec<([f32; LANES], [u32; LANES])>,
        near: LaneSet,
        less: u32,
    }

    const ROWS: [[f32; 3]; 3] = [[0.5, 0.25, -1.5], [-0.75, 0.1, 0.3], [1.1, -0.2, 0.7]];

    const THRESHOLD: f32 = 0.25;

    impl<const N: usize> Pass for Operations<'_, N> {
        #[inline(always)]
        fn run<S: Simd>(&mut self, simd: S) {
            self.near = simd.near_farthest(self.points, self.dir, 0.25);
            let mut values = self.points[0].0[0];
            values[3] = f32::NAN;
            self.less = simd.less(&values, THRESHOLD);
            self.turned = self.points.iter().map(|block| simd.transform(block, &ROWS, self.dir)).collect();
            for faces in self.faces {
                let mut all = Vec::new();
                let highest = simd.highest(self.points, faces, |index, heights| {
                    assert_eq!(index, all.len());
                    all.push(heights);
                });
                self.highest.push(highest);
                self.all_heights.push(all);
            }
        }
    }

    /// Counts of near points, and of lesser values.
    type Seen = [u32; 2];

    fn compare_with_scalars<const N: usize>(rng: &mut SplitMix64, round: usize, seen: &mut Seen) {
        let mut lanes = || [(); LANES].map(|()| rng.between(-1.0, 1.0) as f32);
        let mut points = [(); N].map(|()| PointBlock([lanes(), lanes(), lanes()]));
        // Ties: the first two points and the last one are equal, and so are two faces.
        for axis in 0..3 {
            points[0].0[axis][1] = points[0].0[axis][0];
            points[N - 1].0[axis][LANES - 1] = points[0].0[axis][0];
        }
        let mut faces = [(); N].map(|()| NormalBlock { normal: [lanes(), lanes(), lanes()], offset: lanes() });
        faces[N - 1] = faces[0];
        let n = if round.is_multiple_of(3) { points[0].0.map(|c| c[0]) } else { faces[0].normal.map(|c| c[0]) };
        let at = |i: usize| points[i / LANES].0.map(|c| c[i % LANES]);
        let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let height = |i: usize, p: [f32; 3]| {
            let faces = &faces[i / LANES];
            dot(faces.normal.map(|c| c[i % LANES]), p) + faces.offset[i % LANES]
        };
        let dots: Vec<f32> = (0..LANES * N).map(|i| dot(at(i), n)).collect();
        let best = dots.iter().fold(f32::NEG_INFINITY, |max, dot| max.max(*dot));
        let near: Vec<usize> = (0..LANES * N).filter(|i| dots[*i] >= best - 0.25).collect();
        let less = (0..LANES).filter(|i| *i == 3 || points[0].0[0][*i] < THRESHOLD).map(|i| 1 << i).sum();
        seen[0] += near.len() as u32;
        seen[1] += u32::count_ones(less);
        for dispatch in dispatches() {
            let mut all = Operations {
                points: &points,
                faces: &faces,
                dir: n,
                turned: Vec::new(),
                all_heights: Vec::new(),
                highest: Vec::new(),
                near: LaneSet::EMPTY,
                less: 0,
            };
            dispatch.pass(&mut all);
            assert_eq!(all.less, less, "{dispatch:?}");
            assert_eq!(all.near.iter().collect::<Vec<_>>(), near);
            for i in 0..LANES * N {
                let (block, lane) = (i / LANES, i % LANES);
                let over = |point: usize| height(i, at(point));
                let first_highest =
                    (0..LANES * N).fold(0, |best, point| if over(point) > over(best) { point } else { best });
                let (highest, points) = all.highest[block];
                assert_eq!(
                    (highest[lane], points[lane] as usize),
                    (over(first_highest), first_highest),
                    "{dispatch:?}"
                );
                assert!((0..LANES * N).all(|point| all.all_heights[block][point][lane] == over(point)), "{dispatch:?}");
                for axis in 0..3 {
                    let expected = dot(ROWS[axis], at(i)) + n[axis];
                    assert_eq!(all.turned[block].0[axis][lane], expected);
                }
            }
        }
    }

    #[test]
    fn operations_on_points_and_faces_are_the_same_on_every_instruction_set() {
        let mut rng = SplitMix64::new(5);
        let mut seen = [0; 2];
        for round in 0..100 {
            compare_with_scalars::<1>(&mut rng, round, &mut seen);
            compare_with_scalars::<2>(&mut rng, round, &mut seen);
            compare_with_scalars::<4>(&mut rng, round, &mut seen);
            compare_with_scalars::<8>(&mut rng, round, &mut seen);
        }
        // In 400 rounds: some points near the farthest one, and lesser values.
        assert!(seen[0] > 800 && (1_000..3_000).contains(&seen[1]), "{seen:?}");
    }

    #[test]
    fn argmin_returns_the_first_minimum() {
        let mut rng = SplitMix64::new(3);
        for chunks in [1, 2, 7, 8, 9, 40] {
            for round in 0..200 {
                let mut values = vec![[f64::INFINITY; LANES]; chunks];
                for value in values.as_flattened_mut() {
                    // Few distinct values, so that there are ties, and infinity, which marks unused
                    // lanes.
                    *value = (rng.between(0.0, 20.0) as i32 - 4 + round % 3).into();
                    *value = if *value > 10.0 { f64::INFINITY } else { *value };
                }
                let flat = values.as_flattened();
                let expected = (0..flat.len()).fold(0, |best, at| if flat[at] < flat[best] { at } else { best });
                for dispatch in dispatches() {
                    assert_eq!(dispatch.argmin(&values), expected, "{:?} {values:?}", dispatch.instructions());
                }
            }
        }
        assert_eq!(Dispatch::best().argmin(&[]), 0);
        assert_eq!(Dispatch::best().argmin(&[[f64::NAN; LANES]]), 0);
    }
}
