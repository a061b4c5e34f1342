"""``dolfingrip explore``: designs in the browser."""

from __future__ import annotations

import secrets
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from dolfingrip.cli.options import ConfigFile, Overrides, check_writable, console, one_process
from dolfingrip.config import ConfigError


def explore(
    results: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[RESULTS]…", help="Folders of doe, train, optimise, bend or force."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", help="Folder for solutions; default: explore/ in RESULTS or in out."
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH", help="A slider; repeatable. Default: the campaign's."),
    ] = None,
    host: Annotated[
        str, typer.Option(help="Address to listen at; any other than this machine's is public.")
    ] = "127.0.0.1",
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Default: the first free one from 8760 on.")
    ] = None,
    browser: Annotated[bool, typer.Option("--browser", help="Open it in the browser.")] = False,
    restart: Annotated[
        bool,
        typer.Option(
            "--restart", help="Take the place of the last server: its pages connect again."
        ),
    ] = False,
    config: ConfigFile = None,
    overrides: Overrides = None,
) -> None:
    """Explore designs in the browser: sliders, shape, numbers, front, gripper, exports.

    Designs are solved on demand and kept, and shapes between them are interpolated. The page is
    served to this machine alone, to whoever has the address that is printed.
    """
    one_process("without mpirun")
    from dolfingrip.design.campaign.campaign import read
    from dolfingrip.design.campaign.plan import FIELDS
    from dolfingrip.explore import guard, server, space
    from dolfingrip.explore.handover import Handover
    from dolfingrip.explore.library import Library
    from dolfingrip.explore.session import Session
    from dolfingrip.report.page import sources

    found = sources.find(results) if results else []
    folder = server.state_folder(results[0] if results else None, out)
    check_writable(folder)
    handover = Handover.of(folder)
    token = secrets.token_urlsafe(32)
    if restart:
        before = handover.before()
        if before is None:
            raise ConfigError(f"--restart: no server had {folder}; allowed: without it")
        port, token = before if port is None else (port, before[1])
    designs = {each.folder: read(each.folder).rows for each in found if each.kind == "doe"}
    screen = console()
    with screen.status("reading results"):
        designed = space.of_results(found, designs, config, dict(overrides or ()), parameter or ())
        library = Library(designed)
        for each in found:
            if each.kind == "run":
                library.add(each.folder)
            elif each.kind == "doe":  # of doe --fields
                for kept in sorted((each.folder / FIELDS).glob("*/*")):
                    library.add(kept)
    listening = server.bound(host, port)

    def say(address: str) -> None:
        handover.write(address)
        screen.print(f"explorer: {address}", soft_wrap=True)
        screen.print(f"solutions: {folder}; Ctrl-C ends it", soft_wrap=True)
        if host not in guard.LOOPBACK:
            screen.print(
                f"warning: {host} can be reached by others; whoever has the address can "
                "compute here, and nothing is encrypted",
                style="yellow",
                soft_wrap=True,
            )
        if browser:
            webbrowser.open(handover.file.as_uri())

    server.serve(Session(designed, library, folder), token, listening, host, say)
