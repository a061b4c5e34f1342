"""A diagnosis of coupons as data for ``diagnosis.json``, the page and the pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dolfingrip import __version__
from dolfingrip import config as configuration
from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis import brief, outcome
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import NONE
from dolfingrip.diagnosis.coupon.covariance import SLACK
from dolfingrip.diagnosis.coupon.found import (
    CouponDiagnosis,
    Estimated,
    OfTheRig,
    exact,
    fitted,
    of_the_rig,
)
from dolfingrip.diagnosis.coupon.gain import BANDS, BRANCHES, SPECIMENS
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import find, moduli

ONE_OF = {
    SPECIMENS: "each specimen",
    BANDS: "each third of the strain",
    BRANCHES: "each later branch",
}
"""What is left out, by kind."""
WIDTH_OF_A_BAND = 0.25
"""Of the largest load, of which the page says where something is left."""


def extended_toml(found: CouponDiagnosis) -> str:
    """The configuration at the fitted numbers, these with intervals as comments before it."""
    fit = found.decision.best
    lines = [f"# dolfingrip diagnose: {_sentence(found)}", "# fitted, with 90 % intervals:"]
    lines += [
        f"# {e.key} = {e.value:.4g} ({e.low:.4g} to {e.high:.4g})" for e in found.numbers(fit)
    ]
    extended = found.config.overridden(found.overrides(fit))
    return "\n".join(lines) + "\n" + configuration.dumps(extended)


def outcome_of(found: CouponDiagnosis, data: Sequence[str], out: Path) -> outcome.DiagnosisFile:
    """All that was found, by the schema."""
    decision, posterior = found.decision, found.posterior
    reference = posterior.best(NONE, level=0.0).log_evidence
    total: dict[tuple[str, ...], float] = {}
    for p, fit in zip(posterior.probability, posterior.fits, strict=True):
        total[fit.subset] = total.get(fit.subset, 0.0) + float(p)
    shown = sorted(total, key=lambda subset: -total[subset])[:8]
    fits = [posterior.best(subset) for subset in dict.fromkeys([decision.best.subset, *shown])]
    if NONE not in [fit.subset for fit in fits]:
        fits.append(posterior.best(NONE))
    inclusion = sorted(decision.inclusion.items(), key=lambda each: -each[1])
    result = outcome.DiagnosisFile(
        version=__version__,
        data=tuple(data),
        quick=found.held_out is None,
        readings=len(found.coupons.case.value),
        verdict=outcome.Verdict(
            answer=decision.answer, effects=decision.first, second=decision.second,
            probability=float(np.clip(decision.probability, 0, 1)),
            takes_part=float(np.clip(_takes_part(found), 0, 1)),
            unexplained=float(np.clip(decision.unexplained, 0, 1)), sentence=_sentence(found),
        ),
        classes=tuple(
            outcome.EffectClass(
                effects=(name,), probability=min(p, 1.0), members=(min(p, 1.0),),
                strength_sigma=_strength(found, name),
            )
            for name, p in inclusion
        ),
        none=min(decision.none, 1.0),
        unknown=min(max(decision.unknown, 0.0), 1.0),
        screen={
            fit.subset[0]: fit.log_evidence - reference
            for fit in posterior.fits if len(fit.subset) == 1 and fit.level == 0
        },
        fits=tuple(
            outcome.Fit(
                effects=fit.subset, log_evidence=fit.log_evidence - reference,
                parameters=tuple(
                    outcome.Parameter(key=e.key, value=e.value, low=e.low, high=e.high)
                    for e in found.numbers(fit)
                ),
                simulations=0,
            )
            for fit in fits
        ),
        differences=(),
        sentences=tuple(_off(found)),
        noise=outcome.Noise(
            std=_by_channel(found, found.coupons.errors.noise), correlated_std={},
            models={"as believed": 1.0},
            verdicts={name: _answer(each) for name, each in found.sensitivity.answers.items()},
            sentences=(*found.coupons.errors.sentences, _scatter(found)),
        ),
        nuisances=_nuisances(found),
        gain=tuple(
            outcome.Gain(
                left_out=e.kind, channel=e.channel, folds=e.folds, before=e.configured,
                nuisances=e.nuisances, process=e.process, cause=e.cause,
                cause_low=e.interval[0], cause_high=e.interval[1],
                by_nuisances_low=e.ratio[0], by_nuisances_high=e.ratio[1],
                log_odds_nuisances=e.log_odds[0], log_odds_process=e.log_odds[1],
            )
            for e in (found.held_out.errors if found.held_out else ())
        ),
        gain_claimed=found.held_out.claimed if found.held_out else None,
        next_experiments=tuple(
            outcome.NextExperiment(
                name=e.name, minutes=e.minutes, gain=e.gain, gain_per_minute=e.gain_per_minute,
                splits=e.splits, chance=e.chance,
            )
            for e in found.next
        ),
        suspicions=tuple(found.suspicions),
        warnings=tuple(found.warnings),
        extended=_changes(found),
        simulated_s=0.0,
    )  # fmt: skip
    return result.model_copy(update={"brief": _brief(found, result, out)})


def pictures(found: CouponDiagnosis) -> dict[str, Any]:
    """Plain data for the report."""
    case, listed = found.coupons.case, found.coupons.simulation.measurement.listed()
    rows = found.coupons.simulation.measurement.readings
    decision = found.decision
    after = fitted(found.coupons, decision.best)
    readings = listed.rename(columns={"column": "channel"}).assign(
        displacement_mm=rows["displacement_mm"].to_numpy()[listed["row"]],
        pressure_kPa=np.nan,
        run=listed["test"], noise=found.coupons.errors.noise, configured=case.base,
        before=fitted(found.coupons, found.none), after=after,
    )  # fmt: skip
    return {
        "readings": readings,
        "cause": " with ".join(decision.best.subset),
        "probabilities": {
            **{name.replace("_", " "): p for name, p in decision.inclusion.items()},
            "none": decision.none, "unknown": decision.unknown,
        },
        "gain": [
            {
                "left_out": e.kind, "channel": e.channel, "before": e.configured,
                "nuisances": e.nuisances, "process": e.process, "cause": e.cause,
                "interval": e.interval,
            }
            for e in (found.held_out.errors if found.held_out else ())
        ],
    }  # fmt: skip


# -- the ten lines -------------------------------------------------------------------------------


def _brief(found: CouponDiagnosis, result: outcome.DiagnosisFile, out: Path) -> outcome.Brief:
    decision = found.decision
    named = decision.answer == "cause"
    return outcome.Brief(
        result=brief.with_doubts(result, f"{_configured(found)} {_result(found)}"),
        size=_size(found),
        fit=_fit(found),
        check=_check(found),
        not_explained=_left(found),
        also_possible=_also(found),
        cannot_be_seen=_unseen(found),
        assumed=_assumed(found),
        do_next=_next(found),
        use_it=f"dolfingrip bend --config {out / 'extended.toml'}"
        if named
        else f"dolfingrip bend --config {out / 'extended.toml'} (the fitted modulus alone)",
    )


def _configured(found: CouponDiagnosis) -> str:
    """What is off as configured, and what was fitted for it."""
    case = found.coupons.case
    c = _factor(found, found.decision.best)
    off = case.value - case.base
    share = 100 * float(np.sqrt(np.mean(off**2) / np.mean(case.value**2)))
    told = [
        f"As configured the model is {_percent(share)} off (root mean square). A modulus "
        f"{_times(c)} the configured one is fitted."
    ]
    told += [f"{_of_the_rig(each)}." for each in of_the_rig(found.coupons, found.decision.best)
             if each.far]  # fmt: skip
    return " ".join(told)


def _times(factor: float) -> str:
    if 0.5 < factor < 2:
        return f"{abs(100 * (factor - 1)):.2g} % {'above' if factor > 1 else 'below'}"
    return f"{factor:.3g} times"


def _of_the_rig(each: OfTheRig) -> str:
    """In words, with units and with what was told."""
    sigma = abs(each.value) / each.told
    told = f"±{each.told:.2g} {each.unit} was told: {sigma:.1f} standard deviations"
    if each.name == SLACK:
        way = "early" if each.value > 0 else "late"
        return f"The coupons' force begins {abs(each.value):.2g} mm {way} ({told})"
    return f"{each.name} is off by {each.value:+.2g} {each.unit} ({told})"


def _result(found: CouponDiagnosis) -> str:
    decision = found.decision
    chance = _chance(decision.probability)
    if decision.answer == "none":
        return f"Nothing else is to be seen: probability {chance}."
    if decision.answer == "unknown":
        return f"Something is off that no effect of the catalogue explains: probability {chance}."
    if decision.first == found.coupons.case.scale_names:
        return (
            "Nothing else is off: either the material is so much stiffer or softer, or the "
            f"coupons' cross-section is another (modulus or coupon_area); probability {chance}."
        )
    told = brief.one_of(decision.first)
    if decision.second:
        told += f", together with {brief.one_of(decision.second)}"
    explained = 100 * (1 - decision.unexplained)
    least = found.sensitivity.least
    doubt = f"; {least:.2f} under other priors" if least < 0.9 * decision.probability else ""
    share = "all" if explained > 99.95 else f"{explained:.3g} %"
    return (
        f"The cause of the rest: {told}; probability {chance}{doubt}. It explains {share} of what "
        "the model misses."
    )


def _size(found: CouponDiagnosis) -> str:
    fit = found.decision.best
    numbers = ", ".join(_number(e) for e in found.numbers(fit))
    change = exact(found.coupons, fit) - exact(found.coupons, _without(found, fit))
    place = int(np.argmax(np.abs(change / found.coupons.errors.noise)))
    listed = found.coupons.simulation.measurement.listed().iloc[place]
    channel = CHANNELS[str(listed["column"])]
    if not fit.subset:
        return numbers
    return (
        f"{numbers}; at {listed['control']:.3g} mm it changes the {channel.title.lower()} by "
        f"{change[place]:+.3g} {channel.unit} of {listed['value']:.3g} {channel.unit}"
    )


def _fit(found: CouponDiagnosis) -> str:
    case = found.coupons.case
    before, plain = case.base, fitted(found.coupons, found.none)
    after = fitted(found.coupons, found.decision.best)
    named = bool(found.decision.best.subset)
    noise = _by_channel(found, found.coupons.errors.noise)
    parts = []
    for name, at in _channels(found).items():
        unit = CHANNELS[name].unit
        errors = [_rms((each - case.value)[at]) for each in (before, plain, after)]
        parts.append(
            f"{name}, root mean square: {errors[0]:.3g} {unit} as configured; {errors[1]:.3g} "
            f"{unit} with modulus, slack and each coupon's stiffness fitted"
            + (f"; {errors[2]:.3g} {unit} with the cause, too" if named else "")
            + f"; noise {noise[name]:.2g} {unit}"
        )
    return "; ".join(parts)


def _check(found: CouponDiagnosis) -> str:
    held = found.held_out
    if held is None:
        return "not done: nothing was named" if found.decision.answer != "cause" else "not done"
    parts = []
    for e in held.errors:
        unit = CHANNELS[e.channel].unit
        scale = ", its scale fitted" if e.kind == SPECIMENS else ""
        own = held.scatter.get(e.channel)
        against = f"; specimens scatter by {own:.2g} {unit}" if own else ""
        parts.append(
            f"{ONE_OF[e.kind]} left out in turn{scale}, causes chosen anew: {e.channel} is "
            f"foretold to {e.nuisances:.3g} {unit} without a cause, to {e.cause:.3g} {unit} with it"
            f"{against}"
        )
    worth = "better" if held.claimed else "no better"
    return (
        "; ".join(parts)
        + f"; the cause does {worth} than a fitted modulus and a smooth curve without a cause"
    )


def _left(found: CouponDiagnosis) -> str:
    decision = found.decision
    percent = 100 * decision.unexplained
    share = _percent(percent) if percent >= 0.01 else "less than 0.01 %"
    if decision.discrepancy < 0.5:
        return f"{share}; what is left is no larger than noise and scatter"
    case, along = found.coupons.case, found.coupons.errors.along
    rest = (case.value - fitted(found.coupons, decision.best)) / found.coupons.errors.noise
    bands = np.minimum((along.load / WIDTH_OF_A_BAND).astype(int), int(1 / WIDTH_OF_A_BAND) - 1)
    worst = max(set(bands), key=lambda band: _rms(rest[bands == band]))
    low, high = 100 * worst * WIDTH_OF_A_BAND, 100 * (worst + 1) * WIDTH_OF_A_BAND
    return f"{share}, most of it between {low:.0f} and {high:.0f} % of the largest strain"


def _also(found: CouponDiagnosis) -> str:
    decision = found.decision
    named = {*decision.first, *decision.second}
    rest = [
        f"{name} ({_chance(p)})"
        for name, p in sorted(decision.inclusion.items(), key=lambda each: -each[1])
        if name not in named and p >= 0.01
    ]
    return ", ".join(rest) or "no other cause has a probability of 0.01 or more"


def _unseen(found: CouponDiagnosis) -> str:
    """What these coupons cannot feel, and what no coupon can."""
    material = [n for n in found.coupons.unseen if effect(n).kind in ("elastic", "dissipative")]
    rest = [n for n in found.coupons.unseen if n not in material]
    told = []
    if material:
        told.append(f"{', '.join(material)} (other readings of coupons may tell)")
    if rest:
        told.append(f"what only a finger or another instrument feels: {', '.join(rest)}")
    return "; ".join(told) or "nothing of the catalogue is hidden"


def _assumed(found: CouponDiagnosis) -> str:
    numbers = found.numbers(found.decision.best)
    parameters = find(found.config, [key for key in moduli(found.config) if "bulk" not in key])
    configured = {each.key: each.value(found.config) for each in parameters}
    parts = [
        f"{e.key} {e.value:.3g} MPa ({e.low:.3g} to {e.high:.3g}; configured "
        f"{configured[e.key]:.3g} MPa)"
        for e in numbers if e.key in configured
    ]  # fmt: skip
    rig = of_the_rig(found.coupons, found.decision.best)
    parts += [f"{text[0].lower()}{text[1:]}" for text in map(_of_the_rig, rig)]
    parts.append(_scatter(found))
    if found.coupons.errors.guessed:
        parts.append("the noise is a guess: tell it under [noise]")
    parts += found.warnings[:1]
    return "; ".join(parts)


def _next(found: CouponDiagnosis) -> str:
    decision = found.decision
    if found.next:
        one = found.next[0]
        tells = "tells the causes apart" if one.splits else "may not tell all causes apart"
        return f"{one.name}: {one.minutes:.0f} minutes; it {tells}"
    if decision.answer == "unknown":
        return "a coupon, loading and unloading, at two rates: it would tell memory from elasticity"
    if decision.answer == "none":
        return "measure the finger: the coupons agree with the model"
    if decision.first == found.coupons.case.scale_names:
        return "measure the coupons' cross-section: it is told from the modulus by nothing else"
    named = [n for n in (*decision.first, *decision.second) if n not in found.coupons.case.rig]
    if _once(found) and any(effect(name).kind == "dissipative" for name in named):
        return (
            "a coupon, loading and unloading, with a wait of 60 s between: the curve's shape alone "
            "tells memory here; a loop and a force that fades would prove it"
        )
    return "measure the finger: no other cause is nearly as probable as the first"


# -- parts ---------------------------------------------------------------------------------------


def _sentence(found: CouponDiagnosis) -> str:
    decision = found.decision
    chance = _chance(decision.probability)
    if decision.answer == "none":
        return f"nothing beyond noise and nuisances is to be seen (probability {chance})"
    if decision.answer == "unknown":
        return f"something is off that the catalogue does not explain (probability {chance})"
    told = " or ".join(decision.first)
    if decision.second:
        told += f", with {' or '.join(decision.second)}"
    return f"the cause is {told} (probability {chance})"


def _answer(decision: Any) -> str:
    return " or ".join(decision.first) if decision.answer == "cause" else str(decision.answer)


def _takes_part(found: CouponDiagnosis) -> float:
    first = set(found.decision.first)
    if found.decision.first == found.coupons.case.scale_names:
        return found.decision.probability
    return sum(p for subset, p in found.decision.subsets.items() if first & set(subset))


def _strength(found: CouponDiagnosis, name: str) -> float:
    best = max(
        (
            (p, dict(zip(fit.subset, fit.strengths, strict=True))[name])
            for p, fit in zip(found.posterior.probability, found.posterior.fits, strict=True)
            if name in fit.subset
        ),
        default=(0.0, 0.0),
    )
    return float(best[1])


def _factor(found: CouponDiagnosis, fit: Fit) -> float:
    return float(found.coupons.case.factor(fit.zeta[0])[0])


def _without(found: CouponDiagnosis, fit: Fit) -> Fit:
    """The model at a fit's modulus without its causes."""
    none = found.none
    return Fit(
        NONE, 0.0, none.log_evidence, fit.zeta[:1], none.hessian, none.misfit, none.strengths
    )


def _nuisances(found: CouponDiagnosis) -> dict[str, float]:
    return {"modulus": float(np.log(_factor(found, found.decision.best))
                             / found.coupons.case.modulus_std)}  # fmt: skip


def _channels(found: CouponDiagnosis) -> dict[str, np.ndarray]:
    column = found.coupons.simulation.measurement.listed()["column"].to_numpy()
    return {str(name): column == name for name in dict.fromkeys(column)}


def _by_channel(found: CouponDiagnosis, values: np.ndarray) -> dict[str, float]:
    return {name: float(np.median(values[at])) for name, at in _channels(found).items()}


def _scatter(found: CouponDiagnosis) -> str:
    scatter = found.coupons.errors.scatter
    if not scatter.estimated:
        return "one specimen: its own deviation is taken as 0.3 %"
    return (
        f"specimens differ by {100 * scatter.scale:.2g} % in stiffness and by "
        f"{100 * scatter.shape:.2g} % in shape, by their own differences"
    )


def _once(found: CouponDiagnosis) -> bool:
    """Whether each coupon was pulled once, and no more."""
    listed = found.coupons.simulation.measurement.listed()
    return len(listed.groupby(["cycle", "branch"])) == 1


def _off(found: CouponDiagnosis) -> list[str]:
    """Where the model with the fitted modulus is off, in words."""
    case, along = found.coupons.case, found.coupons.errors.along
    off = fitted(found.coupons, found.none) - case.value
    largest = float(np.abs(found.coupons.simulation.measurement.readings["displacement_mm"]).max())
    told = []
    for name, at in _channels(found).items():
        for band in range(int(1 / WIDTH_OF_A_BAND)):
            low, high = band * WIDTH_OF_A_BAND, (band + 1) * WIDTH_OF_A_BAND
            own = at & (along.load > low) & (along.load <= high)
            if own.any():
                unit = CHANNELS[name].unit
                told.append(
                    f"{name}, {low * largest:.3g} to {high * largest:.3g} mm: simulated less "
                    f"measured {off[own].mean():+.3g} {unit} "
                    f"({100 * off[own].mean() / case.value[own].mean():+.2g} %)"
                )
    return told


def _changes(found: CouponDiagnosis) -> dict[str, Any]:
    """What ``extended.toml`` changes, by section."""
    after = found.config.overridden(found.overrides(found.decision.best))
    before = found.config.model_dump(mode="json", exclude_none=True)
    return {
        section: {k: v for k, v in values.items() if before.get(section, {}).get(k) != v}
        for section, values in after.model_dump(mode="json", exclude_none=True).items()
        if isinstance(values, dict) and values != before.get(section)
    }


def _number(e: Estimated) -> str:
    return f"{e.key} = {e.value:.3g} ({e.low:.3g} to {e.high:.3g})"


def _percent(value: float) -> str:
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _chance(p: float) -> str:
    return f"{p:.2f}" if p < 0.995 else "> 0.99"
