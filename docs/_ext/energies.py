"""Pages of the energies in ``forms/``."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType, ModuleType

import numpy as np
import ufl
from docstrings import Docstring, inline, table
from matplotlib.axes import Axes
from pages import Page, file_of, picture
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

import dolfingrip.forms
from dolfingrip.charts import theme
from dolfingrip.forms import (
    bulk_modulus,
    chain_rule,
    gent,
    membrane,
    neo_hookean,
    ogden_terms,
    plate,
    polynomial,
    pseudo_elastic,
    saint_venant,
    transient_network,
    transverse_isotropy,
    yielding_network,
)
from dolfingrip.forms.evaluate import number
from dolfingrip.forms.evaluate_many import SOLID, Evaluation, constant

MU_MPa = 1.0
STRETCHES = np.linspace(0.6, 2.5, 60)
COLOURS = (theme.BLUE, theme.ORANGE, theme.GREEN, theme.INK)


def pages(folder: Path) -> list[Page]:
    """A page for each energy."""
    return [page(module, folder) for module in modules()]


def modules() -> Iterator[ModuleType]:
    """Files of ``forms/`` that hold an energy or an observable of a body."""
    for found in pkgutil.iter_modules(dolfingrip.forms.__path__):
        module = importlib.import_module(f"dolfingrip.forms.{found.name}")
        if functions(module):
            yield module


def functions(module: ModuleType) -> list[FunctionType]:
    """Functions of a file that return an integrand over the reference configuration."""
    own = [
        each
        for _, each in inspect.getmembers(module, inspect.isfunction)
        if each.__module__ == module.__name__ and not each.__name__.startswith("_")
    ]
    integrands = [
        each for each in own if re.search(r"(per|its) reference", Docstring.of(each).title)
    ]
    return sorted(integrands, key=lambda each: each.__code__.co_firstlineno)


def page(module: ModuleType, folder: Path) -> Page:
    """The page of one file."""
    name = module.__name__.rpartition(".")[2]
    whole = Docstring.of(module)
    title = name.replace("_", " ").capitalize()
    parts = [f"# {title}", f"{inline(whole.title)}.", whole.body()]
    draw = PICTURES.get(name)
    if draw is not None:
        picture(folder / f"{name}.png", draw)
        parts.append(f"![{title}: curve]({name}.png)")
    for function in functions(module):
        told = Docstring.of(function)
        inner = inspect.signature(function).parameters
        rows = [[f"`{key}`", inline(about)] for key, about in told.items("Args") if key in inner]
        parts += [
            f"## `{name}.{function.__name__}`",
            f"{inline(told.paragraphs[0])}",
            told.body(),
            table(["parameter", "meaning"], rows) if rows else "",
        ]
        if "Example" in told.sections:
            parts.append(f"A test runs this example.\n\n{example(told.sections['Example'])}")
    parts.append(file_of(Path(str(module.__file__)).resolve()))
    return Page(name, title, whole.title, "\n\n".join(filter(None, parts)) + "\n")


def example(text: str) -> str:
    """An example's words and its lines of Python."""
    words = text.split(">>>")[0]
    code = text[text.index(">>>") :]
    return f"{inline(words)}\n\n```python\n{code.rstrip()}\n```"


# -- pictures ------------------------------------------------------------------------------------


def stresses(
    density: Callable[[Expr], Expr], stretches: np.ndarray, *, held: bool = False
) -> np.ndarray:
    """Nominal stresses (MPa) as :func:`dolfingrip.forms.evaluate.nominal_stress` has one."""
    symbol = ufl.Constant(SOLID)
    along = ufl.variable(symbol)
    across = ufl.as_ufl(1.0) if held else 1 / ufl.sqrt(along)
    strains = [(each**2 - 1) / 2 for each in (across, across, along)]
    strain = ufl.as_matrix([[strains[i] if i == j else 0 for j in range(3)] for i in range(3)])
    slope = apply_derivatives(
        apply_algebra_lowering(chain_rule.by_variable(density(strain), along))
    )
    (found,) = Evaluation([slope])({symbol: constant(stretches, by_set=True)})
    return np.asarray(found[0])


def stress(*curves: tuple[str, Callable[[Expr], Expr]],
           held: bool = False, least: float = 0.6) -> Callable[[Axes], None]:  # fmt: skip
    """Draws nominal stress against stretch, a line for each energy."""

    def draw(axes: Axes) -> None:
        stretches = STRETCHES[least <= STRETCHES]
        for (label, density), colour in zip(curves, COLOURS, strict=False):
            axes.plot(stretches, stresses(density, stretches, held=held), color=colour, label=label)
        axes.axhline(0, color=theme.GREY, lw=0.6)
        axes.set(xlabel="stretch λ (–)", ylabel="nominal stress P (MPa)")
        axes.set_title("sides held" if held else "uniaxial, constant volume", fontsize=9)
        axes.legend()

    return draw


def _plate(axes: Axes) -> None:
    gaps = np.linspace(0.005, 0.12, 40)
    for stiffness, colour in zip((1.0, 2.0), COLOURS, strict=False):
        values = [number(plate.energy(ufl.as_ufl(g), ufl.as_ufl(0.1), ufl.as_ufl(stiffness)))
                  for g in gaps]  # fmt: skip
        axes.plot(gaps, values, color=colour, label=f"κ = {stiffness:g} MPa")
    axes.axvline(0.1, color=theme.GREY, lw=0.8, ls="--")
    axes.annotate("ĝ = 0.1 mm", (0.1, axes.get_ylim()[1]), (3, -10), textcoords="offset points")
    axes.set(xlabel="distance g (mm)", ylabel="barrier (mJ/mm²)", xlim=(0, None), ylim=(0, None))
    axes.legend()


def _membrane(axes: Axes) -> None:
    across = np.linspace(-0.12, 0.06, 37)
    for share, colour in zip((1.0, 0.0), COLOURS, strict=False):
        values = [
            number(membrane.isotropic(
                ufl.as_matrix([[0, 0, 0], [0, float(e), 0], [0, 0, 0.1]]), 2.0, 0.3, share))
            for e in across
        ]  # fmt: skip
        axes.plot(across, values, color=colour, label=f"c = {share:g}")
    axes.set(xlabel="strain across, 0.1 along (–)", ylabel="energy (mJ/mm²)")
    axes.legend(title="Yt = 2 N/mm, ν = 0.3")


def _softening(axes: Axes) -> None:
    virgin = np.linspace(0.01, 1, 30)
    for r, colour in zip((1.5, 2.2, 4.0), COLOURS, strict=False):
        kept = []
        for each in virgin:
            w = ufl.variable(ufl.as_ufl(float(each)))
            kept.append(1 + number(ufl.diff(pseudo_elastic.energy(w, 1.0, 1 / r, 0.3, 0.0), w)))
        axes.plot(virgin, kept, color=colour, label=f"r = {r:g}")
    axes.set(xlabel="energy w / largest energy W (–)", ylabel="stress / virgin stress η (–)")
    axes.legend(title="m = 0.3 W")


def _network(axes: Axes) -> None:
    rest = ufl.Identity(3)
    for step, colour in zip((0.1, 1.0, 10.0), COLOURS, strict=False):

        def ramp(strain: Expr, step: float = step) -> Expr:
            return transient_network.energy(strain, MU_MPa, rest, rest, step, 1.0)

        axes.plot(STRETCHES, stresses(ramp, STRETCHES), color=colour, label=f"{step:g} τ")
    axes.set(xlabel="stretch λ (–)", ylabel="overstress P (MPa)")
    axes.legend(title="one ramp within")


PICTURES: dict[str, Callable[[Axes], None]] = {
    "bulk_modulus": stress(
        ("ΔK = 1 MPa", lambda e: bulk_modulus.energy(e, 1.0)),
        ("ΔK = 2 MPa", lambda e: bulk_modulus.energy(e, 2.0)),
        held=True,
    ),
    "gent": stress(
        ("neo-Hooke, μ = 1 MPa", lambda e: neo_hookean.energy(e, MU_MPa, 9.0)),
        (
            "with Gent, Jₘ = 10",
            lambda e: neo_hookean.energy(e, MU_MPa, 9.0) + gent.energy(e, MU_MPa, 0.1),
        ),
        (
            "with Gent, Jₘ = 5",
            lambda e: neo_hookean.energy(e, MU_MPa, 9.0) + gent.energy(e, MU_MPa, 0.2),
        ),
    ),
    "membrane": _membrane,
    "neo_hookean": stress(
        ("μ = 1 MPa", lambda e: neo_hookean.energy(e, 1.0, 9.0)),
        ("μ = 2 MPa", lambda e: neo_hookean.energy(e, 2.0, 18.0)),
    ),
    "ogden_terms": stress(
        ("μ = 1 MPa, α = 2", lambda e: ogden_terms.energy(e, [1.0], [2.0])),
        ("α = 4", lambda e: ogden_terms.energy(e, [1.0], [4.0])),
        ("α = −2", lambda e: ogden_terms.energy(e, [1.0], [-2.0])),
    ),
    "plate": _plate,
    "polynomial": stress(
        ("C₁₀ = 0.5 MPa", lambda e: polynomial.energy(e, {(1, 0): 0.5})),
        ("C₁₀ = C₀₁ = 0.25 MPa", lambda e: polynomial.energy(e, {(1, 0): 0.25, (0, 1): 0.25})),
        ("C₁₀ = 0.5, C₂₀ = 0.05 MPa", lambda e: polynomial.energy(e, {(1, 0): 0.5, (2, 0): 0.05})),
    ),
    "pseudo_elastic": _softening,
    "saint_venant": stress(
        ("Y = 3 MPa, ν = 0.45", lambda e: saint_venant.energy(e, 3.0, 0.45)),
        ("neo-Hooke of the same moduli", lambda e: neo_hookean.energy(e, 3 / 2.9, 9.31)),
    ),
    "transient_network": _network,
    "transverse_isotropy": stress(
        ("k = 1 MPa", lambda e: transverse_isotropy.energy(e, 1.0, ufl.as_vector([0, 0, 1]))),
        ("k = −0.1 MPa", lambda e: transverse_isotropy.energy(e, -0.1, ufl.as_vector([0, 0, 1]))),
        least=1.0,
    ),
    "yielding_network": stress(
        ("yields at 10 %", lambda e: yielding_network.energy(e, MU_MPa, ufl.Identity(3), 0.03)),
        ("yields at 30 %", lambda e: yielding_network.energy(e, MU_MPa, ufl.Identity(3), 0.27)),
        ("elastic", lambda e: yielding_network.energy(e, MU_MPa, ufl.Identity(3), 1e3)),
    ),
}
