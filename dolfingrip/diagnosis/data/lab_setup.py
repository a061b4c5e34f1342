"""How the laboratory tested: the TOML file of a measured CSV.

    experiment = ["bending", "blocked_force"]   # one text where there is one
    rate_kPa_per_s = 2.0                        # where the CSV has no time_s
    max_pressure_kPa = 27.5                     # readings above are not compared
    [finger]                                    # what differs from the configuration's finger
    wall_mm = 1.8
    [plate]
    gap_mm = 1.0
    tilt_deg = 0.0
    [gravity]
    direction = [0, 0, -1]
    [angle]                                     # between which points chord_angle_deg is
    from = "clamp"
    to = "tip"
    [specimen.B.finger]                         # of one specimen alone; [specimen.B.cast], …
    wall_mm = 1.7
    [noise]                                     # standard deviations by column
    angle_deg = 0.3
    [noise.correlated]                          # of the part that drifts along a run
    angle_deg = 0.2
    correlation_time_s = 60                     # within which it is alike; absent: in the whole run
    correlation_length_mm = 0.2                 # of the markers' motion, within which it is alike
    [nuisance]                                  # what the laboratory knows better
    pressure_gain = 0.005
    cast.chamber_width_mm = 1.0                 # any number of the configuration, in its unit
    finger.wall_mm = {value = 1.83, std = 0.05} # a number that was read by itself

A coupon needs ``gauge_length_mm`` and ``area_mm2``, or a table ``[coupon]`` with
``gauge_length_mm``, ``width_mm`` and ``thickness_mm``. Texts under other keys, and
``temperature_C``, are notes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from dolfingrip.config import Config, ConfigError, Finger
from dolfingrip.diagnosis.data.table import (
    EXPERIMENT_NAMES,
    NOT_SIMULATED,
    NUMBERS,
    READING_COLUMNS,
    allowed,
    near,
    of_markers,
)
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.index import fitted_effects
from dolfingrip.parameter import named
from dolfingrip.parameter.nuisances import known as known_nuisances
from dolfingrip.parameter.nuisances import usual
from dolfingrip.sections import tables, units
from dolfingrip.sections.section import Role

SECTIONS: Final = (
    *(
        name
        for name, section in Config.classes().items()
        if section.role in (Role.BODY, Role.SETUP, Role.INSTRUMENT)
        if any(section.felt_on(EXPERIMENTS[each].parts) for each in EXPERIMENT_NAMES)
    ),
    "extensions",
)
"""Sections of the configuration that a laboratory can tell about its set-up, and effects in it."""

CENTRES: Final = ("clamp", "tip")
"""Points of the simulated chord: the centres of the two faces."""

STANDARD_GRAVITY_m_s2: Final = 9.81

_DIRECT: Final = (
    "gauge_length_mm",
    "area_mm2",
    "rate_kPa_per_s",
    "rate_mm_per_s",
    "max_pressure_kPa",
)
_TABLES: Final = (*SECTIONS, "noise", "nuisance", "specimen", "angle")
_NOTES: Final = ("temperature_C",)
READ: Final = frozenset({"value", "std"})
"""Keys of a number that was read by itself."""


@dataclass(frozen=True, slots=True)
class LabSetup:
    """The set-up of one specimen in one experiment.

    Attributes:
        sections: values that differ from those of the configuration, by section and key.
        noise: standard deviation by column, in its unit, as far as the laboratory tells it.
        correlated_noise: standard deviation by column of the part that drifts along a run.
        correlation_time_s: correlation time of that part; infinite: as long as a run.
        correlation_length_mm: motion of the markers over which it fades; infinite: however far.
        nuisances: standard deviation by its key, or by key of the configuration;
            numbers of the laboratory replace the usual ones.
        rate: rate of the ramps, in the control's unit per second; None if it is not told.
        max_pressure_kPa: readings above are not compared.
        chord: the points of ``chord_angle_deg``.
        told: keys of nuisances that the laboratory tells.
        numbers: value and standard deviation of numbers that were read by themselves, by key.
    """

    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    correlated_noise: Mapping[str, float] = field(default_factory=dict)
    correlation_time_s: float = math.inf
    correlation_length_mm: float = math.inf
    nuisances: Mapping[str, float] = field(default_factory=usual)
    rate: float | None = None
    max_pressure_kPa: float = math.inf
    chord: tuple[Any, Any] = CENTRES
    told: frozenset[str] = frozenset()
    numbers: Mapping[str, tuple[float, float]] = field(default_factory=dict)


class SetupFile:
    """The TOML file of a CSV.

    Args:
        csv: the measured CSV, or the TOML itself.
        also: further keys that other code reads.

    Attributes:
        file: the TOML file.
        experiments: experiments that it names; empty if it names none.
        warnings: a sentence for each key that is not understood.

    Raises:
        ConfigError: one line, if there is no such file, it is not TOML, or a value is not allowed.
    """

    def __init__(self, csv: Path, also: Sequence[str] = ()) -> None:
        self.file = csv.with_suffix(".toml")
        if not self.file.exists():
            if csv == self.file or not csv.exists():
                raise ConfigError(f"{csv}: no such file")
            raise self._refuse(
                f"missing; allowed: a TOML file of the same stem next to {csv.name}, with the "
                "set-up"
            )
        self._data = tables.whole(self.file, "")
        self.experiments = self._experiments()
        for name in _TABLES:
            if name != "material":
                self.table(name)
        for name in _DIRECT:
            self._optional(name, self._data.get(name))
        self.warnings = [
            f"{self.file}: {key} is not known and not used"
            + (f"; {hint.strip()}" if (hint := near(key, (*_DIRECT, *_TABLES))) else "")
            for key, value in self._data.items()
            if key not in ("experiment", *_DIRECT, *_TABLES, *_NOTES, *also)
            and not isinstance(value, str)
        ]

    def _refuse(self, what: str) -> ConfigError:
        return ConfigError(f"{self.file}: {what}")

    def _experiments(self) -> tuple[str, ...]:
        entry = self._data.get("experiment", [])
        names = [entry] if isinstance(entry, str) else entry
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise self._refuse(f"experiment = {entry}: allowed: a name or a list of names")
        for name in names:
            if name not in (*EXPERIMENT_NAMES, *NOT_SIMULATED):
                raise self._refuse(
                    f"experiment = {name}: unknown; {allowed(name, EXPERIMENT_NAMES)}"
                )
        return tuple(names)

    def table(self, *names: str) -> dict[str, Any]:
        """A table, or one within another; empty if it is absent.

        Raises:
            ConfigError: one line, if it is no table.
        """
        table, key = self._data, ".".join(names)
        for name in names:
            table = table.get(name, {})
            if not isinstance(table, dict):
                raise self._refuse(f"{key} = {table}: allowed: a table, [{key}]")
        return table

    def check_specimens(self, names: set[str]) -> None:
        """Raise if a table belongs to a specimen that is not in the CSV."""
        for name in self.table("specimen").keys() - names:
            there = ", ".join(sorted(names))
            raise self._refuse(f"[specimen.{name}]: not in the CSV; allowed: {there}")

    def of(self, experiment: str, specimen: str) -> LabSetup:
        """The set-up of one specimen in one experiment.

        Raises:
            ConfigError: one line naming the key, its value and what is allowed.
        """
        of_specimen = self.table("specimen", specimen)
        sections = self._sections(self._data, "")
        for name, values in self._sections(of_specimen, specimen).items():
            sections[name] = {**sections.get(name, {}), **values}
        if "gravity" in sections:
            sections["gravity"].setdefault("acceleration_m_s2", STANDARD_GRAVITY_m_s2)
        if experiment == "coupon":
            self._check_coupon(sections.get("coupon", {}))
        else:
            sections.pop("coupon", None)
        noise, spreads = dict(self.table("noise")), _flat(self.table("nuisance"))
        numbers = self._numbers(spreads)
        for cls in fitted_effects():  # what is set anew is another number in each set-up
            if cls.told.each_time and (anew := cls.fitted(Config())) and anew.key in numbers:
                (value, std), (section, _, key) = numbers.pop(anew.key), anew.key.partition(".")
                sections[section] = {**sections.get(section, {}), key: value}
                spreads[cls.told.key] = cls.told.as_told(std, value)
        correlated = dict(self.table("noise", "correlated"))
        noise.pop("correlated", None)
        time_s, length_mm = (
            self._optional(f"noise.correlated.{key}", correlated.pop(key, None)) or math.inf
            for key in ("correlation_time_s", "correlation_length_mm")
        )
        if "specimen_scale" in noise:
            spreads = {"specimen_scale": noise.pop("specimen_scale"), **spreads}
        rate = "rate_mm_per_s" if experiment == "coupon" else "rate_kPa_per_s"
        plain = {**self._data, **of_specimen}
        angle = self._data.get("angle", {})
        return LabSetup(
            sections,
            self._spreads("noise", noise, (*NUMBERS, *of_markers(noise))),
            self._spreads(
                "noise.correlated", correlated, (*READING_COLUMNS, *of_markers(correlated))
            ),
            time_s,
            length_mm,
            usual() | self._spreads("nuisance", spreads, tuple(known_nuisances())),
            self._optional(rate, plain.get(rate)),
            self._optional("max_pressure_kPa", plain.get("max_pressure_kPa")) or math.inf,
            (angle.get("from", CENTRES[0]), angle.get("to", CENTRES[1])),
            told=frozenset(spreads),
            numbers=numbers,
        )

    def _numbers(self, spreads: dict[str, Any]) -> dict[str, tuple[float, float]]:
        """Take numbers that were read by themselves out of [nuisance]."""
        pairs: dict[str, tuple[float, float]] = {}
        for key in [key for key, entry in spreads.items() if isinstance(entry, dict)]:
            entry, where = spreads.pop(key), f"nuisance.{key}"
            if "." in key:
                named(key, f"{self.file}: [nuisance]")
            value = self._number(where, entry["value"], -units.of(key).most)
            pairs[key] = value, self._number(where, entry["std"])
        return pairs

    def spreads(self) -> dict[str, Any]:
        """Standard deviations of what is as configured, by nuisance and by column."""
        noise = {k: v for k, v in self.table("noise").items() if not isinstance(v, dict)}
        spreads = _flat(self.table("nuisance"))
        return noise | {key: std for key, std in spreads.items() if not isinstance(std, dict)}

    def _sections(self, data: Mapping[str, Any], specimen: str) -> dict[str, dict[str, Any]]:
        """Values by section and key; flat keys are put into their sections."""
        where = f"specimen.{specimen}." if specimen else ""
        sections = {name: dict(data[name]) for name in SECTIONS if isinstance(data.get(name), dict)}
        coupon = sections.get("coupon", {})
        if "gauge_length_mm" in data:
            coupon["gauge_length_mm"] = self._number(
                f"{where}gauge_length_mm", data["gauge_length_mm"]
            )
        if "area_mm2" in data:
            side = math.sqrt(self._number(f"{where}area_mm2", data["area_mm2"]))
            coupon |= {"width_mm": side, "thickness_mm": side}
        if coupon:
            sections["coupon"] = coupon
        if specimen:
            keys = {*SECTIONS, *_DIRECT}
            for key, value in data.items():
                if key in Finger.model_fields:
                    sections.setdefault("finger", {})[key] = value
                elif key not in keys and not isinstance(value, str):
                    raise self._refuse(
                        f"{where}{key}: unknown key; {near(key, tuple(Finger.model_fields))}"
                        f"allowed: {', '.join([*SECTIONS, *Finger.model_fields])}"
                    )
        return sections

    def _check_coupon(self, coupon: Mapping[str, Any]) -> None:
        for key, unit, parts in (
            ("gauge_length_mm", "mm", {"gauge_length_mm"}),
            ("area_mm2", "mm²", {"width_mm", "thickness_mm"}),
        ):
            if not parts <= coupon.keys():
                raise self._refuse(f"{key}: missing; a coupon needs it; allowed: above 0 {unit}")

    def _spreads(
        self, table: str, spreads: Mapping[str, Any], keys: tuple[str, ...]
    ) -> dict[str, float]:
        """Standard deviations of a table; [nuisance] may have any key of the configuration."""
        for key in spreads:
            if table == "nuisance" and "." in key:
                named(key, f"{self.file}: [nuisance]")
            elif key not in keys:
                raise self._refuse(f"{table}.{key}: unknown key; {allowed(key, keys)}")
        return {key: self._number(f"{table}.{key}", value, 0.0) for key, value in spreads.items()}

    def _optional(self, key: str, value: Any) -> float | None:
        return None if value is None else self._number(key, value)

    def _number(self, key: str, value: Any, low: float | None = None) -> float:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        unit = units.of(key)
        least = unit.least if low is None else low
        nearly = number and 0 < abs(value) < units.NOTHING
        if not number or nearly or not least <= value <= unit.most:
            within = f"at least {least:g} and at most {unit.most:g} {unit.text}".strip()
            raise self._refuse(f"{key} = {value}: allowed: {within}")
        return float(value)


def _flat(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values of a table and of the tables below it, by dotted keys; a reading is a table."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict) and value.keys() != READ:
            flat |= _flat(value, f"{before}{key}.")
        else:
            flat[f"{before}{key}"] = value
    return flat
