"""Adds colliders to glTF files with `bake export --into`, and reads the results with readers of others.

    python check.py BAKE MODEL FOLDER

For each extension: the file's own bytes and members stay, trimesh and pygltflib read the same render
meshes as before, the colliders lie where the hulls are, masses equal the meshes', and the colliders
bake to the same hulls. Writes the files to FOLDER, for the validator.
"""

import base64
import json
import math
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pygltflib
import trimesh


def read(path):
    """The document and the BIN chunk of a file."""
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), None
    length = struct.unpack_from("<I", data, 12)[0]
    text = data[20 : 20 + length]
    return json.loads(text), data[28 + length :]


def contains(new, old, path=""):
    """Fails unless `new` has all that `old` has; lists may be longer at their end."""
    if isinstance(old, dict):
        for key, value in old.items():
            assert key in new, f"{path}/{key} is gone"
            if path.startswith("/buffers") and key == "byteLength":
                assert new[key] >= value
            else:
                contains(new[key], value, f"{path}/{key}")
    elif isinstance(old, list):
        for index, value in enumerate(old):
            contains(new[index], value, f"{path}/{index}")
    else:
        assert new == old, f"{path}: {new} != {old}"


def matrix(node):
    """Transform of a node."""
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    result = np.eye(4)
    result[:3, :3] = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]) * np.array(node.get("scale", [1, 1, 1]))
    result[:3, 3] = node.get("translation", [0, 0, 0])
    return result


def worlds(document):
    """Transform of each node to the scene."""
    found = {}
    stack = [(root, np.eye(4)) for root in document["scenes"][document.get("scene", 0)]["nodes"]]
    while stack:
        index, parent = stack.pop()
        node = document["nodes"][index]
        found[index] = parent @ matrix(node)
        stack += [(child, found[index]) for child in node.get("children", [])]
    return found


def positions(document, chunk, mesh):
    accessor = document["accessors"][document["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"]]
    view = document["bufferViews"][accessor["bufferView"]]
    uri = document["buffers"][view["buffer"]].get("uri")
    data = base64.b64decode(uri.split(",")[1]) if uri else chunk
    floats = np.frombuffer(data, "<f4", 3 * accessor["count"], view["byteOffset"])
    assert np.allclose(floats.reshape(-1, 3).min(0), accessor["min"], rtol=0, atol=0)
    return floats.reshape(-1, 3).astype(float)


def collider_mesh(document, extensions, name):
    body = extensions[name]["collider"]
    if name == "OMI_physics_body":
        shape = document["extensions"]["OMI_physics_shape"]["shapes"][body["shape"]]
        assert shape["type"] == "convex"
        return shape["convex"]["mesh"]
    geometry = body["geometry"]
    assert geometry["convexHull"] is True
    return document["nodes"][geometry["node"]]["mesh"] if "node" in geometry else geometry["mesh"]


def bake(*words):
    result = subprocess.run([BAKE, *map(str, words)], capture_output=True, text=True)
    assert result.returncode == 0, f"{words}: {result.stderr}"
    return result.stdout


def hulls(pack):
    return json.loads(bake("export", pack, "--format", "json"))["hulls"]


def shape(hull):
    """The faces of a hull as sets of points, whatever the order of vertices."""
    points = [tuple(0.0 + x for x in point) for point in hull["positions"]]
    return {frozenset(points[corner] for corner in face) for face in hull["polygons"]}


def scene(path):
    """Bounds, area and number of meshes that trimesh draws."""
    loaded = trimesh.load(path)
    return np.array(loaded.bounds), loaded.area, len(loaded.graph.nodes_geometry)


def check_masses(document, model, density):
    """Mass, centre and inertia of each body, against trimesh's of the meshes of its node in the scene."""
    loaded = trimesh.load(model)
    world = worlds(document)
    checked = 0
    for index, node in enumerate(document["nodes"]):
        for name in ("KHR_physics_rigid_bodies", "OMI_physics_body"):
            motion = node.get("extensions", {}).get(name, {}).get("motion")
            if not motion:
                continue
            assert name[:3] == "KHR" or motion["type"] == "dynamic"
            transform, geometry = loaded.graph[node["name"]]
            mesh = loaded.geometry[geometry].copy()
            mesh.merge_vertices()
            mesh.apply_transform(transform)
            if mesh.volume < 0:
                mesh.invert()
            mesh.density = density
            center = world[index] @ np.append(motion["centerOfMass"], 1)
            x, y, z, w = motion["inertiaOrientation"]
            turn = matrix({"rotation": [x, y, z, w]})[:3, :3]
            axes = world[index][:3, :3] / np.cbrt(abs(np.linalg.det(world[index][:3, :3])))
            if np.linalg.det(axes) < 0:
                axes = axes @ np.diag([-1, 1, 1])
            tensor = axes @ turn @ np.diag(motion["inertiaDiagonal"]) @ turn.T @ axes.T
            assert math.isclose(motion["mass"], mesh.mass, rel_tol=1e-5), (motion["mass"], mesh.mass)
            assert np.allclose(center[:3], mesh.center_mass, atol=1e-5)
            assert np.allclose(tensor, mesh.moment_inertia, rtol=1e-4, atol=1e-5 * np.trace(tensor)), node["name"]
            checked += 1
    return checked


def check(model, folder, words, names):
    stem = "-".join(word.strip("-") for word in words)
    out = folder / f"{stem}{model.suffix}"
    pack = folder / "pack" / f"{model.stem}.hullmap"
    bake("export", pack, "--into", model, *words, "--out", out, "--force", "--density", "700")
    before, old_chunk = read(model)
    after, chunk = read(out)
    contains(after, before)
    if old_chunk is not None:
        assert chunk[: len(old_chunk)] == old_chunk, "render data changed"
    assert set(names) <= set(after["extensionsUsed"]) and "extensionsRequired" not in after
    assert [np.allclose(a, b) for a, b in zip(scene(model), scene(out))] == [True] * 3, "the scene changed"
    assert len(pygltflib.GLTF2().load(str(out)).scenes[0].nodes) == len(before["scenes"][0]["nodes"])

    world = worlds(after)
    expected = {hull["name"]: np.array(hull["positions"]) for hull in hulls(pack)}
    for name in set(names) - {"OMI_physics_shape"}:
        found = {}
        for index, node in enumerate(after["nodes"]):
            if "collider" in node.get("extensions", {}).get(name, {}):
                assert "mesh" not in node and index in world
                points = positions(after, chunk, collider_mesh(after, node["extensions"], name))
                found[node["name"]] = points @ world[index][:3, :3].T + world[index][:3, 3]
        assert set(found) == set(expected)
        for hull, points in expected.items():
            assert np.abs(found[hull] - points).max() < 1e-6 * np.abs(points).max(), hull
    masses = check_masses(after, model, 700)
    assert masses > 0

    bake("build", out, "--split", "auto", "--out", folder / "again", "--set", "pack_names=stem", "--force")
    again = hulls(folder / "again" / f"{stem}.hullmap")
    assert [hull["name"] for hull in again] == [hull["name"] for hull in hulls(pack)]
    for a, b in zip(again, hulls(pack)):
        assert shape(a) == shape(b), a["name"]
    print(f"{out.name}: {len(expected)} colliders, {masses} bodies, the same hulls again")


def main():
    global BAKE
    BAKE, model, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    bake("build", model, "--split", "object", "--decompose", "--max-error", "4%", "--out", folder / "pack", "--force")
    khr, omi = ["KHR_physics_rigid_bodies"], ["OMI_physics_body", "OMI_physics_shape"]
    for words, names in [
        (["--for", "khr-physics"], khr),
        (["--for", "khr-physics", "--set", "draft=2026-06"], khr),
        (["--for", "omi"], omi),
        (["--for", "both"], khr + omi),
        (["--for", "godot"], omi),
    ]:
        check(model, folder, words, names)


main()
