"""``dolfingrip columns``: what the columns of an experiment's ``result.csv`` mean."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Annotated

import typer

from dolfingrip.cli.options import console
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import EXPERIMENTS, find

WIDTH = 46
"""Width, in characters, to which a meaning is wrapped."""

INTRODUCTION = """# Columns of results

The unit of a column stands at the end of its name.
A column that is not listed for an experiment stays empty.
`scripts/run dolfingrip columns grasp` prints the columns of one experiment;
`scripts/run dolfingrip columns --markdown > docs/columns.md` writes this page.
"""


def columns(
    experiment: Annotated[
        str | None, typer.Argument(metavar="[EXPERIMENT]", help="e.g. grasp; default: all.")
    ] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a page of Markdown.")] = False,
) -> None:
    """Say what each column of an experiment's result.csv means."""
    shown = list(EXPERIMENTS.values()) if experiment is None else [find(experiment)]
    if markdown:
        typer.echo(page(shown), nl=False)
        return
    from dolfingrip.experiments.recorder import described
    from dolfingrip.report.table import of_columns

    screen = console()
    for each in shown:
        rows = described(each)
        meanings = ["\n".join(textwrap.wrap(about, WIDTH)) for _, about in rows]
        cells = {"Column": [name for name, _ in rows], "Meaning": meanings}
        screen.print(of_columns(cells, heading(each), left=tuple(cells)))


def page(experiments: Sequence[Experiment]) -> str:
    """The columns of these experiments as Markdown.

    Each column stands once, in a table with those that the same experiments have.
    """
    from dolfingrip.experiments.recorder import described

    about: dict[str, str] = {}
    commands: dict[str, list[str]] = {}
    for each in experiments:
        for name, meaning in described(each):
            about[name] = meaning
            commands.setdefault(name, []).append(f"`{each.command}`")
    tables: dict[tuple[str, ...], list[str]] = {}
    for name, having in commands.items():
        tables.setdefault(tuple(having), []).append(name)
    lines = [INTRODUCTION]
    for found, names in tables.items():
        title = "every experiment" if len(found) == len(experiments) > 1 else ", ".join(found)
        lines += [f"## Columns of {title}", "", "| column | meaning |", "|---|---|"]
        # a bar would end the cell
        lines += [f"| `{name}` | {about[name].replace('|', '∣')} |" for name in names]
        lines.append("")
    return "\n".join(lines)


def heading(experiment: Experiment) -> str:
    """The experiment's title and its command."""
    return f"{experiment.title} (dolfingrip {experiment.command})"
