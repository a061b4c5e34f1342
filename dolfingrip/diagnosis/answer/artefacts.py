"""Artefacts of instruments: readings that jump and stay so, a travel that is periodically off.

A jump is what a clamp that slips leaves: from some row of a test on, a column or the control is off
by one number. A wave is the error of an uneven screw or of a gear: the control is off by a sine or
a cosine of itself. Neither is like any effect of the catalogue, which are smooth along a branch. So
they are looked for in what the hypotheses leave, and taken out as linear numbers of the rig where
the evidence asks for that. Without this a cause that acts beside a slip is not found.

The search is a matching pursuit (Mallat & Zhang, IEEE Trans. Signal Process. 41, 1993) whose steps
are weighed by evidence. For a column c and what a fit leaves, r, both whitened and after all that
the fit may follow,

    ln p(r | c) − ln p(r) = ½ (cᵀr)² / (1 + cᵀc) − ½ ln(1 + cᵀc)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core.evidence import LEVELS, taken
from dolfingrip.diagnosis.core.search import ModelPosterior
from dolfingrip.diagnosis.core.unknown import Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.policy import ADDITIONS, ARTEFACTS, POLICY


@dataclass(frozen=True, eq=False)
class Artefact:
    """What an instrument does beside measuring.

    Attributes:
        nuisance: its size, and what the readings change by it.
        told: a sentence with a place for its size.
        log_prior: ln of the odds that it is there, before the readings.
    """

    nuisance: Nuisance
    told: str
    log_prior: float = 0.0

    def sentence(self, sigmas: float) -> str:
        """Tell it with its size.

        Args:
            sigmas: its size by its standard deviation.
        """
        size = sigmas * self.nuisance.std
        return self.told.format(f"{size:+.2g} {self.nuisance.unknown.unit}")

    def wide(self) -> Artefact:
        """Return it with the wide part of its prior."""
        own, by = self.nuisance, POLICY.implausible_width
        prior = replace(own.unknown.prior, spread=by * own.std)
        return replace(self, nuisance=Nuisance(replace(own.unknown, prior=prior), by * own.change))


def artefacts(
    measurement: Measurement, errors: Errors, posterior: ModelPosterior
) -> list[Artefact]:
    """Find the artefacts with which the readings would be most probable.

    Beside each hypothesis they are added one after the other, each where it raises the evidence
    most. All else that the hypothesis fits is linear about its fit.

    Args:
        measurement: the readings.
        errors: of them.
        posterior: of all hypotheses without artefacts.

    Returns:
        Those that are more probable than not; none where there are none.
    """
    known = {each.name for each in errors.shared}
    tried = [*_jumps(measurement, errors), *_waves(measurement, errors)]
    found = [each for each in tried if each.nuisance.name not in known]
    if not found:
        return []
    # as all priors are, these are a mixture: nine parts are ordinary, one is four times as wide
    every = [*found, *(each.wide() for each in found)]
    same = np.tile(np.arange(len(found)), 2)
    shares = np.repeat([1 - POLICY.rare, POLICY.rare], len(found)) / len(found)
    log_prior = np.log(POLICY.implausible_odds * shares)
    problem = posterior.problem
    columns = np.column_stack([each.nuisance.change for each in every])
    white: dict[float, np.ndarray] = {}
    logs = [fit.log_evidence + float(np.log(LEVELS[fit.level])) for fit in posterior.fits]
    best, most = list[int](), max(logs)
    for fit, log in sorted(zip(posterior.fits, logs, strict=True), key=lambda each: -each[1]):
        if log + 0.5 * fit.misfit <= most:  # more than all that is missed cannot be gained
            continue
        model = problem.levels[fit.level]
        if fit.level not in white:
            white[fit.level] = model.whitened(columns)
        own, free = white[fit.level], model.whitened(problem.slopes(fit.subset, fit.zeta))
        rest = problem.value - problem.predicted(fit.subset, fit.zeta)
        off = model.whitened(rest) + free @ fit.zeta
        chosen: list[int] = []
        for _ in range(ARTEFACTS.most):
            beside = np.column_stack([free, own[:, chosen]])
            left = own - beside @ taken(own, beside)
            size = np.einsum("nk,nk->k", own, left)
            gain = 0.5 * (off @ left) ** 2 / (1 + size) - 0.5 * np.log1p(size) + log_prior
            gain[np.isin(same, same[chosen])] = -np.inf
            place = int(np.argmax(gain))
            if gain[place] <= ADDITIONS.tied:
                break
            chosen.append(place)
            log += float(gain[place])
        if log > most:
            best, most = chosen, log
    return [replace(every[place], log_prior=float(log_prior[place])) for place in best]


def _alike(measurement: Measurement) -> Iterator[tuple[str, list[SpecimenTest]]]:
    """Tests that one artefact may be of: one alone, or all of an experiment."""
    for test in measurement.tests:
        yield str(test), [test]
    for experiment in dict.fromkeys(test.experiment for test in measurement.tests):
        own = [test for test in measurement.tests if test.experiment == experiment]
        if len(own) > 1:
            yield f"{experiment} of all specimens", own


def _jumps(measurement: Measurement, errors: Errors) -> Iterator[Artefact]:
    """Jumps of columns and of the control, with two readings at least on either side.

    Those of all tests of an experiment are at the same place of the path.
    """
    listed, path = measurement.listed(), errors.along.path
    row, column, number = (listed[name].to_numpy() for name in ("row", "column", "test"))
    for who, tests in _alike(measurement):
        first, mine = tests[0], np.isin(number, [test.number for test in tests])
        unit = CHANNELS[CONTROL[first.experiment]].unit
        largest = float(np.abs(listed["control"][mine]).max())
        ways = [(first.control, unit, mine, largest, errors.steep)]
        for name in dict.fromkeys(map(str, column[mine])):
            at = mine & (column == name)
            size = float(errors.along.size[at].max())
            ways.append((name, CHANNELS[name].unit, at, size, np.ones(len(row))))
        for name, own_unit, at, size, by in ways:
            order = np.flatnonzero(at & (number == first.number))
            order = order[np.unique(row[order], return_index=True)[1]]
            for before, after in pairwise(order[1:-1]):
                start, end = (listed.iloc[place] for place in (before, after))
                if start["leg"] != end["leg"]:
                    continue  # where the way turns a reading may lag or rub
                where = (
                    f"between {start['control']:.4g} and {end['control']:.4g} {unit} in the "
                    f"{end['branch']} of cycle {end['cycle']}"
                )
                yield _artefact(
                    f"jump of {name} of {who} {where}", ARTEFACTS.jump * size, own_unit,
                    by * at * (path > 0.5 * (path[before] + path[after])),
                    f"{name} of {who} jumps by {{}} {where} and stays so, as where something slips",
                )  # fmt: skip


def _waves(measurement: Measurement, errors: Errors) -> Iterator[Artefact]:
    """Sines and cosines of the control, of which two periods at least are read often enough."""
    listed = measurement.listed()
    control, number = listed["control"].to_numpy(), listed["test"].to_numpy()
    for who, tests in _alike(measurement):
        name, mine = tests[0].control, np.isin(number, [test.number for test in tests])
        own = control[number == tests[0].number]
        unit, span = CHANNELS[CONTROL[tests[0].experiment]].unit, float(np.ptp(own))
        read = len(np.unique(np.round(own / max(span, 1e-9), 2)))
        most = min(read / ARTEFACTS.a_period, ARTEFACTS.periods)
        for count in np.arange(ARTEFACTS.fewest_periods, most, ARTEFACTS.period_step):
            phase = 2 * np.pi * count * control / span
            wave = f"of period {span / count:.3g} {unit}"
            for shape, change in (("sine", np.sin(phase)), ("cosine", np.cos(phase) - 1)):
                yield _artefact(
                    f"{shape} {wave} of {name} of {who}", ARTEFACTS.wave * span, unit,
                    errors.steep * mine * change,
                    f"{name} of {who} is off by {{}} times a {shape} {wave}, as of an uneven screw",
                )  # fmt: skip


def _artefact(key: str, std: float, unit: str, change: np.ndarray, told: str) -> Artefact:
    """One of a standard deviation in a unit, which changes the readings by ``change`` for each."""
    return Artefact(Nuisance(Unknown.marginal(key, std, unit), std * change), told)
