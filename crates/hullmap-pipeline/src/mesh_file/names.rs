//! Names in exported files. Names in a pack come from elsewhere and may hold any character: a path
//! that leads out of the folder, a line break, a quote.
//!
//! | target | name |
//! |---|---|
//! | OBJ, JSON, GLB | the hull's name; in OBJ without characters that end or divide a line |
//! | Unreal | `UCX_<render mesh>_<nn>` |
//! | Godot | `<name>`, without suffixes that Godot reads |
//! | MJCF, URDF, names of files | letters, digits, `.`, `_` and `-` |
//!
//! # Reference
//! Unreal Engine, "FBX Static Mesh Pipeline"; Godot Engine, "Node type customization using name
//! suffixes". The importer reads the same names: `conventions.rs` of `hullmap-import`.

use std::collections::HashMap;

/// Maximum length of a token in bytes. With a number, an extension and the affixes of a temporary
/// file it stays below the 255 bytes of common file systems.
const MAX_TOKEN: usize = 180;

pub const NAMES_IN_MESSAGE: usize = 5;

const NAMELESS: &str = "hull";

/// Names that Windows reserves for devices, with any extension.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "com", "lpt"];

/// Whether a character moves the cursor, ends a line, or changes the direction of writing.
pub fn is_escaped(letter: char) -> bool {
    // C0, DEL and C1.
    letter.is_control()
        || matches!(
            letter,
            // Marks, embeddings, overrides and isolates of the bidirectional algorithm.
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
            // Separators of lines and paragraphs.
            | '\u{2028}' | '\u{2029}'
        )
}

/// A name that fits in one line of an OBJ file: no line breaks, no `\`, which continues a line, and
/// no `#`, which starts a comment for some readers.
pub fn line(name: &str) -> String {
    let is_unfit = |letter: char| is_escaped(letter) || matches!(letter, '\\' | '#');
    let name: String = name.chars().map(|letter| if is_unfit(letter) { '_' } else { letter }).collect();
    let name = name.trim();
    if name.is_empty() { NAMELESS.to_owned() } else { name.to_owned() }
}

/// A name of letters, digits, `.`, `_` and `-`, which is the same in XML, in a URI and in the file
/// systems of all platforms. It never names a folder or a device.
pub fn token(name: &str) -> String {
    let kept = |letter: char| letter.is_alphanumeric() || matches!(letter, '.' | '_' | '-');
    let mut token: String = name.chars().map(|letter| if kept(letter) { letter } else { '_' }).collect();
    while token.len() > MAX_TOKEN {
        token.pop();
    }
    if token.chars().all(|letter| !letter.is_alphanumeric()) {
        return NAMELESS.to_owned();
    }
    if token.ends_with('.') {
        token.push('_');
    }
    if token.starts_with(['.', '-']) || is_device(&token) {
        token.insert(0, '_');
    }
    token
}

fn is_device(token: &str) -> bool {
    let stem = token.split('.').next().unwrap_or_default().to_lowercase();
    let bare = stem.trim_end_matches(|letter: char| letter.is_numeric());
    DEVICES.contains(&bare) && stem.chars().count() <= 4
}

/// The names, where each repetition gets the lowest suffix `_2`, `_3`, … that gives a new name.
/// Names that differ in case alone are repetitions, because they may name the same file.
pub fn unique(names: Vec<String>) -> Vec<String> {
    hullmap_import::unique_names(names, str::to_lowercase)
}

/// Name of the object of a hull: without the `_part_<nn>` that a decomposition appends.
pub fn object(name: &str, part: u32) -> &str {
    match name.rsplit_once("_part_") {
        Some((object, number)) if number.parse() == Ok(part) => object,
        _ => name,
    }
}

/// `UCX_<render mesh>_<nn>`, numbered for each render mesh. A hull that has such a name already
/// keeps it, unless `mesh` names the render mesh.
pub fn unreal(names: &[(&str, u32)], mesh: Option<&str>) -> Vec<String> {
    let mut counts: HashMap<String, u32> = HashMap::new();
    let named = names.iter().map(|&(name, part)| {
        if mesh.is_none() && name.len() > "UCX_".len() && name.starts_with("UCX_") {
            return token(name);
        }
        let mesh = token(mesh.unwrap_or_else(|| object(name, part)));
        let count = counts.entry(mesh.clone()).or_default();
        let name = format!("UCX_{mesh}_{count:02}");
        *count += 1;
        name
    });
    unique(named.collect())
}

/// `UCX_<render mesh>_<nn>` for hulls beside these render meshes in one file, numbered for each.
/// The names keep all characters: the importer changes both in the same way.
pub fn unreal_beside(meshes: &[&str]) -> Vec<String> {
    let mut counts: HashMap<&str, u32> = HashMap::new();
    let mut number = |mesh| {
        let count = counts.entry(mesh).or_default();
        *count += 1;
        *count - 1
    };
    meshes.iter().map(|&mesh| format!("UCX_{mesh}_{:02}", number(mesh))).collect()
}

/// Names of nodes in Godot. The colliders are described by an extension, so a suffix that Godot
/// would read is removed: it would add a second collider.
pub fn godot(names: &[(&str, u32)], node: Option<&str>) -> Vec<String> {
    let bare = names.iter().enumerate().map(|(index, (name, _))| match node {
        Some(node) if names.len() > 1 => format!("{}_{index:02}", node_name(node)),
        Some(node) => node_name(node),
        None => node_name(name),
    });
    unique(bare.collect())
}

fn node_name(name: &str) -> String {
    let name = token(name).replace('.', "_");
    let folded = name.to_ascii_lowercase();
    let bare = folded.trim_end_matches(|letter: char| letter.is_ascii_digit() || letter == '_');
    let suffixed = ["convcolonly", "convcol", "colonly", "col"].iter().find_map(|suffix| {
        let rest = bare.strip_suffix(suffix)?;
        rest.strip_suffix(['-', '_']).filter(|rest| !rest.is_empty())
    });
    match suffixed {
        // `to_ascii_lowercase` keeps the positions of all bytes.
        Some(rest) => name[..rest.len()].to_owned() + &name[bare.len()..],
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_a_file_name_everywhere() {
        for (name, expected) in [
            ("rock", "rock"),
            ("größe 漢字", "größe_漢字"),
            ("../../etc/passwd", "_.._.._etc_passwd"),
            ("..", "hull"),
            ("", "hull"),
            ("a/b\\c:d", "a_b_c_d"),
            ("-rf", "_-rf"),
            (".hidden", "_.hidden"),
            ("dot.", "dot._"),
            ("CON", "_CON"),
            ("nul.txt", "_nul.txt"),
            ("COM7", "_COM7"),
            ("console", "console"),
            ("a\"><b & 'c'", "a___b____c_"),
            ("a\n\u{202e}b\0", "a__b_"),
        ] {
            assert_eq!(token(name), expected, "{name:?}");
            assert_eq!(token(expected), expected, "a token stays as it is");
        }
        assert!(token(&"漢".repeat(5000)).len() <= MAX_TOKEN);
    }

    #[test]
    fn a_line_holds_one_name() {
        for (name, expected) in [
            ("a b  c", "a b  c"),
            ("x\nf 1 2 3", "x_f 1 2 3"),
            ("end\\", "end_"),
            ("a # b", "a _ b"),
            (" \t ", "_"),
            ("  ", "hull"),
            ("\u{2028}", "_"),
        ] {
            assert_eq!(line(name), expected, "{name:?}");
        }
    }

    #[test]
    fn repetitions_are_numbered_whatever_their_case() {
        let names = ["a", "A", "a_2", "b"].map(str::to_owned).into();
        assert_eq!(unique(names), ["a", "A_3", "a_2", "b"]);
        assert_eq!(unique(vec!["x".to_owned(); 100_000])[99_999], "x_100000");
    }

    #[test]
    fn unreal_names() {
        let names = [("u_part_00", 0), ("u_part_01", 1), ("wheel", 0), ("UCX_Chair_07", 0), ("a_part_3", 2)];
        let expected = ["UCX_u_00", "UCX_u_01", "UCX_wheel_00", "UCX_Chair_07", "UCX_a_part_3_00"];
        assert_eq!(unreal(&names, None), expected);
        assert_eq!(unreal(&names[2..4], Some("SM Chair")), ["UCX_SM_Chair_00", "UCX_SM_Chair_01"]);
        assert_eq!(unreal(&[("UCX_a", 0), ("ucx_A", 0), ("UCX_a", 0)], None), ["UCX_a", "UCX_ucx_A_00", "UCX_a_2"]);
    }

    #[test]
    fn godot_names() {
        let names = [("rock", 0), ("rock", 0), ("Box-convcolonly", 0), ("a.b", 0), ("Box_CONVCOL_2", 0), ("x-col", 0)];
        assert_eq!(godot(&names, None), ["rock", "rock_2", "Box", "a_b", "Box_2", "x"]);
        assert_eq!(godot(&names[..1], Some("Stone")), ["Stone"]);
        assert_eq!(godot(&names[..2], Some("Stone")), ["Stone_00", "Stone_01"]);
    }
}
