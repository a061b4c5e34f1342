"""``dolfingrip mesh``, ``export`` and ``morph``: the finger's shape as files."""

from __future__ import annotations

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.console import check_writable, console
from dolfingrip.cli.settings import ExportSettings, MeshSettings, MorphSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.files import whole
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files
from dolfingrip.meshes.morph import morphed
from dolfingrip.meshes.quality import check, judge
from dolfingrip.meshes.solid import SolidMesh, assemble, second_order
from dolfingrip.report import printable

FORMATS = (".msh", ".vtk", ".inp")


def mesh(asked: MeshSettings) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp."""
    resolved = configuration.load(asked.config, asked.overrides)
    check_writable(asked.out)

    screen = console()

    def work() -> None:
        with screen.status("meshing"):
            linear = undeformed.solid(resolved.changed(mesh={"order": 1}))
            written = _of_order(_order(resolved), linear)
        quality = check(written)
        screen.say(quality.summary())
        for said in judge(written, quality, "try another mesh.size_mm"):
            screen.say(f"quality: {said}")
        for suffix in FORMATS:
            files.write(asked.out / f"finger{suffix}", written)
            screen.say(f"wrote {asked.out / f'finger{suffix}'}")

    on_root(MPI.COMM_WORLD, work)


def _order(config: Config) -> int:
    """Order of the elements in the files: the one asked for, or the solver's."""
    if config.mesh.order is not None:
        return config.mesh.order
    return 1 if config.solver.element == "P1" else 2


def _of_order(order: int, mesh: SolidMesh) -> SolidMesh:
    """``mesh`` with elements of the first or second order; new edges are straight."""

    if mesh.order == order:
        return mesh
    if order == 2:
        return second_order(mesh)
    return assemble(mesh.points, mesh.cells[:, : mesh.shape.corners], mesh.facets, mesh.regions)


CONFIGURATION = ".toml"


def export(asked: ExportSettings) -> None:
    """Write a design as STL or STEP, ready to print, as a configuration, or its mould."""
    if not asked.files and asked.mould is None:
        raise ConfigError("FILE: none; allowed: a file to write, or --mould FOLDER")
    resolved = configuration.load(asked.config, asked.overrides)

    allowed = (*printable.FORMATS, CONFIGURATION)
    for file in asked.files:
        if file.suffix.lower() not in allowed:
            raise ConfigError(f"FILE {file}: allowed: names that end in {', '.join(allowed)}")
        check_writable(file.parent)
    if asked.mould is not None:
        check_writable(asked.mould)
    screen = console()

    def work() -> None:
        for file in asked.files:
            if file.suffix.lower() == CONFIGURATION:
                whole.write(file, configuration.dumps(resolved))
                screen.say(f"wrote {file}")
                continue
            screen.say(f"wrote {file}: {printable.write(resolved, file).summary()}")
        if asked.mould is not None:
            with screen.status("making the mould"):
                made = printable.write_mould(resolved, asked.mould)
            for file, part in made.parts.items():
                screen.say(f"wrote {file}: {part.summary()}")
            screen.say(
                f"silicone: {made.body_mm3 / 1000:.3g} cm³ for the body, "
                f"{made.base_mm3 / 1000:.3g} cm³ for the base with its "
                f"{resolved.geometry.limiting} in it"
            )
            if not getattr(resolved.geometry, "tube", False):
                key = f"{resolved.geometry_table}.tube"
                screen.say(f"the cavity will be sealed; --set {key}=true leaves room for a hose")

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
