"""Judged cases as a table, from which all figures can be computed again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import pandas as pd

from benchmarks.blind.opinions import Interval, Judged, Names, Opinion

OR: Final = " or "
"""Between effects of a class."""
AND: Final = " + "
"""Between classes, and between hidden causes."""
MAYBE: Final = ("cut", "bound_cut", "beats_rivals")
"""Columns that may be empty."""


def table(judged: Sequence[Judged]) -> pd.DataFrame:
    """A row for each case."""
    return pd.DataFrame([_row(case) for case in judged])


def _row(case: Judged) -> dict[str, Any]:
    return {
        "case": case.name,
        "protocol": case.protocol,
        "kind": case.kind,
        "full": case.full,
        "hidden": AND.join(case.hidden),
        "strengths_sigma": AND.join(f"{each:.6g}" for each in case.strengths_sigma),
        "unexplained_sigma": round(case.unexplained_sigma, 5),
        **_told(case.said, ""),
        **_told(case.bound, "bound_"),
        "intervals": _written(case.intervals),
        "bound_intervals": _written(case.bound_intervals),
        **{name: getattr(case, name) for name in MAYBE},
        "seconds": round(case.seconds, 1),
    }


def _told(opinion: Opinion, whose: str) -> dict[str, Any]:
    return {
        f"{whose}answer": opinion.answer,
        f"{whose}probability": round(opinion.probability, 6),
        f"{whose}class": OR.join(opinion.leading),
        f"{whose}named": AND.join(OR.join(names) for names in opinion.named),
    }


def _written(intervals: Sequence[Interval]) -> str:
    return AND.join(f"{i.key}: {i.low:.10g}, {i.high:.10g}, {i.true:.10g}" for i in intervals)


def read(file: Path) -> list[Judged]:
    """The cases of a table."""
    rows = pd.read_csv(file, keep_default_na=False).to_dict("records")
    return [_judged(row) for row in rows]


def _judged(row: dict[Any, Any]) -> Judged:
    told = {name: row[name] for name in MAYBE}
    maybe = {name: None if text == "" else _number(text) for name, text in told.items()}
    return Judged(
        name=row["case"],
        protocol=row["protocol"],
        kind=row["kind"],
        full=str(row["full"]) == "True",
        hidden=_parts(row["hidden"], AND),
        strengths_sigma=tuple(float(x) for x in _parts(str(row["strengths_sigma"]), AND)),
        unexplained_sigma=float(row["unexplained_sigma"]),
        said=_opinion(row, ""),
        bound=_opinion(row, "bound_"),
        intervals=_intervals(row["intervals"]),
        bound_intervals=_intervals(row["bound_intervals"]),
        seconds=float(row["seconds"]),
        **maybe,
    )  # fmt: skip


def _number(text: object) -> Any:
    return {"True": True, "False": False}.get(str(text)) if str(text)[0] in "TF" else float(text)  # type: ignore[arg-type]


def _parts(text: str, between: str) -> Names:
    return tuple(text.split(between)) if text else ()


def _opinion(row: dict[Any, Any], whose: str) -> Opinion:
    return Opinion(
        row[f"{whose}answer"],
        float(row[f"{whose}probability"]),
        _parts(row[f"{whose}class"], OR),
        tuple(_parts(names, OR) for names in _parts(row[f"{whose}named"], AND)),
    )


def _intervals(text: str) -> tuple[Interval, ...]:
    found = []
    for each in _parts(text, AND):
        key, _, numbers = each.rpartition(": ")
        found.append(Interval(key, *(float(x) for x in numbers.split(", "))))
    return tuple(found)
