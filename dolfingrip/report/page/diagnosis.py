"""The section on a diagnosis, from ``diagnosis.json`` and the tables beside it.

What is missing is left out: a page of an older or newer diagnosis shows what it has. Of the tables,
``readings.csv`` is read: a row for each reading, with the columns channel, experiment, specimen,
branch, pressure_kPa, displacement_mm, value, noise (one standard deviation), configured, before
(nuisances fitted) and after (with the cause).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.channels import CHANNELS, DISPLACEMENT, PRESSURE
from dolfingrip.report.page.content import (
    Axis,
    Bar,
    Chart,
    DiagnosisPart,
    KeyNumber,
    Limit,
    Series,
    Source,
    Style,
    Table,
    Verdict,
)
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.sources import read_json

LINES: Final = 10
"""Lines at the head of the section."""

BAND_STD: Final = 2.0
"""Half width of the noise bands, in standard deviations."""

LEAST_SHARE: Final = 0.005
"""Probability below which a cause has no bar."""

BY_CHANCE: Final = 0.046
"""Share of readings that noise alone puts outside two standard deviations."""

WAYS: Final = (
    ("configured", "as configured"),
    ("before", "nuisances fitted"),
    ("after", "with the cause"),
)


def read(folder: Path) -> DiagnosisPart:
    """The section of a diagnosis.

    Raises:
        ConfigError: one line, if ``diagnosis.json`` cannot be read.
    """
    found = read_json(folder / "diagnosis.json")
    readings = _readings(folder)
    charts = [] if readings is None else [*_overlays(readings), *_residuals(readings)]
    return DiagnosisPart(
        "Diagnosis", [_labelled(line) for line in _lines(folder, found)], _bars(found), charts,
        _tables(found),
        _unexplained(found, readings),
    )  # fmt: skip


def numbers(folder: Path) -> list[KeyNumber]:
    """The answer and its probability, for the head of the page."""
    verdict = _table(read_json(folder / "diagnosis.json"), "verdict")
    answer = str(verdict.get("answer", "")) or "–"
    causes = _words(verdict.get("class"))
    value = causes or {"none": "no cause", "unknown": "unknown cause"}.get(answer, answer)
    chance = verdict.get("probability")
    words = f"probability {said(chance)}" if isinstance(chance, float | int) else ""
    kind: Verdict = {"cause": "fail", "unknown": "open", "none": "pass"}.get(answer, "")  # type: ignore[assignment]
    return [KeyNumber("Diagnosis", value, kind, words)]


def source(folder: Path) -> Source:
    """Where it comes from."""
    found = read_json(folder / "diagnosis.json")
    data = found.get("data") or ()
    again = f"dolfingrip diagnose {' '.join(map(str, data))}" if data else ""
    facts = [("dolfingrip", str(found["version"]))] if "version" in found else []
    extended = folder / "extended.toml"
    files = []
    if extended.is_file():
        files.append(("Extended configuration", extended.read_text(encoding="utf-8")))
    return Source("Diagnosis", str(folder), again, facts, files)


def _table(content: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = content.get(key)
    return found if isinstance(found, Mapping) else {}


def _list(content: Mapping[str, Any], key: str) -> Sequence[Any]:
    found = content.get(key)
    return found if isinstance(found, list | tuple) else ()


def _words(names: Any) -> str:
    """Names of effects in words; several of a class cannot be told apart."""
    if isinstance(names, str):
        names = [names]
    return " or ".join(str(name).replace("_", " ") for name in names or ())


def _lines(folder: Path, found: Mapping[str, Any]) -> list[str]:
    """The first ten lines of the summary; else the verdict's sentence and those on differences."""
    summary = folder / "summary.md"
    if summary.is_file():
        text = summary.read_text(encoding="utf-8").splitlines()
        told = [line.lstrip("#- ").strip() for line in text if line.strip() and "|" not in line]
        if told:
            return told[:LINES]
    verdict = _table(found, "verdict")
    lines = [str(verdict.get("sentence") or verdict.get("answer") or "no verdict")]
    if verdict.get("class"):
        lines.append(f"cause: {_words(verdict['class'])}")
    if verdict.get("second"):
        lines.append(f"second cause: {_words(verdict['second'])}")
    if "unexplained" in verdict:
        lines.append(f"unexplained: {_in_words(verdict['unexplained'])}")
    lines += [str(each) for each in _list(found, "sentences")]
    return lines[:LINES]


def _labelled(line: str) -> tuple[str, str]:
    """A line's label in capitals, such as "NOT EXPLAINED", and the rest."""
    words = line.split(" ")
    label = list(takewhile(lambda word: word.isalpha() and word.isupper(), words))
    return " ".join(label), " ".join(words[len(label) :])


def _in_words(value: Any) -> str:
    if isinstance(value, float | int) and not isinstance(value, bool):
        return said(float(value))
    if isinstance(value, list | tuple):
        return ", ".join(_in_words(each) for each in value)
    if isinstance(value, Mapping):
        return "; ".join(f"{key} {_in_words(each)}" for key, each in value.items())
    return str(value)


def _bars(found: Mapping[str, Any]) -> list[Bar]:
    bars = []
    for each in _list(found, "causes"):
        chance = each.get("probability") if isinstance(each, Mapping) else None
        if isinstance(chance, float | int) and chance >= LEAST_SHARE:
            bars.append(Bar(_words([each.get("name")]), float(chance), _chance(float(chance))))
    for key, name in (("none", "none: noise alone"), ("unknown", "unknown: not in the catalogue")):
        chance = found.get(key)
        if isinstance(chance, float | int):
            bars.append(Bar(name, float(chance), _chance(float(chance))))
    return bars


def _chance(share: float) -> str:
    return "< 0.001" if share < 0.001 else said(share)


def _tables(found: Mapping[str, Any]) -> list[Table]:
    tables = []
    fits = [each for each in _list(found, "fits") if isinstance(each, Mapping)]
    if fits:
        rows = []
        best = max(float(fit.get("log_evidence") or 0) for fit in fits)
        for fit in sorted(fits, key=lambda each: -float(each.get("log_evidence") or 0)):
            values = "; ".join(f"{p.get('key')} = {_interval(p)}" for p in _list(fit, "parameters"))
            name = " with ".join(map(str, fit.get("effects") or ())) or "none"
            below = float(fit.get("log_evidence") or 0) - best
            rows.append([name.replace("_", " "), f"{below:z.1f}", values])
        headings = ["Cause", "ln evidence less the best", "Fitted (central 90 %)"]
        tables.append(Table(headings, rows, "What each cause explains"))
    gain = [each for each in _list(found, "gain") if isinstance(each, Mapping)]
    if gain:
        rows = [
            [f"{_label(str(each.get('channel')))}, {each.get('left_out')} left out",
             *(said(each.get(key)) for key in ("before", "nuisances", "process", "cause"))]
            for each in gain
        ]  # fmt: skip
        headings = ["Error on readings left out", "as configured", "nuisances fitted",
                    "free curve fitted", "with the cause"]  # fmt: skip
        tables.append(Table(headings, rows, "Before and after"))
    downstream = _table(found, "downstream")
    designs = [each for each in _list(downstream, "designs") if isinstance(each, Mapping)]
    if designs:
        rows = [
            [_in_words(each.get("inputs") or {}), said(each.get("force_before_N")),
             said(each.get("force_after_N"))]
            for each in designs
        ]  # fmt: skip
        headings = ["Design", "force before (N)", "force after (N)"]
        tables.append(Table(headings, rows, "Best designs, before and after"))
    following = [each for each in _list(found, "next_experiments") if isinstance(each, Mapping)]
    if following:
        rows = [
            [str(each.get("name")), said(each.get("minutes")), said(each.get("gain"))]
            for each in following
        ]
        headings = ["Experiment", "minutes", "expected ln Bayes factor"]
        tables.append(Table(headings, rows, "What to measure next"))
    return tables


def _interval(parameter: Mapping[str, Any]) -> str:
    """A fitted number with its interval."""
    value, low, high = (said(parameter.get(key)) for key in ("value", "low", "high"))
    return f"{value} ({low} to {high})"


def _unexplained(found: Mapping[str, Any], readings: pd.DataFrame | None) -> list[str]:
    """What stays unexplained, and where."""
    lines = []
    brief, share = _table(found, "brief"), _table(found, "verdict").get("unexplained")
    if brief.get("not_explained"):
        lines.append(f"Of what the model misses: {brief['not_explained']}")
    elif isinstance(share, float | int):
        lines.append(f"Of what the model misses: {100 * share:.2g} %")
    for key in ("unexplained", "not_reached", "suspicions", "warnings"):
        lines += [_in_words(each) for each in _list(found, key)]
    if readings is not None and {"after", "noise"} <= set(readings.columns):
        for title, channel, part in _panels(readings):
            off = np.abs(part["value"] - part["after"]) > BAND_STD * part["noise"]
            share = float(off.mean())
            if share > BY_CHANCE and off.sum() > 1:
                along = _along(part)
                where = part.loc[off, along.name]
                lines.append(
                    f"{title}, {CHANNELS[channel].title.lower()}: {100 * share:.0f} % of the "
                    f"readings lie outside two standard deviations, from "
                    f"{said(float(where.min()))} to {said(float(where.max()), along.symbol)}"
                )
    return lines


def _label(channel: str) -> str:
    return CHANNELS[channel].label if channel in CHANNELS else channel


def _readings(folder: Path) -> pd.DataFrame | None:
    """The table of readings; None if there is none that can be drawn."""
    file = folder / "readings.csv"
    if not file.is_file():
        return None
    table = pd.read_csv(file)
    if not {"channel", "experiment", "value", "noise"} <= set(table.columns):
        return None
    table = table[table["channel"].isin(list(CHANNELS))]
    return table if len(table) else None


def _panels(readings: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    """Title, channel and rows of each panel: a channel of an experiment and specimen."""
    keys = [key for key in ("experiment", "specimen", "channel") if key in readings]
    found = []
    for names, part in readings.groupby(keys, sort=False, dropna=False):
        words = [str(name).replace("_", " ") for name in names[:-1]]
        found.append((", ".join(words), str(names[-1]), part))
    return found


def _along(part: pd.DataFrame) -> Any:
    """What a panel is drawn over: pressure, else travel."""
    for channel in (PRESSURE, DISPLACEMENT):
        if channel.name in part and part[channel.name].notna().all():
            return channel
    return PRESSURE


def _branches(part: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    if "branch" not in part:
        return [("", part)]
    return [(str(name), own) for name, own in part.groupby("branch", sort=False, dropna=False)]


def _overlays(readings: pd.DataFrame) -> list[Chart]:
    """Measured readings with their noise band, and the simulation before and after."""
    found = []
    for title, channel, part in _panels(readings):
        along = _along(part)
        if along.name not in part:
            continue
        series, rows = [], []
        for branch, own in _branches(part):
            own = own.sort_values(along.name)
            x, y, noise = (own[key].to_numpy(float) for key in (along.name, "value", "noise"))
            name = f"measured, {branch}" if branch else "measured"
            series.append(
                Series(name, x, y, "points", None, y - BAND_STD * noise, y + BAND_STD * noise)
            )
            known = [(key, words) for key, words in WAYS if key in own]
            for key, words in known:
                style: Style = "dash" if key != "after" else "line"
                name = f"{words}, {branch}" if branch else words
                series.append(Series(name, x, own[key].to_numpy(float), style))
            for _, row in own.iterrows():
                cells = [
                    row[along.name],
                    row["value"],
                    row["noise"],
                    *(row[key] for key, _ in known),
                ]
                rows.append([said(float(value)) for value in cells] + [branch])
        known_words = [words for key, words in WAYS if key in part]
        headings = [along.label, "measured", "noise (1 σ)", *known_words, "branch"]
        of = CHANNELS[channel]
        found.append(
            Chart(
                f"{title}: {of.title.lower()}",
                f"{title}: measured {of.title.lower()} with its noise, and the simulation.",
                Axis(along.label, along.symbol), Axis(of.label, of.symbol), series,
                Table(headings, rows), section="diagnosis",
                note="Bands: two standard deviations of the measurement's noise.",
            )
        )  # fmt: skip
    return found


def _residuals(readings: pd.DataFrame) -> list[Chart]:
    """Measured less simulated by the noise, before and after, channel by channel and branch."""
    found = []
    for title, channel, part in _panels(readings):
        along = _along(part)
        if along.name not in part:
            continue
        series, rows = [], []
        for branch, own in _branches(part):
            own = own.sort_values(along.name)
            x = own[along.name].to_numpy(float)
            for key, words in WAYS[1:]:
                if key not in own:
                    continue
                by_noise = ((own["value"] - own[key]) / own["noise"]).to_numpy(float)
                name = f"{words}, {branch}" if branch else words
                series.append(Series(name, x, by_noise, "dash" if key == "before" else "line"))
                rows += [[said(a), said(b), name] for a, b in zip(x, by_noise, strict=True)]
        if not series:
            continue
        of = CHANNELS[channel]
        found.append(
            Chart(
                f"{title}: residuals of the {of.title.lower()}",
                f"{title}: measured less simulated {of.title.lower()}, by the noise.",
                Axis(along.label, along.symbol), Axis("Measured less simulated (σ)", "σ"), series,
                Table([along.label, "residual (σ)", "of"], rows),
                limits=[Limit(2.0, "±2 σ"), Limit(-2.0, "")], section="diagnosis",
            )
        )  # fmt: skip
    return found
