"""The blind benchmark: its cases, their files, the bound and the figures.

Curves of the library are made up here, so that no finger is simulated; the last test goes from the
simulation of coupons to the table of figures.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks.blind import __main__ as stages
from benchmarks.blind import bound, cases, ci, generator, library, noise, outsiders, score
from benchmarks.blind.cases import Case
from benchmarks.blind.generator import Cause
from benchmarks.blind.library import Change, Curve, Library
from benchmarks.blind.opinions import Interval, Judged, Opinion
from benchmarks.blind.protocols import FINGERS, PROTOCOLS
from benchmarks.blind.response import Catalogue, Hidden, Truth
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.inference.noise import noise_matrix

SIMULATED = ("mooney_rivlin", "prony", "plate_compliance")
CLOSED = ("angle_gain", "line_lag")


def few() -> dict[str, Cause]:
    known = generator.causes()
    return {name: known[name] for name in (*SIMULATED, *CLOSED)}


def made_up(protocol: str = "P2") -> Catalogue:
    """A finger that bends and presses as powers of the pressure, and three effects on it."""
    at = np.linspace(0, 375, 31)
    base, changes = {}, {}
    for experiment, column, scale in (
        ("bending", "angle_deg", 100),
        ("blocked_force", "force_N", 3),
    ):
        y = scale * (at / 250 + 0.3 * (at / 250) ** 2)
        slopes = {
            (column, "finger.wall_mm"): -0.5 * y * (1 - at / 800),
            (column, "finger.base_layer_mm"): -0.3 * y,
            (column, "plate.gap_mm"): -0.02 * (experiment == "blocked_force") * at / (at + 20),
        }
        base[experiment] = Curve(at, {column: y, "tip_x_mm": y, "tip_z_mm": y}, slopes)
        rows = PROTOCOLS[protocol].course(experiment).rows
        history = rows["pressure_kPa"].to_numpy()
        up = at[at <= 300]
        shapes = {
            "mooney_rivlin": ("curve", up, np.sin(up / 60) * up / 250),
            "prony": ("history", history, np.where(rows["branch"] == "unloading", 1.0, 0.1)
                      * history * (250 - history) / 250**2),
            "plate_compliance": ("curve", up, (experiment == "blocked_force") * (up / 250) ** 3),
        }  # fmt: skip
        for name, (way, place, shape) in shapes.items():
            for form, each in enumerate(few()[name].forms):
                sizes = np.array([part + 0.1 * part**2 for part in each.parts])
                values = 0.1 * scale * (1 + 0.2 * form) * sizes[:, None] * shape[None, :]
                changes[name, form, experiment] = Change(way, place, each.parts, {column: values})
    return Catalogue(PROTOCOLS[protocol], Library(base, changes), few())


def case(catalogue: Catalogue, *hidden: Hidden, kind: cases.Kind = "one", seed: int = 3) -> Case:
    truth = Truth(hidden, {"modulus": 0.4, "pressure_offset": -0.5, "wall": 1.1})
    return Case("development", 0, catalogue.protocol.name, kind, False, truth, (seed,))


def test_the_plan_is_that_of_the_seed() -> None:
    halves = {half: cases.plan(half) for half in cases.HALVES}
    again = cases.plan("development")
    pd.testing.assert_frame_equal(cases.table_of(halves["development"]), cases.table_of(again))
    every = [each for half in halves.values() for each in half]
    assert len(every) >= 200
    assert sum(each.full for each in every) >= 40
    assert len({each.seed for each in every}) == len(every)
    for half in halves.values():
        counts = pd.Series([each.kind for each in half]).value_counts(normalize=True)
        assert counts.to_dict() == pytest.approx(dict(cases.SHARES))
        used = {each.protocol for each in half}
        assert used == set(FINGERS)
    kinds = {each.hidden[0] for each in every if each.kind == "outsider"}
    assert len(kinds) >= 4
    assert not kinds & set(generator.causes())


def test_a_longer_plan_begins_with_other_kinds_only() -> None:
    """What a case hides depends on its own number and kind, not on how many there are."""
    short, long = cases.plan("final", 20), cases.plan("final", 40)
    same = [(a, b) for a, b in zip(short, long, strict=False) if a.kind == b.kind]
    assert same
    for a, b in same:
        assert a == b


def test_strengths_are_within_what_is_simulated() -> None:
    rng = np.random.default_rng(1)
    for cause in generator.causes().values():
        for _ in range(20):
            form, strength = cause.draw(rng)
            low, high = cause.range()
            assert low <= strength <= high
            if cause.simulated:
                assert strength <= 1.2 * max(cause.forms[form].parts)
            # within the bounds of the effect's parameters
            cause.effect(**cause.values(form, strength))


def test_longer_protocols_begin_as_shorter_ones() -> None:
    for name in FINGERS:
        whole = PROTOCOLS[PROTOCOLS[name].history]
        for course in PROTOCOLS[name].courses:
            if course.experiment != "coupon":
                longer = whole.course(course.experiment).rows
                pd.testing.assert_frame_equal(course.rows, longer.iloc[: len(course.rows)])


def test_a_modulus_scales_and_a_regulator_shifts() -> None:
    """α(p; cμ) = α(p/c), F(p; cμ) = c F(p/c), against the curve itself."""
    catalogue = made_up()
    truth = Truth((), {"modulus": 1.0, "pressure_gain": 2.0, "pressure_offset": -1.0})
    bending, blocked = catalogue.readings(truth)
    c = np.exp(0.2)
    x = (1.03 * bending["pressure_kPa"] - 2) / c / 250
    np.testing.assert_allclose(bending["angle_deg"], 100 * (x + 0.3 * x**2), atol=1e-6)
    np.testing.assert_allclose(blocked["force_N"], c * 3 * (x + 0.3 * x**2), atol=1e-6)


def test_strengths_are_interpolated_through_nothing() -> None:
    """The changes here are quadratic in the strength, so that two simulations tell all."""
    catalogue = made_up()
    none = catalogue.vector(Truth())
    one, other = (
        catalogue.vector(Truth((Hidden("mooney_rivlin", 0, part),))) - none for part in (1.0, 0.3)
    )
    np.testing.assert_allclose(other, one * (0.3 + 0.1 * 0.09) / 1.1, atol=1e-9)
    assert np.abs(one).max() > 1


def test_a_history_differs_between_branches() -> None:
    catalogue = made_up()
    change = catalogue.vector(Truth((Hidden("prony", 0, 1.0),))) - catalogue.vector(Truth())
    index = noise.index(catalogue.protocol)
    at = (index["experiment"] == "bending") & (index["pressure_kPa"] == 125)
    loading, unloading = change[at]
    assert unloading == pytest.approx(10 * loading)


def test_noise_is_that_of_the_seed_and_has_the_covariance() -> None:
    protocol = PROTOCOLS["P2"]
    index = noise.index(protocol)
    matrix = noise_matrix(index, noise.by_channel(protocol, noise.Instruments()))
    seed = 11
    print("seed", seed)
    rng = np.random.default_rng(seed)
    draws = np.array([noise.draw(index, matrix, rng) for _ in range(4000)])
    # standard error of a covariance of 4000 draws: 1.4/√4000 of the variance; five of them
    std = np.sqrt(np.diag(matrix))
    got = np.cov(draws.T) / np.outer(std, std)
    np.testing.assert_allclose(got, matrix / np.outer(std, std), atol=0.11)
    angles = (index["channel"] == "angle_deg").to_numpy()
    np.testing.assert_allclose(std[angles], 0.3)
    one, two = (noise.draw(index, matrix, np.random.default_rng(seed)) for _ in range(2))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("protocol", ["P1", "P2", "P4"])
def test_files_are_valid_measured_data(protocol: str, tmp_path: Path) -> None:
    catalogue = made_up(protocol)
    hidden = case(catalogue, Hidden("prony", 1, 0.8))
    readings = cases.read(hidden, catalogue.vector(hidden.truth))
    measurement = read(
        [cases.write(hidden, readings, tmp_path)], generator.analysed(catalogue.protocol)
    )
    assert not measurement.warnings
    assert len(measurement.readings) == sum(len(c.rows) for c in catalogue.protocol.courses)
    value = measurement.listed()["value"].to_numpy()
    np.testing.assert_allclose(value, readings.value[readings.kept], rtol=1e-5)
    assert 0 < (~readings.kept).sum() < 0.3 * len(readings.kept)
    told = instrument_noise(measurement)
    angles = (measurement.listed()["column"] == "angle_deg").to_numpy()
    total = np.hypot(told.independent, told.correlated)[angles]
    np.testing.assert_allclose(total, 0.3, rtol=1e-4)
    assert measurement.tests[1].setup.sections["plate"] == {"gap_mm": 1.0}


def test_the_laboratory_may_be_wrong_about_noise() -> None:
    told = noise.Instruments(told_factor=1 / 1.5).told(("angle_deg",))
    total = np.hypot(told["angle_deg"], told["correlated"]["angle_deg"])
    assert total == pytest.approx(0.2, rel=1e-4)
    silent = noise.Instruments(told_correlated=False).told(("angle_deg",))
    assert silent == {"angle_deg": pytest.approx(0.3)}


def test_what_a_laboratory_knows_better_is_told_and_drawn() -> None:
    protocol = PROTOCOLS["short"]
    assert protocol.setup()["nuisance"] == {"pressure_offset_kPa": 0.2, "plate_gap_mm": 0.03}
    usual, known = (
        [cases.drawn_nuisances(np.random.default_rng(i), PROTOCOLS[name]) for i in range(5)]
        for name in ("P1", "short")
    )
    for name, part in (("pressure_offset", 0.1), ("plate_gap", 0.1), ("modulus", 1.0)):
        assert [k[name] for k in known] == pytest.approx([part * u[name] for u in usual])


def test_outsiders_change_what_they_say() -> None:
    rows = PROTOCOLS["P2"].course("bending").rows
    leak = outsiders.OUTSIDERS["opening_leak"].pressure
    assert leak is not None
    lost = rows["pressure_kPa"].to_numpy() - leak(rows, 1.0)
    assert lost[10] == pytest.approx(0.06 * 250)
    assert lost[5] == pytest.approx(0.06 * 250 / 8)
    stuck = outsiders.OUTSIDERS["backlash"].pressure
    assert stuck is not None
    off = stuck(rows, 1.0) - rows["pressure_kPa"].to_numpy()
    np.testing.assert_allclose(off[1:11], 4)
    np.testing.assert_allclose(off[11:-1], -4)


def test_outsiders_of_a_coupon() -> None:
    rows = PROTOCOLS["coupon"].course("coupon").rows
    travel = rows["displacement_mm"].to_numpy()
    names = ("jaw_slip", "sticky_cell", "twisted_coupon")
    shown = {}
    for name in names:
        displayed = outsiders.OUTSIDERS[name].displayed
        assert displayed is not None
        shown[name] = displayed(rows, {"force_N": travel}, 1.0)["force_N"]
        assert not displayed(PROTOCOLS["P2"].course("bending").rows, {}, 1.0)
    slipped = shown["jaw_slip"] / np.where(travel > 0, travel, 1.0)
    np.testing.assert_allclose(slipped[[12, 13, 20, 39]], [1.0, 0.94, 0.94, 0.94])
    lag = travel - shown["sticky_cell"]
    np.testing.assert_allclose(lag[[0, 1, 20, 21, 40]], [0.0, 0.1, 0.1, -0.1, -0.1])
    assert (shown["twisted_coupon"] - travel).max() == pytest.approx(0.15)
    for name in names:
        assert outsiders.possible(PROTOCOLS["coupon"], name)
        assert not outsiders.possible(PROTOCOLS["P2"], name)


def test_the_bound_names_what_is_strong_and_nothing_where_nothing_is() -> None:
    catalogue = made_up()
    exact = bound.Bound(catalogue)
    strong = case(catalogue, Hidden("mooney_rivlin", 0, 1.0))
    found = exact.attained(strong, cases.read(strong, catalogue.vector(strong.truth)))
    opinion = Opinion.of_verdict(found.verdict)
    assert (opinion.answer, opinion.named) == ("cause", (("mooney_rivlin",),))
    assert found.strengths_sigma[0] > 6
    assert found.cut > 0.5
    (strength,) = found.intervals
    assert strength.high - strength.low < 0.5
    none = case(catalogue, kind="none")
    nothing = exact.attained(none, cases.read(none, catalogue.vector(none.truth)))
    assert nothing.verdict.answer == "none"
    assert (nothing.strengths_sigma, nothing.unexplained_sigma) == ((), 0.0)


def test_what_a_cause_of_the_catalogue_explains_is_not_unexplained() -> None:
    catalogue = made_up()
    exact = bound.Bound(catalogue)
    kept = np.ones(len(exact.index), dtype=bool)
    analysis = exact.analysis(kept)
    own = analysis.covariance.whiten(exact.change([Hidden("mooney_rivlin", 0, 1.0)]))
    assert bound.unexplained(analysis, own) == pytest.approx(0, abs=1e-4)
    other = analysis.covariance.whiten(exact.change([Hidden("perspective", 0, 1.0)]))
    assert 0.5 < bound.unexplained(analysis, other) <= np.linalg.norm(other)


def judged(
    number: int, kind: str, hidden: tuple[str, ...], said: Opinion, **others: object
) -> Judged:
    first = Opinion("cause", 0.99, hidden, (hidden,)) if hidden else Opinion("none", 0.9, (), ())
    values = {
        "strengths_sigma": (14.0,) * len(hidden), "unexplained_sigma": 0.0, "bound": first,
        "name": f"case {number}", "protocol": "P7+", "full": False, **others,
    }  # fmt: skip
    return Judged(kind=kind, hidden=hidden, said=said, **values)  # type: ignore[arg-type]


def cause(*names: str, probability: float = 0.95) -> Opinion:
    return Opinion("cause", probability, names, (names,))


NOTHING = Opinion("none", 0.8, ("gent",), ())
UNKNOWN = Opinion("unknown", 0.8, ("gent",), ())


def of(cases: list[Judged]) -> dict[str, score.Figure]:
    return {figure.name: figure for figure in score.figures(cases)}


def test_figures_of_verdicts_by_hand() -> None:
    inside, outside = Interval("g", 0.1, 0.3, 0.2), Interval("g", 0.1, 0.3, 0.4)
    twins = Opinion("cause", 0.99, ("prony", "gent"), (("prony", "gent"),))
    every = [
        judged(0, "one", ("prony",), cause("prony"), intervals=(inside,), cut=0.6, bound_cut=0.7),
        judged(1, "one", ("prony",), cause("gent", "prony"), intervals=(outside,), bound=twins),
        judged(2, "one", ("gent",), cause("prony", probability=0.5), cut=0.5, bound_cut=0.1),
        judged(3, "one", ("gent",), NOTHING, strengths_sigma=(0.2,)),
        judged(4, "none", (), NOTHING),
        judged(5, "none", (), cause("gent")),
        judged(6, "outsider", ("tear",), UNKNOWN, unexplained_sigma=9.0),
        judged(7, "outsider", ("slip",), cause("gent"), unexplained_sigma=2.0),
        judged(8, "two", ("gent", "prony"), cause("gent", probability=0.91)),
    ]
    found = of(every)
    visible = found["class named first, visible single effects"]
    assert (visible.count, visible.value, visible.bound) == (3, pytest.approx(2 / 3), 1.0)
    assert visible.met is False
    assert found["class named first, invisible ones"].value == 1.0  # the class leads, unclaimed
    # a class that leads counts as first even where the answer is none or unknown
    assert found["answered with the hidden cause's class, visible single effects"].value == (
        pytest.approx(2 / 3)
    )
    strong = found["class named first on P7+, from 12 σ"]
    assert (strong.count, strong.met) == (3, False)
    assert found["class named first on P7+, 6 to 12 σ"].met is None
    assert found["claims with P ≥ 0.9"].value == pytest.approx(4 / 7)
    assert found["claims with P ≥ 0.9"].bound == pytest.approx(5 / 7)
    assert found["of these right"].value == pytest.approx(3 / 4)
    assert found["false alarms where there is no cause"].value == 0.5
    assert found["detection from 6 σ"].value == 1.0
    unknown = found["outsiders from 6 σ unexplained called unknown"]
    assert (unknown.count, unknown.value, unknown.met) == (1, 1.0, True)
    ties = found["ties not named by one member"]
    assert (ties.count, ties.met) == (1, True)
    assert found["90 % intervals that hold the truth"].value == 0.5
    cut = found["error on readings left out is cut by"]
    assert (cut.count, cut.value, cut.bound, cut.met) == (1, 0.6, 0.7, True)


def test_a_leading_class_that_is_not_answered_is_no_answer() -> None:
    shy = Opinion("unknown", 1.0, ("prony",), ())
    found = of([judged(0, "one", ("prony",), shy)])
    assert found["class named first, visible single effects"].value == 1.0
    answered = found["answered with the hidden cause's class, visible single effects"]
    assert (answered.value, answered.bound, answered.met) == (0.0, 1.0, False)


def test_intervals_of_shares() -> None:
    """Clopper and Pearson (1934): 0.05 = (1 − high)ⁿ of no hits, symmetric for all."""
    low, high = score.interval(0, 20)
    assert low == 0
    assert high == pytest.approx(1 - 0.05 ** (1 / 20))
    assert score.interval(20, 20) == (pytest.approx(1 - high), 1.0)


def test_a_kind_scorer_would_be_found_out() -> None:
    """Naming everything is right always, and with shuffled labels, too."""
    names = ("prony", "gent", "ogden", "mullins")
    all_of_them = [judged(i, "one", (names[i % 4],), cause(*names)) for i in range(40)]
    exact = [judged(i, "one", (names[i % 4],), cause(names[i % 4])) for i in range(40)]
    assert of(all_of_them)["class named first, labels shuffled"].met is False
    assert of(exact)["class named first, labels shuffled"].value == 0.0


def test_a_verdict_that_is_worse() -> None:
    before = ci.Answered("a", "prony", "cause", "prony", True)
    assert not before.worse_than(before)
    assert "told apart" in replace(before, named="gent or prony").worse_than(before)
    assert "is right" in replace(before, answer="none", named="", right=False).worse_than(before)
    assert not before.worse_than(replace(before, right=False))
    tied = replace(before, named="gent or prony")
    assert "the readings allow gent or prony" in before.worse_than(tied)


def test_every_kind_of_answer_is_among_the_committed_ones() -> None:
    committed = ci.expected()
    assert [each.case for each in committed] == [each.name for each in ci.cases()]
    assert len(committed) >= 12
    assert {each.answer for each in committed} == {"cause", "none", "unknown"}
    assert any(" + " in each.named for each in committed)
    assert any(" or " in each.named for each in committed)


def test_from_the_simulation_of_coupons_to_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All stages, twice: the second time nothing is computed."""
    every = ["library", "full", "cases", "diagnose", "score"]
    told = ["--only", "coupon", "--number", "6", "--quick", "--out", str(tmp_path)]
    assert stages.main([*every, *told]) == 0
    assert "6 cases" in capsys.readouterr().out
    folder = tmp_path / "score" / "coupon-development-quick"
    figures = pd.read_csv(folder / "figures.csv")
    rows = pd.read_csv(folder / "cases.csv")
    assert len(rows) == 6
    assert (folder / "confusion.png").stat().st_size > 1000
    assert figures.set_index("name").loc["detection from 6 σ", "value"] == 1.0
    wanted = library.entries("coupon")
    assert {entry.job.key for entry in wanted} == set(library.known(wanted, tmp_path / "library"))
    first = (folder / "figures.csv").read_bytes()
    assert stages.main([*every, *told]) == 0
    assert (folder / "figures.csv").read_bytes() == first


def test_what_is_asked_for_in_vain(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for told, complaint in (
        (["--only", "P9"], "--only P9: allowed: P1"),
        (["libary"], "libary: allowed: library"),
        (["--workers", "0"], "--workers 0: allowed: 1 or more"),
    ):
        with pytest.raises(SystemExit) as left:
            stages.parsed(told)
        assert left.value.code == 2
        assert complaint in capsys.readouterr().err
    assert stages.main(["cases", "--only", "P1", "--out", str(tmp_path)]) == 2
    assert "run the stage library first" in capsys.readouterr().out
