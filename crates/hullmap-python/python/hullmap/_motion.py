"""Shapes that move and turn: time of impact, free motions, and derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Optional, Tuple

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._answers import Clearance
from ._answers import TimeOfImpact as _TimeOfImpact
from ._arrays import Floats, joint, number, transforms, vectors
from ._hullmap import ArrayError
from ._results import Codes, _Answer
from ._shapes import MAX_ITERATIONS, RAY_TOLERANCE, TOLERANCE, Shape, native, settings_of

MOTION_TOLERANCE = 1e-6
"""Default tolerance of motions."""

MOTION_ITERATIONS = 200
"""Default limit of queries of a motion, for each turn of 360 degrees."""


class Motion:
    """Motions of a shape over the times 0 to 1, in a common frame: one, or an array of them.

    >>> import numpy as np, hullmap
    >>> door = hullmap.poses([0.5, 0, 0])
    >>> hullmap.Motion.screw(door, angular=[0, 0, np.pi / 2])         # about its hinge, at the origin
    <1 motion>
    >>> hullmap.Motion.between(door, hullmap.poses([[0.5, 1, 0], [0.5, 2, 0]]))
    <motions of the shape (2,)>
    """

    __slots__ = ("_lead", "_rows")

    def __init__(self, rows: Floats, lead: Tuple[int, ...]) -> None:
        self._rows, self._lead = rows, lead

    @classmethod
    def still(cls, pose: npt.ArrayLike) -> Motion:
        """Stays at ``pose``."""
        return cls(*_poses("pose", pose))

    @classmethod
    def between(cls, start: npt.ArrayLike, end: npt.ArrayLike) -> Motion:
        """From ``start`` to ``end``: the origin along a straight line, the rotation by slerp, the shorter way."""
        (a, lead_a), (b, lead_b) = _poses("start", start), _poses("end", end)
        return cls(*_beside([("start", a, lead_a), ("end", b, lead_b)]))

    @classmethod
    def screw(
        cls,
        start: npt.ArrayLike,
        *,
        linear: npt.ArrayLike = (0.0, 0.0, 0.0),
        angular: npt.ArrayLike = (0.0, 0.0, 0.0),
        center: npt.ArrayLike = (0.0, 0.0, 0.0),
    ) -> Motion:
        """From ``start``, by these displacements until time 1: the point that is at ``center`` moves by ``linear``,
        and the shape turns about it by the rotation vector ``angular``, in radians. More than a turn is fine."""
        own = [("start", *_poses("start", start))]
        own += [(name, *vectors(name, value)) for name, value in (("linear", linear), ("angular", angular), ("center", center))]
        return cls(*_beside(own))

    @property
    def shape(self) -> Tuple[int, ...]:
        """The shape of the array of motions."""
        return self._lead

    def __repr__(self) -> str:
        return f"<motions of the shape {self._lead}>" if self._lead else "<1 motion>"

    def __reduce__(self) -> Any:
        return (Motion, (self._rows, self._lead))


def _poses(name: str, value: npt.ArrayLike) -> Tuple[Floats, Tuple[int, ...]]:
    """Rows of seven numbers."""
    rows, lead = transforms(name, value)
    return (rows if rows.shape[-1] == 7 else _hullmap.pose_rows(name, rows)), lead


def _beside(columns: Any) -> Tuple[Floats, Tuple[int, ...]]:
    """Rows side by side, and their shape."""
    try:
        lead = np.broadcast_shapes(*(own for _, _, own in columns))
    except ValueError:
        found = ", ".join(f"{name} {own}" for name, _, own in columns)
        raise ArrayError(f"the shapes do not fit: {found}: pass as many of each, or one") from None
    whole = [np.broadcast_to(rows.reshape((*own, -1)), (*lead, rows.shape[-1])) for _, rows, own in columns]
    joined = np.concatenate(whole, axis=-1)
    return np.ascontiguousarray(joined.reshape(-1, joined.shape[-1])), lead


@dataclass(frozen=True, eq=False, repr=False)
class TimeOfImpact(_TimeOfImpact):
    """When shapes that move and turn first meet, and the derivatives of that time. Points and directions are in the
    common frame of the motions."""

    differentiability: Codes
    """Codes of `Differentiability`: whether ``by_a`` and ``by_b`` are derivatives."""
    by_a: Floats
    """Derivative of t by a twist that displaces the whole motion of A: three numbers for each metre, and three for
    each radian about the origin of A's frame at the impact; (..., 6)."""
    by_b: Floats
    """The same by a twist of B; (..., 6)."""


@dataclass(frozen=True, eq=False, repr=False)
class Derivatives(_Answer):
    """Derivatives of distances or depths by the poses of both shapes, in A's frame."""

    value: Floats
    """The distance or the depth."""
    differentiability: Codes
    """Codes of `Differentiability`: whether these are derivatives, or why not."""
    by_a: Floats
    """By a twist of A: three numbers for each metre, and three for each radian about the origin of its frame;
    (..., 6)."""
    by_b: Floats
    """By a twist of B, whose rotation is about the origin of B's frame; (..., 6)."""
    status: Codes
    """Codes of `Status`, for the value."""


@dataclass(frozen=True, eq=False, repr=False)
class WitnessDerivatives(_Answer):
    """Derivatives of normals and witness points by the poses of both shapes, in A's frame.

    Matrices have a row for each coordinate, and a column for each number of the twist: (..., 3, 6). They are 0
    where there is no derivative."""

    normal: Floats
    """Unit vector from A to B; (..., 3)."""
    point_a: Floats
    """The point of A; (..., 3)."""
    point_b: Floats
    """The point of B; (..., 3)."""
    differentiability: Codes
    """Codes of `Differentiability`: whether these are derivatives, or why not."""
    normal_by_a: Floats
    normal_by_b: Floats
    point_a_by_a: Floats
    """Derivative of the point of A by a twist of A."""
    point_a_by_b: Floats
    """Derivative of the point of A by a twist of B."""
    point_b_by_a: Floats
    point_b_by_b: Floats
    status: Codes
    """Codes of `Status`, for the distance or the depth."""


def _pair_of_motions(a: Motion, b: Motion) -> Tuple[Floats, Floats, Tuple[int, ...]]:
    for name, motion in (("motion_a", a), ("motion_b", b)):
        if not isinstance(motion, Motion):
            raise ArrayError(f"{name}: expected a hullmap.Motion, found {type(motion).__name__}: see Motion.between")
    rows_a, rows_b = a._rows, b._rows
    if len(rows_a) != len(rows_b) and 1 not in (len(rows_a), len(rows_b)):
        raise ArrayError(f"motion_a has the shape {a.shape} and motion_b {b.shape}: pass as many, or one")
    return rows_a, rows_b, joint(a.shape, len(rows_a), b.shape, len(rows_b))


def cast_motion(
    a: Shape,
    b: Shape,
    motion_a: Motion,
    motion_b: Motion,
    *,
    target_distance: float = 0.0,
    tolerance: float = MOTION_TOLERANCE,
    max_iterations: int = MOTION_ITERATIONS,
    threads: Optional[int] = None,
) -> TimeOfImpact:
    """When ``a`` and ``b``, which move and turn, first come within ``target_distance`` of each other.

    ``max_iterations`` is the limit of queries for each turn of 360 degrees, up to 100 turns. Turns of both shapes are
    added and rounded up.

    >>> import numpy as np, hullmap
    >>> rod, wall = hullmap.Box([1, 0.01, 0.01]), hullmap.Box([5, 0.1, 5])
    >>> turning = hullmap.Motion.screw(hullmap.poses([0, 0, 0]), angular=[0, 0, np.pi / 2])
    >>> found = hullmap.cast_motion(rod, wall, turning, hullmap.Motion.still(hullmap.poses([0, 0.7, 0])))
    >>> bool(found.hit), round(float(found.t), 4)
    (True, 0.4033)
    """
    rows_a, rows_b, lead = _pair_of_motions(motion_a, motion_b)
    settings = (number("target_distance", target_distance), *settings_of(tolerance, max_iterations))
    return TimeOfImpact._of(_hullmap.cast_motion(native(a), native(b), rows_a, rows_b, settings, threads), lead)


def clear(
    a: Shape,
    b: Shape,
    motion_a: Motion,
    motion_b: Motion,
    *,
    margin: float = 0.0,
    share: float = 0.5,
    tolerance: float = MOTION_TOLERANCE,
    max_iterations: int = MOTION_ITERATIONS,
    threads: Optional[int] = None,
) -> Clearance:
    """Whether ``a`` and ``b``, which move and turn, stay farther apart than ``margin``, and which clearance is
    proven: at least ``share`` of the least distance that was found, if the status is ``WITHIN``. 0 is the fastest.
    ``max_iterations`` is the same as for `cast_motion`.

    >>> import hullmap
    >>> ball = hullmap.Sphere(0.5)
    >>> past = hullmap.Motion.between(hullmap.poses([-3, 1.5, 0]), hullmap.poses([3, 1.5, 0]))
    >>> found = hullmap.clear(ball, ball, hullmap.Motion.still(hullmap.poses([0, 0, 0])), past)
    >>> hullmap.Verdict(int(found.verdict)).name, bool(0.25 <= found.clearance <= 0.5)
    ('FREE', True)
    """
    rows_a, rows_b, lead = _pair_of_motions(motion_a, motion_b)
    own, most = settings_of(tolerance, max_iterations)
    settings = (number("margin", margin), own, most, number("share", share))
    return Clearance._of(_hullmap.clear(native(a), native(b), rows_a, rows_b, settings, threads), lead)


def derivatives(
    a: Shape,
    b: Shape,
    b_in_a: npt.ArrayLike,
    *,
    of: Literal["distance", "depth"] = "distance",
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    threads: Optional[int] = None,
) -> Derivatives:
    """Derivatives of the distance or the depth of convex shapes by both poses.

    A twist (v, w) moves a shape by v and turns it by the rotation vector w about the origin of its own frame, both
    in A's frame. The value changes by ``by_b[..., :3] @ v + by_b[..., 3:] @ w``, to first order.

    >>> import hullmap
    >>> cube, ball = hullmap.Box([1, 1, 1]), hullmap.Sphere(0.5)
    >>> found = hullmap.derivatives(cube, ball, hullmap.poses([4, 0.5, 0]))
    >>> found.by_b.round(6) + 0.0
    array([1., 0., 0., 0., 0., 0.])
    >>> hullmap.Differentiability.words(found.differentiability)
    ['unique']
    """
    if of not in ("distance", "depth"):
        raise ArrayError(f"of: expected 'distance' or 'depth', found {of!r}")
    rows, lead = transforms("b_in_a", b_in_a)
    settings = settings_of(tolerance, max_iterations)
    return Derivatives._of(
        _hullmap.derivatives(native(a), native(b), rows, of == "depth", settings, threads), lead
    )


def ray_derivatives(
    shape: Shape,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    *,
    max_t: float = float("inf"),
    tolerance: float = RAY_TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    threads: Optional[int] = None,
) -> Derivatives:
    """Derivatives of the t at which rays enter a convex shape: ``by_a`` with respect to the pose of the shape, and
    ``by_b`` to the pose of the ray, a frame with its origin at the ray's, which turns with the direction.

    Twists are as for `derivatives`, in the frame of the shape. A ray that meets an edge has no derivative.

    >>> import hullmap
    >>> found = hullmap.ray_derivatives(hullmap.Box([1, 1, 1]), [0.2, 0.3, 5], [0, 0, -2])
    >>> found.by_b[:3].round(6) + 0.0                        # a higher start by 1 adds 1/2 to t
    array([0. , 0. , 0.5])
    """
    (starts, lead_o), (ways, lead_d) = vectors("origins", origins), vectors("directions", directions)
    lead = joint(lead_o, len(starts), lead_d, len(ways))
    settings = (number("max_t", max_t), *settings_of(tolerance, max_iterations))
    return Derivatives._of(_hullmap.ray_derivatives(native(shape), starts, ways, settings, threads), lead)


def witness_derivatives(
    a: Shape,
    b: Shape,
    b_in_a: npt.ArrayLike,
    *,
    of: Literal["distance", "depth"] = "distance",
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    threads: Optional[int] = None,
) -> WitnessDerivatives:
    """Derivatives of the normals and the points of distances or contacts of convex shapes, by both poses.

    Twists are as for `derivatives`. There are derivatives where the distance or the depth has one, and the same
    vertices, edges or faces are nearest for all poses nearby. Curved places of cylinders and cones have none.

    >>> import hullmap
    >>> cube, ball = hullmap.Box([1, 1, 1]), hullmap.Sphere(0.5)
    >>> found = hullmap.witness_derivatives(cube, ball, hullmap.poses([4, 0.5, 0]))
    >>> found.point_a_by_b[:, :3].round(6) + 0.0            # on a face, the point of the cube follows y and z
    array([[0., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    if of not in ("distance", "depth"):
        raise ArrayError(f"of: expected 'distance' or 'depth', found {of!r}")
    rows, lead = transforms("b_in_a", b_in_a)
    settings = settings_of(tolerance, max_iterations)
    found = _hullmap.witness_derivatives(native(a), native(b), rows, of == "depth", settings, threads)
    names = ("normal", "point_a", "point_b")
    return WitnessDerivatives._of(found, lead, {f"{name}_by_{by}": (3, 6) for name in names for by in "ab"})
