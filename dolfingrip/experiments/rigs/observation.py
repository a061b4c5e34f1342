"""The readings of a finger at one state."""

from __future__ import annotations

import numpy as np

from dolfingrip.channels import CAVITY_PRESSURE, CAVITY_VOLUME, CHORD_ANGLE, PRESSURE
from dolfingrip.config import ConfigError
from dolfingrip.experiments.rigs.bellows import ContactGap
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.mechanics.readings.chord import LineAngle, back_edge, point
from dolfingrip.mechanics.readings.from_rest import FromRest
from dolfingrip.mechanics.readings.integrals import Integral
from dolfingrip.mechanics.readings.of_model import of_model
from dolfingrip.mechanics.readings.plate import PlateForce, PlateGap
from dolfingrip.mechanics.readings.prescribed import ControlValue, Time
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.mechanics.readings.tip import ChordAngle, FaceAngle, TipDisplacement
from dolfingrip.mechanics.readings.turning import Turning


class Observation:
    """Readings of a finger model, in the columns of the result table.

    ``angle_deg`` is the rotation of the tip face's area vector about y, positive towards the base
    layer (−x), also beyond 180°. ``chord_angle_deg`` is the rotation of the line that the camera's
    section names; by default it goes from the clamp's centre to the tip's. Both angles and the
    tip's displacement count from the state in which :meth:`tare` was called, and before that from
    the undeformed state. Volume and force are those of the whole finger.

    Attributes:
        readings: readings by column; there are readings of the plate only if there is a plate.
        from_rest: columns that count from the state at rest.
    """

    def __init__(self, finger: FingerModel) -> None:
        self._finger = finger
        model, plate = finger.model, finger.plate
        self._gap = ContactGap(finger)
        turning = Turning(model)
        counted = [
            FromRest(FaceAngle(model), lambda: float(turning.deg()[-1])),
            FromRest(TipDisplacement(model, "x")),
            FromRest(TipDisplacement(model, "z")),
            # a chord turns as the mean of the sections along it
            FromRest(chord(finger), lambda: float(turning.deg().mean())),
        ]
        found: list[Reading] = [
            Time(model),
            ControlValue(model, PRESSURE.name, model.controls[PRESSURE.name]),
            *counted,
            ControlValue(model, CAVITY_PRESSURE.name, finger.cavity),
            Integral(model, CAVITY_VOLUME.name, finger.enclosed),
            self._gap,
            *of_model(model, "finger"),
        ]
        if plate is not None:
            found += [PlateForce(model, plate), PlateGap(model, plate), *of_model(model, "plate")]
        self._from_rest = [reading for reading in found if isinstance(reading, FromRest)]
        self.from_rest = [reading.column for reading in self._from_rest]
        self.readings = {reading.column: reading for reading in found}
        self._tare_undeformed()

    def _tare_undeformed(self) -> None:
        u = self._finger.model.u.x.array
        kept = u.copy()
        u[:] = 0.0
        self.tare()
        u[:] = kept

    def tare(self) -> None:
        """Count angles and displacements from the present state."""
        for reading in self._from_rest:
            reading.tare()

    @property
    def gaps_mm(self) -> dict[str, float]:
        """Distances (mm) between neighbouring parts, by their names, at the last reading."""
        return self._gap.gaps_mm

    def read(self) -> dict[str, float]:
        """Values by column."""
        return {column: reading.value() for column, reading in self.readings.items()}


def chord(finger: FingerModel) -> Reading:
    """The angle of the chord that the configuration's camera sees.

    Raises:
        ConfigError: one line, if one of its points is not on the finger.
    """
    model, camera, column = finger.model, finger.config.camera, CHORD_ANGLE.name
    if camera.chord == "centres":
        return ChordAngle(model, column)
    if camera.chord == "back edges":
        return LineAngle(model, column, back_edge(model, "clamp"), back_edge(model, "tip"))
    ends = []
    for key in ("from_mm", "to_mm"):
        place = getattr(camera, key)
        found = point(model, np.asarray(place))
        if found is None:
            raise ConfigError(f"camera.{key} = {list(place)}: allowed: a point of the finger")
        ends.append(found)
    return LineAngle(model, column, *ends)
