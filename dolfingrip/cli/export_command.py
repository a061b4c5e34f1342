"""``dolfingrip export``: a finger as files for printers, CAD and other programs, and its mould."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.console import check_writable, console
from dolfingrip.cli.settings import ExportSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.exporting import deck, mujoco, sofa
from dolfingrip.files import whole
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes.mould import COMES_OFF
from dolfingrip.report import printable

CONFIGURATION, DECK = ".toml", ".inp"
Writer = Callable[[Config, Path], str]
LOADED: Mapping[str, Writer] = {DECK: deck.write, ".py": sofa.write, ".xml": mujoco.write}
"""What writes files for other programs, by their suffix."""


def export(args: ExportSettings) -> None:
    """Write a design for a printer, for CAD or another simulator, or what it is made from."""
    if not args.files and args.mould is None:
        raise ConfigError("FILE: none; allowed: a file to write, or --mould FOLDER")
    resolved = configuration.load(args.config, args.overrides)

    allowed = (*printable.FORMATS, *LOADED, CONFIGURATION)
    for file in args.files:
        if file.suffix.lower() not in allowed:
            raise ConfigError(f"FILE {file}: allowed: names that end in {', '.join(allowed)}")
        check_writable(file.parent)
        overwrites = file.suffix.lower() == CONFIGURATION and file.is_file()
        if overwrites and file.read_bytes() != configuration.dumps(resolved).encode():
            words = f"a new name, or --config {file} to read it"
            raise ConfigError(f"FILE {file}: holds another configuration; allowed: {words}")
    if args.mould is not None:
        check_writable(args.mould)
    if args.plate and DECK not in {file.suffix.lower() for file in args.files}:
        raise ConfigError(f"--plate: allowed: with a FILE that ends in {DECK}")
    screen = console()
    loaded: Mapping[str, Writer] = {**LOADED, DECK: partial(deck.write, plate=args.plate)}

    def work() -> None:
        for file in args.files:
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
        if args.mould is not None:
            with screen.status("making the mould"):
                made = printable.write_mould(resolved, args.mould)
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
