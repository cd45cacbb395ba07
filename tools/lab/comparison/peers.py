#!/usr/bin/env python3
"""What somebody writes in Python for each library: `compare.py` runs each function in a process of its own.

    tools/lab/comparison/peers.py FUNCTION FILE ...

Points are raw f64; results are raw u32, three numbers of points a triangle, or what the library writes by itself. The
comparison counts the lines of each function as its steps, so each has all that it needs, and nothing else.
"""

import inspect
import sys


def triangle_delaunay(points, corners):
    import numpy
    import triangle

    given = {"vertices": numpy.fromfile(points).reshape(-1, 2)}
    triangle.triangulate(given, "z")["triangles"].astype("u4").tofile(corners)


def triangle_constrained(points, corners, segments):
    import numpy
    import triangle

    given = {"vertices": numpy.fromfile(points).reshape(-1, 2)}
    given["segments"] = numpy.fromfile(segments, "u4").reshape(-1, 2)
    # Without c, it would leave out triangles between the segments and the hull.
    triangle.triangulate(given, "pcz")["triangles"].astype("u4").tofile(corners)


def scipy_delaunay(points, corners):
    import numpy
    import scipy.spatial

    found = scipy.spatial.Delaunay(numpy.fromfile(points).reshape(-1, 2))
    found.simplices.astype("u4").tofile(corners)


def startinpy_delaunay(points, corners, vertices):
    import numpy
    import startinpy

    xy = numpy.fromfile(points).reshape(-1, 2)
    triangulation = startinpy.DT()
    # Points at a smaller distance are merged; the default is 1e-3, and 0 is ignored.
    triangulation.snap_tolerance = 1e-300
    triangulation.insert(numpy.column_stack([xy, numpy.zeros(len(xy))]))
    triangulation.triangles.astype("u4").tofile(corners)
    # It numbers points as it inserts them.
    triangulation.points[:, :2].tofile(vertices)


def whitebox_delaunay(points, polygons):
    import whitebox_workflows

    environment = whitebox_workflows.WbEnvironment()
    given = environment.read_vector(points)
    environment.vector.sampling_gridding.construct_vector_tin(input_points=given, output=polygons)


def startinpy_dem(survey, target, xmin, ymax, columns, rows, cell):
    import laspy
    import numpy
    import startinpy

    las = laspy.read(survey)
    triangulation = startinpy.DT()
    triangulation.snap_tolerance = 1e-9
    triangulation.insert(numpy.column_stack([las.x, las.y, las.z]))
    columns, rows, cell = int(columns), int(rows), float(cell)
    x = float(xmin) + (numpy.arange(columns) + 0.5) * cell
    y = float(ymax) - (numpy.arange(rows) + 0.5) * cell
    centres = numpy.stack(numpy.meshgrid(x, y), axis=-1).reshape(-1, 2)
    heights = triangulation.interpolate({"method": "TIN"}, centres)
    # It writes no rasters. An ASCII grid needs no further library; a GeoTIFF would need rasterio or GDAL.
    head = f"ncols {columns}\nnrows {rows}\nxllcorner {xmin}\nyllcorner {float(ymax) - rows * cell!r}\n"
    head += f"cellsize {cell!r}\nNODATA_value -9999"
    heights = numpy.where(numpy.isnan(heights), -9999, heights).reshape(rows, columns)
    numpy.savetxt(target, heights, fmt="%.17g", header=head, comments="")


def whitebox_dem(survey, target, cell):
    import whitebox_workflows

    environment = whitebox_workflows.WbEnvironment()
    given = environment.read_lidar(survey)
    gridding = environment.lidar.interpolation_gridding
    gridding.lidar_tin_gridding(input=given, resolution=float(cell), output=target)


def las_to_text(survey, text):
    import laspy
    import numpy

    las = laspy.read(survey)
    xyz = numpy.column_stack([las.x, las.y, las.z])
    numpy.savetxt(text, xyz, fmt="%.3f", delimiter=",", header="x,y,z", comments="")


def lines_of(function):
    """Returns the number of lines that a person writes: those within the function with anything but a comment."""
    lines = [line.strip() for line in inspect.getsource(function).splitlines()[1:]]
    return sum(1 for line in lines if line and not line.startswith("#"))


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
