"""A diagnosis as one page of text."""

from __future__ import annotations

import math
from typing import Final

from dolfingrip.diagnosis import brief, outcome
from dolfingrip.diagnosis.gain.odds import CLEAR

CERTAIN: Final = 0.9

DIGITS: Final = 4
"""Power of ten up to which odds are written out."""

EVEN: Final = 0.5
"""Probability of no cause below which its absence cannot be claimed either."""

LITTLE: Final = 1.0
"""Expected ln Bayes factor below which an experiment tells nothing worth mentioning (Kass and
Raftery 1995)."""


def text(result: outcome.DiagnosisFile) -> str:
    """One page; its first three lines are the verdict."""
    head = brief.lines(result.brief) if result.brief else _head(result)
    lines = [*head, "", "## Where the simulation is off (nuisances fitted)", ""]
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
    if result.downstream:
        lines += _downstream(result.downstream)
    lines += ["", "## Noise", "", *(f"- {each}" for each in result.noise.sentences)]
    if not result.noise.sentences:
        lines.append("- as the laboratory tells it")
    lines += [f"- {each}" for each in result.noise.doubts]
    doubts = [*result.suspicions, *result.not_reached, *result.warnings]
    if doubts:
        lines += ["", "## Beware", "", *(f"- {each}" for each in doubts)]
    return "\n".join(lines) + "\n"


def _downstream(found: outcome.Downstream) -> list[str]:
    lines = ["", "## Best designs of the campaign", "", f"{found.sentence}.", "",
             "| design | force before (N) | after | φ before | after |",
             "|---|---|---|---|---|"]  # fmt: skip
    for each in found.designs:
        place = ", ".join(f"{key} = {value:.3g}" for key, value in each.inputs.items())
        force = "–" if each.force_after_N is None else f"{each.force_after_N:.3g}"
        phi = "–" if each.phi_after is None else f"{each.phi_after:.1%}"
        lines.append(
            f"| {place} | {each.force_before_N:.3g} | {force} | {each.phi_before:.1%} | {phi} |"
        )
    return lines


def _head(result: outcome.DiagnosisFile) -> list[str]:
    """Verdict, how much it explains, and what to do next."""
    verdict = result.verdict
    first = f"# {verdict.sentence[0].upper()}{verdict.sentence[1:]}."
    if verdict.takes_part > max(CERTAIN, verdict.probability):
        chance = _chance(verdict.takes_part)
        who = "one of them" if len(verdict.effects) > 1 else "it"
        first += f" That {who} takes part, perhaps together with something else: {chance}."
    if result.suspicions:
        first += f" But check the data first: {result.suspicions[0]}"
    if result.not_reached:
        first += f" Not all readings are compared: {result.not_reached[0]}."
    if result.noise.too_small or result.noise.correlated:
        first += f" But the noise is not as believed: {result.noise.doubts[0]}."
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
        third = f"Next experiment: {_proposed(result.next_experiments[0])}"
    elif result.verdict.answer == "none" and result.none < EVEN:
        third = (
            "Next experiment: none is ranked, as nothing is claimed; another channel, unloading, "
            "or a coupon in another mode would tell more."
        )
    elif result.verdict.answer == "none":
        third = "Next experiment: none; the readings agree with the model within their noise."
    elif result.verdict.answer == "unknown":
        third = (
            "Next experiment: repeat the measurement; look at the residuals for what is missing."
        )
    return [first, second, third]


def _proposed(one: outcome.NextExperiment) -> str:
    """What is proposed, and what may be expected of it."""
    if one.gain < LITTLE:
        return f"no addition of the list tells them apart; {one.name} would tell the most."
    told = f"{one.name} ({one.minutes:.0f} minutes)"
    return f"{told}." if one.splits else f"{told}; it may not tell all of them apart."


def _gain(result: outcome.DiagnosisFile) -> list[str]:
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
        *_odds(result.gain_odds),
    ]


def _odds(odds: outcome.GainOdds | None) -> list[str]:
    """In words, for the summary."""
    if odds is None:
        return []
    return [
        "",
        "Given the others, readings that were left out are more probable with the cause: "
        f"{_power(min(odds.mean, odds.nuisances))} times against refitted nuisances "
        f"({CLEAR:.0f} are needed), {_power(odds.process)} times against a process without cause "
        "(1 is needed).",
    ]


def _power(log: float) -> str:
    """Odds of this logarithm, in digits or as a power of ten."""
    power = log / math.log(10)
    return f"{math.exp(log):.2g}" if abs(power) < DIGITS else f"10^{power:.0f}"


def _chance(p: float) -> str:
    return f"{p:.2f}" if p < 0.995 else "> 0.99"
