"""Statistics of a diagnosis: fitted numbers and their intervals, misfits, what causes change."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import product

import numpy as np

from dolfingrip.channels import ANGLE, CHANNELS, FORCE
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.data.motion import smallest_change
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import (
    BandMisfit,
    ChannelMisfit,
    CommonChange,
    FittedNumber,
    RigNumber,
)
from dolfingrip.parameter import find, named
from dolfingrip.parameter.nuisances import SPECIMEN, WALL, modulus_keys
from dolfingrip.sections.units import unit

# -- numbers ---------------------------------------------------------------------------------------


def fitted_numbers(analysis: Analysis, fit: MapFit) -> list[FittedNumber]:
    """List the numbers of a fit by key: moduli, walls, rig and body, then those of its causes.

    Args:
        analysis: readings with all that could explain them.
        fit: a hypothesis.
    """
    model, problem, policy = analysis.applied, analysis.problem, analysis.problem.policy
    draws, weights = fit.draws or _by_hessian(fit, policy.draws)
    middle = np.where(np.arange(len(fit.zeta)) < problem.nuisance_count, 0.0, fit.zeta)
    places = np.vstack([middle, fit.zeta, draws])
    factor = problem.factor.at(places[:, 0])
    values = [
        (modulus.key, "material", modulus.value(model) * factor)
        for modulus in find(model, modulus_keys(model))
    ]
    always = [
        (_part(number.told_as), number, place)
        for place, number in enumerate(problem.always) if place and number.role == "always"
    ]  # fmt: skip
    of_causes = [(cause.name, number, place) for cause, number, place in analysis.numbers(fit)]
    for part, number, place in [*always, *of_causes]:
        scale = factor if number.modulus else 1.0
        values.append((number.key, part, number.at(places[:, place]) * scale))
    return [
        _estimated(key, part, value, weights, analysis.causes, policy)
        for key, part, value in values
    ]


def _part(name: str) -> str:
    """The part that a number is of, by what a laboratory tells it as."""
    return "walls" if name == WALL else "body" if "." in name else "rig"


def _by_hessian(fit: MapFit, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Draws from the normal distribution about the most probable numbers."""
    rng = np.random.default_rng(0)
    lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
    draws = fit.zeta + rng.standard_normal((count, len(fit.zeta))) @ lower.T
    return draws, np.full(count, 1 / count)


def _estimated(
    key: str,
    part: str,
    values: np.ndarray,
    weights: np.ndarray,
    causes: Collection[str],
    policy: Policy,
) -> FittedNumber:
    """A number and its interval.

    Args:
        key: of the number.
        part: what it is of.
        values: as configured, as fitted, and draws, shape (2 + draws,).
        weights: of the draws, shape (draws,).
        causes: whose numbers have no configured value.
        policy: what an interval holds.
    """
    configured, value, draws = float(values[0]), float(values[1]), values[2:]
    tail = (1 - policy.nearly) / 2
    ends = np.quantile(draws, [tail, 1 - tail - 1e-9], weights=weights, method="inverted_cdf")
    low, high = map(float, ends)
    return FittedNumber(
        key=key, value=value, low=min(low, value), high=max(high, value), unit=unit(key),
        configured=None if part in causes else configured, part=part,
    )  # fmt: skip


def rig_numbers(analysis: Analysis, fit: MapFit, deviations: dict[str, float]) -> list[RigNumber]:
    """List numbers of rig and body that the laboratory told, but those known exactly.

    Args:
        analysis: readings with all that could explain them.
        fit: a hypothesis.
        deviations: of the numbers, by their standard deviations, by name.
    """
    problem, errors, listed = analysis.problem, analysis.errors, []
    others = {WALL, *(artefact.nuisance.name for artefact in errors.artefacts)}
    here = problem.predicted(fit.subset, fit.zeta)
    for place, number in enumerate(problem.always):
        name = number.told_as
        if not place or name in others or name.startswith(SPECIMEN):
            continue
        as_told = np.where(np.arange(len(fit.zeta)) == place, 0.0, fit.zeta)
        change = here - problem.predicted(fit.subset, as_told)
        text = number.unit or (named(name).unit if "." in name else unit(name))
        # a number of the configuration is absolute, all others without a unit are relative
        size, text = (1.0, text) if text or "." in name else (100.0, "%")
        std = size * number.prior.spread
        seen = np.linalg.norm(change / errors.noise) >= problem.policy.visible
        listed.append(
            RigNumber(
                name=name, unit=text, prior_std=std, value=deviations[name] * std,
                share=_share(analysis, change) if seen else 0.0,
            )
        )  # fmt: skip
    return listed


def _share(analysis: Analysis, change: np.ndarray) -> float:
    """A change of the readings, (n,), by what the model as configured misses, both rms."""
    off = analysis.problem.value - analysis.configured
    reached = np.isfinite(off)
    missed = float(np.linalg.norm(off[reached]))
    return float(np.linalg.norm(change[reached])) / missed if missed else 0.0


# -- readings --------------------------------------------------------------------------------------


def misfit(
    analysis: Analysis, plain: np.ndarray, extended: np.ndarray
) -> tuple[ChannelMisfit, ...]:
    """Compare simulated with measured readings by channel.

    Args:
        analysis: readings with all that could explain them.
        plain: (n,) readings of the model without causes, its numbers fitted.
        extended: (n,) readings of the model with the causes that are named.
    """
    value, errors = analysis.problem.value, analysis.mesh_errors
    off = [
        analysis.measurement.rms(simulated - value)
        for simulated in (analysis.configured, plain, extended)
    ]
    rows = []
    for name, at in analysis.measurement.channels().items():
        configured, fitted, with_cause = (missed[name] for missed in off)
        noise, mesh = float(np.median(analysis.errors.noise[at])), errors.get(name)
        rows.append(
            ChannelMisfit(
                channel=name, unit=CHANNELS[name].unit, configured=configured, fitted=fitted,
                extended=with_cause, noise=noise, mesh=mesh,
                undecided=mesh is not None and mesh > max(0.5 * configured, noise),
            )
        )  # fmt: skip
    return tuple(rows)


def bands(analysis: Analysis, plain: np.ndarray) -> Iterator[tuple[BandMisfit, np.ndarray, bool]]:
    """Tell where along the load a model is off; suction has bands of its own.

    Args:
        analysis: readings with all that could explain them.
        plain: (n,) readings of the model.

    Yields:
        Each band of load that has readings, which these are, (n,) of bool, and whether it ends at
        the largest load.
    """
    along, listed, policy = (
        analysis.errors.along, analysis.measurement.listed, analysis.measurement.policy
    )  # fmt: skip
    value, off = analysis.problem.value, plain - analysis.problem.value
    experiment, control = listed["experiment"].to_numpy(), listed["control"].to_numpy()
    prescribed = {test.experiment: test.prescribed for test in analysis.measurement.tests}
    for name_of, (name, read) in product(
        dict.fromkeys(experiment), analysis.measurement.channels().items()
    ):
        here = read & (experiment == name_of)
        if not here.any():
            continue
        largest = max(float(np.abs(control[here]).max()), 1e-12)
        at_rest = smallest_change(control[here], 0.0, policy) / largest
        for band, way in product(range(int(1 / policy.part)), (1.0, -1.0)):
            low, high = band * policy.part, (band + 1) * policy.part
            load = way * along.load
            at = here & (load > (low if way > 0 else max(low, at_rest))) & (load <= high)
            if not at.any():
                continue
            mean = off[at].mean()
            misfit_there = BandMisfit(
                experiment=name_of, channel=name, start=way * low * largest,
                end=way * high * largest, control_unit=CHANNELS[prescribed[name_of]].unit,
                mean=mean, unit=CHANNELS[name].unit,
                percent=100 * mean / max(abs(value[at].mean()), 1e-300),
            )  # fmt: skip
            yield misfit_there, at, way > 0 and high >= 1


def common_change(
    analysis: Analysis, readings: np.ndarray, *, of_body: bool
) -> CommonChange | None:
    """Find what several hypotheses change alike: where they change most, by the noise.

    Args:
        analysis: readings with all that could explain them.
        readings: of each hypothesis, (hypotheses, n), the leading one first.
        of_body: whether all of them change the body, no instrument.

    Returns:
        The change of the model as configured; None where no band of load has one to the same side.
    """
    reference, noise = analysis.configured, analysis.errors.noise
    changes, best, most = readings - reference, None, 0.0
    for band, read, last in bands(analysis, reference):
        at = read & np.isfinite(reference)
        mean = changes[:, at].mean(axis=1) if at.any() else np.zeros(len(changes))
        by_noise = float(np.abs(mean / np.median(noise[at] if at.any() else noise)).min())
        if (np.sign(mean) == np.sign(mean[0])).all() and by_noise > most:
            best, most = (band, last, mean / reference[at].mean()), by_noise
    if best is None:
        return None
    band, last, share = best
    up = bool(share[0] > 0)
    stiffer = {("coupon", FORCE.name): up, ("bending", ANGLE.name): not up}.get(
        (band.experiment, band.channel)
    )
    way = ("higher" if up else "lower") if stiffer is None or not of_body else (
        "stiffer" if stiffer else "softer"
    )  # fmt: skip
    percent = 100 * np.abs(share)
    return CommonChange.model_validate(
        {
            "experiment": band.experiment, "channel": band.channel, "way": way,
            "percent": percent[0], "low": percent.min(), "high": percent.max(),
            "above": band.start, "below": None if last else band.end,
            "control_unit": band.control_unit,
        }
    )  # fmt: skip
