"""Experiments that a laboratory could add, as measurements that are still to be made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.channels import ANGLE, FORCE, TIP_X, TIP_Z, TRANSVERSE_STRAIN
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import planned
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.data.lab_setup import LabSetup, STANDARD_GRAVITY_m_s2
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.simulation import nominal

STOPS: Final = 10
"""Readings of a ramp."""

SLOWER: Final = 10.0
"""By how much a slow ramp is slower."""

HOLD_s: Final = 60.0

SETUP_MIN: Final[Mapping[str, float]] = {"ramp": 2.0, "coupon": 15.0, "camera": 10.0, "plate": 5.0}
"""Minutes that setting up takes, an engineering guess: what is mounted already, a new coupon, a
camera, the plate or the clamp."""

OTHER_GAP_mm: Final = 2.0
"""By how much the plate is moved away."""

FORCE_AND_WIDTH: Final = (FORCE.name, TRANSVERSE_STRAIN.name)
"""What is read of a coupon: the force, and by a camera the width. Laws whose forces agree may
differ in how far the volume changes."""

FARTHER: Final = 3.0
"""By how much farther a coupon is pulled than before, where laws that agree so far part."""


@dataclass(frozen=True)
class Proposal:
    """An experiment that could be added.

    Attributes:
        name: in words.
        minutes: that it takes, set-up included.
        measurement: its readings to be, all 0.
        kind: one of :data:`dolfingrip.diagnosis.data.rig.KINDS`.
        known_mesh: whether it is simulated on the mesh of the fits, where its simulations are
            there already; else on the ungraded one, which takes a third of the time.
    """

    name: str
    minutes: float
    measurement: Measurement
    kind: str
    known_mesh: bool = False


def proposals(measurement: Measurement, config: Config) -> list[Proposal]:
    """What is worth considering beside a measurement."""
    found: list[Proposal] = []
    finger = next((t for t in measurement.tests if t.experiment != "coupon"), None)
    coupon = next((t for t in measurement.tests if t.experiment == "coupon"), None)
    bending = next((t for t in measurement.tests if t.experiment == "bending"), finger)
    if bending is not None and finger is not None:
        found += _ramps(measurement, bending, config)
        found += _readings(measurement, bending, config)
    if coupon is not None or finger is not None:
        found += _coupons(measurement, coupon, finger, config)
    return found


def _ramps(measurement: Measurement, test: SpecimenTest, config: Config) -> list[Proposal]:
    """The same set-up controlled another way."""
    rows = measurement.rows(test.number)
    top, rate = _top(rows, test), _rate(measurement, test, config)
    reading = (FORCE if test.experiment == "blocked_force" else ANGLE).name
    done = set(rows["branch"])
    ways = [
        ("cycles", "three cycles, loading and unloading", planned.cycles(3), rate),
        ("slow_cycle", "a cycle at a tenth of the rate", planned.cycles(1), rate / SLOWER),
        ("hold", "a hold of 60 s at the highest pressure", [("loading", 1), ("hold", 1)], rate),
    ]
    if "unloading" not in done:
        ways.insert(0, ("unloading", "unloading after the loading", planned.cycles(1), rate))
    return [
        _proposal(kind, name, "ramp", test, test.setup, way, top, pace, (reading,))
        for kind, name, way, pace in ways
    ]


def _readings(measurement: Measurement, test: SpecimenTest, config: Config) -> list[Proposal]:
    """More readings, another gap, and the finger hung and stood."""
    found = []
    rows = measurement.rows(test.number)
    top, rate = _top(rows, test), _rate(measurement, test, config)
    loading = [("loading", 1)]
    if test.experiment == "bending" and rows[TIP_X.name].isna().all():
        found.append(_again(measurement, "tip", "the tip tracked (x and z)", "camera", test,
                            (TIP_X.name, TIP_Z.name)))  # fmt: skip
    blocked = next((t for t in measurement.tests if t.experiment == "blocked_force"), None)
    if blocked is not None:
        own = measurement.rows(blocked.number)
        if own[ANGLE.name].isna().all():
            found.append(_again(measurement, "blocked_angle", "the angle while blocked", "camera",
                                blocked, (ANGLE.name,)))  # fmt: skip
        gap_mm = blocked.setup.applied(config).plate.gap_mm + OTHER_GAP_mm
        away = _with(blocked.setup, "plate", {"gap_mm": gap_mm})
        high = _top(own, blocked)
        found.append(_proposal("gap", f"the blocked force at a gap of {gap_mm:g} mm", "plate",
                               blocked, away, loading, high, rate, (FORCE.name,)))  # fmt: skip
    if test.experiment == "bending":
        poses = [
            _with(test.setup, "gravity", {"direction": [0.0, 0.0, z],
                                          "acceleration_m_s2": STANDARD_GRAVITY_m_s2})
            for z in (1.0, -1.0)
        ]  # fmt: skip
        tests = [replace(test, number=i, setup=pose) for i, pose in enumerate(poses)]
        lines = [_rows(each, loading, top, rate, (ANGLE.name,)) for each in tests]
        minutes = SETUP_MIN["plate"] + 2 * top / rate / 60
        found.append(Proposal("free bending with the tip up and with the tip down", minutes,
                              Measurement(pd.concat(lines, ignore_index=True), tests),
                              "orientation"))  # fmt: skip
    return found


def _coupons(
    measurement: Measurement, coupon: SpecimenTest | None, finger: SpecimenTest | None,
    config: Config,
) -> list[Proposal]:  # fmt: skip
    """Uniaxial tension of the same material."""
    test = coupon or replace(
        _some(finger), experiment="coupon", setup=LabSetup(), specimen="coupon"
    )
    own = test.setup.applied(config).coupon
    top = own.max_strain * own.gauge_length_mm
    rate = own.rate_mm_per_s if coupon is None else _rate(measurement, coupon, config)
    once, held = [("loading", 1)], [("loading", 1), ("hold", 1)]
    ways: list[tuple[str, list[tuple[str, int]], float]] = [
        ("a coupon at a tenth of the rate", once, rate / SLOWER),
        ("a coupon with a hold of 60 s at the largest strain", held, rate),
        ("a coupon, loading and unloading", planned.cycles(1), rate),
        ("a coupon, three cycles", planned.cycles(3), rate),
    ]
    seen = coupon is not None and _has_width(measurement.rows(coupon.number))
    columns = FORCE_AND_WIDTH if seen else FORCE_AND_WIDTH[:1]
    name = "a coupon in uniaxial tension"
    if coupon is None:
        ways.insert(0, (name, once, rate))
    found = [
        _proposal("coupon", name, "coupon", test, test.setup, way, top, pace, columns)
        for name, way, pace in ways
    ]
    if not seen:
        found.append(_with_width(name, test, test.setup, once, top, rate))
    if coupon is None:
        return found
    # a coupon that is compared so far, too
    far = _with(test.setup, "coupon", {"max_strain": FARTHER * own.max_strain})
    strain = f"a strain of {FARTHER * own.max_strain:g}"
    more = [
        (f"a coupon to {strain}", once),
        (f"a coupon to {strain}, a hold of 60 s there, and unloading", [*held, ("unloading", 1)]),
    ]
    for name, way in more:
        found.append(
            _proposal("coupon", name, "coupon", test, far, way, FARTHER * top, rate, columns)
        )
        if not seen:
            found.append(_with_width(name, test, far, way, FARTHER * top, rate))
    return found


def _has_width(rows: pd.DataFrame) -> bool:
    """Whether a coupon's width was measured, so that the camera stands there."""
    return bool(rows[FORCE_AND_WIDTH[1]].notna().any())


def _with_width(
    name: str, test: SpecimenTest, setup: LabSetup, way: Sequence[tuple[str, int]], top: float,
    rate: float,
) -> Proposal:  # fmt: skip
    """A coupon that a camera sees, too."""
    found = _proposal(
        "coupon_width", f"{name}; a camera measures its width, too", "coupon", test, setup, way,
        top, rate, FORCE_AND_WIDTH,
    )  # fmt: skip
    return replace(found, minutes=found.minutes + SETUP_MIN["camera"])


def _some(test: SpecimenTest | None) -> SpecimenTest:
    assert test is not None
    return test


def _with(setup: LabSetup, section: str, values: Mapping[str, Any]) -> LabSetup:
    sections = {**setup.sections, section: {**setup.sections.get(section, {}), **values}}
    return replace(setup, sections=sections)


def _top(rows: pd.DataFrame, test: SpecimenTest) -> float:
    """Highest value of the control, as it was meant."""
    read = float(rows[test.control].max())
    return nominal.end(read, read / STOPS, test.setup.noise.get(test.control, 0.0))


def _rate(measurement: Measurement, test: SpecimenTest, config: Config) -> float:
    """Median rate of the ramps, in the control's unit per second; else as configured."""
    found = measurement.ramp_rate(test)
    if found is not None:
        return found
    applied = test.setup.applied(config)
    return (
        applied.coupon.rate_mm_per_s
        if test.experiment == "coupon"
        else applied.experiment.rate_kPa_per_s
    )


def _proposal(
    kind: str,
    name: str,
    mounting: str,
    test: SpecimenTest,
    setup: LabSetup,
    way: Sequence[tuple[str, int]],
    top: float,
    rate: float,
    columns: tuple[str, ...],
) -> Proposal:
    own = replace(test, number=0, setup=setup)
    lines = _rows(own, way, top, rate, columns)
    minutes = SETUP_MIN[mounting] + float(lines["time_s"].max()) / 60
    return Proposal(name, minutes, Measurement(lines, [own]), kind)


def _again(
    measurement: Measurement, kind: str, name: str, mounting: str, test: SpecimenTest,
    columns: Sequence[str],
) -> Proposal:  # fmt: skip
    """What was measured once more, with other readings; simulated as it was."""
    lines = measurement.readings.copy()
    lines[list(READING_COLUMNS)] = np.nan
    mine = lines["test"] == test.number
    lines.loc[mine, list(columns)] = 0.0
    lasting = float(np.ptp(measurement.rows(test.number)["time_s"])) / 60
    found = Measurement(lines, measurement.tests)
    return Proposal(name, SETUP_MIN[mounting] + lasting, found, kind, known_mesh=True)


def _rows(
    test: SpecimenTest,
    way: Sequence[tuple[str, int]],
    top: float,
    rate: float,
    columns: Sequence[str],
) -> pd.DataFrame:
    ramp = top * np.arange(1, STOPS + 1) / STOPS
    return planned.rows(test, way, ramp, rate, columns, hold_s=HOLD_s, at_rest=True)
