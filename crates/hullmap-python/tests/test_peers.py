"""The same answers as other engines, within their own errors. Engines that are not installed are
skipped."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CUBE, Body, brute_depth, matrices, random_poses, rock

import hullmap


@pytest.fixture(scope="module")
def scene():
    """Two rocks of some hundred vertices, and poses of which about half overlap."""
    a, b = hullmap.bake(rock(400, 11), name="a")[0], hullmap.bake(rock(300, 12), name="b")[0]
    poses = random_poses(400, 13, 3.2)
    gaps, contacts = a.distance(b, poses, tolerance=1e-10), a.contact(b, poses, tolerance=1e-10)
    assert 0.3 < contacts.hit.mean() < 0.7
    return a, b, poses, gaps, contacts


def scalar_first(poses):
    return np.roll(poses[:, 3:], 1, axis=1)


def judge(scene, found, count=3):
    """Where an engine's depths differ most, separating axes decide for hullmap."""
    a, b, poses, _, contacts = scene
    differences = np.where(contacts.hit, abs(found - contacts.depth), 0)
    for row in np.argsort(differences)[-count:]:
        truth = brute_depth(Body(a), Body(b, poses[row]))
        assert contacts.depth[row] == pytest.approx(truth, abs=1e-7), (row, found[row], truth)


def test_coal(scene):
    coal = pytest.importorskip("coal")
    a, b, poses, gaps, contacts = scene
    first, second = (coal.Convex(points_of(coal, hull), triangles_of(coal, hull)) for hull in (a, b))
    identity = coal.Transform3s()
    found = []
    for frame in matrices(poses):
        request, result = coal.DistanceRequest(True, 0.0, 0.0), coal.DistanceResult()
        request.gjk_tolerance = request.epa_tolerance = 1e-8
        request.enable_signed_distance = True
        place = coal.Transform3s(frame[:3, :3], frame[:3, 3])
        found.append(coal.distance(first, identity, second, place, request, result))
    found = np.array(found)
    # Its error comes from its tolerance and from EPA's facets.
    assert np.allclose(found[~contacts.hit], gaps.distance[~contacts.hit], atol=1e-6)
    assert np.allclose(-found[contacts.hit], contacts.depth[contacts.hit], atol=1e-5)
    judge(scene, -found)


def points_of(coal, hull):
    points = coal.StdVec_Vec3s()
    for vertex in hull.vertices.astype(float):
        points.append(vertex)
    return points


def triangles_of(coal, hull):
    triangles = coal.StdVec_Triangle() if hasattr(coal, "StdVec_Triangle") else coal.StdVec_Triangle32()
    kind = coal.Triangle if hasattr(coal, "Triangle") else coal.Triangle32
    for corners in hull.triangles.tolist():
        triangles.append(kind(*corners))
    return triangles


def test_fcl(scene):
    fcl = pytest.importorskip("fcl")
    a, b, poses, gaps, contacts = scene
    bodies = []
    for hull in (a, b):
        faces = np.concatenate([np.concatenate(([len(face)], face)) for face in hull.faces])
        bodies.append(fcl.Convex(hull.vertices.astype(float), len(hull.faces), faces))
    first = fcl.CollisionObject(bodies[0], fcl.Transform())
    distances, hits, depths = [], [], []
    for pose, turn in zip(poses, scalar_first(poses)):
        second = fcl.CollisionObject(bodies[1], fcl.Transform(turn, pose[:3]))
        contact = fcl.CollisionResult()
        hits.append(fcl.collide(first, second, fcl.CollisionRequest(enable_contact=True), contact) > 0)
        depths.append(contact.contacts[0].penetration_depth if contact.contacts else 0.0)
        request = fcl.DistanceRequest(gjk_solver_type=fcl.GJKSolverType.GST_INDEP)
        distances.append(fcl.distance(first, second, request, fcl.DistanceResult()))
    distances = np.array(distances)
    apart = ~contacts.hit
    assert (np.array(hits) == contacts.hit).mean() > 0.99
    assert np.allclose(distances[apart], gaps.distance[apart], rtol=1e-3, atol=1e-5)
    # Its depths are often far off, so nothing is asserted about them.
    judge(scene, np.array(depths))


def test_mujoco(scene):
    mujoco = pytest.importorskip("mujoco")
    a, b, poses, gaps, _ = scene
    text = "\n".join(
        [
            "<mujoco><asset>",
            *(f'<mesh name="{hull.name}" vertex="{" ".join(map(repr, hull.vertices.ravel().tolist()))}"/>' for hull in (a, b)),
            '</asset><worldbody><geom type="mesh" mesh="a"/><body mocap="true"><geom type="mesh" mesh="b"/></body>',
            "</worldbody></mujoco>",
        ]
    )
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-10, 200
    data = mujoco.MjData(model)
    found, segment = [], np.zeros(6)
    for pose, turn in zip(poses, scalar_first(poses)):
        data.mocap_pos[0], data.mocap_quat[0] = pose[:3], turn
        mujoco.mj_kinematics(model, data)
        found.append(mujoco.mj_geomDistance(model, data, 0, 1, 10.0, segment))
    found = np.array(found)
    # The bodies' meshes are stored as 32-bit floats, relative to their centres of mass.
    apart = gaps.distance > 0
    assert np.allclose(found[apart], gaps.distance[apart], atol=1e-5)
    assert (found[~apart] <= 1e-6).all()


def test_a_model_of_mjcf_loads_and_weighs_the_same():
    mujoco = pytest.importorskip("mujoco")
    pack = hullmap.bake_parts([(CUBE, None), (rock(200, 3) + [5, 0, 0], None)], names=["cube", "rock"])
    model = mujoco.MjModel.from_xml_string(hullmap.to_mjcf(pack, "two"))
    assert model.nmesh == 2 and model.ngeom == 2
    assert model.body_mass[1] == pytest.approx(1000 * sum(hull.volume for hull in pack), rel=1e-5)
    frame = np.zeros(9)
    mujoco.mju_quat2Mat(frame, model.body_iquat[1])
    turn = frame.reshape(3, 3)
    inertia = turn @ np.diag(model.body_inertia[1]) @ turn.T
    center = sum(hull.volume * hull.centroid for hull in pack) / sum(hull.volume for hull in pack)
    assert np.allclose(model.body_ipos[1], center, atol=1e-5)
    expected = np.zeros((3, 3))
    for hull in pack:
        own, arm = hull.mass_properties(1000), hull.centroid - center
        expected += own.inertia + own.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    assert np.allclose(inertia, expected, rtol=1e-4, atol=1e-4 * np.trace(expected))


def test_parts_weigh_as_much_as_their_mesh():
    """The parts of a torus overlap. MuJoCo adds their masses, unless the model states the mesh's."""
    mujoco = pytest.importorskip("mujoco")
    trimesh = pytest.importorskip("trimesh")
    torus = trimesh.creation.torus(1.0, 0.35, major_sections=48, minor_sections=24)
    pack = hullmap.bake(torus.vertices, torus.faces, decompose=True, max_error="4%")
    model = mujoco.MjModel.from_xml_string(hullmap.to_mjcf(pack, "torus", density=500.0))
    assert model.body_mass[1] == pytest.approx(500 * torus.volume, rel=1e-6)
    assert np.allclose(np.sort(model.body_inertia[1]), np.sort(500 * np.diag(torus.moment_inertia)), rtol=1e-5)
    assert sum(hull.volume for hull in pack) > 1.1 * torus.volume
    body = pack.mass_properties(500.0)
    assert body.source == "mesh" and body.mass == pytest.approx(model.body_mass[1])
    assert pack[0].mesh_mass_properties(500.0).mass == body.mass
    flat = hullmap.bake(torus.vertices, torus.faces[:-1]).mass_properties()
    assert flat.source == "hulls" and flat.mass > torus.volume


def test_a_link_of_urdf_loads(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    pack = hullmap.bake_parts([(CUBE, None), (rock(200, 3) + [5, 0, 0], None)], names=["cube", "rock"])
    link = hullmap.to_urdf(pack, tmp_path, "base")
    path = tmp_path / "robot.urdf"
    extension = '<mujoco><compiler discardvisual="false" fusestatic="false" strippath="false"/></mujoco>'
    path.write_text(f'<robot name="r">{extension}{link}</robot>')
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.nmesh == 2


def test_trimesh(scene):
    trimesh = pytest.importorskip("trimesh")
    hull = scene[0]
    mesh = hullmap.to_trimesh(hull)
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(hull.volume, rel=1e-9) and mesh.area == pytest.approx(hull.surface_area, rel=1e-9)
    assert np.allclose(mesh.center_mass, hull.centroid, atol=1e-9)
    assert np.allclose(mesh.moment_inertia, hull.inertia, rtol=1e-6, atol=1e-9)
    again = hullmap.from_trimesh(mesh)[0]
    assert (again.vertices == hull.vertices).all()
    cloud = hullmap.from_trimesh(trimesh.PointCloud(CUBE))[0]
    assert cloud.volume == pytest.approx(8)
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box(), node_name="one")
    scene.add_geometry(trimesh.creation.box(), node_name="two", transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    pack = hullmap.from_trimesh(scene)
    assert sorted(pack.names) == ["one", "two"] and np.allclose(pack["two"].centroid, [3, 0, 0])
    with pytest.raises(hullmap.ArrayError, match="expected a mesh, a point cloud or a scene"):
        hullmap.from_trimesh(5)


def test_scipy():
    spatial = pytest.importorskip("scipy.spatial")
    points = rock(2000, 5)
    hull, other = hullmap.bake(points)[0], spatial.ConvexHull(points.astype(float))
    assert set(hull.source_vertices.tolist()) == set(other.vertices.tolist())
    assert hull.volume == pytest.approx(other.volume, rel=1e-9)
    assert hull.surface_area == pytest.approx(other.area, rel=1e-9)


def test_scipy_rotations_are_poses():
    transform = pytest.importorskip("scipy.spatial.transform")
    turns = transform.Rotation.random(20, random_state=1)
    poses = hullmap.poses(np.zeros((20, 3)), turns.as_quat())
    assert np.allclose(matrices(poses)[:, :3, :3], turns.as_matrix())
    assert np.allclose(matrices(hullmap.poses(np.zeros((20, 3)), turns.as_matrix())), matrices(poses), atol=1e-12)
