"""Settings of a collider that its hulls take over: material, contact parameters of engines, filters.

The hulls are prims of their own, so that they would lose what the source's collider states. The settings
are copied by OpenUSD's own classes into the layer that `bake export` wrote.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Tuple

from .._hullmap import BakeError
from ._stage import pxr

# Namespaces of engines' attributes of colliders.
_NAMESPACES = ("physxCollision", "newton", "mjc")
_SCHEMAS = ("PhysxCollisionAPI", "NewtonCollisionAPI", "MjcCollisionAPI", "PhysicsFilteredPairsAPI")
_RELATIONSHIPS = ("physics:filteredPairs", "physics:simulationOwner")
# Limits that the layer states itself.
LIMITS = ("newton:maxHullVertices", "mjc:maxhullvert", "physxConvexHullCollision:hullVertexLimit")
# Relationships that name colliders.
_NAMING = ("physics:filteredPairs", "collection:colliders:includes", "collection:colliders:excludes")


@dataclass
class Settings:
    """Settings of one collider."""

    schemas: List[str] = field(default_factory=list)
    attributes: List[Any] = field(default_factory=list)
    relationships: Dict[str, List[Any]] = field(default_factory=dict)
    named_by: List[Tuple[Any, str]] = field(default_factory=list)
    """Prims and relationships that name the collider."""

    def __bool__(self) -> bool:
        return bool(self.schemas or self.attributes or self.relationships or self.named_by)


def named(stage: Any) -> Dict[str, List[Tuple[Any, str]]]:
    """By path of a collider: prims and relationships that name it."""
    found: Dict[str, List[Tuple[Any, str]]] = {}
    for prim in stage.Traverse():
        for name in _NAMING:
            relationship = prim.GetRelationship(name)
            for target in relationship.GetTargets() if relationship else []:
                found.setdefault(str(target), []).append((prim.GetPath(), name))
    return found


def settings(prim: Any, named_by: List[Tuple[Any, str]]) -> Settings:
    """The settings of a collider."""
    shade = pxr("UsdShade")
    found = Settings(named_by=named_by)
    for attribute in prim.GetAuthoredAttributes():
        name = attribute.GetName()
        if name.split(":")[0] in _NAMESPACES and name not in LIMITS and attribute.Get() is not None:
            found.attributes.append(attribute)
    found.schemas = [schema for schema in prim.GetPrimTypeInfo().GetAppliedAPISchemas() if schema in _SCHEMAS]
    for name in _RELATIONSHIPS:
        relationship = prim.GetRelationship(name)
        if relationship and relationship.GetTargets():
            found.relationships[name] = relationship.GetTargets()
    material, _ = shade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    # Without a material for physics, the drawn one is found.
    if material and material.GetPrim().HasAPI(pxr("UsdPhysics").MaterialAPI):
        found.relationships["material:binding:physics"] = [material.GetPath()]
        found.schemas.append("MaterialBindingAPI")
    return found


def copied(text: str, groups: List[Tuple[str, int, Settings]]) -> str:
    """The layer, with settings for the hulls of groups: path, number of hulls, settings. The text stays as it
    is if there are none."""
    sdf = pxr("Sdf")
    layer = sdf.Layer.CreateAnonymous(".usda")
    if not layer.ImportFromString(text):
        raise BakeError("OpenUSD does not read the layer: please report it, with the stage")
    if not any(own for _, _, own in groups):
        return text
    for path, count, own in groups:
        hulls = [f"{path}/hull_{index:02}" for index in range(count)]
        for hull in hulls:
            spec = layer.GetPrimAtPath(hull)
            _copy(sdf, spec, own)
        for prim, name in own.named_by:
            spec = sdf.CreatePrimInLayer(layer, prim)
            _relate(sdf, spec, name, [sdf.Path(hull) for hull in hulls])
    result: str = layer.ExportToString()
    return result


def _copy(sdf: Any, spec: Any, own: Settings) -> None:
    schemas = spec.GetInfo("apiSchemas")
    known = list(schemas.prependedItems)
    schemas.prependedItems = known + [schema for schema in own.schemas if schema not in known]
    spec.SetInfo("apiSchemas", schemas)
    for attribute in own.attributes:
        made = sdf.AttributeSpec(spec, attribute.GetName(), attribute.GetTypeName(), attribute.GetVariability())
        made.default = attribute.Get()
    for name, targets in own.relationships.items():
        _relate(sdf, spec, name, targets)


def _relate(sdf: Any, spec: Any, name: str, targets: List[Any]) -> None:
    made = spec.relationships.get(name) or sdf.RelationshipSpec(spec, name, False)
    for target in targets:
        made.targetPathList.Prepend(target)
