"""The evidence, the discrepancy and the decision, on cases whose answers are known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from dolfingrip.config import NO_CHANGE
from dolfingrip.diagnosis.answer.discrepancy import Along, kernel, smooth_curves
from dolfingrip.diagnosis.answer.refining import doubtful
from dolfingrip.diagnosis.core.blend import TangentBlend, Tangents, places
from dolfingrip.diagnosis.core.decision import _wider, decide, sensitivity
from dolfingrip.diagnosis.core.fitting import Hypotheses, MapFit
from dolfingrip.diagnosis.core.problem import InferenceProblem, Subset
from dolfingrip.diagnosis.core.sampling import drawn as sampled_draws
from dolfingrip.diagnosis.core.search import search, searched_again
from dolfingrip.diagnosis.core.unknown import NumberReading, Unknown, factor_of_moduli, mixture
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.extensions.effect import Prior

SEED = 5
X = np.linspace(0.1, 1.0, 12)
BASE = 3.0 * X
NOISE = 0.05


def cause(name: str) -> tuple[Unknown, ...]:
    return (Unknown(name, Prior(0.0, 1.0, "invented"), -3.3, 3.3),)


def case(
    value: np.ndarray,
    changes: Mapping[str, np.ndarray],
    rig: Mapping[str, np.ndarray] = NO_CHANGE,
    told: tuple[NumberReading, ...] = (),
) -> InferenceProblem:
    """Readings that are BASE at any modulus, with causes and numbers of a rig that are linear."""
    along = Along(X, X, np.zeros(len(X), dtype=int), np.full(len(X), 2.0))
    factor, wide = factor_of_moduli(0.1, -8.0, 8.0), 4.0 * 3.3
    far = [
        Unknown(name, Prior(0.0, 1.0, "invented"), -wide, wide, role="always", names=(name,))
        for name in rig
    ]
    problem = InferenceProblem(
        value, BASE, np.full(len(X), NOISE), (factor, *far),
        np.column_stack([np.zeros((len(X), 0)), *rig.values()]),
        {name: cause(name) for name in changes}, NOISE**2 * np.eye(len(X)), kernel(along),
        told=told,
    )  # fmt: skip
    u, rate = factor.coordinate_of(1.0)
    plain = np.column_stack([BASE, rate * BASE])
    runs = [((), Tangents(np.array([[u]]), plain[None]))]
    for name, change in changes.items():
        told = np.column_stack([plain, change])
        runs.append(((name,), Tangents(np.array([[u, 0.0]]), told[None])))
    return problem.beside(runs)


def drawn(*parts: np.ndarray) -> np.ndarray:
    print("seed", SEED)
    noise = NOISE * np.random.default_rng(SEED).standard_normal(len(X))
    return BASE + sum(parts, np.zeros(len(X))) + noise


BENT = {"bent": 0.6 * X**3}
WAVES = {"bent": 0.6 * X**3, "wave": 0.5 * np.sin(6 * X), "twin": 0.61 * X**3}


def fitted(own: InferenceProblem, subset: Subset, *starts: np.ndarray) -> MapFit:
    """The fit of a hypothesis without a discrepancy, from its priors' middles where not told."""
    (fit,) = Hypotheses(own, [subset]).fits({
        (subset, 0.0): starts or [np.zeros(len(own.unknowns(subset)))]
    })  # fmt: skip
    return fit


def test_the_evidence_is_the_integral() -> None:
    """Laplace's method against quadrature over both numbers."""
    own = case(drawn(0.5 * BENT["bent"]), BENT)
    best = fitted(own, ("bent",))

    def density(a: float, z: float) -> float:
        rest = own.value - own.predicted(("bent",), np.array([z, a]))
        log = -0.5 * (rest @ rest) / NOISE**2 - 0.5 * (a**2 + z**2)
        return float(np.exp(log - reference)) / (2 * np.pi)

    rest = own.value - own.predicted(("bent",), best.zeta)
    reference = -0.5 * float(rest @ rest) / NOISE**2
    whole, _ = dblquad(density, -3, 3, -3.3, 3.3)
    constant = -len(X) * (np.log(NOISE) + 0.5 * np.log(2 * np.pi))
    assert best.log_evidence == pytest.approx(np.log(whole) + reference + constant, abs=0.02)
    sampled = Hypotheses(own, [("bent",)]).sampled(best, np.random.default_rng(SEED))
    assert sampled.log_evidence == pytest.approx(best.log_evidence, abs=0.1)


def test_an_error_of_an_instrument_does_not_fade_beside_another_cause() -> None:
    """A gain multiplies what the other changes, however strong that is: against the product."""
    alone = case(drawn(), {"bent": BENT["bent"], "gain": 0.3 * BASE})
    (u,) = alone.runs[()].u[0]
    of_modulus, bent = alone.runs[()].told[0, :, 1], BENT["bent"]
    told = [
        np.column_stack([
            (1 + 0.3 * gain) * (BASE + bent), (1 + 0.3 * gain) * of_modulus,
            (1 + 0.3 * gain) * bent, 0.3 * (BASE + bent),
        ])
        for gain in (-2.0, 0.0, 2.0)
    ]  # fmt: skip
    pair = ("bent", "gain")
    at = np.array([[u, 1.0, gain] for gain in (-2.0, 0.0, 2.0)])
    shows = replace(alone, displaying=frozenset({"gain"})).beside(
        [(pair, Tangents(at, np.array(told)))]
    )
    fades = alone.beside([(pair, Tangents(at, np.array(told)))])
    zeta = np.array([0.0, 3.0, 2.0])
    exact = 1.6 * (BASE + 3.0 * bent)
    np.testing.assert_allclose(shows.predicted(pair, zeta), exact, atol=NOISE)
    assert np.abs(fades.predicted(pair, zeta) - exact).max() > 4 * NOISE


def test_fits_from_many_places_at_once_are_those_from_each() -> None:
    """Against fits one by one: the modulus as told and another, at two levels, from three starts.

    The change is curved, and one start lies beyond its range.
    """
    plain = case(drawn(8 * BENT["bent"], 0.5 * BASE), BENT)
    (factor,) = plain.always
    at = np.linspace(-3.3, 3.3, 9)[:, None]
    u, rate = factor.coordinate_of(1.0)
    told = [
        np.column_stack([BASE + np.sinh(z) * BENT["bent"], rate * BASE, np.cosh(z) * BENT["bent"]])
        for (z,) in at
    ]
    own = plain.beside([(("bent",), Tangents(np.hstack([u + 0 * at, at]), np.array(told)))])
    own = replace(own, always=(replace(factor, names=("far",)),))
    starts = [np.array(each) for each in ([0.0, 0.0], [2.0, -3.0], [-2.0, 9.0])]
    hypothesis = Hypotheses(own, [("bent",)])
    keys = [(subset, level) for subset in (("bent",), ("bent", "far")) for level in (0.0, 0.01)]
    both = hypothesis.fits(dict.fromkeys(keys, starts), 1e-14)
    alone = [
        max((hypothesis.fits({key: [each]}, 1e-14)[0] for each in starts),
            key=lambda fit: fit.log_evidence)
        for key in keys
    ]  # fmt: skip
    for fit, other in zip(both, alone, strict=True):
        print(fit.subset, fit.zeta, fit.log_evidence)
        np.testing.assert_allclose(fit.zeta, other.zeta, atol=1e-6)
        assert fit.log_evidence == pytest.approx(other.log_evidence, abs=1e-6)
        assert fit.strengths == pytest.approx(other.strengths, rel=1e-4)
    assert both[2].log_evidence > both[0].log_evidence + 3
    far = fitted(own, ("bent", "far"), *starts)
    assert far.subset == ("bent", "far")
    assert far.log_evidence == pytest.approx(both[2].log_evidence, abs=1e-3)


def test_a_cause_is_named_with_its_twin() -> None:
    """What readings cannot tell apart is named together; what is not there is not."""
    posterior = search(case(drawn(1.5 * WAVES["bent"]), WAVES), np.random.default_rng(SEED))
    decision, under = sensitivity(posterior)
    assert decision.answer == "cause"
    assert set(decision.first) == {"bent", "twin"}
    assert not decision.second
    assert decision.probability > 0.9
    assert decision.unexplained < 0.01
    assert under.least > 0.8


@pytest.mark.parametrize("by", [0.5, 2.0, 4.0])
def test_a_wider_prior_is_a_stronger_change(by: float) -> None:
    """Against the evidence of a cause whose change is so many times as strong, but for how little
    the readings are no linear function of cause and modulus together."""
    value = drawn(1.5 * BENT["bent"])

    def evidence_of(strength: float) -> MapFit:
        own = case(value, {"bent": strength * BENT["bent"]})
        return fitted(own, ("bent",))

    gain = evidence_of(by).log_evidence - evidence_of(1.0).log_evidence
    assert _wider([evidence_of(1.0)], [np.ones(1)], by)[0] == pytest.approx(gain, abs=0.05)


def test_an_answer_that_stays_under_wider_priors_has_lost_none() -> None:
    strong, faint = (
        sensitivity(search(case(drawn(by * BENT["bent"]), BENT), np.random.default_rng(SEED)))
        for by in (2.0, 0.125)
    )
    assert strong[0].first == ("bent",)
    assert strong[1].least > 0.5
    print(faint[1].probability)
    assert {f"priors {by} times as wide" for by in ("0.5", "2", "4")} < set(faint[1].probability)
    assert min(faint[1].probability.values()) < min(strong[1].probability.values())


def test_two_causes_are_both_named() -> None:
    changes = {"bent": WAVES["bent"], "wave": WAVES["wave"]}
    value = drawn(1.5 * changes["bent"], 1.5 * changes["wave"])
    decision, _ = sensitivity(search(case(value, changes), np.random.default_rng(SEED)))
    assert {*decision.first, *decision.second} == {"bent", "wave"}
    assert len(decision.first) == len(decision.second) == 1


def test_nothing_is_seen_in_noise() -> None:
    decision = decide(search(case(drawn(), WAVES), np.random.default_rng(SEED)))
    assert decision.answer == "none"
    assert decision.none > 0.5


def test_an_uneven_outsider_is_not_given_to_a_cause_that_follows_a_little_of_it() -> None:
    """A screw of uneven pitch, 4 standard deviations of a reading in size."""
    waver = 4 * NOISE * np.sin(2 * np.pi * X / 0.3)
    decision = decide(search(case(drawn(waver), BENT), np.random.default_rng(SEED)))
    assert decision.answer == "unknown"


def test_an_outsider_is_unknown() -> None:
    """A change of another shape, 20 standard deviations of a reading, is given to no cause."""
    jump = np.where(X > 0.5, 1.0, 0.0)
    decision = decide(search(case(drawn(jump), BENT), np.random.default_rng(SEED)))
    assert decision.answer == "unknown"


def test_what_a_cause_explains_by_half_is_not_given_to_it() -> None:
    """A strong change of which the cause's shape is only a part."""
    value = drawn(1.5 * BENT["bent"], np.where(X > 0.45, 0.6, 0.0))
    decision = decide(search(case(value, BENT), np.random.default_rng(SEED)))
    assert decision.answer == "unknown"
    assert decision.unexplained > 0.15


def test_a_cause_is_no_surer_than_the_share_that_it_explains() -> None:
    """A strong cause beside a small jump is named, and what stays is told."""
    value = drawn(3 * BENT["bent"], np.where(X > 0.7, 0.35, 0.0))
    decision = decide(search(case(value, BENT), np.random.default_rng(SEED)))
    assert decision.answer == "cause"
    assert decision.first == ("bent",)
    assert 0.01 < decision.unexplained < 0.5
    assert 0.25 < decision.probability <= (1 - decision.unexplained) ** 2


def test_draws_follow_a_curved_ridge() -> None:
    """y ~ N(x², 0.4²) over x ~ N(0, 1): the integral is 1, and E y = E x² = 1."""

    def log_density(at: np.ndarray) -> np.ndarray:
        off = (at[:, 1] - at[:, 0] ** 2) / 0.4
        return np.asarray(-0.5 * (at[:, 0] ** 2 + off**2) - np.log(2 * np.pi * 0.4))

    print("seed", SEED)
    about_mode = np.diag([1.0, 0.16])
    found = sampled_draws(log_density, np.zeros(2), about_mode, np.random.default_rng(SEED))
    assert found is not None
    places, weights, log_integral = found
    assert 1 / np.square(weights).sum() > 100
    assert log_integral == pytest.approx(0.0, abs=0.15)
    assert weights @ places[:, 1] == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("width", [0.3, 0.2, 0.15, 0.01])
def test_draws_of_a_density_in_a_corner(width: float) -> None:
    """Few draws are where a box of density 1/width² is, or none: its integral is 1 if they tell."""

    def log_density(at: np.ndarray) -> np.ndarray:
        inside = ((at >= 0) & (at <= width)).all(axis=1)
        return np.where(inside, -2 * np.log(width), -np.inf)

    print("seed", SEED)
    found = sampled_draws(log_density, np.zeros(2), np.eye(2), np.random.default_rng(SEED))
    assert found is None or found[-1] == pytest.approx(0.0, abs=0.2)
    assert found is not None or width < 0.1


def test_a_far_modulus_is_a_matter_of_the_modulus() -> None:
    """Five standard deviations off, it is the cause itself, and no effect is named for it."""
    own = case(drawn() + 0.6 * BASE, WAVES)
    posterior = search(own, np.random.default_rng(SEED))
    decision = decide(posterior)
    factor = own.factor.at(decision.best.zeta[0])
    assert decision.answer == "cause"
    assert decision.first == own.always[0].names
    assert decision.probability > 0.9
    assert float(factor) == pytest.approx(1.6, rel=0.02)


def test_a_cause_that_needs_no_far_modulus_stands_beside_it() -> None:
    """Force and modulus both 1.6 times as large: readings cannot tell which; other priors agree."""
    own = case(1.6 * drawn(), WAVES | {"gain": 0.4 * BASE})
    decision, under = sensitivity(search(own, np.random.default_rng(SEED)))
    assert decision.answer == "cause"
    assert {*decision.first} == {*own.always[0].names, "gain"}
    assert decision.nuisance_only
    assert under.least > 0.5


def test_a_modulus_within_what_is_told_is_no_cause() -> None:
    decision = decide(search(case(1.15 * drawn(), WAVES), np.random.default_rng(SEED)))
    assert decision.answer == "none"


def test_a_number_of_the_rig_stands_beside_a_cause_not_in_its_place() -> None:
    """A slip of the rig with a cause: the causes' set holds effects, the slip is named second."""
    changes = {"bent": WAVES["bent"], "twin": WAVES["twin"], "slip": WAVES["wave"]}
    value = drawn(3 * changes["bent"], 5 * changes["slip"])
    slip = {"slip": changes.pop("slip")}
    own = case(value, changes, slip)
    decision, _ = sensitivity(search(own, np.random.default_rng(SEED)))
    assert set(decision.first) == {"bent", "twin"}
    assert decision.second == ("slip",)
    alone = case(drawn(5 * slip["slip"]), changes, slip)
    assert decide(search(alone, np.random.default_rng(SEED))).first == ("slip",)


def test_what_was_likely_is_found_again_without_some_readings() -> None:
    """Fits that begin at those of all readings end where a whole search ends."""
    own = case(drawn(1.5 * WAVES["bent"]), WAVES)
    kept = np.arange(len(X)) % 4 != 0
    whole = search(own, np.random.default_rng(SEED), sample=False)
    again = searched_again(own.rows(kept), whole)
    anew = search(own.rows(kept), np.random.default_rng(SEED), sample=False)
    assert again.log_density == pytest.approx(anew.log_density, abs=0.01)
    assert decide(again).first == decide(anew).first


@pytest.mark.parametrize("changed", [(), ("bent",)])
def test_after_a_correction_the_fits_that_it_does_not_concern_stay(
    changed: tuple[str, ...],
) -> None:
    """The same as a whole search, but for rounding."""
    own = case(drawn(1.5 * WAVES["bent"]), WAVES)
    before = search(own, np.random.default_rng(SEED))
    zeta = before.best(changed).zeta
    missed = 0.5 * NOISE * np.cos(9 * X)
    u, rate = np.array([
        n.coordinate(z) for n, z in zip((*own.always, *cause("bent")), zeta, strict=False)
    ]).T  # fmt: skip
    exact = np.column_stack(
        [own.predicted(changed, zeta) + missed, own.slopes(changed, zeta) / rate]
    )
    other = own.beside([(changed, Tangents(u[None], exact[None]))])
    anew = search(other, np.random.default_rng(SEED))
    again = search(other, np.random.default_rng(SEED), before=before, changed=[changed])
    assert [each.subset for each in again.fits] == [each.subset for each in anew.fits]
    # fits beside others are rounded otherwise
    np.testing.assert_allclose(again.probability, anew.probability, rtol=1e-8, atol=1e-15)
    assert abs(again.log_density - before.log_density) > 1e-3
    kept = sum(each is fit for key, fits in again.modes.items() for each in fits
               for fit in before.modes.get(key, ()))  # fmt: skip
    assert (kept > len(again.fits) / 3) == bool(changed)


def test_a_pair_cannot_be_more_likely_than_its_columns_allow() -> None:
    own = case(drawn(1.5 * WAVES["bent"]), WAVES)
    fit = fitted(own, ("bent", "wave"))
    assert Hypotheses(own, [("bent", "wave")]).largest(0.0)[0] > fit.log_evidence


def test_fewer_causes_are_worked_out_before_a_second_one_is_named() -> None:
    """Each alone is far from its simulation, and misses by more than any guess of what that errs.

    Two causes act, and the pair has been simulated as often as it may.
    """
    both = {name: WAVES[name] for name in ("bent", "wave")}
    own = case(drawn(8.0 * both["bent"], 8.0 * both["wave"]), both)
    posterior = search(own, np.random.default_rng(SEED), sample=False)
    _, best = max(posterior.weighed, key=lambda pair: pair[0])
    assert own.causes(best.subset) == ("bent", "wave")
    of = SimpleNamespace(closed_form=False, free=lambda fit: None)
    tried = Counter({("bent", "wave"): own.policy.tries})
    free, fits = doubtful(of, posterior, tried)  # type: ignore[arg-type]
    assert not free
    assert {own.causes(fit.subset) for fit in fits} == {("bent",), ("wave",)}
    tried |= Counter(dict.fromkeys((("bent",), ("wave",)), own.policy.tries))
    assert doubtful(of, posterior, tried) == ([], [])  # type: ignore[arg-type]


def test_the_discrepancy_is_a_covariance_that_is_zero_at_rest() -> None:
    x = np.r_[0.0, X]
    found = kernel(Along(x, x, np.zeros(len(x), dtype=int), np.ones(len(x))))
    assert np.abs(found[0]).max() < 1e-12
    assert np.linalg.eigvalsh(found).min() > -1e-9


def test_a_blend_goes_through_what_was_simulated() -> None:
    """A change of two numbers: values and slopes at the simulations, and near them elsewhere."""
    numbers = (
        Unknown("amount", Prior(1.0, 0.5, "invented", positive=True), -3.3, 3.3),
        Unknown("shape", Prior(0.0, 1.0, "invented"), -2.0, 3.0, amplitude=False),
    )

    def told(u: np.ndarray) -> np.ndarray:
        amount, shape = 1.0 + 0.5 * u[:, :1], u[:, 1:]
        value, turned = amount * np.sin(X * (1 + 0.2 * shape)), np.cos(X * (1 + 0.2 * shape))
        return np.stack([value, 0.5 * value / amount, 0.2 * amount * X * turned], axis=2)

    zeta = places(np.array([[-2.0, 2.0], [-2.0, 3.0]]), 64)
    u = np.column_stack([n.coordinate(zeta[:, i])[0] for i, n in enumerate(numbers)])
    found = TangentBlend.of(numbers, Tangents(u, told(u)), np.full(len(X), NOISE))
    value, slopes = found.at_coordinates(u)
    np.testing.assert_allclose(value @ found.columns.T, told(u)[..., 0], atol=0.1 * NOISE)
    np.testing.assert_allclose(found.columns @ slopes, told(u)[..., 1:], atol=0.1 * NOISE)
    print("seed", SEED)
    fresh = np.random.default_rng(SEED).uniform([-1.5, -1.5], [1.5, 2.5], (50, 2))
    at = np.column_stack([n.coordinate(fresh[:, i])[0] for i, n in enumerate(numbers)])
    off = found.at(fresh) @ found.columns.T - told(at)[..., 0]
    assert np.sqrt(np.mean(off**2)) < 0.1 * NOISE
    step = 1e-5 * np.eye(2)
    by_difference = (found.at(fresh[:1] + step) - found.at(fresh[:1] - step)).T / 2e-5
    np.testing.assert_allclose(found.with_slopes(fresh[:1])[1][0], by_difference, atol=1e-4)


def test_the_evidence_of_numbers_that_are_linear_is_exact() -> None:
    """Against the normal density with their covariance: a number of the rig, and a cause."""
    own = case(drawn(1.5 * WAVES["bent"]), {"bent": WAVES["bent"]}, {"slip": WAVES["wave"]})
    fit = fitted(own, ("bent",))
    slope = own.slopes(("bent",), np.zeros(3))
    # the factor of all moduli is not: it is held where the fit has it
    held = own.predicted(("bent",), np.r_[fit.zeta[0], 0.0, 0.0])
    total = own.covariance + slope[:, 1:] @ slope[:, 1:].T
    known = multivariate_normal(held, total).logpdf(own.value) - 0.5 * fit.zeta[0] ** 2
    white = np.linalg.solve(np.linalg.cholesky(total), own.slopes(("bent",), fit.zeta)[:, 0])
    known -= 0.5 * np.log(1 + white @ white)
    assert fit.log_evidence == pytest.approx(known, abs=1e-6)


def test_numbers_that_are_read_by_themselves_are_readings() -> None:
    """Against the normal density of all: a sum of a number of the rig and one of a cause."""
    # reference: scipy
    told = NumberReading("sum", {"bent": 2.0, "slip": 1.0}, {"bent": 0.0, "slip": 0.0}, 5.0, 0.3,
                         6.1)  # fmt: skip
    own = case(
        drawn(1.5 * WAVES["bent"]), {"bent": WAVES["bent"]}, {"slip": WAVES["wave"]}, (told,)
    )
    for subset, rates in ((("bent",), [1.0, 2.0]), ((), [1.0])):
        d = 1 + len(rates)
        fit = fitted(own, subset)
        slope = own.slopes(subset, np.zeros(d))[:, 1:]
        held = own.predicted(subset, np.r_[fit.zeta[0], np.zeros(d - 1)])
        both = np.vstack([slope, rates])
        total = block_diag(own.covariance, 0.3**2) + both @ both.T
        value, mean = np.append(own.value, 1.1), np.append(held, 0.0)
        known = multivariate_normal(mean, total).logpdf(value) - 0.5 * fit.zeta[0] ** 2
        factor = np.append(own.slopes(subset, fit.zeta)[:, 0], 0.0)
        white = np.linalg.solve(np.linalg.cholesky(total), factor)
        known -= 0.5 * np.log(1 + white @ white)
        assert fit.log_evidence == pytest.approx(known, abs=1e-6)


def test_a_cause_that_is_read_by_itself_is_named() -> None:
    """Twins that readings tell apart by nothing; one is read as absent, or as what it is."""
    twins = {"bent": WAVES["bent"], "twin": WAVES["bent"]}
    value = drawn(2.0 * WAVES["bent"])

    def named(*read: float) -> tuple[str, ...]:
        told = [NumberReading("twin", {"twin": 1.0}, {"twin": 0.0}, 0.0, 0.1, r) for r in read]
        own = case(value, twins, told=tuple(told))
        decision = decide(search(own, np.random.default_rng(SEED), sample=False))
        assert decision.answer == "cause"
        return decision.first

    assert {*named()} == {*twins}
    assert named(2.0) == ("twin",)
    assert named(0.0) == ("bent",)


def test_a_mixture_is_weighed_by_both_of_its_parts() -> None:
    """Against quadrature: a cause whose prior has a wide part, far out."""
    value = drawn(7.0 * BENT["bent"])
    own = case(value, BENT)
    (number,) = cause("bent")
    own = replace(own, numbers={"bent": (replace(number, low=-20.0, high=20.0, tail=4.0),)})
    fit = fitted(own, ("bent",), np.zeros(2), np.array([0.0, 6.0]))

    def density(z: float, a: float) -> float:
        rest = own.value - own.predicted(("bent",), np.array([a, z]))
        log = -0.5 * (rest @ rest) / NOISE**2 - mixture(np.array([z]), np.array([4.0]))[0]
        return float(np.exp(log[0] - 0.5 * a**2 - best)) / (2 * np.pi)

    best = fit.log_evidence + len(X) * (np.log(NOISE) + 0.5 * np.log(2 * np.pi))
    whole, _ = dblquad(density, -4, 4, 4, 10)
    assert np.log(whole) == pytest.approx(0.0, abs=0.02)


def test_where_readings_tell_nothing_probabilities_are_the_priors() -> None:
    """Effects too weak to be read: none, one or two act as probably as before the readings."""
    weak = {name: 1e-7 * change for name, change in WAVES.items()}
    own = case(drawn(), weak)
    posterior = search(own, np.random.default_rng(SEED), sample=False)
    found = [0.0, 0.0, 0.0]
    for subset, probability in posterior.subsets.items():
        found[len(own.causes(subset))] += probability
    assert found == pytest.approx(Policy().prior_by_size, rel=0.01)
    twos = [p for subset, p in posterior.subsets.items() if subset == ("bent", "wave")]
    assert twos == pytest.approx([Policy().prior_by_size[2] / 3], rel=0.1)


@pytest.mark.parametrize(("change", "by_shape"), [(0.8 * X**3, True), (0.8 * (X > 0.5), False)])
def test_memory_that_one_rate_shows_has_to_beat_any_smooth_elastic_curve(
    change: np.ndarray, by_shape: bool
) -> None:
    """A smooth change is followed by some elastic law as well, a step is not."""
    along = Along(X, X, np.zeros(len(X), dtype=int), np.full(len(X), 2.0))
    own = replace(
        case(drawn(1.5 * change), {"remembers": change}),
        remembering=frozenset({"remembers"}), curves=smooth_curves(along),
    )  # fmt: skip
    decision = decide(search(own, np.random.default_rng(SEED)))
    assert (decision.answer, decision.first) == ("cause", ("remembers",))
    assert decision.by_shape == by_shape
    assert (decision.probability <= 0.5) == by_shape
    elastic = decide(search(replace(own, curves=None), np.random.default_rng(SEED)))
    assert not elastic.by_shape
    assert elastic.probability > 0.9


def test_memory_that_has_the_shape_of_a_curve_is_no_second_cause() -> None:
    """Beside a cause that no curve is in the place of, which is claimed as surely as by itself."""
    along = Along(X, X, np.zeros(len(X), dtype=int), np.full(len(X), 2.0))
    wave, bent = 0.5 * np.sin(9 * X), 0.8 * X**3
    both = replace(
        case(drawn(2 * wave + 1.5 * bent), {"wave": wave, "remembers": bent}),
        remembering=frozenset({"remembers"}),
    )
    told = decide(search(both, np.random.default_rng(SEED)))
    assert {*told.first, *told.second} == {"wave", "remembers"}
    own = replace(both, curves=smooth_curves(along))
    decision = decide(search(own, np.random.default_rng(SEED)))
    assert (decision.first, decision.second) == (("wave",), ())
    assert not decision.by_shape
    assert decision.probability > 0.9
