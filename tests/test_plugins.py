"""Things of a user's own from files outside the package: taken, refused, kept apart in stores."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from support.checkout import needs_checkout

from dolfingrip import plugins
from dolfingrip.jobs.job import MACHINE, Job
from dolfingrip.jobs.work import compute
from dolfingrip.plugins import VARIABLE, PluginError

MADE_UP = Path(__file__).parent / "additions"
LAW, EFFECT = MADE_UP / "stiffening.py", MADE_UP / "force_square.py"

pytestmark = needs_checkout


def python(code: str, folder: Path) -> list[str]:
    """Lines that code prints in a process of its own, whose last lines are those of an error."""
    environment = {k: v for k, v in os.environ.items() if k != VARIABLE}
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=folder, env=environment, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    return [*ended.stdout.splitlines(), *ended.stderr.splitlines()[-1:]]


def command(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """What a command of its own process says."""
    environment = {**os.environ, "COLUMNS": "200"}
    environment.pop(VARIABLE, None)
    return subprocess.run(
        [sys.executable, "-P", "-m", "dolfingrip", *map(str, arguments)],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


KEYS = """
import dolfingrip
{before}
from dolfingrip.config import changed, load
from dolfingrip.experiments.request import Request
print(Request.of("coupon", load()).key)
print(Request.of("coupon", load(None, {change})).key)
"""


def keys(path: Path | None, folder: Path, change: dict[str, object]) -> list[str]:
    """Keys of a stored simulation of the default material, and of one with a change."""
    before = "" if path is None else f"dolfingrip.plugin({str(path)!r})"
    return python(KEYS.format(before=before, change=change), folder)


def test_another_digest_is_another_job(tmp_path: Path) -> None:
    """Simulations that do not use the plugin keep their keys."""
    law = {"material.law": "stiffening"}
    copy = tmp_path / LAW.name
    copy.write_bytes(LAW.read_bytes())
    first = keys(copy, tmp_path, law)
    assert keys(copy, tmp_path, law) == first
    copy.write_bytes(LAW.read_bytes() + b"\n# another digest\n")
    second = keys(copy, tmp_path, law)
    assert first[0] == second[0] == keys(None, tmp_path, {})[0]
    assert len({*first, *second}) == 3


def test_an_effect_is_tried_in_a_diagnosis(tmp_path: Path) -> None:
    code = (
        "import dolfingrip\n"
        f"dolfingrip.plugin({str(EFFECT)!r})\n"
        "from dolfingrip.config import Config\n"
        "from dolfingrip.diagnosis.core.unknown import causes\n"
        "print([each.name for each in causes(Config()) if each.name == 'force_square'])\n"
        "import pickle\n"
        "from dolfingrip.extensions.index import effect\n"
        "print(pickle.loads(pickle.dumps(effect('force_square')())))"
    )
    assert python(code, tmp_path) == ["['force_square']", "square_per_N=0.1"]


def test_a_run_tells_its_plugins(tmp_path: Path) -> None:
    short = ("--set", "coupon.max_strain=0.1", "--set", "coupon.step_strain=0.1")
    ended = command(
        tmp_path, "coupon", "--plugin", LAW, *short, "--set", "material.law=stiffening",
        "--out", "out", f"--plugin={EFFECT}",
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    told = json.loads((tmp_path / "out" / "run.json").read_text(encoding="utf-8"))
    assert {each["path"]: each["digest"] for each in told["plugins"]} == {
        str(file): plugins.Plugin("", str(file)).digest for file in (LAW, EFFECT)
    }
    again = command(tmp_path, "coupon", "--config", "out/run.json", "--out", "again")
    assert again.returncode == 2
    assert again.stderr.endswith("or one of your own, by --plugin stiffening.py\n")


def test_one_of_each_kind_is_taken_from_the_command_line(tmp_path: Path) -> None:
    """Nothing is loaded before ``--plugin`` is read, by which each kind joins its index."""
    files = [*MADE_UP.glob("*.py"), MADE_UP.parent / "added_channel" / "narrowing.py"]
    ended = command(tmp_path, "--help", *(f"--plugin={file}" for file in files))
    assert ended.returncode == 0, ended.stderr
    assert "Pull the material by a tenth" in ended.stdout


@pytest.mark.parametrize(
    ("key", "missing"),
    [
        ("material.law=my-law", "my_law.py"),
        ("extensions.my_effect.a=1", "my_effect.py"),
        ("finger.kind=my_geometry", "my_geometry.py"),
        ("food.kind=my-food", "my_food.py"),
        ("food.kind=2 eggs", "FILE.py"),
    ],
)
def test_a_refusal_tells_which_plugin_is_missing(key: str, missing: str, tmp_path: Path) -> None:
    ended = command(tmp_path, "config", "--set", key)
    assert ended.returncode == 2
    assert ended.stderr.endswith(f"or one of your own, by --plugin {missing}\n")


BAD = {
    "syntax.py": ("a = (", "line 1: '(' was never closed"),
    "nothing.py": ("import json", "allowed: a file that imports from one of"),
    "two words.py": (LAW.read_text(encoding="utf-8"), "no name of Python"),
    "gent.py": (EFFECT.read_text(encoding="utf-8"), "gent is taken; allowed: another name"),
    "fails.py": ("from dolfingrip.extensions.effect import Effect\n\n1 / 0", "line 3: ZeroDiv"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_plugin_is_one_line(name: str, tmp_path: Path) -> None:
    text, why = BAD[name]
    (tmp_path / name).write_text(text, encoding="utf-8")
    ended = command(tmp_path, "config", "--plugin", name)
    assert ended.returncode == 2
    assert ended.stderr.startswith("dolfingrip: --plugin ")
    assert ended.stderr.count("\n") == 1
    assert why in ended.stderr


def test_a_plugin_that_comes_too_late_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    import_module("dolfingrip.config")  # which is made of all laws that there are
    monkeypatch.setenv(VARIABLE, "")
    with pytest.raises(PluginError, match="laws are loaded; allowed: dolfingrip"):
        plugins.add(LAW)


def test_a_worker_without_the_plugin_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """This process has its configuration; another one could compute the job."""
    monkeypatch.setenv(VARIABLE, "")
    answer = compute(Job("key", "os:getcwd", {}, plugins={str(LAW): "digest"}))
    assert (answer.status, answer.failure_class) == ("broken", MACHINE)
    monkeypatch.setenv(VARIABLE, str(LAW))
    answer = compute(Job("key", "os:getcwd", {}, plugins={str(LAW): "digest"}))
    assert answer.failure == f"--plugin {LAW}: changed since; allowed: the same command, anew"


def test_an_installed_package_adds_by_entry_points(tmp_path: Path) -> None:
    facts = tmp_path / "rubber-1.2.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: rubber\nVersion: 1.2\n")
    (facts / "entry_points.txt").write_text("[dolfingrip.laws]\nstiffening = rubber.stiffening\n")
    package = tmp_path / "rubber"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "stiffening.py").write_bytes(LAW.read_bytes())
    code = (
        f"import sys\nsys.path.insert(0, {str(tmp_path)!r})\n"
        "from dolfingrip.config import load\n"
        "print(load(None, {'material.law': 'stiffening'}).material.stiffening_c)\n"
        "from dolfingrip import plugins\n"
        "print([(each.module, each.version) for each in plugins.loaded()])"
    )
    assert python(code, tmp_path) == ["0.1", "[('rubber.stiffening', 'rubber 1.2')]"]


@pytest.mark.slow
def test_all_tests_of_a_law_and_an_effect_hold_for_those_of_the_docs(tmp_path: Path) -> None:
    """Copies of the examples under other names join the indexes, by which these tests are made."""
    copies = {"my_law.py": "own_law.py", "my_effect.py": "own_effect.py"}
    for name, example in copies.items():
        (tmp_path / name).write_bytes((MADE_UP.parents[1] / "examples" / example).read_bytes())
    tests = ("extensions/test_index.py", "extensions/test_neutral.py", "experiments/test_laws.py",
             "test_config.py", "test_parameter.py", "experiments/test_synthetic.py")  # fmt: skip
    ended = subprocess.run(
        [sys.executable, "-P", "-m", "pytest", "-n", "0", "-q", "-p", "no:cacheprovider", "-m", "",
         "-k", "my_law or my-law or my_effect", *(str(MADE_UP.parent / each) for each in tests)],
        env={**os.environ, VARIABLE: os.pathsep.join(str(tmp_path / name) for name in copies)},
        cwd=MADE_UP.parents[1], capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout
    passed = re.search(r"(\d+) passed", ended.stdout)
    assert passed is not None
    assert int(passed[1]) >= 3
