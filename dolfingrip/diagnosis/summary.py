"""What was found as data for ``diagnosis.json``, and as one page of text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip import __version__
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import extend, outcome
from dolfingrip.diagnosis.diagnose import Diagnosis
from dolfingrip.diagnosis.inference.sentences import sentences
from dolfingrip.diagnosis.inference.significance import significance_table

LEVEL = 0.05


def differences(found: Diagnosis) -> pd.DataFrame:
    """Where the base model is off after its nuisances are fitted, by groups."""
    problem = found.problem
    everything = np.ones(len(problem.value), dtype=bool)
    fitted = found.none.predicted(problem, everything)
    return significance_table(
        problem.index, problem.value, problem.value - fitted,
        problem.noise_covariance, problem.error_covariance,
    )  # fmt: skip


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
    table = differences(found)
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
                    for key, e in extend.parameters(config, fit, fit.estimates(found.problem))
                ),
                simulations=fit.evaluations,
            )
            for fit in found.fits.values()
        ),
        differences=tuple(_difference(row) for _, row in table.iterrows()),
        sentences=tuple(sentences(table)),
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
        processor_s=found.processor_s,
    )  # fmt: skip


def _verdict(found: Diagnosis) -> outcome.Verdict:
    verdict = found.verdict
    named = [each.names for each in verdict.named]
    return outcome.Verdict(
        answer=verdict.answer,
        effects=named[0] if named else (),
        second=named[1] if len(named) > 1 else (),
        probability=min(max(verdict.probability, 0.0), 1.0),
        sentence=verdict.sentence(),
    )


def _difference(row: pd.Series) -> outcome.Difference:
    def number(name: str) -> Any:
        value = row[name]
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return None
        return value

    return outcome.Difference(
        channel=row["channel"], by=row["by"], low_kPa=number("low_kPa"),
        high_kPa=number("high_kPa"), branch=number("branch"),
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
    first = f"# {result.verdict.sentence[0].upper()}{result.verdict.sentence[1:]}."
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
