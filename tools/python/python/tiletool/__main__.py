"""`python -m tiletool`."""

from . import main

main()
