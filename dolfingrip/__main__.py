"""``python -m dolfingrip``."""

from dolfingrip.cli.app import main

main()
