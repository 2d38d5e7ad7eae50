//! hullmap: `Hull::support` on a pack with any index kind, and `Hull::support_from`. Exact.

use std::time::Duration;

use glam::Vec3;
use hullmap::{Hull, Pack};
use hullmap_bake::IndexKind;

use crate::{
    query::{Rival, SupportQuery},
    subject::Subject,
};

/// A pack with one hull.
pub struct Indexed {
    name: &'static str,
    bytes: Vec<u8>,
    pack: Pack,
}

impl Indexed {
    /// Bakes `subject` with an index of `kind`; also returns the time to build the index.
    pub fn new(name: &'static str, subject: &Subject, kind: IndexKind) -> (Self, Duration) {
        let (bytes, build_time) = subject.pack_bytes(kind);
        (Self::open(name, bytes), build_time)
    }

    fn open(name: &'static str, bytes: Vec<u8>) -> Self {
        let pack = Pack::from_bytes(&bytes).expect("a pack just written opens");
        Self { name, bytes, pack }
    }

    fn hull(&self) -> Hull<'_> {
        self.pack.hull(0).expect("a pack has a hull")
    }
}

impl Rival for Indexed {
    type Query<'a> = Cold<'a>;

    fn name(&self) -> &str {
        self.name
    }

    fn index_bytes(&self) -> usize {
        self.hull().index_byte_len()
    }

    fn footprint_bytes(&self) -> usize {
        2 * self.pack.byte_len()
    }

    fn query(&self) -> Cold<'_> {
        Cold { hull: self.hull() }
    }

    fn duplicate(&self) -> Self {
        Self::open(self.name, self.bytes.clone())
    }
}

/// A query without state.
pub struct Cold<'a> {
    hull: Hull<'a>,
}

impl SupportQuery for Cold<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.hull.support(dir).point
    }
}

/// A query with the last answer as a hint.
pub struct Hinted(pub Indexed);

impl Rival for Hinted {
    type Query<'a> = Warm<'a>;

    fn name(&self) -> &str {
        self.0.name()
    }

    fn index_bytes(&self) -> usize {
        let hull = self.0.hull();
        let edges: usize = (0..hull.vertex_count() as u32).map(|v| hull.neighbours(v).len()).sum();
        self.0.index_bytes() + size_of::<u32>() * hull.vertex_count() + size_of::<[i16; 3]>() * edges
    }

    fn footprint_bytes(&self) -> usize {
        self.0.footprint_bytes()
    }

    fn query(&self) -> Warm<'_> {
        Warm { hull: self.0.hull(), last: 0 }
    }

    fn duplicate(&self) -> Self {
        Self(self.0.duplicate())
    }
}

/// A query that starts from its last answer.
pub struct Warm<'a> {
    hull: Hull<'a>,
    last: u32,
}

impl SupportQuery for Warm<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        let found = self.hull.support_from(dir, self.last);
        self.last = found.index;
        found.point
    }
}
