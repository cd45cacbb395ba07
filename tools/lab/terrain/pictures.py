"""Draws hillshades with contours, as in docs/terrain.md.

    pictures.py TILETOOL INPUT -o PICTURE.png --resolution R --contours STEP [--base B] [--title T] [--ponds STEP] [--build=OPTIONS]

INPUT is anything that `tiletool build` takes, or a grid (NAME.f32le with NAME.json beside it), whose cells become
points in metres. With --ponds, each depression that a closed contour bounds, of those STEP apart, becomes a pond
(`build --flatten`), and is drawn too. Everything but the drawing is done by tiletool.
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy
import rasterio
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from PIL import Image

METRES_PER_DEGREE = 111_320


def run(*command):
    subprocess.run([str(part) for part in command], check=True)


def points_of_grid(path, folder):
    """Writes the cells of a grid as points in metres."""
    about = json.loads(path.with_suffix(".json").read_text())
    z = numpy.fromfile(path, "<f4").reshape(about["rows"], about["cols"]).astype(float)
    step = about["dy"] * METRES_PER_DEGREE
    middle = about["y0_cell_centre_top"] - about["rows"] / 2 * about["dy"]
    x = numpy.arange(about["cols"]) * about["dx"] * METRES_PER_DEGREE * math.cos(math.radians(middle))
    y = (about["rows"] - 1 - numpy.arange(about["rows"])) * step
    x, y = numpy.meshgrid(x, y)
    numpy.column_stack([x.ravel(), y.ravel(), z.ravel()]).astype("<f8").tofile(folder / "grid.f64")
    return folder / "grid.f64"


def lines_of(path):
    """The level and the positions of each contour."""
    for feature in json.loads(path.read_text())["features"]:
        geometry = feature["geometry"]
        parts = geometry["coordinates"]
        for part in parts if geometry["type"] == "MultiLineString" else [parts]:
            yield feature["properties"]["z"], numpy.array(part)[:, :2]


def area(ring):
    """The signed area of a closed ring."""
    x, y = (ring - ring[0]).T
    return 0.5 * numpy.sum(x[:-1] * y[1:] - x[1:] * y[:-1])


def depressions(contours, least):
    """The closed contours of at least this area with lower ground inside. Contours have it on their right."""
    rings = [(level, ring) for level, ring in contours if (ring[0] == ring[-1]).all() and area(ring) <= -least]
    rings.sort(key=lambda level_and_ring: area(level_and_ring[1]))
    taken = []
    for _, ring in rings:
        # A ring inside a larger one is in its pond already.
        if not any(contains(other, ring[0]) for other in taken):
            taken.append(ring)
    return taken


def contains(ring, point):
    (x, y), (a, b) = point, (ring[:-1], ring[1:])
    crosses = (a[:, 1] <= y) != (b[:, 1] <= y)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool(numpy.count_nonzero(crosses & (at > x)) % 2)


def ponds_of(args, folder, points):
    """Writes the ponds of a set of points as polygons."""
    run(args.tiletool, "build", points, "-o", folder / "alone.tiles", "--quiet", *args.build)
    run(args.tiletool, "export", folder / "alone.tiles", "-o", folder / "alone.geojson", "--contours", args.ponds)
    rings = depressions(list(lines_of(folder / "alone.geojson")), args.least_area)
    polygons = [[ring[::-1].tolist()] for ring in rings]
    (folder / "ponds.geojson").write_text(json.dumps({"type": "MultiPolygon", "coordinates": polygons}))
    return rings


def draw(args, folder, ponds):
    with rasterio.open(folder / "shade.tif") as raster:
        shade = raster.read(1, masked=True)
        left, bottom, right, top = raster.bounds
    width = 10
    figure, axes = pyplot.subplots(figsize=(width, width * (top - bottom) / (right - left) + 0.5), dpi=100)
    axes.imshow(shade, cmap="gray", vmin=0, vmax=255, extent=(left, right, bottom, top), interpolation="none")
    contours = list(lines_of(folder / "contours.geojson"))
    is_main = [round((level - args.base) / args.contours) % 5 == 0 for level, _ in contours]
    for main, line_width in [(False, 0.35), (True, 0.9)]:
        some = [line for (_, line), its in zip(contours, is_main) if its == main]
        axes.add_collection(LineCollection(some, linewidths=line_width, colors="#7a3b10"))
    axes.add_collection(PolyCollection(ponds, facecolors="#4a90c4a0", edgecolors="#1f5f8b", linewidths=0.8))
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", title=args.title)
    axes.tick_params(labelsize=7)
    axes.ticklabel_format(useOffset=False, style="plain")
    figure.tight_layout()
    figure.savefig(args.output)
    # Few colours are enough, in a third of the bytes.
    Image.open(args.output).convert("RGB").quantize(96).save(args.output, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiletool", type=Path)
    parser.add_argument("input", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--resolution", type=float, required=True, help="side of a cell")
    parser.add_argument("--contours", type=float, required=True, help="height between contours")
    parser.add_argument("--base", type=float, default=0)
    parser.add_argument("--ponds", type=float, help="height between the contours that may bound ponds")
    parser.add_argument("--least-area", type=float, default=0, help="area of the smallest pond")
    parser.add_argument("--max-edge", type=float, help="from the hull inwards")
    parser.add_argument("--title", default="")
    parser.add_argument("--build", type=str.split, default=[], help="options of tiletool build")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        points = args.input
        if points.suffix == ".f32le":
            points = points_of_grid(points, folder)
            args.build += ["--dims", "3"]
        ponds, flatten = [], []
        if args.ponds:
            ponds, flatten = ponds_of(args, folder, points), ["--flatten", folder / "ponds.geojson"]
        tiles = folder / "ground.tiles"
        run(args.tiletool, "build", points, "-o", tiles, "--crossings", "split", *flatten, *args.build)
        surface = ["--max-edge", args.max_edge, "--from-hull"] if args.max_edge else []
        shade = ["--what", "hillshade", "--resolution", args.resolution]
        run(args.tiletool, "export", tiles, "-o", folder / "shade.tif", *shade, *surface)
        levels = ["--contours", args.contours, "--base", args.base]
        run(args.tiletool, "export", tiles, "-o", folder / "contours.geojson", *levels, *surface)
        draw(args, folder, ponds)


if __name__ == "__main__":
    main()
