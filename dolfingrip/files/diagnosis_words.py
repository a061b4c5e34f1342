"""Words of a diagnosis: three lines, tables and cautions, all from the fields of its file.

No other module says a diagnosis in words. ``summary.md``, the command, the report and the examples
take them from here.

>>> chance(0.9361), chance(0.9999), listed(["yeoh", "ogden", "gent"], 2)
('0.94', '> 0.99', 'yeoh, ogden or 1 more')
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from dolfingrip.files.diagnosis import (
    Advice,
    CommonChange,
    DiagnosisFile,
    Downstream,
    FittedNumber,
    Slip,
    Verdict,
    Way,
)
from dolfingrip.files.result_file import Part
from dolfingrip.files.text_table import TextTable

LONGEST: Final = 25
"""Words of a line, at most."""
NAMES: Final = 3
"""Names in a line, at most."""
IN_A_CELL: Final = 4
"""Names in a cell of a table, at most."""
LEAST: Final = 0.005
"""Probability below which two digits say nothing."""
INSTRUMENT: Final = "measurement"
BODY: Final = ("elastic", "dissipative", "geometry")
"""Kinds of effects of instruments, and of the body."""

COMPARED: Final = {
    "material": ("The material", "is", "stiffer", "softer"),
    "walls": ("The walls", "are", "thicker", "thinner"),
}
"""Numbers in words, by their part: subject, verb, above and below what is configured."""

NUMBERS: Final = {
    "modulus": "the material is stiffer or softer",
    "coupon_area": "the coupons' cross-section is another",
    "coupon_slack_mm": "the coupons' force begins at another travel",
    "coupon.gauge_length_mm": "the coupons' gauge length is another",
}
"""Causes that are no effects of the catalogue."""

ADVICE: Final[dict[Way, str]] = {
    "nothing": "Nothing more is needed: nothing else is nearly as probable.",
    "finger": "Measure the finger: these coupons tell no more.",
    "area": "Measure the coupons' cross-section: nothing else tells it from the modulus.",
    "empty_machine": "Run the testing machine without a specimen: its friction shows itself alone.",
    "memory": "Unload, wait at the highest pressure, or run a slow cycle: each shows memory alone.",
    "loop": "Pull a coupon up and down, with a wait of 60 s: a loop and a fading force would prove "
    "memory.",
    "rates": "Pull a coupon up and down at two rates: it would tell memory from elasticity.",
    "other_channel": "Measure another channel, unloading, or a coupon: it would tell what kind of "
    "effect acts.",
    "finger_or_channel": "Measure {unload}the finger or another channel: it may tell whether "
    "{names} acts.",
    "coupon_or_channel": "Measure {unload}a coupon or another channel: it may tell whether {names} "
    "acts.",
    "alone": "Measure another channel, or each of these by itself: {names}.",
}
"""What to do next where no test or check that was weighed tells what is open."""


MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as it cannot be told: it may be named as an "
    "effect; compare readings with a finer mesh"
)
"""Said where neither a second mesh nor a bisection tells it."""


def lines(result: DiagnosisFile) -> tuple[str, str, str]:
    """Say a diagnosis in three lines of at most :data:`LONGEST` words.

    Args:
        result: content of ``diagnosis.json``.

    Returns:
        The answer in one number with the option that uses it; how sure it is, and why; what to
        measure next, and what that will tell.
    """
    return _answer(result), _sure(result), _next(result)


def page(result: DiagnosisFile) -> str:
    """Write a diagnosis as one page: three lines, tables, cautions.

    Args:
        result: content of ``diagnosis.json``.

    Returns:
        Markdown.
    """
    return sections([*lines(result)], tables(result), cautions(result))


def sections(start: Sequence[str], shown: Sequence[TextTable], doubts: Sequence[str]) -> str:
    """Write lines, tables below headings, and what to beware of.

    Args:
        start: the lines.
        shown: the tables.
        doubts: what to beware of.

    Returns:
        Markdown.
    """
    text = [*start]
    for table in shown:
        text += ["", f"## {table.title}", "", *table.markdown()]
    if doubts:
        text += ["", "## Beware", "", *(f"- {doubt}" for doubt in doubts)]
    return "\n".join(text) + "\n"


# -- pieces ----------------------------------------------------------------------------------------


def chance(probability: float) -> str:
    """Write a probability in two digits.

    Args:
        probability: 0 to 1.
    """
    return f"{probability:.2f}" if probability < 1 - LEAST else "> 0.99"


def listed(names: Sequence[str], most: int = IN_A_CELL) -> str:
    """List names, the first in words; the others are counted.

    Args:
        names: in their order.
        most: names that are listed, at most.
    """
    more = [f"{len(names) - most} more"] if len(names) > most else []
    *first, last = [*names[:most], *more] or ["–"]
    return f"{', '.join(first)} or {last}" if first else last


def number_words(number: FittedNumber) -> str:
    """Write a number with its unit and its interval, in three digits.

    Args:
        number: that was fitted.
    """
    value, low, high = (f"{x:.3g}" for x in (number.value, number.low, number.high))
    return " ".join(filter(None, (number.key, "=", value, number.unit, f"({low} to {high})")))


def beside_causes(result: DiagnosisFile) -> dict[str, float]:
    """Say what else may be: probabilities that no cause is seen, or one out of the catalogue.

    That nothing acts is less probable than that nothing is seen, as a cause may hide.

    Args:
        result: content of ``diagnosis.json``.
    """
    nothing = result.verdict.probability if result.verdict.answer == "none" else result.none
    hidden = result.none - nothing
    return {
        "none: noise alone": nothing,
        **({"hidden: not seen, not excluded": hidden} if hidden > 0 else {}),
        "unknown: not in the catalogue": result.unknown,
    }


def slip_words(slip: Slip) -> str:
    """Ask about a doubtful column.

    Args:
        slip: that is suspected.
    """
    factor = "" if slip.factor is None else f" (factor {slip.factor:.4g})"
    return f"{slip.where}: {slip.column}: {slip.meaning}?{factor}"


def fate(downstream: Downstream) -> str:
    """Say what becomes of a campaign's optimum.

    Args:
        downstream: designs by the model before and after.
    """
    before = downstream.designs[0]
    after = max(downstream.designs, key=lambda design: design.force_after_N or 0.0)
    if before.phi_after is None or after.phi_after is None:
        return "the campaign's optimum could not be computed with the extended model"
    change = f"φ of the campaign's optimum {before.phi_before:.1%} → {before.phi_after:.1%}"
    if after is before:
        return f"{change}; it stays the best of the {len(downstream.designs)} that were computed"
    return f"{change}; the best is now {_cell(after.inputs)} with φ = {after.phi_after:.1%}"


def _percent(share: float) -> str:
    """A share in percent, in two digits where it is small."""
    value = 100 * share
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def _fitting(*variants: str) -> str:
    """The first of several wordings that is short enough for a line; else the last."""
    return next((text for text in variants if len(text.split()) <= LONGEST), variants[-1])


def _capital(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def _load(start: float, end: float | None, unit: str) -> str:
    if end is None:
        return f"above {start:.3g} {unit}"
    return f"between {start:z.3g} and {end:.3g} {unit}" if start else f"up to {end:.3g} {unit}"


# -- the three lines -------------------------------------------------------------------------------


def _answer(result: DiagnosisFile) -> str:
    """The answer in one number, with its interval and the option that uses it."""
    if result.slips:
        slip, start = result.slips[0], "Check the data first:"
        return _fitting(f"{start} {slip_words(slip)}", f"{start} {slip.column}: {slip.meaning}?")
    number, verdict = result.headline.number, result.verdict
    use = f": `{result.headline.option}`" if result.headline.option else ""
    fitted = f"{number_words(number)}{use}"
    if verdict.answer != "cause":
        if verdict.answer == "none":
            return f"{_compared(number)}: {fitted}"
        why = "No effect of the catalogue explains the readings" if verdict.claimed else (
            "No cause can be claimed"
        )  # fmt: skip
        return f"{why}; as fitted, {fitted}"
    words = {cause.name: cause.words for cause in result.causes}
    cause = result.headline.cause
    if number.part in COMPARED and not verdict.second:
        names = [name for name in verdict.effects if name != cause]
        others = "".join(f", or {words.get(name) or name}" for name in names)
        start, fewer = _compared(number), f", or {listed(names, 1)}" if names else ""
        return _fitting(f"{start}{others}: {fitted}", f"{start}{fewer}: {fitted}")
    if result.headline.common and len(verdict.effects) > 1:
        common = result.headline.common
        what = "it" if common.way in ("stiffer", "softer") else common.channel
        change = f"all of them make {what} {common_words(common)}{use}"
        return _fitting(*(f"{_named(verdict, most)}: {change}" for most in range(NAMES, 0, -1)))
    alone = f"{_capital(words.get(cause) or cause)} ({cause}): {fitted}"
    return _fitting(
        *([] if verdict.second else [alone]),
        *(f"{_named(verdict, most)}: {fitted}" for most in range(NAMES, 0, -1)),
    )


def _named(verdict: Verdict, most: int) -> str:
    """The effects of the leading class, and of a second cause."""
    return " with ".join(
        listed(names, most) for names in (verdict.effects, verdict.second) if names
    )


def common_words(change: CommonChange) -> str:
    """Say what causes change about the readings.

    Args:
        change: that all of them make.
    """
    value, low, high = (
        f"{share:.3g}" if share < 999.5 else f"{share:.0f}"
        for share in (change.percent, change.low, change.high)
    )
    where = _load(change.above, change.below, change.control_unit)
    return f"{value} % ({low} to {high} %) {change.way} than configured {where}"


def _compared(number: FittedNumber) -> str:
    """A number by what is configured."""
    subject, verb, above, below = COMPARED.get(number.part, (number.key, "is", "larger", "smaller"))
    if not number.off:
        return f"{subject} may be as configured"
    ratio = number.value / number.configured if number.configured else 0.0
    if ratio <= 0:
        return f"{subject} {verb} not as configured"
    way, factor = (above, ratio) if ratio > 1 else (below, 1 / ratio)
    times = f"{factor:.{1 if factor < 10 else 0}f} times"
    much = _percent(abs(ratio - 1)) if factor < 2 else times
    return f"{subject} {verb} {much} {way} than configured"


def _sure(result: DiagnosisFile) -> str:
    """How sure the answer is, and why; what limits it as far as the line has room."""
    verdict = result.verdict
    sure = f"Probability {chance(verdict.probability)}"
    line = {"cause": _why_a_cause, "none": _why_none, "unknown": _why_unknown}[verdict.answer](
        result, sure
    )
    for limit, _ in _limits(result):
        line = _fitting(f"{line}; {limit}", line) if limit else line
    return f"{line}."


def _why_a_cause(result: DiagnosisFile, sure: str) -> str:
    verdict = result.verdict
    if verdict.least < 0.9 * verdict.probability:
        sure += f" ({chance(verdict.least)} under other priors)"
    if not verdict.claimed:
        sure = f"Not enough to claim it: {sure[0].lower()}{sure[1:]}"
    if verdict.by_shape:
        return f"{sure}: an elastic law or friction in the rig follows these readings as well"
    share = "all" if verdict.unexplained < 5e-4 else f"{100 * (1 - verdict.unexplained):.3g} %"
    why = f"{sure}: it explains {share} of what the model misses"
    kinds = {cause.kind for cause in result.causes if cause.name in verdict.effects}
    if INSTRUMENT in kinds and not kinds.isdisjoint(BODY):
        return _fitting(f"{why}; either an instrument is off or the finger", why)
    return why


def _why_none(result: DiagnosisFile, sure: str) -> str:
    verdict = result.verdict
    if verdict.claimed:
        left = max((of.extended / of.noise for of in result.misfit if of.noise), default=0.0)
        return f"{sure} that nothing else is off: {left:.2g} times the noise is left"
    names = [cause.name for cause in result.causes if cause.open]
    behind = f" behind {' and '.join(result.behind)}" if result.behind else ""
    untried = result.failed or result.not_tried
    why = "not every cause was tried" if untried else "the readings tell too little"
    act = f"{listed(names, 1)} may hide{behind}" if names else why
    if verdict.probability < 0.5:
        sure = f"Something is off with probability {chance(1 - verdict.probability)}"
        return _fitting(f"{sure}, but no cause can be claimed: {act}", sure)
    sure += " that nothing else is off"
    return _fitting(f"{sure}, too little to claim it: {act}", sure)


def _why_unknown(result: DiagnosisFile, sure: str) -> str:
    verdict = result.verdict
    if not verdict.claimed:
        names = [cause.name for cause in result.causes if cause.open]
        sure = f"Something is off with probability {chance(1 - result.none)}"
        return f"{sure}; {listed(names, NAMES)} may act" if names else sure
    left = f"{_percent(verdict.unexplained)} of what the model misses stays"
    beside = f" beside the nearest, {listed(verdict.nearest, NAMES)}" if verdict.nearest else ""
    return f"{sure} that something else acts: {left}{beside}"


def _next(result: DiagnosisFile) -> str:
    """The third line: what to measure next, and what it will tell."""
    advice = result.advice
    if result.next_experiments and not result.verdict.by_shape:
        first = result.next_experiments[0]
        start = f"Measure next: {first.name} ({first.minutes:.0f} minutes):"
        tells = [f"may tell {listed(first.tells, most)}" for most in (2, 1) if first.tells]
        if first.chance >= LEAST:
            alone = f"leaves one answer with probability {chance(first.chance)}"
            tells = [*(f"{text}, and {alone}" for text in tells), alone]
        return _fitting(*(f"{start} it {text}." for text in tells or ["hardly tells them apart"]))
    return _fitting(*(advice_words(advice, most) for most in (NAMES, 2, 1))) if advice else ""


def advice_words(advice: Advice, most: int = NAMES) -> str:
    """Say what to do where nothing that was weighed tells what is open.

    Args:
        advice: with the causes that it is about.
        most: names of these, at most.
    """
    unload = "with unloading " if advice.unload else ""
    return ADVICE[advice.way].format(names=listed(advice.names, most), unload=unload)


# -- tables ----------------------------------------------------------------------------------------


def tables(result: DiagnosisFile) -> list[TextTable]:
    """List all that stands below the three lines as tables.

    Args:
        result: content of ``diagnosis.json``.
    """
    return [table for table in _tables(result) if table.rows]


def _tables(result: DiagnosisFile) -> Iterator[TextTable]:
    """Iterate over all tables; those without rows are left out of the page."""
    yield _listing(
        "Misfit: root mean square of simulated less measured readings",
        result.misfit, "channel unit configured fitted extended noise mesh",
    )  # fmt: skip
    yield _listing(
        "Change of the readings by what is named, against the model as configured",
        [result.headline.common] if result.headline.common else [],
        "experiment channel percent low high way above below control_unit",
    )
    shown = [cause for cause in result.causes if cause.probability >= LEAST or cause.open]
    rows = [
        [cause.name, cause.words, chance(cause.probability), "yes" if cause.open else ""]
        for cause in shown
    ]
    rows += [[name, "", chance(p), ""] for name, p in beside_causes(result).items()]
    headings = ["cause", "what it is", "probability that it takes part", "may act unseen"]
    yield TextTable(headings, rows, "Causes")
    fits = sorted(result.fits, key=lambda fit: -fit.log_evidence)
    rows = [
        [" with ".join(fit.effects) or "none", f"{fit.log_evidence:z.1f}",
         "; ".join(map(number_words, fit.parameters))]
        for fit in fits
    ]  # fmt: skip
    yield TextTable(["effects", "ln evidence", "parameters (90 %)"], rows, "Fits")
    yield _listing(
        "Numbers of the answer (90 %)", result.fits[0].parameters if result.fits else (),
        "key part configured value low high unit",
    )  # fmt: skip
    yield _listing(
        "Numbers of rig and body: differences from what was told",
        result.rig, "name value prior_std unit share",
    )  # fmt: skip
    yield _listing(
        "Where the simulation is off: simulated less measured, numbers fitted, no cause",
        result.bands, "experiment channel start end control_unit mean unit percent",
    )  # fmt: skip
    yield _listing("Under other priors", result.other_priors, "prior answer effects probability")
    worth = "does better" if result.gain_claimed else "does no better"
    yield _listing(
        "Error on readings that were left out (root mean square, in the channel's unit): the cause "
        f"{worth} than a model without it",
        result.gain, "left_out folds channel before nuisances process cause cause_low cause_high",
    )  # fmt: skip
    yield _listing("Further checks", result.next_experiments, "name minutes chance tells gain")
    behind: dict[tuple[str, ...], list[str]] = {}
    for name, numbers in result.hides.items():
        behind.setdefault(numbers, []).append(name)
    rows = [[", ".join(names), " and ".join(numbers) or "nothing: too faint"]
            for numbers, names in behind.items()]  # fmt: skip
    yield TextTable(["effects", "hidden behind"], rows, "Effects that these readings do not show")
    yield _listing(
        "Artefacts of instruments, which are taken out", result.artefacts, "name size unit"
    )
    yield _listing(
        "Noise that the laboratory does not tell", result.noise_sources, "column test std source"
    )
    yield _listing(
        "Relative scatter of specimens, by their differences or as usual",
        [result.scatter] if result.scatter else [], "specimens scale shape estimated",
    )  # fmt: skip
    if result.downstream:
        yield _listing(
            f"Best designs of the campaign: {fate(result.downstream)}", result.downstream.designs,
            "inputs force_before_N force_after_N phi_before phi_after",
        )  # fmt: skip


def _listing(title: str, parts: Sequence[Part], keys: str) -> TextTable:
    """A row for each part, a column for each of its keys, which the file has, too."""
    names = keys.split()
    rows = [[_cell(getattr(part, name), name) for name in names] for part in parts]
    return TextTable([name.replace("_", " ") for name in names], rows, title)


def _cell(value: object, name: str = "") -> str:
    """Write a value of a field, by its name."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {_cell(number)}" for key, number in value.items())
    if isinstance(value, tuple):
        return listed(value)
    if isinstance(value, float):
        return chance(value) if name in ("probability", "chance") else f"{value:z.3g}"
    return {None: "–", True: "yes", False: "no"}.get(value, f"{value}")  # type: ignore[call-overload]


# -- cautions --------------------------------------------------------------------------------------


def cautions(result: DiagnosisFile) -> list[str]:
    """List what to beware of, the gravest first.

    Args:
        result: content of ``diagnosis.json``.
    """
    limits = [text for _, text in _limits(result) if text]
    return [*map(slip_words, result.slips), *limits, *result.warnings]


def _limits(result: DiagnosisFile) -> Iterator[tuple[str, str]]:
    """Iterate over what limits the answer, the gravest first: in few words, and on the page."""
    if result.not_tried:
        names = ", ".join(result.not_tried)
        yield f"--quick left out {len(result.not_tried)} causes", f"--quick left out {names}"
    for test in result.not_reached:
        yield "some readings are not reached", test
    for channel in result.misfit:
        if channel.undecided:
            short = f"this mesh cannot decide about {channel.channel}"
            sizes = [f"{size:.2g} {channel.unit}" for size in (channel.mesh, channel.configured)]
            error = f"its own error is about {sizes[0]}, where the model is {sizes[1]} off"
            yield short, f"{short}: {error}; take a finer one"
    if result.apart:
        who, without = " and ".join(result.apart.specimens), result.apart.without
        answer = f"{without.answer} {_named(without, NAMES)}".rstrip()
        apart = f"of the specimens {who} stands apart (odds {result.apart.odds:.2g} to 1)"
        other = f"the answer without: {answer}, probability {chance(without.probability)}"
        yield f"without {who} it may differ", f"{apart}; {other}"
    for name, why in result.failed.items():
        yield f"{name} could not be tried", f"{name} could not be tried: {why}"
    if result.artefacts:
        yield "artefacts of instruments are taken out", ""
    if result.gain_claimed is False:
        yield "left-out readings do not confirm it", ""
    if not result.mesh_known:
        yield "", MESH_UNKNOWN
    if result.scatter and result.scatter.wide:
        scale, prior = map(_percent, (result.scatter.scale, result.scatter.prior_scale))
        believed = f"where {prior} is believed (nuisance.specimen_scale)"
        yield "", f"the specimens' stiffness scatters by {scale}, {believed}"
    if result.extrapolated:
        yield "", "the leading fit was not simulated: its readings are extrapolated"
    if result.quick:
        yield "", "--quick left out the gain on left-out readings, and tests to simulate"
    if result.advice and result.next_experiments:
        yield "", advice_words(result.advice)
