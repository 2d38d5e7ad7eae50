//! What a user should know about a pack: what is wrong with it, and what may surprise at runtime.

use hullmap::Hull;

use super::census::Census;

/// Length over thickness from which a solid counts as thin: contacts on its sides then lose four digits.
const THIN: f64 = 1e4;

/// Distance from the origin over diameter from which positions lose digits: of an f32's seven, three are gone.
const FAR: f64 = 1e3;

/// Dot products that a query takes at most where the default index fits; more is slower than need be.
const MANY_DOTS: u32 = 64;

/// Vertices from which a hull without an index is slower than one with it.
const MANY_WITHOUT_INDEX: usize = 32;

/// What may surprise about a hull, a sentence each.
pub fn hull_warnings(hull: &Hull, census: &Census) -> Vec<String> {
    let mut list = Vec::new();
    match hull.rank() {
        2 => list.push(
            "flat: all its points lie in one plane, so it has no volume; give it thickness if it should stop things"
                .to_owned(),
        ),
        1 => {
            list.push("a segment: all its points lie on one line; if it should be a solid, check the source".to_owned())
        }
        0 => list.push(
            "a single point: all its points lie in one place; if it should be a solid, check the source".to_owned(),
        ),
        _ => {
            let thickness = 3.0 * hull.volume() / hull.surface_area();
            let aspect = hull.diameter() / thickness;
            // NaN takes the failing branch.
            if !(aspect < THIN) {
                list.push(format!(
                    "thin: {aspect:.0} times as long as thick; contacts on its sides lose digits, so thicken it or make it flat"
                ));
            }
        }
    }
    let distance = hull.centroid().length() / hull.diameter();
    // A point has no diameter; where it lies is no matter.
    if hull.rank() > 0 && distance > FAR {
        list.push(format!(
            "far from the origin: {distance:.0} times its diameter, where f32 coordinates have few digits left; move the mesh to the origin and place it by its pose"
        ));
    }
    let worst = hull.worst_cost().dots;
    if hull.index_kind() == hullmap::IndexKind::None && hull.vertex_count() > MANY_WITHOUT_INDEX {
        list.push(format!(
            "no index: every query multiplies {} vertices; --index tree takes at most 8 for most hulls",
            hull.vertex_count()
        ));
    } else if worst > MANY_DOTS {
        list.push(format!(
            "dear in places: some queries take {worst} dot products, {:.1} on average; --index tree has a bound of few",
            census.mean_dots
        ));
    }
    list
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind;

    use super::super::census::{census, even_directions};
    use super::super::index_reader::tests::{baked, cloud};
    use super::*;

    fn warned(positions: Vec<[f32; 3]>, kind: IndexKind) -> String {
        let (pack, contents) = baked(positions, kind);
        hull_warnings(&pack.hull(0).unwrap(), &census(&contents.indices[0], &even_directions(500))).join("|")
    }

    #[test]
    fn each_oddity_is_named_and_nothing_else() {
        let moved = |by: f32, flat: f32| cloud(200).iter().map(|&[x, y, z]| [x + by, y, z * flat]).collect::<Vec<_>>();
        for (positions, kind, expected) in [
            (cloud(200), IndexKind::TREE, ""),
            (moved(0.0, 1e-5), IndexKind::TREE, "thin:"),
            (moved(0.0, 0.0), IndexKind::TREE, "flat:"),
            (vec![[0.0; 3], [1.0; 3]], IndexKind::TREE, "a segment:"),
            (vec![[0.0; 3]], IndexKind::TREE, "a single point:"),
            (moved(1e5, 1.0), IndexKind::TREE, "far from the origin:"),
            (cloud(200), IndexKind::None, "no index:"),
            (cloud(200), IndexKind::CubeMap { resolution: 1 }, "dear in places:"),
        ] {
            let found = warned(positions, kind);
            assert!(found.starts_with(expected) && !found.contains('|'), "{expected} {found}");
            assert_eq!(found.is_empty(), expected.is_empty(), "{found}");
        }
    }
}
