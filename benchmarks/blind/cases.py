"""What is hidden in each case, and the files that a laboratory would hand over.

60 % of the cases hide one effect, 15 % none, 15 % a cause outside the catalogue, 10 % two effects.
A case is its number and a seed: the plan is the same whenever it is made.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import tomlkit

from benchmarks.blind import noise
from benchmarks.blind.generator import Cause, causes
from benchmarks.blind.noise import Instruments
from benchmarks.blind.outsiders import OUTSIDERS, possible
from benchmarks.blind.protocols import PROTOCOLS, Protocol
from benchmarks.blind.response import NUISANCES, Hidden, Truth
from dolfingrip.diagnosis.data.columns import MEASURED, READING_COLUMNS
from dolfingrip.diagnosis.inference.noise import noise_matrix

Kind = Literal["one", "none", "outsider", "two"]
SETS: Final = (
    "development", "final", "confirmation", "second-confirmation", "third-confirmation"
)  # fmt: skip
"""The first is for finding what to mend. The others are only ever scored; each of the last three
was drawn when the one before it had been looked at."""
SEED: Final = 20_261
NUMBER: Final = 120
"""Cases of a set."""
SHARES: Final[Mapping[Kind, float]] = {"one": 0.6, "none": 0.15, "outsider": 0.15, "two": 0.1}
OFTEN: Final[Mapping[str, float]] = {"P1": 0.2, "P2": 0.2, "P3": 0.15, "P4": 0.15, "P7+": 0.3}
"""How often each protocol is followed."""
EVERY_FULL: Final = 5
"""Each fifth case has a simulation of its own."""
KINKED: Final = ("plate_tilt",)
"""Causes whose change no quadratic through the library's strengths follows: cases that hide one
have a simulation of their own. A tilted plate is touched by the tip's end or by the other end of
what faces it, one after the other where the finger turns by more than the tilt."""
OFTEN_FULL: Final[Mapping[str, float]] = {"P1": 0.5, "P2": 0.35, "P7+": 0.15}
WIDEST: Final = 2.0
"""Standard deviations at which nuisances are cut off."""


@dataclass(frozen=True, slots=True)
class Case:
    """A case.

    Attributes:
        set_name, number: which it is.
        protocol: that is followed.
        kind: how many causes there are, and of what sort.
        full: whether it has a simulation of its own.
        truth: what is hidden.
        seed: of noise and missing readings.
        instruments: how they scatter, and what the laboratory tells.
    """

    set_name: str
    number: int
    protocol: str
    kind: Kind
    full: bool
    truth: Truth
    seed: tuple[int, ...]
    instruments: Instruments = field(default_factory=Instruments)

    @property
    def name(self) -> str:
        """Name of its folder."""
        return f"{self.set_name}-{self.number:03d}-{self.protocol}"

    @property
    def hidden(self) -> tuple[str, ...]:
        """Names of the causes."""
        return tuple(each.name for each in self.truth.causes)


def plan(
    set_name: str,
    number: int = NUMBER,
    often: Mapping[str, float] = OFTEN,
    seed: int = SEED,
    full: Mapping[str, float] = OFTEN_FULL,
) -> list[Case]:
    """The cases of a set.

    Args:
        set_name: of :data:`SETS`.
        number: of cases.
        often: how often each protocol is followed.
        seed: of everything that is drawn.
        full: how often each protocol is followed with a simulation of its own; never if empty.
    """
    start = (seed, SETS.index(set_name))
    known = causes()
    return [
        _case(set_name, i, kind,
              _picked(full if full and not i % EVERY_FULL else often, (*start, i)),
              bool(full) and not i % EVERY_FULL, (*start, i), known)
        for i, kind in enumerate(_kinds(number, np.random.default_rng(start)))
    ]  # fmt: skip


def _kinds(number: int, rng: np.random.Generator) -> list[Kind]:
    """Kinds in random order; the number of each follows from its share."""
    found: list[Kind] = []
    total = 0.0
    for kind, share in SHARES.items():
        total += share
        found += [kind] * (round(total * number) - len(found))
    return [found[i] for i in rng.permutation(len(found))]


def _picked(often: Mapping[str, float], seed: Sequence[int]) -> str:
    weights = np.array(list(often.values()))
    rng = np.random.default_rng([*seed, 0])
    return str(rng.choice(list(often), p=weights / weights.sum()))


def _case(
    set_name: str, number: int, kind: Kind, protocol: str, full: bool, seed: tuple[int, ...],
    known: Mapping[str, Cause],
) -> Case:  # fmt: skip
    rng = np.random.default_rng([*seed, 1])
    hidden: list[Hidden] = []
    if kind == "outsider":
        names = [name for name in OUTSIDERS if possible(PROTOCOLS[protocol], name)]
        name = str(rng.choice(names))
        hidden = [Hidden(name, 0, OUTSIDERS[name].draw(rng))]
    elif kind != "none":
        felt = [name for name in known if is_felt(known[name], PROTOCOLS[protocol])]
        for name in rng.choice(felt, 2 if kind == "two" else 1, replace=False):
            form, strength = known[str(name)].draw(rng)
            hidden.append(Hidden(str(name), form, strength))
    return Case(
        set_name,
        number,
        protocol,
        kind,
        full or any(each.name in KINKED for each in hidden),
        Truth(tuple(hidden), drawn_nuisances(rng, PROTOCOLS[protocol])),
        (*seed, 2),
    )


def is_felt(cause: Cause, protocol: Protocol) -> bool:
    """Whether a protocol has an experiment that a cause can be felt in; a coupon has few."""
    fingers = any(course.experiment != "coupon" for course in protocol.courses)
    return fingers or cause.effect.has("strain_energy") or cause.name.startswith("force_")


def drawn_nuisances(rng: np.random.Generator, protocol: Protocol) -> dict[str, float]:
    """Each nuisance by its usual standard deviation, cut off."""
    found = {}
    for name in NUISANCES:
        value = rng.standard_normal()
        while abs(value) > WIDEST:
            value = rng.standard_normal()
        found[name] = float(value) * protocol.known_better.get(name, 1.0)
    return found


@dataclass(frozen=True, slots=True)
class Readings:
    """What a case's instruments read.

    Attributes:
        true: (n,) without noise.
        noise: (n,) of it.
        kept: (n,) which are there.
    """

    true: np.ndarray
    noise: np.ndarray
    kept: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """(n,) with noise; NaN where one is missing."""
        return np.where(self.kept, self.true + self.noise, np.nan)


def read(case: Case, true: np.ndarray) -> Readings:
    """The readings of a case, from the true ones (n,)."""
    return read_by(PROTOCOLS[case.protocol], case.instruments, case.seed, true)


def read_by(
    protocol: Protocol, instruments: Instruments, seed: Sequence[int], true: np.ndarray
) -> Readings:
    """Readings of any protocol with the noise of instruments."""
    index = noise.index(protocol)
    rng = np.random.default_rng(seed)
    covariance = noise_matrix(index, noise.by_channel(protocol, instruments))
    scatter = noise.draw(index, covariance, rng)
    return Readings(true, scatter, noise.kept(index, rng))


def rows(protocol: Protocol, value: np.ndarray, specimen: str = "A") -> list[dict[str, Any]]:
    """Rows of a measured CSV with the readings ``value`` (n,)."""
    found: list[dict[str, Any]] = []
    place = 0
    for course in protocol.courses:
        names = [c for c in READING_COLUMNS if c in protocol.columns[course.experiment]]
        for row in course.rows.to_dict("records"):
            read_here = dict(zip(names, value[place : place + len(names)], strict=True))
            place += len(names)
            which = {"experiment": course.experiment, "specimen": specimen}
            found.append({**which, **row, **read_here})
    return found


def write(case: Case, readings: Readings, folder: Path) -> Path:
    """``measured.csv`` and ``.toml``, and ``truth.json`` that nobody but the scorer reads.

    Returns:
        The CSV.
    """
    protocol = PROTOCOLS[case.protocol]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "measured.csv"
    told = {**protocol.setup(), "noise": case.instruments.told(noise.channels(protocol))}
    write_files(path, rows(protocol, readings.value), told)
    (folder / "truth.json").write_text(json.dumps(asdict(case)) + "\n", encoding="utf-8")
    return path


def write_files(path: Path, table: Sequence[Mapping[str, Any]], told: Mapping[str, Any]) -> None:
    """A measured CSV and its TOML."""
    names = [name for name in MEASURED if any(name in row for row in table)]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        for row in table:
            writer.writerow({name: _text(value) for name, value in row.items()})
    path.with_suffix(".toml").write_text(tomlkit.dumps(told), encoding="utf-8")


def _text(value: Any) -> Any:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return value


def table_of(cases: Sequence[Case]) -> pd.DataFrame:
    """A row for each case: what is hidden, for people."""
    return pd.DataFrame(
        [
            {
                "case": case.name,
                "protocol": case.protocol,
                "kind": case.kind,
                "full": case.full,
                "hidden": " + ".join(
                    f"{each.name} {each.strength:.3g}" for each in case.truth.causes
                ),
                **{name: round(case.truth.sigma(name), 3) for name in NUISANCES},
            }
            for case in cases
        ]
    )
