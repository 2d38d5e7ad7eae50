use glam::DVec3;
use hullmap_format::{
    fan,
    slot::{Slot, encode_f64},
    walk::MAX_NODES,
};
use shapes::families;

use super::*;
use crate::{index, test_meshes::hull_of};

fn rock() -> Hull {
    hull_of(families::rock(300, 3))
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

fn fan_words(bits: u32, x: [f64; 3], y: [f64; 3], slots: [Slot; 2]) -> Vec<u32> {
    let numbers = x.into_iter().chain(y).chain([-1.0, f64::from(1 << bits) / fan::TURN]);
    let mut words: Vec<u32> = numbers.flat_map(encode_f64).collect();
    words.push(bits);
    words.extend((0..1 << bits).map(|step: usize| slots[step % 2].encode()));
    words
}

/// Fans around two axes cut the sphere into a million regions with three thousand words. All of
/// them lead to lists of all vertices, so that only the work can end the proof.
#[test]
fn work_is_bounded() {
    const BITS: u32 = 10;
    let hull = rock();
    let blocks = index::build(&hull, IndexKind::None).unwrap().encoded.blocks;
    let length = fan::HEAD_WORDS + (1 << BITS);
    // The roots, the outer fan, two inner fans, and two lists.
    let at = [6, 6 + length, 6 + 2 * length, 6 + 3 * length, 8 + 3 * length];
    let lists = [Slot::List(at[3]), Slot::List(at[4])];
    let mut words = vec![Slot::Fan(at[0]).encode(); 6];
    words.extend(fan_words(BITS, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [Slot::Fan(at[1]), Slot::Fan(at[2])]));
    words.extend(fan_words(BITS, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], lists));
    words.extend(fan_words(BITS, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], lists));
    words.extend([0, blocks.len() as u32, 0, blocks.len() as u32]);
    assert_eq!(prove(&hull, IndexKind::Tree, &words, &blocks), Err(Unproven::Work));
}

/// As many nested fans of many steps as a file may contain, on the stack of a thread.
#[test]
fn deep_indices_do_not_overflow_the_stack() {
    const BITS: u32 = 12;
    let hull = rock();
    let blocks = index::build(&hull, IndexKind::None).unwrap().encoded.blocks;
    let length = fan::HEAD_WORDS + (1 << BITS);
    let depth = MAX_NODES - 1;
    let list = Slot::List(6 + depth * length);
    let mut words = vec![Slot::Fan(6).encode(); 6];
    for level in 0..depth {
        let next = if level + 1 < depth { Slot::Fan(6 + (level + 1) * length) } else { list };
        // The axes turn, or a fan would have the angles of the one above it.
        let axis = |k: u32| DVec3::AXES[(level + k) as usize % 3].to_array();
        words.extend(fan_words(BITS, axis(0), axis(1), [next, list]));
    }
    words.extend([0, blocks.len() as u32]);
    let proof = prove(&hull, IndexKind::Tree, &words, &blocks);
    assert!(matches!(proof, Ok(_) | Err(Unproven::Work | Unproven::Thin { .. })), "{proof:?}");
}
