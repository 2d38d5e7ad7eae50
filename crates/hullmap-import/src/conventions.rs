//! Naming conventions for collision parts, used by `--split auto`.
//!
//! | tool | name | treated as |
//! |---|---|---|
//! | Unreal | `UCX_<mesh>`, `UCX_<mesh>_<nn>` | a part |
//! | Unreal | the same with `UBX_`, `USP_`, `UCP_` | a part: the hull of a box, sphere or capsule |
//! | Godot | `<name>-convcolonly`, `<name>-convcol` | a part; the second is also rendered |
//! | Godot | `<name>-colonly`, `<name>-col` | a part, with a warning: Godot uses the triangles |
//! | CoACD, V-HACD | `convex_<n>` for every object | a part each |
//!
//! A part stands for the object `<mesh>` or `<name>` in the file; `-convcol` and `-col` are
//! rendered, and stand for themselves. Other objects are render meshes and are left out. A file
//! without these names is not split.
//!
//! Godot accepts `-`, `_` or `$` before its suffixes, ignores their case, and digits, blanks, `_`
//! and `.` behind them, since modelling tools number copies. Unreal's prefixes are upper case.
//!
//! # Reference
//! Unreal Engine, "FBX Static Mesh Pipeline"; Godot Engine, "Node type customization using name
//! suffixes"; CoACD's `SaveOBJ`.

use std::collections::HashMap;

use crate::fault::excerpt;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartName {
    /// Unreal's `UCX_`: convex.
    UnrealConvex,
    /// Unreal's `UBX_`, `USP_`, `UCP_`: a shape that Unreal rebuilds from its bounds.
    UnrealShape,
    /// Godot's `-convcol` and `-convcolonly`.
    GodotConvex,
    /// Godot's `-col` and `-colonly`: triangle meshes.
    GodotTriangles,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// For each name whether it is the name of a part.
    pub is_part: Vec<bool>,
    /// For each name of a part the index of the object that it stands for, if there is one.
    pub stands_for: Vec<Option<usize>>,
    pub notes: Vec<String>,
    /// Warnings about names with another meaning elsewhere, a sentence each.
    pub warnings: Vec<String>,
}

pub fn select(names: &[&str]) -> Option<Selection> {
    if !names.is_empty() && names.iter().all(|name| is_convex_n(name)) {
        let notes = vec![format!("parts of a convex decomposition (convex_<n>), one hull each: {}", names.len())];
        let stands_for = vec![None; names.len()];
        return Some(Selection { is_part: vec![true; names.len()], stands_for, notes, warnings: Vec::new() });
    }
    let parts: Vec<Option<PartName>> = names.iter().map(|name| part(name)).collect();
    let count = |kinds: &[PartName]| parts.iter().flatten().filter(|part| kinds.contains(part)).count();
    let mut notes = Vec::new();
    let unreal = count(&[PartName::UnrealConvex, PartName::UnrealShape]);
    let godot = count(&[PartName::GodotConvex, PartName::GodotTriangles]);
    if unreal + godot == 0 {
        return None;
    }
    if unreal > 0 {
        notes.push(format!("collision parts named as in Unreal (UCX_, UBX_, USP_, UCP_), one hull each: {unreal}"));
    }
    if godot > 0 {
        notes.push(format!("collision parts named as in Godot (-convcol, -convcolonly, …), one hull each: {godot}"));
    }
    if names.len() > unreal + godot {
        notes.push(format!("objects that are not collision parts, left out: {}", names.len() - unreal - godot));
    }
    let mut warnings = Vec::new();
    let first = |kind: PartName| names.iter().zip(&parts).find(|(_, part)| **part == Some(kind)).map(|(name, _)| *name);
    if let Some(name) = first(PartName::GodotTriangles) {
        warnings.push(format!(
            "object {}: Godot collides with the triangles of -col and -colonly, but this pack has its convex hull; rename it to -convcolonly, or use --decompose",
            excerpt(name)
        ));
    }
    if let Some(name) =
        names.iter().zip(&parts).find(|(name, part)| **part == Some(PartName::UnrealShape) && !name.starts_with("UBX_"))
    {
        let name = name.0;
        notes.push(format!("object {}: a sphere or capsule, treated as the hull of its vertices", excerpt(name)));
    }
    let is_part: Vec<bool> = parts.iter().map(Option::is_some).collect();
    let mut meshes: HashMap<&str, usize> = HashMap::new();
    for (index, name) in names.iter().enumerate().filter(|(index, _)| is_part.get(*index) == Some(&false)) {
        meshes.entry(name).or_insert(index);
    }
    let stands_for = names.iter().zip(&parts).enumerate().map(|(index, (name, part))| {
        let part = part.as_ref()?;
        let named = mesh_names(name, *part).into_iter().find_map(|mesh| meshes.get(mesh).copied());
        named.or_else(|| is_rendered(name).then_some(index))
    });
    Some(Selection { stands_for: stands_for.collect(), is_part, notes, warnings })
}

/// Whether a name has the form `convex_<n>`, as CoACD and the examples of V-HACD write it.
fn is_convex_n(name: &str) -> bool {
    name.strip_prefix("convex_").is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()))
}

/// Names of the objects that a part may stand for, the likeliest first.
fn mesh_names(name: &str, part: PartName) -> Vec<&str> {
    match part {
        PartName::UnrealConvex | PartName::UnrealShape => {
            let whole = name.get("UCX_".len()..).unwrap_or_default();
            let numbered = whole.trim_end_matches(|c: char| c.is_ascii_digit()).strip_suffix('_');
            std::iter::once(whole).chain(numbered.filter(|mesh| mesh.len() < whole.len())).collect()
        }
        PartName::GodotConvex | PartName::GodotTriangles => {
            let at = name.rfind(['-', '$']).or_else(|| without_number(name).rfind('_'));
            at.and_then(|at| name.get(..at)).into_iter().collect()
        }
    }
}

fn is_rendered(name: &str) -> bool {
    let bare = without_number(name).to_lowercase();
    ["convcol", "col"]
        .iter()
        .any(|suffix| bare.strip_suffix(suffix).is_some_and(|rest| rest.ends_with(['-', '_', '$'])))
}

fn without_number(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit() || c.is_whitespace() || c == '_' || c == '.')
}

fn part(name: &str) -> Option<PartName> {
    if name.len() > "UCX_".len() {
        if name.starts_with("UCX_") {
            return Some(PartName::UnrealConvex);
        }
        if ["UBX_", "USP_", "UCP_"].iter().any(|prefix| name.starts_with(prefix)) {
            return Some(PartName::UnrealShape);
        }
    }
    let bare = without_number(name).to_lowercase();
    let ends_with = |suffix: &str| bare.strip_suffix(suffix).is_some_and(|rest| rest.ends_with(['-', '_', '$']));
    if ends_with("convcolonly") || ends_with("convcol") {
        return Some(PartName::GodotConvex);
    }
    (ends_with("colonly") || ends_with("col")).then_some(PartName::GodotTriangles)
}
