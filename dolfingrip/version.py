"""The version, of which pyproject.toml makes that of a wheel, beside those of other packages."""

import platform
from importlib import metadata

__version__ = "0.2.0"


def versions_of(*packages: str) -> dict[str, str]:
    """Return the versions of dolfingrip, Python and other packages, by name.

    Args:
        packages: their names; those of FEniCS are told without ``fenics-``.
    """
    versions = {"dolfingrip": __version__, "python": platform.python_version()}
    for name in packages:
        try:
            versions[name.removeprefix("fenics-")] = metadata.version(name)
        except metadata.PackageNotFoundError:  # a Debian package without metadata
            versions[name.removeprefix("fenics-")] = "unknown"
    return versions
