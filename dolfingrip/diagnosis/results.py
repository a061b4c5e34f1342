"""The files of a diagnosis: diagnosis.json, extended.toml, summary.md, and data for pictures.

A diagnosis, and a plan, is one page of text, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.ten_lines import (
    answer_sentence,
    chance,
    scatter,
    ten_lines,
)
from dolfingrip.diagnosis.core.decision import held
from dolfingrip.diagnosis.core.evidence import NONE, MapFit
from dolfingrip.diagnosis.data.motion import smallest_change
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.policy import PAGE, POLICY
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files import whole
from dolfingrip.files.plan import PlanFile
from dolfingrip.files.table import TextTable
from dolfingrip.version import __version__


def section(title: str, lines: Iterable[str]) -> list[str]:
    """Lines below a heading."""
    return ["", f"## {title}", "", *lines]


def plan_text(result: PlanFile) -> str:
    """Write a plan as one page of text.

    Args:
        result: the plan.

    Returns:
        Markdown.
    """
    rig = ", ".join(result.experiments)
    lines = [
        f"# {rig}: {100 * result.share:.0f} % of the effects of the catalogue would be named, "
        f"{100 * result.class_share:.0f} % up to effects that change these readings alike",
        "",
        f"{result.readings} readings in {result.minutes:.1f} minutes of pressure. Named: a "
        "diagnosis of these readings would answer with this effect alone. Assumed: one effect "
        "acts, at a strength from its prior, under the noise of these instruments; in "
        f"{100 * (1 - POLICY.discrepancy_off):.0f} % of cases something acts beside it that no "
        "effect is.",
        "",
    ]
    effects, *additions = result.tables()
    lines += effects.markdown()
    for each in additions:
        lines += section(each.title, each.markdown())
    if result.warnings:
        lines += section("Beware", (f"- {each}" for each in result.warnings))
    return "\n".join(lines) + "\n"


def page(result: outcome.DiagnosisFile) -> str:
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
    for each in result.tables():
        lines += section(each.title, each.markdown())
    if result.downstream:
        lines += ["", f"{result.downstream.sentence}."]
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
    rows = [[name, chance(p)] for name, p in (*shown, *result.beside_causes.items())]
    return TextTable(["cause", "probability that it takes part"], rows).markdown()


@dataclass(frozen=True)
class Written:
    """Results of a diagnosis that were written.

    Attributes:
        text: of the summary.
        result: content of ``diagnosis.json``.
        readings: content of ``readings.csv``.
    """

    text: str
    result: outcome.DiagnosisFile
    readings: pd.DataFrame


def write(found: Diagnosis, data: Sequence[Path], out: Path) -> Written:
    """Write all files but the pictures.

    Args:
        found: the diagnosis.
        data: files that were diagnosed.
        out: folder.

    Returns:
        What was written.

    Raises:
        WriteError: one line.
    """
    extended = _extended(found, found.decision.best, out / "extended.toml")
    for stale in out.glob("extended.*.toml"):
        stale.unlink()
    for name, fit in found.members.items():
        _extended(found, fit, out / f"extended.{name}.toml")
    result = _outcome_of(found, extended, [str(file) for file in data], out)
    result.write(out)
    text = page(result)
    whole.write(out / "summary.md", text)
    readings = _readings(found)
    whole.write(out / outcome.READINGS, readings.to_csv(index=False))
    return Written(text, result, readings)


def _extended(found: Diagnosis, fit: MapFit, file: Path) -> Config | None:
    """Write the configuration at a fit's numbers, these with intervals as comments before it."""
    try:
        extended = found.extended(fit)
    except ConfigError as error:
        found.warnings.append(f"{file.name} is not written: {error}")
        return None
    lines = [f"# dolfingrip diagnose: {answer_sentence(found)}", "# fitted, with 90 % intervals:"]
    lines += [f"# {each.words(digits=4)}" for each in found.numbers(fit)]
    whole.write(file, "\n".join(lines) + "\n" + configuration.dumps(extended))
    return extended


def _outcome_of(
    found: Diagnosis, extended: Config | None, data: Sequence[str], out: Path
) -> outcome.DiagnosisFile:
    """All that was found, by the schema."""
    decision, posterior = found.decision, found.posterior
    errors, channels = found.analysis.errors, found.analysis.measurement.channels()
    reference = posterior.best(NONE, level=0.0).log_evidence
    total = posterior.subsets
    shown = sorted(total, key=lambda subset: -total[subset])[:8]
    causes = posterior.problem.causes
    members = [fit.subset for fit in found.members.values()]
    alone = dict.fromkeys(causes(fit.subset) for fit in posterior.fits if fit.level == 0)
    named = [
        each for each in alone if len(each) == 1 and each[0] in (*decision.first, *decision.second)
    ]
    known = dict.fromkeys(map(causes, (decision.best.subset, *members, *named, *shown, NONE)))
    fits = [posterior.best(subset) for subset in known]
    strengths = posterior.strengths
    inclusion = sorted(decision.inclusion.items(), key=lambda each: -each[1])
    return outcome.DiagnosisFile(
        version=__version__,
        data=tuple(data),
        quick=found.quick,
        readings=len(found.analysis.problem.value),
        verdict=outcome.Verdict(
            answer=decision.answer, effects=decision.first, second=decision.second,
            probability=found.probability, claimed=found.claimed,
            takes_part=float(np.clip(held(decision.subsets, decision.first), 0, 1)),
            unexplained=float(np.clip(decision.unexplained, 0, 1)), sentence=answer_sentence(found),
        ),
        brief=ten_lines(found, out),
        causes=tuple(
            outcome.CauseProbability(
                name=n, probability=min(p, 1.0), strength_sigma=strengths.get(n, 0.0)
            )
            for n, p in inclusion
        ),
        none=min(decision.none, 1.0),
        unknown=min(max(decision.unknown, 0.0), 1.0),
        screen={
            each[0]: posterior.best(each, level=0.0).log_evidence - reference
            for each in alone if len(each) == 1
        },
        fits=tuple(
            outcome.FittedHypothesis(
                effects=fit.subset, log_evidence=fit.log_evidence - reference,
                parameters=tuple(found.numbers(fit)),
            )
            for fit in fits
        ),
        sentences=tuple(_off(found)),
        noise=outcome.AssumedNoise(
            std={name: float(np.median(errors.noise[at])) for name, at in channels.items()},
            sentences=(*errors.sentences, scatter(found)),
        ),
        under_other_priors={
            name: " or ".join(each.first) if each.answer == "cause" else each.answer
            for name, each in found.sensitivity.answers.items()
        },
        nuisances=found.nuisances(found.decision.best),
        gain=found.held_out.errors if found.held_out else (),
        gain_claimed=found.held_out.claimed if found.held_out else None,
        next_experiments=tuple(found.next),
        downstream=found.downstream,
        suspicions=tuple(found.suspicions),
        warnings=tuple(found.warnings),
        extended=_changes(found.config, extended) if extended else {},
        not_reached=tuple(found.analysis.not_reached),
        simulated_s=found.simulated_s,
    )  # fmt: skip


def _readings(found: Diagnosis) -> pd.DataFrame:
    """The table of readings, measured and simulated."""
    listed = found.analysis.measurement.listed
    rows = found.analysis.measurement.readings
    return listed.rename(columns={"column": "channel"}).assign(
        displacement_mm=rows["displacement_mm"].to_numpy()[listed["row"]],
        pressure_kPa=rows["pressure_kPa"].to_numpy()[listed["row"]],
        run=listed["test"], noise=found.analysis.errors.noise, configured=found.analysis.configured,
        before=found.with_best_modulus(), after=found.analysis.fitted(found.decision.best),
        **{f"after_{name}": found.analysis.fitted(fit) for name, fit in found.members.items()},
    )  # fmt: skip


def _off(found: Diagnosis) -> list[str]:
    """Where the model is off with the modulus that leaves least, in words."""
    problem, along = found.analysis.problem, found.analysis.errors.along
    off = found.with_best_modulus() - problem.value
    listed = found.analysis.measurement.listed
    experiment, control = listed["experiment"].to_numpy(), listed["control"].to_numpy()
    sentences = []
    for of in dict.fromkeys(experiment):
        for name, at in found.analysis.measurement.channels().items():
            here = at & (experiment == of)
            if not here.any():
                continue
            largest = max(float(np.abs(control[here]).max()), 1e-12)
            rest = smallest_change(control[here], 0.0) / largest
            for band, way in product(range(int(1 / PAGE.band)), (1.0, -1.0)):
                low, high = band * PAGE.band, (band + 1) * PAGE.band
                load = way * along.load
                own = here & (load > (low if way > 0 else max(low, rest))) & (load <= high)
                if own.any():
                    unit = CHANNELS[name].unit
                    sentences.append(
                        f"{of}, {name}, {way * low * largest:z.3g} to {way * high * largest:.3g} "
                        f"{CHANNELS[CONTROL[of]].unit}: simulated less measured "
                        f"{off[own].mean():+.3g} {unit} "
                        f"({100 * off[own].mean() / abs(problem.value[own].mean()):+.2g} %)"
                    )
    return sentences


def _changes(config: Config, extended: Config) -> dict[str, Any]:
    """Changes of ``extended.toml``, by section."""
    before = config.model_dump(mode="json", exclude_none=True)
    return {
        section: {k: v for k, v in values.items() if before.get(section, {}).get(k) != v}
        for section, values in extended.model_dump(mode="json", exclude_none=True).items()
        if isinstance(values, dict) and values != before.get(section)
    }
