"""Bakes, files, the command, and ways in and out."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest
from conftest import CUBE, rock, torus

import hullmap

L_SHAPE = """
v 0 0 0
v 2 0 0
v 2 1 0
v 1 1 0
v 1 2 0
v 0 2 0
v 0 0 1
v 2 0 1
v 2 1 1
v 1 1 1
v 1 2 1
v 0 2 1
f 6 5 4 3 2 1
f 7 8 9 10 11 12
f 1 2 8 7
f 2 3 9 8
f 3 4 10 9
f 4 5 11 10
f 5 6 12 11
f 6 1 7 12
"""


def command(*words, cwd=None):
    return subprocess.run([sys.executable, "-m", "hullmap", *map(str, words)], cwd=cwd, capture_output=True, text=True)


@pytest.fixture()
def mesh(tmp_path):
    path = tmp_path / "ell.obj"
    path.write_text(L_SHAPE)
    return path


def test_bakes_are_deterministic():
    points = rock(2000, 1)
    first = hullmap.bake(points, threads=1).to_bytes()
    assert hullmap.bake(points).to_bytes() == first == hullmap.bake(points.astype(float), threads=2).to_bytes()


def test_options_are_those_of_the_command():
    points = rock(3000, 4)
    sizes = {kind: hullmap.bake(points, index=kind).nbytes for kind in ("tree", "medium", "compact", "none")}
    assert sizes["tree"] > sizes["medium"] > sizes["compact"] > sizes["none"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        few = hullmap.bake(points, max_vertices=32, index="compact")
    assert len(few[0]) <= 32 and few[0].outer_error > 0 and few.options.endswith("max_vertices 32")
    assert [type(warning.message) for warning in caught] == [hullmap.BakeWarning]
    assert "max_vertices" in str(caught[0].message) and "--" not in str(caught[0].message)
    assert caught[0].filename == __file__
    # The simplified hull contains every point.
    assert (few[0].signed_distance(points[::10]).upper < 1e-6).all()
    scaled = hullmap.bake(CUBE + 100, unit_scale=0.5, recentre=True)[0]
    assert np.allclose(scaled.bounds, [[-0.5] * 3, [0.5] * 3]) and np.allclose(scaled.origin, 50)
    assert hullmap.bake(CUBE, max_vertices=None, decompose=False).options == hullmap.bake(CUBE).options


def test_concave_meshes_become_parts(mesh):
    whole, parts = hullmap.bake_file(mesh), hullmap.bake_file(mesh, decompose=True)
    assert len(whole) == 1 and len(parts) == 2
    assert sum(hull.volume for hull in parts) == pytest.approx(3, rel=0.03)
    assert whole[0].protrusion is None and whole[0].uncovered is None and whole[0].part_count == 0
    assert all(hull.part_count == 2 and hull.solid in ("watertight", "closed") for hull in parts)
    assert all(0 <= hull.protrusion < 0.2 and hull.uncovered < 0.1 for hull in parts)
    assert all(hull.protrusion_at.shape == (3,) for hull in parts)
    notch = hullmap.poses([1.4, 1.4, 0.5])
    ball = hullmap.Sphere(0.01)
    assert whole.intersects(ball, notch).hit and not parts.intersects(ball, notch).hit
    vertices = [line.split()[1:] for line in L_SHAPE.splitlines() if line.startswith("v")]
    faces = [[int(v) - 1 for v in line.split()[1:]] for line in L_SHAPE.splitlines() if line.startswith("f")]
    arrays = hullmap.bake(np.array(vertices, float), faces, decompose=True)
    assert [hull.vertices.tolist() for hull in arrays] == [hull.vertices.tolist() for hull in parts]


def test_points_without_faces_were_not_decomposed_in_silence(tmp_path):
    (tmp_path / "cloud.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in CUBE))
    for bake in (
        lambda: hullmap.bake(rock(50, 1), decompose=True),
        lambda: hullmap.bake_file(tmp_path / "cloud.obj", decompose=True),
        lambda: hullmap.bake_parts([(CUBE, None), (CUBE + 5, None)], decompose=True),
    ):
        with pytest.warns(hullmap.BakeWarning, match="not decomposed, because it has no faces; add faces"):
            bake()


@pytest.mark.parametrize("flags", [{}, {"decompose": True}, {"index": "compact", "unit_scale": 0.01}])
def test_a_saved_pack_has_the_bytes_of_the_command(mesh, flags):
    words = [word for key, value in flags.items() for word in ("--set", f"{key}={str(value).lower()}")]
    run = command("build", mesh.name, "--out", ".", *words, cwd=mesh.parent)
    assert run.returncode == 0, run.stderr
    assert hullmap.bake_file(mesh, **flags).to_bytes() == (mesh.parent / "ell.hullmap").read_bytes()


def test_packs_are_saved_and_opened(tmp_path, cube):
    path = cube.pack.save(tmp_path / "cube.hullmap")
    assert path.read_bytes() == cube.pack.to_bytes() and [p.name for p in tmp_path.iterdir()] == ["cube.hullmap"]
    if os.name == "posix":
        mask = os.umask(0)
        os.umask(mask)
        assert path.stat().st_mode & 0o777 == 0o666 & ~mask
    pack = hullmap.open(path)
    assert pack.path == path and pack.nbytes == path.stat().st_size and pack["cube"].volume == cube.volume
    # Replaced while it is mapped.
    hullmap.bake(CUBE * 2).save(path)
    assert pack[0].volume == pytest.approx(8) and hullmap.open(path)[0].volume == pytest.approx(64)
    pack.check()
    with pytest.raises(FileNotFoundError):
        pack.save(tmp_path / "missing" / "cube.hullmap")


def test_the_command_runs(tmp_path, mesh, cube):
    assert command("--version").stdout.startswith("bake ")
    assert command("build").returncode == 2 and command("inspect", tmp_path / "none.hullmap").returncode == 2
    run = command("build", tmp_path, "--out", tmp_path / "baked", "--verify", "--json")
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    assert run.returncode == 0 and rows[0]["status"] == "baked"
    saved = cube.pack.save(tmp_path / "cube.hullmap")
    row = json.loads(command("inspect", saved, "--json").stdout)
    assert row["hulls"][0]["name"] == "cube"
    answer = json.loads(command("query", saved, saved, "--pose", "3 0 0 0 0 0 1", "--mode", "distance", "--json").stdout)
    assert answer["distance"] == pytest.approx(cube.distance(cube, [3, 0, 0, 0, 0, 0, 1]).distance)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_the_command_and_leaves_no_files(tmp_path):
    meshes = tmp_path / "meshes"
    meshes.mkdir()
    for index in range(200):
        text = "\n".join(f"v {x} {y} {z}" for x, y, z in rock(3000, index))
        (meshes / f"{index}.obj").write_text(text)
    words = [sys.executable, "-m", "hullmap", "build", str(meshes), "--out", str(tmp_path / "baked"), "--jobs", "1"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        deadline = time.monotonic() + 60
        while not list(tmp_path.glob("baked/*.hullmap")):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=30)
    assert process.returncode == 130 and b"interrupted" in stderr
    left = list((tmp_path / "baked").iterdir())
    assert 0 < len(left) < 200 and all(path.suffix == ".hullmap" for path in left)


def test_a_long_decomposition_showed_nothing():
    shares: list[float] = []
    parts = hullmap.bake(*torus(120, 30), decompose=True, progress=shares.append)
    assert parts.to_bytes() == hullmap.bake(*torus(120, 30), decompose=True).to_bytes() and len(parts) > 4
    assert shares == sorted(set(shares)) and len(shares) > 4 and 0 <= shares[0] < 0.6 and shares[-1] == 1
    for quick in (lambda call: hullmap.bake(CUBE, progress=call), lambda call: hullmap.bake_parts([(CUBE, None)], progress=call)):
        shares.clear()
        quick(shares.append)
        assert shares[-1:] == [1]
    with pytest.raises(hullmap.BakeError, match="progress: expected True or a function of the share that is done, found 0.5"):
        hullmap.bake(CUBE, progress=0.5)


def test_an_exception_of_the_callback_ends_the_bake():
    def stop(share):
        raise RuntimeError(f"enough at {share}")

    with pytest.raises(RuntimeError, match="enough at "):
        hullmap.bake(*torus(120, 30), decompose=True, max_error="0.5%", progress=stop)


BAR = """
import sys; sys.path.insert(0, sys.argv[1])
from conftest import torus
import hullmap
hullmap.bake(*torus(120, 30), name="ri\\x1bng", decompose=True, progress=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_a_bar_shows_on_terminals_alone():
    words = [sys.executable, "-c", BAR, os.path.dirname(__file__)]
    run = subprocess.run(words, capture_output=True)
    assert run.returncode == 0 and run.stderr == b"", run.stderr
    screen, terminal = os.openpty()
    with subprocess.Popen(words, stderr=terminal) as process:
        os.close(terminal)
        shown = b""
        while True:
            try:
                read = os.read(screen, 4096)
            except OSError:  # Linux's end of a terminal
                break
            if not read:
                break
            shown += read
    os.close(screen)
    lines = shown.decode().split("\r")
    assert process.returncode == 0 and len(lines) > 3, shown
    assert re.fullmatch(r"ri\?ng \[#* *\] +\d+%, \d+ s *", lines[1]) and "\x1b" not in shown.decode(), lines
    # The bar is gone at the end.
    assert lines[-2].strip() == "" and lines[-1] == "", lines


INTERRUPTED = """
import os, signal, sys, threading, time
import numpy as np, hullmap
sys.path.insert(0, sys.argv[1])
from conftest import torus
# Where the tests run in the background, signals of the keyboard are ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
points = np.random.default_rng(1).normal(size=(2_000_000, 3))
hull = hullmap.bake(points[:3000] / np.linalg.norm(points[:3000], axis=1, keepdims=True))[0]
poses = np.tile(hullmap.poses([1.5, 0.3, 0.2]), (4_000_000, 1))
ring = torus(400, 80)
def interrupt():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt, daemon=True).start()
start = time.monotonic()
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start)
    sys.stdout.flush()
    # Whether anything still computes.
    used = [time.process_time() for _ in range(16) if time.sleep(0.5) is None]
    print("idle", min(b - a for a, b in zip(used, used[1:])))
    sys.stdout.flush()
    os._exit(0)
print("done", time.monotonic() - start)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    "call", ["hull.contact(hull, poses)", "hullmap.bake(points)", 'hullmap.bake(*ring, decompose=True, max_error="0.5%")']
)
def test_ctrl_c_ends_a_long_call(call):
    words = [sys.executable, "-c", INTERRUPTED.format(call=call), os.path.dirname(__file__)]
    run = subprocess.run(words, capture_output=True, text=True, timeout=240)
    assert run.stdout.startswith("interrupted"), run.stdout + run.stderr
    assert float(run.stdout.split()[1]) < 5
    # A bake of one hull finishes in the background; a decomposition does not.
    if "bake(points)" not in call:
        assert float(run.stdout.split()[3]) < 0.05, run.stdout


@pytest.mark.filterwarnings("ignore::hullmap.BakeWarning")
def test_xml_snippets_are_complete(tmp_path):
    from xml.etree import ElementTree

    pack = hullmap.bake_parts([(CUBE, None), (CUBE * [1, 2, 3] + 5, None)], names=["a <&>", "b"])
    model = ElementTree.fromstring(hullmap.to_mjcf(pack, 'x "y"'))
    assert [mesh.get("name") for mesh in model.iter("mesh")] == ['x "y"_a <&>', 'x "y"_b']
    numbers = np.array(next(model.iter("mesh")).get("vertex").split(), np.float32).reshape(-1, 3)
    assert (numbers == pack[0].vertices).all()
    link = ElementTree.fromstring(hullmap.to_urdf(pack, tmp_path, density=2.0, prefix="package://m/"))
    assert float(link.find("inertial/mass").get("value")) == pytest.approx(2 * (8 + 48))
    files = [mesh.get("filename") for mesh in link.iter("mesh")]
    assert all(file.startswith("package://m/") for file in files) and len(set(files)) == 2
    for hull, file in zip(pack, files):
        again = hullmap.bake_file(tmp_path / file.removeprefix("package://m/"))[0]
        assert (again.vertices == hull.vertices).all() and len(again.faces) == len(hull.faces)
    # The inertia of both about their common centre of mass, from a fine sum over tetrahedra.
    inertia = {key: float(value) for key, value in link.find("inertial/inertia").attrib.items()}
    assert inertia["ixy"] < 0 and inertia["ixx"] > 0
    with pytest.raises(hullmap.ArrayError, match="MuJoCo requires a solid"):
        hullmap.to_mjcf(hullmap.bake(CUBE[:4]))


def test_primitives_replace_hulls_in_xml(tmp_path):
    from xml.etree import ElementTree

    # A slab on two posts, turned and moved. Each part is a box.
    slab, post = CUBE * [3, 2, 0.2], CUBE * [0.2, 0.3, 1]
    boxes = [slab, post + [-2, 0, -1.2], post + [2, 0, -1.2]]
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    points = np.concatenate(boxes) @ turn.T + [1, 2, 3]
    triangles = np.concatenate([np.array(faces) + 8 * index for index in range(3)])
    pack = hullmap.bake(points, triangles, decompose=True, max_error="1%", primitives=True)
    assert [hull.primitive.kind for hull in pack] == ["box"] * 3
    model = ElementTree.fromstring(hullmap.to_mjcf(pack))
    link = ElementTree.fromstring(hullmap.to_urdf(pack, tmp_path))
    assert list(model.iter("mesh")) == list(link.iter("mesh")) == list(tmp_path.iterdir()) == []
    geoms, collisions = list(model.iter("geom")), list(link.iter("collision"))
    assert len(geoms) == len(collisions) == 3
    read = lambda element, key: np.array(element.get(key).split(), float)
    for geom, collision in zip(geoms, collisions):
        size, center = read(geom, "size"), read(geom, "pos")
        origin = collision.find("origin")
        assert np.allclose(read(collision.find("geometry/box"), "size"), 2 * size) and np.allclose(read(origin, "xyz"), center)
        (w, x, y, z), angles = read(geom, "quat"), read(origin, "rpy")
        by_quaternion = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
        by_angles = (
            np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
            @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
            @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        )
        assert np.allclose(by_quaternion, by_angles)
        # All corners of one of the boxes are corners of this one.
        local = (points - center) @ by_quaternion
        assert (np.abs(np.abs(local) - size).max(axis=1) < 1e-3).sum() >= 8
