"""The blind benchmark: controls, of which each has to behave in its own way."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from blind.made_up import case, made_up

from benchmarks.blind import controls
from benchmarks.blind.bound import Bound
from benchmarks.blind.cases import Case
from benchmarks.blind.diagnoses import RESULT, How
from benchmarks.blind.response import Hidden


def test_controls_by_hand(tmp_path: Path) -> None:
    """Doubled noise widens the class; of noise that is not as told, one kind is noticed."""
    catalogue = made_up()
    none = replace(case(catalogue, kind="none", seed=4), number=1)
    own = [case(catalogue, Hidden("prony", 0, 1.0)), none]
    wanted = controls.variants(own)
    assert {name: len(cases) for name, cases in wanted.items()} == {
        controls.USUAL: 2, "doubled": 2, "too_small": 2, "independent": 2,
    }  # fmt: skip

    def folder(each: Case) -> Path:
        return tmp_path / each.kind / (each.variant or "usual")

    how = How(tmp_path, quick=True)
    for name, cases in wanted.items():
        for each in cases:
            effects = ["prony", "gent"][: 2 if name == "doubled" else 1]
            if each.kind == "none":  # all that is visible leads where nothing is named
                effects = ["prony", "gent", "yeoh", "ogden"][: 2 if name == "doubled" else 4]
            answer = "cause" if each.kind == "one" or name == "independent" else "none"
            content = {
                "verdict": {"answer": answer, "class": effects, "second": [], "probability": 0.95},
                "classes": [{"effects": effects}],
                "noise": {"too_small": name == "too_small", "correlated": False},
                "fits": [],
            }
            place = folder(each) / how.mode
            place.mkdir(parents=True)
            (place / RESULT).write_text(json.dumps(content), encoding="utf-8")
    found = controls.table(wanted, folder, how).set_index("control")
    assert list(found["false_alarms"]) == [0.0, 0.0, 0.0, 1.0]
    assert list(found["mean_class"]) == [1.0, 2.0, 1.0, 1.0]
    assert list(found["noise_doubted"]) == [0.0, 0.0, 1.0, 0.0]
    assert list(found["behaves"]) == [True, True, True, False]


def test_noise_that_is_as_told_cannot_be_noticed() -> None:
    """Noise that is 1.5 times as large always can, drift in a first loading hardly ever."""
    bound = Bound(made_up())
    found = {
        name: controls.noticeable(bound, instruments)
        for name, instruments in controls.VARIANTS.items()
    }
    print(found)
    assert found["doubled"] == 0.0
    assert found["too_small"] > 0.5
    assert 0.0 < found["independent"] < found["too_small"]
