"""The base class of experiments on a pressurised finger."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

from dolfingrip.experiments.experiment import (
    DYNAMIC_OPTION,
    MPI,
    PRESSURE_OPTION,
    SUCTION_OPTION,
    Config,
    Experiment,
    Option,
    Profile,
    Readings,
)
from dolfingrip.experiments.protocol import Stop, pressure_stops
from dolfingrip.sections.supply import refuse_supply
from dolfingrip.sections.units import doubted

if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.finger_rig import FingerRig
    from dolfingrip.sections.geometry.geometry import Geometry


NEARLY_INCOMPRESSIBLE = {"P2": (0.49, "locks: the finger is too stiff"),
                         "S2": (0.47, "converges slowly")}  # fmt: skip
"""Poisson's ratio above which an element with quadratic displacements and no pressure field is not
enough, and what it does there. Hexahedra do not lock: with nu = 0.499 they take twice the time of
0.45, with 0.4999 four times."""


class FingerExperiment(Experiment):
    """An experiment whose control is the pressure or the volume of the finger's cavity.

    Args:
        made_for: dimensions that the mesh is made for and moved from; None: the configuration's.
    """

    options: ClassVar[tuple[Option, ...]] = (PRESSURE_OPTION, SUCTION_OPTION, DYNAMIC_OPTION)
    dynamic: ClassVar = True

    def __init__(self, made_for: Geometry | None = None) -> None:
        self.made_for = made_for

    def schedule(self, config: Config) -> Sequence[Stop]:
        return pressure_stops(config)

    def prepare(self, config: Config, comm: MPI.Comm, profile: Profile) -> FingerRig:
        return self._rig(config, comm, profile)

    def _rig(self, config: Config, comm: MPI.Comm, profile: Profile, **further: Any) -> FingerRig:
        """Build the finger's rig.

        Args:
            config: to which :meth:`settings` was applied.
            comm: ranks to run on.
            profile: takes the time of each phase.
            further: arguments of :meth:`FingerRig.built`.
        """
        from dolfingrip.experiments.rigs.finger_rig import FingerRig

        further |= {"plate": "plate" in self.parts, "made_for": self.made_for}
        return FingerRig.built(config, comm, profile, **further)

    def setup(self, config: Config) -> dict[str, Any]:
        data: dict[str, Any] = {
            "rate_kPa_per_s": config.experiment.rate_kPa_per_s,
            **config.drawn(),
        }
        if camera := config.camera.model_dump(exclude_defaults=True, exclude_none=True):
            data["camera"] = camera
        if config.gravity.acceleration_m_s2:
            data["gravity"] = {"direction": list(config.gravity.direction)}
        return data

    def notes(self, config: Config) -> list[str]:
        from dolfingrip.experiments import ballooning

        return [*notes(config), *ballooning.note(config)]

    def remarks(self, result: Readings) -> list[str]:
        from dolfingrip.experiments.results import doubts, following

        said = [doubt.sentence for doubt in doubts.of_motion(result)]
        return [*doubts.elongation(result), *said, *following.remarks(result)]


class WholeFingerExperiment(FingerExperiment):
    """An experiment that asks how the finger moves sideways, too: both halves are meshed."""

    measured: ClassVar = False
    gradients: ClassVar = False

    def settings(self, config: Config) -> Config:
        refuse_supply(config.supply)
        return config.changed(mesh={"half": False})


def notes(config: Config) -> list[str]:
    """Return one line for each doubt about the finger's cavities, regions and element.

    Args:
        config: of a simulation.
    """
    from dolfingrip.experiments.results import doubts

    sentences = [*doubts.not_given(config), *_units(config)]
    names = config.cavity.all if config.mesh.file else config.geometry.cavities()
    cavities = config.cavity
    if names and not any(cavities.ratio(name) or name in cavities.own for name in names):
        first = next(iter(names))
        why = "closed = true" if cavities.of(first).closed else "pressure_ratio = 0"
        sentences.append(
            f"cavity.{first}.{why}: no cavity has a supply, so the pressure moves nothing; allowed "
            "for an answer to it: at least one cavity that is not closed, at a ratio that is not 0"
        )
    region, element = config.geometry.limiting, config.solver.element
    if region and not (config.mesh.file or region in config.material.own or config.film.all):
        sentences.append(
            f'finger.kind = "{config.finger.kind}": its region {region} is of the same material as '
            "the rest, so nothing limits its strain, and the finger may bend the wrong way; give "
            f"[material.{region}], or a film on it, as [film.NAME]"
        )
    quadratic = element or ("S2" if config.hexahedra else "P2")
    if element == "P1":
        sentences.append(
            'solver.element = "P1": linear tetrahedra are too stiff in thin walls (tip '
            'displacement 38 % too small with walls of 1 mm); take "P2"'
        )
    most, does = NEARLY_INCOMPRESSIBLE.get(quadratic, (0.5, ""))
    if config.material.poisson > most:
        sentences.append(
            f'solver.element = "{quadratic}": nu = {config.material.poisson:.4g} is nearly '
            f'incompressible, where it {does}; take "P2-P1"'
        )
    return sentences


RUBBER_MPA: Final = (0.001, 30.0)
"""Least and largest shear modulus that is not doubted: those of foams, gels, rubbers and TPU."""


def _units(config: Config) -> Iterator[str]:
    """Yield a doubt about the unit of a modulus or of a length, with the factor."""
    from dolfingrip.parameter import moduli

    mu, (low, high) = config.material.shear_MPa, RUBBER_MPA
    units = {"in Pa?": 1e-6, "in kPa?": 1e-3, "in GPa?": 1e3}
    fits = [f"{name} It is {mu * by:.4g} MPa then" for name, by in units.items()
            if low <= mu * by <= high]  # fmt: skip
    if not low <= mu <= high:
        said = f"a shear modulus of {mu:.4g} MPa, where rubbers have {low:g} to {high:g} MPa"
        yield f"{next(iter(moduli(config)))}: {said}; {fits[-1] if fits else 'in which unit?'}"
    key, length_mm = f"{config.geometry_table}.length_mm", config.geometry.length_mm
    file, length_is_given = config.mesh.file, "length_mm" in config.geometry.model_fields_set
    if file is not None and file.is_file() and not length_is_given:
        from dolfingrip.experiments.rigs.undeformed import solid

        z_mm = solid(config).points[:, 2]
        key, length_mm = "mesh.file", float(z_mm.max() - z_mm.min())
    for doubt in doubted(length_mm, 1.0):
        yield f"{key}: {doubt}"
