"""Writes the small files of points and triangulations here, with programs that are not the project's.

    pip install numpy pyarrow trimesh
    python make_points.py

All files of points have those of points.csv, in this order. The coordinates are multiples of 1/8, so
that all types of numbers have them exactly.
"""

import json
import struct
from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import trimesh

HERE = Path(__file__).parent
COUNT = 200
CRS = {"type": "ProjectedCRS", "name": "ETRS89 / UTM zone 33N", "id": {"authority": "EPSG", "code": 25833}}


def points():
    """Returns x, y and z."""
    random = np.random.default_rng(23)
    return random.integers(-8000, 8000, (COUNT, 3)) / 8


def parquet(name, table, **options):
    """Writes a table in row groups of 64 rows."""
    pq.write_table(table, HERE / name, row_group_size=64, **options)


def geo(encoding, types, **about):
    """Returns the key of GeoParquet."""
    column = {"encoding": encoding, "geometry_types": types, **about}
    return {"geo": json.dumps({"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": column}})}


def wkb(point, z=True):
    """Returns a point as WKB of ISO."""
    return struct.pack("<BI3d", 1, 1001, *point) if z else struct.pack(">BI2d", 0, 1, *point[:2])


def multipoint(group):
    """Returns several points as WKB, as PostGIS writes it with an SRID."""
    head = struct.pack("<BIII", 1, 0xA0000004, 25833, len(group))
    return head + b"".join(struct.pack("<BI3d", 1, 0x80000001, *point) for point in group)


def write_columns(xyz):
    """Writes files of columns, one for each codec."""
    x, y, z = xyz.T
    numbers = pa.table({"id": np.arange(COUNT), "x": x, "y": y, "z": z})
    parquet("columns.parquet", numbers, compression="snappy")
    single = [pa.array(axis, pa.float32()) for axis in (z, y, x)]
    named = pa.table(single, names=["Elevation", "Latitude", "Longitude"])
    parquet("columns_f32.parquet", named, compression="zstd", data_page_version="2.0")
    decimals = [pa.array([Decimal(value) for value in axis], pa.decimal128(12, 3)) for axis in (x, y, z)]
    exact = pa.table(decimals, names=["Easting", "Northing", "Height"])
    parquet("columns_decimal.parquet", exact, compression="gzip", store_decimal_as_integer=True)


def write_geometries(xyz):
    """Writes GeoParquet in three ways; every seventh row of the first has no geometry."""
    rows = [None if n % 7 == 6 else wkb(point) for n, point in enumerate(list(xyz))]
    table = pa.table({"geometry": pa.array(rows, pa.binary())})
    table = table.replace_schema_metadata(geo("WKB", ["Point Z"], crs=CRS))
    parquet("geo_wkb.parquet", table, compression="snappy")
    groups = [xyz[start : start + size] for start, size in [(0, 1), (1, 2), (3, 3), (6, 4), (10, 5)]]
    rest = 15
    rows = [multipoint(group) for group in groups] + [multipoint([])] + [wkb(point) for point in xyz[rest:]]
    table = pa.table({"geometry": pa.array(rows, pa.binary())})
    table = table.replace_schema_metadata(geo("WKB", []))
    parquet("geo_multipoint.parquet", table, compression="none", use_dictionary=False)
    struct_type = pa.struct([("x", pa.float64()), ("y", pa.float64()), ("z", pa.float64())])
    rows = [dict(zip("xyz", point)) for point in xyz.tolist()]
    table = pa.table({"name": ["a"] * COUNT, "geometry": pa.array(rows, struct_type)})
    table = table.replace_schema_metadata(geo("point", ["Point Z"], crs={**CRS, "id": None}))
    parquet("geo_point.parquet", table, compression="lz4")


def write_meshes():
    """Writes a triangulation of a grid of points that are moved a little."""
    random = np.random.default_rng(4)
    side = 7
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    vertices = np.column_stack([grid * 8 + random.integers(0, 16, grid.shape) / 8, random.integers(0, 80, side * side) / 8])
    corners = [row * side + column for row in range(side - 1) for column in range(side - 1)]
    faces = [face for a in corners for face in ((a, a + 1, a + side), (a + 1, a + side + 1, a + side))]
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.export(HERE / "tin.ply")
    mesh.export(HERE / "tin_ascii.ply", encoding="ascii")
    mesh.export(HERE / "tin.obj")


def main():
    """Writes all files."""
    xyz = points()
    (HERE / "points.csv").write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in xyz.tolist()))
    write_columns(xyz)
    write_geometries(xyz)
    write_meshes()


if __name__ == "__main__":
    main()
