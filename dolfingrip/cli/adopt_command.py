"""``dolfingrip adopt``: a user's own geometry as a finger."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from mpi4py import MPI

from dolfingrip.cli.meshing import Meshing
from dolfingrip.cli.options import check_writable, console
from dolfingrip.config import Config, ConfigError
from dolfingrip.files.whole import write

if TYPE_CHECKING:
    from dolfingrip.meshes.adoption.adopt import AdoptedPart

NAME = "adopted"
"""Stem of the files that are written."""


def _point(option: str, text: str | None) -> Any:
    """Three numbers from ``x,y,z``.

    Raises:
        ConfigError: one line naming the option.
    """
    if text is None:
        return None
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != 3:
        raise ConfigError(f"{option} {text}: allowed: three numbers, as in 0,10,25.5")
    return found


def _positive(option: str, value: float | None, most: float) -> None:
    if value is not None and not 0 < value <= most:
        raise ConfigError(f"{option} {value:g}: allowed: above 0 and up to {most:g}")


def adopt(
    part: Annotated[
        Path, typer.Argument(help="STEP, IGES or BREP; STL, OBJ or PLY; or a mesh, such as .msh.")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for results.")] = Path(
        "out/adopt"
    ),
    cavity: Annotated[
        list[str] | None,
        typer.Option(metavar="X,Y,Z", help="Point in or on a cavity (mm); repeatable."),
    ] = None,
    clamp: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Point on the plane face that is clamped.")
    ] = None,
    tip: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Point on the face that is the tip.")
    ] = None,
    back: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Direction that the strain-limiting side faces."),
    ] = None,
    whole: Annotated[bool, typer.Option("--whole", help="Mesh both halves.")] = False,
    size_mm: Annotated[float | None, typer.Option(help="Size of elements.")] = None,
    order: Annotated[int | None, typer.Option(help="Order of elements, 1 or 2.")] = None,
    cap_mm: Annotated[
        float | None, typer.Option(help="Thickness of a cap on an opening away from the clamp.")
    ] = None,
    limit_s: Annotated[
        float, typer.Option("--limit-s", help="Time after which meshing is given up (s).")
    ] = 300.0,
    scale: Annotated[
        float, typer.Option(help="mm for each unit of the file; 25.4 for inches.")
    ] = 1.0,
) -> None:
    """Turn your own geometry into a finger: mesh, configuration and a picture.

    It takes closed shells inside, or hollows with an opening, for cavities, a plane face at an
    end for the clamp, and the other end for the tip. The picture shows what it took for what;
    options correct it. All coordinates are those of the file, in mm.
    """
    from dolfingrip.meshes.adoption.roles import Asked
    from dolfingrip.meshes.adoption.sizes import MeshRequest

    asked = Asked(
        tuple(_point("--cavity", text) for text in cavity or ()),
        _point("--clamp", clamp),
        _point("--tip", tip),
        _point("--back", back),
        whole,
    )
    _positive("--size-mm", size_mm, 1000.0)
    _positive("--cap-mm", cap_mm, 1000.0)
    _positive("--limit-s", limit_s, 1e6)
    _positive("--scale", scale, 1e6)
    if order not in (None, 1, 2):
        raise ConfigError(f"--order {order}: allowed: 1 or 2")
    check_writable(out)
    from dolfingrip.mechanics.model.domain import on_root

    screen = console()

    def work() -> None:
        from dolfingrip.meshes import files
        from dolfingrip.meshes.adoption.adopt import adopt as make
        from dolfingrip.report import adopted as picture

        with Meshing(screen, part, limit_s) as meshing:
            found = make(part, asked, MeshRequest(size_mm, order, cap_mm, meshing.tell), scale)
        files.write(out / f"{NAME}.msh", found.mesh)
        write(out / f"{NAME}.toml", _configuration(found, part))
        title = f"{part.name}: what is taken for what"
        picture.draw(found.mesh, out / f"{NAME}.png", title)
        for name, said in found.roles.said.items():
            screen.print(f"{name + ':':15} {said}", soft_wrap=True)
        screen.print(f"{'walls:':15} {_walls(found)}", soft_wrap=True)
        screen.print(f"{'mesh:':15} {found.quality.summary()}", soft_wrap=True)
        for suffix in (".png", ".msh", ".toml"):
            screen.print(f"wrote {out / f'{NAME}{suffix}'}", soft_wrap=True)
        screen.print(f"next: dolfingrip bend --config {out / f'{NAME}.toml'}", soft_wrap=True)

    on_root(MPI.COMM_WORLD, work)


def _walls(found: AdoptedPart) -> str:
    said = f"{found.measured.wall.mm:.3g} mm at least, elements of {found.measured.size_mm:.3g} mm"
    if found.measured.gap.mm < float("inf"):
        said += f"; gaps between outer sides of {found.measured.gap.mm:.3g} mm at least"
    return said


def _configuration(found: AdoptedPart, part: Path) -> str:
    """The configuration of the adopted part, as TOML."""
    depth, width, length = found.size_mm
    defaults = Config()
    gap = found.measured.gap.mm
    barrier = min(defaults.contact.barrier_mm, gap / 4)
    facing = min(defaults.plate.contact_length_mm, length / 2)
    lines = [
        f"# {part.name}, adopted: clamp at z = 0, tip towards +z, strain-limiting side at x = 0",
        "[finger]",
        f'kind = "{NAME}"',
        "",
        f"[{NAME}]",
        f"length_mm = {length:.6g}",
        f"width_mm = {width:.6g}",
        f"depth_mm = {depth:.6g}",
        f"wall_mm = {found.measured.wall.mm:.4g}",
        "",
        "[mesh]",
        f'file = "{NAME}.msh"',
        f"half = {str(found.roles.half).lower()}",
        "",
        "[morph]  # the plane between the strain-limiting side and the rest",
        f"d_mm = {depth / 2:.6g}",
        "",
        "[cog]  # the part's own centre of gravity: the offset of the part as drawn is 0",
        f"x_ref_mm = {found.centroid_x_mm:.6g}",
        "",
        "[plate]",
        f"contact_length_mm = {facing:.4g}",
    ]
    if barrier < defaults.contact.barrier_mm:
        lines += ["", "[contact]  # a fourth of the narrowest gap", f"barrier_mm = {barrier:.3g}"]
    cavities = [name for name in found.mesh.facets if name.startswith("cavity")]
    if len(cavities) > 1:
        for name in sorted(cavities):
            lines += ["", f"[cavity.{name}]  # its pressure by the experiment's",
                      "pressure_ratio = 1.0"]  # fmt: skip
    lines += ["", "# [material]  # default: NinjaFlex; see docs/materials.md"]
    lines += [f"# [material.{region}]  # of this part of the file" for region in found.mesh.regions]
    return "\n".join(lines) + "\n"
