"""Continuous collision of two hulls: `hullmap.cast_motion` beside Tesseract (Bullet's casts) and FCL (steps).

    check_motions.py MOTIONS VERTICES ANGLE

One hull rests. The other one moves from one random pose to another: its origin along a line, and its rotation by
ANGLE degrees about a random axis. About half of the motions hit. Truth comes from coal, at 1,000 steps of each
motion, without what it remembers of earlier queries:

- a motion hits for certain if coal finds a penetration at a step; the first such step bounds the time of impact
  from above, and bisection by coal narrows it;
- a motion is free for certain if the distance at each step exceeds what any point moves in half a step.

An engine misses a motion that hits if it reports none, or a time after the first step that penetrates. hullmap must
not miss any, and its interval must contain the time of coal. Tesseract casts the convex hull of both ends, which
is not where a shape that turns has been: its hits without a contact are counted. FCL tries 100 steps. Its conservative
advancement is not measured: in python-fcl 0.7.0.11, along lines, it also reports no contact of two boxes that meet.
coal itself has no continuous query, and MuJoCo's is not in its headers.

First coal, Tesseract and FCL answer two known boxes. Times are CPU microseconds a motion of one thread. They are printed, and decide nothing.
"""

import pathlib
import sys
import time

import numpy as np

try:
    import coal

    import hullmap
except ImportError as error:
    print(f"skipped: motions: {error}")
    sys.exit()

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "benches/peers"))
import known  # noqa: E402

SEED = 41
STEPS = 1000
# Depth and distance below which coal's answer does not decide, for hulls of diameter 2.
ROUNDING = 1e-5


def rock(count, rng):
    points = rng.normal(size=(count, 3))
    points *= np.array([1.0, 0.8, 0.6]) / np.linalg.norm(points, axis=1, keepdims=True)
    return hullmap.bake(points)[0]


def quaternions(axes, angles):
    half = np.asarray(angles)[..., None] / 2
    return np.concatenate((axes * np.sin(half), np.cos(half)), axis=-1)


def product(p, q):
    a, s, b, t = p[..., :3], p[..., 3:], q[..., :3], q[..., 3:]
    return np.concatenate((s * b + t * a + np.cross(a, b), s * t - (a * b).sum(-1, keepdims=True)), axis=-1)


def frames(poses):
    """Rotation matrices of poses."""
    x, y, z, w = np.moveaxis(poses[..., 3:], -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


class Motions:
    """Motions past the origin, by lines and turns about fixed axes."""

    def __init__(self, count, angle, rng):
        unit = lambda: (lambda v: v / np.linalg.norm(v, axis=-1, keepdims=True))(rng.normal(size=(count, 3)))
        way = unit()
        across = np.cross(way, unit())
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
        middle = across * rng.uniform(0, 2.3, size=(count, 1))
        self.start, self.end = middle - 2.5 * way, middle + 2.5 * way
        self.first = quaternions(unit(), rng.uniform(0, 6.28, size=count))
        self.axes, self.angle = unit(), np.radians(angle)

    def pose_at(self, t, which=slice(None)):
        t = np.asarray(t, float)
        turn = quaternions(self.axes[which], np.broadcast_to(self.angle * t, self.axes[which].shape[:-1]))
        place = self.start[which] + t[..., None] * (self.end[which] - self.start[which])
        return np.concatenate((place, product(turn, self.first[which])), axis=-1)


def coal_hull(hull):
    points = coal.StdVec_Vec3s()
    for point in hull.vertices.astype(float):
        points.append(point)
    triangles = coal.StdVec_Triangle() if hasattr(coal, "StdVec_Triangle") else coal.StdVec_Triangle32()
    kind = coal.Triangle if hasattr(coal, "Triangle") else coal.Triangle32
    for corners in hull.triangles:
        triangles.append(kind(*map(int, corners)))
    return coal.Convex(points, triangles)


class Truth:
    def __init__(self, a, b, motions):
        self.a, self.b, self.motions = coal_hull(a), coal_hull(b), motions
        self.identity = coal.Transform3s()
        # How fast any point of B moves.
        reach = np.linalg.norm(b.vertices.astype(float), axis=1).max()
        self.speed = np.linalg.norm(motions.end - motions.start, axis=-1) + motions.angle * reach

    @staticmethod
    def prove(a, b):
        """Ends the program if coal answers the known boxes wrongly."""
        truth = Truth(a, b, Motions(1, 0.0, np.random.default_rng(SEED)))
        known.require("coal", [(f"{name}: gap", gap, truth.gap(np.array(pose))) for name, (pose, gap) in known.POSES.items()])

    def gap(self, pose):
        """The signed distance."""
        request, result = coal.DistanceRequest(True, 0.0, 0.0), coal.DistanceResult()
        request.enable_signed_distance = True
        place = coal.Transform3s(frames(pose), pose[:3])
        return coal.distance(self.a, self.identity, self.b, place, request, result)

    def judge(self, which):
        """Whether the motion certainly hits, or certainly does not, and the time of the first penetration."""
        gap_at = lambda t: self.gap(self.motions.pose_at(t, which))
        # Steps as long as the distance allows, but at most a thousandth.
        t, is_free, before = 0.0, True, 0.0
        while True:
            found = gap_at(t)
            if found < -ROUNDING:
                late, early = t, before
                for _ in range(30):
                    middle = 0.5 * (early + late)
                    early, late = (early, middle) if gap_at(middle) < -ROUNDING else (middle, late)
                return True, False, late
            if t >= 1.0:
                return False, is_free, np.inf
            safe = 0.95 * max(0.0, found - ROUNDING) / self.speed[which]
            is_free &= safe >= 0.5 / STEPS or found > self.speed[which] * 0.5 / STEPS + ROUNDING
            before, t = t, min(1.0, t + max(safe, 1.0 / STEPS))


class Tesseract:
    name = "Tesseract"

    def __init__(self, a, b):
        import tesseract_robotics
        from tesseract_robotics import tesseract_collision as collision
        from tesseract_robotics import tesseract_common as common
        from tesseract_robotics import tesseract_geometry as geometry

        self.collision, self.common = collision, common
        folder = pathlib.Path(tesseract_robotics.__file__).parent.parent / "tesseract_robotics.libs"
        library = next(folder.glob("libtesseract_collision_bullet_factories*")).name[3:-3]
        plugins = "continuous_plugins: {default: cast, plugins: {cast: {class: BulletCastBVHManagerFactory}}}"
        places = f"search_paths: [{folder}]\n  search_libraries: [{library}]"
        config = f"contact_manager_plugins:\n  {places}\n  {plugins}\n"
        self.factory = collision.ContactManagersPluginFactory(config, common.GeneralResourceLocator())
        self.manager = self.factory.createContinuousContactManager("cast")
        for name, hull in (("a", a), ("b", b)):
            points = common.VectorVector3d()
            for point in hull.vertices.astype(float):
                points.append(point.reshape(3, 1))
            faces = np.concatenate([[len(face), *face] for face in hull.faces]).astype(np.int32)
            shapes = geometry.GeometriesConst()
            shapes.append(geometry.ConvexMesh(points, faces))
            places = common.VectorIsometry3d()
            places.append(common.Isometry3d(np.eye(4)))
            self.manager.addCollisionObject(name, 0, shapes, places)
        self.manager.setActiveCollisionObjects(["b"])
        self.manager.setDefaultCollisionMarginData(0.0)
        self.request = collision.ContactRequest(collision.ContactTestType_FIRST)

    def prepared(self, poses):
        matrices = np.tile(np.eye(4), (len(poses), 1, 1))
        matrices[:, :3, :3], matrices[:, :3, 3] = frames(poses), poses[:, :3]
        return [self.common.Isometry3d(matrix) for matrix in matrices]

    def cast(self, start, end):
        self.manager.setCollisionObjectsTransform("b", start, end)
        found = self.collision.ContactResultMap()
        self.manager.contactTest(found, self.request)
        return (found.size() > 0, np.nan)


class Fcl:
    name = "FCL, 100 steps"

    def __init__(self, a, b):
        import fcl

        self.fcl = fcl
        models = []
        for hull in (a, b):
            model = fcl.BVHModel()
            model.beginModel(len(hull.triangles), len(hull.vertices))
            model.addSubModel(hull.vertices.astype(float), hull.triangles.astype(np.int64))
            model.endModel()
            models.append(model)
        self.a, self.b = fcl.CollisionObject(models[0], fcl.Transform()), models[1]

    def prepared(self, poses):
        return [self.fcl.Transform(frame, pose[:3]) for frame, pose in zip(frames(poses), poses)]

    def cast(self, start, end):
        fcl = self.fcl
        request = fcl.ContinuousCollisionRequest(
            num_max_iterations=100,
            toc_err=1e-5,
            ccd_motion_type=fcl.CCDMotionType.CCDM_LINEAR,
            ccd_solver_type=fcl.CCDSolverType.CCDC_NAIVE,
        )
        result = fcl.ContinuousCollisionResult()
        moving = fcl.CollisionObject(self.b, start)
        time_of_contact = fcl.continuousCollide(self.a, fcl.Transform(), moving, end, request, result)
        return (result.is_collide, time_of_contact if result.is_collide else np.inf)


def prove(engine, a, b):
    """Ends the program if an engine moves one known box into the other without a hit, or hits without a motion."""
    own = engine(a, b)
    apart, deep = (own.prepared(np.array([known.POSES[name][0]]))[0] for name in ("separated", "overlapping"))
    known.require(engine.name, [("motion into the other, hit", True, own.cast(apart, deep)[0]), ("at rest, hit", False, own.cast(apart, apart)[0])])


def cpu(run):
    start = time.process_time()
    return run(), time.process_time() - start


def main():
    count, vertices, angle = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    boxes = [hullmap.bake(known.corners(box))[0] for box in "AB"]
    Truth.prove(*boxes)
    rng = np.random.default_rng(SEED)
    a, b = rock(vertices, rng), rock(vertices, rng)
    motions = Motions(count, angle, rng)
    poses = [motions.pose_at(np.full(count, t)) for t in (0.0, 1.0)]
    truth = Truth(a, b, motions)
    hits, free, times = (np.array(own) for own in zip(*(truth.judge(which) for which in range(count))))
    share = hits.mean()
    assert 0.25 < share < 0.75, f"seed {SEED}: {share:.0%} of the motions hit"
    print(f"{count} motions, seed {SEED}: two hulls of {vertices} vertices, {angle:g} degrees; by coal, {hits.sum()} hit, {free.sum()} are free")

    still = hullmap.Motion.still(hullmap.poses([0, 0, 0]))
    # A screw, since that turns by the angle about the axis.
    turning = hullmap.Motion.screw(poses[0], linear=motions.end - motions.start, angular=motions.axes * motions.angle, center=motions.start)
    found, seconds = cpu(lambda: hullmap.cast_motion(a, b, still, turning, threads=1))
    missed = hits & ~(found.hit & (found.t_lower <= times))
    late = hits & (found.t_lower > times)
    wrong = free & found.hit
    assert not missed.any() and not wrong.any(), (np.flatnonzero(missed), np.flatnonzero(wrong))
    error = np.abs(found.t[hits] - times[hits])
    line = f"  hullmap: {seconds / count * 1e6:.1f} µs; 0 missed, {late.sum()} late, {wrong.sum()} hits without a contact"
    print(f"{line}; t off by {np.median(error):.1e} (median), {error.max():.1e}; {np.median(found.iterations):.0f} queries")
    for engine in (Tesseract, Fcl):
        try:
            prove(engine, *boxes)
            own = engine(a, b)
        except ImportError as error:
            print(f"  skipped: {engine.name}: {error}")
            continue
        start, end = (own.prepared(rows) for rows in poses)
        answers, seconds = cpu(lambda: [own.cast(*pair) for pair in zip(start, end)])
        hit, t = (np.array(column) for column in zip(*answers))
        hit, t = hit.astype(bool), t.astype(float)
        missed, wrong = hits & ~hit, free & hit
        late = hits & hit & (t > times + 1.0 / STEPS)
        line = f"  {own.name}: {seconds / count * 1e6:.1f} µs; {missed.sum()} missed, {late.sum()} late, {wrong.sum()} hits without a contact"
        both = hits & hit & np.isfinite(t)
        if both.any():
            error = np.abs(t[both] - times[both])
            line += f"; t off by {np.median(error):.1e} (median), {error.max():.1e}"
        print(line)


main()
