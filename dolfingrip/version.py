"""The version, of which pyproject.toml makes that of a wheel."""

__version__ = "0.2.0"
