"""What is known of an open tile file: metadata, digest, verification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import _core
from ._arguments import byte_count
from ._base import Questions


class Cache:
    """A cache of tiles, which several readers may share.

    Parameters
    ----------
    capacity : int or str
        Bytes of the tiles that it holds at most, such as ``256 << 20`` or ``"256MiB"``.

    Examples
    --------
    >>> cache = dt.Cache("64MiB")
    >>> towns = [dt.open("town.tiles", cache=cache) for _ in range(2)]
    >>> cache.capacity
    67108864
    """

    __slots__ = ("_core",)

    def __init__(self, capacity: int | str) -> None:
        self._core = _core.Cache(byte_count(capacity, "capacity"))

    @property
    def capacity(self) -> int:
        """Bytes of the tiles that the cache holds at most."""
        return self._core.capacity

    @property
    def statistics(self) -> dict[str, int]:
        """Requests that found their tile (``hits``), that did not (``misses``), and the ``bytes`` held now."""
        return dict(zip(("hits", "misses", "bytes"), self._core.statistics(), strict=True))

    def __reduce__(self) -> tuple[Any, ...]:
        return Cache, (self.capacity,)


@dataclass(frozen=True, slots=True)
class Metadata:
    """The metadata of a tile file; counts are of the whole file."""

    tiles: int
    tile_vertices: int
    vertices: int
    triangles: int
    hull_edges: int
    points: int
    duplicates: int
    added_vertices: int
    constraint_edges: int
    regions: int
    hole_regions: int
    hole_triangles: int
    sites: int
    crossings: int
    generation: int
    file_bytes: int
    has_z: bool
    exterior_is_hole: bool
    producer: str
    file_id: str
    digest: str
    bounds: tuple[float, float, float, float] | None


@dataclass(frozen=True, slots=True)
class Verified:
    """The counts of a file that was verified. `edges` is 0 unless the check was deep."""

    tiles: int
    vertices: int
    triangles: int
    edges: int
    constraint_edges: int


class OpenFile(Questions):
    """What `Tiles` and `AsyncTiles` have in common."""

    __slots__ = ("_cache", "_crs", "_path")

    def __init__(self, reader: _core.Reader, path: str, cache: Cache, crs: str | None) -> None:
        self._reader = reader
        self._path = path
        self._cache = cache
        self._crs = crs

    @property
    def name(self) -> str:
        """The path or the address of the file."""
        return self._path

    @property
    def metadata(self) -> Metadata:
        """The metadata of the file."""
        return Metadata(**self._reader.metadata())

    @property
    def bounds(self) -> tuple[float, float, float, float] | None:
        """The box around all vertices, ``(min_x, min_y, max_x, max_y)``, or None if there are none."""
        return self.metadata.bounds

    @property
    def crs(self) -> str | None:
        """The coordinate reference system, as WKT, PROJJSON or the name that the input gave; or None."""
        return self._crs

    @property
    def cache(self) -> Cache:
        """The cache of tiles."""
        return self._cache

    def digest(self) -> Any:
        """Computes the digest of the triangulation from the tiles, as `tiletool digest --recompute` does.

        Returns
        -------
        str
            Lines of a name, a count and a hash. Files with the same triangulation have the same digest, whatever
            their tiles. ``metadata.digest`` is the digest that the file states.

        Examples
        --------
        >>> t.digest() == t.metadata.digest
        True
        """
        return self._ask(self._reader.digest)

    def verify(self, deep: bool = False) -> Any:
        """Checks all tiles. With `deep`, proves that they hold the (constrained) Delaunay triangulation.

        Returns
        -------
        Verified
            Counts of what was checked.

        Raises
        ------
        VerifyError
            The first fault.
        FileError
            A tile is damaged.

        Examples
        --------
        >>> t.verify(deep=True).triangles == t.metadata.triangles
        True
        """
        return self._ask(lambda awaited: self._reader.verify(deep, awaited), lambda counts: Verified(*counts))

    def __repr__(self) -> str:
        about = self.metadata
        return f"<{type(self).__name__} {self._path!r}: {about.vertices} vertices, {about.triangles} triangles>"
