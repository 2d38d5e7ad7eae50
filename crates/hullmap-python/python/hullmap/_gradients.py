"""Values of arrays of poses or configurations, with their gradients, for `hullmap.torch` and `hullmap.jax`.

The rotation of a pose is its quaternion q divided by its length, so a value does not change along q. A twist turns
the shape by a rotation vector w: q changes by (w, 0) q / 2, the product of quaternions. So if the derivative by w
is d, the gradient by q is 2 (d, 0) q / |q|²: the only vector that is perpendicular to q, and has the product d · w
with that change.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any, Literal, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from ._answers import Differentiability, Status
from ._arrays import Floats
from ._hullmap import ArrayError, Error
from ._motion import Motion, cast_motion, derivatives, ray_derivatives
from ._poses import relative
from ._results import Codes
from ._robot import Robot
from ._shapes import Shape

Gradients = Tuple[Floats, ...]


def required(module: str) -> Any:
    """An optional module. The extra has the name of its package."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Error(f"this requires {module} ({error}): install it with `pip install hullmap[{module.split('.')[0]}]`") from None


def check_width(shape: Tuple[int, ...], width: Optional[int]) -> None:
    """Checks that arrays of this shape hold rows of ``width`` numbers; of any number if it is None."""
    if width is not None and tuple(shape[-1:]) != (width,):
        rows = {
            3: "vectors of the shape (..., 3)",
            7: "poses of the shape (..., 7), rows of x y z qx qy qz qw",
            13: "motions of the shape (..., 13), rows of a pose, a displacement and a rotation vector",
        }
        raise ArrayError(f"expected {rows[width]}, found {tuple(shape)}")


def _unit(rows: Floats) -> Tuple[Floats, Floats]:
    """Poses with quaternions of length 1, and the lengths that they had. A quaternion of 0 becomes NaN."""
    length = np.linalg.norm(rows[..., 3:], axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.concatenate((rows[..., :3], rows[..., 3:] / length), axis=-1), length


def _rotated(poses: Floats, vectors: Floats) -> Floats:
    """Vectors from the frames of poses to the frame that the poses map to."""
    axis, scalar = poses[..., 3:6], poses[..., 6:]
    across = 2.0 * np.cross(axis, vectors)
    rotated: Floats = vectors + scalar * across + np.cross(axis, across)
    return rotated


def _by_numbers(twists: Floats, poses: Floats, length: Floats) -> Floats:
    """The gradient by the seven numbers of poses, from the derivative by twists."""
    turn, axis, scalar = twists[..., 3:], poses[..., 3:6], poses[..., 6:]
    vector = turn * scalar + np.cross(turn, axis)
    quaternion = np.concatenate((vector, -(turn * axis).sum(-1, keepdims=True)), axis=-1)
    return np.concatenate((twists[..., :3], quaternion * (2.0 / length)), axis=-1)


@dataclass(frozen=True)
class PairValue:
    """Distance, depth or clearance of two convex shapes, by ``b_in_a``, or by both poses in a common frame."""

    of: Literal["distance", "depth", "clearance"]
    a: Shape
    b: Shape
    tolerance: float
    strict: bool

    def __call__(self, poses: Sequence[Floats], gradient: bool) -> Tuple[Floats, Gradients]:
        """The values, and their gradients by the numbers of all poses, which are of one shape."""
        units = [_unit(rows) for rows in poses]
        b_in_a = units[0][0] if len(units) == 1 else relative(units[0][0], units[1][0])
        if not gradient:
            return self._value(b_in_a), ()
        value, kinds, by_a, by_b = self._slopes(b_in_a)
        twists = [by_b]
        if len(units) == 2:
            # From A's frame to the common one.
            a_in_world = units[0][0]
            parts = [(by[..., :3], by[..., 3:]) for by in (by_a, by_b)]
            twists = [np.concatenate([_rotated(a_in_world, part) for part in pair], axis=-1) for pair in parts]
        if self.strict:
            twists = [_strict(kinds, own) for own in twists]
        return value, tuple(_by_numbers(own, *unit) for own, unit in zip(twists, units))

    def _value(self, b_in_a: Floats) -> Floats:
        if self.of == "depth":
            return self.a.contact(self.b, b_in_a, tolerance=self.tolerance).depth
        gap = self.a.distance(self.b, b_in_a, tolerance=self.tolerance)
        if self.of == "distance":
            return gap.distance
        value = np.array(gap.distance)
        meets = np.asarray(gap.status == Status.OVERLAPPING)
        if meets.any():
            value[meets] = -self.a.contact(self.b, b_in_a[meets], tolerance=self.tolerance).depth
        return value

    def _slopes(self, b_in_a: Floats) -> Tuple[Floats, Codes, Floats, Floats]:
        """The values, codes of `Differentiability`, and the derivatives by twists of A and of B, in A's frame."""
        first: Literal["distance", "depth"] = "depth" if self.of == "depth" else "distance"
        found = derivatives(self.a, self.b, b_in_a, of=first, tolerance=self.tolerance)
        value, kinds = np.array(found.value), np.array(found.differentiability)
        by_a, by_b = np.array(found.by_a), np.array(found.by_b)
        # 0 on the far side of its kink.
        flat = np.asarray(found.status == (Status.SEPARATED if first == "depth" else Status.OVERLAPPING))
        if self.of == "clearance" and flat.any():
            deep = derivatives(self.a, self.b, b_in_a[flat], of="depth", tolerance=self.tolerance)
            value[flat], kinds[flat] = -deep.value, deep.differentiability
            by_a[flat], by_b[flat] = -deep.by_a, -deep.by_b
        elif self.of != "clearance":
            kinds[flat] = Differentiability.UNIQUE
            by_a[flat], by_b[flat] = 0.0, 0.0
        return value, kinds, by_a, by_b


@dataclass(frozen=True)
class RayValue:
    """The t at which rays enter a convex shape, by their origins and directions."""

    shape: Shape
    tolerance: float
    strict: bool

    def __call__(self, rays: Sequence[Floats], gradient: bool) -> Tuple[Floats, Gradients]:
        origins, directions = rays
        if not gradient:
            return self.shape.ray(origins, directions, tolerance=self.tolerance).t, ()
        found = ray_derivatives(self.shape, origins, directions, tolerance=self.tolerance)
        by_origin, by_turn = found.by_b[..., :3], found.by_b[..., 3:]
        # A change across the direction turns the ray, and one along it divides t.
        t = np.where(np.isfinite(found.value), found.value, 0.0)[..., None]
        across = np.cross(by_turn, directions) - t * directions
        slopes = (by_origin, across / (directions**2).sum(-1, keepdims=True))
        if self.strict:
            slopes = (_strict(found.differentiability, slopes[0]), _strict(found.differentiability, slopes[1]))
        return found.value, slopes


def _by_rotation_vector(twists: Floats, turns: Floats) -> Floats:
    """The gradient by rotation vectors, from the derivative by small rotations after them: the transpose of the left
    Jacobian of SO(3), times the derivative."""
    angle = np.linalg.norm(turns, axis=-1, keepdims=True)
    half = np.sinc(angle / (2.0 * np.pi))
    # (θ - sin θ)/θ³ loses its digits at small angles.
    square = np.where(angle > 1e-2, angle**2, 1.0)
    cubic = np.where(angle > 1e-2, (1.0 - np.sinc(angle / np.pi)) / square, (1.0 - angle**2 / 20.0) / 6.0)
    along = (turns * twists).sum(-1, keepdims=True)
    found: Floats = np.sinc(angle / np.pi) * twists - 0.5 * half**2 * np.cross(turns, twists) + cubic * along * turns
    return found


@dataclass(frozen=True)
class ImpactValue:
    """The time at which two shapes that move and turn first meet, by their motions: rows of 13 numbers."""

    a: Shape
    b: Shape
    target_distance: float
    tolerance: float
    strict: bool

    def __call__(self, motions: Sequence[Floats], gradient: bool) -> Tuple[Floats, Gradients]:
        """The values, and their gradients by the numbers of both motions."""
        units = [_unit(rows[..., :7]) for rows in motions]
        screws = [
            Motion.screw(pose, linear=rows[..., 7:10], angular=rows[..., 10:], center=pose[..., :3])
            for rows, (pose, _) in zip(motions, units)
        ]
        found = cast_motion(self.a, self.b, *screws, target_distance=self.target_distance, tolerance=self.tolerance)
        if not gradient:
            return found.t, ()
        t = np.where(np.isfinite(found.t), found.t_lower, 0.0)[..., None]
        slopes = []
        for by, rows, (pose, length) in zip((found.by_a, found.by_b), motions, units):
            # At the impact, the shape is displaced by what a change of the motion displaces it there.
            place, turn, turned = by[..., :3], by[..., 3:], t * rows[..., 10:]
            half = 0.5 * np.linalg.norm(turned, axis=-1, keepdims=True)
            back = np.concatenate((0.0 * place, -0.5 * np.sinc(half / np.pi) * turned, np.cos(half)), axis=-1)
            start = _by_numbers(np.concatenate((place, _rotated(back, turn)), axis=-1), pose, length)
            slopes.append(np.concatenate((start, t * place, t * _by_rotation_vector(turn, turned)), axis=-1))
        if self.strict:
            slopes = [_strict(found.differentiability, own) for own in slopes]
        return found.t, tuple(slopes)


@dataclass(frozen=True)
class RobotValue:
    """Clearance of a robot, by its configuration. It is the upper bound of the nearest pair."""

    robot: Robot
    tolerance: float
    strict: bool

    def __call__(self, configurations: Sequence[Floats], gradient: bool) -> Tuple[Floats, Gradients]:
        (q,) = configurations
        found = self.robot.clearance(q, gradient=gradient, tolerance=self.tolerance)
        if found.gradient is None or found.differentiability is None:
            return found.upper, ()
        slopes = _strict(found.differentiability, found.gradient) if self.strict else found.gradient
        return found.upper, (slopes,)


def _strict(kinds: Codes, slopes: Floats) -> Floats:
    """NaN where there is no derivative."""
    # Without a pair, the value is infinite, and does not change.
    has_one = (kinds == Differentiability.UNIQUE) | (kinds == Differentiability.MISSING)
    return np.where(np.expand_dims(has_one, -1), slopes, np.nan)


def perturbations(
    radius: float, angle: float, samples: int, seed: int
) -> Tuple[Floats, npt.NDArray[np.float64]]:
    """Translations, (S, 3), and matrices that multiply quaternions from the left, (S, 4, 4).

    Translations are uniform in a ball, and rotation vectors, too. They come in opposite pairs.
    """
    if samples < 2 or samples % 2:
        raise ArrayError(f"samples must be an even number of at least 2, found {samples}: they come in opposite pairs")
    rng = np.random.default_rng(seed)

    def ball(size: float) -> Floats:
        ways = rng.normal(size=(samples // 2, 3))
        ways *= size * rng.uniform(size=(samples // 2, 1)) ** (1 / 3) / np.linalg.norm(ways, axis=-1, keepdims=True)
        return np.concatenate((ways, -ways))

    shifts, turns = ball(radius), ball(angle)
    half = np.linalg.norm(turns, axis=-1, keepdims=True) / 2
    x, y, z = (turns / 2 * np.sinc(half / np.pi)).T
    w = np.cos(half[:, 0])
    rows = [[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]]
    return shifts, np.moveaxis(np.array(rows), -1, 0)
