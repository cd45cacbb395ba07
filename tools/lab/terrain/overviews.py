#!/usr/bin/env python3
"""Overviews beside greedy insertion (pydelatin) on grids of heights, with equally many vertices.

    python3 -m pip install -r tools/lab/terrain/requirements.txt
    tools/lab/terrain/overviews.py target/release/tiletool jacksboro_fault.f32le:344:403
    tools/lab/terrain/overviews.py target/release/tiletool --tile-vertices 100 a.f32le:91:120 b.f32le:344:403

A grid is a file of little-endian f32, row by row, with its numbers of rows and columns. All of its points become points
of a tile file, one apart. For each overview, this prints the root mean square of the errors at all points of the grid,
that of greedy insertion with as many vertices, and their ratio; the same of the largest errors.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
from pydelatin import Delatin

# How close the numbers of vertices must be.
CLOSE = 0.002


def overviews(tiletool, heights, tile_vertices):
    """The overviews of a grid, as tiletool lists them."""
    rows, columns = heights.shape
    y, x = numpy.mgrid[0:rows, 0:columns]
    points = numpy.stack([x.ravel(), y.ravel(), heights.ravel()], axis=1)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        points.astype("<f8").tofile(folder / "grid.f64")
        command = [tiletool, "build", folder / "grid.f64", "--dims", "3", "-o", folder / "grid.tiles", "--overviews"]
        command += ["--tile-vertices", str(tile_vertices), "--json"]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)["overview_list"]


def errors(heights, vertices, triangles):
    """The root mean square and the largest of the errors of a triangulation at all points of a grid."""
    found = numpy.full(heights.shape, numpy.nan)
    for corners in vertices[triangles]:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
        x0, x1 = int(min(ax, bx, cx)), int(max(ax, bx, cx))
        y0, y1 = int(min(ay, by, cy)), int(max(ay, by, cy))
        y, x = numpy.mgrid[y0 : y1 + 1, x0 : x1 + 1]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        of_b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
        of_c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
        is_inside = (of_b >= -1e-12) & (of_c >= -1e-12) & (of_b + of_c <= 1 + 1e-12)
        z = az + of_b * (bz - az) + of_c * (cz - az)
        found[y0 : y1 + 1, x0 : x1 + 1][is_inside] = z[is_inside]
    assert not numpy.isnan(found).any()
    difference = found - heights
    return numpy.sqrt(numpy.mean(difference**2)), numpy.abs(difference).max()


def greedy(heights, count):
    """The triangulation by greedy insertion with about so many vertices."""
    low, high = 0.0, float(numpy.ptp(heights))
    best = None
    for _ in range(40):
        middle = (low + high) / 2
        mesh = Delatin(heights.astype("<f4"), max_error=middle)
        found = len(mesh.vertices)
        if best is None or abs(found - count) < abs(len(best.vertices) - count):
            best = mesh
        if abs(found - count) <= CLOSE * count:
            break
        low, high = (middle, high) if found > count else (low, middle)
    vertices = numpy.array(best.vertices, dtype=float).reshape(-1, 3)
    # It counts rows from the other end.
    vertices[:, 1] = heights.shape[0] - 1 - vertices[:, 1]
    at = heights[vertices[:, 1].astype(int), vertices[:, 0].astype(int)]
    assert numpy.abs(at - vertices[:, 2]).max() < 1e-3
    return vertices, numpy.array(best.triangles).reshape(-1, 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    parser.add_argument("grids", nargs="+", metavar="FILE:ROWS:COLUMNS")
    parser.add_argument("--tile-vertices", type=int, default=200, help="the coarsest overview is one tile")
    parser.add_argument("--most", type=float, help="fail if a ratio of root mean squares is larger")
    arguments = parser.parse_args()
    worst = 0.0
    print("| grid | vertices | rms | greedy: vertices | rms | ratio | largest | greedy: largest | ratio |")
    print("|---|---|---|---|---|---|---|---|---|")
    for grid in arguments.grids:
        path, rows, columns = grid.rsplit(":", 2)
        heights = numpy.fromfile(path, "<f4").reshape(int(rows), int(columns)).astype(float)
        for row in overviews(arguments.tiletool, heights, arguments.tile_vertices):
            vertices, triangles = greedy(heights, row["vertices"])
            rms, largest = errors(heights, vertices, triangles)
            ratio = row["rms_error"] / rms
            worst = max(worst, ratio)
            cells = [Path(path).stem, row["vertices"], f"{row['rms_error']:.4g}", len(vertices), f"{rms:.4g}"]
            cells += [f"{ratio:.2f}", f"{row['largest_error']:.4g}", f"{largest:.4g}"]
            cells += [f"{row['largest_error'] / largest:.2f}"]
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)
    if arguments.most is not None and worst > arguments.most:
        sys.exit(f"a ratio is {worst:.2f}, more than {arguments.most}")


if __name__ == "__main__":
    main()
