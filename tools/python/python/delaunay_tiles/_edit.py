"""Changes of the points, lines and sites of a tile file."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Iterable
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from . import _core, _sites
from ._arguments import byte_count, coordinates, path_text, word
from ._geometry import crs_of, wkb


@dataclass(frozen=True, slots=True)
class EditSummary:
    """What an edit changed, and counts of the file after it."""

    inserted: int
    duplicates: int
    deleted: int
    moved: int
    z_set: int
    skipped: int
    segments: int
    inserted_edges: int
    inserted_sites: int
    deleted_sites: int
    removed_segments: int
    removed_lines: int
    freed_edges: int
    vertices: int
    triangles: int
    constraint_edges: int
    regions: int
    hole_regions: int
    tiles_written: int
    bytes_appended: int
    file_bytes: int
    pending_transactions: int

    @classmethod
    def _of(cls, text: str) -> EditSummary:
        found = json.loads(text)
        points, lines, sites = (found.pop(name) for name in ("points", "lines", "sites"))
        points["skipped"] += lines.pop("skipped") + sites.pop("skipped")
        found |= points | lines | {f"{name}_sites": count for name, count in sites.items()}
        return cls(**{name: found[name] for name in cls.__slots__})


class Editor:
    """A tile file that is locked for edits, of which `edit` makes one after another.

    With ``durability="log"``, small edits are fast: those of at most 4,096 points, in a file of nothing but points,
    are appended to a log beside the file (``NAME.log``), and are on the disk when the edit ends. They are made in the
    file, many at once, by `checkpoint`; before that, readers do not see them. Other edits make a checkpoint first. If
    the process ends before, the next editor of the file makes them as it opens it.

    Used as a context manager, it makes a checkpoint at the end of the block, and closes the file. If the block raises
    an exception, it only closes the file; finished edits stay in the log.

    Parameters
    ----------
    file : str or path
        The tile file to change.
    memory : int or str
        What each edit may use, such as ``"256MiB"``.
    durability : {"file", "log"}
        Where an edit is on the disk when it ends.

    Raises
    ------
    FileError, OSError
        The file cannot be opened, or changes in its log cannot be made.
    EditError
        Another editor has the file, or it has no triangles.

    Examples
    --------
    >>> summary = dt.build([(x, y) for x in range(10) for y in range(10)], "live.tiles", overwrite=True)
    >>> with dt.Editor("live.tiles", durability="log") as editor:
    ...     for x in (2.5, 3.5, 4.5):
    ...         with dt.edit(editor) as changes:
    ...             changes.insert([(x, 0.5)])
    >>> changes.summary.pending_transactions, dt.open("live.tiles").metadata.vertices
    (3, 103)
    """

    def __init__(
        self, file: str | os.PathLike[str], *, memory: int | str = "1GiB", durability: str = "file"
    ) -> None:
        self._core = _core.Editor(
            path_text(file, "file"), byte_count(memory, "memory"), word(durability, "durability")
        )

    def checkpoint(self) -> EditSummary | None:
        """Makes the edits of the log in the file. Returns their summary, or None if there are none.

        Raises
        ------
        EditError
            An edit is in progress.
        MemoryLimitError, OSError
            The memory or the disk does not suffice. The edits stay in the log.
        """
        text = self._core.checkpoint()
        return None if text is None else EditSummary._of(text)

    def close(self) -> None:
        """Unlocks the file, once an edit in progress has ended. Edits that are in the log stay there."""
        self._core.close()

    def __enter__(self) -> Editor:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.checkpoint()
        finally:
            self.close()


class edit:
    """Changes the points, lines and sites of a tile file; all changes take effect at once, at the end.

    The file then has exactly the triangles that a build of the changed points, lines and sites would have. Calls
    that change points act in their order, and so do those that change sites. Lines that are removed are those that
    the file had before, and they go before others come. Used as a context manager, it makes the changes at the end
    of the block, and none if the block raises an exception. Readers that have the file open keep what they opened;
    open the file again to see the changes. No two edits can have a file at once.

    Parameters
    ----------
    file : str, path or Editor
        The tile file to change.
    memory : int or str
        What the edit may use, such as ``"256MiB"``; by default 1 GiB, or what the `Editor` may use. Each change of a
        point takes 80 bytes of it, 240 with moves, each site 160 and twice its id, each segment 200, and all together
        at most half.
    missing_z : {"drape", "error", "zero"}
        What to do if the file has z, and ends of lines have none: take it from the surface before the edit, raise an
        error, or give them 0. Points without z are an error, or get 0.
    skip_missing : bool
        Leave out, and count, changes of points, lines to remove and sites to delete that are not there; otherwise the
        first one is an `EditError`.
    dry_run : bool
        Do all the work, and report it in the summary, but leave the file as it is.

    Raises
    ------
    FileError, OSError
        The file cannot be opened.
    EditError
        Another edit has the file, or it has no triangles.
    TypeError
        There is a memory for the edit of an `Editor`.

    Examples
    --------
    >>> summary = dt.build([(x, y) for x in range(10) for y in range(10)], "field.tiles", overwrite=True)
    >>> with dt.edit("field.tiles") as changes:
    ...     changes.insert([(20.0, 20.0), (4.5, 4.5)])
    ...     changes.delete([(0, 0)])
    ...     changes.move([(9, 9)], [(30, 3)])
    ...     changes.constrain([[(1, 1), (5, 1)]], "walls")
    >>> changes.summary.vertices, changes.summary.moved, changes.summary.constraint_edges
    (101, 1, 4)
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | Editor,
        *,
        memory: int | str | None = None,
        missing_z: str = "drape",
        skip_missing: bool = False,
        dry_run: bool = False,
    ) -> None:
        self._summary: EditSummary | None = None
        arguments = (word(missing_z, "missing_z"), bool(skip_missing), bool(dry_run))
        if isinstance(file, Editor):
            if memory is not None:
                raise TypeError("an Editor has a memory of its own: leave out the argument memory")
            self._core = file._core.begin(*arguments)
            return
        editor = Editor(file, memory="1GiB" if memory is None else memory)
        try:
            self._core = editor._core.begin(*arguments)
        finally:
            # What was begun keeps the file locked.
            editor.close()

    def insert(self, points: Any) -> None:
        """Inserts points: an array (n, 2), or (n, 3) if the file has z. They may lie outside the hull.

        A point at the position of another one is a duplicate, and left out.
        """
        self._core.insert(coordinates(points, "points", (2, 3)))

    def delete(self, points: Any) -> None:
        """Deletes the points at these positions: an array (n, 2) or (n, 3), of which z is not compared.

        A vertex stays as long as a site or the end of a line is there.
        """
        self._core.delete(coordinates(points, "points", (2, 3)))

    def move(self, starts: Any, ends: Any) -> None:
        """Moves points from `starts` to `ends`, arrays (n, 2), with their z. Moves happen in their order.

        A point that is moved to the position of another one is a duplicate, and gone.
        """
        before, after = coordinates(starts, "starts"), coordinates(ends, "ends")
        if len(before) != len(after):
            raise ValueError(f"starts and ends must be equally many, not {len(before)} and {len(after)}")
        self._core.move_points(before, after)

    def set_z(self, points: Any) -> None:
        """Gives the points at x and y of an array (n, 3) its z."""
        self._core.set_z(coordinates(points, "points", (3,)))

    def constrain(self, lines: Any, kind: str = "lines") -> None:
        """Makes lines constraints: break lines, ``"walls"`` or ``"obstacles"``; see `build` for what they may be.

        Their ends may lie outside the hull. No line may cross another one.
        """
        self._take(lines, kind, False)

    def unconstrain(self, lines: Any, kind: str = "lines") -> None:
        """Removes lines that the file has: break lines, ``"walls"`` or ``"obstacles"``, given by their geometry.

        Each segment must be a whole segment of a line of this kind. Obstacles are removed with all their rings.
        Vertices go if only ends of removed lines were there.
        """
        self._take(lines, kind, True)

    def remove_lines(self, numbers: Iterable[int]) -> None:
        """Removes lines by their numbers in the file, and obstacles with all their rings. This reads all tiles."""
        self._core.remove_lines([operator.index(number) for number in numbers])

    def insert_sites(self, sites: Any, ids: Iterable[Any] | None = None, site_id: str | None = None) -> None:
        """Inserts sites: an array (n, 2) or (n, 3), a GeoDataFrame of points, or one file.

        Sites without ids get the numbers that follow those of all sites of the file. A site where no vertex is makes
        one.
        """
        if isinstance(sites, (str, bytes, os.PathLike)):
            self._core.site_file(path_text(sites, "sites"), site_id)
            return
        xy, texts, crs = _sites.arrays(sites, ids, site_id)
        if crs is not None:
            self._core.take_crs("sites", crs)
        self._core.insert_sites(xy, texts)

    def delete_sites(self, sites: Any) -> None:
        """Deletes the sites at these positions, whatever their ids. Vertices go if nothing else holds them."""
        xy, _, crs = _sites.arrays(sites, None, None)
        if crs is not None:
            self._core.take_crs("sites", crs)
        self._core.delete_sites(xy)

    def _take_crs(self, given: Any, name: str) -> None:
        crs = crs_of(given)
        if crs is not None:
            self._core.take_crs(name, crs)

    def _take(self, lines: Any, kind: str, are_to_go: bool) -> None:
        if isinstance(lines, (str, bytes, os.PathLike)):
            self._core.line_file(kind, path_text(lines, kind), are_to_go)
        elif isinstance(lines, (list, tuple)) and any(isinstance(item, (str, os.PathLike)) for item in lines):
            for item in lines:
                self._take(item, kind, are_to_go)
        else:
            self._take_crs(lines, kind)
            self._core.line_wkb(kind, wkb(lines, kind == "obstacles", kind), are_to_go)

    def finish(self) -> EditSummary:
        """Makes the changes.

        Raises
        ------
        EditError
            A point or a line is not there, a point has no z in a file with z, or lines cross. The file is unchanged.
        MemoryLimitError, OSError
            The memory or the disk does not suffice. The file is unchanged.
        """
        self._summary = EditSummary._of(self._core.finish("points"))
        return self._summary

    @property
    def summary(self) -> EditSummary | None:
        """The summary of the finished edit, or None before."""
        return self._summary

    def close(self) -> None:
        """Forgets the changes, unless they are made."""
        self._core.close()

    def __enter__(self) -> edit:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if kind is None and self._summary is None:
            self.finish()
        else:
            self.close()
