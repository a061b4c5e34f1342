"""How long the explorer takes, in Chromium, after a slider moves and after it is let go.

    scripts/run python -m benchmarks.explorer [FOLDER]
    scripts/run python -m benchmarks.explorer FOLDER --estimates

The default finger to 100 kPa; each design is one that no run before has seen, and the last one is
asked for while that before is solved on its own mesh. ``explorer.csv`` has seconds until the page
shows the design's own geometry, its solution on the coarse mesh and that as configured, with the
processor's seconds of server and worker, and the angles that both solutions tell. Solutions are
kept in the folder; the default is a temporary one.

With ``--estimates`` sixteen designs are solved on the coarse mesh, and ``explorer_estimates.csv``
has estimates of a design between 4 to 12 others, drawn at random: the angle at 100 kPa by its
solution and by the estimate, and the error that the explorer tells.
"""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI
from playwright.sync_api import Page, sync_playwright

from dolfingrip.experiments.loop import follow
from dolfingrip.explore import space
from dolfingrip.explore.library import Library
from dolfingrip.explore.wanted import read
from dolfingrip.report.page.pdf import chromium

DESIGNS = (("n-2", 1.9), ("n-2", 1.75), ("n-0", 0.2), ("n-0", 0.3), ("n-0", 0.4))
"""Number boxes (0: ξ₁, 2: wall in mm) and their values, one design after another."""

BUSY_S = 2.0
"""How long the last but one is solved on its own mesh before the last one takes its place."""

ESTIMATED = {"morph.xi1": (-0.2, 0.4), "morph.xi2": (-0.2, 0.3), "finger.wall_mm": (1.6, 2.2)}
"""Ranges from which designs of estimates are drawn."""

SOLVED, DRAWN = 16, 150
"""Numbers of these designs, and of draws."""

LONGEST_MS = 600_000
TABLE = Path(__file__).with_suffix(".csv")
MOVE = "(node, value) => { node.value = value; node.dispatchEvent(new Event('input')); }"


def processor_s(root: int) -> float:
    """Processor time of a process and of those below it, also of those that have ended."""
    parents: dict[int, int] = {}
    spent: dict[int, int] = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = file.read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
        except OSError:  # it has ended meanwhile
            continue
        pid = int(file.parent.name)
        parents[pid], spent[pid] = int(words[1]), sum(map(int, words[11:15]))
    tree, found = {root}, 0
    while len(tree) > found:
        found = len(tree)
        tree |= {pid for pid, parent in parents.items() if parent in tree}
    return sum(spent.get(pid, 0) for pid in tree) / os.sysconf("SC_CLK_TCK")


def angle_deg(page: Page) -> float:
    """Angle at the highest pressure that the page tells."""
    told = re.search(r"Tip angle.*?\s([\d.]+)°", page.inner_text("#numbers"), re.DOTALL)
    assert told
    return float(told[1])


def timed(page: Page, server: int, box: str, value: float, *, fine: bool = True) -> dict[str, Any]:
    """A row of the table; without the fine solution it is left while this is computed."""
    row: dict[str, Any] = {"design": f"{box}={value:g}"}
    asked = int(page.evaluate("document.documentElement.dataset.asked"))
    begun = time.perf_counter()
    page.locator(f"#{box}").evaluate(MOVE, value)
    page.wait_for_selector(f"html[data-shown='{asked + 1}']:not(.stale)", timeout=LONGEST_MS)
    row["geometry_s"] = round(time.perf_counter() - begun, 2)
    begun, spent = time.perf_counter(), processor_s(server)
    page.locator(f"#{box}").dispatch_event("change")
    for name, said in (
        ("coarse", "solved on a coarse mesh"),
        ("fine", "solved by finite elements"),
    )[: 1 + fine]:
        page.wait_for_selector(f"html[data-origin='{said}']", timeout=LONGEST_MS)
        row[f"{name}_s"] = round(time.perf_counter() - begun, 2)
        row[f"{name}_processor_s"] = round(processor_s(server) - spent, 2)
        row[f"{name}_deg"] = angle_deg(page)
    row["load"] = round(os.getloadavg()[0], 1)
    print(row, flush=True)
    if not fine:
        time.sleep(BUSY_S)
    return row


def main(folder: Path) -> None:
    """Measure, and write the table."""
    command = [
        sys.executable, "-m", "dolfingrip", "explore", "-o", str(folder), "--port", "0",
        "--set", "experiment.max_pressure_kPa=100",
    ]  # fmt: skip
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        address = server.stdout.readline().removeprefix("explorer: ").strip()
        with sync_playwright() as playwright:
            arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
            browser = playwright.chromium.launch(executable_path=chromium(), args=arguments)
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(address)
            page.wait_for_selector("html[data-ready]")
            time.sleep(10)  # a person reads, and the worker loads what it needs
            last = len(DESIGNS) - 2
            rows = [timed(page, server.pid, *d, fine=i != last) for i, d in enumerate(DESIGNS)]
            browser.close()
    finally:
        server.kill()
    written(TABLE, rows)


def estimates(folder: Path) -> None:
    """Solve designs, estimate each from others, and write the table."""
    designed = space.of_results([], None, {"experiment.max_pressure_kPa": 100}, [])
    random = np.random.default_rng(1)
    every, asked = Library(designed), []
    for number in range(SOLVED):
        inputs = {key: round(random.uniform(*ends), 3) for key, ends in ESTIMATED.items()}
        wanted = read(designed, {"view": "bending", "inputs": inputs})
        coarse, fields = wanted.coarse, folder / f"{number:02d}"
        assert coarse is not None
        if not (fields / "run.json").exists():
            follow(replace(coarse.request, fields=fields), MPI.COMM_SELF)
        every.add(fields)
        asked.append(wanted)
    solved, rows = every.solved["bending"], []
    for _ in range(DRAWN):
        order, count = random.permutation(SOLVED), int(random.integers(4, 13))
        library = Library(designed, {"bending": [solved[i] for i in order[:count]]})
        found, own = library.blend(asked[order[count]]), solved[order[count]]
        if found is None or (error := found.error("angle_deg")) is None:
            continue
        angles = {"solved": own.reading("angle_deg"), "estimate": found.reading("angle_deg")}
        last = {f"{name}_deg": round(float(each[-1]), 3) for name, each in angles.items()}
        rows.append({"of": len(found.of), **last, "told_deg": round(float(error[-1]), 3)})
    ratios = np.array([abs(r["estimate_deg"] - r["solved_deg"]) / r["told_deg"] for r in rows])
    within = ", ".join(f"{(ratios < n).mean():.0%} within {n}" for n in (1, 2))
    print(f"{len(rows)} estimates of {DRAWN}: {within} of the told error")
    written(TABLE.with_name("explorer_estimates.csv"), rows)


def written(file: Path, rows: list[dict[str, Any]]) -> None:
    """Write a table."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        chosen = [each for each in sys.argv[1:] if each != "--estimates"]
        run = estimates if "--estimates" in sys.argv else main
        run(Path(chosen[0]) if chosen else Path(made))
