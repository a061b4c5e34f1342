"""How much memory this machine has left and this process takes; too large a model is refused."""

from __future__ import annotations

from pathlib import Path

from mpi4py import MPI

from dolfingrip.sections.errors import ConfigError

MB = 1e6


def refuse_too_large(
    unknowns: int,
    needed_MB: float,
    allowed_GB: float | None,
    comm: MPI.Comm,
    how: str,
    also: str = "",
) -> float:
    """Raise an error if a model will not fit, before its solver takes the memory.

    Args:
        unknowns: number of unknowns.
        needed_MB: by the solver on all ranks, beyond what the processes have now.
        allowed_GB: by the configuration; None: what is free.
        comm: ranks, on one machine.
        how: name of the solver, for the error.
        also: what else is allowed, for the error.

    Returns:
        The forecast of the largest memory on all ranks (MB).

    Raises:
        ConfigError: on every rank, one line.
    """
    now_MB = comm.allreduce(_resident_MB(), MPI.SUM)
    forecast = now_MB + needed_MB
    allowed = now_MB + free_MB() if allowed_GB is None else 1e3 * allowed_GB
    allowed = comm.bcast(allowed)
    if forecast > allowed:
        key = "what is free" if allowed_GB is None else "solver.memory_GB"
        raise ConfigError(
            f"mesh: {unknowns:,} unknowns take about {forecast / 1e3:.2g} GB with the {how} solver;"
            f" allowed: up to {allowed / 1e3:.2g} GB ({key}){also}"
        )
    return float(forecast)


def free_MB() -> float:
    """Memory that new work may take (10⁶ bytes): of the machine, or of this process' group."""
    available_MB = [float("inf")]
    available_MB += _entry_MB("/proc/meminfo", "MemAvailable")
    limit, used = (_read(f"/sys/fs/cgroup/memory.{name}").strip() for name in ("max", "current"))
    if limit.isdigit() and used.isdigit():
        available_MB.append((int(limit) - int(used)) / MB)
    return min(available_MB)


def peak_MB() -> float:
    """Largest memory of this process so far (10⁶ bytes).

    ``getrusage`` has that of the process which started this one, where that was larger.
    """
    return sum(_entry_MB("/proc/self/status", "VmHWM"))


def _entry_MB(path: str, name: str) -> list[float]:
    """The entry of this name in a file of the kernel, which tells KiB; none if there is none."""
    lines = [line.split() for line in _read(path).splitlines() if line.startswith(f"{name}:")]
    return [float(words[1]) * 1024 / MB for words in lines]


def _resident_MB() -> float:
    return sum(_entry_MB("/proc/self/status", "VmRSS"))


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="ascii", errors="ignore")
    except OSError:
        return ""
