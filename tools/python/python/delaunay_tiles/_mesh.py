"""Triangulations in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._arguments import coordinates


@dataclass(frozen=True, slots=True)
class Triangulation:
    """A (constrained) Delaunay triangulation in memory.

    Attributes
    ----------
    points : array of shape (n, 2)
        The points as given.
    triangles : int64 array of shape (m, 3)
        The corners of each triangle, counter-clockwise, as rows of `points`.
    neighbours : int64 array of shape (m, 3)
        The triangle opposite to each corner, or −1, as in `scipy.spatial.Delaunay.neighbors`.
    constraints : bool array of shape (m, 3)
        Whether the edge opposite to each corner is a constraint.
    representative : int64 array of shape (n,)
        The first point at the position of each point; only these are corners.
    """

    points: np.ndarray
    representative: np.ndarray
    triangles: np.ndarray
    neighbours: np.ndarray
    constraints: np.ndarray


def triangulate(xy: Any, segments: Any = None, holes: Any = None) -> Triangulation:
    """Triangulates points in memory, exactly.

    Parameters
    ----------
    xy : array of shape (n, 2)
        Points; of several at a position, the first one counts. Without three that are not on a line, there are no
        triangles.
    segments : int array of shape (m, 2), optional
        Pairs of rows of `xy`, whose connections become constraints. They must not cross.
    holes : array of shape (k, 2), optional
        Points; the triangles that can be reached from one without crossing a constraint are left out.

    Returns
    -------
    Triangulation

    Raises
    ------
    BuildError
        Two segments cross.
    ValueError, TypeError
        An array has the wrong shape, type or values.

    Examples
    --------
    >>> square = dt.triangulate([(0, 0), (2, 0), (2, 2), (0, 2)])
    >>> len(square.triangles), int((square.neighbours < 0).sum())
    (2, 4)
    """
    points = coordinates(xy)
    pairs = np.empty((0, 2), dtype=np.int64) if segments is None else np.asarray(segments)
    if pairs.size == 0:
        pairs = np.empty((0, 2), dtype=np.int64)
    if pairs.dtype.kind not in "iu":
        raise TypeError(f"segments must hold whole numbers, not {pairs.dtype}")
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise ValueError(f"segments must have the shape (m, 2), not {pairs.shape}")
    seeds = coordinates([] if holes is None else holes, "holes")
    found = _core.triangulate(points, np.ascontiguousarray(pairs, dtype=np.int64), seeds)
    return Triangulation(points, *found)
