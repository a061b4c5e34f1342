"""The explorer's page."""

from __future__ import annotations

from markupsafe import Markup

import dolfingrip
from dolfingrip.explore.space import Space
from dolfingrip.foods.index import KINDS
from dolfingrip.report.page import front, html
from dolfingrip.report.page.scene import palettes
from dolfingrip.sections.gripper import ALPHA_DEG

PACKAGE = "dolfingrip.explore"


def rendered(space: Space, view: str) -> tuple[str, str]:
    """The page, and its Content-Security-Policy.

    Args:
        space: what varies.
        view: experiment that is shown first.
    """
    scripts = [html.script("vendor.js"), html.script("explore.js")]
    style = html.asset("report.css") + html.asset("explore.css")
    designs = front.front(space.loop, most_shapes=0)
    axes = [] if designs is None else _axes(space)
    data = {
        "sliders": space.sliders,
        "palettes": palettes(),
        "front": None if designs is None else html.front_data(designs),
        "alpha_deg": ALPHA_DEG,
        "axes": axes,
        "view": view,
    }
    text = (
        html.templates(PACKAGE)
        .get_template("explore.html.j2")
        .render(
            style=Markup(style),
            scripts=[Markup(each) for each in scripts],
            data=Markup(html.json_text(data)),
            sliders=space.sliders,
            front=designs,
            axes=axes,
            view=view,
            poses=list(ALPHA_DEG),
            foods=[kind for kind in KINDS if kind != "file"],
            gripper=space.base.gripper,
            food=space.base.food,
            licences=html.licences("explore.js"),
            version=dolfingrip.__version__,
        )
    )
    return text, html.content_policy(scripts, style, "'self'")


def _axes(space: Space) -> list[str]:
    """Names of the front's two outputs."""
    return list(space.surrogate.output_names[:2]) if space.surrogate else []
