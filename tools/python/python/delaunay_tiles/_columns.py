"""From the columns of the compiled part to the arrays of answers."""

from __future__ import annotations

from typing import Any

import numpy as np

# The words of the codes; a code picks its word.
_STATUS = np.array(["ok", "unreachable", "inside_obstacle", "out_of_budget"], dtype=object)
_OK, _INSIDE = 0, 2


def status(codes: Any) -> Any:
    """Returns the words of codes; one word for one code."""
    return _STATUS[codes]


def spread(offsets: np.ndarray, k: int, values: np.ndarray, missing: Any) -> np.ndarray:
    """Returns rows of `k` values; the values that a row lacks are `missing`, which may be one for each row."""
    count = len(offsets) - 1
    if len(values) == count * k:
        return values.reshape(count, k, *values.shape[1:])
    rows = np.empty((count, k, *values.shape[1:]), values.dtype)
    rows[...] = np.reshape(missing, (-1, *[1] * (rows.ndim - 1)))
    lengths = np.diff(offsets)
    ranks = np.arange(len(values)) - np.repeat(offsets[:-1], lengths)
    rows[np.repeat(np.arange(count), lengths), ranks] = values
    return rows


def missing_distances(codes: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns value, lower and upper bound of what was not found, for each question."""
    is_ok = codes == _OK
    value = np.where(is_ok, np.inf, np.nan)
    return value, np.where(is_ok, np.inf, bounds), np.where(codes == _INSIDE, np.nan, np.inf)


def ids(sites: Any, names: tuple[np.ndarray, np.ndarray]) -> Any:
    """Returns the ids of sites: None for a site without one, and where the number is -1."""
    numbers, texts = names
    return texts[np.where(np.less(sites, 0), -1, np.searchsorted(numbers, sites))]


def names(numbers: np.ndarray, texts: list[str | None]) -> tuple[np.ndarray, np.ndarray]:
    """Returns the numbers of the sites of an answer, and their ids, with None at the end."""
    table = np.empty(len(texts) + 1, dtype=object)
    table[:-1] = texts
    return numbers, table
