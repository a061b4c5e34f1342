"""The files of a diagnosis: diagnosis.json, extended.toml, summary.md, readings.csv; pictures'."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import extend, page, summary
from dolfingrip.diagnosis.coupon import results as coupon_results
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.found import Diagnosis


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes:
        text: of the summary.
        pictures: plain data for the report.
    """

    text: str
    pictures: dict[str, Any]


def write(
    found: Diagnosis | CouponDiagnosis, config: Config, data: Sequence[Path], out: Path
) -> Written:
    """Write all files but the pictures into ``out``."""
    out.mkdir(parents=True, exist_ok=True)
    if isinstance(found, CouponDiagnosis):
        told = coupon_results.extended_toml(found)
        (out / "extended.toml").write_text(told, encoding="utf-8")
        result = coupon_results.outcome_of(found, [str(file) for file in data], out)
        result.write(out / "diagnosis.json")
        text = page.text(result)
        (out / "summary.md").write_text(text, encoding="utf-8")
        return _written(text, coupon_results.pictures(found), out)
    fit = found.best
    try:
        extend.write(
            out / "extended.toml", config, fit, found.numbers(fit), found.verdict.sentence()
        )
    except ConfigError as error:
        found.warnings.append(f"extended.toml is not written: {error}")
    result = summary.outcome_of(found, config, [str(file) for file in data])
    result.write(out / "diagnosis.json")
    text = page.text(result)
    (out / "summary.md").write_text(text, encoding="utf-8")
    return _written(text, _pictures(found), out)


def _written(text: str, pictures: dict[str, Any], out: Path) -> Written:
    """What was written, with the readings beside it as a table."""
    pictures["readings"].to_csv(out / "readings.csv", index=False)
    return Written(text, pictures)


def _pictures(found: Diagnosis) -> dict[str, Any]:
    problem = found.problem
    everything = np.ones(len(problem.value), dtype=bool)
    verdict = found.verdict
    return {
        "readings": problem.index.assign(
            value=problem.value,
            noise=problem.noise_std,
            configured=problem.simulated,
            before=found.nuisances_fitted,
            after=found.best.predicted(problem, everything),
        ),
        "cause": " with ".join(found.best.effects),
        "probabilities": {
            **{_in_words(each.names): each.probability for each in verdict.table},
            "none": verdict.none,
            "unknown": verdict.unknown,
        },
        "gain": [
            {
                "left_out": row.left_out, "channel": row.channel, "before": row.before,
                "nuisances": row.nuisances, "process": row.process, "cause": row.cause,
                "interval": row.cause_interval,
            }
            for row in found.gain
        ],
    }  # fmt: skip


def _in_words(names: Sequence[str]) -> str:
    return " or ".join(names).replace("_", " ")
