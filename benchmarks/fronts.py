"""Error and front against the number of simulations, learnt from gradients and from values alone.

A front of the paper's finger is continued to :data:`MOST` simulations. What its process says of
held-out designs after each of them is compared with simulations of these. The same is done with
designs of ``paper_designs.csv``, spread as far apart as they go, that are not held out: by the same
process without gradients, and by the network of the paper. Hypervolumes are compared with that of
all 208 designs, joined by splines.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline
from scipy.stats import norm

from dolfingrip.charts.theme import BLUE, GREEN, INK, ORANGE, figure_theme
from dolfingrip.design.gradient.evaluation import DesignSimulations
from dolfingrip.design.gradient.front import FrontFinder
from dolfingrip.design.gradient.problem import Problem, Scaling
from dolfingrip.design.gradient.read import read
from dolfingrip.design.surrogate.process import GradientProcess
from dolfingrip.design.surrogate.table import Table
from dolfingrip.design.surrogate.training import train
from dolfingrip.experiments.simulate import computed_in
from dolfingrip.files import table
from dolfingrip.jobs.pool import Pool

Floats = NDArray[np.float64]

HERE = Path(__file__).parent
PICTURES = HERE.parent / "docs"
EXAMPLE = HERE.parent / "examples" / "paper_front.toml"
MOST, HELD_OUT, SEED = 20, 40, 33
COUNTS = (6, 8, 10, 12, 15, 20, 30, 40, 60, 100, 168)
"""Numbers of designs that are learnt from without gradients; the last one is all others."""

FEWEST = 20
"""Least number of designs that the network is trained on."""

NINETY = float(norm.ppf(0.95))
"""Half of a 90 % interval in deviations."""

NAMES = ("morph.xi1", "morph.xi2", "cog_offset_mm", "force_N")


class Reference:
    """The 208 designs.

    Attributes:
        table: shape (designs, 4), columns :data:`NAMES`.
        held, others: rows that are held out, and the others, spread as far apart as they go.
        places: shape (n, 2), a fine grid of ξ1 and ξ2.
        offset, force: shape (n,), of these, by splines.
        limits: shape (levels,), of the COG offset.
    """

    def __init__(self, scaling: Scaling) -> None:
        self.scaled, self.values = scaling.parts, scaling.values
        with (HERE / "paper_designs.csv").open(encoding="utf-8", newline="") as stream:
            given = [[float(row[name]) for name in NAMES] for row in csv.DictReader(stream)]
        self.table = np.array(given)
        order = np.random.default_rng(SEED).permutation(len(self.table))
        self.held = order[:HELD_OUT]
        self.others = self._spread(order[HELD_OUT:])
        first, second = np.unique(self.table[:, 0]), np.unique(self.table[:, 1])
        grid = self.table[np.lexsort((self.table[:, 1], self.table[:, 0]))]
        splines = [
            RectBivariateSpline(first, second, grid[:, column].reshape(len(first), len(second)))
            for column in (2, 3)
        ]
        axes = [np.linspace(each[0], each[-1], 120) for each in (first, second)]
        self.places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        self.offset, self.force = (each.ev(*self.places.T) for each in splines)
        self.limits = np.linspace(max(self.offset.min(), 0.0), 10.0, 40)

    def _spread(self, chosen: NDArray[np.int_]) -> NDArray[np.int_]:
        """Each next one is the furthest from those before."""
        at = self.scaled(self.table[chosen, :2])
        order = [int(np.abs(at - 0.5).max(axis=1).argmin())]
        apart = np.full(len(at), np.inf)
        while len(order) < len(at):
            apart = np.minimum(apart, np.linalg.norm(at - at[order[-1]], axis=1))
            apart[order] = -1.0
            order.append(int(apart.argmax()))
        return np.asarray(chosen[order])

    def front(self, force: Floats) -> NDArray[np.int_]:
        """Row of the best place for each limit."""
        within = self.offset[None] <= self.limits[:, None] + 1e-12
        return np.asarray(np.where(within, force[None], -np.inf).argmax(axis=1))

    def hypervolume_percent(self, force: Floats, scale: float = 1.0) -> float:
        """Error of the hypervolume of a front of these forces, in percent of the splines'."""
        expected = scale * self.force[self.front(self.force)]
        lowest = expected.min()
        got, exact = (
            float(np.trapezoid(np.maximum(each - lowest, 0), self.limits))
            for each in (force[self.front(force)], expected)
        )
        return 100 * (got / exact - 1)


def _row(way: str, count: int, off: Floats, deviation: Floats | None) -> dict[str, Any]:
    inside = None if deviation is None else float(np.mean(np.abs(off) <= NINETY * deviation))
    return {
        "learnt_from": way,
        "simulations": count,
        "rms_error_N": round(float(np.sqrt(np.mean(off**2))), 4),
        "largest_error_N": round(float(np.abs(off).max()), 4),
        "in_90_percent_interval": None if inside is None else round(inside, 3),
    }


def front(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each way and number of simulations; the table and the picture."""
    asked = read(EXAMPLE)
    assert asked.front is not None
    stops = FrontFinder(asked, asked.front, computed_in(out, pool)).run()
    unsure = asked.front.model_copy(update={"unsure": 1e-9})
    problem = replace(asked, method=asked.method.model_copy(update={"simulations": MOST}))
    longer = FrontFinder(problem, unsure, computed_in(out, pool)).run()
    reference = Reference(Scaling(problem.variables))
    found = _by_gradients(
        problem,
        np.array([list(each.inputs.values()) for each in longer.simulated]),
        reference,
        DesignSimulations(problem, computed_in(out, pool)),
    )
    for row in found:
        row["stops_here"] = row["simulations"] == stops.simulations
    found += _by_values(reference)
    table.write(HERE / "design_front.csv", found)
    _draw(found, PICTURES / "design_front_error.png")
    return found


def _by_gradients(
    problem: Problem, designs: Floats, reference: Reference, simulations: DesignSimulations
) -> list[dict[str, Any]]:
    def computed(values: Floats) -> tuple[Floats, Floats]:
        every = []
        for number, each in enumerate(values):
            simulated = simulations.at(each)
            if simulated.failure:
                raise SystemExit(simulated.failure)
            every.append(simulated.by_condition[0][problem.objective])
            print(f"{number + 1} of {len(values)}", flush=True)
        return np.array([one.value for one in every]), np.array([one.slopes for one in every])

    size = Scaling(problem.variables).size
    held = reference.table[reference.held]
    exact, _ = computed(held[:, :2])
    # the table is of an earlier state of the code: its forces are off by a common factor
    scale = float(np.median(exact / held[:, 3]))
    print(f"forces of today by those of the table: {scale:.5f}")
    values, slopes = computed(designs)
    found = []
    for count in range(4, len(designs) + 1):
        scaled = reference.scaled(designs[:count])
        process = GradientProcess(scaled, values[:count], slopes[:count] * size)
        mean, deviation = process.predict(reference.scaled(held[:, :2]))
        row = _row("values and gradients", count, mean - exact, deviation)
        force = process.predict(reference.scaled(reference.places))[0]
        row["hypervolume_percent"] = round(reference.hypervolume_percent(force, scale), 3)
        found.append(row)
        print(row, flush=True)
    return found


def _by_values(reference: Reference) -> list[dict[str, Any]]:
    held = reference.table[reference.held]

    def process(table: Floats) -> Callable[[Floats], tuple[Floats, Floats | None]]:
        return GradientProcess(reference.scaled(table[:, :2]), table[:, 3]).predict

    def network(table: Floats) -> Callable[[Floats], tuple[Floats, Floats | None]]:
        found = train(Table(NAMES[:2], NAMES[3:], table[:, :2], table[:, 3:])).surrogate
        return lambda scaled: (found.predict(reference.values(scaled), warn=False)[:, 0], None)

    found = []
    for way, learn in (("values", process), ("values, network", network)):
        for count in COUNTS:
            if learn is network and count < FEWEST:
                continue
            predict = learn(reference.table[reference.others[:count]])
            mean, deviation = predict(reference.scaled(held[:, :2]))
            row = _row(way, count, mean - held[:, 3], deviation)
            force = predict(reference.scaled(reference.places))[0]
            row["hypervolume_percent"] = round(reference.hypervolume_percent(force), 3)
            row["stops_here"] = False
            found.append(row)
            print(row, flush=True)
    return found


def _draw(found: list[dict[str, Any]], file: Path) -> None:
    looks = {
        "values and gradients": (BLUE, "o"),
        "values": (ORANGE, "s"),
        "values, network": (GREEN, "^"),
    }
    with figure_theme():
        figure = Figure(figsize=(12.5, 3.8), layout="constrained")
        FigureCanvasAgg(figure)
        error, area, inside = figure.subplots(1, 3)
        for way, (colour, marker) in looks.items():
            own = [row for row in found if row["learnt_from"] == way]
            at = [row["simulations"] for row in own]
            style = {"color": colour, "marker": marker, "ms": 4, "label": way}
            error.loglog(at, [row["rms_error_N"] for row in own], **style)
            area.loglog(at, [max(abs(row["hypervolume_percent"]), 1e-3) for row in own], **style)
            if own[0]["in_90_percent_interval"] is not None:
                inside.semilogx(at, [row["in_90_percent_interval"] for row in own], **style)
        stop = [row["simulations"] for row in found if row["stops_here"]]
        for axes in (error, area, inside):
            axes.set(xlabel="Simulations")
            for at in stop:
                axes.axvline(at, color=INK, lw=0.8, ls=":", label="dolfingrip stops")
            axes.set_xticks(
                [4, 6, 10, 20, 40, 100, 168], ["4", "6", "10", "20", "40", "100", "168"]
            )
            axes.minorticks_off()
        error.set(ylabel="Force of held-out designs, rms error (N)")
        area.set(ylabel="Hypervolume, error (%)")
        area.axhline(1.0, color=INK, lw=0.8, ls="--", label="goal")
        inside.axhline(0.9, color=INK, lw=0.8, ls="--", label="goal")
        inside.set(ylabel="Constraint-out designs in their 90 % interval", ylim=(0, 1.05))
        for axes in (error, area, inside):
            axes.legend(fontsize=7)
        figure.savefig(file)
