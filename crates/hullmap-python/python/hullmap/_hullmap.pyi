"""The part of the package that is written in Rust. Use the classes of `hullmap` instead."""

from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

__version__: str
has_gpu: bool

_Floats = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.uint32]
_Columns = Dict[str, npt.NDArray[Any]]
_Vector = Tuple[float, float, float]
_Pairs = Union[Pairs, Tuple[Shape, Shape]]

# Poses of B in A; poses of A and of B in the world; poses of all shapes of `Pairs` in the world.
Poses = Union[Tuple[_Floats, Optional[_Floats]], _Floats]

class Error(ValueError):
    """Wrong input. The base of all exceptions of hullmap."""

class ArrayError(Error):
    """An array has a wrong shape, type or value."""

class PoseError(Error):
    """Numbers are not a rigid pose."""

class ShapeError(Error):
    """A shape cannot be made, or cannot be queried this way."""

class BakeError(Error):
    """A mesh cannot be baked, or an option is wrong."""

class BakeWarning(UserWarning):
    """A finding of a bake to act on."""

class InvalidPack(Error):
    """A file is not a pack, or is damaged."""

class Shape:
    @staticmethod
    def sphere(radius: float) -> Shape: ...
    @staticmethod
    def cuboid(half_edges: _Vector) -> Shape: ...
    @staticmethod
    def capsule(half_length: float, radius: float) -> Shape: ...
    @staticmethod
    def cylinder(half_height: float, radius: float) -> Shape: ...
    @staticmethod
    def cone(half_height: float, radius: float) -> Shape: ...
    @staticmethod
    def segment(start: _Vector, end: _Vector) -> Shape: ...
    @staticmethod
    def triangle(a: _Vector, b: _Vector, c: _Vector) -> Shape: ...
    @staticmethod
    def half_space(normal: _Vector, offset: float) -> Shape: ...

class Pairs:
    def __init__(self, shapes: Sequence[Shape], a: _Indices, b: _Indices) -> None: ...

class Hull:
    index: int
    name: str
    def shape(self) -> Shape: ...
    def facts(self) -> Dict[str, Any]: ...
    def array(self, name: str) -> npt.NDArray[Any]: ...

_Mass = Tuple[float, _Vector, Tuple[_Vector, _Vector, _Vector], str]

class Pack:
    path: Optional[str]
    notes: List[str]
    byte_len: int
    source_path: str
    options: str
    @staticmethod
    def open(path: str, mmap: bool) -> Pack: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> Pack: ...
    def bytes(self) -> bytes: ...
    def mass_properties(self, hulls: Sequence[int], density: float) -> _Mass: ...
    def __len__(self) -> int: ...
    def names(self) -> List[str]: ...
    def hull(self, index: int) -> Hull: ...
    def hull_named(self, name: str) -> Hull: ...
    def check_repeats(self) -> None: ...
    def shape(self) -> Shape: ...

class TriangleMesh:
    path: Optional[str]
    @staticmethod
    def open(path: str) -> TriangleMesh: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> TriangleMesh: ...
    @staticmethod
    def from_arrays(
        vertices: npt.NDArray[np.float32], corners: _Indices, materials: npt.NDArray[np.uint16]
    ) -> TriangleMesh: ...
    def bytes(self) -> bytes: ...
    def facts(self) -> Dict[str, Any]: ...
    def array(self, name: str) -> npt.NDArray[Any]: ...
    def shape(self) -> Shape: ...

class HeightField:
    path: Optional[str]
    @staticmethod
    def open(path: str) -> HeightField: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> HeightField: ...
    @staticmethod
    def from_array(
        heights: npt.NDArray[np.float32],
        grid: Tuple[Tuple[float, float], Tuple[float, float], str],
        holes: npt.NDArray[np.bool_],
        materials: npt.NDArray[np.uint16],
    ) -> HeightField: ...
    def bytes(self) -> bytes: ...
    def facts(self) -> Dict[str, Any]: ...
    def array(self, name: str) -> npt.NDArray[Any]: ...
    def heights_at(self, points: _Floats) -> _Floats: ...
    def shape(self) -> Shape: ...

class Robot:
    format: str
    notes: List[str]
    body_count: int
    @staticmethod
    def read(path: str, packs: Sequence[str], packages: Sequence[str], strict: bool) -> Robot: ...
    def names(self) -> Tuple[List[str], List[str]]: ...
    def joint_facts(self) -> List[Tuple[str, Optional[Tuple[float, float]], float, bool]]: ...
    def pairs(self) -> List[Tuple[int, int]]: ...
    def skipped(self) -> List[Tuple[List[str], List[str], str]]: ...
    def disallowing(self, pairs: Sequence[Tuple[str, str]]) -> Robot: ...
    def allowing(self, pairs: Sequence[Tuple[str, str]]) -> Robot: ...
    def allowing_srdf(self, path: str) -> Robot: ...
    def with_obstacles(self, obstacles: Sequence[Tuple[str, Shape, List[float]]]) -> Robot: ...
    def without_obstacles(self) -> Robot: ...
    def link_poses(self, q: _Floats) -> _Floats: ...
    def touching(self, q: _Floats) -> List[Tuple[int, int]]: ...
    def in_collision(
        self,
        count: int,
        q: Optional[_Floats],
        poses: Optional[_Floats],
        margin: float,
        threads: Optional[int],
        report: Optional[Callable[[float], object]],
    ) -> _Columns: ...
    def clearance(
        self,
        count: int,
        q: Optional[_Floats],
        poses: Optional[_Floats],
        settings: Tuple[float, int],
        gradient: bool,
        threads: Optional[int],
        report: Optional[Callable[[float], object]],
    ) -> _Columns: ...
    def clear(
        self,
        start: _Floats,
        end: _Floats,
        settings: Tuple[float, float, float, int],
        threads: Optional[int],
        report: Optional[Callable[[float], object]],
    ) -> _Columns: ...

def run_command(words: Sequence[str]) -> int: ...
def bake_arrays(
    name: str,
    meshes: Sequence[Tuple[str, _Floats, _Indices, _Indices]],
    options: Sequence[Tuple[str, str]],
    threads: Optional[int],
    progress: Optional[Callable[[float], object]],
) -> Pack: ...
def bake_file(
    path: str,
    options: Sequence[Tuple[str, str]],
    threads: Optional[int],
    progress: Optional[Callable[[float], object]],
) -> Pack: ...
def usd_layer(
    stage: Dict[str, Any], groups: Sequence[Dict[str, Any]], off: Sequence[str]
) -> Tuple[str, List[str]]: ...
def pose_rows(name: str, matrices: _Floats) -> _Floats: ...
def relative(a_in_world: _Floats, b_in_world: _Floats) -> _Floats: ...
def intersects(
    pairs: _Pairs, poses: Poses, coherent: bool, threads: Optional[int], device: str
) -> _Columns: ...
def distance(
    pairs: _Pairs,
    poses: Poses,
    settings: Tuple[float, int],
    coherent: bool,
    threads: Optional[int],
    device: str,
) -> _Columns: ...
def contact(
    pairs: _Pairs,
    poses: Poses,
    settings: Tuple[float, int],
    coherent: bool,
    threads: Optional[int],
    device: str,
) -> _Columns: ...
def manifold(
    pairs: _Pairs,
    poses: Poses,
    settings: Tuple[float, int],
    prediction: Optional[float],
    coherent: bool,
    threads: Optional[int],
) -> _Columns: ...
def manifolds(
    pairs: _Pairs,
    poses: Poses,
    settings: Tuple[float, int],
    prediction: Optional[float],
    max_pairs: int,
    coherent: bool,
    threads: Optional[int],
) -> _Columns: ...
def cast(
    pairs: _Pairs,
    poses: Poses,
    velocities: _Floats,
    settings: Tuple[float, float, int],
    coherent: bool,
    threads: Optional[int],
) -> _Columns: ...
def cast_motion(
    a: Shape,
    b: Shape,
    motion_a: _Floats,
    motion_b: _Floats,
    settings: Tuple[float, float, int],
    threads: Optional[int],
) -> _Columns: ...
def clear(
    a: Shape,
    b: Shape,
    motion_a: _Floats,
    motion_b: _Floats,
    settings: Tuple[float, float, int, float],
    threads: Optional[int],
) -> _Columns: ...
def derivatives(
    a: Shape,
    b: Shape,
    b_in_a: _Floats,
    of_depth: bool,
    settings: Tuple[float, int],
    threads: Optional[int],
) -> _Columns: ...
def witness_derivatives(
    a: Shape,
    b: Shape,
    b_in_a: _Floats,
    of_depth: bool,
    settings: Tuple[float, int],
    threads: Optional[int],
) -> _Columns: ...
def ray_derivatives(
    shape: Shape,
    origins: _Floats,
    directions: _Floats,
    settings: Tuple[float, float, int],
    threads: Optional[int],
) -> _Columns: ...
def ray(
    shape: Shape,
    origins: _Floats,
    directions: _Floats,
    settings: Tuple[float, float, int],
    threads: Optional[int],
) -> _Columns: ...
def signed_distance(
    shape: Shape, points: _Floats, settings: Tuple[float, int], coherent: bool, threads: Optional[int]
) -> _Columns: ...
def support(shape: Shape, directions: _Floats, threads: Optional[int]) -> _Columns: ...
