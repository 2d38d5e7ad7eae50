"""Shapes that move and turn, and derivatives: against formulas and differences."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import hullmap
from conftest import CUBE, random_poses

ORIGIN = hullmap.poses([0, 0, 0])


def turned(poses: np.ndarray, twists: np.ndarray) -> np.ndarray:
    """Poses after small twists, in the frame of the poses."""
    half = twists[..., 3:] / 2
    v, w = poses[..., 3:6], poses[..., 6:]
    vector = v + w * half + np.cross(half, v)
    scalar = w - (half * v).sum(-1, keepdims=True)
    quaternion = np.concatenate((vector, scalar), axis=-1)
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return np.concatenate((poses[..., :3] + twists[..., :3], quaternion), axis=-1)


def test_a_rod_meets_a_wall_when_the_formula_says() -> None:
    rod, wall = hullmap.Box([1, 0.01, 0.01]), hullmap.Box([5, 0.1, 5])
    heights = np.linspace(0.2, 1.2, 50)
    still = hullmap.Motion.still(hullmap.poses(np.stack((0 * heights, heights, 0 * heights), axis=-1)))
    turning = hullmap.Motion.screw(ORIGIN, angular=[0, 0, np.pi / 2])
    found = hullmap.cast_motion(rod, wall, turning, still)
    reach = (heights - 0.1) / np.hypot(1, 0.01)
    with np.errstate(invalid="ignore"):
        truth = (np.arcsin(reach) - np.arctan(0.01)) / (np.pi / 2)
    np.testing.assert_array_equal(found.hit, reach <= 1)
    hit = reach < 1
    assert found.shape == (50,) and (found.t_lower[hit] <= truth[hit]).all() and (truth[hit] <= found.t_upper[hit]).all()
    np.testing.assert_allclose(found.t[hit], truth[hit], atol=2e-5)
    assert np.isinf(found.t[~hit]).all()
    one = hullmap.cast_motion(rod, wall, turning, still, target_distance=0.05)
    assert (one.t_upper[hit] <= found.t[hit] + 1e-9).all()


def test_clear_agrees_with_distances() -> None:
    rng = np.random.default_rng(6)
    a, b = hullmap.bake(CUBE)[0], hullmap.Capsule(1.0, 0.2)
    start, end = random_poses(200, 7, 4.0), random_poses(200, 8, 4.0)
    found = hullmap.clear(a, b, hullmap.Motion.still(ORIGIN), hullmap.Motion.between(start, end))
    cast = hullmap.cast_motion(a, b, hullmap.Motion.still(ORIGIN), hullmap.Motion.between(start, end))
    free = found.verdict == hullmap.Verdict.FREE
    np.testing.assert_array_equal(free, ~cast.hit)
    assert 20 < free.sum() < 180 and rng is not None
    ends = np.minimum(a.distance(b, start).upper, a.distance(b, end).upper)
    assert (found.clearance[free] <= ends[free]).all() and (found.clearance[free] > 0).all()


def test_derivatives_agree_with_central_differences() -> None:
    a, b = hullmap.bake(CUBE * [1, 0.7, 0.5])[0], hullmap.Capsule(0.6, 0.3)
    poses = random_poses(300, 9, 3.0)
    for of, query, field in (("distance", a.distance, "distance"), ("depth", a.contact, "depth")):
        found = hullmap.derivatives(a, b, poses, of=of, tolerance=0)
        unique = found.differentiability == hullmap.Differentiability.UNIQUE
        assert unique.sum() > 50
        step = 1e-6
        wrong = np.zeros(300, bool)
        for axis in range(6):
            twist = np.eye(6)[axis] * step
            above, below = (getattr(query(b, turned(poses, sign * twist), tolerance=0), field) for sign in (1, -1))
            wrong |= np.abs((above - below) / (2 * step) - found.by_b[:, axis]) > 1e-4
        assert wrong[unique].sum() <= 0.02 * unique.sum()
        # A twist that moves both changes nothing.
        np.testing.assert_allclose(found.by_a[:, :3], -found.by_b[:, :3], atol=1e-12)
    apart = hullmap.derivatives(a, b, hullmap.poses([9, 0, 0]), of="depth")
    assert hullmap.Differentiability.words(apart.differentiability) == ["missing"] and not apart.by_b.any()


def test_the_time_of_impact_has_derivatives() -> None:
    ball = hullmap.Sphere(0.5)
    coming = hullmap.Motion.screw(hullmap.poses([3, 0.25, 0]), linear=[-4, 0, 0])
    found = hullmap.cast_motion(ball, ball, hullmap.Motion.still(ORIGIN), coming, tolerance=0)
    assert found.differentiability == hullmap.Differentiability.UNIQUE
    # It comes later by 1/4 for each metre.
    np.testing.assert_allclose(found.by_b[0], 0.25, atol=1e-6)


def test_half_spaces_packs_and_wrong_input() -> None:
    floor, ball = hullmap.HalfSpace([0, 0, 1]), hullmap.Sphere(0.5)
    still, falling = hullmap.Motion.still(ORIGIN), hullmap.Motion.between(hullmap.poses([0, 0, 2]), hullmap.poses([0, 0, -2]))
    assert float(hullmap.cast_motion(floor, ball, still, falling).t) == pytest.approx(0.375, abs=1e-6)
    assert hullmap.Verdict(int(hullmap.clear(floor, ball, still, falling).verdict)) == hullmap.Verdict.HIT
    found = hullmap.clear(floor, ball, still, hullmap.Motion.between(hullmap.poses([0, 0, 2]), hullmap.poses([0, 0, 1])))
    assert hullmap.Verdict(int(found.verdict)) == hullmap.Verdict.FREE and 0.25 <= float(found.clearance) <= 0.5
    assert float(hullmap.cast_motion(ball, floor, falling, still).t) == pytest.approx(0.375, abs=1e-6)
    with pytest.raises(hullmap.ShapeError, match="two half-spaces have no query"):
        hullmap.cast_motion(floor, floor, falling, still)
    pack = hullmap.bake_parts([(CUBE, None), (CUBE + [5, 0, 0], None)])
    found = hullmap.cast_motion(pack, ball, still, hullmap.Motion.between(hullmap.poses([5, 0, 4]), hullmap.poses([5, 0, 0])))
    assert found.parts.tolist() == [1, 0] and float(found.t) == pytest.approx(0.625, abs=1e-5)
    with pytest.raises(hullmap.ShapeError, match="derivatives takes convex shapes"):
        hullmap.derivatives(pack, ball, ORIGIN)
    with pytest.raises(hullmap.ArrayError, match="expected a hullmap.Motion"):
        hullmap.clear(ball, ball, ORIGIN, still)  # type: ignore[arg-type]
    with pytest.raises(hullmap.ArrayError, match="the shapes do not fit"):
        hullmap.Motion.between(np.tile(ORIGIN, (2, 1)), np.tile(ORIGIN, (3, 1)))
    with pytest.raises(hullmap.ArrayError, match="pass as many"):
        two, three = (hullmap.Motion.still(np.tile(ORIGIN, (n, 1))) for n in (2, 3))
        hullmap.clear(ball, ball, two, three)
    with pytest.raises(hullmap.ArrayError, match="of: expected"):
        hullmap.derivatives(ball, ball, ORIGIN, of="angle")  # type: ignore[arg-type]
    with pytest.raises(hullmap.PoseError, match=r"motion_b\[0\]"):
        hullmap.clear(ball, ball, still, hullmap.Motion.screw(ORIGIN, linear=[np.inf, 0, 0]))
    copy = pickle.loads(pickle.dumps(falling))
    assert repr(copy) == "<1 motion>" and copy.shape == ()
