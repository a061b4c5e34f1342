"""A laboratory with a hidden finger: it measures what it is asked to, and tells how it tested."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import tomlkit
from support.stiffened import stiffened

from benchmarks.blind.fingers import finger
from benchmarks.blind.fingers.finger import GAIN, WALL, Protocol, Truth
from benchmarks.blind.frozen import FrozenCase
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.unknown import MODULUS
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.experiments.derivatives.gradients import MASS, shape_number
from dolfingrip.extensions.index import effect
from dolfingrip.files.diagnosis import NextExperiment, PlannedTest
from dolfingrip.parameter import named

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
        read: value and standard deviation of numbers that were read by themselves, by their keys
            in ``[nuisance]``.
        gauge_std_mm: of the plate's gap, which is read each time it is set; None where it is not.
    """

    protocol: Protocol
    truth: Truth
    workers: Workers
    seed: tuple[int, ...]
    tests: list[tuple[Protocol, pd.DataFrame | Path]] = field(default_factory=list)
    read: dict[str, tuple[float, float]] = field(default_factory=dict)
    gauge_std_mm: float | None = None

    @property
    def config(self) -> Config:
        """The model that is diagnosed."""
        return self.protocol.analysed()

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
        before = len(self.tests)
        try:
            for place, test in enumerate(advised.tests):
                self.tests.append(self._measured(test, rng, f"further-{turn}-{place}"))
        except (ConfigError, ValueError) as error:
            del self.tests[before:]
            raise NotPossible(f"{error}") from None
        for quantity in advised.quantities:
            noise = quantity.std * float(rng.standard_normal())
            if quantity.key == GAP:  # the same tool is at hand each time that the plate is set
                self.gauge_std_mm = quantity.std
            else:
                self.read[quantity.key] = self.true(quantity.key) + noise, quantity.std

    def true(self, key: str) -> float:
        """Return a hidden number.

        Args:
            key: by which it is told under ``[nuisance]``.
        """
        config = finger.configured(self.protocol, self.truth)
        if key == MODULUS:
            return self.truth.modulus
        if key == MASS:
            return shape_number(MASS, config, ())[0]
        if key.startswith(EXTENSIONS):
            _, name, number = key.split(".")
            on = config.extensions.inner.get(name)
            return (
                float(effect(name).neutral.get(number, 0.0))
                if on is None
                else (on.number_at(number))
            )
        return named(key).value(config.adapted())

    def _gap_mm(self, place: int) -> float:
        """The plate's gap at a measurement, as a gauge block tells it."""
        assert self.gauge_std_mm is not None
        rng = np.random.default_rng((*self.seed, 200 + place))
        truth = replace(self.truth, far=self.truth.far | self._far(place))
        true = finger.configured(self.tests[place][0], truth).plate.gap_mm
        return max(true + self.gauge_std_mm * float(rng.standard_normal()), 0.0)

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
        for place, (protocol, readings) in enumerate(self.tests):
            if isinstance(readings, Path):
                file = folder / readings.name
                file.write_text(readings.read_text(encoding="utf-8"), encoding="utf-8")
            else:
                file = finger.write(protocol, [readings], folder)
            setup = finger.told(protocol)
            read = dict(self.read)
            if self.gauge_std_mm is not None and "blocked_force" in protocol.tests:
                read[GAP] = self._gap_mm(place), self.gauge_std_mm
            setup["nuisance"] |= {
                key: {"value": value, "std": std} for key, (value, std) in read.items()
            }
            file.with_suffix(".toml").write_text(tomlkit.dumps(setup), encoding="utf-8")
            files.append(file)
        return files
