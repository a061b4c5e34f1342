"""A rig: the measurements that a laboratory could make, before it makes them.

A TOML file like that of a measurement (:mod:`dolfingrip.diagnosis.data.lab_setup`), with a table of
how it would be controlled and read:

    experiment = ["bending", "blocked_force"]
    rate_kPa_per_s = 25.0
    [noise]
    angle_deg = 0.3
    [protocol]
    cycles = 3
    tip = true                     # the camera sees the tip's place, too
    can_vary = ["hold", "coupon"]  # what could be added

Tests that are not made yet have rows with readings of 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import pandas as pd
from pydantic import Field

from dolfingrip.channels import ANGLE, FORCE, TIME, TIP_X, TIP_Z, TRANSVERSE_STRAIN
from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError, checked
from dolfingrip.diagnosis.data.lab_setup import LabSetup, SetupFile
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import NUMBERS
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.experiments.protocol import cycles
from dolfingrip.experiments.synthetic import NOISE
from dolfingrip.sections.procedure import ExperimentSettings
from dolfingrip.sections.section import Section

MOST_READINGS: Final = 1000
"""Largest number of readings of a ramp."""


def planned_rows(
    test: SpecimenTest,
    way: ExperimentSettings,
    ramp: Sequence[float] | np.ndarray,
    rate: float,
    columns: Sequence[str],
) -> pd.DataFrame:
    """Rows of a protocol, as in ``Measurement.readings``; the first is at rest.

    Args:
        test: test of the rows; its ``control`` column is prescribed, other supplies rest at 0.
        way: how often it goes up and down, and its waits.
        ramp: (m,) rising values, above 0, at which loading is read.
        rate: rate of ramps, in the unit of ``ramp`` per second.
        columns: columns that are read.
    """
    return pd.DataFrame([
        {
            "line": 0, "test": test.number, "experiment": test.experiment,
            "specimen": test.specimen, "cycle": stop.cycle, "branch": stop.branch,
            **dict.fromkeys(NUMBERS, np.nan), TIME.name: stop.time_s,
            **dict.fromkeys(test.supplies, 0.0), test.control: stop.value,
            **dict.fromkeys(columns, 0.0),
        }
        for stop in cycles([0.0, *map(float, ramp)], rate, way)
    ])  # fmt: skip


EXPERIMENTS: Final = ("bending", "blocked_force")
"""Experiments of the paper."""

KINDS: Final = (
    "unloading", "cycles", "slow_cycle", "hold", "tip", "blocked_angle", "gap", "orientation",
    "coupon", "coupon_width", "pace",
)  # fmt: skip
"""Additions that a laboratory may be able to make; another pace tells of bodies that move."""


class RigProtocol(Section):
    """How the rig leads and reads."""

    highest_pressure_kPa: float = Field(
        ExperimentSettings().max_pressure_kPa, gt=0, le=1e4, description="end of a ramp"
    )
    step_kPa: float = Field(
        ExperimentSettings().step_kPa, gt=0, le=1e4, description="between readings"
    )
    coupon_readings: int = Field(
        Policy().dense, ge=2, le=MOST_READINGS, description="of a ramp of a coupon"
    )
    cycles: int = Field(1, ge=1, le=100, description="ramps up; more than one are up and down")
    unload: bool = Field(False, description="read while unloading, too")
    hold_s: float = Field(0.0, ge=0, le=1e6, description="wait at the top of each cycle")
    tip: bool = Field(False, description="the tip's x and z are read in free bending")
    blocked_angle: bool = Field(False, description="the angle is read while blocked")
    coupon_width: bool = Field(False, description="a coupon's width is read, too")
    can_vary: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        KINDS, description=f"additions that are possible, of {', '.join(KINDS)}"
    )


def read(
    file: Path | None,
    config: Config,
    changes: Change = NO_CHANGE,
    noise: Mapping[str, float] = NO_CHANGE,
    policy: Policy = Policy(),
) -> tuple[Measurement, tuple[str, ...]]:
    """The measurement that a rig would make, with readings of 0, and the additions it can make.

    Args:
        file: TOML file; None: the paper's protocol.
        config: configuration that its set-up is a difference from.
        changes: values by key of its table ``[protocol]``.
        noise: standard deviations by column, which replace those of the file.
        policy: numbers that its readings are simulated and compared by.

    Raises:
        ConfigError: one line naming the file or key, the value and what is allowed.
    """
    setup_file = SetupFile(file, also=("protocol",)) if file else None
    data = (setup_file.table("protocol") if setup_file else {}) | dict(changes)
    protocol = checked(RigProtocol, data)
    for kind in protocol.can_vary:
        if kind not in KINDS:
            raise ConfigError(f"protocol.can_vary = {kind}: allowed: {', '.join(KINDS)}")
    experiments = (setup_file.experiments if setup_file else ()) or EXPERIMENTS
    tests = []
    for i, experiment in enumerate(experiments):
        setup = setup_file.of(experiment, "rig") if setup_file else LabSetup()
        setup = replace(setup, noise={**NOISE, **setup.noise, **noise})
        tests.append(SpecimenTest(i, file or Path("rig.toml"), experiment, "rig", setup))
    tables = [_rows(test, protocol, config, policy) for test in tests]
    warnings = setup_file.warnings if setup_file else []
    rows = pd.concat(tables, ignore_index=True)
    return Measurement(rows, tests, list(warnings), policy), protocol.can_vary


def _rows(
    test: SpecimenTest, protocol: RigProtocol, config: Config, policy: Policy
) -> pd.DataFrame:
    if test.experiment == "coupon":
        coupon, count = test.applied(config).coupon, protocol.coupon_readings
        top = coupon.max_strain * coupon.gauge_length_mm
    else:
        top = protocol.highest_pressure_kPa
        if protocol.step_kPa * MOST_READINGS < top:
            raise ConfigError(
                f"step_kPa = {protocol.step_kPa:g}: allowed: at least {top / MOST_READINGS:g} kPa, "
                f"which is {MOST_READINGS} readings of a ramp to {top:g} kPa"
            )
        count = max(round(top / protocol.step_kPa), 1)
    read = {
        "coupon": [FORCE, *([TRANSVERSE_STRAIN] if protocol.coupon_width else ())],
        "bending": [ANGLE, *([TIP_X, TIP_Z] if protocol.tip else ())],
        "blocked_force": [FORCE, *([ANGLE] if protocol.blocked_angle else ())],
    }[test.experiment]
    rate, columns = test.setup.rate or test.configured_rate(config), [c.name for c in read]
    ramp = top * np.arange(1, count + 1) / count
    way = ExperimentSettings(
        cycles=protocol.cycles, unload=protocol.unload, hold_s=protocol.hold_s,
        hold_readings=policy.few,
    )  # fmt: skip
    return planned_rows(test, way, ramp, rate, columns)
