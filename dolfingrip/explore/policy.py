"""The numbers of the explorer."""

from __future__ import annotations

from typing import Final

STEPS: Final = 12
"""Readings up to the highest pressure, where a campaign has fewer."""

COARSE_STEPS: Final = 4
"""Readings up to the highest pressure on the coarse mesh."""

PRESSURES: Final = (0.1, 2.0)
"""Ends of the slider of the highest pressure, by the configured one."""

NEIGHBOURS: Final = 12
"""Solved designs that one is interpolated between."""

LOOKED_AT: Final = 40
"""Solved designs, the nearest, among which those of one mesh are looked for."""

CHECKED: Final = 4
"""Solved designs from which on the interpolation's error is estimated."""

SAME: Final = 1e-6
"""Distance of two designs, in shares of the sliders' ranges, up to which they are one."""

OUTSIDE: Final = 0.02
"""Distance from the solved designs' hull, in the same shares, up to which a design counts as lying
among them."""

CURVE_S: Final = (0.001, 3600.0)
"""Shortest and longest rise and hold of a curve that a supply follows."""

CURVE_STEPS: Final = 100
"""Steps of such a curve; other designs wait while its commands are found."""

GRASP_KPA: Final = 150.0
"""Highest pressure of a grasp where none is asked for."""

GRASP_STEP_KPA: Final = 25.0
"""Between readings of a grasp."""
