//! Facts and arrays of hulls.
#![allow(unsafe_code)]

use std::ffi::CString;

use super::*;

#[test]
fn facts_and_arrays_match_the_pack() {
    let (pack, file) = (open(), file());
    let twin = hullmap::Pack::from_bytes(&file).unwrap();
    // SAFETY: the pointers are valid, and the arrays live as long as the pack.
    unsafe {
        assert_eq!(hullmap_pack_hull_count(pack.0), 2);
        let (mut index, name) = (7, CString::new("right").unwrap());
        assert_eq!((hullmap_pack_find(pack.0, name.as_ptr(), &raw mut index), index), (Code::Ok, 1));
        let mut facts = std::mem::zeroed::<types::HullFacts>();
        facts.struct_size = size_of::<types::HullFacts>();
        assert_eq!(hullmap_pack_hull_facts(pack.0, 1, &raw mut facts), Code::Ok);
        let hull = twin.hull(1).unwrap();
        assert_eq!(std::slice::from_raw_parts(facts.name.data.cast::<u8>(), facts.name.length), b"right");
        assert_eq!((facts.vertex_count, facts.face_count), (hull.vertex_count(), hull.face_count()));
        assert_eq!((facts.volume, facts.diameter), (hull.volume(), hull.diameter()));
        assert_eq!((facts.surface_area, facts.rank, facts.part), (hull.surface_area(), 3, 0));
        assert_eq!(facts.centroid, hull.centroid());
        let tensor = hull.inertia_tensor();
        assert_eq!((facts.inertia[1], facts.inertia[8]), (tensor.y_axis.x, tensor.z_axis.z));
        assert_eq!((facts.inner_radius, facts.outer_radius), (hull.inner_radius(), hull.outer_radius()));
        assert_eq!(facts.bounds.max, hull.bounds()[1].as_dvec3());
        let unmeasured = (facts.part_count, facts.solid, facts.uncovered, facts.protrusion);
        assert_eq!((facts.voids, facts.voids_error), (-1.0, 0.0));
        assert_eq!(unmeasured, (0, types::Solid::Unmeasured as u32, 0.0, 0.0));
        let mut mass = std::mem::zeroed::<types::MassProperties>();
        assert_eq!(hullmap_pack_mass_properties(pack.0, 0, 2, 3.0, &raw mut mass), Code::Ok);
        let expected = twin.mass_properties(3.0);
        assert_eq!((mass.mass, mass.center_of_mass), (expected.mass, expected.center_of_mass));
        assert_eq!(mass.inertia, expected.inertia.transpose().to_cols_array());
        assert_eq!(mass.source, types::MassSource::Hulls);
        for (first, count, density, code) in [
            (1, 2, 1.0, Code::NotFound),
            (usize::MAX, 2, 1.0, Code::NotFound),
            (0, 0, 1.0, Code::InvalidArgument),
            (0, 1, f64::NAN, Code::InvalidArgument),
            (0, 1, -1.0, Code::InvalidArgument),
        ] {
            assert_eq!(hullmap_pack_mass_properties(pack.0, first, count, density, &raw mut mass), code);
        }
        let mut arrays = std::mem::zeroed::<types::HullArrays>();
        assert_eq!(hullmap_pack_hull_arrays(pack.0, 1, &raw mut arrays), Code::Ok);
        let vertices = std::slice::from_raw_parts(arrays.vertices, 3 * arrays.vertex_count);
        assert!(vertices.iter().copied().eq(hull.vertices().flat_map(|v| v.to_array())));
        let faces = std::slice::from_raw_parts(arrays.face_vertices, arrays.face_vertex_count);
        assert!(faces.iter().copied().eq(hull.faces().flatten()));
        let neighbours = std::slice::from_raw_parts(arrays.neighbours, arrays.neighbour_count);
        let all = (0..hull.vertex_count() as u32).flat_map(|vertex| hull.neighbours(vertex));
        assert!(neighbours.iter().copied().eq(all));
    }
}

/// An L of height 1, as two bars that overlap in its corner. It has a volume of 4, its bars of 5.
#[test]
fn parts_weigh_as_much_as_their_mesh() {
    let bar = |high: [f32; 3]| {
        let corners = packs::corners([0.0; 3], high);
        hullmap_bake::bake_hull(&packs::point_set("l", &corners), hullmap_bake::IndexKind::Tree).unwrap()
    };
    let [mut first, mut second] = [bar([2.0, 1.0, 1.0]), bar([1.0, 3.0, 1.0])];
    let l = shapes::concave::l();
    let set = hullmap_bake::PointSet { triangles: l.fans(), ..packs::point_set("l", &l.vertices) };
    let mass = hullmap_bake::fit::mesh_mass(&set).unwrap();
    (first.part_count, first.mesh_mass) = (2, Some(mass));
    (second.part_count, second.part) = (2, 1);
    let file = hullmap_bake::write_owned_pack(vec![first, second], &hullmap_bake::SourceRecord::default()).unwrap();
    // SAFETY: the pointers are valid.
    unsafe {
        let pack = Owned::new(hullmap_pack_free, |out| hullmap_pack_from_memory(file.as_ptr(), file.len(), 0, out));
        let mut found = std::mem::zeroed::<types::MassProperties>();
        assert_eq!(hullmap_pack_mass_properties(pack.0, 0, 2, 2.0, &raw mut found), Code::Ok);
        assert_eq!(found.source, types::MassSource::Mesh);
        assert!((found.mass - 8.0).abs() < 1e-6, "{}", found.mass);
        // A bar alone.
        assert_eq!(hullmap_pack_mass_properties(pack.0, 0, 1, 2.0, &raw mut found), Code::Ok);
        assert_eq!(found.source, types::MassSource::Hulls);
        assert!((found.mass - 4.0).abs() < 1e-6, "{}", found.mass);
    }
}

/// A box that is the only part of its mesh, and a rock that is not a part.
#[test]
fn primitives_match_the_pack() {
    let corners = packs::corners([0.0; 3], [1.0, 2.0, 3.0]);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = hullmap_bake::PointSet { triangles, ..packs::point_set("box", &corners) };
    let rock = packs::point_set("rock", &shapes::families::rock(40, 3));
    let [mut part, rock] =
        [&mesh, &rock].map(|set| hullmap_bake::bake_hull(set, hullmap_bake::IndexKind::Tree).unwrap());
    let (solid, hulls) = (hullmap_bake::fit::solid::Solid::new(&mesh), [&part.hull]);
    let fits = hullmap_bake::fit::fits(&mesh, &hulls, None).unwrap();
    let limits = hullmap_bake::primitive::PrimitiveLimits { protrusion: 0.01, deadline: None };
    let found = hullmap_bake::primitive::primitives(&solid, &mesh, &hulls, &fits, &limits);
    (part.part_count, part.fit, part.primitive) = (1, Some(fits[0]), found[0]);
    let file = hullmap_bake::write_owned_pack(vec![part, rock], &hullmap_bake::SourceRecord::default()).unwrap();

    let twin = hullmap::Pack::from_bytes(&file).unwrap();
    let expected = twin.hull(0).unwrap().primitive().unwrap();
    // SAFETY: the pointers are valid.
    unsafe {
        let pack = Owned::new(hullmap_pack_free, |out| hullmap_pack_from_memory(file.as_ptr(), file.len(), 0, out));
        let mut found = std::mem::zeroed::<types::Replacement>();
        assert_eq!(hullmap_pack_hull_primitive(pack.0, 0, &raw mut found), Code::Ok);
        assert_eq!(found.kind, types::PrimitiveKind::Box as u32);
        assert_eq!((found.sizes, found.protrusion), (expected.sizes, expected.protrusion));
        assert_eq!(found.pose.translation, expected.center);
        let DQuat { x, y, z, w } = found.pose.rotation;
        assert_eq!([x, y, z, w], expected.rotation.to_array());
        // Half of its edges, in any order.
        let mut sizes = found.sizes;
        sizes.sort_by(f64::total_cmp);
        assert!(sizes.iter().zip([0.5, 1.0, 1.5]).all(|(size, half)| (size - half).abs() < 1e-5), "{sizes:?}");

        assert_eq!(hullmap_pack_hull_primitive(pack.0, 1, &raw mut found), Code::Ok);
        assert_eq!((found.kind, found.sizes), (types::PrimitiveKind::None as u32, [0.0; 3]));
    }
}
