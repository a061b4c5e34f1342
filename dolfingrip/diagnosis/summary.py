"""What was found as data for ``diagnosis.json``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip import __version__
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import extend, outcome
from dolfingrip.diagnosis.found import Diagnosis
from dolfingrip.diagnosis.gain.gain import GainRow
from dolfingrip.diagnosis.gain.odds import Odds, log_odds_of_kinds, mean_log_odds
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.multiple import holm
from dolfingrip.diagnosis.inference.sentences import sentences
from dolfingrip.diagnosis.inference.significance import significance_table
from dolfingrip.diagnosis.simulation.nuisances import WALL

BANDS: Final = 5
STEPS: Final = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Widths of a band, times a power of ten."""

IN_WORDS: Final = {"bending": "free bending", "blocked_force": "blocked", "coupon": "coupons"}


def differences(found: Diagnosis) -> tuple[pd.DataFrame, list[str]]:
    """Where the base model is off after its nuisances are fitted, by groups and in words.

    Experiments are apart, as a force on the plate is none on a coupon; p-values are corrected for
    all looks together.
    """
    problem = found.problem
    fitted = found.nuisances_fitted
    tables, units = [], {}
    for experiment in dict.fromkeys(problem.index["experiment"]):
        at = np.flatnonzero(problem.index["experiment"] == experiment)
        index = problem.index.iloc[at]
        units[experiment] = "mm of travel" if experiment == "coupon" else "kPa"
        if experiment == "coupon":
            index = index.assign(pressure_kPa=index["displacement_mm"])
        block = np.ix_(at, at)
        table = significance_table(
            index, problem.value[at], (problem.value - fitted)[at],
            problem.noise_covariance[block], Covariance.of(problem.error_covariance.matrix[block]),
            _edges(float(index["pressure_kPa"].max())),
        )  # fmt: skip
        tables.append(table.assign(experiment=experiment))
    whole = pd.concat(tables, ignore_index=True)
    whole["p_corrected"] = holm(whole["p"].to_numpy())
    told = []
    for experiment, unit in units.items():
        own = sentences(whole[whole["experiment"] == experiment], band_unit=unit)
        where = f"{IN_WORDS.get(experiment, experiment)}: " if len(units) > 1 else ""
        told += [where + each for each in own]
    return whole, told


def _edges(top: float) -> list[float]:
    """About five bands from 0 on with round ends."""
    wide = max(top, 1e-9) / BANDS
    power = 10.0 ** math.floor(math.log10(wide))
    step = next(power * each for each in STEPS if power * each >= wide * (1 - 1e-9))
    return [step * number for number in range(math.ceil(top / step - 1e-9) + 1)]


def fitted_nuisances(found: Diagnosis) -> dict[str, float]:
    """Nuisances of the best fit, in their standard deviations."""
    problem, fit = found.problem, found.best
    shifts = {WALL, *(each.key for each in problem.shifts)}
    moved = {p.key: float(z) for p, z in zip(fit.parameters, fit.zeta, strict=True)
             if p.key in shifts}  # fmt: skip
    return moved | fit.fitted_nuisances(problem)


def outcome_of(found: Diagnosis, config: Config, data: Sequence[str]) -> outcome.DiagnosisFile:
    """All that was found, by the schema."""
    table, told = differences(found)
    verdict = found.verdict
    reference = found.none.log_evidence(found.problem)
    return outcome.DiagnosisFile(
        version=__version__,
        data=tuple(data),
        quick=found.quick,
        readings=len(found.problem.value),
        verdict=_verdict(found),
        classes=tuple(
            outcome.EffectClass(
                effects=each.names, probability=each.probability, members=each.members,
                strength_sigma=each.strength_sigma,
            )
            for each in verdict.table
        ),
        none=verdict.none,
        unknown=verdict.unknown,
        screen={score.name: score.log_evidence for score in found.conclusion.scores},
        fits=tuple(
            outcome.Fit(
                effects=fit.effects,
                log_evidence=fit.log_evidence(found.problem) - reference,
                parameters=tuple(
                    outcome.Parameter(key=key, value=e.value, low=e.low, high=e.high)
                    for key, e in found.numbers(fit)
                ),
                simulations=fit.evaluations,
            )
            for fit in found.fits.values()
        ),
        differences=tuple(_difference(row) for _, row in table.iterrows()),
        sentences=tuple(told),
        noise=outcome.Noise(
            std={k: n.std for k, n in found.problem.noise.items()},
            correlated_std={k: n.correlated_std for k, n in found.problem.noise.items()},
            models=dict(found.models),
            verdicts={
                name: each.sentence()
                for name, each in {**found.under, **found.doubts.under}.items()
            },
            sentences=found.noise.sentences,
            doubts=found.doubts.sentences,
            too_small=found.doubts.too_small,
            correlated=found.doubts.correlated,
            if_not_believed=dict(found.doubts.models),
        ),
        nuisances=fitted_nuisances(found),
        gain=tuple(_gain(row, found.odds) for row in found.gain),
        gain_claimed=found.gain_claimed,
        gain_odds=_odds(found.odds) if found.odds else None,
        next_experiments=tuple(
            outcome.NextExperiment(
                name=each.name, minutes=each.minutes, gain=each.gain,
                gain_per_minute=each.gain_per_minute, splits=each.splits, chance=each.chance,
            )
            for each in found.next
        ),
        downstream=_downstream(found),
        suspicions=tuple(found.suspicions),
        not_reached=tuple(found.not_reached),
        warnings=tuple(found.warnings),
        extended=_changes(config, found),
        simulated_s=found.simulated_s,
    )  # fmt: skip


def _odds(odds: Sequence[Odds]) -> outcome.GainOdds:
    return outcome.GainOdds(
        mean=mean_log_odds(odds, "nuisances"),
        nuisances=log_odds_of_kinds(odds, "nuisances"),
        process=log_odds_of_kinds(odds, "process"),
    )


def _gain(row: GainRow, odds: Sequence[Odds]) -> outcome.Gain:
    same = [o for o in odds if (o.left_out, o.channel) == (row.left_out, row.channel)]
    return outcome.Gain(
        left_out=row.left_out, channel=row.channel, folds=row.folds, before=row.before,
        nuisances=row.nuisances, process=row.process, cause=row.cause,
        cause_low=row.cause_interval[0], cause_high=row.cause_interval[1],
        by_nuisances_low=row.by_nuisances[0], by_nuisances_high=row.by_nuisances[1],
        log_odds_nuisances=sum(same[0].nuisances) if same else None,
        log_odds_process=sum(same[0].process) if same else None,
    )  # fmt: skip


def _verdict(found: Diagnosis) -> outcome.Verdict:
    verdict = found.verdict
    named = [each.names for each in verdict.named]
    return outcome.Verdict(
        answer=verdict.answer,
        effects=named[0] if named else (),
        second=named[1] if len(named) > 1 else (),
        probability=min(max(verdict.probability, 0.0), 1.0),
        takes_part=min(found.takes_part, 1.0),
        unexplained=_unexplained(found),
        sentence=verdict.sentence(),
    )


def _unexplained(found: Diagnosis) -> float:
    """Share of the misfit of the model with its nuisances fitted that the named cause leaves."""
    problem = found.problem
    covariance = problem.covariance

    def misfit(fit: Hypothesis) -> float:
        white = covariance.whiten(fit.residual(problem.value))
        return float(white @ white) - len(white)

    before = misfit(found.none)
    return float(np.clip(misfit(found.best) / before, 0.0, 1.0)) if before > 0 else 0.0


def _downstream(found: Diagnosis) -> outcome.Downstream | None:
    own = found.downstream
    if own is None:
        return None
    return outcome.Downstream(
        original_before_N=own.original_before_N,
        original_after_N=own.original_after_N,
        designs=tuple(outcome.DesignChange(**vars(each)) for each in own.designs),
        sentence=own.sentence(),
    )


def _difference(row: pd.Series) -> outcome.Difference:
    def number(name: str) -> Any:
        value = row[name]
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return None
        return value

    return outcome.Difference(
        experiment=row["experiment"], channel=row["channel"], by=row["by"],
        low=number("low_kPa"), high=number("high_kPa"), branch=number("branch"),
        cycle=None if number("cycle") is None else int(number("cycle")),
        rate_kPa_per_s=number("rate_kPa_per_s"), specimen=number("specimen"),
        count=int(row["count"]), simulated_minus_measured=row["simulated_minus_measured"],
        std_error=row["std_error"], p_corrected=row["p_corrected"], percent=number("percent"),
    )  # fmt: skip


def _changes(config: Config, found: Diagnosis) -> dict[str, Any]:
    """What ``extended.toml`` changes, by section."""
    try:
        after = extend.extended(config, found.best).model_dump(mode="json", exclude_none=True)
    except ConfigError:
        return {}
    before = config.model_dump(mode="json", exclude_none=True)
    return {
        section: {key: value for key, value in values.items()
                  if before.get(section, {}).get(key) != value}
        for section, values in after.items()
        if isinstance(values, dict) and values != before.get(section)
    }  # fmt: skip
