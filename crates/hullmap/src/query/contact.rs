//! Contact of two geometries, and the contacts of all pairs of their parts.

use super::{PairQuery, answer};
use crate::compound::{self, ContactCounts, Parts, half_space};
use crate::geometry::Geometry;
use crate::pose::Pose;
use crate::shapes::{HalfSpace, Shape};
use crate::solver::{Cache, Contact, Settings, queries};

/// Contact of `a` and `b`, with `b` at `b_in_a`: penetration depth, normal and witness points.
///
/// Lengths are in the geometries' unit, points and directions in A's frame. The normal points from
/// A to B: moving B by `depth` along it separates two shapes, and no shorter motion does. `cache`
/// belongs to this ordered pair; the query reads and updates it.
///
/// Numerical trouble never reads as "no contact": [`Contact::hit`] is false only if a separating
/// plane was found, of each pair of parts, and [`Contact::status`] reports how the interval of the
/// depth ended.
///
/// With parts, the contact belongs to the pair of parts with the maximum depth, and the interval
/// contains this maximum: `depth_lower` is the maximum lower bound over all pairs, `depth_upper`
/// the maximum upper bound. Moving B by less than `depth_lower` in any direction leaves the
/// geometries overlapping. Moving it by `depth_upper` along `normal` separates this pair; other
/// pairs may still overlap then, or begin to. For a half-space, the normal is the plane's, the
/// depth belongs to the lowest part, and moving B by it separates all parts.
///
/// # Complexity
/// Two shapes: 1 to 4 support calls for most separated pairs, 10 to 40 for most that overlap;
/// bounded by `settings`. Rounded shapes cost up to three distance queries of their cores, and a
/// contact query if the cores overlap. Parts: as [`contacts`]. Half-space: one support query for
/// each part that may be the lowest. Allocation: see [`Cache`].
///
/// # Reference
/// Kenwright, Algorithm 1 and Listing 2; van den Bergen 2001 for the depth.
/// docs/contributors/intervals.md proves the interval.
#[inline]
pub fn contact<A, B>(a: &A, b: &B, b_in_a: Pose, settings: &Settings, cache: &mut Cache) -> Contact
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, ContactOf { b_in_a, settings, cache })
}

/// Calls `visit` with the [`contact`](contact()) of every pair of parts of `a` and `b` that is not
/// proved separated.
///
/// [`Contact::parts`] are the two parts. The order follows the traversal, and is the same for the
/// same input. Returns the number of contacts and the cost.
///
/// # Complexity
/// All pairs of overlapping boxes, and one contact query for each pair of parts in overlapping
/// leaves: G H of them if all overlap, for geometries of G and H parts. Allocation: see [`Cache`].
///
/// # Examples
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/cubes.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let cubes = two_cubes();
/// use hullmap::glam::DVec3;
/// use hullmap::{Cache, Contact, Pose, Settings};
///
/// let above = Pose::from_translation(DVec3::new(0.0, 0.0, 0.875))?;
/// let (settings, mut depths) = (Settings::default(), Vec::new());
/// let visit = |contact: &Contact| depths.push((contact.parts, contact.depth));
/// let counts = hullmap::contacts(&cubes, &cubes, above, &settings, &mut Cache::new(), visit);
/// assert_eq!(counts.hits, 2);
/// assert!(depths.iter().all(|([a, b], depth)| a == b && (depth - 0.125).abs() < 1e-12));
/// # Ok(())
/// # }
/// ```
pub fn contacts<A, B>(
    a: &A,
    b: &B,
    b_in_a: Pose,
    settings: &Settings,
    cache: &mut Cache,
    mut visit: impl FnMut(&Contact),
) -> ContactCounts
where
    A: Geometry + ?Sized,
    B: Geometry + ?Sized,
{
    answer(a, b, ContactsOf { of: ContactOf { b_in_a, settings, cache }, visit: &mut visit })
}

struct ContactOf<'q> {
    b_in_a: Pose,
    settings: &'q Settings,
    cache: &'q mut Cache,
}

impl PairQuery for ContactOf<'_> {
    type Answer = Contact;

    #[inline(always)]
    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> Contact {
        queries::contact(a, b, self.b_in_a, self.settings, self.cache)
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Contact {
        compound::contact(a, b, self.b_in_a, self.settings, self.cache)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Contact {
        half_space::lowest(a, b, self.b_in_a).contact()
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> Contact {
        half_space::lowest(b, a, self.b_in_a.inverse()).contact().exchanged(self.b_in_a)
    }
}

struct ContactsOf<'q> {
    of: ContactOf<'q>,
    visit: &'q mut dyn FnMut(&Contact),
}

impl PairQuery for ContactsOf<'_> {
    type Answer = ContactCounts;

    fn shapes<A: Shape + ?Sized, B: Shape + ?Sized>(self, a: &A, b: &B) -> ContactCounts {
        let mut counts = ContactCounts::default();
        counts.visit(self.of.shapes(a, b), self.visit);
        counts
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> ContactCounts {
        let ContactOf { b_in_a, settings, cache } = self.of;
        compound::contacts(a, b, b_in_a, settings, cache, self.visit)
    }

    fn half_space<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> ContactCounts {
        half_space::contacts(a, b, self.of.b_in_a, self.visit)
    }

    fn half_space_as_b<A: Parts + ?Sized>(self, a: &A, b: &HalfSpace) -> ContactCounts {
        let Self { of: ContactOf { b_in_a, .. }, visit } = self;
        half_space::contacts(b, a, b_in_a.inverse(), &mut |found| visit(&found.exchanged(b_in_a)))
    }
}
