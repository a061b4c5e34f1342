"""A mesh that is coarser than it ought to be."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior, Setup
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.section import Ratio


class CoarseMesh(Effect):
    """A mesh coarser than the base model's.

    Element sizes ← factor · sizes. This is not a property of a finger: it shows how much of a
    difference may be the mesh's.

    Walls always have at least one hexahedron across, so only hexahedra at concave edges grow.

    Prior: 1.5 ± 0.5, a choice and no property of the finger (engineering guess).
    Fingerprint: angle and force lower by 0.4 to 0.8 %. Of a mesh that is not graded
    (``mesh.edge_size_mm`` as large as the rest) higher by 1 to 2 %, unevenly over the pressures.
    Loading and unloading agree.
    Confused with: the modulus, wall thickness.
    """

    kind: ClassVar = "numerical"
    place: ClassVar = 1
    neutral: ClassVar = {"factor": 1.0}
    # the mesh's error is a nuisance, see :mod:`dolfingrip.diagnosis.finger.model`
    tried: ClassVar = False

    factor: Annotated[Ratio, Prior(1.5, 0.5, "engineering guess", positive=True)] = Field(
        1.5, gt=0.1, le=10, description="element size by the base model's"
    )

    def adapt[S: Setup](self, config: S) -> S:
        mesh = config.mesh
        if mesh.file is not None:
            raise ConfigError(
                f"extensions.coarse_mesh.factor = {self.factor:g}: allowed: with a mesh that is "
                "made from sizes; mesh.file is one already"
            )
        changes: dict[str, float] = {"size_mm": config.size_mm * self.factor}
        if config.hexahedra:
            changes["edge_size_mm"] = mesh.hexahedra_mm(config.geometry)[1] * self.factor
        elif mesh.edge_size_mm is not None:
            changes["edge_size_mm"] = mesh.edge_size_mm * self.factor
        if mesh.target_elements is not None:
            changes["target_elements"] = max(round(mesh.target_elements / self.factor**3), 100)
        return config.changed(mesh=changes)
