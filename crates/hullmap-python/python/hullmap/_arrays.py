"""Arguments as contiguous arrays of doubles, checked."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np
import numpy.typing as npt

from ._hullmap import ArrayError

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.uint32]


def is_ragged(value: object) -> bool:
    """Whether ``value`` is a list of rows that differ in length."""
    if not isinstance(value, (list, tuple)):
        return False
    return len({len(row) if hasattr(row, "__len__") else -1 for row in value}) > 1


def floats(name: str, value: npt.ArrayLike) -> Floats:
    """``value`` as an array of doubles, of any shape and layout."""
    # Old versions of NumPy make an array of lists.
    if is_ragged(value):
        raise ArrayError(f"{name}: the rows differ in length: pass a rectangular array")
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ArrayError(f"{name}: this is no array ({error}): pass a rectangular array of numbers") from None
    if array.dtype.kind not in "fiu":
        raise ArrayError(f"{name}: expected an array of real numbers, found one of type {array.dtype}: convert it")
    # Aligned, unlike a field of a packed record or a buffer that starts at an odd byte.
    return np.require(array, np.float64, "A")


def indices(name: str, array: npt.NDArray[Any], noun: str) -> Counts:
    """``array`` as 32-bit indices of ``noun``."""
    if array.size == 0:
        return np.zeros(0, dtype=np.uint32)
    if array.dtype.kind not in "iu":
        raise ArrayError(f"{name}: expected whole numbers, found {array.dtype}: convert the array with astype(int)")
    low, high = array.min(), array.max()
    if low < 0 or high >= 2**32:
        raise ArrayError(f"{name}: index {low if low < 0 else high} is out of range: {noun} are counted from 0")
    # `ascontiguousarray` does not copy an array of this type that starts at an odd byte.
    return np.require(array.reshape(-1), np.uint32, ["C", "A"])


def number(name: str, value: float) -> float:
    """``value`` as a number of at least 0. NaN is none."""
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = float("nan")
    if not found >= 0.0:
        raise ArrayError(f"{name} must be a number of at least 0, found {value!r}")
    return found


def vectors(name: str, value: npt.ArrayLike) -> Tuple[Floats, Tuple[int, ...]]:
    """``value`` as rows of three numbers, and the shape of the answer."""
    array = floats(name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ArrayError(f"{name}: expected the shape (..., 3), found {array.shape}: pass rows of x, y, z")
    return np.ascontiguousarray(array.reshape(-1, 3)), array.shape[:-1]


def vector(name: str, value: npt.ArrayLike) -> Tuple[float, float, float]:
    """``value`` as three numbers."""
    array = floats(name, value)
    if array.shape != (3,):
        raise ArrayError(f"{name}: expected three numbers x, y, z, found the shape {array.shape}")
    return (float(array[0]), float(array[1]), float(array[2]))


def transforms(name: str, value: npt.ArrayLike) -> Tuple[Floats, Tuple[int, ...]]:
    """``value`` as rows of seven or sixteen numbers, and the shape of the answer."""
    array = floats(name, value)
    if array.ndim >= 2 and array.shape[-2:] == (4, 4):
        return np.ascontiguousarray(array.reshape(-1, 16)), array.shape[:-2]
    if array.ndim >= 1 and array.shape[-1] == 7:
        return np.ascontiguousarray(array.reshape(-1, 7)), array.shape[:-1]
    raise ArrayError(
        f"{name}: expected the shape (..., 7), rows of x y z qx qy qz qw, or (..., 4, 4), found {array.shape}: "
        "hullmap.poses makes such rows"
    )


def joint(lead_a: Tuple[int, ...], count_a: int, lead_b: Tuple[int, ...], count_b: int) -> Tuple[int, ...]:
    """The shape of the answer for two arguments, of which either may be one row for all."""
    if count_a == count_b:
        return lead_a if len(lead_a) > len(lead_b) else lead_b
    return lead_b if count_a == 1 else lead_a
