"""Derivatives of a finger's readings at its present state by any number of parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Final

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.finger_rig import at_rest, has_weight, put_at_rest
from dolfingrip.experiments.rigs.perturbation import perturbations, velocities
from dolfingrip.experiments.rigs.undeformed import unplaced
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.shape_gradient import Coordinates, ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.readings.plate import PlatePlace
from dolfingrip.mechanics.readings.reading import FromRest, Reading
from dolfingrip.mechanics.sensitivity.adjoint import Adjoint, ShapeDerivative
from dolfingrip.mechanics.sensitivity.forward import ForwardSensitivity
from dolfingrip.mechanics.sensitivity.repeated_step import Perturbation
from dolfingrip.parameter import Entry, Parameter

PLACE: Final = "plate_place_mm"
"""Name of the plate's place among what is derived at rest."""


class _PlateMoved:
    """The plate's place as a parameter (mm along its normal)."""

    scale: float = 1.0
    direction: float = 1.0

    def __init__(self, plate: RigidPlate) -> None:
        self._plate = plate

    @contextmanager
    def applied(self, amount: float) -> Iterator[None]:
        place = float(self._plate.unloaded.value)
        stands = float(self._plate.offset.value)
        self._plate.put(place + amount)
        try:
            yield
        finally:
            self._plate.put(place)
            self._plate.offset.value = stands


class FingerAdjoints:
    """Derivatives of some readings of a finger at a solution: one linear solve for each.

    The tangent is factorised once. A reading that counts from rest, and the gap from which the
    plate stands, depend on the state at rest too, whose derivatives are taken there.

    Args:
        finger: at a solution.
        readings: to derive; each may count from rest.
        newton: solver of the finger's model, whose elimination order and pattern serve again;
            default: a new one.

    Raises:
        HasHistory: one line, where the state remembers earlier ones.
    """

    def __init__(
        self, finger: FingerModel, readings: Sequence[Reading], newton: Newton | None = None
    ) -> None:
        self._finger = finger
        self._readings = {reading.column: reading for reading in readings}
        model = finger.model
        solve = (newton or Newton(model, finger.config.solver)).linear()
        self._adjoints = {
            # a reading without its zero
            name: Adjoint(model, lambda: solve, one.raw if isinstance(one, FromRest) else one)
            for name, one in self._readings.items()
        }

    # -- by all coordinates ----------------------------------------------------------------------

    @cached_property
    def coordinates(self) -> Coordinates:
        """Coordinates of the finger's mesh."""
        return Coordinates(self._finger.model.u.function_space)

    @cached_property
    def by_coordinates(self) -> dict[str, ShapeDerivative]:
        """Derivatives by all coordinates of the undeformed mesh, by column.

        Raises:
            NoShapeGradient: one line, where a term or a reading has none.
        """
        if self._finger.site.geometric:
            raise NoShapeGradient("effects that measure the mesh: no derivative by coordinates")
        resting = self._rest_by_coordinates()
        by_column = {}
        for name, adjoint in self._adjoints.items():
            here = adjoint.by_coordinates(self.coordinates)
            if isinstance(self._readings[name], FromRest):
                here = here.plus(resting[name], -1.0)
            if PLACE in resting:
                here = here.plus(resting[PLACE], self._by_place[name])
            by_column[name] = here
        return by_column

    @cached_property
    def _by_place(self) -> dict[str, float]:
        """Derivatives by the plate's place (for each mm), by column."""
        plate = self._finger.plate
        assert plate is not None
        return self.derivatives(_PlateMoved(plate))

    def derivatives(self, perturbation: Perturbation) -> dict[str, float]:
        """Derivatives by a parameter that the state at rest does not depend on, by column."""
        return {name: adjoint.derivative(perturbation) for name, adjoint in self._adjoints.items()}

    def _counted(self) -> list[Reading]:
        """List what depends on the state at rest: readings that count from there, and the plate."""
        plate = self._finger.plate
        raw = [reading.raw for reading in self._readings.values() if isinstance(reading, FromRest)]
        return raw if plate is None else [*raw, PlatePlace(self._finger.model, plate)]

    def _rest_by_coordinates(self) -> dict[str, ShapeDerivative]:
        """Derivatives at rest of :meth:`_counted`, by column."""
        finger, counted = self._finger, self._counted()
        with at_rest(finger):
            if not has_weight(finger):  # it stays undeformed, whatever its shape
                return {reading.column: self._partial(reading) for reading in counted}
            model = finger.by_pressure
            solve = Newton(model, finger.config.solver).linear()
            return {
                reading.column: Adjoint(model, lambda: solve, reading).by_coordinates(
                    self.coordinates
                )
                for reading in counted
            }

    def _partial(self, reading: Reading) -> ShapeDerivative:
        """Derivatives by coordinates at fixed unknowns."""
        gradient = ShapeGradient(self.coordinates)
        reading.add_shape_gradient(gradient)
        return ShapeDerivative(self.coordinates, gradient.owned)

    # -- by parameters ---------------------------------------------------------------------------

    def by_parameters(
        self, config: Config, parameters: Sequence[Parameter]
    ) -> dict[str, dict[str, float]]:
        """Derivatives by parameters, by column and by key.

        Parameters of the mesh follow from the derivatives by coordinates by the chain rule. Others,
        and all where there are none of these, are differences of the residual.

        Args:
            config: that the finger was built from.
            parameters: any but choices of the model.
        """
        points = self._finger.model.domain.mesh.geometry.x
        shaped = [parameter for parameter in parameters if parameter.entry is Entry.SHAPE]
        try:
            by_points = self.by_coordinates if shaped else {}
        except NoShapeGradient:
            shaped, by_points = [], {}
        moving = velocities(shaped, config, unplaced(points, config)) if shaped else {}
        others = [parameter for parameter in parameters if parameter.key not in moving]
        by_others = self._by_differences(config, others)
        return {
            name: {
                parameter.key: by_points[name].along(moving[parameter.key])
                if parameter.key in moving
                else by_others[name][parameter.key]
                for parameter in parameters
            }
            for name in self._adjoints
        }

    def _by_differences(
        self, config: Config, parameters: Sequence[Parameter]
    ) -> dict[str, dict[str, float]]:
        """Derivatives by the perturbations of parameters, by column and by key."""
        finger = self._finger
        moves = perturbations(parameters, config, finger)
        counted = self._counted()
        zeros: list[dict[str, float]] = [{} for _ in moves]
        if moves and counted:
            model = finger.by_pressure
            with at_rest(finger):  # from where readings and the plate's gap count
                linear = Newton(model, finger.config.solver).linear
                resting = ForwardSensitivity(model, linear, moves)
                zeros = resting.readings(lambda: {one.column: one.value() for one in counted})
            for one, change in zip(moves, resting.changes, strict=True):
                moved = change.unknowns[: len(model.u.x.array)]
                one.at_rest = moved if put_at_rest(finger) and moved.any() else None
        by_column: dict[str, dict[str, float]] = {}
        for name, adjoint in self._adjoints.items():
            counts = isinstance(self._readings[name], FromRest)
            by_column[name] = {
                one.parameter.key: adjoint.derivative(one) - (zero[name] if counts else 0.0)
                for one, zero in zip(moves, zeros, strict=True)
            }
        return by_column
