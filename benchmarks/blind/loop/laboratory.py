"""A laboratory with a hidden finger: it measures what it is asked to, and tells how it tested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import tomlkit
from support.stiffened import stiffened

from benchmarks.blind.fingers import finger
from benchmarks.blind.fingers.finger import GAIN, WALL, Protocol, Truth
from benchmarks.blind.frozen import FrozenCase
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.diagnosis.core.unknown import MODULUS
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.extensions.index import NAMES, effect
from dolfingrip.files.diagnosis import NextExperiment, PlannedQuantity, PlannedTest
from dolfingrip.parameter import every, scaled

EXTENSIONS: Final = "extensions."
GAP: Final = "plate.gap_mm"


class NotPossible(Exception):
    """An advice cannot be done as the result file tells it."""


def truth_of(case: FrozenCase, protocol: Protocol) -> Truth:
    """Return what is hidden in a case, by its file alone.

    Args:
        case: as it is kept.
        protocol: by which it was measured first.
    """
    numbers = dict(case.numbers)
    modulus = float(numbers.pop("modulus"))
    base = finger.configured(protocol, Truth())
    far = {
        "wall_offset": (numbers.pop("finger.wall_mm") / base.finger.wall_mm - 1) / WALL,
        "plate_gap": (numbers.pop(GAP) - base.plate.gap_mm) / protocol.gap_std_mm,
        "pressure_gain": (numbers.pop("extensions.pressure_gain.gain") - 1) / GAIN,
        "pressure_offset": numbers.pop("extensions.pressure_offset.offset_kPa")
        / protocol.offset_std_kPa,
    }
    return Truth(stiffened(numbers, 1 / modulus), modulus=modulus, far=far)


@dataclass(eq=False)
class Laboratory:
    """Measures a hidden finger, and keeps what it knows.

    Attributes:
        protocol: of its first measurement.
        truth: what is hidden.
        workers: where the hidden finger is simulated.
        seed: of all noise.
        tests: readings of each measurement, with the protocol that it was made by.
        numbers: that were read by themselves, by key of the configuration.
        nuisance: standard deviations of these, as entries of ``[nuisance]``.
        absent: effects that were read by themselves and do nothing.
        acting: effects that were read by themselves and act.
    """

    protocol: Protocol
    truth: Truth
    workers: Workers
    seed: tuple[int, ...]
    tests: list[tuple[Protocol, pd.DataFrame | Path]] = field(default_factory=list)
    numbers: dict[str, Any] = field(default_factory=dict)
    nuisance: dict[str, float] = field(default_factory=dict)
    absent: list[str] = field(default_factory=list)
    acting: list[str] = field(default_factory=list)

    @property
    def config(self) -> Config:
        """The model that is diagnosed, with the numbers that were read by themselves."""
        return changed(self.protocol.analysed(), self.numbers)

    @property
    def effects(self) -> tuple[str, ...] | None:
        """Causes that may be named; the whole catalogue where None."""
        return tuple(name for name in NAMES if name not in self.absent) if self.absent else None

    def do(self, advised: NextExperiment, turn: int) -> None:
        """Do what a result file advises.

        Args:
            advised: a further measurement, or a check.
            turn: number of the advice, which noise is drawn by.

        Raises:
            NotPossible: one phrase, why it cannot be done.
        """
        rng = np.random.default_rng((*self.seed, 100 + turn))
        if not advised.tests and not advised.quantities:
            raise NotPossible("neither tests nor quantities are told")
        if any(len(quantity.numbers) > 1 for quantity in advised.quantities):
            raise NotPossible("no file takes a sum of several numbers")
        before = len(self.tests)
        try:
            for place, test in enumerate(advised.tests):
                self.tests.append(self._measured(test, rng, f"further-{turn}-{place}"))
        except (ConfigError, ValueError) as error:
            del self.tests[before:]
            raise NotPossible(f"{error}") from None
        read: dict[str, list[tuple[str, float, PlannedQuantity]]] = {}
        for quantity in advised.quantities:
            (key,) = quantity.numbers
            noise = quantity.std * float(rng.standard_normal())
            owner = key.split(".")[1] if key.startswith(EXTENSIONS) else key
            read.setdefault(owner, []).append((key, self.true(key) + noise, quantity))
        for owner, numbers in read.items():
            self._tell(owner, numbers)

    def true(self, key: str) -> float:
        """Return a hidden number.

        Args:
            key: of the configuration, or of all moduli.
        """
        if key == MODULUS:
            return self.truth.modulus
        config = finger.configured(self.protocol, self.truth)
        there = {parameter.key: parameter.value(config) for parameter in every(config)}
        return there[key] if key in there else _resting(key)

    def _tell(self, owner: str, numbers: Sequence[tuple[str, float, PlannedQuantity]]) -> None:
        """Put numbers of one owner where the analyser reads them."""
        stds: dict[str, float] = {}
        for _, _, quantity in numbers:
            stds |= quantity.nuisance
        if owner == MODULUS:
            self.numbers |= scaled(self.protocol.analysed(), numbers[0][1])
        elif owner == GAP:  # the same tool is at hand each time that the plate is set
            self.tests = [(self._gauged(test, numbers[0][2].std, place), readings)
                          for place, (test, readings) in enumerate(self.tests)]  # fmt: skip
        elif owner in NAMES and not effect(owner).told.key:
            far = [abs(value - _resting(key)) / quantity.std for key, value, quantity in numbers]
            if max(far) < Policy().unlikely:
                self.absent.append(owner)
                return
            self.acting.append(owner)
            self.numbers |= {key: value for key, value, _ in numbers}
        else:
            self.numbers |= {key: value for key, value, _ in numbers}
        self.nuisance |= stds

    def _gauged(self, test: Protocol, std: float, place: int) -> Protocol:
        """A measurement whose plate was read with a gauge block."""
        rng = np.random.default_rng((*self.seed, 200 + place))
        truth = replace(self.truth, far=self.truth.far | self._far(place))
        true = finger.configured(test, truth).plate.gap_mm
        return replace(test, gap_mm=max(true + std * float(rng.standard_normal()), 0.0))

    def _far(self, place: int) -> Mapping[str, float]:
        """Where the plate truly is at a measurement: it is set anew each time but the first."""
        if not place:
            return {}
        rng = np.random.default_rng((*self.seed, 300 + place))
        return {"plate_gap": float(np.clip(rng.standard_normal(), -2, 2))}

    def _measured(
        self, test: PlannedTest, rng: np.random.Generator, name: str
    ) -> tuple[Protocol, pd.DataFrame]:
        """Readings of a test that is told in a result file."""
        settings = dict(test.settings)
        gap_mm = settings.pop(GAP, self.protocol.gap_mm)
        rows = pd.DataFrame({
            "cycle": test.cycle, "branch": test.branch, "time_s": test.time_s,
            test.control: test.value,
        })  # fmt: skip
        protocol = replace(
            self.protocol, name=name, tests={test.experiment: rows},
            columns={test.experiment: test.read}, settings=settings, gap_mm=gap_mm,
        )  # fmt: skip
        truth = replace(self.truth, far=self.truth.far | self._far(len(self.tests)))
        true = finger.measured(protocol, truth, self.workers)
        (readings,) = finger.scattered(protocol, true, rng)
        return protocol, readings

    def write(self, folder: Path) -> list[Path]:
        """Write all measurements so far, each with what is told of the set-up.

        Args:
            folder: that is written to.

        Returns:
            The tables.
        """
        folder.mkdir(parents=True, exist_ok=True)
        files = []
        for protocol, readings in self.tests:
            if isinstance(readings, Path):
                file = folder / readings.name
                file.write_text(readings.read_text(encoding="utf-8"), encoding="utf-8")
            else:
                file = finger.write(protocol, [readings], folder)
            setup = finger.told(protocol)
            setup["nuisance"] = {**setup["nuisance"], **self.nuisance}
            file.with_suffix(".toml").write_text(tomlkit.dumps(setup), encoding="utf-8")
            files.append(file)
        return files


def _resting(key: str) -> float:
    """Value of a number of an effect at which it does nothing, or which has no part in that."""
    _, name, number = key.split(".")
    return float(effect(name).neutral.get(number, 0.0))
