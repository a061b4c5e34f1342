"""A material that is less compressible than the base model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import bulk_modulus


class BulkModulus(Elastic):
    """A material that is less compressible than the base model.

    ψ += ΔK/2 (ln J)²: the bulk modulus is K = λ + 2μ/3 + ΔK. See
    :mod:`dolfingrip.forms.bulk_modulus`.

    Prior: ΔK = 100 ± 100 MPa, an engineering guess: solid polyurethane has more than 1 GPa, but
    printed parts have pores. The default Poisson's ratio of 0.45 gives K = 28 MPa.
    Fingerprint: the angle is lower by 4.6 % at 25 kPa and 3.6 % at 250 kPa, the force by 0.4 and
    2.0 %. Walls that cannot change their volume are stiffer where they bend as plates. Loading and
    unloading agree.
    Confused with: the modulus, wall thickness, locking of coarse meshes.
    """

    # in the displacement alone it would lock, as the mixed element is to avoid
    mixed: ClassVar = False
    curved: ClassVar = True

    more_MPa: Annotated[float, Prior(100.0, 100.0, "engineering guess", positive=True)] = Field(
        100.0, ge=0, le=1e5, description="added to the bulk modulus"
    )

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return bulk_modulus.energy(strain, c["more_MPa"])
