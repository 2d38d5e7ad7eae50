"""The picture of the README: a mesh, its convex parts, and the parts pulled apart, with their numbers.

    python decomposition.py [FOLDER] [MESH]

The command `hullmap decompose` makes the parts. A depth buffer draws them, with flat shading.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import List, Tuple

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TEAPOT = Path(__file__).resolve().parents[3] / "tests" / "meshes" / "vhacd_teapot.obj"
MAX_PARTS = 8
# Pixels of a panel, before each block of 2 by 2 becomes one.
HEIGHT, WIDTH = 860, 1400
# Share of its distance from the middle by which a part is pulled away.
PULL = 0.35
COLOURS = ["#d9743f", "#3f8fd0", "#56ad62", "#8f8f4d", "#419c9c", "#8e6bbd", "#c99a34", "#d678a5"]
GREY = "#c4c4c8"

# Vertices, and triangles of their indices.
Surface = Tuple[np.ndarray, np.ndarray]


def read(path: Path) -> List[Surface]:
    """The objects of an OBJ file, with polygons cut into triangles."""
    vertices: List[List[float]] = []
    objects: List[List[List[int]]] = [[]]
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["o"]:
            objects.append([])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            objects[-1] += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    points = np.array(vertices)
    surfaces = []
    for triangles in filter(None, objects):
        used, indices = np.unique(np.array(triangles), return_inverse=True)
        surfaces.append((points[used], indices.reshape(-1, 3)))
    return surfaces


def view(points: np.ndarray) -> np.ndarray:
    """Turns y-up points towards the camera, which looks along -z."""
    yaw, pitch = np.radians(-25.0), np.radians(20.0)
    about_y = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]])
    return points @ (about_x @ about_y).T


def draw(surfaces: List[Surface], colours: List[str], middle: np.ndarray, scale: float) -> np.ndarray:
    """An image of surfaces in one colour each, `scale` pixels per unit, with `middle` in its centre."""
    image = np.ones((HEIGHT, WIDTH, 3))
    depth = np.full((HEIGHT, WIDTH), -np.inf)
    light = np.array([-0.35, 0.6, 0.72])
    for (vertices, triangles), colour in zip(surfaces, colours):
        turned = (view(vertices) - view(middle)) * scale
        screen = np.column_stack((turned[:, 0] + WIDTH / 2, HEIGHT / 2 - turned[:, 1], turned[:, 2]))
        for corners, (a, b, c) in zip(turned[triangles], screen[triangles]):
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            if abs(area) < 1e-9:
                continue
            normal *= np.sign(normal[2]) / np.linalg.norm(normal)
            low = np.maximum(np.floor(np.minimum(np.minimum(a, b), c))[:2].astype(int), 0)
            high = np.minimum(np.ceil(np.maximum(np.maximum(a, b), c))[:2].astype(int) + 1, (WIDTH, HEIGHT))
            x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
            u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
            v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
            z = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
            block = np.s_[low[1] : high[1], low[0] : high[0]]
            seen = (u >= 0) & (v >= 0) & (u + v <= 1) & (z > depth[block])
            shade = 0.35 + 0.65 * max(0.0, float(normal @ light))
            depth[block][seen] = z[seen]
            image[block][seen] = np.array(matplotlib.colors.to_rgb(colour)) * shade
    return image.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 3).mean(axis=(1, 3))


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    source = Path(sys.argv[2]) if len(sys.argv) > 2 else TEAPOT
    with tempfile.TemporaryDirectory() as temporary:
        out = Path(temporary) / "parts.obj"
        command = ["decompose", str(source), str(out), "--max-parts", str(MAX_PARTS), "--quiet"]
        subprocess.run([sys.executable, "-m", "hullmap", *command], check=True)
        parts = read(out)
    mesh = read(source)
    everything = np.concatenate([vertices for vertices, _ in mesh])
    middle = (everything.min(axis=0) + everything.max(axis=0)) / 2
    moved = [(vertices + PULL * (vertices.mean(axis=0) - middle), triangles) for vertices, triangles in parts]
    scale = 0.74 * WIDTH / np.ptp(everything, axis=0).max()
    colours = [COLOURS[index % len(COLOURS)] for index in range(len(parts))]
    triangles, vertices = sum(len(each) for _, each in mesh), sum(len(each) for each, _ in parts)
    panels = [
        (mesh, [GREY] * len(mesh), f"mesh: {triangles:,} triangles"),
        (parts, colours, f"{len(parts)} convex parts: {vertices:,} vertices"),
        (moved, colours, "the parts, pulled apart"),
    ]
    figure, axes = plt.subplots(1, 3, figsize=(12, 3), layout="constrained")
    for axis, (surfaces, chosen, title) in zip(axes, panels):
        axis.imshow(draw(surfaces, chosen, middle, scale), interpolation="antialiased")
        axis.text(0.5, 0.0, title, ha="center", va="bottom", transform=axis.transAxes, color="#444444")
        axis.set_axis_off()
        print(title)
    figure.savefig(folder / "decomposition.png", dpi=100)


if __name__ == "__main__":
    main()
