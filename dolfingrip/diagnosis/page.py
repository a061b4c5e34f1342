"""A diagnosis as one page of text."""

from __future__ import annotations

from dolfingrip.diagnosis.words import chance, section, table
from dolfingrip.files import diagnosis as outcome


def text(result: outcome.DiagnosisFile) -> str:
    """Write a diagnosis as one page; its first ten lines are the verdict.

    Args:
        result: the diagnosis.

    Returns:
        Markdown.
    """
    lines = _brief(result.brief) if result.brief else [result.verdict.sentence]
    off = [f"- {each}" for each in result.sentences] or ["- nowhere"]
    lines += section("Where the simulation is off (nuisances fitted)", off)
    lines += section("Causes", _causes(result))
    if len(result.fits) > 1:
        lines += section("Fits", _fits(result))
    if result.gain:
        lines += section("Error on readings that were left out (root mean square)", _gain(result))
    if result.next_experiments:
        lines += section("Next experiment", _next(result))
    if result.downstream:
        lines += section("Best designs of the campaign", _downstream(result.downstream))
    noise = [f"- {each}" for each in result.noise.sentences] or ["- as the laboratory tells it"]
    lines += section("Noise", noise)
    doubts = [*result.suspicions, *result.not_reached, *result.warnings]
    if doubts:
        lines += section("Beware", (f"- {each}" for each in doubts))
    return "\n".join(lines) + "\n"


def _brief(brief: outcome.Brief) -> list[str]:
    """The ten lines, for a reader who knows none of the methods."""
    width = max(map(len, outcome.HEADINGS.values()))
    return [
        f"{heading:<{width}}  {getattr(brief, key)}" for key, heading in outcome.HEADINGS.items()
    ]


def _causes(result: outcome.DiagnosisFile) -> list[str]:
    shown = [(each.name, each.probability) for each in result.causes if each.probability >= 0.005]
    shown += [("none", result.none), ("unknown", result.unknown)]
    rows = (f"| {name} | {chance(p)} |" for name, p in shown)
    return table("| cause | probability that it takes part |", rows)


def _fits(result: outcome.DiagnosisFile) -> list[str]:
    rows = (
        f"| {' with '.join(fit.effects) or 'none'} | {fit.log_evidence:.1f} | "
        f"{'; '.join(each.words() for each in fit.parameters)} |"
        for fit in sorted(result.fits, key=lambda fit: -fit.log_evidence)
    )
    return table("| effects | ln evidence | parameters (90 %) |", rows)


def _gain(result: outcome.DiagnosisFile) -> list[str]:
    rows = (
        f"| {row.left_out} ({row.folds}) | {row.channel} | {row.before:.3g} | "
        f"{row.nuisances:.3g} | {row.process:.3g} | {row.cause:.3g} "
        f"({row.cause_low:.3g} to {row.cause_high:.3g}) |"
        for row in result.gain
    )
    return table(
        "| left out | reading | as configured | nuisances refitted | process | cause (90 %) |", rows
    )


def _next(result: outcome.DiagnosisFile) -> list[str]:
    rows = (
        f"| {each.name} | {each.minutes:.0f} | {each.gain:+.1f} | "
        f"{'yes' if each.splits else 'no'} |"
        for each in result.next_experiments
    )
    return table("| experiment | minutes | expected ln Bayes factor | tells all apart |", rows)


def _downstream(found: outcome.Downstream) -> list[str]:
    rows = []
    for each in found.designs:
        place = ", ".join(f"{key} = {value:.3g}" for key, value in each.inputs.items())
        force = "–" if each.force_after_N is None else f"{each.force_after_N:.3g}"
        phi = "–" if each.phi_after is None else f"{each.phi_after:.1%}"
        rows.append(
            f"| {place} | {each.force_before_N:.3g} | {force} | {each.phi_before:.1%} | {phi} |"
        )
    columns = "| design | force before (N) | after | φ before | after |"
    return [f"{found.sentence}.", "", *table(columns, rows)]
