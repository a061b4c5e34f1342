"""``dolfingrip mesh`` and ``morph``: the finger's mesh as files."""

from __future__ import annotations

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.console import console
from dolfingrip.cli.settings import MeshSettings, MorphSettings
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files
from dolfingrip.meshes.morph import morphed
from dolfingrip.meshes.quality import check, judge

FORMATS = (".msh", ".vtk", ".inp")


def mesh(args: MeshSettings) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp."""
    resolved = configuration.load(args.config, args.overrides)

    screen = console()

    def work() -> None:
        with screen.status("meshing"):
            written = undeformed.elements(resolved, resolved.mesh.order)
        quality = check(written)
        screen.say(quality.summary())
        for said in judge(written, quality, "try another mesh.size_mm"):
            screen.say(f"quality: {said}")
        for suffix in FORMATS:
            files.write(args.out / f"finger{suffix}", written)
            screen.say(f"wrote {args.out / f'finger{suffix}'}")

    on_root(MPI.COMM_WORLD, work)


def morph(args: MorphSettings) -> None:
    """Move a mesh by ξ1 up to the plane x = morph.d_mm, and by ξ2 beyond it."""
    changes = {**args.overrides, "morph.xi1": args.xi[0], "morph.xi2": args.xi[1]}
    resolved = configuration.load(args.config, changes)

    def work() -> None:
        original = files.read(args.mesh, needed=())
        move = undeformed.morph(resolved)
        files.write(args.out, morphed(original, move.inverse() if args.inverse else move))
        console().say(f"wrote {args.out}")

    on_root(MPI.COMM_WORLD, work)
