"""Whole robots: collisions, clearances and edges of configurations."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._arrays import Counts, Floats, floats, number, transforms
from ._hullmap import ArrayError, Error
from ._progress import Progress, shown
from ._results import Codes, Flags, _Answer
from ._shapes import MAX_ITERATIONS, TOLERANCE, Shape, _count, native, settings_of

FilePath = Union[str, "os.PathLike[str]"]
Names = Tuple[str, str]

MAX_QUERIES = 10_000
"""Default limit of queries of an edge."""

RESOLUTION = 1e-3
"""Default width of the interval of the first hit, as a share of the edge."""

NO_PAIR = 0xFFFFFFFF
"""Index in ``pair`` if there is none."""


class Skipped(NamedTuple):
    """A pair or a geometry that a `Robot` does not test."""

    links: Tuple[str, ...]
    """Names of the two links of a pair, or of the link and the obstacle. For a geometry, the name of its link; empty
    if it belongs to no link that was read, such as an included model."""
    geoms: Tuple[str, ...]
    """Names of the geoms of these links that are meant. Empty for a pair if all of them are."""
    reason: str
    """Why it is not tested."""


@dataclass(frozen=True, eq=False, repr=False)
class RobotClearance(_Answer):
    """Clearances of a robot. Points and directions are in the world."""

    lower: Floats
    """Lower bound of the clearance, with allowance for rounding error: no pair is nearer. If bodies overlap, it is
    the negative depth of the deepest pair. Infinite if there is no pair."""
    upper: Floats
    """Upper bound: the pair that decides is this near."""
    pair: Counts
    """Indices of `Robot.names` of the pair that decides, the lower one first; (..., 2). 4294967295 if there is
    no pair."""
    status: Codes
    """Codes of `Status`, for this pair."""
    normal: Floats
    """Unit vector from the first to the second of the pair; (..., 3)."""
    point_a: Floats
    """The point of the first that is closest to the second, or deepest in it; (..., 3)."""
    point_b: Floats
    """The point of the second; (..., 3)."""
    differentiability: Optional[Codes] = None
    """Codes of `Differentiability`: whether ``gradient`` is the derivative. None without a gradient."""
    gradient: Optional[Floats] = None
    """Derivative of the clearance by each joint: metres for each radian or metre; (..., J)."""


@dataclass(frozen=True, eq=False, repr=False)
class RobotEdges(_Answer):
    """Verdicts on edges in joint space. Times are shares of the edge."""

    verdict: Codes
    """Codes of `Verdict`."""
    status: Codes
    """Codes of `Status`. ``WITHIN``: a hit whose interval is as narrow as the resolution, or a free edge with the
    requested clearance. Otherwise the limit of queries or rounding error stopped the search."""
    clearance: Floats
    """Lower bound of the clearance in all configurations of a free edge. Otherwise 0."""
    nearest: Floats
    """Upper bound of the least clearance: a pair is at most this far apart in some configuration."""
    t_lower: Floats
    """Up to this time, the edge is free. Infinite for a free edge."""
    t_upper: Floats
    """At this time, a pair certainly hits. Infinite if no such time is known."""
    pair: Counts
    """Indices of `Robot.names` of the pair that hits or is nearest; (..., 2). 4294967295 if none is known."""
    queries: Counts
    """Number of distance and contact queries."""


class Robot:
    """A robot on exact convex hulls: its links, its joints, and obstacles.

    The bodies of a link are the hulls of its collision meshes, and its primitives. The description decides which
    pairs are tested: in URDF and SDF, all pairs but the parent and the child of a joint, and links that never move
    relative to each other; in MJCF, the pairs that MuJoCo tests. `allowing` and `disallowing` override it, and
    `skipped` lists all that is not tested, with the reasons.

    A configuration is a row of one number for each of `joint_names`: radians, or metres for sliders. Joints that
    follow others (``mimic``, ``equality``) have no number. Ball joints, floating and planar ones stay where the
    description puts them. With ``poses``, the caller gives the poses of the links instead, for instance from
    Pinocchio, MuJoCo or a simulator: one pose in the world for each of `link_names`, (..., L, 7) or
    (..., L, 4, 4).

    A robot does not change: methods return new ones that share its hulls. Queries run on all processors.

    >>> import hullmap, pathlib, tempfile
    >>> text = '''<mujoco><worldbody><body name="base"><geom type="sphere" size="0.1"/>
    ...   <body name="upper"><joint name="a" axis="0 0 1"/>
    ...     <body name="lower" pos="1 0 0"><joint name="b" axis="0 0 1"/>
    ...       <geom type="sphere" size="0.2" pos="1 0 0"/></body></body></body></worldbody></mujoco>'''
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "arm.xml"
    >>> _ = path.write_text(text)
    >>> arm = hullmap.Robot.from_mjcf(path)
    >>> arm.joint_names, [(arm.names[a], arm.names[b]) for a, b in arm.pairs]
    (['a', 'b'], [('base', 'lower')])
    >>> arm.in_collision([[0.0, 0.0], [0.0, 3.0]])
    array([False,  True])
    >>> gap = arm.clearance([0.0, 2.0], gradient=True)
    >>> float(gap.lower.round(4)), gap.gradient.round(4) + 0.0
    (0.7806, array([ 0.    , -0.8415]))
    >>> edge = arm.clear([0.0, 0.0], [0.0, 3.0])
    >>> hullmap.Verdict(int(edge.verdict)).name, bool(edge.t_lower <= 0.9468 <= edge.t_upper)
    ('HIT', True)
    """

    __slots__ = ("_native", "_steps")

    def __init__(self, robot: _hullmap.Robot, steps: Tuple[Any, ...]) -> None:
        self._native, self._steps = robot, steps

    @classmethod
    def from_urdf(
        cls,
        path: FilePath,
        *,
        packs: Sequence[FilePath] = (),
        packages: Sequence[FilePath] = (),
        srdf: Optional[FilePath] = None,
        strict: bool = False,
    ) -> Robot:
        """The robot of a URDF file.

        ``packs`` are folders of packs: the pack of ``meshes/hand.stl`` is ``hand.hullmap``, and must have been
        baked from that mesh. A mesh without a pack stands for its convex hull. ``packages`` are folders of
        packages, or folders that hold them. Files are read below them and in the project: the nearest folder above
        with ``.git``, or the package. Pairs that the ``srdf`` file disables are allowed, as by `allowing_srdf`. With
        ``strict=True``, geometry that cannot be tested is an error; without, `skipped` lists it.
        """
        return cls._read("URDF", path, packs, packages, srdf, strict)

    @classmethod
    def from_mjcf(
        cls,
        path: FilePath,
        *,
        packs: Sequence[FilePath] = (),
        packages: Sequence[FilePath] = (),
        strict: bool = False,
    ) -> Robot:
        """The robot of an MJCF file. MuJoCo's rules decide which geoms are tested: ``contype``, ``conaffinity``,
        ``exclude``, ``pair``, parents and children, and the flags ``contact`` and ``filterparent``. ``margin`` and
        ``gap`` do not matter. The other parameters are the same as for `from_urdf`."""
        return cls._read("MJCF", path, packs, packages, None, strict)

    @classmethod
    def from_sdf(
        cls,
        path: FilePath,
        *,
        packs: Sequence[FilePath] = (),
        packages: Sequence[FilePath] = (),
        strict: bool = False,
    ) -> Robot:
        """The robot of an SDF file. Models that it includes are not tested. The parameters are the same as for
        `from_urdf`."""
        return cls._read("SDF", path, packs, packages, None, strict)

    @classmethod
    def _read(
        cls,
        kind: str,
        path: FilePath,
        packs: Sequence[FilePath],
        packages: Sequence[FilePath],
        srdf: Optional[FilePath],
        strict: bool = False,
    ) -> Robot:
        if isinstance(packs, (str, bytes, os.PathLike)) or isinstance(packages, (str, bytes, os.PathLike)):
            raise Error("packs and packages are lists of folders: pass [folder]")
        own, folders, around = os.fspath(path), [os.fspath(p) for p in packs], [os.fspath(p) for p in packages]
        made = _hullmap.Robot.read(own, folders, around, bool(strict))
        if made.format != kind:
            raise Error(f"{own}: this is {made.format}, not {kind}: use Robot.from_{made.format.lower()}")
        robot = cls(made, (("_read", kind, own, folders, around, None, bool(strict)),))
        return robot if srdf is None else robot.allowing_srdf(srdf)

    def _then(self, made: _hullmap.Robot, *step: Any) -> Robot:
        return Robot(made, (*self._steps, step))

    def allowing(self, pairs: Iterable[Names]) -> Robot:
        """The robot with more pairs that may collide, by the names of links and obstacles: they are not tested.
        `allowing` and `disallowing` are the entries of MoveIt's allowed collision matrix; a later one wins."""
        own = [(str(a), str(b)) for a, b in pairs]
        return self._then(self._native.allowing(own), "allowing", own)

    def disallowing(self, pairs: Iterable[Names]) -> Robot:
        """The robot with more pairs that must not collide: they are tested with all of their geoms, whatever the
        description says."""
        own = [(str(a), str(b)) for a, b in pairs]
        return self._then(self._native.disallowing(own), "disallowing", own)

    def allowing_srdf(self, path: FilePath) -> Robot:
        """The robot with the pairs allowed that an SRDF file disables, and disallowed that it enables. Names of
        other robots are passed over."""
        own = os.fspath(path)
        return self._then(self._native.allowing_srdf(own), "allowing_srdf", own)

    def with_obstacles(self, obstacles: Mapping[str, Union[Shape, Tuple[Shape, npt.ArrayLike]]]) -> Robot:
        """The robot with more obstacles, by name: a shape, or a shape and its pose in the world.

        Shapes are hulls, packs, primitives, half-spaces, triangle meshes and height fields. The inside of a
        triangle mesh is free, and so is what is below a height field.
        """
        own: List[Tuple[str, Shape, Tuple[float, ...]]] = []
        for name, value in obstacles.items():
            shape, pose = value if isinstance(value, tuple) else (value, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
            rows, lead = transforms(f"pose of obstacle {name!r}", pose)
            if lead:
                raise ArrayError(f"pose of obstacle {name!r}: expected one pose, found the shape {lead}")
            rows = rows if rows.shape[-1] == 7 else _hullmap.pose_rows(name, rows)
            own.append((str(name), shape, tuple(map(float, rows[0]))))
        made = self._native.with_obstacles([(name, native(shape), list(pose)) for name, shape, pose in own])
        return self._then(made, "with_obstacles", {name: (shape, pose) for name, shape, pose in own})

    def without_obstacles(self) -> Robot:
        """The robot without obstacles."""
        return self._then(self._native.without_obstacles(), "without_obstacles")

    @property
    def joint_names(self) -> List[str]:
        """Names of the joints that a configuration has numbers for, in their order."""
        return [name for name, _, _, _ in self._native.joint_facts()]

    @property
    def limits(self) -> Floats:
        """Minimum and maximum of each joint; (J, 2). Infinite where there is none."""
        none = (-np.inf, np.inf)
        return np.array([none if own is None else own for _, own, _, _ in self._native.joint_facts()]).reshape(-1, 2)

    @property
    def neutral(self) -> Floats:
        """The neutral configuration; (J,)."""
        return np.array([neutral for _, _, neutral, _ in self._native.joint_facts()], np.float64)

    @property
    def link_names(self) -> List[str]:
        """Names of all links, in the order of the description: bodies in MJCF, the world first."""
        return self._native.names()[0]

    @property
    def names(self) -> List[str]:
        """Names of links, then of obstacles: what indices of ``pair`` mean."""
        links, obstacles = self._native.names()
        return links + obstacles

    @property
    def pairs(self) -> Counts:
        """The pairs that are tested, as indices of `names`; (P, 2)."""
        return np.array(self._native.pairs(), np.uint32).reshape(-1, 2)

    @property
    def skipped(self) -> List[Skipped]:
        """All that is not tested, with the reasons: first geometry, then pairs of links with geometry.

        >>> import hullmap
        >>> # for links, geoms, reason in robot.skipped: print(*links, *geoms, reason)
        """
        return [Skipped(tuple(links), tuple(geoms), reason) for links, geoms, reason in self._native.skipped()]

    @property
    def notes(self) -> List[str]:
        """Geometry that is not tested, joints that are not moved, and why."""
        return self._native.notes

    def link_poses(self, q: npt.ArrayLike) -> Floats:
        """Forward kinematics: the poses of `link_names` in the world, x y z and a quaternion x y z w; (..., L, 7).

        These are poses as ``in_collision(poses=...)`` takes them. Links that a ball, floating or planar joint moves
        are where the description puts them: change their poses, and the poses of the links below, if they are elsewhere.
        """
        rows, lead = self._rows("q", q)
        poses: Floats = self._native.link_poses(rows).reshape((*lead, len(self.link_names), 7))
        return poses

    def touching(self, q: npt.ArrayLike) -> List[Names]:
        """Names of all pairs that touch in one configuration: to allow those that touch by design.

        >>> import hullmap
        >>> # robot = robot.allowing(robot.touching(robot.neutral))
        """
        rows, lead = self._rows("q", q)
        if lead:
            raise ArrayError(f"q: expected one configuration, found the shape {lead}")
        names = self.names
        return [(names[a], names[b]) for a, b in self._native.touching(rows)]

    def in_collision(
        self,
        q: Optional[npt.ArrayLike] = None,
        *,
        poses: Optional[npt.ArrayLike] = None,
        margin: float = 0.0,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> Flags:
        """Whether any pair touches, or is within ``margin``; of the shape of ``q`` without its last axis.

        Pairs that only touch, and those that cannot be decided, count as collisions. ``progress`` is True for a
        bar, or a function of the share that is done.
        """
        rows, of_links, lead = self._configurations(q, poses)
        own = number("margin", margin)
        with shown(progress, "in_collision") as report:
            count = _product(lead)
            found = self._native.in_collision(count, rows, of_links, own, threads, report)["hit"]
        hit: Flags = found.reshape(lead) if lead else found[0]
        return hit

    def clearance(
        self,
        q: Optional[npt.ArrayLike] = None,
        *,
        poses: Optional[npt.ArrayLike] = None,
        gradient: bool = False,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> RobotClearance:
        """How far the nearest pair is apart, or how deep the deepest pair overlaps, as a negative length.

        With ``gradient=True``, also the derivative by the joints. ``differentiability`` says where there is none:
        the gradient then belongs to one of several pairs, normals or points, and is a direction for an optimiser.
        """
        rows, of_links, lead = self._configurations(q, poses)
        if gradient and rows is None:
            raise ArrayError("gradient: poses have no joints: pass q")
        settings = settings_of(tolerance, max_iterations)
        with shown(progress, "clearance") as report:
            count = _product(lead)
            found = self._native.clearance(count, rows, of_links, settings, gradient, threads, report)
        if gradient and rows is not None:
            # Robots without joints have no such column.
            found["gradient"] = np.reshape(found.get("gradient", ()), np.shape(rows))
        else:
            del found["differentiability"]
        return RobotClearance._of(found, lead)

    def clear(
        self,
        start: npt.ArrayLike,
        end: npt.ArrayLike,
        *,
        margin: float = 0.0,
        resolution: float = RESOLUTION,
        share: float = 0.5,
        max_queries: int = MAX_QUERIES,
        threads: Optional[int] = None,
        progress: Progress = None,
    ) -> RobotEdges:
        """Whether edges are free: while each joint moves linearly from ``start`` to ``end``.

        A free edge is free in each of its configurations, which is proven, and not sampled. For a hit, the
        first touch is between ``t_lower`` and ``t_upper``. An open edge is free up to ``t_lower``; then it
        grazes, or ``max_queries`` was reached.

        Pairs within ``margin`` count as a hit. If the status is ``WITHIN``, the interval of a hit is at most
        ``resolution`` wide, and the clearance of a free edge is at least ``share`` of the least distance that was
        computed. A share of 0 is the fastest.
        """
        (start_rows, lead_start), (end_rows, lead_end) = self._rows("start", start), self._rows("end", end)
        width = start_rows.shape[-1:]
        try:
            lead = np.broadcast_shapes(lead_start, lead_end)
        except ValueError:
            raise ArrayError(f"start has the shape {lead_start} and end {lead_end}: pass as many, or one") from None
        both = [
            np.ascontiguousarray(np.broadcast_to(rows.reshape(own + width), lead + width).reshape((_product(lead), *width)))
            for rows, own in ((start_rows, lead_start), (end_rows, lead_end))
        ]
        most = _count("max_queries", max_queries, 0, 2**32 - 1)
        settings = (number("margin", margin), number("resolution", resolution), number("share", share), most)
        with shown(progress, "clear") as report:
            found = self._native.clear(both[0], both[1], settings, threads, report)
        return RobotEdges._of(found, lead)

    def _rows(self, name: str, q: npt.ArrayLike) -> Tuple[Floats, Tuple[int, ...]]:
        """Configurations as rows, and the shape of the answer."""
        array, width = floats(name, q), len(self._native.joint_facts())
        if array.ndim == 0 or array.shape[-1] != width:
            raise ArrayError(
                f"{name}: expected the shape (..., {width}), a number for each of the joints, found {array.shape}"
            )
        return np.ascontiguousarray(array.reshape(_product(array.shape[:-1]), width)), array.shape[:-1]

    def _configurations(
        self, q: Optional[npt.ArrayLike], poses: Optional[npt.ArrayLike]
    ) -> Tuple[Optional[Floats], Optional[Floats], Tuple[int, ...]]:
        if (q is None) == (poses is None):
            raise ArrayError("pass q, or poses of all links")
        if q is not None:
            rows, lead = self._rows("q", q)
            return rows, None, lead
        rows, lead = transforms("poses", poses)  # type: ignore[arg-type]
        links = len(self.link_names)
        if lead[-1:] != (links,):
            raise ArrayError(f"poses: expected one for each of the {links} links in the last axis, found {lead}")
        return None, rows, lead[:-1]

    def __repr__(self) -> str:
        links, obstacles = self._native.names()
        with_obstacles = f", {len(obstacles)} obstacles" if obstacles else ""
        joints = len(self._native.joint_facts())
        return f"<robot of {len(links)} links, {joints} joints, {self._native.body_count} bodies{with_obstacles}>"

    def __reduce__(self) -> Any:
        return (_replayed, (self._steps,))


def _replayed(steps: Tuple[Any, ...]) -> Robot:
    """The robot that these calls make."""
    (_, *arguments), *others = steps
    robot = Robot._read(*arguments)
    for name, *own in others:
        robot = getattr(robot, name)(*own)
    return robot


def _product(lead: Tuple[int, ...]) -> int:
    return int(np.prod(lead, dtype=np.intp))
