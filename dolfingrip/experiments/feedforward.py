"""Commands of a supply with which a finger follows a curve of pressure or angle.

The finger is simulated once, at rest at each pressure: its cavity's volume and its angle follow
from that. The air of the supply is then balanced with this volume at steps of equal length. At each
step, valve and exhaust are opened as far as the curve asks for, or as far as they can.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import brentq

from dolfingrip.channels import ANGLE, CAVITY_VOLUME, PRESSURE, TIME
from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.config import KPA, Config
from dolfingrip.experiments.filling import RestingFinger, step_response
from dolfingrip.experiments.loop import run
from dolfingrip.experiments.prediction import PressureCurve
from dolfingrip.experiments.results.following import REACHED, StepResponse
from dolfingrip.experiments.rigs.pneumatics import line_of
from dolfingrip.mechanics.model.pneumatics import CAVITY, LEAST_MPA, TUBE, Air, Line
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.supply import with_valve

STOPS: Final = 12
"""Pressures at which the finger is simulated."""

NAMES: Final[Mapping[str, str]] = {
    "set_point_kPa": "set point", "valve_open": "valve", "exhaust_open": "exhaust"
}  # fmt: skip
"""What the key of the picture calls the columns of commands."""

COLOURS: Final = ("green", "purple")
"""Colours of commands in it."""

OPENING: Final = 1e-9
"""Error of the part of a valve that is open."""


@dataclass(frozen=True, slots=True)
class Feedforward:
    """Commands of a supply at equal times, and what the finger does by them.

    Attributes:
        time_s: ends of the steps, (n,).
        wished_kPa: pressure that the cavity should have there, (n,).
        reached_kPa: pressure that it has, (n,).
        tube_kPa: pressure in the tube, (n,).
        angle_deg: of the finger at rest at the pressure that is reached, (n,).
        wished_deg: angle that it should have, (n,); None where a pressure is wished.
        commands: by column: ``set_point_kPa`` of a regulator, or ``valve_open`` and
            ``exhaust_open``, the parts of the step in which they are open, (n,).
        cavity_cm3: volume of the cavity at rest.
        fastest: its filling to the highest wished pressure, with the valve open all the time.
    """

    time_s: np.ndarray
    wished_kPa: np.ndarray
    reached_kPa: np.ndarray
    tube_kPa: np.ndarray
    angle_deg: np.ndarray
    wished_deg: np.ndarray | None
    commands: Mapping[str, np.ndarray]
    cavity_cm3: float
    fastest: StepResponse

    def rows(self) -> list[dict[str, float]]:
        """Return the table's rows, by column."""
        columns = {TIME.name: self.time_s, "wished_kPa": self.wished_kPa,
                   "cavity_pressure_kPa": self.reached_kPa, "tube_kPa": self.tube_kPa}  # fmt: skip
        if self.wished_deg is not None:
            columns["wished_deg"] = self.wished_deg
        columns |= {ANGLE.name: self.angle_deg, **self.commands}
        lines = zip(*columns.values(), strict=True)
        return [dict(zip(columns, map(float, line), strict=True)) for line in lines]

    def sentences(self) -> list[str]:
        """Return what to know of them: the fastest filling, and where the curve is missed."""
        highest = self.fastest.wanted_kPa
        lines = [f"at best {self.fastest.sentence}; at rest it holds {self.cavity_cm3:.3g} cm³"]
        late = self.reached_kPa - self.wished_kPa
        worst = int(np.abs(late).argmax())
        if abs(late[worst]) < (1 - REACHED) * highest:
            return [*lines, f"it follows the curve within {abs(late[worst]):.2g} kPa"]
        below = late[worst] < 0
        side, end = ("below", "highest") if below else ("above", "lowest")
        if "valve_open" in self.commands:
            at_its_end = f"though the {'valve' if below else 'exhaust'} is fully open"
        else:
            at_its_end = f"though the set point is the {end}"
        part = float(np.mean(np.abs(late) >= (1 - REACHED) * highest))
        where = f"{abs(late[worst]):.3g} kPa {side} the curve after {self.time_s[worst]:.3g} s"
        missed = f"it is more than {100 * (1 - REACHED):.0f} % of {highest:.4g} kPa off"
        lines.append(f"the cavity is {where}, {at_its_end}")
        return [*lines, f"{missed} for {100 * part:.0f} % of the time"]

    def chart(self) -> Chart:
        """Draw the pressures over time, and the commands below them."""
        time = Axis("Time (s)", "s", "Time")
        regulated = "set_point_kPa" in self.commands
        up = Axis("Set point (kPa)", "kPa") if regulated else Axis("Duty (–)")
        commands = [
            Series(NAMES[name], self.time_s, values, colour=colour)
            for colour, (name, values) in zip(COLOURS, self.commands.items(), strict=False)
        ]
        lower = Chart("Commands", time, up, commands)
        pressures = [
            Series("tube", self.time_s, self.tube_kPa, colour="orange"),
            Series("cavity", self.time_s, self.reached_kPa, colour="blue"),
            Series("wished", self.time_s, self.wished_kPa, style="dash", colour="ink"),
        ]
        return Chart("Pressures", time, Axis("Pressure (kPa)", "kPa"), pressures, below=lower)


def command_for(
    config: Config,
    time_s: Sequence[float],
    *,
    pressure_kPa: Sequence[float] | None = None,
    angle_deg: Sequence[float] | None = None,
    every_s: float | None = None,
    regulator_kPa: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    finger: RestingFinger | None = None,
) -> Feedforward:
    """Find the commands of a supply with which a finger follows a curve.

    The finger's inertia and memory are left out.

    Args:
        config: with a supply, of a finger of one cavity.
        time_s: times of the curve, rising from 0 on, (m,).
        pressure_kPa: pressure that the cavity should have there, (m,); or
        angle_deg: angle that the tip should have there, (m,).
        every_s: length of a step; default: a 200th of the curve.
        regulator_kPa: highest set point of an ideal source; default: the highest wished pressure.
        progress: called with the number of steps that are done, and of all.
        finger: at rest up to the highest pressure; default: it is simulated.

    Returns:
        The commands.

    Raises:
        ConfigError: one line about what is wrong with the curve or the configuration.
    """
    supply, times = with_valve(config.supply), np.asarray(time_s, dtype=float)
    if len(times) < 2 or times[0] != 0 or not (np.diff(times) > 0).all():
        raise ConfigError(f"{TIME.name} = {times[:3]}: allowed: two or more, rising from 0 s on")
    every = times[-1] / 200 if every_s is None else every_s
    if not 0 < every <= times[-1]:
        raise ConfigError(f"every_s = {every:g}: allowed: above 0 and up to {times[-1]:g} s")
    if (pressure_kPa is None) == (angle_deg is None):
        raise ConfigError(f"a curve: allowed: one of {PRESSURE.name} and {ANGLE.name}")
    steps = every * np.arange(1, int(times[-1] / every * (1 + 1e-9)) + 1)
    if pressure_kPa is not None:
        pressures = np.asarray(pressure_kPa, dtype=float)
        _within(PRESSURE.name, pressures, 0.0, supply.most_kPa, "kPa, the highest of the source")
        finger = finger or _resting(config, float(pressures.max()))
        wished_deg, wished = None, np.interp(steps, times, pressures)
    else:
        most = min(config.experiment.max_pressure_kPa, supply.most_kPa)
        finger = finger or _resting(config, most)
        angles = np.asarray(angle_deg, dtype=float)
        low, high = finger.angle_deg.min(), finger.angle_deg.max()
        _within(ANGLE.name, angles, float(low), float(high), f"°, that of {most:g} kPa")
        rising = np.maximum.accumulate(finger.angle_deg)
        wished_deg = np.interp(steps, times, angles)
        wished = np.interp(wished_deg, rising, finger.pressure_kPa)
    highest = float(wished.max()) if regulator_kPa is None else regulator_kPa
    filling = Filling(line_of(supply), finger.volume_at(), highest * KPA)
    reached = []
    for step in filling.following(wished * KPA, every):
        reached.append(step)
        progress(len(reached), len(steps))
    line = filling.line
    opened = line if filling.regulated else replace(line, commanded=(line.duty, 0.0))
    fastest = step_response(finger, opened, highest, float(wished.max()))
    cavity, tube, command = np.array(reached).T
    ambient = line.ambient
    if filling.regulated:
        commands = {"set_point_kPa": (command - ambient) / KPA}
    else:
        commands = {"valve_open": command.clip(min=0), "exhaust_open": (-command).clip(min=0)}
    reached_kPa = (cavity - ambient) / KPA
    return Feedforward(
        steps, wished, reached_kPa, (tube - ambient) / KPA,
        PressureCurve.of(finger.pressure_kPa, finger.angle_deg).at(reached_kPa),
        wished_deg, commands, float(finger.volume_mm3[0]) / 1000, fastest,
    )  # fmt: skip


def _within(name: str, values: np.ndarray, low: float, high: float, unit: str) -> None:
    """Refuse values of a curve that no finger or source has."""
    outside = values[~((values >= low) & (values <= high))]
    if outside.size:
        raise ConfigError(f"{name} = {outside[0]:g}: allowed: {low:.4g} to {high:.4g} {unit}")


def _resting(config: Config, highest_kPa: float) -> RestingFinger:
    """Simulate the finger at rest, up to a pressure.

    Raises:
        ConfigError: one line, where it has no equilibrium up to there, or several cavities.
    """
    if highest_kPa <= 0:
        raise ConfigError(f"{PRESSURE.name} = 0 all along: allowed: a curve that rises above 0 kPa")
    ramp = {"min_pressure_kPa": 0.0, "max_pressure_kPa": highest_kPa,
            "step_kPa": highest_kPa / STOPS}  # fmt: skip
    result = run("bending", config.at_rest().changed(experiment=ramp))
    if result.failure is not None:
        raise ConfigError(f"up to {highest_kPa:g} kPa: {result.failure.sentence()}")
    if CAVITY_VOLUME.name not in result.rows[0]:
        raise ConfigError("supply = a table: allowed here: for a finger of one cavity")
    columns = (result.column(one.name) for one in (PRESSURE, CAVITY_VOLUME, ANGLE))
    pressure, volume, angle = columns
    return RestingFinger(pressure, volume, angle)


@dataclass(slots=True)
class Filling:
    """A cavity that a supply fills, with its valve and exhaust or its set point commanded.

    Attributes:
        line: of the supply.
        volume_mm3: of the cavity by its pressure (kPa above the air around).
        highest: the largest set point of a regulator (MPa).
    """

    line: Line
    volume_mm3: Callable[[float], float]
    highest: float

    @property
    def regulated(self) -> bool:
        """A set point is commanded, in place of valve and exhaust."""
        return self.line.pump is None and not self.line.tank_mm3

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest command."""
        ambient = self.line.ambient
        return (ambient, ambient + self.highest) if self.regulated else (-1.0, self.line.duty)

    def following(self, wished: np.ndarray, step_s: float) -> Iterator[tuple[float, float, float]]:
        """Follow a curve of pressures above that of the air around (MPa), from rest on.

        Yields:
            At each step's end the pressures of cavity and tube (MPa, absolute), and the command.
        """
        air, (least, most) = Air(self.line), self.ends
        air.rest(self.volume_mm3(0.0))
        for pressure in wished + self.line.ambient:

            def excess(command: float, air: Air = air, pressure: float = pressure) -> float:
                return self._excess(air, pressure, command, step_s)

            if excess(most) <= 0:
                yield (*self._step(air, most, step_s), most)
            elif excess(least) >= 0:
                yield (*self._step(air, least, step_s), least)
            else:
                command = float(brentq(excess, least, most, xtol=OPENING))
                yield (*self._accepted(air, pressure, command, step_s), command)

    def _commanded(self, air: Air, command: float) -> float:
        """Set the valves; return the pressure that the source is asked for."""
        if self.regulated:
            return command
        air.line = replace(self.line, commanded=(max(command, 0.0), max(-command, 0.0)))
        return 0.0

    def _excess(self, air: Air, cavity: float, command: float, step_s: float) -> float:
        """Volume of the air by that of the cavity at a pressure, less (mm³)."""
        taken = air.volume_mm3(cavity, self._commanded(air, command), step_s)
        return taken - self.volume_mm3((cavity - self.line.ambient) / KPA)

    def _step(self, air: Air, command: float, step_s: float) -> tuple[float, float]:
        """Take a step; return the pressures of cavity and tube at its end (MPa, absolute)."""
        most = 4 * max(command if self.regulated else 0.0, *air.now.pressures, self.line.tank_MPa,
                       self.line.pump.pressures[-1] if self.line.pump else 0.0)  # fmt: skip
        cavity = float(
            brentq(lambda p: self._excess(air, p, command, step_s), LEAST_MPA, most, xtol=1e-12)
        )
        return self._accepted(air, cavity, command, step_s)

    def _accepted(
        self, air: Air, cavity: float, command: float, step_s: float
    ) -> tuple[float, float]:
        """End a step with a pressure in the cavity; return those of cavity and tube there."""
        end = air.ends(cavity, self._commanded(air, command), step_s)
        air.accept(end, step_s)
        air.accept(end, 0.0)  # the next command is a sudden change
        return float(end.pressures[CAVITY]), float(end.pressures[TUBE])
