"""Judges the parts of robots in random configurations, by Pinocchio and coal.

    check_configurations.py BAKE COUNT FILE...

Bakes each URDF with `--decompose`. In each configuration, whenever the meshes of two links collide, so do
their parts. Whenever parts collide, the meshes are no farther from each other than both links protrude by
the report, or one encloses the other.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

try:
    import coal
    import pinocchio
except ImportError:
    print("skipped: configurations: Pinocchio is not installed")
    sys.exit()

SEED = 38
MAX_ERROR = "2%"
# Distance, in metres, up to which surfaces that should meet may be apart: rounding to f32, and text.
ROUNDING = 2e-6


def bake(program, file, out):
    command = [program, "robot", str(file), "--out", str(out), "--json", "--quiet", "--decompose", "--max-error", MAX_ERROR]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(run.stderr.strip() or run.stdout)
    return json.loads(run.stdout)


class Geometry:
    """The collision geometry of a description, and the pairs of links that may collide in it."""

    def __init__(self, model, file, folders, is_convex):
        kind = pinocchio.GeometryType.COLLISION
        self.own = pinocchio.buildGeomFromUrdf(model, str(file), kind, [str(folder) for folder in folders])
        if is_convex:
            for item in self.own.geometryObjects:
                if isinstance(item.geometry, coal.BVHModelBase):
                    item.geometry.buildConvexHull(True, "Qt")
                    item.geometry = item.geometry.convex
        # Links that a joint connects touch by design.
        self.links = [model.frames[item.parentFrame].name for item in self.own.geometryObjects]
        joints = [item.parentJoint for item in self.own.geometryObjects]
        for a in range(len(joints)):
            for b in range(a):
                if joints[a] != joints[b] and joints[a] not in (model.parents[joints[b]], joints[b]) \
                        and joints[b] != model.parents[joints[a]]:
                    self.own.addCollisionPair(pinocchio.CollisionPair(b, a))
        self.pairs = [self.of_links(pair) for pair in self.own.collisionPairs]
        self.data = pinocchio.GeometryData(self.own)

    def of_links(self, pair):
        return tuple(sorted((self.links[pair.first], self.links[pair.second])))

    def colliding(self, model, data, q):
        pinocchio.computeCollisions(model, data, self.own, self.data, q, False)
        results = self.data.collisionResults
        return {links for links, result in zip(self.pairs, results) if result.isCollision()}

    def placed(self, link):
        """The shapes of a link and their poses, after `colliding`."""
        found = (index for index, own in enumerate(self.links) if own == link)
        return [(self.own.geometryObjects[index].geometry, self.data.oMg[index]) for index in found]

    def distance(self, links):
        """Between two links, after `colliding`."""
        least = np.inf
        for a, pose_a in self.placed(links[0]):
            for b, pose_b in self.placed(links[1]):
                result = coal.DistanceResult()
                coal.distance(a, transform(pose_a), b, transform(pose_b), coal.DistanceRequest(), result)
                least = min(least, result.min_distance)
        return least


def transform(pose):
    return coal.Transform3s(pose.rotation, pose.translation)


def is_enclosed(meshes, parts, links):
    """Whether a corner of a mesh of one link is inside a part of the other."""
    point = coal.Sphere(1e-9)
    for own, other in (links, links[::-1]):
        for mesh, pose in meshes.placed(own):
            corner = pose.act(np.array(mesh.vertices(0))) if isinstance(mesh, coal.BVHModelBase) else pose.translation
            at = coal.Transform3s(np.eye(3), corner)
            for part, place in parts.placed(other):
                result = coal.CollisionResult()
                if coal.collide(point, at, part, transform(place), coal.CollisionRequest(), result):
                    return True
    return False


def check(program, file, count, out):
    row = bake(program, file, out)
    protrusion = {}
    for collision in row["collisions"]:
        own = (collision["protrusion_mm"] or 0.0) / 1000.0
        protrusion[collision["link"]] = max(own, protrusion.get(collision["link"], 0.0))
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    folders = list(file.parents)[:6]
    meshes = Geometry(model, file, folders, is_convex=False)
    parts = Geometry(model, pathlib.Path(row["output"]), [out, *folders], is_convex=True)
    random = np.random.default_rng(SEED)
    low = np.where(np.isfinite(model.lowerPositionLimit), model.lowerPositionLimit, -np.pi)
    high = np.where(np.isfinite(model.upperPositionLimit), model.upperPositionLimit, np.pi)
    met, near, enclosed, grazing = 0, 0, 0, 0
    for index in range(count):
        q = pinocchio.neutral(model) if index == 0 else random.uniform(low, high)
        of_meshes, of_parts = (own.colliding(model, data, q) for own in (meshes, parts))
        met += len(of_meshes)
        for links in of_meshes - of_parts:
            if parts.distance(links) > ROUNDING:
                return False, f"configuration {index}: the meshes of {links} collide, and their parts do not"
            grazing += 1
        for links in of_parts - of_meshes:
            distance = meshes.distance(links)
            if distance <= sum(protrusion.get(link, 0.0) for link in links) + ROUNDING:
                near += 1
            elif is_enclosed(meshes, parts, links):
                enclosed += 1
            else:
                return False, f"configuration {index}: the parts of {links} collide, {distance} m before the meshes"
    text = f"{count} configurations, {met} collisions of meshes, {near} of parts alone, within their protrusion"
    return True, f"{text}; {enclosed} enclosed, {grazing} within rounding"


def main(program, count, files):
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for index, file in enumerate(pathlib.Path(file).resolve() for file in files):
            is_right, text = check(program, file, int(count), pathlib.Path(folder) / str(index))
            faults += not is_right
            print(f"{'ok' if is_right else 'FAILED'}: {file.name}: {text}", flush=True)
    sys.exit(faults > 0)


main(sys.argv[1], sys.argv[2], sys.argv[3:])
