use std::time::Instant;

use shapes::families::Family;

use super::*;
use crate::{PointSet, hull, index};

fn hull_of(positions: Vec<[f32; 3]>) -> Hull {
    let source_vertices = (0..positions.len() as u32).collect();
    hull::build(&PointSet { positions, source_vertices, ..PointSet::default() }).unwrap()
}

const KINDS: [IndexKind; 7] = [
    IndexKind::Tree,
    IndexKind::Medium,
    IndexKind::Compact,
    IndexKind::Binary,
    IndexKind::CubeMap { resolution: 7 },
    IndexKind::CubeMap { resolution: 64 },
    IndexKind::None,
];

#[test]
fn explore() {
    for family in Family::ALL {
        for count in [8, 9, 40, 300, 2_000, 20_000] {
            let hull = hull_of(family.points(count, 4));
            for kind in KINDS {
                let start = Instant::now();
                let index = index::build(&hull, kind).unwrap();
                let built = start.elapsed().as_secs_f64();
                let start = Instant::now();
                let proof = certify(&hull, index.kind, &index.encoded.slots[..], index.encoded.blocks.iter().copied());
                let proven = start.elapsed().as_secs_f64();
                println!(
                    "{family:?} {count} n={} {kind:?} {:.1} ms, proof {:.1} ms ({:.2}): {proof:?}",
                    hull.vertices.len(),
                    built * 1e3,
                    proven * 1e3,
                    proven / built
                );
            }
        }
    }
}

#[test]
fn pinky() {
    let bytes = std::fs::read("/work/shared/found/unitree_left_pinky_MC.stl").unwrap();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    let f = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let mut points: Vec<[f32; 3]> = (0..count)
        .flat_map(|t| (0..3).map(move |c| 84 + 50 * t + 12 + 12 * c))
        .map(|at| [f(at), f(at + 4), f(at + 8)])
        .collect();
    let mut seen = std::collections::HashSet::new();
    points.retain(|p| seen.insert(p.map(f32::to_bits)));
    let hull = hull_of(points);
    let index = crate::index::build_kind(&hull, IndexKind::Tree).unwrap();
    println!("{} {:?}", hull.vertices.len(), index.prove(&hull));
}
