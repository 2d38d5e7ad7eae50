"""Compares which mesh files names in descriptions lead to with MuJoCo, and the robots after `bake robot`.

    check_paths.py BAKE TABLE

The table, `mesh_paths.json`, states for bodies the file that MuJoCo opens. It is tested here, and
`crates/hullmap-robot` is tested against it. Each robot is written to its own folder and to another one; in
MuJoCo, all colliding vertices must be where they were. A package whose name differs from its folder's must be found
by Pinocchio and PyBullet.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import mujoco
import numpy as np
from check import pinocchio, pybullet

TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

INLINE = """<mujoco><asset>
 <mesh name="points" vertex="0 0 0 1 0 0 0 1 0 0 0 1.5"/>
 <mesh name="faces" scale="1 2 -1" vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 2 1 0 1 3 0 3 2 1 2 3"/>
</asset><worldbody><body name="b"><freejoint/><geom type="mesh" mesh="points"/><geom type="mesh" mesh="faces" pos="3 0 0"/>
<geom type="mesh" mesh="faces" pos="9 0 0" euler="0 90 0"/></body></worldbody></mujoco>"""


def written(folder, case):
    """Writes the files of a case; no two meshes have the same size."""
    for size, mesh in enumerate(case["meshes"], 1):
        path = folder / mesh
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TETRAHEDRON.format(size))
    for name, text in case["files"].items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder / case["model"]


def paths(model):
    """The mesh file of each body, in MuJoCo."""
    found = {}
    for geom in range(model.ngeom):
        mesh = model.geom_dataid[geom]
        if mesh >= 0:
            at = model.mesh_pathadr[mesh]
            found[model.body(model.geom_bodyid[geom]).name] = model.paths[at:].split(b"\0")[0].decode()
    return found


def vertices(path):
    """The colliding vertices of each body, in the world."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = {}
    for geom in range(model.ngeom):
        mesh = model.geom_dataid[geom]
        if mesh >= 0 and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            own = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
            placed = own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            body = model.body(model.geom_bodyid[geom]).name
            found.setdefault(body, []).extend((np.round(placed, 4) + 0.0).tolist())
    return {body: sorted(own) for body, own in found.items()}


def check(bake_path, case, folder):
    model = written(folder, case)
    found = paths(mujoco.MjModel.from_xml_path(str(model)))
    for body, expected in case["expected"].items():
        if pathlib.Path(found.get(body, "-")).resolve() != (folder / expected).resolve():
            yield f"MuJoCo reads {found.get(body)} for {body}, and the table says {expected}"
    before = vertices(model)
    # The second one replaces included files.
    for out in (folder / "out", model.with_name("baked_" + model.name)):
        command = [bake_path, "robot", str(model), "--out", str(out), "--json", "--quiet", "--force"]
        run = subprocess.run(command, capture_output=True, text=True, cwd=folder)
        if run.returncode:
            yield f"{run.stderr.strip() or run.stdout}"
            continue
        try:
            after = vertices(folder / json.loads(run.stdout)["output"])
        except ValueError as error:
            yield f"MuJoCo does not load the output in {out.name}: {error}"
            continue
        if before != after:
            yield f"the output in {out.name} has other collisions: {before}, {after}"


def check_package(bake_path, folder):
    """The folder is `my-robot`, the name in package.xml is `my_robot`."""
    mesh = '<geometry><mesh filename="package://my-robot/meshes/x.obj"/></geometry>'
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    link = f'<inertial><mass value="1"/>{inertia}</inertial><visual>{mesh}</visual><collision>{mesh}</collision>'
    urdf = f'<robot name="arm"><link name="a">{link}</link></robot>'
    files = {"my-robot/urdf/arm.urdf": urdf, "my-robot/package.xml": "<package><name>my_robot</name></package>"}
    case = {"meshes": ["my-robot/meshes/x.obj"], "files": files, "model": "my-robot/urdf/arm.urdf"}
    model = written(folder, case)
    output = model.with_name("hulls.urdf")
    subprocess.run([bake_path, "robot", str(model), "--out", str(output), "--quiet"], check=True, cwd=folder)
    if "package://my-robot/urdf/hulls_collision/x_hull.obj" not in output.read_text():
        yield output.read_text()
    if pinocchio:
        robot = pinocchio.buildModelFromUrdf(str(output))
        kind = pinocchio.GeometryType.COLLISION
        try:
            if pinocchio.buildGeomFromUrdf(robot, str(output), kind, package_dirs=[str(folder)]).ngeoms != 1:
                yield "Pinocchio reads no collision"
        except ValueError as error:
            yield f"Pinocchio: {error}"
    if pybullet:
        client = pybullet.connect(pybullet.DIRECT)
        try:
            body = pybullet.loadURDF(str(output))
            if len(pybullet.getCollisionShapeData(body, -1)) != 1:
                yield "PyBullet reads no collision"
        except pybullet.error as error:
            yield f"PyBullet: {error}"
        finally:
            pybullet.disconnect(client)


def main(bake_path, table):
    bake_path = str(pathlib.Path(bake_path).resolve())
    cases = json.loads(pathlib.Path(table).read_text())
    inline = {"model": "m.xml", "files": {"m.xml": INLINE}, "meshes": [], "expected": {}}
    cases.append({"name": "meshes in the model", **inline})
    failed = 0
    for case in cases:
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / ".git").mkdir()
            for fault in check(bake_path, case, pathlib.Path(folder).resolve()):
                print(f"{case['name']}: {fault}")
                failed += 1
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / ".git").mkdir()
        for fault in check_package(bake_path, pathlib.Path(folder).resolve()):
            print(f"package: {fault}")
            failed += 1
    print(f"mesh files: {len(cases)} robots, {failed} faults")
    return failed


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1], sys.argv[2]) else 0)
