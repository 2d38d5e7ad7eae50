"""Bodies of convex parts that fall into a pit, in MuJoCo: time of a step, penetration, and rest.

    pip install mujoco
    python benches/peers/pit_mujoco.py FOLDER... [--bodies 200] [--steps 900]

Each FOLDER holds OBJ files with one object for each part, for instance of `bake decompose` and of
decompose.py. Only names that all folders have are used. The scene is the same as in `parts-table`
of crates/hullmap-parry/tests/scenes: bodies 1 m long, rotated at random, in layers above a pit; a step takes 1/120 s.
First one body of two known boxes has the right mass, and the right depth in the floor.
"""

import argparse
import pathlib
import tempfile
import time

import mujoco
import numpy as np

import known

SPACING, MARGIN, STEP = 1.4, 0.3, 1 / 120


def parts_of(path):
    """The parts of an OBJ file, each an array of points; all together fit a box of 1 m."""
    parts, points = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["o"]:
            points = []
            parts.append(points)
        elif words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
    parts = [np.array(points) for points in parts if len(points) > 3]
    low = np.min([part.min(axis=0) for part in parts], axis=0)
    high = np.max([part.max(axis=0) for part in parts], axis=0)
    return [(part - (low + high) / 2) / max(high - low) for part in parts]


def world(meshes, count, half, seed):
    """A model of `count` bodies of the meshes in turn."""
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP
    spec.memory = 1 << 30
    box = mujoco.mjtGeom.mjGEOM_BOX
    spec.worldbody.add_geom(type=box, size=[half + 1, half + 1, 0.5], pos=[0, 0, -0.5])
    for x, y in [(1, 0), (-1, 0), (0, 1), (0, -1)]:
        size = [0.5 if x else half + 1, 0.5 if y else half + 1, 20]
        spec.worldbody.add_geom(type=box, size=size, pos=[x * (half + 0.5), y * (half + 0.5), 20])
    for name, parts in meshes:
        for index, part in enumerate(parts):
            spec.add_mesh(name=f"{name}_{index}", uservert=part.flatten().tolist())
    random = np.random.default_rng(seed)
    row = max(int((half - MARGIN) * 2 / SPACING), 1)
    for i in range(count):
        layer, cell = divmod(i, row * row)
        across = lambda k: (k - (row - 1) / 2) * SPACING
        shift = 0.3 if layer % 2 else 0.0
        turn = random.normal(size=4)
        pos = [across(cell % row) + shift, across(cell // row) + shift, 1.2 + layer * SPACING]
        body = spec.worldbody.add_body(pos=pos, quat=turn / np.linalg.norm(turn))
        body.add_freejoint()
        name, parts = meshes[i % len(meshes)]
        for index in range(len(parts)):
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"{name}_{index}", density=1000)
    return spec.compile()


def deepest(data):
    """Depth of the deepest contact."""
    return max(-data.contact.dist.min(), 0) if data.ncon else 0.0


def prove():
    """Ends the program if a body of the known boxes is not as heavy, or as deep in the floor, as it should be."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "boxes.obj")
        path.write_text(known.obj("separated"))
        parts = parts_of(path)
    points = np.concatenate(known.placed("separated"))
    scale = 1 / np.ptp(points, axis=0).max()
    model = world([("boxes", parts)], 1, 1.0, 1)
    data, depths = mujoco.MjData(model), []
    # The pit is empty but for its floor; the body lies in it, and hangs above it.
    for _, gap in known.POSES.values():
        data.qpos[:] = [0, 0, scale * (gap + 0.5 * np.ptp(points[:, 2])), 1, 0, 0, 0]
        mujoco.mj_forward(model, data)
        depths.append((f"gap {gap:g}: depth", max(-gap, 0.0), deepest(data) / scale))
    mass = model.body_mass.sum() / (1000 * scale**3)
    known.require(f"MuJoCo {mujoco.__version__}", [("volume", sum(known.VOLUMES), mass), *depths])


def run(model, steps):
    """Milliseconds a step in the first and the last quarter, deepest contact, speed at the end."""
    data = mujoco.MjData(model)
    times, depths = [], []
    for _ in range(steps):
        start = time.process_time()
        mujoco.mj_step(model, data)
        times.append(1e3 * (time.process_time() - start))
        depths.append(deepest(data))
    quarter = max(steps // 4, 1)
    speeds = np.linalg.norm(data.qvel.reshape(-1, 6)[:, :3], axis=1)
    middle = data.qpos.reshape(-1, 7)[:, :3]
    return {
        "ms first": np.mean(times[:quarter]),
        "ms last": np.mean(times[-quarter:]),
        "deepest mm": 1e3 * max(depths),
        "deepest mm, last quarter": 1e3 * max(depths[-quarter:]),
        "median speed mm/s": 1e3 * np.median(speeds),
        "slower than 10 mm/s": int((speeds < 0.01).sum()),
        "below the floor": int((middle[:, 2] < 0).sum()),
        "contacts": data.ncon,
        "warnings": int(sum(warning.number for warning in data.warning)),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--steps", type=int, default=900)
    parser.add_argument("--half-width", type=float, default=4.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    prove()
    names = set.intersection(*({path.stem for path in folder.glob("*.obj")} for folder in arguments.folders))
    for folder in arguments.folders:
        meshes = [(name, parts_of(folder / f"{name}.obj")) for name in sorted(names)]
        model = world(meshes, arguments.bodies, arguments.half_width, arguments.seed)
        found = run(model, arguments.steps)
        print(f"{folder}: {len(meshes)} meshes, {sum(len(parts) for _, parts in meshes)} parts, MuJoCo {mujoco.__version__}")
        for name, value in found.items():
            print(f"    {name}: {value:.4g}" if isinstance(value, float) else f"    {name}: {value}")


if __name__ == "__main__":
    main()
