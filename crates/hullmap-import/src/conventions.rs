//! Names by which artists mark collision parts, for `--split auto`.
//!
//! | from | name | taken as |
//! |---|---|---|
//! | Unreal | `UCX_<mesh>`, `UBX_`, `USP_`, `UCP_`, each perhaps with `_<nn>` | a part; a box, sphere or capsule is taken by its vertices |
//! | Godot | `<name>-convcolonly`, `<name>-convcol` | a part; the second is drawn too |
//! | Godot | `<name>-colonly`, `<name>-col` | a part, with a warning: Godot takes its triangles, not its hull |
//! | CoACD, V-HACD | every object is called `convex_<n>` | a part each |
//!
//! What is no part is a render mesh, and left out. A file without any of these names is not cut.
//!
//! Godot takes `-`, `_` or `$` before its suffixes, in capitals or not, and ignores digits, blanks, `_` and `.` behind
//! them, since modellers number copies. Unreal's prefixes are in capitals.
//!
//! # Reference
//! Unreal Engine, "FBX Static Mesh Pipeline"; Godot Engine, "Node type customization using name suffixes"; CoACD's
//! `SaveOBJ`.

/// Which convention makes a name that of a collision part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// Unreal's `UCX_`: convex.
    UnrealConvex,
    /// Unreal's `UBX_`, `USP_`, `UCP_`: a shape that Unreal makes again from its bounds.
    UnrealShape,
    /// Godot's `-convcol` and `-convcolonly`.
    GodotConvex,
    /// Godot's `-col` and `-colonly`: triangles.
    GodotTriangles,
}

/// Which objects of a file are collision parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// For each name whether it is a part's.
    pub is_part: Vec<bool>,
    /// What was recognised.
    pub notes: Vec<String>,
    /// What may not be what the artist meant.
    pub warnings: Vec<String>,
}

/// Recognises the collision parts among objects with these names; `None` where there are none.
pub fn select(names: &[&str]) -> Option<Selection> {
    if !names.is_empty() && names.iter().all(|name| is_of_decomposition(name)) {
        let notes = vec![format!("parts of a convex decomposition (convex_<n>), one hull each: {}", names.len())];
        return Some(Selection { is_part: vec![true; names.len()], notes, warnings: Vec::new() });
    }
    let parts: Vec<Option<Part>> = names.iter().map(|name| part(name)).collect();
    let count = |kinds: &[Part]| parts.iter().flatten().filter(|part| kinds.contains(part)).count();
    let mut notes = Vec::new();
    let unreal = count(&[Part::UnrealConvex, Part::UnrealShape]);
    let godot = count(&[Part::GodotConvex, Part::GodotTriangles]);
    if unreal + godot == 0 {
        return None;
    }
    if unreal > 0 {
        notes.push(format!("collision parts by Unreal's names (UCX_, UBX_, USP_, UCP_), one hull each: {unreal}"));
    }
    if godot > 0 {
        notes.push(format!("collision parts by Godot's names (-convcol, -convcolonly, …), one hull each: {godot}"));
    }
    if names.len() > unreal + godot {
        notes.push(format!("objects that are no collision parts, left out: {}", names.len() - unreal - godot));
    }
    let mut warnings = Vec::new();
    let first = |kind: Part| names.iter().zip(&parts).find(|(_, part)| **part == Some(kind)).map(|(name, _)| *name);
    if let Some(name) = first(Part::GodotTriangles) {
        warnings.push(format!(
            "object {name}: Godot collides with the triangles of -col and -colonly; here it gets its convex hull: name it -convcolonly where that is meant, or use --decompose"
        ));
    }
    if let Some(name) =
        names.iter().zip(&parts).find(|(name, part)| **part == Some(Part::UnrealShape) && !name.starts_with("UBX_"))
    {
        let name = name.0;
        notes.push(format!("object {name}: a sphere or capsule, taken as the hull of its vertices"));
    }
    Some(Selection { is_part: parts.iter().map(Option::is_some).collect(), notes, warnings })
}

/// `convex_<n>`, the only names that CoACD and V-HACD's examples give.
fn is_of_decomposition(name: &str) -> bool {
    name.strip_prefix("convex_").is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()))
}

fn part(name: &str) -> Option<Part> {
    if name.len() > "UCX_".len() {
        if name.starts_with("UCX_") {
            return Some(Part::UnrealConvex);
        }
        if ["UBX_", "USP_", "UCP_"].iter().any(|prefix| name.starts_with(prefix)) {
            return Some(Part::UnrealShape);
        }
    }
    let bare = name.trim_end_matches(|c: char| c.is_ascii_digit() || c.is_whitespace() || c == '_' || c == '.');
    let bare = bare.to_lowercase();
    let ends_with = |suffix: &str| bare.strip_suffix(suffix).is_some_and(|rest| rest.ends_with(['-', '_', '$']));
    if ends_with("convcolonly") || ends_with("convcol") {
        return Some(Part::GodotConvex);
    }
    (ends_with("colonly") || ends_with("col")).then_some(Part::GodotTriangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(names: &[&str]) -> Option<Vec<usize>> {
        let selection = select(names)?;
        let numbered = selection.is_part.iter().enumerate();
        Some(numbered.filter(|(_, is)| **is).map(|(number, _)| number).collect())
    }

    #[test]
    fn unreal() {
        let names =
            ["Chair", "UCX_Chair", "UCX_Chair_01", "UBX_Chair_00", "USP_Chair", "UCP_Chair_2", "ucx_Chair", "UCX_"];
        assert_eq!(parts(&names).unwrap(), [1, 2, 3, 4, 5]);
        let notes = select(&names).unwrap().notes;
        assert!(notes.iter().any(|note| note.contains("left out: 3")), "{notes:?}");
    }

    #[test]
    fn godot() {
        for name in
            ["Box-convcol", "Box-convcolonly", "Box_convcolonly", "Box$ConvCol", "Box-convcolonly.001", "a-convcol_2"]
        {
            assert_eq!(parts(&["Box", name]), Some(vec![1]), "{name}");
            assert!(select(&[name]).unwrap().warnings.is_empty());
        }
        for name in ["Box-col", "Box-colonly", "Box-COLONLY 3"] {
            assert_eq!(parts(&["Box", name]), Some(vec![1]), "{name}");
            assert!(select(&["Box", name]).unwrap().warnings[0].contains(name));
        }
        for name in ["protocol", "Boxconvcol", "Box-convcollider", "col", "Box-noimp"] {
            assert_eq!(parts(&["Box", name]), None, "{name}");
        }
    }

    #[test]
    fn decompositions() {
        assert_eq!(parts(&["convex_0", "convex_1", "convex_12"]), Some(vec![0, 1, 2]));
        assert_eq!(parts(&["convex_0", "mesh"]), None);
        assert_eq!(parts(&["convex_", "convex_0"]), None);
        assert_eq!(parts(&[]), None);
    }
}
