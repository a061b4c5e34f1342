"""What an experiment is: a name, a schedule, a rig, and how its result is shown.

An experiment's file imports no solver before :meth:`Experiment.prepare` is called, since the
command reads it for its help.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from dolfingrip.config import Config
from dolfingrip.experiments.description import Column, Option, Plot
from dolfingrip.experiments.protocol.schedule import Stop

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.experiments.results.result import Result
    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.mechanics.model.profile import Profile


class Experiment(ABC):
    """One experiment. The first line of its docstring is the help of its command.

    Attributes:
        name: in the column ``experiment`` of results and measurements.
        command: the subcommand of ``dolfingrip``.
        title: above its table.
        control: column of the prescribed quantity.
        columns: of the result, which only this experiment has.
        table: what is printed of the result; results are joined by the first column.
        plot: what is drawn of the result.
        options: of its command, besides those of all.
        protocol: whether it may follow a protocol.
        poses: whether its deformed poses can be drawn.
        measured: whether the measured-data format has it.
        gradients: whether its readings can be derived by parameters.
        gripper: whether a whole gripper is drawn of its result.
    """

    name: ClassVar[str]
    command: ClassVar[str]
    title: ClassVar[str]
    control: ClassVar[str] = "pressure_kPa"
    columns: ClassVar[tuple[str, ...]] = ()
    table: ClassVar[tuple[Column, ...]]
    plot: ClassVar[Plot]
    options: ClassVar[tuple[Option, ...]] = ()
    protocol: ClassVar[bool] = True
    poses: ClassVar[bool] = True
    measured: ClassVar[bool] = True
    gradients: ClassVar[bool] = True
    gripper: ClassVar[bool] = False

    @classmethod
    def summary(cls) -> str:
        """The first line of its docstring."""
        return (cls.__doc__ or "").splitlines()[0]

    # -- before it is run ------------------------------------------------------------------------

    def settings(self, config: Config) -> Config:
        """``config`` with the settings that the experiment requires.

        Raises:
            ConfigError: one line, where that cannot be.
        """
        return config

    def asked(self, given: Mapping[str, Any]) -> Experiment:
        """The experiment to run with these options of its command, by name."""
        return self

    @abstractmethod
    def schedule(self, config: Config) -> Sequence[Stop]:
        """Where it is read, in order.

        Raises:
            ConfigError: one line, where the protocol is none for this experiment.
        """

    @abstractmethod
    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        """Build its rig: the model, its control and its readings.

        Args:
            config: with :meth:`settings` applied.
            comm: ranks to run on.
            profile: where the time is booked.

        Raises:
            ConfigError: on every rank, one line.
        """

    # -- set-up and result -----------------------------------------------------------------------

    def setup(self, config: Config) -> dict[str, Any]:
        """The set-up by the keys of a measurement's TOML file."""
        return {}

    def described(self, config: Config) -> dict[str, Any]:
        """The set-up as in a measurement's TOML file, without what is empty."""
        data = {"experiment": self.name, **self.setup(config)}
        if config.protocol.time_s:  # its time stamps say it
            data = {key: value for key, value in data.items() if not key.startswith("rate_")}
        return {key: value for key, value in data.items() if value != {}}

    def notes(self, config: Config) -> list[str]:
        """One line for each doubt about the configuration."""
        return []

    def conclude(self, result: Result, rig: Rig) -> None:  # noqa: B027  # most have nothing
        """Add to the result what follows from all its rows together."""

    def remarks(self, result: Result) -> list[str]:
        """Sentences on the result, printed below its table."""
        return []
