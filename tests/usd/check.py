"""Bakes a stage by `hullmap.usd.bake`, and checks the layer by OpenUSD itself.

    check.py [BAKE]

Truth comes from elsewhere: boxes have a formula for their mass, OpenUSD computes the mass of bodies
(`RigidBodyAPI.ComputeMassProperties`), and its validators judge the composed stage. Newton loads the stage
too, if it is installed. `BAKE` is the command, for `bake export --for usd`.
"""

import contextlib
import itertools
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation, Vt

import hullmap
import hullmap.usd

METERS = 0.01  # The stage is in centimetres.
HOSTILE = 'a "quoted"\nname @b'


def box(low, high):
    """Points and faces of a box, counter-clockwise seen from outside."""
    points = np.array(list(itertools.product(*zip(low, high))), dtype=np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, faces


def ell():
    """An L: two boxes as one closed mesh, of the volume 5."""
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    points = np.array([(x, y, z) for z in (0, 1) for x, y in outline], dtype=np.float32)
    faces = [(5, 4, 3, 2, 1, 0), (6, 7, 8, 9, 10, 11)] + [(i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6) for i in range(6)]
    return points, faces


def rock(seed):
    """A rock whose faces are the faces of its own hull."""
    hull = hullmap.bake(np.random.default_rng(seed).normal(size=(200, 3)).astype(np.float32) * 7)[0]
    return hull.vertices.copy(), [face.tolist() for face in hull.faces]


def mesh(stage, path, shape, **attributes):
    made = UsdGeom.Mesh.Define(stage, path)
    points, faces = shape
    made.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    made.CreateFaceVertexCountsAttr([len(face) for face in faces])
    made.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
    made.CreateExtentAttr([Gf.Vec3f(*map(float, points.min(0))), Gf.Vec3f(*map(float, points.max(0)))])
    made.CreateSubdivisionSchemeAttr("none")
    for name, value in attributes.items():
        getattr(made, f"Create{name}Attr")(value)
    return made


def collider(prim, approximation, **values):
    UsdPhysics.CollisionAPI.Apply(prim)
    UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(approximation)
    for name, value in values.items():
        prim.CreateAttribute(name.replace("__", ":"), Sdf.ValueTypeNames.Int).Set(value)


def asset(path):
    """Meshes with transforms, instances, bodies and hostile names."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, METERS)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    world = UsdGeom.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(world.GetPrim())
    # A body that is turned and scaled, with two meshes and no collider.
    body = UsdGeom.Xform.Define(stage, "/World/body")
    body.AddTranslateOp().Set(Gf.Vec3d(10, 20, 30))
    body.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40))
    body.AddScaleOp().Set(Gf.Vec3f(2, 3, 4))
    UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
    mesh(stage, "/World/body/box", box((0, 0, 0), (1, 2, 4))).AddTranslateOp().Set(Gf.Vec3d(5, 0, 0))
    mesh(stage, "/World/body/ell", ell())
    # A mirror image.
    mesh(stage, "/World/mirror", box((0, 0, 0), (1, 2, 4))).AddScaleOp().Set(Gf.Vec3f(-1, 1, 2))
    # A body whose colliders are meshes of the purpose guide, and which is drawn by another mesh.
    arm = UsdGeom.Xform.Define(stage, "/World/arm")
    UsdPhysics.RigidBodyAPI.Apply(arm.GetPrim())
    mesh(stage, "/World/arm/drawn", rock(1))
    concave = mesh(stage, "/World/arm/concave", ell(), Purpose="guide").GetPrim()
    collider(concave, "convexDecomposition", physxConvexDecompositionCollision__maxConvexHulls=8)
    concave.AddAppliedSchema("PhysxCollisionAPI")
    concave.CreateAttribute("physxCollision:contactOffset", Sdf.ValueTypeNames.Float).Set(0.25)
    UsdPhysics.MassAPI.Apply(concave).CreateMassAttr(7.0)
    rubber = UsdShade.Material.Define(stage, "/World/rubber")
    UsdPhysics.MaterialAPI.Apply(rubber.GetPrim()).CreateStaticFrictionAttr(0.9)
    UsdShade.MaterialBindingAPI.Apply(concave).Bind(rubber, materialPurpose="physics")
    group = UsdPhysics.CollisionGroup.Define(stage, "/World/group")
    group.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(concave.GetPath())
    limited = mesh(stage, "/World/arm/limited", rock(2)).GetPrim()
    collider(limited, "convexHull", newton__maxHullVertices=16)
    cube = UsdGeom.Cube.Define(stage, "/World/arm/cube").GetPrim()
    UsdPhysics.CollisionAPI.Apply(cube)
    # Instances of a prim of the stage, and one more that is no instance.
    proto = stage.CreateClassPrim("/_proto")
    proto.SetTypeName("Xform")
    mesh(stage, "/_proto/stone", rock(3))
    for number in range(3):
        copy = UsdGeom.Xform.Define(stage, f"/World/stone_{number}")
        copy.AddTranslateOp().Set(Gf.Vec3d(number, 0, 0))
        copy.GetPrim().GetReferences().AddInternalReference("/_proto")
        copy.GetPrim().SetInstanceable(number < 2)
    # Names as they come: letters of other alphabets, and a name made of one that is hostile.
    mesh(stage, "/World/größe_漢字", box((-1, -1, -1), (1, 1, 1)), Orientation="leftHanded")
    named = Tf.MakeValidIdentifier(HOSTILE)
    mesh(stage, f"/World/{named}", rock(1)).GetPrim().SetDisplayName(HOSTILE)
    mesh(stage, f"/World/{named}_hulls", rock(4))
    # Meshes that get none.
    mesh(stage, "/World/proxy", rock(5), Purpose="proxy")
    mesh(stage, "/World/hidden", rock(5)).GetVisibilityAttr().Set("invisible")
    mesh(stage, "/World/broken", box((0, 0, 0), (1, 1, 1)), FaceVertexIndices=[0, 1, 99] * 8)
    mesh(stage, "/World/flat", (np.eye(3, dtype=np.float32), [(0, 1, 2)]))
    mesh(stage, "/World/empty", (np.zeros((1, 3), np.float32), []))
    moving = mesh(stage, "/World/moving", rock(5)).GetPointsAttr()
    moving.Set(moving.Get(), 1.0)
    moving.Set(moving.Get(), 2.0)
    still = mesh(stage, "/World/terrain", ell()).GetPrim()
    collider(still, "none")
    collider(mesh(stage, "/World/boxed", rock(5)).GetPrim(), "boundingCube")
    stage.GetRootLayer().Save()
    return stage


def properties(stage):
    """All properties of the prims of a stage, without properties that hulls may change."""
    found = {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        if "_hulls" in str(prim.GetPath()) and prim.GetName() != Tf.MakeValidIdentifier(HOSTILE) + "_hulls":
            continue
        values = {}
        for item in prim.GetAuthoredProperties():
            if item.GetName() in ("physics:collisionEnabled", "collection:colliders:includes"):
                continue
            is_attribute = isinstance(item, Usd.Attribute)
            values[item.GetName()] = str(item.Get() if is_attribute else item.GetTargets())
        found[str(prim.GetPath())] = (prim.GetTypeName(), tuple(prim.GetPrimTypeInfo().GetAppliedAPISchemas()), values)
    return found


def expected(points, faces, frame, density):
    """Mass and centre in the world, and inertia about it, of the solid of a mesh whose points are moved by a
    matrix for row vectors. By tetrahedra from the origin."""
    points = points.astype(float) @ frame[:3, :3] + frame[3, :3]
    triangles = np.array([(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)])
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    corners = np.stack([np.zeros_like(a), a, b, c], axis=1)
    sums = corners.sum(1)
    moments = (np.einsum("tki,tkj->tij", corners, corners) + np.einsum("ti,tj->tij", sums, sums)) / 20
    sign = np.sign(volumes.sum())
    volume = abs(volumes.sum())
    center = sign * np.einsum("t,ti->i", volumes, sums / 4) / volume
    second = sign * np.einsum("t,tij->ij", volumes, moments) - volume * np.outer(center, center)
    return density * volume, center, density * (np.trace(second) * np.eye(3) - second)


def check_mass(stage, body, parts):
    """The mass that OpenUSD adds up from the hulls of a body is the mass of its meshes, in the body's frame."""
    prim = stage.GetPrimAtPath(body)
    asked = []

    def volume_of(shape):
        asked.append(shape)
        info = UsdPhysics.RigidBodyAPI.MassInformation()
        info.volume, info.inertia, info.centerOfMass = 1.0, Gf.Matrix3f(1.0), Gf.Vec3f(0)
        world = Gf.Transform(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
        own = Gf.Transform(UsdGeom.XformCache().GetLocalToWorldTransform(shape))
        turn = world.GetRotation().GetInverse()
        info.localPos = Gf.Vec3f(turn.TransformDir(own.GetTranslation() - world.GetTranslation()))
        info.localRot = Gf.Quatf((own.GetRotation() * turn).GetQuat())
        return info

    mass, moments, center, axes = UsdPhysics.RigidBodyAPI(prim).ComputeMassProperties(volume_of)
    total = sum(part[0] for part in parts)
    assert asked and math.isclose(mass, total, rel_tol=1e-5), (body, mass, total)
    return mass, np.array(moments), np.array(center), axes


def check_hulls(report, stage, found):
    """Vertices equal hullmap's, bit for bit, and each hull is a convex collider that is not drawn."""
    count = 0
    for prim in report.prims:
        source = stage.GetPrimAtPath(prim.path)
        group = stage.GetPrimAtPath(prim.hulls)
        hulls = group.GetAllChildren()
        assert len(hulls) == prim.parts, prim
        points, faces = found[prim.path]
        for hull in hulls:
            own = np.array(UsdGeom.Mesh(hull).GetPointsAttr().Get())
            assert own.dtype == np.float32
            if prim.parts == 1 and prim.protrusion is None and "limited" not in prim.path:
                wanted = hullmap.bake(points, faces)[0].vertices
                assert own.tobytes() == wanted.tobytes(), prim.path
            low, high = UsdGeom.Mesh(hull).GetExtentAttr().Get()
            assert np.array_equal(own.min(0), low) and np.array_equal(own.max(0), high)
            assert UsdGeom.Imageable(hull).ComputePurpose() == "guide"
            assert UsdPhysics.CollisionAPI(hull).GetCollisionEnabledAttr().Get() is True
            assert UsdPhysics.MeshCollisionAPI(hull).GetApproximationAttr().Get() == "convexHull"
            assert hull.GetAttribute("newton:maxHullVertices").Get() == -1
            assert hull.GetAttribute("mjc:maxhullvert").Get() == -1
            assert hull.GetAttribute("physxConvexHullCollision:hullVertexLimit").Get() == max(4, len(own))
            assert hull.GetCustomData()["hullmap"]["mesh"] == prim.path
            assert ("protrusion" in hull.GetCustomData()["hullmap"]) == (prim.protrusion is not None)
            count += 1
        # Hulls follow their mesh.
        if not source.GetPath().HasPrefix("/_proto"):
            frames = [UsdGeom.XformCache().GetLocalToWorldTransform(own) for own in (source, group)]
            assert Gf.IsClose(*frames, 1e-9), prim.path
    return count


def validate(stage):
    """Names and messages of what the validators of OpenUSD find."""
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return {(error.GetName(), error.GetMessage()) for error in context.Validate(stage)}


def check_validators(stage, known):
    """No validator finds an error that the asset does not have."""
    new = validate(stage) - known
    assert not new, new


def check_python(folder):
    before = asset(folder / "asset @1.usda")
    text = (folder / "asset @1.usda").read_bytes()
    known, shown = validate(before), properties(before)
    report = hullmap.usd.bake(folder / "asset @1.usda", folder / "deep" / "hulls.usda")
    assert (folder / "asset @1.usda").read_bytes() == text, "the asset was changed"
    stage = Usd.Stage.Open(str(folder / "deep" / "hulls.usda"))
    assert stage.GetRootLayer().subLayerPaths == ["../asset @1.usda"]
    assert UsdGeom.GetStageMetersPerUnit(stage) == METERS and UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert properties(stage) == shown, "a prim of the asset was changed"
    named = Tf.MakeValidIdentifier(HOSTILE)
    found = {
        "/World/mirror": box((0, 0, 0), (1, 2, 4)), "/World/body/box": box((0, 0, 0), (1, 2, 4)),
        "/World/body/ell": ell(), "/World/arm/concave": ell(),
        "/World/arm/limited": rock(2), "/_proto/stone": rock(3), "/World/stone_2/stone": rock(3),
        "/World/größe_漢字": box((-1, -1, -1), (1, 1, 1)), f"/World/{named}": rock(1), f"/World/{named}_hulls": rock(4),
    }  # fmt: skip
    # The faces of a left-handed mesh are read backwards.
    points, faces = found["/World/größe_漢字"]
    found["/World/größe_漢字"] = points, [face[::-1] for face in faces]
    baked = {prim.path: prim for prim in report.prims}
    assert set(baked) == set(found), set(baked) ^ set(found)
    count = check_hulls(report, stage, found)
    # Distinct meshes are baked once.
    assert baked["/_proto/stone"].bake == baked["/World/stone_2/stone"].bake and baked["/_proto/stone"].instances == 2
    # Two boxes, the L as a hull and as parts, four rocks, and the flat mesh.
    assert report.bakes == 9 and baked["/World/mirror"].bake == baked["/World/body/box"].bake, report.bakes
    skipped = {entry.path: entry.reason for entry in report.skipped}
    for path, reason in [
        ("arm/drawn", "has colliders"), ("proxy", "purpose is proxy"), ("hidden", "invisible"), ("broken", "index 99"),
        ("flat", "flat"), ("empty", "no points"), ("moving", "animated"), ("terrain", "does not move"),
        ("boxed", "boundingCube"),
    ]:  # fmt: skip
        assert reason in skipped.pop(f"/World/{path}"), path
    assert not skipped, skipped
    # The colliders that are replaced are off, and no other.
    off = {"/World/arm/concave", "/World/arm/limited"}
    assert set(report.off) == off
    for prim in stage.Traverse():
        if prim.HasAPI(UsdPhysics.CollisionAPI):
            is_on = UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get()
            assert is_on != (str(prim.GetPath()) in off), prim
    # Settings of the collider.
    assert baked["/World/arm/concave"].parts > 1 and baked["/World/arm/limited"].vertices <= 16
    hull = stage.GetPrimAtPath("/World/arm/concave_hulls/hull_01")
    assert hull.GetAttribute("physxCollision:contactOffset").Get() == 0.25
    assert "PhysxCollisionAPI" in hull.GetPrimTypeInfo().GetAppliedAPISchemas()
    material, _ = UsdShade.MaterialBindingAPI(hull).ComputeBoundMaterial("physics")
    assert material.GetPath() == "/World/rubber"
    members = UsdPhysics.CollisionGroup(stage.GetPrimAtPath("/World/group")).GetCollidersCollectionAPI()
    assert members.ComputeMembershipQuery().IsPathIncluded(hull.GetPath())
    check_validators(stage, known)
    # Mass: of both meshes of the body at 1000 kg/m3, in the world; and the mass that the collider states.
    density = 1000 * METERS**3
    cache = UsdGeom.XformCache()
    parts = []
    for path in ("/World/body/box", "/World/body/ell"):
        frame = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path)))
        parts.append(expected(*found[path], frame, density))
    mass, moments, center, _ = check_mass(stage, "/World/body", parts)
    assert math.isclose(sum(baked[path].mass for path in ("/World/body/box", "/World/body/ell")), mass, rel_tol=1e-6)
    own = {path: hull_mass(stage, baked[path].hulls) for path in baked}
    for path, part in zip(("/World/body/box", "/World/body/ell"), parts):
        frame = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path)))
        check_solid(stage, baked[path].hulls, frame, part)
    frame = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath("/World/mirror")))
    check_solid(stage, "/World/mirror_hulls", frame, expected(*found["/World/mirror"], frame, density))
    assert math.isclose(own["/World/arm/concave"], 7.0, rel_tol=1e-6)
    assert math.isclose(own["/World/größe_漢字"], 8 * density, rel_tol=1e-6)
    print(
        f"python: {len(baked)} meshes, {count} hulls, {report.bakes} bakes, {len(report.skipped)} skipped; "
        f"body {mass} kg"
    )
    return stage


def hull_mass(stage, group):
    return sum(UsdPhysics.MassAPI(hull).GetMassAttr().Get() for hull in stage.GetPrimAtPath(group).GetChildren())


def check_solid(stage, group, frame, part):
    """Centre and inertia of hulls, in the world, equal the mesh's."""
    mass, center, inertia = part
    hulls = stage.GetPrimAtPath(group).GetChildren()
    # Rows are the axes of the frame without its scale.
    turn = frame[:3, :3] / np.linalg.norm(frame[:3, :3], axis=1)[:, None]
    total = np.zeros((3, 3))
    for hull in hulls:
        api = UsdPhysics.MassAPI(hull)
        at = np.array(api.GetCenterOfMassAttr().Get(), dtype=float) @ frame[:3, :3] + frame[3, :3]
        assert np.allclose(at, center, rtol=1e-5, atol=1e-5), (group, at, center)
        axes = np.array(Gf.Matrix3d(Gf.Quatd(api.GetPrincipalAxesAttr().Get())))
        total += turn.T @ axes.T @ np.diag(np.array(api.GetDiagonalInertiaAttr().Get(), dtype=float)) @ axes @ turn
    assert np.allclose(total, inertia, rtol=1e-5, atol=1e-5 * np.abs(inertia).max()), (group, total, inertia)
    assert math.isclose(hull_mass(stage, group), mass, rel_tol=1e-6)


def check_always(folder):
    """Drawn meshes replace the colliders of their body, primitives too."""
    report = hullmap.usd.bake(
        folder / "asset @1.usda", from_visual="always", decompose=True, max_error="2mm", max_vertices=32
    )
    assert {"/World/arm/concave", "/World/arm/limited", "/World/arm/cube", "/World/terrain"} == set(report.off), (
        report.off
    )
    assert all(prim.protrusion is None or prim.protrusion <= 0.002 * (1 + 1e-9) for prim in report.prims)
    assert {"/World/arm/drawn", "/World/terrain"} <= {prim.path for prim in report.prims}
    never = hullmap.usd.bake(folder / "asset @1.usda", from_visual="never")
    assert {prim.path for prim in never.prims} == {"/World/arm/concave", "/World/arm/limited"}
    again = hullmap.usd.bake(folder / "asset @1.usda", from_visual="never")
    assert again.text == never.text, "not reproducible"


def check_errors(folder):
    """Errors name the file and the remedy, and nothing is written."""
    source, layer = folder / "asset @1.usda", folder / "deep" / "hulls.usda"
    (folder / "no.usda").write_text("no stage")
    for error, words, call in [
        (FileExistsError, "force", lambda: hullmap.usd.bake(source, layer)),
        (FileNotFoundError, "gone.usda", lambda: hullmap.usd.bake(folder / "gone.usda")),
        (hullmap.BakeError, "no.usda", lambda: hullmap.usd.bake(folder / "no.usda")),
        (hullmap.BakeError, "is the stage itself", lambda: hullmap.usd.bake(source, source, force=True)),
        (hullmap.BakeError, "hulls of hullmap already", lambda: hullmap.usd.bake(layer)),
        (hullmap.BakeError, ".usda", lambda: hullmap.usd.bake(source, folder / "x.obj")),
        (hullmap.BakeError, "recentre", lambda: hullmap.usd.bake(source, recentre=True)),
        (hullmap.BakeError, "octree", lambda: hullmap.usd.bake(source, index="octree")),
        (hullmap.BakeError, "from_visual", lambda: hullmap.usd.bake(source, from_visual="some")),
    ]:
        try:
            call()
        except error as found:
            assert words in str(found), found
        else:
            raise AssertionError(words)
    assert sorted(path.name for path in folder.iterdir()) == ["asset @1.usda", "deep", "no.usda"]
    # A stage in memory, and an instance of another file.
    stage = Usd.Stage.CreateInMemory()
    mesh(stage, "/root", rock(6))
    stage.SetDefaultPrim(stage.GetPrimAtPath("/root"))
    there = stage.DefinePrim("/there")
    there.GetReferences().AddReference(str(source), "/World/body")
    there.SetInstanceable(True)
    report = hullmap.usd.bake(stage)
    assert (
        "subLayers" not in report.text
        and report.prims[0].hulls == "/root/hulls"
        and "default prim" in report.prims[0].notes[-1]
    )
    assert len(report.skipped) == 2 and all("instance of" in entry.reason for entry in report.skipped)


def check_command(bake, folder):
    """`bake export --for usd`, over a stage whose mesh has the name that OpenUSD makes of the object's."""
    out = folder / "command"
    out.mkdir()
    points, faces = ell()
    lines = [f"v {x} {y} {z}" for x, y, z in points] + ["f " + " ".join(str(c + 1) for c in face) for face in faces]
    name = 'seat "x" @1'
    (out / "chair.obj").write_text("\n".join([f"o {name}", *lines]) + "\n")
    stage = Usd.Stage.CreateNew(str(out / "chair.usda"))
    UsdGeom.Xform.Define(stage, "/World/chair")
    own = Tf.MakeValidIdentifier(name)
    collider(mesh(stage, f"/World/chair/{own}", ell()).GetPrim(), "none")
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, METERS)
    stage.SetDefaultPrim(stage.GetPrimAtPath("/World"))
    known = validate(stage)
    stage.GetRootLayer().Save()
    run = lambda line: subprocess.run([bake, *line], cwd=out, check=True, capture_output=True, text=True)
    run(["build", "chair.obj", "--out", ".", "--split", "object", "--decompose", "--quiet"])
    line = ["export", "chair.hullmap", "--for", "usd", "--prim", "/World/chair", "--asset", "./chair.usda"]
    run([*line, "--set", f"meters_per_unit={METERS}", "--set", "stage_up=y", "--out", "hulls.usda"])
    both = Usd.Stage.Open(str(out / "hulls.usda"))
    check_validators(both, known)
    assert UsdPhysics.CollisionAPI(both.GetPrimAtPath(f"/World/chair/{own}")).GetCollisionEnabledAttr().Get() is False
    hulls = both.GetPrimAtPath(f"/World/chair/{own}_hulls").GetChildren()
    pack = hullmap.open(out / "chair.hullmap")
    assert len(hulls) == len(pack) > 1
    for prim, hull in zip(hulls, pack):
        assert np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get()).tobytes() == hull.vertices.tobytes()
    check_solid(both, f"/World/chair/{own}_hulls", np.eye(4), expected(points, faces, np.eye(4), 1000 * METERS**3))
    # Python finds the same parts.
    report = hullmap.usd.bake(out / "chair.usda", decompose=True)
    assert report.prims[0].parts == len(hulls)
    print(f"command: {len(hulls)} hulls equal to the pack's")


@contextlib.contextmanager
def moved(folder):
    """In another working directory."""
    here = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(here)


def check_document():
    """The example of docs/usd.md runs as it stands."""
    text = (pathlib.Path(__file__).parents[2] / "docs" / "usd.md").read_text(encoding="utf-8")
    example = text.split("```python\n")[1].split("```")[0]
    with tempfile.TemporaryDirectory() as name, moved(name):
        for asset_name in ("robot.usd", "chair.usd"):
            stage = Usd.Stage.CreateNew(asset_name)
            UsdGeom.Xform.Define(stage, "/World")
            mesh(stage, "/World/seat", ell())
            stage.GetRootLayer().Save()
        names = {}
        exec(example, names)
        assert [prim.parts for prim in names["report"].prims] == [2] and pathlib.Path("robot_physics.usda").exists()


def check_newton(stage):
    try:
        import newton
    except ImportError:
        print("skipped: newton is not installed")
        return
    # It does not read faulty meshes.
    for name in ("broken", "empty"):
        stage.GetPrimAtPath(f"/World/{name}").SetActive(False)
    builder = newton.ModelBuilder()
    found = builder.add_usd(stage)
    shapes = found["path_shape_map"]
    bodies = found["path_body_map"]
    compared = 0
    for prim in stage.Traverse():
        shape = shapes.get(str(prim.GetPath()))
        if shape is None or "hullmap" not in prim.GetCustomData():
            continue
        own = np.unique(np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get()), axis=0)
        read = np.unique(np.asarray(builder.shape_source[shape].vertices, dtype=np.float32), axis=0)
        assert len(read) == len(own), (prim, len(read), len(own))
        compared += 1
    assert compared > 5, compared
    wanted = sum(hull_mass(stage, f"/World/body/{name}_hulls") for name in ("box", "ell"))
    mass = builder.body_mass[bodies["/World/body"]]
    assert math.isclose(mass, wanted, rel_tol=1e-4), (mass, wanted)
    print(f"newton: {compared} hulls with all of their vertices; body {mass} kg")


def main(bake):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stage = check_python(folder)
        check_always(folder)
        check_errors(folder)
        check_document()
        check_newton(stage)
        if bake:
            check_command(bake, folder)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
