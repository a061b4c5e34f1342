"""Coupons as they truly are: simulated, with slips, gauges and specimens of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from support.stiffened import stiffened

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.experiments.rigs.uniaxial import Stretching, UniaxialTension
from dolfingrip.parameter import scaled

GAUGE_mm: Final = 33.0
AREA_mm2: Final = 9.0
LARGEST_mm: Final = 16.0
STEP: Final = 0.025
"""Strain of a load step; the analyser's are twice as long."""

NOISE_N: Final = 0.05
NOISE_mm: Final = 0.01
SCALE: Final = 0.015
SHAPE: Final = 0.002
SLACK_mm: Final = 0.1
GAUGE_STD_mm: Final = 0.5
MODULUS: Final = 0.2


@dataclass(frozen=True, slots=True)
class Protocol:
    """A plan of what is measured of each specimen.

    Attributes:
        name: of it.
        specimens: how many.
        time_s, travel_mm, cycle, branch: of each row.
    """

    name: str
    specimens: int
    time_s: np.ndarray
    travel_mm: np.ndarray
    cycle: np.ndarray
    branch: np.ndarray

    @property
    def read(self) -> np.ndarray:
        """Rows at which the force is read: not in the toe, as the default command has it."""
        return self.travel_mm >= Policy().toe * GAUGE_mm


def _protocol(name: str, specimens: int, ramps: list[tuple[float, float, int, float]]) -> Protocol:
    """Ramps: from, to (mm), readings, rate (mm/s)."""
    time, travel, cycle, branch = [0.0], [0.0], [1], ["loading"]
    for number, (start, end, count, rate) in enumerate(ramps):
        for place in np.linspace(start, end, count + 1)[1:]:
            time.append(time[-1] + abs(place - travel[-1]) / rate)
            travel.append(float(place))
            cycle.append(1 + number // 2)
            branch.append("loading" if end > start else "unloading")
    arrays = (np.array(each)[1:] for each in (time, travel, cycle, branch))
    return Protocol(name, specimens, *arrays)


PROTOCOLS: Final[Mapping[str, Protocol]] = {
    each.name: each
    for each in (
        _protocol("pull", 3, [(0.0, LARGEST_mm, 20, 2.5)]),
        _protocol(
            "loops", 2,
            [(0.0, LARGEST_mm, 14, 2.5), (LARGEST_mm, 0.0, 14, 2.5),
             (0.0, LARGEST_mm, 10, 0.5), (LARGEST_mm, 0.0, 10, 0.5)],
        ),
    )
}  # fmt: skip
"""``pull``: three specimens, once. ``loops``: two, up and down twice, the second time slowly."""


@dataclass(frozen=True, slots=True)
class Truth:
    """The hidden truth.

    Attributes:
        causes: values of effects of the catalogue by key, moduli at the configured stiffness.
        outsider: name, and strength by the ordinary one; none where empty.
        modulus, area, gauge: true by told.
        slack_mm: of all coupons.
        quiet: no noise, no scatter of specimens.
    """

    causes: Change = field(default_factory=dict)
    outsider: tuple[str, float] = ("", 0.0)
    modulus: float = 1.0
    area: float = 1.0
    gauge: float = 1.0
    slack_mm: float = 0.0
    discrepancy: float = 0.0
    quiet: bool = False


Outsider = Callable[["Pull", float], "Pull"]


@dataclass(slots=True)
class Pull:
    """One specimen on its way.

    Attributes:
        protocol: of it.
        number: of the specimen.
        travel_mm: at which the specimen is.
        stiffness: by that of the others.
        force_N: shown; empty before it is simulated.
    """

    protocol: Protocol
    number: int
    travel_mm: np.ndarray
    stiffness: float = 1.0
    force_N: np.ndarray = field(default_factory=lambda: np.empty(0))


def _jaws_slip(pull: Pull, strength: float) -> Pull:
    """Jaws slip once, at 60 % of the largest travel."""
    gone = np.cumsum(pull.travel_mm > 0.6 * LARGEST_mm) > 0
    pull.travel_mm = pull.travel_mm - 0.25 * strength * gone
    return pull


def _screw(pull: Pull, strength: float) -> Pull:
    """A screw of the crosshead that is uneven: an error of its pitch, 5 mm."""
    pull.travel_mm = pull.travel_mm + 0.12 * strength * np.sin(2 * np.pi * pull.travel_mm / 5.0)
    return pull


def _other_material(pull: Pull, strength: float) -> Pull:
    """One specimen is of another material: stiffer."""
    if pull.number == 1:
        pull.stiffness *= 1 + 0.15 * strength
    return pull


def _locks(pull: Pull, strength: float) -> Pull:
    """An energy that no entry has: fibres that pull from a strain of 30 % on."""
    strain = pull.travel_mm / GAUGE_mm
    pull.force_N = pull.force_N + 8.0 * strength * np.maximum(strain - 0.3, 0.0) ** 1.5 * AREA_mm2
    return pull


def _guide_rubs(pull: Pull, strength: float) -> Pull:
    """Dry friction of the guides: hysteresis that depends neither on rate nor on material."""
    moved = np.diff(pull.travel_mm, prepend=0.0)
    rub = np.zeros(len(moved))
    for i, step in enumerate(moved):
        before = rub[i - 1] if i else 0.0
        way = np.sign(step)
        rub[i] = way + (before - way) * np.exp(-abs(step) / 0.8)
    pull.force_N = pull.force_N + 0.4 * strength * rub
    return pull


def _cell_sticks(pull: Pull, strength: float) -> Pull:
    """A load cell that follows only what exceeds its play."""
    play, at = 0.25 * strength, 0.0
    shown = []
    for force in pull.force_N:
        at = float(np.clip(at, force - play, force + play))
        shown.append(at)
    pull.force_N = np.array(shown)
    return pull


def _tears(pull: Pull, strength: float) -> Pull:
    """A notch that opens beyond 35 % strain, for good."""
    open_ = np.maximum.accumulate(np.maximum(pull.travel_mm / GAUGE_mm - 0.35, 0.0))
    pull.force_N = pull.force_N * (1 - 0.6 * strength * open_)
    return pull


OUTSIDERS: Final[Mapping[str, tuple[Outsider, bool]]] = {
    "jaws_slip": (_jaws_slip, True),
    "screw": (_screw, True),
    "other_material": (_other_material, True),
    "locks": (_locks, False),
    "guide_rubs": (_guide_rubs, False),
    "cell_sticks": (_cell_sticks, False),
    "tears": (_tears, False),
}
"""With whether it acts on the travel, before the material answers."""


def configured() -> Config:
    """The model that is diagnosed, on these coupons."""
    side = AREA_mm2**0.5
    coupon = {"gauge_length_mm": GAUGE_mm, "width_mm": side, "thickness_mm": side}
    return Config().changed(coupon=coupon)


def measured(protocol: Protocol, truth: Truth, rng: np.random.Generator) -> list[np.ndarray]:
    """Forces (N) of each specimen, at the rows that are read."""
    base = configured()
    change = {**scaled(base, truth.modulus), **stiffened(truth.causes, truth.modulus)}
    config = changed(base, change)
    bar = UniaxialTension(config)
    act, on_travel = OUTSIDERS.get(truth.outsider[0], (None, False))
    # the same deviation of the material's law for all, as a discrepancy of the model
    common = _smooth(protocol, rng) * truth.discrepancy
    found = []
    for number in range(protocol.specimens):
        own = 0.0 if truth.quiet else SLACK_mm * np.sqrt(0.5) * rng.standard_normal()
        travel = protocol.travel_mm - truth.slack_mm - own
        pull = Pull(protocol, number, travel)
        if not truth.quiet:
            pull.stiffness = float(np.exp(SCALE * rng.standard_normal()))
        if act and on_travel:
            pull = act(pull, truth.outsider[1])
        pull.force_N = _force(bar, truth, pull)
        if act and not on_travel:
            pull = act(pull, truth.outsider[1])
        size = np.sqrt(np.mean(pull.force_N**2))
        pull.force_N = pull.force_N + size * common
        if not truth.quiet:
            slope = np.gradient(pull.force_N, np.cumsum(np.abs(np.diff(travel, prepend=0.0))))
            pull.force_N = pull.force_N + SHAPE * size * _smooth(protocol, rng)
            pull.force_N = pull.force_N + slope * NOISE_mm * rng.standard_normal(len(slope))
            pull.force_N = pull.force_N + NOISE_N * rng.standard_normal(len(slope))
        found.append(pull.force_N[protocol.read])
    return found


def _force(bar: UniaxialTension, truth: Truth, pull: Pull) -> np.ndarray:
    """Force of one specimen; below its slack it is not pulled."""
    strain = np.maximum(pull.travel_mm, 0.0) / (GAUGE_mm * truth.gauge)
    way = Stretching(list(strain), list(pull.protocol.time_s), STEP)
    (stretched,) = bar.follow({}, [way])
    return np.asarray(stretched.stress_MPa[0] * AREA_mm2 * truth.area * pull.stiffness)


def _smooth(protocol: Protocol, rng: np.random.Generator) -> np.ndarray:
    """A smooth deviation along load and path, 1 in size, 0 at rest: a spline of random knots."""
    path = np.cumsum(np.abs(np.diff(protocol.travel_mm, prepend=0.0))) / LARGEST_mm
    load = protocol.travel_mm / LARGEST_mm
    found = np.zeros(len(load))
    for along, every in ((load, 0.25), (path, 0.6)):
        knots = np.arange(0.0, along.max() + 2 * every, every)
        values = np.r_[0.0, rng.standard_normal(len(knots) - 1)]
        found += CubicSpline(knots, values)(along) / np.sqrt(2)
    return found


TOLD: Final = f"""experiment = "coupon"
gauge_length_mm = {GAUGE_mm}
area_mm2 = {AREA_mm2}
[noise]
force_N = {NOISE_N}
displacement_mm = {NOISE_mm}
[nuisance]
specimen_scale = {SCALE}
coupon.gauge_length_mm = {GAUGE_STD_mm}
"""


def write(protocol: Protocol, forces: list[np.ndarray], folder: Path) -> Path:
    """Write a CSV and its TOML, as a laboratory hands them over."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["experiment,specimen,cycle,branch,time_s,displacement_mm,force_N"]
    for number, force in enumerate(forces):
        shown = np.full(len(protocol.read), "", dtype=object)
        shown[protocol.read] = [f"{each:.5f}" for each in force]
        rows = zip(protocol.cycle, protocol.branch, protocol.time_s, protocol.travel_mm, shown,
                   strict=True)  # fmt: skip
        lines += [f"coupon,S{number + 1},{c},{b},{t:.3f},{x:.4f},{f}" for c, b, t, x, f in rows]
    file = folder / f"{protocol.name}.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    file.with_suffix(".toml").write_text(TOLD, encoding="utf-8")
    return file
