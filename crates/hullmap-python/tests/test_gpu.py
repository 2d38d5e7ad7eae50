"""device="gpu": in a wheel with the feature, against brute force; in one without, the error."""

from __future__ import annotations

import os

import numpy as np
import pytest
from conftest import random_poses

import hullmap
from hullmap import Overlap, Status, _hullmap


def test_unknown_devices_are_errors(cube):
    with pytest.raises(hullmap.ArrayError, match="expected 'cpu' or 'gpu', found \"tpu\""):
        cube.distance(cube, hullmap.poses([3, 0, 0]), device="tpu")


@pytest.mark.skipif(_hullmap.has_gpu, reason="the wheel has the feature gpu")
def test_a_wheel_without_the_feature_says_so(cube):
    for query in (cube.intersects, cube.distance, cube.contact):
        with pytest.raises(hullmap.Error, match="requires a wheel with the feature gpu.*device='cpu'"):
            query(cube, hullmap.poses([3, 0, 0]), device="gpu")


@pytest.fixture(scope="module")
def device(cube):
    """The device to pass. Without one, the tests are skipped."""
    if not _hullmap.has_gpu:
        pytest.skip("the wheel was built without the feature gpu")
    try:
        cube.intersects(cube, hullmap.poses([3, 0, 0]), device="gpu")
    except hullmap.Error as error:
        if os.environ.get("HULLMAP_REQUIRE_GPU") == "1":
            raise
        pytest.skip(str(error))
    return "gpu"


def test_answers_are_those_of_brute_force(device, rocks, truth):
    (a, b), (poses, depths, gaps) = rocks, truth
    hits = a.intersects(b, poses, device=device)
    assert (hits.hit == (depths > 0)).all()
    assert set(np.unique(hits.status)) == {Overlap.SEPARATED, Overlap.OVERLAPPING}

    gap = a.distance(b, poses, device=device)
    assert (gap.lower <= gaps + 1e-12).all() and (gaps <= gap.upper + 1e-12).all()
    assert np.allclose(gap.distance, gaps, rtol=3e-5, atol=1e-5)
    assert (gap.status[gaps == 0] == Status.OVERLAPPING).all()

    contact = a.contact(b, poses, device=device)
    depths = np.maximum(depths, 0)
    assert (contact.depth_lower <= depths + 1e-12).all() and (depths <= contact.depth_upper + 1e-12).all()
    assert np.allclose(contact.depth, depths, rtol=3e-5, atol=1e-5)
    assert (contact.hit == (depths > 0)).all()


def test_a_hull_meets_itself(device, large):
    poses = random_poses(300, 6, 2.5)
    found, own = large.distance(large, poses, device=device), large.distance(large, poses)
    assert (found.lower <= own.upper).all() and (own.lower <= found.upper).all()
    assert ((found.status == Status.OVERLAPPING) == (own.status == Status.OVERLAPPING)).all()
    # Pairs that the GPU leaves open, here all of them, have the processor's own answer.
    limited = large.distance(large, poses, device=device, max_iterations=1)
    assert (limited.lower <= own.upper).all() and (own.lower <= limited.upper).all()


def test_pairs_of_several_packs_are_those_of_the_processor(device, rocks, large, cube):
    pack = hullmap.bake_parts([(hull.vertices, None) for hull in (cube, *rocks)])
    shapes = [*rocks, large, pack[2], pack[0], cube]
    pairs = hullmap.Pairs(shapes, *np.triu_indices(len(shapes), 1))
    at = random_poses(20 * len(shapes), 7, 3.0).reshape(20, len(shapes), 7)
    own, found = pairs.distance(in_world=at), pairs.distance(in_world=at, device=device)
    assert found.shape == (20, len(pairs)) and 0.2 < (own.distance == 0).mean() < 0.8
    assert (found.lower <= own.upper).all() and (own.lower <= found.upper).all()
    assert (pairs.intersects(in_world=at, device=device).hit == pairs.intersects(in_world=at).hit).all()
    own, found = pairs.contact(in_world=at), pairs.contact(in_world=at, device=device)
    assert (found.depth_lower <= own.depth_upper).all() and (own.depth_lower <= found.depth_upper).all()


def test_shapes_of_each_row_and_none(device, cube):
    lone = cube.distance(cube, hullmap.poses([3, 0, 0]), device=device)
    assert np.shape(lone.distance) == () and np.isclose(lone.distance, 1.0)
    assert cube.contact(cube, hullmap.poses(np.zeros((0, 3))), device=device).depth.shape == (0,)
    with pytest.raises(hullmap.ShapeError, match="takes hulls"):
        cube.distance(hullmap.Sphere(1.0), hullmap.poses([3, 0, 0]), device=device)
    with pytest.raises(hullmap.PoseError, match=r"b_in_a\[1\]"):
        cube.distance(cube, [[3, 0, 0, 0, 0, 0, 1], [3, 0, 0, 0, 0, 0, 2]], device=device)
