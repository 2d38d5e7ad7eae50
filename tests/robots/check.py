"""Loads robot descriptions in other projects' parsers, before and after `bake robot`.

    check.py BAKE FILE...

Joints, masses and inertias must be equal. A parser that is not installed is skipped, with a line that
says so; a description that it does not load before is not its concern either.
"""

import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def installed(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"skipped: {name} is not installed")
        return None


mujoco, pinocchio, pybullet, drake, newton = (
    installed(n) for n in ("mujoco", "pinocchio", "pybullet", "pydrake", "newton")
)


def in_mujoco(path):
    if not mujoco or path.suffix == ".sdf":
        return None
    model = mujoco.MjModel.from_xml_path(str(path))
    names = ["body_mass", "body_inertia", "body_ipos", "body_iquat", "body_pos", "body_quat"]
    names += ["jnt_type", "jnt_pos", "jnt_axis", "jnt_range", "qpos0", "dof_damping"]
    return [getattr(model, name).copy() for name in names]


def in_pinocchio(path):
    if not pinocchio or path.suffix != ".urdf":
        return None
    model = pinocchio.buildModelFromUrdf(str(path))
    here = os.getcwd()
    os.chdir(path.parent)
    try:
        pinocchio.buildGeomFromUrdf(model, str(path), pinocchio.GeometryType.COLLISION, [str(path.parent)])
    finally:
        os.chdir(here)
    return [np.array([inertia.toDynamicParameters() for inertia in model.inertias]), np.array(list(model.names), dtype="U")]


def in_pybullet(path):
    if not pybullet or path.suffix != ".urdf":
        return None
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        dynamics = [pybullet.getDynamicsInfo(body, link)[:5] for link in range(-1, pybullet.getNumJoints(body))]
        # Mass, inertia, and frame of the inertia.
        return [np.array([np.concatenate([[d[0]], d[2], d[3], d[4]]) for d in dynamics])]
    finally:
        pybullet.disconnect(client)


def in_drake(path):
    if not drake or path.suffix == ".xml":
        return None
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.multibody.tree import BodyIndex
    from pydrake.systems.framework import DiagramBuilder

    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    context = plant.CreateDefaultContext()
    inertia = [body.CalcSpatialInertiaInBodyFrame(context).CopyToFullMatrix6() for body in bodies]
    return [np.array(inertia), np.array([plant.num_joints()])]


def in_newton(path):
    if not newton or path.suffix == ".sdf":
        return None
    builder = newton.ModelBuilder()
    if path.suffix == ".urdf":
        # If a link has no mass, Newton computes it from the collisions.
        builder.default_shape_cfg.density = 0.0
    (builder.add_mjcf if path.suffix == ".xml" else builder.add_urdf)(str(path))
    bodies = [builder.body_mass, builder.body_inertia, builder.body_com]
    joints = [builder.joint_type, builder.joint_axis, builder.joint_X_p, builder.joint_X_c]
    return [np.array(values, dtype=float) for values in bodies + joints]


PARSERS = {
    "mujoco": in_mujoco,
    "pinocchio": in_pinocchio,
    "pybullet": in_pybullet,
    "drake": in_drake,
    "newton": in_newton,
}


def equal(a, b):
    if a.dtype.kind == "U":
        return np.array_equal(a, b)
    return a.shape == b.shape and np.allclose(a, b, rtol=1e-12, atol=1e-12)


def main(bake, files):
    failed = 0
    for file in map(lambda name: pathlib.Path(name).resolve(), files):
        for options in ([], ["--decompose", "--max-error", "2mm"], ["--from-visual", "always"]):
            with tempfile.TemporaryDirectory() as out:
                command = [bake, "robot", str(file), "--out", out, "--json", "--quiet", *options]
                run = subprocess.run(command, capture_output=True, text=True)
                if run.returncode:
                    print(f"{file.name}: {run.stderr.strip() or run.stdout}")
                    failed += 1
                    continue
                row = json.loads(run.stdout)
                written = pathlib.Path(row["output"]).resolve()
                again = subprocess.run(command, capture_output=True, text=True)
                if json.loads(again.stdout)["status"] != "fresh":
                    print(f"{file.name}: a second run changes files")
                    failed += 1
                for name, load in PARSERS.items():
                    try:
                        before = load(file)
                    except Exception as error:  # The original is at fault.
                        print(f"{file.name}: {name} does not load the original: {error}")
                        continue
                    if before is None:
                        continue
                    try:
                        after = load(written)
                    except Exception as error:
                        print(f"{file.name} {options}: {name} does not load the output: {error}")
                        failed += 1
                        continue
                    if len(before) != len(after) or not all(map(equal, before, after)):
                        print(f"{file.name} {options}: {name}: joints, masses or inertias differ")
                        failed += 1
                    else:
                        counts = [own["action"] for own in row["collisions"]]
                        tally = {action: counts.count(action) for action in sorted(set(counts))}
                        print(f"{file.name} {options}: {name}: equal; {tally}")
    return failed


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1], sys.argv[2:]) else 0)
