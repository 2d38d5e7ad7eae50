"""Distances, depths and clearances that JAX differentiates, in reverse mode.

>>> import hullmap, hullmap.jax, jax                                    # doctest: +SKIP
>>> jax.config.update("jax_enable_x64", True)                           # doctest: +SKIP
>>> cube, ball = hullmap.Box([1, 1, 1]), hullmap.Sphere(0.5)              # doctest: +SKIP
>>> pose = jax.numpy.array([3, 0.5, 0, 0, 0, 0, 1.0])                   # doctest: +SKIP
>>> jax.grad(lambda pose: hullmap.jax.distance(cube, ball, pose))(pose)[:3]  # doctest: +SKIP
Array([1., 0., 0.], dtype=float64)

Poses are arrays of the shape (..., 7). Queries run on the processor, as callbacks, so ``jit`` and ``vmap`` work, and
``vmap`` makes one call of all poses. The rotation of a pose is its quaternion divided by its length, so the numbers
of a pose are free variables of an optimiser. The gradient by a quaternion is perpendicular to it.

Where there is no derivative (`hullmap.Differentiability`), the gradient belongs to one of several normals or pairs
of points: it is a direction, like the gradient of ``abs`` at 0. With ``strict=True`` it is NaN there. Only first
derivatives are computed. It requires JAX: ``pip install hullmap[jax]``.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np

from ._differentiable import Functions
from ._gradients import check_width, perturbations, required

if TYPE_CHECKING:
    import jax

__all__ = ["clearance", "depth", "distance", "perturbed", "ray", "robot_clearance", "time_of_impact"]


@lru_cache(maxsize=None)
def _function() -> Any:
    """The function with a rule for its gradient, of how to evaluate it and of its inputs."""
    module = required("jax")

    def called(evaluate: Any, inputs: Any, gradient: bool) -> Any:
        dtype = inputs[0].dtype

        def run(*arrays: Any) -> Any:
            value, gradients = evaluate([np.asarray(own, np.float64) for own in arrays], gradient)
            return np.asarray(value, dtype), tuple(np.asarray(own, dtype) for own in gradients)

        value = module.ShapeDtypeStruct(inputs[0].shape[:-1], dtype)
        gradients = tuple(module.ShapeDtypeStruct(own.shape, dtype) for own in inputs) if gradient else ()
        return module.pure_callback(run, (value, gradients), *inputs, vmap_method="broadcast_all")

    def value(evaluate: Any, inputs: Any) -> Any:
        return called(evaluate, inputs, False)[0]

    def forward(evaluate: Any, inputs: Any) -> Any:
        return called(evaluate, inputs, True)

    def backward(_: Any, gradients: Any, by_value: Any) -> Any:
        return (tuple(by_value[..., None] * own for own in gradients),)

    function = partial(module.custom_vjp, nondiff_argnums=(0,))(value)
    function.defvjp(forward, backward)
    return function


def _apply(evaluate: Any, inputs: Sequence[Any], width: Optional[int]) -> Any:
    numpy = required("jax.numpy")
    arrays = [numpy.asarray(own) for own in inputs]
    for own in arrays:
        check_width(own.shape, width)
    kind = numpy.result_type(float, *arrays)
    return _function()(evaluate, tuple(numpy.broadcast_arrays(*(own.astype(kind) for own in arrays))))


_functions: Functions[jax.Array] = Functions(_apply)
distance = _functions.distance
depth = _functions.depth
clearance = _functions.clearance
ray = _functions.ray
time_of_impact = _functions.time_of_impact
robot_clearance = _functions.robot_clearance


def perturbed(poses: jax.Array, *, radius: float, angle: float = 0.0, samples: int = 32, seed: int = 0) -> jax.Array:
    """Poses moved by up to ``radius``, and turned by up to ``angle`` about the origin of their shape's frame;
    (samples, ..., 7). The mean of a value over the first axis is a smoothed value: see `hullmap.torch.perturbed`.

    >>> near = hullmap.jax.perturbed(poses, radius=0.01, angle=0.02)          # doctest: +SKIP
    >>> smooth = hullmap.jax.clearance(a, b, near).mean(0)                    # doctest: +SKIP
    """
    numpy = required("jax.numpy")
    shifts, turns = (numpy.asarray(own, poses.dtype) for own in perturbations(radius, angle, samples, seed))
    places = poses[..., :3] + shifts.reshape((samples,) + (1,) * (poses.ndim - 1) + (3,))
    quaternions = numpy.einsum("sij,...j->s...i", turns, poses[..., 3:])
    found: jax.Array = numpy.concatenate((places, quaternions), -1)
    return found
