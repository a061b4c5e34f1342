"""The surrogate: it fits, repeats, warns outside its range, and runs no code when it is read."""

from __future__ import annotations

import hashlib
import json
import math
import pickle
import random
import warnings
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
from support import stand_in
from tools.fuzz import damaged

from dolfingrip.config import ConfigError
from dolfingrip.design.surrogate import surrogate, table
from dolfingrip.design.surrogate.surrogate import OutsideRange, load
from dolfingrip.design.surrogate.training import Training, TrainingSettings, split, train
from dolfingrip.files.surrogate import SurrogateFile

torch = pytest.importorskip("torch", reason="the extra surrogate brings it")

INPUTS, OUTPUTS = ("morph.xi1", "morph.xi2"), ("cog_offset_mm", "force_N")
BRIEF = TrainingSettings(epochs=20)


@pytest.mark.slow
def test_the_papers_network_reaches_the_papers_error(training: Training) -> None:
    assert training.surrogate.facts.layers == (2, 20, 50, 2)
    assert training.curve[-1]["epoch"] == 5000
    # the paper: below 0.001; smooth data without noise give some 1e-6
    assert training.curve[-1]["training_mse"] < 1e-4
    assert training.curve[-1]["test_mse"] < 1e-4
    assert training.curve[0]["training_mse"] > 1e-2
    facts = training.surrogate.facts
    assert (facts.training_designs, facts.test_designs) == (166, 42)


def test_reported_error_is_that_of_the_predictions(training: Training) -> None:
    data, model = stand_in.table(), training.surrogate
    miss = model.predict(data.inputs) - data.outputs
    normalised = miss / (model.outputs.high - model.outputs.low)
    assert np.mean(normalised[training.test] ** 2) == pytest.approx(training.curve[-1]["test_mse"])
    assert np.mean(normalised[~training.test] ** 2) == pytest.approx(
        training.curve[-1]["training_mse"]
    )
    force = np.sqrt(np.mean(miss[training.test, 1] ** 2))
    assert model.facts.rms_error["force_N"].test == pytest.approx(force)


def test_a_seed_repeats_and_leaves_the_callers_random_numbers() -> None:
    torch.manual_seed(7)
    expected = torch.rand(1)
    torch.manual_seed(7)
    first = train(stand_in.table(), BRIEF).surrogate
    assert torch.rand(1) == expected
    assert first.sha256() == train(stand_in.table(), BRIEF).surrogate.sha256()
    other = TrainingSettings(epochs=20, seed=1)
    assert first.sha256() != train(stand_in.table(), other).surrogate.sha256()


def test_a_fifth_is_held_out() -> None:
    held_out = split(208, 0.2, seed=3)
    assert held_out.sum() == 42
    assert not (held_out == split(208, 0.2, seed=4)).all()


def test_saved_and_loaded_predictions_agree(training: Training, surrogate_folder: Path) -> None:
    again = load(surrogate_folder)
    xi = stand_in.designs()
    np.testing.assert_array_equal(again.predict(xi), training.surrogate.predict(xi))
    assert again.sha256() == training.surrogate.sha256()
    written = again.facts.model_copy(update={"weights_sha256": ""})
    assert written.plain() == training.surrogate.facts.plain()


def test_outside_the_range_it_warns(training: Training) -> None:
    model = training.surrogate
    with pytest.warns(OutsideRange, match=r"^morph\.xi1 = 1\.2: .* from -0\.2 to 1 \(1 of 2"):
        model.predict(np.array([[0.0, 0.0], [1.2, 0.0]]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.predict(np.array([[-0.2, -0.5], [1.0, 1.0]]))  # the range's corners are in it


class _Malice:
    """An object whose unpickling makes a file."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return _make, (str(self.file),)


def _make(file: str) -> None:
    Path(file).touch()


@pytest.mark.parametrize("how", ["torch", "pickle"])
def test_code_in_the_weights_is_refused(how: str, surrogate_folder: Path, tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    weights = tmp_path / surrogate.WEIGHTS
    if how == "torch":
        torch.save({"0.weight": _Malice(trace)}, weights)
    else:
        weights.write_bytes(pickle.dumps(_Malice(trace), protocol=2))
    _describe(surrogate_folder, tmp_path)
    with pytest.raises(ConfigError, match="not the weights of this network alone"):
        load(tmp_path)
    assert not trace.exists()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_weights_that_are_no_finite_numbers_are_refused(
    value: float, surrogate_folder: Path, tmp_path: Path
) -> None:
    weights = torch.load(surrogate_folder / surrogate.WEIGHTS, weights_only=True)
    weights["0.bias"][1] = value
    torch.save(weights, tmp_path / surrogate.WEIGHTS)
    _describe(surrogate_folder, tmp_path)
    with pytest.raises(ConfigError, match=r"surrogate\.pt: weights that are no finite numbers"):
        load(tmp_path)


def test_finite_weights_that_give_no_finite_output(surrogate_folder: Path, tmp_path: Path) -> None:
    weights = torch.load(surrogate_folder / surrogate.WEIGHTS, weights_only=True)
    last = max((n for n in weights if n.endswith("weight")), key=lambda n: int(n.split(".")[0]))
    weights[last][:] = 1e308
    torch.save(weights, tmp_path / surrogate.WEIGHTS)
    _describe(surrogate_folder, tmp_path)
    corner = np.array([[0.5, 0.5]])
    with pytest.raises(ConfigError, match="gives no finite numbers"):
        load(tmp_path).predict(corner, warn=False)


def test_damaged_weights_are_refused_in_one_line(surrogate_folder: Path, tmp_path: Path) -> None:
    """With a matching sum: whoever damages them can write it, too."""
    seed = 76
    print("seed", seed)
    good = (surrogate_folder / surrogate.WEIGHTS).read_bytes()
    weights = tmp_path / surrogate.WEIGHTS
    refused = 0
    for number in range(300):
        weights.write_bytes(damaged(good, random.Random(seed + number)))
        _describe(surrogate_folder, tmp_path)
        try:
            net = load(tmp_path).net
        except ConfigError as error:
            refused += "\n" not in str(error)
        else:
            assert all(each.isfinite().all() for each in net.parameters()), number
    assert refused > 100


@pytest.mark.parametrize("how", ["layers", "compressed"])
def test_a_small_file_takes_no_large_memory(
    how: str, surrogate_folder: Path, tmp_path: Path
) -> None:
    good, weights = surrogate_folder / surrogate.WEIGHTS, tmp_path / surrogate.WEIGHTS
    with ZipFile(good) as packed, ZipFile(weights, "w", ZIP_DEFLATED) as made:
        for part in packed.infolist():
            made.writestr(part.filename, packed.read(part))
        if how == "compressed":
            made.writestr("archive/data/99", bytes(50_000_000))
    _describe(surrogate_folder, tmp_path)
    if how == "layers":
        file = tmp_path / SurrogateFile.FILE
        facts = json.loads(file.read_text())
        facts["layers"] = [facts["layers"][0], 10**9, facts["layers"][-1]]
        file.write_text(json.dumps(facts))
    with pytest.raises(ConfigError, match="not the weights of this network alone"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [("inputs", math.nan), ("outputs", math.inf), ("layers", -3), ("layers", 0)],
)
def test_a_description_has_finite_ranges_and_layers(
    key: str, value: float, surrogate_folder: Path, tmp_path: Path
) -> None:
    facts = json.loads((surrogate_folder / SurrogateFile.FILE).read_text())
    if key == "layers":
        facts["layers"][1] = value
    else:
        next(iter(facts[key].values()))[0] = value
    (tmp_path / SurrogateFile.FILE).write_text(json.dumps(facts))
    (tmp_path / surrogate.WEIGHTS).write_bytes(b"")
    with pytest.raises(ConfigError, match=rf"surrogate\.json: {key}\.") as refused:
        load(tmp_path)
    assert "\n" not in str(refused.value)


def _describe(good: Path, folder: Path) -> None:
    """A description that vouches for whatever weights are in the folder."""
    description = json.loads((good / SurrogateFile.FILE).read_text())
    description["weights_sha256"] = _sha256(folder / surrogate.WEIGHTS)
    (folder / SurrogateFile.FILE).write_text(json.dumps(description))


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def test_what_is_no_surrogate_is_refused_in_one_line(
    surrogate_folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match="No such file or directory; allowed: a surrogate"):
        load(tmp_path)
    description = tmp_path / SurrogateFile.FILE
    weights = tmp_path / surrogate.WEIGHTS
    weights.write_bytes((surrogate_folder / surrogate.WEIGHTS).read_bytes())
    for text, complaint in (
        ("{", "not JSON"),
        ("[]", "no JSON object"),
        ('{"schema_version": 2}', "schema_version = 2; allowed: 1"),
        ("{}", "inputs: Field required"),
    ):
        description.write_text(text)
        with pytest.raises(ConfigError, match=complaint):
            load(tmp_path)
    good = (surrogate_folder / SurrogateFile.FILE).read_text()
    description.write_text(good)
    weights.write_bytes(weights.read_bytes() + b" ")
    with pytest.raises(ConfigError, match=r"not the weights that surrogate\.json was written for"):
        load(tmp_path)


def test_failed_designs_are_dropped_and_counted(tmp_path: Path) -> None:
    file = stand_in.write_csv(tmp_path / "designs.csv", failed=5)
    found = table.read(file, INPUTS, OUTPUTS)
    assert (len(found), found.failed, found.incomplete) == (203, 5, 0)
    assert found.outputs.max() < 20  # the failed ones' 999 N are not among them
    lines = file.read_text().splitlines()
    cut = lines[-1].split(",")
    cut[3] = ""
    file.write_text("\n".join([*lines[:-1], ",".join(cut)]))
    found = table.read(file, INPUTS, OUTPUTS)
    assert (len(found), found.failed, found.incomplete) == (202, 5, 1)


def test_parquet_and_csv_are_the_same_table(tmp_path: Path) -> None:
    import pyarrow.csv
    import pyarrow.parquet

    file = stand_in.write_csv(tmp_path / "designs.csv", failed=2)
    pyarrow.parquet.write_table(pyarrow.csv.read_csv(file), tmp_path / "designs.parquet")
    assert (
        table.read(file, INPUTS, OUTPUTS).sha256()
        == table.read(tmp_path / "designs.parquet", INPUTS, OUTPUTS).sha256()
    )


def test_bad_tables_are_refused_in_one_line(tmp_path: Path) -> None:
    file = stand_in.write_csv(tmp_path / "designs.csv")
    with pytest.raises(ConfigError, match=r"no column mass_g; allowed: morph\.xi1, morph\.xi2, "):
        table.read(file, INPUTS, ["mass_g"])
    with pytest.raises(ConfigError, match="column status holds text; allowed: numbers"):
        table.read(file, INPUTS, ["status"])
    with pytest.raises(ConfigError, match=r"no\.csv: No such file"):
        table.read(tmp_path / "no.csv", INPUTS, OUTPUTS)
    with pytest.raises(ConfigError, match=r"allowed: .*\.csv"):
        table.read(tmp_path / "designs.xlsx", INPUTS, OUTPUTS)
    few = table.read(file, INPUTS, OUTPUTS)
    small = table.Table(few.input_names, few.output_names, few.inputs[:3], few.outputs[:3])
    with pytest.raises(ConfigError, match="3 computed designs; allowed: at least 10"):
        train(small)


def test_outputs_are_normalised_by_the_training_designs_alone() -> None:
    """Where the greatest force is held out, the range ends below it."""
    data = stand_in.table()
    seed = next(s for s in range(99) if split(len(data), 0.2, s)[data.outputs[:, 1].argmax()])
    found = train(data, TrainingSettings(epochs=1, seed=seed))
    known = data.outputs[~found.test]
    np.testing.assert_array_equal(found.surrogate.outputs.low, known.min(axis=0))
    np.testing.assert_array_equal(found.surrogate.outputs.high, known.max(axis=0))
    assert found.surrogate.outputs.high[1] < data.outputs[:, 1].max()
    np.testing.assert_array_equal(found.surrogate.inputs.high, data.inputs.max(axis=0))
