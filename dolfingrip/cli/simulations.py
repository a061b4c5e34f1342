"""What commands that simulate on a campaign's workers have in common."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

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
def ending_with_workers(screen: Console) -> Iterator[None]:
    """End the command with one line and code 1 where all workers are gone."""
    from dolfingrip.design.campaign.campaign import SchedulerGone

    try:
        yield
    except SchedulerGone as gone:
        screen.print(f"[red]{gone}[/red]", soft_wrap=True)
        raise typer.Exit(1) from None
