"""The objectives of the paper, from simulation: COG offset, blocked force, and the tip's angle.

As a program, ``python -m dolfingrip.design.campaign.objective request.json answer.json`` does the
same on all ranks of an mpirun; :func:`simulate` starts it where more than one rank is asked for.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from dolfingrip import config as configuration
from dolfingrip.channels import ANGLE, CONTACT_GAP, FORCE, PRESSURE
from dolfingrip.design.campaign.evaluate import Outcome
from dolfingrip.files import whole
from dolfingrip.jobs.job import JobFailure

if TYPE_CHECKING:
    from mpi4py import MPI

    from dolfingrip.experiments.result import Result

QUANTITIES: Final = ("cog_offset_mm", FORCE.name, ANGLE.name)
"""What can be computed: the undeformed centroid's offset, and the blocked force and the free
tip's angle at the highest pressure."""

EXPERIMENTS: Final = {FORCE.name: ("blocked_force", "blocked"), ANGLE.name: ("bending", "free")}
"""Experiment by the quantity that it yields, and what its columns of the curve begin with."""

MODULE: Final = "dolfingrip.design.campaign.objective"
"""This file, as a program."""

_OF_MPI: Final = ("OMPI_MCA_", "OMPI_COMM_", "PMIX_", "OPAL_", "PRTE_", "PMI_")


def simulate(
    config: dict[str, Any],
    quantities: tuple[str, ...],
    ranks: int,
    keys: Sequence[str] | None = None,
    fields: str | None = None,
) -> Outcome:
    """Compute a design in this process, or on several ranks under ``mpirun``.

    Args:
        config: resolved, as nested dictionaries.
        quantities: outputs that are wanted.
        ranks: MPI processes.
        keys: of parameters that the outputs are derived by, () for all; None for ξ1 and ξ2 where
            the adjoint gives them.
        fields: folder for a result of each experiment with its fields; None: none is written.

    Raises:
        JobFailure: where there is no result.
        ConfigError: where there is no such finger, or no such parameter of it.
    """
    if ranks > 1:
        return _on_ranks(config, quantities, ranks, keys, fields)
    from mpi4py import MPI

    return compute(config, quantities, MPI.COMM_SELF, keys, fields)


def compute(
    config: dict[str, Any],
    quantities: tuple[str, ...],
    comm: MPI.Comm,
    keys: Sequence[str] | None = None,
    fields: str | None = None,
) -> Outcome:
    """Compute a design on the ranks of ``comm``; for the rest see :func:`simulate`.

    Raises:
        JobFailure: on every rank, where the load path ended early.
        ConfigError: on every rank, where there is no such finger, or no such parameter of it.
    """
    from dolfingrip.design.campaign.derivatives import Derivatives
    from dolfingrip.experiments import run
    from dolfingrip.experiments.derivatives import gradients
    from dolfingrip.experiments.results import record
    from dolfingrip.mechanics.model.domain import on_root

    resolved = configuration.from_dict(config)
    asked = None if keys is None else Derivatives(resolved, keys)
    offset, slopes = comm.bcast(
        on_root(
            comm,
            lambda: gradients.cog_offset_mm(resolved) if asked is None else asked.of_cog_offset(),
        )
    )
    outcome = Outcome({"cog_offset_mm": offset}, iterations=0, versions=record.versions())
    outcome.curve = {}
    found = {"cog_offset_mm": slopes}
    for quantity, (name, prefix) in EXPERIMENTS.items():
        if quantity not in quantities:
            continue
        found[quantity] = {}
        result = run(
            name,
            resolved,
            out=None if fields is None else Path(fields) / name,
            comm=comm,
            visit=gradients.at_highest(found[quantity]),
            gradients=None if asked is None else asked.forward,
        )
        outcome.curve |= _curve(result, quantity, prefix)
        outcome.iterations = (outcome.iterations or 0) + result.facts.newton.iterations
        if result.failure is not None:
            raise JobFailure(
                str(result.failure.kind), result.failure.sentence(), {"curve": outcome.curve}
            )
        highest = max(result.rows, key=lambda row: row[PRESSURE.name])
        outcome.outputs[quantity] = highest[quantity]
        if asked is not None:
            row = result.rows.index(highest)
            found[quantity] = asked.of_reading(result, quantity, row, found[quantity])
    outcome.gradients = {name: found[name] for name in quantities if found[name]}
    return outcome


def _curve(result: Result, quantity: str, prefix: str) -> dict[str, list[float]]:
    """Readings at each pressure that was reached."""
    columns = {
        f"{prefix}_{PRESSURE.name}": PRESSURE.name,
        quantity: quantity,
        f"{prefix}_{CONTACT_GAP.name}": CONTACT_GAP.name,
    }
    return {name: list(map(float, result.column(source))) for name, source in columns.items()}


def _on_ranks(
    config: dict[str, Any],
    quantities: tuple[str, ...],
    ranks: int,
    keys: Sequence[str] | None,
    fields: str | None,
) -> Outcome:
    # the kernel ends mpirun with the worker, however that ends
    guard = ["setpriv", "--pdeathsig", "TERM"] if shutil.which("setpriv") else []
    environment = {k: v for k, v in os.environ.items() if not k.startswith(_OF_MPI)}
    kept = {k: v for k, v in os.environ.items() if "_MCA_" in k}
    with tempfile.TemporaryDirectory(prefix="dolfingrip-") as folder:
        request, answer = Path(folder) / "request.json", Path(folder) / "answer.json"
        whole.write(request, json.dumps([config, quantities, keys, fields]))
        program = [
            sys.executable,
            "-P",
            "-m",
            MODULE,
            request,
            answer,
        ]
        ended = subprocess.run(
            [*guard, "mpirun", "--oversubscribe", "-n", str(ranks), *map(str, program)],
            env={**environment, **kept, "OMP_NUM_THREADS": "1"},
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            check=False,
        )  # fmt: skip
        if not answer.exists():
            said = [line for line in ended.stderr.splitlines() if line.strip()]
            last = said[-1] if said else "nothing said"
            raise JobFailure("crash", f"mpirun ended with {ended.returncode}: {last}")
        kind, content = json.loads(answer.read_text(encoding="utf-8"))
    if kind == "outcome":
        return Outcome(**content)
    if kind == "refused":
        raise configuration.ConfigError(content)
    if kind == "unwritten":
        raise whole.WriteError(*content)
    raise JobFailure(*content)


def main(request: Path, answer: Path) -> None:
    """Compute on all ranks; rank 0 writes what came out."""
    _end_with_parent()
    from mpi4py import MPI

    config, quantities, keys, fields = json.loads(request.read_text(encoding="utf-8"))
    content: tuple[str, Any]
    try:  # what is caught here is raised on all ranks
        found = compute(config, tuple(quantities), MPI.COMM_WORLD, keys, fields)
        content = ("outcome", asdict(found))
    except configuration.ConfigError as error:
        content = ("refused", str(error))
    except whole.WriteError as error:
        content = ("unwritten", [error.errno, error.strerror, error.filename])
    except JobFailure as failure:
        content = ("failure", [failure.kind, failure.sentence, failure.partial])
    except Exception:
        traceback.print_exc()
        MPI.COMM_WORLD.Abort(70)  # the other ranks would wait for this one for ever
    if MPI.COMM_WORLD.rank == 0:
        whole.write(answer, json.dumps(content))


def _end_with_parent() -> None:
    """Have Linux kill this rank once mpirun is gone, which a killed mpirun itself cannot."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(1, int(signal.SIGKILL), 0, 0, 0)  # PR_SET_PDEATHSIG


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
