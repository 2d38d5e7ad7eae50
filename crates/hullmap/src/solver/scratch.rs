//! Memory for the polytopes of EPA: the workspace of a query, and [`Scratch`] for threads with a
//! small stack.

use std::cell::RefCell;

use super::epa::polytope::Polytope;

/// Maximum number of vertices of each polytope size. The first is enough for small hulls and
/// touching pairs, the second for nearly all queries, the third for sphere-like hulls; the last
/// limits the cost of a query.
pub(super) const SIZES: [usize; 4] = [24, 64, 256, 1024];

pub(super) type Small = Polytope<{ SIZES[0] }, { 2 * SIZES[0] }>;
pub(super) type Medium = Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>;
pub(super) type Big = Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>;
pub(super) type Biggest = Polytope<{ SIZES[3] }, { 2 * SIZES[3] }>;

/// The polytopes of the first two sizes: 16 KB, written before their first use.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub(super) small: Option<Small>,
    pub(super) medium: Option<Medium>,
}

impl Workspace {
    #[inline(always)]
    pub(super) fn small(&mut self) -> &mut Small {
        existing(&mut self.small)
    }

    #[inline(always)]
    pub(super) fn medium(&mut self) -> &mut Medium {
        existing(&mut self.medium)
    }

    #[inline(never)]
    pub(super) fn enlarge(&mut self) {
        let medium = existing(&mut self.medium);
        if let Some(small) = &self.small {
            small.overwrite(medium);
        }
    }
}

thread_local! {
    /// The workspace of the thread. A new one would be written in each query.
    static WORKSPACE: RefCell<Workspace> = const { RefCell::new(Workspace { small: None, medium: None }) };
}

/// Runs a search with the workspace of the thread. A search inside another one, in the support
/// mapping of a user's own shape, has a new one.
#[inline(always)]
pub(super) fn with_workspace<R>(search: impl FnOnce(&mut Workspace) -> R) -> R {
    WORKSPACE.with(|own| match own.try_borrow_mut() {
        Ok(mut workspace) => search(&mut workspace),
        Err(_) => search(&mut Box::default()),
    })
}

/// The polytope in `place`.
#[inline(always)]
fn existing<const V: usize, const F: usize>(place: &mut Option<Polytope<V, F>>) -> &mut Polytope<V, F> {
    match place {
        Some(polytope) => polytope,
        none => insert_empty(none),
    }
}

/// The polytope in `place`, without a surface. `noise` is the error bound of offsets, a length.
#[inline(always)]
pub(super) fn cleared<const V: usize, const F: usize>(
    place: &mut Option<Polytope<V, F>>,
    noise: f64,
) -> &mut Polytope<V, F> {
    let polytope = existing(place);
    polytope.clear(noise);
    polytope
}

/// Not inlined: the polytope would be on the stack of each caller before it is moved.
#[cold]
#[inline(never)]
fn insert_empty<const V: usize, const F: usize>(place: &mut Option<Polytope<V, F>>) -> &mut Polytope<V, F> {
    place.insert(Polytope::EMPTY)
}

/// Memory for the large polytopes of deep contacts. With it, every query runs on a stack of
/// [`STACK_SIZE`](Self::STACK_SIZE).
///
/// A deep contact of two round shapes with thousands of vertices needs a polytope of up to 1,024
/// vertices. Without scratch memory it is on the stack: see
/// [`Settings::stack_size`](crate::Settings::stack_size). A thread whose stack is smaller, for
/// instance a fiber of a job system, owns one `Scratch` and lends it to the cache of each query
/// with [`Cache::set_scratch`](crate::Cache::set_scratch). The answers have the same bits with and
/// without it.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Pose, Scratch, Settings, contact, shapes::Cuboid};
///
/// let cube = Cuboid::new(DVec3::ONE)?;
/// // One per thread, made once.
/// let mut scratch = Scratch::boxed();
/// // One per pair.
/// let mut caches = vec![Cache::new(); 2];
/// let b_in_a = Pose::from_translation(DVec3::new(1.9, 0.1, 0.3))?;
/// for cache in &mut caches {
///     cache.set_scratch(scratch);
///     assert!(contact(&cube, &cube, b_in_a, &Settings::default(), cache).hit);
///     scratch = cache.take_scratch().ok_or("the cache has it")?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scratch {
    pub(super) big: Big,
    pub(super) biggest: Biggest,
}

impl Scratch {
    /// Stack in bytes that is enough for every query whose cache has been lent a `Scratch`: on
    /// 64-bit processors, in an optimised build, in addition to what a user's own shape needs.
    ///
    /// # Reference
    /// Measured: `tests/queries/stack.rs` runs every query on a stack of this size.
    pub const STACK_SIZE: usize = 64 * 1024;

    /// Allocates scratch memory: about 230 KB. The largest part of it is on the stack for a moment,
    /// so call it on a thread with an ordinary stack.
    pub fn boxed() -> Box<Self> {
        Box::new(Self { big: Polytope::EMPTY, biggest: Polytope::EMPTY })
    }
}

/// The scratch memory that a cache has been lent. It is not part of the cache's contents: a clone
/// of the cache has none, and caches are equal with and without it.
#[derive(Debug, Default)]
pub(super) struct Lent(pub(super) Option<Box<Scratch>>);

impl Clone for Lent {
    fn clone(&self) -> Self {
        Self(None)
    }
}

impl PartialEq for Lent {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
