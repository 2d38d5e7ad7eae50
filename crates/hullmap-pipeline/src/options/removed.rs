//! Options of earlier versions that were removed, and what to use instead.

/// Remedy for options of V-HACD, without dashes: for flags, keys and bindings.
pub const VHACD: &str = "V-HACD was removed; use decompose without a method: it finds fewer parts, with proven \
                         bounds. Parts that another tool made are imported by split auto";

pub const COVER: &str = "decompose takes no method; use it alone, or with true";

pub const INDEX: &str = "the options index-budget and resolution were removed; choose a kind with index: compact and \
                         medium are smaller than tree, and a cubemap has 64 cells along each edge";

pub const WALL: &str = "min_thickness was renamed; use wall";

pub const ENGINE: &str = "--for-engine and --budget were renamed; use --for, or for in hullmap.toml";

pub const SYMMETRY: &str = "the option symmetry was removed; parts of a symmetric mesh are symmetric unless that \
                            takes more parts";

pub const FILL: &str = "the option fill was removed; parts fill the solid";

pub const OVERLAP: &str = "the option overlap was removed; parts are merged if they overlap by at most 5%";

pub const REACHABLE: &str = "the option reachable was removed; delete inner walls from the mesh, or use solid closed";

/// Whether a record may have an option that this version does not have, since it changes no bound.
pub fn may_be_recorded(key: &str) -> bool {
    ["overlap", "symmetry", "fill"].contains(&key)
}

/// Remedy for an option that this version does not have; `None` if earlier ones did not have it
/// either. `key` is written as in `hullmap.toml` or as a flag without dashes in front.
pub fn instead_of_option(key: &str) -> Option<&'static str> {
    match key.replace('-', "_").as_str() {
        "index_budget" | "resolution" => Some(INDEX),
        "min_thickness" => Some(WALL),
        "for_engine" | "budget" => Some(ENGINE),
        "symmetry" => Some(SYMMETRY),
        "fill" => Some(FILL),
        "overlap" => Some(OVERLAP),
        "reachable" => Some(REACHABLE),
        key => key.starts_with("vhacd_").then_some(VHACD),
    }
}

pub fn instead_of_value(key: &str, value: &str) -> Option<&'static str> {
    match (key, value) {
        ("decompose", "vhacd") => Some(VHACD),
        ("decompose", "cover") => Some(COVER),
        _ => None,
    }
}

/// V-HACD was the first method, and is recorded as `decompose true`.
pub fn instead_of_record(record: &str) -> Option<&'static str> {
    let instead = |option: &str| match option {
        "decompose true" => Some(VHACD),
        "index cubemap 64" => None,
        _ if option.starts_with("min_thickness ") => Some(WALL),
        "symmetry none" => Some(SYMMETRY),
        "fill true" => Some(FILL),
        _ if option.starts_with("overlap ") => Some(OVERLAP),
        _ if option.starts_with("reachable ") => Some(REACHABLE),
        _ if ["index budget ", "index cubemap "].iter().any(|own| option.starts_with(own)) => Some(INDEX),
        _ => None,
    };
    record.split(", ").find_map(instead)
}
