"""A rule that bakes one mesh. Untested: no Bazel of version 7 or newer was available.

With Bazel, each mesh is an action of its own, which costs more than a small mesh takes. For many small
meshes, use `bake build --cache`, which shares packs by their keys.
"""

def _hullmap_pack_impl(ctx):
    pack = ctx.actions.declare_file(ctx.label.name + "/" + ctx.file.mesh.basename.rsplit(".", 1)[0] + ".hullmap")
    arguments = ctx.actions.args()
    arguments.add("build")
    arguments.add(ctx.file.mesh)
    arguments.add("--out", pack.dirname)

    # The same pack wherever Bazel puts the mesh, and no search for files that are no inputs.
    arguments.add("--set", "record_source=name")
    arguments.add("--config", "none")
    arguments.add("--set", "pack_names=stem")
    arguments.add("--jobs", "1")
    arguments.add("--quiet")
    arguments.add_all(ctx.attr.options)
    ctx.actions.run(
        executable = ctx.executable.bake,
        arguments = [arguments],
        inputs = [ctx.file.mesh] + ctx.files.buffers,
        outputs = [pack],
        mnemonic = "HullmapBake",
        progress_message = "Baking %{input}",
    )
    return [DefaultInfo(files = depset([pack]))]

hullmap_pack = rule(
    implementation = _hullmap_pack_impl,
    doc = "Bakes one mesh into a .hullmap pack.",
    attrs = {
        "mesh": attr.label(allow_single_file = [".obj", ".gltf", ".glb", ".stl", ".ply", ".dae", ".msh"], mandatory = True),
        "buffers": attr.label_list(allow_files = True, doc = "Buffers beside a glTF file."),
        "options": attr.string_list(doc = "Flags of `bake build`, for instance --set=index=compact."),
        "bake": attr.label(executable = True, cfg = "exec", allow_single_file = True, mandatory = True),
    },
)
