//! Warnings about hulls whose support queries are slow.

use hullmap::{Hull, IndexKind};

use crate::census::Census;

/// Maximum dot products of a query with the default index. Above it, another index is faster.
const MANY_DOTS: u32 = 64;

/// Number of vertices above which a hull without an index is slower than one with an index.
const MANY_WITHOUT_INDEX: usize = 32;

pub fn cost_warning(hull: &Hull, census: &Census) -> Option<String> {
    let (name, vertex_count, worst) = (hull.name(), hull.vertex_count(), hull.worst_cost().dots);
    if hull.index_kind() == IndexKind::None && vertex_count > MANY_WITHOUT_INDEX {
        return Some(format!(
            "hull {name} has no index: every query scans all {vertex_count} vertices; \
             with --set index=tree most hulls need at most 8 dot products"
        ));
    }
    (worst > MANY_DOTS).then(|| {
        format!(
            "hull {name} is slow in some directions: up to {worst} dot products per query, {:.1} on average; {}",
            census.mean_dots,
            if hull.index_kind() == IndexKind::Tree {
                "--max-vertices makes it simpler"
            } else {
                "--set index=tree is usually faster"
            }
        )
    })
}

/// One warning for all hulls of a pack: the warning about the first, and the number of the others.
pub fn summary(warnings: &[String]) -> Option<String> {
    match warnings {
        [] => None,
        [only] => Some(only.clone()),
        [first, others @ ..] => Some(format!("{first} (and {} more hulls with slow queries)", others.len())),
    }
}

#[cfg(test)]
mod tests {
    use hullmap_bake::IndexKind as Kind;

    use super::*;
    use crate::census::{census, even_directions};
    use crate::test_packs::{baked, cloud};

    fn warning(kind: Kind) -> Option<String> {
        let (pack, contents) = baked(cloud(200), kind);
        cost_warning(&pack.hull(0).unwrap(), &census(&contents.indices[0], &even_directions(500)))
    }

    #[test]
    fn one_warning_for_all_hulls() {
        let warnings = ["a is slow", "b is slow", "c is slow"].map(str::to_owned);
        assert_eq!(summary(&[]), None);
        assert_eq!(summary(&warnings[..1]).unwrap(), "a is slow");
        assert_eq!(summary(&warnings).unwrap(), "a is slow (and 2 more hulls with slow queries)");
    }

    #[test]
    fn slow_indices_are_named() {
        assert_eq!(warning(Kind::Tree), None);
        assert!(warning(Kind::None).unwrap().starts_with("hull cloud has no index:"));
        let coarse = warning(Kind::CubeMap { resolution: 1 }).unwrap();
        assert!(coarse.starts_with("hull cloud is slow in some directions:"), "{coarse}");
    }
}
