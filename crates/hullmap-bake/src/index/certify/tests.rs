use shapes::families;

use super::*;
use crate::{PointSet, hull, index};

fn rock() -> Hull {
    let positions = families::rock(300, 3);
    let source_vertices = (0..300).collect();
    hull::build(&PointSet { positions, source_vertices, ..PointSet::default() }).unwrap()
}

fn prove(hull: &Hull, kind: IndexKind, words: &[u32], blocks: &[Block]) -> Result<Proof, Unproven> {
    certify(hull, kind, words, blocks.iter().copied())
}

#[test]
fn a_leaf_in_place_of_another_is_found() {
    let hull = rock();
    let index = index::build(&hull, IndexKind::CubeMap { resolution: 8 }).unwrap();
    let (mut words, blocks) = (index.encoded.slots, index.encoded.blocks);
    assert!(prove(&hull, index.kind, &words, &blocks).is_ok());
    // Cells on opposite sides of the cube share no candidates.
    words.swap(27, 64 + 27);
    let found = prove(&hull, index.kind, &words, &blocks);
    assert!(
        matches!(found, Err(Unproven::Missing { slot: 27, .. } | Unproven::Elsewhere { slot: 27, .. })),
        "{found:?}"
    );
}

#[test]
fn a_position_that_is_not_the_vertex_is_found() {
    let hull = rock();
    let index = index::build(&hull, IndexKind::Tree).unwrap();
    let mut blocks = index.encoded.blocks;
    blocks[3].y[2] = blocks[3].y[2].next_up();
    let found = prove(&hull, index.kind, &index.encoded.slots, &blocks);
    assert_eq!(found, Err(Unproven::Lane { block: 3, lane: 2 }));
    blocks[3].y[2] = f32::NAN;
    assert_eq!(prove(&hull, index.kind, &index.encoded.slots, &blocks), Err(Unproven::Lane { block: 3, lane: 2 }));
}

#[test]
fn a_scan_that_lacks_a_vertex_is_found() {
    let hull = rock();
    let index = index::build(&hull, IndexKind::None).unwrap();
    let mut blocks = index.encoded.blocks;
    assert!(prove(&hull, index.kind, &[], &blocks).is_ok());
    blocks.pop();
    assert!(matches!(prove(&hull, index.kind, &[], &blocks), Err(Unproven::Missing { .. })));
}

/// A million squares lead to one list of all vertices, which every arc crosses: a proof gives up.
#[test]
fn work_is_bounded() {
    let hull = rock();
    let index = index::build(&hull, IndexKind::CubeMap { resolution: 1 }).unwrap();
    let blocks = index.encoded.blocks;
    let all = Certifier::new(&hull, index.kind, &index.encoded.slots[..], &[]).work;
    assert!(all < 1_000_000, "{all}");
    // Two lists alternate, so that no two neighbours are one region.
    let resolution = 400;
    let list = index.encoded.slots[0];
    let slots = vec![list; 6 * resolution * resolution];
    let kind = IndexKind::CubeMap { resolution: resolution as u32 };
    let proof = prove(&hull, kind, &slots, &blocks);
    // One rectangle a face.
    assert_eq!(proof.map(|proof| proof.leaves), Ok(6));
}
