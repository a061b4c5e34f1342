"""``dolfingrip mesh``, ``export`` and ``morph``: the finger's shape as files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.console import check_writable, console
from dolfingrip.cli.settings import ExportSettings, MeshSettings, MorphSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.exporting import deck, mujoco, sofa
from dolfingrip.exporting.asked import elements
from dolfingrip.files import whole
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files
from dolfingrip.meshes.morph import morphed
from dolfingrip.meshes.mould import COMES_OFF
from dolfingrip.meshes.quality import check, judge
from dolfingrip.report import printable

FORMATS = (".msh", ".vtk", ".inp")


def mesh(asked: MeshSettings) -> None:
    """Mesh the finger: .msh, VTK and Abaqus .inp."""
    resolved = configuration.load(asked.config, asked.overrides)
    check_writable(asked.out)

    screen = console()

    def work() -> None:
        with screen.status("meshing"):
            written = elements(resolved, resolved.mesh.order)
        quality = check(written)
        screen.say(quality.summary())
        for said in judge(written, quality, "try another mesh.size_mm"):
            screen.say(f"quality: {said}")
        for suffix in FORMATS:
            files.write(asked.out / f"finger{suffix}", written)
            screen.say(f"wrote {asked.out / f'finger{suffix}'}")

    on_root(MPI.COMM_WORLD, work)


CONFIGURATION, DECK = ".toml", ".inp"
Writer = Callable[[Config, Path], str]
LOADED: Mapping[str, Writer] = {DECK: deck.write, ".py": sofa.write, ".xml": mujoco.write}
"""What writes files for other programs, by their suffix."""


def export(asked: ExportSettings) -> None:
    """Write a design for a printer, for CAD or another simulator, or what it is made from."""
    if not asked.files and asked.mould is None:
        raise ConfigError("FILE: none; allowed: a file to write, or --mould FOLDER")
    resolved = configuration.load(asked.config, asked.overrides)

    allowed = (*printable.FORMATS, *LOADED, CONFIGURATION)
    for file in asked.files:
        if file.suffix.lower() not in allowed:
            raise ConfigError(f"FILE {file}: allowed: names that end in {', '.join(allowed)}")
        check_writable(file.parent)
        own = file.suffix.lower() == CONFIGURATION and file.is_file()
        if own and file.read_bytes() != configuration.dumps(resolved).encode():
            words = f"a new name, or --config {file} to read it"
            raise ConfigError(f"FILE {file}: holds another configuration; allowed: {words}")
    if asked.mould is not None:
        check_writable(asked.mould)
    if asked.plate and DECK not in {file.suffix.lower() for file in asked.files}:
        raise ConfigError(f"--plate: allowed: with a FILE that ends in {DECK}")
    screen = console()
    loaded: Mapping[str, Writer] = {**LOADED, DECK: partial(deck.write, plate=asked.plate)}

    def work() -> None:
        for file in asked.files:
            suffix = file.suffix.lower()
            if suffix == CONFIGURATION:
                whole.write(file, configuration.dumps(resolved))
                screen.say(f"wrote {file}")
                continue
            with screen.status("meshing"):
                if suffix in loaded:
                    said = loaded[suffix](resolved, file)
                else:
                    said = printable.write(resolved, file).summary()
            screen.say(f"wrote {file}: {said}")
        if asked.mould is not None:
            with screen.status("making the mould"):
                made = printable.write_mould(resolved, asked.mould)
            for file, part in made.parts.items():
                screen.say(f"wrote {file}: {part.summary()}")
            screen.say(f"taken off the cast in this order: {', '.join(COMES_OFF)}")
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
