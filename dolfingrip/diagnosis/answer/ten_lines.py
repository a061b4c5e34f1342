"""The ten lines that the page begins with, for a reader who knows none of its methods."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, SetupEstimate
from dolfingrip.diagnosis.answer.errors import SLACK
from dolfingrip.diagnosis.answer.gain import BANDS, BRANCHES, SPECIMENS
from dolfingrip.diagnosis.answer.settling import advice, some
from dolfingrip.diagnosis.core.evidence import NONE
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.policy import PAGE, POLICY
from dolfingrip.extensions.index import NAMES, effect
from dolfingrip.files.diagnosis import Brief, NextExperiment
from dolfingrip.parameter import named

ONE_OF = {
    SPECIMENS: "each specimen",
    BANDS: "each third of the {load}",
    BRANCHES: "each later branch",
}
"""What is left out, by kind."""
NUISANCES: Final = {
    "coupon_slack_mm": "the force of the coupons begins at another travel than reported",
    "coupon.gauge_length_mm": "another gauge length than reported",
    "coupon_area": "another cross-section of the coupons than reported",
    "modulus": "a stiffer or softer material",
}
"""Causes that are no effects of the catalogue, in words."""


def chance(p: float) -> str:
    """A probability in two digits."""
    return f"{p:.2f}" if p < 0.995 else "> 0.99"


def ten_lines(found: Diagnosis, out: Path) -> Brief:
    """Write the ten lines that the page begins with.

    Args:
        found: the diagnosis.
        out: folder of the results.

    Returns:
        The lines by their headings.
    """
    use_it = f"dolfingrip bend --config {out / 'extended.toml'}"
    if found.decision.answer != "cause":
        use_it += " (as fitted, without a cause)"
    return Brief(
        result=f"{_doubts(found)}{_configured(found)} {answer_sentence(found)}{_survives(found)}",
        size=_size(found),
        fit=_fit(found),
        check=_check(found),
        not_explained=_left(found),
        also_possible=_also(found),
        cannot_be_seen=found.hidden() or "nothing of the catalogue is hidden",
        assumed=_assumed(found),
        do_next=_next(found),
        use_it=use_it,
    )


def _in_words(found: Diagnosis, name: str) -> str:
    """A cause in words, its name in brackets."""
    if name in NAMES:
        return f"{found.words(name)} ({name})"
    return f"{NUISANCES.get(name, name)} ({name})"


def _one_of(found: Diagnosis, names: Sequence[str]) -> str:
    """Causes that cannot be told apart, the most probable first."""
    words = [_in_words(found, name) for name in names[: PAGE.in_words]]
    text = words[0] if len(words) == 1 else " or ".join(words)
    rest = names[PAGE.in_words :]
    return f"{text} or, less probably, {' or '.join(rest)}" if rest else text


def _doubts(found: Diagnosis) -> str:
    """Tell what to know about the data before the result."""
    text = ""
    if found.suspicions:
        text = f"Check the data first: {' Or: '.join(found.suspicions[:2])} Then: "
    text += "".join(f"{each}. " for each in found.undecided_channels())
    if found.analysis.not_reached:
        text += f"Not all readings are compared: {found.analysis.not_reached[0]}. "
    if names := ", ".join(found.analysis.failed):
        text += f"Not all causes are compared, as no simulation of these ended: {names}. "
    return text


def _configured(found: Diagnosis) -> str:
    """Tell what is off as configured, and what was fitted for it."""
    value, simulated = found.analysis.problem.value, found.analysis.configured
    come = np.isfinite(simulated)
    off = (value - simulated)[come]
    share = 100 * float(np.sqrt(np.mean(off**2) / np.mean(value[come] ** 2))) if come.any() else 0.0
    lost = int((~come).sum())
    so_far = f" and does not come to {lost} of {len(value)} readings" if lost else ""
    sentences = [
        f"As configured the model is {_percent(share)} off (root mean square){so_far}. "
        f"{found.fitted(found.decision.best)}"
    ]
    sentences += [f"{each}." for each in _off(found.setup_estimates(found.decision.best))]
    return " ".join(sentences)


def _off(rig: Sequence[SetupEstimate], *, every: bool = False) -> list[str]:
    """Numbers of the rig that are far out, or every one; several settings in one sentence."""
    kinds: dict[str, list[SetupEstimate]] = defaultdict(list)
    for each in rig:
        kinds[each.name.partition(" at ")[0]].append(each)
    found: list[str] = []
    for kind, alike in kinds.items():
        shown = [each for each in alike if every or each.telling]
        if len(shown) < PAGE.in_words:
            found += map(_setup_estimate, shown)
            continue
        values = [each.value for each in shown]
        most = max(shown, key=lambda each: abs(each.value) / each.prior_std)
        found.append(
            f"{kind} is off by {min(values):+.2g} to {max(values):+.2g} {most.unit} in "
            f"{len(shown)} of {len(alike)} settings (prior ±{most.prior_std:.2g} {most.unit}: "
            f"up to {abs(most.value) / most.prior_std:.1f} standard deviations)"
        )
    return found


def _setup_estimate(each: SetupEstimate) -> str:
    """Describe a number of the rig with its unit and its prior."""
    sigma = abs(each.value) / each.prior_std
    told = f"prior ±{each.prior_std:.2g} {each.unit}: {sigma:.1f} standard deviations"
    if each.name == SLACK:
        way = "early" if each.value > 0 else "late"
        return f"The coupons' force begins {abs(each.value):.2g} mm {way} ({told})"
    return f"{each.name} is off by {each.value:+.2g} {each.unit} ({told})"


def _survives(found: Diagnosis) -> str:
    """Tell whether the answer stays under other priors."""
    if not found.claimed:
        return ""
    low, *_, high = sorted(POLICY.widths)
    if lost := found.sensitivity.lost:
        told = []
        for prior in lost:
            other = found.sensitivity.answers[prior]
            names = [*other.first, *other.second] or other.nearest
            told.append(f"{prior} (these lead to {' or '.join(names)})" if names else prior)
        return f" It is not more probable than not with {', nor with '.join(told)}."
    return f" It stays with priors from {low:g} to {high:g} times as wide."


def answer_sentence(found: Diagnosis) -> str:
    """Tell in words what the answer is, and how sure.

    Args:
        found: the diagnosis.
    """
    decision, problem = found.decision, found.analysis.problem
    sure = chance(found.probability)
    if decision.answer == "none" and found.claimed:
        return f"Nothing else is to be seen: probability {sure}.{_untold(found)}"
    if found.undecided:
        nothing = found.probability if decision.answer == "none" else decision.none
        if decision.answer == "unknown" or nothing < 1 - POLICY.claimed:
            return (
                "No cause can be claimed, though something is off with probability "
                f"{chance(1 - nothing)}.{_untold(found)}"
            )
        return (
            "It cannot be told whether anything else is off: that nothing is has probability "
            f"{sure}.{_untold(found)}"
        )
    if decision.answer == "unknown":
        others = " that could be simulated" if found.analysis.failed else ""
        sentence = (
            f"Something is off that no effect of the catalogue{others} explains: "
            f"probability {sure}."
        )
        if decision.nearest:
            sentence += (
                f" Nearest comes {_one_of(found, decision.nearest)}, but "
                f"{_percent(100 * decision.unexplained)} of what the model misses stays then."
            )
        return sentence
    if len(decision.first) > 1 and decision.first == problem.always[0].names:
        return (
            "Nothing else is off: either the material is so much stiffer or softer, or the "
            f"coupons' cross-section is another (modulus or coupon_area); probability {sure}."
        )
    own = problem.implausible.keys() >= {*decision.first}
    if decision.nuisance_only and own and decision.probability >= POLICY.likelier:
        return f"Nothing else is off: {_one_of(found, decision.first)}; probability {sure}."
    sentence = _one_of(found, decision.first)
    told = {*decision.first, *decision.second}
    if decision.second:
        sentence += f", together with {_one_of(found, decision.second)}"
    elif len({*decision.first}.intersection(decision.best.subset)) > 1:
        sentence += ", most probably together"
    if beside := [each for each in problem.causes(decision.best.subset) if each not in told]:
        sentence += f", most probably together with {_one_of(found, beside)}"
    explained = 100 * (1 - decision.unexplained)
    least = found.sensitivity.least
    doubt = f"; {least:.2f} under other priors" if least < 0.9 * decision.probability else ""
    share = "all" if explained > 99.95 else f"{explained:.3g} %"
    likelier = decision.probability >= POLICY.likelier and not decision.by_shape
    named = "The cause of the rest" if likelier else "Nearest comes"
    explains = f"It explains {share} of what the model misses.{_of_both(decision.first)}"
    if decision.by_shape:
        explains += (
            " An elastic law by itself, with other walls or with friction in the rig, follows "
            "these readings as well."
        )
    return f"{named}: {sentence}; probability {sure}{doubt}. {explains}"


def _of_both(names: Sequence[str]) -> str:
    """Tell that either an instrument is off or the finger, where causes of both are tied."""
    kinds = {effect(name).kind for name in names if name in NAMES}
    if "measurement" not in kinds or kinds.isdisjoint(("elastic", "dissipative", "geometry")):
        return ""
    return " Either an instrument is off or the finger is: look at both."


def _untold(found: Diagnosis) -> str:
    """Tell which causes are not excluded where none is named, and what they hide behind."""
    names = found.open_names
    if not names:
        return ""
    behind = dict.fromkeys(number for each in found.alternatives for number in each.behind)
    hiding = f", hidden behind {' and '.join(behind)}" if behind else ""
    return f" One of these may act{hiding}: {some(names)}."


def _size(found: Diagnosis) -> str:
    fit = found.decision.best
    own = found.numbers(fit)
    numbers = ", ".join(each.words() for each in own)
    causes = found.analysis.problem.causes(fit.subset)
    if not causes:
        held = "; the intervals hold whichever cause of ALSO POSSIBLE acts"
        return f"{numbers}{held if found.alternatives else ''}"
    for name, member in [*found.members.items()][: PAGE.in_words]:
        other = found.numbers(member)
        told = [each.words() for each in other if name in each.key.split(".")]
        numbers += f"; or, with {name} in its place, {', '.join(told)}" if told else ""
    without = replace(fit, subset=NONE, zeta=fit.zeta[: found.analysis.problem.nuisance_count])
    change = found.analysis.exact(fit) - found.analysis.exact(without)
    place = int(np.argmax(np.abs(change / found.analysis.errors.noise)))
    listed = found.analysis.measurement.listed.iloc[place]
    control = CHANNELS[CONTROL[str(listed["experiment"])]]
    channel = CHANNELS[str(listed["column"])]
    return (
        f"{numbers}; at {listed['control']:.3g} {control.unit} it changes the "
        f"{channel.title.lower()} by "
        f"{change[place]:+.3g} {channel.unit} of {listed['value']:.3g} {channel.unit}"
    )


def _fit(found: Diagnosis) -> str:
    problem = found.analysis.problem
    before, plain = found.analysis.configured, found.with_best_modulus()
    after = found.analysis.fitted(found.decision.best)
    named = bool(found.analysis.problem.causes(found.decision.best.subset))
    parts = []
    what = "the cause, and " if named else "another modulus, and "
    for name, at in found.analysis.measurement.channels().items():
        unit = CHANNELS[name].unit
        errors = [_rms((each - problem.value)[at]) for each in (before, plain, after)]
        noise = np.median(found.analysis.errors.noise[at])
        without = f"{errors[1]:.3g} {unit} with another modulus; " if named else ""
        parts.append(
            f"{name}, root mean square: {errors[0]:.3g} {unit} as configured; {without}"
            f"{errors[2]:.3g} {unit} with {what}{found.beside}; noise {noise:.2g} {unit}"
        )
    return "; ".join(parts)


def _check(found: Diagnosis) -> str:
    held = found.held_out
    if held is None:
        return "not done: nothing was named" if found.decision.answer != "cause" else "not done"
    parts = []
    own, channels = found.analysis.errors.scatter, found.analysis.measurement.channels()
    for e in held.errors:
        unit = CHANNELS[e.channel].unit
        scale = ", its scale fitted" if e.left_out == SPECIMENS else ""
        differ = own.shape * _rms(found.analysis.problem.value[channels[e.channel]])
        against = f"; specimens differ by {differ:.2g} {unit} in shape" if own.estimated else ""
        parts.append(
            f"{ONE_OF[e.left_out].format(load=found.load)} left out in turn{scale}, causes chosen "
            f"anew: {e.channel} is predicted to {e.nuisances:.3g} {unit} without a cause, to "
            f"{e.cause:.3g} {unit} with it{against}"
        )
    worth = "better" if held.claimed else "no better"
    return (
        "; ".join(parts)
        + f"; the cause does {worth} than a fitted modulus and a smooth curve without a cause"
    )


def _left(found: Diagnosis) -> str:
    decision = found.decision
    percent = 100 * decision.unexplained
    share = _percent(percent) if percent >= 0.01 else "less than 0.01 %"
    problem, along = found.analysis.problem, found.analysis.errors.along
    rest = (problem.value - found.analysis.fitted(decision.best)) / found.analysis.errors.noise
    if decision.discrepancy < 0.5 or percent < 0.01:
        left = f"what is left is {_rms(rest):.2g} times the noise, root mean square"
        if decision.answer == "cause" or percent < 0.01:
            return f"{share}; {left}"
        beyond = chance(decision.discrepancy)
        return f"{left}; something beside it has probability {beyond}"
    bands = np.minimum((along.load / PAGE.band).astype(int), int(1 / PAGE.band) - 1)
    worst = max(set(bands), key=lambda band: _rms(rest[bands == band]))
    low, high = 100 * worst * PAGE.band, 100 * (worst + 1) * PAGE.band
    return f"{share}, most of it between {low:.0f} and {high:.0f} % of the largest {found.load}"


def _also(found: Diagnosis) -> str:
    decision = found.decision
    # the model's own numbers are fitted already
    named = {*decision.first, *decision.second, *found.analysis.problem.implausible}
    rest = [
        f"{name} ({chance(p)})"
        for name, p in sorted(decision.inclusion.items(), key=lambda each: -each[1])
        if name not in named and p >= POLICY.joint
    ]
    seen = ", ".join(rest)
    if hiding := [n for n in found.open_names if decision.inclusion.get(n, 0.0) < POLICY.joint]:
        seen += f"{'; ' if seen else ''}not excluded, likeliest first: {', '.join(hiding)}"
    return seen or "no other cause has a probability of 0.01 or more"


def _assumed(found: Diagnosis) -> str:
    numbers = found.numbers(found.decision.best)
    configured = found.configured()
    parts = [
        f"{e.key} {e.value:.3g} {named(e.key).unit} ({e.low:.3g} to {e.high:.3g}; configured "
        f"{configured[e.key]:.3g} {named(e.key).unit})"
        for e in numbers if e.key in configured
    ]  # fmt: skip
    estimates = found.setup_estimates(found.decision.best)
    rig = _off([each for each in estimates if each.name not in configured], every=True)
    parts += [f"{text[0].lower()}{text[1:]}" for text in rig]
    off = [f"{x:.2g} {CHANNELS[name].unit}" for name, x in found.analysis.mesh_errors.items()]
    parts += [f"the mesh may be off by {' and '.join(off)} (root mean square)"] if off else []
    parts.append(scatter(found))
    if any("guess" in sentence for sentence in found.analysis.errors.sentences):
        parts.append("the noise is a guess: tell it under [noise]")
    parts += found.warnings[:1]
    return "; ".join(parts)


def _next(found: Diagnosis) -> str:
    """Tell the few tests and checks that tell most, and how many more there are."""
    shown, told = found.next[: PAGE.in_words], {name for e in found.next for name in e.tells}
    parts = [*map(_settling, shown)]
    if not parts or found.decision.by_shape or not told.issuperset(found.tied):
        parts.append(advice(found, told))
    text, further = "; or ".join(parts), len(found.next) - len(shown)
    return f"{text}; {further} more under Further checks" if further else text


def _settling(each: NextExperiment) -> str:
    """Tell what a test or a check would tell."""
    told = [f"leaves one answer with probability {chance(each.chance)}"] if each.chance else []
    if each.tells:
        told.append(f"may tell {some(each.tells)}")
    return (
        f"{each.name}: {each.minutes:.0f} minutes, {', '.join(told) or 'may not tell them apart'}"
    )


def scatter(found: Diagnosis) -> str:
    """Tell in words how far specimens differ.

    Args:
        found: the diagnosis.
    """
    own = found.analysis.errors.scatter
    if not own.estimated:
        share = f"{100 * own.shape:.2g} %" if own.shape else "nothing"
        count = len({each.specimen for each in found.analysis.measurement.tests})
        whose = "one specimen: its" if count == 1 else f"{count} specimens: each one's"
        return f"{whose} own deviation is taken as {share}"
    return (
        f"specimens differ by {100 * own.scale:.2g} % in stiffness and by "
        f"{100 * own.shape:.2g} % in shape, by their own differences"
    )


def _percent(value: float) -> str:
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def _rms(values: np.ndarray) -> float:
    """Return the root mean square of those readings that the model reaches."""
    come = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(come**2))) if come.size else 0.0
