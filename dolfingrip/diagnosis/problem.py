"""A measurement beside its base simulation, as the inference takes it: arrays and covariances."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.channels import PRESSURE
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest, in_proportion
from dolfingrip.diagnosis.inference import candidate as inference
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.readings import load
from dolfingrip.diagnosis.model import FreeParameter, coupons_alone, wall_parameter
from dolfingrip.diagnosis.simulation.base import BaseSimulation
from dolfingrip.diagnosis.simulation.nuisances import WALL, Nuisance
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.simulation.walls import WallCurves
from dolfingrip.sections.geometry.index import TABLES

MODULUS: Final = "modulus"
"""The nuisance that fits treat beside the effect's parameters, as it may be far off."""

AREA: Final = "coupon_area"
"""Of coupons alone, what cannot be told from the modulus."""

LAW_LENGTH: Final = 0.3
"""Length of the error of a material's law, as part of the largest travel: exp(−distance), so of any
shape, smooth or not."""

LEAST_RATIO, MOST_RATIO = 0.3, 3.0


def index_of(measurement: Measurement) -> pd.DataFrame:
    """The table of single readings as the inference wants it, a row for each of ``listed()``."""
    listed = measurement.listed()
    rows = measurement.readings.iloc[listed["row"].to_numpy()].reset_index(drop=True)
    test = listed["test"].to_numpy()
    rates = {test.number: _pressure_rate(measurement, test) for test in measurement.tests}
    designs = {test.number: _design(test) for test in measurement.tests}
    return pd.DataFrame(
        {
            "channel": listed["column"].to_numpy(),
            "run": test,
            "experiment": listed["experiment"].to_numpy(),
            "specimen": listed["specimen"].to_numpy(),
            "design": np.array([designs[number] for number in test], dtype=object),
            "cycle": listed["cycle"].to_numpy(),
            "branch": listed["branch"].to_numpy(),
            "time_s": listed["time_s"].to_numpy(dtype=float),
            "pressure_kPa": rows["pressure_kPa"].to_numpy(dtype=float),
            "displacement_mm": rows["displacement_mm"].to_numpy(dtype=float),
            "rate_kPa_per_s": np.array([rates[number] for number in test], dtype=float),
        }
    )


DRAWN: Final = (*TABLES, "morph", "material", "film")
"""Sections of a set-up that tell how a specimen is drawn."""


def _design(test: SpecimenTest) -> str:
    """What a laboratory tells of a specimen's own dimensions and materials."""
    own = {name: dict(test.setup.sections.get(name, {})) for name in DRAWN}
    return json.dumps(own, sort_keys=True, default=str)


def _pressure_rate(measurement: Measurement, test: SpecimenTest) -> float:
    """Rate of the ramps in kPa/s; NaN where there is none, or another quantity is controlled."""
    rate = measurement.ramp_rate(test) if test.control == PRESSURE.name else None
    return np.nan if rate is None else rate


@dataclass(frozen=True, eq=False)
class Problem:
    """Arrays of the n readings that the base simulation reached.

    Attributes:
        measurement, base: where they come from.
        kept: places of the readings in ``measurement.listed()``, shape (n,).
        index: table of the readings.
        value: measured, shape (n,).
        noise: by place in ``tracks``: channel of each test.
        control_std: of the reading of the control, shape (n,).
        scale: the factor of all moduli, where fits find it beside the effects' parameters.
        walls: readings with other walls, where these are no linear nuisance.
        walls_at: thickness of the walls, by that configured, that the mesh's error is for.
        shifts: gap and regulator's zero, where they do so, too
            (:mod:`dolfingrip.diagnosis.contact_shift`); else they are linear nuisances.
    """

    measurement: Measurement
    base: BaseSimulation
    kept: np.ndarray
    index: pd.DataFrame
    value: Vector
    noise: Mapping[str, ChannelNoise]
    control_std: Vector
    scale: FreeParameter | None = None
    walls: WallCurves | None = None
    walls_at: float = 1.0
    shifts: tuple[FreeParameter, ...] = ()

    def take(self, values: np.ndarray) -> Vector:
        """Those of the readings that are kept, of an array over all."""
        return np.asarray(values[self.kept], dtype=float)

    @property
    def simulated(self) -> Vector:
        """y0 as configured, shape (n,)."""
        return self.take(self.base.readings)

    @cached_property
    def channel(self) -> np.ndarray:
        """Key of the noise of each reading: a column of a test, shape (n,)."""
        return noise_keys(self.index)

    @cached_property
    def ratio(self) -> Vector:
        """Measured by simulated of each column of each test, within reason, shape (n,)."""
        found = np.ones(len(self.value))
        for key in set(self.channel):
            at = self.channel == key
            square = float(self.simulated[at] @ self.simulated[at])
            if square > 0:
                found[at] = float(self.value[at] @ self.simulated[at]) / square
        return np.clip(found, LEAST_RATIO, MOST_RATIO)

    @property
    def wall(self) -> FreeParameter | None:
        """The walls' thickness, where fits find it beside the modulus."""
        if self.walls is None:
            return None
        return wall_parameter(min(t.setup.nuisances[WALL] for t in self.measurement.tests))

    def linear_nuisances(self) -> list[Nuisance]:
        """Nuisances whose change is taken as linear, at the size that the readings have."""
        in_scale: set[str] = set()
        if self.scale is not None:
            in_scale = {MODULUS, AREA} if coupons_alone(self.measurement) else {MODULUS}
        if self.walls is not None:
            in_scale.add(WALL)
        fitted = {each.key.rpartition(".")[2] for each in self.shifts}
        names = {"offset_kPa": "pressure_offset_kPa", "gap_mm": "plate_gap_mm"}
        in_scale |= {names[key] for key in fitted}
        found = [
            Nuisance(each.name, self.take(each.change) * self.ratio)
            for each in self.base.nuisance_list
            if each.name not in in_scale
        ]
        return [*found, *self._slack()]

    def _slack(self) -> list[Nuisance]:
        """Travel at which each coupon's force begins."""
        slope = self.take(self.base.by_control) * self.ratio
        found = []
        for test in self.measurement.tests:
            std_mm = test.setup.nuisances["coupon_slack_mm"]
            if test.experiment == "coupon" and std_mm:
                mine = (self.index["run"] == test.number).to_numpy()
                change = np.where(mine, slope * std_mm, 0.0)
                found.append(Nuisance(f"coupon_slack_mm of {test.specimen}", change))
        return found

    @cached_property
    def noise_std(self) -> Vector:
        """Standard deviation of the noise of each reading, shape (n,)."""
        own = np.array([self.noise[key].total_std() for key in self.channel])
        return np.asarray(np.hypot(own, self.gauge_std))

    @property
    def gauge_std(self) -> Vector:
        """What the noise of the gauge of the control does to each reading, shape (n,)."""
        return np.asarray(np.abs(self.take(self.base.by_control)) * self.ratio * self.control_std)

    @cached_property
    def noise_covariance(self) -> Matrix:
        """Σ, shape (n, n)."""
        matrix = noise_matrix(self.index.assign(channel=self.channel), self.noise)
        matrix[np.diag_indices(len(matrix))] += self.gauge_std**2
        return matrix

    def tolerance(self) -> Matrix:
        """Smooth changes of coupons' readings that no simple law follows, shape (n, m).

        Those of the force and of the width are independent of one another.
        """
        coupons = (self.index["experiment"] == "coupon").to_numpy()
        channels = self.index["channel"].to_numpy()
        own = [coupons & (channels == name) for name in dict.fromkeys(channels[coupons])]
        parts = [self._off_a_law(rows) for rows in own]
        return np.hstack([np.zeros((len(self.value), 0)), *parts])

    def _off_a_law(self, rows: np.ndarray) -> Matrix:
        """The same of these rows alone, shape (n, m)."""
        spreads = {t.number: t.setup.nuisances["material_law"] for t in self.measurement.tests}
        std = np.array([spreads[number] for number in self.index["run"]]) * rows
        place, where = np.unique(np.round(load(self.index), 3), return_inverse=True)
        apart = (place[:, None] - place[None, :]) / LAW_LENGTH
        values, vectors = np.linalg.eigh(np.exp(-np.abs(apart)))
        keep = values > 1e-6 * values[-1]
        root = (vectors[:, keep] * np.sqrt(values[keep]))[where]
        size = np.abs(self.simulated) * self.ratio
        return np.asarray(root * (std * size)[:, None])

    @cached_property
    def nuisances(self) -> Matrix:
        """Changes by one standard deviation of each nuisance, shape (n, k).

        The modulus is among them where it is none of the parameters that are fitted.
        """
        parts = [each.change[:, None] for each in self.linear_nuisances()]
        return np.hstack([np.zeros((len(self.value), 0)), *parts])

    @cached_property
    def errors(self) -> Matrix:
        """What mesh and material laws get wrong, as columns of one standard deviation, (n, l)."""
        mesh = self.base.mesh
        if self.walls is not None and mesh.shape[1]:
            mesh = mesh + self.walls.mesh(self.walls_at)[:, None]
        return np.hstack([np.nan_to_num(mesh[self.kept]), self.tolerance()])

    @cached_property
    def error_covariance(self) -> Covariance:
        """Of noise, mesh and laws, at known nuisances."""
        return Covariance.of(self.noise_covariance + self.errors @ self.errors.T)

    @cached_property
    def covariance(self) -> Covariance:
        """Of the residual at known parameters: noise, nuisances and mesh."""
        return self.error_covariance.widened(self.nuisances)

    def with_noise(self, noise: Mapping[str, ChannelNoise]) -> Problem:
        """The same readings under another model of the noise."""
        return replace(self, noise=noise)

    def candidates(self, left_out: Sequence[str] = ()) -> list[inference.Candidate]:
        """The effects that some reading feels, as the inference takes them."""
        return [
            as_candidate(self, each)
            for each in self.base.candidates
            if each.felt and each.name not in left_out
        ]


def as_candidate(problem: Problem, found: Candidate) -> inference.Candidate:
    """An effect's secants as the inference takes them."""
    # a coupon's force changes in proportion to its modulus, which the readings tell
    size = np.where(in_proportion(problem.measurement)[problem.kept], problem.ratio, 1.0)
    # tried on both sides: each has a change of its own, and a strength above 0
    side = np.sign(found.parts)
    shapes = tuple(
        inference.Shape(problem.take(change) * size * sign, label)
        for change, label, sign in zip(found.shapes, found.labels, side, strict=True)
    )
    one_sided = found.one_sided or bool((side < 0).any())
    return inference.Candidate(found.name, shapes, spread=found.spread, one_sided=one_sided)


def noise_keys(index: pd.DataFrame) -> np.ndarray:
    """Which noise each reading has: a column of a test, shape (n,)."""
    return np.array(
        [
            f"{column} of test {run}"
            for column, run in zip(index["channel"], index["run"], strict=True)
        ]
    )
