"""What was found as data for ``diagnosis.json``, and as one page of text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip import __version__
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import extend, outcome
from dolfingrip.diagnosis.diagnose import Diagnosis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.multiple import holm
from dolfingrip.diagnosis.inference.sentences import sentences
from dolfingrip.diagnosis.inference.significance import significance_table

BANDS: Final = 5
STEPS: Final = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Widths of a band, times a power of ten."""

CERTAIN: Final = 0.9

IN_WORDS: Final = {"bending": "free bending", "blocked_force": "blocked", "coupon": "coupons"}


def differences(found: Diagnosis) -> tuple[pd.DataFrame, list[str]]:
    """Where the base model is off after its nuisances are fitted, by groups and in words.

    Experiments are apart, as a force on the plate is none on a coupon; p-values are corrected for
    all looks together.
    """
    problem = found.problem
    fitted = found.none.predicted(problem, np.ones(len(problem.value), dtype=bool))
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
    """Nuisances beside the best fit, by their standard deviations."""
    problem, fit = found.problem, found.best
    columns = np.hstack([fit.jacobian, problem.nuisances])
    white = problem.error_covariance.whiten(np.column_stack([fit.residual(problem.value), columns]))
    information = np.eye(columns.shape[1]) + white[:, 1:].T @ white[:, 1:]
    zeta = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])[fit.jacobian.shape[1] :]
    names = [each.name for each in problem.linear_nuisances()]
    return {name: float(z) for name, z in zip(names, zeta, strict=True)}


def outcome_of(found: Diagnosis, config: Config, data: Sequence[str]) -> outcome.Diagnosis:
    """All that was found, by the schema."""
    table, told = differences(found)
    verdict = found.verdict
    reference = found.none.log_evidence(found.problem)
    return outcome.Diagnosis(
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
            verdicts={name: each.sentence() for name, each in found.under.items()},
            sentences=found.noise.sentences,
        ),
        nuisances=fitted_nuisances(found),
        gain=tuple(
            outcome.Gain(
                left_out=row.left_out, channel=row.channel, folds=row.folds, before=row.before,
                nuisances=row.nuisances, process=row.process, cause=row.cause,
                cause_low=row.cause_interval[0], cause_high=row.cause_interval[1],
                by_nuisances_low=row.by_nuisances[0], by_nuisances_high=row.by_nuisances[1],
            )
            for row in found.gain
        ),
        gain_claimed=found.gain_claimed,
        next_experiments=tuple(
            outcome.NextExperiment(
                name=each.name, minutes=each.minutes, gain=each.gain,
                gain_per_minute=each.gain_per_minute, splits=each.splits,
            )
            for each in found.next
        ),
        warnings=tuple(found.warnings),
        extended=_changes(config, found),
        simulated_s=found.simulated_s,
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
        sentence=verdict.sentence(),
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


def text(result: outcome.Diagnosis) -> str:
    """One page; its first three lines are the verdict."""
    lines = [*_head(result), "", "## Where the simulation is off (nuisances fitted)", ""]
    lines += [f"- {each}" for each in result.sentences] or ["- nowhere"]
    lines += ["", "## Classes of effects", "", "| effects | probability |", "|---|---|"]
    lines += [
        f"| {', '.join(each.effects)} | {_chance(each.probability)} |"
        for each in result.classes
        if each.probability >= 0.005
    ]
    lines += [f"| none | {_chance(result.none)} |", f"| unknown | {_chance(result.unknown)} |"]
    if len(result.fits) > 1:
        lines += [
            "",
            "## Fits",
            "",
            "| effects | ln evidence | parameters (90 %) |",
            "|---|---|---|",
        ]
        for fit in sorted(result.fits, key=lambda fit: -fit.log_evidence):
            numbers = "; ".join(
                f"{p.key} = {p.value:.3g} ({p.low:.3g} to {p.high:.3g})" for p in fit.parameters
            )
            name = " with ".join(fit.effects) or "none"
            lines.append(f"| {name} | {fit.log_evidence:.1f} | {numbers} |")
    if result.gain:
        lines += _gain(result)
    if result.next_experiments:
        lines += ["", "## Next experiment", "",
                  "| experiment | minutes | expected ln Bayes factor | tells all apart |",
                  "|---|---|---|---|"]  # fmt: skip
        lines += [
            f"| {each.name} | {each.minutes:.0f} | {each.gain:+.1f} | "
            f"{'yes' if each.splits else 'no'} |"
            for each in result.next_experiments
        ]
    lines += ["", "## Noise", "", *(f"- {each}" for each in result.noise.sentences)]
    if not result.noise.sentences:
        lines.append("- as the laboratory tells it")
    if result.warnings:
        lines += ["", "## Beware", "", *(f"- {each}" for each in result.warnings)]
    return "\n".join(lines) + "\n"


def _head(result: outcome.Diagnosis) -> list[str]:
    """Verdict, how much it explains, and what to do next."""
    verdict = result.verdict
    first = f"# {verdict.sentence[0].upper()}{verdict.sentence[1:]}."
    if verdict.takes_part > max(CERTAIN, verdict.probability):
        chance = _chance(verdict.takes_part)
        who = "one of them" if len(verdict.effects) > 1 else "it"
        first += f" That {who} takes part, perhaps beside something else: {chance}."
    best = next((f for f in result.fits if f.effects and set(f.effects) <= {
        *result.verdict.effects, *result.verdict.second}), None)  # fmt: skip
    if result.quick:
        second = "Quick screen alone: nothing was fitted, strengths are linear estimates."
    elif result.gain:
        rows = result.gain
        parts = [
            f"{row.nuisances:.3g} → {row.cause:.3g} ({row.channel}, {row.left_out})"
            for row in rows[:2]
        ]
        claim = "beats both rivals" if result.gain_claimed else "does not beat both rivals"
        second = (
            f"Error on left-out readings, nuisances refitted → cause: {', '.join(parts)}; {claim}."
        )
    elif best is None:
        second = "Nothing was named, so the model stays as configured but for the fitted modulus."
    else:
        second = f"Fitted: {', '.join(f'{p.key} = {p.value:.3g}' for p in best.parameters)}."
    third = "Next experiment: none is needed to tell effects apart."
    if result.next_experiments:
        one = result.next_experiments[0]
        third = f"Next experiment: {one.name} ({one.minutes:.0f} minutes)."
    elif result.verdict.answer == "none":
        third = "Next experiment: none; the readings agree with the model within their noise."
    elif result.verdict.answer == "unknown":
        third = (
            "Next experiment: repeat the measurement; look at the residuals for what is missing."
        )
    return [first, second, third]


def _gain(result: outcome.Diagnosis) -> list[str]:
    lines = ["", "## Error on readings that were left out (root mean square)", "",
             "| left out | reading | as configured | nuisances refitted | process | cause (90 %) |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    return [
        *lines,
        *(
            f"| {row.left_out} ({row.folds}) | {row.channel} | {row.before:.3g} | "
            f"{row.nuisances:.3g} | {row.process:.3g} | {row.cause:.3g} "
            f"({row.cause_low:.3g} to {row.cause_high:.3g}) |"
            for row in result.gain
        ),
    ]


def _chance(p: float) -> str:
    return f"{p:.2f}" if p < 0.995 else "> 0.99"
