"""Judges `hullmap.Robot` by Pinocchio and coal, and by samples along edges; measures it beside MuJoCo.

    check_planner.py CONFIGURATIONS EDGES FILE...

For each URDF, with all pairs of links that hullmap tests:

- link poses equal Pinocchio's;
- a configuration collides if and only if coal finds that the convex hulls of the meshes do, up to the rounding
  of both. Where they differ, coal is queried once more, without its memory of the last configuration;
- whenever the meshes themselves collide, by coal's triangles, so do the hulls: no collision is missed;
- clearances equal coal's;
- a free edge is free at 1,000 steps, with at least its clearance; the first hit of the steps is not before the
  interval of a hit edge, nor after it by more than a step.

First coal and MuJoCo answer a robot of two known boxes, in the way that they are measured. Times are CPU seconds of
one thread. They are printed, and decide nothing.
"""

import pathlib
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import numpy as np

try:
    import coal
    import pinocchio

    import hullmap
except ImportError as error:
    print(f"skipped: planner: {error}")
    sys.exit()
try:
    import mujoco
except ImportError:
    mujoco = None

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "benches/peers"))
import known  # noqa: E402

SEED = 40
STEPS = 1000
# Metres within which coal and hullmap may disagree about touching: coal's tolerance, and rounding.
ROUNDING = 2e-5


class Reference:
    """A robot by Pinocchio, with the pairs that hullmap tests."""

    def __init__(self, file, folders, robot, is_convex):
        self.robot, self.model = robot, pinocchio.buildModelFromUrdf(str(file))
        self.data = self.model.createData()
        kind = pinocchio.GeometryType.COLLISION
        self.shapes = pinocchio.buildGeomFromUrdf(self.model, str(file), kind, [str(folder) for folder in folders])
        if is_convex:
            for item in self.shapes.geometryObjects:
                if isinstance(item.geometry, coal.BVHModelBase):
                    item.geometry.buildConvexHull(True, "Qt")
                    item.geometry = item.geometry.convex
        self.links = [self.model.frames[item.parentFrame].name for item in self.shapes.geometryObjects]
        names, tested = robot.names, {frozenset(pair) for pair in robot.pairs.tolist()}
        index = {name: at for at, name in enumerate(names)}
        for b in range(len(self.links)):
            for a in range(b):
                if frozenset((index[self.links[a]], index[self.links[b]])) in tested:
                    self.shapes.addCollisionPair(pinocchio.CollisionPair(a, b))
        self.found = pinocchio.GeometryData(self.shapes)
        self.follow = followers(file)

    def configuration(self, q):
        """Hullmap's numbers as Pinocchio's: a continuous joint has a cosine and a sine."""
        value = dict(zip(self.robot.joint_names, q))
        for name, (leader, factor, offset) in self.follow.items():
            value[name] = factor * value.get(leader, 0.0) + offset
        out = pinocchio.neutral(self.model)
        for joint in range(1, self.model.njoints):
            at, width = self.model.idx_qs[joint], self.model.nqs[joint]
            own = value.get(self.model.names[joint], 0.0)
            out[at : at + width] = [own] if width == 1 else [np.cos(own), np.sin(own)]
        return out

    def collides(self, q, first_only=True):
        return pinocchio.computeCollisions(self.model, self.data, self.shapes, self.found, q, first_only)

    def collides_afresh(self, q):
        """Clears coal's cache of the last configuration, which has made it miss collisions."""
        self.found = pinocchio.GeometryData(self.shapes)
        return self.collides(q, first_only=False)

    def clearance(self, q):
        pinocchio.computeDistances(self.model, self.data, self.shapes, self.found, q)
        return min(result.min_distance for result in self.found.distanceResults)

    def poses(self, q):
        """Poses of hullmap's links."""
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        frames = [self.data.oMf[self.model.getFrameId(name)].homogeneous for name in self.robot.link_names]
        return np.array(frames)


def followers(file):
    """The joints that follow others: leader, factor and offset."""
    found = {}
    for joint in ElementTree.parse(file).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            own = mimic.attrib
            found[joint.get("name")] = (own["joint"], float(own.get("multiplier", 1)), float(own.get("offset", 0)))
    return found


def cpu(run):
    """The result of a call, and its CPU seconds."""
    start = time.process_time()
    return run(), time.process_time() - start


def check(file, count, edges, random):
    folders = list(file.parents)[:6]
    packages = [folder for folder in folders if folder != pathlib.Path("/")]
    robot = hullmap.Robot.from_urdf(file, packages=packages)
    neutral = np.clip(robot.neutral, *robot.limits.T)
    # Links that touch in the neutral pose are no collisions.
    robot = robot.allowing(robot.touching(neutral))
    if not len(robot.pairs):
        return f"{file.name}: no pairs"
    hulls, meshes = (Reference(file, folders, robot, is_convex) for is_convex in (True, False))
    low, high = (np.where(np.isfinite(end), end, sign * np.pi) for end, sign in zip(robot.limits.T, (-1, 1)))
    qs = random.uniform(low, high, (count, len(low)))
    found, seconds = cpu(lambda: robot.in_collision(qs, threads=1))
    gaps, gap_seconds = cpu(lambda: robot.clearance(qs, threads=1))
    theirs = [hulls.configuration(q) for q in qs]
    expected, coal_seconds = cpu(lambda: np.array([hulls.collides(q) for q in theirs]))
    distances, coal_gap_seconds = cpu(lambda: np.array([hulls.clearance(q) for q in theirs]))
    of_meshes = np.array([meshes.collides(q) for q in theirs[: max(2000, count // 4)]])
    poses = np.array([hulls.poses(q) for q in theirs[:200]])
    given, own = robot.clearance(poses=poses, tolerance=0), robot.clearance(qs[:200], tolerance=0)
    assert np.abs(given.upper - own.upper).max() < 1e-9, "link poses differ from Pinocchio's"
    different = [at for at in np.flatnonzero(found != expected) if abs(gaps.upper[at]) >= ROUNDING]
    for at in different:
        again = hulls.collides_afresh(theirs[at])
        assert found[at] == again, f"{file.name}: configuration {at}: {found[at]}, and coal {again}: {gaps[at]}"
    missed = np.flatnonzero(of_meshes & ~found[: len(of_meshes)])
    missed = [at for at in missed if gaps.lower[at] > ROUNDING]
    assert not len(missed), f"{file.name}: the meshes collide in configurations {missed}, and hullmap says no"
    apart = distances > ROUNDING
    wrong = np.abs(np.clip(distances, gaps.lower, gaps.upper) - distances)[apart]
    assert wrong.max(initial=0) < ROUNDING, f"{file.name}: clearances differ by {wrong.max()} m"
    line = (
        f"{file.name}: {len(low)} joints, {len(robot.pairs)} pairs; {found.mean():.1%} of {count} configurations collide; "
        f"{of_meshes.sum()} of {len(of_meshes)} by meshes, 0 missed; coal's first answer was another one in "
        f"{len(different)} configurations, and hullmap's when it was queried afresh\n"
        f"  in_collision: {count / seconds:,.0f} a second and core; Pinocchio and coal {count / coal_seconds:,.0f}"
    )
    of_mujoco = mujoco_rate(file, robot, hulls, qs)
    line += f"; {of_mujoco}\n" if of_mujoco else "\n"
    line += f"  clearance: {count / gap_seconds:,.0f}; Pinocchio and coal {count / coal_gap_seconds:,.0f}\n"
    return line + check_edges(file, robot, qs, edges, random, (low, high))


def check_edges(file, robot, qs, count, random, limits):
    start = qs[:count]
    # Half of the edges are short, as a planner's steps are; the others lead anywhere.
    step = random.normal(size=start.shape) * 0.2
    end = np.where(np.arange(len(start))[:, None] % 2, random.permutation(qs)[: len(start)], np.clip(start + step, *limits))
    found, seconds = cpu(lambda: robot.clear(start, end, threads=1))
    quick, quick_seconds = cpu(lambda: robot.clear(start, end, share=0, threads=1))
    times = np.linspace(0, 1, STEPS + 1)
    sampled_seconds = 0.0
    for at in range(len(start)):
        path = start[at] + (end[at] - start[at]) * times[:, None]
        hits, own = cpu(lambda: robot.in_collision(path, threads=1))
        sampled_seconds += own
        first = times[hits.argmax()] if hits.any() else np.inf
        verdict = hullmap.Verdict(int(found.verdict[at]))
        where = f"{file.name}: edge {at}, {verdict.name}, first sampled hit {first}: {found[at]}"
        if verdict == hullmap.Verdict.FREE:
            least = robot.clearance(path[::20]).upper.min()
            assert not hits.any() and 0 < found.clearance[at] <= least, where
        else:
            assert found.t_lower[at] <= first, where
        if verdict == hullmap.Verdict.HIT and np.isfinite(first):
            assert first <= found.t_upper[at] + 1 / STEPS, where
    counts = np.bincount(found.verdict, minlength=3)
    short = np.arange(len(start)) % 2 == 0
    queries = [np.median(quick.queries[own]) for own in (short, ~short)]
    return (
        f"  edges: {counts[0]} free, {counts[1]} hit, {counts[2]} open; {len(start) / quick_seconds:,.0f} a second "
        f"and core, {len(start) / seconds:,.0f} with clearances, {len(start) / sampled_seconds:,.0f} by {STEPS} samples of "
        f"hullmap; {queries[0]:.0f} and {queries[1]:.0f} queries for a short and a long edge (median)"
    )


def mujoco_model(file, robot):
    """MuJoCo's model of a URDF, with the pairs that hullmap tests. Fails with a ValueError if MuJoCo does not read it."""
    with tempfile.TemporaryDirectory() as folder:
        # MuJoCo removes folders from names, and needs the meshes in one.
        index = 0
        tree = ElementTree.fromstring(file.read_text())
        for link in tree.iter("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
            for mesh in link.iter("mesh"):
                path = mesh.get("filename").split("://")[-1]
                places = [parent / own for own in (path, path.split("/", 1)[-1]) for parent in file.parents]
                source = next((place for place in places if place.is_file()), None)
                if source is None or source.suffix.lower() not in (".stl", ".obj"):
                    raise ValueError(f"it does not read {mesh.get('filename')}")
                name = f"{index}{source.suffix}"
                (pathlib.Path(folder) / name).write_bytes(source.read_bytes())
                mesh.set("filename", name)
                index += 1
        own = ElementTree.SubElement(tree, "mujoco")
        ElementTree.SubElement(own, "compiler", meshdir=folder, balanceinertia="true", fusestatic="false")
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(tree, encoding="unicode"))
        tested = {frozenset(pair) for pair in robot.pairs.tolist()}
        index = {name: at for at, name in enumerate(robot.names)}
        bodies = [body.name for body in spec.bodies]
        for at, b in enumerate(bodies):
            for a in bodies[:at]:
                if frozenset((index.get(a), index.get(b))) not in tested:
                    spec.add_exclude(bodyname1=a, bodyname2=b)
        return spec.compile()


def mujoco_run(model, robot, reference, qs):
    """The number of configurations in which MuJoCo finds a contact, the CPU seconds, and its data of the last one."""
    data = mujoco.MjData(model)
    joints = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, at) for at in range(model.njnt)]
    rows = np.zeros((len(qs), model.nq))
    for at, name in enumerate(joints):
        if name in robot.joint_names:
            rows[:, model.jnt_qposadr[at]] = qs[:, robot.joint_names.index(name)]
        elif name in reference.follow:
            leader, factor, offset = reference.follow[name]
            rows[:, model.jnt_qposadr[at]] = factor * qs[:, robot.joint_names.index(leader)] + offset

    def run():
        hits = 0
        for row in rows:
            data.qpos[:] = row
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            hits += data.ncon > 0
        return hits

    return *cpu(run), data


def mujoco_rate(file, robot, reference, qs):
    """Configurations a second of MuJoCo, in words."""
    if mujoco is None:
        return ""
    try:
        model = mujoco_model(file, robot)
    except ValueError as error:
        return f"MuJoCo: {str(error).splitlines()[0]}"
    hits, seconds, _ = mujoco_run(model, robot, reference, qs)
    return f"MuJoCo {len(qs) / seconds:,.0f} ({hits / len(qs):.1%} collide)"


# Box A is fixed to the base. Two joints move box B, which is turned as in the known poses.
BOXES = """<robot name="boxes">
  <link name="base"/>
  <link name="slide"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="A"><collision><geometry><mesh filename="package://boxes/A.obj"/></geometry></collision></link>
  <link name="B"><collision><geometry><mesh filename="package://boxes/B.obj"/></geometry></collision></link>
  <joint name="to_A" type="fixed"><parent link="base"/><child link="A"/></joint>
  <joint name="along_z" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
  <joint name="along_x" type="prismatic"><parent link="slide"/><child link="B"/><axis xyz="1 0 0"/>
    <origin rpy="1.5707963267948966 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
</robot>
"""


def prove():
    """Ends the program if coal or MuJoCo answers the known boxes wrongly."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "boxes", "boxes.urdf")
        file.parent.mkdir()
        file.write_text(BOXES)
        for box in known.BOXES:
            file.with_name(f"{box}.obj").write_text(known.obj_of([known.corners(box)]))
        robot = hullmap.Robot.from_urdf(file, packages=[folder])
        hulls, meshes = (Reference(file, [folder], robot, is_convex) for is_convex in (True, False))
        model = mujoco and mujoco_model(file, robot)
        of_coal, of_mujoco = [], []
        for name, ((x, _, z, *_), gap) in known.POSES.items():
            q = np.array([{"along_x": x, "along_z": z}[joint] for joint in robot.joint_names])
            own = hulls.configuration(q)
            found = [(f"{kind}, hit", gap < 0, of.collides(own)) for kind, of in (("hulls", hulls), ("meshes", meshes))]
            of_coal += [(f"{name}: gap", gap, hulls.clearance(own)), *found]
            if model:
                hits, _, data = mujoco_run(model, robot, hulls, q[None])
                of_mujoco += [(f"{name}: hit", gap < 0, bool(hits)), ("depth", max(-gap, 0.0), -data.contact.dist.min() if hits else 0.0)]
        known.require(f"Pinocchio {pinocchio.__version__} and coal {coal.__version__}", of_coal)
        if model:
            known.require(f"MuJoCo {mujoco.__version__}", of_mujoco)


def main(count, edges, files):
    faults = 0
    print(f"seed {SEED}")
    prove()
    for file in files:
        try:
            print(f"ok: {check(pathlib.Path(file).resolve(), int(count), int(edges), np.random.default_rng(SEED))}", flush=True)
        except AssertionError as error:
            faults += 1
            print(f"FAILED: {error}", flush=True)
    sys.exit(faults > 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
