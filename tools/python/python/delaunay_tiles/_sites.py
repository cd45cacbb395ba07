"""Sites in arrays, tables and GeoDataFrames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _points
from ._arguments import coordinates
from ._geometry import crs_of


def arrays(
    sites: Any, ids: Iterable[Any] | None, site_id: str | None
) -> tuple[NDArray[np.float64], list[str] | None, str | None]:
    """Returns the coordinates of sites, their ids, and their coordinate reference system."""
    if site_id is not None and ids is None:
        ids = _points._column(sites, site_id, "sites")
    series = getattr(sites, "geometry", sites)
    crs = None
    if hasattr(series, "geom_type"):
        crs = crs_of(series)
        sites = _points._of_series(series, "sites")
    elif hasattr(sites, "__arrow_c_stream__"):
        sites = _points._of_table(sites, "sites")
    texts = None if ids is None else [_id_text(item, number) for number, item in enumerate(ids)]
    return coordinates(sites, "sites", (2, 3)), texts, crs


def _id_text(item: Any, number: int) -> str:
    """Returns the id of a site as text."""
    try:
        is_missing = item is None or bool(item != item)
    except TypeError:
        # NA of pandas is neither equal to itself nor not.
        is_missing = True
    if is_missing:
        raise ValueError(f"the id of site {number} is missing; give each site one")
    return str(item)
