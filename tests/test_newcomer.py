"""What somebody meets who uses the package for the first time: options, names, refusals."""

from __future__ import annotations

import io
import re
from pathlib import Path

import pytest
import typer
from rich.console import Console
from support import pages
from support.checkout import needs_checkout
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli import console as console_module
from dolfingrip.cli import diagnosis_commands, experiment_commands, progress, settings
from dolfingrip.cli.commands import app
from dolfingrip.cli.console import console
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.data import table
from dolfingrip.experiments.index import EXPERIMENTS, find
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.files.plan import AdditionWorth, EffectOutlook, PlanFile
from dolfingrip.report.table import of_columns
from dolfingrip.sections import protocol_file
from dolfingrip.sections.tables import assignments

ROOT = Path(__file__).resolve().parents[1]
COMMAND = typer.main.get_command(app)
PRESSURISED = ("bend", "force", "cycle", "push", "grasp")


@pytest.mark.parametrize("name", PRESSURISED)
def test_each_experiment_with_pressure_has_its_option(name: str) -> None:
    command = COMMAND.commands[name].entry.built()  # type: ignore[attr-defined]
    assert "--pressure" in {flag for option in command.params for flag in option.opts}


def test_a_protocol_has_its_own_pressures(tmp_path: Path) -> None:
    asked = ["bend", "--pressure", "100", "--protocol", "x.toml", "-o", str(tmp_path / "out")]
    found = CliRunner().invoke(app, asked)
    assert isinstance(found.exception, ConfigError)
    assert "--pressure 100: allowed: without --protocol" in str(found.exception)


@pytest.mark.parametrize(
    "given",
    [
        ["bend", "--video-length"],
        ["grasp", "--no-video", "--colour-by", "pressure", "--video-turn"],
    ],
)
def test_a_length_or_a_turn_needs_a_video(given: list[str], tmp_path: Path) -> None:
    found = CliRunner().invoke(app, [*given, "5", "-o", str(tmp_path / "out")])
    assert str(found.exception) == f"{given[-1]} 5: allowed: with --video"


@pytest.mark.parametrize(("colour", "cut"), [("pressure", True), ("stretch", False), (None, False)])
def test_pressure_is_shown_on_the_walls_that_it_acts_on(colour: str | None, cut: bool) -> None:
    """They are inside: without a cut a picture would have no colour of its scale."""
    asked = settings.of_experiment(EXPERIMENTS["bending"])(colour_by=colour)
    assert experiment_commands.wanted_pictures(asked).cut is cut


def test_a_coupon_has_no_pressure_to_show(tmp_path: Path) -> None:
    asked = ["coupon", "--video", "--colour-by", "pressure", "-o", str(tmp_path / "out")]
    found = CliRunner().invoke(app, asked)
    assert isinstance(found.exception, ConfigError)
    assert str(found.exception).startswith("--colour-by pressure: allowed: for fingers")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("command", "name"), [("bend", "bending"), ("force", "blocked_force")])
def test_an_experiment_is_found_by_either_name(command: str, name: str) -> None:
    assert find(command) is find(name) is EXPERIMENTS[name]
    assert f"In files and Python: {name}." in EXPERIMENTS[name].summary()
    with pytest.raises(ConfigError, match=rf"{name} \(or {command}\)"):
        find("bendign")


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_csv_with_another_separator_is_told_so(separator: str, tmp_path: Path) -> None:
    file = tmp_path / "measured.csv"
    names = ["time_s", "displacement_mm", "force_N"]
    rows = [["0", "0", "0"], ["1", "0,5", "0,12"], ["2", "1", "0,2"]]
    file.write_text("\n".join(separator.join(row) for row in [names, *rows]) + "\n")
    said = "its entries are separated by (semicolons|tabs); allowed: commas"
    with pytest.raises(ConfigError, match=said):
        coupons.read(file)
    with pytest.raises(ConfigError, match=said):
        protocol_file.read(file, "coupon", "displacement_mm")
    with pytest.raises(ConfigError, match=said):
        table.read(file, ["coupon"])


def test_a_plan_is_printed_as_tables_of_80_columns() -> None:
    effect = EffectOutlook(
        effect="temperature_drift", ordinary="", strength_sigma=12.3, named_from=None,
        named_from_sigma=None, class_from=None, share=0.5, class_share=0.75,
        confused_with=("mooney_rivlin", "base_layer_offset", "plate_compliance", "prony"),
    )  # fmt: skip
    addition = AdditionWorth(
        name="a coupon, loading and unloading", kind="coupon", minutes=12.0, share=0.625,
        gain_per_minute=-1e-9, lifts=("mooney_rivlin", "print_anisotropy"),
    )  # fmt: skip
    found = PlanFile(
        version="1", experiments=("bending",), readings=9, minutes=3.0, share=0.5,
        class_share=0.6, effects=(effect,), additions=(addition,),
    )  # fmt: skip
    console = Console(width=80, record=True, file=io.StringIO())
    for each in diagnosis_commands.tables(found):
        console.print(each)
    said = console.export_text()
    assert max(map(len, said.splitlines())) <= 80
    assert "…" not in said
    assert "|" not in said
    assert {"temperature_drift", "base_layer_offset,", "12.3", "+0.00", "0.62"} <= set(said.split())


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))])
def test_commands_run_as_copied(page: Path) -> None:
    """Outside of the environment there is no ``dolfingrip``."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    lines = [line for block in blocks for line in block.splitlines()]
    assert [line for line in lines if line.startswith("dolfingrip")] == []


def test_brackets_of_a_warning_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """``[film.NAME]`` is a table of a configuration, but markup to rich."""
    bending, settings = (
        EXPERIMENTS["bending"],
        config.load(None, assignments(["finger.kind=pneunet"])),
    )
    experiment_commands.warn(bending, settings, console())
    told = capsys.readouterr().out
    (note,) = bending.notes(settings)
    assert "[material.paper]" in note
    assert "[film." in note
    assert told == f"warning: {note}\n"


def test_what_looks_like_markup_is_printed_as_it_stands(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    text = "[red]a[/red] [film.NAME] [/] :x: \\[b]"
    screen = console()
    screen.print(text, style="red", soft_wrap=True)
    screen.print(of_columns({text: [text]}, title=text))
    terminal = Console(file=io.StringIO(), force_terminal=True, width=120, highlight=False)
    with progress.shown(terminal, text, total=1) as show:
        show(1, 1, text)
    assert isinstance(terminal.file, io.StringIO)
    assert capsys.readouterr().out.count(text) == 4  # line, title, heading, cell
    assert text in terminal.file.getvalue()


def test_results_are_printed_on_one_kind_of_console() -> None:
    """Elsewhere it would read markup."""
    package = Path(console_module.__file__).parents[1]
    made = [
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        if re.search(
            r"(?<!\w)(Console|Screen)\(|import print\b|\[/(red|yellow|green|bold|dim)\]",
            file.read_text(),
        )
    ]
    assert made == ["cli/console.py"]


def test_an_effect_is_described_without_markup() -> None:
    said = CliRunner().invoke(app, ["extensions", "prony"]).output
    assert "material.mu_MPa is the" in said
    assert "``" not in said
    assert ":mod:" not in said


ANSWERS = list(pages.blocks(ROOT / "docs" / "five_answers.md"))
MADE = (
    ("out/picture/strip.png", "out/picture/curve.png"),
    ("out/video/video.mp4", "out/video/video.gif"),
    ("out/finger.stl",),
    ("out/verdict/summary.md",),
    ("out/my_law/result.csv",),
)
"""Files that each answer leaves."""


def test_each_answer_is_short_and_on_one_page() -> None:
    """Three commands and twelve typed lines at most."""
    assert len(ANSWERS) == len(MADE)
    for each in ANSWERS:
        print(each.heading, len(each.commands), len(each.typed))
        assert len(each.commands) <= 3
        assert len(each.typed) <= 12


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty clone, which all answers are copied into."""
    return pages.clone(tmp_path_factory.mktemp("clone"))


@needs_checkout
@pytest.mark.parametrize(
    ("answer", "made"),
    list(zip(ANSWERS, MADE, strict=True)),
    ids=[each.heading for each in ANSWERS],
)
def test_an_answer_is_had_by_copying_it(
    answer: pages.Block, made: tuple[str, ...], clone: Path
) -> None:
    """Blocks run as they stand on the page, with the sizes that their marker names."""
    pages.run(answer.reduced(), clone)
    for name in made:
        assert (clone / name).stat().st_size > 100
