"""Checks and conversions of arguments."""

from __future__ import annotations

import re
from os import fspath
from typing import Any, overload

import numpy as np

_UNITS = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "tb": 10**12}
_UNITS |= {"kib": 2**10, "mib": 2**20, "gib": 2**30, "tib": 2**40}


def coordinates(values: Any, name: str = "xy", widths: tuple[int, ...] = (2,)) -> np.ndarray:
    """Returns values as a C-contiguous float64 array of shape (n, width); one point becomes n = 1.

    An array that has this form already is returned itself, without a copy.
    """
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    if array.dtype.kind not in "fiu" and array.size > 0:
        raise TypeError(f"{name} must hold real numbers, not {array.dtype}")
    if array.ndim == 1 and array.size in widths:
        array = array.reshape(1, -1)
    elif array.size == 0 and array.ndim < 2:
        array = array.reshape(0, widths[0])
    if array.ndim != 2 or array.shape[1] not in widths:
        expected = " or ".join(f"(n, {width})" for width in widths)
        raise ValueError(f"{name} must have the shape {expected}, not {array.shape}")
    return np.require(array, np.float64, ["C", "ALIGNED"])


def refuse_masked(values: Any, name: str) -> None:
    """Refuses an array with masked values, because its mask would get lost."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values; leave their rows out")


def finite(value: Any, name: str) -> float:
    """Returns a number that is neither NaN nor infinite."""
    number = float(value)
    if not np.isfinite(number):
        raise ValueError(f"{name} must be a finite number, not {value!r}")
    return number


def word(value: Any, name: str) -> str:
    """Returns one of several words, which the compiled part knows."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text, not {type(value).__name__}")
    return value


def point(values: Any, name: str) -> np.ndarray:
    """Returns one point as an array of shape (2,)."""
    array = coordinates(values, name)
    if len(array) != 1:
        raise ValueError(f"{name} must be one point (x, y), not {len(array)}")
    return array[0]


def is_single(values: Any) -> bool:
    """Returns whether values are one point rather than a list of points."""
    return np.ndim(values) == 1 and np.size(values) > 0


@overload
def byte_count(size: int | str, name: str) -> int: ...


@overload
def byte_count(size: None, name: str) -> None: ...


def byte_count(size: int | str | None, name: str) -> int | None:
    """Returns a size in bytes, given as a number or as text such as "256MiB"."""
    if size is None:
        return None
    if isinstance(size, str):
        found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([a-zA-Z]*)\s*", size)
        unit = _UNITS.get(found[2].lower()) if found else None
        if found is None or unit is None:
            raise ValueError(f"{name} must be a number of bytes, or text such as '512MiB' or '2GB', not {size!r}")
        return int(float(found[1]) * unit)
    count = positive(size, name)
    return count


def positive(value: Any, name: str) -> int:
    """Returns a whole number above 0."""
    try:
        number = value.__index__()
    except AttributeError:
        raise TypeError(f"{name} must be a whole number, not {type(value).__name__}") from None
    if number <= 0 or number >= 2**63:
        raise ValueError(f"{name} must be above 0 and below 2**63, not {number}")
    return number


def path_text(path: Any, name: str) -> str:
    """Returns a path or an address as text."""
    try:
        text = fspath(path)
    except TypeError:
        raise TypeError(f"{name} must be a path, not {type(path).__name__}") from None
    text = text.decode() if isinstance(text, bytes) else text
    if "\0" in text:
        raise ValueError(f"{name} must not contain a zero byte")
    return text
