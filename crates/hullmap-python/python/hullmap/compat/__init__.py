"""Interfaces of other libraries for convex decomposition, on top of hullmap's, for programs that change
over: `hullmap.compat.coacd` has the names, arguments and return values of CoACD 1.0.14. A program changes
its import and nothing else. The results are hullmap's: parts that contain the whole surface of the mesh,
with a proven bound on how far they protrude, the same on every machine. ``docs/baking.md`` compares them
with the results of CoACD and V-HACD.
"""

from __future__ import annotations

from . import coacd

__all__ = ["coacd"]
