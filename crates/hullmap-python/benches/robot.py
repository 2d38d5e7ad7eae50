"""Queries a second on two links of a robot: hullmap beside coal, MuJoCo and python-fcl.

    python robot.py LINK_A.obj LINK_B.obj [--count 1000000] [--peer-count 50000] [--rounds 5] [--judge 3]

All engines get the vertices of the same two hulls and the same poses, about half of which overlap.
Engines that pip has not installed are left out. hullmap takes all poses in one call. The others are
called once a pose from a Python loop, as their users have to; the row `call` is the same loop on two
spheres of the engine, most of which is the cost of the call. Runs are interleaved, and the median
counts. On one thread, time is processor time, which other programs disturb less. Answers are
compared. Where an engine differs most, and where it disagrees about a hit, separating axes judge:
all normals of faces and all products of edges, in doubles. First each engine answers two known boxes.

With --pairs N, a robot of 30 links, copies of the two in other sizes, moves for 200 steps, and N of
its pairs are queried by a call for each pair, and by one call for all.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import sys
import time
from importlib import metadata
from pathlib import Path

import numpy as np

import hullmap

sys.path.append(str(Path(__file__).resolve().parents[3] / "benches/peers"))
import known  # noqa: E402


def random_poses(count, reach, seed):
    """Random rotations, and positions up to ``reach`` away from each other."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(count, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    ways = rng.normal(size=(count, 3))
    ways *= reach * rng.uniform(0, 1, size=(count, 1)) / np.linalg.norm(ways, axis=1, keepdims=True)
    return hullmap.poses(ways, turns)


def motion(count, reach):
    """One slow motion in and out of each other, in small steps."""
    t = np.linspace(0, 60 * np.pi, count)
    ways = reach * 0.5 * (1 + np.cos(t / 7))[:, None] * np.stack((np.cos(t), np.sin(t), np.sin(0.37 * t)), axis=1)
    half = 0.5 * np.stack((0.3 * t, 0.2 * t, 0.1 * t), axis=1)
    angle = np.linalg.norm(half, axis=1, keepdims=True)
    turns = np.concatenate((np.sin(angle) * half / np.maximum(angle, 1e-30), np.cos(angle)), axis=1)
    return hullmap.poses(ways, turns / np.linalg.norm(turns, axis=1, keepdims=True))


def frames(poses):
    """Rotation matrices of poses."""
    x, y, z, w = poses[:, 3:].T
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)]
    rows += [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)]
    rows += [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]
    return np.stack(rows, axis=-1).reshape(-1, 3, 3)


class Coal:
    """coal: GJK and EPA, doubles."""

    package = "coal"

    def __init__(self, a, b):
        import coal

        self.coal = coal
        self.pair = [coal.Convex(self._points(hull), self._triangles(hull)) for hull in (a, b)]
        self.balls = [coal.Sphere(0.1), coal.Sphere(0.1)]

    def _points(self, hull):
        points = self.coal.StdVec_Vec3s()
        for vertex in hull.vertices.astype(float):
            points.append(vertex)
        return points

    def _triangles(self, hull):
        coal = self.coal
        triangles = coal.StdVec_Triangle() if hasattr(coal, "StdVec_Triangle") else coal.StdVec_Triangle32()
        kind = coal.Triangle if hasattr(coal, "Triangle") else coal.Triangle32
        for corners in hull.triangles.tolist():
            triangles.append(kind(*corners))
        return triangles

    def prepare(self, poses):
        return [self.coal.Transform3s(turn, place) for turn, place in zip(frames(poses), poses[:, :3])]

    def _hits(self, pair, places):
        collide, identity = self.coal.collide, self.coal.Transform3s()
        request, result, found = self.coal.CollisionRequest(), self.coal.CollisionResult(), []
        request.enable_contact = False
        for place in places:
            result.clear()
            found.append(collide(pair[0], identity, pair[1], place, request, result) > 0)
        return np.array(found)

    def _signed(self, pair, places, signed):
        distance, identity = self.coal.distance, self.coal.Transform3s()
        request, result, found = self.coal.DistanceRequest(True, 0.0, 0.0), self.coal.DistanceResult(), []
        request.enable_signed_distance = signed
        for place in places:
            result.clear()
            found.append(distance(pair[0], identity, pair[1], place, request, result))
        return np.array(found)

    def intersects(self, places):
        return self._hits(self.pair, places)

    def distance(self, places):
        return self._signed(self.pair, places, False)

    def contact(self, places):
        return -self._signed(self.pair, places, True)

    def call(self, places):
        return self._signed(self.balls, places, False)


class MuJoCo:
    """MuJoCo: GJK and EPA, doubles. Its distance is signed."""

    package = "mujoco"

    def __init__(self, a, b):
        import mujoco

        self.mujoco = mujoco
        meshes = [f'<mesh name="{n}" vertex="{" ".join(map(repr, h.vertices.ravel().tolist()))}"/>' for n, h in (("a", a), ("b", b))]
        geoms = '<geom type="mesh" mesh="a"/><geom type="mesh" mesh="b"/><geom size="0.1"/><geom size="0.1"/>'
        text = f"<mujoco><asset>{''.join(meshes)}</asset><worldbody>{geoms}</worldbody></mujoco>"
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.data)
        # MuJoCo moves each mesh to its centre of mass and its axes of inertia.
        self.place, self.turn = self.data.geom_xpos[1].copy(), self.data.geom_xmat[1].reshape(3, 3).copy()

    def prepare(self, poses):
        turns = frames(poses)
        return list(zip(poses[:, :3] + turns @ self.place, (turns @ self.turn).reshape(-1, 9)))

    def _signed(self, a, b, places, limit):
        distance, model, data, segment, found = self.mujoco.mj_geomDistance, self.model, self.data, np.zeros(6), []
        place, turn = data.geom_xpos[b], data.geom_xmat[b]
        for way, matrix in places:
            place[:], turn[:] = way, matrix
            found.append(distance(model, data, a, b, limit, segment))
        return np.array(found)

    def distance(self, places):
        return np.maximum(self._signed(0, 1, places, 1e3), 0)

    def contact(self, places):
        return -self._signed(0, 1, places, 0.0)

    def call(self, places):
        return self._signed(2, 3, places, 1e3)


class Fcl:
    """FCL: GJK and EPA by libccd, doubles."""

    package = "python-fcl"

    def __init__(self, a, b):
        import fcl

        self.fcl = fcl
        self.pair = []
        for hull in (a, b):
            faces = np.concatenate([np.concatenate(([len(face)], face)) for face in hull.faces])
            self.pair.append(fcl.Convex(hull.vertices.astype(float), len(hull.faces), faces))
        self.balls = [fcl.Sphere(0.1), fcl.Sphere(0.1)]

    def prepare(self, poses):
        return [self.fcl.Transform(np.roll(pose[3:], 1), pose[:3]) for pose in poses]

    def _objects(self, pair):
        return [self.fcl.CollisionObject(shape, self.fcl.Transform()) for shape in pair]

    def intersects(self, places):
        (a, b), fcl, found = self._objects(self.pair), self.fcl, []
        request = fcl.CollisionRequest()
        for place in places:
            b.setTransform(place)
            found.append(fcl.collide(a, b, request, fcl.CollisionResult()) > 0)
        return np.array(found)

    def _distance(self, pair, places):
        (a, b), fcl, found = self._objects(pair), self.fcl, []
        request = fcl.DistanceRequest()
        for place in places:
            b.setTransform(place)
            found.append(fcl.distance(a, b, request, fcl.DistanceResult()))
        return np.maximum(found, 0)

    def distance(self, places):
        return self._distance(self.pair, places)

    def contact(self, places):
        (a, b), fcl, found = self._objects(self.pair), self.fcl, []
        request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
        for place in places:
            b.setTransform(place)
            result = fcl.CollisionResult()
            fcl.collide(a, b, request, result)
            found.append(result.contacts[0].penetration_depth if result.contacts else 0.0)
        return np.array(found)

    def call(self, places):
        return self._distance(self.balls, places)


def prove(engine):
    """Ends the program if an engine answers the known boxes wrongly."""
    made = engine(*(hullmap.bake(known.corners(box))[0] for box in "AB"))
    answers = []
    for name, (pose, gap) in known.POSES.items():
        places = made.prepare(hullmap.poses([pose[:3]], [pose[3:]]))
        if hasattr(made, "intersects"):
            answers.append((f"{name}: hit", gap < 0, made.intersects(places)[0]))
        answers.append(("depth", -gap, made.contact(places)[0]) if gap < 0 else ("distance", gap, made.distance(places)[0]))
    known.require(f"{engine.package} {metadata.version(engine.package)}", answers)


def overlap(a, b, pose):
    """The least overlap over all separating axes, which is the depth; negative without contact."""
    turn = frames(pose[None])[0]
    points = [a.vertices.astype(float), b.vertices.astype(float) @ turn.T + pose[:3]]
    edges, axes = [], []
    for hull, own in zip((a, b), points):
        corners = own[hull.triangles]
        axes.append(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        pairs = [(v, w) for v, near in enumerate(hull.neighbours) for w in near.tolist() if v < w]
        ways = own[[w for _, w in pairs]] - own[[v for v, _ in pairs]]
        edges.append(ways / np.linalg.norm(ways, axis=1, keepdims=True))
    products = np.cross(edges[0][:, None], edges[1][None]).reshape(-1, 3)
    least = np.inf
    for piece in np.array_split(np.concatenate((*axes, products)), 1 + len(products) // 20_000):
        lengths = np.linalg.norm(piece, axis=1)
        # A product of nearly parallel edges has no direction.
        piece = piece[lengths > 1e-12] / lengths[lengths > 1e-12, None]
        first, second = points[0] @ piece.T, points[1] @ piece.T
        both = np.minimum(first.max(0) - second.min(0), second.max(0) - first.min(0))
        least = min(least, both.min())
    return float(least)


def judged(a, b, poses, reference, name, hits, depths, count):
    """Lines of a table: poses in which an engine differs most, its answer, hullmap's, and the truth."""
    overlapping = reference["intersects"]
    rows = [] if hits is None else np.flatnonzero(hits != overlapping)[:count].tolist()
    rows += np.argsort(np.where(overlapping, abs(depths - reference["contact"]), 0))[-count:].tolist()
    for row in dict.fromkeys(rows):
        hit = "-" if hits is None else hits[row]
        answers = f"{hit} | {depths[row]:.9f} | {overlapping[row]} | {reference['contact'][row]:.9f}"
        yield f"{name} | {row} | {answers} | {overlap(a, b, poses[row]):.9f}"


def pairs_table(a, b, count, rounds):
    """Prints how long all pairs of a robot take, by single calls and in one call; on one thread."""
    rng, links, steps = np.random.default_rng(1), 30, 200
    factors = np.linspace(0.4, 1.0, links // 2)
    shapes = [hullmap.bake(hull.vertices * factor)[0] for hull in (a, b) for factor in factors]
    first, second = np.triu_indices(links, 1)
    chosen = np.sort(rng.choice(len(first), count, replace=False))
    first, second = first[chosen], second[chosen]
    # Each link has a motion of its own, about a centre in a cube in which a tenth of the pairs overlap.
    long = motion(100_000, 0.1 * a.diameter)
    path = np.stack([long[start : start + steps] for start in rng.integers(len(long) - steps, size=links)], axis=1)
    path[..., :3] += rng.uniform(-0.33, 0.33, size=(links, 3)) * (a.diameter + b.diameter)
    b_in_a = hullmap.relative(path[0, first], path[0, second])
    kinds = ("intersects", "distance", "contact", "manifold")
    rows = {kind: [] for kind in kinds}
    for _ in range(rounds):
        for kind in kinds:
            moving, still = hullmap.Pairs(shapes, first, second), hullmap.Pairs(shapes, first, second)
            single = [getattr(shapes[i], kind) for i in first]
            work = (
                lambda: [query(shapes[j], pose, threads=1) for query, j, pose in zip(single, second, b_in_a)],  # noqa: B023
                lambda: [getattr(still, kind)(in_world=poses, threads=1) for poses in path],  # noqa: B023
                lambda: [getattr(moving, kind)(in_world=poses, threads=1, coherent=True) for poses in path],  # noqa: B023
            )
            rows[kind].append([timed(each)[0] / calls for each, calls in zip(work, (1, steps, steps))])
    overlapping = hullmap.Pairs(shapes, first, second).intersects(in_world=path).hit.mean()
    print(f"{count} pairs of {links} links, {overlapping:.0%} overlapping; ms\n")
    print("query | a call for each | one call | one call, a motion\n---|---|---|---")
    for kind in kinds:
        print(" | ".join([kind, *(f"{1e3 * statistics.median(cell):.3f}" for cell in zip(*rows[kind]))]))


def timed(work, clock=time.process_time):
    start = clock()
    answer = work()
    return clock() - start, answer


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("links", nargs=2, type=Path)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--peer-count", type=int, default=50_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--judge", type=int, default=3)
    parser.add_argument("--pairs", type=int)
    arguments = parser.parse_args()
    a, b = (hullmap.bake_file(path)[0] for path in arguments.links)
    # Positions relative to the centres, up to the sum of the radii of the hulls.
    a, b = (hullmap.bake(hull.vertices - hull.bounds.mean(axis=0), name=hull.name)[0] for hull in (a, b))
    if arguments.pairs:
        return pairs_table(a, b, arguments.pairs, arguments.rounds)
    reach = 0.5 * (a.diameter + b.diameter)
    poses = random_poses(arguments.count, reach, 1)
    path = motion(arguments.count, reach)
    some = poses[: arguments.peer_count]
    engines = []
    for engine in (Coal, MuJoCo, Fcl):
        try:
            prove(engine)
            made = engine(a, b)
            engines.append((f"{engine.package} {metadata.version(engine.package)}", made, made.prepare(some)))
        except ImportError:
            print(f"skipped: {engine.package} is not installed")
    queries = ("intersects", "distance", "contact")
    rows: dict[tuple[str, str], list[float]] = {}
    answers: dict[tuple[str, str], np.ndarray] = {}
    fields = {"intersects": "hit", "distance": "distance", "contact": "depth"}
    for _ in range(arguments.rounds):
        for query in (*queries, "call"):
            for name, made, prepared in engines:
                if hasattr(made, query):
                    seconds, answer = timed(lambda: getattr(made, query)(prepared))
                    rows.setdefault((name, query), []).append(seconds / len(some))
                    answers[name, query] = answer
            for label, places, threads, coherent in (
                ("hullmap, 1 thread", poses, 1, False),
                ("hullmap, all threads", poses, None, False),
                ("hullmap, a motion, 1 thread", path, 1, True),
                ("hullmap, a motion, all threads", path, None, True),
            ):
                if query in queries:
                    work = lambda: getattr(a, query)(b, places, threads=threads, coherent=coherent)  # noqa: B023, E731
                    seconds, answer = timed(work, time.process_time if threads == 1 else time.perf_counter)
                    rows.setdefault((label, query), []).append(seconds / len(places))
                    if not coherent:
                        answers[label, query] = getattr(answer, fields[query])[: len(some)]
            if query == "call":
                far = hullmap.Sphere(0.1)
                seconds, _ = timed(lambda: far.distance(far, poses, threads=1))
                rows.setdefault(("hullmap, 1 thread", query), []).append(seconds / len(poses))

    print(f"\nPython {platform.python_version()}, NumPy {np.__version__}, hullmap {hullmap.__version__}, {os.cpu_count()} processors")
    print(f"{a.name}: {len(a)} vertices; {b.name}: {len(b)} vertices; {len(poses):,} poses for hullmap, {len(some):,} for the others")
    print(f"overlapping: {answers['hullmap, 1 thread', 'intersects'].mean():.0%}\n")
    print("queries a second | intersects | distance | contact | call\n---|---|---|---|---")
    for name in sorted(dict.fromkeys(name for name, _ in rows), key=lambda name: not name.startswith("hullmap")):
        cells = [rows.get((name, query)) for query in (*queries, "call")]
        print(" | ".join([name, *(f"{1 / statistics.median(cell):,.0f}" if cell else "-" for cell in cells)]))
    print("\nlargest difference to hullmap | hits that differ | distance | depth\n---|---|---|---")
    for name, _, _ in engines:
        hits = answers.get((name, "intersects"))
        reference = {query: answers["hullmap, 1 thread", query] for query in queries}
        differ = "-" if hits is None else f"{(hits != reference['intersects']).sum()}"
        apart, overlapping = ~reference["intersects"], reference["intersects"]
        gap = abs(answers[name, "distance"] - reference["distance"])[apart].max()
        depth = abs(answers[name, "contact"] - reference["contact"])[overlapping].max()
        print(f"{name} | {differ} | {gap:.1e} | {depth:.1e}")
    print("\nengine | pose | hit | depth | hit, hullmap | depth, hullmap | overlap by separating axes\n" + "---|" * 6 + "---")
    for name, _, _ in engines:
        own = answers.get((name, "intersects")), answers[name, "contact"]
        for line in judged(a, b, some, reference, name, *own, arguments.judge):
            print(line)
    print(f"\ndiameters: {a.diameter:.3g}, {b.diameter:.3g}")


if __name__ == "__main__":
    main()
