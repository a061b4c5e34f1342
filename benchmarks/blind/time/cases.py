"""What is hidden in each case in time, its readings, and its diagnosis.

Each case of a protocol hides one cause, or a pair that is easily confused. Strengths are drawn
from the ordinary part of their priors, and numbers that a laboratory tells are 3 to 5 standard
deviations off. The truth has another mesh and shorter steps in time than the analyser.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import tomlkit

from benchmarks.blind import said
from benchmarks.blind.case import FAR, Case, ordinary
from benchmarks.blind.frozen import FrozenCase
from dolfingrip import config as configuration
from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.core.unknown import causes
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose
from dolfingrip.experiments import run
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import effect
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest

SEED: Final = 740511
STL: Final = Path(__file__).resolve().parents[3] / "examples" / "released_beam" / "beam.stl"

BEAM: Final[Change] = {
    "finger.kind": "adopted", "adopted.length_mm": 100, "adopted.width_mm": 30,
    "adopted.depth_mm": 30, "adopted.solid_body": True, "morph.d_mm": 15,
    "material.mu_MPa": 0.09, "material.density_kg_m3": 1070, "contact.self_contact": False,
    "gravity.acceleration_m_s2": 9.81, "gravity.direction": [-1, 0, 0],
    "release.held_x_mm": 0.0, "experiment.dynamic": True, "solver.time_error_mm": 0.05,
}  # fmt: skip
LOSSY: Final[Change] = {**BEAM, "extensions.loss_factor.loss_factor": 0.1}
FINGER: Final[Change] = {
    "mesh.size_mm": 10, "mesh.edge_size_mm": 10, "finger.length_mm": 38, "finger.bellows": 2,
    "contact.self_contact": False, "material.mu_MPa": 1.0, "experiment.max_pressure_kPa": 40,
}  # fmt: skip
FINER: Final[Change] = {"mesh.size_mm": 8, "mesh.edge_size_mm": 8}
PUMP: Final[Change] = {
    **FINGER, "supply.source": "pump", "supply.pump_kPa": [0.0, 100.0],
    "supply.pump_l_per_min": [3.0, 0.0], "supply.valve_dm3_per_s_bar": 0.02,
    "supply.tube_dm3_per_s_bar": 0.05, "supply.tube_cm3": 5.0,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Protocol:
    """A plan of what is measured.

    Attributes:
        name: of it.
        model: that is diagnosed, by changes of the default.
        truth: further changes of the generator's: its mesh, and its steps in time.
        times_s, pressures_kPa: of the rows.
        noise: standard deviation of each column that is read, in its unit; a force is that of the
            blocked finger.
        effects: that are tried.
        modulus: relative standard deviation of the modulus, as told. Swings and sags tell modulus
            by density alone; so a coupon was pulled where a density is hidden.
        meshes_mm: sizes of the elements of an adopted beam, the analyser's and the generator's.
        cycle: of each row, where it is told.
    """

    name: str
    model: Change
    truth: Change
    times_s: np.ndarray
    pressures_kPa: np.ndarray
    noise: Mapping[str, float]
    effects: tuple[str, ...]
    modulus: float = 0.1
    meshes_mm: tuple[float, float] | None = None
    cycle: np.ndarray | None = None

    @property
    def protocol(self) -> dict[str, list[float]]:
        """Columns that are prescribed."""
        columns = {"time_s": self.times_s, "pressure_kPa": self.pressures_kPa}
        if self.cycle is not None:
            columns["cycle"] = self.cycle
        return {name: values.tolist() for name, values in columns.items()}

    @property
    def experiments(self) -> dict[str, list[str]]:
        """Columns that are read in each experiment."""
        forces = [name for name in self.noise if name == "force_N"]
        others = [name for name in self.noise if name not in forces]
        return {"bending": others} | ({"blocked_force": forces} if forces else {})


SWING_S: Final = np.arange(0.0, 0.2001, 0.01)
FILL_S: Final = np.arange(0.0, 2.001, 0.1)
RISE_S: Final = np.array([0, 0.25, 0.5, 0.75, 1, 1.5, 3, 3.25, 3.5, 3.75, 4])
TIRED: Final = np.repeat([1, 10, 100, 1000], 4)
WAIT_S: Final = np.array([0, 1, 2, 4, 10, 60, 120, 240, 480, 600, 601, 602, 604, 700, 900])
MOVING: Final = ("loss_factor", "density", "tip_mass", "sensor_lag", "prony")

PROTOCOLS: Final[Mapping[str, Protocol]] = {
    plan.name: plan
    for plan in (
        Protocol("swing", LOSSY, {"solver.time_error_mm": 0.005}, SWING_S, 0 * SWING_S,
                 {"tip_x_mm": 0.05}, ("density", "tip_mass", "sensor_lag"), 0.02, (30.0, 25.0)),
        Protocol("elastic", BEAM, {"solver.time_error_mm": 0.005}, SWING_S, 0 * SWING_S,
                 {"tip_x_mm": 0.05}, MOVING, meshes_mm=(30.0, 25.0)),
        Protocol("filling", PUMP, {**FINER, "supply.error_kPa": 0.02}, FILL_S,
                 np.where((FILL_S > 0) & (FILL_S < 1.05), 40.0, 0.0), {"angle_deg": 0.03},
                 ("leak", "dead_volume", "starving_valve", "sensor_lag", "set_point_logged")),
        Protocol("waits", FINGER, FINER, WAIT_S,
                 np.interp(WAIT_S, [0, 4, 600, 604], [0, 40, 40, 0]), {"angle_deg": 0.05},
                 ("zero_drift", "prony", "temperature_drift", "permanent_set")),
        Protocol("gauge", {**PUMP, "supply.gauge_part": 0.0, "supply.tube_dm3_per_s_bar": 0.02},
                 {**FINER, "supply.error_kPa": 0.02}, FILL_S,
                 np.where((FILL_S > 0) & (FILL_S < 1.05), 40.0, 0.0), {"angle_deg": 0.03},
                 ("gauge_at_the_source", "leak", "dead_volume", "sensor_lag")),
        Protocol("rise", {**FINGER, "plate.gap_mm": 0.1}, FINER, RISE_S,
                 np.interp(RISE_S, [0, 1, 3, 4], [0, 40, 40, 0]),
                 {"angle_deg": 0.03, "force_N": 0.002},
                 ("set_point_logged", "sensor_lag", "prony")),
        Protocol("tired", FINGER, FINER, 10.0 * TIRED + np.tile([0, 2, 4, 6], 4),
                 np.tile([0.0, 20.0, 40.0, 20.0], 4), {"angle_deg": 0.03},
                 ("fatigue", "mullins", "permanent_set", "temperature_drift"), cycle=TIRED),
    )
}  # fmt: skip
"""``swing``: a beam of silicone that is held level and let go; ``elastic``: the same, of whose loss
the analyser knows nothing; ``filling``: a finger that a pump fills and a valve vents; ``waits``:
one that is held under pressure for ten minutes, and rests; ``gauge``: ``filling`` with a gauge that
is taken to be at the cavity; ``rise``: a ramp whose angle and force are read; ``tired``: four of a
thousand cycles."""

HIDDEN: Final[Mapping[str, Mapping[str, tuple[tuple[str, ...], ...]]]] = {
    "swing": {"one": 3 * (("sensor_lag",), ("density",), ("tip_mass",)),
              "two": (("density", "sensor_lag"), ("density", "tip_mass"))},
    "elastic": {"one": 3 * (("loss_factor",),), "two": (("loss_factor", "sensor_lag"),)},
    "filling": {"one": 3 * (("leak",), ("dead_volume",), ("starving_valve",)),
                "two": (("set_point_logged", "sensor_lag"), ("dead_volume", "starving_valve"))},
    "waits": {"one": 3 * (("zero_drift",),), "two": (("zero_drift", "prony"),)},
    "gauge": {"one": 3 * (("gauge_at_the_source",),), "two": (("gauge_at_the_source", "leak"),)},
    "rise": {"one": 3 * (("set_point_logged",),), "two": (("set_point_logged", "prony"),)},
    "tired": {"one": 3 * (("fatigue",),), "two": (("fatigue", "mullins"),)},
}  # fmt: skip
"""Causes of each case by its kind, in the order of its number."""


@dataclass(frozen=True, slots=True)
class Truth:
    """Causes and numbers that are hidden.

    Attributes:
        causes: change of the configuration by effects and by numbers that were told wrongly.
        modulus: true by configured.
        outsider: none is hidden here.
    """

    causes: Change
    modulus: float
    outsider: tuple[str, float] = ("", 0.0)


def configured(plan: Protocol, scratch: Path, *, truly: bool = False) -> Config:
    """Return the analyser's configuration, or the generator's before anything is hidden.

    Args:
        plan: the protocol.
        scratch: folder of meshes.
        truly: whether the generator's.
    """
    change: dict[str, Any] = {**plan.model, **(plan.truth if truly else {})}
    if plan.meshes_mm:
        size_mm = plan.meshes_mm[truly]
        mesh = scratch / f"beam-{size_mm:g}.msh"
        if not mesh.exists():
            mesh.parent.mkdir(parents=True, exist_ok=True)
            back = Asked(back=(-1.0, 0.0, 0.0))
            files.write(mesh, adopt(STL, back, MeshRequest(size_mm=size_mm)).mesh)
        change["mesh.file"] = str(mesh)
    return configuration.load(None, change)


def drawn(plan: Protocol, scratch: Path, which: str, kind: str, number: int) -> Case[Truth]:
    """Draw a case.

    Args:
        plan: the protocol.
        scratch: folder of meshes.
        which: the set, of which there is one.
        kind, number: of the case.
    """
    seed = (SEED, list(PROTOCOLS).index(plan.name), len(kind), number, len(which))
    rng, names = np.random.default_rng(seed), HIDDEN[plan.name][kind][number]
    config = configured(plan, scratch)
    by_name = {cause.name: cause for cause in causes(config, names)}
    modulus, change, zetas = (
        float(np.exp(plan.modulus * rng.standard_normal())),
        dict[str, Any](),
        [],
    )
    for name in names:
        if name in by_name:
            cause = by_name[name]
            zeta = ordinary(rng, cause, 1.0)
            change |= cause.overrides(zeta)
            zetas += zeta.tolist()
        else:
            change |= _told_wrongly(effect(name), config, rng)
    return Case(plan.name, kind, number, False, Truth(change, modulus), names, tuple(zetas), (),
                seed)  # fmt: skip


def _told_wrongly(cls: type[Effect], config: Config, rng: np.random.Generator) -> Change:
    """A number that a laboratory tells, 3 to 5 standard deviations off, within its bounds."""
    number = cls.fitted(config)
    assert number is not None
    spread = cls.told.spread(cls.told.std, number.value)
    off = float(rng.uniform(*FAR)) * spread
    below = rng.random() < 0.5 and number.value - off > max(number.low, 0.2 * number.value)
    return {number.key: number.value + (-off if below else off)}


def measured(plan: Protocol, scratch: Path, case: Case[Truth]) -> Path:
    """Measure a case, and write its readings and what the laboratory tells.

    Args:
        plan: the protocol.
        scratch: folder that is written to.
        case: what is hidden.
    """
    base = configured(plan, scratch, truly=True)
    modulus = {"material.mu_MPa": case.truth.modulus * base.material.shear_MPa}
    truth = changed(base, {**modulus, **case.truth.causes}).changed(protocol=plan.protocol)
    rng, tables = np.random.default_rng((*case.seed, 1)), []
    for experiment, columns in plan.experiments.items():
        result = run(experiment, truth)
        assert result.failure is None, result.failure.sentence()
        rows = pd.DataFrame({"experiment": experiment, **plan.protocol})
        for name in columns:
            rows[name] = result.column(name) + plan.noise[name] * rng.standard_normal(len(rows))
        tables.append(rows)
    folder = scratch / f"{case.kind}-{case.number}"
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{plan.name}.csv"
    pd.concat(tables).to_csv(file, index=False, float_format="%.6g", lineterminator="\n")
    told: dict[str, Any] = {"experiment": list(plan.experiments), "noise": {**plan.noise},
                            "nuisance": {"modulus": plan.modulus}}  # fmt: skip
    if len(plan.experiments) > 1:
        told["plate"] = {"gap_mm": base.plate.gap_mm}
    file.with_suffix(".toml").write_text(tomlkit.dumps(told), encoding="utf-8")
    return file


def diagnosed(plan: Protocol, scratch: Path, case: Case[Truth]) -> Diagnosis:
    """Measure, write, read and diagnose a case up to its verdict.

    Args:
        plan: the protocol.
        scratch: folder that is written to.
        case: what is hidden.
    """
    file = measured(plan, scratch, case)
    how = DiagnosisSettings(1, scratch / "analyser", effects=plan.effects)
    return diagnose([file], configured(plan, scratch), file.parent, how)


def frozen(case: Case[Truth]) -> FrozenCase:
    """Tell what is hidden in a case."""
    numbers = {"modulus": case.truth.modulus, **case.truth.causes}
    return FrozenCase(case.protocol, case.kind, case.number, case.wide, case.names,
                      numbers=numbers, seed=case.seed)  # fmt: skip


def bench(plan: Protocol, scratch: Path) -> said.Bench[Case[Truth]]:
    """Return what draws, measures and diagnoses the cases of a protocol.

    Args:
        plan: the protocol.
        scratch: folder of measurements and simulations.
    """
    return said.Bench(
        partial(drawn, plan, scratch), partial(diagnosed, plan, scratch),
        measured=partial(measured, plan, scratch), frozen=frozen,
    )  # fmt: skip
