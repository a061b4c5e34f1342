"""What the server does for its tabs: one worker for all of them, one library of solutions."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from dolfingrip import config as configuration
from dolfingrip.config import ConfigError
from dolfingrip.experiments.simulate import job
from dolfingrip.explore import describe, rig
from dolfingrip.explore.library import Library
from dolfingrip.explore.space import Space
from dolfingrip.explore.wanted import Wanted, curve, read
from dolfingrip.files import whole
from dolfingrip.files.run import RunFile
from dolfingrip.jobs.job import JobResult
from dolfingrip.jobs.single import Single
from dolfingrip.report import printable
from dolfingrip.sections.errors import shown

EXPORTS: Final = (*printable.FORMATS, ".toml")
"""Formats of exports, by their suffix."""

FOLDERS: Final = ("solved", "coarse")
"""Of solutions as configured, and of those on coarse meshes."""

LOAD: Final = "dolfingrip.experiments.simulate:load"
"""What the worker calls while nothing is solved yet."""

SOLVED: Final = {"is": "solved"}
"""Message on which a tab shows its design anew."""

Tell = Callable[[dict[str, Any]], None]
"""Sends a message to one tab; called in the server's loop."""


class Session:
    """Answers requests of tabs.

    Args:
        space: what varies.
        library: solutions that are there.
        out: folder for new ones.
    """

    def __init__(self, space: Space, library: Library, out: Path) -> None:
        self.space, self.library, self.out = space, library, out
        self.tabs: set[Tell] = set()
        # Gmsh and the meshes are one thread's
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="explore")
        self._loop: asyncio.AbstractEventLoop | None = None
        self._single = Single(out / "spool", self._heard, self._answered, LOAD)
        self._asked: dict[str, tuple[Wanted, Wanted]] = {}  # design and its mesh, by the job's key
        self._progress: dict[str, Any] | None = None
        self._plan: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Take up what was solved before."""
        self._loop = asyncio.get_running_loop()
        for folder in sorted(path for kind in FOLDERS for path in (self.out / kind).glob("*")):
            await self.work(self.library.add, folder)
        await asyncio.to_thread(self._single.begin)

    async def close(self) -> None:
        """End the worker and the plan."""
        if self._plan is not None and self._plan.returncode is None:
            self._plan.terminate()
        await asyncio.to_thread(self._single.close)
        self._thread.shutdown(cancel_futures=True)

    async def work[T](self, function: Callable[..., T], *arguments: Any) -> T:
        """Call a function in the thread that may mesh."""
        assert self._loop is not None
        return await self._loop.run_in_executor(self._thread, function, *arguments)

    def state(self) -> dict[str, Any]:
        """Return the message for every tab: solved designs, and how far the worker is."""
        return {"is": "state", "counts": self.library.counts(), "working": self._progress}

    async def show(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """Describe a design.

        Raises:
            ConfigError: one line.
        """
        wanted = read(self.space, message)
        shown = await self.work(
            describe.described, self.space, self.library, wanted, self.folder(wanted)
        )
        about = {"id": message.get("id"), "view": wanted.view, "design": wanted.design}
        return {"is": "shown", **about, **shown}

    async def follow(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """Find the supply's commands for a curve.

        Raises:
            ConfigError: one line.
        """
        wanted = read(self.space, message)
        wished = curve(message, wanted.config.experiment.max_pressure_kPa)
        finger = await self.work(describe.resting, self.library, wanted)
        # in the thread of all designs: LSODA solves one problem at a time
        commands = await self.work(describe.followed, self.space, wanted, finger, wished)
        return {"is": "followed", "id": message.get("id"), **commands}

    def folder(self, wanted: Wanted) -> Path:
        """Where the solution of a design is; that on a coarse mesh is no result as configured."""
        kind = FOLDERS[not wanted.refined]
        return self.out / kind / f"{wanted.view}-{wanted.request.key[:16]}"

    async def solve(self, message: Mapping[str, Any]) -> None:
        """Solve a design in place of what is being solved, on a coarse mesh first.

        Raises:
            ConfigError: one line.
        """
        wanted = read(self.space, message)
        if not await self._found(wanted):
            coarse = wanted.coarse
            needed = coarse is not None and not await self._found(coarse)
            await self._ask(wanted, coarse if coarse is not None and needed else wanted)

    async def _found(self, meshed: Wanted) -> bool:
        """Tell tabs of a design that is solved on its mesh; False if it is not."""
        folder, key = self.folder(meshed), meshed.request.key
        answer = self._single.known(key)
        if answer is None or not _shows(answer) or not RunFile.is_in(folder):
            return False
        await self.work(self.library.add, folder)
        self._everyone(SOLVED)
        return True

    async def _ask(self, wanted: Wanted, meshed: Wanted) -> None:
        """Have a design solved, on its own mesh or on a coarse one."""
        folder = self.folder(meshed)
        design_job = job(replace(meshed.request, fields=folder))
        key = design_job.key
        self._single.forget(key)
        before = self._single.job
        if before is not None and before.key != key and before.key in self._asked:
            dropped = self._asked[before.key][0].design
            self._everyone({"is": "replaced", "design": dropped, "by": wanted.design})
        self._asked[key] = wanted, meshed
        self._advance(wanted, meshed, 0, 0, "starting")
        folder.parent.mkdir(parents=True, exist_ok=True)
        await asyncio.to_thread(self._single.ask, design_job)

    async def cancel(self) -> None:
        """Give up what is being solved."""
        await asyncio.to_thread(self._single.cancel)
        self._progress = None
        self._everyone(self.state())

    def export(self, suffix: str, message: Mapping[str, Any]) -> bytes:
        """A design as a file; called in the thread that may mesh.

        Raises:
            ConfigError: one line.
        """
        if suffix not in EXPORTS:
            raise ConfigError(f"{suffix}: allowed: {', '.join(EXPORTS)}")
        wanted = read(self.space, message)
        if suffix == ".toml":
            return configuration.dumps(wanted.config).encode()
        with TemporaryDirectory() as folder:
            file = Path(folder) / f"design{suffix}"
            printable.write(wanted.config, file)
            return file.read_bytes()

    async def rig(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """The files of a measurement.

        Raises:
            ConfigError: one line.
        """
        wanted = read(self.space, message)
        answers = message.get("answers")
        files = await self.work(
            rig.files, answers if isinstance(answers, Mapping) else {}, wanted.config
        )
        return {"is": "rig", "setup": files.setup, "plan": files.plan, "header": files.header,
                "readings": files.readings}  # fmt: skip

    async def plan(self, message: Mapping[str, Any], tell: Tell) -> None:
        """Run ``plan-experiment`` for a rig; a newer plan takes the place of an older one.

        Raises:
            ConfigError: one line.
        """
        made = await self.rig(message)
        if self._plan is not None and self._plan.returncode is None:
            self._plan.terminate()
        file, out = self.out / "rig.toml", self.out / "plan"
        whole.write(file, made["plan"])
        process = self._plan = await asyncio.create_subprocess_exec(
            *rig.command(file, out),
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT,
        )  # fmt: skip
        assert process.stdout is not None
        last = ""
        async for line in process.stdout:
            last = line.decode(errors="replace").strip() or last
            tell({"is": "planning", "text": last})
        if await process.wait():
            tell({"is": "error", "about": "plan", "text": last.removeprefix("dolfingrip: ")})
            return
        text = (out / "plan.md").read_text(encoding="utf-8")
        tell({"is": "planned", "text": text, "folder": str(out)})

    def _heard(self, key: str, done: int, total: int, note: str) -> None:
        """Take progress from the worker's thread."""
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._in_progress, key, done, total, note)

    def _in_progress(self, key: str, done: int, total: int, note: str) -> None:
        if key in self._asked:
            self._advance(*self._asked[key], done, total, note)

    def _advance(self, wanted: Wanted, meshed: Wanted, done: int, total: int, note: str) -> None:
        self._progress = {
            "done": done, "total": total, "note": note, "view": wanted.view,
            "design": wanted.design, "coarse": not meshed.refined,
        }  # fmt: skip
        self._everyone(self.state())

    def _answered(self, answer: JobResult) -> None:
        """Take an answer from the worker's thread."""
        assert self._loop is not None
        asyncio.run_coroutine_threadsafe(self._take(answer), self._loop)

    async def _take(self, answer: JobResult) -> None:
        wanted, meshed = self._asked.pop(answer.key)
        self._progress = None
        if _shows(answer):
            await self.work(self.library.add, self.folder(meshed))
            self._everyone(self.state())
            self._everyone(SOLVED)
        elif meshed.refined:
            text = f"{wanted.view.replace('_', ' ')}: {answer.failure}"
            self._everyone({"is": "error", "about": "solve", "design": wanted.design, "text": text})
        if not meshed.refined and self._single.job is None:  # nothing newer took its place
            await self._ask(wanted, wanted)
        self._everyone(self.state())

    def _everyone(self, message: dict[str, Any]) -> None:
        for tell in list(self.tabs):
            tell(message)


def _shows(answer: JobResult) -> bool:
    """True where a job has solved more than the state at rest, though it may have failed beyond."""
    columns = (answer.result or answer.partial or {}).get("columns", {})
    return max(map(len, columns.values()), default=0) > 1


def parsed(text: str) -> dict[str, Any]:
    """A message of a tab.

    Args:
        text: as it came, which should be a JSON object.

    Raises:
        ConfigError: one line.
    """
    try:
        message = json.loads(text, parse_constant=_finite, parse_float=_finite, parse_int=_whole)
        json.dumps(message, ensure_ascii=False).encode()
    except ConfigError:
        raise
    except UnicodeEncodeError:
        raise ConfigError("message: half a surrogate pair; allowed: whole characters") from None
    except RecursionError:
        raise ConfigError("message: nested too deeply") from None
    except ValueError:
        raise ConfigError("message: not JSON") from None
    if not isinstance(message, dict):
        raise ConfigError("message: allowed: a JSON object")
    return message


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ConfigError(f"message: number {shown(text)}: allowed: finite, below 1.8e308")
    return value


def _whole(text: str) -> int:
    _finite(text)
    return int(text)
