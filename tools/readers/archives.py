"""Archives of map tiles: PMTiles by the readers of their authors, pictures by pillow, vector tiles by mapbox-vector-tile."""

import gzip
import io

import mapbox_vector_tile
import numpy
from common import near, same, tool
from PIL import Image
from pmtiles.reader import MmapSource, Reader, all_tiles
from pmtiles.tile import Compression, TileType, zxy_to_tileid


def check_directory(path, header, tiles, report):
    """What `pmtiles verify` checks: sections that follow each other, counts, and tiles in the order of their numbers."""
    same("version and order", (header["version"], header["clustered"]), (3, True))
    same("numbers of map tiles", (len(tiles), header["addressed_tiles_count"]), (report["map_tiles"],) * 2)
    numbers = [zxy_to_tileid(*zxy) for zxy, _ in tiles]
    same("order", numbers, sorted(set(numbers)))
    zooms = [zxy[0] for zxy, _ in tiles]
    assert header["min_zoom"] <= min(zooms) and max(zooms) <= header["max_zoom"], zooms
    contents = {data for _, data in tiles}
    same("contents, each stored once", header["tile_contents_count"], len(contents))
    same("bytes of contents", header["tile_data_length"], sum(map(len, contents)))
    last = max(
        header[f"{part}_offset"] + header[f"{part}_length"]
        for part in ["root", "metadata", "leaf_directory", "tile_data"]
    )
    same("length", path.stat().st_size, last)


def check_place(header, metadata, tiles):
    """The bounds are on Earth, and each tile meets them."""
    west, south, east, north = metadata["bounds"]
    of_header = [header[f"{side}_e7"] / 1e7 for side in ["min_lon", "min_lat", "max_lon", "max_lat"]]
    near("bounds", of_header, metadata["bounds"], 1e-9)
    assert -180 <= west < east <= 180 and -85.06 < south < north < 85.06, metadata["bounds"]
    for (z, x, y), _ in tiles:
        lon = [(x + i) / 2**z * 360 - 180 for i in (0, 1)]
        lat = [numpy.degrees(numpy.arctan(numpy.sinh(numpy.pi * (1 - 2 * (y + i) / 2**z)))) for i in (1, 0)]
        assert lon[0] <= east and west <= lon[1] and lat[0] <= north and south <= lat[1], (z, x, y)


def check_heights(tiles, z):
    """Heights are within those of the file, which is in feet, rounded to 1/256 m."""
    for zxy, data in tiles:
        pixels = numpy.asarray(Image.open(io.BytesIO(data)).convert("RGBA"), float)
        heights = pixels[..., 0] * 256 + pixels[..., 1] + pixels[..., 2] / 256 - 32768
        heights = heights[pixels[..., 3] > 0] / 0.3048
        assert heights.size and z.min() - 0.02 <= heights.min() and heights.max() <= z.max() + 0.02, zxy


def check_vectors(tiles, metadata):
    """Layers and fields are those of the metadata. Some tile has triangles."""
    known = {layer["id"]: set(layer["fields"]) for layer in metadata["vector_layers"]}
    found = set()
    for zxy, data in tiles:
        for name, layer in mapbox_vector_tile.decode(gzip.decompress(data)).items():
            assert layer["features"] and name in known, (zxy, name)
            assert all(set(feature["properties"]) <= known[name] for feature in layer["features"]), (zxy, name)
            found.add(name)
    assert {"cells", "info", "triangles"} <= found, found


def check(folder, tiles_file, z):
    """Exports all layers in both grids, and compares headers, metadata and tiles. `z` are the heights of the input."""
    counts = 0
    for layer in ["shade", "terrarium", "mesh"]:
        for grid in ["native", "WebMercatorQuad"]:
            path = folder / f"{layer}-{grid}.pmtiles"
            zooms = ["--zooms", "0..2"] if grid == "native" else []
            report = tool("export", tiles_file, "-o", path, "--layer", layer, "--grid", grid, *zooms)
            with open(path, "rb") as file:
                source = MmapSource(file)
                reader = Reader(source)
                header, metadata, tiles = reader.header(), reader.metadata(), list(all_tiles(source))
                for zxy, data in tiles:
                    same(f"{path.name}: {zxy}", reader.get(*zxy), data)
            check_directory(path, header, tiles, report)
            check_place(header, metadata, tiles)
            same("grid and zooms", (metadata["grid"], [metadata["minzoom"], metadata["maxzoom"]]), (grid, report["zooms"]))
            same("encoding", metadata.get("encoding"), "terrarium" if layer == "terrarium" else None)
            is_mesh = layer == "mesh"
            expected = (TileType.MVT, Compression.GZIP) if is_mesh else (TileType.PNG, Compression.NONE)
            same("type and compression", (header["tile_type"], header["tile_compression"]), expected)
            if is_mesh:
                check_vectors(tiles, metadata)
            else:
                same("sizes", {Image.open(io.BytesIO(data)).size for _, data in tiles}, {(256, 256)})
            if layer == "terrarium":
                check_heights(tiles, z)
            counts += len(tiles)
    print(f"{counts} map tiles in 6 archives are what their headers and metadata say")
