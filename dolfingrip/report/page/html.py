"""The page as one HTML file: nothing is fetched, nothing but the bundled scripts runs.

Text of data files is escaped: Jinja escapes all that the template prints, and the data of scripts
stand in a JSON block in which no "<" occurs.
"""

from __future__ import annotations

import base64
import hashlib
import json
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

import dolfingrip
from dolfingrip.report.page.content import Page, as_data
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


def written(page: Page, file: Path) -> Path:
    """Write a page.

    Raises:
        OSError: if it cannot be written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(rendered(page), encoding="utf-8")
    part.replace(file)
    return file


def rendered(page: Page) -> str:
    """The HTML of a page."""
    scripts = [_script("vendor.js"), _script("report.js")]
    style = _asset("report.css")
    environment = Environment(
        loader=PackageLoader(PACKAGE, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    charts = [{"id": f"chart-{i}", **each} for i, each in enumerate(_charts(page))]
    return environment.get_template("report.html.j2").render(
        page=page,
        charts=charts,
        version=dolfingrip.__version__,
        policy=_policy(scripts, style),
        style=Markup(style),
        scripts=[Markup(each) for each in scripts],
        data=Markup(_json(_data(page, charts))),
        licences=licences(),
        stills=[(alt, _image(content)) for alt, content in page.stills],
        sign={"pass": "✓", "fail": "✗", "open": "○", "": ""},
        colours=COLOURS,
    )


def licences() -> list[Licence]:
    """Full texts of the licences of what is inside a page."""
    facts = json.loads(_asset("bundle.json"))
    own = _asset("gpl-3.0.txt")
    return [
        Licence(
            part["name"],
            part["version"] or dolfingrip.__version__,
            part["licence"],
            part["sha256"],
            part["licence_text"] or own,
        )
        for part in facts["parts"]
    ]


def _charts(page: Page) -> list[dict[str, Any]]:
    found = []
    for chart in page.all_charts():
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
    front = as_data(page.front) if page.front else None
    if front is not None and page.front is not None:
        front["models"] = list(page.front.models)  # packed already
        line = front["line"]
        front["line"] = None if line is None else {"x": line[0], "y": line[1]}
        front["alt"] = front["title"]
    return {"scenes": page.scenes, "charts": shown, "front": front, "palettes": palettes()}


def _json(content: dict[str, Any]) -> str:
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _script(name: str) -> str:
    text = _asset(name)
    # what would end the element, or open a comment in it
    assert not any(mark in text.lower() for mark in ("</script", "<!--")), name
    return text


def _asset(name: str) -> str:
    return resources.files(PACKAGE).joinpath("bundle", name).read_text(encoding="utf-8")


def _policy(scripts: list[str], style: str) -> str:
    """Content-Security-Policy: these scripts and this style alone, no request at all."""

    def hashes(texts: list[str]) -> str:
        digests = (hashlib.sha256(text.encode("utf-8")).digest() for text in texts)
        return " ".join(f"'sha256-{base64.b64encode(each).decode()}'" for each in digests)

    return (
        f"default-src 'none'; script-src {hashes(scripts)}; style-src {hashes([style])}; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


def _image(content: Path | bytes) -> str:
    data = content if isinstance(content, bytes) else content.read_bytes()
    return f"data:image/png;base64,{base64.b64encode(data).decode('ascii')}"
