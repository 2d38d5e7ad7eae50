//! Bits of the point families, on every machine and in every version.

use shapes::families::Family;

fn fingerprint(points: &[[f32; 3]]) -> u64 {
    let bytes = points.iter().flatten().flat_map(|x| x.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Benchmarks of different days are comparable only while these hold: change them knowingly.
#[test]
fn families_have_not_drifted() {
    let found = Family::ALL.map(|f| (f.name(), fingerprint(&f.points(1_000, 42))));
    let expected = [
        ("sphere", 0x1afd_f8ce_add6_6226),
        ("clustered_ellipsoid", 0xe19e_da2d_a9b6_0e07),
        ("rock", 0x7a0f_ae7b_0859_b51a),
        ("prism", 0x9e37_2eb9_cb10_dde5),
        ("rotated_prism", 0xe058_87c6_9bed_473d),
        ("cone", 0x5215_104e_7a0e_9724),
        ("lens", 0x9a9f_3ccb_479c_66f1),
        ("uv_sphere", 0xe0da_0fd8_21ce_2861),
        ("ball", 0x1926_8399_3dbb_066e),
        ("cube_grid", 0xf9cb_6d04_0d14_e025),
        ("flat_sheet", 0xdb26_ecdb_bf88_4ddb),
        ("needle", 0xcb4e_a533_a6d6_884e),
    ];
    assert_eq!(found, expected, "{found:#x?}");
}
