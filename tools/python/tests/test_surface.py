"""Heights, rasters, contours, profiles and volumes are those of the tool; also with asyncio."""

from __future__ import annotations

import asyncio
import csv
import json

import numpy as np
import pytest
from conftest import collection

import delaunay_tiles as dt

SURFACES = {
    "all": ({}, []),
    "holes": ({"holes": True}, ["--all"]),
    "short edges": ({"max_edge": 4.0}, ["--max-edge", 4]),
}
RING = [(15.0, 20.0), (70.0, 15.0), (60.0, 75.0), (15.0, 20.0)]


@pytest.fixture(params=SURFACES)
def surface(request):
    return SURFACES[request.param]


def read_grid(path) -> np.ndarray:
    """Reads an ASCII grid."""
    values = np.loadtxt(path, skiprows=6, ndmin=2)
    return np.where(values == -9999, np.nan, values)


def lines_of(contours: dt.Contours) -> list[tuple]:
    pairs = zip(contours.z, contours.closed, strict=True)
    return sorted((z, closed, contours[i].tolist()) for i, (z, closed) in enumerate(pairs))


def test_heights_are_those_of_the_tool(survey, run, tmp_path, surface):
    ours, theirs = surface
    xy = np.random.default_rng(1).uniform(-3, 103, (500, 2))
    (tmp_path / "batch.csv").write_text("".join(f"{x!r},{y!r}\n" for x, y in xy.tolist()))
    printed = run("query", "z", survey.name, "--batch", tmp_path / "batch.csv", "--csv", *theirs)
    expected = [float(row["z"] or "nan") for row in csv.DictReader(printed.splitlines())]
    found = survey.interpolate(xy, **ours)
    assert np.array_equal(found, expected, equal_nan=True) and np.isnan(found).any()
    alone = survey.interpolate(tuple(xy[0]), **ours)
    assert isinstance(alone, float) and np.array_equal(alone, found[0], equal_nan=True)
    assert np.isnan(survey.interpolate([(np.nan, 1), (np.inf, 1), (1e300, 2)])).all()
    assert survey.interpolate([]).shape == (0,)


RASTERS = [
    ({"resolution": 3.0}, []),
    ({"resolution": 2.5, "bounds": (10, 20, 61, 70)}, ["--bounds", "10,20,61,70"]),
    ({"resolution": 4.0, "align": (1.0, 0.5)}, ["--align", "1,0.5"]),
    ({"resolution": 3.0, "what": "slope", "z_factor": 2.0}, ["--what", "slope", "--z-factor", 2]),
    ({"resolution": 3.0, "what": "aspect"}, ["--what", "aspect"]),
    (
        {"resolution": 3.0, "what": "hillshade", "azimuth": 100, "altitude": 30},
        ["--what", "hillshade", "--azimuth", 100, "--altitude", 30],
    ),
]


@pytest.mark.parametrize("number", range(len(RASTERS)))
def test_rasters_are_those_of_the_tool(survey, run, tmp_path, surface, number):
    ours, theirs = RASTERS[number]
    run("export", survey.name, "-o", tmp_path / "r.asc", "--resolution", ours["resolution"], *theirs, *surface[1])
    raster = survey.raster(**ours, **surface[0])
    expected = read_grid(tmp_path / "r.asc")
    if ours.get("what") == "hillshade":
        expected = np.where(expected == 0, np.nan, expected)
        assert np.array_equal(np.round(raster.values), expected, equal_nan=True) or np.array_equal(
            raster.values, expected, equal_nan=True
        )
    else:
        assert np.array_equal(raster.values, expected, equal_nan=True)
    header = dict(line.split() for line in (tmp_path / "r.asc").read_text().splitlines()[:5])
    rows, columns = raster.values.shape
    assert [float(header[name]) for name in ("xllcorner", "yllcorner")] == list(raster.bounds[:2])
    assert raster.bounds[2] - raster.bounds[0] == pytest.approx(columns * raster.resolution)
    assert raster.transform == (raster.resolution, 0, raster.bounds[0], 0, -raster.resolution, raster.bounds[3])
    assert raster.extent == (raster.bounds[0], raster.bounds[2], raster.bounds[1], raster.bounds[3])
    assert raster.crs == "EPSG:25832"


def test_a_raster_has_the_heights_at_the_centres_of_its_cells(survey):
    raster = survey.raster(5.0)
    width, _, left, _, height, top = raster.transform
    rows, columns = np.indices(raster.values.shape)
    centres = np.column_stack([left + width * (columns.ravel() + 0.5), top + height * (rows.ravel() + 0.5)])
    assert np.allclose(survey.interpolate(centres), raster.values.ravel(), equal_nan=True)


def test_contours_are_those_of_the_tool(survey, run, tmp_path, surface):
    options = ["--contours", 7.5, "--base", 1]
    run("export", survey.name, "-o", tmp_path / "c.geojson", *options, *surface[1])
    features = json.loads((tmp_path / "c.geojson").read_text())["features"]
    theirs = [
        (each["properties"]["z"], each["properties"]["closed"], [at[:2] for at in each["geometry"]["coordinates"]])
        for each in features
    ]
    contours = survey.contours(7.5, base=1, **surface[0])
    assert lines_of(contours) == sorted(theirs) and len(contours) == len(theirs) > 3
    assert contours[-1].tolist() == contours[len(contours) - 1].tolist()
    with pytest.raises(IndexError):
        contours[len(contours)]
    frame = contours.to_geopandas()
    assert frame.crs == "EPSG:25832" and frame["z"].tolist() == contours.z.tolist()


def test_profiles_are_those_of_the_tool(survey, run, tmp_path, surface):
    line = [[-5.0, 20.0], [60.0, 70.0], [99.0, 30.0]]
    (tmp_path / "line.geojson").write_text(collection("LineString", [line]))
    printed = run("query", "profile", survey.name, "--line", tmp_path / "line.geojson", "--csv", *surface[1])
    names = ("distance", "x", "y", "z")
    rows = [[float(row[name]) for name in names] for row in csv.DictReader(printed.splitlines()) if row["z"]]
    profile = survey.profile(line, **surface[0])
    assert np.column_stack([profile.distance, profile.points, profile.z]).tolist() == rows
    assert profile.length == pytest.approx(np.hypot(*np.diff(line, axis=0).T).sum())
    assert profile.offsets[0] == 0 and profile.offsets[-1] == len(rows)


@pytest.mark.parametrize("is_clipped", [False, True])
def test_volumes_are_those_of_the_tool(survey, run, tmp_path, surface, is_clipped):
    (tmp_path / "clip.geojson").write_text(collection("Polygon", [[RING]]))
    polygon = ["--polygon", tmp_path / "clip.geojson"] if is_clipped else []
    theirs = json.loads(run("query", "volume", survey.name, "--level", 9.5, "--json", *polygon, *surface[1]))
    volume = survey.volume(9.5, clip=np.array(RING) if is_clipped else None, **surface[0])
    for name in ("cut", "fill", "area", "area_above", "area_below"):
        assert getattr(volume, name) == theirs[name]


def test_polygons_of_any_kind_clip_alike(survey):
    geopandas, shapely = pytest.importorskip("geopandas"), pytest.importorskip("shapely")
    polygon = shapely.Polygon(RING)
    expected = survey.volume(0, clip=np.array(RING))
    series = geopandas.GeoSeries([polygon], crs=25832)
    kinds = [RING, [RING], RING[:-1], polygon, [polygon], polygon.wkb, [polygon.wkb]]
    kinds += [series, series.to_frame("geometry")]
    kinds += [polygon.__geo_interface__, {"type": "Feature", "geometry": polygon.__geo_interface__}, [polygon, None]]
    for clip in kinds:
        assert survey.volume(0, clip=clip) == expected
    inside = survey.raster(4.0, clip=polygon).values
    assert 0 < np.isfinite(inside).sum() < np.isfinite(survey.raster(4.0).values).sum()
    assert survey.volume(0, clip=[]).area == 0 and len(survey.contours(5, clip=[])) == 0
    with pytest.raises(ValueError, match="EPSG:4326.*EPSG:25832"):
        survey.volume(0, clip=series.set_crs(4326, allow_override=True))


def asks() -> dict:
    xy = np.random.default_rng(3).uniform(-3, 103, (50, 2))
    return {
        "interpolate": (xy,), "locate": (xy,), "raster": (5.0,), "contours": (9.0,), "volume": (3.0,),
        "profile": ([(1, 1), (90, 60)],), "tile_ids": ((3, 3, 20, 20),), "digest": (), "verify": (), "tile": (2,),
    }  # fmt: skip


def same(a, b) -> bool:
    if isinstance(a, dt.Tile):
        return a.id == b.id and np.array_equal(a.points, b.points) and np.array_equal(a.triangles, b.triangles)
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, name), getattr(b, name)) for name in a.__dataclass_fields__)
    return np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b


def test_asyncio_has_the_same_answers(survey):
    async def ask() -> list:
        t = await dt.aopen(survey.name)
        assert t.crs == survey.crs and t.metadata == survey.metadata
        return await asyncio.gather(*(getattr(t, name)(*given) for name, given in asks().items()))

    for found, (name, given) in zip(asyncio.run(ask()), asks().items(), strict=True):
        assert same(found, getattr(survey, name)(*given)), name


WRONG = [
    (lambda t: t.interpolate([(1, 1)], max_edge=0), ValueError, "max_edge must be a number above 0"),
    (lambda t: t.interpolate([(1, 1)], max_edge=np.nan), ValueError, "max_edge"),
    (lambda t: t.interpolate([(1, 1)], from_hull=True), ValueError, "from_hull needs max_edge"),
    (lambda t: t.interpolate([(1, 1, 1)]), ValueError, "xy must have the shape"),
    (lambda t: t.raster(0), ValueError, "resolution"),
    (lambda t: t.raster(np.nan), ValueError, "resolution"),
    (lambda t: t.raster(-1), ValueError, "resolution"),
    (lambda t: t.raster(np.inf), ValueError, "resolution"),
    (lambda t: t.raster(1e-5), dt.MemoryLimitError, "memory"),
    (lambda t: t.raster(1e-300), ValueError, "columns"),
    (lambda t: t.raster(1, bounds=(5, 5, 0, 0)), ValueError, "lower ends first"),
    (lambda t: t.raster(1, bounds=(0, 0, np.nan, 5)), ValueError, "no NaN"),
    (lambda t: t.raster(1, bounds=(0, 0, np.inf, 5)), ValueError, "columns"),
    (lambda t: t.raster(1, align=(1,)), ValueError, "align"),
    (lambda t: t.raster(1, what="colour"), ValueError, "what must be 'z', 'slope', 'aspect' or 'hillshade'"),
    (lambda t: t.raster(1, what=None), TypeError, "what must be a text"),
    (lambda t: t.raster(1, z_factor=np.nan), ValueError, "z_factor must be a finite number"),
    (lambda t: t.raster(1, azimuth=np.inf), ValueError, "azimuth must be a finite number"),
    (lambda t: t.contours(0), ValueError, "step"),
    (lambda t: t.contours(np.nan), ValueError, "step"),
    (lambda t: t.contours(5, base=np.nan), ValueError, "base"),
    (lambda t: t.contours(1e-9), dt.QueryError, "levels"),
    (lambda t: t.volume(np.nan), ValueError, "level must be a finite number"),
    (lambda t: t.volume(None), TypeError, ""),
    (lambda t: t.volume(0, clip=3), TypeError, "clip must be a list"),
    (lambda t: t.volume(0, clip=[[(0, 0), (1, np.nan), (1, 1)]]), dt.InputError, "clip: .*NaN"),
    (lambda t: t.profile([(1, 1)]), dt.QueryError, "no two different points"),
    (lambda t: t.profile([(1, 1), (np.nan, 1)]), dt.QueryError, "not finite"),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_wrong_arguments_are_named(survey, number):
    act, error, text = WRONG[number]
    with pytest.raises(error, match=text or None):
        act(survey)


@pytest.mark.parametrize("name", ["none", "one", "line"])
def test_files_without_z_say_so(small, name):
    t = small[name]
    for act in (
        lambda: t.interpolate((1, 1)), lambda: t.contours(1), lambda: t.volume(1), lambda: t.profile([(0, 0), (1, 1)])
    ):  # fmt: skip
        with pytest.raises(dt.QueryError, match="has no z"):
            act()
    with pytest.raises((dt.QueryError, ValueError), match="has no z|no area"):
        t.raster(1)


def test_two_points_have_no_surface(small):
    t = small["two"]
    assert t.interpolate([(1, 1), (1.5, 1.5)]).tolist()[0] == 5 and np.isnan(t.interpolate((1.5, 1.5)))
    assert np.isnan(t.raster(1).values).all() and len(t.contours(1)) == 0 and t.volume(0).area == 0
