"""Load paths of the pressure."""

from __future__ import annotations

from typing import Any

from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath


def by_pressure(newton: Newton, **options: Any) -> LoadPath:
    """A path whose steps the pressure limits, as the solver's settings say."""
    return LoadPath(newton, {"pressure_kPa": newton.settings.max_step_kPa}, **options)
