"""``dolfingrip adopt``: a user's own geometry as a finger."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from mpi4py import MPI
from rich.text import Text

from dolfingrip.cli.console import Screen, console
from dolfingrip.cli.progress import EVERY_S
from dolfingrip.cli.settings import AdoptSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.ballooning import diameter_mm
from dolfingrip.experiments.rigs.first_step import adopt as make
from dolfingrip.files.whole import write
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.adopt import AdoptedPart
from dolfingrip.meshes.adoption.roles import Asked as Roles
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.report import adopted as picture
from dolfingrip.sections.units import UNITS_MM


@contextmanager
def told_meshing(screen: Screen, part: Path, limit_s: float) -> Iterator[Callable[[str], None]]:
    """Say what is meshed and since when, and end the process after a limit.

    The library cannot be interrupted, so the process ends. Nothing is written before.

    Args:
        screen: a terminal has a line that changes; else there is a line every ``EVERY_S`` seconds.
        part: the file.
        limit_s: time after which one line says what to change, and the exit code is 2.

    Yields:
        What is called with words on what is meshed.
    """
    said, ended, status = "the part is read", threading.Event(), screen.status("meshing")

    def tell(words: str) -> None:
        nonlocal said
        said = words
        status.update(Text(f"meshing: {words}"))  # names in it are no markup

    def watch() -> None:
        start, passed = time.monotonic(), 0.0
        while passed < limit_s:
            if ended.wait(min(EVERY_S, limit_s - passed)):
                return
            passed = time.monotonic() - start
            if passed < limit_s and not screen.is_terminal:
                screen.say(f"meshing, {passed:.0f} s: {said}")
        status.stop()
        sys.stdout.flush()
        sys.stderr.write(
            f"dolfingrip: {part}: no mesh after {limit_s:g} s: {said}; allowed: another --size-mm, "
            "a longer --limit-s, or thicker walls\n"
        )
        sys.stderr.flush()
        os._exit(2)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        with status:
            yield tell
    finally:
        ended.set()
        thread.join()


NAME = "adopted"
"""Stem of the files that are written."""


def adopt(args: AdoptSettings) -> None:
    """Turn your own geometry into a finger: mesh, configuration and a picture."""

    once = {}
    for name in ("clamp", "tip", "back"):
        points = getattr(args, name)
        if len(points) > 1:
            raise ConfigError(f"--{name}: given {len(points)} times; allowed: once")
        once[name] = points[0] if points else None
    roles = Roles(
        cavities=[cavity for cavity in args.cavity if not isinstance(cavity, Path)],
        cavity_files=[cavity for cavity in args.cavity if isinstance(cavity, Path)],
        held=args.clamp_region,
        whole=args.whole,
        repair=args.repair,
        **once,
    )
    if (args.out / f"{NAME}.msh").resolve() == args.part.resolve():
        raise ConfigError(f"--out {args.out}: {args.part} would be lost; allowed: another folder")

    screen = console()

    def work() -> None:

        with told_meshing(screen, args.part, args.limit_s) as tell:
            part = make(
                args.part,
                roles,
                MeshRequest(args.size_mm, args.order, args.cap_mm, tell),
                UNITS_MM[args.unit],
            )
        files.write(args.out / f"{NAME}.msh", part.mesh)
        write(args.out / f"{NAME}.toml", _configuration(part, args.part))
        title = f"{args.part.name}: what is taken for what"
        picture.draw(part.mesh, args.out / f"{NAME}.png", title)
        for name, said in part.roles.said.items():
            screen.say(f"{name + ':':15} {said}")
        screen.say(f"{'walls:':15} {_walls(part)}")
        screen.say(f"{'mesh:':15} {part.quality.summary()}")
        for said in part.warnings or ("good",):
            screen.say(f"{'quality:':15} {said}")
        for suffix in (".png", ".msh", ".toml"):
            screen.say(f"wrote {args.out / f'{NAME}{suffix}'}")
        mu_MPa = Config().material.shear_MPa
        if not part.roles.cavities:
            screen.say(f"{'material:':15} not known; {mu_MPa:g} MPa is NinjaFlex's: give yours")
            screen.say(
                f"next: dolfingrip vibrate --config {args.out / f'{NAME}.toml'} "
                f"--set material.mu_MPa={mu_MPa:g}"
            )
            return
        first = f"{float(f'{_first_kPa(part, mu_MPa):.2g}'):g}"
        screen.say(
            f"{'material:':15} not known; {mu_MPa:g} MPa is NinjaFlex's: give yours below; walls "
            f"strain by about {100 * STRAIN:.0f} % at {first} kPa, in proportion to the modulus"
        )
        said = f"--set material.mu_MPa={mu_MPa:g} --pressure {first}"
        screen.say(f"next: dolfingrip bend --config {args.out / f'{NAME}.toml'} {said}")

    on_root(MPI.COMM_WORLD, work)


STRAIN = 0.2
"""Strain of a part's walls at the pressure that is tried first."""


def _first_kPa(part: AdoptedPart, mu_MPa: float) -> float:
    """A pressure at which the thinnest wall strains by :data:`STRAIN`, to the order of magnitude.

    The wall is that of a tube, ε = p r / (E t), or a clamped strip between the cavity's sides,
    ε = p a² / (2 E t²), whichever strains more; a = 2 r is the largest width of a cavity across,
    and E = 3 μ.

    Source: S. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells (1959), articles 2
    and 6 for the strip, and 108 for the tube.
    """
    slim = part.measured.wall.mm / max(max(sides[:2]) for sides in _hollows_mm(part))
    return 1000 * 3 * mu_MPa * STRAIN * min(2 * slim, 2 * slim**2)


def _hollows_mm(part: AdoptedPart) -> list[list[float]]:
    """Sides (mm) along x, y and z of the box around each cavity of the whole part."""
    mesh, copies = part.mesh, np.array([1, 1 + part.roles.half, 1])
    hollows = [mesh.points[np.unique(mesh.facets[n])] for n in groups.cavities(mesh.facets)]
    return [(copies * np.ptp(hollow, axis=0)).tolist() for hollow in hollows]


def _walls(part: AdoptedPart) -> str:
    said = f"{part.measured.wall.mm:.3g} mm at least, elements of {part.measured.size_mm:.3g} mm"
    if part.measured.gap.mm < float("inf"):
        said += f"; gaps between outer sides of {part.measured.gap.mm:.3g} mm at least"
    return said


def _configuration(part: AdoptedPart, file: Path) -> str:
    """The configuration of the adopted part, as TOML."""
    depth, width, length = part.size_mm
    defaults = Config()
    gap = part.measured.gap.mm
    barrier = min(defaults.contact.barrier_mm, gap / 4)
    facing = min(defaults.plate.contact_length_mm, length / 2)
    lines = [
        f"# {file.name}, adopted: clamp at z = 0, tip towards +z, strain-limiting side at x = 0",
        "[finger]",
        f'kind = "{NAME}"',
        "",
        f"[{NAME}]",
        f"length_mm = {length:.6g}",
        f"width_mm = {width:.6g}",
        f"depth_mm = {depth:.6g}",
        f"wall_mm = {part.measured.wall.mm:.4g}",
        f"chamber_mm = {max(map(diameter_mm, _hollows_mm(part)), default=0.0):.4g}",
        f"solid_body = {str(not part.roles.cavities).lower()}",
        f"back = {json.dumps(part.roles.said['back'], ensure_ascii=False)}",
        f"bends_to_back = {str(part.bends_to_back).lower()}",
        f"doubts = {json.dumps(part.warnings, ensure_ascii=False)}",
        "",
        "[mesh]",
        f'file = "{NAME}.msh"',
        f"half = {str(part.roles.half).lower()}",
        "",
        "[morph]  # the plane between the strain-limiting side and the rest",
        f"d_mm = {depth / 2:.6g}",
        "",
        "[cog]  # the part's own centre of gravity: the offset of the part as drawn is 0",
        f"x_ref_mm = {part.centroid_x_mm:.6g}",
        "",
        "[plate]",
        f"contact_length_mm = {facing:.4g}",
    ]
    if barrier < defaults.contact.barrier_mm:
        lines += ["", "[contact]  # a fourth of the narrowest gap", f"barrier_mm = {barrier:.3g}"]
    cavities = groups.cavities(part.mesh.facets)
    if len(cavities) > 1:
        for name in cavities:
            lines += ["", f"[cavity.{name}]  # its pressure by the experiment's",
                      "pressure_ratio = 1.0"]  # fmt: skip
    lines += ["", "# [material]  # default: NinjaFlex; see docs/materials.md"]
    lines += [f"# [material.{region}]  # of this part of the file" for region in part.mesh.regions]
    return "\n".join(lines) + "\n"
