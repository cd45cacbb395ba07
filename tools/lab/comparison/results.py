"""Reads the triangles that programs wrote: corners, and vertices if they are not the points of the input."""

import numpy

# A polygon of one ring of four points in a shapefile: a triangle.
HEAD = [("number", ">i4"), ("length", ">i4"), ("type", "<i4"), ("box", "<f8", 4)]
# A record without a shape: its number, length and type.
NOTHING = b"\0\0\0\1\0\0\0\2\0\0\0\0"
TRIANGLE = numpy.dtype([*HEAD, ("parts", "<i4"), ("points", "<i4"), ("first", "<i4"), ("ring", "<f8", (4, 2))])


class NoTriangles(Exception):
    """A result that cannot be read, and why."""


def read_corners(corners, vertices=None):
    """Returns triangles of raw numbers, and the raw vertices if the program has its own."""
    own = None if vertices is None else numpy.fromfile(vertices, "<f8").reshape(-1, 2)
    return numpy.fromfile(corners, "<u4").reshape(-1, 3).astype(int), own


def read_ele(path):
    """Returns triangles and vertices of Triangle's text files."""
    with open(path.with_suffix(".node")) as nodes:
        rows = [line.split() for line in nodes if not line.startswith("#")]
    first = int(rows[1][0]) if len(rows) > 1 else 0
    vertices = numpy.array([[float(x), float(y)] for _, x, y, *_ in rows[1:]]).reshape(-1, 2)
    with open(path) as elements:
        rows = [line.split() for line in elements if not line.startswith("#")]
    corners = numpy.array([[int(n) for n in row[1:4]] for row in rows[1:]], int).reshape(-1, 3)
    return corners - first, vertices


def read_polygons(path):
    """Returns triangles and vertices of a shapefile with a polygon for each triangle."""
    body = path.read_bytes()[100:] if path.exists() else b""
    if len(body) == len(NOTHING) and body[4:] == NOTHING[4:]:
        body = b""
    if len(body) % TRIANGLE.itemsize:
        raise NoTriangles("has polygons that are no triangles")
    rings = numpy.frombuffer(body, TRIANGLE)["ring"]
    if not (rings[:, 0] == rings[:, 3]).all():
        raise NoTriangles("has polygons that are no triangles")
    vertices, corners = numpy.unique(rings[:, :3].reshape(-1, 2), axis=0, return_inverse=True)
    return corners.reshape(-1, 3), vertices
