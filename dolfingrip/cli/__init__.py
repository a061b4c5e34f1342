"""The ``dolfingrip`` command: its subcommands, their options and what they print."""
