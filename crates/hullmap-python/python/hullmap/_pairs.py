"""Many different pairs of shapes in one call."""

from __future__ import annotations

from typing import Any, List, Literal, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._answers import Contact, Distance, Impact, Intersection
from ._arrays import Counts, Floats, indices, number, transforms, vectors
from ._hullmap import ArrayError
from ._results import Manifold, PairManifolds
from ._shapes import MAX_ITERATIONS, RAY_TOLERANCE, TOLERANCE, Poses, Shape, length_of, native, pairs_of, settings_of


class Pairs:
    """Pairs of shapes that one call queries together: for instance the links of a robot that may
    meet.

    ``shapes`` are shapes of any kind and of any packs; of a `Pack` itself, they are its hulls. ``a``
    and ``b`` are indices of shapes, one of each for each pair.

    Poses are as for `Shape`, with one row for each pair in the last axis: ``b_in_a``, or
    ``a_in_world`` and ``b_in_world``. Or pass ``in_world``: one pose for each shape, (..., S, 7) or
    (..., S, 4, 4). Axes before that are moments. Answers have the shape (..., P).

    With ``coherent=True``, the poses are the next ones of a motion: each search starts from the
    answer that its pair got in the last such call, or at the moment before. Threads of Python then
    need pairs of their own.

    >>> import numpy as np, hullmap
    >>> shapes = [hullmap.Box([1, 1, 1]), hullmap.Sphere(0.5), hullmap.Capsule(1.0, 0.25)]
    >>> pairs = hullmap.Pairs(shapes, *np.triu_indices(3, 1))       # 0 and 1, 0 and 2, 1 and 2
    >>> at = hullmap.poses([[0, 0, 0], [1.25, 0, 0], [5, 0, 0]])    # of the three shapes
    >>> found = pairs.contact(in_world=at)
    >>> found.depth, [(int(pairs.a[p]), int(pairs.b[p])) for p in np.flatnonzero(found.hit)]
    (array([0.25, 0.  , 0.  ]), [(0, 1)])
    """

    __slots__ = ("_native", "a", "b", "shapes")

    shapes: List[Shape]
    """The shapes."""
    a: Counts
    """Index of the first shape of each pair."""
    b: Counts
    """Index of the second shape of each pair."""

    def __init__(self, shapes: Sequence[Shape], a: npt.ArrayLike, b: npt.ArrayLike) -> None:
        self.shapes = list(shapes)
        try:
            first, second = np.broadcast_arrays(a, b)
        except ValueError as error:
            raise ArrayError(f"a and b: {error}: pass one index of each for each pair") from None
        if first.ndim > 1:
            raise ArrayError(f"a and b: expected one axis, found the shape {first.shape}: ravel them")
        self.a, self.b = indices("a", first, "shapes"), indices("b", second, "shapes")
        self._native = _hullmap.Pairs([native(shape) for shape in self.shapes], self.a, self.b)

    def intersects(
        self,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Intersection:
        """As `Shape.intersects`, for each pair."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        return Intersection._of(_hullmap.intersects(self._native, poses, coherent, threads, device), lead)

    def distance(
        self,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Distance:
        """As `Shape.distance`, for each pair."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        settings = settings_of(tolerance, max_iterations)
        return Distance._of(_hullmap.distance(self._native, poses, settings, coherent, threads, device), lead)

    def contact(
        self,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Contact:
        """As `Shape.contact`, for each pair."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        settings = settings_of(tolerance, max_iterations)
        return Contact._of(_hullmap.contact(self._native, poses, settings, coherent, threads, device), lead)

    def cast(
        self,
        b_in_a: Poses = None,
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        max_t: float = float("inf"),
        tolerance: float = RAY_TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> Impact:
        """As `Shape.cast`, for each pair. ``velocity`` is the velocity of B in A's frame: one vector
        for all pairs, or one for each."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        velocities, own = vectors("velocity", velocity)
        if own:
            velocities = _expanded("velocity", velocities, own, lead)
        settings = (number("max_t", max_t), *settings_of(tolerance, max_iterations))
        return Impact._of(_hullmap.cast(self._native, poses, velocities, settings, coherent, threads), lead)

    def manifold(
        self,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        prediction: Optional[float] = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> Manifold:
        """As `ConvexShape.manifold`, for each pair. No shape may be a `Pack`."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        settings, length = settings_of(tolerance, max_iterations), length_of(prediction)
        return Manifold._of_points(_hullmap.manifold(self._native, poses, settings, length, coherent, threads), lead)

    def manifolds(
        self,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        in_world: Poses = None,
        max_pairs: int = 8,
        prediction: Optional[float] = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        threads: Optional[int] = None,
    ) -> PairManifolds:
        """As `Shape.manifolds`, for each pair: up to ``max_pairs`` pairs of hulls that touch."""
        poses, lead = self._poses(b_in_a, a_in_world, b_in_world, in_world)
        settings, length, most = settings_of(tolerance, max_iterations), length_of(prediction), pairs_of(max_pairs)
        found = _hullmap.manifolds(self._native, poses, settings, length, most, False, threads)
        return PairManifolds._of_points(found, lead, most)

    def _poses(
        self, b_in_a: Poses, a_in_world: Poses, b_in_world: Poses, in_world: Poses
    ) -> Tuple[_hullmap.Poses, Tuple[int, ...]]:
        """The arrays of poses, and the shape of the answer."""
        given = [pose is not None for pose in (b_in_a, a_in_world, b_in_world, in_world)]
        if given == [False, False, False, True]:
            rows, lead = transforms("in_world", in_world)  # type: ignore[arg-type]
            if lead[-1:] != (len(self.shapes),):
                raise ArrayError(
                    f"in_world: expected one pose for each of the {len(self.shapes)} shapes in the last axis, "
                    f"found poses of the shape {lead}"
                )
            return rows, lead[:-1] + (len(self),)
        if given == [True, False, False, False]:
            rows, lead = transforms("b_in_a", b_in_a)  # type: ignore[arg-type]
            full = self._full(lead)
            return (_expanded("b_in_a", rows, lead, full), None), full
        if given != [False, True, True, False]:
            raise ArrayError("pass b_in_a, or both a_in_world and b_in_world, or in_world")
        a, lead_a = transforms("a_in_world", a_in_world)  # type: ignore[arg-type]
        b, lead_b = transforms("b_in_world", b_in_world)  # type: ignore[arg-type]
        full = self._full(lead_a, lead_b)
        return (_expanded("a_in_world", a, lead_a, full), _expanded("b_in_world", b, lead_b, full)), full

    def _full(self, *leads: Tuple[int, ...]) -> Tuple[int, ...]:
        """The shape of the answer for poses of these shapes."""
        try:
            full = np.broadcast_shapes((len(self),), *leads)
        except ValueError:
            full = ()
        if full[-1:] != (len(self),):
            found = " and ".join(map(str, leads))
            raise ArrayError(
                f"expected one pose for each of the {len(self)} pairs in the last axis, or one for all, "
                f"found poses of the shape {found}"
            )
        return full

    def __len__(self) -> int:
        return len(self.a)

    def __repr__(self) -> str:
        return f"<{len(self)} pairs of {len(self.shapes)} shapes>"

    def __reduce__(self) -> Any:
        return (Pairs, (self.shapes, self.a, self.b))


def _expanded(name: str, rows: Floats, lead: Tuple[int, ...], full: Tuple[int, ...]) -> Floats:
    """``rows`` of the shape ``lead``, repeated to the shape ``full``."""
    if lead == full:
        return rows
    width = rows.shape[-1:]
    try:
        repeated = np.broadcast_to(rows.reshape(lead + width), full + width)
    except ValueError:
        raise ArrayError(f"{name}: expected rows of the shape {full}, or one for all, found {lead}") from None
    return np.ascontiguousarray(repeated.reshape(-1, *width))
