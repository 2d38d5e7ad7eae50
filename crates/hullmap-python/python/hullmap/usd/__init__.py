"""Collision hulls for stages of Universal Scene Description (USD): `bake` writes a layer over an asset.

>>> import hullmap.usd                                                  # doctest: +SKIP
>>> report = hullmap.usd.bake("chair.usd", "chair_physics.usda", decompose=True, max_error="2mm")  # doctest: +SKIP
>>> [(prim.path, prim.parts, prim.protrusion) for prim in report.prims]  # doctest: +SKIP
[('/World/chair/seat', 4, 0.0017)]

The layer has the asset as its sublayer: open it in place of the asset. The asset is not touched, and its
prims keep every opinion except ``physics:collisionEnabled`` of the colliders that are replaced. It
requires OpenUSD's Python modules: ``pip install usd-core``. ``docs/usd.md`` in the repository is the guide.
"""

from __future__ import annotations

from ._bake import bake
from ._report import BakedPrim, Report, SkippedPrim

__all__ = ["BakedPrim", "Report", "SkippedPrim", "bake"]
