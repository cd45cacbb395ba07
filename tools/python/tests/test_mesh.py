"""Triangulations in memory: those of scipy, and what must hold for all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import delaunay_tiles as dt

cell = st.integers(0, 9)
lattice = st.lists(st.tuples(cell, cell), max_size=30)


def rows_of(triangles) -> set[frozenset[int]]:
    return set(map(frozenset, triangles.tolist()))


def area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def check_neighbours(mesh: dt.Triangulation) -> None:
    """Checks that neighbour i of a triangle is on the other side of the edge opposite to its corner i."""
    corners, neighbours = mesh.triangles, mesh.neighbours
    for triangle, row in enumerate(neighbours.tolist()):
        for corner, other in enumerate(row):
            edge = {int(corners[triangle, i]) for i in range(3) if i != corner}
            if other < 0:
                continue
            assert edge < set(corners[other].tolist())
            back = neighbours[other].tolist().index(triangle)
            assert set(corners[other].tolist()) - {int(corners[other, back])} == edge
            assert mesh.constraints[triangle, corner] == mesh.constraints[other, back]


@pytest.mark.parametrize("count", [3, 10, 500, 5000])
def test_random_points_have_the_triangles_of_scipy(count):
    scipy_spatial = pytest.importorskip("scipy.spatial")
    xy = np.random.default_rng(count).normal(size=(count, 2))
    ours, theirs = dt.triangulate(xy), scipy_spatial.Delaunay(xy)
    assert rows_of(ours.triangles) == rows_of(theirs.simplices)
    assert (area(xy, ours.triangles) > 0).all() and not ours.constraints.any()
    number = {frozenset(row): i for i, row in enumerate(theirs.simplices.tolist())}
    for mine, row in zip(ours.triangles.tolist(), ours.neighbours.tolist(), strict=True):
        at = number[frozenset(mine)]
        beside = dict(zip(theirs.simplices[at].tolist(), theirs.neighbors[at].tolist(), strict=True))
        for corner, other in zip(mine, row, strict=True):
            found = -1 if other < 0 else number[frozenset(ours.triangles[other].tolist())]
            assert found == beside[corner]


@given(lattice)
def test_points_on_a_lattice_are_covered_once_and_the_circles_are_empty(points):
    xy = np.array(points, dtype=np.float64).reshape(-1, 2)
    mesh = dt.triangulate(xy)
    assert mesh.points is xy or np.array_equal(mesh.points, xy)
    firsts = {point: points.index(point) for point in points}
    assert mesh.representative.tolist() == [firsts[point] for point in points]
    assert set(mesh.triangles.ravel().tolist()) <= set(firsts.values())
    check_neighbours(mesh)
    areas = area(xy, mesh.triangles)
    assert (areas > 0).all()
    try:
        from scipy.spatial import ConvexHull, QhullError
    except ImportError:
        return
    try:
        hull = ConvexHull(xy).volume if len(xy) > 2 else 0.0
    except QhullError:
        hull = 0.0
    assert areas.sum() == pytest.approx(hull)
    for triangle in mesh.triangles.tolist():
        a, b, c = (tuple(map(int, xy[corner])) for corner in triangle)
        for x, y in firsts:
            rows = [(px - x, py - y) for px, py in (a, b, c)]
            (ax, ay), (bx, by), (cx, cy) = rows
            squares = [px * px + py * py for px, py in rows]
            inside = squares[0] * (bx * cy - by * cx) - squares[1] * (ax * cy - ay * cx)
            assert inside + squares[2] * (ax * by - ay * bx) <= 0


@pytest.mark.parametrize("points", [[], [(1, 2)], [(1, 2), (1, 2)], [(0, 0), (1, 1), (2, 2), (5, 5)]])
def test_points_on_a_line_have_no_triangles(points):
    mesh = dt.triangulate(points, segments=[(0, len(points) - 1)] if len(points) > 2 else None, holes=[(0, 0)])
    assert mesh.triangles.shape == mesh.neighbours.shape == mesh.constraints.shape == (0, 3)
    assert mesh.representative.shape == (len(points),)
    assert mesh.triangles.dtype == mesh.neighbours.dtype == np.int64 and mesh.constraints.dtype == bool


def edges_of(mesh: dt.Triangulation, chosen: np.ndarray) -> set[frozenset[int]]:
    pairs = np.stack([np.roll(mesh.triangles, -1, axis=1), np.roll(mesh.triangles, -2, axis=1)], axis=-1)
    return rows_of(pairs[chosen])


def test_segments_become_constraints():
    xy = np.random.default_rng(5).random((200, 2))
    order = np.argsort(xy[:, 0])[:40]
    # A chain that is monotonous in x does not cross itself.
    segments = np.stack([order[:-1], order[1:]], axis=1)
    for kind in (np.int64, np.uint8, ">i4"):
        mesh = dt.triangulate(xy, segments.astype(kind))
        assert edges_of(mesh, mesh.constraints) == rows_of(segments)
    check_neighbours(mesh)


def test_a_segment_through_points_is_several_constraints():
    xy = [(0, 0), (4, 0), (2, 0), (2, 3), (2, -3), (4, 0)]
    mesh = dt.triangulate(xy, [(0, 5), (5, 0), (3, 3)])
    assert edges_of(mesh, mesh.constraints) == {frozenset((0, 2)), frozenset((2, 1))}
    assert mesh.representative.tolist() == [0, 1, 2, 3, 4, 1]


def test_crossing_segments_are_an_error_that_names_them():
    xy = [(0, 0), (2, 2), (0, 2), (2, 0)]
    with pytest.raises(dt.BuildError, match=r"segments\[1\] from point 2 to 3 crosses .* between points [01] and [01]"):
        dt.triangulate(xy, [(0, 1), (2, 3)])


def test_holes_are_left_out():
    xy = np.array([(x, y) for y in range(7) for x in range(7)], dtype=float)
    ring = [16, 18, 32, 30, 16]
    segments = np.stack([ring[:-1], ring[1:]], axis=1)
    whole = dt.triangulate(xy, segments)
    mesh = dt.triangulate(xy, segments, holes=[(3, 3), (99, 99), (np.nan, 1)][:2])
    assert area(xy, whole.triangles).sum() == 36 and area(xy, mesh.triangles).sum() == 32
    check_neighbours(mesh)
    assert ((mesh.neighbours < 0) & mesh.constraints).sum() == 8
    assert dt.triangulate(xy, segments, holes=[(0.5, 0.5)]).triangles.shape == (8, 3)
    # A point on a constraint makes holes of both sides, and one at a vertex of all around it.
    assert len(dt.triangulate(xy, segments, holes=[(2.5, 2)]).triangles) == 0


XY = [(0, 0), (1, 0), (0, 1)]
WRONG = [
    ({"xy": np.zeros((3, 3))}, ValueError, "xy must have the shape"),
    ({"xy": [(0, 0), (1, np.nan)]}, ValueError, r"xy\[1\] is \(1, NaN\)"),
    ({"xy": [(0, 0), (np.inf, 1)]}, ValueError, r"xy\[1\]"),
    ({"xy": [(0, 1e300)]}, ValueError, r"xy\[0\]"),
    ({"xy": [(0, 1e-300)]}, ValueError, r"xy\[0\]"),
    ({"xy": None}, TypeError, "xy must hold real numbers"),
    ({"xy": np.array(XY, dtype=object)}, TypeError, "real numbers, not object"),
    ({"xy": np.ma.masked_less(np.array(XY), 1)}, ValueError, "xy has masked values"),
    ({"xy": np.broadcast_to(1.0, (10**12, 2))}, MemoryError, "allocate"),
    ({"xy": XY, "segments": [(0, 3)]}, ValueError, r"segments\[0\] is \(0, 3\), and there are 3 points"),
    ({"xy": XY, "segments": [(0, 1), (-1, 2)]}, ValueError, r"segments\[1\]"),
    ({"xy": XY, "segments": [(0.0, 1.0)]}, TypeError, "whole numbers, not float64"),
    ({"xy": XY, "segments": [(True, False)]}, TypeError, "whole numbers, not bool"),
    ({"xy": XY, "segments": [0, 1]}, ValueError, r"\(m, 2\)"),
    ({"xy": XY, "segments": [(0, 1, 2)]}, ValueError, r"\(m, 2\)"),
    ({"xy": XY, "segments": np.array([(0, 2**64 - 1)], dtype=np.uint64)}, ValueError, "segments"),
    ({"xy": XY, "holes": [1.0, 2.0, 3.0]}, ValueError, "holes must have the shape"),
    ({"xy": XY, "holes": "x"}, TypeError, "holes"),
]


@pytest.mark.parametrize(("arguments", "error", "text"), WRONG, ids=[str(list(w[0].items()))[:50] for w in WRONG])
def test_wrong_arguments_are_named(arguments, error, text):
    with pytest.raises(error, match=text):
        dt.triangulate(**arguments)


@pytest.mark.parametrize("kind", [np.float32, np.int16, ">f8"])
def test_arrays_of_any_kind_have_the_same_triangles(kind):
    xy = np.random.default_rng(1).integers(0, 50, (300, 2)).astype(np.float64)
    expected = dt.triangulate(xy)
    for form in (xy.astype(kind), np.asfortranarray(xy), np.repeat(xy, 2, axis=0)[::2], xy.tolist()):
        assert np.array_equal(dt.triangulate(form).triangles, expected.triangles)
