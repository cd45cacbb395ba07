"""What all questions to a tile file share: the reader, and how its answers are awaited."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import _core


class Questions:
    """Asks questions of a reader. `_ask` of a subclass blocks, or returns an awaitable."""

    __slots__ = ("_reader",)

    _reader: _core.Reader

    def _ask(self, question: Callable[[bool], Any], answer: Callable[[Any], Any] = lambda found: found) -> Any:
        """Calls `question` with whether it is awaited, and returns what `answer` makes of the result."""
        raise NotImplementedError
