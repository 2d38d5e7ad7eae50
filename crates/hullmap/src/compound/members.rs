//! A compound shape: the hulls of a pack, or one hull.

use super::bvh::Nodes;
use crate::hull::{Hull, MassProperties};
use crate::pack::Pack;

/// The union of the hulls of a pack, or a single hull. A cheap copy: it borrows the pack.
#[derive(Clone, Copy, Debug)]
pub struct Compound<'a> {
    members: Members<'a>,
}

#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a hull consists of slices; a pointer to it would require an owner")]
enum Members<'a> {
    Pack(&'a Pack),
    One(Hull<'a>),
}

impl<'a> Compound<'a> {
    /// The union of all hulls of `pack`, in the frame of the pack.
    pub fn new(pack: &'a Pack) -> Self {
        Self { members: Members::Pack(pack) }
    }

    /// Number of hulls; 0 only for a pack that was opened without checks.
    pub fn hull_count(&self) -> usize {
        match self.members {
            Members::Pack(pack) => pack.hull_count(),
            Members::One(_) => 1,
        }
    }

    /// Mass properties at a uniform `density`, as one rigid body: see [`Pack::mass_properties`]. A
    /// single hull has the mass properties of its mesh if it represents the whole mesh.
    ///
    /// # Complexity
    /// O(number of hulls).
    pub fn mass_properties(&self, density: f64) -> MassProperties {
        match self.members {
            Members::Pack(pack) => pack.mass_properties(density),
            Members::One(hull) => hull.body_mass_properties(density),
        }
    }

    pub(super) fn nodes(&self) -> Nodes<'_> {
        match self.members {
            Members::Pack(pack) => Nodes::of_pack(pack.nodes()),
            Members::One(hull) => {
                let [low, high] = hull.bounds().map(|corner| corner.as_dvec3());
                Nodes::one(low, high)
            }
        }
    }

    /// The hull with this index; `None` if the index is not below [`hull_count`](Self::hull_count).
    pub fn hull(&self, index: usize) -> Option<Hull<'a>> {
        match self.members {
            Members::Pack(pack) => pack.hull(index).ok(),
            Members::One(hull) => (index == 0).then_some(hull),
        }
    }
}

impl<'a> From<Hull<'a>> for Compound<'a> {
    fn from(hull: Hull<'a>) -> Self {
        Self { members: Members::One(hull) }
    }
}

impl<'a> From<&'a Pack> for Compound<'a> {
    fn from(pack: &'a Pack) -> Self {
        Self::new(pack)
    }
}
