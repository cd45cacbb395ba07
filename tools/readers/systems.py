"""Reference systems: the PROJJSON of GeoParquet for codes and for WKT of several kinds, by pyproj."""

import json

import pyarrow.parquet
import pyproj
from common import same, same_system, tool
from pyproj.enums import WktVersion

# One for each of the usual methods, units, meridians and orders of axes.
CODES = [2056, 2154, 2193, 2225, 2994, 3031, 3035, 3857, 4258, 4326, 25832, 27572, 27700, 28992, 31256, 31370, 32661]
KINDS = [WktVersion.WKT1_GDAL, WktVersion.WKT1_ESRI, WktVersion.WKT2_2019]


def crs_of_parquet(folder, text):
    """Builds a file whose system has this text, exports it, and returns the key `geo` and the notes."""
    points = folder / "points.csv"
    points.write_text("0,0\n1,0\n0,1\n")
    tiles, path = folder / "system.tiles", folder / "system.parquet"
    tool("build", points, "-o", tiles, "--crs", text, "--force")
    notes = tool("export", tiles, "-o", path)["notes"]
    metadata = pyarrow.parquet.read_schema(path).metadata
    return json.loads(metadata[b"geo"])["columns"]["geometry"], metadata, notes


def check(folder):
    for code in CODES:
        geo, _, notes = crs_of_parquet(folder, f"EPSG:{code}")
        same_system(f"EPSG:{code}", geo["crs"], code)
        same(f"code of EPSG:{code}", (geo["crs"]["id"]["code"], notes), (code, []))
    for code in [2056, 2994, 3031, 4326, 28992]:
        for kind in KINDS:
            text = pyproj.CRS.from_epsg(code).to_wkt(kind)
            geo, _, _ = crs_of_parquet(folder, text)
            same_system(f"{kind.name} of EPSG:{code}", geo["crs"], code)
    geo, _, notes = crs_of_parquet(folder, "OGC:CRS84")
    same("CRS84", ("crs" in geo, notes), (False, []))
    text = 'PROJCS["mine",GEOGCS["WGS 84"],PROJECTION["of_my_own"],UNIT["metre",1]]'
    geo, metadata, notes = crs_of_parquet(folder, text)
    same("a system that cannot be converted", (geo["crs"], len(notes)), (None, 1))
    same("its text", metadata[b"delaunay-tiles:crs"].decode(), text)
    print(f"{len(CODES)} codes and {len(KINDS)} kinds of WKT are the right PROJJSON")
