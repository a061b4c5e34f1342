"""``diagnosis.json``: the results of a diagnosis, in a documented and versioned schema."""

from __future__ import annotations

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
    probability: float = Field(description="that the answer is right")
    claimed: bool = Field(True, description="whether that is enough to claim it")
    takes_part: float = Field(
        description="that one of the class takes part, alone, with another cause or an unknown one"
    )
    unexplained: float = Field(
        0.0, ge=0, le=1, description="share of what the configured model misses that stays"
    )
    sentence: str = Field(description="the answer in words")


class Brief(Part):
    """The ten lines that the page begins with."""

    result: str = Field(description="the answer in words, and how sure it is")
    size: str = Field(description="fitted numbers, and what they change")
    fit: str = Field(description="error before and after, and the noise")
    check: str = Field(description="error on readings that were left out")
    not_explained: str = Field(description="share that stays, and where")
    also_possible: str = Field(description="other causes")
    cannot_be_seen: str = Field(description="effects that these readings do not feel")
    assumed: str = Field(description="modulus, scatter, noise, doubts about the data")
    do_next: str = Field(description="the next experiment, its minutes, what it would tell")
    use_it: str = Field(description="the command that uses the extended model")


HEADINGS: Final = {
    "result": "RESULT",
    "size": "SIZE",
    "fit": "FIT",
    "check": "CHECK",
    "not_explained": "NOT EXPLAINED",
    "also_possible": "ALSO POSSIBLE",
    "cannot_be_seen": "CANNOT BE SEEN HERE",
    "assumed": "ASSUMED",
    "do_next": "DO NEXT",
    "use_it": "USE IT",
}
"""Headings of the lines, in their order."""


class CauseProbability(Part):
    """One cause of the catalogue."""

    name: str
    probability: float = Field(description="that it takes part, alone or in a pair")
    strength_sigma: float = Field(description="length of the fitted change, standard deviations")


class FittedNumber(Part):
    """A fitted number."""

    key: str = Field(description="of the configuration; modulus: factor of all moduli; strength "
                     "of …: by the effect's ordinary strength")  # fmt: skip
    value: float
    low: float = Field(description="lower end of the central 90 %")
    high: float = Field(description="upper end")

    def words(self, digits: int = 3) -> str:
        """The number, and its interval in brackets."""
        value, low, high = (f"{each:.{digits}g}" for each in (self.value, self.low, self.high))
        return f"{self.key} = {value} ({low} to {high})"


class FittedHypothesis(Part):
    """A hypothesis that was fitted on the graded mesh with nuisances free."""

    effects: tuple[str, ...] = Field(description="none: base model and nuisances")
    log_evidence: float = Field(description="natural logarithm, relative to no effect")
    parameters: tuple[FittedNumber, ...]


class AssumedNoise(Part):
    """The noise that was taken."""

    std: dict[str, float] = Field(description="independent part, by column of a test")
    sentences: tuple[str, ...]


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
    by_nuisances_low: float = Field(description="cause by nuisances, lower end")
    by_nuisances_high: float = Field(description="upper end")
    log_odds_nuisances: float | None = Field(
        None, description="ln of the odds for the cause, by all folds; null: not compared"
    )
    log_odds_process: float | None = Field(None, description="ln of the odds against the process")


class NextExperiment(Part):
    """Worth of an addition to the measurement."""

    name: str
    minutes: float
    gain: float = Field(description="expected increase of the log Bayes factor between the tied")
    gain_per_minute: float = Field(description="up to what decides, by the minute")
    chance: float = Field(ge=0, le=1, description="that the true one of them is left alone")
    excludes: tuple[str, ...] = Field((), description="what it refutes if the leading one is true")
    shows: tuple[str, ...] = Field((), description="what refutes the leading one if it is true")

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


class DesignChange(Part):
    """A design of a campaign, by the model before and by the extended one."""

    inputs: dict[str, float]
    cog_offset_mm: float
    force_before_N: float
    force_after_N: float | None = Field(description="null: the extended model fails")
    phi_before: float = Field(description="force over the original finger's, less 1")
    phi_after: float | None

    def cells(self) -> list[str]:
        """The design, its forces in N and φ as texts."""
        place = ", ".join(f"{key} = {value:.3g}" for key, value in self.inputs.items())
        force = "–" if self.force_after_N is None else f"{self.force_after_N:.3g}"
        phi = "–" if self.phi_after is None else f"{self.phi_after:.1%}"
        return [place, f"{self.force_before_N:.3g}", force, f"{self.phi_before:.1%}", phi]


class Downstream(Part):
    """Changes of a campaign's best designs by the extended model."""

    original_before_N: float = Field(description="force of the original finger")
    original_after_N: float
    designs: tuple[DesignChange, ...] = Field(description="the best before first")

    @computed_field(description="in words")  # type: ignore[prop-decorator]
    @property
    def sentence(self) -> str:
        """The fate of the campaign's optimum."""
        before, after = self.designs[0], max(self.designs, key=lambda d: d.force_after_N or 0.0)
        if before.phi_after is None or after.phi_after is None:
            return "the campaign's optimum could not be computed with the extended model"
        change = f"φ of the campaign's optimum {before.phi_before:.1%} → {before.phi_after:.1%}"
        if after is before:
            return f"{change}; it stays the best of the {len(self.designs)} that were computed"
        place = ", ".join(f"{key} = {value:.3g}" for key, value in after.inputs.items())
        return f"{change}; the best is now {place} with φ = {after.phi_after:.1%}"


class DiagnosisFile(ResultFile):
    """Contents of ``diagnosis.json``."""

    FILE: ClassVar[str] = "diagnosis.json"
    MADE_BY: ClassVar[str] = "dolfingrip diagnose"

    schema_version: Literal[2] = 2  # it rises if a key changes its meaning or goes
    version: str = Field(description="of dolfingrip")
    data: tuple[str, ...] = Field(description="files")
    quick: bool = Field(description="whether it stopped after the screen")
    readings: int
    verdict: Verdict
    brief: Brief | None = Field(None, description="null: not written for this measurement yet")
    causes: tuple[CauseProbability, ...] = Field(description="the most probable first")
    none: float = Field(description="probability of no cause that can be seen")
    unknown: float = Field(description="probability of a cause that is not in the catalogue")
    screen: dict[str, float] = Field(description="log evidence of each effect alone, linear")
    fits: tuple[FittedHypothesis, ...]
    sentences: tuple[str, ...] = Field(description="where the simulation is off, in words")
    noise: AssumedNoise
    under_other_priors: dict[str, str] = Field(description="the answer under each")
    nuisances: dict[str, float] = Field(description="fitted, by their standard deviations")
    gain: tuple[HeldOutError, ...] = ()
    gain_claimed: bool | None = Field(None, description="whether the cause beats both rivals")
    next_experiments: tuple[NextExperiment, ...] = ()
    downstream: Downstream | None = None
    suspicions: tuple[str, ...] = Field((), description="slips of units, signs and columns")
    not_reached: tuple[str, ...] = Field(
        (), description="tests with readings that the base simulation does not reach, and why"
    )
    warnings: tuple[str, ...] = ()
    extended: dict[str, Any] = Field({}, description="what extended.toml changes")
    simulated_s: float = Field(
        description="time of all simulations on a worker each, those from the store included"
    )

    @property
    def beside_causes(self) -> dict[str, float]:
        """Probabilities that no cause is seen, and of one that is not in the catalogue, by words.

        That nothing acts is less probable than that nothing is seen, as a cause may hide.
        """
        nothing = self.verdict.probability if self.verdict.answer == "none" else self.none
        hides = (
            {"hidden: not seen, not excluded": self.none - nothing} if nothing < self.none else {}
        )
        return {
            "none: noise alone": nothing,
            **hides,
            "unknown: not in the catalogue": self.unknown,
        }

    def overview(self) -> TextTable:
        """Return the ten lines that the page of the diagnosis begins with."""
        rows = [[HEADINGS[name], line] for name, line in self.brief or ()]
        return TextTable(["", ""], rows, self.verdict.sentence)

    def tables(self) -> list[TextTable]:
        """List what was found as tables: fits, gain, next experiments, best designs."""
        tables = []
        if len(self.fits) > 1:
            fits = sorted(self.fits, key=lambda each: -each.log_evidence)
            rows = [
                [" with ".join(each.effects) or "none", f"{each.log_evidence:z.1f}",
                 "; ".join(number.words() for number in each.parameters)]
                for each in fits
            ]  # fmt: skip
            tables.append(TextTable(["effects", "ln evidence", "parameters (90 %)"], rows, "Fits"))
        if self.gain:
            rows = [
                [f"{each.left_out} ({each.folds})", each.channel, f"{each.before:.3g}",
                 f"{each.nuisances:.3g}", f"{each.process:.3g}",
                 f"{each.cause:.3g} ({each.cause_low:.3g} to {each.cause_high:.3g})"]
                for each in self.gain
            ]  # fmt: skip
            headings = ["left out", "reading", "as configured", "nuisances refitted", "process",
                        "cause (90 %)"]  # fmt: skip
            title = "Error on readings that were left out (root mean square)"
            tables.append(TextTable(headings, rows, title))
        if self.next_experiments:
            rows = [
                [
                    each.name,
                    f"{each.minutes:.0f}",
                    f"{each.chance:.2f}",
                    ", ".join(each.tells) or "–",
                    f"{each.gain:+.1f}",
                ]
                for each in self.next_experiments
            ]
            headings = ["test or check", "minutes", "leaves one answer", "may tell",
                        "expected ln Bayes factor"]  # fmt: skip
            tables.append(TextTable(headings, rows, "Further checks"))
        if self.downstream is not None:
            rows = [each.cells() for each in self.downstream.designs]
            headings = ["design", "force before (N)", "after", "φ before", "after"]
            tables.append(TextTable(headings, rows, "Best designs of the campaign"))
        return tables

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
