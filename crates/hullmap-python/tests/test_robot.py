"""Whole robots: against a formula, against Pairs, and along edges."""

from __future__ import annotations

import pathlib
import pickle

import numpy as np
import pytest

import hullmap
from conftest import CUBE

BALLS = """<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom type="sphere" size="0.1"/>
  <body name="upper"><joint name="a" axis="0 0 1"/>
    <body name="lower" pos="1 0 0"><joint name="b" axis="0 0 1" range="-3.1 3.1"/>
      <geom type="sphere" size="0.2" pos="1 0 0"/></body></body></body></worldbody></mujoco>"""

ARM = """<robot name="arm">
  <link name="base"><collision><geometry><mesh filename="meshes/cube.obj" scale="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="upper"/>
  <link name="lower"><collision><origin xyz="0.5 0 0"/><geometry><mesh filename="meshes/cube.obj" scale="0.48 0.05 0.05"/>
    </geometry></collision></link>
  <link name="tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="a" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="c" type="prismatic"><parent link="lower"/><child link="tip"/><origin xyz="1.1 0 0"/><axis xyz="1 0 0"/>
    <mimic joint="b" multiplier="0.1" offset="0.05"/></joint>
</robot>"""


def obj(points: np.ndarray) -> str:
    hull = hullmap.bake(points)[0]
    lines = [f"v {x} {y} {z}" for x, y, z in hull.vertices]
    return "\n".join(lines + ["f " + " ".join(str(v + 1) for v in face) for face in hull.faces]) + "\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("robots")
    (folder / "balls.xml").write_text(BALLS)
    (folder / "arm.urdf").write_text(ARM)
    (folder / "meshes").mkdir()
    (folder / "meshes" / "cube.obj").write_text(obj(CUBE))
    return folder


@pytest.fixture(scope="module")
def balls(folder: pathlib.Path) -> hullmap.Robot:
    return hullmap.Robot.from_mjcf(folder / "balls.xml")


@pytest.fixture(scope="module")
def arm(folder: pathlib.Path) -> hullmap.Robot:
    return hullmap.Robot.from_urdf(folder / "arm.urdf")


def test_facts(balls: hullmap.Robot, arm: hullmap.Robot) -> None:
    assert balls.joint_names == ["a", "b"] and arm.joint_names == ["a", "b"]
    np.testing.assert_array_equal(balls.limits, [[-np.inf, np.inf], [-3.1, 3.1]])
    np.testing.assert_array_equal(arm.neutral, [0, 0])
    assert balls.link_names == ["world", "base", "upper", "lower"] and balls.names == balls.link_names
    assert balls.pairs.tolist() == [[1, 3]] and [arm.names[i] for i in arm.pairs[0]] == ["base", "lower"]
    assert repr(arm) == "<robot of 4 links, 2 joints, 3 bodies>"


def test_a_formula(balls: hullmap.Robot) -> None:
    rng = np.random.default_rng(1)
    q = rng.uniform(-3, 3, (100, 5, 2))
    truth = 2 * np.abs(np.cos(q[..., 1] / 2)) - 0.3
    found = balls.clearance(q, gradient=True)
    assert found.shape == (100, 5) and found.gradient.shape == (100, 5, 2)
    assert (found.lower <= truth).all() and (truth <= found.upper).all()
    np.testing.assert_allclose(found.upper, truth, atol=1e-5)
    assert (found.differentiability == hullmap.Differentiability.UNIQUE).all()
    expected = np.stack((np.zeros_like(truth), -np.sin(q[..., 1] / 2) * np.sign(np.cos(q[..., 1] / 2))), axis=-1)
    np.testing.assert_allclose(found.gradient, expected, atol=1e-6)
    assert (found.pair == [1, 3]).all()
    np.testing.assert_array_equal(balls.in_collision(q), truth < 0)
    np.testing.assert_array_equal(balls.in_collision(q, margin=0.25), truth <= 0.25)
    assert balls.in_collision([0, 3.0]).ndim == 0 and bool(balls.in_collision([0, 3.0]))
    # One thread and many give the same bits.
    again = balls.clearance(q, threads=1)
    np.testing.assert_array_equal(again.lower, found.lower)


def test_edges(balls: hullmap.Robot) -> None:
    rng = np.random.default_rng(2)
    start, end = rng.uniform(-2.5, 2.5, (2, 400, 2))
    end[:, 1] *= 1.24
    found = balls.clear(start, end)
    times = np.linspace(0, 1, 1001)
    angles = start[:, 1, None] + (end - start)[:, 1, None] * times
    gaps = 2 * np.cos(angles / 2) - 0.3
    free, hit = (found.verdict == code for code in (hullmap.Verdict.FREE, hullmap.Verdict.HIT))
    np.testing.assert_array_equal(hit, gaps.min(1) < 0)
    assert (free | hit).all() and 20 < hit.sum() < 380
    assert (found.clearance[free] <= gaps.min(1)[free]).all() and (found.clearance[free] > 0).all()
    assert (found.clearance[free] >= 0.49 * gaps.min(1)[free]).all()
    first = times[(gaps < 0).argmax(1)]
    assert (found.t_lower[hit] <= first[hit]).all() and (first[hit] <= found.t_upper[hit] + 1e-3).all()
    assert (found.t_upper[hit] - found.t_lower[hit] <= 1e-3).all()
    one = balls.clear(start[0], end)
    assert one.shape == (400,)
    assert hullmap.Verdict.words(balls.clear([0, -2.8], [0, 2.8], max_queries=2).verdict) == ["open"]


def test_poses_of_the_caller(arm: hullmap.Robot) -> None:
    """Link poses by NumPy, and `Pairs` over the same shapes."""
    rng = np.random.default_rng(3)
    q = rng.uniform(-3.14, 3.14, (300, 2))
    poses = np.tile(np.eye(4), (300, 4, 1, 1))
    for at, (a, b) in enumerate(q):
        turn_a, turn_b, slide = np.eye(4), np.eye(4), np.eye(4)
        turn_a[:2, :2] = [[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]
        turn_b[[0, 0, 2, 2], [0, 2, 0, 2]] = np.cos(b), np.sin(b), -np.sin(b), np.cos(b)
        turn_b[0, 3], slide[0, 3] = 1, 1.1 + 0.1 * b + 0.05
        poses[at, 1], poses[at, 2], poses[at, 3] = turn_a, turn_a @ turn_b, turn_a @ turn_b @ slide
    by_joints, by_poses = arm.clearance(q), arm.clearance(poses=poses)
    np.testing.assert_allclose(by_joints.upper, by_poses.upper, atol=1e-12)
    np.testing.assert_array_equal(arm.in_collision(q), arm.in_collision(poses=poses))
    boxes = [hullmap.Box([0.1] * 3), hullmap.Box([0.48, 0.05, 0.05]), hullmap.Sphere(0.1)]
    moved = poses[:, [0, 2, 3]].copy()
    moved[:, 1] = moved[:, 1] @ np.block([[np.eye(3), np.array([[0.5], [0], [0]])], [np.zeros((1, 3)), np.ones((1, 1))]])
    pairs = hullmap.Pairs(boxes, [0, 0], [1, 2])
    gaps = pairs.distance(in_world=moved).distance.min(-1)
    apart = gaps > 0
    assert 100 < apart.sum() < 295
    np.testing.assert_allclose(by_joints.upper[apart], gaps[apart], atol=1e-5)


def test_obstacles_and_allowed_pairs(arm: hullmap.Robot, balls: hullmap.Robot, folder: pathlib.Path) -> None:
    post = (hullmap.Box([0.1, 0.1, 1]), hullmap.poses([0, 1.5, 0]))
    cubes = hullmap.bake_parts([(CUBE * 0.1 + [3, 0, 0], None), (CUBE * 0.1 - [3, 0, 0], None)])
    level = hullmap.TriangleMesh.from_arrays(np.array([[-3, -3, 1.5], [3, -3, 1.5], [0, 3, 1.5]]), [[0, 1, 2]])
    floor = hullmap.HalfSpace([0, 0, 1], -0.5)
    scene = arm.with_obstacles({"post": post, "floor": floor, "cubes": cubes, "level": level})
    assert scene.names[-4:] == ["post", "floor", "cubes", "level"] and arm.names == arm.link_names
    q = np.random.default_rng(4).uniform(-3, 3, (500, 2))
    hits, alone = scene.in_collision(q), arm.in_collision(q)
    assert (hits >= alone).all() and hits.sum() > alone.sum() + 50
    gaps = scene.clearance(q, gradient=True)
    np.testing.assert_array_equal(gaps.upper < 0, hits)
    assert len(set(gaps.pair[:, 1].tolist())) >= 4
    unique = np.flatnonzero(gaps.differentiability == hullmap.Differentiability.UNIQUE)
    assert len(unique) > 50
    step = 1e-6
    for joint in range(2):
        ends = [scene.clearance(q + sign * step * np.eye(2)[joint], tolerance=0) for sign in (1, -1)]
        slope = sum(sign * (end.lower + end.upper) / 2 for sign, end in zip((1, -1), ends)) / (2 * step)
        close = np.abs(slope - gaps.gradient[:, joint]) < 2e-3
        assert close[unique].mean() > 0.98
    found = scene.clear(q[:-1], q[1:])
    assert (found.verdict[hits[:-1]] == hullmap.Verdict.HIT).mean() > 0.99
    freed = scene.allowing([("post", "lower"), ("post", "tip")])
    assert len(freed.pairs) == len(scene.pairs) - 2 and len(scene.without_obstacles().pairs) == len(arm.pairs)
    (folder / "arm.srdf").write_text('<robot name="arm"><disable_collisions link1="base" link2="tip"/></robot>')
    assert len(hullmap.Robot.from_urdf(folder / "arm.urdf", srdf=folder / "arm.srdf").pairs) == len(arm.pairs) - 1
    assert balls.touching([0, 3.0]) == [("base", "lower")]
    copy = pickle.loads(pickle.dumps(freed))
    np.testing.assert_array_equal(copy.in_collision(q), freed.in_collision(q))


MOBILE = """<mujoco><worldbody><geom name="wall" type="box" size="0.1 2 1" pos="2 0 0"/>
  <body name="table" pos="0 2 0"><geom type="box" size="0.3 0.3 0.5"/></body>
  <body name="base"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
    <geom name="body" type="box" size="0.3 0.3 0.2"/><geom name="screen" size="0.1" contype="0"/></body>
  </worldbody>{}</mujoco>"""


def test_pairs_that_are_not_tested_have_reasons(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "mobile.xml"
    path.write_text(MOBILE.format(""))
    base = hullmap.Robot.from_mjcf(path, strict=True)
    q = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]
    assert base.in_collision(q).tolist() == [False, True, True]
    masks = "`contype` and `conaffinity` do not match"
    assert base.skipped == [(("world", "table"), (), "rigidly connected")]
    wall = base.allowing([("base", "world")])
    assert wall.in_collision(q).tolist() == [False, False, True] and wall.skipped[-1] == (("world", "base"), (), "allowed")
    again = pickle.loads(pickle.dumps(wall.disallowing([("world", "base")])))
    assert again.in_collision(q).tolist() == base.in_collision(q).tolist()
    path.write_text(MOBILE.format("").replace('pos="2 0 0"', 'pos="2 0 0" contype="0"'))
    names = hullmap.Skipped(links=("world", "base"), geoms=("wall", "screen"), reason=masks)
    assert names in hullmap.Robot.from_mjcf(path).skipped
    path.write_text(MOBILE.format('<contact><exclude body1="base" body2="world"/><exclude body1="base" body2="table"/></contact>'))
    assert not hullmap.Robot.from_mjcf(path).in_collision(q).any()
    path.write_text(MOBILE.format("").replace('type="box" size="0.1 2 1"', 'type="plane" size="1 1 1"'))
    floor = hullmap.Robot.from_mjcf(path)
    assert floor.skipped[0] == (("world",), ("wall",), "line 1: `plane` is not a mesh") and len(floor.notes) == 1
    with pytest.raises(hullmap.Error, match="mobile.xml: link `world`, line 1: not tested: `plane`"):
        hullmap.Robot.from_mjcf(path, strict=True)


def test_link_poses(arm: hullmap.Robot, balls: hullmap.Robot) -> None:
    q = np.random.default_rng(6).uniform(-3, 3, (4, 5, 2))
    poses = arm.link_poses(q)
    assert poses.shape == (4, 5, 4, 7) and arm.link_poses(q[0, 0]).shape == (4, 7)
    np.testing.assert_array_equal(arm.in_collision(poses=poses), arm.in_collision(q))
    tip = balls.link_poses(q)[..., 3, :3]
    np.testing.assert_allclose(tip, np.stack([np.cos(q[..., 0]), np.sin(q[..., 0]), 0 * q[..., 0]], -1), atol=1e-15)


def test_packs_take_the_place_of_meshes(folder: pathlib.Path, tmp_path: pathlib.Path, arm: hullmap.Robot) -> None:
    q = np.random.default_rng(5).uniform(-3, 3, (50, 2))
    hullmap.bake_file(folder / "meshes" / "cube.obj").save(tmp_path / "cube.hullmap")
    packed = hullmap.Robot.from_urdf(folder / "arm.urdf", packs=[tmp_path])
    np.testing.assert_allclose(packed.clearance(q).upper, arm.clearance(q).upper, atol=1e-9)
    hullmap.bake(CUBE * 2, name="cube").save(tmp_path / "cube.hullmap")
    with pytest.raises(hullmap.Error, match="was not baked from .*cube.obj"):
        hullmap.Robot.from_urdf(folder / "arm.urdf", packs=[tmp_path])


def test_progress_and_interrupts(balls: hullmap.Robot) -> None:
    q = np.zeros((100_000, 2))
    shares: list[float] = []
    balls.in_collision(q, progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0 and len(shares) >= 3

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        balls.clear(q, q, progress=stop)


def test_wrong_input(balls: hullmap.Robot, folder: pathlib.Path) -> None:
    with pytest.raises(FileNotFoundError):
        hullmap.Robot.from_urdf(folder / "gone.urdf")
    with pytest.raises(hullmap.Error, match="this is MJCF, not URDF: use Robot.from_mjcf"):
        hullmap.Robot.from_urdf(folder / "balls.xml")
    with pytest.raises(hullmap.Error, match="lists of folders"):
        hullmap.Robot.from_urdf(folder / "arm.urdf", packs=str(folder))
    with pytest.raises(hullmap.Error, match="nowhere: no such folder; name folders of packs"):
        hullmap.Robot.from_urdf(folder / "arm.urdf", packs=[folder / "nowhere"])
    with pytest.raises(hullmap.ArrayError, match=r"q: expected the shape \(..., 2\)"):
        balls.in_collision([0.0, 1.0, 2.0])
    with pytest.raises(hullmap.ArrayError, match="pass q, or poses"):
        balls.clearance()
    with pytest.raises(hullmap.ArrayError, match="poses have no joints"):
        balls.clearance(poses=np.tile(np.eye(4), (4, 1, 1)), gradient=True)
    with pytest.raises(hullmap.ArrayError, match="one for each of the 4 links"):
        balls.clearance(poses=np.tile(np.eye(4), (3, 1, 1)))
    with pytest.raises(hullmap.ArrayError, match="row 1: joint `b`: NaN is no position"):
        balls.in_collision([[0, 0], [0, np.nan]])
    with pytest.raises(hullmap.Error, match="`hand` is neither a link"):
        balls.allowing([("base", "hand")])
    with pytest.raises(hullmap.Error, match="has the name of another"):
        balls.with_obstacles({"base": hullmap.Sphere(1.0)})
    with pytest.raises(hullmap.ArrayError, match="margin must be"):
        balls.clear([0, 0], [0, 1], margin=-1.0)
    (folder / "broken.urdf").write_text('<robot name="r"><link name="l"><collision><geometry><box/></geometry></collision></link></robot>')
    with pytest.raises(hullmap.Error, match="broken.urdf:1: link `l`: the sizes of `box`"):
        hullmap.Robot.from_urdf(folder / "broken.urdf")
    (folder / "bare.urdf").write_text(
        '<robot name="r"><link name="l"><collision><geometry><mesh filename="gone.stl"/></geometry></collision></link></robot>'
    )
    # Advice for the command would not help here.
    with pytest.raises(hullmap.Error, match=r"no file `gone.stl`; restore it$"):
        hullmap.Robot.from_urdf(folder / "bare.urdf")


def test_robots_without_joints_or_pairs(folder: pathlib.Path) -> None:
    (folder / "one.urdf").write_text(
        '<robot name="r"><link name="l"><collision><geometry><sphere radius="1"/></geometry></collision></link></robot>'
    )
    robot = hullmap.Robot.from_urdf(folder / "one.urdf")
    found = robot.clearance(np.zeros((3, 0)), gradient=True)
    assert np.isinf(found.lower).all() and found.gradient.shape == (3, 0) and (found.pair == 2**32 - 1).all()
    assert not robot.in_collision(np.zeros((0, 0))).size
    edge = robot.clear(np.zeros(0), np.zeros(0))
    assert edge.verdict == hullmap.Verdict.FREE and np.isinf(edge.clearance)
    links = [f'<link name="{name}"/>' for name in "ab"]
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    (folder / "two.urdf").write_text(f'<robot name="r">{"".join(links)}{joint}</robot>')
    found = hullmap.Robot.from_urdf(folder / "two.urdf").clearance(np.zeros((3, 1)), gradient=True)
    assert found.gradient.shape == (3, 1) and found[0].gradient.shape == (1,)


def test_a_robot_of_an_sdf_file(tmp_path: pathlib.Path) -> None:
    """Two balls of radius 0.2, 1 apart, of which one slides towards the other."""
    ball = '<collision name="c"><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>'
    path = tmp_path / "slider.sdf"
    path.write_text(
        f"""<sdf version="1.9"><model name="slider"><link name="base">{ball}</link>
        <link name="middle"/><link name="slide"><pose>1 0 0 0 0 0</pose>{ball}</link>
        <joint name="r" type="revolute"><parent>base</parent><child>middle</child><axis><xyz>1 0 0</xyz>
        <limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
        <joint name="s" type="prismatic"><parent>middle</parent><child>slide</child>
        <axis><xyz>-1 0 0</xyz><limit><lower>0</lower><upper>1</upper></limit></axis></joint></model></sdf>"""
    )
    slider = hullmap.Robot.from_sdf(path)
    assert slider.in_collision([[0.0, 0.0], [0.5, 0.59], [0.5, 0.61]]).tolist() == [False, False, True]
    with pytest.raises(hullmap.Error, match="this is SDF, not MJCF: use Robot.from_sdf"):
        hullmap.Robot.from_mjcf(path)
    assert pickle.loads(pickle.dumps(slider)).joint_names == slider.joint_names
