"""Fingers whose diagnoses may ask for more: what is hidden in each, drawn and kept as files."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Final

from benchmarks.blind import said
from benchmarks.blind.case import Case
from benchmarks.blind.fingers import cases as fingers
from benchmarks.blind.fingers import finger
from benchmarks.blind.fingers.finger import FREE, PRESSURE, Protocol, Truth, ramped

FOLDER: Final = Path(__file__).with_name("frozen")
SEED: Final = 720611
SEEN: Final = 4.0
"""Standard deviations of the hidden simulation from which on a cause is hidden."""
KIND: Final = "one"

SMALL: Final = Protocol(
    "small", ("mesh.size_mm=7", "finger.length_mm=63", "finger.bellows=5"),
    finger.MESH, (),
    dict.fromkeys(FREE, ramped(PRESSURE, [(80.0, 8, 25.0), (0.0, 8, 25.0)])), FREE,
    gap_mm=0.5, offset_std_kPa=0.5, gap_std_mm=0.1, noise=0.5, once=True,
)  # fmt: skip
"""Five bellows, free and blocked, up and down to 80 kPa, with half the ordinary noise. The hidden
mesh is a finer one: tetrahedra of 8 mm are 14 % stiffer than a converged mesh, and so their moduli
are not those that a diagnosis should find. Strengths are counted on the analyser's mesh."""

PULL: Final = Protocol(
    "pull", (), (), (), {"coupon": ramped("displacement_mm", [(finger.COUPON_mm, 12, 2.5)])},
    {"coupon": ("force_N",)},
)  # fmt: skip
"""A coupon that is pulled once: in closed form, so that its loop takes a minute."""

PROTOCOLS: Final[Mapping[str, Protocol]] = {
    plan.name: plan for plan in (SMALL, finger.PROTOCOLS["reference"], PULL)
}
FINGERS: Final = ("small", "reference")
COUPONS: Final = ("pull",)
COUNTS: Final[Mapping[str, int]] = {"small": 32, "reference": 8, "pull": 12}


def bench(protocol: str, scratch: Path, workers: int = 1) -> said.Bench[Case[Truth]]:
    """Return what draws and measures the cases of a protocol.

    Args:
        protocol: its name.
        scratch: folder of measurements and simulations.
        workers: processes.
    """
    simulating = fingers.Bench(PROTOCOLS[protocol], scratch, workers)
    return said.Bench(
        partial(_drawn, simulating), partial(fingers.diagnosed, simulating),
        measured=partial(fingers.measured, simulating),
        frozen=partial(fingers.frozen, simulating),
    )  # fmt: skip


def _drawn(bench: fingers.Bench, which: str, kind: str, number: int) -> Case[Truth]:
    seed = (SEED, list(PROTOCOLS).index(bench.protocol.name), number)
    return fingers.drawn_from(bench, seed, kind, number, SEEN)


def freeze(protocol: str, scratch: Path, only: int | None, workers: int, folder: Path) -> None:
    """Draw the cases of a protocol that are not there yet, and keep them as files.

    Args:
        protocol: its name.
        scratch: folder of measurements and simulations.
        only: the first so many; all where None.
        workers: processes.
        folder: of the files.
    """
    count = COUNTS[protocol] if only is None else min(only, COUNTS[protocol])
    said.freeze(bench(protocol, scratch, workers), "loop", {KIND: count}, folder)
