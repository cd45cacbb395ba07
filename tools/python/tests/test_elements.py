"""Tiles, tables and places against the tool, Arrow and exact orientations."""

from __future__ import annotations

import csv
import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import delaunay_tiles as dt

pyarrow = pytest.importorskip("pyarrow")


@pytest.fixture(params=["survey", "town"])
def tiles(request):
    return request.getfixturevalue(request.param)


def key(corners) -> tuple:
    """Returns a triangle or an edge as the set of its corners, without z."""
    return tuple(sorted(tuple(corner[:2]) for corner in corners))


def triangles_of(tiles, chosen=lambda tile: slice(None)) -> list[tuple]:
    return [key(t) for tile in tiles.tiles() for t in tile.corners[tile.triangles[chosen(tile)]].tolist()]


def exported(run, tiles, folder, *options) -> list[dict]:
    """Returns the features that the tool exports as GeoJSON."""
    run("export", tiles.name, "-o", folder / "out.geojson", *options)
    return json.loads((folder / "out.geojson").read_text())["features"]


def test_tiles_have_each_triangle_once(tiles, run, tmp_path):
    found = triangles_of(tiles)
    assert len(found) == len(set(found)) == tiles.metadata.triangles
    theirs = exported(run, tiles, tmp_path, "--all")
    assert sorted(found) == sorted(key(feature["geometry"]["coordinates"][0][:3]) for feature in theirs)
    without_holes = exported(run, tiles, tmp_path)
    solid = triangles_of(tiles, lambda tile: ~tile.holes)
    assert sorted(solid) == sorted(key(feature["geometry"]["coordinates"][0][:3]) for feature in without_holes)
    assert len(found) - len(solid) == tiles.metadata.hole_triangles > 0


def test_triangles_are_counter_clockwise_and_corners_are_vertices_of_other_tiles(tiles):
    points = [tile.points for tile in tiles.tiles()]
    assert sum(map(len, points)) == tiles.metadata.vertices
    for tile in tiles.tiles():
        a, b, c = (tile.corners[tile.triangles[:, corner]] for corner in range(3))
        assert ((b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]).all()
        owners, indices = tile.others
        foreign = tile.corners[len(tile.points) :]
        assert len(owners) == len(indices) == len(foreign)
        for owner, index, corner in zip(owners.tolist(), indices.tolist(), foreign.tolist(), strict=True):
            assert owner != tile.id and points[owner][index].tolist() == corner


def test_constraints_are_the_edges_that_the_tool_exports(tiles, run, tmp_path):
    ours = set()
    for tile in tiles.tiles():
        ends = np.stack([tile.triangles, np.roll(tile.triangles, -1, axis=1)], axis=-1)[tile.constraints]
        ours |= {key(edge) for edge in tile.corners[ends].tolist()}
    theirs = {
        key(feature["geometry"]["coordinates"]) for feature in exported(run, tiles, tmp_path, "--what", "edges")
    }
    assert ours == theirs and len(ours) == tiles.metadata.constraint_edges
    rows = pyarrow.table(tiles.arrow("edges")).to_pylist()
    assert {key([(row["x0"], row["y0"]), (row["x1"], row["y1"])]) for row in rows} == theirs
    assert {row["kind"] for row in rows} == {"break_line", "wall", "obstacle"} or len(theirs) == len(rows)


def test_tables_have_the_rows_of_tiles(tiles):
    triangles = pyarrow.table(tiles.arrow())
    vertices = pyarrow.table(tiles.arrow("vertices"))
    all_tiles = list(tiles.tiles())
    assert triangles["tile"].to_pylist() == [tile.id for tile in all_tiles for _ in tile.triangles]
    joined = {
        "triangle": [tile.triangle_ids for tile in all_tiles],
        "region": [tile.regions for tile in all_tiles],
        "hole": [tile.holes for tile in all_tiles],
    }
    for corner in range(3):
        joined[f"x{corner}"] = [tile.corners[tile.triangles[:, corner], 0] for tile in all_tiles]
        joined[f"y{corner}"] = [tile.corners[tile.triangles[:, corner], 1] for tile in all_tiles]
        joined[f"z{corner}"] = [tile._corner_z[tile.triangles[:, corner]] for tile in all_tiles]
    for name, arrays in joined.items():
        assert triangles[name].to_numpy().tolist() == np.concatenate(arrays).tolist(), name
    assert vertices["record"].to_pylist() == np.concatenate([tile.records for tile in all_tiles]).tolist()
    for axis, name in enumerate("xy"):
        assert vertices[name].to_pylist() == np.concatenate([tile.points[:, axis] for tile in all_tiles]).tolist()
    assert vertices["z"].to_pylist() == np.concatenate([tile.z for tile in all_tiles]).tolist()


def test_tables_can_be_read_again_and_by_other_packages(survey):
    table = survey.arrow("vertices")
    polars = pytest.importorskip("polars")
    assert pyarrow.table(table).equals(pyarrow.table(table))
    assert polars.DataFrame(table).height == polars.from_arrow(pyarrow.table(table)).height == survey.metadata.vertices


@pytest.mark.parametrize("kind", ["triangles", "vertices", "edges"])
def test_bounds_choose_rows(kind, survey):
    shapely = pytest.importorskip("shapely")
    bounds = (18.0, 55.0, 45.0, 82.0)
    frame, part = survey.to_geopandas(kind=kind), survey.to_geopandas(bounds, kind=kind)
    met = frame.geometry if kind == "triangles" else frame.geometry.envelope
    expected = frame[met.intersects(shapely.box(*bounds))]
    assert 0 < len(part) < len(frame) and part.reset_index(drop=True).equals(expected.reset_index(drop=True))
    assert part.crs == "EPSG:25832"
    ids = survey.tile_ids(bounds)
    assert set(part["tile"]) <= set(ids) < set(survey.tile_ids()) == set(range(survey.metadata.tiles))
    assert [tile.id for tile in survey.tiles(bounds)] == ids
    assert not survey.tile_ids((500, 500, 600, 600))


def places_of(tiles, xy) -> list[tuple]:
    """Returns the kind of each place, and the positions of the corners, of the edge or the vertex.

    They are None if the tile has the triangle, but another tile owns it, so that the arrays do not have it.
    """
    found, rows = tiles.locate(xy), []
    for kind, owner, triangle, corner in zip(found.kind, found.tile, found.triangle, found.corner, strict=True):
        if kind == 0:
            assert (owner, triangle, corner) == (-1, -1, -1)
            rows.append(("outside", ()))
            continue
        tile = tiles.tile(owner)
        if kind == 3:
            rows.append(("vertex", key([tile.points[corner].tolist()])))
            continue
        at = np.flatnonzero(tile.triangle_ids == triangle)
        if len(at) == 0:
            rows.append((("triangle", "edge")[kind - 1], None))
            continue
        ring = tile.corners[tile.triangles[at[0]]]
        if kind == 1:
            rows.append(("triangle", key(ring.tolist())))
        else:
            rows.append(("edge", key(ring[[corner, (corner + 1) % 3]].tolist())))
    return rows


def test_places_are_those_of_the_tool(tiles, run, tmp_path):
    min_x, min_y, max_x, max_y = tiles.bounds
    random = np.random.default_rng(2).uniform((min_x - 2, min_y - 2), (max_x + 2, max_y + 2), (300, 2))
    tile = tiles.tile(0)
    ends = tile.corners[tile.triangles[:20, :2]]
    xy = np.concatenate([random, tile.points[:30], ends.mean(axis=1), np.round(random[:50])])
    (tmp_path / "batch.csv").write_text("".join(f"{x!r},{y!r}\n" for x, y in xy.tolist()))
    points = [each.points for each in tiles.tiles()]
    theirs = []
    printed = run("query", "locate", tiles.name, "--batch", tmp_path / "batch.csv", "--csv")
    for row in csv.DictReader(printed.splitlines()):
        names = [row[f"vertex_{i}"] for i in range(3) if row[f"vertex_{i}"]]
        numbers = [tuple(map(int, name.split(":"))) for name in names]
        theirs.append((row["element"], key([points[owner][index].tolist() for owner, index in numbers])))
    ours = places_of(tiles, xy)
    for mine, other in zip(ours, theirs, strict=True):
        assert mine == other or (mine[0] == other[0] and mine[1] is None)
    assert sum(corners is not None for _, corners in ours) > len(ours) / 2
    assert {kind for kind, _ in ours} == {"outside", "triangle", "edge", "vertex"}
    assert tiles.locate(xy).inside.tolist() == [kind != "outside" for kind, _ in ours]


numbers = st.one_of(st.floats(-5, 105), st.floats(), st.integers(-5, 105).map(float))


@given(st.lists(st.tuples(numbers, numbers), max_size=12))
def test_places_agree_with_exact_orientations(survey, points):
    for point, (kind, corners) in zip(points, places_of(survey, points), strict=True):
        if kind == "outside" or corners is None:
            continue
        assert np.isfinite(point).all()
        x, y = map(Fraction, point)
        if kind == "vertex":
            assert corners == (point,)
            continue
        exact = [(Fraction(cx), Fraction(cy)) for cx, cy in corners]
        sides = []
        for (ax, ay), (bx, by) in zip(exact, exact[1:] + exact[:1], strict=True):
            sides.append((bx - ax) * (y - ay) - (by - ay) * (x - ax))
        if kind == "edge":
            assert sides[0] == 0
        else:
            assert all(side > 0 for side in sides) or all(side < 0 for side in sides)


def test_points_that_are_not_finite_are_outside(survey):
    wrong = [(np.nan, 5), (5, np.nan), (np.inf, 5), (5, -np.inf), (1e300, 5), (5e-324, -5)]
    assert survey.locate(wrong).kind.tolist() == [0] * 6 and len(survey.locate(wrong)) == 6
    assert survey.locate([]).kind.shape == (0,) and len(survey.locate((50, 50))) == 1


WRONG = [
    (lambda t: t.locate(np.zeros((2, 3))), ValueError, "xy must have the shape"),
    (lambda t: t.locate([("a", "b")]), TypeError, "xy must hold real numbers"),
    (lambda t: t.locate(np.broadcast_to(1.0, (10**12, 2))), MemoryError, "allocate"),
    (lambda t: t.tile(-1), IndexError, "no tile -1"),
    (lambda t: t.tile(10**6), IndexError, "no tile 1000000; the file has"),
    (lambda t: t.tile(2**70), IndexError, "no tile"),
    (lambda t: t.tile(0.0), TypeError, "whole number, not float"),
    (lambda t: t.arrow("faces"), ValueError, "'triangles', 'vertices' or 'edges', not 'faces'"),
    (lambda t: t.arrow(bounds=(1, 1, 0, 0)), ValueError, "lower ends first"),
    (lambda t: t.tile_ids((0, 0, np.nan, 1)), ValueError, "no NaN"),
    (lambda t: t.tile_ids((0, 0)), ValueError, "bounds must be"),
    (lambda t: t.tile_ids("abcd"), ValueError, "bounds must be"),
    (lambda t: list(t.tiles(5)), ValueError, "bounds must be"),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_wrong_arguments_are_named(survey, number):
    act, error, text = WRONG[number]
    with pytest.raises(error, match=text):
        act(survey)


@pytest.mark.parametrize(("name", "vertices"), [("none", 0), ("one", 1), ("two", 2), ("line", 3)])
def test_small_files_have_no_triangles(small, name, vertices):
    t = small[name]
    assert sum(len(tile.points) for tile in t.tiles()) == t.metadata.vertices == vertices
    assert all(tile.triangles.shape == tile.constraints.shape == (0, 3) for tile in t.tiles())
    for kind, count in (("triangles", 0), ("edges", 0), ("vertices", vertices)):
        assert pyarrow.table(t.arrow(kind)).num_rows == len(t.to_geopandas(kind=kind)) == count
    assert t.locate([(1, 2), (9, 9)]).kind.shape == (2,) and t.verify(deep=True).vertices == vertices
    assert (t.bounds is None) == (vertices == 0)
