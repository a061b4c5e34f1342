"""A finger as it truly is: its readings, simulated in full, and the files of the laboratory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy.linalg
import tomlkit
from support import small
from support.stiffened import stiffened

from benchmarks.blind.fingers.outsiders import OUTSIDERS
from dolfingrip import config as configuration
from dolfingrip.channels import CHANNELS
from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.simulation.runner import Workers, request
from dolfingrip.diagnosis.simulation.simulated import path_independent
from dolfingrip.experiments.request import Request
from dolfingrip.parameter import scaled
from dolfingrip.sections.tables import assignments

SETTINGS: Final = (
    "contact.barrier_mm=0.15",
    "contact.stiffness_MPa=0.01",
    "plate.barrier_mm=0.07",
    "plate.stiffness_MPa=0.2",
    "solver.max_step_kPa=17",
)
"""Other than the analyser's."""

MODULUS: Final = 0.2
WALL: Final = 0.05
GAIN: Final = 0.015
"""Standard deviations of nuisances that the analyser is not told, relative."""

SHARE: Final = 0.25
LASTS_S: Final = 20.0
"""Part of the noise's variance that drifts along a test, and for how long it keeps."""
MISSING: Final = 0.06
"""Probability that a reading is missing."""

RATE_kPa_per_s: Final = 25.0
"""Of the ramp that a finger without memory is simulated on."""
KEYS: Final = ("cycle", "branch", "time_s")
CONTROL: Final = {"coupon": "displacement_mm"}
PRESSURE: Final = "pressure_kPa"
"""Control of an experiment, where it is another."""


@dataclass(frozen=True, slots=True)
class Protocol:
    """A plan of what is measured.

    Attributes:
        name: of it.
        finger: overrides of the configured finger and of the analyser's mesh.
        mesh: overrides of the generator's.
        strength_mesh: likewise of the mesh on which strengths are counted.
        tests: ``cycle``, ``branch``, ``time_s`` and control of each row, by experiment.
        columns: that are read, by experiment.
        gap_mm: of the plate, as told.
        offset_std_kPa, gap_std_mm: of the regulator's zero and of the plate, as told.
        noise: by the ordinary one of each channel.
        once: whether a finger without memory is simulated up to the largest pressure once, and read
            there.
        settings: of the set-up beside the plate's gap, as told, by key of the configuration.
    """

    name: str
    finger: tuple[str, ...]
    mesh: tuple[str, ...]
    strength_mesh: tuple[str, ...]
    tests: Mapping[str, pd.DataFrame]
    columns: Mapping[str, tuple[str, ...]]
    gap_mm: float = 1.0
    offset_std_kPa: float = 2.0
    gap_std_mm: float = 0.3
    noise: float = 1.0
    once: bool = False
    settings: Change = field(default_factory=dict)

    def analysed(self) -> Config:
        """The model that is diagnosed."""
        return configuration.load(None, assignments(list(self.finger)))

    def std(self, column: str) -> float:
        """Return the standard deviation of a channel's noise, in its unit."""
        return self.noise * CHANNELS[column].noise


@dataclass(frozen=True, slots=True)
class Truth:
    """The hidden truth.

    Attributes:
        causes: values of effects of the catalogue by key, moduli at the configured stiffness.
        outsider: name, and strength by the ordinary one; none where empty.
        modulus: true by told.
        far: standard deviations from what was told, by the catalogue's name of a nuisance.
    """

    causes: Change = field(default_factory=dict)
    outsider: tuple[str, float] = ("", 0.0)
    modulus: float = 1.0
    far: dict[str, float] = field(default_factory=dict)


def ramped(control: str, ramps: list[tuple[float, int, float]], wait: float = 0.0) -> pd.DataFrame:
    """Ramps from rest: to (control's unit), readings, rate (per second); a wait (s) at the end."""
    rows: list[dict[str, Any]] = [{"cycle": 1, "branch": "loading", "time_s": 0.0, control: 0.0}]
    for number, (end, count, rate) in enumerate(ramps):
        start, begun_s = rows[-1][control], rows[-1]["time_s"]
        branch = "loading" if end > start else "unloading"
        rows += [
            {"cycle": 1 + number // 2, "branch": branch,
             "time_s": begun_s + abs(at - start) / rate, control: float(at)}
            for at in np.linspace(start, end, count + 1)[1:]
        ]  # fmt: skip
    held = {**rows[-1], "branch": "hold"}
    for part in (0.03, 0.1, 0.3, 0.6, 1.0):
        if wait:
            rows.append({**held, "time_s": held["time_s"] + wait * part})
    return pd.DataFrame(rows)


FREE: Final = {"bending": ("angle_deg",), "blocked_force": ("force_N",)}
TIP: Final = ("tip_x_mm", "tip_z_mm")
RICH: Final = {
    "bending": ("angle_deg", *TIP),
    "blocked_force": ("force_N", "angle_deg", *TIP),
    "coupon": ("force_N",),
}
COUPON_mm: Final = 16.5
SHORT: Final = (
    "mesh.size_mm=6", "mesh.edge_size_mm=4", "finger.length_mm=38", "finger.bellows=2",
)  # fmt: skip
"""Two bellows, coarsely meshed by the analyser."""
FEW: Final = (*SHORT, *small.FEW)
"""The same on half the elements; folds are not looked at, as they do not touch up to 50 kPa."""
SHORT_MESH: Final = ("solver.element=P2", "mesh.size_mm=5", "mesh.edge_size_mm=3")
MESH: Final = (
    "solver.element=S2", "mesh.size_mm=3", "mesh.edge_size_mm=0.125",
    "contact.stiffness_MPa=0.005",
)  # fmt: skip
"""At 250 kPa these hexahedra turn the reference finger by 147.3°, a converged mesh by 147.9°. With
contact twice as stiff their folds snap from 192 kPa on, and a simulation takes twice as long."""

_UP_AND_DOWN: Final = ramped(PRESSURE, [(250.0, 10, 25.0), (0.0, 10, 25.0)])
_LONG: Final = ramped(
    PRESSURE,
    [(250.0, 10, 25.0), (0.0, 10, 25.0), (250.0, 5, 25.0), (0.0, 5, 25.0),
     (250.0, 5, 2.5), (0.0, 5, 2.5), (250.0, 5, 25.0)],
    wait=60.0,
)  # fmt: skip
_SHORT: Final = ramped(PRESSURE, [(50.0, 10, 25.0), (0.0, 10, 25.0)])
_PULLED: Final = ramped("displacement_mm", [(COUPON_mm, 10, 0.55), (0.0, 10, 0.55)])

PROTOCOLS: Final[Mapping[str, Protocol]] = {
    each.name: each
    for each in (
        Protocol("short", SHORT, SHORT_MESH, SHORT_MESH, dict.fromkeys(FREE, _SHORT), FREE,
                 gap_mm=0.1, offset_std_kPa=0.2, gap_std_mm=0.03, noise=0.5),
        Protocol("reference", (), MESH, (), dict.fromkeys(FREE, _UP_AND_DOWN), FREE,
                 once=True),
        Protocol("rich", (), MESH, (), {**dict.fromkeys(FREE, _LONG), "coupon": _PULLED}, RICH,
                 once=True),
        Protocol("few", FEW, SHORT_MESH, SHORT_MESH, dict.fromkeys(FREE, _SHORT), FREE,
                 gap_mm=0.1, offset_std_kPa=0.2, gap_std_mm=0.03, noise=0.5),
    )
}  # fmt: skip
"""``short``: two bellows, free and blocked, up and down. ``reference``: the same of the reference
finger. ``rich``: with two more cycles, the second ten times as slow, a wait, tip and coupon.
``few``: as ``short`` on half the elements, for continuous integration."""


def configured(protocol: Protocol, truth: Truth) -> Config:
    """The generator's configuration with all that is hidden but what an outsider displays."""
    told = [*protocol.finger, *SETTINGS, *protocol.mesh, f"plate.gap_mm={protocol.gap_mm}"]
    base = configuration.load(None, assignments(told))
    far = truth.far
    gap_mm = base.plate.gap_mm + protocol.gap_std_mm * far.get("plate_gap", 0.0)
    wall_mm = base.finger.wall_mm * (1 + WALL * far.get("wall_offset", 0.0))
    change = OUTSIDERS[truth.outsider[0]].overrides if truth.outsider[0] else None
    offset_kPa = protocol.offset_std_kPa * far.get("pressure_offset", 0.0)
    return changed(base, {
        **protocol.settings,
        **scaled(base, truth.modulus),
        "finger.wall_mm": wall_mm,
        "plate.gap_mm": max(gap_mm, 0.0),
        "extensions.pressure_gain.gain": 1 + GAIN * far.get("pressure_gain", 0.0),
        "extensions.pressure_offset.offset_kPa": offset_kPa,
        **(change(base, truth.outsider[1]) if change else {}),
        **stiffened(truth.causes, truth.modulus),
    })  # fmt: skip


def simulated(protocol: Protocol, truth: Truth) -> list[tuple[Request, np.ndarray]]:
    """Return the simulation of each test, and which of its stops each row is, shape (rows,).

    Args:
        protocol: the tests.
        truth: what is hidden.
    """
    config = configured(protocol, truth)
    act = OUTSIDERS[truth.outsider[0]].pressure if truth.outsider[0] else None
    found = []
    for experiment, rows in protocol.tests.items():
        control = CONTROL.get(experiment, PRESSURE)
        at = act(rows, truth.outsider[1]) if act and control == PRESSURE else rows[control]
        told, stops = rows.assign(**{control: at}), np.arange(len(rows))
        if protocol.once and control == PRESSURE and path_independent(config):
            _, first, stops = np.unique(at, return_index=True, return_inverse=True)
            told = told.iloc[first].assign(cycle=1, branch="loading")
            told["time_s"] = told[control] / RATE_kPa_per_s
        protocol_of = {name: told[name].tolist() for name in (*KEYS, control)}
        found.append((request(experiment, config.changed(protocol=protocol_of)), stops))
    return found


def measured(protocol: Protocol, truth: Truth, workers: Workers) -> list[pd.DataFrame]:
    """Readings of each test without noise: its rows with the columns that are read.

    Raises:
        ValueError: where a simulation does not reach all rows.
    """
    requests, every = zip(*simulated(protocol, truth), strict=True)
    results = workers.results(requests)
    show = OUTSIDERS[truth.outsider[0]].displayed if truth.outsider[0] else None
    found = []
    for (experiment, rows), stops, result in zip(
        protocol.tests.items(), every, results, strict=True
    ):
        if result.failure_class is not None:
            raise ValueError(f"{experiment}: {result.failure}")
        true = {name: result.columns[name][stops] for name in protocol.columns[experiment]}
        if show and experiment != "coupon":
            true |= show(rows, true, truth.outsider[1])
        found.append(rows.assign(**true))
    return found


def flat(protocol: Protocol, tables: list[pd.DataFrame]) -> np.ndarray:
    """Readings (n,) by the standard deviation of their noise."""
    return np.concatenate([
        table[name].to_numpy() / protocol.std(name)
        for table, names in zip(tables, protocol.columns.values(), strict=True) for name in names
    ])  # fmt: skip


def scattered(
    protocol: Protocol, tables: list[pd.DataFrame], rng: np.random.Generator
) -> list[pd.DataFrame]:
    """Add noise, of which a part drifts, and leave some readings out."""
    found = []
    for table, names in zip(tables, protocol.columns.values(), strict=True):
        time_s = table["time_s"].to_numpy()
        kept = np.exp(-np.abs(np.subtract.outer(time_s, time_s)) / LASTS_S)
        lower = scipy.linalg.cholesky((1 - SHARE) * np.eye(len(time_s)) + SHARE * kept, lower=True)
        shown = {}
        for name in names:
            noise = protocol.std(name) * lower @ rng.standard_normal(len(time_s))
            gone = rng.random(len(time_s)) < MISSING
            shown[name] = np.where(gone, np.nan, table[name] + noise)
        found.append(table.assign(**shown))
    return found


def write(protocol: Protocol, tables: list[pd.DataFrame], folder: Path) -> Path:
    """Write a CSV and its TOML, as a laboratory hands them over."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{protocol.name}.csv"
    parts = [
        table.assign(experiment=experiment, specimen="A")
        for experiment, table in zip(protocol.tests, tables, strict=True)
    ]
    every = pd.concat(parts, ignore_index=True)
    first = ["experiment", "specimen", *KEYS]
    every = every[[*first, *(name for name in every if name not in first)]]
    every.to_csv(file, index=False, float_format="%.6g", lineterminator="\n")
    file.with_suffix(".toml").write_text(tomlkit.dumps(told(protocol)), encoding="utf-8")
    return file


def told(protocol: Protocol) -> dict[str, Any]:
    """Return what the laboratory tells of its set-up."""
    read = list(dict.fromkeys(name for names in protocol.columns.values() for name in names))
    noise: dict[str, Any] = {
        name: round(protocol.std(name) * (1 - SHARE) ** 0.5, 6) for name in read
    }
    drifting = {name: round(protocol.std(name) * SHARE**0.5, 6) for name in read}
    noise["correlated"] = {**drifting, "correlation_time_s": LASTS_S}
    known = {
        "pressure_offset_kPa": protocol.offset_std_kPa, "plate_gap_mm": protocol.gap_std_mm,
    }  # fmt: skip
    found: dict[str, Any] = {"experiment": list(protocol.tests)}
    if "coupon" in protocol.tests:
        # what the generator's coupons do not have
        known |= {"coupon_slack_mm": 0.0, "material_law": 0.0}
        found |= {"gauge_length_mm": 33.0, "area_mm2": 9.0}
    sections: dict[str, dict[str, Any]] = {"plate": {"gap_mm": protocol.gap_mm}}
    for key, value in protocol.settings.items():
        section, _, name = key.partition(".")
        sections.setdefault(section, {})[name] = value
    return {**found, **sections, "nuisance": known, "noise": noise}
