"""Charts of measured coupons and the laws fitted to them, in three modes of tension."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.charts.picture import Look
from dolfingrip.experiments.material_fit.coupons import MODES, CouponSeries
from dolfingrip.experiments.material_fit.fit import LawFit

LOOK: Final = Look(panel_in=(3.2, 3.8), key="below", titled=True)

BEYOND: Final = 3.0
"""Curves are cut off at so many times the largest stress of the best law, if none is measured."""

OTHERS: Final = [
    (colour, style)
    for style in ("dash", "dots", "line")
    for colour in ("orange", "green", "purple", "grey")
]
"""Colour and style of the laws but the best."""


def charts(data: Sequence[CouponSeries], fits: Sequence[LawFit], best: LawFit) -> list[Chart]:
    """Make charts of nominal stress against stretch: readings, all laws, the best's 90 % interval.

    Args:
        data: readings of the coupons.
        fits: the fitted laws, the best one among them.
        best: the law that is drawn with its interval.

    Returns:
        A chart for each mode of tension.
    """
    reached = np.concatenate([[1.0], *(series.stretch for series in data)])
    stretch = np.linspace(reached.min(), reached.max(), 120)
    drawn = []
    for mode in MODES:
        measured = [series for series in data if series.mode == mode]
        middle, half = best.band(mode, stretch)
        others = [fit for fit in fits if fit is not best]
        series = [
            Series(fit.law.title, stretch, fit.band(mode, stretch)[0], style, colour=colour)  # type: ignore[arg-type]
            for fit, (colour, style) in zip(others, OTHERS * 9, strict=False)
        ]
        series.append(
            Series(f"{best.law.title}, 90 % interval", stretch, middle, low=middle - half,
                   high=middle + half, colour="blue")
        )  # fmt: skip
        series += [
            Series("" if i else "measured", test.stretch, test.stress_MPa, "points", colour="ink",
                   marker=".")
            for i, test in enumerate(measured)
        ]  # fmt: skip
        shown = np.concatenate([[0.0], middle, *(test.stress_MPa for test in measured)])
        ends = (1.08 if measured else BEYOND) * np.array([shown.min(), shown.max()])
        drawn.append(
            Chart(
                f"{mode}, {'measured' if measured else 'predicted'}",
                Axis("Stretch (–)", ends=(float(stretch[0]), float(stretch[-1]))),
                Axis("Nominal stress (MPa)", "MPa", ends=(float(ends[0]), float(ends[1]))),
                series,
            )
        )
    return drawn
