"""Derivatives of a short finger's readings: by the package, and by central differences of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.sensitivities import Sensitivities
from dolfingrip.experiments.index import find
from dolfingrip.experiments.rigs.finger import build
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.perturbation import velocity
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.parameter import Entry, Parameter

SHORT = (
    "mesh.size_mm=6", "mesh.edge_size_mm=6", "finger.length_mm=38", "finger.bellows=2",
    "plate.gap_mm=0.1", "solver.rtol=1e-12", "solver.atol_N=1e-11",
)  # fmt: skip
"""A short, coarse finger, solved to rounding: the differences of its runs are good to 1e-8. Its
plate has a gap, as no central difference is to be had at a gap of 0."""

STEP = 1e-3
"""Step of the differences, as a part of a parameter's scale."""

STEP_RUBBING = 1e-4
"""This step if bellows rub. A difference of runs crosses a kink wherever a pair of contact comes
or goes between the two: with steps of 1e-3 by ξ2 it is off by 1.4e-3, with these by 3.3e-4."""

ELASTIC = (
    "extensions.mooney_rivlin.C01_MPa=1.0", "extensions.yeoh={}", "extensions.gent={}",
    "extensions.ogden={}", "extensions.bulk_modulus.more_MPa=10",
    "extensions.print_anisotropy.raster_deg=5", "extensions.temperature_drift={}",
    "extensions.pressure_gain={}", "extensions.pressure_offset={}",
)  # fmt: skip
INSTRUMENTS = (
    "extensions.angle_definition={}", "extensions.angle_gain={}", "extensions.angle_offset={}",
    "extensions.force_gain={}", "extensions.force_offset={}", "extensions.zero_drift={}",
)  # fmt: skip
LASTING = (
    "extensions.prony={}", "extensions.mullins={}", "extensions.permanent_set={}",
    "extensions.set_point_logged={}", "extensions.temperature_drift={}",
)  # fmt: skip
RUBBING = (
    "extensions.plate_friction={}", "extensions.bellows_friction={}", "finger.gap_mm=0.4",
    "plate.tilt_deg=5", "experiment.max_pressure_kPa=100", "experiment.step_kPa=50",
)  # fmt: skip
"""Bellows touch before 100 kPa. At a tilt of exactly 0 the force has a kink."""

CYCLES = ("experiment.cycles=2", "experiment.max_pressure_kPa=50", "experiment.step_kPa=25")
BLOCKED = (
    "finger.gap_mm=0.4", "plate.gap_mm=0.1", "plate.tilt_deg=5",
    "experiment.max_pressure_kPa=100", "experiment.step_kPa=50", "solver.max_step_kPa=25",
)  # fmt: skip
HANGING = ("extensions.gravity_pitch.pitch_deg=30", "experiment.max_pressure_kPa=50")
COMPLIANT = (
    "extensions.plate_compliance={}", "extensions.clamp_compliance={}",
    "extensions.plate_gap={}", "extensions.plate_tilt={}",
    "extensions.wall_offset={}", "extensions.base_layer_offset={}",
)  # fmt: skip
MOTION = (
    "experiment.dynamic=true", "protocol.time_s=[0.0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03]",
    "protocol.pressure_kPa=[0.0, 10.0, 20.0, 20.0, 20.0, 20.0, 20.0]",
    "solver.time_error_mm=10", "solver.max_step_s=0.0025", "contact.self_contact=false",
    "extensions.loss_factor.highest_Hz=50", "extensions.tip_mass.mass_g=2",
    "gravity.acceleration_m_s2=9.81",
)  # fmt: skip
"""A rise of the pressure in 10 ms and what follows, in steps of 2.5 ms. The loss has the same
number of branches on both sides of its frequencies."""
SUPPLIED = (
    "protocol.time_s=[0.0, 0.02, 0.04, 0.1, 0.2, 0.3]",
    "protocol.pressure_kPa=[0.0, 40.0, 40.0, 40.0, 40.0, 0.0]", "solver.max_step_s=0.01",
    "supply.valve_dm3_per_s_bar=0.01", "supply.leak_mm=0.3", "supply.exponent=1.2",
    "supply.duty=0.9", "supply.error_kPa=10",
    "supply.leak_growth_mm2=0.1", "supply.gauge_part=0.75",
)  # fmt: skip
"""The cavity fills through a valve, leaks and is vented."""


def rows(
    experiment: str, base: Config, changed: Config, moved: np.ndarray | None = None
) -> list[dict[str, float]]:
    """Readings at all stops of ``changed``, on the mesh of ``base`` with its points moved (mm)."""
    domain = load_domain(base, MPI.COMM_SELF)
    if moved is not None:
        domain.mesh.geometry.x[:] += moved
    finger = build(changed, domain, plate=experiment == "blocked_force")
    rig = FingerRig(changed, finger, Observation(finger), Profile())
    stops = find(experiment).schedule(changed)
    path = LoadPath(rig.newton, rig.longest())
    assert rig.start(path, stops[0]) is None
    found = []
    for stop in stops:
        arrival = path.advance(rig.controls(stop))
        assert arrival.failure is None, arrival.failure.sentence()
        found.append(rig.read())
    return found


def derivatives(
    experiment: str, config: Config, parameters: Sequence[Parameter]
) -> tuple[list[dict[str, float]], list[dict[str, int | float | str]]]:
    """Readings at all stops, and their derivatives as in ``sensitivity.csv``."""
    domain = load_domain(config, MPI.COMM_SELF)
    finger = build(config, domain, plate=experiment == "blocked_force")
    rig = FingerRig(config, finger, Observation(finger), Profile())
    forward = Sensitivities(rig, config, parameters)
    stops = find(experiment).schedule(config)
    path = LoadPath(rig.newton, rig.longest(), observers=[forward.forward])
    assert rig.start(path, stops[0]) is None
    found = []
    for i, stop in enumerate(stops):
        assert path.advance(rig.controls(stop)).failure is None
        found.append(rig.read())
        forward.record(i)
    return found, forward.rows


def difference(
    experiment: str, config: Config, direction: Mapping[Parameter, float], step: float = STEP
) -> list[dict[str, float]]:
    """Derivative of all readings along a direction, by central differences of two runs.

    Args:
        experiment: its name.
        config: in the middle.
        direction: change of each parameter, in its unit, for each unit of the result.
        step: half the change along it between the two runs.
    """
    ends = [shifted(experiment, config, direction, sign) for sign in (step, -step)]
    return [
        {name: (there[name] - back[name]) / (2 * step) for name in there}
        for there, back in zip(*ends, strict=True)
    ]


def shifted(
    experiment: str, config: Config, direction: Mapping[Parameter, float], part: float
) -> list[dict[str, float]]:
    """Readings at all stops, with parameters changed by a part of a direction.

    Args:
        experiment: its name.
        config: before the change, for which the mesh is made.
        direction: change of each parameter, in its unit, for the whole of it.
        part: of the direction.
    """
    points = load_domain(config, MPI.COMM_SELF).mesh.geometry.x
    moving, changed = np.zeros_like(points), config
    for parameter, rate in direction.items():
        if parameter.entry is Entry.SHAPE:
            moving += rate * velocity(parameter, config, points)
        changed = parameter.at(changed, parameter.value(config) + part * rate)
    return rows(experiment, config, changed, part * moving)


def error(
    base: Sequence[Mapping[str, float]],
    found: Sequence[Mapping[str, float]],
    expected: Sequence[Mapping[str, float]],
) -> tuple[float, str]:
    """Largest difference as part of the reading's scale, and the column where."""
    worst = (0.0, "")
    for name in found[0]:
        if name == "time_s":
            continue
        scale = max(abs(row[name]) for row in base)
        if scale == 0:
            continue
        apart = max(abs(a[name] - b[name]) for a, b in zip(found, expected, strict=True))
        worst = max(worst, (apart / scale, name))
    return worst


def by_parameter(
    slopes: Sequence[Mapping[str, int | float | str]], key: str, rate: float
) -> list[dict[str, float]]:
    """Rows of the derivatives by one parameter, times ``rate``."""
    count = 1 + max(int(row["row"]) for row in slopes)
    found: list[dict[str, float]] = [{} for _ in range(count)]
    for row in slopes:
        if row["parameter"] == key:
            found[int(row["row"])][str(row["column"])] = rate * float(row["derivative"])
    return found
