"""Questions by walking distance and by Euclidean distance."""

from __future__ import annotations

from ._base import Questions


class Proximity(Questions):
    """Questions by walking distance and by Euclidean distance."""

    __slots__ = ()
