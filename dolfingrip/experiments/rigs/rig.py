"""The rig of an experiment: a model with its control and its readings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.rigs.perturbation import ParameterPerturbation
from dolfingrip.files.run import PlatePose
from dolfingrip.mechanics.model.model import Control
from dolfingrip.mechanics.newton.air_supply import AirSupply
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.mechanics.path.path import LoadPath, Observer
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.mechanics.sensitivity.repeated_step import Perturbation
from dolfingrip.parameter import Parameter


class Rig(ABC):
    """A test rig with its specimen.

    Attributes:
        specimen_name: what the specimen is called.
        newton: solver of the specimen's model.
        specimen: the model with its parts, which visitors of the run receive.
        gaps_mm: for each reading, distances (mm) between neighbouring parts by their names.
        plate: where the force sensor stands; None if there is none.
        sag_mm: mean displacement of the tip's face from the shape as built to that at rest.
        pressures: pressure (kPa) in each cavity of the specimen by its name.
        readings: readings by column, without instruments' errors.
        from_rest: columns that count from the state at rest.
        tared: called as soon as the state at rest is known.
        place_load: the load that holds a place, which parameters change; None if none does.
        air: supply of the specimen's air, which begins at rest; None without one.
        held: called with that place (mm) once it is held, as a function of the model's state.
        further: returns an experiment's further readings by column, without instruments' errors.
    """

    specimen_name: ClassVar[str]
    readings: Mapping[str, Reading]
    from_rest: Sequence[str] = ()

    def __init__(self, newton: Newton, specimen: Any) -> None:
        self.newton = newton
        self.specimen = specimen
        self.gaps_mm: list[dict[str, float]] = []
        self.plate: PlatePose | None = None
        self.sag_mm: tuple[float, float, float] | None = None
        self.pressures: Mapping[str, Control] = {}
        self.tared: Callable[[], None] = lambda: None
        self.place_load: Perturbation | None = None
        self.air: AirSupply | None = None
        self.held: Callable[[Callable[[], float]], None] = lambda place_mm: None
        self.further: Callable[[], Mapping[str, float]] = dict
        self._true: defaultdict[str, list[float]] = defaultdict(list)

    @property
    def quantity(self) -> str:
        """Name of the quantity that is prescribed at present."""
        return "pressure"

    @property
    def softening(self) -> str:
        """A limit point in words, without its reason."""
        return f"the {self.specimen_name} goes soft here"

    @property
    def jumps(self) -> bool:
        """True if a load step may jump to another state if none is near."""
        return True

    @abstractmethod
    def longest(self) -> dict[str, float]:
        """Longest load step of each control that limits the step."""

    def path(self, observers: Sequence[Observer]) -> LoadPath:
        """A load path of the specimen's model under the rig's present control."""
        return LoadPath(
            self.newton,
            self.longest(),
            passable=self.passable,
            foreseen=self.foreseen,
            observers=observers,
            damped=self.jumps,
        )

    @abstractmethod
    def controls(self, stop: Stop) -> Mapping[str, float]:
        """Controls of a stop by name."""

    @abstractmethod
    def read(self) -> dict[str, float]:
        """Readings at the present state by column, with the errors of instruments."""

    def displayed(self, config: Config, true: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """A run's readings so far, (rows,) by column, with the errors of instruments."""
        return config.extensions.displayed(true, config.camera)

    def shown(self, config: Config, true: Mapping[str, float]) -> dict[str, float]:
        """The next row as the instruments show it, which may depend on the rows before."""
        for column, value in true.items():
            self._true[column].append(value)
        rows = {column: np.array(values) for column, values in self._true.items()}
        return {column: float(x[-1]) for column, x in self.displayed(config, rows).items()}

    def perturbations(
        self, config: Config, parameters: Sequence[Parameter]
    ) -> Sequence[ParameterPerturbation]:
        """Changes of the specimen's model, one for each parameter of ``config``."""
        raise ConfigError("--gradients: allowed: with another experiment")

    @property
    def from_rest_shape(self) -> bool:
        """True where supports are placed from the shape at rest, else from the undeformed one."""
        return False

    def over(self) -> bool:
        """Return whether the experiment ends before its last stop."""
        return False

    def start(self, path: LoadPath, first: Stop) -> Failure | None:
        """Bring the specimen to where the experiment starts.

        Args:
            path: load path of the model.
            first: the experiment's first stop.

        Returns:
            Why the start was not reached; None if it was.
        """
        return None

    def continuation(self, failure: Failure) -> Sequence[Stop]:
        """Hand over to another control after an experiment ended early.

        From there on :attr:`newton`, :meth:`longest` and :meth:`controls` are those of the new
        control.

        Returns:
            Stops under the other control; empty if there is none.

        Args:
            failure: why it ended; the specimen is in its last good state.
        """
        return ()

    def advice(self, failure: Failure) -> str:
        """Settings with which the experiment goes on, in a sentence; "" if nothing is known.

        Args:
            failure: why it ended; the specimen is in its last good state.
        """
        return ""

    def passable(self, attempted: Mapping[str, float]) -> bool:
        """Return whether equilibrium goes on at a falling load where a step failed.

        Args:
            attempted: controls that were not reached, by name.
        """
        return False

    def foreseen(self, attempted: Mapping[str, float]) -> bool:
        """Return whether the load is forecast to turn before the controls of a step.

        Args:
            attempted: controls by name.
        """
        return False
