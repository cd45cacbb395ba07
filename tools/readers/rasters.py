"""Rasters: GeoTIFF and ASCII grids by rasterio and by GDAL's own programs."""

import subprocess

import meshio
import numpy
import rasterio
from common import has_ogrinfo, near, same, same_system, tool

RESOLUTION = 7


def heights(folder, tiles, transform, shape):
    """The heights at the centres of cells, by barycentric coordinates in the triangles of a PLY file, and NaN."""
    path = folder / "surface.ply"
    tool("export", tiles, "-o", path)
    mesh = meshio.read(path)
    x = transform.c + transform.a * (numpy.arange(shape[1]) + 0.5)
    y = transform.f + transform.e * (numpy.arange(shape[0]) + 0.5)
    found = numpy.full(shape, numpy.nan)
    for a, b, c in mesh.points[mesh.cells_dict["triangle"]]:
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        of_b = ((x[None, :] - a[0]) * (c[1] - a[1]) - (y[:, None] - a[1]) * (c[0] - a[0])) / area
        of_c = ((b[0] - a[0]) * (y[:, None] - a[1]) - (b[1] - a[1]) * (x[None, :] - a[0])) / area
        inside = (of_b >= 0) & (of_c >= 0) & (of_b + of_c <= 1)
        found[inside] = (a[2] + of_b * (b[2] - a[2]) + of_c * (c[2] - a[2]))[inside]
    return found


def read(path, dtype, no_data):
    with rasterio.open(path) as raster:
        same(f"{path.name}: type and missing value", (raster.dtypes[0], raster.nodata), (dtype, no_data))
        values = raster.read(1, masked=True).astype(float).filled(numpy.nan)
        return values, raster.transform, raster.crs, raster.overviews(1)


def check_place(path, transform, values):
    """Asks GDAL's own program for the value at a place."""
    places = numpy.argwhere(~numpy.isnan(values))
    row, column = places[len(places) // 3]
    x, y = transform * (column + 0.5, row + 0.5)
    place = subprocess.run(
        ["gdallocationinfo", "-valonly", "-geoloc", path, str(x), str(y)], check=True, capture_output=True, text=True
    )
    near(f"{path.name}: gdallocationinfo", float(place.stdout), values[row, column], 1e-9)
    info = subprocess.run(["gdalinfo", path], check=True, capture_output=True, text=True).stdout
    assert "NoData Value=-9999" in info, info


def check(folder, tiles, inspected):
    """Exports rasters, and compares them with each other and with the triangles."""
    path = folder / "z.tif"
    report = tool("export", tiles, "-o", path, "--resolution", RESOLUTION, "--cog")
    values, transform, crs, overviews = read(path, "float64", -9999)
    same("z.tif: rows and columns", values.shape, (report["rows"], report["columns"]))
    same("z.tif: overviews", overviews, [2**i for i in range(1, len(overviews) + 1)])
    assert overviews, "no overviews"
    same_system("z.tif", crs, inspected["crs"])
    expected = heights(folder, tiles, transform, values.shape)
    same("z.tif: cells with a value", numpy.isnan(values).sum(), numpy.isnan(expected).sum())
    near("z.tif: heights", numpy.nan_to_num(values), numpy.nan_to_num(expected), 1e-9 * numpy.nanmax(expected))
    if has_ogrinfo():
        check_place(path, transform, values)
    path = folder / "z.asc"
    tool("export", tiles, "-o", path, "--resolution", RESOLUTION)
    text = numpy.loadtxt(path, skiprows=6)
    near("z.asc", text, numpy.nan_to_num(values, nan=-9999), 0)
    path = folder / "z32.tif"
    tool("export", tiles, "-o", path, "--resolution", RESOLUTION, "--float32")
    rounded, *_ = read(path, "float32", -9999)
    near("z32.tif", numpy.nan_to_num(rounded), numpy.nan_to_num(values.astype("f4").astype(float)), 0)
    path = folder / "shade.tif"
    tool("export", tiles, "-o", path, "--resolution", RESOLUTION, "--what", "hillshade")
    shades, *_ = read(path, "uint8", 0)
    same("shade.tif: cells with a value", numpy.isnan(shades).sum(), numpy.isnan(values).sum())
    return f"{values.shape[1]} columns and {values.shape[0]} rows"
