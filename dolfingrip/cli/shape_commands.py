"""``dolfingrip mesh`` and ``morph``: the finger's mesh as files."""

from __future__ import annotations

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.console import check_writable, console
from dolfingrip.cli.settings import MeshSettings, MorphSettings
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files
from dolfingrip.meshes.morph import morphed
from dolfingrip.meshes.quality import check, judge

FORMATS = (".msh", ".vtk", ".inp")


def mesh(asked: MeshSettings) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp."""
    resolved = configuration.load(asked.config, asked.overrides)
    check_writable(asked.out)

    screen = console()

    def work() -> None:
        with screen.status("meshing"):
            written = undeformed.elements(resolved, resolved.mesh.order)
        quality = check(written)
        screen.say(quality.summary())
        for said in judge(written, quality, "try another mesh.size_mm"):
            screen.say(f"quality: {said}")
        for suffix in FORMATS:
            files.write(asked.out / f"finger{suffix}", written)
            screen.say(f"wrote {asked.out / f'finger{suffix}'}")

    on_root(MPI.COMM_WORLD, work)


def morph(asked: MorphSettings) -> None:
    """Move a mesh by ξ1 up to the plane x = morph.d_mm, and by ξ2 beyond it."""
    changes = {**asked.overrides, "morph.xi1": asked.xi[0], "morph.xi2": asked.xi[1]}
    resolved = configuration.load(asked.config, changes)

    def work() -> None:
        original = files.read(asked.mesh, needed=())
        move = undeformed.morph(resolved)
        files.write(asked.out, morphed(original, move.inverse() if asked.inverse else move))
        console().say(f"wrote {asked.out}")

    on_root(MPI.COMM_WORLD, work)
