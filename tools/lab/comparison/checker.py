#!/usr/bin/env python3
"""Checks exactly, with whole numbers, whether triangles are a Delaunay triangulation. It uses no library.

    tools/lab/comparison/checker.py points.f64 corners.u32

It checks that every triangle is counter-clockwise, that every edge inside is locally Delaunay, that the areas sum up
to that of the convex hull, that every position of the points is a corner, and that there are as many triangles and
edges of the hull as Euler's formula demands. Given segments, it checks that they are chains of edges; those edges need
not be locally Delaunay. All of this together proves the triangulation; it is not unique where points are on a circle.
"""

import array
import sys
from collections import Counter
from fractions import Fraction
from itertools import pairwise


class Report:
    """What is wrong: nothing, if the triangulation is correct."""

    def __init__(self):
        self.wrong = set()
        self.missing = self.strange = self.lost_segments = 0
        self.area = self.count = True
        self.too_little = False

    def correct(self):
        return not (self.wrong or self.missing or self.strange or self.lost_segments) and self.area and self.count

    def __str__(self):
        said = [
            (self.strange, f"{self.strange} corners that are no points"),
            (self.wrong, f"{len(self.wrong)} wrong triangles"),
            (self.missing, f"{self.missing} missing points"),
            (self.lost_segments, f"{self.lost_segments} missing segments"),
            (not self.area, "does not fill the hull" if self.too_little else "overlaps"),
        ]
        # What is said above leads to a wrong number in most cases.
        text = ", ".join(text for is_so, text in said if is_so)
        return text or ("correct" if self.count else "wrong number of triangles")


def whole(points):
    """Returns the points, scaled by a power of two so that all coordinates are whole numbers."""
    exact = [(Fraction(x), Fraction(y)) for x, y in points]
    scale = max((number.denominator for point in exact for number in point), default=1)
    return [(int(x * scale), int(y * scale)) for x, y in exact]


def turn(a, b, c):
    """Returns twice the signed area: positive if the triangle is counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def in_circle(a, b, c, d):
    """Returns a positive number if d is inside the circle through the counter-clockwise a, b and c."""
    ax, ay, bx, by, cx, cy = a[0] - d[0], a[1] - d[1], b[0] - d[0], b[1] - d[1], c[0] - d[0], c[1] - d[1]
    lift = (ax * ax + ay * ay) * (bx * cy - by * cx)
    lift += (bx * bx + by * by) * (cx * ay - cy * ax)
    return lift + (cx * cx + cy * cy) * (ax * by - ay * bx)


def hull(points):
    """Returns the distinct points on the boundary of the convex hull, also those within its sides, in order."""
    points = sorted(points)
    if all(turn(points[0], points[-1], point) == 0 for point in points):
        return points

    def half(points):
        chain = []
        for point in points:
            while len(chain) >= 2 and turn(chain[-2], chain[-1], point) < 0:
                chain.pop()
            chain.append(point)
        return chain[:-1]

    return half(points) + half(points[::-1])


def doubled_area(ring):
    return sum(turn(ring[0], b, c) for b, c in pairwise(ring))


def chains(points, segments):
    """Returns for each segment the edges that it must consist of: from each point on it to the next."""
    for a, b in segments:
        along = [p for p in points if turn(a, b, p) == 0 and min(a, b) <= p <= max(a, b)]
        along.sort()
        yield list(pairwise(along))


def check_edges(triangles, constraints, report):
    """Checks the edges inside. Returns those of the boundary, and all."""
    apex = {}
    for number, (a, b, c) in enumerate(triangles):
        for edge, opposite in (((a, b), c), ((b, c), a), ((c, a), b)):
            if edge in apex:
                # Two triangles on the same side of an edge overlap.
                report.wrong |= {number, apex[edge][1]}
            apex[edge] = opposite, number
    boundary = []
    for (a, b), (c, number) in apex.items():
        across = apex.get((b, a))
        if across is None:
            boundary.append((a, b))
        elif a < b and (a, b) not in constraints and turn(a, b, c) > 0 and in_circle(a, b, c, across[0]) > 0:
            report.wrong |= {number, across[1]}
    return boundary, apex


def counter_clockwise(triangles):
    """Returns triangles that are polygons, whose orders mean nothing, in order."""
    return [(a, c, b) if turn(a, b, c) < 0 else (a, b, c) for a, b, c in triangles]


def check(points, corners, segments=(), vertices=None, polygons=False):
    """Checks triangles: three numbers of vertices each. The vertices are the points unless they are given."""
    report = Report()
    vertices = points if vertices is None else vertices
    exact = whole([*points, *vertices])
    given, places = exact[: len(points)], exact[len(points) :]
    distinct = set(given)
    triangles = [tuple(places[number] for number in triangle) for triangle in corners]
    triangles = counter_clockwise(triangles) if polygons else triangles
    report.strange = len({corner for triangle in triangles for corner in triangle} - distinct)
    report.wrong = {number for number, triangle in enumerate(triangles) if turn(*triangle) <= 0}
    wanted = list(chains(distinct, [(given[a], given[b]) for a, b in segments]))
    edges_of_segments = {edge for chain in wanted for edge in chain}
    boundary, apex = check_edges(triangles, edges_of_segments, report)
    border = hull(distinct) if distinct else []
    area = doubled_area(border) if border else 0
    filled = sum(turn(*triangle) for triangle in triangles)
    report.area, report.too_little = filled == area, filled < area
    if area == 0:
        # Points on a line have no triangles.
        report.count = not triangles
        return report
    report.missing = len(distinct - {corner for triangle in triangles for corner in triangle})
    # Euler's formula, for a triangulation whose boundary is that of the hull.
    sides = Counter(zip(border, border[1:] + border[:1]))
    report.count = len(triangles) == 2 * len(distinct) - 2 - len(border) and Counter(boundary) == sides
    report.lost_segments = sum(not all((a, b) in apex or (b, a) in apex for a, b in chain) for chain in wanted)
    return report


def pairs(numbers, size):
    return list(zip(*[iter(numbers)] * size))


def read(path, kind, size):
    """Returns tuples of numbers of a raw file."""
    numbers = array.array(kind)
    with open(path, "rb") as file:
        numbers.frombytes(file.read())
    return pairs(numbers, size)


def main(points, corners):
    report = check(read(points, "d", 2), read(corners, "I", 3))
    print(report)
    return 0 if report.correct() else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
