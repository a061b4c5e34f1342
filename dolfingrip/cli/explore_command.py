"""``dolfingrip explore``: designs in the browser."""

from __future__ import annotations

import secrets
import webbrowser

from dolfingrip.cli.console import check_writable, console, one_process, resumable
from dolfingrip.cli.settings import ExploreSettings
from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.plan import FIELDS
from dolfingrip.explore import server, space
from dolfingrip.explore.library import Library
from dolfingrip.explore.session import Session
from dolfingrip.report.page import sources
from dolfingrip.serving.guard import LOOPBACK, Handover
from dolfingrip.serving.listening import bound


def explore(args: ExploreSettings) -> None:
    """Explore designs in the browser: sliders, shape, numbers, front, gripper, exports."""
    one_process("without mpirun")

    result_sources = sources.find(args.results) if args.results else []
    folder = server.state_folder(args.results[0] if args.results else None, args.out)
    check_writable(folder)
    handover = Handover.of(folder)
    port, token = args.port, secrets.token_urlsafe(32)
    if args.restart:
        before = handover.before()
        if before is None:
            raise ConfigError(f"--restart: no server had {folder}; allowed: without it")
        port, token = before if port is None else (port, before[1])
    screen = console()
    with screen.status("reading results"):
        designed = space.of_results(result_sources, args.config, args.overrides, args.parameter)
        library = Library(designed)
        for source in result_sources:
            if source.kind == "run":
                library.add(source.folder)
            elif source.kind == "doe":  # of doe --fields
                for kept in sorted((source.folder / FIELDS).glob("*/*")):
                    library.add(kept)
    listening = bound(args.host, port)

    def say(address: str) -> None:
        handover.write(address)
        screen.say(f"explorer: {address}")
        screen.say(f"solutions: {folder}; Ctrl-C ends it")
        if args.host not in LOOPBACK:
            screen.say(
                f"warning: {args.host} can be reached by others; whoever has the address can "
                "compute here, and nothing is encrypted",
                style="yellow",
            )
        if args.browser:
            webbrowser.open(handover.file.as_uri())

    with resumable(screen, folder):
        server.serve(Session(designed, library, folder), token, listening, args.host, say)
