"""The classes as a user sees them: what each method returns when it blocks, and when it is awaited."""

import os
from collections.abc import Coroutine, Iterator, Sequence
from datetime import timedelta
from typing import Any, Literal, Self, SupportsIndex, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._answers import Along, Distances, Footing, Nearest, Neighbours, Reached
from ._elements import Bounds, Places, Table, Tile
from ._outputs import Map
from ._paths import Path, Paths
from ._reach import Reach
from ._surface import Contours, Profile, Raster, Volume
from ._tiles import Cache, Metadata, Verified

_T = TypeVar("_T")
_Awaited = Coroutine[Any, Any, _T]
_Time = float | timedelta | None

class Tiles:
    def __init__(self, reader: _core.Reader, path: str, cache: Cache, crs: str | None) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def metadata(self) -> Metadata: ...
    @property
    def bounds(self) -> Bounds | None: ...
    @property
    def crs(self) -> str | None: ...
    @property
    def cache(self) -> Cache: ...
    def arrow(
        self, kind: Literal["triangles", "vertices", "edges"] = "triangles", bounds: Bounds | None = None
    ) -> Table: ...
    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def digest(self) -> str: ...
    def verify(self, deep: bool = False) -> Verified: ...
    def tile(self, number: SupportsIndex) -> Tile: ...
    def tile_ids(self, bounds: Bounds | None = None) -> list[int]: ...
    def locate(self, xy: ArrayLike) -> Places: ...
    def knn(
        self,
        xy: ArrayLike,
        k: SupportsIndex,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Neighbours: ...
    def within(
        self,
        xy: ArrayLike,
        r: ArrayLike,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Reached: ...
    def path(
        self,
        a: ArrayLike,
        b: ArrayLike,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Path: ...
    def paths(
        self,
        a: ArrayLike,
        b: ArrayLike,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Paths: ...
    def matrix(
        self, a: ArrayLike, b: ArrayLike, mode: str = "exact", *, max_tiles: int | None = None, max_time: _Time = None
    ) -> Distances: ...
    def along(
        self, a: ArrayLike, b: ArrayLike, k: SupportsIndex = 1, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> Along: ...
    def reach(self, p: ArrayLike, r: float, *, max_tiles: int | None = None, max_time: _Time = None) -> Reach: ...
    def nearest(
        self,
        xy: ArrayLike,
        k: SupportsIndex = 1,
        of: Literal["vertices", "sites"] = "vertices",
        *,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> Nearest: ...
    def footing(self, xy: ArrayLike, *, max_tiles: int | None = None, max_time: _Time = None) -> Footing: ...
    def edge_distances(
        self, a: ArrayLike, b: ArrayLike, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> Distances: ...
    @overload
    def interpolate(
        self, xy: tuple[float, float], *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> float: ...
    @overload
    def interpolate(
        self,
        xy: Sequence[Sequence[float]],
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
    ) -> NDArray[np.float64]: ...
    @overload
    def interpolate(
        self, xy: ArrayLike, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> Any: ...
    def raster(
        self,
        resolution: float,
        *,
        bounds: Bounds | None = None,
        align: tuple[float, float] | None = None,
        what: Literal["z", "slope", "aspect", "hillshade"] = "z",
        z_factor: float = 1.0,
        azimuth: float = 315.0,
        altitude: float = 45.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Raster: ...
    def contours(
        self,
        step: float,
        *,
        base: float = 0.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Contours: ...
    def profile(
        self, line: ArrayLike, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> Profile: ...
    def volume(
        self,
        level: float,
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> Volume: ...
    def export(
        self,
        out: str | os.PathLike[str],
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
        **options: Any,
    ) -> dict[str, Any]: ...
    def tiles(self, bounds: Bounds | None = None) -> Iterator[Tile]: ...
    @overload
    def plot(self, out: None = None, *, ax: None = None, bounds: None = None) -> Map: ...
    @overload
    def plot(self, out: str | os.PathLike[str], *, ax: None = None, bounds: None = None) -> None: ...
    @overload
    def plot(self, out: None = None, *, ax: _T, bounds: Bounds | None = None, **style: Any) -> _T: ...
    def to_geopandas(
        self, bounds: Bounds | None = None, kind: Literal["triangles", "vertices", "edges"] = "triangles"
    ) -> Any: ...
    def to_meshio(self, bounds: Bounds | None = None) -> Any: ...

class AsyncTiles:
    def __init__(self, reader: _core.Reader, path: str, cache: Cache, crs: str | None) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def metadata(self) -> Metadata: ...
    @property
    def bounds(self) -> Bounds | None: ...
    @property
    def crs(self) -> str | None: ...
    @property
    def cache(self) -> Cache: ...
    def arrow(
        self, kind: Literal["triangles", "vertices", "edges"] = "triangles", bounds: Bounds | None = None
    ) -> Table: ...
    def digest(self) -> _Awaited[str]: ...
    def verify(self, deep: bool = False) -> _Awaited[Verified]: ...
    def tile(self, number: SupportsIndex) -> _Awaited[Tile]: ...
    def tile_ids(self, bounds: Bounds | None = None) -> _Awaited[list[int]]: ...
    def locate(self, xy: ArrayLike) -> _Awaited[Places]: ...
    def knn(
        self,
        xy: ArrayLike,
        k: SupportsIndex,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> _Awaited[Neighbours]: ...
    def within(
        self,
        xy: ArrayLike,
        r: ArrayLike,
        mode: str = "exact",
        *,
        paths: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> _Awaited[Reached]: ...
    def path(
        self,
        a: ArrayLike,
        b: ArrayLike,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> _Awaited[Path]: ...
    def paths(
        self,
        a: ArrayLike,
        b: ArrayLike,
        mode: str = "exact",
        *,
        certified: bool = False,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> _Awaited[Paths]: ...
    def matrix(
        self, a: ArrayLike, b: ArrayLike, mode: str = "exact", *, max_tiles: int | None = None, max_time: _Time = None
    ) -> _Awaited[Distances]: ...
    def along(
        self, a: ArrayLike, b: ArrayLike, k: SupportsIndex = 1, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> _Awaited[Along]: ...
    def reach(
        self, p: ArrayLike, r: float, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> _Awaited[Reach]: ...
    def nearest(
        self,
        xy: ArrayLike,
        k: SupportsIndex = 1,
        of: Literal["vertices", "sites"] = "vertices",
        *,
        max_tiles: int | None = None,
        max_time: _Time = None,
    ) -> _Awaited[Nearest]: ...
    def footing(self, xy: ArrayLike, *, max_tiles: int | None = None, max_time: _Time = None) -> _Awaited[Footing]: ...
    def edge_distances(
        self, a: ArrayLike, b: ArrayLike, *, max_tiles: int | None = None, max_time: _Time = None
    ) -> _Awaited[Distances]: ...
    @overload
    def interpolate(
        self, xy: tuple[float, float], *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> _Awaited[float]: ...
    @overload
    def interpolate(
        self,
        xy: Sequence[Sequence[float]],
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
    ) -> _Awaited[NDArray[np.float64]]: ...
    @overload
    def interpolate(
        self, xy: ArrayLike, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> _Awaited[Any]: ...
    def raster(
        self,
        resolution: float,
        *,
        bounds: Bounds | None = None,
        align: tuple[float, float] | None = None,
        what: Literal["z", "slope", "aspect", "hillshade"] = "z",
        z_factor: float = 1.0,
        azimuth: float = 315.0,
        altitude: float = 45.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> _Awaited[Raster]: ...
    def contours(
        self,
        step: float,
        *,
        base: float = 0.0,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> _Awaited[Contours]: ...
    def profile(
        self, line: ArrayLike, *, holes: bool = False, max_edge: float | None = None, from_hull: bool = False
    ) -> _Awaited[Profile]: ...
    def volume(
        self,
        level: float,
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
    ) -> _Awaited[Volume]: ...
    def export(
        self,
        out: str | os.PathLike[str],
        *,
        holes: bool = False,
        max_edge: float | None = None,
        from_hull: bool = False,
        clip: Any = None,
        **options: Any,
    ) -> _Awaited[dict[str, Any]]: ...

def open(path_or_url: str | os.PathLike[str], cache: Cache | int | str | None = None) -> Tiles: ...
async def aopen(path_or_url: str | os.PathLike[str], cache: Cache | int | str | None = None) -> AsyncTiles: ...
def _reopened(path: str, file_id: str, generation: int, cache: Cache) -> Tiles: ...
