"""What one tab asks for: a design, the experiment, and for a grasp the gripper and the food."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Any, Final

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.request import Request
from dolfingrip.explore import policy
from dolfingrip.explore.space import EXPERIMENTS, Space
from dolfingrip.sections.units import unit

VIEWS: Final = (*EXPERIMENTS, "grasp")
"""What can be shown."""

GRIPPER: Final = ("pose", "alpha_deg", "L_mm", "W_mm", "R_mm")
"""Keys of the gripper that have a control; one without a value follows from the pose."""

FOOD: Final = ("kind", "friction", "turn_deg")
"""Keys of the food that have one."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """A design to show.

    Attributes:
        view: one of :data:`VIEWS`.
        inputs: values of the parameters, and of single chambers that have their own, by key.
        config: with these, checked.
        refined: whether its mesh is as configured.
    """

    view: str
    inputs: Mapping[str, float]
    config: Config
    refined: bool = True

    @property
    def design(self) -> str:
        """Hash that tells it from other designs and experiments."""
        return self.request.key

    @property
    def coarse(self) -> Wanted | None:
        """The design on a mesh that is not graded, with few readings; None if it has no such mesh.

        Meshes of files, of tetrahedra and of the gripper are as they are configured.
        """
        config = self.config
        if self.view == "grasp" or config.mesh.file is not None or not config.hexahedra:
            return None
        size_mm, edge_mm = config.mesh.hexahedra_mm(config.geometry)
        if edge_mm >= size_mm:
            return None
        largest = abs(config.experiment.max_pressure_kPa)
        step = max(config.experiment.step_kPa, largest / policy.COARSE_STEPS)
        changes = {"mesh": {"edge_size_mm": size_mm}, "experiment": {"step_kPa": step}}
        return replace(self, config=config.changed(**changes), refined=False)

    @property
    def request(self) -> Request:
        """The simulation that solves it."""
        return Request.of(self.view, self.config)


def read(space: Space, message: Mapping[str, Any]) -> Wanted:
    """Read and check a tab's message.

    Args:
        space: what varies.
        message: from a tab.

    Raises:
        ConfigError: one line naming the key, its value and what is allowed.
    """
    view = message.get("view")
    if view not in VIEWS:
        raise ConfigError(f"view = {view}: allowed: {', '.join(VIEWS)}")
    given = _table(message, "inputs")
    inputs = {}
    for varied in (*space.varied, *(one for one in space.chambers if one.key in given)):
        value = number(varied.key, given.get(varied.key, varied.parameter.value(space.base)))
        if not varied.low <= value <= varied.high:
            range_ = f"{varied.low:g} to {varied.high:g} {unit(varied.key)}".rstrip()
            raise ConfigError(f"{varied.key} = {value:g}: allowed: {range_}")
        inputs[varied.key] = float(round(value)) if varied.parameter.integer else value
    config = space.put(space.base, inputs)
    if view == "grasp":
        config = _grasping(config, message)
    elif space.pressure is not None:
        config = pressurised(config, _pressure(message, space.base.experiment.max_pressure_kPa))
    return Wanted(view, inputs, config)


def curve(message: Mapping[str, Any], highest_kPa: float) -> tuple[list[float], list[float]]:
    """Read the curve that a supply should follow: a rise, a hold, a fall and a rest as long.

    Args:
        message: from a tab.
        highest_kPa: that is held.

    Returns:
        Times (s), and the pressures (kPa) there.

    Raises:
        ConfigError: one line naming the key, its value and what is allowed.
    """
    parts = []
    for key in ("rise_s", "hold_s"):
        value = number(key, _table(message, "curve").get(key))
        low, high = policy.CURVE_S
        if not low <= value <= high:
            raise ConfigError(f"{key} = {value:g}: allowed: {low:g} to {high:g} s")
        parts.append(value)
    times = [0.0, *accumulate(2 * parts)]
    return times, [0.0, highest_kPa, highest_kPa, 0.0, 0.0]


def pressurised(config: Config, largest_kPa: float) -> Config:
    """A configuration with another highest pressure and as many readings up to it.

    Args:
        config: of a finger.
        largest_kPa: of the experiment.

    Raises:
        ConfigError: one line, if it is not allowed.
    """
    before = config.experiment.max_pressure_kPa
    if largest_kPa == before:
        return config
    step = config.experiment.step_kPa * abs(largest_kPa / before) if before else abs(largest_kPa)
    return config.changed(experiment={"max_pressure_kPa": largest_kPa, "step_kPa": step or 1.0})


def _pressure(message: Mapping[str, Any], default: float) -> float:
    given = message.get("pressure_kPa")
    return default if given is None else number("pressure_kPa", given)


def _grasping(config: Config, message: Mapping[str, Any]) -> Config:
    """The configuration with the gripper, the food and the pressure of a grasp."""
    gripper, food = _table(message, "gripper"), _table(message, "food")
    tables: dict[str, dict[str, Any]] = {"gripper": {"preset": "coarse"}, "food": {}}
    for name, given, keys in (("gripper", gripper, GRIPPER), ("food", food, FOOD)):
        for key in keys:
            value = given.get(key)
            if value is None or value == "":
                continue
            tables[name][key] = value if isinstance(value, str) else number(key, value)
    if "kind" in tables["food"]:  # the size of the configuration's own food is of another kind
        tables["food"] |= {"width_mm": None, "length_mm": None, "height_mm": None}
    pressure = _pressure(message, policy.GRASP_KPA)
    tables["experiment"] = {
        "max_pressure_kPa": pressure, "step_kPa": min(policy.GRASP_STEP_KPA, pressure),
    }  # fmt: skip
    return config.changed(**tables)


def _table(message: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    table = message.get(key) or {}
    if not isinstance(table, Mapping):
        raise ConfigError(f"{key}: allowed: a table")
    return table


def number(key: str, value: Any) -> float:
    """Return a number that a tab has sent.

    Args:
        key: its name.
        value: as it came.

    Raises:
        ConfigError: one line, where it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{key} = {value}: allowed: a number")
    return float(value)
