"""A build from arrays and geometries makes the triangulation that the tool makes from files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, collection
from hypothesis import given, settings
from hypothesis import strategies as st

import delaunay_tiles as dt

XY = np.random.default_rng(3).uniform(-50, 50, (700, 2)).round(3)
XYZ = np.column_stack([XY, XY[:, 0] * 2 - XY[:, 1]])
SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)]


def digest(points, folder: Path, **options) -> str:
    """Builds a file, and returns the digest of its tiles. Leaves no file."""
    out = folder / "ours.tiles"
    summary = dt.build(points, out, **options)
    tiles = dt.open(out)
    assert tiles.metadata.vertices == summary.vertices and tiles.metadata.triangles == summary.triangles
    found = tiles.digest()
    assert found == tiles.metadata.digest
    out.unlink()
    assert not list(folder.glob("*.partial*"))
    return found.strip()


@pytest.fixture(scope="module")
def of_tool(run, tmp_path_factory):
    """Returns the digest of what the tool builds from points as raw f64, and other files."""

    def of_tool(points, *options: object, files: dict[str, str] | None = None, folder: Path | None = None) -> str:
        folder = folder or tmp_path_factory.mktemp("tool")
        rows = np.ascontiguousarray(points, dtype="<f8")
        rows.tofile(folder / "points.f64")
        for name, text in (files or {}).items():
            (folder / name).write_text(text)
        given = ["points.f64", "--dims", rows.shape[1]] if len(rows) or not files else []
        run("build", *given, *options, "-o", "tool.tiles", "--quiet", "--force", cwd=folder)
        return run("digest", "tool.tiles", "--recompute", cwd=folder).strip()

    return of_tool


class Sub(np.ndarray):
    """A subclass of arrays."""


def read_only(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flags.writeable = False
    return array


def memmap(array: np.ndarray, folder: Path) -> np.ndarray:
    array.tofile(folder / "array.bin")
    return np.memmap(folder / "array.bin", dtype=array.dtype, mode="r", shape=array.shape)


KINDS = {
    "an array": lambda rows: rows,
    "by columns": np.asfortranarray,
    "every second row": lambda rows: np.repeat(rows, 2, axis=0)[::2],
    "backwards": lambda rows: rows[::-1].copy()[::-1],
    "columns of more": lambda rows: np.hstack([np.zeros((len(rows), 1)), rows])[:, 1:],
    "big-endian": lambda rows: rows.astype(">f8"),
    "long doubles": lambda rows: rows.astype(np.longdouble),
    "read-only": read_only,
    "a subclass": lambda rows: rows.view(Sub),
    "a masked array": np.ma.masked_array,
    "a memory view": memoryview,
    "unaligned": lambda a: np.frombuffer(b"\0" + a.tobytes(), np.uint8)[1:].view(np.float64).reshape(a.shape),
    "a list of lists": lambda rows: rows.tolist(),
    "a list of tuples": lambda rows: list(map(tuple, rows.tolist())),
    "a tuple": lambda rows: tuple(map(tuple, rows.tolist())),
    "rows of arrays": list,
    "a generator of rows": lambda rows: (tuple(row) for row in rows.tolist()),
    "a list of arrays": lambda rows: [rows[:100], rows[100:101], rows[101:101], rows[101:]],
    "a generator of arrays": lambda rows: (part for part in np.array_split(rows, 7)),
    "nested": lambda rows: [[rows[:100]], iter([rows[100:].tolist()])],
}


@pytest.mark.parametrize("width", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_any_kind_of_array_gives_the_digest_of_the_tool(kind, width, of_tool, tmp_path):
    rows = XYZ[:, :width].copy()
    before = rows.copy()
    assert digest(KINDS[kind](rows), tmp_path, tile_vertices=128) == of_tool(before)
    assert np.array_equal(rows, before)


def test_arrays_on_disk_are_read(of_tool, tmp_path):
    assert digest(memmap(XYZ, tmp_path), tmp_path) == of_tool(XYZ)


@pytest.mark.parametrize("kind", ["f4", "f2", "i1", "u1", "i4", ">i4", "u8", "i8"])
def test_other_numbers_are_those_of_float64(kind, of_tool, tmp_path):
    rows = (np.abs(XY) if kind.startswith("u") else XY).astype(kind)
    assert digest(rows, tmp_path) == of_tool(rows.astype(np.float64))


def test_more_points_than_are_converted_at_once(of_tool, tmp_path):
    rows = np.random.default_rng(4).random((300_000, 2), dtype=np.float32)
    expected = of_tool(rows.astype(np.float64))
    assert digest(rows, tmp_path) == expected
    assert digest(iter(rows.tolist()), tmp_path) == expected


def test_text_and_paths_are_files(of_tool, run, tmp_path):
    text = "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in XYZ.tolist())
    (tmp_path / "points.csv").write_text("x,y,z\n" + text)
    expected = of_tool(XYZ)
    for path in (tmp_path / "points.csv", str(tmp_path / "points.csv"), bytes(tmp_path / "points.csv")):
        assert digest(path, tmp_path) == expected
    assert digest([tmp_path / "points.csv", np.empty((0, 3))], tmp_path) == expected


@pytest.mark.parametrize("rows", [[], [(1, 2)], [(1, 2), (1, 2)], [(0, 0), (1, 1), (2, 2)], [(0, 0), (4, 0), (0, 4)]])
def test_few_points_are_a_file_too(rows, of_tool, tmp_path):
    assert digest(rows, tmp_path) == of_tool(np.reshape(np.array(rows, dtype=np.float64), (-1, 2)))
    summary = dt.build(rows, tmp_path / "few.tiles")
    assert summary.points == len(rows) and summary.vertices == len(set(rows))


@pytest.mark.parametrize("options", [{"tile_vertices": 16}, {"memory": "16MiB", "threads": 1}, {"threads": 3}])
def test_tiles_memory_and_threads_do_not_matter(options, of_tool, tmp_path):
    rows = np.random.default_rng(5).random((20_000, 2))
    assert digest(rows, tmp_path, compress=True, **options) == of_tool(rows)


@pytest.mark.parametrize("which", ["first", "lowest", "highest"])
def test_duplicates_are_chosen_as_by_the_tool(which, of_tool, tmp_path):
    rows = np.concatenate([XYZ, XYZ[::3] + (0, 0, 1), XYZ[::5] - (0, 0, 3)])
    assert digest(rows, tmp_path, duplicates=which) == of_tool(rows, "--duplicates", which)
    with pytest.raises(dt.BuildError, match="record"):
        dt.build(rows, tmp_path / "no.tiles", duplicates="error")
    assert dt.build(rows, tmp_path / "counted.tiles").duplicates == len(rows) - len(XYZ)


cell = st.integers(0, 12)
place = st.tuples(cell, cell)
point_sets = st.lists(st.tuples(cell, cell, st.integers(-5, 5)), max_size=40)
line_sets = st.lists(st.lists(place, min_size=2, max_size=4), max_size=4)
sites_sets = st.lists(place, max_size=3, unique=True)
triangles = st.tuples(place, place, place).filter(
    lambda t: (t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) != (t[1][1] - t[0][1]) * (t[2][0] - t[0][0])
)


class Shape:
    """An object with `__geo_interface__`."""

    def __init__(self, kind, coordinates):
        self.__geo_interface__ = {"type": kind, "coordinates": coordinates}


def as_shapely(kind, coordinates):
    import shapely

    return shapely.geometry.shape({"type": kind, "coordinates": coordinates})


def as_array(kind, coordinates):
    return np.array(coordinates if kind == "LineString" else coordinates[0])


FORMS = {
    "arrays": as_array,
    "interfaces": Shape,
    "mappings": lambda kind, coordinates: {"type": kind, "coordinates": coordinates},
    "features": lambda *shape: {"type": "Feature", "geometry": dict(zip(("type", "coordinates"), shape, strict=True))},
    "shapely": as_shapely,
    "bytes": lambda kind, coordinates: as_shapely(kind, coordinates).wkb,
    "series": as_shapely,
}


def pass_shapes(form: str, kind: str, shapes: list):
    made = [FORMS[form](kind, shape) for shape in shapes]
    if form == "series":
        import geopandas

        return geopandas.GeoSeries(made)
    return made


@settings(max_examples=25)
@given(point_sets, line_sets, line_sets, st.lists(triangles, max_size=2), sites_sets, st.sampled_from(list(FORMS)))
def test_lines_polygons_and_sites_give_the_digest_of_the_tool(of_tool, points, lines, walls, rings, sites, form):
    folder = Path("lattice")
    folder.mkdir(exist_ok=True)
    rows = np.array(points, dtype=np.float64).reshape(-1, 3)
    polygons = [[[*ring, ring[0]]] for ring in rings]
    files = {
        "lines.geojson": collection("LineString", lines),
        "walls.geojson": collection("LineString", walls),
        "obstacles.geojson": collection("Polygon", polygons),
        "sites.csv": "".join(f"{x},{y},s{number}\n" for number, (x, y) in enumerate(sites)),
    }
    given = ["--segments", "lines.geojson", "--walls", "walls.geojson", "--obstacles", "obstacles.geojson"]
    options = ["--sites", "sites.csv", "--crossings", "split"]
    expected = of_tool(rows, *given, *options, files=files, folder=folder)
    builder = dt.Builder(folder / "ours.tiles", crossings="split", overwrite=True)
    builder.add_lines(pass_shapes(form, "LineString", lines))
    builder.add_lines(pass_shapes(form, "LineString", walls), "walls")
    builder.add_lines(pass_shapes(form, "Polygon", polygons), "obstacles")
    builder.add_sites(np.array(sites).reshape(-1, 2), ids=[f"s{number}" for number in range(len(sites))])
    builder.add_points(rows)
    builder.finish()
    assert dt.open(folder / "ours.tiles").digest().strip() == expected


@pytest.mark.parametrize("form", ["arrays", "shapely", "series"])
@pytest.mark.parametrize("exterior", ["keep", "hole"])
def test_lines_with_z_ponds_and_the_exterior_are_those_of_the_tool(form, exterior, of_tool, tmp_path):
    lines = [[(-40.0, -40.0, 7.0), (40.0, -39.0, 9.0)]]
    pond = [[(-20.0, 5.0), (10.0, 5.0), (10.0, 30.0), (-20.0, 5.0)]]
    house = [[(20.0, -20.0), (30.0, -20.0), (30.0, -10.0), (20.0, -20.0)]]
    files = {
        "lines.geojson": collection("LineString", lines),
        "ponds.geojson": collection("Polygon", [pond]),
        "houses.geojson": collection("Polygon", [house]),
    }
    given = ["--flatten", "ponds.geojson", "--segments", "lines.geojson", "--obstacles", "houses.geojson"]
    expected = of_tool(XYZ, *given, "--exterior", exterior, files=files)
    shapes = {
        "lines": pass_shapes(form, "LineString", lines),
        "ponds": pass_shapes(form, "Polygon", [pond]),
        "obstacles": pass_shapes(form, "Polygon", [house]),
    }
    assert digest(XYZ, tmp_path, exterior=exterior, **shapes) == expected
    (tmp_path / "files").mkdir()
    for name, text in files.items():
        (tmp_path / "files" / name).write_text(text)
    paths = {"lines": "lines.geojson", "ponds": "ponds.geojson", "obstacles": "houses.geojson"}
    paths = {name: tmp_path / "files" / path for name, path in paths.items()}
    assert digest(XYZ, tmp_path, exterior=exterior, **paths) == expected
    lists = {name: [path] for name, path in paths.items()}
    assert digest(XYZ, tmp_path, exterior=exterior, **lists) == expected


@pytest.mark.parametrize("missing_z", ["drape", "zero"])
def test_missing_z_is_found_as_by_the_tool(missing_z, of_tool, tmp_path):
    lines = [[(-40.0, -40.0), (40.0, -39.0)]]
    files = {"lines.geojson": collection("LineString", lines)}
    expected = of_tool(XYZ, "--segments", "lines.geojson", "--missing-z", missing_z, files=files)
    assert digest(XYZ, tmp_path, lines=lines, missing_z=missing_z) == expected
    with pytest.raises(dt.BuildError, match="missing_z"):
        dt.build(XYZ, tmp_path / "no.tiles", lines=lines, missing_z="error")


def test_points_in_holes_make_holes(tmp_path):
    corners = [(0, 0), (10, 0), (10, 10), (0, 10)]
    nodes = "".join(f"{number} {x} {y}\n" for number, (x, y) in enumerate(corners))
    poly = tmp_path / "plan.poly"
    poly.write_text(f"4 2 0 0\n{nodes}4 0\n0 0 1\n1 1 2\n2 2 3\n3 3 0\n1\n0 5 5\n")
    out = tmp_path / "poly.tiles"
    assert dt.build(poly, out).hole_triangles == 2
    found = dt.open(out).digest()
    summary = dt.build(corners, tmp_path / "array.tiles", walls=[SQUARE], holes=[(5, 5)])
    assert summary.hole_triangles == 2 and summary.hole_regions == 1
    ours = dt.open(tmp_path / "array.tiles").digest()
    assert [line.split() for line in ours.splitlines()[:4]] == [line.split() for line in found.splitlines()[:4]]


def test_lines_alone_are_a_file(of_tool, tmp_path):
    files = {"house.geojson": collection("Polygon", [[SQUARE]])}
    assert digest(None, tmp_path, obstacles=[SQUARE]) == of_tool([], "--obstacles", "house.geojson", files=files)


def test_crossing_lines_are_an_error_that_names_them(tmp_path):
    with pytest.raises(dt.BuildError, match=r"(?s)lines: feature 0.*feature 1.*\(5, 5\).*crossings='split'"):
        dt.build(XY, tmp_path / "no.tiles", lines=[[(0, 0), (10, 10)], [(0, 10), (10, 0)]])
    assert not list(tmp_path.iterdir())


FILTERS = {
    "classes": ({"classes": [2]}, ["--class", 2]),
    "a class": ({"classes": 2}, ["--class", 2]),
    "every": ({"every": 3}, ["--every", 3]),
    "bounds": ({"bounds": (636500, 849500, 637500, 851000)}, ["--bounds", "636500,849500,637500,851000"]),
    "returns": ({"returns": "last"}, ["--returns", "last"]),
    "format": ({"format": "las"}, ["--format", "las"]),
}


@pytest.mark.parametrize("kind", FILTERS)
def test_options_of_a_point_file_are_those_of_the_tool(kind, run, tmp_path):
    las = DATA / "las" / "autzen.las"
    ours, theirs = FILTERS[kind]
    run("build", las, *theirs, "-o", "tool.tiles", "--quiet", cwd=tmp_path)
    summary = dt.build(dt.PointFile(las, **ours), tmp_path / "ours.tiles")
    assert 0 < summary.points and (kind == "format") == (summary.points == 106)
    assert dt.open(tmp_path / "ours.tiles").digest() == dt.open(tmp_path / "tool.tiles").digest()


def test_columns_of_text_are_chosen(tmp_path):
    rows = "".join(f"{z},{y},{x}\n" for x, y, z in XYZ.tolist())
    (tmp_path / "p.csv").write_text("height,north,east\n" + rows)
    file = dt.PointFile(tmp_path / "p.csv", columns="east,north,height")
    assert digest(file, tmp_path) == digest(XYZ, tmp_path)
    assert digest(dt.PointFile(tmp_path / "p.csv", columns="3,2"), tmp_path) == digest(XY, tmp_path)


WRONG_FILES = [
    ({"dims": 4}, ValueError, "dims"),
    ({"every": 0}, ValueError, "every"),
    ({"columns": "a,b"}, ValueError, "a"),
    ({"format": "docx"}, ValueError, "docx"),
    ({"returns": "second"}, ValueError, "second"),
    ({"bounds": (1, 2)}, (TypeError, ValueError), "bounds"),
    ({"classes": [300]}, ValueError, "classes"),
    ({"classes": "2"}, ValueError, "classes"),
]


@pytest.mark.parametrize(("options", "error", "text"), WRONG_FILES, ids=[str(row[0]) for row in WRONG_FILES])
def test_wrong_options_of_a_point_file_are_refused(options, error, text, tmp_path):
    (tmp_path / "p.csv").write_text("x,y\n0,0\n1,0\n0,1\n")
    with pytest.raises(error, match=text):
        dt.build(dt.PointFile(tmp_path / "p.csv", **options), tmp_path / "no.tiles")
    assert [path.name for path in tmp_path.iterdir()] == ["p.csv"]


def test_the_summary_has_the_counts_of_the_file(survey, tmp_path):
    calls = []
    summary = dt.build(
        XYZ, tmp_path / "s.tiles", sites=XY[:3], walls=[[(0, 0), (1, 1)]], progress=lambda *state: calls.append(state)
    )
    about = dt.open(tmp_path / "s.tiles").metadata
    for name in ("vertices", "triangles", "hull_edges", "points", "constraint_edges", "sites", "tiles", "file_bytes"):
        assert getattr(summary, name) == getattr(about, name), name
    assert summary.file_bytes == (tmp_path / "s.tiles").stat().st_size and summary.notes == ()
    assert about.has_z and json.dumps(about.digest)
