"""Judges the pairs that `hullmap.Robot` tests in MJCF, by MuJoCo's contacts on random models.

    check_pairs.py COUNT [SEED]

Each model has bodies that are static, jointed, free, mocap or rigidly connected, geoms of all convex kinds, masks,
classes, `exclude`, `pair`, flags and margins. In every second one, all geoms overlap, so that MuJoCo has a contact
for each pair of geoms that it tests: those are the pairs that hullmap tests, exactly. In the others, `in_collision`
of random configurations is true if and only if MuJoCo has a contact with a distance of at most 0, and `link_poses`
are MuJoCo's. Distances within GRAZING of 0 are not judged.
"""

import pathlib
import random
import sys
import tempfile
from collections import Counter

import numpy as np

try:
    import hullmap
    import mujoco
except ImportError as missing:
    print(f"skipped: pairs: {missing.name} is not installed")
    sys.exit()

CONFIGURATIONS = 6
# In metres; geoms are 0.05 to 2 large. MuJoCo's tolerance for convex pairs is 1e-6.
GRAZING = 1e-5
MESHES = 12
# Few meshes, since reading them takes most of the time.
KINDS = [*["box", "sphere", "capsule", "cylinder", "ellipsoid"] * 3, "mesh"]


def numbers(values):
    return " ".join(f"{value:.17g}" for value in np.atleast_1d(values))


def write_meshes(folder, rng):
    """Octahedra with vertices moved along their axes."""
    for index in range(MESHES):
        reach = rng.uniform(0.1, 0.4, 6)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        axes = np.concatenate([np.eye(3), -np.eye(3)]) * reach[:, None]
        points = axes @ (turn * np.sign(np.linalg.det(turn))).T + rng.uniform(-0.01, 0.01, 3)
        faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
        lines = [f"v {numbers(point)}" for point in points] + ["f " + " ".join(str(v + 1) for v in face) for face in faces]
        (folder / f"m{index}.obj").write_text("\n".join(lines) + "\n")


class Model:
    """The text of a random model."""

    def __init__(self, seed):
        self.seed, self.pick, self.rng = seed, random.Random(seed), np.random.default_rng(seed)
        # Geoms that are larger than all offsets overlap.
        self.is_crowded = seed % 2 == 0
        self.bodies, self.geoms, self.joints = ["world"], [], 0
        self.moves_alone = False
        rest = [self.body(0) for _ in range(self.pick.randint(1, 4))]
        world = [self.geom() for _ in range(self.pick.choice([0, 0, 1, 2]))]
        cut = self.pick.randint(0, len(rest)) if self.chance(0.1) else 0
        parts = [rest[:cut], rest[cut:]] if cut else [rest]
        worlds = [f"<worldbody>\n{''.join((world if not at else []) + part)}</worldbody>" for at, part in enumerate(parts)]
        self.text = f"<mujoco>\n{self.head()}{''.join(worlds)}{self.contact()}\n</mujoco>"

    def chance(self, share):
        return self.pick.random() < share

    def offset(self):
        return self.rng.uniform(-1, 1, 3) * (0.02 if self.is_crowded else 0.6)

    def place(self):
        turn = self.rng.normal(size=4)
        return f'pos="{numbers(self.offset())}" quat="{numbers(turn)}"'

    def masks(self):
        if self.chance(0.6):
            return ""
        return "".join(
            f' {name}="{self.pick.choice([0, 1, 1, 2, 3, 4])}"' for name in ("contype", "conaffinity") if self.chance(0.7)
        )

    def geom(self):
        name = f"g{len(self.geoms)}"
        self.geoms.append(name)
        kind = self.pick.choice(KINDS)
        low, high = (1, 2) if self.is_crowded else (0.05, 0.3)
        size = numbers(self.rng.uniform(low, high, {"sphere": 1, "capsule": 2, "cylinder": 2}.get(kind, 3)))
        shape = f'size="{size}"'
        if kind == "mesh":
            shape = f'mesh="{"big" if self.is_crowded else "m"}{self.pick.randrange(MESHES)}"'
        extra = f' class="{self.pick.choice("ab")}"' if self.chance(0.15) else ""
        extra += f' margin="{self.rng.uniform(0, 0.1):.3f}"' if self.chance(0.15) else ""
        extra += f' gap="{self.rng.uniform(0, 0.1):.3f}"' if self.chance(0.1) else ""
        text = f'<geom name="{name}" type="{kind}" {shape} {self.place()}{self.masks()}{extra}/>\n'
        return f"<frame {self.place()}>{text}</frame>\n" if self.chance(0.1) else text

    def joint(self, kind):
        name = f"j{self.joints}"
        self.joints += 1
        if kind in ("ball", "free"):
            self.moves_alone = True
            return f'<joint name="{name}" type="{kind}"/>\n'
        axis, at = numbers(self.rng.normal(size=3)), numbers(self.offset())
        text = f'<joint name="{name}" type="{kind}" axis="{axis}" pos="{at}"/>\n'
        return f"<frame {self.place()}>{text}</frame>\n" if self.chance(0.1) else text

    def body(self, depth):
        is_named = self.chance(0.8)
        name = f"b{len(self.bodies)}"
        self.bodies.append(name if is_named else None)
        kinds = []
        is_mocap = depth == 0 and self.chance(0.15)
        if is_mocap:
            self.moves_alone = True
        elif depth == 0 and self.chance(0.1):
            kinds = ["free"]
        elif self.chance(0.65):
            kinds = self.pick.choices(["hinge", "slide"], k=self.pick.choice([1, 1, 1, 2, 3]))
            if self.chance(0.05):
                kinds = ["ball"]
        own = [self.joint(kind) for kind in kinds] + ['<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>\n']
        own += [self.geom() for _ in range(self.pick.choice([0, 1, 1, 1, 2, 3]))]
        if depth < 4:
            own += [self.body(depth + 1) for _ in range(self.pick.choice([0, 0, 1, 1, 2]))]
        attributes = f' name="{name}"' if is_named else ""
        attributes += ' mocap="true"' if is_mocap else ""
        attributes += f' childclass="{self.pick.choice("ab")}"' if self.chance(0.1) else ""
        text = f"<body{attributes} {self.place()}>\n{''.join(own)}</body>\n"
        return f"<frame {self.place()}>{text}</frame>\n" if self.chance(0.1) else text

    def head(self):
        flags = [("filterparent", 0.25), ("contact", 0.01), ("constraint", 0.01)]
        flags = [name for name, share in flags if self.chance(share)]
        self.is_disabled = flags[-1:] not in ([], ["filterparent"])
        flags = [f'<flag {name}="disable"/>' for name in flags]
        option = "".join(f"<option>{flag}</option>\n" for flag in flags)
        scale = numbers(self.rng.uniform(0.5, 1.5, 3) * self.pick.choice([1, -1]))
        meshes = "".join(
            f'<mesh name="m{at}" file="m{at}.obj" scale="{scale}"/><mesh name="big{at}" file="m{at}.obj" scale="20 20 20"/>'
            for at in range(MESHES)
        )
        classes = "".join(f'<default class="{name}"><geom{self.masks()}/></default>' for name in "ab")
        return f"{option}<default><geom{self.masks()}/>{classes}</default>\n<asset>{meshes}</asset>\n"

    def contact(self):
        named = [name for name in self.bodies if name]
        lines = []
        for _ in range(self.pick.choice([0, 0, 1, 2, 4])):
            if len(named) > 1:
                a, b = self.pick.sample(named, 2)
                lines.append(f'<exclude body1="{a}" body2="{b}"/>')
        for _ in range(self.pick.choice([0, 0, 0, 1, 2, 4])):
            if len(self.geoms) > 1:
                a, b = self.pick.sample(self.geoms, 2)
                margin = ' margin="0.05"' if self.chance(0.2) else ""
                lines.append(f'<pair geom1="{a}" geom2="{b}"{margin}/>')
        return f"<contact>{''.join(lines)}</contact>" if lines else ""


def contacts(model, data):
    """The least distance of each pair of geoms that MuJoCo has contacts of, by their indices."""
    found = {}
    for at in range(data.ncon):
        pair = tuple(sorted(map(int, data.contact.geom[at])))
        found[pair] = min(found.get(pair, np.inf), float(data.contact.dist[at]))
    return found


def tested(robot, model):
    """The pairs of geoms that hullmap tests, by MuJoCo's indices: pairs of tested links, without the skipped ones."""
    # Geoms that are only drawn do not collide.
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    collides[np.concatenate([model.pair_geom1, model.pair_geom2]).astype(int)] = True
    of_link = [np.flatnonzero(collides & (model.geom_bodyid == body)).tolist() for body in range(model.nbody)]
    index = {model.geom(geom).name: geom for geom in range(model.ngeom)}
    skipped = {tuple(sorted(index[geom] for geom in own.geoms)) for own in robot.skipped if len(own.geoms) == 2}
    pairs = [(a, b) for own_a, own_b in robot.pairs.tolist() if own_a != own_b for a in of_link[own_a] for b in of_link[own_b]]
    return {tuple(sorted(pair)) for pair in pairs} - skipped


def judge(text, path, tally, rng):
    """Compares a model. Returns what differs."""
    path.write_text(text.text)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    robot = hullmap.Robot.from_mjcf(path, strict=not text.is_disabled)
    links = [name and model.body(at).name for at, name in enumerate(text.bodies)]
    if len(robot.link_names) != model.nbody or any(a and a != b for a, b in zip(links, robot.link_names)):
        return f"links {robot.link_names} are not MuJoCo's {links}"
    if text.is_crowded:
        mujoco.mj_fwdPosition(model, data)
        expected = contacts(model, data)
        # Pairs within a body are compared by body.
        body = lambda pair: tuple(int(model.geom_bodyid[geom]) for geom in pair)
        inner = {body(pair) for pair in expected if len(set(body(pair))) == 1}
        outer = {pair for pair in expected if len(set(body(pair))) == 2}
        tally["pairs of geoms"] += len(expected)
        of_geoms = tested(robot, model)
        if outer != of_geoms or inner != {(a, b) for a, b in robot.pairs.tolist() if a == b}:
            names = lambda pairs: [tuple(model.geom(geom).name for geom in pair) for pair in sorted(pairs)]
            return f"only MuJoCo tests {names(outer - of_geoms)}, only hullmap {names(of_geoms - outer)}, within {inner}"
        return None
    addresses = [model.joint(name).qposadr[0] for name in robot.joint_names]
    for _ in range(CONFIGURATIONS):
        q = rng.uniform(-1.5, 1.5, len(addresses))
        data.qpos[addresses] = q
        if text.moves_alone:
            free = np.ones(model.nq, bool)
            free[addresses] = False
            data.qpos[free] = rng.normal(size=free.sum())
            data.mocap_pos[:] = rng.uniform(-1, 1, data.mocap_pos.shape)
            data.mocap_quat[:] = rng.normal(size=data.mocap_quat.shape)
        mujoco.mj_fwdPosition(model, data)
        distances = contacts(model, data)
        if any(abs(distance) < GRAZING for distance in distances.values()):
            tally["grazing"] += 1
            continue
        # MuJoCo's contacts of a pair may contradict its distance of the pair, which is right then.
        for pair, distance in distances.items():
            own = mujoco.mj_geomDistance(model, data, *pair, 10, None)
            if (own <= 0) != (distance <= 0) and abs(own) > GRAZING:
                tally["MuJoCo contradicts itself"] += 1
                print(f"seed {text.seed}: geoms {pair}: MuJoCo's contact has the distance {distance}, mj_geomDistance {own}")
                distances[pair] = own
        expected = {pair for pair, distance in distances.items() if distance <= 0}
        poses = hullmap.poses(data.xpos, data.xquat, order="wxyz")
        hits = [bool(robot.in_collision(poses=poses))]
        if not text.moves_alone:
            hits.append(bool(robot.in_collision(q)))
            own = robot.link_poses(q)
            turns = np.abs((own[:, 3:] * poses[:, 3:]).sum(-1))
            if np.abs(own[:, :3] - poses[:, :3]).max() > 1e-9 or (turns < 1 - 1e-9).any():
                return f"q = {q.tolist()}: link poses differ"
            bodies = {tuple(sorted(int(model.geom_bodyid[geom]) for geom in pair)) for pair in expected}
            index = {name: at for at, name in enumerate(robot.link_names)}
            touching = {tuple(sorted((index[a], index[b]))) for a, b in robot.touching(q)}
            if bodies != touching:
                return f"q = {q.tolist()}: MuJoCo {sorted(bodies)}, hullmap {sorted(touching)}, distances {distances}"
        tally["configurations"] += 1
        tally["collisions"] += bool(expected)
        if any(hit != bool(expected) for hit in hits):
            return f"q = {q.tolist()}: MuJoCo {sorted(expected)}, hullmap {hits}, distances {distances}"
    return None


def main(count, seed=0):
    tally, faults = Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_meshes(folder, np.random.default_rng(seed))
        for at in range(seed, seed + count):
            text = Model(at)
            difference = judge(text, folder / "model.xml", tally, np.random.default_rng(at))
            for feature in ("mocap", "<exclude", "<pair", "filterparent", "free", "margin", "contype"):
                tally[feature] += feature in text.text
            if difference:
                faults += 1
                print(f"seed {at}: {difference}\n{text.text if faults == 1 else ''}")
    print(f"{count} models from seed {seed}: {dict(tally)}, {faults} differ")
    # The sample is representative.
    if count >= 1000:
        assert 0.2 < tally["collisions"] / tally["configurations"] < 0.8, tally
        assert all(tally[feature] > count / 50 for feature in ("mocap", "<exclude", "<pair", "filterparent", "free")), tally
    return faults


if __name__ == "__main__":
    sys.exit(1 if main(*map(int, sys.argv[1:])) else 0)
