"""What to install where something is missing: DOLFINx, or what an extra of the package brings."""

from __future__ import annotations

import re
from contextlib import suppress
from importlib import metadata
from importlib.util import find_spec

DOLFINX = """DOLFINx is missing; install it by one of these two lines:
    pip install dolfinx-solver-real               (Linux on x86-64)
    conda install -c conda-forge fenics-dolfinx   (Linux, macOS)"""
"""DOLFINx is a dependency that pip cannot resolve by itself everywhere."""

_OF_DOLFINX = {"dolfinx", "petsc4py", "mpi4py", "ufl", "basix", "ffcx"}


def extras() -> dict[str, list[str]]:
    """List the distributions that each extra of the installed package brings.

    Returns:
        Names of distributions, without versions, by the extra; "" has those that are always there.
    """
    by_extra: dict[str, list[str]] = {"": []}
    for line in metadata.requires("dolfingrip") or ():
        requirement, _, marker = line.partition(";")
        extra = re.search(r"extra\s*==\s*['\"]([^'\"]+)", marker)
        name = re.split(r"[^\w.-]", requirement.strip())[0]
        by_extra.setdefault(extra[1] if extra else "", []).append(name)
    return by_extra


def how_to_install(module: str) -> str:
    """Say how to install what is missing.

    Args:
        module: name of the package that could not be imported.

    Returns:
        A line, or three of DOLFINx; "" for a package that is none of the dependencies.
    """
    module = module.partition(".")[0]
    if module in _OF_DOLFINX:
        return DOLFINX
    wanted = {"PIL": "pillow"}.get(module, module).replace("_", "-").lower()
    for extra, names in extras().items():
        if wanted in (name.lower() for name in names):
            line = " ".join(names if extra else [wanted])
            what = f" (dolfingrip's extra {extra})" if extra else ""
            return f"{module} is missing; install it by: pip install {line}{what}"
    return ""


def solver() -> str:
    """Say in one line which DOLFINx is there, without importing it."""
    for name in ("fenics-dolfinx", "dolfinx-solver-real"):  # Debian's, conda's and Spack's; PyPI's
        with suppress(metadata.PackageNotFoundError):
            return f"DOLFINx {metadata.version(name)}"
    return "DOLFINx" if find_spec("dolfinx") else "DOLFINx is missing"


def missing(module: str) -> str:
    """Say how to install a package, where it is not installed.

    Args:
        module: name of the package.

    Returns:
        As :func:`how_to_install`; "" where the package is there.
    """
    return "" if find_spec(module) else how_to_install(module)


def need(module: str) -> None:
    """Refuse long work that would miss a package at its end.

    Args:
        module: name of the package.

    Raises:
        ModuleNotFoundError: the package is not installed; :mod:`dolfingrip.cli.edge` says how to
            install it.
    """
    if missing(module):
        raise ModuleNotFoundError(name=module)
