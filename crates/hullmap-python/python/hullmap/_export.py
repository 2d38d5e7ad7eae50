"""Ways in and out: trimesh, MuJoCo's MJCF, URDF."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, List, Optional, Union
from xml.sax.saxutils import quoteattr

import numpy as np

from ._bake import bake, bake_parts
from ._hullmap import ArrayError, Error
from ._options import BakeOptions
from ._progress import Progress
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
    hull. The options are those of `bake`."""
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


def to_mjcf(shape: Union[Hull, Pack], name: str = "hull") -> str:
    """A MuJoCo model (MJCF) with one body: a mesh geom for each hull, with its vertices in the text.

    ``mujoco.MjModel.from_xml_string`` loads it, and MuJoCo's ``MjSpec`` attaches it to other models.
    MuJoCo builds the hull of the vertices again.

    >>> import hullmap
    >>> corner = hullmap.bake([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], name="corner")
    >>> print(hullmap.to_mjcf(corner, "body"))
    <mujoco model="body">
      <asset>
        <mesh name="body_corner" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
      </asset>
      <worldbody>
        <body name="body">
          <geom type="mesh" mesh="body_corner"/>
        </body>
      </worldbody>
    </mujoco>
    """
    assets, geoms = [], []
    for hull in _hulls(shape):
        if hull.rank < 3:
            raise ArrayError(f"hull {hull.name}: MuJoCo requires a solid, but this hull is flat: leave it out")
        own = quoteattr(f"{name}_{hull.name}")
        assets.append(f'    <mesh name={own} vertex="{_numbers(hull.vertices)}"/>')
        geoms.append(f'      <geom type="mesh" mesh={own}/>')
    lines = [f"<mujoco model={quoteattr(name)}>", "  <asset>", *assets, "  </asset>", "  <worldbody>"]
    lines += [f"    <body name={quoteattr(name)}>", *geoms, "    </body>", "  </worldbody>", "</mujoco>"]
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
    ``prefix="package://robot/meshes/"`` for ROS.

    The inertial element is that of the hulls as solids of uniform ``density``. Where the parts of a
    pack overlap, it counts the overlap twice.
    """
    place = Path(folder)
    hulls = _hulls(shape)
    lines = [f"<link name={quoteattr(name)}>"]
    properties = [hull.mass_properties(density) for hull in hulls]
    mass = sum(own.mass for own in properties)
    if mass > 0.0:
        center = sum(own.mass * own.center_of_mass for own in properties) / mass
        inertia = np.zeros((3, 3))
        for own in properties:
            arm = own.center_of_mass - center
            inertia += own.inertia + own.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        numbers = " ".join(f'{key}="{float(inertia[at])!r}"' for key, at in entries.items())
        lines += ["  <inertial>", f'    <origin xyz="{_numbers(center)}" rpy="0 0 0"/>']
        lines += [f'    <mass value="{float(mass)!r}"/>', f"    <inertia {numbers}/>", "  </inertial>"]
    for hull in hulls:
        safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in f"{name}_{hull.name}")
        file = f"{safe}_{hull.index}.obj" if len(hulls) > 1 else f"{safe}.obj"
        (place / file).write_text(_obj(hull), encoding="utf-8")
        mesh = f"<geometry><mesh filename={quoteattr(prefix + file)}/></geometry>"
        lines.append(f"  <collision name={quoteattr(hull.name)}>{mesh}</collision>")
    return "\n".join([*lines, "</link>"])


def _obj(hull: Hull) -> str:
    """The hull as the text of an OBJ file, which bakes to the same hull."""
    lines = [f"v {_numbers(vertex)}" for vertex in hull.vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face.tolist()) for face in hull.faces]
    return "\n".join(lines) + "\n"
