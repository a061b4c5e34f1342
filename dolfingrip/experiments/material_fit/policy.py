"""The numbers that decide how laws are fitted to coupons and doubted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class FitPolicy:
    """The numbers with which laws are fitted to coupons and fits are judged.

    Attributes:
        within: half width of a 90 % interval of a normal distribution, in standard deviations.
        tolerance: accuracy that is asked of a law, as a part of a reading's stress; it is added to
            the noise, so that small stresses weigh as much as large ones.
        loose: a prediction is not determined if its half width is a larger part of it than this.
        equal: fits whose relative scatter is larger than the smallest by no more than this part of
            it are as good.
        finest: fits whose relative scatter is below this are equally good, as no coupon is measured
            better.
        free: a value is called free if the half width of its interval is larger by this factor.
        middle_stretch: stretch at which other modes are predicted, if the coupons go so far.
        looked_at: stretch up to which instabilities and a balloon's limit points are sought; twice
            the largest measured stretch where coupons went further.
        log_step: step of these searches, in the logarithm of the stretch.
        widest_log_stretch: largest logarithm of a lateral stretch in the search.
        digits: number of digits of a value that is written; its interval is never so narrow.
    """

    within: float = 1.645
    tolerance: float = 0.02
    loose: float = 0.2
    equal: float = 0.1
    finest: float = 0.001
    free: float = 100.0
    middle_stretch: float = 1.5
    looked_at: float = 8.0
    log_step: float = 0.005
    widest_log_stretch: float = 3.0
    digits: int = 6


POLICY: Final = FitPolicy()
