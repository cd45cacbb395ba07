"""The programs: how each does a task, in how many steps, and where its result is."""

import shutil
import subprocess
import sys
from pathlib import Path

import measured
import numpy
import peers
import results

HERE = Path(__file__).parent


def code_lines(*paths):
    """Returns the number of lines that are neither blank nor a comment."""
    lines = [line.strip() for path in paths for line in path.read_text().splitlines()]
    return sum(1 for line in lines if line and not line.startswith("//"))


class Case:
    """Points, and perhaps segments, in a folder, in the format that each program reads."""

    def __init__(self, folder, points, segments=None):
        self.folder, self.points, self.segments = Path(folder), points, segments
        points.astype("<f8").tofile(self.folder / "points.f64")
        if segments is not None:
            segments.astype("<u4").tofile(self.folder / "segments.u32")

    def path(self, name):
        return self.folder / name

    def csv(self):
        path = self.path("points.csv")
        if not path.exists():
            numpy.savetxt(path, self.points, fmt="%.17g", delimiter=",", header="x,y", comments="")
        return path

    def shapefile(self):
        path = self.path("points.shp")
        if not path.exists():
            names = ["-oo", "X_POSSIBLE_NAMES=x", "-oo", "Y_POSSIBLE_NAMES=y"]
            measured.run(["ogr2ogr", path, self.csv(), *names])
        return path


class Program:
    """A program. `why` says why it is not there."""

    stores = "corners"
    constrains = True
    # Whether the triangles are polygons, whose order of corners means nothing.
    polygons = False
    why = None

    def version(self):
        raise NotImplementedError

    def command(self, case):
        """Returns the command, and before that makes files in the program's format."""
        raise NotImplementedError

    def steps(self, constrained=False):
        raise NotImplementedError

    def triangulate(self, case, limit):
        """Returns the measured run."""
        if self.why:
            raise measured.Skipped(self.why)
        return measured.run(self.command(case), limit)

    def triangles(self, case, limit):
        """Triangulates. Returns corners, and vertices or None."""
        self.triangulate(case, limit)
        return results.read_corners(case.path(f"{self.name}.u32"))


class Tiletool(Program):
    stores = "a tile file: vertices, triangles, neighbours, directory"

    def __init__(self, program, label="tiletool", *options):
        self.program, self.name, self.options = program, label, options

    def version(self):
        return measured.run([self.program, "--version"]).printed.split()[-1]

    def steps(self, constrained=False):
        return "1 command"

    def command(self, case):
        lines = [] if case.segments is None else ["--segments", case.path("segments.u32")]
        output = ["-o", case.path("tiletool.tiles"), "--force", "--quiet"]
        return [self.program, "build", case.path("points.f64"), *lines, *output, *self.options]

    def triangles(self, case, limit):
        self.triangulate(case, limit)
        path = case.path("tiletool.ele")
        measured.run([self.program, "export", case.path("tiletool.tiles"), "-o", path], limit)
        return results.read_ele(path)


class Cgal(Program):
    name = "CGAL"

    def __init__(self, folder):
        self.folder = Path(folder)
        for task in ("delaunay", "constrained"):
            source, program = HERE / f"cgal_{task}.cpp", self.folder / f"cgal_{task}"
            command = ["g++", "-std=c++17", "-O2", "-DNDEBUG", source, "-o", program, "-lgmp", "-lmpfr"]
            try:
                done = subprocess.run(command, capture_output=True, text=True, check=False)
            except FileNotFoundError:
                self.why = "g++ is not installed"
                return
            if done.returncode:
                self.why = "CGAL is not installed (apt-get install libcgal-dev)"
                return

    def version(self):
        source = "#include <CGAL/version.h>\nCGAL_VERSION_STR"
        how = {"input": source, "capture_output": True, "text": True}
        done = subprocess.run(["g++", "-E", "-P", "-x", "c++", "-"], check=True, **how)
        return done.stdout.split('"')[-2]

    def steps(self, constrained=False):
        task = "constrained" if constrained else "delaunay"
        return f"{code_lines(HERE / 'raw.hpp', HERE / f'cgal_{task}.cpp')} lines of C++"

    def command(self, case):
        files = [case.path("points.f64"), case.path("CGAL.u32")]
        if case.segments is None:
            return [self.folder / "cgal_delaunay", *files]
        return [self.folder / "cgal_constrained", *files, case.path("segments.u32")]


class Spade(Program):
    name = "spade"
    source = HERE.parent / "src" / "bin" / "spade_corners.rs"

    def __init__(self, program):
        self.program = program
        if not program.exists():
            self.why = "cargo build --release -p lab --bin spade-corners was not run"

    def version(self):
        lock = (HERE.parents[2] / "Cargo.lock").read_text()
        return lock.split('name = "spade"\nversion = "')[1].split('"')[0]

    def steps(self, constrained=False):
        return f"{code_lines(self.source)} lines of Rust"

    def command(self, case):
        segments = [] if case.segments is None else [case.path("segments.u32")]
        return [self.program, case.path("points.f64"), case.path("spade.u32"), *segments]


class InPython(Program):
    """A library of Python, with functions of `peers`."""

    def __init__(self, name, package, constrains=False):
        self.name, self.package, self.constrains = name, package, constrains
        try:
            self.version()
        except ModuleNotFoundError:
            self.why = f"the Python package {package} is not installed"

    def version(self):
        from importlib import metadata

        return metadata.version(self.package)

    def function(self, constrained):
        return f"{self.name.lower()}_{'constrained' if constrained else 'delaunay'}"

    def steps(self, constrained=False):
        return f"{peers.lines_of(getattr(peers, self.function(constrained)))} lines of Python"

    def command(self, case):
        files = [case.path("points.f64"), case.path(f"{self.name}.u32")]
        if case.segments is not None:
            files.append(case.path("segments.u32"))
        return [sys.executable, HERE / "peers.py", self.function(case.segments is not None), *files]


class Startinpy(InPython):
    stores = "corners, vertices"

    def __init__(self):
        super().__init__("startinpy", "startinpy")

    def command(self, case):
        return [*super().command(case), case.path("startinpy.f64")]

    def triangles(self, case, limit):
        self.triangulate(case, limit)
        return results.read_corners(case.path("startinpy.u32"), case.path("startinpy.f64"))


class WritesPolygons:
    """What programs have in common that write triangles as polygons, to the shapefile `written`."""

    stores = "a shapefile of polygons"
    polygons = True

    def triangles(self, case, limit):
        self.triangulate(case, limit)
        return results.read_polygons(case.path(self.written))


class Whitebox(WritesPolygons, InPython):
    written = "whitebox.shp"

    def __init__(self):
        super().__init__("whitebox", "whitebox-workflows")

    def command(self, case):
        written = case.path(self.written)
        written.unlink(missing_ok=True)
        return [sys.executable, HERE / "peers.py", self.function(False), case.shapefile(), written]


class Gdal(WritesPolygons, Program):
    name = "GDAL (GEOS)"
    written = "gdal.shp"
    constrains = False

    def __init__(self):
        if not shutil.which("ogr2ogr"):
            self.why = "ogr2ogr is not installed (apt-get install gdal-bin)"

    def version(self):
        return measured.run(["ogr2ogr", "--version"]).printed.split()[1].rstrip(",")

    def steps(self, constrained=False):
        return "1 command with SQL"

    def command(self, case):
        for path in case.folder.glob("gdal.*"):
            path.unlink()
        columns = ["-oo", "X_POSSIBLE_NAMES=x", "-oo", "Y_POSSIBLE_NAMES=y"]
        query = "SELECT ST_DelaunayTriangulation(ST_Collect(geometry)) AS geometry FROM points"
        sql = ["-dialect", "sqlite", "-sql", query, "-explodecollections", "-nlt", "POLYGON"]
        return ["ogr2ogr", case.path(self.written), case.csv(), *columns, *sql]


class Pdal(Program):
    name = "PDAL"
    stores = "a PLY file"
    constrains = False

    def __init__(self):
        if not shutil.which("pdal"):
            self.why = "PDAL is not installed"

    def version(self):
        return measured.run(["pdal", "--version"]).printed.split()[1]

    def steps(self, constrained=False):
        return "1 command with 3 stages"

    def command(self, case):
        given = case.path("points.txt")
        if not given.exists():
            flat = numpy.column_stack([case.points, numpy.zeros(len(case.points))])
            numpy.savetxt(given, flat, fmt="%.17g", delimiter=",", header="X,Y,Z", comments="")
        target = case.path("pdal.ply")
        return ["pdal", "translate", given, target, "delaunay", "--writers.ply.faces=true"]

    def triangles(self, case, limit):
        raise measured.Skipped(self.why or "its PLY files are not read")


def programs(tiletool, spade, folder):
    """Returns all programs, also those that are not installed."""
    return [
        Tiletool(tiletool),
        Tiletool(tiletool, "tiletool, 1 thread, 256 MiB", "--threads", 1, "--memory", "256MiB"),
        Cgal(folder),
        Spade(spade),
        InPython("Triangle", "triangle", constrains=True),
        InPython("SciPy", "scipy"),
        Startinpy(),
        Whitebox(),
        Gdal(),
        Pdal(),
    ]
