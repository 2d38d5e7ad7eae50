//! What `bake init` writes.

/// A `hullmap.toml` that says nothing yet: every option with its default, commented out.
pub const TEMPLATE: &str = r#"# How `bake build` reads and bakes the meshes in this folder and below.
#
# Flags of the command win over this file, later rules over earlier ones, rules over [defaults].
# A mesh is baked again when its own options change, not when this file does.
# Of several such files the one nearest above a mesh counts, alone.

[defaults]
# One hull a file ("none"), one for each object ("object"), or by artists' names such as UCX_… ("auto").
# split = "none"
# The points that elements reference ("referenced"), or all of them ("all").
# vertices = "referenced"
# Coordinates are multiplied with this: 0.01 turns centimetres into metres.
# unit_scale = 1.0
# Turn about x: "keep", "y-to-z" (what points along y then points along z), "z-to-y".
# up_axis = "keep"
# Take points from the middle of the file's bounds, for meshes far from the origin.
# recentre = false

# The direction index: "tree", "medium", "compact" (half the bytes), "binary", "cubemap" or "none".
# index = "tree"
# Cells along the edge of a cube face; only together with index = "cubemap".
# resolution = 64
# Instead of index: the fastest one of at most this many bytes a hull vertex.
# index_budget = 100

# An outer hull of at most so many vertices, or one that leaves the source by at most so many units; one of the two.
# max_vertices = "none"
# max_error = "none"

# Cut concave meshes into convex parts (V-HACD).
# decompose = false
# vhacd_concavity = 0.01
# vhacd_resolution = 64
# vhacd_max_parts = 1024
# vhacd_alpha = 0.05
# vhacd_beta = 0.05
# vhacd_plane_downsampling = 4
# vhacd_hull_downsampling = 4
# vhacd_hull_approximation = true
# vhacd_fill = "flood"

# Rules for some meshes. A glob with `/` starts at this folder (`*` stays in a folder, `**` does not); one without `/` is
# compared with the file's name. Capitals do not count.
#
# [[rule]]
# files = "props/**"
# index = "compact"
#
# [[rule]]
# files = ["*_collision.obj", "vehicles/*.obj"]
# split = "object"
"#;
