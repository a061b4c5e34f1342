"""Vibrations, falls and steps in time, against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from support import bodies
from support.oscillator import oscillator

from dolfingrip import config
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.materials import densities
from dolfingrip.extensions.effect import Relaxing
from dolfingrip.mechanics.model.inertia import Inertia
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.vibration import complex_frequencies, natural_frequencies_Hz
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.sections.tables import assignments

SIDES, LENGTH = (3.0, 4.5), 90.0
STRICT = ("solver.rtol=1e-10", "solver.atol_N=1e-13", "material.nu=0.0001")


def bar(cells: tuple[int, int, int], *more: str, clamped: bool = True) -> FingerModel:
    """A bar along z, wider than thick, held at one end."""
    asked = config.load(None, assignments([*STRICT, "contact.self_contact=false", *more]))
    solid = bodies.box(cells, (*SIDES, LENGTH))
    ends = {"clamp": bodies.plane(2, 0.0)} if clamped else {}
    ends["tip"] = bodies.plane(2, LENGTH)
    return build(asked, bodies.domain(solid, ends), plate=False)


def timoshenko_Hz(
    depth: float, count: int, mass_g: float = 0.0, centre_mm: float = 0.0
) -> list[float]:
    """Natural frequencies of the cantilever by Timoshenko's theory, ν = 0 and k = 5/6.

    The state (w, ψ, M, V) at the tip follows from that at the clamp by a matrix exponential. A mass
    m that is spread over the tip's face, its centre c before it, needs V = m ω² (w + c ψ) and
    M = c V + m h²/12 ω² ψ there, which a determinant tells that vanishes.
    """
    shear, density = 2.93, 1190e-12
    young, area = 2 * shear, SIDES[0] * SIDES[1]
    inertia = area * depth**2 / 12

    def minor(omega: float) -> float:
        slopes = np.zeros((4, 4))
        slopes[0, 1], slopes[0, 3] = 1.0, 1 / (5 / 6 * shear * area)
        slopes[1, 2] = 1 / (young * inertia)
        slopes[2, 1], slopes[2, 3] = -density * inertia * omega**2, -1.0
        slopes[3, 0] = -density * area * omega**2
        pull = 1e-6 * mass_g * omega**2 * np.array([1.0, centre_mm, 0.0, 0.0])
        turn = 1e-6 * mass_g * omega**2 * np.array([0.0, depth**2 / 12, 0.0, 0.0])
        ends = np.eye(4)[2:] - [centre_mm * pull + turn, pull]
        return float(np.linalg.det(ends @ expm(slopes * LENGTH)[:, 2:]))

    tried = np.linspace(1.0, 1000.0, 500)
    values = [minor(omega) for omega in tried]
    roots = [
        brentq(minor, low, high)
        for low, high, one, other in zip(tried, tried[1:], values, values[1:], strict=False)
        if one * other < 0
    ]
    return [root / (2 * np.pi) for root in roots[:count]]


def test_frequencies_are_timoshenkos() -> None:
    """Two in each direction of a bar of slenderness 20 and 30."""
    finger = bar((2, 2, 24))
    mass = Inertia(finger.model.u, finger.site.domain, densities(finger.site)).mass
    newton = Newton(finger.model, finger.config.solver)
    found = natural_frequencies_Hz(newton, mass, 4)
    expected = sorted(each for depth in SIDES for each in timoshenko_Hz(depth, 2))
    np.testing.assert_allclose(found, expected, rtol=1e-3)


@pytest.mark.parametrize(("mass_g", "centre_mm"), [(1.0, 0.0), (5.0, 8.0)])
def test_a_mass_on_the_tip(mass_g: float, centre_mm: float) -> None:
    """First mode in each direction of a bar of 1.4 g with a mass, against Timoshenko's theory."""
    given = {"mass_g": mass_g, "centre_mm": centre_mm}
    loaded = bar((2, 2, 24), *(f"extensions.tip_mass.{key}={x}" for key, x in given.items()))
    site = loaded.site
    mass = Inertia(loaded.model.u, site.domain, densities(site), site.masses).mass
    found = natural_frequencies_Hz(Newton(loaded.model, loaded.config.solver), mass, 2)
    expected = sorted(timoshenko_Hz(depth, 1, **given)[0] for depth in SIDES)
    np.testing.assert_allclose(found, expected, rtol=2e-3)
    assert found[0] < 0.7 * timoshenko_Hz(min(SIDES), 1)[0]


def test_damping_ratios_are_those_of_the_complex_modulus() -> None:
    """A slender bar: s² + ω² E(s)/E∞ = 0 with E = 9Kμ/(3K + μ), the bulk elastic.

    Reference: the correspondence principle, with ω of the bar without loss, from its own tangent.
    Modes that bend the clamped end's corners change a little with the modulus by the bulk's.
    """
    rubber, loss = "material.nu=0.48", "extensions.loss_factor.loss_factor=0.15"
    elastic, lossy = bar((2, 2, 24), rubber), bar((2, 2, 24), rubber, loss)
    g, tau = map(np.array, lossy.config.extensions.active(Relaxing)[0].branches())
    bulk = elastic.config.material.lmbda_MPa + 2 * elastic.config.material.mu_MPa / 3
    at_rest, found = elastic.config.material.mu_MPa, {}
    for one in (elastic, lossy):
        mass = Inertia(one.model.u, one.site.domain, densities(one.site)).mass
        newton = Newton(one.model, one.config.solver)
        times = tau if one is lossy else ()
        found[one is lossy] = complex_frequencies(newton, mass, 2, one.site.history, times)
    np.testing.assert_allclose(found[False].real, 0.0, atol=1e-12)

    def young(s: complex) -> complex:
        mu = at_rest * (1 + (g / (1 - g.sum()) * s * tau / (1 + s * tau)).sum())
        return complex(9 * bulk * mu / (3 * bulk + mu))

    for free, damped in zip(found[False], found[True], strict=True):
        s = free
        for _ in range(50):
            s = 1j * abs(free) * np.sqrt(young(s) / young(0.0))
        assert damped == pytest.approx(s, rel=5e-3)
        assert -damped.real / abs(damped) == pytest.approx(-s.real / abs(s), rel=0.015)
        assert -damped.real / abs(damped) > 0.03


class Moving:
    """A bar in motion: its model, its inertia and its path in time."""

    def __init__(self, finger: FingerModel, longest_s: float, **how: Any) -> None:
        self.finger, self.model = finger, finger.model
        (self.inertia,) = (each for each in self.model.memories if isinstance(each, Inertia))
        self.newton = Newton(self.model, finger.config.solver)
        self.path = LoadPath(self.newton, {"time_s": longest_s}, **how)

    def to(self, time_s: float) -> None:
        arrival = self.path.advance({"pressure_kPa": 0.0, "time_s": time_s})
        assert arrival.failure is None, arrival.failure.sentence()

    def first_mode(self) -> tuple[np.ndarray, float]:
        """The first mode of unit largest displacement, and its ω (1/s), by inverse iteration."""
        inverse, mass = self.newton.linear(), self.inertia.mass
        shape = np.random.default_rng(1).uniform(-1, 1, len(self.model.u.x.array))
        x, y = mass.createVecs()
        for _ in range(40):
            x.array[:] = self.model.free * shape
            mass.mult(x, y)
            shape = inverse(self.model.free * y.array_r)
            stretch = np.abs(shape).max() / np.abs(x.array_r).max()
            shape /= np.abs(shape).max()
        return shape, 1 / np.sqrt(stretch)

    def plucked(self, speed: float) -> tuple[Callable[[], float], float]:
        """Let it vibrate in its first mode; the displacement by the mode's, and ω."""
        mode, omega = self.first_mode()
        self.inertia.motion.start(speed * mode, np.zeros_like(mode))
        place = int(np.abs(mode).argmax())
        return lambda: float(self.model.u.x.array[place] / mode[place]), omega


DYNAMIC = "experiment.dynamic=true"


def test_a_free_fall_is_exact() -> None:
    """v t + g t²/2 after steps of any length, for every α."""
    thrown, gravity = np.array([30.0, 0.0, -20.0]), np.array([0.0, 0.0, 9810.0])
    for alpha in (0.0, -0.1):
        falling = Moving(
            bar((1, 1, 2), DYNAMIC, f"solver.hht_alpha={alpha}",
                "gravity.acceleration_m_s2=9.81", clamped=False),
            0.01,
        )  # fmt: skip
        nodes = len(falling.model.u.x.array) // 3
        falling.inertia.motion.start(np.tile(thrown, nodes), np.tile(gravity, nodes))
        for time_s in (0.003, 0.0042, 0.05):
            falling.to(time_s)
            moved = thrown * time_s + gravity * time_s**2 / 2
            np.testing.assert_allclose(
                falling.model.u.x.array.reshape(-1, 3), np.tile(moved, (nodes, 1)), atol=1e-7
            )


@pytest.mark.parametrize("alpha", [0.0, -0.2])
def test_a_vibration_is_the_schemes_own(alpha: float) -> None:
    """Small amplitudes follow the scheme's equations of one degree of freedom.

    Energy is kept with α = 0, else lost at the scheme's rate. The error against the exact sine is
    of second order in the step.
    """
    moving = Moving(bar((1, 1, 6), DYNAMIC, f"solver.hht_alpha={alpha}"), 1.0, damped=False)
    speed = 1.0  # mm/s
    displacement, omega = moving.plucked(speed)
    start = moving.inertia.kinetic_mJ()
    errors = []
    for steps in (20, 40):
        state, period = moving.model.state(), 2 * np.pi / omega
        step_s = 0.6 * period / steps
        for i in range(1, steps + 1):
            moving.to(state.controls["time_s"] + i * step_s)
        expected, kept = oscillator(omega, step_s, steps, alpha, speed)
        assert displacement() == pytest.approx(expected, rel=1e-4)
        errors.append(displacement() - speed / omega * np.sin(0.6 * 2 * np.pi))
        left = (moving.model.energy() + moving.inertia.kinetic_mJ()) / start
        assert left == pytest.approx(kept, abs=1e-5)
        assert kept == pytest.approx(1.0, abs=1e-12) if alpha == 0 else kept < 0.9999
        moving.model.restore(state)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_steps_are_as_long_as_their_error_allows() -> None:
    """A plucked bar: no accepted step has a larger error, and a smaller one is more exact.

    The error of a step grows with the third power of its length.
    """
    found = {}
    for allowed_mm in (1e-3, 1e-5):
        finger = bar((1, 1, 6), DYNAMIC, f"solver.time_error_mm={allowed_mm}", "solver.hht_alpha=0")
        errors: list[float] = []
        moving = Moving(finger, 0.05, damped=False)
        moving.path.observers = [Watch(moving, errors)]
        displacement, omega = moving.plucked(1.0)
        end = 1.2 * 2 * np.pi / omega
        moving.to(end)
        assert max(errors) <= 1.0
        assert max(errors) > 0.3  # they are no shorter than needed
        off = displacement() - np.sin(omega * end) / omega
        found[allowed_mm] = len(errors), abs(off)
    (few, rough), (many, fine) = found.values()
    assert many / few == pytest.approx(100 ** (1 / 3), rel=0.3)
    assert fine < 0.1 * rough


class Watch:
    """Notes the error of each accepted step."""

    def __init__(self, moving: Moving, errors: list[float]) -> None:
        self._moving, self._errors = moving, errors

    def converged(self, before: Any) -> None:
        self._errors.append(self._moving.inertia.step_error())
