"""The text of ``results.md`` around its table."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan

from benchmarks.convergence import QUANTITIES, limits, points
from benchmarks.outcomes import Outcome
from benchmarks.parts import (
    CALCULIX_SHORT,
    COOK_NU,
    FINEST,
    FINGER_NU,
    PARTS,
    REFERENCE_NODES,
    UNGRADED_MM,
)
from benchmarks.plots import growth_points

Found = dict[str, Outcome]

TABLED = ("convergence", "growth", "incompressible")
"""Parts with a separate table."""


def preamble(found: Found, speed: float) -> str:
    """The explanation of the table."""
    machine = "CalculiX was not run, so the goals in seconds are taken as they are."
    if "machine" in found and not isnan(found["machine"].median("calculix", "run_s")):
        seconds = found["machine"].median("calculix", "run_s")
        machine = (
            "The goals in seconds are for a machine on which CalculiX 2.20 takes 19.5 s to bend "
            f"the quadratic half finger of {REFERENCE_NODES:,} nodes to 100 kPa; here it took "
            f"{seconds:.1f} s, so they are multiplied by {speed:.2f}."
        )
    return (
        "Written by `scripts/benchmark` from `out/benchmark`; medians of repeated runs, one "
        "at a time, each a separate process on one core with one thread, its forms compiled "
        "before. Seconds are of the whole run (mesh, setup, load path), Python's start-up left "
        f"out; where they exceed the processor time by far, the machine was busy. {machine}"
    )


def all_sections(found: Found, pictures: str) -> Iterator[str]:
    """The details, line by line."""
    yield from _runs(found)
    yield from _convergence(found, pictures)
    yield from _growth(found, pictures)
    yield from _incompressible(found)
    yield from _circumstances(found)


def _number(value: float, form: str = ".1f") -> str:
    return "" if isnan(value) else format(value, form)


def _runs(found: Found) -> Iterator[str]:
    yield "## Runs"
    yield ""
    yield "| part | run | dofs | mesh s | setup s | solve s | processor s | iterations | GB | n |"
    yield "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|"
    for part, outcome in found.items():
        if part in TABLED:
            continue
        for label, runs in outcome.runs.items():

            def of(key: str, outcome: Outcome = outcome, label: str = label) -> float:
                return outcome.median(label, key)

            solve = of("run_s") if isnan(of("solve_s")) else of("solve_s")
            cells = [
                part, label, _number(of("dofs"), ",.0f"), _number(of("mesh_s")),
                _number(of("setup_s")), _number(solve), _number(of("processor_s")),
                _number(of("iterations"), ".0f"), _number(of("peak_MB") / 1000, ".2f"),
                str(len(runs)),
            ]  # fmt: skip
            yield "| " + " | ".join(cells) + " |"
    yield ""
    for part in (name for name in found if name not in TABLED):
        yield f"- **{part}**: {PARTS[part].title}"
    yield ""
    yield (
        "FElupe has no step control: its steps are equal, as few as it converges with, and "
        "SuperLU orders by minimum degree on Aᵀ + A, which is faster here than its default. The "
        "ratio is of solving alone."
    )
    yield ""
    yield from _calculix(found)


def _calculix(found: Found) -> Iterator[str]:
    """Say what the ratio to CalculiX counts, and how its tip is compared."""
    machine = found.get("machine", Outcome("machine"))
    whole = machine.median("calculix", "process_s") / machine.median("dolfingrip", "process_s")
    yield (
        "CalculiX bends with its own increments and tolerances. It is handed the mesh, so the "
        "ratio in the table leaves out dolfingrip's meshing and the start-up of Python. "
        + ("" if isnan(whole) else f"Of whole processes, both counted, the ratio is {whole:.1f}. ")
        + "An independent check on a busy machine found 5.0 for whole processes and 6.0 without "
        "start-up."
    )
    yield ""
    yield (
        "CalculiX' tip depends on its tolerance: `calculix close` has its residuals held to 1e-4 "
        "instead of 5e-3, the loosest tried whose tip is within 0.5 %, `calculix tight` to 1e-5. "
        "The same check found that CalculiX ends an increment while the angle is still up to "
        "0.13 % off, whatever residual is asked for. `calculix short` therefore bends in "
        f"increments of at most {100 * CALCULIX_SHORT:g} kPa, to separate that error from a "
        "difference of the models"
        + ("." if "calculix short" in machine.runs else "; it has not been run yet.")
    )
    yield ""


def _convergence(found: Found, pictures: str) -> Iterator[str]:
    if "convergence" not in found:
        return
    best = limits(found["convergence"])
    yield "## Convergence"
    yield ""
    for kind, quantity in QUANTITIES.items():
        measured = points(found["convergence"], kind)
        if not measured:
            continue
        value = f"{quantity.name} ({quantity.unit})"
        yield f"| mesh | elements | dofs | {value} | error | processor s |"
        yield "|---|--:|--:|--:|--:|--:|"
        for p in measured:
            error = f"{p.value / best[kind].value - 1:+.2%}" if kind in best else ""
            yield (
                f"| {p.mesh} | {p.elements:,} | {p.dofs:,} | {p.value:.4f} | {error} "
                f"| {p.seconds:.1f} |"
            )
        yield ""
        if kind in best:
            limit = best[kind]
            order = "no order is seen" if isnan(limit.order) else f"order {limit.order:.2f}"
            yield (
                f"The {quantity.name} tends to {limit.value:.4g} ± {limit.uncertainty:.2g} "
                f"{quantity.unit} ({order} in (elements)^(−1/3), from the refinements of the "
                "default mesh; sharp concave edges keep it below that of smooth solutions)."
            )
            yield ""
    yield (
        "P1, P2 and P2-P1 are tetrahedra of that size (mm), S2 hexahedra, divided so often along "
        "each axis. A second number is the size at concave edges (mm); S2 has an eighth of the "
        f"wall there by default, and none smaller than elsewhere with {UNGRADED_MM:g}."
    )
    yield ""
    yield f"![error against time]({pictures}/error_time.png)"
    yield ""


def _growth(found: Found, pictures: str) -> Iterator[str]:
    if "growth" not in found:
        return
    yield "## Growth with dofs"
    yield ""
    yield "| element | dofs | processor s | GB |"
    yield "|---|--:|--:|--:|"
    for element in ("S2", "P2", "P1"):
        for dofs, seconds, peak in growth_points(found["growth"], element):
            yield f"| {element} | {dofs:,.0f} | {seconds:.1f} | {peak / 1000:.2f} |"
    yield ""
    yield f"![time against dofs]({pictures}/time_dofs.png)"
    yield ""


def _incompressible(found: Found) -> Iterator[str]:
    if "incompressible" not in found:
        return
    outcome = found["incompressible"]
    best = {
        "cook": outcome.last(f"cook P2-P1 {FINEST['cook']}").get("rise_mm"),
        "finger": _angle(outcome, f"finger P2-P1 {FINEST['finger']:g}"),
    }
    yield "## Near-incompressible"
    yield ""
    yield (
        f"Cook's membrane at finite strain, ν = {COOK_NU} (`tests/support/cook.py`; literature: "
        f"the corner rises by 6.9 mm), and the free finger at 25 kPa, ν = {FINGER_NU}. Errors are "
        "against the mixed element's finest mesh, the last line of each."
    )
    yield ""
    yield "| problem | element | mesh | dofs | value | error | iterations | solve s |"
    yield "|---|---|--:|--:|--:|--:|--:|--:|"
    for label in PARTS["incompressible"].specs:
        problem, element, size = label.split()
        run = outcome.last(label)
        mesh = f"{size} × {size}" if problem == "cook" else f"{size} mm"
        value = run.get("rise_mm") if problem == "cook" else _angle(outcome, label)
        if value is None:
            yield f"| {problem} | {element} | {mesh} | | load not reached | | | |"
            continue
        unit = "mm" if problem == "cook" else "°"
        against = best[problem]
        error = "" if against is None else f"{value / against - 1:+.1%}"
        yield (
            f"| {problem} | {element} | {mesh} | {run['dofs']:,} | {value:.3f} {unit} | {error} "
            f"| {run['iterations']} | {run['solve_s']:.1f} |"
        )
    yield ""


def _angle(outcome: Outcome, label: str) -> float | None:
    """Last angle of a finger's run (°), None where it has not been made."""
    rows = outcome.last(label).get("rows")
    return rows[-1]["angle_deg"] if rows else None


def _circumstances(found: Found) -> Iterator[str]:
    yield "## Circumstances"
    yield ""
    yield "| part | date | commit | load average at start |"
    yield "|---|---|---|---|"
    for part, outcome in found.items():
        low, high = outcome.load()
        facts = outcome.facts
        yield f"| {part} | {facts['date']} | {facts['commit']} | {low:.1f}–{high:.1f} |"
    yield ""
    for processor in dict.fromkeys(outcome.facts["processor"] for outcome in found.values()):
        yield f"Machine: {processor}."
    newest = max(found.values(), key=lambda outcome: outcome.facts["date"], default=None)
    if newest is not None:
        versions = newest.facts.get("versions", {})
        said = ", ".join(f"{name} {version}" for name, version in versions.items())
        yield f"Versions: {said}; CalculiX as `ccx -v` says, 2.20 in Debian 12."
    yield ""
    yield "`+` after a commit: files of the solver had changed since."
