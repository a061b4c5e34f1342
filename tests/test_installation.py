"""What is said where something is not installed, and that the installed package is imported."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import typer
from support.checkout import needs_checkout

import dolfingrip
from dolfingrip.cli import edge
from dolfingrip.cli.installation import extras, how_to_install
from dolfingrip.cli.settings import DoctorSettings

ROOT = Path(__file__).resolve().parents[1]
MODULES = {
    "surrogate": ["torch"],
    "cluster": ["dask", "distributed", "dask_jobqueue"],
    "explore": ["starlette", "uvicorn", "websockets"],
    "video": ["av"],
    "pdf": ["playwright"],
}
"""What each extra lets import."""


@pytest.mark.parametrize(
    ("extra", "module"), [(extra, name) for extra, names in MODULES.items() for name in names]
)
def test_a_missing_extra_is_named_with_the_line_that_installs_it(extra: str, module: str) -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = " ".join(sorted(listed["optional-dependencies"][extra]))
    said = how_to_install(module)
    assert " ".join(sorted(extras()[extra])) == names
    for name in names.split():
        assert f" {name}" in said
    assert said.startswith(f"{module} is missing; install it by: pip install ")
    assert said.endswith(f"(dolfingrip's extra {extra})")


def test_what_is_always_needed_has_a_line_and_other_modules_none() -> None:
    assert how_to_install("PIL") == "PIL is missing; install it by: pip install pillow"
    assert how_to_install("nobody_s_module") == ""


HIDING = """
import sys

class Hiding:
    def __init__(self, finder):
        self.finder = finder
    def __getattr__(self, name):
        return getattr(self.finder, name)
    def find_spec(self, name, path=None, target=None):
        hidden = name.partition(".")[0] in {missing!r}
        return None if hidden else self.finder.find_spec(name, path, target)

sys.meta_path[:] = [Hiding(each) for each in sys.meta_path]
"""
"""Finds some packages nowhere. With None in their place SciPy would take torch for imported."""

WITHOUT = """
sys.argv = ["dolfingrip", *{arguments!r}]
from dolfingrip.cli.app import main
main()
"""
FENICS = ["mpi4py", "dolfinx", "petsc4py", "ufl", "basix", "ffcx"]


def without(missing: list[str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command in a Python that lacks some packages."""
    code = HIDING.format(missing=missing) + WITHOUT.format(arguments=arguments)
    alone = {key: value for key, value in os.environ.items() if key not in edge.LAUNCHED}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=alone
    )


@pytest.mark.parametrize("command", ["bend", "mesh", "diagnose"])
def test_without_dolfinx_a_command_says_two_lines_that_install_one(command: str) -> None:
    ended = without(FENICS, command, *(["nothing.csv"] if command == "diagnose" else []))
    assert ended.returncode == 1
    first, *lines = ended.stderr.splitlines()
    assert first == "dolfingrip: DOLFINx is missing; install it by one of these two lines:"
    assert [line.split()[:2] for line in lines] == [["pip", "install"], ["conda", "install"]]


EXTRAS = [name for names in MODULES.values() for name in names]
IMPORTED = """
from dolfingrip.cli.commands import COMMANDS
for each in (below for one in COMMANDS for below in (one, *one.below)):
    try:
        each.function()
    except ModuleNotFoundError as error:
        print(each.name, error.name)
"""


def test_the_explorer_alone_needs_an_extra_to_begin() -> None:
    """What an extra brings is imported where it is used."""
    code = HIDING.format(missing=EXTRAS) + IMPORTED
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"explore (starlette|uvicorn)\S*\n", ended.stdout)


@pytest.mark.parametrize(
    ("command", "missing", "extra"),
    [
        (["reproduce", "{root}/examples/paper_study.toml"], "torch", "surrogate"),
        (
            ["doe", "--parameter", "finger.wall_mm=1:2:2", "--workers", "2"],
            "distributed",
            "cluster",
        ),
        (["explore", "nowhere"], "uvicorn", "explore"),
    ],
)
def test_a_command_that_needs_an_extra_says_the_line_that_installs_it(
    command: list[str], missing: str, extra: str, tmp_path: Path
) -> None:
    words = [word.format(root=ROOT) for word in command]
    ended = without([missing], *words, "--out", str(tmp_path / "out"))
    assert ended.returncode == 1
    (said,) = ended.stderr.splitlines()
    assert f"{missing} is missing; install it by: pip install " in said
    assert said.endswith(f"(dolfingrip's extra {extra})")
    assert not (tmp_path / "out").exists()  # it is told before any work


@pytest.mark.slow
def test_one_process_computes_designs_without_dask(tmp_path: Path) -> None:
    small = ["--set", "finger.bellows=2", "--set", "finger.length_mm=38", "--set",
             "mesh.size_mm=8", "--set", "mesh.edge_size_mm=8"]  # fmt: skip
    load = ["--set", "experiment.max_pressure_kPa=10", "--set", "experiment.step_kPa=10"]
    out = tmp_path / "out"
    ended = without(
        ["distributed", "dask"], "doe", "--parameter", "finger.wall_mm=1.4:1.8:2", *small, *load,
        "--out", str(out),
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert "2 designs: 2 computed now, 2 done, 0 failed" in ended.stdout


def test_a_pdf_without_a_browser_is_refused_before_the_page_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from dolfingrip.cli.commands import app
    from dolfingrip.report.page import pdf

    monkeypatch.setattr(pdf, "chromium", lambda: None)
    out = tmp_path / "report.html"
    said = CliRunner().invoke(app, ["report", str(tmp_path), "-o", str(out), "--pdf"])
    assert str(said.exception).startswith(f"--pdf {tmp_path / 'report.pdf'}: allowed: ")
    assert not out.exists()


def test_the_extra_all_has_every_extra_that_commands_use() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    every = listed["optional-dependencies"]
    (line,) = every["all"]
    names = line.removeprefix("dolfingrip[").removesuffix("]").split(",")
    assert set(names) == set(every) - {"all", "dolfinx", "docs", "test"}


def test_a_grasp_without_pyav_has_all_but_the_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from dolfingrip.report import video

    monkeypatch.setitem(sys.modules, "av", None)
    (written,) = video.write(tmp_path / "grasp", [np.zeros((8, 8, 3), np.uint8)])
    assert written == tmp_path / "grasp.gif"
    assert "pip install av" in caplog.text


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The doctor looks at no environment: that of this machine takes seconds to measure."""
    monkeypatch.setenv("DOLFINGRIP_CACHE", str(tmp_path))


@pytest.mark.usefixtures("empty_cache")
def test_without_dolfinx_the_help_and_the_doctor_work() -> None:
    assert without(FENICS, "--help").returncode == 0
    ended = without(FENICS, "doctor")
    assert "DOLFINx     missing" in ended.stdout
    assert "pip install dolfinx-solver-real" in ended.stdout
    assert (ended.returncode, ended.stderr) == (1, "")


@pytest.mark.usefixtures("empty_cache")
def test_the_doctor_says_what_is_there(capfd: pytest.CaptureFixture[str]) -> None:
    from dolfinx import __version__

    from dolfingrip.cli.doctor_command import doctor

    doctor(DoctorSettings())
    said = dict(line.split(maxsplit=1) for line in capfd.readouterr().out.splitlines())
    assert said["DOLFINx"].startswith(f"{__version__}, PETSc ")
    assert said["factors"].startswith(("CHOLMOD, ", "MUMPS; "))
    assert said["contact"].endswith(", works on this processor")
    assert Path(said["Python.h"]).is_file()
    assert said["threads"].startswith("1 ")
    assert said.get("scripts/run", "--forget would free 0 MB") == "--forget would free 0 MB"
    assert {f"[{extra}]" for extra in MODULES} <= set(said)


@pytest.mark.usefixtures("empty_cache")
def test_a_missing_compiler_is_told(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from dolfingrip.cli.doctor_command import doctor

    monkeypatch.setenv("CC", "no-such-compiler -O1")
    with pytest.raises(typer.Exit):
        doctor(DoctorSettings())
    assert "\ncompiler    missing (no-such-compiler): " in capfd.readouterr().out


@pytest.mark.usefixtures("empty_cache")
def test_a_library_that_crashes_on_this_processor_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """As the wheel of ipctk 1.6.1 does without AVX-512."""
    from dolfingrip.cli.doctor_command import doctor

    crash = "import os, signal\nos.kill(os.getpid(), signal.SIGILL)\n"
    (tmp_path / "ipctk.py").write_text(crash, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(typer.Exit):
        doctor(DoctorSettings())
    said = dict(line.split(maxsplit=1) for line in capfd.readouterr().out.splitlines())
    assert said["contact"].startswith("missing: ipctk ")
    assert "crashes on this processor (SIGILL)" in said["contact"]


def test_a_script_beside_a_clone_imports_the_installed_package(tmp_path: Path) -> None:
    """Python takes any folder beside the script for a package."""
    (tmp_path / "dolfingrip").symlink_to(ROOT)
    script = tmp_path / "script.py"
    script.write_text("import dolfingrip.forms\nprint(dolfingrip.__version__)\n", encoding="utf-8")
    alone = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    ended = subprocess.run(
        [sys.executable, script],
        cwd=tmp_path,
        env=alone,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, "")


CONDA = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base", "torch": "pytorch"}
"""Names of distributions that conda-forge calls otherwise."""


@pytest.mark.parametrize(
    ("file", "with_extras"),
    [("environment.yml", ["cluster", "surrogate", "explore", "video"]),
     ("packaging/conda/recipe.yaml", [])],
)  # fmt: skip
def test_conda_s_files_list_all_dependencies(file: str, with_extras: list[str]) -> None:
    lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
    listed = {line.split()[1] for line in lines if line.strip().startswith("- ")}
    needed = [name for extra in ("", *with_extras) for name in extras()[extra]]
    assert {CONDA.get(name, name) for name in needed} <= listed
    assert "fenics-dolfinx" in listed


def test_files_that_repeat_the_version_have_that_of_the_package() -> None:
    version = dolfingrip.__version__
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    recipe = (ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^## \[(\d\S*)\]", changelog, re.M)[0] == version
    assert f'  version: "{version}"' in recipe.splitlines()
    assert re.findall(r"^version: (.*)$", citation, re.M) == [version]


@needs_checkout
def test_a_wheel_is_built_without_git_and_has_the_version(tmp_path: Path) -> None:
    source = tmp_path / "source"
    leave_out = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in ("dolfingrip", "forms", "meshes"):
        shutil.copytree(ROOT / name, source / name, ignore=leave_out)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    code = f"from setuptools.build_meta import build_wheel; build_wheel({str(tmp_path)!r})"
    # no git is on the path, and nothing is above the folder
    alone = {**os.environ, "PATH": "", "GIT_CEILING_DIRECTORIES": str(tmp_path)}
    command = [sys.executable, "-c", code]
    subprocess.run(command, cwd=source, env=alone, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.split("-")[1] == dolfingrip.__version__


@needs_checkout
def test_every_package_is_in_the_wheel() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = settings["tool"]["setuptools"]["packages"]
    files = [file.relative_to(ROOT) for file in ROOT.glob("*/**/__init__.py")]
    rooms = {"dolfingrip": (), "forms": ("dolfingrip",), "meshes": ("dolfingrip",)}
    here = [
        ".".join([*rooms[file.parts[0]], *file.parent.parts])
        for file in files
        if file.parts[0] in rooms
    ]
    assert sorted(here) == sorted(listed)
