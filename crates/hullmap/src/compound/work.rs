//! Tests of the work of a query, counted: parts taken, and pairs of boxes compared.

use std::cell::RefCell;

use glam::{DQuat, DVec3};
use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};
use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::packs::{bytes, point_set};
use shapes::{families, rng::SplitMix64};

use super::bvh::Nodes;
use super::parts::Tree;
use super::traversal::BOXES;
use crate::geometry::{Geometry, Visitor};
use crate::height_field::{Diagonal, HeightField, Layout};
use crate::pack::Pack;
use crate::shapes::Sphere;
use crate::shapes::triangle::VisitTriangle;
use crate::triangle_mesh::TriangleMesh;
use crate::{Cache, CastSettings, Compound, CompoundManifolds, ManifoldSettings, Motion, Pose, Ray, Settings};

/// Parts that remember which of them were taken.
struct Counted<'a, P>(&'a P, RefCell<Vec<usize>>);

impl<'a, P: Tree> Counted<'a, P> {
    fn new(parts: &'a P) -> Self {
        Self(parts, RefCell::default())
    }

    /// Numbers of parts taken and of pairs of boxes compared by a query. Panics if a part was taken
    /// twice, although `is_single` says that the other geometry is one part.
    fn work<T>(&self, is_single: bool, query: impl FnOnce(&Self) -> T) -> [u32; 2] {
        self.1.borrow_mut().clear();
        BOXES.set(0);
        let _ = query(self);
        let mut taken = self.1.borrow().clone();
        let count = taken.len();
        taken.sort_unstable();
        taken.dedup();
        assert!(!is_single || taken.len() == count, "{count} parts taken, {} of them twice", count - taken.len());
        [count as u32, BOXES.get()]
    }
}

impl<P: Tree> Tree for Counted<'_, P> {
    type Part<'p>
        = P::Part<'p>
    where
        Self: 'p;

    fn part_count(&self) -> usize {
        self.0.part_count()
    }

    fn part(&self, index: usize) -> Option<P::Part<'_>> {
        self.1.borrow_mut().push(index);
        self.0.part(index)
    }

    fn sheet_normal(&self, index: usize) -> Option<DVec3> {
        self.0.sheet_normal(index)
    }

    fn nodes(&self) -> Nodes<'_> {
        self.0.nodes()
    }

    fn any_in_box(&self, bounds: [DVec3; 2], visit: &mut VisitTriangle<'_>) -> Option<(bool, u32)> {
        self.0.any_in_box(bounds, visit)
    }
}

impl<P: Tree> Geometry for Counted<'_, P> {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        visitor.parts(self)
    }
}

type Query<'q, P> = &'q dyn Fn(&Counted<'_, P>);

/// A pack of rocks of this size at these places.
fn rocks(places: impl Iterator<Item = DVec3>, size: f64) -> Pack {
    let set = |(i, place): (usize, DVec3)| {
        let placed = |p: &[f32; 3]| std::array::from_fn(|axis| (f64::from(p[axis]) * size + place[axis]) as f32);
        point_set("rock", &families::rock(32, i as u64 % 16).iter().map(placed).collect::<Vec<_>>())
    };
    let sets: Vec<_> = places.enumerate().map(set).collect();
    Pack::from_bytes(&bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()).unwrap()
}

/// `count` rocks in a ball around the origin.
fn cloud(count: usize, rng: &mut SplitMix64) -> Pack {
    let mut place = || DVec3::from_array(rng.direction()) * (1.2 * rng.between(0.3, 1.0));
    rocks((0..count).map(|_| place()), 0.3)
}

fn pose(rng: &mut SplitMix64, reach: f64) -> Pose {
    let turn = DQuat::from_array([(); 4].map(|()| rng.between(-1.0, 1.0))).normalize();
    Pose::new(DVec3::from_array(rng.direction()) * (reach * rng.between(0.2, 1.0)), turn).unwrap()
}

/// Level triangles: squares of size 1, two of them each, around the origin.
fn grid(cells: usize) -> TriangleMesh {
    let (row, half) = (cells + 1, 0.5 * cells as f32);
    let positions: Vec<[f32; 3]> =
        (0..row * row).map(|i| [(i % row) as f32 - half, (i / row) as f32 - half, 0.0]).collect();
    let square = |i: usize| {
        let at = (i / cells * row + i % cells) as u32;
        let [a, b, c, d] = [at, at + 1, at + row as u32 + 1, at + row as u32];
        [[a, b, c], [a, c, d]]
    };
    let corners: Vec<[u32; 3]> = (0..cells * cells).flat_map(square).collect();
    let baked = bake_triangle_mesh(&Triangles { positions: &positions, corners: &corners, materials: &[] });
    TriangleMesh::from_bytes(&write_triangle_mesh(baked.unwrap(), &Default::default()).unwrap()).unwrap()
}

fn field(cells: usize) -> HeightField {
    let (row, low) = (cells + 1, -0.5 * cells as f64);
    let layout = Layout { columns: row, rows: row, origin: [low; 2], spacing: [1.0; 2], diagonal: Diagonal::Rising };
    let heights = vec![0.0; row * row];
    let baked = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &[], materials: &[] });
    HeightField::from_bytes(&write_height_field(baked.unwrap(), &Default::default()).unwrap()).unwrap()
}

#[test]
fn few_pairs_of_parts_are_queried() {
    let (seed, rounds) = (0xc0_11de, 300);
    println!("seed {seed:#x}");
    let mut rng = SplitMix64::new(seed);
    let (many, few, mesh) = (cloud(20, &mut rng), cloud(12, &mut rng), grid(6));
    let (whole_a, whole_b) = (Compound::new(&many), Compound::new(&few));
    let (a, b, sheet) = (Counted::new(&whole_a), Counted::new(&whole_b), Counted::new(&mesh));
    let (settings, casts, rock) = (Settings::default(), CastSettings::default(), few.hull(0).unwrap());
    let mut sums = [0; 5];
    for _ in 0..rounds {
        let (near, cache) = (pose(&mut rng, 2.7), &mut Cache::new());
        let motion = Motion::new(-near.translation()).unwrap();
        let ray = Ray::new(near.translation() * 2.0, DVec3::from_array(rng.direction()) - near.translation()).unwrap();
        let work = [
            a.work(false, |a| crate::intersects(a, &b, near, cache)),
            a.work(false, |a| crate::distance(a, &b, near, &settings, &mut Cache::new())),
            a.work(false, |a| crate::contacts(a, &b, near, &settings, &mut Cache::new(), |_| ())),
            a.work(false, |a| crate::cast(a, &b, near, motion, &casts, &mut Cache::new())),
            a.work(true, |a| crate::ray(a, &ray, &casts)),
        ];
        (0..5).for_each(|i| sums[i] += work[i][0]);
        let point = near.translation();
        for cache in [&mut Cache::new(), &mut Cache::with_pairs(8)] {
            for _ in 0..2 {
                sheet.work(true, |sheet| crate::intersects(sheet, &rock, near, cache));
                sheet.work(true, |sheet| crate::distance(sheet, &rock, near, &settings, cache));
                sheet.work(true, |sheet| crate::contacts(sheet, &rock, near, &settings, cache, |_| ()));
                sheet.work(true, |sheet| crate::cast(sheet, &rock, near, motion, &casts, cache));
                a.work(true, |a| crate::signed_distance(a, point, &settings, cache));
                a.work(true, |a| crate::distance(a, &rock, near, &settings, cache));
            }
        }
        sheet.work(true, |sheet| crate::ray(sheet, &ray, &casts));
    }
    println!("pairs of {}: {sums:?} of intersects, distance, contacts, casts, rays", rounds * 20 * 12);
    assert!(sums[..4].iter().all(|pairs| pairs * 10 < rounds * 20 * 12), "{sums:?}");
    assert!(sums[4] * 2 < rounds * 20, "{sums:?}");
}

/// Boxes grow as the logarithm of the number of parts, for packs, meshes and fields.
#[test]
fn boxes_grow_with_the_logarithm_of_the_number_of_parts() {
    let near = Pose::from_translation(DVec3::new(0.2, 0.1, 1.3)).unwrap();
    let low = Pose::from_translation(DVec3::new(0.2, 0.1, 0.45)).unwrap();
    let down = Ray::new(DVec3::new(0.45, 0.4, 9.0), DVec3::NEG_Z).unwrap();
    let passing = Ray::new(DVec3::new(0.2, 0.1, 9.0), DVec3::new(0.1, 0.2, 1.0)).unwrap();
    let (ball, settings, casts) = (Sphere::new(0.5).unwrap(), Settings::default(), CastSettings::default());
    /// Work of a distance, a ray that hits, a ray that misses, contacts and manifolds.
    fn of<P: Tree>(parts: &P, queries: [Query<'_, P>; 5]) -> [[u32; 2]; 5] {
        let counted = Counted::new(parts);
        queries.map(|query| counted.work(true, query))
    }
    macro_rules! work {
        ($parts:expr) => {
            of(
                $parts,
                [
                    &|parts| assert!(crate::distance(parts, &ball, near, &settings, &mut Cache::new()).lower > 0.0),
                    &|parts| assert!(crate::ray(parts, &down, &casts).hit),
                    &|parts| assert!(!crate::ray(parts, &passing, &casts).hit),
                    &|parts| {
                        let counts = crate::contacts(parts, &ball, low, &settings, &mut Cache::new(), |_| ());
                        assert!(counts.hits > 0);
                    },
                    &|parts| {
                        let mut manifolds = CompoundManifolds::new(16);
                        manifolds.set_welding(false);
                        assert!(manifolds.update(parts, &ball, low, &ManifoldSettings::default()).touching > 0);
                    },
                ],
            )
        };
    }
    let side = |side: usize| {
        let half = 0.5 * (side as f64 - 1.0);
        rocks((0..side * side).map(|i| DVec3::new((i % side) as f64 - half, (i / side) as f64 - half, 0.0)), 0.6)
    };
    let mut kinds: [Vec<[[u32; 2]; 5]>; 3] = Default::default();
    for cells in [8, 16, 32] {
        kinds[0].push(work!(&Compound::new(&side(cells))));
    }
    for cells in [8, 32, 128] {
        kinds[1].push(work!(&grid(cells)));
        kinds[2].push(work!(&field(cells)));
    }
    println!("parts and boxes of a distance, a hit, a miss, contacts, manifolds: {kinds:?}");
    for counts in &kinds {
        let (first, last) = (counts[0], counts[2]);
        for query in 0..5 {
            // Up to 256 times as many parts: eight more levels.
            assert!(last[query][1] <= first[query][1] + 64, "{counts:?}");
            // Parts taken, also those that an axis then rules out.
            assert!(last[query][0] <= [10, 8, 0, 12, 12][query], "{counts:?}");
        }
    }
}
