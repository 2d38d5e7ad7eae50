//! EPA, the expanding polytope algorithm: penetration depth from a polytope that grows inside the
//! Minkowski difference until its nearest face is a face of the difference.
//!
//! Computes the minimum support value h(n) over all unit normals n, which is the penetration depth,
//! as an interval; or a separating plane, if the origin turns out to be outside.
//!
//! # Reference
//! van den Bergen 2001 (expanding polytope), cited by Kenwright as [15]. It takes over from portal
//! refinement, whose depth depends on the origin ray.
//!
//! # Steps
//! 1. Start from the tetrahedron of v0 and the portal, from the last query's polytope under the new
//!    pose, or from a tetrahedron of [`seed`].
//! 2. Take the face nearest to the origin. Its plane's offset d bounds the depth from below.
//! 3. Query w = support(n) along its normal n. The support value h(n) = w · n bounds the depth from
//!    above.
//! 4. Stop if the bounds are close. Else insert w into the polytope and repeat from step 2.
//!
//! `search` has steps 2 to 4, `polytope` the surface, `flat` the cases without volume, and
//! `workspace` the memory.
//!
//! # Deviations
//! - "Nearest" is by signed offset, so the origin need not be inside at the start. While it is
//!   outside, the polytope grows towards it, until it is inside or a support plane proves it
//!   outside. No portal is too poor to start from.
//! - d is a bound only once the surface certainly winds around the origin. Until then nothing is
//!   claimed.
//! - The smallest h(n) of all faces tried is kept with its face, so the upper bound never grows.
//! - The face of the smallest h(n) may be inside the difference, or the origin's foot may be
//!   outside the face, as in the middle of a flat or curved side with many vertices. Then GJK finds
//!   the witness points ([`Bound::settle`]).
//! - The ball around the interior points bounds the depth from below too, so round shapes end at
//!   once.
//! - Polytopes come in four sizes: most queries never touch the large arrays.

mod flat;
mod polytope;
mod search;
mod seed;
pub(in crate::solver) mod workspace;

pub(in crate::solver) use self::flat::{BESIDE_ROUNDINGS, FLAT_ROUNDINGS};
pub(in crate::solver) use self::search::{End, Expansion, Goal, TOUCHING_ROUNDINGS, Terms};
pub(crate) use self::workspace::Workspace;

use glam::DVec3;

use self::flat::{expand_flat, settle, widest_normal};
use self::polytope::Polytope;
use self::search::{Aim, KEEP, Next, State, aim, continue_with, run};
use self::seed::{Flat, seed};
use self::workspace::{Big, Biggest, Large, Medium, SIZES, Small, cleared};
use crate::solver::bound::{Bound, FOOT_ROUNDINGS};
use crate::solver::cache::Cache;
use crate::solver::minkowski::{Minkowski, Point};
use crate::solver::scratch::Scratch;
use crate::support::SupportMap;

/// Number of expansions that need no polytope of the last size, from any start.
pub(in crate::solver) const MAX_BIG_EXPANSIONS: u32 = (SIZES[2] - KEEP) as u32;

/// A portal is not a start if the height of its tetrahedron is at most this many rounding errors:
/// its planes would be noise.
const THIN_ROUNDINGS: f64 = 64.0;

/// Expansions from a kept polytope after which it is stale and dropped.
const WORN_OUT: u32 = 8;

/// Free vertices that a kept polytope must leave in the smallest size.
const SPARE: usize = 6;

/// An expansion that waits for a support point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EpaSearch {
    terms: Terms,
    state: State,
    aim: Aim,
    is_medium: bool,
    /// It has started from the polytope of the cache.
    again: bool,
    /// The polytope is stored in the cache while it grows.
    keeps: bool,
}

/// Progress of an expansion.
pub(in crate::solver) enum Progress {
    /// It needs the support point in this direction.
    Ask(DVec3),
    /// It has ended. `None` if it started from the polytope of the cache and has stalled.
    Ended(Option<Expansion>),
}

impl EpaSearch {
    fn new(terms: Terms, state: State) -> Self {
        Self { terms, state, aim: Aim::NOTHING, is_medium: false, again: false, keeps: terms.keeps_polytope() }
    }

    /// Expands from `tetrahedron` if it has volume, else from one found here. `bound` is an upper
    /// bound known already. If the goal is a depth, keeps the polytope in `cache`.
    ///
    /// # Errors
    /// The difference is flat; this is the whole result.
    #[inline(always)]
    pub(in crate::solver) fn start<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &mut Minkowski<'_, A, B>,
        tetrahedron: Option<[Point; 4]>,
        terms: Terms,
        bound: Bound,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Result<Self, Expansion> {
        let mut state = State::new(bound);
        let small = cleared(&mut workspace.small, m.noise());
        let thin = THIN_ROUNDINGS * m.rounding_error();
        if !tetrahedron.is_some_and(|tetrahedron| small.start(tetrahedron, thin))
            && let Err(Flat { normal }) = start_elsewhere(m, small)
        {
            let expansion = expand_flat(m, normal, state.out);
            return Err(settle(m, expansion));
        }
        state.encloses = small.encloses();
        if terms.keeps_polytope() {
            cache.forget_polytope();
        }
        Ok(Self::new(terms, state))
    }

    /// Expands from the polytope in `cache`. `None` if there is none that encloses the origin under
    /// the new pose.
    #[inline(always)]
    pub(in crate::solver) fn start_again<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &Minkowski<'_, A, B>,
        terms: Terms,
        cache: &Cache,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        let points = cache.polytope()?.points().len();
        let is_medium = points + SPARE > SIZES[0];
        let state = if is_medium {
            restore(m, cleared(&mut workspace.medium, m.noise()), cache)?
        } else {
            restore(m, cleared(&mut workspace.small, m.noise()), cache)?
        };
        Some(Self { is_medium, again: true, keeps: false, ..Self::new(terms, state) })
    }

    /// Continues up to the next support query.
    #[inline(always)]
    pub(in crate::solver) fn aim<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Progress {
        let Self { terms, state, is_medium, keeps, .. } = self;
        if !*is_medium {
            match aim(workspace.small(), state, terms, keeps.then_some(&mut *cache)) {
                Next::Ask(aim) => return self.ask(aim),
                Next::Ended => return self.end(m, cache, workspace),
                Next::Full => {
                    workspace.enlarge();
                    (*is_medium, *keeps) = (true, terms.keeps_polytope());
                }
            }
        }
        match aim(workspace.medium(), state, terms, keeps.then_some(&mut *cache)) {
            Next::Ask(aim) => self.ask(aim),
            Next::Ended => self.end(m, cache, workspace),
            // Polytopes of the last two sizes are not kept, and they are rare: they are expanded at
            // once.
            Next::Full => {
                let expansion = match cache.scratch() {
                    Some(scratch) => expand_in_scratch(m, workspace.medium(), state, terms, scratch),
                    None => expand_on_stack(m, workspace.medium(), state, terms),
                };
                self.settle(m, expansion, cache)
            }
        }
    }

    #[inline(always)]
    fn ask(&mut self, aim: Aim) -> Progress {
        self.aim = aim;
        Progress::Ask(aim.direction())
    }

    /// Continues with the support point in the direction that was stated last, up to the next
    /// support query.
    #[inline(always)]
    pub(in crate::solver) fn continue_with<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        point: Point,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Progress {
        let Self { terms, state, aim, .. } = self;
        let has_ended = if self.is_medium {
            continue_with(workspace.medium(), state, terms, aim, point)
        } else {
            continue_with(workspace.small(), state, terms, aim, point)
        };
        if has_ended { self.end(m, cache, workspace) } else { self.aim(m, cache, workspace) }
    }

    fn end<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &mut self,
        m: &mut Minkowski<'_, A, B>,
        cache: &mut Cache,
        workspace: &mut Workspace,
    ) -> Progress {
        let Self { terms, state, .. } = self;
        let kept_in = terms.keeps_polytope().then_some(&mut *cache);
        let expansion = if self.is_medium {
            finish(m, workspace.medium(), state, terms, kept_in)
        } else {
            finish(m, workspace.small(), state, terms, kept_in)
        };
        self.settle(m, expansion, cache)
    }

    fn settle<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        &self,
        m: &mut Minkowski<'_, A, B>,
        expansion: Expansion,
        cache: &mut Cache,
    ) -> Progress {
        if self.again && self.state.out.iterations > WORN_OUT {
            cache.forget_polytope();
        }
        let is_useless = self.again && expansion.end == End::Stalled;
        Progress::Ended((!is_useless).then(|| settle(m, expansion)))
    }
}

/// Decides whether the origin is inside, at once, from `tetrahedron` if it has volume. At most
/// `max_expansions` steps.
pub(in crate::solver) fn decide<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    tetrahedron: Option<[Point; 4]>,
    max_expansions: u32,
    cache: &mut Cache,
) -> Expansion {
    let (mut workspace, terms) = (Workspace::default(), Terms::new(m, Goal::Decide, max_expansions));
    let mut search = match EpaSearch::start(m, tetrahedron, terms, Bound::none(), cache, &mut workspace) {
        Ok(search) => search,
        Err(expansion) => return expansion,
    };
    let mut progress = search.aim(m, cache, &mut workspace);
    loop {
        match progress {
            Progress::Ask(dir) => progress = search.continue_with(m.point(dir), m, cache, &mut workspace),
            Progress::Ended(Some(expansion)) => return expansion,
            // Only an expansion from the cache's polytope ends this way.
            Progress::Ended(None) => return State::new(Bound::none()).out,
        }
    }
}

/// Restores the polytope in `cache` under the new pose. `None` if it does not certainly enclose the
/// origin.
#[inline]
fn restore<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &Minkowski<'_, A, B>,
    polytope: &mut Polytope<V, F>,
    cache: &Cache,
) -> Option<State> {
    let kept = cache.polytope()?;
    let points = kept.points().map(|features| m.recall(features));
    let encloses = polytope.restore(points, kept.faces()) && polytope.encloses();
    encloses.then(|| State { encloses: true, ..State::new(Bound::none()) })
}

/// Starts from a tetrahedron of [`seed`].
#[cold]
#[inline(never)]
fn start_elsewhere<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &mut Small,
) -> Result<(), Flat> {
    let tetrahedron = seed(m)?;
    // Otherwise its height is noise in the normal of a thin triangle.
    let is_solid = polytope.start(tetrahedron, 0.0);
    if is_solid { Ok(()) } else { Err(Flat { normal: widest_normal(tetrahedron) }) }
}

/// Continues in caller-owned memory.
#[inline(never)]
fn expand_in_scratch<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Medium,
    state: &mut State,
    terms: &Terms,
    Scratch { large: Large { big, biggest } }: &mut Scratch,
) -> Expansion {
    match expand_in(m, medium, big, state, terms) {
        Ok(expansion) => expansion,
        Err(big) => expand_in(m, big, biggest, state, terms).unwrap_or_else(|last| finish(m, last, state, terms, None)),
    }
}

/// Continues on the stack.
#[inline(never)]
fn expand_on_stack<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
    m: &mut Minkowski<'_, A, B>,
    medium: &Medium,
    state: &mut State,
    terms: &Terms,
) -> Expansion {
    /// A function of its own, since most expansions do not need its stack.
    #[inline(never)]
    fn expand_to_the_limit<A: SupportMap + ?Sized, B: SupportMap + ?Sized>(
        m: &mut Minkowski<'_, A, B>,
        big: &Big,
        state: &mut State,
        terms: &Terms,
    ) -> Expansion {
        let mut biggest = Biggest::empty(0.0);
        expand_in(m, big, &mut biggest, state, terms).unwrap_or_else(|last| finish(m, last, state, terms, None))
    }
    let mut big = Big::empty(0.0);
    expand_in(m, medium, &mut big, state, terms).unwrap_or_else(|big| expand_to_the_limit(m, big, state, terms))
}

/// Moves the surface into `larger` and expands it there without suspending.
///
/// # Errors
/// That polytope is full too; the state reports it.
fn expand_in<
    'p,
    A: SupportMap + ?Sized,
    B: SupportMap + ?Sized,
    const V: usize,
    const F: usize,
    const W: usize,
    const G: usize,
>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &Polytope<V, F>,
    larger: &'p mut Polytope<W, G>,
    state: &mut State,
    terms: &Terms,
) -> Result<Expansion, &'p Polytope<W, G>> {
    polytope.overwrite(larger);
    if run(m, larger, state, terms) { Ok(finish(m, larger, state, terms, None)) } else { Err(larger) }
}

/// Computes the witness points of the bound and keeps the polytope if it is fit to be kept.
///
/// The steps of the search for witness points count in the result, and not in `state`.
fn finish<A: SupportMap + ?Sized, B: SupportMap + ?Sized, const V: usize, const F: usize>(
    m: &mut Minkowski<'_, A, B>,
    polytope: &Polytope<V, F>,
    state: &mut State,
    terms: &Terms,
    cache: Option<&mut Cache>,
) -> Expansion {
    let Bound { upper, normal, .. } = state.out.bound;
    let face = state.corners.map(|corners| corners.map(|i| polytope.point(i)));
    if let Some(face) = &face {
        state.out.bound = Bound::on_face(upper, normal, face.each_ref());
        state.out.features = Point::first_features(face.iter().map(|point| point.features));
    }
    if state.encloses && terms.keeps_polytope() {
        state.out.others = polytope.offset_beside(normal);
    }
    let mut expansion = state.out;
    if expansion.end == End::Converged {
        let width = (upper - expansion.lower).min(terms.allowance(upper)).max(0.0);
        let enough = width + FOOT_ROUNDINGS * m.noise();
        expansion.iterations += expansion.bound.settle(m, face.as_ref().map_or(&[], |face| face), enough);
    }
    if let Some(cache) = cache {
        if !state.encloses || state.out.end == End::Stalled {
            cache.forget_polytope();
        } else if polytope.point_count() <= KEEP {
            cache.keep_polytope(polytope.features(), polytope.faces());
        }
    }
    expansion
}
