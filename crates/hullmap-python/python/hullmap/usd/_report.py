"""Report of the bake of a stage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple


@dataclass(frozen=True)
class BakedPrim:
    """A mesh that has hulls. Lengths are in metres and masses in kilograms, at the scale of the stage."""

    path: str
    """The mesh; for a mesh in instances, the prim that they share."""
    hulls: str
    """The group of its hulls."""
    bake: int
    """Index of its bake. Meshes with the same bake have the same points, faces and options."""
    parts: int
    """Number of hulls."""
    vertices: int
    """Number of their vertices."""
    protrusion: Optional[float]
    """Bound on how far a hull protrudes from the mesh's solid; `None` if it was not decomposed."""
    uncovered: Optional[float]
    """Bound on how far a point of the mesh lies outside all hulls; `None` if it was not decomposed."""
    mass: Optional[float]
    """Mass of its hulls together; `None` if the layer states none."""
    instances: int
    """Number of instances that share the mesh; 0 if it is in none."""
    notes: Tuple[str, ...]
    """Findings of interest."""


@dataclass(frozen=True)
class SkippedPrim:
    """A mesh without hulls."""

    path: str
    reason: str


@dataclass(frozen=True)
class Report:
    """Report of `hullmap.usd.bake`."""

    text: str
    """The layer, as the text of a ``.usda`` file."""
    path: Optional[str]
    """The file that was written, if one was."""
    prims: Tuple[BakedPrim, ...]
    """Meshes that have hulls, in the order of the stage."""
    skipped: Tuple[SkippedPrim, ...]
    """Meshes without hulls, with the reason."""
    bakes: int
    """Number of bakes: of distinct meshes and options."""
    off: Tuple[str, ...]
    """Colliders that the layer switches off."""
