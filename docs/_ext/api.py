"""Pages of the modules that other code is meant to use."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pages import Page

PAGES: Final = (
    (
        "configuration",
        "Configuration and parameters",
        "From TOML and overrides to a checked configuration; its numbers that can change.",
        "config parameter parameter.search sections.errors channels",
    ),
    (
        "experiments",
        "Experiments",
        "Running an experiment, its result, and what a new experiment describes.",
        "experiments.loop experiments.request experiments.simulate experiments.result "
        "experiments.results.readings experiments.results.sensitivity_table "
        "experiments.experiment experiments.derivatives.sensitivities",
    ),
    (
        "model",
        "Model and solver",
        "Potential, terms, Newton's method, load path, sensitivities.",
        "mechanics.model.model mechanics.model.term mechanics.newton.newton "
        "mechanics.path.path mechanics.sensitivity.forward mechanics.sensitivity.adjoint "
        "mechanics.readings.reading",
    ),
    (
        "additions",
        "What additions derive from",
        "Base classes of effects, laws, geometries and foods.",
        "extensions.effect extensions.site sections.laws.law sections.geometry.geometry foods.kind",
    ),
    (
        "meshes",
        "Meshes",
        "Meshing a finger or a part of one's own, and mesh files.",
        "meshes.generate meshes.files meshes.solid meshes.adoption.adopt",
    ),
    (
        "report",
        "Pictures",
        "Deformed shapes as pictures, strips and videos.",
        "report.render",
    ),
    (
        "design",
        "Campaigns and designs",
        "Many simulations, surrogates and optima.",
        "jobs.job jobs.run design.quantities.quantity design.campaign.campaign "
        "design.campaign.space design.surrogate.surrogate design.optimum.optimum",
    ),
    (
        "diagnosis",
        "Diagnosis and fits",
        "Measured data, the diagnosis and its files, fits to coupons.",
        "diagnosis.data diagnosis.diagnose files.diagnosis files.diagnosis_words "
        "experiments.material_fit.fit experiments.material_fit.coupons",
    ),
)
"""Name, title and content of each page, and its modules below ``dolfingrip``."""

ELSEWHERE: Final = {"config": "ConfigError"}
"""Names that a module has from another one on these pages."""


def pages(_: Path) -> list[Page]:
    """A page for each part of the package."""
    return [
        Page(name, title, said, f"# {title}\n\n{said}\n" + "".join(map(_module, modules.split())))
        for name, title, said, modules in PAGES
    ]


def _module(name: str) -> str:
    """The section of a module."""
    elsewhere = f"   :exclude-members: {ELSEWHERE[name]}\n" if name in ELSEWHERE else ""
    return (
        f"\n## `dolfingrip.{name}`\n\n```{{eval-rst}}\n.. automodule:: dolfingrip.{name}\n"
        f"   :members:\n{elsewhere}   :show-inheritance:\n```\n"
    )
