"""Experiments that a laboratory could add, as measurements that are still to be made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np
import pandas as pd

from dolfingrip.channels import ANGLE, FORCE, TIP_X, TIP_Z, TRANSVERSE_STRAIN
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.clock import moves
from dolfingrip.diagnosis.data.lab_setup import LabSetup, STANDARD_GRAVITY_m_s2
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.simulation import stops
from dolfingrip.files.diagnosis import PlannedTest
from dolfingrip.sections.procedure import ExperimentSettings

STOPS: Final = 10
"""Readings of a ramp."""

LOADING: Final = ExperimentSettings()
UNLOADED: Final = ExperimentSettings(unload=True)


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
    quantities: ClassVar = ()

    @property
    def columns(self) -> np.ndarray:
        """Channel of each reading, shape (m,)."""
        return self.measurement.listed["column"].to_numpy()

    @property
    def tests(self) -> tuple[PlannedTest, ...]:
        """The tests of the experiment, as a result file tells them."""
        planned = []
        for test in self.measurement.tests:
            rows = self.measurement.rows(test.number)
            read = [name for name in self.measurement.columns if rows[name].notna().any()]
            if not read:
                continue
            sections = test.setup.sections.items()
            planned.append(PlannedTest(
                experiment=test.experiment, specimen=test.specimen, control=test.control,
                settings={f"{name}.{key}": value
                          for name, keys in sections for key, value in keys.items()},
                read=tuple(read), branch=tuple(rows["branch"]),
                cycle=tuple(map(int, rows["cycle"])), time_s=tuple(rows["time_s"]),
                value=tuple(rows[test.control]),
            ))  # fmt: skip
        return tuple(planned)


def proposals(measurement: Measurement, config: Config) -> list[Proposal]:
    """List the experiments that are worth considering beside a measurement.

    Args:
        measurement: so far.
        config: the model that is diagnosed.

    Returns:
        Those that were not made yet, each as a measurement whose readings are 0. A record of a body
        that moves is made again, faster and slower.
    """
    applied = zip(measurement.tests, measurement.applied(config), strict=True)
    moving = [test for test, its_config in applied if moves(its_config)]
    if moving:
        return [
            _paced(measurement, test, pace)
            for test in moving for pace in (0.5, 2.0)
            if measurement.rows(test.number)[test.control].nunique() > 1
        ]  # fmt: skip
    additions: list[Proposal] = []
    finger = next((t for t in measurement.tests if t.experiment != "coupon"), None)
    coupon = next((t for t in measurement.tests if t.experiment == "coupon"), None)
    bending = next((t for t in measurement.tests if t.experiment == "bending"), finger)
    if bending is not None:
        additions += _of_finger(measurement, bending, config)
    if coupon is not None:
        additions += _coupons(measurement, coupon, config, new=False)
    elif finger is not None:
        new = replace(finger, experiment="coupon", setup=LabSetup(), specimen="coupon")
        additions += _coupons(measurement, new, config, new=True)
    return [proposal for proposal in additions if not _made(measurement, proposal, config)]


def _made(measurement: Measurement, proposal: Proposal, config: Config) -> bool:
    """Tell whether tests of the same way, size and duration have read all that is proposed."""

    def led(of: Measurement, test: SpecimenTest) -> tuple[Any, np.ndarray, set[str]]:
        rows = of.rows(test.number)
        legs = tuple(dict.fromkeys(zip(rows["branch"], rows["cycle"], strict=True)))
        sizes = np.array([rows[test.control].max(), np.ptp(rows["time_s"])])
        read = {name for name in of.columns if rows[name].notna().any()}
        return (test.experiment, test.applied(config), legs), sizes, read

    before = [led(measurement, test) for test in measurement.tests]
    planned = [led(proposal.measurement, test) for test in proposal.measurement.tests]
    alike = measurement.policy.alike
    return all(
        any(way == w and read <= r and np.allclose(sizes, s, rtol=alike) for w, s, r in before)
        for way, sizes, read in planned if read
    )  # fmt: skip


def _of_finger(measurement: Measurement, test: SpecimenTest, config: Config) -> list[Proposal]:
    """Other ways of leading a set-up, more readings, another gap, and the finger hung and stood."""
    rows, policy = measurement.rows(test.number), measurement.policy
    top, rate = _top(rows, test, policy), _rate(measurement, test, config)
    reading = (FORCE if test.experiment == "blocked_force" else ANGLE).name
    often, held = _repeated(policy), _held(policy)
    ways = [
        ("unloading", "unloading after the loading", UNLOADED, rate),
        ("cycles", "three cycles, loading and unloading", often, rate),
        ("slow_cycle", "a cycle at a tenth of the rate", UNLOADED, rate / 10),
        ("hold", "a hold of 60 s at the highest pressure", held, rate),
    ]
    additions = [
        _proposal(kind, name, ["ramp"], [test], way, top, pace, [reading], policy)
        for kind, name, way, pace in ways
        if kind != "unloading" or "unloading" not in set(rows["branch"])
    ]
    if test.experiment == "bending" and rows[TIP_X.name].isna().all():
        columns = [TIP_X.name, TIP_Z.name]
        additions.append(_seen(measurement, "tip", "the tip tracked (x and z)", test, columns))
    blocked = next((t for t in measurement.tests if t.experiment == "blocked_force"), None)
    if blocked is not None:
        table = measurement.rows(blocked.number)
        if table[ANGLE.name].isna().all():
            name = "the angle while blocked"
            additions.append(_seen(measurement, "blocked_angle", name, blocked, [ANGLE.name]))
        gap_mm = blocked.applied(config).plate.gap_mm + 2
        away = _with(blocked, "plate", {"gap_mm": gap_mm})
        name, high = f"the blocked force at a gap of {gap_mm:g} mm", _top(table, blocked, policy)
        additions.append(_proposal("gap", name, ["plate"], [away], LOADING, high, rate,
                               [FORCE.name], policy))  # fmt: skip
    if test.experiment == "bending":
        weight, name = STANDARD_GRAVITY_m_s2, "free bending with the tip up and with the tip down"
        poses = [
            _with(test, "gravity", {"direction": [0.0, 0.0, z], "acceleration_m_s2": weight})
            for z in (1.0, -1.0)
        ]
        additions.append(
            _proposal(
                "orientation", name, ["plate"], poses, LOADING, top, rate, [ANGLE.name], policy
            )
        )
    return additions


def _coupons(
    measurement: Measurement, test: SpecimenTest, config: Config, *, new: bool
) -> list[Proposal]:
    """Uniaxial tension of the same material; ``new`` where no coupon was pulled so far."""
    coupon = test.applied(config).coupon
    top = coupon.max_strain * coupon.gauge_length_mm
    usual = coupon.rate_mm_per_s if new else _rate(measurement, test, config)
    # where a width was measured the camera stands there
    seen = not new and measurement.rows(test.number)[TRANSVERSE_STRAIN.name].notna().any()
    held = _held(measurement.policy)

    def pulled(
        name: str,
        way: ExperimentSettings = LOADING,
        rate: float = usual,
        by: float = 1.0,
        *,
        width: bool = False,
    ) -> Proposal:
        far = _with(test, "coupon", {"max_strain": by * coupon.max_strain})
        # laws whose forces agree may differ in how far the volume changes, which the width tells
        columns = [FORCE.name, *([TRANSVERSE_STRAIN.name] if seen or width else ())]
        return _proposal(
            "coupon_width" if width else "coupon",
            f"{name}; a camera measures its width, too" if width else name,
            ["coupon", "camera"] if width else ["coupon"],
            [test if by == 1.0 else far], way, by * top, rate, columns,
            measurement.policy,
        )  # fmt: skip

    name = "a coupon in uniaxial tension"
    additions = [
        *([pulled(name)] if new else []),
        pulled("a coupon at a tenth of the rate", rate=usual / 10),
        pulled("a coupon with a hold of 60 s at the largest strain", held),
        pulled("a coupon, loading and unloading", UNLOADED),
        pulled("a coupon, three cycles", _repeated(measurement.policy)),
        *([] if seen else [pulled(name, width=True)]),
    ]
    if new:
        return additions
    # a coupon that is compared so far, too
    farther = measurement.policy.farther
    strain = f"a strain of {farther * coupon.max_strain:g}"
    back = held.model_copy(update={"unload": True})
    for name, way in (
        (f"a coupon to {strain}", LOADING),
        (f"a coupon to {strain}, a hold of 60 s there, and unloading", back),
    ):
        additions.append(pulled(name, way, by=farther))
        if not seen:
            additions.append(pulled(name, way, by=farther, width=True))
    return additions


def _repeated(policy: Policy) -> ExperimentSettings:
    return ExperimentSettings(cycles=policy.cycles)


def _held(policy: Policy) -> ExperimentSettings:
    return ExperimentSettings(hold_s=60.0, hold_readings=policy.few)


def _with(test: SpecimenTest, section: str, values: Mapping[str, Any]) -> SpecimenTest:
    """The test with other values in a section of its set-up."""
    before = test.setup.sections
    sections = {**before, section: {**before.get(section, {}), **values}}
    return replace(test, setup=replace(test.setup, sections=sections))


def _top(rows: pd.DataFrame, test: SpecimenTest, policy: Policy) -> float:
    """Highest value of the control, as it was meant."""
    read = float(rows[test.control].max())
    return stops.meant_end(read, read / STOPS, test.sigma, policy)


def _rate(measurement: Measurement, test: SpecimenTest, config: Config) -> float:
    """Median rate of the ramps, in the control's unit per second; else as configured."""
    return measurement.ramp_rate(test) or test.configured_rate(config)


def _proposal(
    kind: str,
    name: str,
    mounted: Sequence[str],
    tests: Sequence[SpecimenTest],
    way: ExperimentSettings,
    top: float,
    rate: float,
    columns: Sequence[str],
    policy: Policy,
) -> Proposal:
    planned = [replace(test, number=i) for i, test in enumerate(tests)]
    ramp = top * np.arange(1, STOPS + 1) / STOPS
    rows = [rig.planned_rows(test, way, ramp, rate, columns) for test in planned]
    minutes = sum(policy.set_up_min[part] for part in mounted)
    minutes += sum(float(table["time_s"].max()) for table in rows) / 60
    every_row = pd.concat(rows, ignore_index=True)
    return Proposal(name, minutes, Measurement(every_row, planned, policy=policy), kind)


def _paced(measurement: Measurement, test: SpecimenTest, pace: float) -> Proposal:
    """Repeat what was measured in time, its control so many times as fast."""
    lines = measurement.rows(test.number).assign(test=0)
    lines["time_s"] /= pace
    columns = measurement.columns
    lines[columns] = lines[columns].where(lines[columns].isna(), 0.0)
    minutes = measurement.policy.set_up_min["ramp"] + float(np.ptp(lines["time_s"])) / 60
    again = Measurement(
        lines.reset_index(drop=True), [replace(test, number=0)], policy=measurement.policy
    )
    name = f"{test.experiment} of {test.specimen} again, {pace:g} times as fast"
    return Proposal(name, minutes, again, "pace")


def _seen(
    measurement: Measurement, kind: str, name: str, test: SpecimenTest, columns: list[str]
) -> Proposal:
    """Repeat what was measured, with a camera's readings alone; simulated as it was."""
    lines = measurement.readings.copy()
    lines[measurement.columns] = np.nan
    lines.loc[lines["test"] == test.number, columns] = 0.0
    lasting = float(np.ptp(measurement.rows(test.number)["time_s"])) / 60
    minutes = measurement.policy.set_up_min["camera"] + lasting
    seen = Measurement(lines, measurement.tests, policy=measurement.policy)
    return Proposal(name, minutes, seen, kind, known_mesh=True)
