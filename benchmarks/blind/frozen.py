"""Cases as files: what a laboratory hands over, and what was hidden; no analyser is asked.

A protocol has three files here: ``NAME.csv`` with the readings of all cases, ``NAME.toml`` with
what the laboratory tells of its set-up, and ``NAME-truth.csv`` with what is hidden.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Final

FOLDER: Final = Path(__file__).with_name("frozen")


@dataclass(frozen=True, slots=True)
class FrozenCase:
    """A case whose readings are kept as a file, and what is hidden in it.

    Attributes:
        protocol, kind, number: of it.
        wide: whether strengths are from priors twice as wide.
        hidden: the causes and a nuisance that is far out; an outsider's name is not here.
        outsider: its name; none where empty.
        outsider_strength: by the ordinary one.
        sigma: standard deviations that each cause changes the hidden simulation by, after modulus
            and rig; then those of the outsider, or of the nuisance.
        left: of an outsider alone, the standard deviations that the best single cause leaves of it,
            by the analyser of the draw; None elsewhere, or where it is not known.
        numbers: true values by key of the configuration, and the modulus by the told one.
        seed: of the draw.
    """

    protocol: str
    kind: str
    number: int
    wide: bool
    hidden: tuple[str, ...] = ()
    outsider: str = ""
    outsider_strength: float = 0.0
    sigma: tuple[float, ...] = ()
    left: float | None = None
    numbers: Mapping[str, Any] = field(default_factory=dict)
    seed: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Name among the cases of the protocol."""
        return f"{self.kind}-{self.number}"

    def row(self) -> dict[str, Any]:
        """The row of the table."""
        told = asdict(self)
        for name, value in told.items():
            if isinstance(value, tuple):
                told[name] = " ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in value)
        left = "" if self.left is None else f"{self.left:.4g}"
        return told | {"numbers": json.dumps(self.numbers), "left": left}

    @classmethod
    def of(cls, row: Mapping[str, str]) -> FrozenCase:
        """Read a row of the table."""
        return cls(
            row["protocol"], row["kind"], int(row["number"]), row["wide"] == "True",
            tuple(row["hidden"].split()), row["outsider"], float(row["outsider_strength"]),
            tuple(map(float, row["sigma"].split())), float(row["left"]) if row["left"] else None,
            json.loads(row["numbers"]), tuple(map(int, row["seed"].split())),
        )  # fmt: skip


def cases(protocol: str, folder: Path = FOLDER) -> list[FrozenCase]:
    """Read what is hidden in the cases of a protocol.

    Args:
        protocol: its name.
        folder: of the files.

    Returns:
        The cases in the order of their draws; none where there is no such file.
    """
    file = folder / f"{protocol}-truth.csv"
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as stream:
        return [FrozenCase.of(row) for row in csv.DictReader(stream)]


def add(case: FrozenCase, measured: Path, folder: Path = FOLDER) -> None:
    """Add a case to the files of its protocol; the truth comes last, so that it marks a whole case.

    Args:
        case: what is hidden.
        measured: its readings, with what the laboratory tells beside them.
        folder: of the files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    told = folder / f"{case.protocol}.toml"
    content = measured.with_suffix(".toml").read_text(encoding="utf-8")
    if told.exists() and told.read_text(encoding="utf-8") != content:
        raise ValueError(f"{told}: another set-up than that of {case.name}")
    told.write_text(content, encoding="utf-8")
    known = [line for line in _lines(case.protocol, folder) if not line.startswith(f"{case.name},")]
    header, *readings = measured.read_text(encoding="utf-8").splitlines()
    lines = known or [f"case,{header}"]
    lines += [f"{case.name},{line}" for line in readings]
    (folder / f"{case.protocol}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = folder / f"{case.protocol}-truth.csv"
    begun = file.exists()
    with file.open("a", encoding="utf-8", newline="") as stream:
        table = csv.DictWriter(stream, [each.name for each in fields(FrozenCase)],
                               lineterminator="\n")  # fmt: skip
        if not begun:
            table.writeheader()
        table.writerow(case.row())


def _lines(protocol: str, folder: Path) -> list[str]:
    file = folder / f"{protocol}.csv"
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


def written(case: FrozenCase, out: Path, folder: Path = FOLDER) -> Path:
    """Write a case's readings and set-up as a laboratory would.

    Args:
        case: which one.
        out: folder that is written to.
        folder: of the files.

    Returns:
        The table, whose TOML lies beside it.
    """
    header, *rows = _lines(case.protocol, folder)
    own = [row.partition(",")[2] for row in rows if row.startswith(f"{case.name},")]
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"{case.protocol}.csv"
    file.write_text("\n".join([header.partition(",")[2], *own]) + "\n", encoding="utf-8")
    told = (folder / f"{case.protocol}.toml").read_text(encoding="utf-8")
    file.with_suffix(".toml").write_text(told, encoding="utf-8")
    return file


def protocols(folder: Path = FOLDER) -> Iterator[str]:
    """Names of the protocols that have cases.

    Args:
        folder: of the files.
    """
    for file in sorted(folder.glob("*-truth.csv")):
        yield file.name.removesuffix("-truth.csv")
