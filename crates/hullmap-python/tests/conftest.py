"""Shapes and poses that the tests share, and brute-force truth in doubles."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import hullmap

CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def rock(count: int, seed: int) -> np.ndarray:
    """Points on a lumpy ellipsoid, as 32-bit floats, so that a bake does not round them."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    points *= np.array([1.0, 0.8, 0.6]) / np.linalg.norm(points, axis=1, keepdims=True)
    return points.astype(np.float32)


def torus(around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and quadrilaterals of a torus whose tube swells nine times."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    tube = 0.3 * (1 + 0.2 * np.sin(9 * u))
    ring = 1 + tube * np.cos(v)
    points = np.stack((ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)), axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    return points, np.stack([k % around * across + m % across for k, m in corners], axis=-1).reshape(-1, 4)


def random_poses(count: int, seed: int, reach: float) -> np.ndarray:
    """Random rotations, and positions at distances of 0 to ``reach``."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(count, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    ways = rng.normal(size=(count, 3))
    ways *= rng.uniform(0, reach, size=(count, 1)) / np.linalg.norm(ways, axis=1, keepdims=True)
    return hullmap.poses(ways, turns)


def matrices(poses: np.ndarray) -> np.ndarray:
    """Rows of seven numbers as 4x4 matrices, by a formula of its own."""
    x, y, z, w = np.moveaxis(poses[..., 3:], -1, 0)
    result = np.zeros(poses.shape[:-1] + (4, 4))
    result[..., :3, 3] = poses[..., :3]
    result[..., 3, 3] = 1
    result[..., 0, 0], result[..., 0, 1], result[..., 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    result[..., 1, 0], result[..., 1, 1], result[..., 1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    result[..., 2, 0], result[..., 2, 1], result[..., 2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    return result


class Body:
    """Vertices, triangles, edges and face normals of a hull, in doubles."""

    def __init__(self, hull: hullmap.Hull, pose: np.ndarray | None = None) -> None:
        self.points = hull.vertices.astype(float)
        if pose is not None:
            frame = matrices(pose)
            self.points = self.points @ frame[:3, :3].T + frame[:3, 3]
        self.triangles = self.points[hull.triangles]
        pairs = {tuple(sorted((v, int(w)))) for v, near in enumerate(hull.neighbours) for w in near}
        self.edges = self.points[np.array(sorted(pairs))]
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        normals = np.cross(b - a, c - a)
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)


def brute_depth(a: Body, b: Body) -> float:
    """Separating axes: the smallest overlap over all face normals and products of edges. It is
    negative if the bodies are separated."""
    da, db = np.diff(a.edges, axis=1)[:, 0], np.diff(b.edges, axis=1)[:, 0]
    crosses = np.cross(da[:, None], db[None]).reshape(-1, 3)
    lengths = np.linalg.norm(crosses, axis=1)
    keep = lengths > 1e-9 * np.linalg.norm(da, axis=1).max() * np.linalg.norm(db, axis=1).max()
    crosses = crosses[keep] / lengths[keep, None]
    axes = np.concatenate((a.normals, -b.normals, crosses, -crosses))
    # In pieces: all products of two large bodies would fill the memory.
    pieces = np.array_split(axes, 1 + len(axes) // 20_000)
    return float(min(((a.points @ piece.T).max(0) - (b.points @ piece.T).min(0)).min() for piece in pieces))


def _points_to_triangles(points: np.ndarray, triangles: np.ndarray) -> float:
    """The smallest distance of any point from any triangle's interior or corners; edges are left to
    pairs of edges."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, ac = b - a, c - a
    ap = points[:, None] - a[None]
    d00, d01, d11 = (ab * ab).sum(-1), (ab * ac).sum(-1), (ac * ac).sum(-1)
    d20, d21 = (ap * ab).sum(-1), (ap * ac).sum(-1)
    det = d00 * d11 - d01 * d01
    v, w = (d11 * d20 - d01 * d21) / det, (d00 * d21 - d01 * d20) / det
    inside = (v >= 0) & (w >= 0) & (v + w <= 1)
    foot = a + v[..., None] * ab + w[..., None] * ac
    gaps = np.linalg.norm(points[:, None] - foot, axis=-1)
    return float(np.where(inside, gaps, np.inf).min())


def _edges_to_edges(p: np.ndarray, q: np.ndarray) -> float:
    """The smallest distance of any two segments."""
    (p0, p1), (q0, q1) = (np.moveaxis(p, 1, 0) for p in (p, q))
    d1, d2 = (p1 - p0)[:, None], (q1 - q0)[None]
    r = p0[:, None] - q0[None]
    a, e, b = (d1 * d1).sum(-1), (d2 * d2).sum(-1), (d1 * d2).sum(-1)
    c, f = (d1 * r).sum(-1), (d2 * r).sum(-1)
    det = a * e - b * b
    s = np.clip(np.where(det > 1e-14 * a * e, (b * f - c * e) / np.where(det == 0, 1, det), 0.0), 0, 1)
    t = np.clip((b * s + f) / e, 0, 1)
    s = np.clip((b * t - c) / a, 0, 1)
    t = np.clip((b * s + f) / e, 0, 1)
    return float(np.linalg.norm(r + s[..., None] * d1 - t[..., None] * d2, axis=-1).min())


def brute_distance(a: Body, b: Body) -> float:
    """The smallest distance of any two features; 0 if the separating axes find none."""
    if brute_depth(a, b) >= 0:
        return 0.0
    return min(
        _points_to_triangles(a.points, b.triangles),
        _points_to_triangles(b.points, a.triangles),
        _edges_to_edges(a.edges, b.edges),
    )


@pytest.fixture(scope="session")
def cube() -> hullmap.Hull:
    return hullmap.bake(CUBE, name="cube")[0]


@pytest.fixture(scope="session")
def rocks() -> tuple[hullmap.Hull, hullmap.Hull]:
    return hullmap.bake(rock(60, 1), name="a")[0], hullmap.bake(rock(40, 2), name="b")[0]


@pytest.fixture(scope="session")
def large() -> hullmap.Hull:
    return hullmap.bake(rock(5000, 3), name="large")[0]


@pytest.fixture(scope="session")
def truth(rocks):
    """Poses of the rocks, and their depths and distances by brute force."""
    a, b = rocks
    poses = random_poses(200, 5, 3.2)
    body = Body(a)
    depths = np.array([brute_depth(body, Body(b, pose)) for pose in poses])
    gaps = np.array([brute_distance(body, Body(b, pose)) for pose in poses])
    # Neither kind of pair is missing.
    assert 0.3 < (depths > 0).mean() < 0.7
    return poses, depths, gaps
