"""One clock: the time of a log at each frame of a video, or row of another log.

A shift that is found by the motion contains the finger's own lag, so its error is as wide as such
lags are; a light or a knock that both show makes it narrow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.sections.errors import ConfigError

Floats = np.ndarray


@dataclass(frozen=True, slots=True)
class ClockPolicy:
    """How two clocks are brought together.

    Attributes:
        lag_s: standard deviation of a finger's own lag, with that of a camera's filter.
        least_share: part of the motion that the pressure has to explain.
        alike: two shifts explain the motion alike if the parts that they leave differ by less than
            this part of the motion.
        drift_s: a record that is longer is looked through for drift.
        overlap: least part of the video that the log has to cover.
    """

    lag_s: float = 0.3
    least_share: float = 0.6
    alike: float = 0.01
    drift_s: float = 120.0
    overlap: float = 0.6


POLICY: Final = ClockPolicy()


@dataclass(frozen=True, slots=True)
class Clock:
    """From a video's time to a log's: ``shift_s + rate × time``.

    Attributes:
        shift_s: time of the log at the first frame.
        rate: seconds of the log in a second of the video.
        std_s: standard deviation of the shift.
        by: what both show.
        doubt: a sentence; "" where there is none.
    """

    shift_s: float
    rate: float
    std_s: float
    by: str
    doubt: str = ""

    def of(self, time_s: Floats) -> Floats:
        """Times of the log at times of the video.

        Args:
            time_s: since the first frame.
        """
        return self.shift_s + self.rate * time_s


def by_motion(log_s: Floats, control: Floats, time_s: Floats, motion: Floats) -> Clock:
    """Find the shift by which a log's control explains a motion best.

    The motion is taken as a polynomial of the third degree of the control.

    Args:
        log_s: (n,) times of the log.
        control: (n,) its pressure.
        time_s: (m,) times of the frames.
        motion: (m,) of the finger, in any unit; NaN where it is not known.

    Raises:
        ConfigError: one line, where no shift explains the motion.
    """
    there = np.isfinite(motion)
    time_s, motion = time_s[there], motion[there]
    if len(time_s) < 10 or np.ptp(motion) == 0 or np.ptp(control) == 0:
        raise ConfigError(
            f"log: {len(time_s)} frames or rows show the finger, and the pressure "
            f"{'changes' if np.ptp(control) else 'does not change'}; allowed: records in which "
            "the finger moves, or --shift SECONDS"
        )
    shift, left, doubt = _best(log_s, control, time_s, motion)
    if 1 - left < POLICY.least_share:
        raise ConfigError(
            f"log: its pressure explains {100 * max(1 - left, 0):.0f} % of the motion at best; "
            f"allowed: a log of the same test ({100 * POLICY.least_share:.0f} %), or --shift"
        )
    rate, long = 1.0, float(np.ptp(time_s))
    if long > POLICY.drift_s:
        halves = np.array_split(np.arange(len(time_s)), 2)
        ends = [_best(log_s, control, time_s[half], motion[half])[0] for half in halves]
        middles = [float(time_s[half].mean()) for half in halves]
        rate = 1 + (ends[1] - ends[0]) / (middles[1] - middles[0])
        shift = ends[0] - (rate - 1) * middles[0]
    step = max(float(np.median(np.diff(log_s))), float(np.median(np.diff(time_s))))
    return Clock(shift, rate, float(np.hypot(POLICY.lag_s, step)), "the motion", doubt)


def _best(
    log_s: Floats, control: Floats, time_s: Floats, motion: Floats
) -> tuple[float, float, str]:
    """The shift, the part of the motion that is left, and a doubt where another is as good."""
    step = min(max(float(np.median(np.diff(log_s))), float(np.median(np.diff(time_s)))), 0.25)
    room = (1 - POLICY.overlap) * np.ptp(time_s)
    tried = np.arange(log_s[0] - time_s[0] - room, log_s[-1] - time_s[-1] + room + step, step)
    if not len(tried):
        return 0.0, 1.0, ""
    tried = tried[:: len(tried) // 20_000 + 1]
    left = np.array([_left(log_s, control, time_s, motion, shift) for shift in tried])
    best = int(left.argmin())
    fine = tried[best] + np.linspace(-step, step, 41)
    finest = np.array([_left(log_s, control, time_s, motion, shift) for shift in fine])
    shift, least = float(fine[finest.argmin()]), float(finest.min())
    inner = left[1:-1]
    lows = np.flatnonzero((inner <= left[:-2]) & (inner <= left[2:])) + 1
    others = [
        i
        for i in lows
        if abs(tried[i] - shift) > 3 * POLICY.lag_s and left[i] < least + POLICY.alike
    ]
    doubt = f"a shift of {tried[others[0]]:.2f} s explains the motion as well" if others else ""
    return shift, least, doubt


def _left(log_s: Floats, control: Floats, time_s: Floats, motion: Floats, shift: float) -> float:
    """Part of a motion's variance that a control leaves, at a shift.

    Outside the log the control is as at its end. Were frames there left out, a shift that leaves
    out the largest motions would explain what little the others move.
    """
    at = time_s + shift
    if ((at >= log_s[0]) & (at <= log_s[-1])).mean() < POLICY.overlap:
        return 1.0
    pressure = np.interp(at, log_s, control)
    table = np.vander((pressure - pressure.mean()) / (pressure.std() or 1.0), 4)
    residual = motion - table @ np.linalg.lstsq(table, motion, rcond=None)[0]
    return float(residual.var() / motion.var())


def by_events(
    log_events_s: Floats, events_s: Floats, log_step_s: float, step_s: float, by: str
) -> Clock:
    """Find the shift by events that both show, in their order.

    Args:
        log_events_s: (n,) times of the log.
        events_s: (m,) times of the video.
        log_step_s: time between two rows of the log.
        step_s: time between two frames.
        by: what the events are.

    Raises:
        ConfigError: one line, where numbers of events differ or there is none.
    """
    if not len(events_s) or len(events_s) != len(log_events_s):
        raise ConfigError(
            f"{by}: {len(events_s)} in the video and {len(log_events_s)} in the log; allowed: the "
            "same number of them, at least one"
        )
    shifts = log_events_s - events_s
    std = float(np.hypot(log_step_s, step_s) / np.sqrt(12 * len(shifts)))
    rate = 1.0
    if np.ptp(events_s) > POLICY.drift_s:
        rate = 1 + float(np.polyfit(events_s, shifts, 1)[0])
    return Clock(float(np.mean(log_events_s - rate * events_s)), rate, std, by)


def steps_up(time_s: Floats, values: Floats) -> Floats:
    """Times at which a signal rises through the middle of its range, as that of a light.

    Args:
        time_s: (n,).
        values: (n,).
    """
    low, high = np.nanpercentile(values, [2, 98])
    if high - low <= 0.2 * max(abs(high), 1e-9):
        low, high = np.nanmin(values), np.nanmax(values)
    above = values > (low + high) / 2
    rises = np.flatnonzero(above[1:] & ~above[:-1])
    # a light that goes on within an exposure makes that frame partly bright
    part = (values[rises + 1] - low) / max(high - low, 1e-9)
    partly = (rises + 2 < len(values)) & (part < 0.9)
    return np.where(partly, time_s[rises + 1], (time_s[rises] + time_s[rises + 1]) / 2)


def knock(time_s: Floats, values: Floats) -> Floats:
    """Time of the greatest jerk of a signal.

    Args:
        time_s: (n,).
        values: (n, m) signals that jump together.
    """
    jerk = np.nansum(np.abs(np.diff(values, 2, axis=0)), axis=1)
    return np.array([time_s[int(jerk.argmax()) + 1]])
