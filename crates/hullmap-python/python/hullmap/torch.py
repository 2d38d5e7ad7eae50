"""Distances, depths and clearances that PyTorch differentiates.

>>> import hullmap, hullmap.torch, torch                                # doctest: +SKIP
>>> cube, ball = hullmap.Box([1, 1, 1]), hullmap.Sphere(0.5)              # doctest: +SKIP
>>> pose = torch.tensor([3.0, 0.5, 0, 0, 0, 0, 1], requires_grad=True)   # doctest: +SKIP
>>> gap = hullmap.torch.distance(cube, ball, pose)                      # doctest: +SKIP
>>> gap.backward(); pose.grad[:3]                                       # doctest: +SKIP
tensor([1., 0., 0.])

Poses are tensors of the shape (..., 7), on any device. Queries run on the processor, for all poses in one call. The
rotation of a pose is its quaternion divided by its length, so the numbers of a pose are free variables of an
optimiser. The gradient by a quaternion is perpendicular to it.

Where there is no derivative (`hullmap.Differentiability`), the gradient is that of one of several normals or pairs
of points: it is a direction, as the gradient of ``abs`` at 0. With ``strict=True`` it is NaN there. Only first
derivatives are computed. It requires PyTorch: ``pip install hullmap[torch]``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np

from ._gradients import ImpactValue, PairValue, RayValue, RobotValue, check_width, perturbations, required
from ._hullmap import ArrayError
from ._motion import MOTION_TOLERANCE
from ._robot import Robot
from ._shapes import Shape

if TYPE_CHECKING:
    import torch

__all__ = ["clearance", "depth", "distance", "perturbed", "ray", "robot_clearance", "time_of_impact"]


@lru_cache(maxsize=None)
def _function() -> Any:
    """The function of PyTorch's autograd."""
    module = required("torch")

    def forward(context: Any, evaluate: Any, *inputs: Any) -> Any:
        arrays = [own.detach().to("cpu", module.float64).numpy() for own in inputs]
        value, gradients = evaluate(arrays, any(context.needs_input_grad))
        like = inputs[0]
        context.save_for_backward(*(like.new_tensor(np.asarray(own)) for own in gradients))
        return like.new_tensor(np.asarray(value))

    @module.autograd.function.once_differentiable  # type: ignore[untyped-decorator, unused-ignore]
    def backward(context: Any, by_value: Any) -> Any:
        return (None, *(by_value.unsqueeze(-1) * own for own in context.saved_tensors))

    functions = {"forward": staticmethod(forward), "backward": staticmethod(backward)}
    return type("HullmapFunction", (module.autograd.Function,), functions)


def _apply(evaluate: Any, inputs: Sequence[Any], width: Optional[int]) -> Any:
    for own in inputs:
        check_width(tuple(own.shape), width)
    return _function().apply(evaluate, *required("torch").broadcast_tensors(*inputs))


def _pair(value: PairValue, b_in_a: Any, a_in_world: Any, b_in_world: Any) -> Any:
    given = [own is not None for own in (b_in_a, a_in_world, b_in_world)]
    if given not in ([True, False, False], [False, True, True]):
        raise ArrayError("pass either b_in_a, or both a_in_world and b_in_world")
    return _apply(value, [b_in_a] if given[0] else [a_in_world, b_in_world], 7)


def distance(
    a: Shape,
    b: Shape,
    b_in_a: Optional[torch.Tensor] = None,
    *,
    a_in_world: Optional[torch.Tensor] = None,
    b_in_world: Optional[torch.Tensor] = None,
    tolerance: float = 0.0,
    strict: bool = False,
) -> torch.Tensor:
    """Distances of convex shapes; 0 with a gradient of 0 where they overlap."""
    value = PairValue("distance", a, b, tolerance, strict)
    found: torch.Tensor = _pair(value, b_in_a, a_in_world, b_in_world)
    return found


def depth(
    a: Shape,
    b: Shape,
    b_in_a: Optional[torch.Tensor] = None,
    *,
    a_in_world: Optional[torch.Tensor] = None,
    b_in_world: Optional[torch.Tensor] = None,
    tolerance: float = 0.0,
    strict: bool = False,
) -> torch.Tensor:
    """Penetration depths of convex shapes; 0 with a gradient of 0 where they are separated."""
    found: torch.Tensor = _pair(PairValue("depth", a, b, tolerance, strict), b_in_a, a_in_world, b_in_world)
    return found


def clearance(
    a: Shape,
    b: Shape,
    b_in_a: Optional[torch.Tensor] = None,
    *,
    a_in_world: Optional[torch.Tensor] = None,
    b_in_world: Optional[torch.Tensor] = None,
    tolerance: float = 0.0,
    strict: bool = False,
) -> torch.Tensor:
    """Signed distances of convex shapes: the distance, or the negative depth where they overlap. For the signed
    distance of points, B is ``hullmap.Sphere(0)``."""
    value = PairValue("clearance", a, b, tolerance, strict)
    found: torch.Tensor = _pair(value, b_in_a, a_in_world, b_in_world)
    return found


def ray(
    shape: Shape, origins: torch.Tensor, directions: torch.Tensor, *, tolerance: float = 1e-6, strict: bool = False
) -> torch.Tensor:
    """Where rays enter a convex shape, at ``origins + t * directions``; infinite with a gradient of 0 where they
    miss it. Origins and directions have the shape (..., 3)."""
    found: torch.Tensor = _apply(RayValue(shape, tolerance, strict), [origins, directions], 3)
    return found


def time_of_impact(
    a: Shape,
    b: Shape,
    motion_a: torch.Tensor,
    motion_b: torch.Tensor,
    *,
    target_distance: float = 0.0,
    tolerance: float = MOTION_TOLERANCE,
    strict: bool = False,
) -> torch.Tensor:
    """Times from 0 to 1 at which convex shapes that move and turn first come within ``target_distance`` of each other;
    infinite with a gradient of 0 where they do not.

    Motions have the shape (..., 13): the pose at the start, the displacement of the origin of the shape's frame until
    time 1, and the rotation vector by which the shape turns about that origin until then. The gradient is by all of
    these numbers. With a tolerance of ε, it is off by as much as the shapes turn in the time that ε takes."""
    value = ImpactValue(a, b, target_distance, tolerance, strict)
    found: torch.Tensor = _apply(value, [motion_a, motion_b], 13)
    return found


def robot_clearance(robot: Robot, q: torch.Tensor, *, tolerance: float = 0.0, strict: bool = False) -> torch.Tensor:
    """Clearances of a robot in the configurations ``q``, (..., J): the signed distance of the nearest pair."""
    found: torch.Tensor = _apply(RobotValue(robot, tolerance, strict), [q], None)
    return found


def perturbed(
    poses: torch.Tensor, *, radius: float, angle: float = 0.0, samples: int = 32, seed: int = 0
) -> torch.Tensor:
    """Poses moved by up to ``radius``, and turned by up to ``angle`` about the origin of their shape's frame;
    (samples, ..., 7). The mean of a value over the first axis is a smoothed value.

    Translations and rotation vectors are uniform in balls, the same for all poses and in all calls with this
    ``seed``, and come in opposite pairs. With more samples, the mean converges to a function with a continuous
    gradient, since distances and depths change at most as fast as points move. It differs from the value at the
    pose by at most ``radius + angle * reach``, for a shape whose points are within ``reach`` of its origin. With
    few samples, the gradient still jumps, by a share of 1/samples each.

    >>> near = hullmap.torch.perturbed(poses, radius=0.01, angle=0.02)        # doctest: +SKIP
    >>> smooth = hullmap.torch.clearance(a, b, near).mean(0)                  # doctest: +SKIP
    """
    module = required("torch")
    shifts, turns = (poses.new_tensor(own) for own in perturbations(radius, angle, samples, seed))
    lead = (samples,) + (1,) * (poses.dim() - 1)
    places = poses[..., :3] + shifts.reshape((*lead, 3))
    quaternions = module.einsum("sij,...j->s...i", turns, poses[..., 3:])
    found: torch.Tensor = module.cat((places, quaternions), -1)
    return found
