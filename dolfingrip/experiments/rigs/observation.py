"""The readings of a finger at one state."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import ipctk
import numpy as np

from dolfingrip import channels
from dolfingrip.config import ConfigError
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.pneumatics import of_supply
from dolfingrip.experiments.rigs.undeformed import REST, morph
from dolfingrip.mechanics.model.assembly import undeformed
from dolfingrip.mechanics.readings.chord import LineAngle, back_edge, point
from dolfingrip.mechanics.readings.energy import energies
from dolfingrip.mechanics.readings.integrals import Integral
from dolfingrip.mechanics.readings.line import of_line
from dolfingrip.mechanics.readings.obstacle import on_obstacle
from dolfingrip.mechanics.readings.peak_stretch import LargestStretch
from dolfingrip.mechanics.readings.plate import PlateForce, PlateGapReading
from dolfingrip.mechanics.readings.prescribed import ControlValue, Time
from dolfingrip.mechanics.readings.reading import FromRest, Reading, of_model
from dolfingrip.mechanics.readings.rotation import Slices, TipRotation
from dolfingrip.mechanics.readings.tip import ChordAngle, FaceAngle, TipDisplacement

NEAR_WIDTHS = 10.0
"""Distance, by the barrier's width, from which on opposite walls are near."""


class ContactGap(Reading):
    """Smallest distance between neighbours of bellows, base block and tip (mm).

    It is NaN if none is known or near. Parts are identified by the configuration's dimensions, so a
    mesh file of another shape has no gaps here. Vertices below the gap's floor belong to no part.

    Attributes:
        gaps_mm: distance of each pair of neighbours at the last reading; infinite beyond 1.25 times
            the gap at rest.
    """

    differentiable = False

    def __init__(self, finger: FingerModel) -> None:
        super().__init__(finger.model, channels.CONTACT_GAP.name)
        self.gaps_mm: dict[str, float] = {}
        geometry = finger.config.geometry
        gaps = geometry.gaps()
        self._reach = 1.25 * gaps.width_mm
        self._pairs: list[tuple[str, ipctk.CollisionMesh, np.ndarray]] = []
        contact = finger.contact
        self._surface = contact.surface if contact is not None else None
        if self._surface is None:
            return
        floor = float(morph(finger.config).moved(np.array(gaps.floor_mm)))
        floor += 1e-6 * geometry.depth_mm
        part = _parts(floor, gaps.intervals, self._surface.rest)
        for i, (one, other) in enumerate(pairwise(gaps.parts)):
            mesh, vertices = self._facing(part, i)
            if mesh is not None:
                self._pairs.append((f"{one} and {other}", mesh, vertices))

    def _facing(
        self, part: np.ndarray, first: int
    ) -> tuple[ipctk.CollisionMesh | None, np.ndarray]:
        """Collision mesh of the parts ``first`` and ``first`` + 1, without contact within one."""
        assert self._surface is not None
        corners = self._surface.triangles
        label = part[corners]
        inside = (label == label[:, :1]).all(axis=1) & np.isin(label[:, 0], (first, first + 1))
        if len(np.unique(label[inside, 0])) < 2:
            return None, np.empty(0, dtype=np.int64)
        vertices, triangles = np.unique(corners[inside], return_inverse=True)
        faces = np.asfortranarray(triangles.reshape(-1, 3).astype(np.int32))
        mesh = ipctk.CollisionMesh(
            np.asfortranarray(self._surface.rest[vertices]), ipctk.edges(faces), faces
        )
        mesh.can_collide = ipctk.make_vertex_patches_filter(part[vertices].astype(np.int32))
        return mesh, vertices

    def value(self) -> float:
        self.gaps_mm = {}
        if self._surface is not None:
            now = self._surface.positions(self.model.u.x.array)
            for name, mesh, vertices in self._pairs:
                moved = np.asfortranarray(now[vertices])
                close = ipctk.NormalCollisions()
                close.build(mesh, moved, self._reach)
                self.gaps_mm[name] = float(np.sqrt(close.compute_minimum_distance(mesh, moved)))
        return _smallest(self.gaps_mm.values())


class WallGap(Reading):
    """Smallest distance of opposite walls of a cavity (mm); NaN if none is known or near."""

    differentiable = False

    def __init__(self, finger: FingerModel) -> None:
        super().__init__(finger.model, channels.WALL_GAP.name)
        self._inside = list(finger.site.walls.values())

    def value(self) -> float:
        dofs = self.model.u.x.array
        gaps = [cavity.opposite_mm(dofs, NEAR_WIDTHS * cavity.width_mm) for cavity in self._inside]
        return _smallest(gaps)


def _smallest(gaps_mm: Iterable[float]) -> float:
    smallest = min(gaps_mm, default=np.inf)
    return smallest if np.isfinite(smallest) else float("nan")


def _parts(floor_mm: float, gaps: list[tuple[float, float]], points: np.ndarray) -> np.ndarray:
    """Number of gaps before each reference point (along z), (n,); −1 for points below the gaps."""
    part = np.zeros(len(points), dtype=np.int64)
    for start, end in gaps:
        part[points[:, 2] > (start + end) / 2] += 1
    part[points[:, 0] <= floor_mm] = -1
    return part


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
        elongation: the largest stretch.
    """

    def __init__(self, finger: FingerModel) -> None:
        self._finger = finger
        model, plate = finger.model, finger.plate
        self._gap = ContactGap(finger)
        slices = Slices(model)
        counted = [
            FromRest(FaceAngle(model), lambda: float(slices.deg()[-1])),
            FromRest(TipDisplacement(model, "x")),
            # in half a finger it is 0
            *(() if model.domain.half else (FromRest(TipDisplacement(model, "y")),)),
            FromRest(TipDisplacement(model, "z")),
            # a chord turns as the mean of the sections along it
            FromRest(chord(finger), lambda: float(slices.deg().mean())),
        ]
        cavities = finger.site.domain.cavities
        cavity = finger.pressure_in(*cavities) if len(cavities) == 1 else finger.cavity
        readings: list[Reading] = [
            Time(model),
            ControlValue(model, channels.PRESSURE.name, model.controls[channels.PRESSURE.name]),
            *counted,
            ControlValue(model, channels.CAVITY_PRESSURE.name, cavity),
            Integral(model, channels.CAVITY_VOLUME.name, finger.enclosed),
            *of_cavities(finger),
            self._gap,
            WallGap(finger),
            *of_model(model, "finger"),
            *of_line(model, finger.config.camera.markers, finger.config.curve),
        ]
        if finger.config.obstacle is not None and finger.site.obstacle is not None:
            readings += on_obstacle(model, finger.site.obstacle, finger.config.obstacle.friction)
        if finger.air is not None:
            readings += of_supply(model, finger.air)
        if finger.inertia is not None:
            readings += energies(model, finger.inertia)
        if plate is not None:
            readings += [
                PlateForce(model, plate),
                PlateGapReading(model, plate),
                *of_model(model, "plate"),
            ]
        self._from_rest = [reading for reading in readings if isinstance(reading, FromRest)]
        self.from_rest = [reading.column for reading in self._from_rest]
        self.readings = {reading.column: reading for reading in readings}
        self._rotation = TipRotation(model, slices)
        self.elongation = Elongation(finger)
        with undeformed(model.u):
            self.tare()

    def tare(self) -> None:
        """Count angles and displacements from the present state."""
        for reading in self._from_rest:
            reading.tare()
        self._rotation.tare()

    @property
    def gaps_mm(self) -> dict[str, float]:
        """Distances (mm) between neighbouring parts, by their names, at the last reading."""
        return self._gap.gaps_mm

    def read(self) -> dict[str, float]:
        """Values by column."""
        values = {column: reading.value() for column, reading in self.readings.items()}
        return {
            channels.TIP_Y.name: 0.0,
            **values,
            **self._rotation.values(),
            **self.elongation.values(),
        }


class Elongation:
    """The largest stretch, and its elongation as a share of that at break of each material."""

    def __init__(self, finger: FingerModel) -> None:
        model, material = finger.model, finger.config.material
        domain, degree = model.domain, model.potential.degree
        self._parts = []
        for part in domain.parts or (REST,):
            cells = domain.cells(part) if domain.parts else None
            at_break = material.of(part).elongation_at_break
            self._parts.append((LargestStretch(model, degree, cells), at_break))

    def values(self) -> dict[str, float]:
        """Values by column; no share where no elongation at break is told."""
        reached = [(part.value(), at_break) for part, at_break in self._parts]
        shares = [(stretch - 1) / at_break for stretch, at_break in reached if at_break]
        values = {channels.LARGEST_STRETCH.name: max(stretch for stretch, _ in reached)}
        return {**values, channels.BREAK_SHARE.name: max(shares)} if shares else values


def of_cavities(finger: FingerModel) -> list[Reading]:
    """Pressure and volume of each of several cavities, and what its own supply is set to."""
    readings: list[Reading] = []
    cavities = finger.site.domain.cavities
    for name in cavities if len(cavities) > 1 else ():
        pressure, volume = channels.of_cavity(name)
        readings += [
            ControlValue(finger.model, pressure.name, finger.pressure_in(name)),
            Integral(finger.model, volume.name, finger.volume_of(name)),
        ]
    for name in finger.site.supplies:
        supply = channels.supply_of(name).name
        readings.append(ControlValue(finger.model, supply, finger.model.controls[supply]))
    return readings


def chord(finger: FingerModel) -> Reading:
    """The angle of the chord that the configuration's camera sees.

    Raises:
        ConfigError: one line, if one of its points is not on the finger.
    """
    model, camera, column = finger.model, finger.config.camera, channels.CHORD_ANGLE.name
    if camera.chord == "centres":
        return ChordAngle(model, column)
    if camera.chord == "back edges":
        return LineAngle(model, column, back_edge(model, "clamp"), back_edge(model, "tip"))
    ends = []
    for key in ("from_mm", "to_mm"):
        place = getattr(camera, key)
        node = point(model, np.asarray(place))
        if node is None:
            raise ConfigError(f"camera.{key} = {list(place)}: allowed: a point of the finger")
        ends.append(node)
    return LineAngle(model, column, *ends)
