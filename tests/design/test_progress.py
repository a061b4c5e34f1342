"""Lines on a campaign's progress where there is no terminal."""

from __future__ import annotations

import io

from rich.console import Console

from dolfingrip.design.campaign import progress
from dolfingrip.design.campaign.campaign import Standing


def _lines(total: int) -> list[str]:
    """What is printed as three designs are done within a moment."""
    text = io.StringIO()
    with progress.shown(Console(file=text)) as show:
        for done in range(4):
            show(Standing(total=total, done=done))
    return text.getvalue().splitlines()


def test_a_small_campaign_has_a_line_for_each_design() -> None:
    words = [line.split(",")[0] for line in _lines(30)]
    assert words == [f"{done} of 30 designs" for done in range(4)]


def test_a_large_campaign_has_a_line_now_and_then() -> None:
    assert [line.split(",")[0] for line in _lines(208)] == ["0 of 208 designs"]
