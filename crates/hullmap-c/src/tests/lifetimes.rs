//! Shapes that outlive their pack, names of results, versions.
#![allow(unsafe_code)]

use std::sync::Arc;

use super::*;

/// Shapes keep their pack; names of results and versions are there.
#[test]
fn shapes_outlive_their_pack() {
    let pack = open();
    // SAFETY: the handle is valid.
    let pack_handle = Arc::downgrade(unsafe { &*pack.0 }.pack());
    let shapes = all_shapes(&pack);
    drop(pack);
    assert!(pack_handle.upgrade().is_some());
    let b_in_a = IDENTITY;
    let mut contact = types::Contact::default();
    // SAFETY: the pointers are valid.
    let code =
        unsafe { hullmap_contact(shapes[0].0, shapes[3].0, &raw const b_in_a, null(), null_mut(), &raw mut contact) };
    assert!(code == Code::Ok && contact.hit);
    drop(shapes);
    assert!(pack_handle.upgrade().is_none());

    // SAFETY: the texts end with NUL.
    let text = |text| unsafe { CStr::from_ptr(text) }.to_str().unwrap();
    assert_eq!(text(hullmap_version()), env!("CARGO_PKG_VERSION"));
    assert_eq!((hullmap_abi_version(), hullmap_format_version()), (types::ABI_VERSION, hullmap::FORMAT_VERSION));
    assert_eq!(text(hullmap_result_name(Code::Panic as u32)), "panic");
    assert_eq!(text(hullmap_result_name(Code::NotFound as u32)), "not_found");
    assert_eq!(text(hullmap_result_name(9)), "unknown");
    let mut relative = b_in_a;
    let far = types::Pose { translation: DVec3 { x: 1e9, y: 0.0, z: 2.0 }, ..b_in_a };
    let a = types::Pose { translation: DVec3 { x: 1e9, y: 0.0, z: 0.0 }, ..b_in_a };
    // SAFETY: the pointers are valid.
    assert_eq!(unsafe { hullmap_pose_relative(&raw const a, &raw const far, &raw mut relative) }, Code::Ok);
    assert_eq!(relative.translation, DVec3 { x: 0.0, y: 0.0, z: 2.0 });
}
