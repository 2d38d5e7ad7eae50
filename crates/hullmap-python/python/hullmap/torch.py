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

Where there is no derivative (`hullmap.Differentiability`), the gradient belongs to one of several normals or pairs
of points: it is a direction, like the gradient of ``abs`` at 0. With ``strict=True`` it is NaN there. Only first
derivatives are computed. It requires PyTorch: ``pip install hullmap[torch]``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np

from ._differentiable import Functions
from ._gradients import check_width, perturbations, required

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


_functions: Functions[torch.Tensor] = Functions(_apply)
distance = _functions.distance
depth = _functions.depth
clearance = _functions.clearance
ray = _functions.ray
time_of_impact = _functions.time_of_impact
robot_clearance = _functions.robot_clearance


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
