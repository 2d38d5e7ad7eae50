"""Input of any type and layout is accepted; wrong input is an exception with cause and remedy."""

from __future__ import annotations

import os

import numpy as np
import pytest
from conftest import CUBE, matrices, random_poses

import hullmap
from hullmap import ArrayError, BakeError, Error, InvalidPack, PoseError, ShapeError


def test_types_and_layouts_do_not_matter(cube):
    poses = random_poses(64, 3, 4)
    expected = cube.distance(cube, poses).distance
    wide = np.zeros((64, 14))
    wide[:, ::2] = poses
    for form in (
        poses.tolist(), np.asfortranarray(poses), wide[:, ::2], poses[::-1][::-1], poses.astype(">f8"),
        poses.astype(np.longdouble), np.asarray(poses).view(np.ndarray), memoryview(poses),
    ):  # fmt: skip
        assert np.array_equal(cube.distance(cube, form).distance, expected)
    single = cube.distance(cube, poses.astype(np.float32)).distance
    assert np.allclose(single, expected, atol=1e-5)
    assert np.allclose(cube.distance(cube, poses.astype(np.float16)).distance, expected, atol=0.02)
    turned = np.asfortranarray(matrices(poses))
    assert np.allclose(cube.distance(cube, turned).distance, expected, rtol=1e-6, atol=1e-9)
    assert cube.distance(cube, [[3, 0, 0, 0, 0, 0, 1]]).distance.tolist() == [1.0]
    readonly = poses.copy()
    readonly.flags.writeable = False
    assert np.array_equal(cube.distance(cube, readonly).distance, expected)


def test_misaligned_arrays_are_copied(cube):
    """They raised an error about contiguity."""

    def misaligned(array):
        buffer = bytearray(array.nbytes + 1)
        moved = np.frombuffer(buffer, array.dtype, array.size, offset=1).reshape(array.shape)
        moved[...] = array
        assert not moved.flags.aligned and moved.flags.c_contiguous
        return moved

    poses = random_poses(64, 3, 4)
    expected = cube.distance(cube, poses).distance
    assert np.array_equal(cube.distance(cube, misaligned(poses)).distance, expected)
    record = np.zeros(64, [("flag", "i1"), ("pose", "f8", 7)])
    record["pose"] = poses
    assert np.array_equal(cube.distance(cube, record["pose"]).distance, expected)
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5]], np.uint32)
    assert hullmap.bake(misaligned(CUBE), misaligned(faces)).to_bytes() == hullmap.bake(CUBE, faces).to_bytes()
    assert cube.support(misaligned(CUBE)).point.tolist() == cube.support(CUBE).point.tolist()


def test_meshes_of_any_type_bake_to_the_same_bytes():
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    expected = hullmap.bake(CUBE, faces).to_bytes()
    for vertices, corners in (
        (CUBE.astype(np.float32), faces.astype(np.uint8)),
        (np.asfortranarray(CUBE), np.asfortranarray(faces)),
        (CUBE.astype(np.int8), faces.tolist()),
        (CUBE.tolist(), [tuple(face) for face in faces]),
        (CUBE, [*faces[:5].tolist(), [1, 5, 7], [1, 7, 3]]),
    ):
        assert hullmap.bake(vertices, corners).to_bytes() == expected
    # Points have the same hull, but no mesh whose mass could be recorded.
    points = hullmap.bake(CUBE)
    assert points.to_bytes() != expected and points.mass_properties().source == "hulls"
    assert (points[0].vertices == hullmap.bake(CUBE, faces)[0].vertices).all()
    # A vertex that no face references is left out, unless all are requested.
    more = np.concatenate((CUBE, [[9, 9, 9]]))
    assert hullmap.bake(more, faces).to_bytes() == expected
    assert hullmap.bake(more, faces, vertices="all")[0].bounds.max() == 9


@pytest.mark.parametrize(
    ("poses", "error", "words"),
    [
        ([1, 2, 3], ArrayError, r"b_in_a: expected the shape \(\.\.\., 7\)"),
        ([], ArrayError, r"b_in_a: expected the shape"),
        (5.0, ArrayError, r"b_in_a: expected the shape"),
        (np.zeros((3, 3)), ArrayError, r"found \(3, 3\): hullmap.poses makes such rows"),
        ([[0] * 7, [0] * 6], ArrayError, "the rows differ in length"),
        (["a"] * 7, ArrayError, "expected an array of real numbers"),
        (np.zeros(7, complex), ArrayError, "expected an array of real numbers"),
        ([None] * 7, ArrayError, "expected an array of real numbers"),
        ([np.nan, 0, 0, 0, 0, 0, 1], PoseError, r"b_in_a\[0\]: translation must be finite"),
        ([0, 0, 0, 0, np.inf, 0, 1], PoseError, r"b_in_a\[0\]: rotation must be finite"),
        ([[0, 0, 0, 0, 0, 0, 1], [0] * 7], PoseError, r"b_in_a\[1\]: rotation must not be the zero quaternion"),
        ([0, 0, 0, 1, 1, 0, 0], PoseError, "must be a unit quaternion in the order x y z w.*normalise it, or check the order"),
        (np.diag([2.0, 2.0, 2.0, 1.0]), PoseError, "matrix must be a rotation and a translation"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), PoseError, "mirrors"),
        (np.full((4, 4), np.nan), PoseError, "matrix must be a rotation"),
        ([1e39, 0, 0, 0, 0, 0, 1], PoseError, "translation must be finite and within"),
    ],
)
def test_wrong_poses_are_rejected(cube, poses, error, words):
    with pytest.raises(error, match=words):
        cube.distance(cube, poses)
    assert issubclass(error, Error) and issubclass(Error, ValueError)


def test_the_first_wrong_pose_is_named(cube):
    poses = random_poses(5000, 1, 3)
    poses[[1234, 3000, 4999], 4] = np.nan
    for threads in (1, 2):
        with pytest.raises(PoseError, match=r"b_in_a\[1234\]"):
            cube.distance(cube, poses, threads=threads)


def test_wrong_arguments_of_queries_are_rejected(cube):
    poses = random_poses(3, 1, 3)
    with pytest.raises(ArrayError, match="pass either b_in_a, or both"):
        cube.distance(cube)
    with pytest.raises(ArrayError, match="pass either b_in_a, or both"):
        cube.distance(cube, poses, a_in_world=poses)
    with pytest.raises(ArrayError, match="a_in_world has 3 poses and b_in_world has 2"):
        cube.distance(cube, a_in_world=poses, b_in_world=poses[:2])
    with pytest.raises(ArrayError, match="expected a shape of hullmap, found ndarray: hullmap.bake makes one"):
        cube.distance(CUBE, poses)
    for threads in (0, 5000, -1, 2**70, 1.5, "all"):
        with pytest.raises(Error, match=f"threads must be a whole number from 1 to 1024, or None for all processors, found {threads!r}"):
            cube.distance(cube, poses, threads=threads)
        with pytest.raises(Error, match="threads must be a whole number"):
            hullmap.bake(CUBE, threads=threads)
    with pytest.raises(ArrayError, match="max_iterations must be a whole number from 0"):
        cube.distance(cube, poses, max_iterations=-1)
    with pytest.raises(ArrayError, match=r"directions\[1\]: a direction must be finite and not zero"):
        cube.support([[1, 0, 0], [0, 0, 0]])
    with pytest.raises(ArrayError, match=r"ray 0: direction must be finite"):
        cube.ray([0, 0, 0], [np.nan, 0, 0])
    with pytest.raises(ArrayError, match="directions has 3 rows, expected 2"):
        cube.ray(np.zeros((2, 3)), np.ones((3, 3)))
    with pytest.raises(ArrayError, match=r"points\[0\]: point must be finite"):
        cube.signed_distance([np.inf, 0, 0])
    with pytest.raises(PoseError, match=r"velocity\[0\]: velocity must be finite"):
        cube.cast(cube, poses[0], [np.nan, 0, 0])


@pytest.mark.parametrize("number", [float("nan"), -1e-9, float("-inf"), None, "small"])
def test_a_tolerance_of_nan_was_taken_for_0(cube, number):
    poses, floor = random_poses(3, 1, 3), hullmap.HalfSpace([0, 0, 1], 0.0)
    for query, name, more in (
        (cube.distance, "tolerance", [cube, poses]), (cube.contact, "tolerance", [cube, poses]),
        (cube.manifold, "tolerance", [cube, poses]), (cube.manifolds, "tolerance", [cube, poses]),
        (cube.cast, "tolerance", [cube, poses]), (cube.cast, "max_t", [cube, poses]),
        (cube.ray, "tolerance", [[0, 0, 5], [0, 0, -1]]), (cube.ray, "max_t", [[0, 0, 5], [0, 0, -1]]),
        (cube.signed_distance, "tolerance", [[0, 0, 5]]), (floor.contact, "tolerance", [cube, poses]),
        (hullmap.Pairs([cube], [0], [0]).contact, "tolerance", [poses[:1]]),
    ):  # fmt: skip
        with pytest.raises(ArrayError, match=f"{name} must be a number of at least 0, found "):
            query(*more, **{name: number})
    if number is not None:
        with pytest.raises(ArrayError, match="prediction must be a number of at least 0"):
            cube.manifold(cube, poses, prediction=number)
    assert cube.ray([0, 0, 5], [0, 0, -1], max_t=float("inf"), tolerance=0).t == pytest.approx(4)


def test_wrong_shapes_are_rejected():
    with pytest.raises(ShapeError, match="radius must be from 0 to 3.4e38, found -1: check where the value comes from"):
        hullmap.Sphere(-1.0)
    with pytest.raises(ShapeError, match="normal must be finite and not zero"):
        hullmap.HalfSpace([0, 0, 0])
    with pytest.raises(ArrayError, match="half_edges: expected three numbers"):
        hullmap.Box([1, 2])


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "words"),
    [
        (np.zeros((0, 3)), None, ArrayError, "vertices: the array is empty"),
        ([], None, ArrayError, r"vertices: expected the shape \(V, 3\), found \(0,\)"),
        (np.zeros((4, 2)), None, ArrayError, r"found \(4, 2\): pass rows of x, y, z"),
        ([[0, 0, np.nan]], None, BakeError, r"mesh: vertex 0 is \(0, 0, NaN\)"),
        ([[0, 0, 1e300]], None, BakeError, "too large for 32-bit floats"),
        (CUBE, [[0, 1, 8]], BakeError, "face 0 references vertex 8, but there are 8 vertices, counted from 0"),
        (CUBE, [[0, 1, -1]], ArrayError, "faces: index -1 is out of range"),
        (CUBE, [[0, 1, 2**40]], ArrayError, "faces: index 1099511627776 is out of range"),
        (CUBE, [[0.5, 1, 2]], ArrayError, "faces: expected whole numbers, found float64"),
        (CUBE, np.zeros((2, 2, 2), int), ArrayError, r"faces: expected the shape \(F, 3\)"),
    ],
)
def test_wrong_meshes_are_rejected(vertices, faces, error, words):
    with pytest.raises(error, match=words):
        hullmap.bake(vertices, faces)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"indx": "tree"}, "unknown option indx; did you mean index?"),
        ({"index": "oak"}, "invalid value oak of option index: expected one of tree"),
        ({"max_vertices": 3}, "expected a whole number of at least 4, or none"),
        ({"max_vertices": 2.5}, "invalid value 2.5 of option max_vertices"),
        ({"max_error": float("nan")}, "invalid value nan of option max_error"),
        ({"max_error": 0.1, "max_vertices": 8}, "max_error and max_vertices exclude each other"),
        ({"decompose": [1]}, "option decompose: expected a word, a number or a truth value"),
    ],
)
def test_wrong_options_are_rejected(options, words):
    with pytest.raises(BakeError, match=words):
        hullmap.bake(CUBE, **options)


def test_wrong_files_are_rejected(tmp_path, cube):
    for read, name in ((hullmap.open, "none.hullmap"), (hullmap.bake_file, "none.obj")):
        with pytest.raises(FileNotFoundError, match="cannot read.*; check the ") as caught:
            read(tmp_path / name)
        text = str(caught.value)
        assert name in text and text.startswith("[Errno 2] ") and "os error" not in text, text
    for mmap in (True, False):
        with pytest.raises(OSError, match="(?i)is a directory; name a pack in this folder"):
            hullmap.open(tmp_path, mmap=mmap)
    data = bytearray(cube.pack.to_bytes())
    path = tmp_path / "damaged.hullmap"
    for change, words in (
        (lambda: b"", "0 bytes long"),
        (lambda: b"v 0 0 0", "7 bytes long"),
        (lambda: bytes(200), "hullmap"),
        (lambda: bytes(data[:-1]), "bytes"),
        (lambda: bytes(data[:500]) + b"\xff" + bytes(data[501:]), "checksum"),
    ):
        path.write_bytes(change())
        for mmap in (True, False):
            with pytest.raises(InvalidPack, match=words) as caught:
                hullmap.open(path, mmap=mmap)
            assert str(path) in str(caught.value)
        with pytest.raises(InvalidPack):
            hullmap.from_bytes(path.read_bytes())


def test_paths_may_be_bytes(tmp_path, cube):
    """They raised a TypeError. A long name of a pack was too long for its temporary file."""
    for name in ("cube.hullmap", "x" * 247 + ".hullmap", "é" * 123 + ".hullmap"):
        path = tmp_path / name
        assert cube.pack.save(os.fsencode(path)) == path
        for form in (path, str(path), os.fsencode(path)):
            assert hullmap.open(form).to_bytes() == cube.pack.to_bytes()
        assert hullmap.open(os.fsencode(path)).path == path
    mesh = tmp_path / "point.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n")
    assert len(hullmap.bake_file(os.fsencode(mesh))[0]) == 4
    for read in (hullmap.open, hullmap.bake_file):
        with pytest.raises(TypeError, match="expected str, bytes or os.PathLike object, not int"):
            read(5)


def test_damaged_packs_never_crash(cube):
    """Every tenth byte, flipped: either the pack is rejected, or it answers."""
    data = cube.pack.to_bytes()
    for at in range(0, len(data), 10):
        damaged = bytearray(data)
        damaged[at] ^= 0xFF
        with pytest.raises(InvalidPack):
            hullmap.from_bytes(damaged)


def test_wrong_helpers_are_rejected():
    with pytest.raises(ArrayError, match="order: expected"):
        hullmap.poses([0, 0, 0], [0, 0, 0, 1], order="zyxw")
    with pytest.raises(ArrayError, match="pass as many of both"):
        hullmap.poses(np.zeros((2, 3)), np.ones((3, 4)))
    with pytest.raises(ArrayError, match="rotations: expected the shape"):
        hullmap.poses([0, 0, 0], [1, 2])
    with pytest.raises(ArrayError, match="names: expected 1, one for each part, found 2"):
        hullmap.bake_parts([(CUBE, None)], names=["a", "b"])
    with pytest.raises(ArrayError, match="parts: the list is empty"):
        hullmap.bake_parts([])


def test_quaternions_of_either_order_and_matrices_agree():
    poses = random_poses(20, 6, 1)
    scalar_first = np.roll(poses[:, 3:], 1, axis=1)
    assert np.allclose(hullmap.poses(poses[:, :3], scalar_first, order="wxyz"), poses)
    turned = hullmap.poses(poses[:, :3], matrices(poses)[:, :3, :3])
    assert np.allclose(matrices(turned), matrices(poses), atol=1e-12)


def test_poses_did_not_take_matrices_of_poses(cube):
    poses = random_poses(20, 6, 1).reshape(4, 5, 7)
    rows = hullmap.poses(matrices(poses))
    assert rows.shape == (4, 5, 7) and np.allclose(matrices(rows), matrices(poses), atol=1e-12)
    assert hullmap.poses(np.eye(4).tolist()).tolist() == [0, 0, 0, 0, 0, 0, 1]
    assert hullmap.poses(np.zeros((0, 4, 4))).shape == (0, 7)
    # A matrix needs no conversion.
    assert np.allclose(cube.distance(cube, matrices(poses)).distance, cube.distance(cube, rows).distance, atol=1e-9)
    with pytest.raises(ArrayError, match="matrices of poses, which contain rotations: leave out the argument rotations"):
        hullmap.poses(np.eye(4), [0, 0, 0, 1])
    wrong = matrices(poses)
    wrong[2, 1, 0, 0] += 0.5
    with pytest.raises(PoseError, match=r"^positions\[11\]: matrix must be a rotation"):
        hullmap.poses(wrong)
    with pytest.raises(PoseError, match=r"^rotations\[11\]: matrix must be a rotation"):
        hullmap.poses(poses[..., :3], wrong[..., :3, :3])
    with pytest.raises(ArrayError, match=r"positions: expected the shape \(\.\.\., 3\), found \(4,\)"):
        hullmap.poses(np.zeros(4))
