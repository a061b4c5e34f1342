"""Differences of readings beside causes: noise, rig, specimens, artefacts, a discrepancy.

The discrepancy is a process for what no effect of the catalogue is: an always-possible discrepancy.

    K = S² {½ [k_SE(x, x′)]₀ + ¼ [k_M(s, s′)]₀ + ⅛ [k_E(x, x′)]₀ + ⅛ [k_E(s, s′)]₀}
    [k(a, b)]₀ = k(a, b) − k(a, 0) k(0, b)

x is the load by the largest, s the path Σ|Δx| of the load plus the logarithm of waits, S the root
mean square of a channel (Kennedy & O'Hagan, J. R. Stat. Soc. B 63, 2001). k_SE is a squared
exponential, k_M a Matérn kernel of order 3/2, k_E an exponential one. So the process is 0 at rest,
is smooth along the load, may differ between branches, cycles and waits, and may jump and waver:
without the last two a slip or a crosshead's uneven screw is taken for whichever effect follows a
little of it. Readings of another channel or another protocol have their own.

An artefact of an instrument is a jump that stays, as where a clamp slips: from some row of a test
on, a column or the control is off by one number. Or it is a wave, as of an uneven screw: the
control is off by a sine or a cosine of itself. Neither is like any effect of the catalogue, which
are smooth along a branch. Those that the evidence asks for are numbers of the rig. Without this a
cause that acts beside a slip is not found.

The noise of the instruments is as told, else estimated from their readings.

    σ² = Σ (Δᵈy)² / (n C(2d, d)),   d = 3,

over the third differences Δ³y of the readings of one branch, in the order of the control. If rows
are dense the curve itself has no such differences, and independent noise σ gives them a variance of
C(6, 3) σ² = 20 σ² (von Neumann, Ann. Math. Stat. 12, 1941, with first differences). A branch of at
least ``DATA.dense`` rows is dense. Cycles from the second on repeat one another: if branches are
not dense, half the variance of their differences is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from math import comb
from typing import Final

import numpy as np
import pandas as pd
import scipy.linalg
from scipy.special import logsumexp

from dolfingrip.channels import CHANNELS, TRANSVERSE_STRAIN
from dolfingrip.diagnosis.core.unknown import Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.policy import ADDITIONS, ARTEFACTS, DATA, POLICY
from dolfingrip.diagnosis.simulation.simulated import Simulator


@dataclass(frozen=True, slots=True)
class InstrumentNoise:
    """Noise of every reading, aligned with ``Measurement.listed``.

    Attributes:
        independent: (n,) standard deviation of the part that differs from reading to reading, in
            the column's unit.
        correlated: (n,) standard deviation of the part that drifts along a run; 0 if none is told.
        correlation_time_s: (n,) correlation time of that part; infinite: as long as the run.
        control: (n,) standard deviation of the reading of the control (kPa or mm).
        sentences: sources of the numbers that the laboratory does not tell.
    """

    independent: np.ndarray
    correlated: np.ndarray
    correlation_time_s: np.ndarray
    control: np.ndarray
    sentences: tuple[str, ...]


def instrument_noise(measurement: Measurement) -> InstrumentNoise:
    """The noise of each reading of ``measurement``."""
    listed = measurement.listed
    independent, correlated, control = np.zeros((3, len(listed)))
    correlation_time_s = np.full(len(listed), np.inf)
    sentences: list[str] = []
    for (number, column), part in listed.groupby(["test", "column"], sort=False):
        test = measurement.tests[int(number)]
        at = part.index.to_numpy()
        std = test.setup.noise.get(str(column))
        if std is None:
            std, how = _estimated(measurement, test, str(column))
            sentences.append(f"noise of {column} in {test}: {std:.3g}, {how}")
        independent[at] = std
        correlated[at] = test.setup.correlated_noise.get(str(column), 0.0)
        if test.setup.correlation_time_s is not None:
            correlation_time_s[at] = test.setup.correlation_time_s
        control[at] = test.sigma
    return InstrumentNoise(
        independent, correlated, correlation_time_s, control, tuple(dict.fromkeys(sentences))
    )


def _estimated(measurement: Measurement, test: SpecimenTest, column: str) -> tuple[float, str]:
    """A standard deviation, and a sentence about its source."""
    rows = measurement.rows(test.number)
    for parts, how in (
        (_differences(rows, test.control, column), "estimated from its scatter along a branch"),
        (_repeats(rows, test.control, column), "estimated from repeated cycles"),
    ):
        found = np.concatenate([np.empty(0), *parts])
        # rounded readings may not differ at all
        if len(found) >= DATA.fewest_differences and found.any():
            return float(np.sqrt(np.mean(found**2))), how
    usual = CHANNELS[column].noise
    return usual, "an engineering guess, as the readings are too few to estimate it"


def _differences(rows: pd.DataFrame, control: str, column: str) -> Iterator[np.ndarray]:
    """Third differences of dense ramps, divided by those of noise of 1."""
    for (branch, _), part in rows.groupby(["branch", "leg"], sort=False):
        in_order = part if branch == "hold" else part.sort_values(control)
        value, order = in_order[column].dropna().to_numpy(), DATA.differences
        if len(value) >= DATA.dense:
            yield np.diff(value, order) / np.sqrt(comb(2 * order, order))


def _repeats(rows: pd.DataFrame, control: str, column: str) -> Iterator[np.ndarray]:
    """Differences between successive cycles from the second on, divided by √2."""
    for _, branch in rows[rows["cycle"] > 1].groupby("branch", sort=False):
        cycles = [part for _, part in branch.groupby("cycle", sort=True)]
        for before, after in pairwise(cycles):
            if len(before) != len(after):
                continue
            away = after[control].to_numpy() - before[control].to_numpy()
            if np.abs(away).max() > DATA.same_place * max(float(np.ptp(before[control])), 1e-9):
                continue
            change = after[column].to_numpy() - before[column].to_numpy()
            yield change[~np.isnan(change)] / np.sqrt(2)


@dataclass(frozen=True, eq=False)
class Scatter:
    """How far the specimens differ from one another.

    Attributes:
        scale: relative standard deviation of their stiffness.
        prior_scale: as the laboratory told, or usual.
        shape: individual deviation, by the root mean square of a channel.
        estimated: whether the readings of several specimens tell these.
    """

    scale: float
    prior_scale: float
    shape: float
    estimated: bool


def between(
    measurement: Measurement, covariance: np.ndarray, along: Along, signal: np.ndarray
) -> tuple[Scatter, np.ndarray]:
    """Estimate how specimens differ: in stiffness, and by smooth deviations of their own.

    Of several specimens their differences tell both: a curve that all have in common is taken out
    first (restricted likelihood; Patterson & Thompson, Biometrika 58, 1971), so that no hypothesis
    about it matters. The stiffness' size is the most probable. The shape's variance is the expected
    one: of few specimens the most probable is often 0, and what two have in common by chance would
    be taken for a cause. Beside fingers, and of one specimen, the shape of coupons is assumed: no
    simple law follows them exactly.
    """
    own = Individual(measurement, covariance, along, signal)
    told = own.told
    one_curve = len({test.experiment for test in measurement.tests}) == 1
    if len(set(own.specimen)) == 1 or not one_curve:
        coupon = (measurement.listed["experiment"] == "coupon").to_numpy()
        shape = kernel(along) * np.outer(coupon, coupon)
        level = POLICY.single_shape if coupon.all() else 0.0
        return Scatter(0.0, told, level, estimated=False), POLICY.single_shape**2 * shape
    likelihood = own.likelihood()
    best = 0
    for number, of in enumerate(likelihood.max(axis=1)):
        if of > likelihood[best].max() + 0.5:
            best = number
    scale = POLICY.specimen_scales[best] * told
    weights = np.exp(likelihood[best] - likelihood[best].max())
    levels = np.array(POLICY.specimen_shapes)
    level = float(np.sqrt(weights @ levels**2 / weights.sum()))
    return Scatter(scale, told, level, estimated=True), own.apart(scale, level)


@dataclass(eq=False)
class Individual:
    """Readings of specimens that share a curve, each with a stiffness and a shape of its own.

    Attributes:
        measurement: the readings.
        covariance: of everything else, shape (n, n).
        along: where they lie.
        signal: a smooth curve through them, shape (n,).
        some: which of the readings; all where None.
    """

    measurement: Measurement
    covariance: np.ndarray
    along: Along
    signal: np.ndarray
    some: np.ndarray | None = None

    def __post_init__(self) -> None:
        listed = self.measurement.listed
        at = np.arange(len(listed)) if self.some is None else self.some
        self._listed = listed.iloc[at].reset_index(drop=True)
        self.covariance = self.covariance[np.ix_(at, at)]
        self.along = self.along.at(at)
        self.specimen = self._listed["specimen"].to_numpy()
        scaled = (self._listed["column"] != TRANSVERSE_STRAIN.name).to_numpy() * self.signal[at]
        self._stiff, self._shape = np.outer(scaled, scaled), kernel(self.along)
        self._same = self.specimen[:, None] == self.specimen

    @classmethod
    def of(cls, measurement: Measurement, errors: Errors, some: np.ndarray) -> Individual:
        """Some readings of a measurement by its errors, without the scatter in them."""
        every = cls(measurement, errors.covariance, errors.along, errors.signal)
        scatter = every.apart(errors.scatter.scale, errors.scatter.shape)
        return cls(measurement, errors.covariance - scatter, errors.along, errors.signal, some)

    @property
    def told(self) -> float:
        """Relative scatter of the stiffness as the laboratory told it."""
        tests = self.measurement.tests
        return float(np.max([test.setup.nuisances["specimen_scale"] for test in tests]))

    def apart(self, scale: float, shape: float) -> np.ndarray:
        """(n, n) covariance by the specimens' own stiffness and shape, relative."""
        return (scale**2 * self._stiff + shape**2 * self._shape) * self._same

    def likelihood(self, outside: Sequence[str] = ()) -> np.ndarray:
        """ln of the restricted likelihood of each scatter of stiffness (rows) and shape.

        Args:
            outside: specimens that stand apart from the others.
        """
        common, value = _common(self._listed, self.along), self._listed["value"].to_numpy()
        far = np.isin(self.specimen, outside)
        wide = POLICY.far**2 * (self._stiff + self._shape) * self._same * np.outer(far, far)
        return np.array([
            [
                _restricted(
                    self.covariance + wide + self.apart(factor * self.told, level), common, value
                )
                for level in POLICY.specimen_shapes
            ]
            for factor in POLICY.specimen_scales
        ])  # fmt: skip

    def evidence(self, outside: Sequence[str]) -> float:
        """ln p of the readings where some specimens stand apart, the scatter integrated out."""
        found = self.likelihood(outside)
        return float(np.logaddexp.reduce(found, axis=None) - np.log(found.size))


def _common(listed: pd.DataFrame, along: Along) -> np.ndarray:
    """Columns of any curve that all specimens share, (n, k).

    It has as many numbers as one specimen has readings: what it cannot follow would be taken for
    scatter, and hide what the model misses of all specimens alike.
    """
    columns: list[np.ndarray] = []
    for at in along.ways(listed):
        x = along.load[at]
        each = int(listed.iloc[at].groupby("test").size().median())
        degree = min(len(np.unique(np.round(x, 3))), each, POLICY.common) - 1
        own = np.zeros((len(along.load), degree + 1))
        span = max(float(np.ptp(x)), 1e-9)
        own[at] = np.polynomial.chebyshev.chebvander(2 * (x - x.min()) / span - 1, degree)
        columns.append(own)
    return np.hstack(columns)


def _restricted(covariance: np.ndarray, common: np.ndarray, value: np.ndarray) -> float:
    lower = scipy.linalg.cholesky(covariance, lower=True)
    white = scipy.linalg.solve_triangular(lower, np.column_stack([value, common]), lower=True)
    q, r = np.linalg.qr(white[:, 1:])
    rest = white[:, 0] - q @ (q.T @ white[:, 0])
    determinant = np.log(np.diag(lower)).sum() + np.log(np.abs(np.diag(r)) + 1e-300).sum()
    return float(-0.5 * rest @ rest - determinant)


@dataclass(frozen=True, eq=False)
class Along:
    """Where readings lie.

    Attributes:
        load: x, shape (n,).
        path: s, shape (n,).
        block: number of the channel and protocol of each, shape (n,).
        size: S of its channel, shape (n,).
    """

    load: np.ndarray
    path: np.ndarray
    block: np.ndarray
    size: np.ndarray

    def at(self, some: np.ndarray) -> Along:
        """Where some of the readings lie."""
        return Along(self.load[some], self.path[some], self.block[some], self.size[some])

    def ways(self, listed: pd.DataFrame) -> list[np.ndarray]:
        """Places of the readings of each branch of each cycle, by channel and protocol."""
        keys = [self.block, listed["cycle"].to_numpy(), listed["branch"].to_numpy()]
        return [*listed.reset_index(drop=True).groupby(keys, sort=False).indices.values()]


def kernel(along: Along) -> np.ndarray:
    """K for a level of 1, shape (n, n)."""
    x, s = along.load / POLICY.load_length, along.path / POLICY.path_length
    parts = (
        0.5 * _at_rest_zero(lambda t: np.exp(-0.5 * t**2), x)
        + 0.25 * _at_rest_zero(lambda t: (1 + np.sqrt(3) * t) * np.exp(-np.sqrt(3) * t), s)
        + 0.125 * _at_rest_zero(lambda t: np.exp(-t), along.load / POLICY.rough_length)
        + 0.125 * _at_rest_zero(lambda t: np.exp(-t), along.path / POLICY.rough_length)
    )
    same = along.block[:, None] == along.block
    return np.asarray(np.outer(along.size, along.size) * np.where(same, parts, 0.0))


def _at_rest_zero(k: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """[k]₀ of a kernel by the distance."""
    rest = k(np.abs(at))
    return k(np.abs(at[:, None] - at)) - np.outer(rest, rest)


def smooth_curves(along: Along) -> np.ndarray:
    """Columns of any smooth curve of the load in each channel, as free as its size, (n, k)."""
    columns = []
    for block in np.unique(along.block):
        own = along.block == block
        shapes = np.polynomial.chebyshev.chebvander(2 * along.load - 1, POLICY.smooth - 1)
        columns.append((own * along.load * along.size)[:, None] * shapes)
    return np.hstack(columns)


def without_memory(measurement: Measurement, errors: Errors) -> np.ndarray:
    """Columns of all that has the shape of memory along one loading or in a loop, (n, k).

    That is any smooth elastic curve, and friction in the rig.

    Args:
        measurement: the readings.
        errors: of them.
    """
    rubs = _plays(measurement.listed, [*_shown(measurement, errors)])
    friction = [each.wide.nuisance.change for each in rubs]
    return np.column_stack([smooth_curves(errors.along), *friction])


def path_of(load: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """s of one run's rows in the order of time, shape (rows,)."""
    moved = np.abs(np.diff(load, prepend=0.0))
    waited = np.where(moved > 1e-3, 0.0, np.diff(time_s, prepend=time_s[0]))
    since = np.zeros(len(load))
    for i in range(1, len(load)):
        since[i] = since[i - 1] + waited[i] if waited[i] > 0 else 0.0
    slow = POLICY.wait_weight * np.log1p(since / POLICY.wait_s)
    rise = np.maximum(np.diff(slow, prepend=0.0), 0.0)
    return np.asarray(np.cumsum(moved + rise))


SLACK: Final = "coupon_slack_mm"


@dataclass(frozen=True, eq=False)
class Errors:
    """Everything but causes that readings differ by.

    Attributes:
        covariance: shape (n, n).
        noise: of instruments and gauge, standard deviations, shape (n,).
        steep: derivatives of a smooth curve through the readings by the control, shape (n,).
        along: where the readings lie, for a discrepancy that all specimens share.
        signal: a smooth curve through the readings, shape (n,).
        shared: numbers of the rig.
        fitted: covariance of what a fit gives the rig and each specimen, shape (n, n).
        scatter: of the specimens.
        sentences: where the noise comes from.
        artefacts: of instruments, whose sizes are among the shared numbers.
    """

    covariance: np.ndarray
    noise: np.ndarray
    steep: np.ndarray
    along: Along
    signal: np.ndarray
    shared: tuple[Nuisance, ...]
    fitted: np.ndarray
    scatter: Scatter
    sentences: tuple[str, ...]
    artefacts: tuple[Artefact, ...] = ()

    def beside(self, found: Sequence[Artefact]) -> Errors:
        """Return them with artefacts of instruments, whose sizes are numbers of the rig.

        Args:
            found: which readings have.
        """
        changes = np.column_stack([each.nuisance.change for each in found])
        own = changes @ changes.T
        return replace(
            self, covariance=self.covariance + own, fitted=self.fitted + own,
            shared=(*self.shared, *(each.nuisance for each in found)),
            artefacts=(*self.artefacts, *found),
        )  # fmt: skip


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
    shared = [replace(each, change=each.change * by) for each in rig]
    off = of_mesh(simulation.mesh, listed["experiment"], along.load)
    fitted = off @ off.T
    slack_mm = np.array([
        test.setup.nuisances[SLACK] if test.experiment == "coupon" else 0.0
        for test in measurement.tests
    ])  # fmt: skip
    if slack_mm.any():
        late = slack_mm[test] * steep
        fitted += POLICY.own_slack * np.outer(late, late) * (test[:, None] == test)
        share = float(np.sqrt(1 - POLICY.own_slack))
        slack = Unknown.marginal(SLACK, share * float(slack_mm.max()), "mm")
        shared.insert(0, Nuisance(slack, share * late))
    instrument = instrument_noise(measurement)
    covariance = np.diag(np.maximum(instrument.independent, 1e-9) ** 2) + drifting(
        listed, instrument
    )
    # one reading of the control stands behind all readings of its row
    gauge = steep * instrument.control / np.sqrt(_in_a_mean(measurement))[row]
    covariance += np.outer(gauge, gauge) * (row[:, None] == row)
    noise = np.sqrt(np.diag(covariance))
    fitted = fitted + sum(np.outer(each.change, each.change) for each in shared)
    covariance += fitted
    scatter, apart = between(measurement, covariance, along, signal)
    specimen = listed["specimen"].to_numpy()
    stiff = scatter.scale * signal
    fitted = fitted + np.outer(stiff, stiff) * (specimen[:, None] == specimen)
    return Errors(
        covariance + apart, noise, steep, along, signal, tuple(shared), fitted, scatter,
        instrument.sentences,
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
    own = error[:, None] * pd.get_dummies(experiment).to_numpy(float)
    part = np.abs(load)[:, None]
    return np.hstack([own * (1 - part), own * part])


def _in_a_mean(measurement: Measurement) -> np.ndarray:
    """Number of rows whose mean each row's pressure or travel is: in a wait all of them."""
    rows = measurement.readings
    waits = (rows["branch"] == "hold").to_numpy()
    counts = rows.groupby(["test", "leg"])["leg"].transform("size").to_numpy()
    return np.where(waits, counts, 1)


def followed(listed: pd.DataFrame, along: Along, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit the factor that makes the model's readings a smooth curve through those measured.

    A polynomial of the load for each channel, protocol and branch.

    Returns:
        The factor, shape (n,), and its derivative by the load, shape (n,).
    """
    value = listed["value"].to_numpy()
    found, turned = np.zeros(len(value)), np.zeros(len(value))
    for at in along.ways(listed):
        x = 2 * along.load[at] - 1
        degree = int(np.clip(len(np.unique(np.round(x / 2, 4))) // 4, 0, POLICY.smooth))
        powers = np.polynomial.chebyshev.chebvander(x, degree)
        weights, *_ = np.linalg.lstsq(base[at, None] * powers, value[at], rcond=1e-8)
        found[at] = powers @ weights
        by_x = np.polynomial.chebyshev.chebder(weights)
        turned[at] = 2 * np.polynomial.chebyshev.chebval(x, by_x)
    return found, turned


def lying(simulation: Simulator) -> Along:
    """Where a measurement's readings lie: loads by the largest of their experiment.

    The load of a coupon is its strain. Channels of tests that are simulated together share a
    discrepancy.
    """
    measurement = simulation.measurement
    listed, rows = measurement.listed, measurement.readings.reset_index(drop=True)
    load, path = np.zeros((2, len(rows)))
    of = rows.groupby("test").indices
    for test in measurement.tests:
        coupon = test.applied(simulation.config).coupon
        by = coupon.gauge_length_mm if test.experiment == "coupon" else 1.0
        load[of[test.number]] = rows[test.control].to_numpy()[of[test.number]] / by
    largest = pd.Series(np.abs(load)).groupby(rows["experiment"]).transform("max")
    load /= largest.replace(0.0, 1.0).to_numpy()
    for mine in of.values():
        path[mine] = path_of(load[mine], rows["time_s"].to_numpy()[mine])
    group = {test: place for place, each in enumerate(simulation.groups) for test in each.tests}
    block = listed.groupby([listed["test"].map(group), "column"]).ngroup()
    size = np.sqrt((listed["value"] ** 2).groupby(block).transform("mean"))
    row = listed["row"].to_numpy()
    return Along(load[row], path[row], block.to_numpy(), size.to_numpy())


def drifting(listed: pd.DataFrame, noise: InstrumentNoise) -> np.ndarray:
    """Noise that drifts along a run, told by the laboratory."""
    if not noise.correlated.any():
        return np.zeros((len(listed), len(listed)))
    time_s = listed["time_s"].to_numpy()
    run = (listed["test"].astype(str) + listed["column"].astype(str)).to_numpy()
    lasting = np.where(np.isfinite(noise.correlation_time_s), noise.correlation_time_s, 1e6)
    same = run[:, None] == run
    fading = np.exp(-np.abs(time_s[:, None] - time_s) / lasting[:, None])
    return np.outer(noise.correlated, noise.correlated) * np.where(same, fading, 0.0)


@dataclass(frozen=True, eq=False)
class Artefact:
    """An artefact of an instrument: a jump, a play or a wave of what it shows.

    Attributes:
        nuisance: its size, and what the readings change by it.
        told: a sentence with a place for its size.
        kind: of which at most one acts: a jump at a place, a play, a screw's sine or cosine.
        log_prior: ln of the odds that it is there, and that its size is of this part of its prior.
    """

    nuisance: Nuisance
    told: str
    kind: str
    log_prior: float = 0.0

    def sentence(self, sigmas: float) -> str:
        """Tell it with its size.

        Args:
            sigmas: its size by its standard deviation.
        """
        size = sigmas * self.nuisance.std
        return self.told.format(f"{size:+.2g} {self.nuisance.unknown.unit}")

    @property
    def wide(self) -> Artefact:
        """Artefact whose size has the wide part of its prior."""
        own, by = self.nuisance, POLICY.implausible_width
        prior = replace(own.unknown.prior, spread=by * own.std)
        return replace(self, nuisance=Nuisance(replace(own.unknown, prior=prior), by * own.change))


def artefacts(measurement: Measurement, errors: Errors) -> list[Artefact]:
    """List what may be wrong with the instruments, with both parts of each one's prior.

    Args:
        measurement: the readings.
        errors: of them; artefacts that these have already are left out, and waves beside a wave.
    """
    have, listed = {each.kind for each in errors.artefacts}, measurement.listed
    shown = [*_shown(measurement, errors)]
    every = [
        *_jumps(listed, errors.along.path, shown), *_waves(listed, shown),
        *filter(_either_way, _plays(listed, shown)),
    ]  # fmt: skip
    new = [each for each in every if each.kind not in have]
    # as all priors are, these are a mixture: nine parts are ordinary, one is four times as wide
    usual, rare = (
        float(np.log(POLICY.implausible_odds * part / max(len(new), 1)))
        for part in (1 - POLICY.rare, POLICY.rare)
    )
    return [
        *(replace(each, log_prior=usual) for each in new),
        *(replace(each.wide, log_prior=rare) for each in new),
    ]  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class _Shown:
    """A column or the control of some tests, as an instrument shows it.

    Attributes:
        name: of it and of the tests.
        unit: of it.
        control_unit: of the control.
        tests: these.
        at: (n,) which readings are off where it is off.
        by: (n,) how much by each unit.
        size: its ordinary size.
        controls: whether it is the control.
    """

    name: str
    unit: str
    control_unit: str
    tests: Sequence[SpecimenTest]
    at: np.ndarray
    by: np.ndarray
    size: float
    controls: bool


def _shown(measurement: Measurement, errors: Errors) -> Iterator[_Shown]:
    """All columns and controls, of each test and of all of an experiment."""
    listed = measurement.listed
    column, number = listed["column"].to_numpy(), listed["test"].to_numpy()
    for who, tests in _together(measurement.tests):
        first, mine = tests[0], np.isin(number, [test.number for test in tests])
        unit = CHANNELS[CONTROL[first.experiment]].unit
        size, by = float(np.abs(listed["control"][mine]).max()), errors.steep
        yield _Shown(f"{first.control} of {who}", unit, unit, tests, mine, by, size, True)
        for name in dict.fromkeys(map(str, column[mine])):
            at, own_unit = mine & (column == name), CHANNELS[name].unit
            size, by = float(errors.along.size[at].max()), np.ones(len(listed))
            yield _Shown(f"{name} of {who}", own_unit, unit, tests, at, by, size, False)


def _together(tests: Sequence[SpecimenTest]) -> Iterator[tuple[str, Sequence[SpecimenTest]]]:
    """Each test alone, and all of an experiment, and what they are called."""
    for test in tests:
        yield str(test), [test]
    for experiment in dict.fromkeys(test.experiment for test in tests):
        own = [test for test in tests if test.experiment == experiment]
        if len(own) > 1:
            yield f"all specimens ({experiment})", own


def _jumps(listed: pd.DataFrame, path: np.ndarray, every: Sequence[_Shown]) -> Iterator[Artefact]:
    """Jumps with two readings at least on either side.

    Those of all tests of an experiment are at the same place of the path.
    """
    row, number = listed["row"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        order = np.flatnonzero(shown.at & (number == shown.tests[0].number))
        order = order[np.unique(row[order], return_index=True)[1]]
        for before, after in pairwise(order[1:-1]):
            start, end = (listed.iloc[place] for place in (before, after))
            if start["leg"] != end["leg"]:
                continue  # where the way turns a reading may lag or rub
            where = (
                f"between {start['control']:.4g} and {end['control']:.4g} {shown.control_unit} "
                f"in the {end['branch']} of cycle {end['cycle']}"
            )
            yield _artefact(
                f"jump of {shown.name} {where}", ARTEFACTS.jump * shown.size, shown.unit,
                shown.by * shown.at * (path > 0.5 * (path[before] + path[after])),
                f"{shown.name} jumps by {{}} {where} and stays so, as where something slips",
            )  # fmt: skip


def _plays(listed: pd.DataFrame, every: Sequence[_Shown]) -> Iterator[Artefact]:
    """Lags behind either way by as much, as of a gauge with a play.

    What rubs turns within a part of the range (Dahl, AIAA Journal 14, 1976).
    """
    row, number = listed["row"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        for length in ARTEFACTS.turns:
            behind = np.zeros(len(listed))
            for test in shown.tests:
                mine = number == test.number
                _, first, back = np.unique(row[mine], return_index=True, return_inverse=True)
                control = listed["control"].to_numpy()[mine][first]
                steps = np.diff(control, prepend=0.0) / max(np.ptp(control), 1e-9)
                behind[mine] = np.fromiter(_behind(steps, length), float)[back]
            if behind.any():
                yield _artefact(
                    f"play of {shown.name}, within {length:g} of the range",
                    ARTEFACTS.play * shown.size, shown.unit, shown.by * shown.at * behind,
                    f"{shown.name} is off by {{}} on the way up and by as much to the other side "
                    "on the way down, as of friction or a play",
                    f"play of {shown.name}",
                )  # fmt: skip


def _either_way(play: Artefact) -> bool:
    """Tell if readings are off to either side; else much has the shape of a play."""
    change = play.nuisance.change
    return bool(change.min() < 0 < change.max())


def _behind(steps: np.ndarray, length: float) -> Iterator[float]:
    """How far what rubs is behind after each step, from −1 on the way down to 1."""
    at = 0.0
    for step in steps:
        at = float(np.sign(step) + (at - np.sign(step)) * np.exp(-abs(step) / length))
        yield at


def _waves(listed: pd.DataFrame, every: Sequence[_Shown]) -> Iterator[Artefact]:
    """Sines and cosines of controls, of which enough periods are read often enough."""
    control, number = listed["control"].to_numpy(), listed["test"].to_numpy()
    for shown in every:
        if not shown.controls:
            continue
        own = control[number == shown.tests[0].number]
        span = float(np.ptp(own))
        read = len(np.unique(np.round(own / max(span, 1e-9), 2)))
        most = min(read / ARTEFACTS.a_period, ARTEFACTS.periods)
        for count in np.arange(ARTEFACTS.fewest_periods, most, ARTEFACTS.period_step):
            phase = 2 * np.pi * count * control / span
            wave = f"of period {span / count:.3g} {shown.unit}"
            for shape, change in (("sine", np.sin(phase)), ("cosine", np.cos(phase) - 1)):
                yield _artefact(
                    f"{shape} {wave} of {shown.name}", ARTEFACTS.wave * span, shown.unit,
                    shown.by * shown.at * change,
                    f"{shown.name} is off by {{}} times a {shape} {wave}, as of an uneven screw",
                    shape,
                )  # fmt: skip


def _artefact(
    key: str, std: float, unit: str, change: np.ndarray, told: str, kind: str = ""
) -> Artefact:
    """One of a standard deviation in a unit, which changes the readings by ``change`` for each.

    Its kind is its key where no other is told.
    """
    own = Nuisance(Unknown.marginal(key, std, unit), std * change)
    return Artefact(own, told, kind or key)


@dataclass(frozen=True, slots=True)
class Apart:
    """Specimens that stand apart.

    Attributes:
        names: of them.
        log_odds: ln of the odds that they do, and no others.
    """

    names: tuple[str, ...]
    log_odds: float

    @property
    def sentence(self) -> str:
        """Statement that they do, with the odds."""
        who = f"specimen {self.names[0]} stands" if len(self.names) == 1 else (
            f"specimens {' and '.join(self.names)} stand"
        )  # fmt: skip
        odds = np.exp(min(self.log_odds, 99.0))
        return f"{who} apart from the others (odds {odds:.2g} to 1)"


def apart(measurement: Measurement, errors: Errors) -> Apart | None:
    """Find the specimens whose readings are far likelier apart from those of the others.

    A specimen that stands apart has a curve of its own, up to a tenth of the signal away from the
    others'. The curve that the others share is taken out first, so that no hypothesis about it
    matters (restricted likelihood, as where their scatter is estimated).

    Args:
        measurement: of specimens, of which two may stand apart where there are four.
        errors: of its readings.

    Returns:
        None where none does, or where too few specimens could tell.
    """
    if not errors.scatter.estimated:
        return None
    some = np.arange(0, len(errors.signal), -(-len(errors.signal) // POLICY.some))
    own = Individual.of(measurement, errors, some)
    names = sorted(set(own.specimen))
    # two at least share a curve; which two, four specimens tell where the others differ
    log = {
        each: own.evidence(each) + len(each) * float(np.log(POLICY.implausible_odds))
        for count in range(min(POLICY.apart, len(names) - 2) + 1)
        for each in combinations(names, count)
    }
    best = max(log, key=log.__getitem__)
    rest = [value for each, value in log.items() if each != best]
    found = Apart(best, log[best] - float(logsumexp(rest)) if rest else 0.0)
    return found if best and found.log_odds > ADDITIONS.tied else None
