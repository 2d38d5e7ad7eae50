//! Baked bytes do not depend on the number of threads. Hulls of every family are tested, large
//! enough to be divided among threads.

use hullmap_bake::{IndexKind, PointSet, SourceRecord, bake_hull, write_pack};
use shapes::families::Family;

const SEED: u64 = 11;
const POINTS: usize = 4000;

fn bake(family: Family, kind: IndexKind, threads: usize) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let positions = family.points(POINTS, SEED);
    let source_vertices = (0..positions.len() as u32).collect();
    let set = PointSet { name: family.name().to_owned(), positions, source_vertices, ..PointSet::default() };
    pool.install(|| write_pack(&[bake_hull(&set, kind).unwrap()], &SourceRecord::default()).unwrap())
}

#[test]
fn one_two_and_sixteen_threads_bake_the_same_bytes() {
    for family in Family::ALL {
        for kind in [IndexKind::Tree, IndexKind::Compact] {
            let alone = bake(family, kind, 1);
            for threads in [2, 16] {
                // Not assert_eq, which would print the bytes.
                assert!(bake(family, kind, threads) == alone, "{} on {threads} threads", family.name());
            }
        }
    }
}
