"""``dolfingrip morph``: move the mesh in a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Overrides, console


def morph(
    mesh: Annotated[Path, typer.Argument(help="Mesh of the original: .msh, .inp, .vtk or .vtu.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="File of the moved mesh.")],
    xi: Annotated[
        tuple[float, float],
        typer.Option(metavar="ξ1 ξ2", help="Relative change of both regions' thickness."),
    ],
    inverse: Annotated[bool, typer.Option("--inverse", help="Undo this morph instead.")] = False,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Move a mesh by ξ1 up to the plane x = morph.d_mm, and by ξ2 beyond it."""
    asked = {**dict(overrides or ()), "morph.xi1": xi[0], "morph.xi2": xi[1]}
    resolved = configuration.load(config, asked)
    from dolfingrip.experiments.rigs import undeformed
    from dolfingrip.mechanics.model.domain import on_root
    from dolfingrip.meshes import files
    from dolfingrip.meshes.morph import morphed

    def work() -> None:
        original = files.read(mesh, needed=())
        move = undeformed.morph(resolved)
        files.write(out, morphed(original, move.inverse() if inverse else move))
        console().print(f"wrote {out}", soft_wrap=True)

    on_root(MPI.COMM_WORLD, work)
