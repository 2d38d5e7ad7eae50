"""Triangle meshes, against brute force over all triangles in doubles."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import hullmap
from hullmap import TriangleMesh

SEED = 39


def ground(cells: int = 6):
    """A rough floor: vertices, and two triangles a square, with fronts upwards."""
    rng = np.random.default_rng(SEED)
    side = cells + 1
    x, y = np.meshgrid(np.arange(side) - cells / 2, np.arange(side) - cells / 2)
    vertices = np.stack((x.ravel(), y.ravel(), rng.uniform(-0.3, 0.3, side * side)), axis=1)
    first = (np.arange(cells)[:, None] * side + np.arange(cells)).ravel()
    a, b, c, d = first, first + 1, first + side + 1, first + side
    return vertices, np.concatenate((np.stack((a, b, c), axis=1), np.stack((a, c, d), axis=1)))


@pytest.fixture(scope="module")
def mesh() -> TriangleMesh:
    vertices, triangles = ground()
    return TriangleMesh.from_arrays(vertices, triangles, np.arange(len(triangles)))


def nearest(triangle: np.ndarray, p: np.ndarray) -> float:
    """Distance of a point from a triangle: to its plane if it is above the inside, or to an edge."""
    a, b, c = triangle
    normal = np.cross(b - a, c - a)
    sides = [np.dot(np.cross(to - start, p - start), normal) for start, to in ((a, b), (b, c), (c, a))]
    if min(sides) >= 0:
        return float(abs(np.dot(normal, p - a)) / np.linalg.norm(normal))
    gaps = []
    for start, to in ((a, b), (b, c), (c, a)):
        t = np.clip(np.dot(p - start, to - start) / np.dot(to - start, to - start), 0, 1)
        gaps.append(np.linalg.norm(start + t * (to - start) - p))
    return float(min(gaps))


def test_distances_are_those_of_brute_force(mesh):
    print("seed", SEED)
    points = np.random.default_rng(SEED).uniform(-4, 4, (200, 3))
    corners = mesh.vertices.astype(float)[mesh.triangles]
    truth = np.array([[nearest(triangle, p) for triangle in corners] for p in points])
    found = mesh.distance(hullmap.Sphere(0.0), hullmap.poses(points))
    assert (found.lower <= truth.min(1) + 1e-12).all() and (truth.min(1) <= found.upper + 1e-12).all()
    # The triangle that is named is a nearest one.
    named = truth[np.arange(len(points)), found.parts[:, 0]]
    assert np.allclose(named, truth.min(1), rtol=1e-5, atol=1e-12)


def test_rays_hit_the_triangle_below(mesh):
    where = np.random.default_rng(SEED + 1).uniform(-2.9, 2.9, (200, 2))
    hit = mesh.ray(np.column_stack((where, np.full(200, 5.0))), [0, 0, -1])
    assert hit.hit.all()
    corners = mesh.vertices.astype(float)[mesh.triangles[hit.part]]
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    # The height of the plane of the triangle at this place.
    height = a[:, 2] - (normal[:, :2] * (where - a[:, :2])).sum(1) / normal[:, 2]
    assert np.allclose(5.0 - hit.t, height, atol=1e-9)
    assert not mesh.ray([[9, 9, 5]], [0, 0, -1]).hit.any()


def test_a_box_rests_on_a_flat_floor():
    floor = TriangleMesh.from_arrays([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    box = hullmap.Box([0.5, 0.5, 0.5])
    found = floor.manifolds(box, hullmap.poses([0.1, 0, 0.499]), max_pairs=4)
    assert int(found.touching) == 2
    touching = found.count > 0
    assert np.allclose(found.normal[touching], [0, 0, 1], atol=1e-9)
    assert floor.contact(box, hullmap.poses([0.1, 0, 0.499])).depth == pytest.approx(1e-3)
    assert floor.intersects(box, hullmap.poses([[0, 0, 0.4], [0, 0, 0.6]])).hit.tolist() == [True, False]
    assert float(floor.cast(box, hullmap.poses([0, 0, 2.5]), [0, 0, -4]).t) == pytest.approx(0.5)
    # The mesh may be the other shape, and either side a pack, a mesh or a half-space.
    cube = hullmap.bake([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    below = hullmap.poses([0, 0, -2])
    assert box.distance(floor, below).distance == pytest.approx(1.5)
    assert cube.distance(floor, below).distance == floor.distance(cube, hullmap.poses([0, 0, 2])).distance == 2
    assert floor.distance(floor, hullmap.poses([0, 0, 3])).distance == 3
    assert hullmap.HalfSpace([0, 0, 1]).distance(floor, hullmap.poses([0, 0, 3])).distance == 3


def test_arrays_describe_the_mesh(mesh):
    vertices, triangles = ground()
    order = mesh.source_triangles
    assert (np.sort(order) == np.arange(len(triangles))).all() and (mesh.materials == order).all()
    assert (mesh.vertices[mesh.triangles] == vertices.astype(np.float32)[triangles[order]]).all()
    counts = mesh.counts
    assert counts["triangles"] == len(mesh) == 72 and counts["vertices"] == 49 and counts["border"] == 24
    assert (mesh.neighbours >= 0).sum() == 3 * 72 - 24
    border = TriangleMesh.EDGE_CLASSES.index("border")
    assert ((mesh.neighbours < 0) == (mesh.edge_classes == border)).all()
    assert mesh.vertex_classes.shape == (49,) and mesh.bounds.shape == (2, 3)
    assert repr(mesh).startswith("<TriangleMesh of 72 triangles, ")
    assert (mesh.source_path, mesh.options, mesh.warnings, mesh.path) == ("", "", [], None)


def test_files_round_trip(mesh, tmp_path):
    path = mesh.save(tmp_path / "level.hullmesh")
    opened = TriangleMesh.open(path)
    assert opened.path == path and opened.to_bytes() == mesh.to_bytes() and opened.nbytes == path.stat().st_size
    assert TriangleMesh.from_bytes(mesh.to_bytes()).counts == mesh.counts
    assert pickle.loads(pickle.dumps(mesh)).to_bytes() == mesh.to_bytes()
    assert type(hullmap.open(path)) is TriangleMesh
    pack = hullmap.bake([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(hullmap.InvalidPack, match="not a hullmap triangle mesh"):
        TriangleMesh.from_bytes(pack.to_bytes())
    damaged = bytearray(mesh.to_bytes())
    damaged[200] ^= 1
    with pytest.raises(hullmap.InvalidPack, match="checksum"):
        TriangleMesh.from_bytes(damaged)
    with pytest.raises(FileNotFoundError):
        TriangleMesh.open(tmp_path / "gone.hullmesh")


def test_the_command_writes_what_python_opens(tmp_path):
    vertices, triangles = ground()
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in vertices.astype(np.float32))
    text += "usemtl rock\n" + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles)
    (tmp_path / "level.obj").write_text(text)
    words = ["bake", "build", str(tmp_path / "level.obj"), "--out", str(tmp_path), "--keep-triangles", "--quiet"]
    assert hullmap._hullmap.run_command(words) == 0
    opened = TriangleMesh.open(tmp_path / "level.hullmesh")
    assert (opened.materials == 1).all() and opened.counts["triangles"] == 72
    assert opened.options.endswith("keep_triangles true")


@pytest.mark.parametrize(
    ("vertices", "triangles", "materials", "error", "words"),
    [
        ([[0, 0]], [[0, 0, 0]], None, hullmap.ArrayError, "vertices: expected the shape"),
        ([[0, 0, 0]], [[0, 0]], None, hullmap.ArrayError, "triangles: expected the shape"),
        ([[0, 0, 0]], [[0.0, 0.0, 0.0]], None, hullmap.ArrayError, "whole numbers"),
        ([[0, 0, 0]], [[0, 0, -1]], None, hullmap.ArrayError, "out of range"),
        ([[0, 0, 0]], [[0, 0, 1]], None, hullmap.BakeError, "1"),
        ([[0, 0, np.nan]], [[0, 0, 0]], None, hullmap.BakeError, "not finite"),
        ([[0, 0, 1e300]], [[0, 0, 0]], None, hullmap.BakeError, "not finite"),
        ([[0, 0, 0]], [[0, 0, 0]], [1, 2], hullmap.BakeError, "2"),
        ([[0, 0, 0]], [[0, 0, 0]], [70_000], hullmap.ArrayError, "65535"),
        ([[0, 0, 0]], [[0, 0, 0]], [0.5], hullmap.ArrayError, "whole number"),
    ],
)
def test_wrong_arrays_are_errors(vertices, triangles, materials, error, words):
    with pytest.raises(error, match=words):
        TriangleMesh.from_arrays(vertices, triangles, materials)


def test_queries_without_an_answer_are_errors(mesh):
    with pytest.raises(hullmap.ShapeError, match="signed_distance takes a shape with an inside"):
        mesh.signed_distance([0, 0, 1])
    with pytest.raises(hullmap.ShapeError, match="triangle mesh"):
        hullmap.Box([1, 1, 1]).manifold(mesh, hullmap.poses([0, 0, 1]))
    above, below = hullmap.poses([0, 0, 1]), hullmap.poses([0, 0, -1])
    plane = hullmap.HalfSpace([0, 0, 1])
    assert mesh.distance(plane, above).distance == plane.distance(mesh, below).distance
