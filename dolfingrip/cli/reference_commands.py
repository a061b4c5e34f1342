"""``dolfingrip config``, ``columns`` and ``extensions``: what there is to look up."""

from __future__ import annotations

import inspect
import re
import sys
import textwrap
from collections.abc import Sequence

import typer
from mpi4py import MPI
from rich.box import SIMPLE_HEAD
from rich.table import Table

from dolfingrip import config as configuration
from dolfingrip.cli.console import console
from dolfingrip.cli.settings import ColumnsSettings, ConfigSettings, EffectSettings
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS, find
from dolfingrip.experiments.recorder import described
from dolfingrip.extensions import effect as effects
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.report.table import of_columns
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.units import unit

WIDTH = 46
"""Width, in characters, to which a meaning is wrapped."""

INTRODUCTION = """# Columns of results

The unit of a column stands at the end of its name.
A column that is not listed for an experiment stays empty. With `--bands` each reading has two
more, such as `low_angle_deg` and `high_angle_deg`: the ends of an interval that holds the reading
with 95 %; the page on [bands](../sensitivities.md#bands) says what it is made of.
`scripts/run dolfingrip columns grasp` prints the columns of one experiment.
"""


def show_config(args: ConfigSettings) -> None:
    """Print the resolved configuration, each key with its meaning."""
    resolved = configuration.load(args.config, args.overrides)
    if MPI.COMM_WORLD.rank == 0:
        sys.stdout.write(configuration.dumps(resolved))


def columns(args: ColumnsSettings) -> None:
    """Say what each column of an experiment's result.csv means."""
    shown = list(EXPERIMENTS.values()) if args.experiment is None else [find(args.experiment)]
    if args.markdown:
        typer.echo(page(shown), nl=False)
        return

    screen = console()
    for experiment in shown:
        rows = described(experiment)
        meanings = ["\n".join(textwrap.wrap(about, WIDTH)) for _, about in rows]
        cells = {"Column": [name for name, _ in rows], "Meaning": meanings}
        title = f"{experiment.title} (dolfingrip {experiment.command})"
        screen.print(of_columns(cells, title, left=tuple(cells)))


def page(experiments: Sequence[Experiment]) -> str:
    """The columns of these experiments as Markdown.

    Each column stands once, in a table with those that the same experiments have.
    """

    about: dict[str, str] = {}
    commands: dict[str, list[str]] = {}
    for experiment in experiments:
        for name, meaning in described(experiment):
            about[name] = meaning
            commands.setdefault(name, []).append(f"`{experiment.command}`")
    tables: dict[tuple[str, ...], list[str]] = {}
    for name, having in commands.items():
        tables.setdefault(tuple(having), []).append(name)
    lines = [INTRODUCTION]
    for sharing, names in tables.items():
        title = "every experiment" if len(sharing) == len(experiments) > 1 else ", ".join(sharing)
        lines += [f"## Columns of {title}", "", "| column | meaning |", "|---|---|"]
        # a bar would end the cell
        lines += [f"| `{name}` | {about[name].replace('|', '∣')} |" for name in names]
        lines.append("")
    return "\n".join(lines)


def extensions(args: EffectSettings) -> None:
    """List the effects that can be switched on, with their parameters and priors."""
    out = console()
    if args.name is None:
        out.print(tabulate())
        out.say(
            "All about one: dolfingrip extensions prony. Switch on: --set extensions.prony.g=[0.2]"
        )
        return
    by_name = {effect.name(): effect for effect in EFFECTS}
    if args.name not in by_name:
        raise ConfigError(f"{args.name}: no effect; allowed: {', '.join(by_name)}")
    out.say(_plain(inspect.getdoc(by_name[args.name]) or ""))
    out.print(tabulate([by_name[args.name]], source=True))


def _plain(text: str) -> str:
    """Return a docstring without its markup, as ``:mod:`forms```."""
    return re.sub(r":\w+:`~?([^`]+)`", r"\1", text).replace("``", "")


def tabulate(effects: Sequence[type[effects.Effect]] = EFFECTS, *, source: bool = False) -> Table:
    """A table with each parameter of ``effects``: its prior, default and source, if asked."""
    table = Table(box=SIMPLE_HEAD)
    headings = ["effect", "kind", "parameter", "prior"]
    for name in [*headings, "default", "source"] if source else headings:
        table.add_column(name, no_wrap=name not in ("prior", "source"))
    for effect in effects:
        lead = [effect.name(), effect.kind]
        priors = effect.priors()
        for key, info in effect.model_fields.items():
            prior = priors.get(key)
            default = info.default
            if isinstance(default, tuple):
                default = list(default)
            prior_cell = f"{prior.mean:g} ± {prior.spread:g} {unit(key)}" if prior else "–"
            more = [str(default), prior.source if prior else ""] if source else []
            table.add_row(*lead, key, prior_cell, *more)
            lead = ["", ""]
    return table
