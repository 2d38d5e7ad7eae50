"""Two pictures of a hull: its Gauss map, and distance fields around it.

    python plots.py [FOLDER] [MESH]

The Gauss map colours each direction by the vertex that is farthest in it: the normal cones of the
vertices, which the direction index looks up. The distance fields are a section through the hull,
and all positions of a second body.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

import hullmap  # noqa: E402


def gauss_map(hull: hullmap.Hull, path: Path) -> None:
    """Draws which vertex is the support vertex in each direction."""
    longitude, latitude = np.meshgrid(np.linspace(-np.pi, np.pi, 1440), np.linspace(-np.pi / 2, np.pi / 2, 720))
    ring = np.cos(latitude)
    directions = np.stack((ring * np.cos(longitude), ring * np.sin(longitude), np.sin(latitude)), axis=-1)
    vertex = hull.support(directions).vertex  # a million support queries
    colours = np.random.default_rng(3).permutation(len(hull))

    figure, axes = plt.subplots(figsize=(9, 4.6), layout="constrained")
    axes.imshow(colours[vertex], extent=(-180, 180, -90, 90), origin="lower", cmap="turbo", interpolation="nearest")
    axes.set(title=f"Gauss map of {hull.name}: {len(hull)} normal cones", xlabel="longitude of the direction", ylabel="latitude")
    axes.set(xticks=range(-180, 181, 60), yticks=range(-90, 91, 30))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def distance_fields(hull: hullmap.Hull, path: Path) -> None:
    """Draws signed distances in a section, and distances and depths of a second body."""
    centre, steps = hull.bounds.mean(axis=0), np.linspace(-1, 1, 400) * hull.diameter
    x, z = np.meshgrid(steps, steps)
    grid = np.stack((x, np.zeros_like(x), z), axis=-1)
    section = hull.signed_distance(centre + 0.8 * grid).distance

    # The second body is the same hull, upside down, with its centre at each point of the grid.
    upside_down = [1.0, 0.0, 0.0, 0.0]
    place = centre + 1.3 * grid - centre * [1.0, -1.0, -1.0]
    poses = hullmap.poses(place, upside_down)
    pair = hull.distance(hull, poses).distance - hull.contact(hull, poses).depth

    figure, panels = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained")
    titles = (f"signed distance from {hull.name}", "distance of a second body, by its position")
    for axes, field, title, scale in zip(panels, (section, pair), titles, (0.8, 1.3)):
        limit, (x, _, z) = abs(field).max(), np.moveaxis(scale * grid, -1, 0)
        image = axes.pcolormesh(x, z, field, cmap="RdBu", vmin=-limit, vmax=limit, shading="nearest")
        axes.contour(x, z, field, levels=np.linspace(-limit, limit, 25), colors="k", linewidths=0.3)
        axes.contour(x, z, field, levels=[0], colors="k", linewidths=1.6)
        axes.set(title=title, xlabel="x", ylabel="z", aspect="equal")
        figure.colorbar(image, ax=axes, shrink=0.85, label="negative: penetration depth")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    if len(sys.argv) > 2:
        hull = hullmap.bake_file(sys.argv[2])[0]
    else:
        points = np.random.default_rng(7).normal(size=(400, 3))
        points *= np.array([1.0, 0.8, 0.6]) / np.linalg.norm(points, axis=1, keepdims=True)
        hull = hullmap.bake(points, name="rock")[0]
    gauss_map(hull, folder / "gauss_map.png")
    distance_fields(hull, folder / "distance_field.png")
    print(f"wrote {folder / 'gauss_map.png'} and {folder / 'distance_field.png'}")


if __name__ == "__main__":
    main()
