"""The stops that a test asks for: the protocol in time, or one curve where history does not matter.

Branches of few rows are simulated at their rows, at round values where these were read with noise.
Of more rows some stops are made and the rows are interpolated. A wait has stops that grow sparser.
How many there are, :class:`~dolfingrip.diagnosis.policy.Policy` says. The control is taken as
one-directional within a ramp and constant within a wait, at the mean of what was read: the gauge's
own noise is no motion of the finger. Where a ramp begins behind the end of the one before, the way
back is led, too. A model with a memory but no clock settles: its third cycle is its second.

Stops are at round values on straight ramps: where the laboratory meant to stop, not where it read.
Two measurements with like controls then ask for the same simulations. A ramp at one rate takes
half the iterations of one that changes its rate at every stop, as the load path's prediction goes
on. Rows are read between the stops at the pressure that was read.

An interpolant has successive stops of one branch, and the rows that are read between them.

Readings at rows are weighted sums of those at stops, y_rows = W y_stops, by a cubic spline through
its stops in the control (in the logarithm of time where that rests). A row that is a stop has
that stop's reading itself. Beyond the ends a straight line goes on. W does not depend on what is
interpolated, so changes and derivatives are interpolated as the readings themselves are. A force
turns at once where a finger begins to touch; it is read from the stops at which it acts.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from dolfingrip.channels import DISPLACEMENT
from dolfingrip.diagnosis.data.motion import farthest, smallest_change
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.experiments.protocol import Stop
from dolfingrip.sections.procedure import Branch, branch_of


@dataclass(frozen=True, slots=True)
class StopInterpolant:
    """Stops and rows along one branch.

    Attributes:
        stops: places of the stops in the simulation's list.
        at: of each stop, what the leg is read by: pressure (kPa), travel (mm), or in a wait a
            logarithm of time.
        rows: places of the rows in ``Measurement.readings``.
        rows_at: of each row.
        policy: how far beyond the stops that were reached rows are read, and how many stops tell
            where a force begins.
    """

    stops: np.ndarray
    at: np.ndarray
    rows: np.ndarray
    rows_at: np.ndarray
    policy: Policy = Policy()

    def weights(
        self,
        reached: int,
        derivative: int = 0,
        force: np.ndarray | None = None,
    ) -> np.ndarray:
        """Weights (rows, stops) with the first ``reached`` stops of the simulation.

        Args:
            reached: number of stops that there are readings of; the rest have no weight.
            derivative: 1 for that by what the leg is read by.
            force: at these stops, where it is read, a change or a derivative of it, (reached,).

        Returns:
            NaN in the rows that cannot be read, as the simulation did not come so far.
        """
        where = self.rows_at
        there = np.flatnonzero(self.stops < reached)
        weights = np.zeros((len(where), len(self.stops)))
        if not there.size:
            weights[:] = np.nan
            return weights
        some = there if force is None else there[self._acts(force[self.stops[there]])]
        weights[:, some] = spline_weights(self.at[some], where, derivative)
        if force is not None and some.size < there.size:
            acting = force[self.stops[some]]
            interpolated = spline_weights(self.at[some], where, 0) @ acting
            weights[interpolated * acting.sum() < 0] = 0.0
        if there.size < len(self.stops):
            low, high = self.at[there].min(), self.at[there].max()
            margin = self.policy.alike * (high - low)
            weights[(where > high + margin) | (where < low - margin)] = np.nan
        return weights

    def _acts(self, force: np.ndarray) -> slice:
        """Stops at which a force acts, where it begins or ends to act between two of them.

        A curve through stops on either side of that place is off by 0.0037 N of 1.46 N on a finger
        that is 1.25 times as stiff as simulated, one through these by 0.0010 N.

        Args:
            force: at the leg's stops that were reached, shape (stops,).
        """
        some = np.flatnonzero(np.abs(force) > 1e-9 * np.abs(force).max(initial=0.0))
        if len(some) < self.policy.few:
            return slice(None)
        first, last = int(some[0]), int(some[-1]) + 1
        at, acting = self.at[first:last], force[first:last]

        def over(place: int, end: float) -> bool:
            """Tell if the force is over before a stop, beyond the one at which it is ``end``."""
            beyond = float(spline_weights(at, self.at[[place]], 0)[0] @ acting)
            return beyond / end < -0.1

        first = first if first and over(first - 1, acting[0]) else 0
        last = last if last < len(force) and over(last, acting[-1]) else len(force)
        return slice(first, last)


def spline_weights(at: np.ndarray, where: np.ndarray, derivative: int) -> np.ndarray:
    """Weights (where, at) of values by those at some places, or of a derivative.

    Args:
        at: places, shape (at,); of three the spline is a parabola.
        where: values are wanted, shape (where,); beyond the ends a straight line goes on.
        derivative: 0 or 1.
    """
    return _spline_weights(tuple(at.tolist()), tuple(where.tolist()), derivative)


@functools.lru_cache(maxsize=1000)  # of coupons the same rows are read for each of many numbers
def _spline_weights(at: tuple[float, ...], where: tuple[float, ...], derivative: int) -> np.ndarray:
    # of stops at one place, as between two cycles at rest, the last one counts
    places, last = np.unique(np.array(at)[::-1], return_index=True)
    unit = np.eye(len(at))[len(at) - 1 - last]
    if len(places) == 1:
        return np.repeat(unit * float(derivative == 0), len(where), axis=0)
    spline, inside = CubicSpline(places, unit), np.clip(where, places[0], places[-1])
    slopes = np.asarray(spline(inside, 1))
    if derivative:
        return slopes
    return np.asarray(spline(inside) + (where - inside)[:, None] * slopes)


@dataclass(frozen=True, slots=True)
class StopSchedule:
    """All stops of a simulation, in order, and its legs.

    Attributes:
        control: column of the control.
        time_s, value, cycle, branch: of each stop.
        legs: every measured row is on one of them.
        others: values of further controls at each stop, by column.
    """

    control: str
    time_s: tuple[float, ...]
    value: tuple[float, ...]
    cycle: tuple[int, ...]
    branch: tuple[str, ...]
    legs: tuple[StopInterpolant, ...]
    others: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def protocol(self) -> dict[str, object]:
        """The protocol's columns; :func:`protocol_file.key` tells where they belong."""
        return {
            **{name: list(values) for name, values in self.others.items()},
            "time_s": list(self.time_s),
            self.control: list(self.value),
            "cycle": list(self.cycle),
            "branch": list(self.branch),
        }

    def at_rows(
        self,
        values: np.ndarray,
        count: int,
        derivative: int = 0,
        force: np.ndarray | None = None,
    ) -> np.ndarray:
        """Readings at the measured rows from those at the stops, or their derivatives.

        Args:
            values: (…, reached) of one column, at the stops that were reached.
            count: number of rows of the measurement.
            derivative: 1 for that by the control; 0 where that rests.
            force: see :meth:`StopInterpolant.weights`.

        Returns:
            (…, count) NaN in rows that are not on this route or were not reached.
        """
        *several, reached = values.shape
        readings = np.full((*several, count), np.nan)
        padded = np.zeros((*several, len(self.value)))
        padded[..., :reached] = values
        for leg in self.legs:
            weights = leg.weights(reached, derivative, force)
            if derivative and self.branch[int(leg.stops[-1])] == "hold":
                weights = 0.0 * weights
            readings[..., leg.rows] = padded[..., leg.stops] @ weights.T
        return readings


@dataclass(frozen=True, slots=True)
class ControlSegment:
    """Successive rows of a test in one branch of one cycle.

    Attributes:
        cycle, branch: of all rows.
        rows: places in ``Measurement.readings``.
        time_s, value: of each row; time from the test's first row on where that is at rest. In a
            wait all values are their mean.
        size: largest value of the whole test.
        sigma: standard deviation of the gauge that reads the values.
        rounds_by: standard deviation within which stops are at round values: of pressures as told,
            or guessed where the rows are few. Else 0.
        jump: a change of the control that is none of the gauge's noise.
        leads_to: value of the wait that follows; NaN where none does.
        lead: column of the control whose values these are: of several the one that moves farthest.
        way: 1 where the value rises, -1 where it falls, as a load of suction does while it grows;
            0 where it waits.
        others: values of the other controls at each row, by column; those that rest are constant.
        policy: how many stops it has, and where.
    """

    cycle: int
    branch: Branch
    rows: np.ndarray
    time_s: np.ndarray
    value: np.ndarray
    size: float
    sigma: float
    rounds_by: float
    jump: float
    leads_to: float = math.nan
    lead: str = ""
    way: float = 0.0
    others: Mapping[str, np.ndarray] = field(default_factory=dict)
    policy: Policy = Policy()

    def led(self, stops: Sequence[Stop], before: Stop | None) -> Iterator[Stop]:
        """Stops of it with the values of all controls, straight in time from one row to the next.

        Args:
            stops: with the values of the one that leads.
            before: the stop before them; None at the start of a test.
        """
        start = [] if before is None else [before]
        time_s = [*(s.time_s for s in start), *self.time_s]
        for stop in stops:
            others = {
                name: float(
                    np.interp(stop.time_s, time_s, [*(s.others[name] for s in start), *values])
                )
                for name, values in self.others.items()
            }
            yield replace(stop, others={self.lead: stop.value, **others})

    @property
    def end(self) -> float:
        """Where it leads to."""
        if not math.isnan(self.leads_to):
            return self.leads_to
        return float(self.value.min() if self.way < 0 else self.value.max())


def segments(
    rows: pd.DataFrame, controls: Sequence[str], sigma: float, policy: Policy = Policy()
) -> list[ControlSegment]:
    """The segments of one test's rows, in order; ``sigma`` is the controls' gauge's."""
    values = rows[list(controls)].to_numpy().T
    time_s = rows["time_s"].to_numpy()
    cycle, branch = rows["cycle"].to_numpy(), rows["branch"].to_numpy()
    jumps = [smallest_change(value, sigma, policy) for value in values]
    guessed = sigma or policy.gauge * float(np.abs(values).max())
    few, many = (0.0, 0.0) if controls[0] == DISPLACEMENT.name else (guessed, sigma)
    if (np.abs(values[:, 0]) < jumps).all():  # at rest, so that the clock's start means nothing
        time_s = time_s - time_s[0]
    _, starts, leg = np.unique(rows["leg"], return_index=True, return_inverse=True)
    pieces: list[ControlSegment] = []
    places = np.split(np.arange(len(rows)), starts[1:])
    for part, lead in zip(places, farthest(values, leg), strict=True):
        value, jump, start = values[lead], jumps[lead], part[0]
        led, size = value[part], max(float(np.abs(value).max()), 1e-12)
        others = {
            name: _settled_at(beside[part], least)
            for name, beside, least in zip(controls, values, jumps, strict=True)
            if name != controls[lead]
        }
        rounds_by = few if len(part) <= policy.most_stops else many  # whose stops are means
        if branch[start] == "hold":
            # where the ramp before it led to was read once more, as its last row
            read_before = start and abs(value[start - 1] - led.mean()) <= jump
            before = value[start - 1 : start] if read_before else led[:0]
            mean = float(np.concatenate([before, led]).mean())
            within = rounds_by / math.sqrt(len(part))
            meant = meant_end(mean, size / policy.most_stops, within, policy)
            led = np.full(len(part), meant)
            if before.size and pieces[-1].branch != "hold" and pieces[-1].lead == controls[lead]:
                pieces[-1] = replace(pieces[-1], leads_to=meant)
        side = led[-1] if branch[start] == "loading" else value[max(start - 1, 0)]
        away = {"loading": 1.0, "unloading": -1.0}.get(branch[start], 0.0)
        pieces.append(
            ControlSegment(
                int(cycle[start]), branch[start], rows.index.to_numpy()[part], time_s[part], led,
                size, sigma, rounds_by, jump, lead=controls[lead],
                way=-away if side < -jump else away, others=others, policy=policy,
            )
        )  # fmt: skip
    return pieces


def _settled_at(value: np.ndarray, jump: float) -> np.ndarray:
    """Values along a leg; their mean where both halves tell that they rest."""
    half = (len(value) + 1) // 2
    rests = abs(value[-half:].mean() - value[:half].mean()) < jump / 2
    return np.full(len(value), value.mean()) if rests else value


def alike(first: Sequence[ControlSegment], second: Sequence[ControlSegment]) -> bool:
    """Tell whether two tests went the same way, so that one simulation serves both."""
    off = first[0].policy.alike * max(abs(s.end) for s in first)
    return _as_far(first, second, off) and all(
        a.cycle == b.cycle
        and abs(np.ptp(a.time_s) - np.ptp(b.time_s)) <= 0.1 * np.ptp(a.time_s) + 0.5
        for a, b in zip(first, second, strict=True)
    )


def elastic(tests: Sequence[Sequence[ControlSegment]], control: str) -> StopSchedule:
    """One curve from rest to the largest value, from which all rows of ``tests`` are read.

    For models without memory and clock.
    """
    every = [segment for test in tests for segment in test]
    values = np.concatenate([segment.value for segment in every])
    low, high = min(0.0, float(values.min())), float(values.max())
    longest = max(every, key=lambda segment: len(segment.rows))
    policy = longest.policy
    least = max(policy.gauge * (high - low), policy.certain * longest.sigma)
    at = _rising([low, *np.sort(values), high], least)
    if len(at) <= policy.most_stops:
        at = np.unique(meant_places(at, longest.rounds_by, policy))
    else:
        last = meant_end(high, (high - low) / policy.most_stops, longest.rounds_by, policy)
        at = np.linspace(low, last, policy.most_stops)
    rows = np.concatenate([segment.rows for segment in every])
    leg = StopInterpolant(np.arange(len(at)), at, rows, values, policy)
    time_s = np.cumsum(np.abs(np.diff(at, prepend=at[0])))  # which nothing feels
    count = len(at)
    return StopSchedule(
        control, tuple(time_s), tuple(at), (1,) * count, ("loading",) * count, (leg,)
    )


def in_time(
    tests: Sequence[Sequence[ControlSegment]], control: str, *, settles: bool = False
) -> StopSchedule:
    """The way that the tests went, in time; all have to be alike.

    The test with most rows says where the stops are.

    Args:
        tests: segments of each.
        control: column of the experiment's control; others are supplies of single cavities.
        settles: whether a cycle that goes as far as those before it is like the one before: that of
            a model with a memory but no clock. It is read from that one then.
    """
    longest = max(tests, key=lambda test: sum(len(segment.rows) for segment in test))
    again = _settled(longest) if settles and not longest[0].others else {}
    stops: list[Stop] = []
    legs: list[StopInterpolant] = []
    for i, segment in enumerate(longest):
        same = [test[i] for test in tests]
        waits = segment.branch == "hold"
        if i in again:
            places = legs[again[i]].stops
        else:
            last = stops[-1] if stops else None
            before = last and replace(last, value=last.others[segment.lead])
            back = _back(segment, before)
            before = back[-1] if back else before
            first = len(stops) + len(back)
            new = _wait(segment, before) if waits else _ramp(segment, before)
            stops += segment.led([*back, *new], last)
            if before is not None and (not waits or before.value == stops[-1].value):
                first -= 1  # the leg begins where the one before it ends
            places = np.arange(first, len(stops))
        on_leg = [stops[place] for place in places]
        if waits:
            start_s = longest[again.get(i, i)].time_s[0]
            moments_s = [part.time_s - part.time_s[0] + start_s for part in same]
            stops_s = np.array([stop.time_s for stop in on_leg])
            rows_at, at = _faded(np.concatenate(moments_s), stops_s), _faded(stops_s, stops_s)
        else:
            rows_at = np.concatenate([part.value for part in same])
            at = np.array([stop.others[segment.lead] for stop in on_leg])
        rows = np.concatenate([part.rows for part in same])
        legs.append(StopInterpolant(places, at, rows, rows_at, segment.policy))
    return _scheduled(stops, legs, control)


def moment_by_moment(tests: Sequence[Sequence[ControlSegment]], control: str) -> StopSchedule:
    """Each row of the test with most rows as a stop, so that motion is read by its time alone.

    For fingers with inertia or a supply of air, which move while the control rests.

    Args:
        tests: segments of each; all have to be alike.
        control: column of the experiment's control; others are supplies of single cavities.
    """
    longest = max(tests, key=lambda test: sum(len(segment.rows) for segment in test))
    stops: list[Stop] = []
    for segment in longest:
        after_s = stops[-1].time_s if stops else -math.inf
        new = [
            Stop(float(value), float(time_s), segment.branch, segment.cycle)
            for time_s, value in zip(segment.time_s, segment.value, strict=True)
            if time_s > after_s
        ]
        stops += segment.led(new, stops[-1] if stops else None)
    parts = [segment for test in tests for segment in test]
    rows_at = np.concatenate([segment.time_s for segment in parts])
    rows = np.concatenate([segment.rows for segment in parts])
    stops_s = np.array([stop.time_s for stop in stops])
    leg = StopInterpolant(np.arange(len(stops)), stops_s, rows, rows_at, longest[0].policy)
    return _scheduled(stops, [leg], control)


def _scheduled(
    stops: Sequence[Stop], legs: Sequence[StopInterpolant], control: str
) -> StopSchedule:
    """The schedule of stops that tell the values of all controls."""
    beside = sorted({*stops[0].others} - {control})
    value, *others = (tuple(stop.others[name] for stop in stops) for name in (control, *beside))
    return StopSchedule(
        control, tuple(stop.time_s for stop in stops), value,
        tuple(stop.cycle for stop in stops), tuple(stop.branch for stop in stops), tuple(legs),
        dict(zip(beside, others, strict=True)),
    )  # fmt: skip


def _settled(segments: Sequence[ControlSegment]) -> dict[int, int]:
    """Segments of cycles that go as the one before them did, where that was not the first so far.

    Returns:
        the place of the segment that it is like, by that of each.
    """
    cycle = [segment.cycle for segment in segments]
    cycles = [[*places] for _, places in groupby(range(len(segments)), cycle.__getitem__)]
    off = segments[0].policy.alike * max(abs(segment.end) for segment in segments)
    like: dict[int, int] = {}
    for before, now in pairwise(cycles[1:]):
        ends = [segment.end for segment in segments[: before[0]]]
        once, again = ([segments[place] for place in places] for places in (before, now))
        reached = all(min(ends) - off <= s.end <= max(ends) + off for s in once)
        starts = abs(once[0].value[0] - again[0].value[0]) <= off
        if reached and starts and _as_far(once, again, off):
            like |= dict(zip(now, before, strict=True))
    return like


def _as_far(first: Sequence[ControlSegment], second: Sequence[ControlSegment], off: float) -> bool:
    """Tell whether the same branches lead to the same ends, but for ``off``."""
    ways = ([(s.branch, s.lead) for s in part] for part in (first, second))
    return next(ways) == next(ways) and all(
        abs(a.end - b.end) <= off
        and all(abs(values[-1] - b.others[name][-1]) <= off for name, values in a.others.items())
        for a, b in zip(first, second, strict=True)
    )


def _faded(time_s: np.ndarray, stops_s: np.ndarray) -> np.ndarray:
    """Return the logarithm of a wait's time, in which its stops are evenly spread."""
    first_s = float(stops_s[1] - stops_s[0]) if len(stops_s) > 1 else 1.0
    return np.log1p(np.maximum(time_s - stops_s[0], 0.0) / first_s)


def _back(segment: ControlSegment, before: Stop | None) -> list[Stop]:
    """The way back from the stop before to where a ramp begins, if nothing was read along it."""
    way, apart = segment.way, segment.size / segment.policy.most_stops
    start = meant_end(float(segment.value[0]), apart, segment.rounds_by, segment.policy)
    if before is None or way * (start - before.value) >= -segment.jump:
        return []
    time_s = max(float(segment.time_s[0]), before.time_s + 1e-6)
    return [Stop(start, time_s, branch_of(before.value, start), segment.cycle)]


def _ramp(segment: ControlSegment, before: Stop | None) -> list[Stop]:
    """Stops of a ramp."""
    way, closest = segment.way, segment.policy.gauge * segment.size
    time_s, value = segment.time_s, segment.value
    most = segment.policy.most_stops
    if segment.sigma:  # fewer where its rows lie within the gauge's noise
        told_apart = int(np.ptp(value) / (segment.policy.certain * segment.sigma))
        most = min(most, max(segment.policy.few, told_apart))
    if len(value) > most:
        edges = np.linspace(0, len(value), most + 1).astype(int)
        parts = [slice(a, b) for a, b in pairwise(edges)]
        value = np.array([value[part].mean() for part in parts])
        time_s = np.array([time_s[part].mean() for part in parts])
        value = np.append(value, value[-1] + (value[-1] - value[-2]) / 2)
        time_s = np.append(time_s, segment.time_s[-1])
        if before is None:
            value, time_s = np.append(segment.value[0], value), np.append(segment.time_s[0], time_s)
    if not math.isnan(segment.leads_to):
        there = way * value < way * segment.leads_to - closest
        value = np.append(value[there], segment.leads_to)
        time_s = np.append(time_s[there], segment.time_s[-1])
    went = [(before.time_s, before.value) if before else (0.0, -np.inf * way)]
    for moment, here in zip(time_s, value, strict=True):
        last_s, last = went[-1]
        if way * (here - last) > closest:
            went.append((max(float(moment), last_s), float(here)))
    if len(went) == 1:  # a ramp that does not move
        went.append((max(float(time_s[-1]), went[0][0]), went[0][1]))
    time_s, value = np.array(went if before else went[1:]).T
    if segment.rounds_by and np.ptp(value):
        time_s, value = _meant_ramp(time_s, value, segment, goes_on=before is not None)
    stops = [
        Stop(float(here), float(moment), segment.branch, segment.cycle)
        for moment, here in zip(time_s, value, strict=True)
    ]
    return stops[1:] if before else stops


def _wait(segment: ControlSegment, before: Stop | None) -> list[Stop]:
    """Stops of a wait, at the value that came before where that is the same."""
    value = segment.end
    if before is not None and abs(value - before.value) <= segment.jump:
        value = before.value
    last_s = before.time_s if before else 0.0
    start_s, end_s = float(segment.time_s[0]), float(segment.time_s[-1])
    most = 2 * segment.policy.few
    if len(segment.rows) <= most or end_s == start_s:
        moments = [float(moment) for moment in segment.time_s]
    else:
        since = last_s if before is not None and value == before.value else start_s
        delays = segment.time_s - since
        spread = np.geomspace(delays[delays > 0].min(), end_s - since, most)
        moments = [*([start_s] if start_s == since else []), *(since + spread)]
    later = [at_s for at_s in map(float, np.unique(moments)) if not before or at_s > last_s]
    return [Stop(value, at_s, "hold", segment.cycle) for at_s in later or [last_s + 1e-6]]


def _rising(values: Sequence[float], least: float) -> np.ndarray:
    """Values that rise by more than ``least`` from one to the next; the ends stay."""
    rising = [values[0]]
    for value in values[1:]:
        if value > rising[-1] + least:
            rising.append(value)
    if values[-1] > rising[-1]:
        rising[-1] = values[-1]
    return np.array(rising, dtype=float)


def meant_end(value: float, distance: float, sigma: float, policy: Policy = Policy()) -> float:
    """The round value near a stop if the gauge's noise allows, else as it was read.

    Round are multiples of the largest round number times a power of ten up to a part of a distance.
    """
    if not (sigma and distance > 0):
        return value
    most = distance / policy.fineness
    power = 10.0 ** math.floor(math.log10(most) + 1e-9)
    unit = power * max(step for step in policy.steps if step * power <= most * (1 + 1e-9))
    meant = float(f"{round(value / unit) * unit:.9g}")
    return meant if abs(meant - value) <= policy.certain * sigma else value


def meant_places(read: np.ndarray, sigma: float, policy: Policy = Policy()) -> np.ndarray:
    """Round values of successive places, (n,), of those for which the gauge's noise allows it."""
    distance = abs(float(read[-1] - read[0])) / max(len(read) - 1, 1)
    return np.array([meant_end(float(value), distance, sigma, policy) for value in read])


def _meant_ramp(
    time_s: np.ndarray, read: np.ndarray, segment: ControlSegment, *, goes_on: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Times and round values of the stops of a ramp, at one rate where its rows allow.

    Args:
        time_s: of the stops.
        read: values there, which rise or fall.
        segment: the ramp.
        goes_on: whether the first of them is the last stop before the ramp, which stays.
    """
    sigma, policy = segment.rounds_by, segment.policy
    meant = meant_places(read, sigma, policy)
    if not math.isnan(segment.leads_to):
        meant[-1] = segment.leads_to
    if goes_on:
        meant[0] = read[0]
    span = float(meant[-1] - meant[0]) or 1.0
    whole_s = float(time_s[-1] - time_s[0])
    # the time at which the gauge reads an end is as uncertain as its reading there
    sigma_s = sigma * whole_s / abs(float(read[-1] - read[0]))
    lasts_s = meant_end(whole_s, whole_s / (len(read) - 1), sigma_s, policy)
    part = (meant - meant[0]) / span
    line_s = time_s[0] + lasts_s * np.clip(part, 0.0, 1.0)
    if np.abs(line_s - time_s).max() <= 0.1 * whole_s:
        time_s = line_s
    at, places = np.unique(part, return_index=True)
    inner = places[(at > policy.gauge) & (at < 1 - policy.gauge)]
    kept = [0, *inner, len(meant) - 1]
    return np.array([float(f"{moment:.9g}") for moment in time_s[kept]]), meant[kept]
