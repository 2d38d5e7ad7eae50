"""The functions that `hullmap.torch` and `hullmap.jax` share: only how a value becomes one that the framework
differentiates is their own."""

from __future__ import annotations

from typing import Any, Callable, Generic, Optional, Sequence, TypeVar

from ._gradients import ImpactValue, PairValue, RayValue, RobotValue
from ._hullmap import ArrayError
from ._motion import MOTION_TOLERANCE
from ._robot import Robot
from ._shapes import Shape

Array = TypeVar("Array")


class Functions(Generic[Array]):
    """The functions of a framework. ``apply`` takes a value, its arrays, and the width of their rows."""

    def __init__(self, apply: Callable[[Any, Sequence[Any], Optional[int]], Array]) -> None:
        self._apply = apply

    def _pair(self, value: PairValue, b_in_a: Any, a_in_world: Any, b_in_world: Any) -> Array:
        given = [own is not None for own in (b_in_a, a_in_world, b_in_world)]
        if given not in ([True, False, False], [False, True, True]):
            raise ArrayError("pass either b_in_a, or both a_in_world and b_in_world")
        return self._apply(value, [b_in_a] if given[0] else [a_in_world, b_in_world], 7)

    def distance(
        self,
        a: Shape,
        b: Shape,
        b_in_a: Optional[Array] = None,
        *,
        a_in_world: Optional[Array] = None,
        b_in_world: Optional[Array] = None,
        tolerance: float = 0.0,
        strict: bool = False,
    ) -> Array:
        """Distances of convex shapes; 0 with a gradient of 0 where they overlap."""
        return self._pair(PairValue("distance", a, b, tolerance, strict), b_in_a, a_in_world, b_in_world)

    def depth(
        self,
        a: Shape,
        b: Shape,
        b_in_a: Optional[Array] = None,
        *,
        a_in_world: Optional[Array] = None,
        b_in_world: Optional[Array] = None,
        tolerance: float = 0.0,
        strict: bool = False,
    ) -> Array:
        """Penetration depths of convex shapes; 0 with a gradient of 0 where they are separated."""
        return self._pair(PairValue("depth", a, b, tolerance, strict), b_in_a, a_in_world, b_in_world)

    def clearance(
        self,
        a: Shape,
        b: Shape,
        b_in_a: Optional[Array] = None,
        *,
        a_in_world: Optional[Array] = None,
        b_in_world: Optional[Array] = None,
        tolerance: float = 0.0,
        strict: bool = False,
    ) -> Array:
        """Signed distances of convex shapes: the distance, or the negative depth where they overlap. For the signed
        distance of points, B is ``hullmap.Sphere(0)``."""
        return self._pair(PairValue("clearance", a, b, tolerance, strict), b_in_a, a_in_world, b_in_world)

    def ray(
        self, shape: Shape, origins: Array, directions: Array, *, tolerance: float = 1e-6, strict: bool = False
    ) -> Array:
        """Where rays enter a convex shape, at ``origins + t * directions``; infinite with a gradient of 0 where they
        miss it. Origins and directions have the shape (..., 3)."""
        return self._apply(RayValue(shape, tolerance, strict), [origins, directions], 3)

    def time_of_impact(
        self,
        a: Shape,
        b: Shape,
        motion_a: Array,
        motion_b: Array,
        *,
        target_distance: float = 0.0,
        tolerance: float = MOTION_TOLERANCE,
        strict: bool = False,
    ) -> Array:
        """Times from 0 to 1 at which convex shapes that move and turn first come within ``target_distance`` of each
        other; infinite with a gradient of 0 where they do not.

        Motions have the shape (..., 13): the pose at the start, the displacement of the origin of the shape's frame
        until time 1, and the rotation vector by which the shape turns about that origin until then. The gradient is by
        all of these numbers. With a tolerance of ε, it is off by as much as the shapes turn in the time that ε
        takes."""
        return self._apply(ImpactValue(a, b, target_distance, tolerance, strict), [motion_a, motion_b], 13)

    def robot_clearance(self, robot: Robot, q: Array, *, tolerance: float = 0.0, strict: bool = False) -> Array:
        """Clearances of a robot in the configurations ``q``, (..., J): the signed distance of the nearest pair."""
        return self._apply(RobotValue(robot, tolerance, strict), [q], None)
