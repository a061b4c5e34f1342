"""``dolfingrip extensions``: list the effects that can be switched on."""

from __future__ import annotations

import inspect
import re
from collections.abc import Sequence
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from dolfingrip.cli.options import console
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.units import unit


def extensions(
    name: Annotated[str | None, typer.Argument(help="One effect, to read all about it.")] = None,
) -> None:
    """List the effects that can be switched on, with their parameters and priors."""
    out = console()
    if name is None:
        out.print(tabulate())
        out.print(
            "All about one: dolfingrip extensions prony. Switch on: --set extensions.prony.g=[0.2]",
            soft_wrap=True,
        )
        return
    by_name = {effect.name(): effect for effect in EFFECTS}
    if name not in by_name:
        raise ConfigError(f"{name}: no effect; allowed: {', '.join(by_name)}")
    out.print(_plain(inspect.getdoc(by_name[name]) or ""), soft_wrap=True)
    out.print(tabulate([by_name[name]], source=True))


def _plain(text: str) -> str:
    """A docstring without its markup, as ``:mod:`forms```."""
    return re.sub(r":\w+:`~?([^`]+)`", r"\1", text).replace("``", "")


def tabulate(effects: Sequence[type[Effect]] = EFFECTS, *, source: bool = False) -> Table:
    """A table with each parameter of ``effects``: its prior, default and source, if asked."""
    table = Table(box=SIMPLE_HEAD)
    headings = ["effect", "kind", "parameter", "prior"]
    for heading in [*headings, "default", "source"] if source else headings:
        table.add_column(heading, no_wrap=heading not in ("prior", "source"))
    for effect in effects:
        lead = [effect.name(), effect.kind]
        priors = effect.priors()
        for key, info in effect.model_fields.items():
            prior = priors.get(key)
            default = info.default
            if isinstance(default, tuple):
                default = list(default)
            known = f"{prior.mean:g} ± {prior.spread:g} {unit(key)}" if prior else "–"
            more = [str(default), prior.source if prior else ""] if source else []
            table.add_row(*lead, key, known, *more)
            lead = ["", ""]
    return table
