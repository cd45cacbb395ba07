"""The command `tiletool`, a package of its own: `delaunay_tiles` imports NumPy, and that takes far longer than the
tool takes to start."""

import sys
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec, module_from_spec


def main() -> None:
    """Runs `tiletool` with the arguments of the process, and ends the process with its exit code."""
    spec = _core()
    if spec is None or spec.loader is None:
        sys.exit("tiletool: the package delaunay_tiles is not complete: install it again")
    core = module_from_spec(spec)
    spec.loader.exec_module(core)
    sys.exit(core.tiletool(["tiletool", *sys.argv[1:]]))


def _core() -> ModuleSpec | None:
    """Finds the compiled part of `delaunay_tiles`, without importing that."""
    package = find_spec("delaunay_tiles")
    if package is None:
        return None
    return PathFinder.find_spec("delaunay_tiles._core", package.submodule_search_locations)
