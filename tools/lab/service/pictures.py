#!/usr/bin/env python3
"""Draws a map of a served file at four zooms, from the whole file to single triangles.

    tiletool serve survey.tiles &
    python3 -m pip install -r tools/lab/service/requirements.txt
    tools/lab/service/pictures.py http://127.0.0.1:3000/survey survey.png --zooms 0,2,4,6 --centre 637000,849200

Each of the four parts shows 3 x 2 tiles of the layer `shade` of the grid `native` around one point, on white.
"""

import argparse
import io
import json
import math
import urllib.error
import urllib.request

from PIL import Image

SIDE, COLUMNS, ROWS, GAP = 256, 3, 2, 8


def fetch(url):
    """Returns the body at a URL, or nothing if the service has none."""
    try:
        with urllib.request.urlopen(url) as answer:
            return answer.read()
    except urllib.error.HTTPError as error:
        if error.code == 404:
            return b""
        raise


def part(url, zoom, centre):
    """Returns a picture around a point, which is given in parts of the grid's side, from the upper left."""
    picture = Image.new("RGB", (COLUMNS * SIDE, ROWS * SIDE), "white")
    left, top = (c * SIDE * 2**zoom - n * SIDE / 2 for c, n in zip(centre, (COLUMNS, ROWS)))
    for x in range(math.floor(left / SIDE), math.floor(left / SIDE) + COLUMNS + 1):
        for y in range(math.floor(top / SIDE), math.floor(top / SIDE) + ROWS + 1):
            body = fetch(f"{url}/{zoom}/{x}/{y}.png") if 0 <= min(x, y) <= max(x, y) < 2**zoom else b""
            if body:
                tile = Image.open(io.BytesIO(body)).convert("RGBA")
                picture.paste(tile, (round(x * SIDE - left), round(y * SIDE - top)), tile)
    return picture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url", help="URL of the file, such as http://127.0.0.1:3000/survey")
    parser.add_argument("output", help="PNG to write")
    parser.add_argument("--zooms", type=lambda text: [int(zoom) for zoom in text.split(",")], required=True)
    parser.add_argument("--centre", type=lambda text: [float(c) for c in text.split(",")], required=True,
                        help="X,Y in coordinates of the file")
    args = parser.parse_args()
    left, bottom, right, top = json.loads(fetch(args.url))["grids"]["native"]["tile_0"]
    centre = ((args.centre[0] - left) / (right - left), (top - args.centre[1]) / (top - bottom))
    width, height = COLUMNS * SIDE, ROWS * SIDE
    whole = Image.new("RGB", (2 * width + GAP, 2 * height + GAP), "white")
    for index, zoom in enumerate(args.zooms):
        picture = part(f"{args.url}/native/shade", zoom, centre)
        whole.paste(picture, (index % 2 * (width + GAP), index // 2 * (height + GAP)))
    whole.quantize(256, dither=Image.Dither.NONE).save(args.output, optimize=True)


if __name__ == "__main__":
    main()
