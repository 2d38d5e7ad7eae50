//! Scalar twin of the kernels in plain f32: GJK and EPA on the Minkowski difference, and the
//! support query.
//!
//! `kernels/*.wgsl` do the same, operation by operation, so that both return the same bits on a
//! device that rounds to nearest and does not fuse operations. Tests compare them. `FUSED` makes
//! the twin fuse every product with the sum that follows, as other devices may; docs/intervals.md,
//! section 13, bounds the errors of both.

mod epa;
mod gjk;
mod query;
mod simplex;
mod support;
mod vector;

use support::Run;
use vector::LOWEST;

pub use query::Query;
pub use support::Found;

use crate::records::{AnswerRecord, IndexedPair, PairRecord, StateRecord, Tables, code};

/// Support calls of a pair. About 10 are usual.
pub const MAX_STEPS: u32 = 64;

/// Nodes and blocks that a pair may read. Of pairs of hulls with up to 65,536 vertices, 99 % read
/// less than 300; the others are near the axis of a fan of thousands of faces, and read all of
/// them.
pub const MAX_READS: u32 = 1 << 11;

/// What the kernel reads about `pair`.
///
/// # Examples
/// ```
/// use hullmap::{Pose, glam::DVec3};
/// use hullmap_wgpu::{IndexedPair, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let b_in_a = Pose::from_translation(DVec3::X * 9.0).expect("finite");
/// let pair = IndexedPair { a: 0, b: 0, b_in_a };
/// let record = twin::prepare(&Tables::from_pack(&pack)?, &pair);
/// // The reach is about 11, and lengths are multiplied by a power of two that makes it about 1.
/// assert_eq!(record.scale, 1.0 / 16.0);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
pub fn prepare(tables: &Tables<'_>, pair: &IndexedPair) -> PairRecord {
    PairRecord::prepare(pair, &tables.hulls)
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
/// use hullmap_wgpu::{IndexedPair, MAX_STEPS, Query, Status, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let tables = Tables::from_pack(&pack)?;
/// let b_in_a = Pose::from_translation(DVec3::X * 9.0).expect("finite");
/// let pair = IndexedPair { a: 0, b: 0, b_in_a };
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
/// use hullmap_wgpu::{IndexedPair, MAX_STEPS, Query, StateRecord, Status, Tables, twin};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
/// let tables = Tables::from_pack(&pack)?;
/// let b_in_a = Pose::from_translation(DVec3::X * 1.2).expect("finite");
/// let pair = IndexedPair { a: 0, b: 0, b_in_a };
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
/// let found = twin::support::<false>(&Tables::from_pack(&pack)?, 0, [0.0, 0.0, 1.0]);
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
