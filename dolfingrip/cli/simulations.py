"""Options and endings of the commands that compute many jobs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from dolfingrip.jobs.interrupts import Interrupted

Workers = Annotated[int, typer.Option(min=1, help="Processes that simulate.")]
StoreFolder = Annotated[
    Path | None,
    typer.Option(metavar="FOLDER", help="Simulations; default: simulations/ in --out."),
]
Effects = Annotated[
    str | None,
    typer.Option(metavar="NAME,NAME,…", help="Effects to try; default: the whole catalogue."),
]


def effect_names(effects: str | None) -> list[str] | None:
    """Names that ``--effects`` joins by commas; None for the whole catalogue."""
    return [name.strip() for name in effects.split(",")] if effects else None


@contextmanager
def resumable(screen: Console, folder: Path) -> Iterator[None]:
    """Say what is kept where a command is interrupted, or where not all jobs can be computed.

    Args:
        screen: where the second is said; the command then ends with code 1.
        folder: of the jobs.
    """
    from dolfingrip.jobs.pool import Unfinished

    try:
        yield
    except Unfinished as ending:
        screen.print(str(ending), style="red", soft_wrap=True)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        raise Interrupted(
            f"what was computed is kept in {folder}; the same command goes on from there"
        ) from None
