"""``dolfingrip explore``: designs in the browser."""

from __future__ import annotations

import secrets
import webbrowser

from dolfingrip.cli.console import check_writable, console, one_process, resumable
from dolfingrip.cli.settings import ExploreSettings
from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.plan import FIELDS
from dolfingrip.explore import server, space
from dolfingrip.explore.guard import LOOPBACK, Handover
from dolfingrip.explore.library import Library
from dolfingrip.explore.session import Session
from dolfingrip.report.page import sources


def explore(asked: ExploreSettings) -> None:
    """Explore designs in the browser: sliders, shape, numbers, front, gripper, exports."""
    one_process("without mpirun")

    found = sources.find(asked.results) if asked.results else []
    folder = server.state_folder(asked.results[0] if asked.results else None, asked.out)
    check_writable(folder)
    handover = Handover.of(folder)
    port, token = asked.port, secrets.token_urlsafe(32)
    if asked.restart:
        before = handover.before()
        if before is None:
            raise ConfigError(f"--restart: no server had {folder}; allowed: without it")
        port, token = before if port is None else (port, before[1])
    screen = console()
    with screen.status("reading results"):
        designed = space.of_results(found, asked.config, asked.overrides, asked.parameter)
        library = Library(designed)
        for each in found:
            if each.kind == "run":
                library.add(each.folder)
            elif each.kind == "doe":  # of doe --fields
                for kept in sorted((each.folder / FIELDS).glob("*/*")):
                    library.add(kept)
    listening = server.bound(asked.host, port)

    def say(address: str) -> None:
        handover.write(address)
        screen.say(f"explorer: {address}")
        screen.say(f"solutions: {folder}; Ctrl-C ends it")
        if asked.host not in LOOPBACK:
            screen.say(
                f"warning: {asked.host} can be reached by others; whoever has the address can "
                "compute here, and nothing is encrypted",
                style="yellow",
            )
        if asked.browser:
            webbrowser.open(handover.file.as_uri())

    with resumable(screen, folder):
        server.serve(Session(designed, library, folder), token, listening, asked.host, say)
