"""``dolfingrip report``: results of any kind as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dolfingrip.cli.options import console, one_process
from dolfingrip.config import ConfigError
from dolfingrip.files import whole

if TYPE_CHECKING:
    from dolfingrip.report.page.contribution import FoundResult

MB = 1e6


def report(
    results: Annotated[
        list[Path], typer.Argument(metavar="RUN…", help="Folders with results of any kind.")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="HTML file.")] = Path("report.html"),
    measured: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Measured data, drawn beside curves.")
    ] = None,
    title: Annotated[str | None, typer.Option(help="Title of the page.")] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Also print it, by Chromium.")] = False,
) -> None:
    """Write results as one HTML page: 3D view, curves, front, checks, provenance.

    RUN is a folder that bend, force, cycle, coupon, push, grasp, doe, train, optimise, design,
    study or diagnose wrote, or one with several of these in it, such as the demo's. The page needs
    no network; it opens in any browser.
    """
    one_process("without mpirun")
    if out.suffix.lower() not in (".html", ".htm"):
        raise ConfigError(f"--out {out}: allowed: a file that ends in .html")
    screen = console()
    with screen.status("reading results"):
        file = write_report(results, out, measured=measured, title=title)
    screen.print(f"report: {file} ({file.stat().st_size / MB:.1f} MB)", soft_wrap=True)
    if pdf:
        from dolfingrip.report.page.pdf import print_page

        with screen.status("printing"):
            printed = print_page(file, file.with_suffix(".pdf"))
        screen.print(f"printed: {printed}", soft_wrap=True)


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
    from dolfingrip.files.columns import read_csv
    from dolfingrip.report.page import build, html, sources
    from dolfingrip.report.page.contribution import Given

    found = sources.find(results)
    table = None
    if measured is not None:
        try:
            table = read_csv(measured)
        except (OSError, ValueError) as error:
            raise ConfigError(f"--measured {measured}: {error}") from None
    page = build.build(found, Given(_designs(found), table), title or "")
    text = html.rendered(page).encode()
    size_MB = len(text) / MB
    if size_MB > html.LARGEST_MB:
        raise ConfigError(
            f"--out {out}: {size_MB:.0f} MB; allowed: {html.LARGEST_MB:g} MB, so give fewer results"
        )
    whole.write(out, text)
    return out


def _designs(found: Sequence[FoundResult]) -> dict[Path, list[dict[str, Any]]]:
    """The designs of each campaign."""
    from dolfingrip.design.campaign.campaign import read

    return {each.folder: read(each.folder).rows for each in found if each.kind == "doe"}
