"""Uniaxial tension of many bars at once, each with other parameters of the same effects.

A bar between sliding grips stretches evenly, so its state is two stretches: λ along the bar, which
the crosshead prescribes, and λ_t across it, which leaves the sides free of stress:

    ∂ψ/∂λ_t = 0,   F = A ∂ψ/∂λ,   E = diag(λ_t² − 1, λ_t² − 1, λ² − 1)/2

ψ is the energy of the finite-element model, with its internal variables and load steps. The bars
need no mesh: see :mod:`dolfingrip.forms.evaluate_many`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, cast

import numpy as np
import ufl
from ufl.core.expr import Expr

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.materials import BaseMaterial
from dolfingrip.extensions.site import Named, Site
from dolfingrip.forms import evaluate_many
from dolfingrip.forms.chain_rule import strain_variable
from dolfingrip.forms.evaluate_many import SOLID, Evaluation

ITERATIONS: Final = 60
"""Largest number of iterations of the secant method."""

TOLERANCE: Final = 1e-7
"""Change of λ_t from one iteration to the next below which it is found: the next one is of 1e-9."""

ACCEPTED: Final = 1e-6
"""Largest last change of λ_t of a bar that counts as solved."""

LARGEST_CHANGE: Final = 0.05
"""Largest change of λ_t in one iteration, and in one load step beyond the change of λ."""

NUDGE: Final = 1e-6
"""Change of λ_t that the first slope is taken by, at rest."""


@dataclass(frozen=True, slots=True)
class Stretched:
    """Stress and width of the bars at the stops.

    Attributes:
        stress_MPa: nominal stress F/A, shape (bars, stops); NaN from where no equilibrium is found.
        across: stretch λ_t across the bar, shape (bars, stops); NaN likewise.
    """

    stress_MPa: np.ndarray
    across: np.ndarray


class UniaxialTension:
    """Bars of one material whose effects have other parameters in each.

    Args:
        config: material and effects; parameters that :meth:`pull` is not given stay as here.

    Raises:
        ValueError: the material differs between the directions across the bar.
    """

    def __init__(self, config: Config) -> None:
        for on in config.extensions.active():
            if on.shears_bars:
                raise ValueError(f"{on.shears_bars}: a bar that is pulled shears; allowed: 0")
        self._along, self._across = ufl.Constant(SOLID), ufl.Constant(SOLID)
        base = BaseMaterial.on(SOLID, config.material)
        self._fixed = {
            made: evaluate_many.constant(made.value) for made in (*base.constants.values(),)
        }
        sides = [(stretch**2 - 1) / 2 for stretch in (self._across, self._across, self._along)]
        strain = strain_variable(
            ufl.as_matrix([[sides[i] if i == j else 0 for j in range(3)] for i in range(3)])
        )
        self._history = history = _InternalVariables()
        clock = history.time_s, history.step_s
        self._site = _Point(config, strain, base.mu, base.lmbda, *clock, history)
        density = config.extensions.strain_energy(base.energy, cast(Site, self._site))(strain)
        self._energy = Evaluation([density])
        self._ends = Evaluation([end for _, end in history.ends])

    def pull(
        self,
        parameters: Mapping[str, np.ndarray],
        strain: Sequence[float],
        time_s: Sequence[float],
        longest: float,
    ) -> Stretched:
        """Follow a protocol from rest.

        Args:
            parameters: (bars,) or (bars, entries) by key of the configuration.
            strain: nominal strain at each stop.
            time_s: time of each stop.
            longest: largest change of strain in one load step.

        Raises:
            KeyError: a key belongs to no effect that is on.
        """
        symbols = {**self._fixed, **self._site.values(parameters)}
        bars = max((len(values) for values in parameters.values()), default=1)
        symbols |= {
            made: evaluate_many.constant(start) for made, start in self._history.starts.items()
        }
        across: np.ndarray = np.ones(bars)
        ahead, steepness = np.zeros(bars), None
        stress, width = [], []
        before, clock = 0.0, float(time_s[0])
        for here, now in zip(strain, time_s, strict=True):
            steps = max(int(np.ceil(abs(here - before) / longest - 1e-9)), 1)
            for step in range(1, steps + 1):
                part = step / steps
                symbols[self._history.time_s] = evaluate_many.constant(clock + part * (now - clock))
                symbols[self._history.step_s] = evaluate_many.constant((now - clock) / steps)
                along = 1 + before + part * (here - before)
                move = (here - before) / steps
                last = across
                # the sides go on as in the step before
                across, slope, steepness = self._equilibrium(
                    symbols, along, last + ahead * move, steepness
                )
                # beyond a limit point the next root is of another branch, which rounding chooses
                stays = np.isfinite(slope) & (np.abs(across - last) <= abs(move) + LARGEST_CHANGE)
                # a bar without equilibrium is lost, and holds the others up no more
                slope, across = np.where(stays, slope, np.nan), np.where(stays, across, np.nan)
                ahead = (across - last) / move if move else ahead
                self._accept(symbols, along, across)
            before, clock = float(here), float(now)
            stress.append(np.broadcast_to(slope, (bars,)))
            width.append(across)
        return Stretched(np.column_stack(stress), np.column_stack(width))

    def _equilibrium(
        self,
        symbols: dict[Expr, np.ndarray],
        along: float,
        guess: np.ndarray,
        slope: np.ndarray | None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """λ_t without stress across, ∂ψ/∂λ there (MPa), and the slope of the stress across there.

        Args:
            symbols: values of all symbols but the stretches.
            along: λ.
            guess: of λ_t, shape (bars,).
            slope: of the stress across by λ_t in the step before; None at rest.
        """
        across = guess
        residual, _ = self._at(symbols, along, across)
        if slope is None:
            beside, _ = self._at(symbols, along, across + NUDGE)
            slope = (beside - residual) / NUDGE
        for _ in range(ITERATIONS):
            with np.errstate(all="ignore"):
                step = np.clip(-residual / slope, -LARGEST_CHANGE, LARGEST_CHANGE)
            changed, axial = self._at(symbols, along, across + step)
            with np.errstate(all="ignore"):
                secant = (changed - residual) / step
            usable = np.isfinite(secant) & (secant > 0) & (np.abs(step) > TOLERANCE)
            slope = np.where(usable, secant, slope)
            across, residual = across + step, changed
            if not (np.abs(step) > TOLERANCE).any():
                break
        solved = np.abs(step) <= ACCEPTED
        return across, np.where(solved, axial, np.nan), slope

    def _at(
        self, symbols: dict[Expr, np.ndarray], along: float, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """∂ψ/∂λ_t and ∂ψ/∂λ (MPa) of each bar."""
        (energy,) = self._energy(self._stretched(symbols, along, across))
        return energy[1], energy[2]

    def _accept(self, symbols: dict[Expr, np.ndarray], along: float, across: np.ndarray) -> None:
        """Give the internal variables their values at the step's end, all at once."""
        ends = self._ends(self._stretched(symbols, along, across))
        for (variable, _), value in zip(self._history.ends, ends, strict=True):
            at_end = np.zeros_like(value)
            at_end[..., 0, :] = value[..., 0, :]
            symbols[variable] = at_end

    def _stretched(
        self, symbols: dict[Expr, np.ndarray], along: float, across: np.ndarray
    ) -> dict[Expr, np.ndarray]:
        symbols[self._across] = evaluate_many.variable(across, 0)
        symbols[self._along] = evaluate_many.variable(np.full(1, along), 1)
        return symbols


class _InternalVariables:
    """Internal variables as symbols, with their values at a load step's end."""

    def __init__(self) -> None:
        self.time_s, self.step_s = ufl.Constant(SOLID), ufl.Constant(SOLID)
        self.starts: dict[Expr, np.ndarray] = {}
        self.ends: list[tuple[Expr, Expr]] = []

    def variable(self, initial: np.ndarray | float) -> Expr:
        start = np.asarray(initial, dtype=float)
        made = ufl.Constant(SOLID, start.shape)
        self.starts[made] = start
        return made

    def evolve(self, variable: Expr, end: Expr) -> None:
        self.ends.append((variable, end))


@dataclass(slots=True)
class _Point:
    """A bar as energies see it: :class:`Site` without a mesh."""

    config: Config
    strain: Expr
    mu: Expr
    lmbda: Expr
    time_s: Expr
    step_s: Expr
    history: _InternalVariables
    parameters: dict[str, tuple[Expr, np.ndarray]] = field(default_factory=dict)

    def constant(self, effect: Named, key: str) -> Expr:
        value = np.asarray(getattr(effect, key), dtype=float)
        made = ufl.Constant(SOLID, value.shape)
        self.parameters[f"extensions.{effect.name()}.{key}"] = made, value
        return made

    def remember(self, effect: Named, name: str, initial: np.ndarray | float) -> Expr:
        return self.history.variable(initial)

    def values(self, given: Mapping[str, np.ndarray]) -> dict[Expr, np.ndarray]:
        """Values of all parameters, those of ``given`` for each bar."""
        symbols = {made: evaluate_many.constant(value) for made, value in self.parameters.values()}
        for key, values in given.items():
            made, usual = self.parameters[key]
            table = np.reshape(np.asarray(values, dtype=float), (len(values), *usual.shape))
            symbols[made] = evaluate_many.constant(np.moveaxis(table, 0, -1), by_set=True)
        return symbols
