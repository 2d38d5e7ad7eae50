"""Packs, hulls and primitives, and the queries on them."""

from __future__ import annotations

import operator
import os
import tempfile
from pathlib import Path
from typing import Any, Iterator, List, Literal, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _hullmap
from ._answers import Contact, Distance, Impact, Intersection, RayHit, SignedDistance
from ._arrays import Counts, Floats, floats, indices, joint, number, transforms, vector, vectors
from ._hullmap import ArrayError
from ._results import Manifold, MassProperties, PairManifolds, Primitive, Support

TOLERANCE = 1e-5
"""Default width of an interval, relative to its upper bound."""

MAX_ITERATIONS = 1000
"""Default number of steps of the last phase of a query."""

RAY_TOLERANCE = 1e-6
"""Default width of the interval of a ray or a cast, relative to t."""

Poses = Optional[npt.ArrayLike]
"""Poses as users pass them."""
FilePath = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]


def _count(name: str, value: int, least: int, most: int) -> int:
    """The whole number ``value``, if it is from ``least`` to ``most``."""
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if not least <= count <= most:
        raise ArrayError(f"{name} must be a whole number from {least} to {most}, found {value}")
    return count


def settings_of(tolerance: float, max_iterations: int) -> Tuple[float, int]:
    """The settings of a query, checked."""
    return number("tolerance", tolerance), _count("max_iterations", max_iterations, 0, 2**32 - 1)


def pairs_of(max_pairs: int) -> int:
    """The maximum number of manifolds, checked."""
    return _count("max_pairs", max_pairs, 1, 2**16)


def length_of(prediction: Optional[float]) -> Optional[float]:
    """The prediction of a manifold, checked."""
    return None if prediction is None else number("prediction", prediction)


def _poses(
    b_in_a: Poses, a_in_world: Poses, b_in_world: Poses
) -> Tuple[_hullmap.Poses, Tuple[int, ...]]:
    """The arrays of poses, and the shape of the answer."""
    if b_in_a is not None and a_in_world is None and b_in_world is None:
        rows, lead = transforms("b_in_a", b_in_a)
        return (rows, None), lead
    if b_in_a is not None or a_in_world is None or b_in_world is None:
        raise ArrayError("pass either b_in_a, or both a_in_world and b_in_world")
    a, lead_a = transforms("a_in_world", a_in_world)
    b, lead_b = transforms("b_in_world", b_in_world)
    return (a, b), joint(lead_a, len(a), lead_b, len(b))


class Shape:
    """A shape that can be queried: a `Hull`, a `Pack` (the union of its hulls), a `TriangleMesh`, a
    `HeightField`, a primitive, or a `HalfSpace`.

    Queries take poses of B, the other shape, in the frame of A, this shape: ``b_in_a``, rows of
    ``x y z qx qy qz qw`` or 4x4 matrices. Or pass the poses of both in a common frame,
    ``a_in_world`` and ``b_in_world``; either may be one pose for all. The answer has the shape of the
    poses: a single pose gives single numbers.

    ``tolerance`` is the width of intervals relative to their upper bound; 0 requests full accuracy.
    With ``coherent=True``, the poses are successive ones of a motion, and each search starts from
    the answer of the pose before: that is faster, and changes answers by rounding error at most.
    ``threads`` is the number of threads; all processors by default.

    ``device="gpu"`` solves pairs of hulls on a Vulkan device, in f32 with certified intervals, and on
    the processor what the GPU leaves open. The package must be built with the feature ``gpu``.
    """

    __slots__ = ("_native",)

    _native: _hullmap.Shape

    def intersects(
        self,
        other: Shape,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Intersection:
        """Whether this shape and ``other`` share a point.

        >>> import hullmap
        >>> box = hullmap.Box([1, 1, 1])
        >>> box.intersects(hullmap.Sphere(0.5), hullmap.poses([[1.4, 0, 0], [2, 0, 0]])).hit
        array([ True, False])
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        found = _hullmap.intersects((self._native, native(other)), poses, coherent, threads, device)
        return Intersection._of(found, lead)

    def distance(
        self,
        other: Shape,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Distance:
        """Distances of this shape and ``other``; 0 if they overlap or touch.

        >>> import hullmap
        >>> gap = hullmap.Box([1, 1, 1]).distance(hullmap.Sphere(0.5), hullmap.poses([3, 0, 0]))
        >>> float(gap.distance), gap.point_b.tolist()
        (1.5, [2.5, 0.0, 0.0])
        >>> bool(gap.lower <= 1.5 <= gap.upper)
        True
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        settings = settings_of(tolerance, max_iterations)
        found = _hullmap.distance((self._native, native(other)), poses, settings, coherent, threads, device)
        return Distance._of(found, lead)

    def contact(
        self,
        other: Shape,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
        device: Literal["cpu", "gpu"] = "cpu",
    ) -> Contact:
        """Penetration depths of this shape and ``other``, with normals and points.

        >>> import hullmap
        >>> floor = hullmap.HalfSpace([0, 0, 1], 0.0)
        >>> c = floor.contact(hullmap.Sphere(1.0), hullmap.poses([0, 0, 0.75]))
        >>> float(c.depth), c.normal.tolist()
        (0.25, [0.0, 0.0, 1.0])
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        settings = settings_of(tolerance, max_iterations)
        found = _hullmap.contact((self._native, native(other)), poses, settings, coherent, threads, device)
        return Contact._of(found, lead)

    def ray(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        max_t: float = float("inf"),
        tolerance: float = RAY_TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        threads: Optional[int] = None,
    ) -> RayHit:
        """Where rays first enter the shape. Directions need not be of unit length: t is a factor of
        them. Either argument may be one vector for all.

        >>> import hullmap
        >>> hit = hullmap.Box([1, 1, 1]).ray([[0, 0, 5], [3, 0, 5]], [0, 0, -2])
        >>> hit.t
        array([ 2., inf])
        """
        (starts, lead_o), (ways, lead_d) = vectors("origins", origins), vectors("directions", directions)
        lead = joint(lead_o, len(starts), lead_d, len(ways))
        settings = (number("max_t", max_t), *settings_of(tolerance, max_iterations))
        return RayHit._of(_hullmap.ray(self._native, starts, ways, settings, threads), lead)

    def cast(
        self,
        other: Shape,
        b_in_a: Poses = None,
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        max_t: float = float("inf"),
        tolerance: float = RAY_TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> Impact:
        """When ``other``, which starts at ``b_in_a`` and translates by ``velocity`` in this shape's
        frame, first meets this shape.

        >>> import hullmap
        >>> floor = hullmap.HalfSpace([0, 0, 1], 0.0)
        >>> float(floor.cast(hullmap.Sphere(0.5), hullmap.poses([0, 0, 2.5]), [1, 0, -4]).t)
        0.5
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        velocities, _ = vectors("velocity", velocity)
        settings = (number("max_t", max_t), *settings_of(tolerance, max_iterations))
        found = _hullmap.cast((self._native, native(other)), poses, velocities, settings, coherent, threads)
        return Impact._of(found, lead)

    def manifolds(
        self,
        other: Shape,
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        max_pairs: int = 8,
        prediction: Optional[float] = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> PairManifolds:
        """Contact points of packs that can carry a body: up to four for each pair of hulls that touch.

        ``max_pairs`` is the maximum number of pairs for each pose; ``dropped`` counts those beyond it.
        ``prediction`` is a length, as in `ConvexShape.manifold`. Each shape that is not a pack counts as
        one hull.

        >>> import hullmap
        >>> unit = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        >>> moved = [[x + 3, y, z] for x, y, z in unit]
        >>> cubes = hullmap.bake_parts([(unit, None), (moved, None)])
        >>> floor = hullmap.HalfSpace([0, 0, 1], 0.0)
        >>> m = floor.manifolds(cubes, hullmap.poses([0, 0, -0.01]), max_pairs=3)
        >>> int(m.touching), m.parts.tolist()[:2], m.count.tolist()
        (2, [[0, 0], [0, 1]], [4, 4, 0])
        >>> m.depth[1].round(9)
        array([0.01, 0.01, 0.01, 0.01])
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        settings = settings_of(tolerance, max_iterations)
        length, most = length_of(prediction), pairs_of(max_pairs)
        found = _hullmap.manifolds((self._native, native(other)), poses, settings, length, most, coherent, threads)
        return PairManifolds._of_points(found, lead, most)

    def signed_distance(
        self,
        points: npt.ArrayLike,
        *,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> SignedDistance:
        """Distances of points from the surface: positive outside, negative inside.

        For a pack, it is the minimum over its hulls: outside, the distance from the union; inside, the
        depth in the hull in which the point is deepest. A ball of that radius around the point is
        inside the union, whose surface may be farther away where hulls overlap or touch.

        >>> import hullmap
        >>> hullmap.Box([1, 1, 1]).signed_distance([[3, 0, 0], [0.75, 0, 0]]).distance
        array([ 2.  , -0.25])
        """
        rows, lead = vectors("points", points)
        settings = settings_of(tolerance, max_iterations)
        found = _hullmap.signed_distance(self._native, rows, settings, coherent, threads)
        return SignedDistance._of(found, lead)


class _Solid(Shape):
    """A shape with a single manifold: everything but a `Pack`."""

    __slots__ = ()

    def manifold(
        self,
        other: Union[ConvexShape, HalfSpace],
        b_in_a: Poses = None,
        *,
        a_in_world: Poses = None,
        b_in_world: Poses = None,
        prediction: Optional[float] = None,
        tolerance: float = TOLERANCE,
        max_iterations: int = MAX_ITERATIONS,
        coherent: bool = False,
        threads: Optional[int] = None,
    ) -> Manifold:
        """Contact points that can carry a body: up to four for each pose.

        Surfaces that are separated by at most ``prediction`` also have points, of negative depth. It
        is a length; by default 2 % of the radius of the smaller shape.

        >>> import hullmap
        >>> floor, box = hullmap.HalfSpace([0, 0, 1], 0.0), hullmap.Box([1, 1, 1])
        >>> m = floor.manifold(box, hullmap.poses([[0, 0, 0.99], [0, 0, 2]]))
        >>> m.count
        array([4, 0], dtype=uint8)
        >>> m.depth[0].round(9)
        array([0.01, 0.01, 0.01, 0.01])
        """
        poses, lead = _poses(b_in_a, a_in_world, b_in_world)
        settings = settings_of(tolerance, max_iterations)
        length = length_of(prediction)
        found = _hullmap.manifold((self._native, native(other)), poses, settings, length, coherent, threads)
        return Manifold._of_points(found, lead)


class _Bounded(Shape):
    """A shape with support points: everything but a `HalfSpace`."""

    __slots__ = ()

    def support(self, directions: npt.ArrayLike, *, threads: Optional[int] = None) -> Support:
        """The farthest points of the shape in given directions, which need not be of unit length.

        >>> import hullmap
        >>> hullmap.Box([1, 2, 3]).support([[1, 1, 1], [-1, 1, 1]]).point
        array([[ 1.,  2.,  3.],
               [-1.,  2.,  3.]])
        """
        rows, lead = vectors("directions", directions)
        return Support._of(_hullmap.support(self._native, rows, threads), lead)


class ConvexShape(_Solid, _Bounded):
    """A bounded convex shape."""

    __slots__ = ()


def native(shape: Shape) -> _hullmap.Shape:
    if not isinstance(shape, Shape):
        raise ArrayError(
            f"expected a shape of hullmap, found {type(shape).__name__}: hullmap.bake makes one from vertices"
        )
    return shape._native


class Sphere(ConvexShape):
    """A ball about the origin."""

    __slots__ = ("radius",)

    def __init__(self, radius: float) -> None:
        self._native = _hullmap.Shape.sphere(radius)
        self.radius = float(radius)

    def __repr__(self) -> str:
        return f"Sphere({self.radius!r})"

    def __reduce__(self) -> Any:
        return (Sphere, (self.radius,))


class Box(ConvexShape):
    """A box about the origin, with edges along the axes."""

    __slots__ = ("half_edges",)

    def __init__(self, half_edges: npt.ArrayLike) -> None:
        self.half_edges = vector("half_edges", half_edges)
        self._native = _hullmap.Shape.cuboid(self.half_edges)

    def __repr__(self) -> str:
        return f"Box({self.half_edges!r})"

    def __reduce__(self) -> Any:
        return (Box, (self.half_edges,))


class Capsule(ConvexShape):
    """All points within a radius of the segment on the z axis from -half_length to half_length."""

    __slots__ = ("half_length", "radius")

    def __init__(self, half_length: float, radius: float) -> None:
        self._native = _hullmap.Shape.capsule(half_length, radius)
        self.half_length, self.radius = float(half_length), float(radius)

    def __repr__(self) -> str:
        return f"Capsule({self.half_length!r}, {self.radius!r})"

    def __reduce__(self) -> Any:
        return (Capsule, (self.half_length, self.radius))


class Cylinder(ConvexShape):
    """A cylinder about the origin, along z."""

    __slots__ = ("half_height", "radius")

    def __init__(self, half_height: float, radius: float) -> None:
        self._native = _hullmap.Shape.cylinder(half_height, radius)
        self.half_height, self.radius = float(half_height), float(radius)

    def __repr__(self) -> str:
        return f"Cylinder({self.half_height!r}, {self.radius!r})"

    def __reduce__(self) -> Any:
        return (Cylinder, (self.half_height, self.radius))


class Cone(ConvexShape):
    """A cone along z, its apex up, the origin halfway up."""

    __slots__ = ("half_height", "radius")

    def __init__(self, half_height: float, radius: float) -> None:
        self._native = _hullmap.Shape.cone(half_height, radius)
        self.half_height, self.radius = float(half_height), float(radius)

    def __repr__(self) -> str:
        return f"Cone({self.half_height!r}, {self.radius!r})"

    def __reduce__(self) -> Any:
        return (Cone, (self.half_height, self.radius))


class Segment(ConvexShape):
    """The segment between two points."""

    __slots__ = ("end", "start")

    def __init__(self, start: npt.ArrayLike, end: npt.ArrayLike) -> None:
        self.start, self.end = vector("start", start), vector("end", end)
        self._native = _hullmap.Shape.segment(self.start, self.end)

    def __repr__(self) -> str:
        return f"Segment({self.start!r}, {self.end!r})"

    def __reduce__(self) -> Any:
        return (Segment, (self.start, self.end))


class Triangle(ConvexShape):
    """The triangle between three points."""

    __slots__ = ("corners",)

    def __init__(self, a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike) -> None:
        self.corners = (vector("a", a), vector("b", b), vector("c", c))
        self._native = _hullmap.Shape.triangle(*self.corners)

    def __repr__(self) -> str:
        return f"Triangle{self.corners!r}"

    def __reduce__(self) -> Any:
        return (Triangle, self.corners)


class HalfSpace(_Solid):
    """Everything below a plane: the points p with ``normal @ p <= offset``, after ``normal`` is
    normalised. Two of them have no query; in `manifold`, it is the first shape."""

    __slots__ = ("normal", "offset")

    def __init__(self, normal: npt.ArrayLike, offset: float = 0.0) -> None:
        self.normal, self.offset = vector("normal", normal), float(offset)
        self._native = _hullmap.Shape.half_space(self.normal, self.offset)

    def __repr__(self) -> str:
        return f"HalfSpace({self.normal!r}, {self.offset!r})"

    def __reduce__(self) -> Any:
        return (HalfSpace, (self.normal, self.offset))


class Lists(Sequence[Counts]):
    """Lists of indices that differ in length, such as the corners of faces. Each is a read-only view
    of ``values``, without a copy.

    >>> import numpy as np, hullmap
    >>> cube = hullmap.bake([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])[0]
    >>> len(cube.faces), len(cube.faces[0]), len(cube.neighbours[7])
    (6, 4, 3)
    """

    __slots__ = ("starts", "values")

    starts: Counts
    """Start of each list in ``values``. The last one ends with ``values``."""
    values: Counts
    """All lists, one after the other."""

    def __init__(self, starts: Counts, values: Counts) -> None:
        self.starts, self.values = starts, values

    def __len__(self) -> int:
        return len(self.starts)

    @overload
    def __getitem__(self, index: int) -> Counts: ...

    @overload
    def __getitem__(self, index: slice) -> List[Counts]: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Counts, List[Counts]]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        count = len(self.starts)
        place = index + count if index < 0 else index
        if not 0 <= place < count:
            raise IndexError(f"index {index} is out of range: there are {count} lists, counted from 0")
        end = self.starts[place + 1] if place + 1 < count else len(self.values)
        return self.values[self.starts[place] : end]

    @property
    def lengths(self) -> npt.NDArray[np.int64]:
        """Length of each list."""
        return np.diff(np.append(self.starts.astype(np.int64), len(self.values)))

    def __repr__(self) -> str:
        return f"Lists({len(self)} lists of {len(self.values)} indices)"


class Hull(ConvexShape):
    """A convex hull of a pack.

    Its arrays are read-only views of the pack's memory, without a copy, and keep it alive. Points
    and lengths are in the frame and unit of the mesh.
    """

    __slots__ = ("_facts", "_hull", "pack")

    pack: Pack
    """The pack that the hull is from."""

    def __init__(self, pack: Pack, hull: _hullmap.Hull) -> None:
        self.pack, self._hull, self._native = pack, hull, hull.shape()
        self._facts = hull.facts()

    @property
    def name(self) -> str:
        """Name of the object in the mesh file, or the name passed to `bake`."""
        return self._hull.name

    @property
    def index(self) -> int:
        """Index in the pack, from 0."""
        return self._hull.index

    @property
    def vertices(self) -> npt.NDArray[np.float32]:
        """Positions of the vertices; (V, 3)."""
        array: npt.NDArray[np.float32] = self._hull.array("vertices")
        return array

    @property
    def source_vertices(self) -> Counts:
        """For each vertex its index in the mesh; 4294967295 for a vertex that the bake created."""
        return self._flat("source_vertices")

    @property
    def faces(self) -> Lists:
        """Corners of each face, counter-clockwise seen from outside. Faces are maximal flat polygons,
        not triangles."""
        return Lists(self._flat("face_starts"), self._flat("face_vertices"))

    @property
    def neighbours(self) -> Lists:
        """For each vertex, the vertices at the other ends of its edges, ascending."""
        return Lists(self._flat("neighbour_starts"), self._flat("neighbours"))

    @property
    def triangles(self) -> npt.NDArray[np.int64]:
        """The faces cut into triangles; (T, 3). A copy.

        >>> import hullmap
        >>> cube = hullmap.bake([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])[0]
        >>> cube.triangles.shape
        (12, 3)
        """
        faces = self.faces
        lengths = faces.lengths
        counts = np.maximum(lengths - 2, 0)
        first = np.repeat(faces.starts.astype(np.int64), counts)
        step = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
        corners = np.stack((first, first + step + 1, first + step + 2), axis=-1)
        triangles: npt.NDArray[np.int64] = faces.values[corners].astype(np.int64)
        return triangles

    def _flat(self, name: str) -> Counts:
        array: Counts = self._hull.array(name)
        return array.reshape(-1)

    @property
    def rank(self) -> int:
        """Dimension: 3 for a solid, 2 for a flat polygon, 1 for a segment, 0 for a point."""
        return int(self._facts["rank"])

    @property
    def volume(self) -> float:
        """Volume; 0 for a hull of rank below 3."""
        return float(self._facts["volume"])

    @property
    def surface_area(self) -> float:
        """Area of all faces."""
        return float(self._facts["surface_area"])

    @property
    def diameter(self) -> float:
        """Largest distance of two vertices."""
        return float(self._facts["diameter"])

    @property
    def centroid(self) -> Floats:
        """Centre of mass at uniform density; (3,)."""
        return floats("centroid", self._facts["centroid"])

    @property
    def inertia(self) -> Floats:
        """Inertia tensor about the centroid at density 1; (3, 3)."""
        return floats("inertia", self._facts["inertia"])

    @property
    def bounds(self) -> Floats:
        """Lowest and highest corner of the axis-aligned box; (2, 3)."""
        return floats("bounds", self._facts["bounds"])

    @property
    def origin(self) -> Floats:
        """Origin of the hull's frame in the frame of the mesh, with the option ``recentre``."""
        return floats("origin", self._facts["origin"])

    @property
    def part(self) -> int:
        """Index among the convex parts of a decomposed mesh."""
        return int(self._facts["part"])

    @property
    def containment_error(self) -> float:
        """Largest distance of a source point outside the hull, relative to the diameter."""
        return float(self._facts["containment_error"])

    @property
    def outer_error(self) -> float:
        """For a simplified hull: largest distance by which it exceeds the exact hull."""
        return float(self._facts["outer_error"])

    @property
    def part_count(self) -> int:
        """Number of convex parts of the mesh; 0 for a hull that is not a part."""
        return int(self._facts["part_count"])

    @property
    def solid(self) -> Optional[str]:
        """Kind of solid that a part was measured against: ``watertight``, ``closed`` (holes were
        closed) or ``walls`` (its triangles alone); ``None`` if the part was not measured."""
        found: Optional[str] = self._facts["solid"]
        return found

    @property
    def uncovered(self) -> Optional[float]:
        """For a part: bound on how far a point of the mesh's surface lies outside all parts.
        ``None`` if that was not measured."""
        found: Optional[float] = self._facts["uncovered"]
        return found

    @property
    def protrusion(self) -> Optional[float]:
        """For a part: bound on how far a point of it lies outside the mesh's solid. ``None`` if that
        was not measured."""
        found: Optional[float] = self._facts["protrusion"]
        return found

    @property
    def protrusion_at(self) -> Optional[Floats]:
        """For a part: the point of it that protrudes most; (3,)."""
        at = self._facts["protrusion_at"]
        return None if at is None else floats("protrusion_at", at)

    @property
    def voids(self) -> Optional[Tuple[float, float]]:
        """For a part: the share of the mesh's solid that is in no part, from 0 to 1, and its error.
        All parts of an object have the same. ``None`` if the pack does not record it."""
        found: Optional[Tuple[float, float]] = self._facts["voids"]
        return found

    @property
    def primitive(self) -> Optional[Primitive]:
        """For a part: the box, sphere, capsule or cylinder that may replace it. ``None`` if there is
        none, or the pack was baked without ``primitives``."""
        found = self._facts["primitive"]
        if found is None:
            return None
        kind, center, rotation, sizes, protrusion = found
        return Primitive(kind, tuple(center), tuple(rotation), tuple(sizes), protrusion)

    @property
    def index_kind(self) -> str:
        """Kind of the direction index."""
        return str(self._facts["index_kind"])

    def mass_properties(self, density: float = 1.0) -> MassProperties:
        """Mass, centre of mass and inertia tensor of the hull at this density."""
        return MassProperties(density * self.volume, self.centroid, density * self.inertia)

    def mesh_mass_properties(self, density: float = 1.0) -> Optional[MassProperties]:
        """Mass, centre of mass and inertia tensor of the mesh that the hull, or the part, was baked
        from. ``None`` if the pack does not record them: the mesh is not watertight, or there is none."""
        mesh = self._facts["mesh"]
        if mesh is None:
            return None
        volume, center, inertia, source = mesh
        return MassProperties(density * volume, floats("center", center), density * floats("inertia", inertia), source)

    def __len__(self) -> int:
        return len(self.vertices)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Hull) and self.pack is other.pack and self.index == other.index

    def __hash__(self) -> int:
        return hash((id(self.pack), self.index))

    def __repr__(self) -> str:
        return f"<Hull {self.name!r}: {len(self)} vertices, {len(self.faces)} faces, rank {self.rank}>"

    def __reduce__(self) -> Any:
        return (_hull_of, (self.pack, self.index))


def _hull_of(pack: Pack, index: int) -> Hull:
    return pack[index]


class Pack(_Bounded, Sequence[Hull]):
    """A pack: one or more hulls. As a shape, it is the union of its hulls.

    >>> import hullmap
    >>> pack = hullmap.bake([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], name="corner")
    >>> len(pack), pack[0].name, pack["corner"].rank, [hull.name for hull in pack]
    (1, 'corner', 3, ['corner'])
    """

    __slots__ = ("_pack",)

    def __init__(self, pack: _hullmap.Pack) -> None:
        self._pack, self._native = pack, pack.shape()

    def __len__(self) -> int:
        return len(self._pack)

    @overload
    def __getitem__(self, key: Union[int, str]) -> Hull: ...

    @overload
    def __getitem__(self, key: slice) -> List[Hull]: ...

    def __getitem__(self, key: Union[int, str, slice]) -> Union[Hull, List[Hull]]:
        if isinstance(key, str):
            return Hull(self, self._pack.hull_named(key))
        if isinstance(key, slice):
            return [self[i] for i in range(*key.indices(len(self)))]
        count = len(self)
        place = key + count if key < 0 else key
        if not 0 <= place < count:
            hulls = "1 hull" if count == 1 else f"{count} hulls"
            raise IndexError(f"hull index {key} is out of range: the pack has {hulls}, counted from 0")
        return Hull(self, self._pack.hull(place))

    def __iter__(self) -> Iterator[Hull]:
        return (self[index] for index in range(len(self)))

    def __contains__(self, key: object) -> bool:
        return key in self.names if isinstance(key, str) else isinstance(key, Hull) and key.pack is self

    @property
    def names(self) -> List[str]:
        """Names of the hulls, in order."""
        return self._pack.names()

    @property
    def notes(self) -> List[str]:
        """Remarks of the bake that require no action; empty for a pack that was opened."""
        return self._pack.notes

    @property
    def path(self) -> Optional[Path]:
        """File that the pack was opened from."""
        path = self._pack.path
        return None if path is None else Path(path)

    @property
    def source_path(self) -> str:
        """Path of the mesh, as recorded; empty if it was baked from arrays."""
        return self._pack.source_path

    @property
    def options(self) -> str:
        """Options of the bake, as recorded."""
        return self._pack.options

    @property
    def nbytes(self) -> int:
        """Size of the file in bytes."""
        return self._pack.byte_len

    def mass_properties(self, density: float = 1.0) -> MassProperties:
        """Mass properties of all hulls as one rigid body at this density.

        Each object has the mass of its mesh, where the pack records it: convex parts protrude, so the
        sum of their masses is too large. ``source`` is ``mesh`` if that holds for all objects.

        >>> import hullmap
        >>> corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> pack = hullmap.bake(corner, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> body = pack.mass_properties(density=6000.0)
        >>> round(body.mass), body.source
        (1000, 'mesh')
        """
        return self._mass_of(range(len(self)), density)

    def _mass_of(self, hulls: Sequence[int], density: float) -> MassProperties:
        mass, center, inertia, source = self._pack.mass_properties(list(hulls), density)
        return MassProperties(mass, floats("center", center), floats("inertia", inertia), source)

    def to_bytes(self) -> bytes:
        """A copy of the bytes of the file."""
        return self._pack.bytes()

    def save(self, path: FilePath) -> Path:
        """Writes the pack to a file, and returns its path. The file is complete or absent at every
        moment: it is written beside ``path`` first, and renamed. Open packs of the old file keep it.
        """
        return write_file(path, self.to_bytes())

    def check(self) -> None:
        """Compares the data that the file holds twice, as ``verify`` does. Raises `InvalidPack` if
        they differ. No query requires it."""
        self._pack.check_repeats()

    def __repr__(self) -> str:
        return f"<Pack of {len(self)} hulls, {self.nbytes} bytes>"

    def __reduce__(self) -> Any:
        return (from_bytes, (self.to_bytes(),))


def write_file(path: FilePath, data: bytes) -> Path:
    """Writes a file that is complete or absent at every moment."""
    target = Path(os.fsdecode(path))
    # Shorter than the longest name that a file system allows, as the name of the file may be.
    handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:50]}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        # Temporary files are private; a pack has the permissions of any new file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise
    return target


def from_bytes(data: Union[bytes, bytearray, memoryview]) -> Pack:
    """A pack from the bytes of a file, which are copied and checked.

    >>> import hullmap
    >>> pack = hullmap.bake([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> hullmap.from_bytes(pack.to_bytes())[0].volume == pack[0].volume
    True
    """
    return Pack(_hullmap.Pack.from_bytes(bytes(data)))
