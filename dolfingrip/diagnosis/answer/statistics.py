"""Statistics of a diagnosis: fitted numbers and their intervals, misfits, what causes change."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from dolfingrip.channels import ANGLE, CHANNELS, FORCE, Channel
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.data.motion import smallest_change
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.policy import PAGE, POLICY
from dolfingrip.diagnosis.simulation.nuisances import UNITS
from dolfingrip.diagnosis.simulation.unknowns import told_as
from dolfingrip.files.diagnosis import (
    BandMisfit,
    ChannelMisfit,
    CommonChange,
    FittedNumber,
    RigNumber,
)
from dolfingrip.parameter import find, named
from dolfingrip.parameter.nuisances import WALL, modulus_keys
from dolfingrip.sections.units import unit

# -- numbers ---------------------------------------------------------------------------------------


def fitted_numbers(analysis: Analysis[Any], fit: MapFit) -> list[FittedNumber]:
    """List the numbers of a fit by key: moduli, walls, rig and body, then those of its causes.

    Args:
        analysis: readings with all that could explain them.
        fit: a hypothesis.
    """
    draws, weights = fit.draws or _by_hessian(fit)
    model, problem = analysis.applied, analysis.problem
    middle = np.where(np.arange(len(fit.zeta)) < problem.nuisance_count, 0.0, fit.zeta)
    places = np.vstack([middle, fit.zeta, draws])
    factor = problem.factor.at(places[:, 0])
    values = [
        (modulus.key, "material", modulus.value(model) * factor)
        for modulus in find(model, modulus_keys(model))
    ]
    always = [
        (_part(told_as(number)), number, place)
        for place, number in enumerate(problem.always[1:], 1)
    ]
    of_causes = [(cause.name, number, place) for cause, number, place in analysis.numbers(fit)]
    for part, number, place in [*always, *of_causes]:
        scale = factor if number.modulus else 1.0
        values.append((number.key, part, number.at(places[:, place]) * scale))
    return [_estimated(key, part, value, weights, analysis.causes) for key, part, value in values]


def _part(name: str) -> str:
    """The part that a number is of, by what a laboratory tells it as."""
    return "walls" if name == WALL else "body" if "." in name else "rig"


def _by_hessian(fit: MapFit) -> tuple[np.ndarray, np.ndarray]:
    """Draws from the normal distribution about the most probable numbers."""
    rng = np.random.default_rng(0)
    lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
    draws = fit.zeta + rng.standard_normal((POLICY.draws, len(fit.zeta))) @ lower.T
    return draws, np.full(POLICY.draws, 1 / POLICY.draws)


def _estimated(
    key: str, part: str, values: np.ndarray, weights: np.ndarray, causes: Collection[str]
) -> FittedNumber:
    """A number and its interval.

    Args:
        key: of the number.
        part: what it is of.
        values: as configured, as fitted, and draws, shape (2 + draws,).
        weights: of the draws, shape (draws,).
        causes: whose numbers have no configured value.
    """
    configured, value, draws = float(values[0]), float(values[1]), values[2:]
    tail = (1 - POLICY.interval) / 2
    ends = np.quantile(draws, [tail, 1 - tail - 1e-9], weights=weights, method="inverted_cdf")
    low, high = map(float, ends)
    return FittedNumber(
        key=key, value=value, low=min(low, value), high=max(high, value), unit=unit(key),
        configured=None if part in causes else configured, part=part,
    )  # fmt: skip


def rig_numbers(
    analysis: Analysis[Any], fit: MapFit, deviations: dict[str, float]
) -> list[RigNumber]:
    """List numbers of rig and body that the laboratory told, but those known exactly.

    Args:
        analysis: readings with all that could explain them.
        fit: a hypothesis.
        deviations: of the numbers, by their standard deviations, by name.
    """
    problem, errors = analysis.problem, analysis.errors
    artefacts = {artefact.nuisance.name for artefact in errors.artefacts}
    changes = [
        (shared.unknown, deviations[shared.name] * shared.change)
        for shared in errors.shared
        if shared.std
        and not shared.name.startswith("specimen_scale")
        and shared.name not in artefacts
    ]
    here = problem.predicted(fit.subset, fit.zeta)
    for place, number in enumerate(problem.always):
        if place and told_as(number) != WALL:
            as_told = np.where(np.arange(len(fit.zeta)) == place, 0.0, fit.zeta)
            changes.append((number, here - problem.predicted(fit.subset, as_told)))
    listed = []
    for number, change in changes:
        name = told_as(number)
        text = number.unit or UNITS.get(name) or (named(name).unit if "." in name else "")
        # a number of the configuration is absolute, all others without a unit are relative
        size, text = (1.0, text) if text or "." in name else (100.0, "%")
        std = size * number.prior.spread
        seen = np.linalg.norm(change / errors.noise) >= POLICY.visible_sigma
        listed.append(
            RigNumber(
                name=name, unit=text, prior_std=std, value=deviations[name] * std,
                share=_share(analysis, change) if seen else 0.0,
            )
        )  # fmt: skip
    return listed


def _share(analysis: Analysis[Any], change: np.ndarray) -> float:
    """A change of the readings, (n,), by what the model as configured misses, both rms."""
    off = analysis.problem.value - analysis.configured
    reached = np.isfinite(off)
    missed = float(np.linalg.norm(off[reached]))
    return float(np.linalg.norm(change[reached])) / missed if missed else 0.0


# -- readings --------------------------------------------------------------------------------------


def misfit(
    analysis: Analysis[Any], plain: np.ndarray, extended: np.ndarray
) -> tuple[ChannelMisfit, ...]:
    """Compare simulated with measured readings by channel.

    Args:
        analysis: readings with all that could explain them.
        plain: (n,) readings of the model without causes, its numbers fitted.
        extended: (n,) readings of the model with the causes that are named.
    """
    value, errors = analysis.problem.value, analysis.mesh_errors
    rows = []
    for name, at in analysis.measurement.channels().items():
        configured, fitted, with_cause = (
            _rms((simulated - value)[at]) for simulated in (analysis.configured, plain, extended)
        )
        noise, mesh = float(np.median(analysis.errors.noise[at])), errors.get(name)
        rows.append(
            ChannelMisfit(
                channel=name, unit=CHANNELS[name].unit, configured=configured, fitted=fitted,
                extended=with_cause, noise=noise, mesh=mesh,
                undecided=mesh is not None and mesh > max(POLICY.mesh_decides * configured, noise),
            )
        )  # fmt: skip
    return tuple(rows)


def _rms(values: np.ndarray) -> float:
    """Return the root mean square of those readings that the model reaches."""
    reached = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(reached**2))) if reached.size else 0.0


@dataclass(frozen=True, eq=False, slots=True)
class _Band:
    """Readings of a channel in a band of load.

    Attributes:
        experiment: of the readings.
        channel: that is read.
        start, end: of the band, in the control's unit, with its sign.
        last: whether the band ends at the largest load.
        control: what the load is.
        at: (n,) which readings.
    """

    experiment: str
    channel: Channel
    start: float
    end: float
    last: bool
    control: Channel
    at: np.ndarray


def _bands(analysis: Analysis[Any]) -> Iterator[_Band]:
    """Iterate over the bands of load that have readings; suction has bands of its own."""
    along, listed = analysis.errors.along, analysis.measurement.listed
    experiment, control = listed["experiment"].to_numpy(), listed["control"].to_numpy()
    for name_of, (name, read) in product(
        dict.fromkeys(experiment), analysis.measurement.channels().items()
    ):
        here = read & (experiment == name_of)
        if not here.any():
            continue
        largest = max(float(np.abs(control[here]).max()), 1e-12)
        at_rest = smallest_change(control[here], 0.0) / largest
        for band, way in product(range(int(1 / PAGE.band)), (1.0, -1.0)):
            low, high = band * PAGE.band, (band + 1) * PAGE.band
            load = way * along.load
            at = here & (load > (low if way > 0 else max(low, at_rest))) & (load <= high)
            if at.any():
                yield _Band(
                    name_of, CHANNELS[name], way * low * largest, way * high * largest,
                    way > 0 and high >= 1, CHANNELS[CONTROL[name_of]], at,
                )  # fmt: skip


def bands(analysis: Analysis[Any], plain: np.ndarray) -> tuple[BandMisfit, ...]:
    """Tell where along the load a model is off.

    Args:
        analysis: readings with all that could explain them.
        plain: (n,) readings of the model.
    """
    value, off = analysis.problem.value, plain - analysis.problem.value
    return tuple(
        BandMisfit(
            experiment=band.experiment, channel=band.channel.name, start=band.start, end=band.end,
            control_unit=band.control.unit, mean=off[band.at].mean(), unit=band.channel.unit,
            percent=100 * off[band.at].mean() / max(abs(value[band.at].mean()), 1e-300),
        )
        for band in _bands(analysis)
    )  # fmt: skip


def common_change(
    analysis: Analysis[Any], changes: np.ndarray, *, of_body: bool
) -> CommonChange | None:
    """Find what several hypotheses change alike: where they change most, by the noise.

    Args:
        analysis: readings with all that could explain them.
        changes: by each hypothesis, (hypotheses, n), of the readings of the model without causes;
            the leading one first.
        of_body: whether all of them change the body, no instrument.

    Returns:
        None where they change the readings of no band of load to the same side.
    """
    best, most = None, 0.0
    for band in _bands(analysis):
        mean = changes[:, band.at].mean(axis=1)
        by_noise = np.abs(changes[:, band.at] / analysis.errors.noise[band.at]).mean(axis=1).min()
        if (np.sign(mean) == np.sign(mean[0])).all() and by_noise > most:
            best, most = band, float(by_noise)
    if best is None:
        return None
    mean = changes[:, best.at].mean(axis=1)
    percent = 100 * np.abs(mean) / max(abs(analysis.problem.value[best.at].mean()), 1e-300)
    up = bool(mean[0] * analysis.problem.value[best.at].mean() > 0)
    stiffer = {("coupon", FORCE): up, ("bending", ANGLE): not up}.get(
        (best.experiment, best.channel)
    )
    way = ("higher" if up else "lower") if stiffer is None or not of_body else (
        "stiffer" if stiffer else "softer"
    )  # fmt: skip
    return CommonChange.model_validate(
        {
            "experiment": best.experiment, "channel": best.channel.name, "way": way,
            "percent": percent[0], "low": percent.min(), "high": percent.max(),
            "above": best.start, "below": None if best.last else best.end,
            "control_unit": best.control.unit,
        }
    )  # fmt: skip
