//! Workspace of EPA: memory for polytopes of each size.

use super::polytope::Polytope;

/// Maximum number of vertices of each polytope size. The first is enough for small hulls and
/// touching pairs, the second for nearly all queries, the third for sphere-like hulls; the last
/// limits the cost of a query.
pub(super) const SIZES: [usize; 4] = [24, 64, 256, 1024];

pub(super) type Small = Polytope<{ SIZES[0] }, { 2 * SIZES[0] }>;
pub(super) type Medium = Polytope<{ SIZES[1] }, { 2 * SIZES[1] }>;
pub(super) type Big = Polytope<{ SIZES[2] }, { 2 * SIZES[2] }>;
pub(super) type Biggest = Polytope<{ SIZES[3] }, { 2 * SIZES[3] }>;

/// The polytopes of the first two sizes: 16 KB, of which only what a query needs is written.
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

    /// Copies the small polytope to the medium one.
    #[inline(never)]
    pub(super) fn enlarge(&mut self) {
        let medium = cleared(&mut self.medium, 0.0);
        if let Some(small) = &self.small {
            small.copy_into(medium);
        }
    }
}

/// The polytope in `place`. There is one: a search starts with [`cleared`].
#[inline(always)]
fn existing<const V: usize, const F: usize>(place: &mut Option<Polytope<V, F>>) -> &mut Polytope<V, F> {
    match place {
        Some(polytope) => polytope,
        none => insert_empty(none),
    }
}

/// Not inlined: the polytope is on this function's stack before it is moved. Inlined, it would be
/// on the stack of each caller.
#[cold]
#[inline(never)]
fn insert_empty<const V: usize, const F: usize>(place: &mut Option<Polytope<V, F>>) -> &mut Polytope<V, F> {
    place.insert(Polytope::empty(0.0))
}

/// The polytope in `place`, without a surface. `noise` is the error bound of offsets, a length.
#[inline(always)]
pub(super) fn cleared<const V: usize, const F: usize>(
    place: &mut Option<Polytope<V, F>>,
    noise: f64,
) -> &mut Polytope<V, F> {
    if let Some(polytope) = place {
        polytope.clear(noise);
    }
    place.get_or_insert_with(|| Polytope::empty(noise))
}

/// The polytopes of the last two sizes.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Large {
    pub(super) big: Big,
    pub(super) biggest: Biggest,
}

impl Large {
    pub(in crate::solver) fn empty() -> Self {
        Self { big: Polytope::empty(0.0), biggest: Polytope::empty(0.0) }
    }
}
