"""What can be explored: a configuration, parameters with their ranges, a design loop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from dolfingrip import config as configuration
from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.design.campaign.plan import FIELDS
from dolfingrip.design.campaign.space import Varied, parse
from dolfingrip.design.surrogate import surrogate as surrogates
from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.explore import policy
from dolfingrip.files.campaign import CampaignDesign
from dolfingrip.files.run import RunFile
from dolfingrip.parameter import named
from dolfingrip.report.design import label
from dolfingrip.report.page import front
from dolfingrip.report.page.content import FoundResult
from dolfingrip.sections.geometry.own import OwnChambers
from dolfingrip.sections.supply import AirLine, with_valve
from dolfingrip.sections.units import unit

Floats = npt.NDArray[np.float64]

DEFAULTS: Final = ("morph.xi1=-0.2:1", "morph.xi2=-0.5:1", "finger.wall_mm=1:3")
"""Parameters of a bellows finger where nothing says which."""

EXPERIMENTS: Final = ("bending", "blocked_force")
"""Experiments of one finger that the explorer shows."""


@dataclass(frozen=True, slots=True)
class Space:
    """Designs that can be explored.

    Attributes:
        base: configuration that parameters are put into; at rest where there is a supply.
        varied: parameters, and between what.
        chambers: those of them that are dimensions which chambers share, of each chamber alone.
        surrogate: of the designs; None if there is none.
        errors: its root mean square error on designs held out, by output.
        loop: campaign, surrogate and optimum of a design loop.
        supply: of air, that fills the solved designs.
    """

    base: Config
    varied: tuple[Varied, ...]
    chambers: tuple[Varied, ...]
    surrogate: Surrogate | None
    errors: Mapping[str, float]
    loop: front.Loop
    supply: AirLine | None = None

    @property
    def sliders(self) -> list[dict[str, Any]]:
        """A slider for each parameter, as the page makes them, with those of single chambers."""
        made = []
        for varied in self.varied:
            value = min(max(varied.parameter.value(self.base), varied.low), varied.high)
            alone = [_slider(one, self._given(one)) for one in self._chambers_of(varied)]
            made.append({**_slider(varied, value), "chambers": alone})
        return made

    def put(self, config: Config, inputs: Mapping[str, float]) -> Config:
        """Return a configuration with other values of parameters.

        Args:
            config: stays as it is.
            inputs: by key, of parameters and of single chambers.

        Raises:
            ConfigError: one line, if there is no such design.
        """
        integers = {varied.key for varied in self.varied if varied.parameter.integer}
        return changed(config, {k: int(v) if k in integers else v for k, v in inputs.items()})

    def place(self, config: Config) -> Floats:
        """Where a design lies: values in shares of the sliders' ranges, shape (parameters,).

        A dimension of all chambers counts as one, however many chambers share it.

        Args:
            config: of the design.
        """
        shares = []
        for varied in (*self.varied, *self.chambers):
            share = (varied.parameter.value(config) - varied.low) / (varied.high - varied.low)
            shares.append(share / math.sqrt(1 + len(self._chambers_of(varied))))
        return np.array(shares)

    def _chambers_of(self, varied: Varied) -> list[Varied]:
        """The dimension of each single chamber, of a shared or a single one of that name."""
        name = varied.key.rpartition(".")[2]
        alike = [one for one in self.chambers if one.key.rpartition(".")[2] == name]
        shared = varied in self.chambers or varied.key == f"{self.base.geometry_table}.{name}"
        return alike if shared else []

    def _given(self, chamber: Varied) -> float | None:
        """The value of a chamber's dimension where the base has one that is not the shared one."""
        _, _, number, name = chamber.key.split(".")
        geometry = self.base.geometry
        assert isinstance(geometry, OwnChambers)
        given = geometry.given(int(number) - 1)
        return next((value for dimension, _, value in given if dimension == name), None)

    @property
    def pressure(self) -> dict[str, Any] | None:
        """The slider of the highest pressure, as the page makes it; None if it is a parameter."""
        key = "experiment.max_pressure_kPa"
        if any(varied.key == key for varied in self.varied):
            return None
        value = self.base.experiment.max_pressure_kPa
        low, high = sorted(part * value for part in policy.PRESSURES)
        return {**_slider(Varied(named(key), low, high, None), value), "label": "Highest pressure"}


def of_results(
    results: Sequence[FoundResult],
    file: Path | None,
    overrides: Change,
    parameters: Sequence[str],
) -> Space:
    """The space of a design loop, of runs, or of a configuration.

    Args:
        results: folders with results.
        file: configuration in place of that of the results.
        overrides: values by key on top of it.
        parameters: ``KEY=LOW:HIGH`` of each slider; none: those of the results.

    Raises:
        ConfigError: one line.
    """
    campaigns, solved = (
        [result.folder for result in results if result.kind == kind] for kind in ("doe", "run")
    )
    loop = front.Loop.of(results)
    surrogate = surrogates.load(loop.surrogate) if loop.surrogate else None
    base = None if file is not None else front.base_of(loop) or _of_runs(solved)
    base = configuration.load(file, overrides) if base is None else changed(base, overrides)
    supply = base.supply
    if supply is not None:
        supply, base = with_valve(supply), base.at_rest()
    shapes = solved or any((folder / FIELDS).is_dir() for folder in campaigns)
    if "experiment.step_kPa" not in overrides and not shapes:  # else their steps are kept
        largest = base.experiment.max_pressure_kPa
        step = min(base.experiment.step_kPa, largest / policy.STEPS)
        base = base.changed(experiment={"step_kPa": step})
    varied = [parse(text) for text in parameters] or _ranges(surrogate, loop.designs, base)
    for v in varied:
        try:
            v.parameter.value(base)
        except (AttributeError, KeyError, IndexError, TypeError):
            raise ConfigError(
                f"--parameter {v.key}: not in this configuration; allowed: one that is"
            ) from None
    return Space(base, tuple(varied), _chambers(base, varied), surrogate, loop.errors, loop, supply)


def _slider(varied: Varied, value: float | None) -> dict[str, Any]:
    field = varied.parameter.field
    about = "" if field is None or not field.description else f": {field.description}"
    return {
        "key": varied.key, "label": label(varied.key).partition(" (")[0], "unit": unit(varied.key),
        "about": f"{varied.key}{about}", "low": varied.low, "high": varied.high, "value": value,
        "step": 1 if varied.parameter.integer else "any",
    }  # fmt: skip


def _chambers(base: Config, varied: Sequence[Varied]) -> tuple[Varied, ...]:
    """Dimensions of single chambers, in the ranges of those that all chambers share."""
    table, keys = base.geometry_table, {v.key for v in varied}
    shared = {f"{table}.{name}" for name in base.geometry.own} & keys
    number, count = base.geometry.count() if shared else ("", 0)
    if number in keys or base.mesh.file is not None:
        return ()
    chambers = []
    for v in varied:
        for i in range(count) if v.key in shared else ():
            key = f"{table}.override.{i + 1}.{v.key.rpartition('.')[2]}"
            if key not in keys:
                chambers.append(Varied(named(key), v.low, v.high, None))
    return tuple(chambers)


def _of_runs(folders: Sequence[Path]) -> Config | None:
    """The configuration of the first run of a finger."""
    for folder in folders:
        facts = RunFile.read(folder)
        if facts.experiment in EXPERIMENTS:
            data = {key: table for key, table in facts.config.items() if table}
            return configuration.from_dict(data)
    return None


def _ranges(
    surrogate: Surrogate | None, designs: Sequence[CampaignDesign], base: Config
) -> list[Varied]:
    """The parameters that the results vary, within the ranges there."""
    ranges: dict[str, tuple[float, float]] = {}
    if surrogate is not None:
        inputs = surrogate.inputs
        for i, name in enumerate(surrogate.input_names):
            ranges[name] = float(inputs.low[i]), float(inputs.high[i])
    for design in designs:
        for name, value in design.inputs.items():
            if isinstance(value, int | float):
                low, high = ranges.get(name, (value, value))
                ranges[name] = min(low, value), max(high, value)
    varied = [
        Varied(named(key, "--parameter"), low, high, None)
        for key, (low, high) in ranges.items()
        if low < high
    ]
    if varied:
        return varied
    if base.finger.kind != "bellows":
        raise ConfigError(
            "--parameter: nothing says what varies; allowed: KEY=LOW:HIGH for each slider"
        )
    return [parse(text) for text in DEFAULTS]
