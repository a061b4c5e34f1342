"""Pages of the effects in ``dolfingrip/extensions``."""

from __future__ import annotations

import csv
import importlib
import inspect
import re
from collections.abc import Sequence
from pathlib import Path

from docstrings import Docstring, block, inline, table
from matplotlib.axes import Axes
from pages import ROOT, Page, file_of, picture

from dolfingrip.charts import theme
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.sections.units import unit

HEADS = ("Prior", "Fingerprint", "Confused with")
PLACES = ("half_up", "top", "half_back", "vented")
HIGHEST_kPa = 250.0
UNITS = {"angle": "deg", "force": "N"}


def pages(folder: Path) -> list[Page]:
    """A page for each effect."""
    with (ROOT / "benchmarks" / "fingerprints.csv").open(encoding="utf-8", newline="") as text:
        measured = list(csv.DictReader(text))
    return [
        page(each, [row for row in measured if row["effect"] == each.name()], folder)
        for each in EFFECTS
    ]


def page(effect: type[Effect], measured: Sequence[dict[str, str]], folder: Path) -> Page:
    """The page of one effect."""
    name, told = effect.name(), Docstring.of(effect)
    about = [each for each in told.paragraphs[1:] if not each.startswith(HEADS)]
    parts = [f"# `{name}`", f"{inline(told.paragraphs[0])} It is one of the effects of the kind "
             f"*{effect.kind}*.", *map(block, about)]  # fmt: skip
    if measured:
        parts.append(fingerprint(effect, measured, folder))
    known = "\n".join(told.paragraphs)
    found = re.split(rf"^({'|'.join(HEADS)}):", known, flags=re.M)
    for head, text in zip(found[1::2], found[2::2], strict=True):
        parts.append(f"**{head}.** {inline(text)}")
    parts += ["## Parameters", parameters(effect), switch(effect)]
    parts.append(file_of(Path(str(inspect.getsourcefile(effect))).resolve()))
    return Page(name, f"`{name}`", told.title, "\n\n".join(filter(None, parts)) + "\n")


def parameters(effect: type[Effect]) -> str:
    """The keys of the effect's table."""
    priors, rows = effect.priors(), []
    for key, info in effect.model_fields.items():
        prior = priors.get(key)
        default = list(info.default) if isinstance(info.default, tuple) else info.default
        rows.append([
            f"`{key}`", unit(key) or "–", inline(info.description or ""), inline(str(default)),
            f"{prior.mean:g} ± {prior.spread:g}" if prior else "–",
            inline(prior.source) if prior else "–",
        ])  # fmt: skip
    if not rows:
        return "It has no parameters."
    return table(["key", "unit", "meaning", "default", "prior", "where the prior is from"], rows)


def switch(effect: type[Effect]) -> str:
    """How a configuration has it."""
    keys = [key for key in effect.model_fields if effect.model_fields[key].default is not None]
    lines = [f"[extensions.{effect.name()}]"]
    for key in keys:
        value = effect.model_fields[key].default
        text = list(value) if isinstance(value, tuple) else value
        if isinstance(text, bool):
            text = str(text).lower()
        lines.append(f"{key} = {text!r}".replace("'", '"') if isinstance(text, str)
                     else f"{key} = {text}")  # fmt: skip
    return "```toml\n" + "\n".join(lines) + "\n```"


def fingerprint(effect: type[Effect], rows: Sequence[dict[str, str]], folder: Path) -> str:
    """How it changes the reference finger, at its default values."""
    module = importlib.import_module(effect.__module__)
    name = module.__name__.rpartition(".")[2]
    pressures = (0.0, HIGHEST_kPa / 2, HIGHEST_kPa, HIGHEST_kPa / 2, 0.0)
    said = []
    for quantity, of in (("angle", "tip's angle (°)"), ("force", "blocked force (N)")):
        lines = {}
        for row in rows:
            changes = [row[f"{quantity}_change_{place}_{UNITS[quantity]}"] for place in PLACES]
            rate = row["rate_kPa_per_s"]
            label = "any rate" if rate == "any" else f"{rate} kPa/s"
            lines[label] = [0.0, *(float(each) for each in changes if each)]
        if not any(any(line) for line in lines.values()):
            said.append(f"It does not change the {of.split(' (')[0]}.")
            continue

        def draw(axes: Axes, lines: dict[str, list[float]] = lines, of: str = of) -> None:
            for (label, line), colour in zip(lines.items(), (theme.BLUE, theme.ORANGE),
                                             strict=False):  # fmt: skip
                there = pressures[: len(line)]
                axes.plot(there[:3], line[:3], "o-", color=colour, ms=4, label=f"{label}, loading")
                if len(line) > 3:
                    axes.plot(there[2:], line[2:], "s--", color=colour, ms=4,
                              label=f"{label}, unloading")  # fmt: skip
            axes.axhline(0, color=theme.GREY, lw=0.6)
            axes.set(xlabel="pressure (kPa)", ylabel=f"change of the {of}")
            axes.legend()

        picture(folder / f"{name}_{quantity}.png", draw)
        said.append(f"![change of the {of} by {name}]({name}_{quantity}.png)")
    return "\n\n".join(said)
