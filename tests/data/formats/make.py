"""Writes the same features in every format of vector data, with GDAL.

    python3 -m venv venv && venv/bin/pip install pyogrio shapely
    venv/bin/python tests/data/formats/make.py

All coordinates are multiples of 1/64, so that GeoJSON has them exactly. No two lines or polygons
cross: each is in a cell of its own.
"""

import random
from pathlib import Path

import numpy as np
import pyogrio.raw
import shapely
from shapely import LineString, MultiLineString, MultiPoint, MultiPolygon, Point, Polygon

HERE = Path(__file__).parent
CRS = "EPSG:25833"
CELL = 64
CORNER = (400_000, 5_800_000)
random.seed(23)


def cells():
    """The corners of cells, row by row."""
    for n in range(1000):
        yield CORNER[0] + CELL * (n % 6), CORNER[1] + CELL * (n // 6)


def step(least, most):
    return random.randint(least * 64, most * 64) / 64


def line(x, y, vertices):
    """A line that goes to the right, from (x, y) on."""
    points = []
    for _ in range(vertices):
        points.append((x, y + step(0, 8), step(20, 90)))
        x += step(1, 4)
    return points


def ring(x, y, radius, is_clockwise):
    """An octagon."""
    r, s = radius, radius / 2
    points = [(r, -s), (r, s), (s, r), (-s, r), (-r, s), (-r, -s), (-s, -r), (s, -r), (r, -s)]
    points = [(x + dx, y + dy) for dx, dy in points]
    return points[::-1] if is_clockwise else points


def lines():
    found = []
    for n, (x, y) in zip(range(30), cells()):
        if n == 7:
            found.append(None)
        elif n % 5 == 2:
            found.append(MultiLineString([line(x + 1, y + 1 + 12 * part, 3 + part) for part in range(3)]))
        else:
            points = line(x + 1, y + 1, 2 + n % 9)
            # A position that is repeated.
            found.append(LineString(points[:1] + points if n % 5 == 4 else points))
    return found


def polygons():
    found = []
    for n, (x, y) in zip(range(24), cells()):
        x, y = x + 32, y + 32
        lake = ring(x, y, 12, is_clockwise=n % 2 == 0)
        outer = Polygon(ring(x, y, 24, is_clockwise=n % 3 == 0), [lake] if n % 4 else [])
        if n % 4 == 3:
            # An island in the lake, with a pond, and another polygon beside it.
            island = Polygon(ring(x, y, 8, is_clockwise=n % 5 == 0), [ring(x, y, 2, is_clockwise=True)])
            beside = Polygon(ring(x + 28, y + 28, 2, is_clockwise=False))
            found.append(MultiPolygon([island, outer, beside]))
        else:
            found.append(outer)
    return found


def sites():
    return [Point(x + step(1, 60), y + step(1, 60)) for _, (x, y) in zip(range(20), cells())]


def clusters():
    return [MultiPoint([(x + step(1, 60), y + step(1, 60)) for _ in range(4)]) for _, (x, y) in zip(range(5), cells())]


def in_parts(feature):
    """The feature as one of several parts, where a layer has such a type."""
    kinds = {"LineString": MultiLineString, "Polygon": MultiPolygon}
    return kinds[feature.geom_type]([feature]) if feature and feature.geom_type in kinds else feature


def write(name, driver, layer, features, kind, **options):
    path = HERE / name
    numbers = np.arange(len(features), dtype=np.int32) * 7
    names = np.array([f"no {n}, ä" for n in range(len(features))], dtype=object)
    pyogrio.raw.write(
        path,
        layer=layer,
        driver=driver,
        geometry=np.array([None if f is None else shapely.to_wkb(f, flavor="iso") for f in features], dtype=object),
        field_data=[numbers, names],
        fields=np.array(["number", "name"], dtype=object),
        geometry_type=kind,
        crs=CRS,
        **options,
    )


def main():
    for old in HERE.iterdir():
        if old.suffix not in (".py", ".md"):
            old.unlink()
    layers = {
        "lines": (lines(), "LineString Z"),
        "polygons": (polygons(), "Polygon"),
        "sites": (sites(), "Point"),
        "clusters": (clusters(), "MultiPoint"),
    }
    for layer, (features, kind) in layers.items():
        # Formats whose layers have one type take the type for several parts.
        multi = kind if kind.startswith(("Point", "Multi")) else f"Multi{kind}"
        parts = [in_parts(feature) for feature in features]
        write(f"{layer}.geojson", "GeoJSON", layer, features, "Unknown")
        write(f"{layer}.shp", "ESRI Shapefile", layer, features, kind)
        write(f"{layer}.fgb", "FlatGeobuf", layer, parts, multi, layer_options={"SPATIAL_INDEX": "NO"})
        write(
            "all.gpkg", "GPKG", layer, features, "Unknown", append=(HERE / "all.gpkg").exists(),
            layer_options={"SPATIAL_INDEX": "NO"},
        )
    features, kind = layers["lines"]
    write("lines.gpkg", "GPKG", "lines", features, "Unknown", layer_options={"SPATIAL_INDEX": "NO"})
    parts = [in_parts(feature) for feature in features if feature is not None]
    write("lines_indexed.fgb", "FlatGeobuf", "lines", parts, f"Multi{kind}")
    # GDAL drops the z of geometries of an unknown type.
    mixed = [shapely.force_2d(feature) for features, _ in layers.values() for feature in features if feature is not None]
    write("mixed.geojson", "GeoJSON", "mixed", mixed, "Unknown")
    write("mixed.fgb", "FlatGeobuf", "mixed", mixed, "Unknown", layer_options={"SPATIAL_INDEX": "NO"})
    for file in HERE.iterdir():
        if file.suffix in (".cpg", ".shx") or (file.suffix == ".dbf" and file.stem != "sites"):
            file.unlink()


main()
