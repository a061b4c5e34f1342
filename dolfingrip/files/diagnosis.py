"""``diagnosis.json``: the results of a diagnosis, in a documented and versioned schema."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

from pydantic import Field, computed_field

from dolfingrip.files.result_file import Part, ResultFile
from dolfingrip.files.text_table import TextTable

if TYPE_CHECKING:
    import pandas as pd

READINGS: Final = "readings.csv"
"""Table with a row for each reading: channel, experiment, specimen, run, branch, pressure_kPa,
displacement_mm, value, noise (one standard deviation), configured, before (nuisances fitted) and
after (with the cause)."""

ALONE: Final = 0.8
"""Probability from which on an addition is expected to leave the true hypothesis alone."""


class Verdict(Part):
    """The answer."""

    answer: Literal["cause", "none", "unknown"] = Field(description="what is wrong with the model")
    effects: tuple[str, ...] = Field(
        alias="class", description="effects of the leading class: the data cannot tell them apart"
    )
    second: tuple[str, ...] = Field((), description="effects of a second cause")
    nearest: tuple[str, ...] = Field((), description="effects that come nearest if none is named")
    probability: float = Field(description="that the answer is right")
    claimed: bool = Field(True, description="whether that is enough to claim it")
    least: float = Field(1.0, description="probability of the answer under the worst other prior")
    takes_part: float = Field(
        description="that one of the class takes part, alone, with another cause or an unknown one"
    )
    unexplained: float = Field(
        0.0, ge=0, le=1, description="share of what the configured model misses that stays"
    )
    by_shape: bool = Field(
        False, description="whether an elastic law or friction in the rig does as well"
    )


class FittedNumber(Part):
    """A fitted number."""

    key: str = Field(description="of the configuration, or of the rig under [nuisance]")
    value: float
    low: float = Field(description="lower end of the central 90 %")
    high: float = Field(description="upper end")
    unit: str = Field("", description="empty: it has none")
    configured: float | None = Field(None, description="null: it belongs to a cause")
    part: str = Field("", description="material, walls, body or rig; of a cause its name")

    @property
    def off(self) -> bool:
        """True where its interval excludes what is configured."""
        return self.configured is None or not self.low <= self.configured <= self.high


class CommonChange(Part):
    """A change of the configured model's readings that all effects of a set make."""

    experiment: str
    channel: str
    way: Literal["stiffer", "softer", "higher", "lower"] = Field(
        description="stiffer, softer: of the body; higher, lower: of the reading"
    )
    percent: float = Field(description="of the configured reading, by the leading effect")
    low: float = Field(description="by the effect that changes least")
    high: float = Field(description="by the effect that changes most")
    above: float = Field(description="load from which on, in the control's unit")
    below: float | None = Field(None, description="load up to which; null: to the largest")
    control_unit: str


class Headline(Part):
    """One number with its interval and the option of other commands that uses it."""

    number: FittedNumber
    cause: str = Field("", description="whose number it is; empty: none is named")
    common: CommonChange | None = Field(
        None, description="in place of the number where effects are a set"
    )
    option: str = Field(description="--set KEY=VALUE, or --config FILE where more has to change")


class CauseProbability(Part):
    """One cause."""

    name: str
    words: str = Field("", description="what it is, at its fitted numbers")
    kind: str = Field("", description="kind of effect; empty: a number of model or rig")
    probability: float = Field(description="that it takes part, alone or in a pair")
    strength_sigma: float = Field(description="length of the fitted change, standard deviations")
    open: bool = Field(False, description="whether it may act though no cause is named")


class FittedHypothesis(Part):
    """A hypothesis that was fitted on the graded mesh with nuisances free."""

    effects: tuple[str, ...] = Field(description="none: base model and nuisances")
    log_evidence: float = Field(description="natural logarithm, relative to no effect")
    parameters: tuple[FittedNumber, ...]


class ChannelMisfit(Part):
    """Root mean squares of simulated less measured readings of a channel, in its unit."""

    channel: str
    unit: str
    configured: float
    fitted: float = Field(description="without a cause, the model's own numbers fitted")
    extended: float = Field(description="with the causes that are named, if any")
    noise: float = Field(description="median standard deviation")
    mesh: float | None = Field(None, description="error of the mesh; null: it is not known")
    undecided: bool = Field(False, description="whether that is too large to decide anything")


class BandMisfit(Part):
    """Mean difference of the model without a cause in a band of load, simulated less measured."""

    experiment: str
    channel: str
    start: float = Field(description="load, in the control's unit")
    end: float
    control_unit: str
    mean: float = Field(description="in the channel's unit")
    unit: str
    percent: float = Field(description="of the mean reading there")


class RigNumber(Part):
    """A number of rig or body that the laboratory told, as the readings tell it."""

    name: str
    unit: str
    prior_std: float = Field(description="as reported, or usual")
    value: float = Field(description="difference from what was told")
    share: float = Field(description="of what the configured model misses; 0: within the noise")


class ArtefactSize(Part):
    """An artefact of an instrument, which the diagnosis takes out."""

    name: str = Field(description="jump, play or wave, of what and where")
    size: float
    unit: str


class Slip(Part):
    """A doubt about a column: a slip of unit or sign, or swapped columns."""

    where: str = Field(description="test, or the specimens that show it alike")
    column: str
    meaning: str = Field(description="the slip")
    factor: float | None = Field(description="that makes the column right; null: swapped")


class SpecimensApart(Part):
    """Specimens that stand apart from the others, and the answer without these."""

    specimens: tuple[str, ...]
    odds: float = Field(description="that they do, and no others")
    without: Verdict


class NoiseSource(Part):
    """A noise that the laboratory does not tell."""

    column: str
    test: str
    std: float
    source: Literal["scatter", "repeats", "guess"]


class Scatter(Part):
    """How far the specimens differ from one another."""

    specimens: int
    scale: float = Field(description="relative standard deviation of their stiffness")
    prior_scale: float = Field(description="as the laboratory told, or usual")
    shape: float = Field(description="individual deviation, by the root mean square of a channel")
    estimated: bool = Field(description="whether their readings tell these")
    wide: bool = Field(False, description="whether they differ by more than is believed")


class OtherPrior(Part):
    """The answer under another prior."""

    prior: str
    answer: Literal["cause", "none", "unknown"]
    effects: tuple[str, ...]
    probability: float = Field(description="of the verdict's answer under it")


class HeldOutError(Part):
    """Error on readings that were not used in the fit."""

    left_out: str = Field(description="what was left out in turn")
    channel: str
    folds: int
    before: float = Field(description="as configured, root mean square, in the channel's unit")
    nuisances: float = Field(description="nuisances refitted")
    process: float = Field(description="a Gaussian process without cause")
    cause: float = Field(description="the extended model")
    cause_low: float = Field(description="lower end of its 90 % interval (bootstrap over folds)")
    cause_high: float = Field(description="upper end")
    log_odds_nuisances: float | None = Field(
        None, description="ln of the odds for the cause, by all folds; null: not compared"
    )
    log_odds_process: float | None = Field(None, description="ln of the odds against the process")


class PlannedTest(Part):
    """A test that is proposed: how the rig leads, and what it reads."""

    experiment: str
    specimen: str
    settings: dict[str, Any] = Field({}, description="by key, what differs from the configuration")
    control: str = Field(description="column that the rig leads")
    read: tuple[str, ...] = Field(description="columns that are read at each row")
    branch: tuple[str, ...] = Field(description="of each row")
    cycle: tuple[int, ...] = Field(description="of each row")
    time_s: tuple[float, ...] = Field(description="of each row")
    value: tuple[float, ...] = Field(description="of the control at each row, in the column's unit")


class PlannedQuantity(Part):
    """A quantity that is proposed to be measured by itself."""

    key: str = Field(
        description="of [nuisance], where KEY = {value = …, std = …} tells the reading"
    )
    unit: str = Field("", description="of reading and std; empty: a pure number")
    configured: float = Field(description="what would be read of the model as configured")
    std: float = Field(description="standard deviation of the measurement")
    numbers: dict[str, float] = Field(
        description="coefficients of the numbers that it tells the sum of, by their keys"
    )


class NextExperiment(Part):
    """Worth of an addition to the measurement."""

    name: str
    minutes: float
    gain: float = Field(description="expected increase of the log Bayes factor between the tied")
    gain_per_minute: float = Field(description="up to what decides, by the minute")
    chance: float = Field(ge=0, le=1, description="that the true one of them is left alone")
    excludes: tuple[str, ...] = Field((), description="what it refutes if the leading one is true")
    shows: tuple[str, ...] = Field((), description="what refutes the leading one if it is true")
    tests: tuple[PlannedTest, ...] = Field((), description="of a further measurement")
    quantities: tuple[PlannedQuantity, ...] = Field((), description="of a check of single numbers")

    @property
    def tells(self) -> tuple[str, ...]:
        """Causes that it tells from the leading one, whichever of both is true."""
        return tuple(dict.fromkeys(filter(None, (*self.excludes, *self.shows))))

    @computed_field(description="whether it is expected to leave the true one alone")  # type: ignore[prop-decorator]
    @property
    def splits(self) -> bool:
        """True where the true hypothesis is expected to be left alone."""
        return self.chance >= ALONE

    @property
    def rank(self) -> tuple[bool, float, float]:
        """Place in the order: the less, the earlier.

        Where the true effect is expected to be left alone, the minutes that this is expected to
        take count, as what is told beyond decides nothing; else tenths of the chance, then what is
        told by the minute.
        """
        first = self.minutes / self.chance if self.splits else -round(self.chance, 1)
        return not self.splits, first, -self.gain_per_minute


Way = Literal[
    "nothing", "finger", "area", "empty_machine", "memory", "loop", "rates", "other_channel",
    "finger_or_channel", "coupon_or_channel", "alone",
]  # fmt: skip
"""Kinds of advice beside the tests and checks that were weighed."""


class Advice(Part):
    """A kind of measurement, where nothing that was weighed tells all that is open."""

    way: Way
    names: tuple[str, ...] = Field((), description="causes that it would tell")
    unload: bool = Field(False, description="whether unloading would help, too")


class DesignChange(Part):
    """A design of a campaign, by the model before and by the extended one."""

    inputs: dict[str, float]
    cog_offset_mm: float
    force_before_N: float
    force_after_N: float | None = Field(description="null: the extended model fails")
    phi_before: float = Field(description="force over the original finger's, less 1")
    phi_after: float | None


class Downstream(Part):
    """Changes of a campaign's best designs by the extended model."""

    original_before_N: float = Field(description="force of the original finger")
    original_after_N: float
    designs: tuple[DesignChange, ...] = Field(description="the best before first")


class DiagnosisFile(ResultFile):
    """Contents of ``diagnosis.json``."""

    FILE: ClassVar[str] = "diagnosis.json"
    MADE_BY: ClassVar[str] = "dolfingrip diagnose"

    schema_version: Literal[3] = 3  # it rises if a key changes its meaning or goes
    version: str = Field(description="of dolfingrip")
    data: tuple[str, ...] = Field(description="files")
    quick: bool = Field(description="whether it stopped after the screen")
    readings: int
    verdict: Verdict
    headline: Headline = Field(description="the answer in one number")
    causes: tuple[CauseProbability, ...] = Field(description="the most probable first")
    none: float = Field(description="probability of no cause that can be seen")
    unknown: float = Field(description="probability of a cause that is not in the catalogue")
    fits: tuple[FittedHypothesis, ...] = ()
    misfit: tuple[ChannelMisfit, ...] = ()
    bands: tuple[BandMisfit, ...] = Field((), description="where the model is off")
    rig: tuple[RigNumber, ...] = ()
    nuisances: dict[str, float] = Field({}, description="fitted, by their standard deviations")
    noise_std: dict[str, float] = Field({}, description="independent part, by column of a test")
    noise_sources: tuple[NoiseSource, ...] = Field(
        (), description="where the laboratory tells none"
    )
    scatter: Scatter | None = None
    artefacts: tuple[ArtefactSize, ...] = ()
    apart: SpecimensApart | None = Field(None, description="null: no specimens stand apart")
    hides: dict[str, tuple[str, ...]] = Field(
        {}, description="effects that the readings do not show, and the numbers they hide behind"
    )
    behind: tuple[str, ...] = Field((), description="numbers that open causes hide behind")
    other_priors: tuple[OtherPrior, ...] = ()
    gain: tuple[HeldOutError, ...] = ()
    gain_claimed: bool | None = Field(None, description="whether the cause beats both rivals")
    next_experiments: tuple[NextExperiment, ...] = Field((), description="the best first")
    advice: Advice | None = Field(None, description="null: the first of these tells all")
    downstream: Downstream | None = None
    slips: tuple[Slip, ...] = Field((), description="of units, signs and columns")
    not_reached: tuple[str, ...] = Field(
        (), description="tests with readings that the base simulation does not reach, and why"
    )
    not_tried: tuple[str, ...] = Field((), description="causes that --quick left out")
    failed: dict[str, str] = Field({}, description="causes that could not be simulated, and why")
    mesh_known: bool = Field(True, description="whether the mesh's error is known")
    extrapolated: bool = Field(False, description="whether the leading fit was not simulated")
    warnings: tuple[str, ...] = Field((), description="what the data were read with")
    extended: dict[str, Any] = Field({}, description="what extended.toml changes")
    simulated_s: float = Field(
        description="time of all simulations on a worker each, those from the store included"
    )

    def overview(self) -> TextTable:
        """Return the lines that the page of the diagnosis begins with."""
        return TextTable([""], [[line] for line in self._words().lines(self)], self.FILE)

    def tables(self) -> list[TextTable]:
        """List what was found as tables."""
        tables: list[TextTable] = self._words().tables(self)
        return tables

    @staticmethod
    def _words() -> Any:
        """The module of all words, which imports this one."""
        return import_module("dolfingrip.files.diagnosis_words")

    @staticmethod
    def readings_in(folder: Path) -> pd.DataFrame | None:
        """Read the table of readings beside it.

        Args:
            folder: of the diagnosis.

        Returns:
            The columns of :data:`READINGS`; None if there is no such table.
        """
        import pandas as pd

        return pd.read_csv(folder / READINGS) if (folder / READINGS).is_file() else None
