"""Pages of the terms of the potential in ``dolfingrip/mechanics``."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from docstrings import Docstring, inline, table
from matplotlib.axes import Axes
from pages import Page, file_of, picture

import dolfingrip.mechanics
from dolfingrip.charts import theme
from dolfingrip.mechanics.contact.density import Smooth, TwoStage
from dolfingrip.mechanics.contact.friction import Ramp
from dolfingrip.mechanics.model.term import Term

CAPABILITIES = (
    ("couplings", "second derivatives beside those that elements integrate"),
    ("tangent_forms", "second derivatives that elements integrate"),
    ("max_step", "a bound on Newton's steps"),
    ("rejects", "a check of converged states"),
    ("commit", "a memory of the last accepted step"),
    ("update_lagged", "quantities that lag while Π is minimised"),
    ("add_shape_gradient", "derivatives by the mesh's coordinates"),
)


def pages(folder: Path) -> list[Page]:
    """A page for each kind of term."""
    return [page(each, folder) for each in kinds()]


def kinds() -> list[type[Term]]:
    """All kinds of terms in the package, by the file."""
    for found in pkgutil.walk_packages(
        dolfingrip.mechanics.__path__, f"{dolfingrip.mechanics.__name__}."
    ):
        importlib.import_module(found.name)

    def below(kind: type[Term]) -> Iterator[type[Term]]:
        for each in kind.__subclasses__():
            yield each
            yield from below(each)

    own = {each for each in below(Term) if each.__module__.startswith("dolfingrip.mechanics")}
    return sorted(own, key=lambda each: each.__module__)


def page(kind: type[Term], folder: Path) -> Page:
    """The page of one kind of term."""
    name = kind.__name__
    whole, file = Docstring.of(kind), Docstring.of(importlib.import_module(kind.__module__))
    parts = [f"# {name}", inline(f"{whole.title}."), inline(file.paragraphs[0])]
    if name in PICTURES:
        picture(folder / f"{name}.png", PICTURES[name])
        parts.append(f"![{name}: curve]({name}.png)")
    parts.append(whole.body())
    rows = [[f"`{key}`", inline(about)] for key, about in (*whole.items("Args"),
                                                          *whole.items("Attributes"))]  # fmt: skip
    if rows:
        parts.append(table(["parameter", "meaning"], rows))
    has = [
        [f"`{hook}`", about]
        for hook, about in CAPABILITIES
        if getattr(kind, hook, None) is not None
        and getattr(kind, hook) is not getattr(Term, hook, None)
    ]
    if has:
        parts.append(f"What the solver asks this term for, beside value and gradient:\n\n"
                     f"{table(['method', 'what it gives'], has)}")  # fmt: skip
    parts.append(file_of(Path(str(inspect.getsourcefile(kind))).resolve()))
    return Page(name, name, whole.title, "\n\n".join(filter(None, parts)) + "\n")


def _densities(axes: Axes) -> None:
    gaps = np.linspace(0.02, 1.2, 100)
    for kind, colour, label in (
        (TwoStage, theme.BLUE, "two stages, at the plate"),
        (Smooth, theme.ORANGE, "smooth logarithm, between bellows"),
    ):
        axes.plot(gaps, -kind(1.0, 1.0).at(gaps).slope, color=colour, label=label)
    axes.set(xlabel="distance / width g/ĝ (–)", ylabel="contact pressure / κ (–)",
             xlim=(0, None), ylim=(0, 3))  # fmt: skip
    axes.legend(loc="center right")


def _friction(axes: Axes) -> None:
    slid = np.linspace(0, 0.05, 100)
    axes.plot(slid, slid * Ramp(0.02).per_slip(slid), color=theme.BLUE)
    axes.axvline(0.02, color=theme.GREY, lw=0.8, ls="--")
    axes.annotate("ε", (0.02, 0.1), (3, 0), textcoords="offset points")
    axes.set(xlabel="slip |s| (mm)", ylabel="friction force / (μ N) (–)", xlim=(0, None),
             ylim=(0, 1.1))  # fmt: skip


PICTURES: dict[str, Callable[[Axes], None]] = {
    "BarrierContact": _densities,
    "RigidContact": _densities,
    "Friction": _friction,
}
