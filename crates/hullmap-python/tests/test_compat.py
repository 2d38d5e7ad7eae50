"""`hullmap.compat`: the interface of CoACD, against CoACD itself where it is installed."""

from __future__ import annotations

import inspect
import logging
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import CUBE, rock, torus

import hullmap
from hullmap.compat import coacd

#: Triangles of `CUBE`.
CUBE_FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
])  # fmt: skip


def ring(scale=1.0, shift=(0.0, 0.0, 0.0)):
    """A torus of triangles; the box around it is 2.7 wide."""
    vertices, quads = torus(18, 6)
    return coacd.Mesh(vertices * scale + np.array(shift), np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]])))


def volume(vertices, faces):
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def outside(parts, points):
    """The greatest distance of a point from the planes of the part that it is deepest in."""
    best = np.full(len(points), np.inf)
    for vertices, faces in parts:
        a, b, c = np.moveaxis(vertices[faces], 1, 0)
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1)
        normals = normals[lengths > 0] / lengths[lengths > 0, None]
        heights = points @ normals.T - np.einsum("ij,ij->i", normals, a[lengths > 0])
        best = np.minimum(best, heights.max(axis=1))
    return float(best.max())


def test_parts_cover_the_mesh_in_its_own_frame():
    mesh = ring(scale=1e-3, shift=(5.0, -7.0, 1.0))
    parts = coacd.run_coacd(mesh)
    assert isinstance(parts, list) and len(parts) > 3
    for part in parts:
        assert isinstance(part, list) and len(part) == 2
        vertices, faces = part
        assert vertices.dtype == np.float64 and vertices.shape[1] == 3 and 4 <= len(vertices) <= 64
        assert faces.dtype == np.int32 and faces.shape[1] == 3 and faces.min() == 0 and faces.max() == len(vertices) - 1
        assert volume(vertices - vertices[0], faces) > 0, "faces are counter-clockwise seen from outside"
    # Vertices and points inside of triangles; 32-bit floats relative to the centre have 2^-24.
    inside = mesh.vertices[mesh.indices].mean(axis=1)
    assert outside(parts, np.concatenate((mesh.vertices, inside))) < 2.72e-3 * 2e-7


def test_a_threshold_is_a_share_of_half_the_longest_side():
    mesh = ring()
    half = np.ptp(mesh.vertices, axis=0).max() / 2
    for threshold in (0.08, 0.4):
        ours = coacd.run_coacd(mesh, threshold=threshold)
        same = coacd.run_coacd(mesh, threshold=threshold * half, real_metric=True)
        pack = hullmap.bake(mesh.vertices, mesh.indices, decompose=True, max_error=threshold * half, recentre=True)
        assert len(ours) == len(same) == len(pack)
        assert max(hull.protrusion for hull in pack) <= threshold * half * (1 + 1e-6)
        for part, again, hull in zip(ours, same, pack):
            assert np.array_equal(part[0], again[0]) and np.array_equal(part[0], hull.vertices + hull.origin)
    few, many = (len(coacd.run_coacd(mesh, threshold=threshold)) for threshold in (0.4, 0.08))
    assert few < many


def test_parts_can_be_boxes():
    mesh = ring(shift=(5.0, -7.0, 1.0))
    hulls, boxes = coacd.run_coacd(mesh), coacd.run_coacd(mesh, apx_mode="box")
    assert len(boxes) == len(hulls) > 3
    for hull, (vertices, faces) in zip(hulls, boxes):
        assert vertices.shape == (8, 3) and faces.shape == (12, 3) and faces.dtype == np.int32
        sides = vertices[[1, 2, 4]] - vertices[0]
        assert np.allclose(sides @ sides.T, np.diag((sides**2).sum(axis=1)))
        size = volume(vertices - vertices[0], faces)
        assert size == pytest.approx(np.prod(np.linalg.norm(sides, axis=1))), "faces seen from outside"
        assert outside([[vertices, faces]], hull[0]) < 1e-9
        # No larger than the box along the axes of any triangle of the hull.
        for a, b, c in hull[0][hull[1]]:
            frame, _ = np.linalg.qr(np.stack([b - a, c - a], axis=1), mode="complete")
            assert size <= np.prod(np.ptp(hull[0] @ frame, axis=0)) * (1 + 1e-9)


def test_numbers_of_parts_and_vertices_are_limited():
    mesh = ring()
    assert len(coacd.run_coacd(mesh, max_convex_hull=3)) <= 3
    small = coacd.run_coacd(mesh, decimate=True, max_ch_vertex=12)
    assert max(len(vertices) for vertices, _ in small) <= 12
    assert outside(small, mesh.vertices) < 1e-6
    assert len(coacd.run_coacd(coacd.Mesh(CUBE, CUBE_FACES))) == 1
    # A convex mesh, too.
    hull = hullmap.bake(rock(500, 1))[0]
    ball = coacd.Mesh(hull.vertices, hull.triangles)
    (whole,), (small,) = coacd.run_coacd(ball), coacd.run_coacd(ball, decimate=True, max_ch_vertex=20)
    assert len(whole[0]) == len(hull) > 20 >= len(small[0])
    assert outside([small], ball.vertices) < 1e-6


#: Values that are not the defaults of arguments without effect.
WITHOUT_EFFECT = dict(
    preprocess_mode="on", preprocess_resolution=30, resolution=1000, mcts_nodes=10, mcts_iterations=60,
    mcts_max_depth=2, pca=1, merge=False, extrude=True, seed=7,
)  # fmt: skip


def warnings_of(mesh, **arguments):
    """The warnings of a call, and its parts."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parts = coacd.run_coacd(mesh, **arguments)
    assert all(warning.category is hullmap.BakeWarning for warning in caught)
    return [str(warning.message) for warning in caught], parts


def test_arguments_without_effect_are_named_once(monkeypatch):
    monkeypatch.setattr(coacd, "_WARNED", set())
    mesh = coacd.Mesh(CUBE, CUBE_FACES)
    none, ((expected, _),) = warnings_of(mesh)
    assert none == []
    for argument, value in WITHOUT_EFFECT.items():
        (text,), ((vertices, _),) = warnings_of(mesh, **{argument: value})
        assert text.startswith(f"arguments without effect: {argument} ("), text
        assert np.array_equal(vertices, expected)
        assert warnings_of(mesh, **{argument: value})[0] == [], "once"
    assert warnings_of(mesh, **WITHOUT_EFFECT)[0] == []
    for argument in inspect.signature(coacd.run_coacd).parameters:
        assert f"``{argument}" in coacd.run_coacd.__doc__ or argument == "mesh", argument


def test_a_call_names_its_arguments_without_effect_in_one_warning(monkeypatch):
    monkeypatch.setattr(coacd, "_WARNED", set())
    mesh = coacd.Mesh(CUBE, CUBE_FACES)
    with pytest.warns(hullmap.BakeWarning) as caught:
        coacd.run_coacd(mesh, seed=7)
    assert caught[0].filename == __file__, "the line of the call"
    (text,), _ = warnings_of(mesh, **WITHOUT_EFFECT, extrude_margin=0.02)
    assert all(argument in text for argument in (*WITHOUT_EFFECT, "extrude_margin") if argument != "seed")
    assert "seed" not in text, "it was named before"


def test_values_that_ask_for_nothing_else_are_no_warning(monkeypatch):
    monkeypatch.setattr(coacd, "_WARNED", set())
    mesh = coacd.Mesh(CUBE, CUBE_FACES)
    defaults = {name: own.default for name, own in inspect.signature(coacd.run_coacd).parameters.items() if name != "mesh"}
    assert warnings_of(mesh, **defaults)[0] == []
    # As numbers of other types.
    same = dict(pca=0, merge=np.True_, seed=np.int64(0), mcts_nodes=np.int32(20), threshold=np.float32(0.05))
    assert warnings_of(mesh, **same)[0] == []
    # Meshes are never remeshed. CoACD, too, ignores these two without decimate and extrude.
    assert warnings_of(mesh, preprocess_mode="off", max_ch_vertex=64, extrude_margin=0.02)[0] == []


def test_forms_of_a_mesh():
    mesh = ring()
    expected = coacd.run_coacd(mesh)
    empty, lists = coacd.Mesh(), coacd.Mesh()
    empty.vertices, empty.indices = mesh.vertices, mesh.indices.astype(np.int64)
    lists.vertices, lists.indices = mesh.vertices.tolist(), mesh.indices.tolist()
    named = coacd.Mesh(vertices=np.asfortranarray(mesh.vertices), indices=mesh.indices.astype(np.uint64))
    for form in (empty, lists, named):
        for part, own in zip(coacd.run_coacd(mesh=form), expected):
            assert np.array_equal(part[0], own[0]) and np.array_equal(part[1], own[1])
    floats = coacd.Mesh(mesh.vertices.astype(np.float32), mesh.indices.astype(np.uint32))
    assert floats.vertices.dtype == np.float64 and floats.indices.dtype == np.int32
    assert len(coacd.run_coacd(floats, 0.05, -1, "auto", 50, 2000, 20, 150, 3, False, True, False, 256)) > 3


def test_options_of_scripts(monkeypatch):
    monkeypatch.setattr(coacd, "_WARNED", set())
    mesh = ring()
    expected = coacd.run_coacd(mesh)
    # A table of options, with words that CoACD takes as "auto".
    table = dict(threshold=0.05, max_convex_hull=-1, mcts_iterations=100, pca=True, merge=False, extrude=True, extrude_margin=0.1)
    for mode in ("on", "off", "auto", "none", True):
        parts = warnings_of(mesh, preprocess_mode=mode, **table)[1]
        assert len(parts) == len(expected) and all(np.array_equal(part[0], own[0]) for part, own in zip(parts, expected))
    for limit in (1, 4):
        _, parts = warnings_of(mesh, max_convex_hull=np.int64(limit), merge=False)
        assert len(parts) <= limit
    # A maximum is not used up.
    for limit in (0, len(expected), 100):
        assert len(coacd.run_coacd(mesh, max_convex_hull=limit)) == len(expected)
    # Threads share the module.
    with ThreadPoolExecutor(3) as pool:
        counts = set(pool.map(lambda threshold: len(coacd.run_coacd(mesh, threshold=threshold)), [0.05] * 3))
    assert counts == {len(expected)}


def test_parts_can_be_changed_and_pickled():
    parts = coacd.run_coacd(ring())
    for (vertices, faces), (same, _) in zip(parts, pickle.loads(pickle.dumps(parts))):
        assert np.array_equal(vertices, same)
        vertices *= 1.005
        faces += 1


def test_parts_are_meshes_of_trimesh():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    vertices, faces = torus(18, 6)
    source = trimesh.Trimesh(vertices, np.concatenate((faces[:, [0, 1, 2]], faces[:, [0, 2, 3]])))
    parts = [trimesh.Trimesh(vs, fs) for vs, fs in coacd.run_coacd(coacd.Mesh(source.vertices, source.faces))]
    assert all(part.is_volume and part.volume > 0 for part in parts)
    assert np.allclose(trimesh.util.concatenate(parts).bounds, source.bounds, atol=0.05 * 2.7 / 2)
    scene = trimesh.Scene(parts)
    assert len(scene.export(file_type="glb")) > 0 and len(scene.export(file_type="obj")) > 0


def test_wrong_arguments_are_errors():
    mesh = coacd.Mesh(CUBE, CUBE_FACES)
    for threshold in (0, -1.0, float("nan"), float("inf")):
        with pytest.raises(hullmap.BakeError, match="threshold"):
            coacd.run_coacd(mesh, threshold=threshold)
    with pytest.raises(hullmap.BakeError, match="apx_mode"):
        coacd.run_coacd(mesh, apx_mode="sphere")
    with pytest.raises(hullmap.BakeError, match="max_ch_vertex"):
        coacd.run_coacd(mesh, decimate=True, max_ch_vertex=3)
    with pytest.raises(hullmap.ArrayError, match="vertices"):
        coacd.Mesh(np.zeros((4, 2)), CUBE_FACES)
    with pytest.raises(hullmap.ArrayError, match="indices"):
        coacd.Mesh(CUBE, np.zeros((4, 4)))
    with pytest.raises(hullmap.ArrayError, match="empty"):
        coacd.run_coacd(coacd.Mesh())
    with pytest.raises(hullmap.Error):
        coacd.run_coacd(coacd.Mesh(CUBE, [[0, 1, 8]]))


def test_levels_of_the_log(caplog):
    level = logging.getLogger("hullmap.compat.coacd").level
    try:
        coacd.set_log_level("info")
        coacd.run_coacd(ring())
        assert any("parts" in record.getMessage() for record in caplog.records)
        caplog.clear()
        coacd.set_log_level("off")
        coacd.run_coacd(ring())
        assert not caplog.records
        for name in ("critical", "error", "err", "warn", "warning", "debug"):
            coacd.set_log_level(name)
        with pytest.raises(ValueError, match="loud"):
            coacd.set_log_level("loud")
    finally:
        logging.getLogger("hullmap.compat.coacd").setLevel(level)


def test_the_interface_is_that_of_coacd():
    real = pytest.importorskip("coacd", reason="coacd is not installed")
    ours, theirs = (inspect.signature(module.run_coacd).parameters.values() for module in (coacd, real))
    assert [(own.name, own.default) for own in ours] == [(own.name, own.default) for own in theirs]
    mesh = ring()
    peer = real.Mesh(mesh.vertices, mesh.indices)
    for name in ("vertices", "indices"):
        assert getattr(peer, name).dtype == getattr(mesh, name).dtype
    real.set_log_level("off")
    for options in ({}, {"max_convex_hull": 4}, {"threshold": 0.1, "decimate": True, "max_ch_vertex": 20}):
        found, other = coacd.run_coacd(mesh, **options), real.run_coacd(peer, **options)
        for parts in (found, other):
            assert type(parts) is list and parts and {type(part) for part in parts} == {list}
            assert {(vertices.dtype, vertices.ndim, faces.dtype, faces.ndim) for vertices, faces in parts} == {
                (np.dtype(np.float64), 2, np.dtype(np.int32), 2)
            }
            assert all(volume(vertices - vertices[0], faces) > 0 for vertices, faces in parts)
        assert outside(found, mesh.vertices) < 1e-6
    # Their meshes are accepted, too.
    assert len(coacd.run_coacd(peer)) == len(coacd.run_coacd(mesh))
