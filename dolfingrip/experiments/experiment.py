"""The base class of experiments: a name, a schedule, a rig, and how the result is shown.

An experiment's file imports no solver before :meth:`Experiment.prepare` is called, since the
command reads it for its help.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, ClassVar, Final

from dolfingrip.channels import PRESSURE, Channel, Part
from dolfingrip.experiments.protocol import Stop

if TYPE_CHECKING:  # what experiments receive: their modules import the solver
    from mpi4py import MPI

    from dolfingrip.config import Config
    from dolfingrip.experiments.results.readings import Readings
    from dolfingrip.experiments.rigs.rig import Rig
    from dolfingrip.mechanics.model.profile import Profile
else:
    MPI = Config = Readings = Rig = Profile = object


@dataclass(frozen=True, slots=True)
class Curve:
    """A line of a plot: the result's column, and what the legend calls it."""

    column: str
    label: str


@dataclass(frozen=True, slots=True)
class Plot:
    """The plot of a result.

    Attributes:
        label: label of the vertical axis.
        curves: the first curve must be in the result; the others are drawn if they are.
        over: what the horizontal axis shows.
    """

    label: str
    curves: tuple[Curve, ...]
    over: Channel = PRESSURE


@dataclass(frozen=True, slots=True)
class Option:
    """An option that the command of one experiment has in addition to the common options.

    Attributes:
        flag: name on the command line.
        type: type of its value; ``bool`` for a flag without value, a list if it can be repeated.
        default: value if it is not given; None leaves the configuration as it is.
        help: one line.
        key: key of the configuration that it sets; "" if the experiment itself reads the option.
        needs: the option that it is allowed with, and its value in words.
    """

    flag: str
    type: Any
    default: object
    help: str
    key: str = ""
    needs: str = ""

    @property
    def name(self) -> str:
        """The flag as a Python name."""
        return self.flag.lstrip("-").replace("-", "_")


PRESSURE_OPTION: Final = Option(
    "--pressure",
    float,
    None,
    "Highest pressure; a negative one is suction alone.",
    "experiment.max_pressure_kPa",
)
"""The option of all experiments that pressurise."""

SUCTION_OPTION: Final = Option(
    "--min-pressure",
    float,
    None,
    "Suction before the highest pressure, such as -60.",
    "experiment.min_pressure_kPa",
)
"""The option of all experiments that may begin with suction."""

DYNAMIC_OPTION: Final = Option(
    "--dynamic",
    bool,
    None,
    "Solve with inertia, in the time of ramps and waits.",
    "experiment.dynamic",
)
"""The option of all experiments on a finger that may move in time."""


class Experiment(ABC):
    """One experiment. The first line of its docstring is the help of its command.

    Attributes:
        name: its name in the column ``experiment`` of results and measurements.
        command: the subcommand of ``dolfingrip``.
        title: heading of its table.
        control: the prescribed quantity.
        parts: parts of its rig whose channels it reads.
        columns: channels of the result that only this experiment has.
        table: channels of the result that are printed; results are joined by the first one.
        plot: what is drawn of the result.
        options: options of its command in addition to the common options.
        protocol: whether it may follow a protocol.
        drawable: whether deformed shapes of the specimen can be drawn.
        measured: whether the format of measured data has it.
        gradients: whether its readings can be derived by parameters.
        dynamic: whether its specimen may move with inertia.
        mesh_check: whether its command estimates the error of the mesh where that is asked for.
        pictures: file of ``report`` whose ``draw`` makes the pictures of its result; "finger" for
            the deformed shapes of one finger.
        does_without: keys that its answer does not depend on, of tables that its parts feel.
    """

    name: ClassVar[str]
    command: ClassVar[str]
    title: ClassVar[str]
    control: ClassVar[Channel] = PRESSURE
    parts: ClassVar[tuple[Part, ...]] = ()
    columns: ClassVar[tuple[Channel, ...]] = ()
    table: ClassVar[tuple[Channel, ...]]
    plot: ClassVar[Plot]
    options: ClassVar[tuple[Option, ...]] = ()
    protocol: ClassVar[bool] = True
    drawable: ClassVar[bool] = True
    measured: ClassVar[bool] = True
    gradients: ClassVar[bool] = True
    dynamic: ClassVar[bool] = False
    mesh_check: ClassVar[bool] = False
    pictures: ClassVar[str] = "finger"
    does_without: ClassVar[tuple[str, ...]] = ("cog.x_ref_mm",)  # a number of the unloaded shape

    @classmethod
    def summary(cls) -> str:
        """Help of its command: its docstring's first line and example.

        It has its name where that is not its command's.
        """
        line, *parts = cleandoc(cls.__doc__ or "").split("\n\n")
        named = cls.__dict__.get("name", cls.command)  # a cycle is named like what it repeats
        line += "" if named == cls.command else f" In files and Python: {named}."
        return "\n\n".join([line, *(part for part in parts if part.startswith("Example: "))])

    # -- before the run --------------------------------------------------------------------------

    def settings(self, config: Config) -> Config:
        """Return a configuration with the settings that the experiment requires.

        Args:
            config: of the user.

        Raises:
            ConfigError: one line, if the configuration cannot have them.
        """
        return config

    def with_options(self, given: Mapping[str, Any]) -> Experiment:
        """Return the experiment that options of the command ask for.

        Args:
            given: values by the options' names.
        """
        return self

    @abstractmethod
    def schedule(self, config: Config) -> Sequence[Stop]:
        """Return the stops at which readings are taken, in order.

        Args:
            config: to which :meth:`settings` was applied.

        Raises:
            ConfigError: one line, if the protocol is not one for this experiment.
        """

    def efforts(self, config: Config) -> list[float]:
        """Return the cost of each reading of the schedule, in any unit; for the time left."""
        return [1.0 for _ in self.schedule(config)]

    @abstractmethod
    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> Rig:
        """Build its rig: the model, its control and its readings.

        Args:
            config: configuration to which :meth:`settings` was applied.
            comm: ranks to run on.
            profile: takes the time of each phase.

        Raises:
            ConfigError: on every rank, one line.
        """

    # -- set-up and result -----------------------------------------------------------------------

    def setup(self, config: Config) -> dict[str, Any]:
        """The set-up, by the keys of a measurement's TOML file."""
        return {}

    def described(self, config: Config) -> dict[str, Any]:
        """The contents of a measurement's TOML file; empty tables are left out."""
        data = {"experiment": self.name, **self.setup(config)}
        if config.protocol.time_s:  # its time stamps tell the rate
            data = {key: value for key, value in data.items() if not key.startswith("rate_")}
        return {key: value for key, value in data.items() if value != {}}

    def notes(self, config: Config) -> list[str]:
        """One line for each doubt about the configuration."""
        return []

    def conclude(self, result: Readings, rig: Rig) -> None:  # noqa: B027  # most have nothing
        """Add to the result what depends on all of its rows."""

    def remarks(self, result: Readings) -> list[str]:
        """Sentences on the result, printed below its table."""
        return []
