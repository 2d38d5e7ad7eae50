"""Reads a stage: which meshes get hulls, where the hulls go, and why other meshes get none.

Reference: OpenUSD, "Rigid Body Physics in USD"; "Scenegraph Instancing".
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Set, Tuple

import numpy as np
import numpy.typing as npt

from .._hullmap import BakeError, Error
from ._report import SkippedPrim

FROM_VISUAL = ("missing", "always", "never")

# A mesh collider of these approximations is not the mesh, or the mesh itself is better than hulls.
_PRIMITIVES = ("boundingCube", "boundingSphere")
_TRIANGLES = ("none", "meshSimplification")
_HULLS = ("convexHull", "convexDecomposition")


def pxr(module: str) -> Any:
    """A module of OpenUSD."""
    try:
        return importlib.import_module(f"pxr.{module}")
    except ImportError as error:
        raise Error(f"this requires OpenUSD ({error}): install it with `pip install usd-core`") from None


@dataclass
class Source:
    """A mesh that gets hulls."""

    prim: Any
    """The prim that the layer can write over: of an instance, the prim that all of them share."""
    points: npt.NDArray[np.float32]
    counts: npt.NDArray[np.int64]
    corners: npt.NDArray[np.int64]
    approximation: Optional[str]
    """The approximation of its own collider, if it has one."""
    body: Optional[Any]
    """The rigid body that it belongs to."""
    frames: List[npt.NDArray[np.float64]] = field(default_factory=list)
    """The linear parts of its transforms to the world, for row vectors: one, or one per instance."""
    instances: int = 0

    @property
    def path(self) -> str:
        return str(self.prim.GetPath())


@dataclass
class Walk:
    """The meshes of a stage."""

    sources: List[Source]
    skipped: List[SkippedPrim]
    replaced: Dict[str, str]
    """By path of a collider that is no mesh, or is not baked: the body whose drawn meshes replace it."""


def _prims(stage: Any) -> Iterator[Any]:
    usd = pxr("Usd")
    return iter(stage.Traverse(usd.TraverseInstanceProxies(usd.PrimDefaultPredicate)))


def _body(prim: Any) -> Optional[Any]:
    """The rigid body that a prim belongs to: the nearest one above, or itself."""
    physics = pxr("UsdPhysics")
    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(physics.RigidBodyAPI):
            return prim
        prim = prim.GetParent()
    return None


def _is_collider(prim: Any) -> bool:
    return bool(prim.HasAPI(pxr("UsdPhysics").CollisionAPI))


def _is_on(prim: Any) -> bool:
    return pxr("UsdPhysics").CollisionAPI(prim).GetCollisionEnabledAttr().Get() is not False


def _target(prim: Any, stage: Any, layers: Set[Any]) -> Tuple[Any, str]:
    """The prim that the layer can write over, or `None` and the reason.

    Opinions below an instance have no effect. If the instance refers to a prim of the stage's own layers,
    an opinion there has one, in all instances.
    """
    if not prim.IsInstanceProxy():
        return prim, ""
    stack = prim.GetPrimInPrototype().GetPrimStack()
    for spec in stack:
        if spec.layer in layers:
            found = stage.GetPrimAtPath(spec.path.StripAllVariantSelections())
            if found and not found.IsInstanceProxy():
                return found, ""
    asset = stack[0].layer.identifier if stack else "another file"
    return None, (
        f"it is in an instance of {asset}, where no other layer can change it: bake that file, and refer to the layer "
        "over it, or set instanceable to false"
    )


def _geometry(mesh: Any) -> Tuple[npt.NDArray[np.float32], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Points, numbers of corners and corners of the faces, counter-clockwise seen from outside. Raises a
    `BakeError` with the reason if there is no such mesh."""
    geom = pxr("UsdGeom")
    if mesh.GetPointsAttr().ValueMightBeTimeVarying():
        raise BakeError("its points are animated, and hulls do not follow them")
    if (
        mesh.GetPrim().HasRelationship("skel:skeleton")
        and mesh.GetPrim().GetRelationship("skel:skeleton").GetForwardedTargets()
    ):
        raise BakeError("it is bound to a skeleton, and hulls do not follow it")
    points = np.asarray(mesh.GetPointsAttr().Get() or [], dtype=np.float32).reshape(-1, 3)
    counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get() or [], dtype=np.int64)
    corners = np.asarray(mesh.GetFaceVertexIndicesAttr().Get() or [], dtype=np.int64)
    if len(points) == 0 or len(corners) == 0:
        raise BakeError("it has no points or no faces")
    if (counts < 0).any() or counts.sum() != len(corners):
        raise BakeError(
            f"faceVertexCounts names {int(counts.sum())} corners, but faceVertexIndices has {len(corners)}: repair the "
            "mesh"
        )
    if corners.min() < 0 or corners.max() >= len(points):
        wrong = corners.min() if corners.min() < 0 else corners.max()
        raise BakeError(
            f"faceVertexIndices has the index {int(wrong)}, but there are {len(points)} points: repair the mesh"
        )
    owner = np.repeat(np.arange(len(counts)), counts)
    holes = np.asarray(mesh.GetHoleIndicesAttr().Get() or [], dtype=np.int64)
    kept = ~np.isin(np.arange(len(counts)), holes)
    corners, counts = corners[kept[owner]], counts[kept]
    if mesh.GetOrientationAttr().Get() == geom.Tokens.leftHanded:
        ends = np.cumsum(counts)
        # Each face backwards.
        owner = np.repeat(np.arange(len(counts)), counts)
        at = np.arange(len(corners))
        corners = corners[(ends - counts)[owner] + ends[owner] - 1 - at]
    return points, counts, corners


class Walker:
    """Walks over a stage once to see which bodies have colliders, and once to choose meshes."""

    def __init__(self, stage: Any, from_visual: str, replaces_triangles: bool) -> None:
        self.stage, self.from_visual, self.replaces_triangles = stage, from_visual, replaces_triangles
        self.layers = set(stage.GetLayerStack())
        self.frames = pxr("UsdGeom").XformCache()
        # Prims of bodies by the path of the body.
        self.colliders: Dict[str, List[Any]] = {}
        self.drawn: Dict[str, List[Any]] = {}

    def walk(self) -> Walk:
        """The meshes of the stage."""
        geom = pxr("UsdGeom")
        self._survey()
        found: Dict[str, Source] = {}
        skipped: Dict[str, SkippedPrim] = {}
        replaced: Dict[str, str] = {}
        for prim in _prims(self.stage):
            is_replaced = self._is_replaced(prim)
            if not is_replaced and not prim.IsA(geom.Mesh):
                continue
            target, reason = _target(prim, self.stage, self.layers)
            key = str((target or prim).GetPath())
            if is_replaced and target:
                replaced[key] = str(_body(prim).GetPath())  # type: ignore[union-attr]
            if not prim.IsA(geom.Mesh):
                continue
            try:
                if not target:
                    raise BakeError(reason)
                if key not in found:
                    found[key] = self._source(prim, target)
                source = found[key]
            except BakeError as error:
                skipped.setdefault(key, SkippedPrim(key, str(error)))
                continue
            frame = np.array(self.frames.GetLocalToWorldTransform(prim), dtype=np.float64)[:3, :3]
            source.frames.append(frame)
            source.instances += 1 if prim.IsInstanceProxy() else 0
        return Walk(list(found.values()), list(skipped.values()), replaced)

    def _survey(self) -> None:
        geom = pxr("UsdGeom")
        for prim in _prims(self.stage):
            if "hullmap" in prim.GetCustomData():
                raise BakeError(
                    f"{prim.GetPath()}: the stage has hulls of hullmap already: bake the asset, not the layer over it"
                )
            body = _body(prim)
            if body is None:
                continue
            if _is_collider(prim) and _is_on(prim):
                self.colliders.setdefault(str(body.GetPath()), []).append(prim)
            elif prim.IsA(geom.Mesh) and self._is_drawn(prim) is None:
                self.drawn.setdefault(str(body.GetPath()), []).append(prim)

    def _is_replaced(self, prim: Any) -> bool:
        """Whether a collider gives way to hulls of what is drawn."""
        body = _body(prim)
        return (
            self.from_visual == "always"
            and body is not None
            and _is_collider(prim)
            and _is_on(prim)
            and str(body.GetPath()) in self.drawn
        )

    def _is_drawn(self, prim: Any) -> Optional[str]:
        """`None` for a mesh that is drawn, or why it is not."""
        geom = pxr("UsdGeom")
        image = geom.Imageable(prim)
        purpose = image.ComputePurpose()
        if purpose not in (geom.Tokens.default_, geom.Tokens.render):
            return f"its purpose is {purpose}, and it is no collider"
        if image.ComputeVisibility() == geom.Tokens.invisible:
            return "it is invisible, and no collider"
        return None

    def _source(self, prim: Any, target: Any) -> Source:
        """The mesh. Raises a `BakeError` with the reason if it gets no hulls."""
        body = _body(prim)
        own = str(body.GetPath()) if body else ""
        approximation = None
        if _is_collider(prim):
            if not _is_on(prim):
                raise BakeError("its collision is off")
            if self._is_replaced(prim):
                raise BakeError("meshes that are drawn replace it (from_visual)")
            approximation = self._approximation(prim, body)
        else:
            reason = self._is_drawn(prim)
            if reason is not None:
                raise BakeError(reason)
            if self.from_visual == "never":
                raise BakeError("it is no collider (from_visual)")
            if self.from_visual == "missing" and own in self.colliders:
                raise BakeError(f"its body {own} has colliders (from_visual)")
        points, counts, corners = _geometry(pxr("UsdGeom").Mesh(prim))
        return Source(target, points, counts, corners, approximation, body)

    def _approximation(self, prim: Any, body: Optional[Any]) -> str:
        """The approximation of a collider that hulls replace."""
        physics = pxr("UsdPhysics")
        found = str(physics.MeshCollisionAPI(prim).GetApproximationAttr().Get() or "none")
        if found in _PRIMITIVES:
            raise BakeError(f"its collider is a {found}, which stays")
        if found in _TRIANGLES and body is None and not self.replaces_triangles:
            raise BakeError("its collider is its triangles, and does not move: it stays, unless decompose is given")
        if found not in _HULLS + _TRIANGLES:
            raise BakeError(f"its collider has the approximation {found}, which stays")
        return found
