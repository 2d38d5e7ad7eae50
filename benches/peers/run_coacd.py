"""Decomposes the OBJ meshes of a folder with CoACD, for `decompose-table --peer`.

    pip install coacd trimesh
    python benches/peers/run_coacd.py FOLDER OUT [THRESHOLD]

Writes OUT/NAME.obj with one object for each part, and OUT/seconds.tsv with the processor time of
each mesh. The first OUT/NAME.obj that exists already is kept, and so is its time.
"""

import pathlib
import sys
import time

import coacd
import trimesh

folder, out = (pathlib.Path(path) for path in sys.argv[1:3])
threshold = float(sys.argv[3]) if len(sys.argv) > 3 else 0.05
out.mkdir(parents=True, exist_ok=True)
coacd.set_log_level("error")
for path in sorted(folder.glob("*.obj")):
    target = out / path.name
    if target.exists():
        continue
    mesh = trimesh.load(path, force="mesh", process=False)
    start = time.process_time()
    parts = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), threshold=threshold)
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
