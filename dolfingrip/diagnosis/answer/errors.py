"""Everything but causes and the rig's numbers that readings differ by, as one covariance.

Noise (:mod:`.noise`), the mesh, specimens (:mod:`.specimens`), artefacts of instruments
(:mod:`.artefacts`), and where the readings lie for a discrepancy (:mod:`.discrepancy`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd
from numpy.polynomial import chebyshev

from dolfingrip.diagnosis.answer.artefacts import Artefact, plays
from dolfingrip.diagnosis.answer.discrepancy import Along, lying, smooth_curves
from dolfingrip.diagnosis.answer.noise import drifting, instrument_noise
from dolfingrip.diagnosis.answer.specimens import between
from dolfingrip.diagnosis.core.unknown import Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger import Simulator
from dolfingrip.files.diagnosis import NoiseSource, Scatter

SLACK: Final = "coupon_slack_mm"


@dataclass(frozen=True, eq=False)
class Errors:
    """Everything but causes that readings differ by.

    Attributes:
        unfitted: covariance of what no fit gives a number, shape (n, n): noise, and how specimens
            differ in shape.
        individual: covariance of what a fit gives the mesh and each specimen, shape (n, n).
        noise: of instruments and gauge, standard deviations, shape (n,).
        steep: derivatives of a smooth curve through the readings by the control, shape (n,).
        along: where the readings lie, for a discrepancy that all specimens share.
        signal: a smooth curve through the readings, shape (n,).
        rig: its numbers, which every hypothesis fits.
        scatter: of the specimens.
        sources: of noises that the laboratory does not tell.
        artefacts: of instruments, whose sizes are numbers of the rig, too.
    """

    unfitted: np.ndarray
    individual: np.ndarray
    noise: np.ndarray
    steep: np.ndarray
    along: Along
    signal: np.ndarray
    rig: tuple[Nuisance, ...]
    scatter: Scatter
    sources: tuple[NoiseSource, ...]
    artefacts: tuple[Artefact, ...] = ()

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance (n, n) of all but the rig's numbers."""
        return self.unfitted + self.individual


def errors_of(simulation: Simulator) -> Errors:
    """Everything but causes, as one covariance.

    Where the gauge of the control has noise, and where coupons have slack, the slope by the control
    counts. It is that of a smooth curve through the readings: a material that softens answers a
    slip of the travel at its toe by more, and later by less, than the configured one.

    Args:
        simulation: of the model. Where it is in closed form the rig's changes are by the readings
            as those of the model are by its own.
    """
    measurement, rig, base = simulation.measurement, simulation.rig, simulation.base.readings
    slope = np.nan_to_num(simulation.base.by_control)
    listed = measurement.listed
    along = lying(simulation)
    factor, turned = followed(listed, along, base)
    control, signal = listed["control"].to_numpy(), base * factor
    moved = (np.abs(control) > 1e-9) & (slope != 0)
    by_control = np.where(moved, along.load / np.where(moved, control, 1.0), 0.0)
    test, row = listed["test"].to_numpy(), listed["row"].to_numpy()
    steep = slope * factor + base * turned * by_control
    by = factor if simulation.closed_form else np.ones(len(test))
    shared = [replace(nuisance, change=nuisance.change * by) for nuisance in rig]
    off = of_mesh(simulation.mesh, listed["experiment"], along.load)
    individual = off @ off.T
    slack_mm = np.array([
        test.setup.nuisances[SLACK] if test.experiment == "coupon" else 0.0
        for test in measurement.tests
    ])  # fmt: skip
    if slack_mm.any():
        late = -slack_mm[test] * steep  # at a travel, what is slack is pulled by less
        # half of the variance is each coupon's own, half the rig's
        individual += 0.5 * np.outer(late, late) * (test[:, None] == test)
        share = float(np.sqrt(0.5))
        slack = Unknown.marginal(SLACK, share * float(slack_mm.max()), "mm")
        shared.insert(0, Nuisance(slack, share * late))
    instrument, sources = instrument_noise(measurement)
    # one reading of the control stands behind all readings of its row
    gauge = steep * instrument["control"].to_numpy() / np.sqrt(_in_a_mean(measurement))[row]
    read = (
        np.diag(np.maximum(instrument["independent"].to_numpy(), 1e-9) ** 2)
        + drifting(measurement, instrument)
        + np.outer(gauge, gauge) * (row[:, None] == row)
    )
    alike = read + individual + sum(np.outer(n.change, n.change) for n in shared)
    scatter, stiff, shape = between(measurement, alike, along, signal)
    return Errors(
        read + shape, individual + stiff, np.sqrt(np.diag(read)), steep, along, signal,
        tuple(shared), scatter, sources,
    )  # fmt: skip


def of_mesh(error: np.ndarray, experiment: pd.Series, load: np.ndarray) -> np.ndarray:
    """Ways in which a mesh may be wrong, (n, k), one standard deviation each.

    Together they are ``error``. In each experiment a mesh may be wrong by another part at small
    loads than at large ones: a finger that presses has contact, and the error of a mesh is no
    multiple of what grading changes.

    Args:
        error: of the mesh, with its sign, shape (n,).
        experiment: of each reading, (n,).
        load: by the largest of the experiment, shape (n,).
    """
    by_experiment = error[:, None] * pd.get_dummies(experiment).to_numpy(float)
    part = np.abs(load)[:, None]
    return np.hstack([by_experiment * (1 - part), by_experiment * part])


def _in_a_mean(measurement: Measurement) -> np.ndarray:
    """Number of rows whose mean each row's pressure or travel is: in a wait all of them."""
    rows = measurement.readings
    waits = (rows["branch"] == "hold").to_numpy()
    counts = rows.groupby(["test", "leg"])["leg"].transform("size").to_numpy()
    return np.where(waits, counts, 1)


def followed(listed: pd.DataFrame, along: Along, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit the factor that makes the model's readings a smooth curve through those measured.

    A polynomial of the load for each channel, protocol and branch.

    Args:
        listed: the readings.
        along: where they lie.
        base: those of the model, shape (n,).

    Returns:
        The factor, shape (n,), and its derivative by the load, shape (n,).
    """
    value = listed["value"].to_numpy()
    factor, turned = np.zeros(len(value)), np.zeros(len(value))
    for at in along.ways(listed):
        x = 2 * along.load[at] - 1
        places = len(np.unique(np.round(x / along.policy.gauge)))
        degree = min(places // along.policy.few, along.policy.smooth)
        powers = chebyshev.chebvander(x, degree)
        weights, *_ = np.linalg.lstsq(base[at, None] * powers, value[at], rcond=1e-8)
        factor[at] = powers @ weights
        by_x = chebyshev.chebder(weights)
        turned[at] = 2 * chebyshev.chebval(x, by_x)
    return factor, turned


def without_memory(measurement: Measurement, errors: Errors) -> np.ndarray:
    """Columns of all that has the shape of memory along one loading or in a loop, (n, k).

    That is any smooth elastic curve, and friction in the rig.

    Args:
        measurement: the readings.
        errors: of them.
    """
    rubs = [play.nuisance for play in plays(measurement, errors.along, errors.steep)]
    friction = [play.unknown.prior.wide * play.change for play in rubs]
    return np.column_stack([smooth_curves(errors.along), *friction])
