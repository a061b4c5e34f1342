"""The result of an experiment as an object: columns, pandas, plot, last row, derivatives, files."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

from dolfingrip import config, experiments
from dolfingrip.config import ConfigError
from dolfingrip.experiments import Result, run
from dolfingrip.files.result_file import ResultFileError

COUPON = {"coupon.max_strain": 0.2, "coupon.step_strain": 0.05}
PARAMETER = "material.mu_MPa"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A coupon's result with derivatives, in a folder given as text."""
    out = str(tmp_path_factory.mktemp("result") / "coupon")
    return run("coupon", config.load(None, COUPON), out=out, gradients=[PARAMETER])


def test_columns_and_rows(written: Result) -> None:
    assert len(written) == len(written.rows) > 2
    np.testing.assert_array_equal(written["force_N"], written.column("force_N"))
    assert set(written["branch"]) == {"loading"}
    assert "force_N" in written
    assert "angle_deg" not in written
    with pytest.raises(ConfigError, match=r"^column angle_deg: not in a result of coupon; allowed"):
        written["angle_deg"]
    table = written.to_pandas()
    assert table.shape == (len(written), len(list(written)))
    assert table["force_N"].iloc[-1] == written["force_N"][-1]


def test_it_shows_its_last_row(written: Result) -> None:
    first, last = repr(written).splitlines()
    assert first == f"<Result of coupon: {len(written)} readings, complete>"
    assert f"force_N {written['force_N'][-1]:.6g}" in last


def test_derivatives_are_a_table(written: Result) -> None:
    found = written.sensitivities
    assert found.parameters == (PARAMETER,)
    assert found.values.shape == (len(written), len(found.columns), 1)
    slopes = found["force_N", PARAMETER]
    assert slopes.tolist() == [e["derivative"] for e in found if e["column"] == "force_N"]
    # the force of a neo-Hookean bar grows by μ where the bulk modulus does
    assert (np.diff(slopes) > 0).all()
    assert found.to_pandas().loc[(len(written) - 1, "force_N"), PARAMETER] == slopes[-1]
    with pytest.raises(KeyError, match=r"no derivative of angle_deg by "):
        found["angle_deg", PARAMETER]


def test_it_is_read_from_its_folder(written: Result) -> None:
    assert written.folder is not None
    again = Result.read(str(written.folder))
    assert again.config == written.config
    assert again.facts == written.facts
    assert list(again) == list(again.to_pandas()) == list(written.to_pandas())
    for name in ("displacement_mm", "force_N"):
        np.testing.assert_allclose(again[name], written[name], rtol=1e-9)
    assert again["branch"].tolist() == written["branch"].tolist()
    np.testing.assert_allclose(
        again.sensitivities.values, written.sensitivities.values, rtol=1e-9, atol=1e-12
    )


def test_it_draws_itself(written: Result) -> None:
    mpl.use("agg")
    axes = written.plot()
    (line,) = axes.get_lines()
    name = "nominal_stress_MPa"
    np.testing.assert_array_equal(np.asarray(line.get_ydata()), written[name])
    assert axes.get_ylabel().endswith("(MPa)")


def test_results_on_the_same_axes_have_a_colour_and_a_label_each(written: Result) -> None:
    mpl.use("agg")
    assert written.folder is not None
    axes = written.plot(label="first")
    assert Result.read(written.folder).plot(axes, label="second") is axes
    first, second = axes.get_lines()
    assert first.get_color() != second.get_color()
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["first", "second"]
    assert [line.get_color() for line in legend.get_lines()] == [
        first.get_color(), second.get_color()
    ]  # fmt: skip


def test_a_folder_without_a_result_gets_one_line(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError) as caught:
        Result.read(tmp_path)
    assert str(caught.value) == f"{tmp_path / 'run.json'}: No such file or directory"


def test_the_package_shows_what_is_public() -> None:
    assert dir(experiments) == ["Result", "command_for", "pressures_kPa", "run"]
