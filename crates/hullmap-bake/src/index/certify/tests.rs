use hullmap_format::{
    fan,
    slot::{Slot, encode_f64},
};
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

/// Fans around two axes cut the sphere into a million regions with three thousand words. All of
/// them lead to lists of all vertices, so that only the work can end the proof.
#[test]
fn work_is_bounded() {
    const BITS: u32 = 10;
    let hull = rock();
    let blocks = index::build(&hull, IndexKind::None).unwrap().encoded.blocks;
    let fan_words = fan::HEAD_WORDS as usize + (1 << BITS);
    let fan = |x: [f64; 3], y: [f64; 3], slots: [Slot; 2]| {
        let numbers = x.into_iter().chain(y).chain([-1.0, f64::from(1 << BITS) / fan::TURN]);
        let mut words: Vec<u32> = numbers.flat_map(encode_f64).collect();
        words.push(BITS);
        words.extend((0..1 << BITS).map(|step: usize| slots[step % 2].encode()));
        words
    };
    // The roots, the outer fan, two inner fans, and two lists.
    let at = [6, 6 + fan_words, 6 + 2 * fan_words, 6 + 3 * fan_words, 8 + 3 * fan_words].map(|at| at as u32);
    let lists = [Slot::List(at[3]), Slot::List(at[4])];
    let mut words = vec![Slot::Fan(at[0]).encode(); 6];
    words.extend(fan([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [Slot::Fan(at[1]), Slot::Fan(at[2])]));
    words.extend(fan([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], lists));
    words.extend(fan([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], lists));
    words.extend([0, blocks.len() as u32, 0, blocks.len() as u32]);
    assert_eq!(prove(&hull, IndexKind::Tree, &words, &blocks), Err(Unproven::Work));
}
