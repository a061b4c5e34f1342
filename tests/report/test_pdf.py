"""A page as PDF where the program that prints it fails."""

from __future__ import annotations

from pathlib import Path

import pytest

from dolfingrip.report.page import pdf
from dolfingrip.sections.errors import ConfigError


def test_a_program_that_prints_nothing_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program, page = tmp_path / "chromium", tmp_path / "page.html"
    program.write_text("#!/bin/sh\necho no display >&2\nexit 1\n", encoding="utf-8")
    program.chmod(0o700)
    page.write_text("<p>page</p>", encoding="utf-8")
    monkeypatch.setattr(pdf, "chromium", lambda: str(program))
    out = tmp_path / "page.pdf"
    with pytest.raises(ConfigError, match=f"^--pdf {out}: {program} wrote nothing: no display$"):
        pdf.print_page(page, out)
    assert not out.exists()
