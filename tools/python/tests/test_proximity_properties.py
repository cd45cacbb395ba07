"""What must hold between answers by distance, whatever is asked."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import delaunay_tiles as dt

coordinate = st.one_of(st.integers(-2, 22), st.floats(-2, 22, allow_subnormal=False))
point = st.tuples(coordinate, coordinate)
points = st.lists(point, max_size=6)

# Between a value and a bound of the same value, or between sums in another order.
SLACK = 1 + 1e-12


@pytest.fixture(scope="module")
def t(folder):
    return dt.open(folder / "town.tiles")


@given(points, st.integers(1, 14), st.sampled_from(["exact", "fast", "within:0.1"]))
def test_neighbours_come_in_order_and_within_their_bounds(t, at, k, mode):
    near = t.knn(at, k, mode)
    assert near.site.shape == near.distance.shape == near.id.shape == (len(at), k)
    assert near.xy.shape == (len(at), k, 2) and len(near) == len(at)
    found = near.site >= 0
    assert (near.lower[found] <= near.distance[found]).all() and (near.distance[found] <= near.upper[found]).all()
    for one, is_found in zip(near, found, strict=True):
        assert is_found.sum() == (min(k, 12) if one.status == "ok" else 0)
        assert len(set(one.site[is_found])) == is_found.sum()
        if mode != "fast":
            assert (np.diff(one.distance[is_found]) >= 0).all()
        assert np.isnan(one.xy[~is_found]).all() and all(text is None for text in one.id[~is_found])
        rest = np.inf if one.status == "ok" else np.nan
        for numbers in (one.distance, one.lower, one.upper):
            assert np.array_equal(numbers[~is_found], np.full(k - is_found.sum(), rest), equal_nan=True)


@given(point, st.floats(0, 30))
def test_sites_within_a_distance_are_the_first_neighbours(t, at, r):
    near, reached = t.knn(at, 12), t.within(at, r)
    inside = near.distance <= r
    assert reached.status == near.status
    assert reached.site.tolist() == near.site[inside].tolist()
    assert reached.distance.tolist() == near.distance[inside].tolist()
    assert reached.xy.tolist() == near.xy[inside].tolist() and reached.id.tolist() == near.id[inside].tolist()


@given(points.filter(len), st.integers(1, 5))
def test_an_answer_for_one_point_is_that_of_a_list(t, at, k):
    for ask in (
        lambda xy: t.knn(xy, k),
        lambda xy: t.within(xy, 5.0),
        lambda xy: t.nearest(xy, k, "sites"),
        lambda xy: t.footing(xy),
    ):
        several = ask(at)
        for i, one in enumerate(at):
            alone, row = ask(one), several[i]
            assert alone.status == row.status == several.status[i]
            for name in ("site", "distance", "xy", "offsets", "nearest_free", "free", "tile", "index", "id"):
                if hasattr(alone, name):
                    left, right = np.asarray(getattr(alone, name)), np.asarray(getattr(row, name))
                    is_number = left.dtype.kind == "f"
                    assert left.shape == right.shape and np.array_equal(left, right, equal_nan=is_number)


@given(point, point, point)
def test_distances_are_symmetric_and_no_way_round_is_shorter(t, a, b, c):
    there, back = t.path(a, b), t.path(b, a)
    assert there.status == back.status
    if not there:
        assert there.status == "inside_obstacle"
        return
    assert there.lower <= back.upper and back.lower <= there.upper
    straight = np.hypot(*np.subtract(a, b))
    assert there.distance * SLACK >= straight
    legs = np.hypot(*np.diff(there.points, axis=0).T)
    assert there.distance == pytest.approx(legs.sum(), rel=1e-12)
    first, second = t.path(a, c), t.path(c, b)
    if first and second:
        assert there.lower <= (first.upper + second.upper) * SLACK


@given(points, points, st.sampled_from(["exact", "fast", "within:0.05"]))
def test_a_matrix_has_the_distances_of_paths(t, a, b, mode):
    matrix = t.matrix(a, b, mode)
    assert matrix.distance.shape == matrix.lower.shape == matrix.status.shape == (len(a), len(b))
    for i, start in enumerate(a):
        paths = t.paths(start, b, mode)
        assert paths.status.tolist() == matrix.status[i].tolist()
        np.testing.assert_allclose(paths.distance, matrix.distance[i], rtol=1e-12)
        if mode == "within:0.05":
            assert (paths.upper[paths.status == "ok"] <= 1.05 * SLACK * paths.lower[paths.status == "ok"]).all()


@given(point, st.floats(0, 15), points)
def test_the_area_within_reach_has_the_points_that_paths_reach(t, at, r, others):
    reach = t.reach(at, r)
    paths = t.paths(at, others)
    inside = reach.contains(others)
    assert inside.shape == (len(others),)
    assert [reach.contains(one) for one in others] == inside.tolist()
    # The polygons are inside the true area by at most 0.0001 of the radius.
    assert (paths.distance[inside] <= r * (1 + 1e-6) + 1e-9).all()
    free = t.footing(at).free
    near = np.array([path.status == "ok" and path.distance < r * (1 - 1e-3) - 1e-6 for path in paths], dtype=bool)
    margins = np.array([is_clear(t, one, 1e-3 * r + 1e-6) for one in others], dtype=bool)
    assert inside[near & margins & free].all()
    assert 0 <= reach.area <= np.pi * r * r * SLACK


def is_clear(t, at, margin) -> bool:
    """Returns whether a point is away from walls and obstacles, at which rounding decides."""
    x, y = at
    near_house = 8 - margin <= x <= 12 + margin and 6 - margin <= y <= 14 + margin
    near_fence = abs(x - 4) <= margin and 2 - margin <= y <= 11 + margin
    return not (near_house or near_fence)


@given(point, point, st.integers(1, 4))
def test_intervals_along_a_line_cover_it_with_the_nearest_sites(t, a, b, k):
    along = t.along(a, b, k)
    assert along.from_t[0] == 0 and along.to_t[-1] == 1
    assert (along.from_t[1:] == along.to_t[:-1]).all() and along.site.shape == (len(along), k)
    for i in range(len(along)):
        if not along.free[i] or along.to_t[i] - along.from_t[i] < 1e-6:
            continue
        middle = (along.start[i] + along.end[i]) / 2
        near = t.knn(middle, k)
        ours = t.paths(middle, along.xy[i]).distance
        np.testing.assert_allclose(ours, near.distance, rtol=1e-7, atol=1e-7)


@given(st.lists(point, max_size=8), st.integers(1, 6))
def test_the_euclidean_nearest_are_those_of_all(t, at, k):
    shops = t.nearest((0, 0), 12, "sites")
    near = t.nearest(at, k, "sites")
    gaps = np.asarray(at, float).reshape(-1, 1, 2) - shops.xy
    expected = np.sort(np.hypot(gaps[..., 0], gaps[..., 1]), axis=1)[:, :k]
    np.testing.assert_allclose(near.distance, expected, rtol=1e-14)


@given(points, points)
def test_a_way_along_edges_is_a_little_longer(folder, a, b):
    plain = dt.open(folder / "plain.tiles")
    count = min(len(a), len(b))
    a, b = np.asarray(a, float).reshape(-1, 2)[:count], np.asarray(b, float).reshape(-1, 2)[:count]
    edges, paths = plain.edge_distances(a, b), plain.paths(a, b)
    assert edges.distance.shape == (count,)
    assert (edges.upper >= paths.lower).all() and (edges.lower <= 2.42 * SLACK * paths.upper + 1e-9).all()


def test_what_nothing_reaches_is_infinitely_far(run, tmp_path):
    (tmp_path / "points.csv").write_text("0,0\n10,0\n10,10\n0,10\n")
    ring = [[3, 3], [6, 3], [6, 6], [3, 6], [3, 3]]
    feature = {"type": "LineString", "coordinates": ring}
    (tmp_path / "yard.geojson").write_text(json.dumps(feature))
    (tmp_path / "sites.csv").write_text("1,1\n4,4\n")
    files = ["points.csv", "--walls", "yard.geojson", "--sites", "sites.csv"]
    run("build", *files, "-o", "x.tiles", "--quiet", cwd=tmp_path)
    t = dt.open(tmp_path / "x.tiles")
    path = t.path((1, 2), (5, 5))
    assert (path.status, path.distance, path.lower, path.upper) == ("unreachable", *[np.inf] * 3) and not path
    assert path.points.shape == (0, 2) and path.to_wkt() == "LINESTRING EMPTY" and path.nearest_free is None
    assert t.matrix([(1, 2)], [(5, 5), (2, 2)]).status.tolist() == [["unreachable", "ok"]]
    near = t.knn([(1, 2), (5, 5)], 2)
    assert near.site.tolist() == [[0, -1], [1, -1]] and (near.distance[:, 1] == np.inf).all()
    assert near.status.tolist() == ["ok", "ok"]
    edges = t.edge_distances((1, 2), [(5, 5), (2, 2)])
    assert edges.status.tolist() == ["unreachable", "ok"] and edges.distance[0] == np.inf
    assert t.along((1, 2), (1, 3), 2).from_distance[0, 1] == np.inf


def test_other_libraries_take_paths_and_areas(town):
    shapely = pytest.importorskip("shapely")
    path, reach = town.path((3, 8), (5, 8)), town.reach((6, 10), 4)
    line = shapely.geometry.shape(path)
    assert line.length == pytest.approx(path.distance) and line.equals(shapely.from_wkt(path.to_wkt()))
    area = shapely.geometry.shape(reach)
    assert area.is_valid and area.area == pytest.approx(reach.area)
    assert area.equals(shapely.from_wkt(reach.to_wkt()))
    xy = np.random.default_rng(0).uniform(2, 10, (500, 2))
    assert (shapely.contains_xy(area, xy) == reach.contains(xy)).all()
    assert reach.contains(np.concatenate([ring for polygon in reach.polygons for ring in polygon])).all()
    empty = town.reach((9, 9), 1)
    assert shapely.geometry.shape(empty).is_empty and empty.to_wkt() == "MULTIPOLYGON EMPTY" and empty.area == 0
    assert not empty.contains((9, 9))


def test_geopandas_takes_paths(town):
    geopandas = pytest.importorskip("geopandas")
    ways = town.paths((3, 8), [(5, 8), (3, 9), (9, 9)])
    series = geopandas.GeoSeries.from_wkt([way.to_wkt() for way in ways])
    assert series.length.tolist()[:2] == pytest.approx(ways.distance.tolist()[:2])
    frame = geopandas.GeoDataFrame.from_features(ways)
    assert frame["status"].tolist() == ["ok", "ok", "inside_obstacle"]
    assert frame.length[:2].tolist() == pytest.approx(frame["distance"][:2].tolist()) and frame.geometry[2] is None


def test_paths_are_sliced(town):
    ways = town.paths((3, 8), [(5, 8), (3, 9), (9, 9), (13, 10)])
    some = ways[1:]
    assert len(some) == 3 and some.offsets[0] == 0 and some.offsets[-1] == len(some.points)
    for left, right in zip(some, list(ways)[1:], strict=True):
        assert left.points.tolist() == right.points.tolist() and left.bends == right.bends
        assert (left.status, left.certified) == (right.status, right.certified)
    assert len(ways[3:1]) == 0 and ways[-1].bends == some[-1].bends == some[1:][1].bends
    with pytest.raises(IndexError):
        ways[4]
    with pytest.raises(ValueError, match="step 1"):
        ways[::2]


def test_a_question_that_reached_its_limit_has_bounds(islands):
    footing = islands.footing(np.random.default_rng(3).uniform((96, -11), (141, 7), (40, 2)))
    sea = footing.nearest_free[footing.free]
    path = islands.path(sea[0], sea[-1], max_tiles=1)
    full = islands.path(sea[0], sea[-1])
    assert full and path.status == "out_of_budget" and not path
    assert np.isnan(path.distance) and path.lower <= full.distance and path.upper == np.inf
    assert islands.path(sea[0], sea[-1], max_time=1e-9).status == "out_of_budget"
    assert islands.matrix(sea[:1], sea[-1:], max_time=1e-9).status.tolist() == [["out_of_budget"]]
    assert islands.reach(sea[0], 5, max_time=1e-9).status == "out_of_budget"
    assert islands.along(sea[0], sea[-1], max_time=1e-9).status == "out_of_budget"
    reached = islands.within(sea[0], np.inf, max_time=1e-9)
    assert reached.status == "out_of_budget" and reached.bound >= 0
