"""The error of a run's readings that is due to its mesh.

Every cell is bisected, and the run's solution at a load is the start of one on these parts, which
tells by how much readings change. Bisected once more and so on, the changes fall by a constant
factor, so that the whole error is a multiple of the first one. Where stress at re-entrant
edges rules, the error of a reading falls with h^1.08 (twice the exponent 0.54 of the displacement
at an edge of 270°; Williams, J. Appl. Mech. 19, 1952).

From there the load rises on the bisected mesh, in a few large steps and up to the highest load of
the run, since parts of an error may have opposite signs and grow at different rates. The default
finger's blocked force is 1.3 % too large at 50 kPa and 1.1 % too small at 250 kPa. (That finger's
folds touch above 100 kPa: at 125 kPa the force is 0.1 % too large, and 0.8 % without their
contact.)

Between these loads the relative error is interpolated. Below them it is that at the nearest one,
and above them, where the bisected mesh did not get so far, too, which has to be tested: the line
through the relative errors at the last two goes on to the highest load. Where it leads to another
error there, the error cannot be told.

Prolonged to the parts of a cell, the solution has other strains than at the integration points of
the cell, where they are best, and Newton's method fails from there at moderate deformation already.
So it is first solved with the energies' expansions about these points
(:mod:`dolfingrip.mechanics.model.linearised`), and from there with the energies themselves.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import CHANNELS, PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.experiments.rigs.finger import build, element_name
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.regions import parts_of, sheets_of
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import MeshCheck
from dolfingrip.mechanics.model import linearised
from dolfingrip.mechanics.model.domain import distribute
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.nested import Nesting
from dolfingrip.mechanics.model.state import Guess, State
from dolfingrip.mechanics.model.term import Lagged
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.readings.reading import FromRest, Reading
from dolfingrip.meshes.bisection import bisected
from dolfingrip.meshes.solid import MeshError
from dolfingrip.sections.geometry.boxes import Cylinder, CylinderSolid


@dataclass(frozen=True, slots=True)
class MeshErrorPolicy:
    """Numbers of the estimate.

    Attributes:
        order: power of the element size that errors fall with.
        order_in_blocks: the same of thick blocks, which are integrated selectively: too stiff cells
            rule there.
        rtol: residual of both solutions on the bisected mesh, by that at their starts.
        iterations: of Newton's method, after which the two meshes have too little in common.
        largest: largest error of a reading, by the reading's largest value, that is told.
        parts: of the highest load at which the mesh is bisected, the next where one fails.
        loads: number of loads at which it is bisected where the load cannot rise from one.
        rises: parts of the highest load to which it rises on the bisected mesh.
        rises_to: residual there, by what the rise adds to it.
        rise_iterations: of Newton's method for one rise.
        change: largest factor, either way, between the relative error at the nearer load and that
            where the line through both leads to at the highest load.
    """

    order: float = 1.08
    order_in_blocks: float = 2.0
    rtol: float = 1e-2
    iterations: int = 8
    largest: float = 0.25
    parts: tuple[float, ...] = (0.5, 0.25, 0.1)
    loads: int = 2
    rises: tuple[float, ...] = (0.25, 0.5, 0.7, 0.85, 1.0)
    rises_to: float = 1e-4
    rise_iterations: int = 16
    change: float = 2.0

    def whole(self, config: Config) -> float:
        """The error by the change from one bisection, 1 + r + r² + … of that change.

        Args:
            config: of the run.
        """
        blocks = config.hexahedra and config.integration == "selective"
        return 1 / (1 - 2 ** -(self.order_in_blocks if blocks else self.order))


POLICY: Final = MeshErrorPolicy()


class CannotTell(Exception):
    """Why there is no estimate, in words."""


class Bisection:
    """A finger on the bisected mesh, about its states on the mesh itself.

    Args:
        rig: of a finger, on one rank.
        config: of the run.
        policy: limits.

    Raises:
        CannotTell: where the mesh or the model is of a kind that has no estimate.
        ConfigError: one line, where the bisected model does not fit into memory.
    """

    def __init__(self, rig: FingerRig, config: Config, policy: MeshErrorPolicy = POLICY) -> None:
        self._finger = finger = rig.specimen
        self._readings, self._model, self._policy = rig.readings, finger.model, policy
        _refuse(self._model)
        solid = undeformed.solid(config)
        if len(solid.cells) != self._model.domain.mesh.topology.index_map(3).size_global:
            raise CannotTell("the mesh was moved from that of other dimensions")
        try:
            fine = bisected(solid, _round_faces(config))
        except MeshError as error:
            raise CannotTell(str(error)) from None
        # stress and moduli have the effects on the material already, the state has the supply's
        plain = finger.config.model_copy(update={"extensions": Config().extensions})
        plain = plain.changed(solver={"mixed_integration_point": True})
        parts, sheets = parts_of(plain, fine), sheets_of(plain, fine)
        domain = distribute(self._model.comm, fine, parts, sheets)
        full = plain.integration != "reduced"
        self._expansions = linearised.of_model(self._model, full=full)
        self._fields = [linearised.fields(domain.mesh, each.degree) for each in self._expansions]
        energies = linearised.energies(self._fields)
        plate = finger.plate is not None
        self._start = build(plain, domain, plate=plate, energies=energies)
        self._fine = build(finger.config, domain, plate=plate)
        self._fine_readings = Observation(self._fine).readings
        loose = {"rtol": policy.rtol, "max_iterations": policy.iterations}
        settings = config.solver.model_copy(update=loose)
        self._first = Newton(self._start.model, settings)
        self._second = Newton(self._fine.model, settings)
        rising = {"rtol": policy.rises_to, "max_iterations": policy.rise_iterations}
        self._third = Newton(self._fine.model, config.solver.model_copy(update=rising))
        u, fine_u = self._model.u, self._start.model.u
        self._nesting = Nesting(solid.shape, element_name(plain, domain), u, fine_u)

    def changes(self, state: State) -> dict[str, float]:
        """By how much readings change at a state of the run, by column.

        Args:
            state: a solution.

        Returns:
            The changes from the mesh to the bisected one, in the columns' units.

        Raises:
            CannotTell: where the step is too long for a linear system.
        """
        self._put(state)
        self._take()
        start, fine = self._start.model, self._fine.model
        guess = Guess(start.unknowns.local(), start.carried.values)
        near = self._first.solve(guess, again=False).converged
        fine.u.x.array[:] = start.u.x.array
        if near and not state.history:  # what an effect remembers is in the expansion alone
            near = self._second.solve(again=False).converged
        if not near:
            raise CannotTell
        return self._read()

    def risen(self, state: State) -> dict[str, float]:
        """By how much readings change at a higher load than before, by column.

        Args:
            state: a solution of the run at that load.

        Returns:
            The changes from the mesh to the bisected one, in the columns' units.

        Raises:
            CannotTell: where the bisected mesh does not come to that load.
        """
        self._put(state)
        if not self._third.solve(again=False).converged:
            raise CannotTell
        return self._read()

    def _read(self) -> dict[str, float]:
        """Changes of readings from the run's state to that of the bisected mesh."""
        found = {}
        for name, reading in self._fine_readings.items():
            if name in CHANNELS and name in self._readings and reading.derived:
                found[name] = _raw(reading).value() - _raw(self._readings[name]).value()
        return found

    def _put(self, state: State) -> None:
        """Restore a state of the run, and its load on the bisected mesh, too."""
        self._model.restore(state)
        for each in (self._start, self._fine):
            each.cavity.set(self._finger.cavity.value)
            for name, own in self._finger.site.supplies.items():
                each.site.supplies[name].value = own.value
            if self._finger.plate is not None and each.plate is not None:
                each.plate.put(float(self._finger.plate.unloaded.value))

    def _take(self) -> None:
        """Take the run's state to the bisected mesh."""
        fine, carried = self._start.model, self._start.model.potential.carried
        fine.u.x.array[:] = (
            self._nesting.prolongation @ self._model.u.x.array.reshape(-1, 3)
        ).ravel()
        assert carried is not None
        carried.reset()
        held = [carried.stress, *carried.on_sheets]
        for of, into, stress in zip(self._expansions, self._fields, held, strict=False):
            found = of.values()
            for values, field in zip(found, into, strict=True):
                field.x.array[:] = self._nesting.nearest(values, of.degree).ravel()
            stress.x.array[:] = self._nesting.continued(found.stress, of.degree).ravel()


def _refuse(model: Model) -> None:
    """Refuse models that have no estimate."""
    if model.p is not None:
        raise CannotTell("it is not told of a mixed element")
    if model.unknowns.global_unknowns:
        raise CannotTell("it is not told where a support, the plate or the volume is solved for")
    if any(isinstance(term, Lagged) for term in model.terms):
        raise CannotTell("it is not told of friction")
    if model.comm.size > 1:
        raise CannotTell("it is told on one process only")


def _raw(reading: Reading) -> Reading:
    """A reading without its zero."""
    return reading.raw if isinstance(reading, FromRest) else reading


def _round_faces(config: Config) -> list[Cylinder]:
    """Cylinders that tetrahedra have only chords of."""
    if config.mesh.file is not None or config.hexahedra:
        return []
    solid = config.adapted().geometry.solid()
    if not isinstance(solid, CylinderSolid):
        return []
    return [*solid.cylinders, *(each for hollow in solid.cavities for each in hollow)]


def places(stops: Sequence[Stop], policy: MeshErrorPolicy = POLICY) -> list[int]:
    """Choose the stops whose states may be looked at.

    Args:
        stops: of the run.
        policy: which parts of the highest load.

    Returns:
        Numbers of the stops, the most wanted first: those of ``parts``, then those of ``rises``.
    """
    values = np.array([stop.value for stop in stops])
    highest = int(np.abs(values).argmax())
    left = [int(each) for each in np.flatnonzero(values[: highest + 1])]
    found: list[int] = []
    for part in policy.parts[: len(left)]:
        some = [each for each in left if each not in found]
        found.append(min(some, key=lambda each: abs(values[each] - part * values[highest])))
    for part in policy.rises if left else ():
        found.append(min(left, key=lambda each: abs(values[each] - part * values[highest])))
    return list(dict.fromkeys(found))


def estimate(
    rig: Rig,
    config: Config,
    states: Sequence[tuple[int, State]],
    result: Readings,
    policy: MeshErrorPolicy = POLICY,
) -> MeshCheck:
    """Estimate the error of all readings of a run.

    Args:
        rig: of the run, which has come to its end.
        config: of the run.
        states: rows and states that may be looked at, the most wanted first.
        result: of the run.
        policy: limits.

    Returns:
        Errors by column at all rows, or why they cannot be told.
    """
    start = time.perf_counter()
    changes: dict[int, dict[str, float]] = {}
    why = "no reading was reached at which it is looked at"
    try:
        if not isinstance(rig, FingerRig):
            raise CannotTell("it is told of fingers that bend or press alone")
        bisection = Bisection(rig, config) if states else None
        for row, state in states[: len(policy.parts)]:
            assert bisection is not None
            with suppress(CannotTell):
                changes[row] = bisection.changes(state)
                for above, higher in sorted(states, key=lambda each: each[0]):
                    if above > row and not state.history:
                        changes[above] = bisection.risen(higher)
            if len(changes) >= policy.loads:
                break
            why = "the mesh is too coarse: on the bisected one the shape is another"
    except (CannotTell, ConfigError) as reason:
        why = str(reason)
    errors: dict[str, tuple[float, ...]] = {}
    reasons: dict[str, str] = {}
    rows = sorted(changes)
    for name in changes[rows[0]] if rows else ():
        found = -policy.whole(config) * np.array([changes[row][name] for row in rows])
        if name not in result or not found.any():
            continue
        try:
            errors[name] = tuple(map(float, at_all_loads(name, rows, found, result, policy)))
        except CannotTell as reason:
            reasons[name] = str(reason)
    at = tuple(float(result.column(PRESSURE.name)[row]) for row in rows)
    return MeshCheck(
        at=at, errors=errors, why="" if changes else why, reasons=reasons,
        wall_s=round(time.perf_counter() - start, 3),
    )  # fmt: skip


def at_all_loads(
    name: str,
    rows: Sequence[int],
    found: np.ndarray,
    result: Readings,
    policy: MeshErrorPolicy = POLICY,
) -> np.ndarray:
    """Tell the errors of a reading at all rows from those at one row or two.

    Args:
        name: of the reading's column.
        rows: whose error was found, in order.
        found: (rows found,) errors there, in the column's unit.
        result: of the run.
        policy: limits.

    Returns:
        (rows,) errors in the column's unit.

    Raises:
        CannotTell: where the error is too large, or does not grow with the reading.
    """
    values, loads = result.column(name), result.column(PRESSURE.name)
    grows = CHANNELS[name].grows
    size = np.abs(values[rows]) if grows else np.nanmax(np.abs(values[: rows[-1] + 1]))
    if (np.abs(found) >= policy.largest * size).any():
        raise CannotTell(f"the mesh is too coarse: its error is above {100 * policy.largest:g} %")
    along = values if grows else loads
    relative, at, loads = found / along[rows], np.abs(loads[rows]), np.abs(loads)
    if at[-1] < loads.max():
        if len(at) == 1:
            raise CannotTell(f"it is found at {at[0]:g} kPa alone, which does not show its growth")
        slope = (relative[-1] - relative[-2]) / (at[-1] - at[-2])
        end = relative[-1] + slope * (loads.max() - at[-1])
        near, end = abs(relative[-1]), end * np.sign(relative[-1])
        if not near / policy.change <= end <= near * policy.change:
            raise CannotTell(
                f"its error is {100 * relative[-2]:+.2g} % of the reading at {at[-2]:g} kPa and "
                f"{100 * relative[-1]:+.2g} % at {at[-1]:g} kPa, which do not tell that at "
                f"{loads.max():g} kPa"
            )
    return np.asarray(np.interp(loads, at, relative) * along)
