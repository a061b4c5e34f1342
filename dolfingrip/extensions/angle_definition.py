"""Another definition of the finger's angle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from dolfingrip.channels import ANGLE, CHORD_ANGLE
from dolfingrip.extensions.effect import DirectCheck, Prior
from dolfingrip.extensions.kinds import Instrument
from dolfingrip.sections.section import Ratio


class AngleDefinition(Instrument):
    """An angle that is not the tip face's.

    α_displayed = (1 − s) α_face + s α_chord. The chord is the line from the clamp's centre to the
    tip's centre. s = 1 is the chord's angle, which two markers give; an s between 0 and 1 is a line
    of markers that begins somewhere along the finger.

    Prior: s = 0.3 ± 0.3 (engineering guess); the format of measured data means the face's angle.
    Fingerprint: the chord turns by a little less than half the face's angle: the angle by one
    factor at all pressures, −15.7 % at s = 0.3; force untouched.
    Confused with: the angle's gain, nearly the same.
    """

    place: ClassVar = 1
    checks: ClassVar = (
        DirectCheck("the tip's face read beside the markers", 10.0, {"chord_share": 0.02}),
    )
    channel: ClassVar = ANGLE

    chord_share: Annotated[Ratio, Prior(0.3, 0.3, "engineering guess", positive=True)] = Field(
        0.3, ge=0, le=1, description="0 tip face, 1 line from clamp to tip"
    )

    def displayed(self, true: Mapping[str, np.ndarray]) -> np.ndarray:
        face, chord = true[ANGLE.name], true[CHORD_ANGLE.name]
        return (1 - self.chord_share) * face + self.chord_share * chord
