//! Every file passes the check, and its bytes do not depend on unused heights.

use hullmap_format::{
    header::{FileKind, HEADER_LEN},
    height_field::{check, check::LayoutError, layout::Diagonal, sections::Sections},
};
use rkyv::util::AlignedVec;
use shapes::rng::SplitMix64;

use super::*;

fn layout(columns: usize, rows: usize) -> Layout {
    Layout { columns, rows, origin: [-1.0, 2.0], spacing: [0.5, 0.25], diagonal: Diagonal::Falling }
}

fn bake(layout: Layout, heights: &[f32], holes: &[bool]) -> Result<BakedHeightField, BakeError> {
    bake_height_field(&HeightGrid { layout, heights, holes, materials: &[] })
}

fn bytes(baked: &BakedHeightField) -> Vec<u8> {
    write_height_field(baked.clone(), &SourceRecord::default()).unwrap()
}

fn check_file(baked: &BakedHeightField) {
    let file = bytes(baked);
    let mut aligned = AlignedVec::<HEADER_LEN>::new();
    aligned.extend_from_slice(&file);
    let payload = &aligned[HEADER_LEN..];
    check::check(&Sections::read(payload).unwrap(), payload).unwrap();
}

#[test]
fn random_fields_pass_the_check() {
    const SEED: u64 = 0x39_f1;
    println!("seed {SEED}");
    let mut rng = SplitMix64::new(SEED);
    let mut with_holes = 0;
    for round in 0..300_usize {
        let (columns, rows) = (2 + rng.below(30), 2 + rng.below(30));
        let scale = [1e-6, 1.0, 1e30][round % 3];
        let mut heights: Vec<f32> = (0..columns * rows).map(|_| (scale * (rng.unit() - 0.3)) as f32).collect();
        if round.is_multiple_of(5) {
            heights.fill(7.5);
        }
        if round.is_multiple_of(2) {
            let count = rng.below(4);
            (0..count).for_each(|_| heights[rng.below(columns * rows)] = f32::NAN);
        }
        let share = if round.is_multiple_of(7) { 0.5 } else { 0.0 };
        let holes: Vec<bool> = (0..(columns - 1) * (rows - 1)).map(|_| rng.unit() < share).collect();
        match bake(layout(columns, rows), &heights, &holes) {
            Ok(baked) => {
                with_holes += usize::from(baked.counts().holes > 0);
                check_file(&baked);
            }
            Err(error) => assert_eq!(error, BakeError::OnlyHoles),
        }
    }
    assert!(with_holes > 50);
}

#[test]
fn heights_of_holes_and_signs_of_zeros_change_no_byte() {
    // The hole is in a corner; the vertex there has no other cell.
    let mut holes = [false; 4];
    holes[3] = true;
    let mut heights = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 99.0];
    let first = bake(layout(3, 3), &heights, &holes).unwrap();
    assert_eq!(first.counts().heights, [0.0, 7.0]);
    heights[8] = f32::NAN;
    heights[0] = -0.0;
    assert_eq!(bytes(&bake(layout(3, 3), &heights, &holes).unwrap()), bytes(&first));
    assert_eq!(bytes(&bake(layout(3, 3), &heights, &[]).unwrap()), bytes(&first));
}

#[test]
fn bytes_a_cell() {
    for (size, most) in [(65, 4.7), (1025, 4.6), (1000, 5.2), (770, 6.1)] {
        let cells = (size - 1) * (size - 1);
        let baked = bake(layout(size, size), &vec![1.0; size * size], &[]).unwrap();
        let per_cell = bytes(&baked).len() as f64 / cells as f64;
        assert!(per_cell < most, "{size}: {per_cell}");
    }
}

#[test]
fn errors_name_what_is_wrong() {
    let of = |layout: Layout, heights: &[f32], holes: &[bool]| bake(layout, heights, holes).unwrap_err();
    assert_eq!(of(layout(1, 5), &[0.0; 5], &[]), LayoutError::Size { columns: 1, rows: 5 }.into());
    assert_eq!(of(layout(1 << 20, 1 << 20), &[], &[]), LayoutError::Size { columns: 1 << 20, rows: 1 << 20 }.into());
    let expected = BakeError::GridCount { what: "heights", found: 3, expected: 4 };
    assert_eq!(of(layout(2, 2), &[0.0; 3], &[]), expected);
    let expected = BakeError::GridCount { what: "holes", found: 2, expected: 1 };
    assert_eq!(of(layout(2, 2), &[0.0; 4], &[true; 2]), expected);
    let infinite = [0.0, 0.0, 0.0, f32::NEG_INFINITY];
    assert_eq!(of(layout(2, 2), &infinite, &[]), BakeError::InfiniteHeight { column: 1, row: 1 });
    assert_eq!(of(layout(2, 2), &[0.0, 0.0, 0.0, f32::NAN], &[]), BakeError::OnlyHoles);
    for (origin, spacing, axis) in [
        ([0.0, 0.0], [0.0, 1.0], 'x'),
        ([0.0, 0.0], [1.0, f64::NAN], 'y'),
        ([0.0, 0.0], [1.0, -1.0], 'y'),
        ([1e20, 0.0], [1.0, 1.0], 'x'),
        ([0.0, 0.0], [1e39, 1.0], 'x'),
    ] {
        let bad = Layout { origin, spacing, ..layout(2, 2) };
        assert_eq!(of(bad, &[0.0; 4], &[]), LayoutError::Coordinates { axis }.into());
    }
}

/// The checksum of a field with holes, materials and rounded positions is fixed for all machines.
#[test]
fn the_bytes_are_the_same_everywhere() {
    let (columns, rows) = (19, 33);
    let heights: Vec<f32> = (0..columns * rows).map(|i| ((i * i % 101) as f32 - 50.0) / 7.0).collect();
    let cells = (columns - 1) * (rows - 1);
    let holes: Vec<bool> = (0..cells).map(|cell| usize::is_multiple_of(cell, 13)).collect();
    let materials: Vec<u16> = (0..cells).map(|cell| (cell % 5) as u16).collect();
    let layout = Layout { spacing: [0.1, 1.0 / 3.0], ..layout(columns, rows) };
    let baked = bake_height_field(&HeightGrid { layout, heights: &heights, holes: &holes, materials: &materials });
    let record = SourceRecord { path: "a/b.png".into(), hash: 7, options: "x".into(), warnings: vec!["y".into()] };
    let file = write_height_field(baked.unwrap(), &record).unwrap();
    let header = Header::read_kind(&file, FileKind::HeightField).unwrap();
    assert_eq!((file.len(), format!("{:016x}", header.checksum)), (4428, "fa18b933d5a585d2".to_owned()));
}
