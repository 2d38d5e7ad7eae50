"""Decomposes the OBJ meshes of a folder with CoACD or V-HACD, for `decompose-table --peer`.

    pip install coacd vhacdx trimesh
    python benches/peers/decompose.py coacd FOLDER OUT [THRESHOLD]
    python benches/peers/decompose.py vhacd FOLDER OUT [MAX_PARTS]

Writes OUT/NAME.obj with one object for each part, and OUT/seconds.tsv with the processor time of
each mesh. An OUT/NAME.obj that exists already is kept, and so is its time.
"""

import importlib
import pathlib
import sys
import time

import trimesh

tool, folder, out = sys.argv[1], *(pathlib.Path(path) for path in sys.argv[2:4])
limit = sys.argv[4:5]
out.mkdir(parents=True, exist_ok=True)
module = importlib.import_module({"coacd": "coacd", "vhacd": "vhacdx"}[tool])
if tool == "coacd":
    module.set_log_level("error")


def parts_of(mesh):
    """The points and triangles of each part."""
    if tool == "coacd":
        threshold = float(limit[0]) if limit else 0.05
        return module.run_coacd(module.Mesh(mesh.vertices, mesh.faces), threshold=threshold)
    most = int(limit[0]) if limit else 64
    return module.compute_vhacd(mesh.vertices, mesh.faces, maxConvexHulls=most)


for path in sorted(folder.glob("*.obj")):
    target = out / path.name
    if target.exists():
        continue
    mesh = trimesh.load(path, force="mesh", process=False)
    start = time.process_time()
    parts = parts_of(mesh)
    seconds = time.process_time() - start
    lines, first = [], 1
    for index, (vertices, faces) in enumerate(parts):
        lines.append(f"o part_{index}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in faces]
        first += len(vertices)
    target.write_text("\n".join(lines) + "\n")
    with open(out / "seconds.tsv", "a", encoding="utf-8") as table:
        table.write(f"{path.stem}\t{seconds:.3f}\n")
    print(path.stem, len(parts), f"{seconds:.1f} s", flush=True)
