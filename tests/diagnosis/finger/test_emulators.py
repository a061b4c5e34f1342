"""Emulators of fingers: from few values and slopes; no simulation."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.reference_measurement import reference_measurement
from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.emulator import (
    Coordinate,
    Pieces,
    PolynomialEmulator,
    SimulatedChanges,
    trained_on,
    turning,
)
from dolfingrip.diagnosis.core.evidence import InferenceProblem
from dolfingrip.diagnosis.core.search import search
from dolfingrip.diagnosis.core.unknown import Cause, causes, factor_of_moduli
from dolfingrip.diagnosis.finger import training
from dolfingrip.diagnosis.finger.training import CauseTraining, box_of, coordinates_of, wider
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.unknowns import IMPLAUSIBLE, unknowns
from dolfingrip.extensions.index import NAMES, effect

SEED = 11
X = np.linspace(0.1, 1.0, 15)
SCALE = np.full(len(X), 0.02)
STD = 0.2
"""Of the moduli."""


def factor(zeta: np.ndarray) -> np.ndarray:
    return np.exp(STD * np.asarray(zeta))


def bend(c: float) -> np.ndarray:
    """Invented: what a load turns a finger by, a curve of load by modulus."""
    return 10 * (X / c) ** 1.3


def changed(zeta: float, c: float) -> np.ndarray:
    """Invented: a softening of log-normal size, read at the load by the modulus."""
    return np.asarray(2 * np.exp(0.4 * zeta) * (X / c) ** 2 / (1 + 0.3 * np.exp(0.4 * zeta)))


def slope(zeta: float, c: float) -> np.ndarray:
    return (changed(zeta + 1e-5, c) - changed(zeta - 1e-5, c)) / 2e-5


AMPLITUDE = Coordinate(lambda zeta: np.exp(0.4 * zeta), amplitude=True, signed=False)


def softening() -> PolynomialEmulator:
    places, nodes = np.array([-2.0, 0.3, 2.3]), np.linspace(-2.5, 2.5, 33)
    values = np.array([[changed(z, factor(m)) for z in places] for m in nodes])
    slopes = np.array([[[slope(z, factor(m))] for z in places] for m in nodes])
    told = SimulatedChanges(places[:, None], values, slopes, nodes)
    return trained_on(told, [AMPLITUDE], SCALE)


def test_three_places_with_slopes_serve_a_whole_prior() -> None:
    found = softening()
    print("left out", found.left)
    rng = np.random.default_rng(SEED)
    zeta = rng.standard_normal((50, 2)).clip(-2.3, 2.3)
    off = [found.columns @ found.at(z[None])[0] - changed(z[1], factor(z[0])) for z in zeta]
    assert np.abs(np.array(off) / SCALE).max() < 1.0
    (value,), (slopes,) = found.with_slopes(zeta[:1])
    step = 1e-5 * np.eye(2)
    by_difference = (found.at(zeta[0] + step) - found.at(zeta[0] - step)).T / 2e-5
    np.testing.assert_allclose(value, found.at(zeta[:1])[0])
    np.testing.assert_allclose(slopes, by_difference, rtol=1e-4, atol=1e-6)


def stiffened(zeta: np.ndarray, c: float) -> np.ndarray:
    """Invented: two coefficients of either sign, in which the modulus is linear."""
    return bend(c * (1 + 0.3 * zeta[0] + 0.2 * zeta[1])) - bend(c)


def stiffness_in(zeta: np.ndarray) -> SimulatedChanges:
    """Changes and slopes at places, (places, 2), at one modulus."""
    steps = 1e-5 * np.eye(2)
    slopes = [[(stiffened(z + h, 1.0) - stiffened(z - h, 1.0)) / 2e-5 for h in steps] for z in zeta]
    values = np.array([[stiffened(z, 1.0) for z in zeta]])
    return SimulatedChanges(zeta, values, np.array([slopes]), None)


def test_coefficients_of_either_sign_that_soften_far_are_followed() -> None:
    """Changes of up to 580 standard deviations of the noise, from five places with slopes."""
    print("seed", SEED)
    told = stiffness_in(np.array([[-1.0, -0.5], [1.2, -0.8], [-0.6, 1.1], [0.2, 0.3], [1.0, 1.2]]))
    own = [Coordinate(lambda zeta: zeta, amplitude=True, of=i) for i in range(2)]
    found = trained_on(told, own, SCALE)
    zeta = np.random.default_rng(SEED).uniform(-1.0, 1.2, (50, 2))
    off = found.at(zeta) @ found.columns.T - [stiffened(z, 1.0) for z in zeta]
    rms = float(np.sqrt(np.square(off / SCALE).mean()))
    print("left out", found.left, "error", rms)
    assert found.left < 1.5
    assert rms < 0.5
    (value,), (slopes,) = found.with_slopes(zeta[:1])
    by_difference = [
        found.at(zeta[:1] + h)[0] - found.at(zeta[:1] - h)[0] for h in 1e-5 * np.eye(2)
    ]
    np.testing.assert_allclose(value, found.at(zeta[:1])[0])
    np.testing.assert_allclose(slopes, np.array(by_difference).T / 2e-5, rtol=1e-4, atol=1e-6)


def turned(zeta: np.ndarray) -> np.ndarray:
    """Invented: a contact that one side of an amplitude moves, at each load at another place."""
    moved = np.clip(-np.asarray(zeta)[:, None] - 0.3 - X, 0.0, None)
    return np.asarray(0.02 * np.asarray(zeta)[:, None] * X + 2.0 * moved)


def turned_in(zeta: np.ndarray) -> SimulatedChanges:
    """Changes and slopes at places, shape (places,)."""
    slopes = (turned(zeta + 1e-6) - turned(zeta - 1e-6)) / 2e-6
    return SimulatedChanges(zeta[:, None], turned(zeta)[None], slopes[None, :, None], None)


SIDES = [
    Coordinate(lambda zeta: np.maximum(zeta, 0.0), amplitude=True),
    Coordinate(lambda zeta: np.minimum(zeta, 0.0), amplitude=True),
]


def test_a_change_that_turns_at_once_is_followed_by_pieces_between_more_places() -> None:
    """A change of 120 standard deviations that no polynomial of these places follows."""
    zeta = np.array([-2.1, -0.7, 0.7, 2.1])
    everywhere = np.linspace(-2.1, 2.1, 301)
    errors, told = [], []
    for _ in range(6):
        found = trained_on(turned_in(zeta), SIDES, SCALE)
        off = found.at(everywhere[:, None]) @ found.columns.T - turned(everywhere)
        errors.append(float(np.sqrt(np.square(off / SCALE).mean())))
        told.append(found.left)
        zeta = np.r_[zeta, turning(turned_in(zeta), 0.0, SCALE)[:, 0]]
    print("left out", told, "error", errors)
    assert isinstance(found.basis, Pieces)
    assert told[0] > 5.0
    assert errors[-1] < 0.6
    # no error is told that is much smaller than it is, where the prior has its weight
    assert all(error < 2 * left for error, left in zip(errors, told, strict=True))
    assert (zeta < 0).sum() > 3 * (zeta > 0).sum()


def test_pieces_tell_their_slopes_and_go_on_straight() -> None:
    zeta = np.array([-2.0, -1.1, -0.4, 0.9])
    told = turned_in(zeta)
    basis = Pieces.of(SIDES, told.zeta)
    value, slope = basis.with_slopes(told.zeta)
    np.testing.assert_allclose(value, np.eye(8)[:4], atol=1e-12)
    np.testing.assert_allclose(slope[..., 0], np.eye(8)[4:], atol=1e-9)
    np.testing.assert_allclose(basis(np.zeros((1, 1))), 0.0, atol=1e-12)
    beyond = basis(np.array([[-3.0], [1.9]]))
    np.testing.assert_allclose(beyond, np.eye(8)[[0, 3]] + [[-1.0], [1.0]] * np.eye(8)[[4, 7]])


def test_the_error_is_that_of_fits_without_each_place() -> None:
    """What a fit by least squares to the other places misses there, by the prior's weight."""
    print("seed", SEED)
    rng, zeta = np.random.default_rng(SEED), np.array([[-1.5], [-0.4], [0.6], [1.7]])
    values = np.sin(2 * zeta) * X + 0.1 * rng.standard_normal((len(zeta), len(X)))
    told = SimulatedChanges(zeta, values[None], np.full((1, 4, 1, len(X)), np.nan), None)
    found = trained_on(
        told, [Coordinate(lambda zeta: zeta, amplitude=False)], SCALE, degree=1, share=1.0
    )
    squares, every = [], np.hstack([np.ones((4, 1)), zeta])
    for out in range(4):
        kept = np.arange(4) != out
        line = np.linalg.lstsq(every[kept], values[kept], rcond=None)[0]
        squares.append(np.square((values[out] - every[out] @ line) / SCALE).mean())
    weight = np.exp(-0.25 * zeta[:, 0] ** 2)
    assert found.left == pytest.approx(float(np.sqrt(weight @ squares / weight.sum())), rel=1e-6)


def test_no_strength_changes_nothing() -> None:
    found = softening()
    assert np.abs(found.columns @ found.at(np.array([[0.3, -60.0]]))[0]).max() < 1e-6


def case_of(readings: np.ndarray) -> InferenceProblem:
    """The invented model at any modulus, with the softening as its only cause."""
    nodes = np.linspace(-2.5, 2.5, 33)
    values = np.array([[bend(factor(m)) - bend(1.0)] for m in nodes])
    told = SimulatedChanges(np.zeros((1, 0)), values, np.zeros((33, 1, 0, len(X))), nodes)
    return InferenceProblem(
        readings, bend(1.0), (factor_of_moduli(STD, -2.5, 2.5),),
        {"softening": softening()}, np.diag(SCALE**2),
        np.diag(SCALE**2) * 1e-6, {"softening": np.array([[-2.7, 2.7]])},
        trained_on(told, [], SCALE, share=1.0, left_out=()),
    )  # fmt: skip


def test_slopes_are_derivatives() -> None:
    case, subset, place = case_of(bend(1.0)), ("softening",), np.array([0.4, 1.2])
    by_difference = [
        (case.predicted(subset, place + step) - case.predicted(subset, place - step)) / 2e-6
        for step in 1e-6 * np.eye(2)
    ]
    told = np.column_stack(by_difference)
    np.testing.assert_allclose(case.slopes(subset, place), told, rtol=1e-4, atol=1e-5)


def test_exact_simulations_correct_values_and_slopes() -> None:
    """Exact at each of their places, also where fewer causes are corrected later; as before far
    from there."""
    print("seed", SEED)
    rng, before, subset = np.random.default_rng(SEED), case_of(bend(1.0)), ("softening",)

    def missed(case: InferenceProblem, subset: tuple[str, ...], zeta: np.ndarray) -> np.ndarray:
        told = np.column_stack([case.predicted(subset, zeta), case.slopes(subset, zeta)])
        return told + 0.3 * rng.standard_normal(told.shape)

    places = [np.array([0.4, 1.2]), np.array([1.1, 0.5])]
    exact = [missed(before, subset, place) for place in places]
    case = before
    for place, told in zip(places, exact, strict=True):
        case = case.corrected([(subset, place, told)])
    alone = np.array([0.2])
    model = missed(case, (), alone)
    case = case.corrected([((), alone, model)])
    np.testing.assert_allclose(case.predicted((), alone), model[:, 0], atol=1e-6)
    for place, told in zip(places, exact, strict=True):
        np.testing.assert_allclose(case.predicted(subset, place), told[:, 0], atol=1e-6)
        np.testing.assert_allclose(case.slopes(subset, place), told[:, 1:], atol=1e-6)
    far = places[0] + 9.0
    same = before.predicted(subset, far)
    np.testing.assert_allclose(case.predicted(subset, far), same, atol=1e-6)
    some = case.rows(np.arange(len(X)) < 5)
    np.testing.assert_allclose(some.predicted(subset, places[0]), exact[0][:5, 0], atol=1e-6)


def test_modulus_and_cause_are_found_together() -> None:
    """A model 25 % too soft, with a cause of 0.8 standard deviations above its median."""
    print("seed", SEED)
    noise = SCALE * np.random.default_rng(SEED).standard_normal(len(X))
    case = case_of(bend(1.25) + changed(0.8, 1.25) + noise)
    decision, _ = sensitivity(search(case, np.random.default_rng(SEED)))
    assert (decision.answer, decision.first) == ("cause", ("softening",))
    assert float(factor(decision.best.zeta[0])) == pytest.approx(1.25, rel=0.02)
    assert decision.best.zeta[1] == pytest.approx(0.8, abs=0.3)
    assert decision.unexplained < 0.01


def test_numbers_of_the_rig_are_causes_where_all_are_tried() -> None:
    """Four times as wide as told; a plate that touches already cannot be nearer."""
    measurement = reference_measurement(1)
    found = {each.name: each for each in unknowns(measurement, Config(), None)}
    assert set(IMPLAUSIBLE) <= set(found)
    gain = found["pressure_gain"].numbers[0]
    assert (gain.prior.mean, gain.prior.spread) == pytest.approx((1.0, 0.06))
    assert box_of(found["plate_gap"])[0, 0] == pytest.approx(-Config().plate.gap_mm / 1.2)
    assert not set(IMPLAUSIBLE) & {each.name for each in unknowns(measurement, Config(), ["gent"])}
    asked = unknowns(measurement, Config(), ["gent", "pressure_gain"])
    assert [each.name for each in asked] == ["gent", "pressure_gain"]
    tilt = coordinates_of(found["plate_tilt"], box_of(found["plate_tilt"]))
    assert len(tilt) == 2  # one for either side
    zeta = np.array([-1.0, 0.0, 2.0])
    np.testing.assert_allclose(tilt[0].value(zeta), [0.0, 0.0, 2.0])
    np.testing.assert_allclose(tilt[1].value(zeta), [-1.0, 0.0, 0.0])


def test_the_whole_catalogue_is_tried_but_the_mesh() -> None:
    """Each alone, where its numbers are at the middle of their priors."""
    found = {each.name: each for each in causes(Config())}
    assert set(found) == {
        n for n in NAMES if not effect(n).nuisance and effect(n).kind != "numerical"
    }
    assert "coarse_mesh" not in found
    for each in found.values():
        on = configuration.changed(
            Config(), each.overrides(np.zeros(len(each.numbers)))
        ).extensions.active()
        assert [other.name() for other in on] == [each.name]


def straight(cause: Cause, size: float) -> InferenceProblem:
    """Readings that a cause explains at a size, with an emulator that is straight in its number."""
    change = 0.2 * np.sin(5 * X)
    zeta, nodes = np.array([-2.0, 0.3, 2.0]), np.array([-2.0, 0.0, 2.0])
    told = SimulatedChanges(
        zeta[:, None], np.tile(np.outer(zeta, change), (3, 1, 1)), np.tile(change, (3, 3, 1, 1)),
        nodes,
    )  # fmt: skip
    emulator = trained_on(told, [Coordinate(lambda zeta: zeta, amplitude=True)], SCALE)
    baseline = SimulatedChanges(
        np.zeros((1, 0)), np.array([[bend(factor(m)) - bend(1.0)] for m in nodes]),
        np.zeros((3, 1, 0, len(X))), nodes,
    )  # fmt: skip
    return InferenceProblem(
        bend(1.0) + size * change, bend(1.0),
        (factor_of_moduli(STD, -2.0, 2.0),), {cause.name: emulator},
        np.diag(SCALE**2), np.outer(X, X), {cause.name: box_of(cause)},
        trained_on(baseline, [], SCALE, share=1.0, left_out=()), tails={cause.name: cause.tails},
    )  # fmt: skip


@pytest.mark.parametrize("size", [1.0, 9.0, -9.0])
def test_a_cause_whose_best_number_lies_beyond_is_simulated_there(size: float) -> None:
    """Readings that a strong cause explains lead to its number; weak ones ask for no simulation."""
    cause = next(each for each in causes(Config()) if each.name == "base_layer_offset")
    box, problem = box_of(cause), straight(cause, size)

    class Trained(CauseTraining):
        def __post_init__(self) -> None:
            self.boxes = {cause.name: box}

        problem = property(lambda self: problem)
        felt = property(lambda self: [cause])

    found = Trained(None, [cause], problem, SCALE).beyond(set())
    if abs(size) < box.max():
        assert found is None
        return
    assert found is not None
    assert found[0] is cause
    assert found[1][1] == pytest.approx(size, rel=0.05)
    assert not Trained(None, [cause], problem, SCALE).beyond({cause.name})


@pytest.mark.parametrize("size", [0.02, 1.0])
def test_a_cause_that_a_likely_fit_sees_is_simulated_further(
    monkeypatch: pytest.MonkeyPatch, size: float
) -> None:
    """Also where its first simulation did not tell that it could be seen beside others."""
    cause = next(each for each in causes(Config()) if each.name == "base_layer_offset")
    problem = straight(cause, size)
    computed: list[str] = []

    class Trained(CauseTraining):
        def __post_init__(self) -> None:
            self.designs = {
                cause.name: SimpleNamespace(first=lambda: None, expands=False, straight=False)
            }
            self.changes = {cause.name: turned_in(np.array([0.3]))}

        problem = property(lambda self: problem)
        felt = property(lambda self: [])

        def compute(self, some: dict[str, SimpleNamespace]) -> None:
            computed.extend(some)

    monkeypatch.setattr(training, "worth_simulating", lambda *asked: set())
    monkeypatch.setattr(Trained, "_reach", lambda self, say: None)
    Trained(None, [cause], problem, SCALE).run(print, fully=False)
    assert computed == [cause.name] * (2 if size > 0.5 else 1)


@pytest.mark.parametrize("turns", [True, False])
def test_places_are_added_until_an_emulator_is_right_or_no_longer_better(
    monkeypatch: pytest.MonkeyPatch, *, turns: bool
) -> None:
    """Of a contact that moves, a few places; of numbers at random, two and no more."""
    print("seed", SEED)
    cause = next(each for each in causes(Config()) if each.name == "plate_tilt")
    rng = np.random.default_rng(SEED)

    def simulated(zeta: np.ndarray) -> SimulatedChanges:
        told = turned_in(zeta)
        if turns:
            return told
        return replace(told, values=rng.standard_normal(told.values.shape))

    class Trained(CauseTraining):
        def __post_init__(self) -> None:
            self.changes = {cause.name: simulated(np.array([-2.1, -0.7, 0.7, 2.1]))}
            self.designs, self._trained = {cause.name: None}, {}
            self.boxes = {cause.name: box_of(cause)}
            self.added: list[float] = []
            self.left: list[float] = []

        felt = property(lambda self: [cause])

        def _trained_on(self, cause: Cause, own: SimulatedChanges) -> PolynomialEmulator:
            found = trained_on(own, SIDES, SCALE)
            self.left.append(found.left)
            return found

        def _added(self, some: dict[str, np.ndarray]) -> list[str]:
            for name, zeta in some.items():
                self.added += zeta.tolist()
                self.changes[name] = self.changes[name].beside(simulated(zeta))
            return []

    monkeypatch.setattr(training, "_design", lambda *asked: asked[-1][:, 0])
    found = Trained(None, [cause], SimpleNamespace(factor=None), SCALE)
    found.refine({"gent"}, print)
    assert not found.added
    found.refine({cause.name}, print)
    print("added", found.added, "left", found.left)
    if turns:
        assert found.left[-1] < 0.5 * found.left[0]
        assert len(found.added) > POLICY.at_once
    else:
        assert len(found.added) == POLICY.at_once


def test_a_range_goes_on_where_an_effect_is_stronger() -> None:
    """At the weak end of a positive number there is nothing to be found."""
    friction = next(each for each in causes(Config()) if each.name == "plate_friction")
    box = box_of(friction)
    assert wider(friction, box, np.array([0.0])) is None
    assert wider(friction, box, box[:, 0]) is None
    found = wider(friction, box, box[:, 1])
    assert found is not None
    assert found[0, 0] == box[0, 0]
    most = friction.numbers[0].zeta(friction.numbers[0].bounds[1])
    assert found[0, 1] == pytest.approx(min(most, POLICY.farthest * friction.tails[0]))
