"""A page as PDF, printed by a Chromium that the machine has."""

from __future__ import annotations

import os
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from dolfingrip.files import whole
from dolfingrip.sections.errors import ConfigError

NAMES: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")

WAIT_MS: Final = 15_000
"""Time of the page's own clock for its pictures; it ends earlier where all is still."""

LIMIT_S: Final = 180.0
"""Time after which Chromium is given up."""


def chromium() -> str | None:
    """Path of a Chromium, the machine's or Playwright's; None if there is none."""
    program = next((path for name in NAMES if (path := shutil.which(name))), None)
    if program is None and find_spec("playwright"):
        from playwright.sync_api import sync_playwright

        with sync_playwright() as playwright:
            path = playwright.chromium.executable_path
        program = path if Path(path).exists() else None
    return program


def browser(out: Path) -> str:
    """Return the path of the Chromium that prints a page.

    Args:
        out: PDF to write.

    Raises:
        ConfigError: one line, if there is none.
    """
    program = chromium()
    if program is None:
        raise ConfigError(
            f"--pdf {out}: allowed: on a machine with {NAMES[0]}, which prints it; install it by: "
            "pip install playwright && playwright install chromium"
        )
    return program


def print_page(page: Path, out: Path) -> Path:
    """Print a page.

    Args:
        page: HTML file.
        out: PDF to write.

    Raises:
        ConfigError: one line, if there is no Chromium or it fails.
        WriteError: one line, if not the whole PDF was written.
    """
    printer = browser(out)
    with (
        TemporaryDirectory() as profile,
        whole.replacing(out, check=whole.ends_with(b"%%EOF")) as (partial,),
    ):
        command = [
            printer, "--headless", "--disable-gpu-sandbox", "--enable-unsafe-swiftshader",
            "--no-first-run", f"--user-data-dir={profile}", "--no-pdf-header-footer",
            f"--virtual-time-budget={WAIT_MS}", f"--print-to-pdf={partial.resolve()}",
            *(["--no-sandbox"] if os.geteuid() == 0 else []), page.resolve().as_uri(),
        ]  # fmt: skip
        environment = {**os.environ, "HOME": profile, "XDG_CONFIG_HOME": profile}
        try:
            ended = subprocess.run(
                command,
                capture_output=True,
                text=True,
                timeout=LIMIT_S,
                env=environment,
                cwd=profile,  # Chromium's library of graphics reads settings there
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise ConfigError(
                f"--pdf {out}: {printer} did not end within {LIMIT_S:.0f} s"
            ) from None
        if not partial.stat().st_size:
            last = (ended.stderr.strip().splitlines() or ["no message"])[-1]
            raise ConfigError(f"--pdf {out}: {printer} wrote nothing: {last}")
    return out
