"""The base of answers, and those that Python has in a form of its own."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple, Type, TypeVar

import numpy as np
import numpy.typing as npt

from ._arrays import Counts, Floats

Answer = TypeVar("Answer", bound="_Answer")
Columns = Mapping[str, npt.NDArray[Any]]
Codes = npt.NDArray[np.uint8]
Flags = npt.NDArray[np.bool_]


class _Words(IntEnum):
    """Base of the codes of words."""

    @classmethod
    def words(cls, codes: npt.ArrayLike) -> List[str]:
        """The words of codes, as the command and Rust write them.

        >>> import hullmap
        >>> ball = hullmap.Sphere(1.0)
        >>> gap = ball.distance(ball, hullmap.poses([[3, 0, 0], [1, 0, 0]]))
        >>> gap.status == hullmap.Status.OVERLAPPING
        array([False,  True])
        >>> hullmap.Status.words(gap.status)
        ['exact', 'overlapping']
        """
        return [cls(int(code)).name.lower() for code in np.ravel(codes)]


class _Answer:
    """Base of all answers: columns of one row for each pose.

    Indices select rows of all columns at once, as of a NumPy array of the shape of the poses: masks,
    arrays of indices, slices. The rows are copied.

    >>> import hullmap
    >>> ball = hullmap.Sphere(1.0)
    >>> contact = ball.contact(ball, hullmap.poses([[1.5, 0, 0], [3, 0, 0], [1, 0, 0]]))
    >>> len(contact), contact[contact.hit].depth, float(contact[-1].depth)
    (3, array([0.5, 1. ]), 1.0)
    """

    @property
    def shape(self) -> Tuple[int, ...]:
        """Shape of the poses. Columns of vectors have more axes."""
        return min((np.shape(column) for column in self._columns().values()), key=len)

    def _columns(self) -> Dict[str, Any]:
        found = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return {name: column for name, column in found.items() if column is not None}

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("the answer for a single pose has no length: pass an array of poses")
        return self.shape[0]

    def __bool__(self) -> bool:
        raise TypeError("an answer is neither true nor false: test one of its columns, such as hit")

    def __getitem__(self: Answer, index: Any) -> Answer:
        lead = self.shape
        rows = np.arange(np.prod(lead, dtype=np.intp)).reshape(lead)[index]
        columns = {name: np.asarray(column) for name, column in self._columns().items()}
        flat = {name: column.reshape((-1, *column.shape[len(lead) :])) for name, column in columns.items()}
        return type(self)(**{name: column[rows] for name, column in flat.items()})

    def __iter__(self: Answer) -> Iterator[Answer]:
        return (self[row] for row in range(len(self)))

    @classmethod
    def _of(
        cls: Type[Answer],
        columns: Columns,
        lead: Tuple[int, ...],
        tails: Optional[Dict[str, Tuple[int, ...]]] = None,
    ) -> Answer:
        """The answer of these columns, in the shape ``lead`` of the arguments."""
        arrays = dict(columns)
        for name, tail in (tails or {}).items():
            arrays[name] = arrays[name].reshape((-1, *tail))
        # One row in one call is what users measure first, so it takes no detours.
        if not lead:
            arrays = {name: array[0] for name, array in arrays.items()}
        elif len(lead) > 1:
            arrays = {name: array.reshape(lead + array.shape[1:]) for name, array in arrays.items()}
        return cls(**arrays)

    def __repr__(self) -> str:
        shapes = []
        for name, value in self._columns().items():
            shapes.append(f"{name}: {value.shape if isinstance(value, np.ndarray) and value.size > 4 else value}")
        return f"{type(self).__name__}({', '.join(shapes)})"


@dataclass(frozen=True, eq=False, repr=False)
class Manifold(_Answer):
    """Contact manifolds: up to four points each, on both surfaces, and separated by at most the
    prediction. Unused points are NaN. Points and directions are in A's frame."""

    count: Codes
    """Number of points."""
    normal: Floats
    """Unit vector from A to B; (..., 3)."""
    point_a: Floats
    """The points on A; (..., 4, 3)."""
    point_b: Floats
    """The points on B; (..., 4, 3)."""
    local_b: Floats
    """The points on B, in B's frame; (..., 4, 3)."""
    depth: Floats
    """Penetration depth at each point, negative where the surfaces are separated; (..., 4)."""
    hit: Flags
    """As in `Contact`."""
    status: Codes
    """Codes of `Status`: of the contact, or of the distance of separated shapes with points.
    ``SEPARATED`` without points, unless the shapes overlap."""

    @classmethod
    def _of_points(cls, columns: Columns, lead: Tuple[int, ...]) -> Manifold:
        return cls._of(columns, lead, {"point_a": (4, 3), "point_b": (4, 3), "local_b": (4, 3), "depth": (4,)})


@dataclass(frozen=True, eq=False, repr=False)
class PairManifolds(_Answer):
    """Contact manifolds of packs: one for each pair of hulls that touch, which means that they overlap
    or are separated by at most the prediction. P is ``max_pairs``. Unused pairs and points are NaN.
    Points and directions are in A's frame."""

    touching: Counts
    """Number of pairs that touch and have a manifold."""
    dropped: Counts
    """Number of pairs that touch but have no manifold, because there are more than ``max_pairs``."""
    parts: Counts
    """Indices of the hulls in A and in B, ascending; (..., P, 2). 4294967295 for unused pairs."""
    count: Codes
    """Number of points of each pair; (..., P)."""
    normal: Floats
    """Unit vector from A to B of each pair; (..., P, 3). At edges between hulls it is the normal of
    the union, so that bodies do not stumble over them."""
    point_a: Floats
    """The points on A; (..., P, 4, 3)."""
    point_b: Floats
    """The points on B; (..., P, 4, 3)."""
    local_b: Floats
    """The points on B, in B's frame; (..., P, 4, 3)."""
    depth: Floats
    """Penetration depth at each point, negative where the surfaces are separated; (..., P, 4)."""
    status: Codes
    """Codes of `Status` for each pair, as in `Manifold`; (..., P). ``EXACT`` where the normal is that
    of a face of the union, ``SEPARATED`` for unused pairs."""

    @classmethod
    def _of_points(cls, columns: Columns, lead: Tuple[int, ...], pairs: int) -> PairManifolds:
        # The counts are in the first row of each pose.
        counts = {name: columns[name][::pairs] for name in ("touching", "dropped")}
        points = {"point_a": (pairs, 4, 3), "point_b": (pairs, 4, 3), "local_b": (pairs, 4, 3), "depth": (pairs, 4)}
        of_pairs = {"parts": (pairs, 2), "normal": (pairs, 3), "count": (pairs,), "status": (pairs,)}
        return cls._of({**columns, **counts}, lead, {**points, **of_pairs})


@dataclass(frozen=True, eq=False, repr=False)
class Support(_Answer):
    """Support points: farthest points in given directions."""

    point: Floats
    """The points; (..., 3)."""
    vertex: Counts
    """For a hull: the index of the vertex."""
    parts: Counts
    """Index of the hull that reaches farthest, for a pack."""


@dataclass(frozen=True)
class Primitive:
    """A box, sphere, capsule or cylinder that may replace a convex part. It contains all of the mesh's surface
    that is in the part."""

    kind: str
    """``box``, ``sphere``, ``capsule`` or ``cylinder``."""
    center: Tuple[float, float, float]
    """Its centre, in the hull's frame."""
    rotation: Tuple[float, float, float, float]
    """Rotation from its own axes: a unit quaternion x, y, z, w. The axis of capsules and cylinders is z."""
    sizes: Tuple[float, float, float]
    """Box: half extents. Sphere: radius. Capsule and cylinder: radius, and half the length of the axis, without
    the ends of a capsule. The others are 0."""
    protrusion: float
    """Bound on how far a point of it lies outside the mesh's solid."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass properties of a solid of uniform density."""

    mass: float
    """Density times volume."""
    center_of_mass: Floats
    """In the hull's frame."""
    inertia: Floats
    """Inertia tensor about the centre of mass, along the axes of the hull's frame; (3, 3)."""
    source: str = "hulls"
    """The solid: ``mesh``, or ``hulls`` where the mass of the mesh is not known."""
