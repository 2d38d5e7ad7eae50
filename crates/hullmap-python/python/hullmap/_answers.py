"""Answers: a class for each query, with an array for each field.

Made from hullmap.h by crates/hullmap-c/header: do not edit."""

from __future__ import annotations

from dataclasses import dataclass

from ._arrays import Counts, Floats
from ._results import Codes, Flags, _Answer, _Words


class Status(_Words):
    """How a distance or contact query ended, and thus how narrow its interval is. The interval
    contains the true value whatever the status is."""

    EXACT = 0
    """The interval is as narrow as rounding error allows."""
    WITHIN = 1
    """The interval is within ``tolerance``."""
    TOUCHING = 2
    """The shapes touch: rounding error leaves open whether they overlap. A gap or a penetration is at
    most 64 rounding errors: docs/contributors/intervals.md, section 6, states them. For baked hulls
    near the origin, that is 1e-10 of the sum of their outer radii."""
    OVERLAPPING = 3
    """The shapes overlap: their distance is 0, or a ray or a motion starts so."""
    SEPARATED = 4
    """Certainly no contact, or no hit of a ray or a motion: a separating plane proves it."""
    ITERATION_LIMIT = 5
    """The iteration limit was reached; the interval is wider than the tolerance, or the witness points
    are less accurate than the interval."""
    STALLED = 6
    """Rounding error stopped all progress; the interval is wider than the tolerance, or the witness
    points are less accurate than the interval."""


class Overlap(_Words):
    """Whether two shapes share a point."""

    SEPARATED = 0
    """They share no point: a separating plane proves it. Any other status counts as a hit."""
    OVERLAPPING = 1
    """Their interiors share points."""
    TOUCHING = 2
    """They touch, as `Status.TOUCHING` defines it."""
    UNDECIDED = 3
    """Not known: an iteration limit was reached, or rounding error stopped all progress."""


class Verdict(_Words):
    """Whether a motion is certainly free."""

    FREE = 0
    """The bodies are certainly farther apart than the margin at all times."""
    HIT = 1
    """They are certainly within the margin at some time."""
    OPEN = 2
    """Neither is known: they graze the margin within rounding error, or the limit of queries was
    reached."""


class Differentiability(_Words):
    """Whether a length or a time has a derivative, or the reason why it has none."""

    UNIQUE = 0
    """There is one pair of points and one normal within the interval of the answer."""
    TOUCHING = 1
    """The shapes touch, or it is not certain that they do not: distance and depth have a kink at 0."""
    PARALLEL = 2
    """Faces or edges are parallel within the interval, so several pairs of points have the same
    distance: a rotation moves each of them differently."""
    NORMALS = 3
    """Several normals have the same depth within the interval, or a line meets a vertex or an edge."""
    GRAZING = 4
    """A ray or a motion is parallel to the surface that it meets, within rounding error."""
    MISSING = 5
    """There is nothing to differentiate: no hit, an overlap at the start of a motion, or the depth of
    a separated pair."""
    INACCURATE = 6
    """The answer is less accurate than its settings require."""
    FEATURE = 7
    """Only of normals and points: a point is on the border of its face or edge, or the normal is on
    the border of the normals of its edge or vertex, within the interval. Other features are nearest
    beyond."""
    CURVED = 8
    """Only of normals and points: the shape is curved there, and no feature describes how."""


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(_Answer):
    """Answer of `intersects`."""

    hit: Flags
    """True unless the shapes are certainly separated: touching and undecided pairs count as hits."""
    status: Codes
    """Whether the shapes share a point. Codes of `Overlap`."""
    iterations: Counts
    """Number of steps of all phases together."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a mesh
    or a field. 0 for a shape without parts. (..., 2)"""


@dataclass(frozen=True, eq=False, repr=False)
class Distance(_Answer):
    """Answer of `distance`: the distance of a pair and the witness points that realise it. Lengths are
    in the shapes' unit, points and directions in A's frame. The interval from ``lower`` to
    ``upper`` always contains the distance."""

    status: Codes
    """How the query ended, and thus how narrow the interval is. Codes of `Status`."""
    distance: Floats
    """Length of the segment from ``point_a`` to ``point_b``; 0 if the shapes overlap or touch."""
    lower: Floats
    """Lower bound of the distance, at least 0, with allowance for rounding error."""
    upper: Floats
    """Upper bound of the distance, with allowance for rounding error."""
    normal: Floats
    """Unit vector from A to B: the normal of the planes that prove ``lower``. It is the direction of
    the shortest segment within the tolerance. (..., 3)"""
    point_a: Floats
    """Witness point: the point of A closest to B. If the shapes overlap, a common point. (..., 3)"""
    point_b: Floats
    """Witness point: the point of B closest to A. If the shapes overlap, a common point. (..., 3)"""
    iterations: Counts
    """Number of steps of the search."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a mesh
    or a field. 0 for a shape without parts. (..., 2)"""


@dataclass(frozen=True, eq=False, repr=False)
class Contact(_Answer):
    """Answer of `contact`: penetration depth, normal and witness points of a pair. Lengths are in the
    shapes' unit, points and directions in A's frame. If rounding error or a limit stopped the
    search, ``status`` says so; the interval from ``depth_lower`` to ``depth_upper`` always contains
    the depth."""

    hit: Flags
    """False only if a separating plane proves the shapes separated."""
    status: Codes
    """How the query ended, and thus how narrow the interval is. Codes of `Status`."""
    depth: Floats
    """Penetration depth: moving B by this length along ``normal`` makes the shapes touch. 0 if they
    are separated or touch."""
    depth_lower: Floats
    """Lower bound of the penetration depth, at least 0, with allowance for rounding error."""
    depth_upper: Floats
    """Upper bound of the penetration depth, with allowance for rounding error."""
    normal: Floats
    """Unit vector from A to B. If two convex shapes are separated, a separating axis. If parts are
    separated, the normal and the points are NaN: one axis may not separate them all. (..., 3)"""
    point_a: Floats
    """Witness point: the point of A that is deepest in B. If the shapes are separated, some point of
    A; `distance` computes the closest one. (..., 3)"""
    point_b: Floats
    """Witness point: the point of B that is deepest in A. If the shapes are separated, some point of
    B. (..., 3)"""
    iterations: Counts
    """Number of steps of all phases together."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a mesh
    or a field. 0 for a shape without parts. (..., 2)"""


@dataclass(frozen=True, eq=False, repr=False)
class RayHit(_Answer):
    """Answer of `ray`: where a ray first enters a shape. Points and directions are in the shape's
    frame. t is a factor of the ray's direction, which need not be of unit length."""

    hit: Flags
    """False only if it is certain that the ray misses the shape up to ``max_t``."""
    status: Codes
    """How the query ended. Codes of `Status`."""
    t: Floats
    """The ray enters the shape at `origin + t direction`; infinite if there is no hit."""
    t_lower: Floats
    """Lower bound of t, at least 0, with allowance for rounding error."""
    t_upper: Floats
    """Upper bound of t, with allowance for rounding error. It may exceed ``max_t`` if the interval
    does."""
    point: Floats
    """The point at t. If the ray grazes the shape, the point need not be on the shape. The origin if
    there is no hit. (..., 3)"""
    normal: Floats
    """Unit outward normal of a support plane of the shape, which the ray crosses at ``t_lower``. On a
    polytope, it is the normal of the face at the point. If there is no hit, normal of a plane that
    takes part in the proof. (..., 3)"""
    iterations: Counts
    """Number of steps of the search."""
    support_calls: Counts
    """Number of support calls."""
    part: Counts
    """Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    field. 0 for a shape without parts."""


@dataclass(frozen=True, eq=False, repr=False)
class Impact(_Answer):
    """Answer of `cast`: when and where a moving shape first meets another. Points and directions are
    in A's frame. Times are in the unit that the velocity implies: at time t, B has moved by t times
    its velocity."""

    hit: Flags
    """False only if it is certain that the shapes do not meet up to ``max_t``."""
    status: Codes
    """How the query ended. Codes of `Status`."""
    t: Floats
    """Time of impact; infinite if there is no hit."""
    t_lower: Floats
    """Lower bound of the time of impact, at least 0, with allowance for rounding error. Until then the
    shapes certainly do not overlap."""
    t_upper: Floats
    """Upper bound of the time of impact, with allowance for rounding error. It may exceed ``max_t`` if
    the interval does."""
    normal: Floats
    """Unit vector from A to B: normal of a plane that separates the shapes until ``t_lower``. If there
    is no hit, normal of a plane that takes part in the proof. (..., 3)"""
    point_a: Floats
    """Point of A at which the shapes meet. If they overlap at the start, a common point. Zero if there
    is no hit. (..., 3)"""
    point_b: Floats
    """Point of B at which the shapes meet, at time ``t``. (..., 3)"""
    iterations: Counts
    """Number of steps of the search."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a mesh
    or a field. 0 for a shape without parts. (..., 2)"""


@dataclass(frozen=True, eq=False, repr=False)
class SignedDistance(_Answer):
    """Answer of `signed_distance`. Lengths are in the shape's unit, points and directions in its
    frame."""

    status: Codes
    """How the query ended. `Status.SEPARATED` and `Status.OVERLAPPING` do not occur: the sign of the
    distance gives that information. Codes of `Status`."""
    distance: Floats
    """Distance from the surface: positive outside, negative inside."""
    lower: Floats
    """Lower bound of the distance, with allowance for rounding error. Positive only if the point is
    certainly outside."""
    upper: Floats
    """Upper bound of the distance, with allowance for rounding error. Negative only if the point is
    certainly inside."""
    point: Floats
    """The point of the surface that is closest to the query point. (..., 3)"""
    normal: Floats
    """Unit outward normal of the surface at ``point``: the gradient of the distance. (..., 3)"""
    iterations: Counts
    """Number of steps of all phases together."""
    support_calls: Counts
    """Number of support calls."""
    part: Counts
    """Index of the part that decided the answer: the hull of a pack, the triangle of a mesh or a
    field. 0 for a shape without parts."""


@dataclass(frozen=True, eq=False, repr=False)
class TimeOfImpact(_Answer):
    """Answer of `cast_motion`: when and where two moving shapes first meet. Points and directions are
    in the common frame of the motions."""

    hit: Flags
    """False only if it is certain that the shapes do not meet until time 1."""
    status: Codes
    """How the query ended. Codes of `Status`."""
    t: Floats
    """Time of impact, between 0 and 1; infinite if there is no hit."""
    t_lower: Floats
    """Lower bound of the time of impact, with allowance for rounding error. Until then the shapes are
    certainly farther apart than the target distance."""
    t_upper: Floats
    """Upper bound: at this time the shapes are certainly within the target distance. Infinite if no
    such time was found."""
    normal: Floats
    """Unit vector from A to B at ``t_lower``: normal of a plane that separates the shapes then.
    (..., 3)"""
    point_a: Floats
    """Point of A closest to B at ``t_lower``. (..., 3)"""
    point_b: Floats
    """Point of B closest to A at ``t_lower``. (..., 3)"""
    iterations: Counts
    """Number of distance and contact queries."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that decided the answer, by index: hulls of a pack, triangles of a mesh
    or a field. 0 for a shape without parts. (..., 2)"""


@dataclass(frozen=True, eq=False, repr=False)
class Clearance(_Answer):
    """Answer of `clear`: whether a motion is free, and with which clearance."""

    verdict: Codes
    """Whether the motion is free. Codes of `Verdict`."""
    status: Codes
    """How the search ended. Codes of `Status`."""
    clearance: Floats
    """Lower bound of the least distance during a free motion, with allowance for rounding error. 0 if
    it is not known to be free."""
    nearest: Floats
    """Upper bound of the least distance: the bodies are this near at some time that was tried. It is
    infinite if no parts were near enough to be tried."""
    t_lower: Floats
    """Until this time, the bodies are certainly farther apart than the margin. Infinite if they are at
    all times."""
    t_upper: Floats
    """At this time, the bodies are certainly within the margin. Infinite if no such time is known."""
    iterations: Counts
    """Number of distance and contact queries."""
    support_calls: Counts
    """Number of support calls. One call queries both shapes once."""
    parts: Counts
    """The parts of A and of B that meet first if the motion hits, by index: hulls of a pack, triangles
    of a mesh or a field. 0 otherwise, and for a shape without parts. (..., 2)"""
