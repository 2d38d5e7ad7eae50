"""Static shapes of many triangles: triangle meshes and height fields; and files of any kind."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._arrays import Counts, Floats, floats, indices
from ._hullmap import ArrayError
from ._shapes import FilePath, Pack, Shape, write_file

_Own = TypeVar("_Own", bound="_Sheet")


class _Sheet(Shape):
    """Common base of triangle meshes and height fields."""

    __slots__ = ("_facts", "_file")

    _KIND: Union[Type[_hullmap.TriangleMesh], Type[_hullmap.HeightField]]
    """The class of the native module."""

    EDGE_CLASSES = ("border", "flat", "convex", "concave", "non-manifold", "reversed")
    """Names of the codes in ``edge_classes``."""

    def __init__(self, file: Union[_hullmap.TriangleMesh, _hullmap.HeightField]) -> None:
        self._file, self._native, self._facts = file, file.shape(), file.facts()

    @classmethod
    def from_bytes(cls: Type[_Own], data: Union[bytes, bytearray, memoryview]) -> _Own:
        """The shape in the bytes of a file, which are copied and checked."""
        return cls(cls._KIND.from_bytes(bytes(data)))

    @property
    def triangles(self) -> Counts:
        """Corners of each triangle among the vertices, counter-clockwise seen from the front; (T, 3)."""
        return self._array("triangles")

    @property
    def neighbours(self) -> npt.NDArray[np.int64]:
        """The triangles beyond the edges, from corner i to the next; -1 if there is none, or more than
        one; (T, 3)."""
        return self._array("neighbours")

    @property
    def edge_classes(self) -> npt.NDArray[np.uint16]:
        """Codes of the classes of the edges, from corner i to the next; (T, 3)."""
        return self._array("edge_classes")

    def _array(self, name: str) -> npt.NDArray[Any]:
        array: npt.NDArray[Any] = self._file.array(name)
        return array

    def _count_edges(self, classes: npt.NDArray[np.uint16]) -> Dict[str, int]:
        counts = np.bincount(classes.ravel(), minlength=len(self.EDGE_CLASSES))
        return {name: int(count) for name, count in zip(self.EDGE_CLASSES, counts)}

    @property
    def bounds(self) -> Floats:
        """Lowest and highest corner of the axis-aligned box; (2, 3)."""
        return floats("bounds", self._facts["bounds"])

    @property
    def path(self) -> Optional[Path]:
        """File that the shape was opened from."""
        path = self._file.path
        return None if path is None else Path(path)

    @property
    def source_path(self) -> str:
        """Path of the source, as recorded; empty if it was baked from arrays."""
        return str(self._facts["source_path"])

    @property
    def options(self) -> str:
        """Options of the bake, as recorded."""
        return str(self._facts["options"])

    @property
    def warnings(self) -> List[str]:
        """Warnings of the bake, as recorded."""
        return list(self._facts["warnings"])

    @property
    def nbytes(self) -> int:
        """Size of the file in bytes."""
        return int(self._facts["byte_len"])

    def to_bytes(self) -> bytes:
        """A copy of the bytes of the file."""
        return self._file.bytes()

    def save(self, path: FilePath) -> Path:
        """Writes the file as `Pack.save` does, and returns its path."""
        return write_file(path, self.to_bytes())

    def __len__(self) -> int:
        """Number of triangles, those in holes of a field included."""
        return int(self._facts["triangles"])

    def __reduce__(self) -> Any:
        return (type(self).from_bytes, (self.to_bytes(),))


class TriangleMesh(_Sheet):
    """A static mesh that keeps its triangles, such as a level. They collide on both sides.

    ``parts`` of an answer has the index of the triangle. The depth of a contact is the depth of the
    deepest triangle: the shorter way out, on either side. Arrays are copies; lengths are in the frame
    and unit of the mesh. The mesh has no support points and no signed distance.

    >>> import numpy as np, hullmap
    >>> corners = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
    >>> ground = hullmap.TriangleMesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
    >>> ball = hullmap.Sphere(0.5)
    >>> ground.distance(ball, hullmap.poses([[1, 2, 3], [1, 2, 0.25]])).distance
    array([2.5, 0. ])
    >>> ground.ray([[1, 2, 4]], [0, 0, -1]).t
    array([4.])
    """

    __slots__ = ()

    _KIND = _hullmap.TriangleMesh

    VERTEX_CLASSES = ("flat", "convex", "concave", "saddle", "border", "irregular")
    """Names of the codes in ``vertex_classes``."""

    @classmethod
    def open(cls, path: FilePath) -> TriangleMesh:
        """Opens a ``.hullmesh`` file, which ``bake build --keep-triangles`` writes. The file is copied
        into memory, and all of it is checked.

        Raises `InvalidPack` if the file is no triangle mesh or is damaged, and an `OSError` if it
        cannot be read.
        """
        return cls(_hullmap.TriangleMesh.open(os.fsdecode(path)))

    @classmethod
    def from_arrays(
        cls, vertices: npt.ArrayLike, triangles: npt.ArrayLike, materials: Optional[npt.ArrayLike] = None
    ) -> TriangleMesh:
        """Bakes triangles: ``vertices`` of shape (V, 3), rounded to 32 bits, and ``triangles`` of shape
        (T, 3), counter-clockwise seen from the front. ``materials`` has a number from 0 to 65535 for
        each triangle.

        Equal vertices are merged. Nothing is repaired: `counts` has what may be wrong.

        Raises `ArrayError` for arrays of other shapes or types, and `BakeError` for an index out of
        range or a vertex that is not finite.
        """
        points = floats("vertices", vertices)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArrayError(f"vertices: expected the shape (V, 3), found {points.shape}: pass rows of x, y, z")
        corners = indices("triangles", np.asarray(triangles), "vertices")
        rows = np.asarray(triangles)
        if rows.ndim != 2 or rows.shape[1] != 3:
            raise ArrayError(f"triangles: expected the shape (T, 3), found {rows.shape}: pass three indices a triangle")
        numbers = _materials(materials, "triangle")
        with np.errstate(over="ignore"):
            single = np.ascontiguousarray(points, dtype=np.float32)
        return cls(_hullmap.TriangleMesh.from_arrays(single, corners.reshape(rows.shape), numbers))

    @property
    def vertices(self) -> npt.NDArray[np.float32]:
        """Positions of the vertices; (V, 3)."""
        return self._array("vertices")

    @property
    def source_triangles(self) -> Counts:
        """For each triangle its index in the mesh that was baked; (T,)."""
        return self._array("source_triangles")

    @property
    def materials(self) -> npt.NDArray[np.uint16]:
        """Material of each triangle: 0 without one; (T,)."""
        return self._array("materials")

    @property
    def vertex_classes(self) -> npt.NDArray[np.uint8]:
        """Codes of the classes of the vertices; (V,)."""
        return self._array("vertex_classes")

    @property
    def counts(self) -> Dict[str, int]:
        """Numbers of triangles, different vertices, merged vertices, degenerate and duplicate triangles,
        and of edges of triangles with each class. An edge that two triangles share counts for both.

        >>> import hullmap
        >>> sheet = hullmap.TriangleMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> sheet.counts["triangles"], sheet.counts["border"], sheet.counts["degenerate"]
        (1, 3, 0)
        """
        counts = {key: int(self._facts[key]) for key in ("triangles", "vertices", "merged", "degenerate", "duplicate")}
        return {**counts, **self._count_edges(self.edge_classes)}

    def __repr__(self) -> str:
        return f"<TriangleMesh of {len(self)} triangles, {self.nbytes} bytes>"


class HeightField(_Sheet):
    """Static ground whose heights are known on a grid: a terrain, a scanned floor. It collides on both
    sides.

    Heights are along +z, columns along +x, rows along +y. Cell (row, column) has the index
    ``i = row * (columns - 1) + column`` and the triangles ``2 * i`` and ``2 * i + 1``; ``parts`` of an
    answer has the index of the triangle. A hole has no triangles, but their indices are reserved. The
    depth of a contact is as for a `TriangleMesh`. Arrays are copies; lengths are in the frame and unit
    of the field. The field has no support points and no signed distance.

    >>> import numpy as np, hullmap
    >>> ramp = hullmap.HeightField.from_array([[0, 1, 2], [0, 1, 2]], spacing=(2, 1), origin=(0, 0))
    >>> ramp.heights_at([3, 0.5])
    array(1.5)
    >>> ramp.ray([[1, 0.5, 4], [9, 0, 4]], [0, 0, -1]).hit
    array([ True, False])
    """

    __slots__ = ()

    _KIND = _hullmap.HeightField
    _file: _hullmap.HeightField

    @classmethod
    def open(cls, path: FilePath) -> HeightField:
        """Opens a ``.hullfield`` file, which ``bake build --terrain`` writes. The file is copied into memory, and all
        of it is checked.

        Raises `InvalidPack` if the file is no height field or is damaged, and an `OSError` if it cannot be
        read.
        """
        return cls(_hullmap.HeightField.open(os.fsdecode(path)))

    @classmethod
    def from_array(
        cls,
        heights: npt.ArrayLike,
        spacing: Union[float, Sequence[float]] = 1.0,
        holes: Optional[npt.ArrayLike] = None,
        *,
        origin: Optional[Sequence[float]] = None,
        materials: Optional[npt.ArrayLike] = None,
        diagonal: str = "rising",
    ) -> HeightField:
        """Bakes ``heights`` of shape (R, C), rounded to 32 bits: rows along +y, columns along +x. All cells
        at a vertex that is NaN are holes.

        ``spacing`` is the distance of neighbouring vertices, or two: along x and along y. ``holes`` of shape
        (R - 1, C - 1) marks cells that are holes, ``materials`` of the same shape has a number from 0 to 65535
        for each cell. ``origin`` is x and y of the first vertex; without it, the middle of the field is at
        x = y = 0. ``diagonal`` divides the cells: "rising" from the least x and y to the greatest, or
        "falling".

        Raises `ArrayError` for arrays of other shapes or types, and `BakeError` for a grid that cannot be
        baked, for instance without ground.
        """
        rows = floats("heights", heights)
        if rows.ndim != 2 or min(rows.shape) < 2:
            raise ArrayError(f"heights: expected the shape (R, C), at least (2, 2), found {rows.shape}: pass rows")
        steps = floats("spacing", spacing)
        if steps.shape not in ((), (2,)):
            raise ArrayError(f"spacing: expected one number, or two, found the shape {steps.shape}")
        across, along = (float(step) for step in np.broadcast_to(steps, 2))
        if origin is None:
            first = (-0.5 * across * (rows.shape[1] - 1), -0.5 * along * (rows.shape[0] - 1))
        else:
            first = _pair("origin", origin)
        cells = (rows.shape[0] - 1, rows.shape[1] - 1)
        _check_cells("materials", materials, cells)
        _check_cells("holes", holes, cells)
        marks = np.zeros(0, dtype=np.bool_) if holes is None else np.asarray(holes)
        if marks.dtype != np.bool_:
            raise ArrayError(f"holes: expected an array of bool, found one of type {marks.dtype}: compare it with 0")
        with np.errstate(over="ignore"):
            single = np.ascontiguousarray(rows, dtype=np.float32)
        grid = (first, (across, along), diagonal)
        numbers = _materials(materials, "cell", 2)
        return cls(_hullmap.HeightField.from_array(single, grid, np.ascontiguousarray(marks.ravel()), numbers))

    @property
    def heights(self) -> npt.NDArray[np.float32]:
        """Heights of the vertices; 0 for a vertex whose cells are all holes; (R, C)."""
        array: npt.NDArray[np.float32] = self.vertices[:, 2].astype(np.float32).reshape(self.shape)
        return array

    @property
    def vertices(self) -> Floats:
        """Positions of the vertices, row by row; (R * C, 3)."""
        return self._array("vertices")

    @property
    def holes(self) -> npt.NDArray[np.bool_]:
        """The cells that are holes; (R - 1, C - 1)."""
        return self._cells("holes")

    @property
    def materials(self) -> npt.NDArray[np.uint16]:
        """Material of each cell: 0 without one, and in holes; (R - 1, C - 1)."""
        return self._cells("materials")

    def _cells(self, name: str) -> npt.NDArray[Any]:
        rows, columns = self.shape
        return self._array(name).reshape(rows - 1, columns - 1)

    @property
    def shape(self) -> Tuple[int, int]:
        """Numbers of rows and columns of vertices."""
        return (int(self._facts["rows"]), int(self._facts["columns"]))

    @property
    def origin(self) -> Tuple[float, float]:
        """x and y of the first vertex."""
        return _pair("origin", self._facts["origin"])

    @property
    def spacing(self) -> Tuple[float, float]:
        """Distance of neighbouring vertices along x and along y."""
        return _pair("spacing", self._facts["spacing"])

    @property
    def diagonal(self) -> str:
        """The diagonal that divides each cell: "rising" or "falling"."""
        return str(self._facts["diagonal"])

    @property
    def counts(self) -> Dict[str, int]:
        """Numbers of triangles and holes, and of edges of triangles with each class. Triangles in holes are
        left out. An edge that two triangles share counts for both.

        >>> import hullmap
        >>> hullmap.HeightField.from_array([[0, 0], [0, 0]]).counts["border"]
        4
        """
        solid = np.repeat(~self.holes.ravel(), 2)
        counts = {"triangles": int(solid.sum()), "holes": int(self._facts["holes"])}
        return {**counts, **self._count_edges(self.edge_classes[solid])}

    def heights_at(self, points: npt.ArrayLike) -> Floats:
        """Height of the ground at points (x, y) of the plane; NaN in holes and beyond the field."""
        places = floats("points", points)
        if places.ndim == 0 or places.shape[-1] != 2:
            raise ArrayError(f"points: expected the shape (..., 2), found {places.shape}: pass rows of x, y")
        found = self._file.heights_at(np.ascontiguousarray(places.reshape(-1, 2)))
        return found.reshape(places.shape[:-1])

    def __repr__(self) -> str:
        rows, columns = self.shape
        return f"<HeightField of {rows} x {columns} vertices, {self.nbytes} bytes>"


def _pair(name: str, value: Sequence[float]) -> Tuple[float, float]:
    array = floats(name, value)
    if array.shape != (2,):
        raise ArrayError(f"{name}: expected two numbers x, y, found the shape {array.shape}")
    return (float(array[0]), float(array[1]))


def _check_cells(name: str, value: Optional[npt.ArrayLike], cells: Tuple[int, int]) -> None:
    if value is not None and np.shape(value) != cells:
        raise ArrayError(f"{name}: expected the shape {cells}, one for each cell, found {np.shape(value)}")


def _materials(materials: Optional[npt.ArrayLike], what: str, axes: int = 1) -> npt.NDArray[np.uint16]:
    """``materials`` as a row of numbers, one for each ``what``; an array of ``axes`` axes, or none."""
    if materials is None:
        return np.zeros(0, dtype=np.uint16)
    numbers = np.asarray(materials)
    if numbers.ndim != axes or not np.issubdtype(numbers.dtype, np.integer):
        raise ArrayError(f"materials: expected a whole number for each {what}, found {numbers.dtype}{numbers.shape}")
    if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) <= 65535:
        raise ArrayError("materials: a number must be from 0 to 65535: number the materials from 0")
    return np.ascontiguousarray(numbers.ravel(), dtype=np.uint16)


_MAGIC_LENGTH = 8

_SHEETS: Dict[bytes, Type[_Sheet]] = {b"hullmsh\n": TriangleMesh, b"hullfld\n": HeightField}
"""The first bytes of files that are no packs."""


def open(path: FilePath, *, mmap: bool = True) -> Any:
    """Opens a baked file: a `Pack`, a `TriangleMesh` or a `HeightField`, whichever it holds. All of it is
    checked: a file that opens cannot crash a query, whoever wrote it.

    A pack is mapped: processes share its memory, and nothing is copied. As with ``numpy.memmap``,
    no process may write to the file or truncate it while the pack is in use. To replace it, rename
    another file to its place, as `Pack.save` and the command do. If you cannot promise that, pass
    ``mmap=False``: the file is copied into memory. Other files are always copied.

    Raises `InvalidPack` if the file is not a baked file or is damaged, and an `OSError` if it cannot be
    read.
    """
    name = os.fsdecode(path)
    # The native module has the errors of files that cannot be read. A pipe can be read once only.
    start = b""
    if os.path.isfile(name) and os.access(name, os.R_OK):
        with io.open(name, "rb") as file:
            start = file.read(_MAGIC_LENGTH)
    if start in _SHEETS:
        sheet: Any = _SHEETS[start]
        return sheet.open(name)
    return Pack(_hullmap.Pack.open(name, mmap))
