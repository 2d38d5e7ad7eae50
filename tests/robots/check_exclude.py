"""Judges `bake robot --exclude-pairs` by other projects' parsers, in random configurations.

    check_exclude.py BAKE FILE...

In MuJoCo, excluded pairs of bodies have no contacts, and all others those that they have without the flag.
Pinocchio reads the SRDF of a URDF and removes its pairs; none of the others touches in the neutral pose.
"""

import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

SEED = 38
CONFIGURATIONS = 300


def installed(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


mujoco, pinocchio = installed("mujoco"), installed("pinocchio")


def bake(program, file, out, *options):
    command = [program, "robot", str(file), "--out", str(out), "--json", "--quiet", *options]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(run.stderr.strip() or run.stdout)
    return json.loads(run.stdout)


def contacts(model, data, positions):
    """For each pair of bodies, the distances of its contacts."""
    data.qpos[:] = positions
    mujoco.mj_forward(model, data)
    found = {}
    for contact in data.contact:
        bodies = [model.geom_bodyid[geom] for geom in (contact.geom1, contact.geom2)]
        pair = tuple(sorted(model.body(body).name or str(body) for body in bodies))
        found.setdefault(pair, []).append(round(contact.dist, 9))
    return {pair: sorted(distances) for pair, distances in found.items()}


def in_mujoco(program, file, out):
    plain = bake(program, file, out / "plain")
    row = bake(program, file, out / "excluded", "--exclude-pairs")
    if bake(program, file, out / "excluded", "--exclude-pairs")["status"] != "fresh":
        return False, "a second run changes files"
    excluded = {tuple(sorted(pair["links"])) for pair in row["excluded_pairs"]}
    models = [mujoco.MjModel.from_xml_path(own["output"]) for own in (plain, row)]
    datas = [mujoco.MjData(model) for model in models]
    random = np.random.default_rng(SEED)
    met, others = set(), 0
    for index in range(CONFIGURATIONS + 1):
        q = models[0].qpos0.copy()
        for joint in range(models[0].njnt if index else 0):
            if models[0].jnt_type[joint] >= 2:
                low, high = models[0].jnt_range[joint] if models[0].jnt_limited[joint] else (-3.0, 3.0)
                q[models[0].jnt_qposadr[joint]] = random.uniform(low, high)
        before, after = (contacts(model, data, q) for model, data in zip(models, datas))
        met |= excluded & before.keys()
        expected = {pair: own for pair, own in before.items() if pair not in excluded}
        others += len(expected)
        if after != expected:
            return False, f"contacts differ: {after}, expected {expected}"
    if excluded != met:
        return False, f"excluded pairs without contacts in any configuration: {excluded - met}"
    return True, f"{len(excluded)} pairs have no contacts any more, {others} contacts of others are equal"


def in_pinocchio(program, file, out):
    row = bake(program, file, out, "--exclude-pairs")
    urdf = pathlib.Path(row["output"])
    model = pinocchio.buildModelFromUrdf(str(urdf))
    here = os.getcwd()
    os.chdir(urdf.parent)
    try:
        kind = pinocchio.GeometryType.COLLISION
        geometry = pinocchio.buildGeomFromUrdf(model, str(urdf), kind, [str(urdf.parent)])
    finally:
        os.chdir(here)
    # Coal tests meshes, not their hulls, unless they are marked as convex.
    for own in geometry.geometryObjects:
        if hasattr(own.geometry, "buildConvexRepresentation"):
            own.geometry.buildConvexRepresentation(True)
            own.geometry = own.geometry.convex
    geometry.addAllCollisionPairs()
    all_pairs = len(geometry.collisionPairs)
    pinocchio.removeCollisionPairs(model, geometry, str(urdf.with_suffix(".srdf")))
    link = lambda at: model.frames[geometry.geometryObjects[at].parentFrame].name
    left = [tuple(sorted((link(pair.first), link(pair.second)))) for pair in geometry.collisionPairs]
    disabled = {tuple(sorted(pair["links"])): pair["reason"] for pair in row["excluded_pairs"]}
    if any(pair in disabled for pair in left):
        return False, "Pinocchio keeps pairs that the SRDF disables"
    data, collisions = model.createData(), geometry.createData()
    pinocchio.computeCollisions(model, data, geometry, collisions, pinocchio.neutral(model), False)
    touching = [pair for pair, found in zip(left, collisions.collisionResults) if found.isCollision()]
    if touching:
        return False, f"pairs that are not disabled touch in the neutral pose: {touching}"
    reasons = list(disabled.values())
    tally = {reason: reasons.count(reason) for reason in sorted(set(reasons))}
    return True, f"{all_pairs - len(left)} of {all_pairs} pairs of geometries are disabled, none of the others touches; {tally}"


def main(program, files):
    failed = 0
    for file in map(lambda name: pathlib.Path(name).resolve(), files):
        judges = {".xml": in_mujoco if mujoco else None, ".urdf": in_pinocchio if pinocchio else None}
        judge = judges.get(file.suffix)
        if judge is None:
            continue
        with tempfile.TemporaryDirectory() as out:
            is_right, result = judge(program, file, pathlib.Path(out))
        failed += not is_right
        print(f"{file.name}: {result}")
    return failed


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1], sys.argv[2:]) else 0)
