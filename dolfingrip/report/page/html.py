"""The page as one HTML file: nothing is fetched, nothing but the bundled scripts runs.

Text of data files is escaped: Jinja escapes all that the template prints, and the data of scripts
stand in a JSON block in which no "<" occurs.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from itertools import zip_longest
from typing import Any, Final

import numpy as np
from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from dolfingrip.charts.chart import Axis, Chart, Numbers
from dolfingrip.files.text_table import TextTable
from dolfingrip.report.page.content import Front, Page, as_data, plain
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.scene import shown_fields
from dolfingrip.version import __version__

LARGEST_MB: Final = 15.0
"""Size that a page does not exceed."""

COLOURS: Final = ("c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8")
"""Classes of a chart's curves, in order; colours of Okabe and Ito."""

NAMED: Final = {"blue": "c1", "orange": "c2", "green": "c3", "purple": "c4", "ink": "ink",
                "grey": "c8", "pale": "c8"}  # fmt: skip
"""Classes of curves whose colour is told."""

STYLES: Final = {"line": "line", "dash": "dash", "dots": "dash", "points": "points"}
"""Styles of the page's script, by those of charts."""

PACKAGE: Final = "dolfingrip.report.page"


def rendered(page: Page) -> str:
    """The HTML of a page.

    Args:
        page: what it shows.

    Returns:
        One file that fetches nothing.
    """
    scripts = [script("vendor.js"), script("report.js")]
    style = asset("report.css")
    every = [*page.charts, *(chart for part in page.diagnoses for chart in part.charts)]
    charts = [{"id": f"chart-{i}", **drawing} for i, drawing in enumerate(charts_data(every))]
    return (
        templates()
        .get_template("report.html.j2")
        .render(
            page=page,
            charts=charts,
            bars=bars,
            version=__version__,
            policy=content_policy(scripts, style),
            style=Markup(style),
            scripts=[Markup(text) for text in scripts],
            data=Markup(json_text(_data(page, charts))),
            licences=licences("report.js"),
            stills=[(alt, base64.b64encode(png).decode("ascii")) for alt, png in page.stills],
            sign={"pass": "✓", "fail": "✗", "open": "○", "": ""},
            colours=COLOURS,
        )
    )


def templates(*packages: str) -> Environment:
    """Templates of these packages and of this one; what they print is escaped."""
    return Environment(
        loader=ChoiceLoader([PackageLoader(name, "templates") for name in (*packages, PACKAGE)]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def licences(script: str) -> list[dict[str, str]]:
    """Full texts of the licences of what is inside the page with this script of its own.

    Args:
        script: name of the bundled script.

    Returns:
        The licences, with name and version of each part.
    """
    facts = json.loads(asset("bundle.json"))
    gpl = asset("gpl-3.0.txt")
    return [
        {
            **part,
            "version": part["version"] or __version__,
            "text": part["licence_text"] or gpl,
        }
        for part in facts["parts"]
        if part["file"] in ("vendor.js", script)
    ]


def charts_data(charts: Sequence[Chart]) -> list[dict[str, Any]]:
    """Write charts as ``web/src/chart.js`` reads them.

    Args:
        charts: without bars.

    Returns:
        Their plain data with colours, and a table of the numbers of those that are no drawing.
    """
    return [
        {**_chart_data(chart), "table": None if chart.equal else as_data(table(chart))}
        for chart in charts
    ]


def _chart_data(chart: Chart) -> dict[str, Any]:
    free = iter(
        [key for key in COLOURS if key not in {NAMED.get(s.colour) for s in chart.series}] * 9
    )
    colour, name, series = "ink", "", []
    for line in chart.series:
        if line.colour or line.name:  # else it belongs to the one before it
            name = line.name or name
            colour = NAMED[line.colour] if line.colour else next(free)
        series.append(
            {
                "name": name, "key": bool(line.name), "colour": colour, "scene": line.scene,
                "dots": line.style == "points" or bool(line.marker) or line.branches is not None,
                "style": STYLES[line.style], "x": _scaled(line.x, chart.x),
                "y": _scaled(line.y, chart.y), "low": _scaled(line.low, chart.y),
                "high": _scaled(line.high, chart.y),
            }
        )  # fmt: skip
    data: dict[str, Any] = plain(
        {
            "equal": chart.equal,
            "below": chart.below and _chart_data(chart.below),
            "title": chart.title,
            "alt": chart.description,
            "note": chart.note,
            "x": _axis(chart.x),
            "y": _axis(chart.y),
            "series": series,
            "limits": [
                {"y": _scaled([mark.at], chart.y)[0], "label": mark.label}
                for mark in chart.marks
                if mark.axis == "y"
            ],
        }
    )
    return data


def _scaled(values: Numbers | None, axis: Axis) -> Any:
    """Values as the page draws them: it has no logarithmic scale."""
    if values is None:
        return None
    return np.log10(np.asarray(values, dtype=float)) if axis.log else np.asarray(values)


def _axis(axis: Axis) -> dict[str, Any]:
    ends = axis.ends if axis.ends and None not in axis.ends else None
    label = f"log₁₀ of the {axis.short or axis.label}" if axis.log else axis.label
    return {"label": label, "unit": "" if axis.log else axis.unit, "ends": ends}


def table(chart: Chart) -> TextTable:
    """Write the numbers of a chart as a table.

    Args:
        chart: without bars.

    Returns:
        A column for the horizontal axis, and one for each curve, those of the chart below included;
        a curve over values of its own has a column of them, too.
    """
    headings: list[str] = []
    columns: list[list[str]] = []
    x: Numbers = []
    below = chart.below
    shown = [(curve, chart.y) for curve in chart.series]
    shown += [(curve, below.y) for curve in below.series] if below else []
    for curve, up in shown:
        if len(x) != len(curve.x) or not np.allclose(x, curve.x, equal_nan=True):
            x = curve.x
            headings.append(chart.x.label)
            columns.append([said(float(value)) for value in x])
        unit = f" ({up.unit})" if up.unit else ""
        name = f"{curve.name}, {up.short}" if below and up is below.y else curve.name
        headings.append(f"{name}{unit}" if curve.name else up.label)
        columns.append([said(float(value)) for value in curve.y])
    return TextTable(headings, list(zip_longest(*columns, fillvalue="")))


def bars(chart: Chart) -> list[dict[str, Any]]:
    """Write the bars of a chart for the page's template.

    Args:
        chart: with one bar for each name.

    Returns:
        Name, length as a part of 1, and text of each bar, in the order of the names.
    """
    placed = []
    for series in chart.series:
        for place, length, text in zip(series.y, series.x, series.said, strict=True):
            placed.append(
                (place, {"name": chart.y.names[int(place)], "share": length, "said": text})
            )
    return [bar for _, bar in sorted(placed, key=lambda pair: pair[0])]


def _data(page: Page, charts: list[dict[str, Any]]) -> dict[str, Any]:
    shown = [{k: v for k, v in chart.items() if k != "table"} for chart in charts]
    front = front_data(page.front) if page.front else None
    return {"scenes": page.scenes, "charts": shown, "front": front, "fields": shown_fields()}


def front_data(front: Front) -> dict[str, Any]:
    """A front as ``web/src/chart.js`` reads it.

    Args:
        front: designs and their shapes.

    Returns:
        Plain data.
    """
    models = list(front.models)  # packed already
    content = as_data(replace(front, models=[]))
    line = content["line"]
    return {
        **content,
        "models": models,
        "line": None if line is None else {"x": line[0], "y": line[1]},
        "alt": front.title,
    }


def json_text(content: dict[str, Any]) -> str:
    """Data of scripts, to stand in a page.

    Args:
        content: plain data.

    Returns:
        JSON in which no "<" occurs.
    """
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def script(name: str) -> str:
    """A bundled script, to stand in a page.

    Args:
        name: of its file.

    Returns:
        Its text.
    """
    text = asset(name)
    # what would end the element, or open a comment in it
    assert not any(mark in text.lower() for mark in ("</script", "<!--")), name
    return text


def asset(name: str) -> str:
    """A bundled text.

    Args:
        name: of its file.

    Returns:
        The text.
    """
    return resources.files(PACKAGE).joinpath("bundle", name).read_text(encoding="utf-8")


def content_policy(scripts: list[str], style: str, connect: str = "'none'") -> str:
    """Content-Security-Policy: these scripts and this style alone.

    Args:
        scripts: texts of the page's scripts.
        style: text of its style sheet.
        connect: where scripts may connect to.
    """

    def hashes(texts: list[str]) -> str:
        digests = (hashlib.sha256(text.encode("utf-8")).digest() for text in texts)
        return " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)

    return (
        f"default-src 'none'; script-src {hashes(scripts)}; style-src {hashes([style])}; "
        f"img-src data: blob:; connect-src {connect}; base-uri 'none'; form-action 'none'"
    )
