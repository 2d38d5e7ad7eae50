"""`hullmap.torch` and `hullmap.jax`: their own checks of gradients, and places without a derivative. Derivatives of
normals and witness points, against central differences."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

import hullmap
from conftest import CUBE, random_poses, rock
from test_motion import turned

HULL = hullmap.bake(rock(40, 3))[0]
OTHER = hullmap.Box([0.5, 0.4, 0.3])


def smooth_poses(of: str, count: int, a: Any = HULL, b: Any = OTHER) -> np.ndarray:
    """Poses with a derivative, and without a kink within a millionth of a metre or of a radian."""
    poses = random_poses(40 * count, 11, 2.5)
    gap = a.distance(b, poses, tolerance=0).distance
    poses = poses[gap > 0.05] if of == "distance" else poses[a.contact(b, poses, tolerance=0).depth > 0.05]
    kept = np.ones(len(poses), bool)
    normals = []
    for twist in np.concatenate((np.zeros((1, 6)), np.eye(6), -np.eye(6))) * 2e-6:
        found = hullmap.derivatives(a, b, turned(poses, twist), of=of, tolerance=0)
        kept &= found.differentiability == hullmap.Differentiability.UNIQUE
        normals.append(found.by_b)
    kept &= (np.abs(np.array(normals) - normals[0]).max(axis=(0, 2)) < 1e-4)
    assert kept.sum() >= count, (of, kept.sum())
    return poses[kept][:count]


def split(b_in_a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses of A and of B in a world, for poses of B in A's frame."""
    a = random_poses(len(b_in_a), 12, 1.0)
    x, y, z, w = np.moveaxis(a[:, 3:], -1, 0)
    rotation = np.stack(
        (w, -z, y, x, z, w, -x, y, -y, x, w, z, -x, -y, -z, w), axis=-1
    ).reshape(-1, 4, 4)
    axis = a[:, 3:6]
    across = 2 * np.cross(axis, b_in_a[:, :3])
    place = a[:, :3] + b_in_a[:, :3] + w[:, None] * across + np.cross(axis, across)
    return a, np.concatenate((place, np.einsum("nij,nj->ni", rotation, b_in_a[:, 3:])), axis=-1)


def torch_module() -> Any:
    pytest.importorskip("torch")
    return importlib.import_module("hullmap.torch")


def jax_module() -> Any:
    pytest.importorskip("jax").config.update("jax_enable_x64", True)
    return importlib.import_module("hullmap.jax")


@pytest.mark.parametrize("of, at", [("distance", "distance"), ("depth", "depth"), ("clearance", "distance"), ("clearance", "depth")])
def test_torch_agrees_with_its_differences(of, at):
    module, torch = torch_module(), pytest.importorskip("torch")
    rows = smooth_poses(at, 12)
    query = getattr(module, of)
    pose = torch.tensor(rows, requires_grad=True)
    assert torch.autograd.gradcheck(lambda own: query(HULL, OTHER, own, strict=True), pose, eps=1e-6, atol=2e-5)
    # A quaternion of another length is the same rotation.
    longer = rows * [1, 1, 1, 1.7, 1.7, 1.7, 1.7]
    pose = torch.tensor(longer, requires_grad=True)
    assert torch.autograd.gradcheck(lambda own: query(HULL, OTHER, own), pose, eps=1e-6, atol=2e-5)
    both = [torch.tensor(own, requires_grad=True) for own in split(rows)]
    check = lambda a, b: query(HULL, OTHER, a_in_world=a, b_in_world=b)
    assert torch.autograd.gradcheck(check, both, eps=1e-6, atol=2e-5)


@pytest.mark.parametrize("of", ["distance", "depth", "clearance"])
def test_jax_agrees_with_its_differences(of):
    module, jax = jax_module(), pytest.importorskip("jax")
    from jax.test_util import check_grads

    rows = smooth_poses("depth" if of == "depth" else "distance", 12)
    query = getattr(module, of)
    check_grads(lambda own: query(HULL, OTHER, own, strict=True), (rows,), 1, modes=["rev"], eps=1e-6, atol=2e-5, rtol=2e-5)
    check = lambda a, b: query(HULL, OTHER, a_in_world=a, b_in_world=b)
    check_grads(check, split(rows), 1, modes=["rev"], eps=1e-6, atol=2e-5, rtol=2e-5)
    whole = jax.grad(lambda own: query(HULL, OTHER, own).sum())(rows)
    single = jax.jit(jax.vmap(jax.grad(lambda own: query(HULL, OTHER, own))))(rows)
    np.testing.assert_array_equal(whole, single)
    # 32-bit numbers stay so.
    small = jax.grad(lambda own: query(HULL, OTHER, own).sum())(rows.astype(np.float32))
    assert small.dtype == np.float32
    np.testing.assert_allclose(small, whole, atol=1e-3)


def test_torch_and_jax_agree():
    (torch_queries, torch), (jax_queries, jax) = (torch_module(), pytest.importorskip("torch")), (jax_module(), pytest.importorskip("jax"))
    rows = random_poses(200, 13, 2.0)
    for of in ("distance", "depth", "clearance"):
        pose = torch.tensor(rows, requires_grad=True)
        value = getattr(torch_queries, of)(HULL, OTHER, pose)
        value.sum().backward()
        query = lambda own: getattr(jax_queries, of)(HULL, OTHER, own)
        np.testing.assert_array_equal(value.detach().numpy(), query(rows))
        np.testing.assert_array_equal(pose.grad.numpy(), jax.grad(lambda own: query(own).sum())(rows))
        # Without a gradient, the value comes from the plain query.
        np.testing.assert_allclose(getattr(torch_queries, of)(HULL, OTHER, torch.tensor(rows)), query(rows), atol=1e-12)
    gap = HULL.distance(OTHER, rows, tolerance=0).distance
    assert 20 < (gap > 0).sum() < 180
    np.testing.assert_array_equal(np.sign(query(rows)), np.where(gap > 0, 1, -1))
    near = torch_queries.perturbed(torch.tensor(rows), radius=0.1, angle=0.2, seed=3).numpy()
    np.testing.assert_allclose(near, jax_queries.perturbed(jax.numpy.asarray(rows), radius=0.1, angle=0.2, seed=3), atol=1e-15)


def test_places_without_a_derivative():
    module, torch = torch_module(), pytest.importorskip("torch")
    cube = hullmap.bake(CUBE)[0]
    # Parallel faces; as deep along two axes; touching; apart.
    poses = hullmap.poses([[3, 0.25, 0.5], [1.5, 1.5, 0.25], [2, 0, 0], [4, 3, 0.1]])
    pose = torch.tensor(poses, requires_grad=True)
    module.clearance(cube, cube, pose).sum().backward()
    assert np.isfinite(pose.grad.numpy()).all()
    np.testing.assert_allclose(pose.grad.numpy()[0, :3], [1, 0, 0], atol=1e-9)
    pose = torch.tensor(poses, requires_grad=True)
    module.clearance(cube, cube, pose, strict=True).sum().backward()
    assert np.isnan(pose.grad.numpy()[:3]).all(axis=1).all()
    # A depth of 0 stays 0 nearby.
    pose = torch.tensor(poses[3], requires_grad=True)
    module.depth(cube, cube, pose, strict=True).backward()
    assert not pose.grad.numpy().any()
    pose = torch.tensor(hullmap.poses([0.1, 0.2, 0.3]), requires_grad=True)
    module.distance(cube, cube, pose, strict=True).backward()
    assert not pose.grad.numpy().any()
    with pytest.raises(hullmap.ArrayError, match="expected poses of the shape"):
        module.distance(cube, cube, torch.zeros(3))
    with pytest.raises(hullmap.ArrayError, match="pass either b_in_a, or both"):
        module.distance(cube, cube, a_in_world=pose)
    with pytest.raises(hullmap.PoseError):
        module.distance(cube, cube, torch.zeros(7))


def test_signed_distances_of_points():
    module, torch = torch_module(), pytest.importorskip("torch")
    point = hullmap.Sphere(0)
    places = np.random.default_rng(5).uniform(-1.5, 1.5, size=(200, 3))
    pose = torch.tensor(hullmap.poses(places), requires_grad=True)
    found = module.clearance(HULL, point, pose)
    truth = HULL.signed_distance(places, tolerance=0)
    np.testing.assert_allclose(found.detach().numpy(), truth.distance, atol=1e-9)
    found.sum().backward()
    close = np.linalg.norm(pose.grad.numpy()[:, :3] - truth.normal, axis=-1) < 1e-6
    assert close.mean() > 0.98 and np.abs(pose.grad.numpy()[:, 3:]).max() < 1e-12


def test_the_mean_over_perturbed_poses_is_smooth():
    module, torch = torch_module(), pytest.importorskip("torch")
    cube = hullmap.bake(CUBE)[0]
    radius, angle = 0.02, 0.03
    # Across the pose at which faces are parallel, by a turn about z.
    turns = np.linspace(-0.02, 0.02, 41)
    rotations = np.stack((0 * turns, 0 * turns, np.sin(turns / 2), np.cos(turns / 2)), axis=-1)
    rows = hullmap.poses(np.broadcast_to([3.0, 0.0, 0.0], (41, 3)), rotations)

    def slopes(samples: int) -> tuple[np.ndarray, np.ndarray]:
        pose = torch.tensor(rows, requires_grad=True)
        near = module.perturbed(pose, radius=radius, angle=angle, samples=samples)
        value = module.clearance(cube, cube, near).mean(0)
        value.sum().backward()
        return value.detach().numpy(), pose.grad.numpy()

    exact = torch.tensor(rows, requires_grad=True)
    value = module.clearance(cube, cube, exact)
    value.sum().backward()
    smooth, gradient = slopes(512)
    reach = np.sqrt(3)
    assert (np.abs(smooth - value.detach().numpy()) <= radius + angle * reach).all()
    jump = lambda own: np.abs(np.diff(own[:, 5])).max()
    assert jump(exact.grad.numpy()) > 1.5 and jump(gradient) < 0.4
    # A linear value is not changed: a face and a corner.
    far = torch.tensor(hullmap.poses([5.0, 0.1, 0.2]))
    ball = hullmap.Sphere(0.5)
    plain = module.clearance(cube, ball, far)
    mean = module.clearance(cube, ball, module.perturbed(far, radius=0.1)).mean(0)
    assert float(mean) == pytest.approx(float(plain), abs=1e-12)
    with pytest.raises(hullmap.ArrayError, match="even number"):
        module.perturbed(far, radius=0.1, samples=3)


ARM = """<mujoco><worldbody><body name="base"><geom type="sphere" size="0.1"/>
  <body name="upper"><joint name="a" axis="0 0 1"/>
    <body name="lower" pos="1 0 0"><joint name="b" axis="0 1 0"/>
      <geom type="box" size="0.1 0.2 0.3" pos="1 0 0"/></body></body></body></worldbody></mujoco>"""


def test_clearances_of_robots(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    wall = (hullmap.Box([0.1, 2, 2]), hullmap.poses([2.6, 0, 0]))
    robot = hullmap.Robot.from_mjcf(path).with_obstacles({"wall": wall})
    q = np.array([[0.3, 0.4], [-0.2, 1.1]])
    module, torch = torch_module(), pytest.importorskip("torch")
    own = torch.tensor(q, requires_grad=True)
    assert torch.autograd.gradcheck(lambda own: module.robot_clearance(robot, own, strict=True), own, eps=1e-6, atol=1e-5)
    other = jax_module()
    jax = pytest.importorskip("jax")
    slopes = jax.grad(lambda own: other.robot_clearance(robot, own).sum())(q)
    np.testing.assert_allclose(slopes, robot.clearance(q, gradient=True, tolerance=0).gradient, atol=1e-12)


def random_rays(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays of which most hit, from outside, with directions of any length."""
    rng = np.random.default_rng(seed)
    origins = rng.normal(size=(count, 3))
    origins *= 4 / np.linalg.norm(origins, axis=-1, keepdims=True)
    return origins, (rng.uniform(-0.8, 0.8, size=(count, 3)) - origins) * rng.uniform(0.3, 2, size=(count, 1))


def test_derivatives_of_rays_agree_with_differences():
    origins, directions = random_rays(400, 31)
    found = hullmap.ray_derivatives(HULL, origins, directions, tolerance=0)
    t = lambda o, d: HULL.ray(o, d, tolerance=0).t
    unique = found.differentiability == hullmap.Differentiability.UNIQUE
    missing = found.differentiability == hullmap.Differentiability.MISSING
    assert unique.sum() > 200 and missing.sum() > 5
    np.testing.assert_array_equal(found.value, t(origins, directions))
    step, off = 1e-6, np.zeros(400)
    for axis in range(6):
        move = np.eye(6)[axis] * step
        turn = lambda sign: directions + sign * np.cross(move[3:], directions)
        after, before = (t(origins + sign * move[:3], turn(sign)) for sign in (1, -1))
        with np.errstate(invalid="ignore"):
            truth = (after - before) / (2 * step)
        off = np.maximum(off, np.abs(found.by_b[:, axis] - truth) / (1 + np.abs(truth)))
    # A ray that meets an edge within the step is rare.
    assert (off[unique] > 1e-5).mean() < 0.02, np.sort(off[unique])[-10:]
    with pytest.raises(hullmap.ShapeError, match="convex"):
        hullmap.ray_derivatives(hullmap.HalfSpace([0, 0, 1], 0), [0, 0, 1], [0, 0, -1])


def smooth_rays() -> tuple[np.ndarray, np.ndarray]:
    """Rays that meet the same face from all places nearby."""
    origins, directions = random_rays(200, 32)
    hit = HULL.ray(origins, directions, tolerance=0)
    kept = hit.hit.copy()
    for shift in np.concatenate((np.eye(3), -np.eye(3))) * 1e-3:
        near = HULL.ray(origins + shift, directions, tolerance=0)
        kept &= near.hit & (np.abs(near.normal - hit.normal).max(-1) < 1e-9)
    assert kept.sum() > 30, kept.sum()
    return origins[kept][:20], directions[kept][:20]


def test_torch_differentiates_rays():
    module, torch = torch_module(), pytest.importorskip("torch")
    rays = [torch.tensor(own, requires_grad=True) for own in smooth_rays()]
    check = lambda origins, directions: module.ray(HULL, origins, directions, tolerance=0, strict=True)
    assert torch.autograd.gradcheck(check, rays, eps=1e-6, atol=2e-5)
    miss = torch.tensor([0.0, 0.0, 5.0], requires_grad=True)
    t = module.ray(HULL, miss, torch.tensor([0.0, 0.0, 1.0]), strict=True)
    t.backward()
    assert t == float("inf") and (miss.grad == 0).all()
    with pytest.raises(hullmap.ArrayError, match="vectors of the shape"):
        module.ray(HULL, torch.zeros(4), torch.zeros(4))


def test_jax_differentiates_rays():
    module = jax_module()
    from jax.test_util import check_grads

    check = lambda origins, directions: module.ray(HULL, origins, directions, tolerance=0, strict=True)
    check_grads(check, smooth_rays(), 1, modes=["rev"], eps=1e-6, atol=2e-5, rtol=2e-5)


def impacts(motions: np.ndarray, others: np.ndarray) -> hullmap.TimeOfImpact:
    """Times of impact of motions of 13 numbers."""
    screws = [
        hullmap.Motion.screw(own[:, :7], linear=own[:, 7:10], angular=own[:, 10:], center=own[:, :3])
        for own in (motions, others)
    ]
    return hullmap.cast_motion(HULL, OTHER, *screws, tolerance=0)


def smooth_motions() -> tuple[np.ndarray, np.ndarray]:
    """Motions of both shapes that meet at the same features from all places nearby. Some do not turn."""
    rng = np.random.default_rng(41)
    count = 120
    start_a, start_b = random_poses(count, 42, 0.3), random_poses(count, 43, 1.0)
    start_b[:, :3] *= 3.5 / np.linalg.norm(start_b[:, :3], axis=1, keepdims=True)
    own = lambda scale: rng.normal(size=(count, 3)) * scale
    turns = own(1.0) * (np.arange(count) % 4 != 0)[:, None]
    a = np.concatenate((start_a, own(0.1), own(0.5)), axis=1)
    b = np.concatenate((start_b, -start_b[:, :3] + own(0.3), turns), axis=1)
    found = impacts(a, b)
    kept = found.hit & (found.differentiability == hullmap.Differentiability.UNIQUE) & (found.t_lower > 0.05)
    for shift in np.concatenate((np.eye(6), -np.eye(6))) * 1e-4:
        moved = b.copy()
        moved[:, :7] = turned(b[:, :7], shift)
        near = impacts(a, moved)
        kept &= near.hit & (np.abs(near.by_b - found.by_b).max(-1) < 1e-2)
    still = ~turns.any(-1)
    assert (kept & still).sum() > 4 and (kept & ~still).sum() > 12, (kept & still).sum()
    chosen = np.concatenate((np.flatnonzero(kept & still)[:3], np.flatnonzero(kept & ~still)[:9]))
    return a[chosen], b[chosen]


def test_torch_differentiates_times_of_impact():
    module, torch = torch_module(), pytest.importorskip("torch")
    motions = [torch.tensor(own, requires_grad=True) for own in smooth_motions()]
    check = lambda a, b: module.time_of_impact(HULL, OTHER, a, b, tolerance=0, strict=True)
    assert torch.autograd.gradcheck(check, motions, eps=1e-5, atol=1e-4)
    away = motions[1].detach().clone()
    away[:, 7:10] *= -1
    away.requires_grad_()
    t = module.time_of_impact(HULL, OTHER, motions[0].detach(), away, strict=True)
    t.sum().backward()
    assert (t == float("inf")).all() and (away.grad == 0).all()
    with pytest.raises(hullmap.ArrayError, match="motions of the shape"):
        module.time_of_impact(HULL, OTHER, torch.zeros(7), torch.zeros(7))


def test_jax_differentiates_times_of_impact_as_torch_does():
    jax, module = pytest.importorskip("jax"), jax_module()
    torch, torch_queries = pytest.importorskip("torch"), torch_module()
    rows = smooth_motions()
    motions = [torch.tensor(own, requires_grad=True) for own in rows]
    torch_queries.time_of_impact(HULL, OTHER, *motions).sum().backward()
    time = lambda a, b: module.time_of_impact(HULL, OTHER, a, b).sum()
    found = jax.jit(jax.grad(time, argnums=(0, 1)))(*rows)
    for own, other in zip(found, motions):
        np.testing.assert_array_equal(own, other.grad.numpy())


def test_missing_modules_name_their_extra(monkeypatch):
    gradients = importlib.import_module("hullmap._gradients")
    with pytest.raises(hullmap.Error, match=r"pip install hullmap\[nothing_of_that_name\]"):
        gradients.required("nothing_of_that_name")


@pytest.mark.parametrize("of", ["distance", "depth"])
@pytest.mark.parametrize("b", [OTHER, hullmap.Capsule(0.6, 0.3), hullmap.Cylinder(0.5, 0.3)], ids=["box", "capsule", "cylinder"])
def test_derivatives_of_normals_and_points_agree_with_differences(of, b):
    poses = random_poses(600, 21, 2.5)
    found = hullmap.witness_derivatives(HULL, b, poses, of=of, tolerance=0)
    unique = found.differentiability == hullmap.Differentiability.UNIQUE
    is_curved = isinstance(b, hullmap.Cylinder)
    assert unique.sum() > (1 if is_curved else 40) and found.normal_by_a.shape == (600, 3, 6)
    assert not found.point_a_by_b[~unique].any()
    step = 1e-5
    off = np.zeros(600)
    query = HULL.distance if of == "distance" else HULL.contact
    for axis in range(6):
        twist = np.eye(6)[axis] * step
        after, before = (query(b, turned(poses, sign * twist), tolerance=0) for sign in (1, -1))
        for name in ("normal", "point_a", "point_b"):
            truth = (getattr(after, name) - getattr(before, name)) / (2 * step)
            own = getattr(found, f"{name}_by_b")[:, :, axis]
            off = np.maximum(off, np.abs(own - truth).max(-1) / (1 + np.abs(truth).max(-1)))
    # A kink within the step is rare.
    assert (off[unique] > 1e-4).mean() < 0.02, np.sort(off[unique])[-20:]
    if is_curved:
        assert (found.differentiability == hullmap.Differentiability.CURVED).sum() > 40
