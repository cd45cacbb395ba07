"""Tables, frames and objects of other packages as points and sites; and what is refused, with which words."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest

import delaunay_tiles as dt

geopandas = pytest.importorskip("geopandas")
pandas = pytest.importorskip("pandas")
polars = pytest.importorskip("polars")
pyarrow = pytest.importorskip("pyarrow")
shapely = pytest.importorskip("shapely")

XY = np.random.default_rng(8).uniform(0, 9, (60, 2)).round(2)
XYZ = np.column_stack([XY, XY.sum(axis=1)])
X, Y, Z = XYZ.T


def digest_of(points, folder, **options) -> str:
    dt.build(points, folder / "t.tiles", overwrite=True, **options)
    return dt.open(folder / "t.tiles").digest()


def geoarrow(width: int, *, is_interleaved: bool):
    """Returns a table with a column of GeoArrow points."""
    rows = XYZ[:, :width]
    if is_interleaved:
        column = pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(rows.ravel()), width)
    else:
        column = pyarrow.StructArray.from_arrays(list(map(pyarrow.array, rows.T)), names=list("xyz"[:width]))
    metadata = {b"ARROW:extension:name": b"geoarrow.point"}
    return pyarrow.table([column], schema=pyarrow.schema([pyarrow.field("geometry", column.type, metadata=metadata)]))


class Las:
    """Points as laspy has them."""

    point_format = 3

    def __init__(self, rows: np.ndarray) -> None:
        self.x, self.y, self.z = rows.T

    def __len__(self) -> int:
        return len(self.x)


def table(**columns):
    return pyarrow.table(columns)


TABLE = table(x=X, y=Y, z=Z)
SERIES = geopandas.GeoSeries(shapely.points(XYZ))
SAME = {
    "a table": lambda: TABLE,
    "other columns too": lambda: table(name=["a"] * len(X), z=Z, y=Y, x=X),
    "capitals": lambda: table(X=X, Y=Y, Z=Z),
    "lon, lat, height": lambda: table(lon=X, lat=Y, height=Z),
    "chunks": lambda: pyarrow.concat_tables([TABLE.slice(0, 7), TABLE.slice(7, 0), TABLE.slice(7)]),
    "a stream": lambda: TABLE.to_reader(max_chunksize=9),
    "a record batch": lambda: TABLE.to_batches()[0],
    "GeoArrow, separated": lambda: geoarrow(3, is_interleaved=False),
    "GeoArrow, interleaved": lambda: geoarrow(3, is_interleaved=True),
    "pandas": lambda: pandas.DataFrame({"x": X, "y": Y, "z": Z}),
    "polars": lambda: polars.DataFrame({"z": Z, "x": X, "y": Y}),
    "a GeoSeries": lambda: SERIES,
    "a GeoDataFrame": lambda: geopandas.GeoDataFrame({"id": range(len(X))}, geometry=SERIES),
    "laspy": lambda: Las(XYZ),
    "several": lambda: [TABLE.slice(0, 20), Las(XYZ[20:30]), SERIES[30:40], polars.DataFrame(TABLE.slice(40))],
}


@pytest.mark.parametrize("kind", SAME)
def test_tables_and_frames_are_the_points_of_arrays(kind, tmp_path):
    assert digest_of(SAME[kind](), tmp_path) == digest_of(XYZ, tmp_path)


@pytest.mark.parametrize("is_interleaved", [False, True])
def test_slices_of_geoarrow_points_are_their_rows(is_interleaved, tmp_path):
    points = geoarrow(2, is_interleaved=is_interleaved)
    assert digest_of(points, tmp_path) == digest_of(XY, tmp_path)
    assert digest_of(points.slice(11, 30), tmp_path) == digest_of(XY[11:41], tmp_path)


@pytest.mark.parametrize("kind", ["float32", "float16", "int8", "uint64", "int32"])
def test_columns_may_hold_any_real_numbers(kind, tmp_path):
    rows = XY.astype(kind)
    expected = digest_of(rows.astype(np.float64), tmp_path)
    assert digest_of(table(x=rows[:, 0], y=rows[:, 1]), tmp_path) == expected
    if kind != "float16":
        mixed = polars.DataFrame({"x": rows[:, 0], "y": rows[:, 1].astype(np.float64)})
        assert digest_of(mixed, tmp_path) == expected


def test_decimals_are_numbers(tmp_path):
    columns = {name: pyarrow.array([1, 2, 5], pyarrow.decimal128(10, 2)) for name in "xz"}
    assert digest_of(table(y=[3, 9, 1], **columns), tmp_path) == digest_of([(1, 3, 1), (2, 9, 2), (5, 1, 5)], tmp_path)


def test_tables_without_rows_have_no_points(tmp_path):
    empty = [TABLE.slice(0, 0), TABLE.schema.empty_table(), pandas.DataFrame({"x": [], "y": []}, dtype=float)]
    empty += [polars.DataFrame(TABLE).clear(), geopandas.GeoSeries([]), Las(XYZ[:0])]
    empty += [geoarrow(2, is_interleaved=True)[:0], geoarrow(2, is_interleaved=False)[:0]]
    for points in empty:
        assert dt.build(points, tmp_path / "t.tiles", overwrite=True).vertices == 0, points


NAN = XY.copy()
NAN[17, 1] = np.nan
MIXED = [shapely.Point(0, 0, 1), shapely.Point(4, 1), shapely.Point(0, 3, 1)]

WRONG = {
    "NaN": (NAN, ValueError, r"record 17 .*NaN"),
    "NaN in a list": (NAN.tolist(), ValueError, r"record 17 .*NaN"),
    "NaN in float32": (NAN.astype("f4"), ValueError, r"record 17 .*NaN"),
    "NaN in the second array": ([XY, NAN], ValueError, "record 77 "),
    "z is NaN": (np.column_stack([XY, NAN[:, 1]]), ValueError, "record 17 has z NaN"),
    "infinite": (np.where(X == X[3], np.inf, X)[:, None] + [0, 1], ValueError, "record 3 .*inf"),
    "too large": (XY * 1e300, ValueError, "record 0 "),
    "too small": (XY * 1e-300, ValueError, "record 0 "),
    "objects": (XY.astype(object), TypeError, "real numbers, not object"),
    "texts": (XY.astype(str), TypeError, "real numbers"),
    "a text among numbers": ([(1, 2), ("3", 4)], TypeError, "real numbers"),
    "complex": (XY.astype(complex), TypeError, "real numbers, not complex"),
    "booleans": (XY > 5, TypeError, "real numbers, not bool"),
    "rows of booleans": ([(True, False), (False, True)], TypeError, "real numbers, not bool"),
    "dates": (np.zeros((4, 2), "M8[s]"), TypeError, "real numbers"),
    "records": (np.zeros(4, [("x", "f8"), ("y", "f8")]), ValueError, "shape"),
    "Decimal": ([(Decimal(1), 2), (3, 4)], TypeError, "not Decimal"),
    "one row": (XY[0], ValueError, r"shape \(n, 2\) or \(n, 3\), not \(2,\)"),
    "one number": (3.5, TypeError, "points must be an array"),
    "no axis": (np.float64(3), ValueError, r"not \(\)"),
    "three axes": (XY.reshape(5, 6, 4), ValueError, r"not \(5, 6, 4\)"),
    "four columns": (np.zeros((5, 4)), ValueError, r"not \(5, 4\)"),
    "one column": (XY[:, :1], ValueError, r"not \(60, 1\)"),
    "a tuple of numbers": ((1.0, 2.0), TypeError, r"points\[0\]"),
    "rows of several lengths": ([(1, 2), (3, 4, 5)], ValueError, "one length"),
    "None": (None, ValueError, "points must be given"),
    "Nones": ([None, XY], TypeError, r"points\[0\] .*not NoneType"),
    "None later": ([XY, None], TypeError, r"points\[1\] .*not NoneType"),
    "a mapping": ({"x": [1], "y": [2]}, TypeError, "not dict"),
    "masked": (np.ma.masked_array(XY, XY > 8.5), ValueError, "masked"),
    "huge": (np.broadcast_to(1.5, (10**12, 2)), dt.BuildError, "disk"),
    "huge in float32": (np.broadcast_to(np.float32(1.5), (10**12, 2)), dt.BuildError, "disk"),
    "huge in int8": (np.broadcast_to(np.int8(1), (10**12, 3)), dt.BuildError, "disk"),
    "huge laspy": (Las(np.broadcast_to(np.float64(1), (10**12, 3))), dt.BuildError, "disk"),
    "a null": (table(x=[1, None], y=[1, 2]), ValueError, "column x has nulls"),
    "a null z": (table(x=[1, 3], y=[1, 2], z=[None, 1]), ValueError, "column z has nulls"),
    "NaN in pandas": (pandas.DataFrame({"x": NAN[:, 0], "y": NAN[:, 1]}), ValueError, "column y has nulls"),
    "NaN in a table": (table(x=[1.0, 2.0], y=[1.0, np.nan]), ValueError, "record 1 .*NaN"),
    "a null in polars": (polars.DataFrame({"x": [1.0, None], "y": [1.0, 2.0]}), ValueError, "column x has nulls"),
    "no y": (table(x=[1.0], z=[2.0]), ValueError, "no columns x and y.* it has x, z"),
    "no columns": (table(), ValueError, "no columns x and y"),
    "no y and no rows": (table(x=pyarrow.array([], "f8")), ValueError, "no columns x and y"),
    "texts in a table": (table(x=["1"], y=["2"]), TypeError, "column x must hold numbers"),
    "booleans in a table": (table(x=[1.0], y=[True]), TypeError, "column y must hold numbers"),
    "numbers as columns": (pandas.DataFrame(XY), ValueError, "it has 0, 1"),
    "a series": (pandas.Series(X), TypeError, "one column"),
    "a polars series": (polars.Series(X), TypeError, "one column"),
    "a chunked array": (pyarrow.chunked_array([X]), TypeError, "one column"),
    "lines": (geopandas.GeoSeries([shapely.LineString([(0, 0), (1, 1)])]), ValueError, "has LineString"),
    "a missing point": (geopandas.GeoSeries([shapely.Point(0, 0), None]), ValueError, "points only; it has None"),
    "an empty point": (geopandas.GeoSeries([shapely.Point(0, 0), shapely.Point()]), ValueError, "record 1 .*NaN"),
    "some without z": (geopandas.GeoSeries(MIXED), ValueError, "row 1 has none"),
    "a shapely point": (shapely.Point(1, 2), TypeError, "not Point"),
    "laspy with NaN": (Las(np.column_stack([NAN, X])), ValueError, "record 17 "),
    "no such file": ("none.csv", FileNotFoundError, "none.csv"),
    "a zero byte": ("a\0b", ValueError, "zero byte"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_no_points_is_refused_and_leaves_no_file(kind, tmp_path):
    points, error, text = WRONG[kind]
    with pytest.raises(error, match=text):
        dt.build(points, tmp_path / "no.tiles")
    assert not list(tmp_path.iterdir())


def test_generators_that_fail_pass_their_exception_on(tmp_path):
    def rows():
        yield 1.0, 2.0
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        dt.build(rows(), tmp_path / "no.tiles")
    assert not list(tmp_path.iterdir())


OPTIONS = [
    ({"duplicates": "last"}, ValueError, "first, lowest or highest"),
    ({"crossings": "x"}, ValueError, "crossings must be 'error' or 'split', not 'x'"),
    ({"exterior": None}, TypeError, "exterior must be a text"),
    ({"missing_z": 0}, TypeError, "missing_z must be a text"),
    ({"tile_vertices": 0}, ValueError, "tile_vertices must be above 0"),
    ({"tile_vertices": 3}, ValueError, "from 4 to 262144"),
    ({"tile_vertices": 64.0}, TypeError, "tile_vertices must be a whole number"),
    ({"threads": -1}, ValueError, "threads must be above 0"),
    ({"threads": 10**6}, ValueError, "threads"),
    ({"memory": "much"}, ValueError, "memory must be a number of bytes"),
    ({"memory": 0}, ValueError, "memory must be above 0"),
    ({"memory": 1.5}, TypeError, "memory"),
    ({"memory": "1KiB"}, dt.MemoryLimitError, "memory"),
    ({"work_folder": "/no/such/folder"}, FileNotFoundError, "/no/such/folder"),
    ({"work_folder": 3}, TypeError, "work_folder must be a path"),
    ({"crs": "my town"}, ValueError, "crs must be a code"),
    ({"crs": 25832}, TypeError, "crs must be text"),
    ({"progress": 3}, TypeError, "progress must be True, or a function"),
    ({"resume": True}, ValueError, "can be resumed"),
    ({"site_id": "id", "sites": XY[:2]}, TypeError, "column 'id'"),
    ({"sites": XY.reshape(30, 4)}, ValueError, "sites must have the shape"),
    ({"sites": NAN}, dt.BuildError, "site 17 "),
    ({"sites": [("a", "b")]}, TypeError, "sites must hold real numbers|sites"),
    ({"holes": [(1, np.nan)]}, dt.BuildError, "hole point 0"),
    ({"holes": "everywhere"}, TypeError, "holes must hold real numbers"),
    ({"lines": 3}, TypeError, "lines must be a list"),
    ({"lines": [NAN]}, dt.InputError, "lines: .*NaN"),
    ({"lines": [np.zeros((4, 4))]}, ValueError, r"lines\[0\] must have the shape"),
    ({"walls": [[(0, 0), (1,)]]}, ValueError, r"walls\[0\]: "),
    ({"lines": [np.array([(0, 1j), (1, 1)])]}, TypeError, r"lines\[0\] must hold real numbers"),
    ({"lines": [shapely.Point(0, 0)]}, ValueError, r"lines\[0\] must be made of lines or polygons, not 'Point'"),
    ({"walls": geopandas.GeoSeries([shapely.Point(0, 0)])}, ValueError, "walls must be made of lines or polygons"),
    ({"lines": [{"type": "Circle"}]}, ValueError, "not 'Circle'"),
    ({"lines": [b"\1\2"]}, dt.InputError, "lines: feature 0"),
    ({"obstacles": [shapely.LineString([(0, 0), (1, 1)])]}, dt.InputError, "obstacles are Polygons"),
    ({"lines": "none.geojson"}, FileNotFoundError, "none.geojson"),
    ({"sites": "none.csv"}, FileNotFoundError, "none.csv"),
]


@pytest.mark.parametrize(("options", "error", "text"), OPTIONS, ids=[str(list(row[0].items()))[:40] for row in OPTIONS])
def test_wrong_arguments_are_named_and_leave_no_file(options, error, text, tmp_path):
    with pytest.raises(error, match=text):
        dt.build(XY, tmp_path / "no.tiles", **options)
    assert not list(tmp_path.iterdir())


def sites_of(folder) -> list[tuple]:
    """Returns x, y and id of each site, in the order of their numbers."""
    found = []
    for tile in dt.open(folder / "t.tiles").tiles():
        at, numbers, ids = tile.sites
        found += zip(numbers.tolist(), tile.points[at].tolist(), ids, strict=True)
    return [(*place, text) for _, place, text in sorted(found)]


IDS = ["kiosk", "Ä 東京", "-7", "07"]
FRAME = {"name": IDS, "y": Y[:4], "x": X[:4]}
SITES = {
    "pandas": lambda: pandas.DataFrame(FRAME),
    "polars": lambda: polars.DataFrame(FRAME),
    "pyarrow": lambda: pyarrow.table(FRAME),
    "geopandas": lambda: geopandas.GeoDataFrame({"name": IDS}, geometry=list(shapely.points(XY[:4]))),
}


@pytest.mark.parametrize("kind", SITES)
def test_sites_of_tables_have_their_ids(kind, tmp_path):
    dt.build(XY, tmp_path / "t.tiles", sites=SITES[kind](), site_id="name")
    assert sites_of(tmp_path) == [(x, y, text) for (x, y), text in zip(XY[:4].tolist(), IDS, strict=True)]
    with pytest.raises(ValueError, match="no column 'size'; it has name"):
        dt.build(XY, tmp_path / "no.tiles", sites=SITES[kind](), site_id="size")


def test_sites_have_given_ids_or_none(tmp_path):
    for ids, expected in ((IDS, IDS), (iter([-1, 2.5, "x", True]), ["-1", "2.5", "x", "True"])):
        with dt.Builder(tmp_path / "t.tiles", overwrite=True) as builder:
            builder.add_sites(XY[:4], ids=ids)
            builder.add_points(XY)
        assert [row[2] for row in sites_of(tmp_path)] == expected
    with dt.Builder(tmp_path / "t.tiles", overwrite=True) as builder:
        builder.add_sites(XY[:4], ids=[40, 20, np.uint8(30), "10"])
        builder.add_points(XY)
    # Ids that are numbers are the numbers of the sites.
    assert dt.open(tmp_path / "t.tiles").nearest(XY[:4], of="sites").site.ravel().tolist() == [40, 20, 30, 10]
    dt.build(XY, tmp_path / "t.tiles", sites=XY[:4], overwrite=True)
    assert [row[:2] for row in sites_of(tmp_path)] == list(map(tuple, XY[:4].tolist()))


@pytest.mark.parametrize(
    ("ids", "text"),
    [
        (["a"], "1 ids for 2 sites"),
        (["a", "b", "c"], "3 ids for 2 sites"),
        ([], "0 ids for 2 sites"),
        (["a", ""], "from 1 to"),
        (["a", "x" * 100_000], "from 1 to"),
        (["a", None], "id of site 1 is missing"),
        ([float("nan"), "b"], "id of site 0 is missing"),
        ([pandas.NA, "b"], "id of site 0 is missing"),
    ],
    ids=str,
)
def test_wrong_ids_are_refused(ids, text, tmp_path):
    builder = dt.Builder(tmp_path / "no.tiles")
    with pytest.raises(ValueError, match=text):
        builder.add_sites(XY[:2], ids=ids)
    builder.close()
    assert not list(tmp_path.iterdir())


def test_ids_of_which_some_are_numbers_name_each_site(tmp_path):
    sites = [(0.25, 0.5), (0.5, 0.5), (0.75, 0.5), (0.9, 0.5)]
    with dt.Builder(tmp_path / "t.tiles") as builder:
        builder.add_sites(sites, ids=["3", "b", "c", "d"])
        builder.add_points([(0, 0), (1, 0), (1, 1), (0, 1)])
    assert dt.open(tmp_path / "t.tiles").knn((0, 0.5), 4).id.tolist() == ["3", "b", "c", "d"]
