"""Runs the Python blocks of the pages, those of a page in one namespace."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from conftest import DATA, SITES, collection

PYTHON = Path(__file__).resolve().parents[1]
REPOSITORY = PYTHON.parents[1]
PAGES = [PYTHON / "README.md", *(REPOSITORY / page for page in ("README.md", "docs/python.md", "docs/recipes.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def files(tmp_path, monkeypatch) -> Path:
    """A folder with the files that the pages read."""
    rows = [f"{x},{y},{x + 2 * y}" for y in range(21) for x in range(21)]
    (tmp_path / "survey.csv").write_text("\n".join(["x,y,z", *rows, ""]))
    shops = json.loads(collection("Point", SITES))
    for number, shop in enumerate(shops["features"]):
        shop["properties"] = {"name": f"shop {number}"}
    (tmp_path / "shops.geojson").write_text(json.dumps(shops))
    house = [[8, 6], [12, 6], [12, 14], [8, 14], [8, 6]]
    (tmp_path / "houses.geojson").write_text(collection("Polygon", [[house]]))
    (tmp_path / "ditches.geojson").write_text(collection("LineString", [[[14, 4], [18, 8.5]]]))
    for suffix in (".las", ".laz"):
        shutil.copy(DATA / "las" / f"autzen{suffix}", tmp_path / f"survey{suffix}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_the_blocks_of_a_page_run(page, files):
    text = page.read_text()
    blocks = list(BLOCK.finditer(text))
    assert blocks
    names = {"__name__": "__main__"}
    for block in blocks:
        line = text[: block.start(1)].count("\n")
        # Messages name the line of the page.
        exec(compile("\n" * line + block[1], str(page), "exec"), names)
