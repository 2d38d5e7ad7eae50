"""Pictures of the guides: the parts of a gear, and how many parts each error gives on three meshes.

    python colliders.py [FOLDER]

The command `hullmap decompose` makes the parts and counts them; `decomposition.py` draws them.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import List

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from decomposition import GREY, WIDTH, draw, read
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[3]
GEAR = ROOT / "assets" / "gear.obj"
CURVES = [ROOT / "assets" / f"{name}.obj" for name in ("torus_knot", "gear", "pawn")]
# Errors of a curve start at a quarter of the default, in % of the diagonal.
LEAST = 0.5
# A gear stands on its edge, and the camera expects y up.
LAID_DOWN = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def hullmap(*words: object) -> str:
    command = [sys.executable, "-m", "hullmap", *map(str, words)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def gear() -> Figure:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        # The caps are concave polygons, which `read` would cut wrongly.
        hullmap("build", GEAR, "--keep-triangles", "--config", "none", "--out", folder)
        hullmap("export", folder / "gear.hullmesh", "--out", folder / "mesh.obj")
        hullmap("decompose", GEAR, folder / "parts.obj")
        both = [read(folder / name) for name in ("mesh.obj", "parts.obj")]
    mesh, parts = ([(points @ LAID_DOWN.T, faces) for points, faces in each] for each in both)
    scale = 0.8 * WIDTH / np.ptp(np.concatenate([points for points, _ in mesh]), axis=0).max()
    wheel = [matplotlib.colormaps[name](index) for name in ("tab20", "tab20b") for index in range(20)]
    colours: List[str] = [matplotlib.colors.to_hex(colour) for colour in wheel[: len(parts)]]
    figure, axes = plt.subplots(1, 2, figsize=(7, 2.4), layout="constrained")
    panels = [(mesh, [GREY] * len(mesh), "the mesh"), (parts, colours, f"{len(parts)} convex parts")]
    for axis, (surfaces, chosen, title) in zip(axes, panels):
        axis.imshow(draw(surfaces, chosen, np.zeros(3), scale), interpolation="antialiased")
        axis.text(0.5, 0.0, title, ha="center", va="bottom", transform=axis.transAxes, color="#444444")
        axis.set_axis_off()
    print(f"gear: {len(parts)} parts")
    return figure


def curve() -> Figure:
    figure, axis = plt.subplots(figsize=(6, 2.8), layout="constrained")
    for path in CURVES:
        [mesh] = json.loads(hullmap("decompose", path, "--curve", "--json"))
        # An error that is left out gives the parts of the next larger one.
        rows = mesh["curve"][::-1]
        errors = [LEAST, *(100 * row["max_error"] / mesh["diagonal"] for row in rows)]
        axis.step(errors, [rows[0]["parts"], *(row["parts"] for row in rows)], where="pre", label=path.name)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("--max-error, in % of the diagonal")
    axis.set_ylabel("parts")
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(lambda value, _: f"{value:g}" if value in (0.5, 2, 5) else "")
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return figure


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    for name, figure in [("colliders", gear()), ("curve", curve())]:
        figure.savefig(folder / f"{name}.png", dpi=100)


if __name__ == "__main__":
    main()
