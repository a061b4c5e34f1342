"""The screen: shapes, secants and what cannot be seen."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from diagnosis.inference import synthetic
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.screen import Screen

TABLE = synthetic.index()
COVARIANCE = synthetic.covariance(TABLE)
LOAD = synthetic.load(TABLE)
FORCE = np.where(synthetic.is_angle(TABLE), 0.0, 0.02)


def test_evidence_of_several_shapes_is_the_average_of_their_densities() -> None:
    # reference: normal densities with the whole covariance
    shapes = [3 * FORCE * LOAD**k for k in (1, 2, 4)]
    candidate = Candidate("a", tuple(Shape(v) for v in shapes), mean=0.0, spread=0.7)
    r = COVARIANCE.sample(np.random.default_rng(12), 1)[:, 0] + 2 * shapes[1]
    zero = np.zeros(len(r))
    none = multivariate_normal(zero, COVARIANCE.matrix).logpdf(r)
    logs = [
        multivariate_normal(zero, COVARIANCE.matrix + 0.49 * np.outer(v, v)).logpdf(r) - none
        for v in shapes
    ]
    score = Screen([candidate], COVARIANCE).scores(COVARIANCE.whiten(r))[0]
    assert score.log_evidence == pytest.approx(np.log(np.mean(np.exp(logs))), abs=1e-6)
    assert score.shape == int(np.argmax(logs))
    batch = Screen([candidate], COVARIANCE).log_evidence(COVARIANCE.whiten(np.c_[r, -r]))
    assert batch[0] == pytest.approx([score.log_evidence] * 2)


def test_an_effect_that_changes_nothing_is_told_and_left_out() -> None:
    zero = Candidate("clamp_compliance", (Shape(np.zeros(len(TABLE))),), 1.0, 0.3, True)
    seen = Candidate("plate_tilt", (Shape(10 * FORCE * np.cos(7 * LOAD)),), 1.0, 0.3, True)
    screen = Screen([zero, seen], COVARIANCE)
    scores = screen.scores(COVARIANCE.whiten(20 * FORCE))
    assert [score.visible for score in scores] == [False, True]
    assert scores[0].log_evidence == pytest.approx(0.0, abs=1e-12)
    assert scores[0].notes == ("clamp_compliance cannot be seen in these readings",)
    assert np.isfinite(scores[0].direction).all()


def test_secants_find_what_tangents_miss() -> None:
    # Mooney–Rivlin's trap: the change at ordinary strength points another way than the tangent.
    seed, draws = 13, 150
    print("seed", seed)
    rng = np.random.default_rng(seed)
    straight, curved = 15 * FORCE * np.sin(5 * LOAD), -30 * FORCE * np.sin(5 * LOAD + 0.6)
    others = [
        Candidate(name, (Shape(v),), 1.0, 0.4, True) for name, v in synthetic.columns(TABLE).items()
    ]

    def true_first(shape: Shape) -> float:
        true = Candidate("mooney_rivlin", (shape,), 1.0, 0.4, True)
        screen = Screen([true, *others], COVARIANCE)
        strength = np.maximum(rng.normal(1.0, 0.3, draws), 0.2)
        change = np.outer(straight, strength) + np.outer(curved, strength**2)
        r = change + COVARIANCE.sample(rng, draws)
        return float((screen.log_evidence(COVARIANCE.whiten(r)).argmax(axis=0) == 0).mean())

    tangent, secant = true_first(Shape(straight)), true_first(Shape(straight + curved))
    print(f"true effect first: tangent {tangent}, secant {secant}")
    assert tangent < 0.1
    assert secant > 0.9


def test_intervals_hold() -> None:
    # strengths from the prior lie in the 90 % interval nine times of ten
    seed, draws = 14, 400
    print("seed", seed)
    rng = np.random.default_rng(seed)
    screen = Screen([synthetic.candidates(TABLE)[3]], COVARIANCE)
    inside = Counter[bool]()
    for _ in range(draws):
        _, strength = screen.candidates[0].draw(rng)
        white = strength * screen.columns[:, 0] + rng.standard_normal(len(TABLE))
        found = screen.scores(white)[0].amplitude
        inside[found.low < strength < found.high] += 1
    print(inside)
    assert inside[True] / draws == pytest.approx(0.9, abs=3 * np.sqrt(0.09 / draws))
