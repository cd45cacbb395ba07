"""The progress of a build."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

Observer = Callable[[str, int, int], object]


class _Bar:
    """A bar of tqdm, which begins anew in each phase."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm = tqdm
        self._bar: Any = None

    def __call__(self, phase: str, done: int, total: int) -> None:
        if self._bar is None or self._bar.desc != f"{phase}: ":
            self.close()
            self._bar = self._tqdm(desc=phase, total=total or None, unit_scale=True)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class _Lines:
    """A line on standard error from time to time."""

    EVERY = 2.0

    def __init__(self) -> None:
        self._next = time.monotonic() + self.EVERY

    def __call__(self, phase: str, done: int, total: int) -> None:
        now = time.monotonic()
        if now >= self._next:
            self._next = now + self.EVERY
            share = f" of {total:,}" if total else ""
            print(f"{phase}: {done:,}{share}", file=sys.stderr)

    def close(self) -> None:
        pass


class _Given:
    """What the caller gave."""

    def __init__(self, call: Observer) -> None:
        self._call = call

    def __call__(self, phase: str, done: int, total: int) -> None:
        self._call(phase, done, total)

    def close(self) -> None:
        pass


def observer(progress: bool | Observer | None) -> Any:
    """Returns what is called while a build works, and closed after it; None if nothing is."""
    if progress is None or progress is False:
        return None
    if progress is not True:
        if not callable(progress):
            raise TypeError(f"progress must be True, or a function of (phase, done, total), not {progress!r}")
        return _Given(progress)
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _Lines()
    return _Bar(tqdm)
