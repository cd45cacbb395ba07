"""Arrays of all kinds, and arguments that are wrong."""

from __future__ import annotations

from datetime import timedelta
from decimal import Decimal

import numpy as np
import pytest

import delaunay_tiles as dt

XY = np.array([[3.0, 8.0], [14.0, 3.0], [9.0, 9.0]])

ASKS = {
    "knn": lambda t, xy: t.knn(xy, 2).distance,
    "within": lambda t, xy: t.within(xy, 9).distance,
    "paths": lambda t, xy: t.paths(xy, (1, 1)).distance,
    "matrix": lambda t, xy: t.matrix(xy, xy).distance,
    "nearest": lambda t, xy: t.nearest(xy, 3).distance,
    "footing": lambda t, xy: t.footing(xy).nearest_free,
    "contains": lambda t, xy: t.reach((3, 8), 4).contains(xy),
}


@pytest.fixture(params=ASKS, scope="module")
def ask(request):
    return ASKS[request.param]


def read_only(xy: np.ndarray) -> np.ndarray:
    xy = xy.copy()
    xy.flags.writeable = False
    return xy


KINDS = {
    "a list": lambda xy: xy.tolist(),
    "tuples": lambda xy: tuple(map(tuple, xy.tolist())),
    "float32": lambda xy: xy.astype(np.float32),
    "int64": lambda xy: xy.astype(np.int64),
    "uint8": lambda xy: xy.astype(np.uint8),
    "big-endian": lambda xy: xy.astype(">f8"),
    "by columns": np.asfortranarray,
    "every second": lambda xy: np.repeat(xy, 2, axis=0)[::2],
    "backwards": lambda xy: xy[::-1].copy()[::-1],
    "columns of more": lambda xy: np.hstack([xy, xy])[:, 1:3][:, ::-1],
    "read-only": read_only,
    "unaligned": lambda xy: np.frombuffer(b"\0" + xy.tobytes(), np.uint8)[1:].view(np.float64).reshape(-1, 2),
}


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_of_any_kind_have_the_same_answer(town, ask, kind):
    xy = KINDS[kind](XY)
    before = np.array(xy)
    assert np.array_equal(ask(town, xy), ask(town, XY), equal_nan=ask is not ASKS["contains"])
    assert np.array_equal(before, np.array(xy))


@pytest.mark.parametrize("empty", [[], (), np.empty((0, 2)), np.empty((0, 2), np.int32)], ids=repr)
def test_no_points_have_an_empty_answer(town, empty):
    assert town.knn(empty, 3).distance.shape == town.knn(empty, 3).id.shape == (0, 3)
    assert town.within(empty, 3).offsets.tolist() == [0]
    assert len(town.within(empty, 3, paths=True).paths) == len(town.paths(empty, empty)) == 0
    assert len(town.paths(empty, (1, 1))) == 0
    assert town.matrix(empty, XY).distance.shape == (0, 3) and town.matrix(XY, empty).status.shape == (3, 0)
    assert town.matrix(empty, XY, "fast").distance.shape == (0, 3)
    assert town.nearest(empty, 2).xy.shape == (0, 2, 2) and town.footing(empty).free.shape == (0,)
    assert town.reach((3, 8), 1).contains(empty).shape == (0,)
    assert list(town.knn(empty, 3)) == list(town.paths(empty, empty)) == []


WRONG = {
    "texts": ([["1", "2"]], TypeError, "real numbers"),
    "objects": (np.array([[1, Decimal(2)]], dtype=object), TypeError, "real numbers"),
    "complex": ([[1 + 0j, 2]], TypeError, "real numbers"),
    "booleans": ([[True, False]], TypeError, "real numbers"),
    "dates": (np.zeros((1, 2), "M8[s]"), TypeError, "real numbers"),
    "None": (None, TypeError, "real numbers"),
    "a number": (3.0, ValueError, "shape"),
    "three coordinates": (np.zeros((4, 3)), ValueError, "shape"),
    "three numbers": ([1.0, 2.0, 3.0], ValueError, "shape"),
    "more axes": (np.zeros((2, 2, 2)), ValueError, "shape"),
    "ragged rows": ([[1, 2], [3]], ValueError, "inhomogeneous"),
    "NaN": ([[1, 2], [3, np.nan]], dt.QueryError, r"\[1\] = \(3.0, nan\) is not a valid point"),
    "infinite": ([[1, 2], [4, 4], [-np.inf, 0]], dt.QueryError, r"\[2\] = \(-inf, 0.0\)"),
    "large": ([[1e61, 2]], dt.QueryError, r"\[0\] = \(1e\+61"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_arrays_that_are_no_points_are_refused(town, ask, kind):
    xy, error, text = WRONG[kind]
    with pytest.raises(error, match=text):
        ask(town, xy)


def test_one_point_must_be_one(town):
    for wrong in (XY, [], [[1, 2], [3, 4]]):
        with pytest.raises(ValueError, match="one point"):
            town.path(wrong, (1, 1))
        with pytest.raises(ValueError, match="one point"):
            town.reach(wrong, 1)
    with pytest.raises(dt.QueryError, match="b.* is not a valid point"):
        town.path((1, 1), (np.nan, 1))
    with pytest.raises(ValueError, match="not 3 and 2"):
        town.paths(XY, XY[:2])


@pytest.mark.parametrize(
    ("k", "error"), [(0, ValueError), (-1, ValueError), (2**63, ValueError), (1.5, TypeError), ("2", TypeError)]
)
def test_a_wrong_rank_is_refused(town, k, error):
    for ask in (town.knn, town.nearest):
        with pytest.raises(error, match="k must be"):
            ask(XY, k)
    with pytest.raises(error, match="k must be"):
        town.along((0, 0), (1, 1), k)


def test_a_rank_beyond_all_sites_is_padded_within_reason(town):
    near = town.knn(XY, 1000)
    assert near.site.shape == (3, 1000) and (near.site[:, 12:] == -1).all()
    assert town.nearest((1, 1), np.int32(1000)).distance.shape == (1000,)
    for k in (10**9, 2**62):
        with pytest.raises(ValueError, match="more than the 12 that the file has"):
            town.knn(XY, k)
        with pytest.raises(ValueError, match="more than the 444 that"):
            town.nearest(XY, k)
        with pytest.raises(ValueError, match="reduce k"):
            town.along((0, 0), (1, 1), k)


@pytest.mark.parametrize(
    ("r", "error"),
    [
        *[(-1, ValueError), (np.nan, ValueError), ([1, 2], ValueError)],
        *[(None, TypeError), ("3", TypeError), (1j, TypeError)],
    ],
)
def test_a_wrong_distance_is_refused(town, r, error):
    with pytest.raises(error, match="r must be"):
        town.within(XY, r)
    with pytest.raises(error, match="r must be"):
        town.reach((1, 1), r)


def test_distances_may_differ_by_point_and_be_infinite(town):
    reached = town.within(XY, [0, np.inf, 1])
    assert np.diff(reached.offsets).tolist() == [0, 12, 0]
    assert town.within((1, 1), 0).site.tolist() == [0]
    assert town.reach((3, 8), 0).area == 0.0 and not town.reach((3, 8), 0).polygons
    with pytest.raises(ValueError, match="one distance"):
        town.reach((3, 8), [1.0])
    with pytest.raises(ValueError, match="finite"):
        town.reach((3, 8), np.inf)


@pytest.mark.parametrize("mode", ["", "Exact", "within", "within:", "within:-1", "within:nan", "within:inf", "a\0b"])
def test_an_unknown_mode_is_refused(town, mode):
    message = "exact, fast, or within"
    with pytest.raises(ValueError, match=message):
        town.knn(XY, 1, mode)
    with pytest.raises(ValueError, match=message):
        town.path((1, 1), (2, 2), mode)
    with pytest.raises(ValueError, match=message):
        town.matrix(XY, XY, mode)
    with pytest.raises(TypeError, match="mode must be"):
        town.knn(XY, 1, 0.05)


def test_limits_are_checked(town):
    for limit in ({"max_tiles": 0}, {"max_tiles": -3}, {"max_time": 0}, {"max_time": -1}, {"max_time": float("nan")}):
        with pytest.raises(ValueError, match="must be above 0"):
            town.knn(XY, 1, **limit)
    for limit in ({"max_tiles": 1.5}, {"max_time": "1s"}, {"max_time": []}):
        with pytest.raises((TypeError, ValueError)):
            town.knn(XY, 1, **limit)
    whole = town.knn(XY, 2).distance
    for time in (timedelta(hours=1), float("inf"), 1e300, 60):
        assert np.array_equal(town.knn(XY, 2, max_time=time).distance, whole, equal_nan=True)
    with pytest.raises(ValueError, match="vertices"):
        town.nearest(XY, of="shops")


def test_a_matrix_that_no_memory_holds_is_refused(town):
    many = np.zeros((5 * 10**6, 2))
    with pytest.raises(MemoryError, match="needs too much memory"):
        town.matrix(many, many)


def test_a_file_that_cannot_answer_says_so(town, run, tmp_path):
    with pytest.raises(dt.QueryError, match="break lines"):
        town.edge_distances((1, 1), (2, 2))
    (tmp_path / "line.csv").write_text("0,0\n1,1\n2,2\n")
    run("build", "line.csv", "-o", "line.tiles", "--quiet", cwd=tmp_path)
    line = dt.open(tmp_path / "line.tiles")
    assert line.nearest((1.2, 1)).xy.tolist() == [[1.0, 1.0]]
    asks = [lambda: line.knn(XY, 1), lambda: line.path((0, 0), (1, 1)), lambda: line.matrix(XY, XY)]
    asks += [lambda: line.footing(XY), lambda: line.reach((1, 1), 1), lambda: line.along((0, 0), (1, 1))]
    for ask in asks:
        with pytest.raises(dt.QueryError, match="no triangles"):
            ask()


def test_a_file_without_sites_has_no_neighbours(run, tmp_path):
    (tmp_path / "p.csv").write_text("0,0\n4,0\n0,4\n")
    run("build", "p.csv", "-o", "p.tiles", "--quiet", cwd=tmp_path)
    t = dt.open(tmp_path / "p.tiles")
    near = t.knn((1, 1), 2)
    assert near.site.tolist() == [-1, -1] and near.id.tolist() == [None, None] and near.status == "ok"
    assert t.within((1, 1), 9).site.shape == (0,) and t.within((1, 1), 9).id.shape == (0,)
    assert t.along((0, 0), (1, 1)).site.tolist() == [[-1]]


def test_the_answer_for_one_point_has_no_length(town):
    with pytest.raises(TypeError, match="one point"):
        len(town.knn((1, 1), 2))
    with pytest.raises(IndexError):
        town.knn(XY, 2)[3]
    assert town.knn(XY, 2)[-1].status == "inside_obstacle"


def test_answers_are_shown_briefly(town):
    answers = [town.knn(XY, 2), town.within((1, 1), 2), town.footing(XY), town.matrix(XY, XY), town.reach((3, 8), 1)]
    texts = list(map(repr, [*answers, town.along((6, 10), (14, 10)), town.paths(XY, XY)]))
    assert texts[:2] == ["<Neighbours: 3 points>", "<Reached: ok>"]
    assert all(len(text) < 60 for text in texts), texts
