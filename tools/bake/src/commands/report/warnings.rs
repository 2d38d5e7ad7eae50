//! What a user should know about a pack: what the bake said of it, and what may surprise at runtime.

use hullmap::{Hull, IndexKind, Pack, SupportMap};

use super::census::Census;
use crate::advice::{self, HullFacts};
use crate::source::Source;

/// Dot products that a query takes at most where the default index fits; more is slower than need be.
const MANY_DOTS: u32 = 64;

/// Vertices from which a hull without an index is slower than one with it.
const MANY_WITHOUT_INDEX: usize = 32;

/// Sentences, as `bake build` says them.
#[derive(Debug, Default)]
pub struct Remarks {
    /// What one may want to know.
    pub notes: Vec<String>,
    /// What one should look at.
    pub warnings: Vec<String>,
}

/// What the import of its source says, and what the parts of each object promise. Without a source, whether the hulls themselves
/// are far from the origin.
pub fn of_pack(pack: &Pack, source: Option<&Source>) -> Remarks {
    let mut remarks = Remarks::default();
    if let Some(source) = source {
        remarks.notes.clone_from(&source.notes);
        remarks.warnings.clone_from(&source.warnings);
    }
    let hulls: Vec<Hull> = pack.hulls().collect();
    let mut start = 0;
    while let Some(first) = hulls.get(start) {
        let count = 1 + hulls[start + 1..].iter().take_while(|hull| hull.part() > 0).count();
        let parts = &hulls[start..start + count];
        let name = if count > 1 {
            first.name().rsplit_once("_part_").map_or(first.name(), |(name, _)| name)
        } else {
            first.name()
        };
        if count > 1 {
            let size = parts.iter().map(Hull::diameter).fold(0.0, f64::max);
            let remark = advice::parts(name, count, first.uncovered(), size);
            remark.tell(&mut remarks.notes, &mut remarks.warnings);
        }
        if source.is_none() {
            let vertices: Vec<[f32; 3]> = parts.iter().flat_map(Hull::vertices).map(|v| v.to_array()).collect();
            remarks.warnings.extend(hullmap_import::far_away(name, &vertices));
        }
        start += count;
    }
    remarks
}

/// What there is to say of a hull.
pub fn of_hull(hull: &Hull, census: &Census) -> Remarks {
    let greatest = hull.bounds().iter().map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
    let facts = HullFacts {
        name: hull.name(),
        rank: hull.rank(),
        point_count: hull.source_point_count() as usize,
        vertex_count: hull.vertex_count(),
        diameter: hull.diameter(),
        inner_radius: hull.inner_radius(),
        greatest_coordinate: greatest.into(),
        outer_error: hull.outer_error(),
    };
    let mut remarks = Remarks { notes: Vec::new(), warnings: advice::of_hull(&facts) };
    if let Some(remark) = advice::simplified(&facts) {
        remark.tell(&mut remarks.notes, &mut remarks.warnings);
    }
    let name = hull.name();
    let worst = hull.worst_cost().dots;
    if hull.index_kind() == IndexKind::None && hull.vertex_count() > MANY_WITHOUT_INDEX {
        remarks.warnings.push(format!(
            "hull {name} has no index: every query multiplies {} vertices; --index tree takes at most 8 for most hulls",
            hull.vertex_count()
        ));
    } else if worst > MANY_DOTS {
        remarks.warnings.push(format!(
            "hull {name} is dear in places: some queries take {worst} dot products, {:.1} on average; --index tree has a bound of few",
            census.mean_dots
        ));
    }
    remarks
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind as Kind;

    use super::super::census::{census, even_directions};
    use super::super::index_reader::tests::{baked, cloud};
    use super::*;

    fn warned(positions: Vec<[f32; 3]>, kind: Kind) -> String {
        let (pack, contents) = baked(positions, kind);
        let mut found = of_pack(&pack, None);
        let hull = of_hull(&pack.hull(0).unwrap(), &census(&contents.indices[0], &even_directions(500)));
        found.warnings.extend(hull.warnings);
        assert!(found.notes.is_empty() && hull.notes.is_empty());
        found.warnings.join("|")
    }

    #[test]
    fn each_oddity_is_named_and_nothing_else() {
        let moved = |by: f32, flat: f32| cloud(200).iter().map(|&[x, y, z]| [x + by, y, z * flat]).collect::<Vec<_>>();
        for (positions, kind, expected) in [
            (cloud(200), Kind::TREE, ""),
            (moved(0.0, 1e-5), Kind::TREE, "hull cloud is thin:"),
            (moved(0.0, 0.0), Kind::TREE, "hull cloud is flat:"),
            (vec![[0.0; 3], [1.0; 3], [2.0; 3]], Kind::TREE, "hull cloud is a segment:"),
            (vec![[0.0; 3], [0.0; 3]], Kind::TREE, "hull cloud is a point:"),
            (vec![[0.0; 3]], Kind::TREE, ""),
            (moved(1e5, 1.0), Kind::TREE, "object cloud: 1.000e5 from the origin"),
            (cloud(200), Kind::None, "hull cloud has no index:"),
            (cloud(200), Kind::CubeMap { resolution: 1 }, "hull cloud is dear in places:"),
        ] {
            let found = warned(positions, kind);
            assert!(found.starts_with(expected) && !found.contains('|'), "{expected} {found}");
            assert_eq!(found.is_empty(), expected.is_empty(), "{found}");
        }
    }
}
