"""Controls that must behave: the same cases with other noise, or with noise that is not as told.

- doubled: twice the noise, which the laboratory tells: intervals widen and fewer claims are made;
- too_small: the laboratory believes it 1.5 times smaller than it is: that is noticed and said;
- independent: a part drifts along each run, and the laboratory does not tell: likewise.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from benchmarks.blind import diagnoses
from benchmarks.blind.bound import Bound
from benchmarks.blind.cases import Case, control
from benchmarks.blind.diagnoses import How
from benchmarks.blind.noise import Instruments
from benchmarks.blind.opinions import Opinion
from benchmarks.blind.score import CLAIM
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import noise_matrix

USUAL: Final = "as usual"
VARIANTS: Final[Mapping[str, Instruments]] = {
    "doubled": Instruments(factor=2.0),
    "too_small": Instruments(told_factor=1 / 1.5),
    "independent": Instruments(told_correlated=False),
}
NUMBER: Final = 12
"""Cases that each control is made of: single causes and none."""
NOTICED: Final = 0.8
"""Share of cases in which wrong noise has to be noticed."""
RARELY: Final = 0.1
"""Share in which right noise may be doubted."""
ODDS: Final = 9.0
"""Odds of the noise that is there against that believed, from which on it can be noticed."""
DRAWS: Final = 400
SEED: Final = 20_263


def chosen(cases: Sequence[Case]) -> list[Case]:
    """The cases that controls are made of."""
    own = [case for case in cases if case.kind in ("one", "none") and not case.full]
    return own[:NUMBER]


def variants(cases: Sequence[Case]) -> dict[str, list[Case]]:
    """The cases of each control, and those as usual."""
    own = chosen(cases)
    found = {USUAL: own}
    for name, instruments in VARIANTS.items():
        found[name] = [control(case, name, instruments) for case in own]
    return found


def table(
    wanted: Mapping[str, Sequence[Case]], folder: Callable[[Case], Path], how: How
) -> pd.DataFrame:
    """A row for each control that has been diagnosed.

    Args:
        wanted: of :func:`variants`.
        folder: of a case.
        how: cases were diagnosed.
    """
    known = {
        name: [
            (case, diagnoses.diagnose(case, folder(case), how))
            for case in cases
            if diagnoses.is_known(folder(case), how)
        ]
        for name, cases in wanted.items()
    }
    named = {
        case.number
        for case, content in known.get(USUAL, ())
        if Opinion.of_file(content).answer == "cause"
    }
    rows = [
        {"control": name, "cases": len(contents), **_numbers(contents, named)}
        for name, contents in known.items()
        if contents
    ]
    found = pd.DataFrame(rows)
    return found.assign(behaves=_behaves(found)) if rows else found


def _numbers(
    contents: Sequence[tuple[Case, dict[str, Any]]], named: Collection[int]
) -> dict[str, float]:
    """Those of one control; classes of the cases ``named``, in which a cause is named as usual.

    Where none is, all that is visible leads as one class, which is smaller where the noise is
    larger and less is visible.
    """
    opinions = [(case, Opinion.of_file(content)) for case, content in contents]
    claims = [opinion.claims(CLAIM) for _, opinion in opinions]
    alarms = [opinion.answer != "none" for case, opinion in opinions if case.kind == "none"]
    spread = [
        each.high - each.low
        for case, content in contents
        for each in diagnoses.intervals(case, content)
        if each.key.startswith(("extensions", "strength"))
    ]
    sizes = [len(opinion.leading) for case, opinion in opinions if case.number in named]
    return {
        "claims": float(np.mean(claims)),
        "false_alarms": float(np.mean(alarms)) if alarms else float("nan"),
        "median_interval": float(np.median(spread)) if spread else float("nan"),
        "mean_class": float(np.mean(sizes)) if sizes else float("nan"),
        "noise_doubted": float(np.mean([diagnoses.doubts_noise(c) for _, c in contents])),
    }


def noticeable(bound: Bound, instruments: Instruments) -> float:
    """Share of measurements in which exact evidence notices that the noise is not as told.

    No cause is there, and nuisances are exactly linear: the noise as it is against the noise as it
    is believed, at odds of :data:`ODDS`.
    """
    spread = bound.nuisances @ bound.nuisances.T
    names = set(bound.index["channel"])
    there, told = (
        Covariance.of(noise_matrix(bound.index, {name: of(name) for name in names}) + spread)
        for of in (instruments.of, instruments.believed)
    )
    drawn = there.sample(np.random.default_rng(SEED), DRAWS).T
    odds = [there.log_density(one) - told.log_density(one) for one in drawn]
    return float(np.mean(np.array(odds) > np.log(ODDS)))


def _behaves(found: pd.DataFrame) -> list[bool]:
    """Whether each control does what it has to."""
    usual = found[found["control"] == USUAL]
    if usual.empty:
        return [False] * len(found)
    before = usual.iloc[0]
    behaviour = []
    for _, row in found.iterrows():
        if row["control"] == USUAL:
            behaviour.append(bool(row["noise_doubted"] <= RARELY))
        elif row["control"] == "doubled":
            # a screen alone has no intervals; its classes widen
            known = row["median_interval"] > 0 and before["median_interval"] > 0
            width = "median_interval" if known else "mean_class"
            wider = row[width] > before[width]
            behaviour.append(bool(row["claims"] <= before["claims"] and wider))
        else:
            behaviour.append(bool(row["noise_doubted"] >= NOTICED))
    return behaviour
