"""Compares where the report page of a robot places its links with other projects' parsers.

    check_page.py BAKE FILE...

Positions of joints are random, from a fixed seed. MuJoCo is the judge of MJCF, Pinocchio of URDF, Drake of
SDF. For MJCF, the pairs of bodies that touch in the neutral pose are compared, too. The scripts of the page
run in Node.js.
"""

import importlib
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

SEED = 20261126
CONFIGURATIONS = 50
HERE = pathlib.Path(__file__).parent


def installed(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


mujoco, pinocchio, drake = (installed(n) for n in ("mujoco", "pinocchio", "pydrake"))


def matrix(frame):
    x, y, z, w = frame["q"]
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.column_stack([np.array(turn), frame["t"]])


def follow(joints, positions):
    """The positions, including joints that follow others."""
    moved = [p - joint["reference"] for p, joint in zip(positions, joints)]
    for _ in joints:
        for index, joint in enumerate(joints):
            if joint["coefficients"]:
                at = 0.0 if joint["leader"] is None else moved[joint["leader"]]
                moved[index] = sum(c * at**power for power, c in enumerate(joint["coefficients"]))
    return [m + joint["reference"] for m, joint in zip(moved, joints)]


def in_mujoco(path, joints):
    if not mujoco or path.suffix != ".xml":
        return None
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    # Joints without a name, in the order of the page, which is MuJoCo's order for each body.
    addresses = [model.jnt_qposadr[model.joint(joint["name"]).id] if joint["name"] else None for joint in joints]
    names = [model.body(index).name for index in range(model.nbody)]

    def poses(positions):
        data.qpos[:] = model.qpos0
        for joint, address, position in zip(joints, addresses, positions):
            if joint["motion"] != "other" and address is not None:
                data.qpos[address] = position
        mujoco.mj_kinematics(model, data)
        return {n: np.column_stack([data.xmat[i].reshape(3, 3), data.xpos[i]]) for i, n in enumerate(names) if n}

    return poses


def in_pinocchio(path, joints):
    if not pinocchio or path.suffix != ".urdf":
        return None
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()

    def poses(positions):
        q = pinocchio.neutral(model)
        for joint, position in zip(joints, positions):
            if joint["motion"] == "other":
                continue
            own = model.joints[model.getJointId(joint["name"])]
            q[own.idx_q : own.idx_q + own.nq] = position if own.nq == 1 else [np.cos(position), np.sin(position)]
        pinocchio.framesForwardKinematics(model, data, q)
        frames = zip(model.frames, data.oMf)
        body = pinocchio.FrameType.BODY
        return {f.name: np.column_stack([o.rotation, o.translation]) for f, o in frames if f.type == body}

    return poses


def in_drake(path, joints):
    if not drake or path.suffix != ".sdf":
        return None
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.multibody.tree import BodyIndex
    from pydrake.systems.framework import DiagramBuilder

    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()

    def poses(positions):
        q = plant.GetPositions(context)
        for joint, position in zip(joints, positions):
            if joint["motion"] != "other":
                q[plant.GetJointByName(joint["name"]).position_start()] = position
        plant.SetPositions(context, q)
        bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
        return {b.name(): plant.EvalBodyPoseInWorld(context, b).GetAsMatrix34() for b in bodies}

    return poses


def neutral_contacts(path):
    """Pairs of bodies of one robot with contacts in MuJoCo's neutral pose, without planes and the world."""
    model = mujoco.MjModel.from_xml_path(str(path))
    # Margins let geoms meet that do not touch.
    model.geom_margin[:] = 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = set()
    for contact in data.contact:
        bodies = sorted(int(model.geom_bodyid[geom]) for geom in (contact.geom1, contact.geom2))
        roots = {int(model.body_rootid[body]) for body in bodies}
        is_one_robot = len(roots) == 1 or not any(model.body_dofnum[root] for root in roots)
        if contact.dist <= 0 and bodies[0] != 0 and is_one_robot:
            found.add(tuple(model.body(body).name for body in bodies))
    return found


def compare(bake, file, out):
    page = out / "page.html"
    command = [bake, "robot", str(file), "--out", str(out / "baked"), "--report", str(page), "--json", "--quiet"]
    row = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
    if row["status"] == "failed":
        return f"{row['errors']}"
    text = page.read_text()
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])
    joints, names = data["joints"], [link["name"] for link in data["links"]]
    judge = next((found for found in (load(file, joints) for load in (in_mujoco, in_pinocchio, in_drake)) if found), None)
    if judge is None:
        return "skipped: no parser of its format is installed"
    random = np.random.default_rng(SEED)
    low = [-3.0 if joint["limits"] is None else joint["limits"][0] for joint in joints]
    high = [3.0 if joint["limits"] is None else joint["limits"][1] for joint in joints]
    configurations = [follow(joints, random.uniform(low, high)) for _ in range(CONFIGURATIONS)]
    configurations.append(follow(joints, [joint["neutral"] for joint in joints]))
    node = ["node", str(HERE / "poses.mjs"), str(page)]
    run = subprocess.run(node, input=json.dumps(configurations), capture_output=True, text=True, check=True)
    worst, compared = 0.0, 0
    for positions, frames in zip(configurations, json.loads(run.stdout)):
        expected = judge(positions)
        for name, frame in zip(names, frames):
            if name in expected:
                worst = max(worst, np.abs(matrix(frame) - expected[name]).max())
                compared += 1
    # The page states the neutral pose as the program computed it, not the script.
    own = [np.abs(matrix(link["neutral"]) - matrix(f)).max() for link, f in zip(data["links"], json.loads(run.stdout)[-1])]
    worst = max(worst, *own)
    if worst > 1e-9 or not compared:
        return f"poses of {compared} links differ by up to {worst}"
    result = f"{compared} poses within {worst:.0e}"
    if file.suffix == ".xml":
        baked = pathlib.Path(row["output"])
        listed = text.split('id="touching"')[1].split("</section>")[0].split("<details>")[0]
        cells = [row.split("<td") for row in listed.split("<tr data-links")[1:]]
        words = [[cell.split("</")[0].rsplit(">", 1)[-1] for cell in row[1:]] for row in cells]
        for side, path in ((2, file), (3, baked)):
            ours = {tuple(sorted(row[:2])) for row in words if row[side] == "touch"}
            theirs = {tuple(sorted(pair)) for pair in neutral_contacts(path)}
            if ours != theirs:
                return f"pairs that touch differ: only ours {ours - theirs}, only MuJoCo's {theirs - ours}"
            result += f", {len(ours)} pairs touch"
    return result


def main(bake, files):
    failed = 0
    for file in map(lambda name: pathlib.Path(name).resolve(), files):
        with tempfile.TemporaryDirectory() as out:
            result = compare(bake, file, pathlib.Path(out))
        failed += "within" not in result and "skipped" not in result
        print(f"{file.name}: {result}")
    return failed


if __name__ == "__main__":
    if not shutil.which("node"):
        print("skipped: poses of report pages: Node.js is not installed")
        sys.exit()
    sys.exit(1 if main(sys.argv[1], sys.argv[2:]) else 0)
