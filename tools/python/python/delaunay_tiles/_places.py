"""Checks of the arguments of questions: points, ranks, distances and limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import timedelta
from typing import Any

import numpy as np

from ._arguments import coordinates, positive
from ._errors import QueryError

# The largest magnitude of a coordinate.
_MOST = 2.0**200

# Answers of at most this many cells are padded, whatever the file has.
_MOST_PADDED = 1 << 22


def places(values: Any, name: str) -> np.ndarray:
    """Returns points as a float64 array of shape (n, 2).

    Raises
    ------
    TypeError, ValueError
        They are no real numbers, or have another shape.
    QueryError
        A coordinate is NaN, infinite or too large.
    """
    array = coordinates(values, name)
    is_valid = np.abs(array) <= _MOST
    if not is_valid.all():
        row = int(np.argmin(is_valid.all(axis=1)))
        x, y = array[row].tolist()
        raise QueryError(
            f"{name}[{row}] = ({x}, {y}) is not a valid point; coordinates must be finite, with a magnitude of at most "
            "2^200"
        )
    return array


def place(values: Any, name: str) -> np.ndarray:
    """Returns one point as an array of shape (2,)."""
    array = places(values, name)
    if len(array) != 1:
        raise ValueError(f"{name} must be one point (x, y), not {len(array)}")
    return array[0]


def pairs(a: Any, b: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns two lists of points of the same length. One point is taken as often as the other list needs."""
    first, second = places(a, "a"), places(b, "b")
    if len(first) == 1:
        first = np.ascontiguousarray(np.broadcast_to(first, second.shape))
    elif len(second) == 1:
        second = np.ascontiguousarray(np.broadcast_to(second, first.shape))
    if len(first) != len(second):
        raise ValueError(f"a and b must have as many points as each other, not {len(first)} and {len(second)}")
    return first, second


def rank(k: Any, rows: int, available: Callable[[], int]) -> int:
    """Returns the number of neighbours for each of `rows` points, of which there are as many as `available` says.

    More than there are is allowed, because the rest is padded, but not if that would fill the memory by mistake.
    """
    number = positive(k, "k")
    if rows * number > _MOST_PADDED and number > available():
        raise ValueError(
            f"k = {number} is more than the {available()} that the file has; an answer has k columns, so reduce k"
        )
    return number


def distances(r: Any, rows: int) -> np.ndarray:
    """Returns a distance for each point. One distance is taken for all."""
    array = np.asarray(r)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"r must be a real number, not {array.dtype}")
    if array.ndim > 1 or (array.ndim == 1 and len(array) != rows):
        raise ValueError(f"r must be one distance or one for each point, not of shape {array.shape}")
    array = array.astype(np.float64)
    if not (array >= 0).all():
        raise ValueError("r must be a distance of at least 0")
    return np.ascontiguousarray(np.broadcast_to(array, (rows,)))


def distance(r: Any) -> float:
    """Returns one distance."""
    if np.ndim(r) != 0:
        raise ValueError(f"r must be one distance, not of shape {np.shape(r)}")
    number = float(distances(r, 1)[0])
    if number == math.inf:
        raise ValueError("r must be finite")
    return number


def options(
    mode: str = "exact",
    max_tiles: int | None = None,
    max_time: float | timedelta | None = None,
    *,
    paths: bool = False,
    certified: bool = False,
) -> tuple[str, int | None, float | None, bool, bool]:
    """Returns the options of a question for the compiled part, which checks the mode."""
    if not isinstance(mode, str):
        raise TypeError(f"mode must be 'exact', 'fast' or 'within:0.05', not {type(mode).__name__}")
    tiles = None if max_tiles is None else positive(max_tiles, "max_tiles")
    return mode, tiles, _seconds(max_time), bool(paths), bool(certified)


def _seconds(time: float | timedelta | None) -> float | None:
    if isinstance(time, timedelta):
        time = time.total_seconds()
    if time is None or time == math.inf:
        return None
    try:
        seconds = float(time)
    except TypeError:
        raise TypeError(f"max_time must be seconds or a timedelta, not {type(time).__name__}") from None
    if not 0 < seconds:
        raise ValueError(f"max_time must be above 0 seconds, not {seconds}")
    # A century is no limit; it keeps clocks from overflowing.
    return min(seconds, 3.2e9)
