//! The nodes of a pack's index: how many there are of each kind, and the positions of its fans.

use glam::DVec3;
use hullmap_format::{
    IndexKind,
    cube::{self, GRID_BITS},
    node::{Node, Words as _},
    slot::{Branch, Slot},
};
use hullmap_tests::{
    directions::Fan,
    hostile::patch::{archive, payload},
};

/// Numbers of branches, planes, bundles, fans, lists and blocks.
pub type Counts = [usize; 6];

/// Numbers of slots of each kind in the first hull of a pack, and all fans. A fan below a plane or
/// another fan has the cell that this one divides.
pub fn nodes(file: &[u8]) -> (Counts, Vec<Fan>) {
    let (mut counts, mut fans) = (Counts::default(), Vec::new());
    let payload = payload(file);
    let pack = archive(&payload);
    let kind = IndexKind::of_record(&pack.hulls[0]).unwrap();
    if !kind.is_tree() {
        return (counts, fans);
    }
    let slots: Vec<u32> = pack.slots.iter().map(|word| word.to_native()).collect();
    let vector = |at: usize| DVec3::from_array([0, 2, 4].map(|axis| slots[..].number(at + axis)));
    // Slot, face, least u and v in grid numbers, bits taken.
    let mut pending: Vec<(u32, u32, [u32; 2], u32)> =
        (0..6).map(|face| (slots[face], face as u32, [0; 2], 0)).collect();
    while let Some((word, face, at, bits)) = pending.pop() {
        let slot = Slot::decode(word);
        counts[match slot {
            Slot::Branch(_) => 0,
            Slot::Plane(_) => 1,
            Slot::Bundle(_) => 2,
            Slot::Fan(_) => 3,
            Slot::List(_) => 4,
            Slot::Block(_) => 5,
        }] += 1;
        if let Slot::Branch(payload) = slot {
            let branch = Branch::decode(payload);
            let (side, taken) = (1_u32 << branch.bits, bits + branch.bits);
            for square in 0..side * side {
                let offset = [square % side, square / side].map(|step| step << (GRID_BITS - taken));
                let corner = [at[0] + offset[0], at[1] + offset[1]];
                pending.push((slots[(branch.at + square) as usize], face, corner, taken));
            }
            continue;
        }
        let Some(node) = Node::below(slot, kind.branches(), &slots[..]) else { continue };
        if let Node::Fan { at: first, bits: steps } = node {
            fans.push(Fan {
                face,
                corner: at.map(cube::grid_to_uv),
                size: 2.0 / f64::from(1 << bits),
                x: vector(first),
                y: vector(first + 6),
                start: slots[..].number(first + 12),
                rate: slots[..].number(first + 14),
                steps: 1 << steps,
            });
        }
        let mut words = slots[node.slots()].to_vec();
        words.dedup();
        pending.extend(words.into_iter().map(|word| (word, face, at, bits)));
    }
    (counts, fans)
}
