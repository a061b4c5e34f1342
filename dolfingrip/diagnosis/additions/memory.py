"""Whether readings show what a material or a joint remembers: unloading, waits, another rate."""

from __future__ import annotations

from typing import Final

from dolfingrip.diagnosis.data.measurement import Measurement

OTHER_RATE: Final = 2.0
"""Ratio of two rates from which on they are different ones."""


def shows(known: Measurement, added: Measurement) -> bool:
    """Whether readings of the same experiments show memory, those that are added among them.

    They do where something is unloaded or waits, or is loaded at two rates.
    """
    rates: dict[str, list[float]] = {}
    for measurement in (known, added):
        for test in measurement.tests:
            rows = measurement.rows(test.number)
            if (rows["branch"] != "loading").any():
                return True
            rate = measurement.ramp_rate(test)
            if rate is not None:
                rates.setdefault(test.experiment, []).append(rate)
    return any(max(own) > OTHER_RATE * min(own) for own in rates.values())
