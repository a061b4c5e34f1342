"""The page as one HTML file: nothing is fetched, nothing but the bundled scripts runs.

Text of data files is escaped: Jinja escapes all that the template prints, and the data of scripts
stand in a JSON block in which no "<" occurs.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, Final

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

import dolfingrip
from dolfingrip.report.page.content import Chart, Front, Page, as_data
from dolfingrip.report.page.scene import palettes

LARGEST_MB: Final = 15.0
"""Size that a page does not exceed."""

COLOURS: Final = ("c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8")
"""Classes of a chart's curves, in order; colours of Okabe and Ito."""

PACKAGE: Final = "dolfingrip.report.page"


@dataclass(frozen=True, slots=True)
class Licence:
    """A licence of something inside the page."""

    name: str
    version: str
    licence: str
    sha256: str
    text: str


def rendered(page: Page) -> str:
    """The HTML of a page."""
    scripts = [script("vendor.js"), script("report.js")]
    style = asset("report.css")
    charts = [{"id": f"chart-{i}", **e} for i, e in enumerate(charts_data(page.all_charts()))]
    return (
        templates()
        .get_template("report.html.j2")
        .render(
            page=page,
            charts=charts,
            version=dolfingrip.__version__,
            policy=content_policy(scripts, style),
            style=Markup(style),
            scripts=[Markup(each) for each in scripts],
            data=Markup(json_text(_data(page, charts))),
            licences=licences("report.js"),
            stills=[(alt, _image(content)) for alt, content in page.stills],
            sign={"pass": "✓", "fail": "✗", "open": "○", "": ""},
            colours=COLOURS,
        )
    )


def templates(*packages: str) -> Environment:
    """Templates of these packages and of this one; what they print is escaped."""
    return Environment(
        loader=ChoiceLoader([PackageLoader(each, "templates") for each in (*packages, PACKAGE)]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def licences(script: str) -> list[Licence]:
    """Full texts of the licences of what is inside the page with this script of its own."""
    facts = json.loads(asset("bundle.json"))
    own = asset("gpl-3.0.txt")
    return [
        Licence(
            part["name"],
            part["version"] or dolfingrip.__version__,
            part["licence"],
            part["sha256"],
            part["licence_text"] or own,
        )
        for part in facts["parts"]
        if part["file"] in ("vendor.js", script)
    ]


def charts_data(charts: Sequence[Chart]) -> list[dict[str, Any]]:
    """Charts as ``web/src/chart.js`` reads them, with colours."""
    found = []
    for chart in charts:
        data = as_data(chart)
        colours = _colours([each["style"] for each in data["series"]])
        for series, colour in zip(data["series"], colours, strict=True):
            series["colour"] = colour
        found.append(data)
    return found


def _colours(styles: list[str]) -> list[str]:
    """Colours in order; measured points are those of ink."""
    rest = iter(COLOURS * (1 + len(styles) // len(COLOURS)))
    return ["ink" if style == "points" else next(rest) for style in styles]


def _data(page: Page, charts: list[dict[str, Any]]) -> dict[str, Any]:
    shown = [{k: v for k, v in chart.items() if k != "table"} for chart in charts]
    front = front_data(page.front) if page.front else None
    return {"scenes": page.scenes, "charts": shown, "front": front, "palettes": palettes()}


def front_data(front: Front) -> dict[str, Any]:
    """A front as ``web/src/chart.js`` reads it."""
    models = list(front.models)  # packed already
    found = as_data(replace(front, models=[]))
    line = found["line"]
    return {
        **found,
        "models": models,
        "line": None if line is None else {"x": line[0], "y": line[1]},
        "alt": front.title,
    }


def json_text(content: dict[str, Any]) -> str:
    """Data of scripts, to stand in a page."""
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def script(name: str) -> str:
    """A bundled script, to stand in a page."""
    text = asset(name)
    # what would end the element, or open a comment in it
    assert not any(mark in text.lower() for mark in ("</script", "<!--")), name
    return text


def asset(name: str) -> str:
    """A bundled text."""
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
        return " ".join(f"'sha256-{base64.b64encode(each).decode()}'" for each in digests)

    return (
        f"default-src 'none'; script-src {hashes(scripts)}; style-src {hashes([style])}; "
        f"img-src data: blob:; connect-src {connect}; base-uri 'none'; form-action 'none'"
    )


def _image(content: Path | bytes) -> str:
    data = content if isinstance(content, bytes) else content.read_bytes()
    return f"data:image/png;base64,{base64.b64encode(data).decode('ascii')}"
