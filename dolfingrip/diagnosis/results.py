"""The files of a diagnosis: diagnosis.json, summary.md, extended.toml, and data for pictures.

``diagnosis.json`` has schema 3 (:class:`dolfingrip.files.diagnosis.DiagnosisFile`). It has named
fields and no sentence; all words are in :mod:`dolfingrip.files.diagnosis_words`, which makes three
lines and tables of these fields for ``summary.md``, the command, the report and the examples.

==================  ============================================================================
``headline``        one number with its interval, what a set has in common, the option to use it
``verdict``         answer, class, second, nearest; probability, and whether it is claimed
``causes``          each with its words, kind, probability, and whether it may act unseen
``fits``            the leading hypotheses and their numbers, the answer's first
``misfit, bands``   how far and where the model is off
``rig, nuisances``  numbers that were told, and how far off they are
``noise_std``       noise, its sources, ``scatter`` of specimens, those that stand ``apart``
``slips``           doubts about units, signs and columns; ``artefacts`` of instruments
``hides, behind``   effects that are not seen, and the numbers they hide behind
``other_priors``    the answer under each
``gain``            errors on readings that were left out
``next``            ``next_experiments`` and ``advice``: what to measure next
==================  ============================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.refining import extrapolated
from dolfingrip.diagnosis.answer.settling import advice
from dolfingrip.diagnosis.answer.statistics import bands, common_change, misfit, rig_numbers
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import NONE
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.extensions.index import NAMES, effect
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files import whole
from dolfingrip.files.diagnosis_words import BODY, NUMBERS, lines, number_words, page, sections
from dolfingrip.files.plan import PlanFile
from dolfingrip.sections.tables import assignment
from dolfingrip.version import __version__


def plan_text(result: PlanFile) -> str:
    """Write a plan as one page of text.

    Args:
        result: the plan.

    Returns:
        Markdown.
    """
    rig = ", ".join(result.experiments)
    text = [
        f"# {rig}: {100 * result.share:.0f} % of the effects of the catalogue would be named, "
        f"{100 * result.class_share:.0f} % up to effects that change these readings alike",
        "",
        f"{result.readings} readings in {result.minutes:.1f} minutes of pressure. Named: a "
        "diagnosis of these readings would answer with this effect alone. Assumed: one effect "
        "acts, at a strength from its prior, under the noise of these instruments; in "
        f"{100 * (1 - Policy().discrepancy_off):.0f} % of cases something acts beside it that no "
        "effect is.",
        "",
    ]
    effects, *additions = result.tables()
    return sections([*text, *effects.markdown()], additions, result.warnings)


def write(
    diagnosis: Diagnosis, data: Sequence[Path], out: Path
) -> tuple[outcome.DiagnosisFile, pd.DataFrame]:
    """Write all files but the pictures.

    Args:
        diagnosis: with its answer.
        data: files that were diagnosed.
        out: folder.

    Returns:
        Contents of ``diagnosis.json`` and of ``readings.csv``.

    Raises:
        WriteError: one line.
    """
    file = out / "extended.toml"
    extended = _extended(diagnosis, diagnosis.decision.best, file)
    result = _content(diagnosis, tuple(map(str, data)), file, extended)
    for stale in out.glob("extended*.toml"):
        stale.unlink()
    if extended:
        _write_extended(file, extended, result, result.fits[0].parameters)
    for name, fit in diagnosis.members.items():
        other = out / f"extended.{name}.toml"
        if with_member := _extended(diagnosis, fit, other):
            _write_extended(other, with_member, result, diagnosis.numbers(fit))
    result.write(out)
    readings = _readings(diagnosis)
    whole.write(out / "summary.md", page(result))
    whole.write(out / outcome.READINGS, readings.to_csv(index=False))
    return result, readings


def _extended(diagnosis: Diagnosis, fit: MapFit, file: Path) -> Config | None:
    """The configuration at a fit's numbers; None where it is refused, or the data are doubted."""
    if diagnosis.slips:
        return None
    try:
        return diagnosis.extended(fit)
    except ConfigError as error:
        diagnosis.warnings.append(f"{file.name} is not written: {error}")
        return None


def _write_extended(
    file: Path,
    extended: Config,
    result: outcome.DiagnosisFile,
    numbers: Sequence[outcome.FittedNumber],
) -> None:
    """Write a configuration; the answer and numbers with intervals are comments before it."""
    comments = [f"dolfingrip diagnose: {lines(result)[0]}", "fitted, with 90 % intervals:"]
    comments += [number_words(number) for number in numbers]
    head = "".join(f"# {comment}\n" for comment in comments)
    whole.write(file, head + configuration.dumps(extended))


def _content(
    diagnosis: Diagnosis, data: tuple[str, ...], file: Path, extended: Config | None
) -> outcome.DiagnosisFile:
    """All that was found, by the schema.

    Args:
        diagnosis: with its answer.
        data: files that were diagnosed.
        file: of the extended configuration.
        extended: that configuration; None where it is refused.
    """
    decision, posterior, analysis = diagnosis.decision, diagnosis.posterior, diagnosis.analysis
    best, causes, plain = decision.best, posterior.problem.causes, analysis.fitted(diagnosis.none)
    reference = posterior.best(NONE, level=0.0).log_evidence
    alone = dict.fromkeys(causes(fit.subset) for fit in posterior.fits if fit.level == 0)
    likely = sorted(posterior.subsets, key=lambda subset: -posterior.subsets[subset])[:10]
    members = [fit.subset for fit in diagnosis.members.values()]
    named = [
        subset for subset in alone
        if len(subset) == 1 and subset[0] in (*decision.first, *decision.second)
    ]  # fmt: skip
    shown = dict.fromkeys(map(causes, (best.subset, *members, *named, *likely, NONE)))
    fits = tuple(
        outcome.FittedHypothesis(
            effects=fit.subset, log_evidence=fit.log_evidence - reference,
            parameters=tuple(diagnosis.numbers(fit)),
        )
        for fit in map(posterior.best, shown)
    )  # fmt: skip
    deviations = analysis.nuisances(best)
    return outcome.DiagnosisFile(
        version=__version__, data=data, quick=diagnosis.quick,
        readings=len(posterior.problem.value), verdict=diagnosis.verdict,
        headline=_headline(diagnosis, fits[0].parameters, file if extended else None),
        causes=_causes(diagnosis), none=min(decision.none, 1.0),
        unknown=min(max(decision.unknown, 0.0), 1.0),
        fits=fits, misfit=misfit(analysis, plain, analysis.fitted(best)),
        bands=tuple(band for band, *_ in bands(analysis, plain)),
        rig=tuple(rig_numbers(analysis, best, deviations)), nuisances=deviations,
        noise_sources=analysis.errors.sources,
        noise_std={
            name: float(np.median(analysis.errors.noise[at]))
            for name, at in analysis.measurement.channels().items()
        },
        scatter=analysis.errors.scatter,
        artefacts=tuple(
            outcome.ArtefactSize(
                name=artefact.nuisance.name, unit=artefact.nuisance.unknown.unit,
                size=deviations[artefact.nuisance.name] * artefact.nuisance.std,
            )
            for artefact in diagnosis.artefacts
        ),
        apart=diagnosis.apart, hides=diagnosis.hidden(),
        behind=tuple(dict.fromkeys(n for other in diagnosis.alternatives for n in other.behind)),
        other_priors=tuple(
            outcome.OtherPrior(
                prior=name, answer=other.answer, effects=(*other.first, *other.second),
                probability=float(np.clip(diagnosis.sensitivity.probability[name], 0, 1)),
            )
            for name, other in diagnosis.sensitivity.answers.items()
        ),
        gain=diagnosis.gain, gain_claimed=diagnosis.gain_claimed,
        next_experiments=tuple(diagnosis.next), advice=advice(diagnosis),
        downstream=diagnosis.downstream, slips=tuple(diagnosis.slips),
        not_reached=tuple(analysis.simulation.not_reached), not_tried=tuple(analysis.not_tried),
        failed=dict(analysis.failed), mesh_known=analysis.closed_form or bool(analysis.mesh_errors),
        extrapolated=extrapolated(posterior.problem, best) > posterior.problem.policy.exactly,
        warnings=tuple(diagnosis.warnings),
        extended=_changes(diagnosis.config, extended) if extended else {},
        simulated_s=diagnosis.simulated_s,
    )  # fmt: skip


def _causes(diagnosis: Diagnosis) -> tuple[outcome.CauseProbability, ...]:
    """All causes, the most probable first."""
    open_names, strengths = diagnosis.open_names, diagnosis.posterior.strengths
    inclusion = dict.fromkeys(diagnosis.decision.first, 0.0) | diagnosis.decision.inclusion
    return tuple(
        outcome.CauseProbability(
            name=name, probability=min(probability, 1.0), strength_sigma=strengths.get(name, 0.0),
            words=diagnosis.words(name) if name in NAMES else NUMBERS.get(name, ""),
            kind=effect(name).kind if name in NAMES else "", open=name in open_names,
        )
        for name, probability in sorted(inclusion.items(), key=lambda item: -item[1])
    )  # fmt: skip


def _headline(
    diagnosis: Diagnosis, numbers: Sequence[outcome.FittedNumber], file: Path | None
) -> outcome.Headline:
    """The number that the answer is about, and the option of other commands that uses it.

    It is that of a cause that is named, and first of one that is a number of the model, else the
    model's own number that changes the readings most. The option sets it alone where nothing else
    that was fitted is seen.

    Args:
        diagnosis: with its answer.
        numbers: of the leading fit.
        file: extended configuration; None where it is refused.
    """
    decision, analysis, problem = diagnosis.decision, diagnosis.analysis, diagnosis.analysis.problem
    fit = decision.best
    far = [name for name in problem.implausible if name in decision.first]
    if far:  # without causes beside it, where such a fit is possible
        fit = diagnosis.member(far[0])
        numbers = diagnosis.numbers(fit)
    values, causes = analysis.overrides(fit), problem.causes(fit.subset)
    by_key = {number.key: number for number in reversed(numbers)}
    # which of ζ each of the model's own numbers is; all moduli are one
    places = {
        place: by_key[number.key]
        for place, number in enumerate(problem.always) if place and number.role == "always"
    }  # fmt: skip
    places[0] = numbers[0]
    used = [place for place in places if place == 0 or places[place].key in values]
    named = [(name, places[problem.implausible[name]]) for name in far]
    of_causes = [(number.part, number) for number in numbers if number.part in causes]
    named += sorted(of_causes, key=lambda item: item[0] not in decision.first)
    most = max(used, key=lambda place: _change(diagnosis, fit, [place]))
    cause, number = named[0] if named and decision.answer == "cause" else ("", places[most])
    others = [place for place in used if places[place] is not number]
    alike = [other for other in numbers if other.part in (causes or ["material"])]
    held = any(analysis.causes[name].held for name in causes)
    alone = not held and (alike == [number] or (not causes and number.part != "material"))
    alone = alone and number.key in values
    alone = alone and _change(diagnosis, fit, others) < diagnosis.policy.visible
    option = f"--config {file}" if file else ""
    if file and alone:
        listed = isinstance(values[number.key], list)
        option = f"--set {assignment(number.key, number.value, listed=listed)}"
    common = None
    if decision.answer == "cause":
        kinds = {effect(name).kind if name in NAMES else "" for name in decision.first}
        fits = [analysis.fitted(fit) for fit in (decision.best, *diagnosis.members.values())]
        common = common_change(analysis, np.array(fits), of_body=kinds <= {*BODY})
    return outcome.Headline(number=number, cause=cause, common=common, option=option)


def _change(diagnosis: Diagnosis, fit: MapFit, places: Sequence[int]) -> float:
    """Length of the readings' change by some of the model's own numbers, standard deviations.

    Args:
        diagnosis: with its answer.
        fit: whose numbers they are.
        places: which of ζ these are.
    """
    problem = diagnosis.analysis.problem
    as_told = np.where(np.isin(np.arange(len(fit.zeta)), places), 0.0, fit.zeta)
    change = problem.predicted(fit.subset, as_told) - problem.predicted(fit.subset, fit.zeta)
    return float(np.linalg.norm(change / diagnosis.analysis.errors.noise))


def _readings(diagnosis: Diagnosis) -> pd.DataFrame:
    """The table of readings, measured and simulated."""
    analysis = diagnosis.analysis
    listed, rows = analysis.measurement.listed, analysis.measurement.readings
    return listed.rename(columns={"column": "channel"}).assign(
        displacement_mm=rows["displacement_mm"].to_numpy()[listed["row"]],
        pressure_kPa=rows["pressure_kPa"].to_numpy()[listed["row"]],
        run=listed["test"], noise=analysis.errors.noise, configured=analysis.configured,
        before=analysis.fitted(diagnosis.none), after=analysis.fitted(diagnosis.decision.best),
        **{f"after_{name}": analysis.fitted(fit) for name, fit in diagnosis.members.items()},
    )  # fmt: skip


def _changes(config: Config, extended: Config) -> dict[str, Any]:
    """Changes of ``extended.toml``, by section."""
    before = config.model_dump(mode="json", exclude_none=True)
    return {
        section: {k: v for k, v in values.items() if before.get(section, {}).get(k) != v}
        for section, values in extended.model_dump(mode="json", exclude_none=True).items()
        if isinstance(values, dict) and values != before.get(section)
    }
