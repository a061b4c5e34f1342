"""Base materials against closed forms: powers of the stretches, polynomials, and chains that end.

P = (∂ψ/∂λ₁ λ₁ − ∂ψ/∂λ₃ λ₃)/λ₁ where the third direction is free and the volume is constant (Ogden,
Non-Linear Elastic Deformations, 1984, section 7.2).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from support import bars, taylor, trial

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.material_fit.law import LAWS as FITTED
from dolfingrip.experiments.rigs.materials import BaseMaterial
from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.element import displacement_element, pressure_field
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.parameter import every
from dolfingrip.sections import material
from dolfingrip.sections.laws.index import LAWS as MATERIALS
from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.laws.polynomial import POWERS
from dolfingrip.sections.tables import assignments

OGDEN = (
    "material.law=ogden",
    "material.ogden_mu_MPa=[1.2, 0.02, 0.4]",
    "material.ogden_alpha=[1.3, 5.0, -2.5]",
)
FILM = ("finger.kind=cast", "material.film.mu_MPa=30")
POLYNOMIAL = (
    "material.law=polynomial",
    "material.C10_MPa=0.5",
    "material.C01_MPa=0.3",
    "material.C20_MPa=-0.02",
    "material.C11_MPa=0.01",
    "material.C30_MPa=0.004",
)
CHAINS = (
    ("material.law=gent", "material.gent_mu_MPa=1.2", "material.gent_limit=12"),
    (
        "material.law=gent-gent", "material.gg_mu_MPa=0.8", "material.gg_limit=15",
        "material.gg_C2_MPa=0.5",
    ),
    ("material.law=arruda-boyce", "material.ab_mu_MPa=1.1", "material.ab_lock=2"),
    (
        "material.law=extended-tube", "material.tube_Gc_MPa=0.7", "material.tube_Ge_MPa=0.5",
        "material.tube_delta=0.2", "material.tube_beta=0.4",
    ),
)  # fmt: skip
SMALL = (
    "finger.bellows=1", "finger.length_mm=26", "mesh.size_mm=12", "mesh.edge_size_mm=12",
    "contact.self_contact=false", "plate.gap_mm=30",
)  # fmt: skip
LAWS = pytest.mark.parametrize("law", [OGDEN, POLYNOMIAL], ids=["ogden", "polynomial"])


def slopes(material: config.Material, stretches: np.ndarray) -> np.ndarray:
    """∂ψ/∂λ of the principal stretches (3,), by hand."""
    if material.law == "ogden":
        return sum(
            2 * mu / alpha * stretches ** (alpha - 1)
            for mu, alpha in zip(material.ogden_mu_MPa, material.ogden_alpha, strict=True)
        )
    first, second = (stretches**2).sum() - 3, (stretches**-2.0).sum() - 3
    by_first = by_second = 0.0
    own = material.constants()
    if material.law.startswith("gent"):
        mu, limit, entangled = [*own.values(), 0.0][:3]
        by_first = mu / 2 / (1 - first / limit)
        by_second = entangled / (second + 3)
    elif material.law == "arruda-boyce":
        mu, lock = own.values()
        for k, a in enumerate((1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750), start=1):
            by_first += mu * a * k * (first + 3) ** (k - 1) / lock ** (2 * k - 2)
    elif material.law == "extended-tube":
        links, tubes, delta, beta = own.values()
        rest = 1 - delta**2 * first
        by_first = links / 2 * ((1 - delta**2) / rest**2 - delta**2 / rest)
        return 2 * by_first * stretches - 2 * tubes / beta * stretches ** (-beta - 1)
    for key, c in own.items() if material.law == "polynomial" else ():
        i, j = POWERS[key]
        by_first += c * i * first ** max(i - 1, 0) * second**j
        by_second += c * j * first**i * second ** max(j - 1, 0)
    return 2 * by_first * stretches - 2 * by_second * stretches**-3.0


def closed_form(material: config.Material, stretches: np.ndarray) -> float:
    """Nominal stress (MPa) along the first stretch, the last direction being free."""
    psi = slopes(material, stretches)
    return float((psi[0] * stretches[0] - psi[2] * stretches[2]) / stretches[0])


@LAWS
def test_incompressible_bar(law: tuple[str, ...]) -> None:
    pull = (*bars.INCOMPRESSIBLE, "coupon.max_strain=1.5", "coupon.step_strain=0.25", *law)
    material = config.load(None, assignments(law)).material
    stretch, found = bars.stress(bars.pull(*pull))
    expected = [closed_form(material, np.array([each, *2 * [each**-0.5]])) for each in stretch]
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


MODES = {"planar": (1, 0.0, -1.0), "equibiaxial": (1, 1, -2.0), "uniaxial": (1, -0.5, -0.5)}
"""Exponents of the principal stretches at constant volume."""


@pytest.mark.parametrize(
    ("law", "element"),
    [*((law, element) for law in (OGDEN, POLYNOMIAL) for element in ("S2", "P2-P1")),
     *((law, "S2") for law in CHAINS)],
    ids=lambda each: each if isinstance(each, str) else each[0].rpartition("=")[2],
)  # fmt: skip
def test_elements_in_planar_and_equibiaxial_tension(law: tuple[str, ...], element: str) -> None:
    """Of one element's cube the residual is the closed form's force, at coincident stretches, too.

    At constant volume the displacement element has no pressure: its free direction then carries
    −P₃, which is taken off as a pressure. The mixed one has p, which frees that direction.
    """
    settings = config.load(None, assignments([*law, "material.nu=0.4999"]))
    kind = mesh.CellType.hexahedron if element == "S2" else mesh.CellType.tetrahedron
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, kind)
    u = fem.Function(fem.functionspace(cube, displacement_element(element)))
    p = pressure_field(element, cube)
    base = BaseMaterial.on(cube, settings.material)
    potential = Potential(u, [lambda strain: base.energy(strain, p)], p=p)
    nodes = u.function_space.tabulate_dof_coordinates()
    for exponents in MODES.values():
        for stretch in (1.2, 2.0):
            stretches = stretch ** np.array(exponents)
            u.x.array[:] = (nodes * (stretches - 1)).ravel()
            psi = slopes(settings.material, stretches) * stretches
            if p is not None:  # ψ is isochoric: its stress has no mean
                p.x.array[:] = psi.mean() - psi[2]
            residual = fem.assemble_vector(to_assemble(potential.gradient)).array.reshape(-1, 3)
            forces = [residual[np.isclose(nodes[:, axis], 1), axis].sum() for axis in range(3)]
            free = forces[2] * stretches[2]
            found = (forces[0] * stretches[0] - free) / stretches[0]
            if p is not None:
                assert abs(free) < 1e-7
            assert found == pytest.approx(closed_form(settings.material, stretches), rel=1e-7)


@pytest.mark.slow
@LAWS
def test_derivatives_of_the_coupon_by_all_parameters(law: tuple[str, ...]) -> None:
    """Forward sensitivities against central differences of runs, whose curvature leaves 1e-5."""
    at = config.load(
        None,
        assignments([*law, "coupon.max_strain=0.6", "coupon.step_strain=0.3", "solver.rtol=1e-12"]),
    )
    parameters = [each for each in every(at) if each.key.startswith("material.")]
    keys = [each.key for each in parameters]
    assert "material.mu_MPa" not in keys
    assert len(keys) == 2 + (6 if at.material.law == "ogden" else 5)
    found = run("coupon", at, comm=MPI.COMM_SELF, gradients=keys).sensitivities
    for parameter in parameters:
        slope = [
            float(row["derivative"])
            for row in found
            if (row["parameter"], row["column"]) == (parameter.key, "nominal_stress_MPa")
        ]
        step = 0.03 * parameter.scale  # 0.3 % of a factor
        after, before = (
            run("coupon", parameter.at(at, parameter.value(at) + h), comm=MPI.COMM_SELF).column(
                "nominal_stress_MPa"
            )
            for h in (step, -step)
        )
        expected = (after - before) / (2 * step)
        print(parameter.key, slope, expected)
        assert parameter.key == "material.density_kg_m3" or abs(expected).max() > 1e-4
        # the rounding of the derivative is 1e-8 MPa for a change of one scale
        np.testing.assert_allclose(slope, expected, rtol=3e-5, atol=5e-8 / parameter.scale)


def fitted(name: str) -> Config:
    """A configuration with a law of the index, which has the most constants that a fit finds.

    They are those that a fit begins with, and none of them is 0. A law that no fit is for, as one
    of a plugin, has its defaults.
    """
    laws = [law for law in FITTED.values() if law.material is MATERIALS[name]]
    if not laws:
        return config.load(None, {"material.law": name})
    law = max(laws, key=lambda law: len(law.keys))
    (start, *_) = law.fittable.starts(1.0)
    return config.load(None, law.tables([value or 0.03 for value in start]))


@pytest.mark.parametrize("name", MATERIALS)
def test_gradient_and_tangent_are_derivatives_of_the_energy(name: str) -> None:
    """Taylor remainders at an irregular strain, where no two stretches agree."""
    settings = fitted(name)
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(cube, displacement_element("S2")))
    base = BaseMaterial.on(cube, settings.material)
    potential = Potential(u, [base.energy], carried=False)
    print("seed", 3)
    rng = np.random.default_rng(3)
    start, way = (0.1 * rng.uniform(-1, 1, u.x.array.size) for _ in range(2))
    u.x.array[:] = start
    tangent = fem_petsc.assemble_matrix(potential.tangent)
    tangent.assemble()
    direction, product = tangent.createVecs()
    direction.array[:] = way
    tangent.mult(direction, product)
    slope = np.array(product.array)

    def gradient(step: float) -> np.ndarray:
        u.x.array[:] = start + step * way
        return np.array(fem.assemble_vector(to_assemble(potential.gradient)).array)

    def energy(step: float) -> float:
        u.x.array[:] = start + step * way
        return float(potential.value(u.x.array))

    assert taylor.rates(gradient, slope, 0.1).min() > 1.9
    assert taylor.rates(energy, float(gradient(0.0) @ way), 0.1).min() > 1.9


@pytest.mark.parametrize("law", CHAINS, ids=lambda law: law[0].rpartition("=")[2])
def test_the_shear_modulus_at_rest_is_the_closed_forms(law: tuple[str, ...]) -> None:
    """At a small stretch of constant volume P = 3 μ ε, and the coupon's law has it, too."""
    material = config.load(None, assignments(law)).material
    small = 1e-5
    pull = closed_form(material, np.array([1 + small, *2 * [(1 + small) ** -0.5]]))
    assert pull / (3 * small) == pytest.approx(material.shear_MPa, rel=1e-4)


REFUSED = {
    ("material.law=ogden",): "material.ogden_mu_MPa = []: allowed: a list of numbers with law",
    ("material.law=ogden", "material.ogden_mu_MPa=[1]"): "material.ogden_alpha = []: allowed: as",
    (*OGDEN, "material.ogden_alpha=[2, 0, 1]"): "allowed: each from 0.05 to 10, or below 0 like",
    (*OGDEN, "material.ogden_mu_MPa=[1, -2, 0]"): "initial shear modulus -1 MPa; allowed: above 0",
    (
        *OGDEN,
        "material.mu_MPa=3",
    ): 'material.mu_MPa = 3: allowed: with another law than "ogden", su',
    (*OGDEN, "material.C10_MPa=1"): 'than "ogden", such as "polynomial"',
    (*FILM, "material.film.C10_MPa=1"): "material.film.C10_MPa = 1: allowed: with another law than",
    (*FILM, "material.film.nu=1"): "material.film.nu = 1: allowed: at least 1e-06 and below 0.5",
    (FILM[0], "material.film.law=ogden"): "material.film.ogden_mu_MPa = []: allowed: a list of",
    (*FILM, "material.film.law=1"): "material.film.law = 1: allowed: arruda-boyce, extended-tube, ",
    (*FILM, "material.film.c10=1"): "material.film.c10: unknown key; allowed: law, mu_MPa, nu",
    ("material.law=polynomial",): "material.C10_MPa = none: allowed: a number with law",
    ("material.law=polynomial", "material.C10_MPa=-1"): "initial shear modulus -2 MPa; allowed: ab",
    ("material.ogden_alpha=[1]",): 'allowed: with another law than "neo-hooke"',
    ("material.law=hooke",): 'material.law = "hooke": allowed: arruda-boyce, extended-tube, ',
}


@pytest.mark.parametrize("overrides", REFUSED, ids=lambda overrides: overrides[-1])
def test_bad_laws_are_one_line(overrides: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as caught:
        config.load(None, assignments(overrides))
    assert REFUSED[overrides] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_law_reads_back_equal(tmp_path: Path) -> None:
    for law in (OGDEN, POLYNOMIAL, *CHAINS):
        resolved: Config = config.load(None, assignments(law))
        printed = tmp_path / "printed.toml"
        printed.write_text(config.dumps(resolved), encoding="utf-8")
        assert config.load(printed) == resolved


def test_marks_do_not_hide_other_variables() -> None:
    """An energy scaled by a function of itself has the product's derivatives."""
    from dolfingrip.forms import polynomial
    from dolfingrip.forms.evaluate import nominal_stress

    def density(strain: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        psi = polynomial.energy(strain, {(1, 0): 1.0})
        return psi * (1 + psi)

    # ψ = λ² + 2/λ − 3 = 2 and ψ' = 2λ − 2/λ² = 3.5 at λ = 2
    assert nominal_stress(density, 2.0) == pytest.approx(3.5 * (1 + 2 * 2), rel=1e-12)


NAMED = sorted(material.named())


@pytest.mark.parametrize("name", NAMED)
def test_a_name_stands_for_law_and_constants(name: str, tmp_path: Path) -> None:
    own = material.named()[name]
    settings = config.load(None, {"material.name": name, "material.nu": 0.49})
    assert settings.material.model_dump(include=own["material"].keys()) == {
        **own["material"],
        "nu": 0.49,
    }
    assert config.changed(config.Config(), {"material.name": name, "material.nu": 0.49}) == settings
    printed = tmp_path / "printed.toml"
    printed.write_text(config.dumps(settings), encoding="utf-8")
    assert f'law = "{own["material"]["law"]}"' in printed.read_text(encoding="utf-8")
    assert config.load(printed) == settings
    assert own["stretch"] > 1
    assert own["elongation_at_break"] > own["stretch"] - 1
    assert {"source", "licence"} <= own.keys()


@pytest.mark.parametrize("name", [each for each in NAMED if "psi" in
                                  material.named()[each]["source"]])  # fmt: skip
def test_constants_of_data_sheets_give_their_stress(name: str) -> None:
    """The nominal stress at 100 % strain of neo-Hooke's law is 1.75 μ."""
    own = material.named()[name]
    psi = float(own["source"].partition(": ")[2].partition(" psi")[0])
    assert 1.75 * own["material"]["mu_MPa"] == pytest.approx(psi * 6.894757e-3, rel=5e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"material.name": "Ecoflex"}, 'material.name = "Ecoflex": allowed: Ecoflex 00-10, '),
        (
            {"material.name": "Ecoflex 00-50", "material.mu_MPa": 0.1},
            'material.mu_MPa = 0.1: allowed: without name = "Ecoflex 00-50"',
        ),
        (
            {"material.name": "Ecoflex 00-50", "material.law": "gent"},
            'material.law = "gent": allowed: without name = "Ecoflex 00-50"',
        ),
    ],
)
def test_a_name_beside_law_or_constants_is_refused(change: config.Change, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        config.load(None, change)
    assert str(refused.value).startswith(said)


def test_the_page_has_the_table_of_named_materials() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "materials.md").read_text("utf-8")
    for name, own in material.named().items():
        constants = ", ".join(
            f"`{key}` {value:g}" for key, value in own["material"].items()
            if key not in ("law", "nu", "density_kg_m3")
        )  # fmt: skip
        row = (
            f"| `{name}` | `{own['material']['law']}`: {constants} | {own['stretch']:g} | "
            f"{100 * own['elongation_at_break']:g} % |"
        )
        assert row in page


@pytest.mark.parametrize("law", MATERIALS)
def test_derivatives_of_every_law(law: str) -> None:
    """Of the index, plugins' too, with the numbers that a law's first fit begins with.

    Taylor remainders of energy and residual of a short finger are of second order.
    """
    change: dict[str, Any] = {"material.law": law}
    for each in MATERIALS[law].fits[:1]:
        for key, value in zip(each.keys, each.starts(2.0)[0], strict=True):
            name, _, place = key.partition("[")
            if place:
                change.setdefault(f"material.{name}", []).append(value)
            else:
                change[f"material.{name}"] = value
    settings = config.load(None, assignments(SMALL) | change)
    assert settings.material.shear_MPa > 0
    finger = trial.stirred(settings)
    assert min(trial.orders(finger)) > 1.9


def test_the_moduli_of_every_law_scale_its_energy() -> None:
    """``moduli`` names the keys that the energy is linear in; the shear modulus follows them."""
    for law, kind in MATERIALS.items():
        start = {key: 1.5 for key in kind.moduli if kind.model_fields[key].annotation is float}
        one, two = (
            kind.model_construct(law=law, **{**_defaults(kind), **start}).shear_MPa
            for start in (start, {key: 2 * value for key, value in start.items()})
        )
        assert two == pytest.approx(2 * one) or not start, law


def _defaults(kind: type[MaterialLaw]) -> dict[str, Any]:
    return {key: info.default for key, info in kind.model_fields.items() if key != "law"}
