"""The finger as the generator simulates it, and the causes of the catalogue that it can hide.

It has other elements than the analyser, more of them, other barriers at plate and bellows, and
shorter load steps. Strengths and shapes are its own: drawn from the priors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from benchmarks.blind.protocols import Protocol
from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.experiments.synthetic import draw
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.parameter import bounds_of

SETTINGS: Final = (
    "contact.barrier_mm=0.15",
    "contact.stiffness_MPa=0.01",
    "plate.barrier_mm=0.07",
    "plate.stiffness_MPa=0.2",
    "solver.max_step_kPa=17",
)
"""Other than the analyser's."""

MESHES: Final[Mapping[str, tuple[str, ...]]] = {
    "reference": ("solver.element=P2", "mesh.size_mm=4", "mesh.edge_size_mm=1.5"),
    "short": ("solver.element=P2", "mesh.size_mm=5", "mesh.edge_size_mm=3"),
}
"""Tetrahedra of the reference finger and of the short one, which tell what causes change."""
CONVERGED: Final[Mapping[str, tuple[str, ...]]] = {
    "reference": ("solver.element=S2", "mesh.size_mm=3", "mesh.edge_size_mm=0.125"),
}
"""Mesh of a finger without causes, and of all in one, where tetrahedra are too stiff.

At 250 kPa these hexahedra turn the reference finger by 147.3°, a converged mesh by 147.9°, and its
tetrahedra by 140.9°. That is 3 standard deviations of the error that the analyser allows a mesh. Of
what a cause changes, 5 % matter little.
"""

HEADROOM: Final = 1.5
"""Elastic curves go to so many times the highest pressure, for soft fingers."""

NEVER: Final = ("pressure_gain", "pressure_offset", "plate_gap", "wall_offset")
"""Nuisances, which no diagnosis names."""
STAGES: Final = ("line_lag",)
"""Effects between regulator and cavity, which need no simulation."""
BY_SLOPE: Final[Mapping[str, str]] = {"base_layer_offset": "finger.base_layer_mm"}
"""Effects that are taken from a derivative by a parameter: another wall would be another mesh."""
DRIFT: Final = "temperature_drift"
"""A modulus that depends on time: from the base curve by scaling."""
NUMERICAL: Final = "numerical"
"""Kind of those that are choices of the analyser's own model: none to hide."""

FEW: Final = (0.7, 1.75)
"""Part of the ordinary strength, and spreads beyond the mean, at which an effect is simulated."""
CERTAIN: Final = 0.01
"""Spread of a strength, by the ordinary one, below which it is not varied."""
FAINTEST: Final = 0.02
"""Least strength that is hidden of what has one sign, by the ordinary one."""
EITHER_WAY: Final = 1.5
"""Spreads to either side at which an effect of two signs is."""


@dataclass(frozen=True, slots=True)
class Form:
    """One form of a cause: values of the parameters that are no strength.

    Attributes:
        label: for people.
        held: values of those parameters.
        parts: strengths that are simulated, by the ordinary one; none where it has a closed form.
    """

    label: str
    held: Mapping[str, float]
    parts: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Cause:
    """A cause of the catalogue.

    Attributes:
        effect: of the catalogue.
        forms: that it is hidden in.
        mean, spread: of the strength, by the ordinary one.
        one_sided: whether the strength is above 0.
    """

    effect: type[Effect]
    forms: tuple[Form, ...]
    mean: float
    spread: float
    one_sided: bool

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.effect.name()

    @property
    def remembers(self) -> bool:
        """Whether it depends on what was before."""
        return self.effect.kind == "dissipative"

    @property
    def simulated(self) -> bool:
        """Whether it needs simulations of its own."""
        return bool(self.forms[0].parts)

    def values(self, form: int, strength: float, modulus: float = 1.0) -> dict[str, Any]:
        """Parameters of the effect at a strength.

        Args:
            form: number of the form.
            strength: by the ordinary one.
            modulus: factor of all moduli, by which the effect's own moduli are larger, too, and
                compliances smaller.
        """
        priors = self.effect.priors()
        found: dict[str, Any] = dict(self.forms[form].held)
        for key in amplitudes(self.effect):
            neutral = neutral_of(self.effect, key)
            found[key] = neutral + strength * step_of(self.effect, key, priors[key])
        for key, value in found.items():
            low, high = bounds_of(self.effect, key)
            inside = float(np.clip(value * _scaling(key, modulus), low, high))
            is_list = isinstance(self.effect.model_fields[key].default, tuple)
            found[key] = [inside] if is_list else inside
        return found

    def overrides(self, form: int, strength: float, modulus: float = 1.0) -> tuple[str, ...]:
        """The assignments of ``--set`` with these values."""
        return tuple(
            f"extensions.{self.name}.{key}={value!r}"
            for key, value in self.values(form, strength, modulus).items()
        )

    def draw(self, rng: np.random.Generator) -> tuple[int, float]:
        """Number of a form and a strength, from the prior; within what was simulated."""
        form = int(rng.integers(len(self.forms)))
        key = amplitudes(self.effect)[0]
        prior = self.effect.priors()[key]
        neutral, step = neutral_of(self.effect, key), step_of(self.effect, key, prior)
        low, high = self.range()
        while True:
            strength = (draw(prior, rng) - neutral) / step
            if low <= strength <= high:
                return form, float(strength)

    def range(self) -> tuple[float, float]:
        """Strengths that are hidden: two spreads about the mean."""
        low, high = self.mean - 2 * self.spread, self.mean + 2 * self.spread
        return (max(low, FAINTEST) if self.mean else low), min(high, strongest(self.effect))


def _scaling(key: str, modulus: float) -> float:
    """Factor of a parameter that leaves everything alike where all moduli change."""
    if key.endswith("_MPa"):
        return modulus
    return 1 / modulus if "_per_N" in key else 1.0


def amplitudes(effect: type[Effect]) -> list[str]:
    """Parameters that are neutral somewhere, the one that is best known first.

    The first one's prior is that of the strength, by which all are scaled together.
    """
    priors = effect.priors()
    found = [key for key in effect.neutral if key in priors]
    return sorted(
        found, key=lambda key: priors[key].spread / abs(step_of(effect, key, priors[key]))
    )


def neutral_of(effect: type[Effect], key: str) -> float:
    """The value at which it changes nothing."""
    value: Any = effect.neutral[key]
    return float(np.ravel(value)[0])


def step_of(effect: type[Effect], key: str, prior: Prior) -> float:
    """From the neutral value to the ordinary one: the prior's mean, or one spread."""
    step = prior.mean - neutral_of(effect, key)
    return step if abs(step) > 1e-9 * prior.spread else prior.spread


def causes() -> dict[str, Cause]:
    """All causes that the generator hides, by name."""
    hidden = [each for each in EFFECTS if each.kind != NUMERICAL and each.name() not in NEVER]
    found = [_cause(effect) for effect in hidden]
    return {cause.name: cause for cause in found}


def strongest(effect: type[Effect]) -> float:
    """The largest strength that all bounds allow."""
    priors = effect.priors()
    found = []
    for key in amplitudes(effect):
        neutral, step = neutral_of(effect, key), step_of(effect, key, priors[key])
        found.append(max((bound - neutral) / step for bound in bounds_of(effect, key)))
    return min(found)


def _cause(effect: type[Effect]) -> Cause:
    key = amplitudes(effect)[0]
    prior = effect.priors()[key]
    neutral, step = neutral_of(effect, key), step_of(effect, key, prior)
    mean, spread = (prior.mean - neutral) / step, prior.spread / abs(step)
    one_sided = any(math.isclose(bound, neutral) for bound in bounds_of(effect, key))
    parts: tuple[float, ...] = ()
    if _needs_simulation(effect):
        if spread < CERTAIN:
            parts = (1.0,)
        elif mean:
            parts = (FEW[0], min(1 + FEW[1] * spread, strongest(effect)))
        else:
            parts = (-EITHER_WAY * spread, EITHER_WAY * spread)
    return Cause(effect, tuple(_forms(effect, parts)), mean, spread, one_sided)


def _needs_simulation(effect: type[Effect]) -> bool:
    name = effect.name()
    return name not in (*STAGES, *BY_SLOPE, DRIFT) and not effect.has("reading")


def _forms(effect: type[Effect], parts: tuple[float, ...]) -> list[Form]:
    """One spread below the middle of the prior of each other parameter, and one above."""
    keys = amplitudes(effect)
    free = {key: prior for key, prior in effect.priors().items() if key not in keys}
    felt = {key: prior for key, prior in free.items() if key not in ("raster_deg", "slip_mm")}
    wide = {key for key, prior in felt.items() if prior.spread > 0.1 * abs(prior.mean)}
    fixed = {key: prior.mean for key, prior in free.items() if key not in wide}
    if not wide:
        return [Form("", fixed, parts)]
    found = []
    for way in (-1.0, 1.0):
        values = {key: _away(free[key], way) for key in sorted(wide)}
        label = ", ".join(f"{key} = {value:.3g}" for key, value in values.items())
        found.append(Form(label, {**fixed, **values}, parts))
    return found


def _away(prior: Prior, spreads: float) -> float:
    """So many standard deviations from the prior's median."""
    if not prior.positive:
        return prior.mean + spreads * prior.spread
    variance = math.log1p((prior.spread / prior.mean) ** 2)
    return prior.mean * math.exp(-variance / 2 + spreads * math.sqrt(variance))


def analysed(protocol: Protocol) -> Config:
    """The model that is diagnosed: the reference finger, or the short one."""
    return configuration.load(None, list(protocol.finger))


def generating(protocol: Protocol, *, changes: bool = False) -> Config:
    """The generator's model of the same finger, as the laboratory has set it up.

    Args:
        protocol: that is followed.
        changes: on the mesh that tells what causes change, in place of the converged one.
    """
    mesh = MESHES[protocol.body]
    if not changes:
        mesh = CONVERGED.get(protocol.body, mesh)
    return configuration.load(
        None, [*protocol.finger, *SETTINGS, *mesh, f"plate.gap_mm={protocol.gap_mm}"]
    )
