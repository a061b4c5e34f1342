"""The tables of a study file: designs, the front of two quantities, and published designs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from dolfingrip.config import ConfigError
from dolfingrip.design.quantities.index import parse
from dolfingrip.design.quantities.quantity import objective
from dolfingrip.files.objective import NamedObjective
from dolfingrip.sections import tables
from dolfingrip.sections.errors import checked
from dolfingrip.sections.section import Section

Numbers = Annotated[tuple[float, ...], Field(strict=False)]
Texts = Annotated[tuple[str, ...], Field(strict=False)]


class StudyFront(Section):
    """The two quantities that are traded off."""

    against: str = Field(description="quantity that is limited")
    at_most: Numbers = Field((), description="limits, in the unit of the quantity")
    at_least: Numbers = Field((), description="limits, in the unit of the quantity")
    maximise: str | None = Field(None, description="quantity that is improved")
    minimise: str | None = Field(None, description="quantity that is improved")

    def objectives(self) -> tuple[NamedObjective, NamedObjective]:
        """Return the limited objective and the improved one.

        Raises:
            ConfigError: one line, where there are not just two of them.
        """
        return trade_off(self.against, self.at_most, self.at_least, self.maximise, self.minimise)


class Hyperparameters(Section):
    """The study of how a choice scatters with the settings of NSGA-II."""

    limit: float = Field(description="of the limited quantity, in its unit")


class PublishedDesign(Section):
    """A design that others found."""

    limit: float = Field(description="that it was chosen by")
    inputs: Numbers = Field(description="in the order of the parameters")
    gain_percent: float = Field(description="measured, over the original design")


class Published(Section):
    """Designs that others found, to compare with."""

    gain_of: str = Field(description="quantity whose gain is compared")
    designs: tuple[PublishedDesign, ...] = Field((), strict=False)


class StudyFile(Section):
    """A study file."""

    config: Path | None = Field(None, strict=False, description="of the finger; relative to it")
    set: Texts = Field((), description="section.key=value")
    parameters: Texts = Field(description="KEY=LOW:HIGH:COUNT")
    front: StudyFront = Field(description="what is traded off")
    hyperparameters: Hyperparameters | None = None
    published: Published | None = None


def trade_off(
    against: str,
    at_most: tuple[float, ...],
    at_least: tuple[float, ...],
    maximise: str | None,
    minimise: str | None,
) -> tuple[NamedObjective, NamedObjective]:
    """Name two objectives that are traded off.

    Args:
        against: quantity that is limited.
        at_most: its limits from above; without any limit it counts as limited from above.
        at_least: its limits from below.
        maximise: quantity that is improved; None: ``minimise`` is.
        minimise: quantity that is improved; None: ``maximise`` is.

    Returns:
        The limited objective, the improved one.

    Raises:
        ConfigError: one line, where both kinds of limits are given, or not one improved quantity.
    """
    improved = maximise or minimise
    if improved is None or (maximise and minimise):
        raise ConfigError("maximise, minimise: allowed: one of them")
    if at_most and at_least:
        raise ConfigError("at_most, at_least: allowed: one of them")
    if against == improved:
        raise ConfigError(f"against = {against}: allowed: another quantity than the improved one")
    return (
        objective(against, "at least" if at_least else "at most"),
        objective(improved, "maximise" if maximise else "minimise"),
    )


def read(file: Path) -> StudyFile:
    """Read a study file.

    Args:
        file: TOML; paths in it are relative to it.

    Returns:
        Its content, with the texts of quantities in their usual form.

    Raises:
        ConfigError: one line about bad input.
    """
    content = checked(StudyFile, tables.whole(file, "FILE"))
    front = {
        key: str(parse(text, f"front.{key} ="))
        for key in ("against", "maximise", "minimise")
        if (text := getattr(content.front, key)) is not None
    }
    update: dict[str, object] = {"front": content.front.model_copy(update=front)}
    if content.config is not None:
        update["config"] = file.parent / content.config
    if content.published is not None:
        gain_of = str(parse(content.published.gain_of, "published.gain_of ="))
        update["published"] = content.published.model_copy(update={"gain_of": gain_of})
    study = content.model_copy(update=update)
    study.front.objectives()  # complains in one line
    return study
