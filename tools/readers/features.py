"""Features: GeoJSON, FlatGeobuf and GeoParquet by GDAL, geopandas and pyarrow."""

import geopandas
import numpy
import pyarrow.parquet
import pyogrio
from common import has_ogrinfo, near, ogrinfo, same, same_system, tool

OPTIONS = {"triangles": ["--all"], "vertices": ["--what", "vertices"], "edges": ["--what", "edges"]}


def read(path):
    """A file as a table."""
    return geopandas.read_parquet(path) if path.suffix == ".parquet" else pyogrio.read_dataframe(path)


def export(tiles, path, count_of, system, *options):
    """Exports features; checks their number and their reference system, a code or another form. Returns their table."""
    report = tool("export", tiles, "-o", path, *options)
    count = report[count_of]
    table = read(path)
    same(f"{path.name}: features", len(table), count)
    same_system(path.name, table.crs, system)
    code = system if isinstance(system, int) else None
    if code and path.suffix != ".parquet":
        same(f"{path.name}: code by GDAL", pyogrio.read_info(path)["crs"], f"EPSG:{code}")
    if path.suffix == ".fgb" and has_ogrinfo():
        printed = ogrinfo(path)
        # GDAL before 3.7 leaves out the number if it is 0.
        assert not count or f"Feature Count: {count}\n" in printed, printed
        assert not code or f'ID["EPSG",{code}]]\n' in printed, printed
    return table


def check(folder, tiles, inspected):
    """Compares the formats. Returns the coordinates of the vertices and the numbers of their records."""
    has_z = inspected["has_z"]
    tables = {}
    for what, options in OPTIONS.items():
        of = [
            export(tiles, folder / f"{what}.{suffix}", what, inspected["epsg"], *options)
            for suffix in ["geojson", "fgb", "parquet"]
        ]
        coordinates = [table.geometry.get_coordinates(include_z=has_z) for table in of]
        for found in coordinates[1:]:
            near(what, found, coordinates[0], 0)
        tables[what] = of[-1]
    vertices = tables["vertices"]
    positions = vertices.geometry.get_coordinates(include_z=has_z).to_numpy()
    table = pyarrow.parquet.read_table(folder / "vertices.parquet")
    axes = ["x", "y", "z"][: positions.shape[1]]
    near("columns of vertices", numpy.column_stack([table[axis] for axis in axes]), positions, 0)
    same("columns", table.column_names, [name for name in vertices.columns])
    return positions, vertices["record"].to_numpy()
