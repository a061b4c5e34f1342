"""The numbers that decide how laws are fitted to coupons and doubted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class FitPolicy:
    """How laws are fitted to coupons, and what is said of the fits.

    Attributes:
        within: standard deviations of a 90 % interval, normal.
        tolerance: part of a reading's stress that no law is asked to follow better; it goes beside
            the noise, so that small stresses weigh as much as large ones.
        loose: half width of a prediction, as a part of it, beyond which it is not fixed.
        free: a value is called free if the half width of its interval is larger by this factor.
        middle_stretch: stretch at which other modes are predicted, where the coupons go as far.
        widest_log_stretch: largest logarithm of a lateral stretch that is sought.
        digits: of a value that is written; its interval is never that narrow.
    """

    within: float = 1.645
    tolerance: float = 0.02
    loose: float = 0.2
    free: float = 100.0
    middle_stretch: float = 1.5
    widest_log_stretch: float = 3.0
    digits: int = 6


POLICY: Final = FitPolicy()
