"""The command `tiletool`."""

import sys

from . import _core


def main() -> None:
    """Runs `tiletool` with the arguments of the process, and ends the process with its exit code."""
    sys.exit(_core.tiletool(["tiletool", *sys.argv[1:]]))
