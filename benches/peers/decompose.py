"""Decomposes the OBJ meshes of a folder with CoACD or V-HACD, for `decompose-table --peer`.

    pip install coacd vhacdx trimesh
    python benches/peers/decompose.py coacd FOLDER OUT [THRESHOLD]
    python benches/peers/decompose.py vhacd FOLDER OUT [MAX_PARTS]

Writes OUT/NAME.obj with one object for each part, and OUT/seconds.tsv with the processor time of
each mesh. An OUT/NAME.obj that exists already is kept, and so is its time.

First the tool decomposes two known boxes, as an OBJ file like all others. Their line goes into
OUT/proof.txt. If the parts are not these boxes, the program ends.
"""

import importlib
import pathlib
import sys
import tempfile
import time
from importlib import metadata

import trimesh

import known


def parts_of(tool, module, path, limit):
    """The points and triangles of each part, and the processor time."""
    mesh = trimesh.load(path, force="mesh", process=False)
    start = time.process_time()
    if tool == "coacd":
        parts = module.run_coacd(module.Mesh(mesh.vertices, mesh.faces), threshold=limit)
    else:
        # Faces are one flat list, each with its number of corners first. Rows of three corners are accepted,
        # too, and read as other faces.
        faces = [number for face in mesh.faces for number in (3, *face)]
        parts = module.compute_vhacd(mesh.vertices, faces, maxConvexHulls=limit)
    return parts, time.process_time() - start


def text_of(parts):
    lines, first = [], 1
    for index, (vertices, faces) in enumerate(parts):
        lines.append(f"o part_{index}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in faces]
        first += len(vertices)
    return "\n".join(lines) + "\n"


def proof(tool, module, name, limit):
    """The line about two separate boxes. V-HACD divides boxes, too, so it gets their number."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "boxes.obj")
        path.write_text(known.obj("separated"), encoding="utf-8")
        parts, _ = parts_of(tool, module, path, len(known.VOLUMES) if tool == "vhacd" else limit)
    volumes = sorted(known.volume(*part) for part in parts)
    of_volumes = zip(("smaller volume", "larger volume"), known.VOLUMES, volumes)
    return known.require(f"{name} {metadata.version(name)}", [("parts", len(known.VOLUMES), len(parts)), *of_volumes])


def main():
    tool, folder, out = sys.argv[1], *(pathlib.Path(path) for path in sys.argv[2:4])
    limit = {"coacd": float, "vhacd": int}[tool]([*sys.argv[4:5], {"coacd": 0.05, "vhacd": 64}[tool]][0])
    name = {"coacd": "coacd", "vhacd": "vhacdx"}[tool]
    module = importlib.import_module(name)
    if tool == "coacd":
        module.set_log_level("error")
    out.mkdir(parents=True, exist_ok=True)
    (out / "proof.txt").write_text(proof(tool, module, name, limit) + "\n", encoding="utf-8")
    for path in sorted(folder.glob("*.obj")):
        target = out / path.name
        if target.exists():
            continue
        parts, seconds = parts_of(tool, module, path, limit)
        target.write_text(text_of(parts), encoding="utf-8")
        with open(out / "seconds.tsv", "a", encoding="utf-8") as table:
            table.write(f"{path.stem}\t{seconds:.3f}\n")
        print(path.stem, len(parts), f"{seconds:.1f} s", flush=True)


if __name__ == "__main__":
    main()
