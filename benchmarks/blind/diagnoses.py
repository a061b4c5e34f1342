"""What the analyser says of a case: the same functions as ``dolfingrip diagnose`` calls.

All cases share one store of simulations. A protocol's base and its effects are simulated once, as
missing readings leave its rows alone; what a further case costs are the fits. ``quick`` leaves
these out, too.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.blind import generator
from benchmarks.blind.cases import Case
from benchmarks.blind.opinions import Interval
from benchmarks.blind.protocols import PROTOCOLS
from dolfingrip.config import Config
from dolfingrip.diagnosis import diagnose as analyser
from dolfingrip.diagnosis import selection
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.results import write
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.workers import StayingWorkers, staying
from dolfingrip.jobs.run import Standing

RESULT: Final = "diagnosis.json"
PACKED: Final = Path(__file__).with_name("simulated")
"""Folder of the simulations in the repository."""
OF_ANALYSER: Final = "analyser-"
"""How the names of files begin that hold the analyser's simulations of one body's protocols."""
MODES: Final = ("quick", "whole")


@dataclass(frozen=True, slots=True)
class How:
    """How cases are diagnosed.

    Attributes:
        store: folder of the analyser's simulations.
        workers: number of processes.
        quick: by closed forms alone.
        effects: names of those that are tried; all where None.
        progress: called with each simulation.
        crew: workers that stay from case to case; each case starts its own where None.
    """

    store: Path
    workers: int = 1
    quick: bool = False
    effects: Sequence[str] | None = None
    progress: Callable[[Standing], None] = lambda standing: None
    crew: StayingWorkers | None = None

    @property
    def mode(self) -> str:
        """Name of the folder of the results."""
        return MODES[0] if self.quick else MODES[1]


@contextmanager
def with_crew(how: How) -> Iterator[How]:
    """``how`` with workers that stay until the ``with`` block ends.

    They know the simulations that come with the package, and those of :mod:`packed`.
    """
    with staying(how.store, how.workers, how.progress) as workers:
        known = workers.known
        for file in sorted(PACKED.glob(f"{OF_ANALYSER}*.npz")):
            packed = shipped.read(file)
            if known and packed:
                known = known.joined(packed)
        yield replace(how, crew=replace(workers, known=known))


def diagnose(case: Case, folder: Path, how: How) -> dict[str, Any]:
    """The content of a case's ``diagnosis.json``, computed where it is not there.

    Args:
        case: which.
        folder: with ``measured.csv``.
        how: it is diagnosed.
    """
    return diagnose_files(case, [folder / "measured.csv"], folder / how.mode, how)


def is_known(folder: Path, how: How) -> bool:
    """Whether a case of this folder has been diagnosed in this way."""
    return (folder / how.mode / RESULT).is_file()


def kept(folder: Path) -> dict[str, Any] | None:
    """The content of a folder's ``diagnosis.json``; None where there is none."""
    path = folder / RESULT
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def diagnose_files(case: Case, files: Sequence[Path], out: Path, how: How) -> dict[str, Any]:
    """Diagnose measured files with the results in ``out``; files that are there are read."""
    if not (out / RESULT).is_file():
        config = generator.analysed(PROTOCOLS[case.protocol])
        settings = settings_of(how)
        found = (
            analyser.diagnose(files, config, out, settings)
            if how.crew is None
            else _diagnosed(files, config, how.crew, settings)
        )
        write(found, files, out)
    content = kept(out)
    assert content is not None
    return content


def settings_of(how: How) -> analyser.Settings:
    """The analyser's settings."""
    return analyser.Settings(how.workers, how.store, how.quick, how.effects, progress=how.progress)


def _diagnosed(
    files: Sequence[Path], config: Config, crew: StayingWorkers, settings: analyser.Settings
) -> CouponDiagnosis:
    """A diagnosis like the analyser's, with one set of workers for all cases."""
    crew.spent_s.clear()
    measurement, notes = selection.selected(measured.read(files, config), config)
    found = analyser.judged(measurement, config, crew, settings)
    found.simulated_s = sum(crew.spent_s.values())
    found.warnings = [*notes, *found.warnings]
    return found


def intervals(case: Case, content: dict[str, Any]) -> tuple[Interval, ...]:
    """Intervals of the hidden effect's numbers where it was fitted alone, the modulus left out."""
    if case.kind != "one" or case.hidden[0] not in content["verdict"]["class"]:
        return ()
    (hidden,) = case.truth.causes
    cause = generator.causes()[hidden.name]
    values = cause.values(hidden.form, hidden.strength, case.truth.modulus)
    true = {
        f"extensions.{hidden.name}.{key}": float(np.ravel(value)[0])
        for key, value in values.items()
    }
    true[f"strength of {hidden.name}"] = hidden.strength
    for fit in content["fits"]:
        if fit["effects"] == [hidden.name]:
            return tuple(
                Interval(each["key"], each["low"], each["high"], true[each["key"]])
                for each in fit["parameters"]
                if each["key"] in true
            )
    return ()


def cut(content: dict[str, Any]) -> float | None:
    """By how much the cause cuts the error with nuisances alone; the mean over what is left out."""
    rows = content["gain"]
    if not rows:
        return None
    return float(np.mean([1 - row["cause"] / row["nuisances"] for row in rows]))
