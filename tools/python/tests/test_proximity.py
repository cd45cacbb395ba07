"""Answers by distance are those of the tool, bit for bit."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

NOTHING = ""


def questions(tiles, count: int, seed: int, width: int = 2) -> np.ndarray:
    """Returns random points in the bounds of a file, and a little outside of them."""
    min_x, min_y, max_x, max_y = tiles.bounds
    low, high = np.array([min_x, min_y]) - 0.3, np.array([max_x, max_y]) + 0.3
    return np.random.default_rng(seed).uniform(low, high, (count * width // 2, 2)).reshape(count, width)


@pytest.fixture(params=["town", "islands"])
def tiles(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def ask(run, tmp_path):
    """Asks the tool a batch of questions, and returns the rows of its table, or its objects."""

    def ask(kind: str, tiles, rows: np.ndarray, *options: object, form: str = "--csv") -> list[dict]:
        batch = tmp_path / "batch.csv"
        batch.write_text("\n".join(",".join(map(repr, row)) for row in rows.tolist()) + "\n")
        text = run("query", kind, tiles.name, "--batch", batch, form, *options)
        lines = text.splitlines()
        return list(csv.DictReader(lines)) if form == "--csv" else [json.loads(line) for line in lines]

    return ask


def number(text: str) -> float:
    return float(text) if text else np.nan


def of_sites(answer, xy, names) -> list[tuple]:
    """Returns the rows that the tool prints of an answer about sites."""
    rows = []
    for (x, y), end, one in zip(xy.tolist(), answer.status, answer, strict=True):
        found = zip(one.site.tolist(), one.xy.tolist(), one.distance, one.lower, one.upper, strict=True)
        for rank, (site, at, *numbers) in enumerate([each for each in found if each[0] >= 0], 1):
            rows.append((x, y, "ok", str(rank), names[site], *at, *numbers))
        if end != "ok":
            rows.append((x, y, end, NOTHING, NOTHING, np.nan, np.nan, np.nan, one.bound, np.nan))
    return rows


def printed_sites(rows: list[dict]) -> list[tuple]:
    """Returns the rows of a table of sites."""
    return [
        (
            *(float(row[name]) for name in ("x", "y")),
            *(row[name] for name in ("status", "rank", "site")),
            *(number(row[name]) for name in ("to_x", "to_y", "distance", "lower", "upper")),
        )
        for row in rows
    ]


def assert_same(ours: list[tuple], theirs: list[tuple]) -> None:
    """Compares rows; a number that is not given is equal to itself."""
    assert len(ours) == len(theirs)
    for mine, other in zip(ours, theirs, strict=True):
        for a, b in zip(mine, other, strict=True):
            assert a == b or (a != a and b != b), (mine, other)


def site_names(tiles) -> list[str]:
    """Returns the names that the tool prints for sites: the ids, or else the numbers."""
    near = tiles.nearest(tiles.bounds[:2], tiles.metadata.sites, "sites")
    texts = [str(number) if text is None else text for number, text in zip(near.site, near.id, strict=True)]
    return [text for _, text in sorted(zip(near.site.tolist(), texts, strict=True))]


@pytest.mark.parametrize("mode", ["exact", "fast", "within:0.05"])
def test_the_nearest_sites_are_those_of_the_tool(tiles, ask, mode):
    xy = questions(tiles, 60, 1)
    rows = ask("knn", tiles, xy, "-k", 4, "--mode", mode)
    assert_same(of_sites(tiles.knn(xy, 4, mode), xy, site_names(tiles)), printed_sites(rows))


def test_at_a_limit_the_answers_are_those_of_the_tool(town, ask):
    xy = questions(town, 60, 2)
    rows = ask("knn", town, xy, "-k", 9, "--max-tiles", 2)
    answer = town.knn(xy, 9, max_tiles=2)
    assert_same(of_sites(answer, xy, site_names(town)), printed_sites(rows))
    is_stopped = answer.status == "out_of_budget"
    assert is_stopped.any() and not is_stopped.all()
    missing = is_stopped[:, None] & (answer.site < 0)
    bounds = np.broadcast_to(answer.bound[:, None], missing.shape)
    assert np.isnan(answer.distance[missing]).all() and (answer.upper[missing] == np.inf).all()
    assert (answer.lower[missing] == bounds[missing]).all()


@pytest.mark.parametrize("mode", ["exact", "fast"])
def test_the_sites_within_a_distance_are_those_of_the_tool(tiles, ask, mode):
    xy = questions(tiles, 20, 3)
    rows = ask("range", tiles, xy, "--radius", 4.5, "--mode", mode)
    reached = tiles.within(xy, 4.5, mode)
    assert_same(of_sites(reached, xy, site_names(tiles)), printed_sites(rows))
    assert reached.offsets[-1] == len(reached.site) == len(reached.xy)
    # All sites are as exact.
    everywhere = [tiles.within(xy, np.inf, of) for of in [mode, "exact"]]
    assert_same(*[of_sites(reached, xy, site_names(tiles)) for reached in everywhere])


def path_object(path) -> dict:
    """Returns what the tool prints of a path."""
    texts = {"turns": lambda bend: bend.turns, "vertex": lambda bend: "{}:{}".format(*bend.vertex)}
    texts["edge_to"] = lambda bend: bend.edge_to and "{}:{}".format(*bend.edge_to)
    texts["at"] = lambda bend: list(bend.xy)
    texts["lines"] = lambda bend: [{"kind": kind, "line": number} for kind, number in bend.lines]
    bends = [{name: of(bend) for name, of in texts.items()} for bend in path.bends]
    return {"points": path.points.tolist(), "bends": bends, "certified": path.certified}


@pytest.mark.parametrize(("mode", "certified"), [("exact", False), ("exact", True), ("fast", False)])
def test_paths_and_their_bends_are_those_of_the_tool(tiles, ask, mode, certified):
    ends = questions(tiles, 40, 4, 4)
    options = ["--mode", mode, *(["--certify"] if certified else [])]
    objects = ask("path", tiles, ends, *options, form="--json")
    paths = tiles.paths(ends[:, :2], ends[:, 2:], mode, certified=certified)
    assert len(paths) == len(objects)
    for path, theirs in zip(paths, objects, strict=True):
        assert path.status == theirs["status"] and bool(path) == (path.status == "ok")
        if path:
            assert [path.distance, path.lower, path.upper] == [theirs[name] for name in ("distance", "lower", "upper")]
            assert path_object(path) == theirs["path"]
        if path.status == "inside_obstacle":
            assert path.nearest_free.tolist() == theirs["nearest_free"]
            assert path.inside_point.tolist() == theirs["inside_point"]
            assert np.isnan([path.distance, path.lower, path.upper]).all()
    assert {"ok", "inside_obstacle"} <= set(paths.status)


def test_paths_to_sites_are_those_of_questions_for_paths(town):
    xy = questions(town, 20, 5)
    near = town.knn(xy, 3, paths=True)
    assert len(near.paths) == (near.site >= 0).sum()
    for at, one in zip(xy, near, strict=True):
        for path, end, distance in zip(one.paths, one.xy, one.distance, strict=False):
            direct = town.path(at, end)
            assert path.distance == distance == pytest.approx(direct.distance, rel=1e-12)
            assert path.points[0].tolist() == at.tolist() and path.points[-1].tolist() == end.tolist()
            assert len(path.bends) == len(path.points) - 2


def test_a_matrix_is_that_of_the_tool(tiles, run, tmp_path):
    starts, ends = questions(tiles, 6, 6), questions(tiles, 9, 7)
    for name, points in (("from.csv", starts), ("to.csv", ends)):
        (tmp_path / name).write_text("\n".join(",".join(map(repr, row)) for row in points.tolist()) + "\n")
    files = ["--from-file", tmp_path / "from.csv", "--to-file", tmp_path / "to.csv"]
    rows = list(csv.DictReader(run("query", "matrix", tiles.name, *files, "--csv").splitlines()))
    matrix = tiles.matrix(starts, ends)
    assert matrix.distance.shape == matrix.status.shape == (6, 9) and len(rows) == 54
    for row in rows:
        cell = int(row["from_index"]), int(row["to_index"])
        assert matrix.status[cell] == row["status"]
        if row["status"] == "ok":
            ours = [array[cell] for array in (matrix.distance, matrix.lower, matrix.upper)]
            assert ours == [float(row[name]) for name in ("distance", "lower", "upper")]


def test_the_sites_along_a_line_are_those_of_the_tool(tiles, ask):
    names = site_names(tiles)
    for line in questions(tiles, 3, 8, 4):
        (theirs,) = ask("along", tiles, line.reshape(1, 4), "-k", 2, form="--json")
        along = tiles.along(line[:2], line[2:], 2)
        assert len(along) == len(theirs["intervals"]) and along.status == theirs["status"]
        for i, interval in enumerate(theirs["intervals"]):
            assert [along.from_t[i], along.to_t[i]] == [interval["from_t"], interval["to_t"]]
            assert [along.start[i].tolist(), along.end[i].tolist()] == [interval["from"], interval["to"]]
            assert along.free[i] == (interval["status"] == "ok")
            found = along.site[i] >= 0
            sites = interval["sites"] or []
            assert [names[site] for site in along.site[i][found]] == [site["site"] for site in sites]
            assert along.xy[i][found].tolist() == [site["to"] for site in sites]
            both = np.stack([along.from_distance[i], along.to_distance[i]], axis=1)
            assert both[found].tolist() == [site["distances"] for site in sites]
            rest = np.inf if along.free[i] else np.nan
            assert np.array_equal(both[~found], np.full((len(found) - len(sites), 2), rest), equal_nan=True)


def test_the_area_within_reach_is_that_of_the_tool(tiles, ask):
    xy = questions(tiles, 8, 9)
    rows = ask("range", tiles, xy, "--radius", 1.2, "--area", form="--json")
    for at, row in zip(xy, rows, strict=True):
        reach = tiles.reach(at, 1.2)
        assert reach.status == row["status"]
        assert reach.area == row.get("area", 0.0)
        if reach.status == "inside_obstacle":
            assert reach.nearest_free.tolist() == row["nearest_free"] and not reach.polygons


@pytest.mark.parametrize("of", ["vertices", "sites"])
def test_the_euclidean_nearest_are_those_of_the_tool(tiles, ask, of):
    xy = questions(tiles, 40, 10)
    rows = ask("nearest", tiles, xy, "-k", 3, *(["--vertices"] if of == "vertices" else []))
    near, names = tiles.nearest(xy, 3, of), site_names(tiles)
    ours = [
        (x, y, "ok", str(rank), f"{tile}:{index}", names[site] if site >= 0 else "", *at, distance)
        for (x, y), one in zip(xy.tolist(), near, strict=True)
        for rank, (tile, index, site, at, distance) in enumerate(
            zip(one.tile, one.index, one.site, one.xy.tolist(), one.distance, strict=True), 1
        )
    ]
    columns = ("to_x", "to_y", "distance")
    theirs = [
        (
            *(float(row[name]) for name in ("x", "y")),
            *(row[name] for name in ("status", "rank", "vertex", "site")),
            *(float(row[name]) for name in columns),
        )
        for row in rows
    ]
    assert_same(ours, theirs)


def test_the_footing_is_that_of_the_tool(tiles, ask):
    xy = questions(tiles, 60, 11)
    rows = ask("locate", tiles, xy, form="--json")
    footing = tiles.footing(xy)
    assert footing.status.tolist() == [row["status"] for row in rows]
    expected = [row.get("nearest_free", at) for row, at in zip(rows, xy.tolist(), strict=True)]
    assert footing.nearest_free.tolist() == expected
    assert tiles.footing(footing.nearest_free[footing.free]).free.all()
