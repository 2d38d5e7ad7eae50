"""Options of a bake, for type checkers. A test compares them with the table of the command."""

from __future__ import annotations

from typing import Literal, Optional, TypedDict, Union


class BakeOptions(TypedDict, total=False):
    """Options of `bake`, `bake_parts`, `bake_file` and `from_trimesh`, as keywords: the options
    of the command, with underscores (``docs/COMMAND.md``). ``None`` stands for the default.

    >>> import hullmap
    >>> options: hullmap.BakeOptions = {"index": "compact", "recentre": True}
    >>> hullmap.bake([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], **options)[0].origin
    array([1., 1., 1.])
    """

    index: Optional[Literal["tree", "medium", "compact", "binary", "cubemap", "none"]]
    """Direction index; "tree" by default. "medium" and "compact" are smaller."""
    max_vertices: Optional[int]
    """Maximum number of vertices, at least 4: makes an enclosing hull instead of the exact one. With
    ``decompose``, the maximum for each part; 64 by default."""
    max_error: Optional[Union[float, str]]
    """Maximum length by which an enclosing hull extends beyond the exact one; ``"1%"`` is relative to
    the diagonal. With ``decompose``, the maximum protrusion of a part; ``"2%"`` by default."""
    for_engine: Optional[
        Literal["none", "physx", "physx-gpu", "jolt", "box3d", "unity", "unreal", "newton", "mujoco-warp"]
    ]
    """Simplify hulls and parts to the limits of an engine on vertices, faces and edges."""
    decompose: Optional[bool]
    """Cover concave meshes by convex parts, with proven bounds. It requires faces."""
    max_parts: Optional[int]
    """Maximum number of parts. The search then looks for the smallest error."""
    solid: Optional[Literal["auto", "closed", "walls"]]
    """"closed" closes the holes of an open mesh and counts its inside; "walls" counts its walls only, so that
    openings stay open. "auto", the default: open surfaces are walls if half of their area has faces on both sides, a
    hole has more than an eighth of it, or all holes together more than all of it; watertight ones are solid."""
    wall: Optional[Union[float, str]]
    """Thickness of the parts of walls; ``"0.5%"`` of the diagonal by default. It is at most half of
    ``max_error``."""
    primitives: Optional[bool]
    """Record a box, sphere, capsule or cylinder for each part that it can replace within both bounds."""
    decompose_seconds: Optional[float]
    """Time after which the search for parts stops. Packs may then differ from run to run."""
    vertices: Optional[Literal["referenced", "all"]]
    """Use the vertices that faces reference, by default, or all vertices."""
    split: Optional[Literal["none", "object", "auto"]]
    """One hull per file, per object, or per collision part (glTF colliders, UCX_…)."""
    unit_scale: Optional[float]
    """Factor of all coordinates; 0.01 converts centimetres to metres."""
    up_axis: Optional[Literal["keep", "y-to-z", "z-to-y"]]
    """Rotation about x: "y-to-z" turns a y-up mesh into a z-up mesh."""
    recentre: Optional[bool]
    """Move the origin to the centre of the bounds, for meshes far from the origin."""
    lean: Optional[bool]
    """Leave out data that only manifolds, hints and walks over the surface need. Packs have less than half
    the size."""
