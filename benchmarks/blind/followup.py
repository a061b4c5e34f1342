"""The experiment that a diagnosis proposes, made by the generator and diagnosed with the rest.

It hides the same causes in the same finger. The plate is set anew, with a gap of its own, and a new
coupon is a specimen of its own, whose stiffness differs by 1.5 %.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.blind import cases as casework
from benchmarks.blind import diagnoses, full, generator, noise
from benchmarks.blind.cases import Case
from benchmarks.blind.diagnoses import How
from benchmarks.blind.opinions import Opinion
from benchmarks.blind.protocols import PROTOCOLS, Course, Protocol
from benchmarks.blind.response import MODULUS_SPREAD, Truth
from dolfingrip.design.campaign.store import Store
from dolfingrip.diagnosis import selection
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.data.lab_setup import NUISANCES
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.page import LITTLE
from dolfingrip.diagnosis.simulation.job import result_of
from dolfingrip.diagnosis.simulation.runner import Workers

FOLDER: Final = "next"
"""Beside a case's diagnosis: the added files, and the diagnosis with them."""
STEPS: Final = ("cycle", "branch", "time_s")


@dataclass(frozen=True, slots=True)
class Added:
    """One test of a proposed experiment.

    Attributes:
        protocol: with this test alone.
        lab: set up otherwise than before, by section of the configuration and key.
        specimen: that is tested.
        truth: what is hidden, with this test's own nuisances.
    """

    protocol: Protocol
    lab: full.Sections
    specimen: str
    truth: Truth


def to_be_split(case: Case, content: Mapping[str, Any]) -> bool:
    """Whether the hidden cause was named in a tie, and an experiment proposed."""
    opinion = Opinion.of_file(content)
    tied = len(opinion.named) == 1 and len(opinion.named[0]) > 1 and opinion.right(case.hidden)
    further = content["next_experiments"]
    return case.kind == "one" and tied and bool(further) and further[0]["gain"] >= LITTLE


def split(case: Case, folder: Path, how: How, workers: Workers) -> dict[str, Any] | None:
    """The diagnosis with the experiment that was proposed first.

    Args:
        case: of which :func:`to_be_split` is true.
        folder: of the case.
        how: it is diagnosed.
        workers: with the store of the generator's own simulations.

    Returns:
        Content of its ``diagnosis.json``; None where the generator's simulation ended early.
    """
    out = folder / how.mode / FOLDER
    files = sorted(out.glob("added-*.csv"))
    if not files:
        files = _made(case, folder, how, workers)
    if not files:
        return None
    return diagnoses.diagnose_files(case, [folder / "measured.csv", *files], out, how)


def known(folder: Path, how: How) -> dict[str, Any] | None:
    """What :func:`split` found for a case of this folder; None where it has not been made."""
    return diagnoses.kept(folder / how.mode / FOLDER)


def _made(case: Case, folder: Path, how: How, workers: Workers) -> list[Path]:
    content = diagnoses.diagnose(case, folder, how)
    wanted = additions(case, _proposal(case, folder, content["next_experiments"][0]["name"]))
    runs = [full.runs(each.protocol, each.truth, each.lab) for each in wanted]
    jobs = [run.job for each in runs for run in each]
    workers.results(jobs)
    with Store(workers.store) as store:
        known = {row["key"]: result_of(row) for row in store.rows() if row["status"] != "pending"}
    out = folder / how.mode / FOLDER
    out.mkdir(parents=True, exist_ok=True)
    tables = []
    for number, (each, own) in enumerate(zip(wanted, runs, strict=True)):
        true = full.readings(each.protocol, each.truth, own, known)
        if true is None:
            return []
        read = casework.read_by(each.protocol, case.instruments, (*case.seed, 50 + number), true)
        tables.append(casework.rows(each.protocol, read.value, each.specimen))
    files = [out / f"added-{number}.csv" for number in range(len(wanted))]
    for file, each, table in zip(files, wanted, tables, strict=True):
        told = {**each.protocol.setup(), **each.lab}
        told["noise"] = case.instruments.told(noise.channels(each.protocol))
        casework.write_files(file, table, told)
    return files


def _proposal(case: Case, folder: Path, name: str) -> Proposal:
    """The proposal of this name, as the analyser makes it of the case's readings."""
    config = generator.analysed(PROTOCOLS[case.protocol])
    read, _ = selection.selected(measured.read([folder / "measured.csv"], config), config)
    return next(each for each in proposals(read, config) if each.name == name)


def additions(case: Case, proposal: Proposal) -> list[Added]:
    """The tests of a proposal, with what is hidden in them."""
    found = []
    for test in proposal.measurement.tests:
        columns = _columns(proposal.measurement, test)
        if columns:
            found.append(_added(case, proposal.measurement, test, columns, len(found)))
    return found


def _columns(planned: Measurement, test: SpecimenTest) -> tuple[str, ...]:
    rows = planned.rows(test.number)
    return tuple(name for name in READING_COLUMNS if rows[name].notna().any())


def _added(
    case: Case, planned: Measurement, test: SpecimenTest, columns: Sequence[str], number: int
) -> Added:
    before = PROTOCOLS[case.protocol]
    rows = planned.rows(test.number)[[*STEPS, test.control]].reset_index(drop=True)
    # what the generator's own protocol does not tell
    lab = _set_up(test)
    protocol = replace(
        before, courses=(Course(test.experiment, rows),), columns={test.experiment: columns},
        gap_mm=lab.get("plate", {}).get("gap_mm", before.gap_mm),
    )  # fmt: skip
    rng = np.random.default_rng((*case.seed, 40 + number))
    sigmas = dict(case.truth.nuisances)
    sigmas["plate_gap"] = casework.drawn_nuisances(rng, before)["plate_gap"]
    specimen = "A"
    if test.experiment == "coupon":
        specimen = "B"
        spread = NUISANCES["specimen_scale"][0] / MODULUS_SPREAD
        sigmas["modulus"] = case.truth.sigma("modulus") + spread * float(rng.standard_normal())
    return Added(protocol, lab, specimen, replace(case.truth, nuisances=sigmas))


def _set_up(test: SpecimenTest) -> dict[str, dict[str, Any]]:
    """How a test is set up, where the protocol of a case does not tell it."""
    sections = test.setup.sections
    if test.experiment == "coupon":
        strain = sections.get("coupon", {}).get("max_strain")
        return {} if strain is None else {"coupon": {"max_strain": strain}}
    names = ("plate", "gravity") if test.experiment == "blocked_force" else ("gravity",)
    return {name: dict(sections[name]) for name in names if name in sections}


def splits(case: Case, after: Mapping[str, Any]) -> bool:
    """Whether the hidden cause is named alone now."""
    opinion = Opinion.of_file(after)
    return opinion.answer == "cause" and opinion.named == (case.hidden,)


def narrows(case: Case, before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Whether its class is smaller than it was."""
    now, then = (Opinion.of_file(content).named for content in (after, before))
    return len(now) == 1 and case.hidden[0] in now[0] and len(now[0]) < len(then[0])
