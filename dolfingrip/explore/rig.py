"""A wizard's answers as the set-up of a measurement: its TOML, its CSV's header, and a plan."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import tomlkit

from dolfingrip.channels import WHO
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.table import CONTROL, READINGS
from dolfingrip.explore.wanted import number
from dolfingrip.files import whole
from dolfingrip.sections.errors import checked, shown

NUMBERS: Final[Mapping[str, tuple[str, ...]]] = {
    "rate_kPa_per_s": ("rate_kPa_per_s",),
    "gap_mm": ("plate", "gap_mm"),
    "angle_deg": ("noise", "angle_deg"),
    "force_N": ("noise", "force_N"),
    "gauge_length_mm": ("gauge_length_mm",),
    "area_mm2": ("area_mm2",),
}
"""Where each number of the form stands in the TOML file."""


@dataclass(frozen=True, slots=True)
class RigFiles:
    """The files of a measurement before it is made.

    Attributes:
        setup: TOML file of the measurement.
        plan: the same with the table that ``plan-experiment`` reads.
        header: first line of the CSV.
        readings: number of readings that the protocol has.
    """

    setup: str
    plan: str
    header: str
    readings: int


def files(answers: Mapping[str, Any], config: Config) -> RigFiles:
    """The files that a form's answers ask for.

    Args:
        answers: ``experiments``, numbers by the keys of :data:`NUMBERS`, and ``protocol``.
        config: of the design that is measured.

    Raises:
        ConfigError: one line naming the key, its value and what is allowed.
    """
    experiments = answers.get("experiments") or []
    allowed = (*rig.EXPERIMENTS, "coupon")
    if not isinstance(experiments, list) or not experiments:
        raise ConfigError(f"experiments: none; allowed: {', '.join(allowed)}")
    for name in experiments:
        if name not in allowed:
            raise ConfigError(f"experiments = {name}: allowed: {', '.join(allowed)}")
    data: dict[str, Any] = {"experiment": experiments if len(experiments) > 1 else experiments[0]}
    if experiments != ["coupon"]:
        data |= {name: table for name, table in config.drawn().items() if table}
        shape = config.morph.model_dump(exclude_defaults=True)
        if shape:
            data["morph"] = shape
    for key, (*tables, name) in NUMBERS.items():
        value = answers.get(key)
        if value is None or value == "":
            continue
        number(key, value)
        table = data
        for section in tables:
            table = table.setdefault(section, {})
        table[name] = value
    protocol = answers.get("protocol") or {}
    if not isinstance(protocol, Mapping):
        raise ConfigError(f"protocol = {shown(protocol)}: allowed: a table")
    protocol = {k: v for k, v in protocol.items() if v not in (None, "")}
    checked(rig.RigProtocol, protocol)
    setup = tomlkit.dumps(data)
    plan = tomlkit.dumps({**data, "protocol": protocol}) if protocol else setup
    measurement = _read(plan, config)
    return RigFiles(setup, plan, _header(measurement), len(measurement.readings))


def _read(text: str, config: Config) -> Measurement:
    """The measurement that the rig would make, by which the file is checked."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "rig.toml"
        whole.write(file, text)
        try:
            return rig.read(file, config)[0]
        except ConfigError as error:
            raise ConfigError(str(error).replace(f"{folder}/", "")) from None


def _header(measurement: Measurement) -> str:
    """The columns of the CSV, in the order of the format."""
    tests = measurement.tests
    readings = measurement.readings
    there = {name for name in readings.columns if readings[name].notna().any()}
    controls = {CONTROL[test.experiment] for test in tests}
    reads = {name for test in tests for name in READINGS[test.experiment]}
    columns = [*WHO, "time_s", *sorted(controls, reverse=True), *sorted(reads & there)]
    written = [name for name in dict.fromkeys(columns) if name in there or name in WHO]
    return ",".join(written)


def command(file: Path, out: Path) -> list[str]:
    """The command that plans a rig's experiment."""
    return [
        sys.executable, "-P", "-m", "dolfingrip", "plan-experiment", str(file),
        "--out", str(out), "--quick", "--workers", "1",
    ]  # fmt: skip
