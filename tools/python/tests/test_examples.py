"""Runs the examples in docstrings."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import delaunay_tiles

OPTIONS = doctest.NORMALIZE_WHITESPACE


def examples() -> list[doctest.DocTest]:
    """Returns the docstrings with examples, of all modules of the package."""
    found = []
    finder = doctest.DocTestFinder(exclude_empty=True)
    for module in pkgutil.iter_modules(delaunay_tiles.__path__, "delaunay_tiles."):
        if not module.name.endswith("._core"):
            found += finder.find(importlib.import_module(module.name), module.name)
    return [test for test in found if test.examples]


@pytest.mark.parametrize("example", examples(), ids=lambda example: example.name.removeprefix("delaunay_tiles."))
def test_an_example_of_a_docstring_holds(example, doctest_namespace, capsys):
    example.globs = dict(doctest_namespace)
    failures, _ = doctest.DocTestRunner(optionflags=OPTIONS).run(example)
    assert failures == 0, capsys.readouterr().out
