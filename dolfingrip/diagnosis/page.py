"""A diagnosis as one page of text."""

from __future__ import annotations

from typing import Final

from dolfingrip.diagnosis import outcome

HEADINGS: Final = {
    "result": "RESULT",
    "size": "SIZE",
    "fit": "FIT",
    "check": "CHECK",
    "not_explained": "NOT EXPLAINED",
    "also_possible": "ALSO POSSIBLE",
    "cannot_be_seen": "CANNOT BE SEEN HERE",
    "assumed": "ASSUMED",
    "do_next": "DO NEXT",
    "use_it": "USE IT",
}
"""Headings of the lines, in their order."""


def text(result: outcome.DiagnosisFile) -> str:
    """One page; its first ten lines are the verdict."""
    head = _brief(result.brief) if result.brief else [result.verdict.sentence]
    lines = [*head, "", "## Where the simulation is off (nuisances fitted)", ""]
    lines += [f"- {each}" for each in result.sentences] or ["- nowhere"]
    lines += ["", "## Causes", "", "| cause | probability that it takes part |", "|---|---|"]
    lines += [
        f"| {each.name} | {_chance(each.probability)} |"
        for each in result.causes
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
    ]


def _chance(p: float) -> str:
    return f"{p:.2f}" if p < 0.995 else "> 0.99"


def _brief(brief: outcome.Brief) -> list[str]:
    """The ten lines, for a reader who knows none of the methods."""
    width = max(map(len, HEADINGS.values()))
    return [f"{heading:<{width}}  {getattr(brief, key)}" for key, heading in HEADINGS.items()]
