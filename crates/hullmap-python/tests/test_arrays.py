"""Hulls as arrays: views of the pack's memory, read-only, that keep it alive."""

from __future__ import annotations

import gc
import pickle
import weakref

import numpy as np
import pytest
from conftest import CUBE, Body, rock

import hullmap


def test_views_share_memory_and_are_read_only(large):
    for name in ("vertices", "source_vertices"):
        first, second = getattr(large, name), getattr(large, name)
        assert np.shares_memory(first, second) and not first.flags.owndata
        assert not first.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            first[0] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            first.flags.writeable = True
    for lists in (large.faces, large.neighbours):
        assert np.shares_memory(lists[3], lists.values) and not lists[3].flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            lists[0][0] = 1


@pytest.mark.parametrize("mmap", [True, False])
def test_views_keep_the_pack_alive(tmp_path, mmap):
    points = rock(5000, 3)
    path = hullmap.bake(points).save(tmp_path / "rock.hullmap")
    pack = hullmap.open(path, mmap=mmap)
    hull = pack[0]
    vertices, faces, expected = hull.vertices, hull.faces, hull.vertices.copy()
    corners = [face.copy() for face in faces]
    path.unlink()
    del pack, hull
    gc.collect()
    # Memory that a freed pack would have left is taken by others.
    filler = [np.full(5000, 7.0) for _ in range(200)]
    assert (vertices == expected).all() and all((face == copy).all() for face, copy in zip(faces, corners))
    del filler


def test_the_pack_is_freed_with_its_last_view():
    pack = hullmap.bake(rock(100, 1))
    native = pack._pack
    hull = pack[0]
    vertices = hull.vertices
    owner = weakref.ref(vertices)
    del pack, native, hull
    gc.collect()
    assert owner() is not None
    del vertices
    gc.collect()
    assert owner() is None


def test_faces_are_those_of_a_closed_convex_surface(large):
    body = Body(large)
    heights = body.points @ body.normals.T - (body.normals * body.triangles[:, 0]).sum(1)
    assert heights.max() < 1e-6
    edges = sum(len(near) for near in large.neighbours) // 2
    assert len(large) - edges + len(large.faces) == 2
    assert large.triangles.shape == (2 * len(large) - 4, 3)
    a, b, c = np.moveaxis(body.triangles, 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(large.volume, rel=1e-9)


def test_facts_of_a_cube(cube):
    assert (len(cube), len(cube.faces), cube.rank, cube.name, cube.index) == (8, 6, 3, "cube", 0)
    assert cube.volume == pytest.approx(8) and cube.surface_area == pytest.approx(24)
    assert np.allclose(cube.centroid, 0) and np.allclose(cube.bounds, [[-1] * 3, [1] * 3])
    assert np.allclose(cube.inertia, np.eye(3) * 8 * 8 / 12)
    properties = cube.mass_properties(1000)
    assert properties.mass == pytest.approx(8000) and np.allclose(properties.inertia, 1000 * cube.inertia)
    assert all(len(near) == 3 for near in cube.neighbours)
    assert (np.sort(cube.source_vertices) == np.arange(8)).all()
    assert (CUBE[cube.source_vertices] == cube.vertices).all()


def test_inertia_of_a_turned_box_has_products(cube):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    half = np.array([1.0, 2.0, 3.0])
    hull = hullmap.bake((CUBE * half) @ turn.T)[0]
    own = np.diag(8 * half.prod() / 3 * (half @ half - half**2))
    assert np.allclose(hull.inertia, turn @ own @ turn.T, rtol=1e-5, atol=1e-3)


def test_lists_behave_like_sequences(cube):
    faces = cube.faces
    assert faces[-1].tolist() == faces[5].tolist() and len(list(faces)) == 6
    assert [len(face) for face in faces[1:4]] == [4, 4, 4] and faces.lengths.tolist() == [4] * 6
    with pytest.raises(IndexError, match="6 is out of range: there are 6 lists"):
        faces[6]


def test_packs_behave_like_sequences():
    pack = hullmap.bake_parts([(CUBE, None), (CUBE + 5, None)], names=["a", "b"])
    assert pack[-1].name == "b" and pack["a"].index == 0 and [hull.name for hull in pack[:]] == ["a", "b"]
    assert "b" in pack and "c" not in pack and pack.names == ["a", "b"]
    assert pack[0] in pack and pack.index(pack[1]) == 1 and hullmap.bake(CUBE)[0] not in pack
    assert len({pack[0], pack["a"], pack[1]}) == 2
    with pytest.raises(IndexError, match="2 is out of range: the pack has 2 "):
        pack[2]
    with pytest.raises(KeyError, match=r"no hull has the name .*c.*: the pack has 2 "):
        pack["c"]


@pytest.mark.filterwarnings("ignore::hullmap.BakeWarning")
def test_flat_hulls_have_a_rank():
    square = hullmap.bake(CUBE[:4])[0]
    assert (square.rank, square.volume, len(square)) == (2, 0.0, 4) and square.surface_area == pytest.approx(8)
    assert hullmap.bake([[1, 2, 3]])[0].rank == 0
    segment = hullmap.bake([[0, 0, 0], [0, 0, 1], [0, 0, 2]])[0]
    assert segment.rank == 1 and segment.triangles.shape == (0, 3)


def test_packs_hulls_and_shapes_can_be_pickled(cube):
    pack = pickle.loads(pickle.dumps(cube.pack))
    assert pack.to_bytes() == cube.pack.to_bytes()
    hull = pickle.loads(pickle.dumps(cube))
    assert hull.name == "cube" and (hull.vertices == cube.vertices).all()
    for shape in (
        hullmap.Sphere(2.0), hullmap.Box([1, 2, 3]), hullmap.Capsule(1, 2), hullmap.Cylinder(1, 2), hullmap.Cone(1, 2),
        hullmap.Segment([0, 0, 0], [1, 0, 0]), hullmap.Triangle([0, 0, 0], [1, 0, 0], [0, 1, 0]), hullmap.HalfSpace([0, 0, 1], 2),
    ):  # fmt: skip
        assert repr(pickle.loads(pickle.dumps(shape))) == repr(shape)
