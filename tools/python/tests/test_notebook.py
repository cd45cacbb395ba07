"""Runs the notebook of the documentation.

Its outputs are kept in the repository, for readers without Python. To renew them, run in the root of the repository
``jupyter execute --inplace docs/python.ipynb``, and look at the pictures.
"""

from __future__ import annotations

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

DOCS = Path(__file__).resolve().parents[3] / "docs"
# So that the repository does not grow with each renewal.
MOST_BYTES = 1_500_000


@pytest.fixture(scope="module")
def notebook():
    return nbformat.read(DOCS / "python.ipynb", as_version=4)


def test_the_notebook_runs(notebook):
    resources = {"metadata": {"path": str(DOCS)}}
    # It raises the first exception of a cell.
    nbclient.NotebookClient(notebook, timeout=300, record_timing=False, resources=resources).execute()


def test_the_kept_outputs_are_small_and_of_the_whole_notebook():
    kept = nbformat.read(DOCS / "python.ipynb", as_version=4)
    numbers = [cell.execution_count for cell in kept.cells if cell.cell_type == "code"]
    assert numbers == list(range(1, len(numbers) + 1)), "renew the outputs"
    assert (DOCS / "python.ipynb").stat().st_size < MOST_BYTES
