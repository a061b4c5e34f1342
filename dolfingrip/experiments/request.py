"""One simulation that is asked for, and what it answered.

Who wants numbers of an experiment makes a :class:`Request`; :mod:`dolfingrip.experiments.simulate`
computes many of them and keeps their answers. It imports no solver.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple, Self

import numpy as np
from pydantic import PlainSerializer, PlainValidator, TypeAdapter

from dolfingrip import plugins
from dolfingrip.channels import of_plugins
from dolfingrip.config import Config, felt
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.index import find
from dolfingrip.jobs.job import Data, content_key
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.supply import AirLine

FORMAT: Final = 2
"""Version of what an answer holds and a key means; to be raised where a request gives another
answer than before."""


Indexed = Annotated[Experiment, PlainValidator(find), PlainSerializer(lambda each: each.command)]
"""An experiment, which is its command's name in plain data."""


def _numbers(values: Sequence[float | None]) -> np.ndarray:
    return np.array(values, dtype=float)  # None, as of JSON, is NaN


Numbers = Annotated[
    np.ndarray, PlainValidator(_numbers), PlainSerializer(lambda values: values.tolist())
]
"""An array of numbers, which is a list in plain data."""

MESH: Final = "mesh"
"""In place of a parameter: the error of a reading that is due to the mesh."""

Slopes = Annotated[
    Mapping[tuple[str, str], np.ndarray],
    PlainValidator(lambda rows: {(column, key): _numbers(each) for column, key, each in rows}),
    PlainSerializer(lambda slopes: [[*names, each.tolist()] for names, each in slopes.items()]),
]
"""Arrays by column and parameter, which are a list of rows in plain data."""


class Place(NamedTuple):
    """A place on a load path: a value of a reading, which may be the pressure.

    Attributes:
        column: of the reading.
        value: in the column's unit.
    """

    column: str
    value: float


@dataclass(frozen=True, slots=True)
class Request:
    """An experiment on a configuration, and what is wanted of it. :meth:`of` makes one.

    Attributes:
        experiment: that is run.
        config: all that the simulation depends on, with the settings that the experiment requires.
        gradients: keys of parameters that readings are derived by; (): all; None: no derivatives.
        at_highest: derivatives are wanted at the highest pressure alone, where adjoints give those
            by ξ1 and ξ2 at less cost.
        columns: readings that are wanted, where the experiment has them; (): all.
        places: of the load path, at which readings and derivatives are taken; (): the stops of the
            experiment.
        made_for: configuration with the dimensions that the mesh is made for and moved from; None:
            ``config``.
        fields: folder for the result with its fields; None: none is written. It is no part of the
            key.
        ranks: MPI processes. They are no part of the key.
        mesh_check: whether the error of the mesh is estimated, too.
        bands: standard deviations by which bands of the readings are computed, too, beside the
            usual ones of :mod:`dolfingrip.parameter.nuisances`; None: no bands.
    """

    experiment: Indexed
    config: Config
    gradients: tuple[str, ...] | None = None
    at_highest: bool = False
    columns: tuple[str, ...] = ()
    places: tuple[Place, ...] = ()
    made_for: Config | None = None
    fields: Path | None = None
    ranks: int = 1
    mesh_check: bool = False
    bands: Mapping[str, float] | None = None

    @classmethod
    def of(
        cls,
        experiment: Experiment | str,
        config: Config,
        gradients: Sequence[str] | None = None,
        **wanted: Any,
    ) -> Self:
        """Ask for an experiment with the settings that it requires.

        Args:
            experiment: an experiment, or its name in :mod:`dolfingrip.experiments.index`.
            config: of the simulation.
            gradients: keys of parameters that readings are derived by; (): all; None: none.
            wanted: further attributes.

        Returns:
            The request.

        Raises:
            ConfigError: one line, where there is no such experiment, or the configuration cannot
                have its settings.
        """
        chosen = find(experiment) if isinstance(experiment, str) else experiment
        keys = None if gradients is None else tuple(gradients)
        if config.experiment.dynamic and not chosen.dynamic:
            raise ConfigError(f"experiment.dynamic = true: {chosen.command}: allowed: false")
        slopes = keys is not None or wanted.get("bands") is not None
        if config.experiment.dynamic and wanted.get("places"):
            raise ConfigError("experiment.dynamic = true: readings at a place: allowed: false")
        supply = config.supply if AirLine.felt_on(chosen.parts) else None
        if supply is not None and wanted.get("places"):
            raise ConfigError("supply = a table: allowed: without readings at a place")
        if supply is not None and slopes and supply.source == "syringe":
            words = "allowed: another source with gradients and bands"
            raise ConfigError(f'supply.source = "syringe": {words}')
        return cls(chosen, chosen.settings(config), keys, **wanted)

    @property
    def key(self) -> str:
        """Hash of all that the answer depends on."""
        return content_key(self.content())

    def content(self) -> Data:
        """Return all that the answer depends on, as plain data.

        Returns:
            Format, experiment, what is wanted of it, and the felt part of the configuration.

        Raises:
            ConfigError: one line, where the mesh file cannot be read.
        """
        parts, made_for = self.experiment.parts, self.made_for
        further: Data = {"mesh_check": True} if self.mesh_check else {}
        further |= {} if self.bands is None else {"bands": self.bands}
        used = plugins.digests(type(self.experiment), *of_plugins(*parts))
        further |= {"plugin": used} if used else {}
        return {
            **further,
            "format": FORMAT,
            "experiment": self.experiment.name,
            "gradients": None if self.gradients is None else sorted(self.gradients),
            "at_highest": self.at_highest,
            "columns": self.columns,
            "places": self.places,
            "config": felt(self.config, parts),
            "made_for": None if made_for is None else felt(made_for, parts),
        }

    def plain(self) -> Data:
        """Return the request as plain data, to be sent; the experiment is one of the index."""
        plain: Data = _REQUEST.dump_python(self, mode="json")
        return plain

    @staticmethod
    def from_plain(data: Data) -> Request:
        """Read what :meth:`plain` wrote.

        Args:
            data: plain data.

        Returns:
            The request; its settings are not applied again.

        Raises:
            ValidationError: where the configuration is not allowed.
        """
        return _REQUEST.validate_python(data)


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request.

    Attributes:
        columns: (reached,) readings by column, at the stops or places that were reached.
        slopes: (reached,) derivatives by column and parameter, for each unit of the parameter; NaN
            where none was taken. By column and :data:`MESH` the error of the mesh, where it was
            asked for and can be told.
        failure_class, failure: why the model did not come to the end, as class and sentence; None
            where it did.
        outcome: class, sentence and time (s) of a grasp's outcome.
        iterations: of Newton's method.
        versions: of the software that computed it, by package.
        wall_s: time that it took.
    """

    columns: Mapping[str, Numbers] = field(default_factory=dict)
    slopes: Slopes = field(default_factory=dict)
    failure_class: str | None = None
    failure: str | None = None
    outcome: Mapping[str, Any] | None = None
    iterations: int = 0
    versions: Mapping[str, str] = field(default_factory=dict)
    wall_s: float | None = None

    def plain(self) -> Data:
        """Return the answer as plain data, to be sent and stored."""
        plain: Data = _ANSWER.dump_python(self, mode="json")
        return plain

    @staticmethod
    def from_plain(data: Data) -> Answer:
        """Read what :meth:`plain` wrote.

        Args:
            data: plain data.

        Returns:
            The answer; numbers that JSON does not have are NaN.
        """
        return _ANSWER.validate_python(data)


_REQUEST, _ANSWER = TypeAdapter(Request), TypeAdapter(Answer)
