//! Scalar twin of the kernels in plain f32: GJK and EPA on the Minkowski difference, and the
//! support query.
//!
//! `kernels/*.wgsl` do the same, operation by operation and function by function, so that both
//! return the same bits on a device that rounds to nearest and does not fuse operations. Tests
//! compare them. `FUSED` makes the twin fuse every product with the sum that follows, as other
//! devices may; docs/intervals.md, section 13, bounds the errors of both.

mod epa;
mod gjk;
mod simplex;
mod support;

use support::Run;

pub use support::Found;

use crate::records::{AnswerRecord, Pair, PairRecord, StateRecord, Tables, code};

/// Query of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Query {
    /// Yes or no: stop at the first proof.
    Intersects,
    /// The distance, until the interval is within the tolerance.
    Distance,
    /// The penetration depth, until the interval is within the tolerance.
    Contact,
}

/// Support calls of a pair. About 10 are usual.
pub const MAX_STEPS: u32 = 64;

/// Nodes and blocks that a pair may read. Of pairs of hulls with up to 65,536 vertices, 99 % read
/// less than 300; the others are near the axis of a fan of thousands of faces, and read all of
/// them.
pub const MAX_READS: u32 = 1 << 11;

/// Twice the largest possible f32 would be infinite; every dot product is above this.
const LOWEST: f32 = -3.0e38;

/// 2⁻²³: bound on the relative error of one operation.
const EPSILON: f32 = f32::EPSILON;

/// A volume above this many times the product of the lengths of two edges and a corner is positive.
const CERTAIN: f32 = 16.0 * EPSILON;

type Vector = [f32; 3];

fn mad<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { libm::fmaf(a, b, c) } else { a * b + c }
}

fn dot<const FUSED: bool>(a: Vector, b: Vector) -> f32 {
    mad::<FUSED>(a[2], b[2], mad::<FUSED>(a[1], b[1], a[0] * b[0]))
}

fn cross<const FUSED: bool>(a: Vector, b: Vector) -> Vector {
    [
        mad::<FUSED>(a[1], b[2], -(a[2] * b[1])),
        mad::<FUSED>(a[2], b[0], -(a[0] * b[2])),
        mad::<FUSED>(a[0], b[1], -(a[1] * b[0])),
    ]
}

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scaled(a: Vector, by: f32) -> Vector {
    [a[0] * by, a[1] * by, a[2] * by]
}

fn l1(a: Vector) -> f32 {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// Input of the kernel for `pair`.
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{Pair, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let pair = Pair { a: 0, b: 0, b_in_a: Pose::from_translation(DVec3::X * 9.0).expect("finite") };
/// let record = twin::prepare(&Tables::of(&pack)?, &pair);
/// // The reach is about 11, and lengths are multiplied by a power of two that makes it about 1.
/// assert_eq!(record.scale, 1.0 / 16.0);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn prepare(tables: &Tables<'_>, pair: &Pair) -> PairRecord {
    PairRecord::of(pair, &tables.hulls)
}

/// Answer of the kernels for one pair.
///
/// `tolerance` is relative, of the width of the interval.
///
/// # Complexity
/// At most `max_steps` support calls, which read at most [`MAX_READS`] nodes and blocks.
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{MAX_STEPS, Pair, Query, Status, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let tables = Tables::of(&pack)?;
/// let pair = Pair { a: 0, b: 0, b_in_a: Pose::from_translation(DVec3::X * 9.0).expect("finite") };
/// let record = twin::prepare(&tables, &pair);
/// let answer = twin::solve::<false>(&tables, &record, Query::Intersects, 1e-5, MAX_STEPS);
/// assert_eq!(answer.status(), Status::Separated);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn solve<const FUSED: bool>(
    tables: &Tables<'_>,
    pair: &PairRecord,
    query: Query,
    tolerance: f32,
    max_steps: u32,
) -> AnswerRecord {
    solve_from::<FUSED>(tables, pair, query, tolerance, max_steps, &mut StateRecord::default())
}

/// Answer of the kernels for one pair, starting from `state`, which becomes the state of the end.
///
/// # Complexity
/// The cost of [`solve`].
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{MAX_STEPS, Pair, Query, StateRecord, Status, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let tables = Tables::of(&pack)?;
/// let pair = Pair { a: 0, b: 0, b_in_a: Pose::from_translation(DVec3::X * 1.2).expect("finite") };
/// let record = twin::prepare(&tables, &pair);
/// let mut state = StateRecord::default();
/// let mut solve = || twin::solve_from::<false>(&tables, &record, Query::Distance, 1e-5, MAX_STEPS, &mut state);
/// let (cold, warm) = (solve(), solve());
/// assert!(cold.status() == warm.status() && warm.steps < cold.steps);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn solve_from<const FUSED: bool>(
    tables: &Tables<'_>,
    pair: &PairRecord,
    query: Query,
    tolerance: f32,
    max_steps: u32,
    state: &mut StateRecord,
) -> AnswerRecord {
    if pair.a == PairRecord::REJECTED {
        let (normal, status) = ([1.0, 0.0, 0.0], code::REJECTED);
        return AnswerRecord { normal, status, upper: -LOWEST, ..AnswerRecord::default() };
    }
    let mut run = Run { tables, fuel: MAX_READS };
    let ended = gjk::gjk::<FUSED>(&mut run, pair, query, tolerance, max_steps, state);
    let mut out = match ended.out.status {
        code::TETRAHEDRON | code::AXES => epa::epa::<FUSED>(&mut run, pair, tolerance, max_steps, ended),
        _ => ended.out,
    };
    out.reads = MAX_READS - run.fuel;
    out
}

/// Answer of the support kernel: the support vertex of hull `hull` in direction `dir`.
///
/// `dir` is in the hull's frame and of about unit length.
///
/// # Complexity
/// At most [`MAX_READS`] nodes and blocks.
///
/// # Examples
/// ```
/// use hullmap_wgpu::{Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(200, 1));
/// let found = twin::support::<false>(&Tables::of(&pack)?, 0, [0.0, 0.0, 1.0]);
/// let hull = pack.hull(0).expect("the pack has a hull");
/// assert_eq!(found.vertex, hull.support(hullmap::glam::Vec3::Z).index);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn support<const FUSED: bool>(tables: &Tables<'_>, hull: u32, dir: [f32; 3]) -> Found {
    let Some(record) = tables.hulls.get(hull as usize) else { return Found::default() };
    if record.block_count == 0 {
        return Found::default();
    }
    Run { tables, fuel: MAX_READS }.support::<FUSED>(hull, dir)
}
