"""The interface of CoACD 1.0.14: replace ``import coacd`` by ``from hullmap.compat import coacd``.

>>> from hullmap.compat import coacd
>>> # An L of two boxes.
>>> outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
>>> vertices = [(x, y, z) for z in (0, 1) for x, y in outline]
>>> lids = [(0, 3, 1), (1, 3, 2), (0, 5, 3), (3, 5, 4), (6, 7, 9), (7, 8, 9), (6, 9, 11), (9, 10, 11)]
>>> sides = [t for i in range(6) for j in [(i + 1) % 6] for t in [(i, j, j + 6), (i, j + 6, i + 6)]]
>>> parts = coacd.run_coacd(coacd.Mesh(vertices, lids + sides))
>>> [(part.shape, part.dtype, faces.shape, faces.dtype) for part, faces in parts]
[((8, 3), dtype('float64'), (12, 3), dtype('int32')), ((8, 3), dtype('float64'), (12, 3), dtype('int32'))]

Reference: Wei, Liu, Ling, Su, "Approximate convex decomposition for 3D meshes with collision-aware
concavity and tree search", SIGGRAPH 2022; https://github.com/SarahWeiii/CoACD.
"""

from __future__ import annotations

import inspect
import logging
import math
import warnings
from typing import Dict, List, Mapping, Optional, Set

import numpy as np
import numpy.typing as npt

from .._arrays import floats
from .._bake import bake
from .._hullmap import ArrayError, BakeError, BakeWarning
from .._shapes import Pack

_LOG = logging.getLogger(__name__)

_LEVELS: Dict[str, int] = {
    "off": logging.CRITICAL + 10,
    "critical": logging.CRITICAL,
    "error": logging.ERROR,
    "err": logging.ERROR,
    "warn": logging.WARNING,
    "warning": logging.WARNING,
    "info": logging.INFO,
    "debug": logging.DEBUG,
    "trace": logging.DEBUG,
}

# Arguments without effect, by the reason.
_WITHOUT_EFFECT = {
    "a mesh is not remeshed": ["preprocess_mode", "preprocess_resolution"],
    "nothing is sampled": ["resolution", "seed"],
    "there is no tree search": ["mcts_nodes", "mcts_iterations", "mcts_max_depth"],
    "directions of cuts come from the mesh": ["pca"],
    "parts are always merged where the threshold allows it": ["merge"],
    "parts are not extruded, so extrude_margin has no effect either": ["extrude"],
}

# Arguments of which this process has warned.
_WARNED: Set[str] = set()


class Mesh:
    """A triangle mesh: ``vertices`` of shape (V, 3), kept as doubles, and ``indices`` of shape (F, 3), kept
    as 32-bit integers.

    Raises `ArrayError` for arrays of another shape.
    """

    def __init__(
        self,
        vertices: npt.ArrayLike = np.zeros((0, 3), dtype=np.double),
        indices: npt.ArrayLike = np.zeros((0, 3), dtype=np.int32),
    ) -> None:
        self.vertices: npt.NDArray[np.float64] = np.ascontiguousarray(vertices, dtype=np.double)
        self.indices: npt.NDArray[np.int32] = np.ascontiguousarray(indices, dtype=np.int32)
        for name, array in (("vertices", self.vertices), ("indices", self.indices)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise ArrayError(f"{name}: expected rows of three numbers, found the shape {array.shape}")


def run_coacd(
    mesh: Mesh,
    threshold: float = 0.05,
    max_convex_hull: int = -1,
    preprocess_mode: str = "auto",
    preprocess_resolution: int = 50,
    resolution: int = 2000,
    mcts_nodes: int = 20,
    mcts_iterations: int = 150,
    mcts_max_depth: int = 3,
    pca: bool = False,
    merge: bool = True,
    decimate: bool = False,
    max_ch_vertex: int = 256,
    extrude: bool = False,
    extrude_margin: float = 0.01,
    apx_mode: str = "ch",
    seed: int = 0,
    real_metric: bool = False,
) -> List[List[npt.NDArray[np.generic]]]:
    """Decomposes a mesh into convex parts, in the frame and unit of the mesh.

    Returns a list of ``[vertices, faces]``: doubles of shape (V, 3), and 32-bit integers of shape (F, 3),
    counter-clockwise seen from outside. A convex mesh gives its hull.

    These arguments are used:

    - ``threshold``: CoACD scales a mesh so that the longest side of its box is 2, and bounds the concavity
      of parts in that frame, a distance between the surfaces of a part and of its hull. Here, no part
      protrudes from the mesh's solid by more than ``threshold`` times half of that side. This is
      `bake`'s ``max_error``: a proven bound, and not an estimate from samples. So the default of 0.05 is
      2.5 % of the longest side.
    - ``real_metric=True``: ``threshold`` is a length in the unit of the mesh.
    - ``max_convex_hull``: the maximum number of parts; -1 for no maximum. As in CoACD, there are as many parts as
      ``threshold`` needs. If these are more than the maximum, ``threshold`` is exceeded, by as little as the
      search finds. It also applies if ``merge`` is off.
    - ``decimate`` and ``max_ch_vertex``: with ``decimate``, parts have at most ``max_ch_vertex`` vertices,
      at least 4. They still contain the surface. Without it, the limit is 64, the default of `bake`, where
      CoACD has none.
    - ``apx_mode="box"``: each part is replaced by a box around it, with the axes of one of its triangles for
      which the volume is smallest. Boxes contain the surface, but may protrude more than ``threshold``.

    These have no effect. A `BakeWarning` names those that are not at their default, each once in a process:

    - ``preprocess_mode``, ``preprocess_resolution``: a mesh is not remeshed, as with "off", which
      gives no warning. It need not be a manifold. Open surfaces are walls, so bodies can enter
      them, if half of their area has faces on both sides, a hole has more than an eighth of it, or all holes
      together more than all of it. Other holes are closed.
    - ``resolution``, ``seed``: nothing is sampled. The same arguments give the same parts.
    - ``mcts_nodes``, ``mcts_iterations``, ``mcts_max_depth``: there is no tree search.
    - ``pca``: directions of cuts come from the mesh.
    - ``merge``: parts are always merged where the threshold allows it.
    - ``extrude``, ``extrude_margin``: parts are not extruded. They cover the mesh without gaps.

    Warnings of `bake` use its names: ``max_error`` for ``threshold``, ``max_parts`` for ``max_convex_hull``.

    Raises `ArrayError` for wrong arrays, and `BakeError` for wrong options and meshes.
    """
    _warn_without_effect(locals())
    if not (math.isfinite(threshold) and threshold > 0):
        raise BakeError(f"threshold: expected a finite number above 0, found {threshold!r}")
    if decimate and max_ch_vertex < 4:
        raise BakeError(f"max_ch_vertex: expected at least 4, found {max_ch_vertex!r}")
    if apx_mode not in ("ch", "box"):
        raise BakeError(f"apx_mode: expected ch or box, found {apx_mode!r}")
    points = floats("vertices", mesh.vertices)
    side = float(np.ptp(points, axis=0).max()) if points.ndim == 2 and len(points) else 0.0
    bound = threshold if real_metric else threshold * side / 2

    def parts_of(most: Optional[int]) -> Pack:
        return bake(
            points,
            mesh.indices,
            name="mesh",
            index="none",
            # Positions relative to the centre lose fewer digits.
            recentre=True,
            decompose=True,
            # A mesh of one point has no side; its hull is itself.
            max_error=bound if bound > 0 else None,
            max_parts=most,
            max_vertices=int(max_ch_vertex) if decimate else None,
        )

    pack = parts_of(None)
    if 0 < max_convex_hull < len(pack):
        pack = parts_of(int(max_convex_hull))
    if decimate and len(pack) == 1 and len(pack[0]) > max_ch_vertex:
        # A convex mesh is not decomposed, and its hull is exact.
        pack = bake(points, mesh.indices, name="mesh", index="none", recentre=True, max_vertices=int(max_ch_vertex))
    for note in pack.notes:
        _LOG.info("%s", note)
    parts = [(hull.vertices.astype(np.float64) + hull.origin, hull.triangles.astype(np.int32)) for hull in pack]
    return [_box_around(*part) if apx_mode == "box" else list(part) for part in parts]


# The outer sides of a box whose corner i has the upper bound along axis k where bit k of i is set.
_BOX_TRIANGLES = [
    [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
]  # fmt: skip


def _box_around(vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int32]) -> List[npt.NDArray[np.generic]]:
    """The smallest box around a hull of those with a side in the plane of a triangle, along one of its edges."""
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    x = np.concatenate([b - a, c - b, a - c])
    z = np.tile(np.cross(b - a, c - a), (3, 1))
    lengths = [np.linalg.norm(axis, axis=1, keepdims=True) for axis in (x, z)]
    is_long = np.minimum(*lengths)[:, 0] > 0
    x, z = (axis[is_long] / length[is_long] for axis, length in zip((x, z), lengths))
    frames = np.stack([x, np.cross(z, x), z], axis=1) if len(x) else np.eye(3)[None]
    heights = frames @ vertices.T
    low, high = heights.min(axis=2), heights.max(axis=2)
    best = np.prod(high - low, axis=1).argmin()
    corners = [[(low, high)[i >> axis & 1][best, axis] for axis in range(3)] for i in range(8)]
    return [np.array(corners) @ frames[best], np.array(_BOX_TRIANGLES, dtype=np.int32)]


def set_log_level(level: str) -> None:
    """Sets what is logged: "off", "critical", "error", "warn", "info", "debug" or "trace".

    Records go to Python's logger ``hullmap.compat.coacd``. If no handler is set up, they go to standard
    error. At "info", each run logs the number of parts and their bounds. Raises a `ValueError` for
    another level.
    """
    if level not in _LEVELS:
        raise ValueError(f"level: expected one of {', '.join(_LEVELS)}, found {level!r}")
    if not _LOG.hasHandlers():
        _LOG.addHandler(logging.StreamHandler())
    _LOG.setLevel(_LEVELS[level])


def _warn_without_effect(given: Mapping[str, object]) -> None:
    """Warns about arguments of `run_coacd` that have no effect, once in a process about each."""
    parameters = inspect.signature(run_coacd).parameters
    found = []
    for reason, names in _WITHOUT_EFFECT.items():
        changed = [name for name in names if given[name] != parameters[name].default and str(given[name]) != "off"]
        if new := [name for name in changed if name not in _WARNED]:
            _WARNED.update(new)
            found.append(f"{', '.join(new)} ({reason})")
    if found:
        warnings.warn(f"arguments without effect: {'; '.join(found)}", BakeWarning, stacklevel=3)
