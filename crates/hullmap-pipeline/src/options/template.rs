//! The `hullmap.toml` that `bake init` writes: every option at its default, commented out.
//! Generated from the table of options.

use std::fmt::Write;

use super::table::{BuildOption, Section, name};
use super::value::Syntax;

const HEAD: &str = "\
# Options of `bake build` for the meshes in this folder and below.
#
# Command-line flags override this file, rules override [defaults], and later rules override
# earlier ones.
# A mesh is baked again when its own options change, not whenever this file changes.
# If several folders above a mesh have such a file, only the nearest one is used.

# With these two, `bake build` needs no arguments. Paths are relative to this folder.
# sources = [\"assets\"]
# output = \"baked\"

[defaults]
";

const RULES: &str = r#"
# Rules override the defaults for some meshes. A glob with `/` is relative to this folder (`*` stays
# within one folder, `**` does not); a glob without `/` is matched against the file name. Case is
# ignored.
#
# [[rule]]
# files = "assets/props/**"
# index = "compact"
#
# [[rule]]
# files = ["*_collision.obj", "assets/vehicles/*.obj"]
# split = "object"
#
# [[rule]]
# files = "assets/levels/**"
# keep_triangles = true
#
# [[rule]]
# files = "assets/ground/*.png"
# terrain = true
#
# [[rule]]
# files = "assets/lods/**"
# skip = true
"#;

const TERRAIN: &str = "
# Options of terrains: grids of heights that a rule chooses with terrain = true. Rules override them.

[terrain]

";

pub fn template() -> String {
    let mut text = HEAD.to_owned();
    for section in Section::ALL {
        let heading = if section == Section::Terrain { TERRAIN } else { &format!("\n# {}\n", section.heading()) };
        text += heading;
        // Rules choose the terrains.
        for option in section.options().filter(|option| option.key != "terrain") {
            let _ = writeln!(text, "# {}.\n# {} = {}", option.help, name(option.key), toml_value(option));
        }
    }
    text + RULES
}

fn toml_value(option: &BuildOption) -> String {
    let value = option.default;
    let is_string = matches!(option.syntax, Syntax::Words(_)) || value == "none" || value.ends_with('%');
    if is_string { format!("\"{value}\"") } else { value.to_owned() }
}
