"""The error of a run's readings that is due to its mesh.

At a few states of the run every cell is bisected, and one linear system tells by how much readings
change there: Newton's first step from the run's solution. Bisected once more and so on, the changes
fall by a constant factor, so that the whole error is a multiple of the first one. Stress at re-entrant
edges rules the order: there the error of a reading falls with h^1.08 (twice the exponent 0.54 of the
displacement at an edge of 270°; Williams, J. Appl. Mech. 19, 1952).

Prolonged to the parts of a cell, the solution has other strains than at the integration points of
the cell, where they are best. So strain, stress and moduli of the parts are continued from these
points (:mod:`dolfingrip.mechanics.model.linearised`); otherwise the step fails from moderate
deformation on. Contact and all that elements do not integrate keep their points.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.protocol.schedule import Stop
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.experiments.rigs.finger import FingerModel, build, element_name
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.experiments.rigs.regions import sheets_of
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import MeshCheck
from dolfingrip.mechanics.model import linearised
from dolfingrip.mechanics.model.domain import distribute
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.nested import Nesting, Unrefined
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes.bisection import bisected
from dolfingrip.meshes.solid import MeshError
from dolfingrip.sections.geometry.boxes import CylinderSolid


@dataclass(frozen=True, slots=True)
class MeshErrorPolicy:
    """Numbers of the estimate.

    Attributes:
        order: power of the element size that errors fall with.
        left: largest residual of the elements after the step, by that before it. Above, the step is
            too long for a linear system to tell it.
        largest: largest error of a reading, by the reading's largest value, that is told.
        share: part of the run's time that a second state may take the estimate to.
    """

    order: float = 1.08
    left: float = 0.1
    largest: float = 0.15
    share: float = 0.25

    @property
    def whole(self) -> float:
        """The error by the change from bisection to bisection, 1 + r + r² + …"""
        return 1 / (1 - 2**-self.order)


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
        finger: FingerModel = rig.specimen
        self._rig, self._model, self._policy = rig, finger.model, policy
        self._pressure = finger.cavity
        if self._model.p is not None:
            raise CannotTell("not for a mixed element")
        if self._model.unknowns.global_unknowns:
            raise CannotTell("not where a support, the plate or the volume is solved for")
        if self._model.comm.size > 1:
            raise CannotTell("on one process only")
        adapted = finger.config.model_copy(
            update={"extensions": type(finger.config.extensions)()}
        ).changed(solver={"mixed_integration_point": True}, contact={"self_contact": False})
        solid = undeformed.solid(config, None)
        if len(solid.cells) != finger.site.domain.mesh.topology.index_map(3).size_global:
            raise CannotTell("the mesh was moved from that of other dimensions")
        try:
            fine = bisected(solid, _round_faces(config))
        except MeshError as error:
            raise CannotTell(str(error)) from None
        domain = distribute(self._model.comm, fine, None, sheets_of(adapted, fine))
        full = adapted.integration != "reduced"
        self._expansions = linearised.of_model(self._model, full=full)
        self._fields = [
            linearised.fields(domain.mesh, each.degree) for each in self._expansions
        ]
        built = build(adapted, domain, plate=False, energies=linearised.energies(self._fields))
        made = built.by_pressure
        self._nesting = Nesting(
            solid.shape, element_name(adapted, domain), self._model.u, made.u
        )
        self._unrefined = Unrefined(self._model, self._nesting.same)
        self._fine_pressure = built.cavity
        self._fine = Model(
            made.domain, made.u, made.potential, made.supports, made.controls, [self._unrefined]
        )
        self._newton = Newton(self._fine, config.solver)

    def changes(self, state: State) -> dict[str, float]:
        """By how much readings change at a state of the run, by column.

        Args:
            state: a solution.

        Returns:
            The changes from the mesh to the bisected one, in the columns' units.

        Raises:
            CannotTell: where the step is too long for a linear system.
        """
        model, fine = self._model, self._fine
        model.restore(state)
        self._fine_pressure.set(self._pressure.value)
        nodes = model.u.x.array.reshape(-1, 3)
        fine.u.x.array[:] = (self._nesting.prolongation @ nodes).ravel()
        self._unrefined.take(fine.u.x.array)
        carried = fine.potential.carried
        assert carried is not None
        carried.reset()
        for place, (of, into) in enumerate(zip(self._expansions, self._fields, strict=True)):
            for values, field in zip(of.values(), into, strict=True):
                field.x.array[:] = self._nesting.to_parts(values, of.degree).ravel()
            held = carried.stress if place == 0 else carried.on_sheets[place - 1]
            held.x.array[:] = into.stress.x.array
        residual = fine.gradient()
        step = self._newton.linear(carried.values)(-residual)
        fine.u.x.array[:] += step
        left = np.linalg.norm(fine.gradient()) / np.linalg.norm(residual)
        before = self._read()
        model.u.x.array[:] += step.reshape(-1, 3)[self._nesting.same].ravel()
        after = self._read()
        model.restore(state)
        if not left < self._policy.left:
            raise CannotTell("the mesh is too coarse: on the bisected one the shape is another")
        return {name: after[name] - value for name, value in before.items()}

    def _read(self) -> dict[str, float]:
        found = {name: each.value() for name, each in self._rig.readings.items()}
        return {name: value for name, value in found.items() if np.isfinite(value)}


def _round_faces(config: Config) -> list:
    if config.mesh.file is not None or config.hexahedra:
        return []
    solid = config.adapted().geometry.solid()
    if not isinstance(solid, CylinderSolid):
        return []
    return [*solid.cylinders, *(each for hollow in solid.cavities for each in hollow)]


def places(stops: Sequence[Stop]) -> list[int]:
    """Choose the stops whose states are looked at.

    Args:
        stops: of the run.

    Returns:
        Numbers of the stops: the highest load, then that at half of it or the lowest.
    """
    values = np.array([stop.value for stop in stops])
    first = int(np.abs(values).argmax())
    rest = values[: first + 1] if np.ptp(np.sign(values)) < 2 else values
    wanted = values[first] / 2 if rest is not values else -values[first]
    second = int(np.abs(rest - wanted).argmin())
    return list(dict.fromkeys(each for each in (first, second) if values[each]))


def estimate(
    rig: Rig,
    config: Config,
    states: Sequence[tuple[float, State]],
    result: Readings,
    wall_s: float,
    policy: MeshErrorPolicy = POLICY,
) -> MeshCheck:
    """Estimate the error of all readings of a run.

    Args:
        rig: of the run, which has come to its end.
        config: of the run.
        states: loads and states that are looked at, the most wanted first.
        result: of the run.
        wall_s: time that the run took.
        policy: limits.

    Returns:
        Errors by column at all rows, or why they cannot be told.
    """
    start = time.perf_counter()
    at: list[float] = []
    changes: list[dict[str, float]] = []
    why = "" if states else "no reading was reached at which it is looked at"
    try:
        if not isinstance(rig, FingerRig):
            raise CannotTell("not for this specimen")
        bisection = Bisection(rig, config, policy) if states else None
        for load, state in states:
            assert bisection is not None
            before = time.perf_counter()
            try:
                changes.append(bisection.changes(state))
                at.append(load)
            except CannotTell as reason:
                why = str(reason)
                continue
            took = time.perf_counter() - before
            if time.perf_counter() + took - start > policy.share * wall_s:
                break
    except (CannotTell, ConfigError) as reason:
        why = str(reason)
    errors: dict[str, tuple[float, ...]] = {}
    for name in sorted(set.intersection(*map(set, changes)) if changes else ()):
        if name not in result:
            continue
        own = -policy.whole * np.array([change[name] for change in changes])
        column = _along(result.column(PRESSURE.name), np.array(at), own)
        size = float(np.nanmax(np.abs(result.column(name))))
        if not own.any():
            continue
        if np.abs(own).max() > policy.largest * size:
            why = why or "the mesh is too coarse: its error is larger than an estimate may tell"
            continue
        errors[name] = tuple(map(float, column))
    return MeshCheck(
        at=tuple(at), errors=errors, why="" if errors else why,
        wall_s=round(time.perf_counter() - start, 3),
    )  # fmt: skip


def _along(loads: np.ndarray, at: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Errors at loads, from those at some of them: a parabola or a line through the origin."""
    powers = np.arange(1, len(at) + 1)
    return np.asarray((loads[:, None] ** powers) @ np.linalg.solve(at[:, None] ** powers, errors))
