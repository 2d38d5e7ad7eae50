"""Bakes a stage, and writes the layer."""

from __future__ import annotations

import hashlib
import os
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Set, Tuple, Union

import numpy as np

from .. import _hullmap
from .._bake import bake as bake_mesh
from .._hullmap import BakeError, BakeWarning, Error
from .._options import BakeOptions
from .._progress import Progress
from .._shapes import FilePath, Pack
from ._report import BakedPrim, Report, SkippedPrim
from ._settings import LIMITS, copied, named, settings
from ._stage import FROM_VISUAL, Source, Walker, pxr

if TYPE_CHECKING:
    from typing_extensions import Unpack

# The stage decides these.
_DECIDED = ("split", "unit_scale", "up_axis", "recentre", "vertices", "lean")
# Options that are lengths.
_LENGTHS = ("max_error", "wall")
# Axes of a frame are at right angles if their dot product, relative to their lengths, is at most this.
_SHEAR = 1e-6
# Vertices of a convex hull in PhysX.
_PHYSX_VERTICES = 255
# A mesh that any options suit.
_CORNER = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_SIDES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def bake(
    stage: Union[FilePath, Any],
    out: Optional[FilePath] = None,
    *,
    from_visual: str = "missing",
    density: float = 1000.0,
    force: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
    **options: Unpack[BakeOptions],
) -> Report:
    """Bakes the meshes of a stage, and writes a layer of collision hulls over it.

    ``stage`` is a path or a ``Usd.Stage``. ``out`` is the layer to write, a ``.usda`` file; without it, the
    report has the text. The layer names the stage's root layer as its sublayer, relative to ``out``. The
    hulls are beside their mesh, in its frame, and each is a ``Mesh`` with the purpose ``guide`` and the
    approximation ``convexHull``.

    Meshes with ``PhysicsCollisionAPI`` get hulls whatever their purpose, and their own collision is switched
    off. Other meshes get hulls if they are drawn (purpose ``default`` or ``render``, visible), and

    - ``from_visual="missing"``: their rigid body has no collider yet
    - ``from_visual="always"``: always; colliders of their body, primitives too, are switched off
    - ``from_visual="never"``: never

    The other options are the same as for `hullmap.bake`. Where they are not given, the collider of the mesh
    decides: ``convexDecomposition`` means ``decompose=True``, with its ``maxConvexHulls``, and limits on hull
    vertices of PhysX, Newton and MuJoCo mean ``max_vertices``. Colliders that are primitives stay, and so do
    triangles that do not move, unless ``decompose`` is given. Lengths are in the unit of the mesh, in front
    of all scales, or as ``"2mm"`` in the world.

    The mass of the hulls is the mass of the mesh: the mass of its collider, if one is stated, or else its
    volume times the density of the collider, the body, the physics material, or ``density``, in kilograms
    per cubic metre. A body whose own mass is stated keeps it.

    Each distinct mesh is baked once. The same stage and options give the same text on every machine.

    Raises `BakeError` for wrong options, and for a stage that has hulls of hullmap already; an `OSError` for
    files that cannot be read, or that exist, unless ``force`` is given. A mesh that cannot be baked is
    skipped, and the report has the reason.
    """
    if from_visual not in FROM_VISUAL:
        raise BakeError(f"from_visual: expected one of {', '.join(FROM_VISUAL)}, found {from_visual!r}")
    if not (np.isfinite(density) and density > 0):
        raise BakeError(f"density: expected a finite number above 0, found {density!r}")
    for option in _DECIDED:
        if dict(options).get(option) is not None:
            raise BakeError(f"option {option}: the stage decides it; leave it out")
    opened = _open(stage)
    root = opened.GetRootLayer()
    target = None if out is None else Path(os.fsdecode(out))
    if target is not None:
        _check(target, root, force)
    walk = Walker(opened, from_visual, bool(dict(options).get("decompose"))).walk()
    maker = _Maker(opened, dict(options), density, threads, progress)
    for source in walk.sources:
        maker.add(source)
    off = sorted(maker.off.union(path for path, body in walk.replaced.items() if body in maker.bodies))
    text = maker.text(_asset(root, target), off)
    if target is not None:
        _write(target, text)
    skipped = walk.skipped + maker.skipped
    return Report(
        text, None if target is None else str(target), tuple(maker.prims), tuple(skipped), len(maker.packs), tuple(off)
    )


def _open(stage: Union[FilePath, Any]) -> Any:
    usd, tf = pxr("Usd"), pxr("Tf")
    if isinstance(stage, usd.Stage):
        return stage
    path = os.fsdecode(stage)
    if not os.path.exists(path):
        raise FileNotFoundError(f"{path}: there is no such file; check the path")
    try:
        return usd.Stage.Open(path)
    except tf.ErrorException as error:
        raise BakeError(f"{path}: OpenUSD cannot read it: {' '.join(str(error).split())}; check the file") from None


def _check(target: Path, root: Any, force: bool) -> None:
    if target.suffix.lower() not in (".usda", ".usd"):
        raise BakeError(f"{target}: the layer is text; name a file with the extension .usda")
    if root.realPath and target.exists() and os.path.samefile(target, root.realPath):
        raise BakeError(f"{target}: is the stage itself, which is not changed; name another file")
    if target.exists() and not force:
        raise FileExistsError(f"{target}: already exists and was not changed; name another file, or pass force=True")


def _asset(root: Any, target: Optional[Path]) -> Optional[str]:
    """The stage's root layer, as the layer over it names it."""
    if root.anonymous:
        return None
    if target is None or not root.realPath:
        return str(root.realPath or root.identifier)
    try:
        relative = os.path.relpath(root.realPath, target.resolve().parent)
    except ValueError:  # On another drive.
        return Path(root.realPath).as_posix()
    relative = Path(relative).as_posix()
    # Without a dot, OpenUSD also searches elsewhere.
    return relative if relative.startswith("../") else f"./{relative}"


def _write(target: Path, text: str) -> None:
    """The file is complete or absent at every moment."""
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, beside = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(beside, 0o666 & ~mask)
        os.replace(beside, target)
    except BaseException:
        os.unlink(beside)
        raise


class _Maker:
    """Bakes meshes, and collects the groups of the layer."""

    def __init__(
        self, stage: Any, options: Dict[str, Any], density: float, threads: Optional[int], progress: Progress
    ) -> None:
        geom, physics = pxr("UsdGeom"), pxr("UsdPhysics")
        self.stage, self.options, self.threads, self.progress = stage, options, threads, progress
        self.meters = float(geom.GetStageMetersPerUnit(stage))
        self.kilograms = float(physics.GetStageKilogramsPerUnit(stage))
        self.up = str(geom.GetStageUpAxis(stage))
        # In the stage's units.
        self.density = density * self.meters**3 / self.kilograms
        self.named = named(stage)
        # By the hash of mesh and options.
        self.packs: Dict[str, Union[Pack, str]] = {}
        self.warnings: Dict[str, List[str]] = {}
        self.taken: Dict[str, Set[str]] = {}
        self.groups: List[Dict[str, Any]] = []
        self.prims: List[BakedPrim] = []
        self.skipped: List[SkippedPrim] = []
        self.off: Set[str] = set()
        self.bodies: Set[str] = set()
        # An option that every mesh would reject is an error before the first.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            bake_mesh(_CORNER, _SIDES, **self._lengths(options, 1.0))

    def add(self, source: Source) -> None:
        """Bakes a mesh, unless it was baked before."""
        scale, notes = self._scale(source)
        options = self._options(source, float(scale.max()) if scale is not None else _stretch(source))
        index, pack, found = self._pack(source, options)
        solids = [hull.index for hull in pack if hull.rank == 3] if isinstance(pack, Pack) else []
        if not isinstance(pack, Pack) or not solids:
            reason = pack if isinstance(pack, str) else "its hull is flat: decompose=True makes parts with a thickness"
            self.skipped.append(SkippedPrim(source.path, reason))
            return
        for warning in found:
            warnings.warn(f"{source.path}: {warning}", BakeWarning, stacklevel=3)
        notes += [*found, *pack.notes]
        parent, name, transform, resets, note = self._place(source)
        notes += note
        mass, density = self._mass(source) if scale is not None else (None, None)
        largest = max(len(pack[at]) for at in solids)
        if largest > _PHYSX_VERTICES:
            notes.append(f"a hull has {largest} vertices, and PhysX keeps {_PHYSX_VERTICES}: max_vertices limits them")
        group = {
            "parent": parent, "name": name, "mesh": source.path, "transform": transform, "resets_transforms": resets,
            "pack": pack._pack, "hulls": solids, "mass": mass, "density": density,
            "scale": [1.0, 1.0, 1.0] if scale is None else scale.tolist(),
        }  # fmt: skip
        self.groups.append(group)
        self.off.update([source.path] if source.approximation is not None else [])
        self.bodies.update([str(source.body.GetPath())] if source.body is not None else [])
        factor = self.meters * (float(scale.max()) if scale is not None else _stretch(source))
        hulls = [pack[at] for at in solids]
        bounds = [_largest([hull.protrusion for hull in hulls]), _largest([hull.uncovered for hull in hulls])]
        protrusion, uncovered = [None if bound is None else bound * factor for bound in bounds]
        if density is not None and scale is not None:
            mass = float(pack._mass_of(solids, density).mass * np.prod(scale))
        own = None if mass is None else mass * self.kilograms
        vertices = sum(len(hull) for hull in hulls)
        path = f"{parent.rstrip('/')}/{name}"
        self.prims.append(
            BakedPrim(
                source.path,
                path,
                index,
                len(hulls),
                vertices,
                protrusion,
                uncovered,
                own,
                source.instances,
                tuple(notes),
            )
        )

    def text(self, asset: Optional[str], off: List[str]) -> str:
        """The layer."""
        default = self.stage.GetDefaultPrim()
        stage = {
            "asset": asset, "default_prim": str(default.GetName()) if default else None,
            "meters_per_unit": self.meters, "kilograms_per_unit": self.kilograms, "up_axis": self.up,
        }  # fmt: skip
        text, of_hulls = _hullmap.usd_layer(stage, self.groups, off)
        note = "the mass comes from its hulls, because the mesh is not watertight"
        self.prims = [
            BakedPrim(**{**vars(prim), "notes": (*prim.notes, note)}) if prim.path in of_hulls else prim
            for prim in self.prims
        ]
        by_path = {prim.path: prim for prim in self.prims}
        replaced = set(off)
        own = [
            (prim.hulls, prim.parts, settings(self.stage.GetPrimAtPath(path), self.named.get(path, [])))
            for path, prim in by_path.items()
            if path in replaced
        ]
        return copied(text, own)

    def _pack(self, source: Source, options: Mapping[str, Any]) -> Tuple[int, Union[Pack, str], List[str]]:
        """Index of the bake of a mesh, its pack, and its warnings; in place of a pack the reason why there is
        none."""
        # Positive zeros, so that equal points have equal bytes.
        points = source.points + np.float32(0)
        digest = hashlib.sha256(repr(sorted(options.items())).encode())
        for array in (points, source.counts, source.corners):
            digest.update(len(array).to_bytes(8, "little") + np.ascontiguousarray(array).tobytes())
        key = digest.hexdigest()
        if key not in self.packs:
            corners, ends = source.corners, np.cumsum(source.counts)
            faces = [corners[end - count : end] for end, count in zip(ends, source.counts)]
            name = source.prim.GetName()
            try:
                with warnings.catch_warnings(record=True) as found:
                    warnings.simplefilter("always", BakeWarning)
                    pack = bake_mesh(points, faces, name=name, threads=self.threads, progress=self.progress, **options)
                self.packs[key], self.warnings[key] = pack, [str(warning.message) for warning in found]
            except Error as error:
                self.packs[key] = str(error)
        return list(self.packs).index(key), self.packs[key], self.warnings.get(key, [])

    def _options(self, source: Source, scale: float) -> Dict[str, Any]:
        """The options of a bake: the given ones, or else the options of the collider."""
        options = {key: value for key, value in self.options.items() if value is not None}
        options.setdefault("index", "none")
        if source.approximation == "convexDecomposition" and "decompose" not in options:
            options["decompose"] = True
            parts = _number(source.prim, "physxConvexDecompositionCollision:maxConvexHulls")
            if parts is not None:
                options.setdefault("max_parts", parts)
        decomposes = bool(options.get("decompose"))
        limit = "physxConvexDecompositionCollision:hullVertexLimit" if decomposes else LIMITS[2]
        limits = [_number(source.prim, name) for name in (*LIMITS[:2], limit)]
        authored = [number for number in limits if number is not None and number >= 4]
        if (
            authored
            and source.approximation
            and "max_vertices" not in options
            and (decomposes or "max_error" not in options)
        ):
            options["max_vertices"] = min(authored)
        return self._lengths(options, scale)

    def _lengths(self, options: Mapping[str, Any], scale: float) -> Dict[str, Any]:
        """The options, with millimetres in the unit of a mesh of this scale."""
        found = dict(options)
        for key in _LENGTHS:
            length = found.get(key)
            if isinstance(length, str) and length.strip().endswith("mm"):
                try:
                    found[key] = float(length.strip()[:-2]) / 1000 / self.meters / scale
                except ValueError:
                    raise BakeError(f"option {key}: expected a length such as 2mm, found {length!r}") from None
        return found

    def _scale(self, source: Source) -> Tuple[Optional[Any], List[str]]:
        """Scale of the mesh's axes in the world; `None` if they are not at right angles."""
        frame = source.frames[0]
        lengths = np.linalg.norm(frame, axis=1)
        notes = []
        if any(not np.allclose(np.linalg.norm(other, axis=1), lengths, rtol=1e-6) for other in source.frames):
            notes.append("its instances have different scales: mass and bounds are computed for the first")
        dots = np.abs(frame @ frame.T - np.diag(lengths**2))
        # NaN takes the failing branch.
        if not (dots <= _SHEAR * np.outer(lengths, lengths)).all() or not (lengths > 0).all():
            return None, [*notes, "its axes are sheared or have no length: the layer states no mass"]
        return lengths, notes

    def _mass(self, source: Source) -> Tuple[Optional[float], Optional[float]]:
        """Mass of the mesh in the stage's unit, or in its place the density."""
        physics, shade = pxr("UsdPhysics"), pxr("UsdShade")
        prim, body = source.prim, source.body
        is_body = body is not None and prim.HasAPI(physics.RigidBodyAPI)
        if prim.HasAPI(physics.MassAPI) and not is_body:
            stated = physics.MassAPI(prim).GetMassAttr().Get() or 0.0
            if stated > 0:
                return float(stated), None
        for owner in [prim, *([body] if body is not None else [])]:
            stated = physics.MassAPI(owner).GetDensityAttr().Get() if owner.HasAPI(physics.MassAPI) else 0.0
            if stated and stated > 0:
                return None, float(stated)
        material, _ = shade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
        if material and material.GetPrim().HasAPI(physics.MaterialAPI):
            stated = physics.MaterialAPI(material.GetPrim()).GetDensityAttr().Get() or 0.0
            if stated > 0:
                return None, float(stated)
        return None, self.density

    def _place(self, source: Source) -> Tuple[str, str, Optional[List[List[float]]], bool, List[str]]:
        """Where the group goes: its parent, name and transform, whether it resets those above, and notes.

        It is beside the mesh, since prims with geometry must not be nested. It is below the mesh only if it
        would not follow the mesh otherwise.
        """
        geom, physics = pxr("UsdGeom"), pxr("UsdPhysics")
        prim = source.prim
        form = geom.Xformable(prim)
        why = None
        if prim.HasAPI(physics.RigidBodyAPI):
            why = "is a rigid body"
        elif form.TransformMightBeTimeVarying():
            why = "is animated"
        elif prim.GetParent().IsPseudoRoot() and prim == self.stage.GetDefaultPrim():
            why = "is the default prim"
        if why is not None:
            note = (
                f"the mesh itself {why}, so its hulls are below it; validators report nested geometry: put it below an "
                "Xform"
            )
            return source.path, self._name(prim, "hulls"), None, False, [note]
        parent = prim.GetParent()
        matrix = np.array(form.GetLocalTransformation(), dtype=np.float64)
        transform = None if np.array_equal(matrix, np.eye(4)) else matrix.tolist()
        return (
            str(parent.GetPath()),
            self._name(parent, f"{prim.GetName()}_hulls"),
            transform,
            form.GetResetXformStack(),
            [],
        )

    def _name(self, parent: Any, name: str) -> str:
        """A name that no child of a prim has."""
        path = str(parent.GetPath())
        taken = self.taken.setdefault(path, set(parent.GetAllChildrenNames()))
        free, number = name, 2
        while free in taken:
            free, number = f"{name}_{number}", number + 1
        taken.add(free)
        return free


def _largest(bounds: List[Optional[float]]) -> Optional[float]:
    known = [bound for bound in bounds if bound is not None]
    return max(known) if known else None


def _stretch(source: Source) -> float:
    """The largest factor by which the mesh's frame stretches a length."""
    return float(np.linalg.norm(source.frames[0], ord=2)) or 1.0


def _number(prim: Any, name: str) -> Optional[int]:
    """An authored count above 0."""
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if attribute and attribute.HasAuthoredValue() else None
    return int(value) if isinstance(value, int) and value > 0 else None
