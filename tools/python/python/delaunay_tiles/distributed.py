"""Builds, and batches of questions, over the workers of a cluster.

A worker is a process that opens the file, or the work folder of a build, itself: by a path or an address that it can
reach too. The questions are sorted along a curve and cut into batches, so that those of a batch need few tiles. Only
questions, answers and numbers of blocks travel. Scheduling, retries and lost workers are matters of the executor: a
`dask.distributed.Client`, or an executor of `concurrent.futures`.

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
import sys
import uuid
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, replace
from datetime import timedelta
from functools import lru_cache
from typing import Any, Protocol, TypeVar

import numpy as np

from . import _core
from ._answers import Distances, Neighbours
from ._arguments import path_text, positive
from ._build import Builder, BuildSummary, _files, begun
from ._columns import names
from ._open import Tiles, _reopened, open
from ._places import places, rank
from ._points import PointFile
from ._progress import Observer, observer
from ._tiles import Cache

__all__ = ["Client", "build", "knn", "matrix"]

_Time = float | timedelta | None
_Answer = TypeVar("_Answer", Neighbours, Distances)
# What a worker needs to open the state of a file: path, file id, generation, bytes of the cache.
_State = tuple[str, str, int, int]


class Client(Protocol):
    """What runs tasks: a `dask.distributed.Client`, or an executor of `concurrent.futures`."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Any:
        """Starts a task. What it returns has the methods ``result()`` and ``cancel()``."""


def build(
    points: Any,
    out: str | os.PathLike[str],
    *,
    client: Client,
    task_threads: int = 1,
    read_inputs: bool = False,
    progress: bool | Observer | None = None,
    **options: Any,
) -> BuildSummary:
    """Builds a tile file, as `build` does, with the help of several workers.

    This process reads the inputs and cuts the points into blocks, of which each fits into `memory`. The workers
    triangulate the blocks, with their lines, in any order. Then this process merges them and completes the file. If
    all points fit into `memory`, there are no blocks, and no worker is asked.

    Parameters
    ----------
    points, out, options
        See `build`. `out` must lie in a folder that the workers reach by the same absolute path, and so must
        `work_folder`, if it is given; or it is an address ``s3://bucket/name.parts``, and the workers need nothing but
        the object store. Where the name ends with ``.parts``, the file is in parts, and nobody copies what the workers
        wrote. A worker needs as much memory as `memory` allows; without it, a quarter of
        what is available here.
    client : Client
        What runs the tasks, one for each block. What a worker did is not lost if another one is killed.
    task_threads : int
        Threads of a task, at most `threads`.
    read_inputs : bool
        Let the workers read the files of `points`, too, each a task. They reach the files by the same absolute paths,
        the files say how many records they have, as LAZ, LAS and raw numbers do, and all are read in the same way.
    progress : bool or callable, optional
        See `build`. While the workers work, the phase is "tasks", and its steps are points.

    Returns
    -------
    BuildSummary
        `resumed_blocks` is the number of blocks, and `peak_memory` that of this process.

    Raises
    ------
    BuildError
        A worker may use less memory than the build has for a block, and the errors of `build`.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> xy = np.random.default_rng(1).random((1_000_000, 2))
    >>> with ThreadPoolExecutor(2) as client:
    ...     summary = dt.distributed.build(xy, "random.tiles", client=client, memory="20MB", overwrite=True)
    >>> summary.vertices
    1000000
    """
    out, threads = path_text(out, "out"), positive(task_threads, "task_threads")
    if "://" not in out:
        out = os.path.abspath(out)
    folder = options.get("work_folder")
    if folder is not None:
        options["work_folder"] = os.path.abspath(path_text(folder, "work_folder"))
    identity = f"dt.distributed.build {uuid.uuid4()}"
    is_read = read_inputs and _read(points, out, client, threads, progress, identity, options)
    begin = begun(points, out, unnamed=identity, has_inputs=is_read, progress=progress, **options)
    blocks = begin._plan()
    if begin.summary is not None:
        return begin.summary
    with _Steps(progress, sum(blocks)) as steps:
        # Dask would take the result of an earlier build of this name for that of a task with the same arguments.
        build = uuid.uuid4().hex
        tasks = [(_conquer, out, block, threads, build) for block in range(len(blocks))]
        _run(client, tasks, lambda task: steps.advance(blocks[task]))
    settings = _settings(options)
    return Builder(out, progress=progress, _resume=True, _identity=begin._identity, **settings).finish()


def _settings(options: dict[str, Any]) -> dict[str, Any]:
    """Returns the options of a build without its input."""
    of_input = ("lines", "walls", "obstacles", "ponds", "sites", "site_id", "holes", "resume")
    return {name: value for name, value in options.items() if name not in of_input}


def _read(
    points: Any,
    out: str,
    client: Client,
    threads: int,
    progress: bool | Observer | None,
    identity: str,
    options: dict[str, Any],
) -> bool:
    """Lets workers distribute the points of files. Returns whether they did: not if all fit into memory."""
    if options.get("resume"):
        raise ValueError("a build whose inputs workers read cannot be resumed here: give read_inputs or resume")
    files = [file if isinstance(file, PointFile) else PointFile(file) for file in _files(points)]
    if not files or any(file._arguments() != files[0]._arguments() or file.keep_edges for file in files):
        raise ValueError("with read_inputs, points must be files, all read in the same way")
    files = [replace(file, path=os.path.abspath(path_text(file.path, "points"))) for file in files]
    begin = Builder(out, progress=progress, _identity=identity, **_settings(options))
    records = begin._plan_inputs(files)
    if records is None:
        return False
    with _Steps(progress, sum(records)) as steps:
        build = uuid.uuid4().hex
        tasks = [(_distribute, out, number, threads, build) for number in range(len(records))]
        _run(client, tasks, lambda task: steps.advance(records[task]))
    return True


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


class _Steps:
    """The progress of the tasks of a build, for an observer."""

    def __init__(self, progress: bool | Observer | None, total: int) -> None:
        self._observer, self._done, self._total = observer(progress), 0, total

    def advance(self, steps: int) -> None:
        self._done += steps
        if self._observer is not None:
            self._observer("tasks", self._done, self._total)

    def __enter__(self) -> _Steps:
        self.advance(0)
        return self

    def __exit__(self, *_: object) -> None:
        if self._observer is not None:
            self._observer.close()


def _conquer(out: str, block: int, threads: int, build: str) -> tuple[int, int, int]:
    return _core.conquer(out, block, _memory_of_worker(), threads)


def _distribute(out: str, number: int, threads: int, build: str) -> tuple[int, int]:
    return _core.distribute(out, number, _memory_of_worker(), threads)


def _memory_of_worker() -> int | None:
    """Returns the memory that a worker of Dask may use, if this is one with a limit."""
    dask = sys.modules.get("distributed")
    try:
        return None if dask is None else dask.get_worker().memory_manager.memory_limit or None
    except ValueError:
        # This process is no worker.
        return None


def _tiles(file: Tiles | str | os.PathLike[str]) -> Tiles:
    return file if isinstance(file, Tiles) else open(file)


def _state(tiles: Tiles) -> _State:
    about, name = tiles.metadata, tiles.name
    # A worker may have another working directory.
    path = name if "://" in name else os.path.abspath(name)
    return path, about.file_id, about.generation, tiles.cache.capacity


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


def _run(
    client: Client, tasks: Iterable[tuple[Any, ...]], done: Callable[[int], None] = lambda task: None
) -> list[Any]:
    """Returns the results of tasks, in their order, and calls `done` with the number of each. If one fails, those that
    have not begun are cancelled."""
    started = [client.submit(*task) for task in tasks]
    results = []
    try:
        for number, task in enumerate(started):
            results.append(task.result())
            done(number)
        return results
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
