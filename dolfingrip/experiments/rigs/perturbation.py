"""A parameter of the configuration as a change of a finger's model, or of its reference mesh."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import basix.ufl
import numpy as np
from dolfinx import fem

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs import materials
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.materials import film_value
from dolfingrip.experiments.rigs.undeformed import REST, free_form, morph, placed, unplaced
from dolfingrip.mechanics.model.compatibility import points_of_cells
from dolfingrip.mechanics.model.model import Model
from dolfingrip.meshes.dimensions import moved
from dolfingrip.parameter import Entry, Parameter


class Movement:
    """Moves a model's reference configuration along a velocity; nodal displacements stay.

    Args:
        model: model whose mesh is moved and whose terms are updated.
        velocity: (n, 3) velocity of this rank's mesh points (mm for each unit of a parameter).
        measures: functions that are called after each motion of the mesh.
    """

    def __init__(
        self,
        model: Model,
        velocity: np.ndarray,
        measures: Sequence[Callable[[], None]] = (),
    ) -> None:
        self._measures = measures
        self._model = model
        self._geometry = model.domain.mesh.geometry
        self._velocity = velocity
        self._rest = self._geometry.x.copy()
        self._nodal = self._at_nodes(velocity)

    def _at_nodes(self, velocity: np.ndarray) -> np.ndarray:
        """Local array of the displacement's nodes, three components each."""
        mesh = self._model.domain.mesh
        element = basix.ufl.element("Lagrange", mesh.topology.cell_name(), 1, shape=(3,))
        space = fem.functionspace(mesh, element)
        field = fem.Function(space)
        corners = space.dofmap.list.shape[1]
        at = velocity[points_of_cells(self._geometry)[:, :corners]]
        field.x.array.reshape(-1, 3)[space.dofmap.list] = at
        moving = fem.Function(self._model.u.function_space)
        moving.interpolate(field)
        return np.asarray(moving.x.array)

    def move(self, amount: float) -> None:
        """Move the reference points to their places after ``amount`` of the parameter."""
        self._geometry.x[:] = self._rest + amount * self._velocity
        for measure in self._measures:
            measure()
        self._model.move_reference(amount * self._nodal if amount else None)


class ParameterPerturbation:
    """Changes a model to that of another value of a parameter without building it again.

    Args:
        parameter: parameter that changes.
        config: configuration that the model was built from.
        model: model that changes.
        constants: constants of the model, by name.
        movement: moves the reference mesh; None if the parameter does not move it.
        set_up: called with a configuration and the change of the displacement at rest (mm); sets
            the stages of the supply and the plate's pose, which are neither constants nor mesh.

    Attributes:
        at_rest: derivative of the displacement at rest (local array, mm for each unit of the
            parameter), from where the plate's gap counts; None while it is 0.
    """

    def __init__(
        self,
        parameter: Parameter,
        config: Config,
        model: Model,
        constants: Mapping[str, fem.Constant],
        movement: Movement | None,
        set_up: Callable[[Config, np.ndarray | float], None],
    ) -> None:
        self.parameter = parameter
        self.scale = parameter.scale
        self.at_rest: np.ndarray | None = None
        self._config = config
        self._model = model
        self._constants = constants
        self._movement = movement
        self._set_up = set_up
        before = constant_values(config, constants)
        sizes = [np.size(value) for value in before.values()]

        def flat(changed: Config) -> np.ndarray:
            values = constant_values(changed, constants)
            return np.concatenate([np.ravel(np.asarray(values[name], float)) for name in before])

        rates = np.split(parameter.derivative(config, flat), np.cumsum(sizes)[:-1])
        self._rates = {
            name: rate.reshape(np.shape(self._constants[name].value))
            for name, rate in zip(before, rates, strict=True)
            if rate.any()
        }

    @property
    def direction(self) -> float:
        """1, or −1 if only smaller values are allowed."""
        return self.parameter.direction(self._config)

    @contextmanager
    def applied(self, amount: float) -> Iterator[None]:
        """A context in which the parameter of the model has changed by ``amount``."""
        kept = {name: self._constants[name].value.copy() for name in self._rates}
        here = self.parameter.value(self._config)
        moved = self._movement is not None
        set_up = self.parameter.entry in (Entry.POSE, Entry.SUPPLY)
        try:
            for name, rate in self._rates.items():
                self._constants[name].value = kept[name] + amount * rate
            if self._movement is not None:
                self._movement.move(amount)
            if set_up or moved or self.at_rest is not None:
                changed = self.parameter.at(self._config, here + amount) if set_up else self._config
                self._set_up(changed, 0.0 if self.at_rest is None else amount * self.at_rest)
            yield
        finally:
            for name, value in kept.items():
                self._constants[name].value = value
            if self._movement is not None:
                self._movement.move(0.0)
            if set_up or moved or self.at_rest is not None:
                self._set_up(self._config, 0.0)


def velocity(parameter: Parameter, config: Config, mesh_points: np.ndarray) -> np.ndarray:
    """Velocity of a finger's mesh points (mm for each unit of the parameter), (n, 3).

    The mesh moves with the finger's dimensions (:mod:`dolfingrip.meshes.dimensions`) and with the
    morph, while its cells and their grading stay. A new mesh would add the change of the mesh's own
    error, and jumps if it needs another cell.

    Args:
        parameter: parameter of the reference mesh.
        config: configuration that the mesh was made from.
        mesh_points: (n, 3) morphed points (mm), for example those of this rank.

    Raises:
        ConfigError: if the mesh is read from a file and so has no dimensions.
    """
    return velocities([parameter], config, unplaced(mesh_points, config))[parameter.key]


def velocities(
    parameters: Sequence[Parameter], config: Config, points: np.ndarray
) -> dict[str, np.ndarray]:
    """Velocities as of :func:`velocity` by key, at points of the straight mesh of ``config``.

    Args:
        parameters: of the reference mesh.
        config: configuration of the finger.
        points: (n, 3) points (mm) before free form and morph, for example those of this rank.

    Raises:
        ConfigError: if the mesh is read from a file and so has no dimensions.
    """
    adapted = config.adapted()

    def at(changed: Config) -> np.ndarray:
        straight = points
        if config.mesh.file is None:
            straight = moved(points, adapted.geometry, changed.adapted().geometry)
        return placed(straight, changed)

    bending = [parameter for parameter in parameters if parameter.key.startswith("form.")]
    by_key: dict[str, np.ndarray] = {}
    for parameter in parameters:
        if config.mesh.file is not None and not parameter.key.startswith("morph"):
            raise ConfigError(
                f"--parameters {parameter.key}: allowed: with a finger that is made from dimensions"
            )
        if parameter not in bending:
            by_key[parameter.key] = parameter.derivative(config, at)
    if bending:  # a free form is linear in its offsets, and a morph in x on both sides of its plane
        form = free_form(adapted)
        slopes = form.slopes(points).tocsc()
        stretch = np.ones((len(points), 3))
        stretch[:, 0] = morph(adapted).slope(form.points(points)[:, 0])
        for parameter in bending:
            number = int(parameter.key.partition("[")[2].rstrip("]"))
            moving = slopes[:, [number]].toarray().reshape(-1, 3)
            by_key[parameter.key] = stretch * moving
    return {parameter.key: by_key[parameter.key] for parameter in parameters}


def perturbations(
    parameters: Sequence[Parameter], config: Config, finger: FingerModel
) -> list[ParameterPerturbation]:
    """A perturbation for each parameter of a finger that was built from ``config``."""

    def set_up(changed: Config, rest_change: np.ndarray | float) -> None:
        finger.take_over(changed.adapted(), finger.rest.displacement + rest_change)

    def movement(parameter: Parameter) -> Movement | None:
        if parameter.entry is not Entry.SHAPE:
            return None
        moving = velocity(parameter, config, finger.model.domain.mesh.geometry.x)
        return Movement(finger.model, moving, finger.site.geometric)

    return of_constants(parameters, config, finger.model, finger.parameters, movement, set_up)


def of_constants(
    parameters: Sequence[Parameter],
    config: Config,
    model: Model,
    constants: Mapping[str, fem.Constant],
    movement: Callable[[Parameter], Movement | None] = lambda parameter: None,
    set_up: Callable[[Config, np.ndarray | float], None] = lambda changed, rest_change: None,
) -> list[ParameterPerturbation]:
    """A perturbation for each parameter; the arguments are those of the class."""
    return [
        ParameterPerturbation(one, config, model, constants, movement(one), set_up)
        for one in parameters
    ]


def constant_values(config: Config, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Values of a model's constants, by name, that ``config`` asks for."""
    config = config.adapted()
    material = config.material
    base = materials.values(material)
    for region in material.own:
        base |= materials.values(material.of(region), f"material.{region}")
    for part in (REST, *material.own):
        base[materials.weight_name(part)] = materials.weight_value(config, part)
        base[materials.density_name(part)] = materials.density_value(config, part)
    base[config.gravity.FALLS] = config.gravity.falls_mm_s2
    constants: dict[str, np.ndarray] = {}
    for name in names:
        if name in base:
            constants[name] = np.asarray(base[name])
            continue
        section, _, inner = name.partition(".")
        if not hasattr(config, section):
            continue  # a load that an experiment sets
        if section == "obstacle":
            constants[name] = np.asarray(getattr(config.obstacle, inner))
            continue
        table, key = inner.split(".")
        if section == "film":
            constants[name] = film_value(config, table, key)
        else:
            constants[name] = np.asarray(getattr(getattr(config.extensions, table), key), float)
    return constants
