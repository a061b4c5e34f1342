"""The reduced model of a finger: its shape and force at a pressure, and the pressure for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Final, Self

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from dolfingrip.experiments.filling import RestingFinger, filled_kPa, step_response
from dolfingrip.experiments.rigs.pneumatics import line_of
from dolfingrip.files.robot import RobotFile
from dolfingrip.robot.chain import Chain, Equilibrium, Loads, Plates, Points, equilibrium
from dolfingrip.robot.fit import softness
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.supply import AirLine, with_valve

TRIED: Final = 26
"""Pressures between which the one that is sought is looked for."""

WEIGHTLESS: Final = (0.0, 0.0, 0.0)
"""Acceleration where gravity does not act."""


class Robot:
    """A finger as a chain of links.

    Args:
        file: what ``dolfingrip robot`` found.
    """

    def __init__(self, file: RobotFile) -> None:
        self.file = file
        self.chain = Chain(np.array([joint.place_mm for joint in file.joints]))
        self.laws = np.array([c.law for joint in file.joints for c in joint.coordinates])
        self.tip = self.chain.fixed(np.array([file.tip_mm]))
        centres = np.array([link.centre_mm for link in file.links])
        self._centres = Points(centres, np.arange(len(centres)))

    @classmethod
    def read(cls, folder: Path | str) -> Self:
        """Read ``robot.json``.

        Args:
            folder: folder that has it, or the file itself.

        Returns:
            The finger.

        Raises:
            ResultFileError: one line, where it cannot be read.
        """
        return cls(RobotFile.read(folder))

    @cached_property
    def _pressures_kPa(self) -> np.ndarray:
        return np.linspace(*self.file.valid.pressure_kPa, TRIED)

    def state(
        self, pressure_kPa: np.ndarray | float, gap_mm: float | None = None, *,
        full_back: bool = False, gravity_m_s2: Sequence[float] = WEIGHTLESS,
    ) -> Equilibrium:  # fmt: skip
        """Find the chain's equilibrium.

        Args:
            pressure_kPa: one, or (states,) that are reached one from another.
            gap_mm: of a plate before the straight finger's back; None: it is free.
            full_back: whether the plate faces the whole back, as food does, and not its last part.
            gravity_m_s2: acceleration along x, y, z; z is from clamp to tip.

        Returns:
            Coordinates, stiffness and forces, (states, …).
        """
        p = np.atleast_1d(np.asarray(pressure_kPa, dtype=float))
        back = np.array(self.file.pressing_mm)
        points = self.chain.fixed(back if full_back else back[-self.file.facing_plate :])
        plate = -np.inf if gap_mm is None else back[-1, 0] - gap_mm
        plates = Plates(np.full(len(p), plate), points, self.file.plate_N_per_mm)
        start = np.zeros((len(p), self.chain.size))
        masses = np.array([link.mass_kg for link in self.file.links])
        weights = Loads(self._centres, np.outer(masses, gravity_m_s2))
        loads = weights if any(gravity_m_s2) else None
        return equilibrium(self.chain, self.laws, p, plates, start, loads)

    def angle_deg(
        self, pressure_kPa: np.ndarray | float, gap_mm: float | None = None,
        gravity_m_s2: Sequence[float] = WEIGHTLESS,
    ) -> np.ndarray:  # fmt: skip
        """Return the tip's angle.

        Args:
            pressure_kPa: one, or (states,).
            gap_mm: of a plate; None: the finger is free.
            gravity_m_s2: acceleration along x, y, z.

        Returns:
            (states,) in degrees.
        """
        w = self.state(pressure_kPa, gap_mm, gravity_m_s2=gravity_m_s2).w
        return np.asarray(np.degrees(w[:, self.chain.bends].sum(axis=1)))

    def tip_mm(self, pressure_kPa: np.ndarray | float, gap_mm: float | None = None) -> np.ndarray:
        """Return the displacement of the tip's centre.

        Args:
            pressure_kPa: one, or (states,).
            gap_mm: of a plate; None: the finger is free.

        Returns:
            (states, 2) along x and z.
        """
        w = self.state(pressure_kPa, gap_mm).w
        return np.asarray((self.chain.places(w, self.tip)[:, 0] - self.tip.rest_mm[0])[:, [0, 2]])

    def force_N(
        self, pressure_kPa: np.ndarray | float, gap_mm: float, *, full_back: bool = False
    ) -> np.ndarray:
        """Return the force on a plate.

        Args:
            pressure_kPa: one, or (states,).
            gap_mm: of the plate.
            full_back: whether it faces the whole back.

        Returns:
            (states,) in N.
        """
        return self.state(pressure_kPa, gap_mm, full_back=full_back).forces_N

    def stiffness_N_per_mm(self, pressure_kPa: np.ndarray | float) -> np.ndarray:
        """Return the stiffness of the free tip.

        Args:
            pressure_kPa: one, or (states,).

        Returns:
            (states, 2) along x, in the plane of bending, and along y.
        """
        p = np.atleast_1d(np.asarray(pressure_kPa, dtype=float))
        return 1 / softness(self.chain, self.laws, self.state(p).w, self.tip, p)

    def frequencies_Hz(self, pressure_kPa: float) -> np.ndarray:
        """Return natural frequencies of the free chain at a constant pressure.

        Args:
            pressure_kPa: in the finger.

        Returns:
            (coordinates,) from the lowest on.
        """
        state, file, at = self.state(pressure_kPa), self.file, self._centres
        slopes, spins = self.chain.slopes(state.w, at)[0], self.chain.spins(state.w, at)[0]
        _, turns, _ = self.chain.frames(state.w[0])
        mass = np.zeros((self.chain.size,) * 2)
        for link, slope, spin, turn in zip(file.links, slopes, spins, turns, strict=True):
            xx, yy, zz, xy, xz, yz = link.inertia_kg_mm2
            inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
            mass += link.mass_kg * slope @ slope.T + spin @ inertia @ spin.T
        # N/mm by kg are 1000/s²
        squares = eigh(1e3 * state.stiffness[0], mass, eigvals_only=True)
        return np.asarray(np.sqrt(squares) / (2 * np.pi))

    def fills_s(self) -> float:
        """Return the time in which the finger's supply fills it to 95 % of its highest pressure.

        Raises:
            ConfigError: one line: the supply never does, or the finger has several cavities.
        """
        highest = self.file.valid.pressure_kPa[1]
        response = step_response(self._resting, line_of(self._supply(None)), highest)
        if math.isinf(response.reached_s):
            raise ConfigError(f"supply: {response.sentence}; allowed: one that fills it")
        return response.reached_s

    def _supply(self, other: AirLine | None) -> AirLine:
        """Another supply, or the finger's own."""
        configured = self.file.supply
        return with_valve(AirLine(**configured) if other is None and configured else other)

    @property
    def _resting(self) -> RestingFinger:
        """The free finger, by the runs of finite elements."""
        if not self.file.volume_mm3:
            raise ConfigError("robot.json: volume_mm3: none; allowed: of a finger of one cavity")
        pressures = np.array(self.file.free_kPa)
        return RestingFinger(pressures, np.array(self.file.volume_mm3), pressures)

    def filled_kPa(
        self, time_s: Sequence[float], set_kPa: Sequence[float], supply: AirLine | None = None
    ) -> np.ndarray:
        """Find the pressure that a supply of air makes in the free finger, without inertia.

        Args:
            time_s: times that rise, (n,).
            set_kPa: pressure that the supply is asked for there, linear in between, (n,).
            supply: of air, no syringe; None: that of the configuration.

        Returns:
            Pressure (kPa) in the finger at these times, (n,); from rest.

        Raises:
            ConfigError: one line: a syringe, times that do not rise, or several cavities.
        """
        if len(time_s) < 2 or len(time_s) != len(set_kPa) or not (np.diff(time_s) > 0).all():
            lengths = f"time_s = {len(time_s)} times, set_kPa = {len(set_kPa)} values"
            raise ConfigError(f"{lengths}: allowed: two or more, as many of both; times that rise")
        return filled_kPa(self._resting, line_of(self._supply(supply)), time_s, set_kPa)

    def pressure_for(
        self,
        *,
        angle_deg: float | None = None,
        tip_force_N: float | None = None,
        squeeze_N: float | None = None,
        gap_mm: float | None = None,
    ) -> float:
        """Find the least pressure for an angle, a tip's force or a squeeze.

        Args:
            angle_deg: of the tip; free, or with ``gap_mm`` against a plate.
            tip_force_N: on a plate that faces the tip, at ``gap_mm`` (default 0).
            squeeze_N: normal force of this finger on a flat side of food that faces its whole back,
                at ``gap_mm`` (default 0).
            gap_mm: from the straight finger's back.

        Returns:
            Pressure in kPa.

        Raises:
            ConfigError: one line, where not one of the three is given, the plate cuts the straight
                finger, or no pressure that the chain was fitted to reaches what is asked for.
        """
        targets = {"angle_deg": angle_deg, "tip_force_N": tip_force_N, "squeeze_N": squeeze_N}
        given = {key: value for key, value in targets.items() if value is not None}
        if len(given) != 1:
            raise ConfigError(f"pressure_for: allowed: one of {', '.join(targets)}")
        ((key, wanted),) = given.items()
        gap = gap_mm or 0.0
        if not gap >= 0:
            raise ConfigError(f"gap_mm = {gap:g}: allowed: 0 mm or more")
        curves: dict[str, Callable[[np.ndarray | float], np.ndarray]] = {
            "angle_deg": lambda p: self.angle_deg(p, gap_mm),
            "tip_force_N": lambda p: self.force_N(p, gap),
            "squeeze_N": lambda p: self.force_N(p, gap, full_back=True),
        }
        at, p = curves[key], self._pressures_kPa
        reached = at(p)
        over = reached - wanted
        above = np.flatnonzero(over >= 0)
        if not len(above) or over[0] > 0:
            raise ConfigError(
                f"{key} = {wanted:g}: allowed: {reached.min():.4g} to {reached.max():.4g} "
                f"{key.rsplit('_', 1)[1]}, from {p[0]:g} to {p[-1]:g} kPa"
            )
        first = int(above[0])
        if over[first] == 0:
            return float(p[first])
        return float(brentq(lambda x: float(at(x)[0]) - wanted, p[first - 1], p[first], xtol=1e-4))
