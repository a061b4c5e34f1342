"""A campaign's plan: the designs that are asked for, each resolved and named by a hash."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dolfingrip.channels import FORCE
from dolfingrip.config import Config, ConfigError, felt, from_dict
from dolfingrip.design.campaign.objective import FUNCTION
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.quantities.index import parse, plugins_of
from dolfingrip.jobs.job import Job, content_key
from dolfingrip.sections import tables

FIELDS = "fields"
"""Folder in a campaign's with the deformed shapes of its designs."""

SCHEMA = 2
"""Version of what a key means; results of other versions are not reused."""

OBJECTIVE = "dolfingrip.design.campaign.objective:simulate"
"""Import path of what computes a design."""

QUANTITIES = ("cog_offset_mm", FORCE.name)
"""Quantities that a campaign has unless others are asked for: the paper's objectives."""


@dataclass(frozen=True, slots=True)
class Design:
    """One design to compute.

    Attributes:
        key: hash of all that its result depends on.
        inputs: the values of the parameters.
        config: resolved, as nested dictionaries.
    """

    key: str
    inputs: Inputs
    config: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Plan:
    """Designs that share everything but their inputs.

    Attributes:
        base: configuration that the inputs are put into.
        parameters: keys that vary.
        points: inputs of each design.
        quantities: outputs that are wanted.
        objective: import path ``module:function`` of what computes them.
        gradients: keys of parameters that the quantities are derived by, () for all of each
            design; None for what the objective derives anyway.
        fields: folder in which each design that is computed keeps its deformed shapes, under its
            key; None where only numbers are kept. It is no part of a design's key.
    """

    base: Config
    parameters: tuple[str, ...]
    points: tuple[Inputs, ...]
    quantities: tuple[str, ...] = QUANTITIES
    objective: str = OBJECTIVE
    gradients: tuple[str, ...] | None = None
    fields: Path | None = None

    def designs(self) -> list[Design]:
        """The designs in order, each once."""
        base = self.base.model_dump(mode="json")
        by_key: dict[str, Design] = {}
        for inputs in self.points:
            config = deepcopy(base)
            tables.put(config, inputs)
            key = self._key(config)
            by_key.setdefault(key, Design(key, inputs, config))
        return list(by_key.values())

    def _key(self, config: dict[str, Any]) -> str:
        content: dict[str, Any] = {
            "schema": SCHEMA,
            "objective": self.objective,
            "quantities": sorted(self.quantities),
            "config": felt(config),
        }
        if self.gradients is not None:
            content["gradients"] = self.gradients
        if used := plugins_of(self.quantities):
            content["plugin"] = used
        return content_key(content)

    def jobs(self, ranks: int = 1) -> list[Job]:
        """The designs as jobs.

        Args:
            ranks: MPI processes of each.
        """
        shared = {
            "quantities": self.quantities,
            "objective": self.objective,
            "ranks": ranks,
            "gradients": self.gradients,
        }

        def kept(design: Design) -> dict[str, str]:
            folder = self.fields
            return {} if folder is None else {"fields": str(folder.resolve() / design.key)}

        return [
            Job(
                design.key,
                FUNCTION,
                {"config": design.config, **shared, **kept(design)},
                design.inputs,
            )
            for design in self.designs()
        ]

    def shared(self, before: dict[str, Any] | None) -> dict[str, Any]:
        """Return what all designs of a campaign share, once these are added to it.

        Args:
            before: what they shared before; None: the campaign begins.

        Returns:
            The facts, with the parameters of both.

        Raises:
            ValueError: where the campaign was begun with other settings.
        """
        facts = self.facts()
        if before is None:
            return facts
        for difference in differences(before, facts):
            raise ValueError(difference)
        parameters = dict.fromkeys([*before["parameters"], *facts["parameters"]])
        return {**facts, "parameters": list(parameters)}

    def facts(self) -> dict[str, Any]:
        """Return what all designs share, to be compared with :func:`differences`."""
        return {
            "schema": SCHEMA,
            "objective": self.objective,
            "quantities": sorted(self.quantities),
            "parameters": list(self.parameters),
            "gradients": "not asked for"
            if self.gradients is None
            else ", ".join(self.gradients) or "by all parameters",
            "base": self.base.model_dump(mode="json"),
        }


def differences(before: dict[str, Any], now: dict[str, Any]) -> Iterator[str]:
    """Differences that keep two plans out of one campaign, one phrase each.

    Values of keys that either of them varies may differ: they stand with each design. Keys that no
    result depends on do not count, nor those that only one version has, at their defaults.
    """
    for name in ("schema", "objective", "quantities", "gradients"):
        if before.get(name) != now[name]:
            yield f"{name} was {before.get(name)}, now {now[name]}"
    free = {*before["parameters"], *now["parameters"]}
    bases = [_counted(facts["base"]) for facts in (before, now)]
    for section in {**bases[0], **bases[1]}:
        old, new = (base.get(section) or {} for base in bases)
        # a base that this version refuses has keys that do not count, too: equal ones are none
        dumped = [facts["base"].get(section) or {} for facts in (before, now)]
        same = {name for name in dumped[0] if dumped[0][name] == dumped[1].get(name)}
        same |= {name for name in {**old, **new} if f"{section}.{name}" in free}
        for name in {**old, **new}:
            if name not in same and old.get(name) != new.get(name):
                yield f"{section}.{name} was {old.get(name)}, now {new.get(name)}"


def _counted(base: dict[str, Any]) -> dict[str, Any]:
    """The values that results depend on, by section; all of a base that this version refuses."""
    try:
        return felt(from_dict(base))
    except ConfigError:
        return _told(base)


def _told(table: dict[str, Any]) -> dict[str, Any]:
    """A table without values that say nothing: None, and tables of such values."""
    cleaned = {k: _told(v) if isinstance(v, dict) else v for k, v in table.items()}
    return {k: v for k, v in cleaned.items() if v is not None and v != {}}


def quantities(texts: Sequence[str], objective: str = OBJECTIVE) -> tuple[str, ...]:
    """Return the quantities that are asked for, each once.

    Args:
        texts: of quantities, such as ``force_N at 250 kPa``.
        objective: import path of what computes them.

    Returns:
        Texts in their usual form; those of another objective as they are.

    Raises:
        ConfigError: one line, where one is unknown.
    """
    usual = objective == OBJECTIVE
    return tuple(dict.fromkeys(str(parse(text)) if usual else text for text in texts))
