"""``python -m dolfingrip``."""

from dolfingrip.cli import main

main()
