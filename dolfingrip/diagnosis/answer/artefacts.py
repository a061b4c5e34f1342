"""Artefacts of instruments: jumps that stay, plays and waves of what they show.

An artefact is a jump that stays, as where a clamp slips: from some row of a test on, a column or
the control is off by one number. Or it is a wave, as of an uneven screw: the control is off by a
sine or a cosine of itself. Neither is like any effect of the catalogue, which are smooth along a
branch. Those that the evidence asks for are numbers of the rig. Without this a cause that acts
beside a slip is not found.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pandas as pd

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.answer.discrepancy import Along
from dolfingrip.diagnosis.core.unknown import Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import Policy


@dataclass(frozen=True, eq=False)
class Artefact:
    """An artefact of an instrument: a jump, a play or a wave of what it shows.

    Attributes:
        nuisance: its size, and what the readings change by it.
        kind: of which at most one acts: a jump at a place, a play, a screw's sine or cosine.
        log_prior: ln of the odds that it is there.
    """

    nuisance: Nuisance
    kind: str
    log_prior: float = 0.0


def possible_artefacts(
    measurement: Measurement, along: Along, steep: np.ndarray, have: Collection[str]
) -> list[Artefact]:
    """List what may be wrong with the instruments.

    Args:
        measurement: the readings.
        along: where they lie.
        steep: their derivatives by the control, shape (n,).
        have: kinds that were found already, which are left out: waves beside a wave, too.
    """
    listed, policy = measurement.listed, measurement.policy
    shown = [*_shown(measurement, along, steep)]
    every = [
        *_jumps(listed, along.path, shown), *_waves(listed, shown, policy),
        *filter(_either_way, _plays(listed, shown, policy)),
    ]  # fmt: skip
    new = [artefact for artefact in every if artefact.kind not in have]
    log_prior = float(np.log(policy.rare / max(len(new), 1)))
    return [replace(artefact, log_prior=log_prior) for artefact in new]


def plays(measurement: Measurement, along: Along, steep: np.ndarray) -> Iterator[Artefact]:
    """List lags behind either way by as much, as of a gauge with a play.

    Args:
        measurement: the readings.
        along: where they lie.
        steep: their derivatives by the control, shape (n,).
    """
    shown = [*_shown(measurement, along, steep)]
    return _plays(measurement.listed, shown, measurement.policy)


@dataclass(frozen=True, eq=False, slots=True)
class _Shown:
    """A column or the control of some tests, as an instrument shows it.

    Attributes:
        name: of it and of the tests.
        unit: of it.
        control_unit: of the control.
        tests: these.
        at: (n,) which readings are off where it is off.
        by: (n,) how much by each unit.
        size: its ordinary size.
        controls: whether it is the control.
    """

    name: str
    unit: str
    control_unit: str
    tests: Sequence[SpecimenTest]
    at: np.ndarray
    by: np.ndarray
    size: float
    controls: bool


def _shown(measurement: Measurement, along: Along, steep: np.ndarray) -> Iterator[_Shown]:
    """All columns and controls, of each test and of all of an experiment."""
    listed = measurement.listed
    column, number = listed["column"].to_numpy(), listed["test"].to_numpy()
    for who, tests in _together(measurement.tests):
        first, mine = tests[0], np.isin(number, [test.number for test in tests])
        unit = CHANNELS[first.prescribed].unit
        size, by = float(np.abs(listed["control"][mine]).max()), steep
        yield _Shown(f"{first.control} of {who}", unit, unit, tests, mine, by, size, True)
        for name in dict.fromkeys(map(str, column[mine])):
            at, own_unit = mine & (column == name), CHANNELS[name].unit
            size, by = float(along.size[at].max()), np.ones(len(listed))
            yield _Shown(f"{name} of {who}", own_unit, unit, tests, at, by, size, False)


def _together(tests: Sequence[SpecimenTest]) -> Iterator[tuple[str, Sequence[SpecimenTest]]]:
    """Each test alone, and all of an experiment, and what they are called."""
    for test in tests:
        yield str(test), [test]
    for experiment in dict.fromkeys(test.experiment for test in tests):
        group = [test for test in tests if test.experiment == experiment]
        if len(group) > 1:
            yield f"all specimens ({experiment})", group


def _jumps(listed: pd.DataFrame, path: np.ndarray, every: Sequence[_Shown]) -> Iterator[Artefact]:
    """Jumps with two readings at least on either side.

    Those of all tests of an experiment are at the same place of the path.
    """
    row, number = listed["row"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        order = np.flatnonzero(shown.at & (number == shown.tests[0].number))
        order = order[np.unique(row[order], return_index=True)[1]]
        for before, after in pairwise(order[1:-1]):
            start, end = (listed.iloc[place] for place in (before, after))
            if start["leg"] != end["leg"]:
                continue  # where the way turns a reading may lag or rub
            where = (
                f"between {start['control']:.4g} and {end['control']:.4g} {shown.control_unit} "
                f"in the {end['branch']} of cycle {end['cycle']}"
            )
            yield _artefact(
                f"jump of {shown.name} {where}", 0.1 * shown.size, shown.unit,
                shown.by * shown.at * (path > 0.5 * (path[before] + path[after])),
            )  # fmt: skip


def _plays(listed: pd.DataFrame, every: Sequence[_Shown], policy: Policy) -> Iterator[Artefact]:
    """Lags behind either way by as much, as of a gauge with a play.

    What rubs turns within a part of the range (Dahl, AIAA Journal 14, 1976).
    """
    row, number = listed["row"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        for length in policy.turns:
            behind = np.zeros(len(listed))
            for test in shown.tests:
                mine = number == test.number
                _, first, back = np.unique(row[mine], return_index=True, return_inverse=True)
                control = listed["control"].to_numpy()[mine][first]
                steps = np.diff(control, prepend=0.0) / max(np.ptp(control), 1e-9)
                behind[mine] = np.fromiter(_behind(steps, length), float)[back]
            if behind.any():
                yield _artefact(
                    f"play of {shown.name}, within {length:g} of the range",
                    policy.play * shown.size, shown.unit, shown.by * shown.at * behind,
                    f"play of {shown.name}",
                )  # fmt: skip


def _either_way(play: Artefact) -> bool:
    """Tell if readings are off to either side; else much has the shape of a play."""
    change = play.nuisance.change
    return bool(change.min() < 0 < change.max())


def _behind(steps: np.ndarray, length: float) -> Iterator[float]:
    """How far what rubs is behind after each step, from −1 on the way down to 1."""
    at = 0.0
    for step in steps:
        at = float(np.sign(step) + (at - np.sign(step)) * np.exp(-abs(step) / length))
        yield at


def _waves(listed: pd.DataFrame, every: Sequence[_Shown], policy: Policy) -> Iterator[Artefact]:
    """Sines and cosines of controls, of which enough periods are read often enough."""
    control, number = listed["control"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        if not shown.controls:
            continue
        values = control[number == shown.tests[0].number]
        span = float(np.ptp(values))
        read = len(np.unique(np.round(values / max(span, 1e-9), 2)))
        most = min(read / policy.few, policy.dense)
        for count in np.arange(policy.fewest_periods, most, 0.1):
            phase = 2 * np.pi * count * control / span
            wave = f"of period {span / count:.3g} {shown.unit}"
            for shape, change in (("sine", np.sin(phase)), ("cosine", np.cos(phase) - 1)):
                yield _artefact(
                    f"{shape} {wave} of {shown.name}", 0.01 * span, shown.unit,
                    shown.by * shown.at * change,
                    shape,
                )  # fmt: skip


def _artefact(key: str, std: float, unit: str, change: np.ndarray, kind: str = "") -> Artefact:
    """One of a standard deviation in a unit, which changes the readings by ``change`` for each.

    Its kind is its key where no other is told.
    """
    nuisance = Nuisance(Unknown.marginal(key, std, unit), std * change)
    return Artefact(nuisance, kind or key)
