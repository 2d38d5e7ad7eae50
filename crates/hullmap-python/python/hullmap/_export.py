"""Ways in and out: trimesh, MuJoCo's MJCF, URDF."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Union
from xml.sax.saxutils import quoteattr

import numpy as np

from ._bake import bake, bake_parts
from ._hullmap import ArrayError, Error
from ._options import BakeOptions
from ._progress import Progress
from ._results import MassProperties, Primitive
from ._shapes import Hull, Pack

if TYPE_CHECKING:
    import trimesh
    from typing_extensions import Unpack


def _hulls(shape: Union[Hull, Pack]) -> List[Hull]:
    if isinstance(shape, Hull):
        return [shape]
    if isinstance(shape, Pack):
        return list(shape)
    raise ArrayError(f"expected a hull or a pack, found {type(shape).__name__}")


def _import_trimesh() -> Any:
    try:
        import trimesh
    except ImportError as error:
        raise Error(f"this requires trimesh ({error}): install it with `pip install trimesh`") from None
    return trimesh


def to_trimesh(shape: Union[Hull, Pack]) -> trimesh.Trimesh:
    """The surface of a hull as a ``trimesh.Trimesh``; of a pack, the surfaces of all hulls. A copy."""
    module = _import_trimesh()
    hulls = _hulls(shape)
    starts = np.cumsum([0] + [len(hull) for hull in hulls])
    vertices = np.concatenate([hull.vertices for hull in hulls]).astype(np.float64)
    faces = np.concatenate([hull.triangles + start for hull, start in zip(hulls, starts)])
    mesh: trimesh.Trimesh = module.Trimesh(vertices=vertices, faces=faces, process=False)
    return mesh


def from_trimesh(
    mesh: Any,
    *,
    name: str = "mesh",
    threads: Optional[int] = None,
    progress: Progress = None,
    **options: Unpack[BakeOptions],
) -> Pack:
    """Bakes a ``trimesh.Trimesh``, ``PointCloud`` or ``Scene``; each geometry of a scene becomes a
    hull. The options are the same as for `bake`."""
    module = _import_trimesh()
    if isinstance(mesh, module.Scene):
        parts, names = [], []
        for node in mesh.graph.nodes_geometry:
            matrix, geometry = mesh.graph[node]
            own = mesh.geometry[geometry]
            points = module.transform_points(np.asarray(own.vertices), matrix)
            parts.append((points, getattr(own, "faces", None)))
            names.append(str(node))
        return bake_parts(parts, names=names, name=name, threads=threads, progress=progress, **options)
    if not hasattr(mesh, "vertices"):
        raise ArrayError(f"expected a mesh, a point cloud or a scene of trimesh, found {type(mesh).__name__}")
    faces = getattr(mesh, "faces", None)
    return bake(np.asarray(mesh.vertices), faces, name=name, threads=threads, progress=progress, **options)


def _numbers(array: Any) -> str:
    """Numbers that read back as the same 32-bit or 64-bit floats."""
    return " ".join(np.format_float_positional(x, unique=True, trim="-") for x in np.ravel(array))


def _mass(shape: Union[Hull, Pack], density: float) -> MassProperties:
    """Mass properties of a hull or a pack as one body."""
    if isinstance(shape, Hull):
        return shape.pack._mass_of([shape.index], density)
    return shape.mass_properties(density)


def to_mjcf(shape: Union[Hull, Pack], name: str = "hull", *, density: float = 1000.0) -> str:
    """A MuJoCo model (MJCF) with one body: a mesh geom for each hull, with its vertices in the text. A hull
    that a primitive may replace (see `Hull.primitive`) is a geom of that kind.

    ``mujoco.MjModel.from_xml_string`` loads it, and MuJoCo's ``MjSpec`` attaches it to other models.
    MuJoCo builds the hull of the vertices again.

    The inertial element describes the mesh at uniform ``density`` if the pack records its mass
    properties, and otherwise the hulls: see `Pack.mass_properties`.

    >>> import hullmap
    >>> corner = hullmap.bake([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], name="corner")
    >>> print(hullmap.to_mjcf(corner, "body"))  # doctest: +ELLIPSIS
    <mujoco model="body">
      <asset>
        <mesh name="body_corner" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
      </asset>
      <worldbody>
        <body name="body">
          <inertial pos="0.25 0.25 0.25" mass="166.66..." fullinertia="12.5..."/>
          <geom type="mesh" mesh="body_corner"/>
        </body>
      </worldbody>
    </mujoco>
    """
    assets, geoms = [], []
    for hull in _hulls(shape):
        if hull.rank < 3:
            raise ArrayError(f"hull {hull.name}: MuJoCo requires a solid, but this hull is flat: leave it out")
        if hull.primitive is not None:
            geoms.append(f"      <geom {_geom(hull.primitive)}/>")
            continue
        own = quoteattr(f"{name}_{hull.name}")
        assets.append(f'    <mesh name={own} vertex="{_numbers(hull.vertices)}"/>')
        geoms.append(f'      <geom type="mesh" mesh={own}/>')
    lines = [f"<mujoco model={quoteattr(name)}>", "  <asset>", *assets, "  </asset>", "  <worldbody>"]
    mass = _mass(shape, density)
    keys = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    inertia = " ".join(repr(float(mass.inertia[at])) for at in keys)
    inertial = f'pos="{_numbers(mass.center_of_mass)}" mass="{mass.mass!r}" fullinertia="{inertia}"'
    lines += [f"    <body name={quoteattr(name)}>", f"      <inertial {inertial}/>", *geoms, "    </body>", "  </worldbody>", "</mujoco>"]
    return "\n".join(lines)


def to_urdf(
    shape: Union[Hull, Pack],
    folder: Union[str, os.PathLike[str]],
    name: str = "link",
    *,
    density: float = 1000.0,
    prefix: str = "",
) -> str:
    """A URDF ``<link>`` with a collision mesh for each hull. Writes the meshes as OBJ files to
    ``folder``, and names them in the text as ``prefix`` and the name of the file: pass
    ``prefix="package://robot/meshes/"`` for ROS. A hull that a primitive may replace (see `Hull.primitive`) is
    that primitive, except for capsules, which URDF does not have.

    The inertial element describes the mesh at uniform ``density`` if the pack records its mass
    properties: see `Pack.mass_properties`. Otherwise it describes the hulls, and overlaps count
    twice.
    """
    place = Path(folder)
    hulls = _hulls(shape)
    lines = [f"<link name={quoteattr(name)}>"]
    mass = _mass(shape, density)
    if mass.mass > 0.0:
        keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        numbers = " ".join(f'{key}="{float(mass.inertia[at])!r}"' for key, at in keys.items())
        lines += ["  <inertial>", f'    <origin xyz="{_numbers(mass.center_of_mass)}" rpy="0 0 0"/>']
        lines += [f'    <mass value="{mass.mass!r}"/>', f"    <inertia {numbers}/>", "  </inertial>"]
    for hull in hulls:
        if hull.primitive is not None and hull.primitive.kind != "capsule":
            lines.append(f"  <collision name={quoteattr(hull.name)}>{_origin_and_geometry(hull.primitive)}</collision>")
            continue
        safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in f"{name}_{hull.name}")
        file = f"{safe}_{hull.index}.obj" if len(hulls) > 1 else f"{safe}.obj"
        (place / file).write_text(_obj(hull), encoding="utf-8")
        mesh = f"<geometry><mesh filename={quoteattr(prefix + file)}/></geometry>"
        lines.append(f"  <collision name={quoteattr(hull.name)}>{mesh}</collision>")
    return "\n".join([*lines, "</link>"])


def _geom(primitive: Primitive) -> str:
    """The attributes of a geom in MJCF: half of all lengths, and a quaternion w, x, y, z."""
    count = {"box": 3, "sphere": 1}.get(primitive.kind, 2)
    x, y, z, w = primitive.rotation
    place = f'pos="{_numbers(primitive.center)}" quat="{_numbers((w, x, y, z))}"'
    return f'type="{primitive.kind}" size="{_numbers(primitive.sizes[:count])}" {place}'


def _origin_and_geometry(primitive: Primitive) -> str:
    """The elements of a collision in URDF: whole lengths, and angles."""
    a, b, _ = primitive.sizes
    if primitive.kind == "box":
        shape = f'<box size="{_numbers(2 * np.array(primitive.sizes))}"/>'
    elif primitive.kind == "sphere":
        shape = f'<sphere radius="{a!r}"/>'
    else:
        shape = f'<{primitive.kind} radius="{a!r}" length="{2 * b!r}"/>'
    angles = _numbers(_roll_pitch_yaw(primitive.rotation))
    return f'<origin xyz="{_numbers(primitive.center)}" rpy="{angles}"/><geometry>{shape}</geometry>'


def _roll_pitch_yaw(rotation: Tuple[float, float, float, float]) -> Tuple[float, float, float]:
    """The angles of URDF about the fixed axes x, y, z, one after the other. Reference: Diebel,
    "Representing attitude", 2006, section 5.8."""
    x, y, z, w = rotation
    sine = 2 * (w * y - z * x)
    if abs(sine) >= 1 - 1e-12:
        # At a pitch of a right angle, roll and yaw turn about one axis.
        return 2 * math.atan2(x, w), math.copysign(math.pi / 2, sine), 0.0
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return roll, math.asin(sine), math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _obj(hull: Hull) -> str:
    """The hull as the text of an OBJ file, which bakes to the same hull."""
    lines = [f"v {_numbers(vertex)}" for vertex in hull.vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face.tolist()) for face in hull.faces]
    return "\n".join(lines) + "\n"
