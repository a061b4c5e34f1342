"""``dolfingrip import``: a laboratory's table as the two files of the format of measured data."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import typer

from dolfingrip.cli.console import Screen, console
from dolfingrip.cli.settings import ImportSettings
from dolfingrip.config import ConfigError
from dolfingrip.importing import importing
from dolfingrip.importing.importing import ImportedTable
from dolfingrip.importing.told import VALUE, ImportOption, NamedColumn, Question, Told
from dolfingrip.report.table import of_columns


def import_table(args: ImportSettings) -> None:
    """Read the table, ask what is not certain, and write the two files."""
    given = {field.name: getattr(args, field.name) for field in fields(Told)}
    bring(args.table, args.out, Told(**given | {"column": named(args.column)}), console())


def named(texts: Sequence[str]) -> tuple[NamedColumn, ...]:
    """Return the columns that texts such as ``p=pressure_bar`` name.

    Args:
        texts: as they are typed; the last sign of equality counts.
    """
    parted = [text.rpartition("=") for text in texts]
    return tuple(NamedColumn(header, column) for header, _, column in parted)


def bring(file: Path, out: Path, settings: Told, screen: Screen) -> Path:
    """Import a table; at a terminal a person answers what is not certain.

    Args:
        file: the table.
        out: folder of the two files.
        settings: what is told already.
        screen: that shows the mapping and asks.

    Returns:
        The CSV that was written.

    Raises:
        ConfigError: one line with the lines to add, where nobody can be asked.
    """
    while True:
        with screen.status(f"reading {file}"):
            imported, questions = _understood(file, settings)
        if not questions or not _asks():
            break
        settings = settings.with_option(_answer(questions[0], screen))
    if imported is not None:
        _show(imported, screen)
    if questions:
        raise ConfigError(f"{file}: {'; '.join(map(str, questions))}")
    assert imported is not None
    for note in imported.notes:
        screen.say(f"- {note}")
    with screen.status(f"writing {out}"):
        written, setup = importing.write(imported, out)
    screen.say(f"{len(imported.table)} rows: {written} and {setup}")
    return written


def offered(files: Sequence[Path], command: str, screen: Screen, out: Path) -> list[Path]:
    """Offer to import those of some tables that are not in the format of measured data.

    Args:
        files: CSV files that a command takes.
        command: the command, for the message.
        screen: that asks.
        out: folder of the command's results.

    Returns:
        The files, with those that were imported in place of their sources.

    Raises:
        ConfigError: one line that names columns and lines to add, where nobody can be asked.
    """
    return [file if _in_format(file) else _offer(file, command, screen, out) for file in files]


def _in_format(file: Path) -> bool:
    """True for a table in the format, and for what no import could read better."""
    return not file.is_file() or importing.is_format(_header(file))


def _header(file: Path) -> list[str]:
    """Names of the columns of a CSV file; an empty name where it is no text."""
    try:
        with file.open(encoding="utf-8-sig") as stream:
            header = next((line for line in stream if not line.startswith("#")), "")
    except UnicodeDecodeError:
        return [""]
    return [name.strip() for name in header.split(",")]


def _offer(file: Path, command: str, screen: Screen, out: Path) -> Path:
    folder = out / "imported"
    line = f"dolfingrip import {file} --out FOLDER"
    try:
        imported, questions = _understood(file, Told())
    except ConfigError as error:
        if importing.is_format(_header(file)[:1]):
            return file  # almost in the format, whose own reader says what is wrong
        raise ConfigError(f"{command} {error}; {line} takes such tables") from None
    if _asks() and typer.confirm(f"{file} is not in the format of measured data. Import it?"):
        return bring(file, folder, Told(), screen)
    mapping = [] if imported is None else [(h, n) for h, n, _ in imported.mapping() if n != "?"]
    taken = [f"{header} is {name}" for header, name in mapping if header != name]
    if mapping and not taken:
        taken = ["its columns are named so, but are no UTF-8 with commas"]
    more = f", which asks: {'; '.join(map(str, questions))}" if questions else ""
    raise ConfigError(
        f"{command} {file}: not in the format of measured data ({', '.join(taken)}); "
        f"allowed: what {line} writes{more}"
    )


def _understood(file: Path, settings: Told) -> tuple[ImportedTable | None, Sequence[Question]]:
    try:
        imported = importing.understand(file, settings)
    except Question as question:
        return None, [question]
    return imported, imported.questions


def _asks() -> bool:
    return sys.stdin.isatty() and sys.stdout.isatty()


def _answer(question: Question, screen: Screen) -> ImportOption:
    """Ask one question at the terminal; the answer is the option that would be added."""
    screen.say(question.text)
    for i, option in enumerate(question.options, start=1):
        screen.say(f"  {i}  {option}")
    choice = 1
    while len(question.options) > 1:
        choice = typer.prompt("which", type=int, default=1)
        if 1 <= choice <= len(question.options):
            break
    option = question.options[choice - 1]
    for place in (VALUE, "FACTOR", "OFFSET"):
        if place in str(option):
            option = option.filled(place, typer.prompt(place.lower(), type=float))
    return option


def _show(imported: ImportedTable, screen: Screen) -> None:
    """Print what was taken for what."""
    rows = imported.mapping()
    columns = {
        "Column": [header for header, _, _ in rows],
        "Taken for": [name for _, name, _ in rows],
        "From": [done for _, _, done in rows],
    }
    screen.say(f"{imported.file.name}: {imported.cells.how}")
    screen.print(of_columns(columns, None, left=tuple(columns)))
