"""What can be explored: a configuration, parameters with their ranges, a design loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.design.campaign.plan import FIELDS
from dolfingrip.design.campaign.space import Varied, parse
from dolfingrip.design.surrogate import surrogate as surrogates
from dolfingrip.design.surrogate.surrogate import Surrogate
from dolfingrip.explore.policy import POLICY
from dolfingrip.files.campaign import CampaignDesign
from dolfingrip.files.run import RunFile
from dolfingrip.parameter import named
from dolfingrip.report.design import label
from dolfingrip.report.page import front
from dolfingrip.report.page.contribution import FoundResult
from dolfingrip.sections.units import unit

DEFAULTS: Final = ("morph.xi1=-0.2:1", "morph.xi2=-0.5:1", "finger.wall_mm=1:3")
"""Parameters of a bellows finger where nothing says which."""

EXPERIMENTS: Final = ("bending", "blocked_force")
"""Experiments of one finger that the explorer shows."""


@dataclass(frozen=True, slots=True)
class Space:
    """Designs that can be explored.

    Attributes:
        base: configuration that parameters are put into.
        varied: parameters, and between what.
        surrogate: of the designs; None if there is none.
        errors: its root mean square error on designs held out, by output.
        loop: campaign, surrogate and optimum of a design loop.
    """

    base: Config
    varied: tuple[Varied, ...]
    surrogate: Surrogate | None
    errors: Mapping[str, float]
    loop: front.Loop

    @property
    def sliders(self) -> list[dict[str, Any]]:
        """A slider for each parameter, as the page makes them."""
        found = []
        for each in self.varied:
            value = min(max(each.parameter.value(self.base), each.low), each.high)
            whole, field = each.parameter.integer, each.parameter.field
            about = "" if field is None or not field.description else f": {field.description}"
            found.append(
                {
                    "key": each.key,
                    "label": label(each.key).partition(" (")[0],
                    "unit": unit(each.key),
                    "about": f"{each.key}{about}",
                    "low": each.low,
                    "high": each.high,
                    "value": value,
                    "step": 1 if whole else "any",
                }
            )
        return found

    @property
    def pressure(self) -> dict[str, Any] | None:
        """The slider of the highest pressure, as the page makes it; None if it is a parameter."""
        key = "experiment.max_pressure_kPa"
        if any(each.key == key for each in self.varied):
            return None
        value = self.base.experiment.max_pressure_kPa
        low, high = sorted(part * value for part in POLICY.pressures)
        about = f"{key}: highest pressure of the experiment"
        return {"key": key, "label": "Highest pressure", "unit": "kPa", "about": about, "low": low,
                "high": high, "value": value, "step": "any"}  # fmt: skip


def of_results(
    found: Sequence[FoundResult],
    file: Path | None,
    overrides: Change,
    parameters: Sequence[str],
) -> Space:
    """The space of a design loop, of runs, or of a configuration.

    Args:
        found: folders with results.
        file: configuration in place of that of the results.
        overrides: values by key on top of it.
        parameters: ``KEY=LOW:HIGH`` of each slider; none: those of the results.

    Raises:
        ConfigError: one line.
    """
    campaigns, solved = (
        [each.folder for each in found if each.kind == kind] for kind in ("doe", "run")
    )
    loop = front.Loop.of(found)
    surrogate = surrogates.load(loop.surrogate) if loop.surrogate else None
    base = None if file is not None else front.base_of(loop) or _of_runs(solved)
    base = configuration.load(file, overrides) if base is None else changed(base, overrides)
    shapes = solved or any((folder / FIELDS).is_dir() for folder in campaigns)
    if "experiment.step_kPa" not in overrides and not shapes:  # else their steps are kept
        largest = base.experiment.max_pressure_kPa
        step = min(base.experiment.step_kPa, largest / POLICY.steps)
        base = base.changed(experiment={"step_kPa": step})
    varied = [parse(text) for text in parameters] or _ranges(surrogate, loop.designs, base)
    for each in varied:
        try:
            each.parameter.value(base)
        except (AttributeError, KeyError, IndexError, TypeError):
            raise ConfigError(
                f"--parameter {each.key}: not in this configuration; allowed: one that is"
            ) from None
    return Space(base, tuple(varied), surrogate, loop.errors, loop)


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
        known = surrogate.inputs
        for i, name in enumerate(surrogate.input_names):
            ranges[name] = float(known.low[i]), float(known.high[i])
    for design in designs:
        for name, value in design.inputs.items():
            if isinstance(value, int | float):
                low, high = ranges.get(name, (value, value))
                ranges[name] = min(low, value), max(high, value)
    found = [
        Varied(named(key, "--parameter"), low, high, None)
        for key, (low, high) in ranges.items()
        if low < high
    ]
    if found:
        return found
    if base.finger.kind != "bellows":
        raise ConfigError(
            "--parameter: nothing says what varies; allowed: KEY=LOW:HIGH for each slider"
        )
    return [parse(text) for text in DEFAULTS]
