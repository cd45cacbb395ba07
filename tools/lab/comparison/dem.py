"""From a lidar file (LAZ) to a raster of heights: by programs that make one, or in the fewest steps with them."""

import importlib.util
import shutil
import sys
from pathlib import Path

import laspy
import measured
import numpy
import peers

HERE = Path(__file__).parent
_spec = importlib.util.spec_from_file_location("terrain_compare", HERE.parent / "terrain" / "compare.py")
terrain = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(terrain)


class Survey(terrain.Case):
    """A LAZ file, and the cells of a raster."""

    def __init__(self, folder, tiletool, points, cells):
        self.laz = Path(folder) / "survey.laz"
        write_laz(self.laz, terrain.generated(Path(folder), tiletool, points))
        super().__init__(Path(folder), tiletool, points, cells, self.laz)

    def files(self):
        """Writes nothing: all programs begin with the LAZ file."""

    def values(self, path):
        if path.suffix != ".asc":
            return super().values(path)
        # GDAL reads ASCII grids as numbers of 32 bits.
        values = numpy.loadtxt(path, skiprows=6).ravel()
        return numpy.where(values == terrain.MISSING, numpy.nan, values)


def write_laz(path, xyz):
    """Writes points in steps of 1 mm, one at each position: which of several counts is not what is compared."""
    offsets = numpy.floor(xyz.min(axis=0))
    steps = numpy.round((xyz - offsets) / 0.001).astype(int)
    first = numpy.unique(steps[:, :2], axis=0, return_index=True)[1]
    steps = steps[numpy.sort(first)]
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales, header.offsets = numpy.full(3, 0.001), offsets
    las = laspy.LasData(header)
    las.X, las.Y, las.Z = steps.T.astype(numpy.int32)
    las.write(path)


def peer(function, *arguments):
    return [sys.executable, HERE / "peers.py", function, *arguments]


def by_tiletool(case, limit):
    tiles, path = case.folder / "survey.tiles", case.folder / "tiletool.tif"
    build = [case.tiletool, "build", case.laz, "-o", tiles, "--force", "--quiet"]
    cells = ["--resolution", case.resolution, "--bounds=" + ",".join(repr(v) for v in case.corners())]
    return measured.run(build, limit) + measured.run([case.tiletool, "export", tiles, "-o", path, *cells], limit), path


def by_gdal(case, limit):
    text, points = case.folder / "points.csv", case.folder / "points.fgb"
    ran = measured.run(peer("las_to_text", case.laz, text), limit)
    options = [part for name in "xyz" for part in ("-oo", f"{name.upper()}_POSSIBLE_NAMES={name}")]
    ran += measured.run(["ogr2ogr", "-lco", "SPATIAL_INDEX=NO", points, text, *options], limit)
    grid, _, path = terrain.by_gdal(case, limit, "ALL_CPUS")
    return ran + grid, path


def by_startinpy(case, limit):
    west, _, _, north = case.corners()
    path = case.folder / "startinpy.asc"
    arguments = [repr(west), repr(north), case.columns, case.rows, case.resolution]
    return measured.run(peer("startinpy_dem", case.laz, path, *arguments), limit), path


def by_whitebox(case, limit):
    path = case.folder / "whitebox.tif"
    return measured.run(peer("whitebox_dem", case.laz, path, case.resolution), limit), path


def by_pdal(case, limit):
    west, south, _, _ = case.corners()
    cells = {"resolution": case.resolution, "origin_x": west, "origin_y": south}
    cells |= {"width": case.columns, "height": case.rows, "nodata": terrain.MISSING}
    path = case.folder / "pdal.tif"
    options = [f"--filters.faceraster.{name}={value!r}" for name, value in cells.items()]
    command = ["pdal", "translate", case.laz, path, "delaunay", "faceraster", "-w", "writers.raster", *options]
    return measured.run(command, limit), path


class Maker:
    """A program that makes a raster, and what it took."""

    def __init__(self, name, steps, once):
        self.name, self.steps, self.once = name, steps, once
        self.runs, self.path, self.why = [], None, None

    def measure(self, case, limit):
        if self.why:
            return
        try:
            ran, self.path = self.once(case, limit)
            self.runs.append(ran)
        except measured.Skipped as why:
            self.why = str(why)

    def difference(self, case, own):
        """Returns the largest and the median difference from tiletool's heights."""
        try:
            return terrain.compared(case.values(self.path), own)[:2]
        except measured.Skipped:
            return "other cells", ""


def makers():
    def lines(function):
        return f"{peers.lines_of(function)} lines of Python"

    pdal = Maker("PDAL", "1 command with 2 filters", by_pdal)
    if not shutil.which("pdal"):
        pdal.why = "PDAL is not installed"
    return [
        Maker("tiletool", "2 commands", by_tiletool),
        Maker("startinpy", lines(peers.startinpy_dem), by_startinpy),
        Maker("whitebox", lines(peers.whitebox_dem), by_whitebox),
        Maker("GDAL", f"{lines(peers.las_to_text)}, 2 commands", by_gdal),
        pdal,
    ]
