"""Bakes: from arrays or a file to a pack."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._arrays import Counts, Floats, floats, indices, is_ragged
from ._hullmap import ArrayError, BakeError
from ._options import BakeOptions
from ._progress import Progress, shown
from ._shapes import FilePath, Pack

if TYPE_CHECKING:
    from typing_extensions import Unpack

Faces = Union[npt.ArrayLike, Sequence[Sequence[int]]]
Mesh = Tuple[str, Floats, Counts, Counts]


def _options(options: Mapping[str, Any]) -> List[Tuple[str, str]]:
    """Options as the text that the command accepts. ``None`` is the default of each."""
    pairs = []
    for key, value in options.items():
        if value is None:
            continue
        if isinstance(value, (bool, np.bool_)):
            text = "true" if value else "false"
        elif isinstance(value, (int, np.integer)):
            text = str(int(value))
        elif isinstance(value, (float, np.floating)):
            text = repr(float(value))
        elif isinstance(value, str):
            text = value
        else:
            raise BakeError(f"option {key}: expected a word, a number or a truth value, found {value!r}")
        pairs.append((key, text))
    return pairs


def _mesh(name: str, what: str, vertices: npt.ArrayLike, faces: Optional[Faces]) -> Mesh:
    points = floats(f"{what}vertices", vertices)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ArrayError(f"{what}vertices: expected the shape (V, 3), found {points.shape}: pass rows of x, y, z")
    if len(points) == 0:
        raise ArrayError(f"{what}vertices: the array is empty, but a hull requires at least one point")
    points = np.ascontiguousarray(points)
    if faces is None:
        none = np.zeros(0, dtype=np.uint32)
        return (name, points, none, none)
    if is_ragged(faces):
        rows = [np.asarray(row) for row in faces]  # type: ignore[union-attr]
        lengths = np.array([row.size for row in rows])
        corners = np.concatenate(rows) if rows else np.zeros(0, dtype=np.uint32)
    else:
        try:
            array = np.asarray(faces)
        except ValueError as error:
            raise ArrayError(f"{what}faces: this is no array ({error}): pass triangles or a list of polygons") from None
        if array.ndim != 2 and array.size > 0:
            raise ArrayError(f"{what}faces: expected the shape (F, 3), (F, 4) or a list of polygons, found {array.shape}")
        lengths = np.full(len(array) if array.size else 0, array.shape[-1])
        corners = array
    ends = np.cumsum(lengths) if len(lengths) else lengths
    return (name, points, indices(f"{what}faces", corners, "vertices"), indices(f"{what}faces", np.asarray(ends), "vertices"))


def bake(
    vertices: npt.ArrayLike,
    /,
    faces: Optional[Faces] = None,
    *,
    name: str = "mesh",
    threads: Optional[int] = None,
    progress: Progress = None,
    **options: Unpack[BakeOptions],
) -> Pack:
    """Bakes a mesh or a point cloud into a pack of one hull, or of its convex parts.

    ``vertices`` has the shape (V, 3); positions are rounded to 32-bit floats once. ``faces`` are
    triangles (F, 3), quadrilaterals (F, 4) or a list of polygons; only ``decompose`` needs them, and
    vertices that no face references are left out, unless the option ``vertices`` is "all".

    `BakeOptions` lists all options. The main ones:

    - ``index``: the direction index, "tree" by default; "medium" and "compact" are smaller
    - ``max_vertices`` or ``max_error``: an enclosing hull with fewer vertices instead of the exact one
    - ``decompose=True``: few convex parts that cover a concave mesh, with proven bounds on how far they
      protrude; ``max_error``, ``max_parts`` and ``max_vertices`` limit them
    - ``unit_scale``, ``up_axis``, ``recentre``: the frame of the hulls

    The same arguments give the same bytes on every machine. Findings to act on are Python warnings.

    ``progress=True`` shows a bar, if standard error is a terminal. A function is called with the share
    that is done, from 0 to 1, a few times per second; an exception that it raises ends the bake, as
    Ctrl-C does.

    Raises `ArrayError` for wrong arrays, and `BakeError` for wrong options and meshes.

    >>> import numpy as np, hullmap
    >>> points = np.random.default_rng(1).normal(size=(10_000, 3))
    >>> ball = points / np.linalg.norm(points, axis=1, keepdims=True)
    >>> len(hullmap.bake(ball)[0]) > 9_900
    True
    >>> len(hullmap.bake(ball, max_vertices=64)[0])
    64
    """
    meshes, pairs = [_mesh(name, "", vertices, faces)], _options(options)
    with shown(progress, name) as report:
        return Pack(_hullmap.bake_arrays(name, meshes, pairs, threads, report))


def bake_parts(
    parts: Sequence[Tuple[npt.ArrayLike, Optional[Faces]]],
    *,
    names: Optional[Sequence[str]] = None,
    name: str = "part",
    threads: Optional[int] = None,
    progress: Progress = None,
    **options: Unpack[BakeOptions],
) -> Pack:
    """Bakes several meshes into one pack, with a hull for each: for instance the parts of a convex
    decomposition by another tool.

    ``parts`` are pairs of vertices and faces, as in `bake`. As a shape, the pack is the union of the
    hulls.

    >>> import numpy as np, hullmap
    >>> cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    >>> pack = hullmap.bake_parts([(cube, None), (cube + [3, 0, 0], None)], names=["left", "right"])
    >>> pack.names, float(pack.distance(hullmap.Sphere(0.5), hullmap.poses([2, 0.5, 0.5])).distance)
    (['left', 'right'], 0.5)
    """
    chosen = list(names) if names is not None else [f"{name}_{index:02}" for index in range(len(parts))]
    if len(chosen) != len(parts):
        raise ArrayError(f"names: expected {len(parts)}, one for each part, found {len(chosen)}")
    if not parts:
        raise ArrayError("parts: the list is empty, but a pack requires at least one hull")
    meshes = [
        _mesh(own, f"parts[{index}]: ", vertices, faces)
        for index, (own, (vertices, faces)) in enumerate(zip(chosen, parts))
    ]
    pairs = _options({**options, "split": "object"})
    with shown(progress, name) as report:
        return Pack(_hullmap.bake_arrays(name, meshes, pairs, threads, report))


def bake_file(
    path: FilePath,
    *,
    threads: Optional[int] = None,
    progress: Progress = None,
    **options: Unpack[BakeOptions],
) -> Pack:
    """Bakes a mesh file: OBJ, glTF, GLB, STL, PLY, COLLADA or MSH.

    The options are the same as for `bake`, and also ``split``: with ``"object"``, each object gets
    a hull. A pack that is saved in the folder of the mesh has the same bytes as the pack of the
    command.

    Raises `BakeError` for a faulty mesh, and an `OSError` for a file that cannot be read.
    """
    with shown(progress, os.path.basename(os.fsdecode(path))) as report:
        return Pack(_hullmap.bake_file(os.fsdecode(path), _options(options), threads, report))
