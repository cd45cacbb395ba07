"""Lines and polygons of any kind as well-known binary."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any

import numpy as np

from ._arguments import coordinates

_LINE, _POLYGON, _COLLECTION = 2, 3, 7
_WITH_Z = 1000


def wkb(geometries: Any, are_polygons: bool, name: str) -> list[bytes]:
    """Returns geometries as well-known binary.

    Takes a GeoSeries or a GeoDataFrame, shapely geometries, objects with `__geo_interface__`, bytes of WKB, and arrays
    of positions; or an iterable of these. An array is a line, or the outer ring of a polygon.
    """
    series = getattr(geometries, "geometry", geometries)
    if hasattr(series, "to_wkb"):
        for kind in set(series.geom_type):
            _refuse_points(kind, name)
        return [item or b"" for item in series.to_wkb()]
    if _is_one(geometries):
        geometries = [geometries]
    if not isinstance(geometries, Iterable):
        raise TypeError(
            f"{name} must be a list of arrays of positions, geometries or well-known binary, not "
            f"{type(geometries).__name__}"
        )
    return [_one(item, are_polygons, f"{name}[{number}]") for number, item in enumerate(geometries)]


def _is_one(item: Any) -> bool:
    """Returns whether an object is one geometry rather than several."""
    if item is None or isinstance(item, (bytes, dict)) or hasattr(item, "__geo_interface__"):
        return True
    if isinstance(item, np.ndarray):
        return item.ndim == 2
    if isinstance(item, (list, tuple)) and item and isinstance(item[0], (list, tuple)):
        return bool(item[0]) and np.isscalar(item[0][0])
    return False


def _one(item: Any, is_polygon: bool, name: str) -> bytes:
    if item is None:
        return b""
    if isinstance(item, bytes):
        return item
    encoded = getattr(item, "wkb", None)
    if isinstance(encoded, bytes):
        _refuse_points(getattr(item, "geom_type", None), name)
        return encoded
    shape = item if isinstance(item, dict) else getattr(item, "__geo_interface__", None)
    if shape is not None:
        return _shape(shape, name)
    positions = coordinates(item, name, (2, 3))
    return _polygon([positions]) if is_polygon else _line(positions)


def _refuse_points(kind: Any, name: str) -> None:
    """Refuses points, which well-known binary may have, but which are neither lines nor polygons."""
    if kind in ("Point", "MultiPoint"):
        raise ValueError(f"{name} must be made of lines or polygons, not {kind!r}")


def _shape(shape: dict[str, Any], name: str) -> bytes:
    """Returns a GeoJSON object as well-known binary."""
    kind = shape.get("type")
    if kind == "Feature":
        return _one(shape.get("geometry"), False, name)
    if kind == "FeatureCollection":
        return _collection(_one(feature, False, name) for feature in shape["features"])
    if kind == "GeometryCollection":
        return _collection(_shape(part, name) for part in shape["geometries"])
    parts = shape.get("coordinates", ())
    if kind in ("LineString", "MultiLineString"):
        lines = [parts] if kind == "LineString" else parts
        return _collection(_line(coordinates(line, name, (2, 3))) for line in lines)
    if kind in ("Polygon", "MultiPolygon"):
        polygons = [parts] if kind == "Polygon" else parts
        return _collection(_polygon([coordinates(ring, name, (2, 3)) for ring in rings]) for rings in polygons)
    raise ValueError(f"{name} must be made of lines or polygons, not {kind!r}")


def _head(kind: int, array: np.ndarray | None, count: int) -> bytes:
    has_z = array is not None and array.shape[1] == 3
    return struct.pack("<BII", 1, kind + _WITH_Z * has_z, count)


def _line(positions: np.ndarray) -> bytes:
    return _head(_LINE, positions, len(positions)) + positions.astype("<f8", copy=False).tobytes()


def _polygon(rings: list[np.ndarray]) -> bytes:
    width = min((ring.shape[1] for ring in rings), default=2)
    encoded = [struct.pack("<I", len(ring)) + ring[:, :width].astype("<f8").tobytes() for ring in rings]
    return b"".join([_head(_POLYGON, rings[0][:, :width] if rings else None, len(rings)), *encoded])


def _collection(parts: Iterable[bytes]) -> bytes:
    """Returns several geometries as one, and one as itself."""
    parts = [part for part in parts if part]
    if len(parts) == 1:
        return parts[0]
    return _head(_COLLECTION, None, len(parts)) + b"".join(parts)


def crs_of(item: Any) -> str | None:
    """Returns the coordinate reference system that an object names, as WKT or as a code."""
    crs = getattr(item, "crs", None)
    if crs is None or callable(crs):
        return None
    code = crs.to_epsg() if hasattr(crs, "to_epsg") else None
    if code is not None:
        return f"EPSG:{code}"
    return crs.to_wkt() if hasattr(crs, "to_wkt") else str(crs)
