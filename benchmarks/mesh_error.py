"""What a diagnosis makes of a finger whose mesh is off: which readings say what, and a wider error.

    dolfingrip diagnose out/mesh/measured.csv --out out/mesh/diagnosis
    scripts/run python -m benchmarks.mesh_error out/mesh/measured.csv --out out/mesh/diagnosis

Prints the parameters of the leading effect (one standard deviation) from all readings and from each
experiment alone, and by how much the best second effects raise ln evidence: with the mesh's error
as it is taken (0.3 x (graded - ungraded)), ten times as large, and with one of its own for each
column of each experiment. The simulations are those of the diagnosis before.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.conclude import NONE, conclude, screen
from dolfingrip.diagnosis.diagnose import Settings, diagnose
from dolfingrip.diagnosis.found import Diagnosis
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.laplace import to_value
from dolfingrip.diagnosis.problem import Problem

SECONDS = 3
"""Second effects that are shown."""


def with_mesh(problem: Problem, mesh: np.ndarray) -> Problem:
    """The same readings with another error of the mesh, shape (all readings, columns)."""
    return replace(problem, base=replace(problem.base, mesh=mesh))


def by_column(problem: Problem) -> np.ndarray:
    """An error of the mesh of its own for each column of each experiment."""
    mesh = problem.base.mesh[:, 0]
    channel = np.full(len(mesh), "", dtype=object)
    channel[problem.kept] = problem.channel
    return np.column_stack([np.where(channel == c, mesh, 0.0) for c in sorted(set(channel))])


def estimated(problem: Problem, fit: Hypothesis, kept: np.ndarray) -> str:
    """Parameters from some of the readings, along the tangent at the fit."""
    columns = np.hstack([fit.jacobian, problem.nuisances])
    noise = problem.error_covariance.matrix[np.ix_(kept, kept)]
    residual = fit.residual(problem.value)
    white = Covariance.of(noise).whiten(np.column_stack([residual[kept], columns[kept]]))
    information = np.eye(columns.shape[1]) + white[:, 1:].T @ white[:, 1:]
    zeta = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])
    std = np.sqrt(np.diag(np.linalg.inv(information)))
    told = []
    for parameter, z, s in zip(fit.parameters, zeta, std, strict=False):
        value = to_value(parameter.prior, float(z))
        wide = to_value(parameter.prior, float(z + s)) - value
        told.append(f"{parameter.key.rpartition('.')[2]} = {value:.4g} ± {wide:.2g}")
    return ", ".join(told)


def seconds(problem: Problem, found: Diagnosis, lead: frozenset[str]) -> str:
    """The best effects beside the leading one, and what they add to its ln evidence."""
    fits = {key: fit for key, fit in found.fits.items() if len(key) < 2}
    analysis = screen(problem, fits[NONE])
    told = conclude(problem, analysis, fits)
    names = [each.name for each in analysis.screen.candidates]
    alone = fits[lead].log_evidence(problem) - fits[NONE].log_evidence(problem)
    gains = {
        next(iter({names[i] for i in pair} - lead)): float(log) - alone
        for pair, log in zip(told.pairs.members, told.pairs.log_evidence, strict=True)
        if lead & {names[i] for i in pair}
    }
    best = sorted(gains, key=lambda name: -gains[name])[:SECONDS]
    verdict = told.verdict(analysis.thresholds)
    return f"{', '.join(f'{name} {gains[name]:+.1f}' for name in best)}; {verdict.sentence()}"


def main() -> None:
    """Diagnose from what is at hand, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="of the diagnosis before")
    options = parser.parse_args()
    found = diagnose([options.data], Config(), options.out, Settings(workers=1))
    problem = found.problem
    lead = frozenset(found.verdict.named[0].names[:1])
    fit = found.fits[lead]
    experiment = problem.index["experiment"].to_numpy()
    print("all readings:", estimated(problem, fit, np.ones(len(experiment), dtype=bool)))
    for name in dict.fromkeys(experiment):
        print(f"{name} alone:", estimated(problem, fit, experiment == name))
    mesh = problem.base.mesh
    for text, other in (
        ("as taken", mesh), ("ten times as large", 10 * mesh), ("by column", by_column(problem)),
    ):  # fmt: skip
        own = with_mesh(problem, other)
        told = estimated(own, fit, np.ones(len(experiment), dtype=bool))
        print(f"mesh's error {text}: {told}; beside it {seconds(own, found, lead)}", flush=True)


if __name__ == "__main__":
    main()
