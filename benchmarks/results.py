"""Writes ``results.md`` from the outcomes that there are."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot, isnan
from pathlib import Path

from benchmarks import sections
from benchmarks.convergence import DEFAULT, limits, points
from benchmarks.orders import exponent
from benchmarks.outcomes import Outcome
from benchmarks.parts import PARTS, RANKS
from benchmarks.plots import growth_points

MACHINE_S = 19.5
"""Time in which CalculiX 2.20 bends the quadratic half finger of the part ``machine`` to 100 kPa on
the machine that the goals in seconds are for."""

Found = dict[str, Outcome]


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the table.

    Attributes:
        what: is measured.
        goal: as it is set.
        measured: in words.
        met: None where it was not measured.
    """

    what: str
    goal: str
    measured: str
    met: bool | None

    def __str__(self) -> str:
        verdict = {True: "yes", False: "**no**", None: "–"}[self.met]
        return f"| {self.what} | {self.goal} | {self.measured} | {verdict} |"


def speed(found: Found) -> float:
    """How many times slower than the goals' machine this one is; 1 where it is not known."""
    factor = found["machine"].median("calculix", "run_s") / MACHINE_S if "machine" in found else 1.0
    return 1.0 if isnan(factor) else factor


def apart(outcome: Outcome, peer: str) -> float:
    """Distance of the two tips over the tip's displacement."""
    ours, other = outcome.last("dolfingrip"), outcome.last(peer)
    if not ours or not other:
        return float("nan")
    tip = ours["rows"][-1]
    x, z = tip["tip_x_mm"], tip["tip_z_mm"]
    return hypot(x - other["tip_x_mm"], z - other["tip_z_mm"]) / hypot(x, z)


def lines(found: Found) -> Iterator[Line]:
    """All lines of the table, measured or not."""
    yield _seconds(found, "blocked", 12, iterations=45)
    yield _seconds(found, "paper", 12)
    yield _seconds(found, "linear", 7)
    yield _ratio(found, "machine", "calculix", 6, 5e-3, "0.5 %", "run_s")
    yield _to_the_end(found)
    for part in ("felupe", "felupe-paper"):
        yield _ratio(found, part, "felupe", 5, 1e-6, "1e-6", "solve_s")
    yield from _errors(found)
    yield from _growth(found)
    yield from _ranks(found)
    yield _memory(found)


def _seconds(found: Found, part: str, goal: float, iterations: int | None = None) -> Line:
    limit = goal * speed(found)
    words = [f"≤ {iterations} iterations"] if iterations else []
    words.append(f"≤ {goal} s (here {limit:.1f} s)")
    if part not in found:
        return Line(PARTS[part].title, ", ".join(words), "not run", None)
    outcome = found[part]
    seconds, count = (outcome.median("dolfingrip", key) for key in ("run_s", "iterations"))
    met = seconds <= limit and (iterations is None or count <= iterations)
    factorised = outcome.median("dolfingrip", "factorisations")
    used, mesh = (outcome.median("dolfingrip", key) for key in ("processor_s", "mesh_s"))
    said = (
        f"{seconds:.1f} s ({used:.1f} s of processor; {mesh:.1f} s for the mesh), "
        f"{count:.0f} iterations, {factorised:.0f} factorisations"
    )
    return Line(PARTS[part].title, ", ".join(words), said, met)


def _ratio(
    found: Found, part: str, peer: str, goal: float, close: float, words: str, key: str
) -> Line:
    """Seconds of ``key``; those of the mesh, which a peer is handed, do not count."""
    wanted = f"≥ {goal:g} times faster, tip within {words}"
    outcome = found.get(part, Outcome(part))
    mesh = outcome.median("dolfingrip", "mesh_s") if key == "run_s" else 0.0
    ours, theirs = outcome.median("dolfingrip", key) - mesh, outcome.median(peer, key)
    if isnan(ours) or isnan(theirs):
        return Line(PARTS[part].title, wanted, "not run", None)
    distance = apart(outcome, peer)
    tips = f"tip {distance:.1e} apart"
    if not isnan(tight := apart(outcome, f"{peer} tight")):
        tips += f", {tight:.1e} with the peer's tolerance tight"
        distance = tight  # nearer to what the models differ by
    if not isnan(short := apart(outcome, f"{peer} short")):
        tips += f", {short:.1e} with its increments short, too"
        distance = short  # what is left is the difference of the models
    if not isnan(other := outcome.median(f"{peer} close", key)):
        tips += (
            f"; {other / ours:.1f} times (to {other:.1f} s) with that by which its tip is within "
            f"{words} ({apart(outcome, f'{peer} close'):.1e})"
        )
    used = [outcome.median(label, "processor_s") for label in (peer, "dolfingrip")]
    said = (
        f"{theirs / ours:.1f} times ({ours:.1f} s{', the mesh given,' if mesh else ''} to "
        f"{theirs:.1f} s; by processor time {used[0] / (used[1] - mesh):.1f} times), {tips}"
    )
    return Line(PARTS[part].title, wanted, said, theirs / ours >= goal and distance <= close)


def _to_the_end(found: Found) -> Line:
    """CalculiX gives up before 250 kPa where it cannot follow; then it has no ratio."""
    outcome = found.get("calculix", Outcome("calculix"))
    ours, theirs = outcome.last("dolfingrip"), outcome.last("calculix")
    if not ours or not theirs:
        return Line(PARTS["calculix"].title, "≥ 6 times faster, tip within 0.5 %", "not run", None)
    if theirs["pressure_kPa"] > 249.9:
        return _ratio(found, "calculix", "calculix", 6, 5e-3, "0.5 %", "run_s")
    seconds = outcome.median("dolfingrip", "run_s")
    said = (
        f"CalculiX gives up at {theirs['pressure_kPa']:.0f} kPa after {theirs['run_s']:.0f} s; "
        f"dolfingrip is at 250 kPa in {seconds:.1f} s, {theirs['run_s'] / seconds:.1f} times sooner"
    )
    return Line(PARTS["calculix"].title, "≥ 6 times faster, tip within 0.5 %", said, None)


def _errors(found: Found) -> Iterator[Line]:
    goal = "≤ 1 % of the extrapolated value"
    best = limits(found["convergence"]) if "convergence" in found else {}
    for kind, name in (("bending", "angle"), ("blocked_force", "force")):
        what = f"error of the {name} at 250 kPa, default mesh"
        default = [
            p for p in (points(found["convergence"], kind) if best else []) if p.mesh == DEFAULT
        ]
        if kind not in best or not default:
            yield Line(what, goal, "not run", None)
            continue
        limit = best[kind]
        error = abs(default[0].value / limit.value - 1)
        spread = limit.uncertainty / abs(limit.value)
        yield Line(what, goal, f"{error:.2%} ± {spread:.2%}", error <= 0.01)


def _growth(found: Found) -> Iterator[Line]:
    for element in ("S2", "P2", "P1"):
        what = f"growth of time with dofs, {element}"
        measured = growth_points(found["growth"], element) if "growth" in found else []
        if len(measured) < 3:
            yield Line(what, "exponent ≤ 1.35", "not run", None)
            continue
        dofs, seconds, _ = zip(*measured, strict=True)
        slope = exponent(dofs, seconds)
        said = f"{slope:.2f} ({dofs[0]:,.0f} to {dofs[-1]:,.0f} dofs)"
        yield Line(what, "exponent ≤ 1.35", said, slope <= 1.35)


def _ranks(found: Found) -> Iterator[Line]:
    outcome = found.get("ranks", Outcome("ranks"))
    for mesh in RANKS:
        one, two = (outcome.median(f"{mesh}, {ranks}", "solve_s") for ranks in (1, 2))
        dofs = outcome.median(f"{mesh}, 1", "dofs")
        what = f"mpirun -n 2 against one rank, {mesh}"
        if isnan(one) or isnan(two):
            yield Line(what, "≥ 1.5 times", "not run", None)
            continue
        said = f"{one / two:.2f} times ({one:.1f} s to {two:.1f} s, {dofs:,.0f} dofs)"
        yield Line(what, "≥ 1.5 times", said, one / two >= 1.5)


def _memory(found: Found) -> Line:
    peak = found.get("blocked", Outcome("blocked")).median("dolfingrip", "peak_MB") / 1000
    what = "peak memory, default run (blocked force)"
    if isnan(peak):
        return Line(what, "≤ 1.2 GB", "not run", None)
    return Line(what, "≤ 1.2 GB", f"{peak:.2f} GB", peak <= 1.2)


def write(found: Found, path: Path, pictures: Path) -> None:
    """Write the page.

    Args:
        found: outcomes by part.
        path: of the page.
        pictures: folder of its pictures.
    """
    table = [
        "| what | goal | measured | met |",
        "|---|---|---|---|",
        *(str(line) for line in lines(found)),
    ]
    text = ["# Benchmarks", "", sections.preamble(found, speed(found)), "", *table, ""]
    text += sections.all_sections(found, os.path.relpath(pictures, path.parent))
    path.write_text("\n".join(text).rstrip() + "\n", encoding="utf-8")
