"""Batches of questions over the workers of a cluster.

A worker is a process that opens the file itself, by a path or an address that it can reach too. The questions are
sorted along a curve and cut into batches, so that those of a batch need few tiles. Only questions and answers
travel. Scheduling, retries and lost workers are matters of the executor: a `dask.distributed.Client`, or an executor
of `concurrent.futures`.

Examples
--------
>>> from concurrent.futures import ThreadPoolExecutor
>>> with ThreadPoolExecutor(2) as client:
...     near = dt.distributed.knn("town.tiles", [(3.5, 8), (16, 3)], 1, client=client)
>>> near.id[:, 0].tolist()
['shop 1', 'shop 8']
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from datetime import timedelta
from functools import lru_cache
from typing import Any, Protocol, TypeVar

import numpy as np

from ._answers import Distances, Neighbours
from ._arguments import positive
from ._columns import names
from ._open import Tiles, _reopened, open
from ._places import places, rank
from ._tiles import Cache

__all__ = ["Client", "knn", "matrix"]

_Time = float | timedelta | None
_Answer = TypeVar("_Answer", Neighbours, Distances)
# What a worker needs to open the state of a file: path, file id, generation, bytes of the cache.
_State = tuple[str, str, int, int]


class Client(Protocol):
    """What runs tasks: a `dask.distributed.Client`, or an executor of `concurrent.futures`."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Any:
        """Starts a task. What it returns has the methods ``result()`` and ``cancel()``."""


def knn(
    file: Tiles | str | os.PathLike[str],
    xy: Any,
    k: int,
    mode: str = "exact",
    *,
    client: Client,
    batch: int = 4096,
    max_tiles: int | None = None,
    max_time: _Time = None,
) -> Neighbours:
    """Finds the k nearest sites by walking distance, as `Tiles.knn` does, on several workers.

    Parameters
    ----------
    file : Tiles, str or path
        The file. The workers open it by its path or address, with a cache of the same capacity each.
    xy : array_like of shape (n, 2)
        The points.
    k : int
        How many sites, at least 1.
    mode, max_tiles, max_time
        See `Proximity`.
    client : Client
        What runs the tasks.
    batch : int
        How many points a task has at most.

    Returns
    -------
    Neighbours
        What `Tiles.knn` returns, without paths.

    Raises
    ------
    FileError
        The file was changed since it was opened here.
    """
    tiles, at = _tiles(file), places(xy, "xy")
    k = rank(k, len(at), lambda: tiles.metadata.sites)
    state, tasks = _state(tiles), _batches(at, positive(batch, "batch"))
    answers = _run(client, [(_knn, state, at[rows], k, mode, max_tiles, max_time) for rows in tasks])
    return _joined(answers, tasks, 0)


def matrix(
    file: Tiles | str | os.PathLike[str],
    a: Any,
    b: Any,
    mode: str = "exact",
    *,
    client: Client,
    batch: int = 64,
    max_tiles: int | None = None,
    max_time: _Time = None,
) -> Distances:
    """Finds the walking distances between all points of two lists, as `Tiles.matrix` does, on several workers.

    A task has some points of the shorter list, and all points of the other: one search serves a whole row or column.

    Parameters
    ----------
    file : Tiles, str or path
        The file. The workers open it by its path or address, with a cache of the same capacity each.
    a : array_like of shape (n, 2)
        The starts.
    b : array_like of shape (m, 2)
        The ends.
    mode, max_tiles, max_time
        See `Proximity`.
    client : Client
        What runs the tasks.
    batch : int
        How many points of the shorter list a task has at most.

    Returns
    -------
    Distances
        Arrays of shape (n, m).

    Raises
    ------
    FileError
        The file was changed since it was opened here.
    """
    state, starts, ends = _state(_tiles(file)), places(a, "a"), places(b, "b")
    axis = int(len(ends) < len(starts))
    tasks = _batches(ends if axis else starts, positive(batch, "batch"))

    def lists(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (starts, ends[rows]) if axis else (starts[rows], ends)

    answers = _run(client, [(_matrix, state, *lists(rows), mode, max_tiles, max_time) for rows in tasks])
    return _joined(answers, tasks, axis)


def _tiles(file: Tiles | str | os.PathLike[str]) -> Tiles:
    return file if isinstance(file, Tiles) else open(file)


def _state(tiles: Tiles) -> _State:
    about = tiles.metadata
    return tiles.name, about.file_id, about.generation, tiles.cache.capacity


@lru_cache(maxsize=8)
def _opened(path: str, file_id: str, generation: int, capacity: int) -> Tiles:
    """Opens a file, once in each process, so that its cache serves all tasks."""
    return _reopened(path, file_id, generation, Cache(capacity))


def _knn(state: _State, xy: np.ndarray, k: int, mode: str, max_tiles: int | None, max_time: _Time) -> Neighbours:
    return _opened(*state).knn(xy, k, mode, max_tiles=max_tiles, max_time=max_time)


def _matrix(
    state: _State, a: np.ndarray, b: np.ndarray, mode: str, max_tiles: int | None, max_time: _Time
) -> Distances:
    return _opened(*state).matrix(a, b, mode, max_tiles=max_tiles, max_time=max_time)


def _batches(xy: np.ndarray, most: int) -> Sequence[np.ndarray]:
    """Returns the row numbers of batches of points that are near each other; at least one batch."""
    count = max(1, -(-len(xy) // most))
    return np.array_split(_curve_order(xy), count)


def _curve_order(xy: np.ndarray) -> np.ndarray:
    """Returns the order of points along a Z curve over their bounding box."""
    if len(xy) == 0:
        return np.arange(0)
    low = xy.min(axis=0)
    span = xy.max(axis=0) - low
    cells = ((xy - low) / np.where(span > 0, span, 1) * (2**16 - 1)).astype(np.uint64)
    for shift, mask in (8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555):
        cells = (cells | cells << np.uint64(shift)) & np.uint64(mask)
    return np.argsort(cells[:, 0] | cells[:, 1] << np.uint64(1), kind="stable")


def _run(client: Client, tasks: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Returns the results of tasks, in their order. If one fails, those that have not begun are cancelled."""
    started = [client.submit(*task) for task in tasks]
    try:
        return [task.result() for task in started]
    except BaseException:
        for task in started:
            task.cancel()
        raise


def _joined(answers: Sequence[_Answer], tasks: Sequence[np.ndarray], axis: int) -> _Answer:
    """Puts the answers of all tasks into one, whose rows, or columns, are in the order of the questions."""
    back = np.argsort(np.concatenate(tasks))

    def together(name: str) -> Any:
        parts = [getattr(answer, name) for answer in answers]
        if name == "_names":
            return _all_names(parts)
        if name == "paths":
            return None
        if name == "_offsets":
            lengths = np.concatenate([np.diff(part) for part in parts])[back]
            return np.concatenate([[0], np.cumsum(lengths)])
        return np.take(np.concatenate(parts, axis), back, axis)

    kind = type(answers[0])
    return kind(*(together(field.name) for field in fields(kind)))


def _all_names(parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Returns the numbers and ids of the sites of all answers, each once, with None at the end."""
    numbers, firsts = np.unique(np.concatenate([numbers for numbers, _ in parts]), return_index=True)
    texts = np.concatenate([texts[:-1] for _, texts in parts])
    return names(numbers, texts[firsts].tolist())
