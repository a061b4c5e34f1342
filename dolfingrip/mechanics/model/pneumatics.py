"""Compressed air from a source through a valve and a tube into a cavity.

Amounts of air are volumes of free air (mm³ at :data:`REFERENCE_MPA` and 20 °C), pressures are
absolute (MPa).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import brentq

from dolfingrip.channels import AMBIENT_KPA

REFERENCE_MPA: Final = 0.1
"""Pressure of the reference atmosphere of ISO 8778, at 20 °C."""
MG_PER_MM3: Final = 1.185e-3
"""Density of air in the reference atmosphere of ISO 8778."""
LAMINAR: Final = 0.999
"""Ratio of pressures from which on a flow is laminar, so that its slope is finite."""
LONGEST_RATIO: Final = 2.4
"""Ratio of a step's length and that before up to which the second-order formula is stable."""
SLOPE: Final = 1e-6
"""Part of a pressure by which a derivative is taken."""
LEAST_MPA: Final = 1e-9
"""Absolute pressure below that of any air here."""

SOURCE, TUBE, CAVITY, OUTSIDE = range(4)
"""Places of volumes in arrays, and what stands for the air around."""
ENTERING, VENTED, THROUGH, LEAK = range(4)
"""Places of flows in arrays: through valve, exhaust, tube and leak."""


@dataclass(frozen=True, slots=True)
class Restriction:
    """A valve, a tube or an orifice by ISO 6358-1: choked, or unchoked with an elliptic law.

    q = C p₁ √(T₀/T₁) ψ(p₂/p₁), with ψ = 1 up to the critical ratio b, and
    ψ² = 1 − ((p₂/p₁ − b)/(1 − b))² above.

    Attributes:
        conductance: C, the sonic conductance (mm³ of free air for each s and MPa).
        critical: b, the critical ratio of pressures.
    """

    conductance: float
    critical: float

    @classmethod
    def orifice(cls, diameter_mm: float, discharge: float = 0.65) -> Restriction:
        """A sharp-edged hole.

        The isentropic nozzle's choked flow of air at 20 °C is C = 0.199 dm³/(s bar) for each mm² of
        its vena contracta, and b = 0.528.

        Args:
            diameter_mm: of the hole.
            discharge: area of the vena contracta by that of the hole.
        """
        return cls(0.199e7 * discharge * math.pi / 4 * diameter_mm**2, 0.528)

    def flow(self, inlet: float, outlet: float, warm: tuple[float, float] = (1.0, 1.0)) -> float:
        """Flow of free air from inlet to outlet (mm³/s); it is negative where it goes back.

        Args:
            inlet, outlet: absolute pressures on both sides (MPa).
            warm: absolute temperatures on both sides, by that of the reference atmosphere.
        """
        if outlet > inlet:
            return -self.flow(outlet, inlet, warm[::-1])
        ratio, b = outlet / inlet, self.critical
        part = 1.0
        if ratio > b:
            part = math.sqrt(1 - ((min(ratio, LAMINAR) - b) / (1 - b)) ** 2)
        if ratio > LAMINAR:
            part *= (1 - ratio) / (1 - LAMINAR)
        return self.conductance * inlet * part / math.sqrt(warm[0])


@dataclass(frozen=True, slots=True)
class Pump:
    """A pump whose flow of free air (mm³/s) falls along a line of points with its pressure.

    Attributes:
        pressures: absolute, that rise (MPa).
        flows: at these; none beyond the last one.
    """

    pressures: Sequence[float]
    flows: Sequence[float]

    def through(self, valve: Restriction, outlet: float) -> float:
        """Flow through a valve behind the pump, as no air is stored in between.

        Args:
            valve: with what part of it is open.
            outlet: absolute pressure behind the valve (MPa).
        """

        def excess(pressure: float) -> float:
            return float(np.interp(pressure, self.pressures, self.flows, right=0.0)) - valve.flow(
                pressure, outlet
            )

        most = self.pressures[-1]
        if valve.conductance == 0 or outlet >= most:
            return 0.0
        return valve.flow(brentq(excess, outlet, most), outlet) if excess(most) < 0 else 0.0


@dataclass(frozen=True, slots=True)
class Line:
    """A line from a source of air to a cavity: valve, exhaust, tube, leak and gauge.

    The source has the prescribed pressure itself where there is neither pump nor tank. A valve in
    front of a pump or tank opens in proportion to what the gauge lacks, up to its duty, and its
    exhaust in proportion to the gauge's excess. An on-off valve that pulses counts by its mean.

    Attributes:
        valve: between source and tube.
        exhaust: from the tube to the air around, or back to a source of prescribed pressure.
        tube: between the tube's volume and the cavity.
        tube_mm3: volume of valve, tube and fittings.
        leak: from the cavity to the air around; None: it is tight.
        leak_growth: by how much its conductance grows with each tenfold number of cycles.
        pump: the source; None: it is none.
        tank_mm3: volume of a tank as the source; 0: there is none.
        tank_MPa: its absolute pressure at first.
        exponent: n of the change of state: 1 isothermal, 1.4 adiabatic.
        duty: largest part of the time that an on-off valve is open.
        band_MPa: what the gauge lacks where the valve is fully open.
        gauge: its place by the tube's resistance: 0 at the cavity, 1 at the valve.
        ambient: absolute pressure of the air around (MPa).
        commanded: parts of valve and exhaust that are open; None: the gauge controls them.
    """

    valve: Restriction
    exhaust: Restriction
    tube: Restriction
    tube_mm3: float
    leak: Restriction | None = None
    pump: Pump | None = None
    tank_mm3: float = 0.0
    tank_MPa: float = 0.0
    exponent: float = 1.0
    duty: float = 1.0
    band_MPa: float = 0.01
    gauge: float = 1.0
    ambient: float = AMBIENT_KPA / 1000
    commanded: tuple[float, float] | None = None
    leak_growth: float = 0.0

    def filling_s(self, cavity_mm3: float) -> float:
        """Time in which valve and tube, choked, fill tube and cavity with air at rest.

        Args:
            cavity_mm3: volume of the cavity.
        """
        slowest = min(self.duty * self.valve.conductance, self.tube.conductance)
        return (cavity_mm3 + self.tube_mm3) / (REFERENCE_MPA * slowest)

    def gauged(self, tube: float, cavity: float) -> float:
        """Pressure at the gauge (MPa), which is linear along the tube.

        Args:
            tube, cavity: absolute pressures at its ends (MPa).
        """
        return self.gauge * tube + (1 - self.gauge) * cavity

    def opening(self, lacking: float) -> tuple[float, float]:
        """Parts of valve and exhaust that are open.

        Args:
            lacking: what the gauge lacks of the prescribed pressure (MPa).
        """
        if self.commanded is not None:
            return self.commanded
        if self.pump is None and not self.tank_mm3:
            return self.duty, self.duty
        part = lacking / self.band_MPa
        return min(max(part, 0.0), self.duty), min(max(-part, 0.0), 1.0)


class Ends(NamedTuple):
    """The air as a load step ends.

    Attributes:
        pressures: absolute, of source, tube and cavity (MPa).
        flows: through valve, exhaust, tube and leak (mm³/s of free air).
        amounts: of air in source, tube and cavity (mm³ of free air).
        invariants: p^(1/n) V of source, tube and cavity (MPa^(1/n) mm³).
        entered: air that came from outside so far (mm³ of free air).
    """

    pressures: np.ndarray
    flows: np.ndarray
    amounts: np.ndarray
    invariants: np.ndarray
    entered: float


@dataclass(slots=True)
class Air:
    """The air in source, tube and cavity, of which a load step's flows are a function.

    Each volume keeps the amount of its air and the invariant S = p^(1/n) V. Air that leaves takes
    S with it in proportion; air that enters at the temperature T adds p^(1/n − 1) p₀ q T/T₀, which
    is the balance of energy of an ideal gas for n = 1.4, and that of mass for n = 1. A step takes
    the second-order backward differentiation formula, so that what leaves one volume is what enters
    the next, to the last digit; a step after a sudden change is the implicit Euler method's.

    Attributes:
        line: what the air flows through.
        now: the air at the present step's start.
        mean: flows in the step before, and rates of the invariants.
        decades: logarithm to the base 10 of the number of the cycle.
        dead_mm3: volume beside the cavity with the pressure in it, as of a syringe; a syringe has
            no flow but the leak.
        syringe: whether the source is a syringe.
    """

    line: Line
    syringe: bool = False
    dead_mm3: float = 0.0
    decades: float = 0.0
    now: Ends = field(init=False)
    mean: tuple[np.ndarray, np.ndarray] = field(init=False)
    _before_s: float = field(default=0.0, init=False)

    def rest(self, cavity_mm3: float) -> None:
        """Fill cavity and tube with air of the pressure around, at rest."""
        line, n = self.line, self.line.exponent
        tube_mm3 = 0.0 if self.syringe else line.tube_mm3  # a syringe's is dead volume
        volumes = np.array([line.tank_mm3, tube_mm3, cavity_mm3 + self.dead_mm3])
        pressures = np.array([line.tank_MPa or line.ambient, line.ambient, line.ambient])
        amounts = pressures * volumes / REFERENCE_MPA
        invariants = pressures ** (1 / n) * volumes
        self.now = Ends(pressures, np.zeros(4), amounts, invariants, 0.0)
        self.mean, self._before_s = (np.zeros(4), np.zeros(3)), 0.0

    # -- a step's end ----------------------------------------------------------------------------

    def ends(self, cavity: float, prescribed: float, step_s: float) -> Ends:
        """The air at a step's end.

        Args:
            cavity: absolute pressure in the cavity (MPa).
            prescribed: absolute pressure that is asked for (MPa).
            step_s: length of the step; 0: nothing has flowed.
        """
        step = _Step.of(self, prescribed, step_s)
        return step.ends(step.pressures(cavity))

    def volume_mm3(self, cavity: float, prescribed: float, step_s: float) -> float:
        """Volume of the cavity's air at a step's end, which falls as its pressure rises.

        The arguments are those of :meth:`ends`.
        """
        invariant = self.ends(cavity, prescribed, step_s).invariants[CAVITY]
        return float(invariant / cavity ** (1 / self.line.exponent)) - self.dead_mm3

    def slope(
        self, cavity: float, prescribed: float, step_s: float, volume_mm3: float, give: float
    ) -> float:
        """Change of :meth:`volume_mm3` by the cavity's pressure (mm³/MPa), for Newton's method.

        A flow's slope jumps where it turns, chokes or a valve closes, so that tangents may lead to
        and fro. It is the secant to the pressure at which the air would fit a cavity that gives way
        in proportion; there, and at a solution, it is the derivative.

        Args:
            cavity: absolute pressure in the cavity (MPa).
            prescribed: absolute pressure that is asked for (MPa).
            step_s: length of the step.
            volume_mm3: of the cavity at this pressure.
            give: by how much it grows with the pressure (mm³/MPa), at least 0.
        """

        def excess(pressure: float) -> float:
            taken = self.volume_mm3(pressure, prescribed, step_s)
            return volume_mm3 + give * (pressure - cavity) - taken

        most = 4 * max(cavity, prescribed, *self.now.pressures)
        fits = cavity
        if excess(LEAST_MPA) < 0 < excess(most):
            fits = float(brentq(excess, LEAST_MPA, most, rtol=SLOPE))
        change = fits - cavity
        if abs(change) < 2 * SLOPE * cavity:
            change = SLOPE * cavity
        taken = [self.volume_mm3(cavity + d, prescribed, step_s) for d in (0.0, change)]
        return (taken[1] - taken[0]) / change

    def error(self, end: Ends, step_s: float) -> float:
        """Error of the pressure (MPa) of a step: its amount of air against the trapezoidal rule's.

        Args:
            end: the step's.
            step_s: its length.
        """
        start = self.now

        def net(of: Ends) -> float:
            return float(of.flows[THROUGH] - of.flows[LEAK])

        trapezoid = step_s * (net(start) + net(end)) / 2
        off = end.amounts[CAVITY] - start.amounts[CAVITY] - trapezoid
        return float(self.line.exponent * end.pressures[CAVITY] * abs(off) / end.amounts[CAVITY])

    def accept(self, end: Ends, step_s: float) -> None:
        """Take a step's end as the start of the next one.

        Args:
            end: of :meth:`ends`.
            step_s: length of the step; after a step of no length the next one has no past.
        """
        if step_s:
            old = self.weight(step_s)
            flows = old * self.mean[0] + (1 - old) * end.flows
            self.mean = (flows, (end.invariants - self.now.invariants) / step_s)
        self._before_s, self.now = step_s, end

    # -- as a part of a state --------------------------------------------------------------------

    def values(self) -> dict[str, np.ndarray]:
        """Return a copy of the state of the air, by name."""
        now = {f"air {name}": np.array(value) for name, value in self.now._asdict().items()}
        means = {"air mean flows": self.mean[0], "air mean rates": self.mean[1]}
        return {**now, **means, "air step_s": np.array(self._before_s)}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore a state that :meth:`values` returned."""
        pressures, flows, amounts, invariants, entered = (
            values[f"air {name}"] for name in Ends._fields
        )
        self.now = Ends(pressures, flows, amounts, invariants, float(entered))
        self.mean = (values["air mean flows"], values["air mean rates"])
        self._before_s = float(values["air step_s"])

    # -- flows -----------------------------------------------------------------------------------

    def weight(self, step_s: float) -> float:
        """Part of the last step's mean flow in that of the next one; 0: the implicit Euler method.

        It is 0, too, where the past would take half of the air that is left.
        """
        ratio = step_s / self._before_s if self._before_s else math.inf
        if not step_s or ratio > LONGEST_RATIO:
            return 0.0
        old = ratio / (1 + 2 * ratio)
        ahead = self.now.invariants + step_s * old * self.mean[1]
        return old if (2 * ahead >= self.now.invariants).all() else 0.0

    @property
    def ways(self) -> Sequence[tuple[int, int]]:
        """From where to where each flow goes; only a tank has a volume in front of the valve."""
        front = SOURCE if self.line.tank_mm3 else OUTSIDE
        return ((front, TUBE), (TUBE, OUTSIDE), (TUBE, CAVITY), (CAVITY, OUTSIDE))

    def flows(
        self, pressures: Sequence[float], prescribed: float, warm: Sequence[float]
    ) -> list[float]:
        """Flows at the pressures and temperatures of source, tube and cavity.

        Args:
            pressures: absolute (MPa), (3,).
            prescribed: absolute pressure that is asked for (MPa).
            warm: temperatures of these and of the air around, by the reference, (4,).
        """
        line = self.line
        source, tube, cavity = pressures
        leak = 0.0
        if line.leak:
            grown = line.leak.conductance + self.decades * line.leak_growth
            hole = Restriction(grown, line.leak.critical)
            leak = hole.flow(cavity, line.ambient, (warm[CAVITY], 1.0))
        if self.syringe:
            return [0.0, 0.0, 0.0, leak]
        part, out = line.opening(prescribed - line.gauged(tube, cavity))
        valve = Restriction(part * line.valve.conductance, line.valve.critical)
        exhaust = Restriction(out * line.exhaust.conductance, line.exhaust.critical)
        between = warm[SOURCE if line.tank_mm3 else OUTSIDE], warm[TUBE]
        vented = exhaust.flow(tube, line.ambient, between[::-1])
        if line.pump:
            entering = line.pump.through(valve, tube)
        elif line.tank_mm3:  # a check valve stands behind it
            entering = max(valve.flow(source, tube, between), 0.0)
        else:
            entering, vented = (valve if source >= tube else exhaust).flow(source, tube, between), 0
        through = line.tube.flow(tube, cavity, (warm[TUBE], warm[CAVITY]))
        return [entering, vented, through, leak]

    def exchanged(
        self, pressures: Sequence[float], prescribed: float, shares: Sequence[float]
    ) -> tuple[list[float], list[float], list[float], list[float]]:
        """Flows, and what source, tube, cavity and the air around gain by them in a second.

        Args:
            pressures: absolute (MPa), (3,).
            prescribed: absolute pressure that is asked for (MPa).
            shares: p^(1/n) V of source, tube and cavity by their amounts of air, (3,).

        Returns:
            The flows; the gain of each place (mm³/s of free air); what enters it; and that times
            its temperature by the reference.
        """
        n = self.line.exponent
        ratios = zip((max(p, LEAST_MPA) for p in pressures), shares, strict=True)
        warm = [*(p ** (1 - 1 / n) * share / REFERENCE_MPA for p, share in ratios), 1.0]
        flows = self.flows(pressures, prescribed, warm)
        gain, entered, warmth = [0.0] * 4, [0.0] * 4, [0.0] * 4
        for (one, other), flow in zip(self.ways, flows, strict=True):
            start, end, size = (one, other, flow) if flow > 0 else (other, one, -flow)
            gain[start] -= size
            gain[end] += size
            entered[end] += size
            warmth[end] += warm[start] * size
        return flows, gain, entered, warmth


@dataclass(slots=True)
class _Step:
    """A load step of the air in a line: its past, and the balances at its end.

    The search for the pressures asks for the balances some thousand times, in plain numbers: arrays
    of three take four times as long.

    Attributes:
        shares: p^(1/n) V of source, tube and cavity at the step's start, by the amount of air.
    """

    air: Air
    prescribed: float
    step_s: float
    old: float
    amounts: list[float]
    invariants: list[float]
    shares: list[float]

    @classmethod
    def of(cls, air: Air, prescribed: float, step_s: float) -> _Step:
        old, now = air.weight(step_s), air.now
        flows, rates = air.mean
        share = np.full(3, REFERENCE_MPA)
        np.divide(now.invariants, now.amounts, out=share, where=now.amounts > 0)
        made = cls(air, prescribed, step_s, old, [], [], list(map(float, share)))
        made.amounts = list(map(float, now.amounts + step_s * old * made.net(flows)[0]))
        made.invariants = list(map(float, now.invariants + step_s * old * rates))
        return made

    def net(self, flows: np.ndarray) -> tuple[np.ndarray, float]:
        """The gain of source, tube and cavity by some flows, and the part of it from outside."""
        gain = np.zeros(4)
        for (one, other), flow in zip(self.air.ways, flows, strict=True):
            gain[one] -= flow
            gain[other] += flow
        return gain[:OUTSIDE], -float(gain[OUTSIDE])

    def balances(self, pressures: Sequence[float]) -> tuple[list[float], list[float], list[float]]:
        """Flows, and amounts and invariants of source, tube and cavity, with these pressures.

        What leaves a volume takes the invariant with it as it is at the end. Temperatures are those
        of the change of state since the step's start.
        """
        n, weight = self.air.line.exponent, self.step_s * (1 - self.old)
        flows, gain, entered, warmth = self.air.exchanged(pressures, self.prescribed, self.shares)
        amounts, invariants = [], []
        for i, pressure in enumerate(max(pressure, LEAST_MPA) for pressure in pressures):
            brought = weight * warmth[i] * REFERENCE_MPA
            before = self.amounts[i] + weight * entered[i]  # anything leaves
            amounts.append(self.amounts[i] + weight * gain[i])
            part = amounts[i] / before if before > 0 else amounts[i]
            invariants.append((self.invariants[i] + brought * pressure ** (1 / n - 1)) * part)
        return flows, amounts, invariants

    def ends(self, pressures: Sequence[float]) -> Ends:
        """The air at the step's end with these pressures of source, tube and cavity."""
        flows, amounts, invariants = map(np.array, self.balances(pressures))
        mean = self.old * self.air.mean[0] + (1 - self.old) * flows
        outside = self.air.now.entered + self.step_s * self.net(mean)[1]
        return Ends(np.array(pressures), flows, amounts, invariants, outside)

    def pressures(self, cavity: float) -> Sequence[float]:
        """Pressures of source, tube and cavity with which the step's balances hold."""
        line, start = self.air.line, self.air.now.pressures
        if self.air.syringe:
            return (cavity, cavity, cavity)
        pumped = line.pump.pressures[-1] if line.pump else 0.0
        most = 4 * max(cavity, self.prescribed, line.tank_MPa, pumped, *start.tolist())
        volumes = (line.tank_mm3, line.tube_mm3)

        def off(node: int, *pressures: float) -> float:
            stored = volumes[node] * pressures[node] ** (1 / line.exponent)
            return float(stored - self.balances(pressures)[2][node])

        def source(tube: float) -> float:
            if not line.tank_mm3:
                return self.prescribed
            return _root(lambda pressure: off(SOURCE, pressure, tube, cavity), most)

        tube = _root(lambda pressure: off(TUBE, source(pressure), pressure, cavity), most)
        return (source(tube), tube, cavity)


def _root(balance: Callable[[float], float], most: float) -> float:
    """The pressure (MPa) at which a balance, which rises with it, is 0."""
    return float(brentq(balance, LEAST_MPA, most, xtol=1e-15, rtol=1e-14))
