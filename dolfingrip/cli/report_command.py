"""``dolfingrip report``: results of any kind as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dolfingrip.cli.console import console, one_process
from dolfingrip.cli.settings import ReportSettings
from dolfingrip.config import ConfigError
from dolfingrip.files import whole
from dolfingrip.files.table import read_csv
from dolfingrip.report.page import html, sources
from dolfingrip.report.page.pdf import browser, print_page

MB = 1e6


def report(args: ReportSettings) -> None:
    """Write results as one HTML page: 3D view, curves, front, checks, provenance."""
    one_process("without mpirun")
    if args.out.suffix.lower() not in (".html", ".htm"):
        raise ConfigError(f"--out {args.out}: allowed: a file that ends in .html")
    if args.pdf:
        browser(args.out.with_suffix(".pdf"))
    screen = console()
    with screen.status("reading results"):
        file = write_report(args.results, args.out, measured=args.measured, title=args.title)
    screen.say(f"report: {file} ({file.stat().st_size / MB:.1f} MB)")
    if args.pdf:
        with screen.status("printing"):
            printed = print_page(file, file.with_suffix(".pdf"))
        screen.say(f"printed: {printed}")


def write_report(
    results: Sequence[Path], out: Path, *, measured: Path | None = None, title: str | None = None
) -> Path:
    """Write the page of these results.

    Args:
        results: folders.
        out: HTML file.
        measured: CSV of measured data; None: there is none.
        title: of the page; None: one by the results.

    Returns:
        The HTML file.

    Raises:
        ConfigError: one line, if there are no results, one cannot be read, or the page is too
            large.
        WriteError: one line.
    """

    result_sources = sources.find(results)
    table = None
    if measured is not None:
        try:
            table = read_csv(measured)
        except (OSError, ValueError) as error:
            raise ConfigError(f"--measured {measured}: {error}") from None
    page = sources.build(result_sources, table, title or "")
    text = html.rendered(page).encode()
    size_MB = len(text) / MB
    if size_MB > html.LARGEST_MB:
        raise ConfigError(
            f"--out {out}: {size_MB:.0f} MB; allowed: {html.LARGEST_MB:g} MB, so give fewer results"
        )
    whole.write(out, text)
    return out
