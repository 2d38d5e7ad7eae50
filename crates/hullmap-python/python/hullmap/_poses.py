"""Poses: rows of seven numbers."""

from __future__ import annotations

from typing import Literal, Optional

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._arrays import Floats, floats, joint, transforms, vectors
from ._hullmap import ArrayError


def poses(
    positions: npt.ArrayLike,
    rotations: Optional[npt.ArrayLike] = None,
    *,
    order: Literal["xyzw", "wxyz"] = "xyzw",
) -> Floats:
    """Poses as rows ``x y z qx qy qz qw``, from positions and rotations, or from 4x4 matrices.

    ``positions`` have the shape (..., 3). ``rotations`` are unit quaternions in the given ``order``, of shape (..., 4), or matrices of shape
    (..., 3, 3). Without rotations, the poses only translate. Positions and rotations are broadcast.
    Matrices of poses, of shape (..., 4, 4), take the place of both. Queries take them as they are, too.

    The scalar comes last in SciPy, ROS, Pinocchio, PyBullet, Eigen's memory and glTF, and in
    hullmap's own command; it comes first in MuJoCo, Drake and trimesh: pass ``order="wxyz"`` there.

    >>> import numpy as np, hullmap
    >>> hullmap.poses([1, 2, 3])
    array([1., 2., 3., 0., 0., 0., 1.])
    >>> hullmap.poses([[1, 2, 3]], [1, 0, 0, 0], order="wxyz")
    array([[1., 2., 3., 0., 0., 0., 1.]])
    >>> hullmap.poses(np.diag([-1.0, -1.0, 1.0, 1.0]))
    array([0., 0., 0., 0., 0., 1., 0.])
    """
    places = floats("positions", positions)
    if places.shape[-2:] == (4, 4):
        if rotations is not None:
            raise ArrayError("positions are matrices of poses, which contain rotations: leave out the argument rotations")
        return _rows("positions", places)
    places, lead = vectors("positions", places)
    places = places.reshape(lead + (3,))
    if order not in ("xyzw", "wxyz"):
        raise ArrayError(f"order: expected 'xyzw' or 'wxyz', found {order!r}")
    turns = floats("rotations", (0.0, 0.0, 0.0, 1.0) if rotations is None else rotations)
    if turns.ndim >= 2 and turns.shape[-2:] == (3, 3):
        turns = _quaternions(turns)
    elif turns.ndim == 0 or turns.shape[-1] != 4:
        raise ArrayError(f"rotations: expected the shape (..., 4) or (..., 3, 3), found {turns.shape}")
    elif order == "wxyz" and rotations is not None:
        turns = np.roll(turns, -1, axis=-1)
    try:
        lead = np.broadcast_shapes(lead, turns.shape[:-1])
    except ValueError:
        raise ArrayError(
            f"positions have the shape {places.shape} and rotations {turns.shape}: pass as many of both, or one of either"
        ) from None
    return np.concatenate((np.broadcast_to(places, lead + (3,)), np.broadcast_to(turns, lead + (4,))), axis=-1)


def _quaternions(matrices: Floats) -> Floats:
    """The quaternions of rotation matrices."""
    frames = np.zeros(matrices.shape[:-2] + (4, 4))
    frames[..., :3, :3] = matrices
    frames[..., 3, 3] = 1.0
    return _rows("rotations", frames)[..., 3:]


def _rows(name: str, matrices: Floats) -> Floats:
    """Matrices of poses as rows of seven numbers."""
    rows, lead = transforms(name, matrices)
    found: Floats = _hullmap.pose_rows(name, rows)
    return found.reshape(lead + (7,))


def relative(a_in_world: npt.ArrayLike, b_in_world: npt.ArrayLike) -> Floats:
    """The poses of B in A's frame, ``b_in_a``, from the poses of both in a common frame.

    Either may be one pose for all. The answer has rows ``x y z qx qy qz qw``. Bodies near each other
    keep their digits, however far they are from the origin.

    >>> import hullmap
    >>> hullmap.relative(hullmap.poses([1e9, 0, 0]), hullmap.poses([[1e9, 0, 2], [1e9, 3, 0]]))
    array([[0., 0., 2., 0., 0., 0., 1.],
           [0., 3., 0., 0., 0., 0., 1.]])
    """
    (a, lead_a), (b, lead_b) = transforms("a_in_world", a_in_world), transforms("b_in_world", b_in_world)
    rows: Floats = _hullmap.relative(a, b)
    return rows.reshape(joint(lead_a, len(a), lead_b, len(b)) + (7,))
