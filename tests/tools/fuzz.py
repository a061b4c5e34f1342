"""Mutated input for every reader: what a damaged file, a wrong key or a hostile message leads to.

    scripts/fuzz [--number 10000] [--seed 0] [--only READER…] [--out tests/tools/fuzz.csv]

Each mutation has a seed of its own, which is printed where one ends badly; `--seed S --number 1
--only READER` repeats it. It ends in one of these ways:

========== ===================================================================================
accepted   the input is still a good one
refused    one line, by an error that the commands turn into exit code 2
traceback  any other error, a message of several lines, or more than 8 GiB of memory
hang       more than 20 s of processor
files      refused, and yet a file was written
dead       the process ended
========== ===================================================================================

Where a mutation is that of one key, a refusal has to name the key.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.config import Config, ConfigError
from dolfingrip.files import table
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.whole import WriteError
from dolfingrip.sections.tables import assignments

HANG_S: Final = 20
MEMORY_BYTES: Final = 8 << 30
"""Address space that a reader may take; what takes more ends in a traceback."""
EXAMPLES: Final = Path(__file__).parents[2] / "examples"
FINGER: Final = {
    "mesh.size_mm": 8.0, "mesh.edge_size_mm": 8.0, "finger.length_mm": 38.0, "finger.bellows": 2,
    "experiment.max_pressure_kPa": 10.0, "experiment.step_kPa": 10.0,
}  # fmt: skip
"""A finger of two bellows, coarsely meshed."""

TABLES: Final = (
    "ecoflex_actuators/bending", "ecoflex_actuators/blocked_force", "coupons/ninjaflex_uniaxial",
)  # fmt: skip
"""Measured tables of each experiment, among the examples."""

TOO_DEEP: Final = "[" * 3000 + "]" * 3000
"""A value that parsers give up at, before they know of a key."""

VALUES: Final = (
    "nan", "inf", "-inf", "-1", "0", "1e-320", "1e308", "-1e308", "1e400", "1" * 401, "true", '""',
    '"x"', '"\\u0000"', "[]", "[1]", "[[1]]", "{}", "{a = 1}", "1979-05-27", "0x10", "1_000", "''",
    '"' + "n" * 300 + '"', TOO_DEEP, '"\\u001b[31m"', '"../../etc"', "3.5", "7",
)  # fmt: skip
"""What takes the place of a value."""

BYTES: Final = (b"\0", b"\xff", b"\xed\xa0\x80", b"\x1b[2J", b"[" * 3000, b"-", b"9" * 400, b"nan",
         b"\n\n", b",", b'"', b"\xef\xbb\xbf", b"<", b"1e-320", b"-1", b"1000000")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Reader:
    """A reader that is fuzzed.

    Attributes:
        read: mutates the input by a generator, or leaves it good where there is none, and reads it
            in a folder; tells the key that it mutated, where it is one.
        share: of all mutations.
        alone: each mutation has a process of its own, as the command has.
    """

    read: Callable[[Path, random.Random | None, Callable[[str], None]], None]
    share: int = 10
    alone: bool = False


# -- mutations -----------------------------------------------------------------------------------


def damaged(data: bytes, rng: random.Random | None) -> bytes:
    """Bytes with one to three places changed."""
    if rng is None:
        return data
    for _ in range(rng.randint(1, 3)):
        at, more = rng.randrange(len(data) + 1), rng.choice((1, 4, 40, 400))
        kind = rng.randrange(6)
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + data[at + more :]
        elif kind == 2:
            data = data[:at] + rng.choice(BYTES) + data[at:]
        elif kind == 3:
            data = data[:at] + rng.choice(BYTES) + data[at + more :]
        elif kind == 4:
            data = data[:at] + data[max(at - more, 0) : at] + data[at:]
        else:
            found = list(re.finditer(rb"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", data))
            if found:
                one = rng.choice(found)
                data = data[: one.start()] + rng.choice(BYTES) + data[one.end() :]
    return data


CELLS: Final = (
    "", "-", "x", "nan", "-inf", "0", "-1", "1e308", "1e-320", "1e400", "12,5", "3 kPa", "12:30",
    "1_0", "#DIV/0!", "TRUE", "loading", "coupon", "1.5", "99999999999",
)  # fmt: skip
"""What takes the place of cells of a table."""

HEADERS: Final = (
    "time_s", "pressure_kPa", "suction_kPa", "angle_deg", "force_N", "tip_x_mm", "cycle", "branch",
    "specimen", "experiment", "displacement_mm", "marker_1_x_mm", "cavity_1_supply_kPa", "mode",
    "transverse_strain", "Pressure [bar]", "Strain (%)", "Stress (MPa)", "stretch", "t/min", "",
)  # fmt: skip
"""What takes the place of a header."""


def retabled(text: str, rng: random.Random) -> str:
    """A table in CSV with one or two changes, as hands and spreadsheets make them."""
    header, *rows = (line.split(",") for line in text.splitlines())
    for _ in range(rng.randint(1, 2)):
        at, kind = rng.randrange(len(header)), rng.randrange(8)
        if kind == 0:
            header[at] = rng.choice(HEADERS)
        elif kind == 1:
            header = [*header, rng.choice(HEADERS)]
            rows = [[*row, rng.choice((str(i), rng.choice(CELLS)))] for i, row in enumerate(rows)]
        elif kind == 2 and len(header) > 1:
            header, *rows = ([*row[:at], *row[at + 1 :]] for row in [header, *rows])
        elif kind == 3:
            rows = rng.choice((rows[::-1], rows + rows[::-1], rng.sample(rows, len(rows))))
        elif kind == 4:
            rows = rows[: rng.choice((0, 1, 2, 3))]
        elif kind == 5:
            cell = rng.choice(CELLS)
            rows = [[*row[:at], cell, *row[at + 1 :]] for row in rows]
        elif rows:
            one = rng.choice(rows)
            one[at] = rng.choice(CELLS)
    text = "".join(",".join(row) + "\n" for row in [header, *rows])
    return text.replace(",", ";") if rng.random() < 0.2 else text


def revalued(text: str, rng: random.Random) -> tuple[str, str]:
    """A TOML text with one value replaced, and its key."""
    lines = text.splitlines()
    at = rng.choice([i for i, line in enumerate(lines) if re.match(r"\w+\s*=", line)])
    key = lines[at].partition("=")[0].strip()
    lines[at] = f"{key} = {rng.choice(VALUES)}"
    return "\n".join(lines) + "\n", key


def _damage_one(folder: Path, rng: random.Random) -> None:
    one = rng.choice(sorted(file for file in folder.rglob("*") if file.is_file()))
    one.write_bytes(damaged(one.read_bytes(), rng))


# -- readers -------------------------------------------------------------------------------------


def _toml(text: str, read: Callable[[Path], Any]) -> Reader:
    """A reader of a TOML file, given as a text."""

    def fuzzed(folder: Path, rng: random.Random | None, told: Callable[[str], None]) -> None:
        file = folder / "file.toml"
        shutil.copy(EXAMPLES / "paper_finger.toml", folder)
        if rng is not None and rng.random() < 0.6:
            changed, key = revalued(text, rng)
            file.write_text(changed, encoding="utf-8")
            if TOO_DEEP not in changed:
                told(key)
        else:
            file.write_bytes(damaged(text.encode(), rng))
        read(file)

    return Reader(fuzzed)


def _copied(
    source: Path, read: Callable[[Path], Any], share: int = 10, *, alone: bool = False
) -> Reader:
    """A reader of a folder, of which one file is damaged."""

    def fuzzed(folder: Path, rng: random.Random | None, told: Callable[[str], None]) -> None:
        shutil.copytree(source, folder, dirs_exist_ok=True)
        if rng is not None:
            _damage_one(folder, rng)
        read(folder)

    return Reader(fuzzed, share, alone)


def _assigned(folder: Path, rng: random.Random | None, told: Callable[[str], None]) -> None:
    rng = rng or random.Random(1)
    plain = Config().model_dump(mode="json", exclude_none=True)
    section = rng.choice([name for name, each in plain.items() if isinstance(each, dict) and each])
    key = rng.choice(list(plain[section]))
    text = f"{section}.{key}={rng.choice(VALUES)}"
    if rng.random() < 0.2:
        text = damaged(text.encode(), rng).decode(errors="surrogateescape")
    else:
        told(key)
    configuration.load(None, dict(assignments([text])))


def _measured(folder: Path) -> None:
    from dolfingrip.diagnosis.data import measurement

    measurement.read([*folder.glob("*.csv")])


def _tabled(source: Path, read: Callable[[Path], Any]) -> Reader:
    """A reader of a folder with a table and its set-up, of which either is changed."""
    (csv,) = source.glob("*.csv")

    def fuzzed(folder: Path, rng: random.Random | None, told: Callable[[str], None]) -> None:
        rows, setup = (each.read_text(encoding="utf-8") for each in (csv, csv.with_suffix(".toml")))
        if rng is not None and rng.random() < 0.8:
            rows = retabled(rows, rng)
        elif rng is not None:
            setup, _ = revalued(setup, rng)
        (folder / csv.name).write_text(rows, encoding="utf-8")
        (folder / csv.name).with_suffix(".toml").write_text(setup, encoding="utf-8")
        read(folder)

    return Reader(fuzzed, 5)


def _imported(folder: Path) -> None:
    from dolfingrip.importing import importing
    from dolfingrip.importing.told import Question, Told

    (file,) = folder.glob("*.csv")
    try:
        found = importing.understand(file, Told())
    except Question as question:
        raise ConfigError(str(question)) from None
    if found.questions:
        raise ConfigError("; ".join(map(str, found.questions)))
    importing.write(found, folder / "imported")


def _design(file: Path) -> None:
    from dolfingrip.design.gradient.read import read

    read(file)


def _rig(file: Path) -> None:
    from dolfingrip.diagnosis.data import rig

    rig.read(file, Config())


def _campaign(folder: Path) -> None:
    from dolfingrip.design.campaign import campaign
    from dolfingrip.jobs.run import check

    try:
        campaign.table(folder)
    except ConfigError as error:
        _one_line(error)
    check(folder)
    campaign.table(folder)


def _result(folder: Path) -> None:
    from dolfingrip.report.page import html, sources

    page = sources.build(sources.find([folder]))
    html.rendered(page)


def _surrogate(folder: Path) -> None:
    from dolfingrip.design.surrogate import surrogate
    from dolfingrip.files.surrogate import SurrogateFile

    surrogate.load(folder)
    learnt = SurrogateFile.read(folder)
    learnt.learning_curve(folder)
    learnt.designs(folder)


def _mesh(folder: Path) -> None:
    from dolfingrip.meshes import files

    for file in folder.iterdir():
        files.read(file)


def _cad(folder: Path) -> None:
    from dolfingrip.meshes.adoption.adopt import adopt
    from dolfingrip.meshes.adoption.roles import Asked
    from dolfingrip.meshes.adoption.sizes import MeshRequest

    for file in folder.iterdir():
        adopt(file, Asked(), MeshRequest())


MESSAGE: Final[Mapping[str, Any]] = {
    "do": "show", "id": 3, "view": "grasp", "inputs": {"morph.xi1": 0.1}, "pressure_kPa": 100.0,
    "gripper": {"pose": "scoop", "R_mm": 30.0}, "food": {"kind": "potato-small", "friction": 0.4},
    "answers": {"experiments": ["bending"], "rate_kPa_per_s": 25.0, "gap_mm": 0.5,
                "protocol": {"step_kPa": 25.0, "cycles": 2, "hold_s": 5.0}},
}  # fmt: skip
NO_VALUES: Final = ("NaN", "1e400", "9" * 400, '"\\ud800"', TOO_DEEP)
"""What a message may not have anywhere."""

VALUES_OF_MESSAGES: Final = (
    *NO_VALUES, "-1", "0", "1e-320", "1e308", "true", "null", '""', '"abc"', "[]",
    "{}", '{"a": {"b": 1}}', "[[1, 2]]", '"x\\u0000"', "1e-9",
)  # fmt: skip


def _message(folder: Path, rng: random.Random | None, told: Callable[[str], None]) -> None:
    from dolfingrip.explore import rig, session, space, wanted

    text = json.dumps(MESSAGE)
    if rng is not None and rng.random() < 0.7:
        places = [
            p
            for p in re.finditer(r'"(\w+(\.\w+)?)": ', text)
            if p[1] not in ("do", "id", "answers")
        ]
        one = rng.choice(places)
        _, end = json.JSONDecoder().raw_decode(text, one.end())
        value = rng.choice(VALUES_OF_MESSAGES)
        text = text[: one.end()] + value + text[end:]
        if value not in NO_VALUES:
            told(one[1])
    else:
        text = damaged(text.encode(), rng).decode(errors="replace")
    known = space.of_results([], None, {}, ["morph.xi1=-0.2:1"])
    message = session.parsed(text)
    asked = wanted.read(known, message)
    answers = message.get("answers")
    rig.files(answers if isinstance(answers, Mapping) else {}, asked.config)


def readers(folder: Path, *, quick: bool = False) -> dict[str, Reader]:
    """Readers, with their good input made in a folder.

    Args:
        folder: for their input.
        quick: without those of CAD and of results, which take long or need a solution.
    """
    from dolfingrip.design.campaign.plan import Plan
    from dolfingrip.experiments import run
    from dolfingrip.experiments.rigs.undeformed import solid
    from dolfingrip.jobs.job import JobResult
    from dolfingrip.jobs.spool import Spool
    from dolfingrip.jobs.store import Store
    from dolfingrip.meshes import files

    finger = configuration.load(None, dict(FINGER))
    tables = {}
    for name in TABLES:
        tables[Path(name).name] = measured = folder / name
        measured.mkdir(parents=True)
        for suffix in (".csv", ".toml"):
            shutil.copy((EXAMPLES / name).with_suffix(suffix), measured)
    found = {
        "configuration": _toml(configuration.dumps(finger), lambda file: configuration.load(file)),
        "--set": Reader(_assigned),
        "protocol": _toml(
            'experiment = ["bending", "blocked_force"]\nrate_kPa_per_s = 25.0\n[noise]\n'
            "angle_deg = 0.3\n[protocol]\nstep_kPa = 25.0\ncycles = 3\nhold_s = 5.0\ntip = true\n"
            'highest_pressure_kPa = 100.0\ncan_vary = ["hold", "coupon"]\n',
            _rig,
        ),
        "design": _toml((EXAMPLES / "paper_design.toml").read_text(encoding="utf-8"), _design),
        "free design": _toml((EXAMPLES / "free_design.toml").read_text(encoding="utf-8"), _design),
        "measured data": _copied(tables["bending"], _measured),
        **{f"measured {name}": _tabled(each, _measured) for name, each in tables.items()},
        **{f"import {name}": _tabled(each, _imported) for name, each in tables.items()},
        "explorer's messages": Reader(_message),
    }
    mesh = solid(configuration.changed(finger, {"mesh.half": False, "mesh.order": 1}))
    for suffix in files.WRITABLE:
        files.write(folder / f"mesh{suffix}" / f"finger{suffix}", mesh)
        found[f"mesh {suffix}"] = _copied(folder / f"mesh{suffix}", _mesh, 3)
    if not quick:
        run("bending", finger, out=folder / "run")
        found["result folder"] = _copied(folder / "run", _result, 5)
        found |= _of_cad(finger, folder)
    points = tuple({"morph.xi1": value / 10} for value in range(6))
    plan = Plan(finger, ("morph.xi1",), points)
    jobs, stored = plan.jobs(), folder / "campaign"
    answers = [
        JobResult(job.key, "done", {"outputs": {"cog_offset_mm": 1.0 + i, "force_N": 2.0}})
        for i, job in enumerate(jobs)
    ]
    with Store(stored, write=True) as store:
        store.add(jobs, plan.shared)
        for answer in answers[:4]:
            store.record(answer)
    (stored / "spool").mkdir()
    for answer in answers[4:]:
        Spool(stored / "spool").write(answer)
    found["campaign"] = _copied(stored, _campaign)
    return found


def _of_cad(finger: Config, folder: Path) -> dict[str, Reader]:
    from dolfingrip.report import printable

    printable.write(finger, folder / "stl" / "finger.stl")
    (folder / "step").mkdir()
    shutil.copy(EXAMPLES / "half_round_finger.step", folder / "step")
    return {f"CAD .{name}": _copied(folder / name, _cad, 1, alone=True) for name in ("stl", "step")}


# -- outcomes ------------------------------------------------------------------------------------


class Hang(BaseException):
    """More than :data:`HANG_S` of processor."""


def _hung(number: int, frame: object) -> None:
    raise Hang


def _one_line(error: Exception) -> None:
    if len(str(error).splitlines()) > 1:
        raise AssertionError(f"several lines: {error!r}")


def once(reader: Reader, seed: int) -> tuple[str, bool | None, str]:
    """Mutate and read once: how it ended, whether the key was named, and what was said.

    A negative seed mutates nothing.
    """
    rng = None if seed < 0 else random.Random(seed)
    keys: list[str] = []
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        folder, work, here = Path(name) / "input", Path(name) / "work", os.getcwd()
        folder.mkdir()
        work.mkdir()

        def told(key: str) -> None:
            keys.append(key)

        signal.signal(signal.SIGPROF, _hung)
        signal.setitimer(signal.ITIMER_PROF, HANG_S)
        try:
            os.chdir(work)
            reader.read(folder, rng, told)
        except (ConfigError, ResultFileError, WriteError) as error:
            said = str(error)
            if len(said.splitlines()) > 1:
                return "traceback", None, said
            left = [*work.iterdir(), *folder.rglob("*.part*")]
            way = "files" if left else "refused"
            return way, (keys[0] in said if keys else None), said
        except Hang:
            return "hang", None, traceback.format_exc(limit=-3)
        except Exception:
            return "traceback", None, traceback.format_exc(limit=-4)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            os.chdir(here)
    return "accepted", None, ""


def _serve(reader: Reader, seeds: list[int], pipe: Any) -> None:
    """Read one seed after another in a process of its own, which may die."""
    logging.disable(logging.CRITICAL)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    for seed in seeds:
        pipe.send((seed, once(reader, seed)))
    pipe.send(None)


def all_of(reader: Reader, seeds: list[int]) -> Iterator[tuple[int, tuple[str, bool | None, str]]]:
    """Outcomes of all seeds, those included at which the process dies or does not come back."""
    left = list(seeds)
    context = multiprocessing.get_context("fork")
    while left:
        ours, theirs = context.Pipe()
        process = context.Process(
            target=_serve, args=(reader, left[:1] if reader.alone else left, theirs), daemon=True
        )
        process.start()
        theirs.close()
        while left:
            try:
                if not ours.poll(20 * HANG_S):
                    raise EOFError
                got = ours.recv()
            except EOFError:
                process.kill()
                yield left.pop(0), ("dead", None, "the process ended or did not come back")
                break
            if got is None:
                break
            left.pop(0)
            yield got
        process.join()


@dataclass
class Tally:
    """Outcomes of one reader."""

    ways: Counter[str] = field(default_factory=Counter)
    keyed: int = 0
    named: int = 0


def main() -> None:
    """Fuzz, and write the table."""
    parser = argparse.ArgumentParser(prog="scripts/fuzz")
    parser.add_argument("--number", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    tallies: dict[str, Tally] = defaultdict(Tally)
    bad = 0
    with tempfile.TemporaryDirectory(prefix="fuzzed-") as folder:
        known = readers(Path(folder))
        chosen = {name: r for name, r in known.items() if not asked.only or name in asked.only}
        whole = sum(each.share for each in chosen.values())
        for name, reader in chosen.items():
            count = max(1, round(asked.number * reader.share / whole))
            ((_, good),) = all_of(reader, [-1])
            if name != "--set" and good[0] != "accepted":
                raise SystemExit(f"{name}: the input is not good without a mutation: {good}")
            for seed, (way, named, said) in all_of(
                reader, list(range(asked.seed, asked.seed + count))
            ):
                tallies[name].ways[way] += 1
                if named is not None:
                    tallies[name].keyed += 1
                    tallies[name].named += named
                if way not in ("accepted", "refused") or named is False:
                    bad += way not in ("accepted", "refused")
                    sys.stdout.write(f"{name}, seed {seed}: {way}: {said}\n")
            tally = tallies[name]
            sys.stdout.write(f"{name}: {dict(tally.ways)}, named {tally.named}/{tally.keyed}\n")
            sys.stdout.flush()
    ways = ("accepted", "refused", "traceback", "hang", "files", "dead")
    rows = [
        {"reader": name, **{way: tally.ways[way] for way in ways},
         "of_one_key": tally.keyed, "key_named": tally.named}
        for name, tally in tallies.items()
    ]  # fmt: skip
    if asked.out is not None:
        table.write(asked.out, rows)
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
