"""Height fields, against formulas in doubles and against the same surface as a triangle mesh."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import hullmap
from hullmap import HeightField, TriangleMesh

SEED = 40


@pytest.fixture(scope="module")
def field() -> HeightField:
    """Rough ground of 7 x 9 vertices, with two holes."""
    rng = np.random.default_rng(SEED)
    holes = np.zeros((6, 8), dtype=bool)
    holes[2, 3] = holes[5, 7] = True
    materials = np.arange(48).reshape(6, 8)
    return HeightField.from_array(rng.uniform(-0.3, 0.3, (7, 9)), (0.5, 2.0), holes, materials=materials)


def as_mesh(field: HeightField) -> TriangleMesh:
    solid = np.repeat(~field.holes.ravel(), 2)
    return TriangleMesh.from_arrays(field.vertices, field.triangles[solid])


def test_heights_and_rays_are_those_of_the_planes(field):
    rng = np.random.default_rng(SEED + 1)
    (low_x, low_y, _), (high_x, high_y, _) = field.bounds
    where = rng.uniform((low_x, low_y), (high_x, high_y), (300, 2))
    hit = field.ray(np.column_stack((where, np.full(300, 5.0))), [0, 0, -1])
    a, b, c = field.vertices[field.triangles[hit.part]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    # The height of the plane of the triangle at this place.
    plane = a[:, 2] - (normal[:, :2] * (where - a[:, :2])).sum(1) / normal[:, 2]
    cell = ((where - field.origin) // field.spacing).astype(int)
    in_hole = field.holes[cell[:, 1], cell[:, 0]]
    assert (hit.hit == ~in_hole).all() and in_hole.sum() > 3
    assert np.allclose(5.0 - hit.t[~in_hole], plane[~in_hole], atol=1e-9)
    assert (hit.part[~in_hole] // 2 == (cell[:, 1] * 8 + cell[:, 0])[~in_hole]).all()
    heights = field.heights_at(where)
    assert (np.isnan(heights) == in_hole).all() and np.allclose(heights[~in_hole], plane[~in_hole], atol=1e-9)
    assert np.isnan(field.heights_at([[99, 0], [0, np.nan]])).all() and field.heights_at([0.1, 0.1]).shape == ()
    assert not field.ray([[99, 9, 5]], [0, 0, -1]).hit.any()


def test_answers_are_those_of_the_same_mesh(field):
    mesh = as_mesh(field)
    rng = np.random.default_rng(SEED + 2)
    poses = hullmap.poses(rng.uniform((-2.5, -7, -1), (2.5, 7, 1), (200, 3)))
    box, cube = hullmap.Box([0.2, 0.3, 0.25]), hullmap.bake([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    for other in (box, cube, hullmap.Sphere(0.2)):
        found, expected = field.distance(other, poses), mesh.distance(other, poses)
        assert np.allclose(found.distance, expected.distance, rtol=1e-4, atol=1e-9)
        assert (field.intersects(other, poses).hit == mesh.intersects(other, poses).hit).all()
        assert np.allclose(field.contact(other, poses).depth, mesh.contact(other, poses).depth, rtol=1e-4, atol=1e-9)
    # The field may be the other shape, too.
    below = hullmap.poses([0, 0, -2])
    assert box.distance(field, below).distance == pytest.approx(float(box.distance(mesh, below).distance))
    above = hullmap.poses([0, 0, 3])
    assert hullmap.HalfSpace([0, 0, 1]).distance(field, above).distance == pytest.approx(3 + field.bounds[0, 2])
    cast = field.cast(box, above, [0, 0, -4])
    assert float(cast.t) == pytest.approx(float(mesh.cast(box, above, [0, 0, -4]).t), abs=1e-6)


def test_a_box_rests_on_flat_ground():
    floor = HeightField.from_array(np.zeros((3, 3)), 9.0, diagonal="falling")
    found = floor.manifolds(hullmap.Box([0.5, 0.5, 0.5]), hullmap.poses([0.1, 0, 0.499]), max_pairs=8)
    touching = found.count > 0
    assert int(found.touching) == touching.sum() > 1
    assert np.allclose(found.normal[touching], [0, 0, 1], atol=1e-9)


def test_arrays_describe_the_field(field):
    rng = np.random.default_rng(SEED)
    heights = rng.uniform(-0.3, 0.3, (7, 9)).astype(np.float32)
    # The last vertex touches a hole alone.
    heights[6, 8] = 0.0
    assert (field.heights == heights).all() and field.shape == (7, 9) and len(field) == 96
    assert (field.origin, field.spacing, field.diagonal) == ((-2.0, -6.0), (0.5, 2.0), "rising")
    vertices = field.vertices.reshape(7, 9, 3)
    assert (vertices[3, 5] == (0.5, 0.0, heights[3, 5])).all()
    assert field.holes.sum() == 2 and field.holes[2, 3] and field.holes[5, 7]
    expected = np.where(field.holes, 0, np.arange(48).reshape(6, 8))
    assert (field.materials == expected).all()
    counts = field.counts
    assert (counts["triangles"], counts["holes"]) == (92, 2)
    # The outline, less the two edges of the hole in its corner, and around both holes.
    assert counts["border"] == 2 * (6 + 8) - 2 + 2 + 4
    border, solid = HeightField.EDGE_CLASSES.index("border"), np.repeat(~field.holes.ravel(), 2)
    assert ((field.neighbours < 0) == (field.edge_classes == border))[solid].all()
    mesh = as_mesh(field)
    assert mesh.counts["border"] == counts["border"] and mesh.counts["concave"] == counts["concave"]
    assert field.bounds.shape == (2, 3) and repr(field).startswith("<HeightField of 7 x 9 vertices, ")
    assert (field.source_path, field.options, field.warnings, field.path) == ("", "", [], None)
    # A vertex without ground makes its cells holes.
    ragged = HeightField.from_array([[0, 0, 0], [0, 0, 0], [0, 0, np.nan]], origin=(1, 2))
    assert ragged.holes.tolist() == [[False, False], [False, True]] and ragged.origin == (1, 2)


def test_files_round_trip(field, tmp_path):
    path = field.save(tmp_path / "terrain.hullfield")
    opened = HeightField.open(path)
    assert type(hullmap.open(path)) is HeightField
    assert opened.path == path and opened.to_bytes() == field.to_bytes() and opened.nbytes == path.stat().st_size
    assert pickle.loads(pickle.dumps(field)).to_bytes() == field.to_bytes()
    with pytest.raises(hullmap.InvalidPack, match="not a hullmap triangle mesh"):
        TriangleMesh.from_bytes(field.to_bytes())
    with pytest.raises(hullmap.InvalidPack, match="not a hullmap height field"):
        HeightField.from_bytes(as_mesh(field).to_bytes())
    damaged = bytearray(field.to_bytes())
    damaged[200] ^= 1
    with pytest.raises(hullmap.InvalidPack, match="checksum"):
        HeightField.from_bytes(damaged)
    with pytest.raises(FileNotFoundError):
        HeightField.open(tmp_path / "gone.hullfield")


def test_the_command_writes_what_python_opens(tmp_path):
    heights = np.random.default_rng(SEED + 3).uniform(0, 1, (4, 5)).astype("<f4")
    heights.tofile(tmp_path / "terrain.f32")
    words = ["bake", "build", str(tmp_path / "terrain.f32"), "--terrain", "--out", str(tmp_path), "--quiet"]
    assert hullmap._hullmap.run_command([*words, "--set", "columns=5", "--set", "rows=4", "--set", "spacing=2"]) == 0
    opened = HeightField.open(tmp_path / "terrain.hullfield")
    assert (opened.heights == heights).all() and opened.spacing == (2.0, 2.0) and opened.source_path == "terrain.f32"


@pytest.mark.parametrize(
    ("heights", "more", "error", "words"),
    [
        ([0, 0], {}, hullmap.ArrayError, "heights: expected the shape"),
        ([[0, 0]], {}, hullmap.ArrayError, "heights: expected the shape"),
        ([[0, 0], [0]], {}, hullmap.ArrayError, "differ in length"),
        ([["a", "b"], ["c", "d"]], {}, hullmap.ArrayError, "real numbers"),
        ([[0, np.inf], [0, 0]], {}, hullmap.BakeError, "finite"),
        ([[0, np.nan], [0, 0]], {}, hullmap.BakeError, "hole"),
        ([[0, 0], [0, 0]], {"spacing": 0.0}, hullmap.BakeError, "spacing"),
        ([[0, 0], [0, 0]], {"spacing": (1, 2, 3)}, hullmap.ArrayError, "spacing"),
        ([[0, 0], [0, 0]], {"origin": (1,)}, hullmap.ArrayError, "origin: expected two numbers"),
        ([[0, 0], [0, 0]], {"holes": [[True, False]]}, hullmap.ArrayError, "holes: expected the shape"),
        ([[0, 0], [0, 0]], {"holes": [[0]]}, hullmap.ArrayError, "array of bool"),
        ([[0, 0], [0, 0]], {"materials": [[70_000]]}, hullmap.ArrayError, "65535"),
        ([[0, 0], [0, 0]], {"materials": [0]}, hullmap.ArrayError, "materials: expected the shape"),
        ([[0, 0], [0, 0]], {"diagonal": "up"}, hullmap.ArrayError, "rising"),
    ],
)
def test_wrong_arrays_are_errors(heights, more, error, words):
    with pytest.raises(error, match=words):
        HeightField.from_array(heights, **more)


def test_queries_without_an_answer_are_errors(field):
    with pytest.raises(hullmap.ShapeError, match="signed_distance takes a shape with an inside, found a height field"):
        field.signed_distance([0, 0, 1])
    with pytest.raises(hullmap.ShapeError, match="height field"):
        hullmap.Box([1, 1, 1]).manifold(field, hullmap.poses([0, 0, 1]))
    above, below = hullmap.poses([0, 0, 1]), hullmap.poses([0, 0, -1])
    plane = hullmap.HalfSpace([0, 0, 1])
    assert field.distance(plane, above).distance == plane.distance(field, below).distance
