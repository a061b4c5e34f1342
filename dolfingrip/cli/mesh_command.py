"""``dolfingrip mesh``: write the finger's mesh."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Out, Overrides, check_writable, console
from dolfingrip.config import Config

if TYPE_CHECKING:
    from dolfingrip.meshes.solid import SolidMesh

FORMATS = (".msh", ".vtk", ".inp")


def mesh(
    out: Out = Path("out/mesh"), config: ConfigFile = None, overrides: Overrides = None
) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp.

    The files hold the solver's elements: hexahedra of 20 nodes (S2, the
    default), tetrahedra of 10 nodes (P2, P2-P1) or of 4 nodes (P1).
    --set mesh.order=1 asks for linear ones, mesh.order=2 for quadratic ones.
    """
    resolved = configuration.load(config, dict(overrides or ()))
    check_writable(out)
    from dolfingrip.experiments.rigs.undeformed import solid
    from dolfingrip.mechanics.model.domain import on_root
    from dolfingrip.meshes import files
    from dolfingrip.meshes.quality import check

    screen = console()

    def work() -> None:
        with screen.status("meshing"):
            linear = solid(resolved.changed(mesh={"order": 1}))
            written = _of_order(_order(resolved), linear)
        screen.print(check(written).summary(), soft_wrap=True)
        for suffix in FORMATS:
            files.write(out / f"finger{suffix}", written)
            screen.print(f"wrote {out / f'finger{suffix}'}", soft_wrap=True)

    on_root(MPI.COMM_WORLD, work)


def _order(config: Config) -> int:
    """Order of the elements in the files: the one asked for, or the solver's."""
    if config.mesh.order is not None:
        return config.mesh.order
    return 1 if config.solver.element == "P1" else 2


def _of_order(order: int, mesh: SolidMesh) -> SolidMesh:
    """``mesh`` with elements of the first or second order; new edges are straight."""
    from dolfingrip.meshes.solid import assemble, second_order

    if mesh.order == order:
        return mesh
    if order == 2:
        return second_order(mesh)
    return assemble(mesh.points, mesh.cells[:, : mesh.shape.corners], mesh.facets, mesh.regions)
