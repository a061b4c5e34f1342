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
"""Largest number of Newton's iterations."""

TOLERANCE: Final = 1e-7
"""Newton's step of λ_t below which it is found; the step is still taken."""

LARGEST_CHANGE: Final = 0.05
"""Largest change of λ_t in one iteration, and in one load step beyond the change of λ."""

NUDGE: Final = 1e-6
"""Change of λ_t by which derivatives are taken."""


@dataclass(frozen=True, slots=True)
class Stretched:
    """Stress and width of the bars at the stops.

    Attributes:
        stress_MPa: nominal stress F/A, shape (bars, stops); NaN from where no equilibrium is found.
        across: stretch λ_t across the bar, shape (bars, stops); NaN likewise.
    """

    stress_MPa: np.ndarray
    across: np.ndarray


@dataclass(frozen=True, slots=True)
class Stretching:
    """A protocol of a bar.

    Attributes:
        strain: nominal strain at each stop.
        time_s: time of each stop.
        longest: largest change of strain in one load step.
        cycle: number of the cycle of each stop; (): the first one all along.
    """

    strain: Sequence[float]
    time_s: Sequence[float]
    longest: float
    cycle: Sequence[float] = ()

    def load_steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """λ, time and cycle at each load step's end, (load steps,), and which end at the stops."""
        moves = np.abs(np.diff(self.strain, prepend=0.0))
        ends = np.cumsum(np.maximum(np.ceil(moves / self.longest - 1e-9), 1)).astype(int)
        number, at = np.arange(1, ends[-1] + 1), [0, *ends]
        along = 1 + np.interp(number, at, [0.0, *self.strain])
        clocks = self.time_s, self.cycle or [1.0] * len(self.strain)
        time_s, cycle = (np.interp(number, at, [row[0], *row]) for row in clocks)
        return along, time_s, cycle, ends - 1


class UniaxialTension:
    """Bars of one material whose effects have other parameters in each.

    Args:
        config: material and effects; parameters that :meth:`follow` is not given stay as here.

    Raises:
        ValueError: the material differs between the directions across the bar.
    """

    def __init__(self, config: Config) -> None:
        for on in config.extensions.active():
            if on.shears_bars:
                raise ValueError(f"{on.shears_bars}: a bar that is pulled shears; allowed: 0")
        self._along, self._across = ufl.Constant(SOLID), ufl.Constant(SOLID)
        self._poisson = config.material.poisson
        base = BaseMaterial.on(SOLID, config.material)
        self._fixed = {
            made: evaluate_many.constant(made.value) for made in (*base.constants.values(),)
        }
        sides = [(stretch**2 - 1) / 2 for stretch in (self._across, self._across, self._along)]
        strain = strain_variable(
            ufl.as_matrix([[sides[i] if i == j else 0 for j in range(3)] for i in range(3)])
        )
        self._history = history = _InternalVariables()
        clock = history.time_s, history.step_s, history.cycle
        self._site = _Point(config, strain, base.mu, base.lmbda, *clock, history)
        density = config.extensions.strain_energy(base.energy, cast(Site, self._site))(strain)
        self._energy = Evaluation([density])
        self._ends = Evaluation([end for _, end in history.ends])

    def follow(
        self, parameters: Mapping[str, np.ndarray], protocols: Sequence[Stretching]
    ) -> list[Stretched]:
        """Follow several protocols, each from rest, all at once.

        Args:
            parameters: (bars,) or (bars, entries) by key of the configuration.
            protocols: one or more.

        Raises:
            KeyError: a key belongs to no effect that is on.
        """
        bars = max((len(values) for values in parameters.values()), default=1)
        given = {
            made: np.tile(value, len(protocols)) if value.shape[-1] > 1 else value
            for made, value in {**self._fixed, **self._site.values(parameters)}.items()
        }
        load_steps = [protocol.load_steps() for protocol in protocols]
        count = max(len(along) for along, *_ in load_steps)
        # shorter protocols stay at their ends
        along, clock, cycle = (
            np.column_stack([np.pad(steps[i], (0, count - len(steps[i])), "edge")
                             for steps in load_steps]).repeat(bars, axis=1)
            for i in (0, 1, 2)
        )  # fmt: skip
        start = np.repeat([protocol.time_s[0] for protocol in protocols], bars)
        steps = _LoadSteps(along, clock, np.diff(clock, prepend=[start], axis=0), cycle)
        with np.errstate(all="ignore"):  # bars without equilibrium
            across, axial = self._equilibrium(given, steps)
        lost = steps.lost(across, np.isfinite(axial))
        stress, width = np.where(lost, np.nan, axial), np.where(lost, np.nan, across)
        return [
            Stretched(
                stress[stops, place * bars : (place + 1) * bars].T,
                width[stops, place * bars : (place + 1) * bars].T,
            )
            for place, (*_, stops) in enumerate(load_steps)
        ]

    def _equilibrium(
        self, given: Mapping[Expr, np.ndarray], steps: _LoadSteps
    ) -> tuple[np.ndarray, np.ndarray]:
        """λ_t without stress across, and ∂ψ/∂λ there (MPa), shape (load steps, bars) each.

        All load steps are solved together by Newton's method. Internal variables follow from the
        stretches of the iteration before (waveform relaxation: Lelarasmee, Ruehli &
        Sangiovanni-Vincentelli, IEEE Trans. Comput.-Aided Des. 1, 1982). A load step is exact at
        the latest when those before it are.

        Args:
            given: values of the parameters.
            steps: λ and the times.
        """
        shape = steps.along.shape
        # the sets: λ_t and λ_t beside it, by load step, by bar
        symbols = {
            made: np.tile(value, 2 * shape[0]) if value.shape[-1] > 1 else value
            for made, value in given.items()
        }
        symbols[self._along] = evaluate_many.variable(np.tile(steps.along.ravel(), 2), 1)
        for made, value in self._history.moments(steps.time_s, steps.step_s, steps.cycle):
            symbols[made] = evaluate_many.constant(np.tile(value.ravel(), 2), by_set=True)
        # no thinner than the bar, so that the first root is that of the branch from rest
        across = steps.along**-self._poisson
        for _ in range(ITERATIONS):
            symbols |= self._remembered(given, steps, across)
            beside = np.concatenate([across.ravel(), across.ravel() + NUDGE])
            symbols[self._across] = evaluate_many.variable(beside, 0)
            (energy,) = self._energy(symbols)
            (residual, moved), (axial, moved_axial) = energy[1:].reshape(2, 2, *shape)
            slope = (moved - residual) / NUDGE
            step = np.where(slope > 0, -residual / slope, -np.sign(residual))
            step = np.clip(step, -LARGEST_CHANGE, LARGEST_CHANGE)
            axial = axial + step * (moved_axial - axial) / NUDGE
            across = across + step
            settled = np.abs(step) <= TOLERANCE
            # what is lost for good holds the others up no more
            lost = steps.lost(np.where(settled, across, np.nan), ~np.isnan(across))
            if (settled | lost).all():
                break
        return across, np.where(settled, axial, np.nan)

    def _remembered(
        self, given: Mapping[Expr, np.ndarray], steps: _LoadSteps, across: np.ndarray
    ) -> dict[Expr, np.ndarray]:
        """Internal variables at the start of each load step, twice, as the sets are ordered."""
        if not self._history.ends:
            return {}
        symbols = {**given}
        here = {
            made: np.repeat(evaluate_many.constant(start), across.shape[1], axis=-1)
            for made, start in self._history.starts.items()
        }
        starts: dict[Expr, list[np.ndarray]] = {made: [] for made in here}
        rows = steps.along, across, steps.time_s, steps.step_s, steps.cycle
        for along, thin, *moment in zip(*rows, strict=True):
            for made, value in here.items():
                starts[made].append(value)
            symbols |= here
            symbols[self._along] = evaluate_many.variable(along, 1)
            symbols[self._across] = evaluate_many.variable(thin, 0)
            for made, value in self._history.moments(*moment):
                symbols[made] = evaluate_many.constant(value, by_set=True)
            ends = self._ends(symbols)
            here = {}
            for (variable, _), value in zip(self._history.ends, ends, strict=True):
                here[variable] = np.zeros_like(value)
                here[variable][..., 0, :] = value[..., 0, :]
        return {
            made: np.concatenate([*values, *values], axis=-1) for made, values in starts.items()
        }


@dataclass(frozen=True, slots=True)
class _LoadSteps:
    """Stretch along each bar, time at its end, duration and cycle, (load steps, bars) each."""

    along: np.ndarray
    time_s: np.ndarray
    step_s: np.ndarray
    cycle: np.ndarray

    def lost(self, across: np.ndarray, solved: np.ndarray) -> np.ndarray:
        """Tell from which load step on a bar has no equilibrium.

        Beyond a limit point the next root is of another branch, which rounding chooses. NaN in λ_t
        is no jump.
        """
        move = np.abs(np.diff(self.along, prepend=1.0, axis=0))
        jumps = np.abs(np.diff(across, prepend=1.0, axis=0)) > move + LARGEST_CHANGE
        return np.asarray(np.logical_or.accumulate(jumps | ~solved, axis=0))


class _InternalVariables:
    """Internal variables as symbols, with their values at a load step's end."""

    def __init__(self) -> None:
        self.time_s, self.step_s, self.cycle = (ufl.Constant(SOLID) for _ in range(3))
        self.starts: dict[Expr, np.ndarray] = {}
        self.ends: list[tuple[Expr, Expr]] = []

    def moments(self, *values: np.ndarray) -> list[tuple[Expr, np.ndarray]]:
        """Time, step and cycle as symbols, with their values."""
        return list(zip((self.time_s, self.step_s, self.cycle), values, strict=True))

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
    cycle: Expr
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
