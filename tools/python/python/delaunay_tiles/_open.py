"""Opening tile files, to ask in turn or with asyncio; and their pickling."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from . import _core
from ._arguments import path_text
from ._elements import Elements
from ._errors import FileError
from ._outputs import Outputs, Pictures
from ._proximity import Proximity
from ._tiles import Cache, OpenFile

_SCHEMES = ("http://", "https://", "s3://")
_DEFAULT_CACHE = 256 << 20


class Tiles(OpenFile, Proximity, Pictures):
    """An open tile file. `open` makes it.

    It may be used by many threads at once, and pickled: the copy opens the same state of the same file again. It keeps
    the state that it opened while others edit the file.
    """

    __slots__ = ()

    def _ask(self, question: Callable[[bool], Any], answer: Callable[[Any], Any] = lambda found: found) -> Any:
        return answer(question(False))

    def __reduce__(self) -> tuple[Any, ...]:
        about = self.metadata
        return _reopened, (self._path, about.file_id, about.generation, self._cache)

    def __enter__(self) -> Tiles:
        return self

    def __exit__(self, *_: object) -> None:
        """Does nothing: the file is closed when nothing refers to it any more."""


class AsyncTiles(OpenFile, Proximity, Outputs, Elements):
    """An open tile file, for asyncio. `aopen` makes it.

    It has the methods of `Tiles`, except `tiles`, `plot`, `to_geopandas` and `to_meshio`. Those that read the file
    return an awaitable. An awaitable that is cancelled stops the work.
    """

    __slots__ = ()

    async def _ask(self, question: Callable[[bool], Any], answer: Callable[[Any], Any] = lambda found: found) -> Any:
        return answer(await question(True))


def open(path_or_url: str | os.PathLike[str], cache: Cache | int | str | None = None) -> Tiles:
    """Opens a tile file.

    Parameters
    ----------
    path_or_url : str or path
        A path, or an address ``http://…``, ``https://…`` or ``s3://bucket/key``, which is read by byte range.
    cache : Cache, int or str, optional
        The cache of tiles, or its capacity in bytes; 256 MiB without it.

    Raises
    ------
    FileNotFoundError, PermissionError, OSError
        The file cannot be opened.
    FileError
        It is no tile file, or its directory is damaged.

    Examples
    --------
    >>> t = dt.open("town.tiles")
    >>> t.metadata.triangles
    806
    """
    path, cache = _named(path_or_url), _cache(cache)
    reader = _core.open(path, cache._core, False)
    return Tiles(reader, path, cache, reader.crs(False))


async def aopen(path_or_url: str | os.PathLike[str], cache: Cache | int | str | None = None) -> AsyncTiles:
    """Opens a tile file for asyncio. Arguments and errors are those of `open`.

    Examples
    --------
    >>> async def distance(a, b):
    ...     town = await dt.aopen("town.tiles")
    ...     return (await town.path(a, b)).distance
    >>> round(asyncio.run(distance((1, 1), (18, 18))), 2)
    25.52
    """
    path, cache = _named(path_or_url), _cache(cache)
    reader = await _core.open(path, cache._core, True)
    return AsyncTiles(reader, path, cache, await reader.crs(True))


def _cache(cache: Cache | int | str | None) -> Cache:
    if isinstance(cache, Cache):
        return cache
    return Cache(_DEFAULT_CACHE if cache is None else cache)


def _named(path: Any) -> str:
    """Returns an address as it is, and a path made absolute, so that a pickle holds wherever it is read."""
    text = path_text(path, "path_or_url")
    return text if text.startswith(_SCHEMES) else os.path.abspath(text)


def _reopened(path: str, file_id: str, generation: int, cache: Cache) -> Tiles:
    """Opens the file of a pickle."""
    opened = open(path, cache)
    about = opened.metadata
    if (about.file_id, about.generation) != (file_id, generation):
        raise FileError(f"{path}: the file is not in the state in which it was pickled; open it again there")
    return opened
