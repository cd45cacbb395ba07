"""A survey with break lines and a pond: LAS and shapefiles in, FlatGeobuf and GeoParquet out."""

import geopandas
import laspy
import numpy
import pyogrio
import shapely
from common import has_ogrinfo, ogrinfo, rows, same, same_system, tool
from features import export


def draw(folder, points, system):
    """Writes shapefiles with two break lines that cross and with a pond beside them. Returns the geometries."""
    low, high = points.min(0), points.max(0)

    def at(*places):
        return low + (high - low) * numpy.array(places)

    lines = [at((0.35, 0.3), (0.75, 0.62)), at((0.4, 0.6), (0.5, 0.4), (0.7, 0.3))]
    lines = [shapely.LineString(line) for line in lines]
    angles = numpy.arange(24) * (2 * numpy.pi / 24)
    shore = numpy.column_stack([0.5 + 0.12 * numpy.cos(angles), 0.75 + 0.08 * numpy.sin(angles)])
    pond = shapely.Polygon(at(*shore))
    for name, shapes in [("lines", lines), ("pond", [pond])]:
        frame = geopandas.GeoDataFrame({"number": range(len(shapes))}, geometry=shapes, crs=system)
        pyogrio.write_dataframe(frame, folder / f"{name}.shp")
    return lines, pond


def check_free_space(triangles, points, pond):
    """The triangles cover the convex hull but for the pond, once."""
    hull = shapely.MultiPoint(points).convex_hull
    expected = hull.area - pond.area
    for what, area in [("sum", triangles.area.sum()), ("union", triangles.union_all().area)]:
        assert abs(area - expected) <= 1e-9 * expected, f"{what} of the areas: {area}, not {expected}"
    inside = shapely.intersects_xy(pond.buffer(-1e-6), *shapely.get_coordinates(triangles.centroid).T)
    same("triangles in the pond", int(inside.sum()), 0)


def check_lines(edges, vertices, lines, pond):
    """Each line is the union of edges, with a vertex where the two cross."""
    crossing = lines[0].intersection(lines[1])
    same("crossing", crossing.geom_type, "Point")
    near_crossing = vertices.geometry.distance(crossing) < 1e-6 * lines[0].length
    same("vertices at the crossing", int(near_crossing.sum()), 1)
    for name, line in [("first line", lines[0]), ("second line", lines[1]), ("shore", pond.exterior)]:
        # The crossing point is rounded, so edges beside it may be off the line by as much.
        on_line = edges.geometry[edges.geometry.within(line.buffer(1e-6))]
        length = on_line.length.sum()
        assert abs(length - line.length) <= 1e-9 * line.length, f"{name}: {length}, not {line.length}"
        missing = rows(shapely.get_coordinates(line)) - rows(on_line.get_coordinates())
        same(f"{name}: corners without an edge", missing, set())


def check(folder, survey):
    """Builds the survey with its lines, exports it, and checks what GDAL and geopandas read."""
    las = laspy.read(survey)
    points = numpy.column_stack([las.x, las.y])
    system = las.header.parse_crs()
    code = system.to_epsg()
    lines, pond = draw(folder, points, system)
    tiles = folder / "survey.tiles"
    shapes = ["--segments", folder / "lines.shp", "--obstacles", folder / "pond.shp"]
    more = ["--crossings", "split", "--missing-z", "zero", "--tile-vertices", 500]
    tool("build", survey, "-o", tiles, *shapes, *more)
    inspected = tool("inspect", tiles)
    same("code", inspected["epsg"], code)
    for suffix in ["fgb", "parquet"]:
        triangles = export(tiles, folder / f"free.{suffix}", "triangles", code or system)
        vertices = export(tiles, folder / f"vertices.{suffix}", "vertices", code or system, "--what", "vertices")
        edges = export(tiles, folder / f"edges.{suffix}", "edges", code or system, "--what", "edges")
        same("triangles", len(triangles), inspected["triangles"] - inspected["hole_triangles"])
        check_free_space(triangles, points, pond)
        check_lines(edges, vertices, lines, pond)
        corners = rows(shapely.get_coordinates([*lines, pond]))
        # The last one is where the lines cross.
        same("vertices", len(vertices), len(rows(points) | corners) + 1)
    counts = f"{len(vertices)} vertices, {len(triangles)} free triangles, {len(edges)} edges of lines"
    print(f"survey in {system.name}: {counts}")
