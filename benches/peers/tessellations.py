"""Number of parts of the same shape at several tessellations, by `bake decompose`.

    python benches/peers/tessellations.py BAKE MESH.obj... [--levels 4] [--most 100000] [-- OPTIONS]

Each level divides every triangle into four, so the shape stays the same. Levels of more than `--most`
triangles are left out. OPTIONS are passed on to `bake decompose`. Prints a line for each mesh: the number
of triangles and of parts at each level, and the spread of the numbers of parts.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile


def read(path):
    """Points, and triangles by index."""
    points, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(float(word) for word in words[1:4]))
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            triangles += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return points, triangles


def divided(points, triangles):
    """Each triangle as four, with the middles of its edges."""
    points, middles, smaller = list(points), {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(points)
            points.append(tuple((x + y) / 2 for x, y in zip(points[a], points[b])))
        return middles[key]

    for a, b, c in triangles:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        smaller += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return points, smaller


def write(path, points, triangles):
    lines = ["v %.9g %.9g %.9g" % point for point in points]
    lines += ["f %d %d %d" % tuple(v + 1 for v in triangle) for triangle in triangles]
    path.write_text("\n".join(lines) + "\n")


def main():
    words = sys.argv[1:]
    options = words[words.index("--") + 1 :] if "--" in words else []
    parser = argparse.ArgumentParser()
    parser.add_argument("bake")
    parser.add_argument("meshes", nargs="+", type=pathlib.Path)
    parser.add_argument("--levels", type=int, default=4)
    parser.add_argument("--most", type=int, default=100_000)
    arguments = parser.parse_args(words[: words.index("--")] if "--" in words else words)
    within = 0
    with tempfile.TemporaryDirectory() as folder:
        mesh, out = pathlib.Path(folder, "mesh.obj"), pathlib.Path(folder, "parts.obj")
        for path in arguments.meshes:
            points, triangles = read(path)
            counts = []
            for level in range(arguments.levels):
                if level > 0:
                    points, triangles = divided(points, triangles)
                if len(triangles) > arguments.most:
                    break
                write(mesh, points, triangles)
                command = [arguments.bake, "decompose", mesh, out, "--force", "--json", *options]
                done = subprocess.run(command, check=True, capture_output=True, text=True)
                counts.append((len(triangles), json.loads(done.stdout)["parts"]))
            parts = [count for _, count in counts]
            spread = max(parts) / min(parts) - 1
            within += spread <= 0.1
            row = ", ".join(f"{count} at {size}" for size, count in counts)
            print(f"{path.stem}: {row}; spread {100 * spread:.0f} %", flush=True)
    print(f"{within} of {len(arguments.meshes)} within 10 %")


if __name__ == "__main__":
    main()
