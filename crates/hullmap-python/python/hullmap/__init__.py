"""Exact convex hulls of detailed meshes, and certified collision queries on arrays of poses.

>>> import numpy as np, hullmap
>>> corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
>>> cube = hullmap.bake(corners, name="cube")[0]
>>> poses = hullmap.poses([[2.5, 0, 0], [1.5, 0, 0]])          # of B in A's frame
>>> cube.distance(cube, poses).distance
array([0.5, 0. ])
>>> cube.contact(cube, poses).depth
array([0. , 0.5])

A pose is a row of seven numbers, ``x y z qx qy qz qw``, or a 4x4 matrix. ``b_in_a`` maps points of
B's frame into A's frame. All answers are in A's frame. Every length is an interval that contains the
true value, and a status says how narrow it is. Nothing converges silently.

Queries run on all processors, without holding Python's global lock.
"""

from __future__ import annotations

from ._answers import (
    Clearance,
    Contact,
    Differentiability,
    Distance,
    Impact,
    Intersection,
    Overlap,
    RayHit,
    SignedDistance,
    Status,
    Verdict,
)
from ._bake import bake, bake_file, bake_parts
from ._export import from_trimesh, to_mjcf, to_trimesh, to_urdf
from ._hullmap import (
    ArrayError,
    BakeError,
    BakeWarning,
    Error,
    InvalidPack,
    PoseError,
    ShapeError,
    __version__,
)
from ._motion import (
    Derivatives,
    Motion,
    TimeOfImpact,
    WitnessDerivatives,
    cast_motion,
    clear,
    derivatives,
    ray_derivatives,
    witness_derivatives,
)
from ._options import BakeOptions
from ._pairs import Pairs
from ._poses import poses, relative
from ._results import Manifold, MassProperties, PairManifolds, Primitive, Support
from ._robot import Robot, RobotClearance, RobotEdges, Skipped
from ._shapes import (
    Box,
    Capsule,
    Cone,
    ConvexShape,
    Cylinder,
    HalfSpace,
    Hull,
    Lists,
    Pack,
    Segment,
    Shape,
    Sphere,
    Triangle,
    from_bytes,
)
from ._sheets import HeightField, TriangleMesh, open

__all__ = [
    "ArrayError",
    "BakeError",
    "BakeOptions",
    "BakeWarning",
    "Box",
    "Capsule",
    "Clearance",
    "Cone",
    "Contact",
    "ConvexShape",
    "Cylinder",
    "Derivatives",
    "Differentiability",
    "Distance",
    "Error",
    "HalfSpace",
    "HeightField",
    "Hull",
    "Impact",
    "Intersection",
    "InvalidPack",
    "Lists",
    "Manifold",
    "MassProperties",
    "Motion",
    "Overlap",
    "Pack",
    "PairManifolds",
    "Pairs",
    "PoseError",
    "Primitive",
    "RayHit",
    "Robot",
    "RobotClearance",
    "RobotEdges",
    "Segment",
    "Shape",
    "ShapeError",
    "SignedDistance",
    "Skipped",
    "Sphere",
    "Status",
    "Support",
    "TimeOfImpact",
    "Triangle",
    "TriangleMesh",
    "Verdict",
    "WitnessDerivatives",
    "__version__",
    "bake",
    "bake_file",
    "bake_parts",
    "cast_motion",
    "clear",
    "derivatives",
    "from_bytes",
    "from_trimesh",
    "poses",
    "ray_derivatives",
    "relative",
    "to_mjcf",
    "to_trimesh",
    "to_urdf",
    "witness_derivatives",
]
