#!/usr/bin/env python3
"""Rasters of the same points by tiletool and by other programs, linear in the triangles: time and differences.

    python3 -m pip install -r tools/lab/terrain/requirements.txt
    tools/lab/terrain/compare.py target/release/tiletool
    tools/lab/terrain/compare.py target/release/tiletool --case 20000:100000 --rounds 1
    tools/lab/terrain/compare.py target/release/tiletool --las survey.laz --case 1000000:4000000

GDAL's programs (gdal_grid, gdal_translate, gdalinfo, ogr2ogr) must be installed, and the machine must be quiet.
Programs that are missing, fail or take too long are named below the table. All get the same numbers of 64 bits, without
points at equal positions, and fill the same cells. README.md says what is measured.
"""

import argparse
import contextlib
import json
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from measured import Skipped, run

MISSING = -9999.0


class Case:
    """Points, and the cells of a raster."""

    def __init__(self, folder, tiletool, points, cells, las, at_origin=False):
        self.folder, self.tiletool = folder, tiletool
        xyz = read_las(las, points) if las else generated(folder, tiletool, points)
        if at_origin:
            xyz[:, :2] -= numpy.floor(xyz[:, :2].min(axis=0))
        # One point of those at a position: which one counts is not what is compared.
        first = numpy.unique(xyz[:, :2], axis=0, return_index=True)[1]
        self.xyz = xyz[numpy.sort(first)]
        low, high = self.xyz[:, :2].min(axis=0), self.xyz[:, :2].max(axis=0)
        width, height = high - low
        # A resolution and a corner of few digits, so that all programs have the same centres.
        self.resolution = float(f"{(width * height / cells) ** 0.5:.2g}")
        self.origin = numpy.floor(low)
        self.columns, self.rows = (int(n) for n in numpy.ceil((high - self.origin) / self.resolution))
        self.files()

    def files(self):
        """Writes the points for each program."""
        self.xyz.astype("<f8").tofile(self.folder / "points.f64")
        numpy.save(self.folder / "points.npy", self.xyz)
        numpy.savetxt(self.folder / "points.csv", self.xyz, fmt="%.17g", delimiter=",", header="x,y,z", comments="")
        names = [f"{name.upper()}_POSSIBLE_NAMES={name}" for name in "xyz"]
        options = [part for name in names for part in ("-oo", name)]
        target = ["-f", "FlatGeobuf", "-lco", "SPATIAL_INDEX=NO", self.folder / "points.fgb"]
        run(["ogr2ogr", *target, self.folder / "points.csv", *options, "-oo", "KEEP_GEOM_COLUMNS=NO"])
        # Whitebox finds no z in FlatGeobuf. Both formats have numbers of 64 bits.
        run(["ogr2ogr", self.folder / "points.shp", self.folder / "points.fgb"])

    def corners(self):
        """Returns the bounds of the cells."""
        x, y = (float(v) for v in self.origin)
        return x, y, x + self.columns * self.resolution, y + self.rows * self.resolution

    def centres(self):
        """Returns the centres of all cells, row by row from the north."""
        x = self.origin[0] + (numpy.arange(self.columns) + 0.5) * self.resolution
        y = self.origin[1] + (numpy.arange(self.rows)[::-1] + 0.5) * self.resolution
        return numpy.stack(numpy.meshgrid(x, y), axis=-1).reshape(-1, 2)

    def values(self, path):
        """Returns the values of a raster, row by row from the north; those of other cells are not a number."""
        if path.suffix == ".npy":
            return numpy.load(path)
        about = json.loads(run(["gdalinfo", "-json", path]).printed)
        if about["size"] != [self.columns, self.rows]:
            raise Skipped(f"has {about['size']} cells, not {[self.columns, self.rows]}")
        raw = path.with_suffix(".raw")
        run(["gdal_translate", "-q", "-of", "ENVI", "-ot", "Float64", path, raw])
        values = numpy.fromfile(raw, "<f8").reshape(self.rows, self.columns)
        values[values == about["bands"][0].get("noDataValue", MISSING)] = numpy.nan
        return (values[::-1] if about["geoTransform"][5] > 0 else values).ravel()


def generated(folder, tiletool, points):
    path = folder / "generated.f64"
    run([tiletool, "generate", "lidar", "-n", points, "--dims", 3, "--seed", 3, "-o", path])
    return numpy.fromfile(path, "<f8").reshape(-1, 3)


def read_las(path, points):
    import laspy

    las = laspy.read(path)
    xyz = numpy.column_stack([las.x, las.y, las.z])
    return xyz[:: max(1, len(xyz) // points)]


class Program:
    """A program with the times of its runs: of the whole, and of the interpolation alone if that can be told."""

    def __init__(self, name, once):
        self.name, self.once = name, once
        self.whole, self.part, self.values, self.why = [], [], None, None

    def measure(self, case, limit):
        if self.why:
            return
        try:
            whole, part, path = self.once(case, limit)
            self.whole.append(whole.seconds)
            self.part.append(part)
            self.values = case.values(path) if self.values is None else self.values
        except Skipped as why:
            self.why = str(why)


def by_tiletool(case, limit, **how):
    tiles, path = case.folder / "points.tiles", case.folder / "tiletool.tif"
    build = [case.tiletool, "build", case.folder / "points.f64", "--dims", 3, "-o", tiles, "--force", "--quiet"]
    cells = ["--resolution", case.resolution, "--bounds=" + ",".join(repr(v) for v in case.corners())]
    export = [case.tiletool, "export", tiles, "-o", path, *cells, "--json"]
    built, exported = run(build, limit, **how), run(export, limit, **how)
    return built + exported, exported.seconds, path


def by_gdal(case, limit, threads):
    path = case.folder / "gdal.tif"
    path.unlink(missing_ok=True)
    west, south, east, north = case.corners()
    cells = ["-txe", west, east, "-tye", north, south, "-outsize", case.columns, case.rows]
    method = ["-a", f"linear:radius=0:nodata={MISSING}", "-ot", "Float64", "-of", "GTiff", "-q"]
    command = ["gdal_grid", *method, *cells, case.folder / "points.fgb", path]
    return run(command, limit, GDAL_NUM_THREADS=threads), None, path


def by_python(name):
    """Returns the program that is this file, in a process of its own, with a function below."""

    def once(case, limit):
        x, y, resolution = *(float(v) for v in case.origin), case.resolution
        arguments = json.dumps([x, y, resolution, case.columns, case.rows])
        command = [sys.executable, __file__, "--peer", name, case.folder, arguments]
        ran = run(command, limit)
        answer = json.loads(ran.printed.splitlines()[-1])
        return ran, answer["interpolation"], case.folder / answer["file"]

    return once


def centres_of(x, y, resolution, columns, rows):
    case = Case.__new__(Case)
    case.origin, case.resolution, case.columns, case.rows = numpy.array([x, y]), resolution, columns, rows
    return case.centres()


def peer_startinpy(folder, grid):
    import startinpy

    triangulation = startinpy.DT()
    # Points at a smaller distance are merged; all are at different positions.
    triangulation.snap_tolerance = 1e-9
    triangulation.insert(numpy.load(folder / "points.npy"))
    began = time.perf_counter()
    values = triangulation.interpolate({"method": "TIN"}, centres_of(*grid))
    seconds = time.perf_counter() - began
    numpy.save(folder / "startinpy.npy", values)
    return {"interpolation": seconds, "file": "startinpy.npy"}


def peer_whitebox(folder, grid):
    import whitebox_workflows

    environment = whitebox_workflows.WbEnvironment()
    points = environment.read_vector(str(folder / "points.shp"))
    cells = environment.read_raster(str(folder / "cells.tif"))
    target = folder / "whitebox.tif"
    environment.raster.general.tin_interpolation(points=points, use_z=True, base_raster=cells, output=str(target))
    return {"interpolation": None, "file": target.name}


def write_cells(case):
    """Writes a raster whose cells whitebox fills."""
    west, south, east, north = case.corners()
    raw = case.folder / "cells.vrt"
    raw.write_text(
        f'<VRTDataset rasterXSize="{case.columns}" rasterYSize="{case.rows}">'
        f"<GeoTransform>{west!r}, {case.resolution!r}, 0, {north!r}, 0, {-case.resolution!r}</GeoTransform>"
        f'<VRTRasterBand dataType="Float64" band="1">'
        f"<NoDataValue>{MISSING}</NoDataValue></VRTRasterBand></VRTDataset>"
    )
    run(["gdal_translate", "-q", raw, case.folder / "cells.tif"])


def programs():
    return [
        Program("tiletool", by_tiletool),
        Program("tiletool, one processor", lambda case, limit: by_tiletool(case, limit, one_processor=True)),
        Program("gdal_grid, all processors", lambda case, limit: by_gdal(case, limit, "ALL_CPUS")),
        Program("gdal_grid, one thread", lambda case, limit: by_gdal(case, limit, 1)),
        Program("startinpy", by_python("startinpy")),
        Program("whitebox", by_python("whitebox")),
    ]


def compared(values, own):
    """Returns the largest and the median difference from the values of tiletool, and how many only one has."""
    one, other = ~numpy.isnan(values), ~numpy.isnan(own)
    difference = numpy.abs(values[one & other] - own[one & other])
    if not len(difference):
        return "", "", int((one ^ other).sum())
    return f"{difference.max():.2g}", f"{numpy.median(difference):.2g}", int((one ^ other).sum())


def report(case, measured):
    cells = case.columns * case.rows
    print(f"\n{len(case.xyz):,} points, {case.columns:,} by {case.rows:,} = {cells:,} cells of {case.resolution}\n")
    titles = ["program", "with triangulation, s", "M cells/s", "interpolation, s", "M cells/s"]
    print("| " + " | ".join([*titles, "largest", "median", "cells of one"]) + " |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    own = measured[0].values
    for program in measured:
        if program.why:
            continue
        whole = statistics.median(program.whole)
        columns = [program.name, f"{whole:.2f}", f"{cells / whole / 1e6:.2f}"]
        if None in program.part:
            columns += ["", ""]
        else:
            part = statistics.median(program.part)
            columns += [f"{part:.2f}", f"{cells / part / 1e6:.2f}"]
        if own is not None:
            largest, median, of_one = compared(program.values, own)
            columns += [largest, median, f"{of_one:,}"]
        else:
            columns += ["", "", ""]
        print("| " + " | ".join(columns) + " |")
    for program in measured:
        if program.why:
            print(f"\n{program.name}: no result: {program.why}")


def measure(arguments, points, cells):
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(dir=arguments.folder))
        case = Case(Path(folder), arguments.tiletool.resolve(), points, cells, arguments.las, arguments.at_origin)
        write_cells(case)
        measured = programs()
        for _ in range(arguments.rounds):
            for program in measured:
                program.measure(case, arguments.limit)
        report(case, measured)


def main():
    if sys.argv[1:2] == ["--peer"]:
        name, folder, grid = sys.argv[2:]
        peers = {"startinpy": peer_startinpy, "whitebox": peer_whitebox}
        print(json.dumps(peers[name](Path(folder), json.loads(grid))))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    cases = "default: 100000:1000000 and 1000000:4000000"
    parser.add_argument("--case", action="append", metavar="POINTS:CELLS", help=cases)
    las = "points of a LAS or LAZ file, thinned to about POINTS, in place of generated ones"
    parser.add_argument("--las", type=Path, help=las)
    at_origin = "move the points to 0,0, where inexact programs err less"
    parser.add_argument("--at-origin", action="store_true", help=at_origin)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=120, help="seconds for one process; slower programs are skipped")
    parser.add_argument("--folder", type=Path, help="for temporary files")
    arguments = parser.parse_args()
    for case in arguments.case or ["100000:1000000", "1000000:4000000"]:
        points, cells = (int(number) for number in case.split(":"))
        measure(arguments, points, cells)


if __name__ == "__main__":
    main()
