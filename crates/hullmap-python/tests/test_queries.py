"""Answers against brute force in doubles."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CUBE, Body, matrices, random_poses, rock

import hullmap
from hullmap import Overlap, Status


def test_hits_are_those_of_brute_force(rocks, truth):
    poses, depths, _ = truth
    found = rocks[0].intersects(rocks[1], poses)
    assert (found.hit == (depths > 0)).all()
    assert set(np.unique(found.status)) == {Overlap.SEPARATED, Overlap.OVERLAPPING}


@pytest.mark.parametrize("coherent", [False, True])
@pytest.mark.parametrize("threads", [1, 2, None])
def test_distances_are_those_of_brute_force(rocks, truth, coherent, threads):
    poses, _, gaps = truth
    found = rocks[0].distance(rocks[1], poses, coherent=coherent, threads=threads)
    assert (found.lower <= gaps + 1e-12).all() and (gaps <= found.upper + 1e-12).all()
    assert np.allclose(found.distance, gaps, rtol=1e-5, atol=1e-12)
    apart = np.linalg.norm(found.point_b - found.point_a, axis=1)
    assert np.allclose(apart[gaps > 0], gaps[gaps > 0], rtol=1e-5)
    assert np.allclose(np.linalg.norm(found.normal, axis=1), 1)
    assert (found.status[gaps == 0] == Status.OVERLAPPING).all()


def test_depths_are_those_of_brute_force(rocks, truth):
    poses, depths, _ = truth
    found = rocks[0].contact(rocks[1], poses)
    depths = np.maximum(depths, 0)
    assert (found.depth_lower <= depths + 1e-12).all() and (depths <= found.depth_upper + 1e-12).all()
    assert np.allclose(found.depth, depths, rtol=1e-5, atol=1e-12)
    # Moved out by the depth, the pairs no longer overlap by more than the tolerance.
    out = poses.copy()
    out[:, :3] += (found.depth * (1 + 2e-5))[:, None] * found.normal
    assert not (rocks[0].contact(rocks[1], out).depth > 2e-5 * depths.max()).any()


def test_zero_tolerance_is_exact(rocks, truth):
    poses, _, gaps = truth
    found = rocks[0].distance(rocks[1], poses, tolerance=0)
    assert np.allclose(found.distance, gaps, rtol=1e-12, atol=1e-13)


def test_support_points_maximise_the_dot_product(large):
    dirs = np.random.default_rng(1).normal(size=(2000, 3))
    found = large.support(dirs)
    dots = large.vertices.astype(float) @ dirs.T
    reached = (found.point * dirs).sum(1)
    assert np.allclose(reached, dots.max(0), rtol=0, atol=1e-9)
    assert (large.vertices[found.vertex] == found.point.astype(np.float32)).all()


def worst_regret(points, count, rng):
    """The largest shortfall of support queries, relative to the diameter, near normals of faces."""
    hull, points = hullmap.bake(points)[0], points.astype(float)
    base = Body(hull).normals
    if len(base) == 0:
        base = np.cross(hull.vertices[1].astype(float) - hull.vertices[0], rng.normal(size=(64, 3)))
        base /= np.linalg.norm(base, axis=1, keepdims=True)
    base = np.concatenate((base, -base))
    near = base[rng.integers(0, len(base), count)] + rng.normal(size=(count, 3)) * 10 ** -rng.uniform(7, 16, (count, 1))
    dirs = np.concatenate((base, near))
    # Differences of points are exact. Where a regret is small, so are the terms of its dot product.
    losses = [((points - got) @ way).max() for way, got in zip(dirs, hull.support(dirs).point)]
    diameter = np.linalg.norm(points[:, None] - points, axis=2).max()
    return (losses / np.linalg.norm(dirs, axis=1)).max() / diameter


@pytest.mark.filterwarnings("ignore::hullmap.BakeWarning")
def test_worst_regrets_are_as_documented():
    """The figures of docs/contributors/intervals.md, section 9, docs/limits.md and docs/contributors/FORMAT.md."""
    rng, worst = np.random.default_rng(5), 0
    for corners, tilt, slope in [(120, 2.5e-7, 0.3), (100, 6e-8, 0.1), (60, 1e-7, 0.1), (80, 6e-8, 1.0)]:
        angles = np.arange(corners // 2) * 4 * np.pi / corners
        rim = np.stack((np.cos(angles), np.sin(angles)), axis=1).astype(np.float32)
        tilted = np.float32(tilt) * (rim[:, 0] + np.float32(slope) * rim[:, 1])
        prism = np.concatenate([np.c_[rim, np.float32(z) + tilted] for z in (-1, 1)])
        worst = max(worst, worst_regret(prism, 10_000, rng))
    assert 3e-16 < worst <= 2.3e-15, worst
    # Flat sets: one on which much is lost, and random ones.
    slanted = [[-0.59, 17e-8, -13e-8], [-0.17, 5.2e-8, 6.3e-8], [0.53, -17e-8, 12e-8], [0.9, 3.5e-8, -15e-8], [-0.09, -16e-8, 6.9e-8]]
    sets = [np.array(slanted)]
    for axes in [1, 2] * 150:
        sizes = np.ones(3)
        sizes[3 - axes :] = 10 ** rng.uniform(-7.3, -6.6)
        sets.append(rng.uniform(-1, 1, (rng.integers(4, 20), 3)) * sizes)
    sets = [points.astype(np.float32) for points in sets]
    flat = [worst_regret(points, 50, rng) for points in sets if hullmap.bake(points)[0].rank < 3]
    assert len(flat) > 50 and 1.2e-7 < max(flat) <= 1.8e-7, (len(flat), max(flat))


def test_rays_enter_where_the_planes_say(large):
    rng = np.random.default_rng(2)
    ways = rng.normal(size=(500, 3))
    origins = -3 * ways / np.linalg.norm(ways, axis=1, keepdims=True) + rng.uniform(-1, 1, size=(500, 3))
    body = Body(large)
    heights = body.normals @ origins.T - (body.normals * body.triangles[:, 0]).sum(1)[:, None]
    speeds = body.normals @ ways.T
    with np.errstate(divide="ignore"):
        times = -heights / speeds
    enter = np.where(speeds < 0, times, -np.inf).max(0)
    leave = np.where(speeds > 0, times, np.inf).min(0)
    hits = (enter <= leave) & (enter >= 0)
    assert 0.3 < hits.mean() < 0.95
    found = large.ray(origins, ways)
    assert (found.hit == hits).all()
    assert np.allclose(found.t[hits], enter[hits], rtol=1e-6)
    assert (found.t_lower[hits] <= enter[hits] + 1e-9).all() and (enter[hits] <= found.t_upper[hits] + 1e-9).all()
    assert np.isinf(found.t[~hits]).all()
    assert not large.ray(origins, ways, max_t=1e-3).hit.any()


def test_signed_distances_inside_are_to_the_nearest_plane(rocks):
    hull = rocks[0]
    body = Body(hull)
    points = np.random.default_rng(3).uniform(-1.2, 1.2, size=(400, 3))
    planes = body.normals @ points.T - (body.normals * body.triangles[:, 0]).sum(1)[:, None]
    inside = planes.max(0) < 0
    assert 0.1 < inside.mean() < 0.9
    found = hull.signed_distance(points)
    assert np.allclose(found.distance[inside], planes.max(0)[inside], rtol=1e-5, atol=1e-9)
    assert (found.distance[~inside] >= planes.max(0)[~inside] - 1e-9).all()
    assert ((found.lower <= found.distance) & (found.distance <= found.upper)).all()
    apart = np.linalg.norm(found.point - points, axis=1)
    assert np.allclose(apart, abs(found.distance), rtol=1e-4, atol=1e-9)


def test_both_forms_of_a_pose_agree(rocks):
    poses = random_poses(100, 9, 3)
    by_rows, by_matrices = (rocks[0].distance(rocks[1], form) for form in (poses, matrices(poses)))
    assert np.allclose(by_rows.distance, by_matrices.distance, rtol=1e-6, atol=1e-12)


def test_world_poses_are_relative_poses(rocks):
    a, b = random_poses(50, 1, 2), random_poses(50, 2, 2)
    expected = np.linalg.inv(matrices(a)) @ matrices(b)
    assert np.allclose(matrices(hullmap.relative(a, b)), expected, atol=1e-12)
    direct = rocks[0].distance(rocks[1], hullmap.relative(a, b)).distance
    assert np.allclose(rocks[0].distance(rocks[1], a_in_world=a, b_in_world=b).distance, direct, rtol=1e-9, atol=1e-12)
    one = rocks[0].distance(rocks[1], a_in_world=a[0], b_in_world=b)
    assert one.distance.shape == (50,) and one.distance[0] == pytest.approx(direct[0])
    assert rocks[0].distance(rocks[1], a_in_world=a, b_in_world=matrices(b[0])).distance.shape == (50,)


def test_one_pose_serves_for_all(cube):
    many, one = random_poses(6, 1, 3), random_poses(1, 2, 3)
    for a, b, lead in (
        (one, many, (6,)), (one[0], many, (6,)), (many, one.reshape(1, 1, 7), (6,)), (one.reshape(1, 1, 7), many, (6,)),
        (many.reshape(2, 3, 7), many, (2, 3)), (one[0], one, (1,)), (one[0], many[:0], (0,)), (one[0], one[0], ()),
    ):  # fmt: skip
        assert cube.distance(cube, a_in_world=a, b_in_world=b).distance.shape == lead
        assert hullmap.relative(a, b).shape == (*lead, 7)
    assert cube.ray(np.zeros((1, 3)), np.ones((2, 2, 3))).t.shape == (2, 2)
    assert cube.ray(np.zeros((0, 3)), [1, 0, 0]).t.shape == (0,)


def test_the_number_of_threads_changes_no_bit(rocks):
    poses = random_poses(3000, 7, 3)
    for coherent in (False, True):
        one, two = (rocks[0].contact(rocks[1], poses, coherent=coherent, threads=n) for n in (1, 2))
        for field in ("depth", "depth_lower", "depth_upper", "normal", "point_a", "status", "support_calls"):
            assert np.array_equal(getattr(one, field), getattr(two, field)), field


def test_shapes_of_answers_follow_the_poses(cube):
    poses = random_poses(12, 1, 3).reshape(3, 4, 7)
    found = cube.distance(cube, poses)
    assert found.distance.shape == (3, 4) and found.normal.shape == (3, 4, 3) and found.parts.shape == (3, 4, 2)
    single = cube.distance(cube, poses[0, 0])
    assert single.distance == found.distance[0, 0] and single.normal.shape == (3,)
    assert isinstance(single.distance, float)
    assert cube.distance(cube, np.zeros((0, 7))).distance.shape == (0,)
    assert cube.manifold(cube, poses).point_a.shape == (3, 4, 4, 3)
    assert cube.manifold(cube, poses[0, 0]).point_a.shape == (4, 3)


def test_a_manifold_carries_a_cube(cube):
    floor = hullmap.Box([5, 5, 1])
    found = floor.manifold(cube, hullmap.poses([[0, 0, 1.99], [0, 0, 2.02], [0, 0, 3]]))
    assert found.count.tolist() == [4, 4, 0]
    # The status of the contact, of the distance, and of a proof that the two are apart.
    assert hullmap.Status.words(found.status) == ["exact", "exact", "separated"]
    assert np.allclose(found.depth[0], 0.01) and np.allclose(found.depth[1], -0.02) and np.isnan(found.depth[2]).all()
    assert np.allclose(found.normal[0], [0, 0, 1])
    corners = np.unique(found.point_b[0].round(6), axis=0)
    assert np.allclose(corners, [[-1, -1, 0.99], [-1, 1, 0.99], [1, -1, 0.99], [1, 1, 0.99]])
    assert np.allclose(found.local_b[0][:, 2], -1)
    assert floor.manifold(cube, hullmap.poses([0, 0, 2.02]), prediction=0.01).count == 0


def test_casts_meet_at_the_time_of_impact(cube):
    poses, velocity = hullmap.poses([[5, 0, 0], [0, 7, 0]]), [[-1, 0, 0], [0, -2, 0]]
    found = cube.cast(cube, poses, velocity)
    assert np.allclose(found.t, [3, 2.5]) and found.hit.all()
    moved = poses.copy()
    moved[:, :3] += found.t[:, None] * np.array(velocity)
    assert np.allclose(cube.distance(cube, moved).distance, 0, atol=1e-5)
    assert not cube.cast(cube, poses, [1, 1, 0]).hit.any()


@pytest.mark.parametrize(
    ("shape", "depth"),
    [
        (hullmap.Sphere(1.0), 0.5),
        (hullmap.Box([1.0, 2.0, 3.0]), 0.5),
        (hullmap.Capsule(2.0, 1.0), 0.5),
        (hullmap.Cylinder(2.0, 1.0), 0.5),
        (hullmap.Segment([-1, 0, 0], [1, 0, 0]), 0.5),
        (hullmap.Triangle([-1, 0, 0], [1, 0, 0], [1, 1, 0]), None),
        (hullmap.Cone(1.0, 1.0), None),
    ],
)
def test_primitives_meet_hulls(cube, shape, depth):
    pose = hullmap.poses([1.5, 0, 0])
    found = cube.contact(shape, pose)
    assert found.hit and found.depth > 0
    if depth is not None:
        assert found.depth == pytest.approx(depth, rel=1e-5) and found.depth_lower <= depth <= found.depth_upper
    assert cube.distance(shape, hullmap.poses([9, 0, 0])).distance > 5
    back = shape.contact(cube, hullmap.poses([-1.5, 0, 0]))
    assert back.depth == pytest.approx(found.depth, rel=1e-4)
    assert shape.support([1, 0, 0]).point.shape == (3,)


def test_half_spaces_on_either_side(cube):
    floor = hullmap.HalfSpace([0, 0, 2], 1.0)
    found = floor.contact(cube, hullmap.poses([[0, 0, 1.75], [0, 0, 4]]))
    assert found.depth.tolist() == [0.25, 0.0] and found.hit.tolist() == [True, False]
    assert floor.manifold(cube, hullmap.poses([0, 0, 1.75])).count == 4
    assert floor.ray([0, 0, 3], [0, 0, -1]).t == 2.0
    assert floor.signed_distance([0, 0, -1]).distance == -2.0
    found = cube.contact(floor, hullmap.poses([0, 0, -1.75]))
    assert found.depth == 0.25 and found.normal.tolist() == [0, 0, -1]
    with pytest.raises(hullmap.ShapeError, match="two half-spaces have no query"):
        floor.contact(floor, hullmap.poses([0, 0, 0]))
    with pytest.raises(hullmap.ShapeError, match="must be the first shape"):
        cube.manifold(floor, hullmap.poses([0, 0, 0]))


@pytest.fixture(scope="module")
def pair_of_cubes():
    """Unit cubes at x from 0 to 1 and from 3 to 4."""
    unit = (CUBE + 1) / 2
    return hullmap.bake_parts([(unit, None), (unit + [3, 0, 0], None)], names=["left", "right"])


def test_a_pack_is_the_union_of_its_hulls(pair_of_cubes):
    pack, poses = pair_of_cubes, random_poses(200, 4, 5)
    probe = hullmap.bake(rock(30, 8))[0]
    each = [hull.distance(probe, poses).distance for hull in pack]
    union = pack.distance(probe, poses)
    assert np.allclose(union.distance, np.minimum(*each), rtol=1e-5, atol=1e-9)
    assert set(union.parts[:, 0].tolist()) == {0, 1} and (union.parts[:, 1] == 0).all()
    assert (pack.intersects(probe, poses).hit == (np.minimum(*each) == 0)).all()
    depths = [hull.contact(probe, poses).depth for hull in pack]
    assert np.allclose(pack.contact(probe, poses).depth, np.maximum(*depths), rtol=1e-5, atol=1e-9)
    assert np.allclose(probe.distance(pack, hullmap.poses([9, 0, 0])).distance, 8, atol=0.5)


def test_packs_meet_packs_planes_and_rays(pair_of_cubes):
    pack = pair_of_cubes
    between = hullmap.poses([1.5, 0, 0])
    assert not pack.intersects(pack, between).hit
    assert pack.distance(pack, hullmap.poses([6, 0, 0])).distance == pytest.approx(2)
    separated = pack.contact(pack, between)
    assert not separated.hit and separated.depth == 0 and separated.status == Status.SEPARATED
    floor = hullmap.HalfSpace([1, 0, 0], 0.0)
    assert floor.contact(pack, hullmap.poses([-3.5, 0, 0])).depth == pytest.approx(3.5)
    hits = pack.ray([[-1, 0.5, 0.5], [9, 0.5, 0.5], [2, 0.5, 5]], [[1, 0, 0], [-1, 0, 0], [0, 0, -1]])
    assert np.allclose(hits.t, [1, 5, np.inf]) and hits.part.tolist()[:2] == [0, 1]
    assert (hits.t_lower <= hits.t).all() and (hits.t <= hits.t_upper).all()
    with pytest.raises(hullmap.ShapeError, match="takes convex shapes, found a pack: query it by manifolds"):
        pack[0].manifold(pack, between)


def test_packs_are_cast_and_have_support_points(pair_of_cubes):
    pack, floor = pair_of_cubes, hullmap.HalfSpace([1, 0, 0], 0.0)
    # Into the gap from above, and past it to the right cube.
    ball, above = hullmap.Sphere(0.5), hullmap.poses([2.0, 0.5, 3.0])
    found = pack.cast(ball, np.tile(above, (3, 1)), [[0, 0, -1], [1, 0, -2.5], [-1, 0, 0]])
    assert found.hit.tolist() == [False, True, False] and found.parts[1].tolist() == [1, 0]
    alone = pack[1].cast(ball, above, [1, 0, -2.5])
    assert found.t_lower[1] <= alone.t_upper and alone.t_lower <= found.t_upper[1]
    # Packs against each other, a hull against a pack, and a plane.
    assert pack.cast(pack, hullmap.poses([8, 0, 0]), [-2, 0, 0]).t == pytest.approx(2.0, abs=1e-5)
    assert pack[0].cast(pack, hullmap.poses([8, 0, 0]), [-1, 0, 0]).t == pytest.approx(7.0, abs=1e-5)
    assert floor.cast(pack, hullmap.poses([1, 0, 0]), [-4, 0, 0]).t == pytest.approx(0.25)
    poses, ways = random_poses(300, 6, 6.0), -random_poses(300, 7, 2.0)[:, :3]
    probe = hullmap.bake(rock(30, 8))[0]
    each = np.array([hull.cast(probe, poses, ways).t for hull in pack]).min(axis=0)
    union = pack.cast(probe, poses, ways)
    sure = union.status != Status.TOUCHING
    assert 0.1 < np.isfinite(each).mean() < 0.9 and sure.mean() > 0.9
    assert np.allclose(union.t[sure], each[sure], rtol=1e-5, atol=1e-5)
    directions = np.random.default_rng(9).normal(size=(200, 3))
    farthest = pack.support(directions)
    dots = [(hull.support(directions).point * directions).sum(axis=1) for hull in pack]
    assert np.array_equal((farthest.point * directions).sum(axis=1), np.maximum(*dots))
    assert np.array_equal(farthest.parts, np.argmax(dots, axis=0)) and set(farthest.parts.tolist()) == {0, 1}
    with pytest.raises(hullmap.ShapeError, match="takes a bounded shape"):
        hullmap._hullmap.support(floor._native, directions, None)


def box_distance(points: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Signed distance from the unit cube with this lowest corner, in closed form."""
    beyond = np.abs(points - low - 0.5) - 0.5
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


@pytest.mark.parametrize("coherent", [False, True])
def test_signed_distances_of_a_pack_are_those_of_the_nearest_hull(pair_of_cubes, coherent):
    points = np.random.default_rng(3).uniform([-1, -1, -1], [5, 2, 2], size=(1000, 3))
    each = np.array([box_distance(points, np.array([x, 0.0, 0.0])) for x in (0, 3)])
    truth = each.min(axis=0)
    found = pair_of_cubes.signed_distance(points, coherent=coherent)
    assert 0.02 < (truth < 0).mean() < 0.3
    assert (found.lower <= truth + 1e-12).all() and (truth <= found.upper + 1e-12).all()
    assert np.allclose(found.distance, truth, rtol=1e-5, atol=1e-9)
    assert np.array_equal(found.part, each.argmin(axis=0)) and set(found.part.tolist()) == {0, 1}
    assert np.allclose(np.linalg.norm(found.point - points, axis=1), abs(truth), rtol=1e-4, atol=1e-9)
    assert pair_of_cubes.signed_distance([0.5, 0.5, 0.75]).distance == pytest.approx(-0.25)
    with pytest.raises(hullmap.ArrayError, match=r"points\[1\]"):
        pair_of_cubes.signed_distance([[0, 0, 0], [0, np.nan, 0]])


def test_where_hulls_overlap_the_deeper_one_decides():
    long = (CUBE * [2, 1, 1], CUBE * [1, 2, 1])
    pack = hullmap.bake_parts([(part, None) for part in long])
    found = pack.signed_distance([[0, 0, 0], [1.5, 0, 0], [0, 1.5, 0.9], [1.25, 1.5, 0]])
    assert np.allclose(found.distance, [-1, -0.5, -0.1, 0.25]) and found.part.tolist()[1:] == [0, 1, 1]


def test_manifolds_of_packs_are_those_of_their_hulls(pair_of_cubes):
    pack, poses = pair_of_cubes, random_poses(400, 4, 4)
    probe = hullmap.bake(rock(30, 8))[0]
    found = pack.manifolds(probe, poses, max_pairs=4)
    assert found.point_a.shape == (400, 4, 4, 3) and found.depth.shape == (400, 4, 4)
    each = [hull.manifold(probe, poses) for hull in pack]
    counts = np.array([alone.count for alone in each])
    assert np.array_equal(found.touching, (counts > 0).sum(axis=0)) and (found.dropped == 0).all()
    assert np.array_equal(found.touching, (found.count > 0).sum(axis=1)) and (counts > 0).mean() > 0.02
    for row, pair in np.argwhere(found.count > 0):
        part, other = found.parts[row, pair]
        alone = each[part]
        assert other == 0 and found.count[row, pair] == alone.count[row]
        assert np.allclose(found.normal[row, pair], alone.normal[row], atol=1e-9)
        for field in ("point_a", "point_b", "local_b", "depth"):
            assert np.allclose(getattr(found, field)[row, pair], getattr(alone, field)[row], atol=1e-9, equal_nan=True)
    unused = found.count == 0
    assert (found.parts[unused] == 2**32 - 1).all() and np.isnan(found.depth[unused]).all()
    assert found.status.shape == (400, 4) and np.array_equal(found.status == hullmap.Status.SEPARATED, unused)
    assert np.isnan(found.normal[unused]).all()
    # The other way around, and without memory for all pairs.
    turned = probe.manifolds(pack, hullmap.relative(poses, hullmap.poses([0, 0, 0])))
    assert np.array_equal(turned.touching, found.touching)
    few = pack.manifolds(hullmap.Box([5, 5, 1]), hullmap.poses([2, 0.5, -0.99]), max_pairs=1)
    assert few.touching == 1 and few.dropped == 1 and few.count.tolist() == [4]


def test_manifolds_say_how_they_ended(rocks, truth):
    cube = hullmap.bake(CUBE)[0]
    # Touching, within the default prediction, beyond it, and 0.5 deep.
    poses = hullmap.poses([[0, 0, 2], [0, 0, 2.01], [0, 0, 3], [0, 0, 1.5]])
    expected = ["touching", "exact", "separated", "exact"]
    for other in (cube, hullmap.Box([1, 1, 1])):
        found, pairs = cube.manifold(other, poses), cube.manifolds(other, poses, max_pairs=2)
        assert Status.words(found.status) == expected and found.count.tolist() == [4, 4, 0, 4]
        assert Status.words(pairs.status[:, 0]) == expected and (pairs.status[:, 1] == Status.SEPARATED).all()
        assert found.hit.tolist() == [True, False, False, True]
    # Without iterations, overlapping shapes have points, but not those of the least depth.
    poses, depths, _ = truth
    deep = poses[depths > 0.1]
    limited, whole = (rocks[0].manifold(rocks[1], deep, max_iterations=n) for n in (0, 200))
    assert (limited.status == Status.ITERATION_LIMIT).mean() > 0.9 and limited.hit.all() and (limited.count > 0).all()
    assert np.isin(whole.status, (Status.EXACT, Status.WITHIN)).all()
    pairs = rocks[0].manifolds(rocks[1], deep, max_pairs=1, max_iterations=0)
    assert np.array_equal(pairs.status[:, 0], limited.status)


def test_manifolds_of_pack_on_pack_and_floor(pair_of_cubes):
    pack, floor = pair_of_cubes, hullmap.HalfSpace([0, 0, 1], 0.0)
    found = floor.manifolds(pack, hullmap.poses([[0, 0, -0.01], [0, 0, 5]]), max_pairs=3)
    assert found.touching.tolist() == [2, 0] and found.parts[0, :2].tolist() == [[0, 0], [0, 1]]
    assert np.allclose(found.depth[0, :2], 0.01) and np.allclose(found.normal[0, :2], [0, 0, 1])
    stacked = pack.manifolds(pack, hullmap.poses([0, 0, 0.99]))
    assert stacked.touching == 2 and stacked.parts[:2].tolist() == [[0, 0], [1, 1]]
    assert np.allclose(stacked.depth[:2], 0.01)
    # One hull counts as a pack of one.
    alone, single = pack[0].manifolds(pack[1], hullmap.poses([-3, 0, 0.99])), hullmap.poses([-3, 0, 0.99])
    assert np.allclose(alone.depth[0], pack[0].manifold(pack[1], single).depth) and alone.touching == 1
    empty = pack.manifolds(pack, np.zeros((0, 7)))
    assert empty.depth.shape == (0, 8, 4) and empty.touching.shape == (0,)
    for wrong in (0, -1, 65537, 2**40, 2.7, float("nan"), None):
        with pytest.raises(hullmap.ArrayError, match="max_pairs must be a whole number from 1 to 65536"):
            pack.manifolds(pack, single, max_pairs=wrong)
    assert pack.manifolds(floor, hullmap.poses([0, 0, 0])).touching == floor.manifolds(pack, hullmap.poses([0, 0, 0])).touching


def test_normals_at_seams_are_those_of_the_union():
    unit = (CUBE + 1) / 2
    road = hullmap.bake_parts([(unit, None), (unit + [1, 0, 0], None)])
    # A ball above the first cube, near the edge of the second.
    ball, pose = hullmap.Sphere(0.5), hullmap.poses([0.9, 0.5, 1.4])
    alone = road[1].manifold(ball, pose)
    assert alone.count == 1 and alone.normal[0] < -0.2
    found = road.manifolds(ball, pose)
    assert np.allclose(found.normal[found.count > 0], [0, 0, 1])


@pytest.mark.parametrize("coherent", [False, True])
def test_the_number_of_threads_changes_no_bit_of_manifolds(pair_of_cubes, coherent):
    poses, probe = random_poses(3000, 7, 3), hullmap.bake(rock(30, 8))[0]
    one, two = (pair_of_cubes.manifolds(probe, poses, max_pairs=3, coherent=coherent, threads=n) for n in (1, 2))
    for field in ("touching", "parts", "count", "normal", "point_a", "depth"):
        assert np.array_equal(getattr(one, field), getattr(two, field), equal_nan=field not in ("touching", "parts", "count")), field


def test_limits_are_reported_and_intervals_hold(rocks, truth):
    poses, depths, _ = truth
    found = rocks[0].contact(rocks[1], poses, max_iterations=0)
    inside = depths > 0
    assert (found.status[inside] == Status.ITERATION_LIMIT).any()
    assert (found.depth_lower[inside] <= depths[inside]).all() and (depths[inside] <= found.depth_upper[inside]).all()


def test_answers_could_not_be_indexed(rocks, truth):
    poses, depths, _ = truth
    found = rocks[0].contact(rocks[1], poses)
    deep = found[found.depth > 0.1]
    assert 0 < len(deep) < len(found) == len(poses) and deep.shape == (len(deep),)
    assert (deep.depth == found.depth[found.depth > 0.1]).all() and (deep.depth > 0.1).all()
    assert (deep.normal == found.normal[found.depth > 0.1]).all() and isinstance(deep, hullmap.Contact)
    order = np.argsort(found.depth)
    assert (np.diff(found[order].depth) >= 0).all() and (found[order].parts == found.parts[order]).all()
    assert (found[::-1].depth == found.depth[::-1]).all() and found[-1].depth == found.depth[-1]
    assert found[-1].normal.shape == (3,) and found[[3, 3]].depth.tolist() == [found.depth[3]] * 2
    assert [one.depth for one in found] == found.depth.tolist()
    # Indices never reach into vectors, whatever the shape of the poses.
    grid = rocks[0].manifold(rocks[1], poses.reshape(20, 10, 7))
    assert grid.shape == (20, 10) and len(grid) == 20
    assert grid[3].depth.shape == (10, 4) and grid[:, 2].normal.shape == (20, 3)
    assert grid[..., 2].point_a.shape == (20, 4, 3) and grid[grid.hit].depth.shape == (grid.hit.sum(), 4)
    assert (grid[grid.hit].depth == grid.depth[grid.hit])[:, 0].all()
    for index in ((0, 0, 0), 20, (slice(None), 10)):
        with pytest.raises(IndexError):
            grid[index]
    for kind in (
        rocks[0].intersects(rocks[1], poses), rocks[0].distance(rocks[1], poses), rocks[0].cast(rocks[1], poses, [1, 0, 0]),
        rocks[0].ray(poses[:, :3], [1, 0, 0]), rocks[0].signed_distance(poses[:, :3]), rocks[0].support(poses[:, :3]),
        rocks[0].manifolds(rocks[1], poses, max_pairs=2),
    ):  # fmt: skip
        few = kind[[5, 7]]
        for name, column in vars(kind).items():
            assert np.array_equal(getattr(few, name), column[[5, 7]], equal_nan=column.dtype.kind == "f"), name
    single = rocks[0].contact(rocks[1], poses[0])
    assert single.shape == () and single[...].depth == single.depth
    with pytest.raises(TypeError, match="a single pose has no length"):
        len(single)
    with pytest.raises(TypeError, match="test one of its columns, such as hit"):
        bool(single)
