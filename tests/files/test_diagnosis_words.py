"""Words of a diagnosis, by values: three short lines for every kind of answer.

Reference: what the fields say, written by hand.
"""

from __future__ import annotations

from html import escape
from typing import Any

import pytest

from dolfingrip.config import Config
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.files.diagnosis import (
    Advice,
    ArtefactSize,
    CauseProbability,
    ChannelMisfit,
    CommonChange,
    DiagnosisFile,
    FittedHypothesis,
    FittedNumber,
    Headline,
    NextExperiment,
    Slip,
    SpecimensApart,
    Verdict,
)
from dolfingrip.files.diagnosis_words import (
    ADVICE,
    LONGEST,
    NUMBERS,
    advice_words,
    cautions,
    lines,
    page,
    tables,
)

MU = FittedNumber(key="material.mu_MPa", value=0.675, low=0.641, high=0.708, unit="MPa",
                  configured=2.93, part="material")  # fmt: skip
AS_TOLD = MU.model_copy(update={"value": 2.95, "low": 2.8, "high": 3.1})
C01 = FittedNumber(key="extensions.mooney_rivlin.C01_MPa", value=1.29, low=0.94, high=1.52,
                   unit="MPa", part="mooney_rivlin")  # fmt: skip
GAIN = FittedNumber(key="extensions.pressure_gain.gain", value=1.07, low=1.05, high=1.1,
                    configured=1.0, part="rig")  # fmt: skip
SET_MU = "--set material.mu_MPa=0.675"
EXTENDED = "--config out/diagnosis/extended.toml"
MANOMETER = NextExperiment(
    name="a manometer at the finger's inlet, at rest and at the highest pressure", minutes=10.0,
    gain=4.0, gain_per_minute=0.4, chance=0.93, shows=("pressure_gain", "plate_gap"),
)  # fmt: skip


def verdict(answer: str, *effects: str, **more: Any) -> Verdict:
    given = {"answer": answer, "class": effects, "probability": 0.92, "takes_part": 0.92}
    return Verdict.model_validate({"least": more.get("probability", 0.92), **given, **more})


def cause(name: str, words: str = "", kind: str = "elastic", **more: Any) -> CauseProbability:
    return CauseProbability(
        name=name, words=words, kind=kind, probability=0.5, strength_sigma=9.0, **more
    )


def told(answer: Verdict, number: FittedNumber = MU, option: str = SET_MU, **more: Any) -> Any:
    """A diagnosis of these fields."""
    common = more.pop("common", None)
    misfit = ChannelMisfit(channel="angle_deg", unit="deg", configured=9.0, fitted=1.0,
                           extended=0.33, noise=0.3)  # fmt: skip
    given = {
        "version": "0", "data": (), "quick": False, "readings": 18, "causes": (), "none": 0.0,
        "unknown": 0.0, "misfit": (misfit,), "simulated_s": 0.0,
        "fits": (FittedHypothesis(effects=(), log_evidence=0.0, parameters=(number,)),),
        "next_experiments": (MANOMETER,),
    }  # fmt: skip
    of = number.part if number is C01 else "".join(answer.effects[:1])
    head = Headline(number=number, cause=of, common=common, option=option)
    return DiagnosisFile.model_validate({"verdict": answer, "headline": head, **given, **more})


COMMON = CommonChange(experiment="bending", channel="angle_deg", way="stiffer", percent=6.04,
                      low=5.1, high=6.42, above=150.0, control_unit="kPa")  # fmt: skip
FAMILY = ("mooney_rivlin", "yeoh", "ogden", "polynomial", "print_anisotropy")
SOFTENS = cause("mooney_rivlin", "softening at moderate strain")
JUMP = "jump of force_N of coupon of S2 (lab.csv) between 8 and 9 mm in the loading of cycle 1"

ANSWERS: dict[str, tuple[DiagnosisFile, str, str]] = {
    "another modulus": (
        told(verdict("none")),
        "The material is 4.3 times softer than configured: material.mu_MPa = 0.675 MPa (0.641 to "
        "0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.92 that nothing else is off: 1.1 times the noise is left.",
    ),
    "none": (
        told(verdict("none"), AS_TOLD, "--set material.mu_MPa=2.95"),
        "The material may be as configured: material.mu_MPa = 2.95 MPa (2.8 to 3.1): `--set "
        "material.mu_MPa=2.95`",
        "Probability 0.92 that nothing else is off: 1.1 times the noise is left.",
    ),
    "cannot tell": (
        told(verdict("none", probability=0.6, claimed=False), behind=("modulus", "wall"),
             causes=(cause("base_layer_offset", open=True), cause("gravity_pitch", open=True))),
        "The material is 4.3 times softer than configured: material.mu_MPa = 0.675 MPa (0.641 to "
        "0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.60 that nothing else is off, too little to claim it: base_layer_offset or 1 "
        "more may hide behind modulus and wall.",
    ),
    "something is off": (
        told(verdict("none", probability=0.2, claimed=False), causes=(cause("yeoh", open=True),)),
        "The material is 4.3 times softer than configured: material.mu_MPa = 0.675 MPa (0.641 to "
        "0.708): `--set material.mu_MPa=0.675`",
        "Something is off with probability 0.80, but no cause can be claimed: yeoh may hide.",
    ),
    "named cause": (
        told(verdict("cause", "mooney_rivlin", unexplained=0.012), C01, EXTENDED,
             causes=(SOFTENS,), common=COMMON),
        "Softening at moderate strain (mooney_rivlin): extensions.mooney_rivlin.C01_MPa = 1.29 MPa "
        "(0.94 to 1.52): `--config out/diagnosis/extended.toml`",
        "Probability 0.92: it explains 98.8 % of what the model misses.",
    ),
    "instrument": (
        told(verdict("cause", "pressure_gain", probability=0.997, least=0.4), GAIN,
             "--set extensions.pressure_gain.gain=1.07",
             causes=(cause("pressure_gain", "a regulator whose scale is off", "loading"),)),
        "A regulator whose scale is off (pressure_gain): extensions.pressure_gain.gain = 1.07 "
        "(1.05 to 1.1): `--set extensions.pressure_gain.gain=1.07`",
        "Probability > 0.99 (0.40 under other priors): it explains all of what the model misses.",
    ),
    "coupon": (
        told(verdict("cause", "modulus", "coupon_area"), causes=(
            cause("modulus", NUMBERS["modulus"], ""),
            cause("coupon_area", NUMBERS["coupon_area"], ""))),
        "The material is 4.3 times softer than configured, or the coupons' cross-section is "
        "another: material.mu_MPa = 0.675 MPa (0.641 to 0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.92: it explains all of what the model misses.",
    ),
    "set": (
        told(verdict("cause", *FAMILY), C01, EXTENDED, common=COMMON),
        "mooney_rivlin, yeoh, ogden or 2 more: all of them make it 6.04 % (5.1 to 6.42 %) stiffer "
        "than configured above 150 kPa: `--config out/diagnosis/extended.toml`",
        "Probability 0.92: it explains all of what the model misses.",
    ),
    "set of instrument and body": (
        told(verdict("cause", "angle_gain", "uneven_stiffness"), C01, EXTENDED,
             causes=(cause("angle_gain", kind="measurement"), cause("uneven_stiffness")),
             common=COMMON.model_copy(update={"way": "lower", "below": 200.0})),
        "angle_gain or uneven_stiffness: all of them make angle_deg 6.04 % (5.1 to 6.42 %) lower "
        "than configured between 150 and 200 kPa: `--config out/diagnosis/extended.toml`",
        "Probability 0.92: it explains all of what the model misses; either an instrument is off "
        "or the finger.",
    ),
    "two sets": (
        told(verdict("cause", "prony", second=FAMILY), C01, EXTENDED,
             causes=(cause("prony", "viscoelasticity"), SOFTENS)),
        "prony with mooney_rivlin, yeoh, ogden or 2 more: extensions.mooney_rivlin.C01_MPa = 1.29 "
        "MPa (0.94 to 1.52): `--config out/diagnosis/extended.toml`",
        "Probability 0.92: it explains all of what the model misses.",
    ),
    "by its shape": (
        told(verdict("cause", "prony", probability=0.5, claimed=False, by_shape=True), C01,
             EXTENDED, causes=(SOFTENS,), advice=Advice(way="memory")),
        "Softening at moderate strain (mooney_rivlin): extensions.mooney_rivlin.C01_MPa = 1.29 MPa "
        "(0.94 to 1.52): `--config out/diagnosis/extended.toml`",
        "Not enough to claim it: probability 0.50: an elastic law or friction in the rig follows "
        "these readings as well.",
    ),
    "unknown": (
        told(verdict("unknown", nearest=("mullins", "gravity_pitch"), unexplained=0.51)),
        "No effect of the catalogue explains the readings; as fitted, material.mu_MPa = 0.675 MPa "
        "(0.641 to 0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.92 that something else acts: 51 % of what the model misses stays beside the "
        "nearest, mullins or gravity_pitch.",
    ),
    "nothing claimed": (
        told(verdict("unknown", probability=0.4, claimed=False), none=0.1,
             causes=(cause("yeoh", open=True), cause("gent", open=True))),
        "No cause can be claimed; as fitted, material.mu_MPa = 0.675 MPa (0.641 to 0.708): `--set "
        "material.mu_MPa=0.675`",
        "Something is off with probability 0.90; yeoh or gent may act.",
    ),
    "quick": (
        told(verdict("none", claimed=False), quick=True, not_tried=("prony", "mullins")),
        "The material is 4.3 times softer than configured: material.mu_MPa = 0.675 MPa (0.641 to "
        "0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.92 that nothing else is off, too little to claim it: not every cause was "
        "tried; --quick left out 2 causes.",
    ),
    "quick, not reached": (
        told(verdict("cause", "mooney_rivlin", claimed=False), C01, EXTENDED, causes=(SOFTENS,),
             quick=True, not_tried=("prony", "mullins"), not_reached=("bending: a limit point",)),
        "Softening at moderate strain (mooney_rivlin): extensions.mooney_rivlin.C01_MPa = 1.29 MPa "
        "(0.94 to 1.52): `--config out/diagnosis/extended.toml`",
        "Not enough to claim it: probability 0.92: it explains all of what the model misses; "
        "--quick left out 2 causes; some readings are not reached.",
    ),
    "not reached": (
        told(verdict("none"), not_reached=("bending of A (lab.csv): a limit point",)),
        "The material is 4.3 times softer than configured: material.mu_MPa = 0.675 MPa (0.641 to "
        "0.708): `--set material.mu_MPa=0.675`",
        "Probability 0.92 that nothing else is off: 1.1 times the noise is left; some readings are "
        "not reached.",
    ),
    "artefact": (
        told(verdict("cause", "mooney_rivlin"), C01, EXTENDED, causes=(SOFTENS,),
             artefacts=(ArtefactSize(name=JUMP, size=-0.5, unit="N"),)),
        "Softening at moderate strain (mooney_rivlin): extensions.mooney_rivlin.C01_MPa = 1.29 MPa "
        "(0.94 to 1.52): `--config out/diagnosis/extended.toml`",
        "Probability 0.92: it explains all of what the model misses; artefacts of instruments are "
        "taken out.",
    ),
    "slip": (
        told(verdict("unknown"), slips=(Slip(where="coupon, 8 specimens (lab.csv)",
             column="force_N", meaning="a force in grams", factor=1 / 101.97),)),
        "Check the data first: coupon, 8 specimens (lab.csv): force_N: a force in grams? (factor "
        "0.009807)",
        "Probability 0.92 that something else acts: 0 % of what the model misses stays.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", ANSWERS)
def test_an_answer_is_three_short_lines(kind: str) -> None:
    result, first, second = ANSWERS[kind]
    shown = lines(result)
    print(*shown, sep="\n")
    assert shown[:2] == (first, second)
    assert all(0 < len(line.split()) <= LONGEST for line in shown)
    assert page(result).splitlines()[:3] == [*shown]


def test_the_third_line_is_what_to_measure_and_what_it_tells() -> None:
    result = told(verdict("none"))
    assert lines(result)[2] == (
        "Measure next: a manometer at the finger's inlet, at rest and at the highest pressure (10 "
        "minutes): it leaves one answer with probability 0.93."
    )
    short = MANOMETER.model_copy(update={"name": "weigh the finger", "minutes": 2.0})
    assert lines(result.model_copy(update={"next_experiments": (short,)}))[2] == (
        "Measure next: weigh the finger (2 minutes): it may tell pressure_gain or plate_gap, and "
        "leaves one answer with probability 0.93."
    )
    never = short.model_copy(update={"chance": 0.0})
    assert lines(result.model_copy(update={"next_experiments": (never,)}))[2] == (
        "Measure next: weigh the finger (2 minutes): it may tell pressure_gain or plate_gap."
    )
    asked = Advice(way="finger_or_channel", names=("yeoh", "gent"), unload=True)
    assert lines(result.model_copy(update={"next_experiments": (), "advice": asked}))[2] == (
        "Measure with unloading the finger or another channel: it may tell whether yeoh or gent "
        "acts."
    )


@pytest.mark.parametrize("way", ADVICE)
def test_each_advice_is_short(way: Any) -> None:
    text = advice_words(Advice(way=way, names=FAMILY, unload=True))
    print(text)
    assert len(text.split()) <= LONGEST
    assert "{" not in text


@pytest.mark.parametrize("effect", [each.name() for each in EFFECTS])
def test_each_effect_has_words_for_the_first_line(effect: str) -> None:
    """At its neutral numbers, beside the longest number and option."""
    (kind,) = (each for each in EFFECTS if each.name() == effect)
    number = C01.model_copy(update={"part": effect, "key": f"extensions.{effect}.number"})
    causes = (cause(effect, kind().words(Config())),)
    first, *_ = lines(told(verdict("cause", effect), number, EXTENDED, causes=causes))
    print(first)
    assert len(first.split()) <= LONGEST
    assert effect in first
    assert EXTENDED in first


def test_walls_and_other_numbers_are_compared_with_what_is_configured() -> None:
    walls = FittedNumber(key="finger.wall_mm", value=1.65, low=1.63, high=1.68, unit="mm",
                         configured=1.6, part="walls")  # fmt: skip
    chamber = walls.model_copy(update={"key": "cast.chamber_width_mm", "part": "body"})
    chamber = chamber.model_copy(update={"configured": 8.0})
    zero = walls.model_copy(update={"key": "coupon_slack_mm", "part": "rig", "configured": 0.0})
    starts = [lines(told(verdict("none"), each))[0].partition(":")[0]
              for each in (walls, chamber, zero)]  # fmt: skip
    assert starts == [
        "The walls are 3.1 % thicker than configured",
        "cast.chamber_width_mm is 4.8 times smaller than configured",
        "coupon_slack_mm is not as configured",
    ]


def test_cautions_stand_below() -> None:
    result, *_ = ANSWERS["slip"]
    more = {
        "apart": SpecimensApart(specimens=("S4",), odds=2e4, without=verdict("cause", "yeoh")),
        "failed": {"gent": "no equilibrium"}, "warnings": ("beware",), "mesh_known": False,
    }  # fmt: skip
    listed = cautions(result.model_copy(update=more))
    assert listed[0].endswith("a force in grams? (factor 0.009807)")
    assert listed[1] == (
        "of the specimens S4 stands apart (odds 2e+04 to 1); the answer without: cause yeoh, "
        "probability 0.92"
    )
    assert "gent could not be tried: no equilibrium" in listed
    assert listed[-1] == "beware"
    assert any("what the mesh gets wrong" in each for each in listed)


def test_a_console_and_a_notebook_show_its_lines_and_tables() -> None:
    found = told(verdict("cause", "pressure_gain"), number=GAIN)
    said, shown = " ".join(repr(found).split()), found._repr_html_()
    for line in lines(found):
        assert " ".join(line.split()) in said
        assert escape(line, quote=False) in _quoted(shown)
    assert max(map(len, repr(found).splitlines())) <= 100
    for table in tables(found):
        assert f"<summary>{escape(table.title)}</summary>" in shown


def _quoted(text: str) -> str:
    """HTML with quotes as they are."""
    return text.replace("&quot;", '"').replace("&#x27;", "'")
