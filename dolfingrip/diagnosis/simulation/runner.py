"""Requests of a diagnosis on workers, each answer kept in a store by its content.

What is in the store is not computed again, whichever data asked for it; a diagnosis that is killed
goes on where it was. What comes with the package, a small file of answers of the reference finger,
is entered instead of being computed.

An answer of that file serves a request of the same configuration whose protocol is the beginning of
its own: who loads once, or unloads, is served by three cycles. A file is stale where the code has
changed since: answers with an effect count only with that effect's code unchanged, and where the
mechanics have changed at all, one simulation is computed anew and has to agree before any other is
believed.

Digests of the code are of its syntax trees, comments and texts aside.
"""

from __future__ import annotations

import ast
import gzip
import hashlib
import importlib.util
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from dolfingrip.channels import CHANNELS, TIME
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.table import CONTROL, READING_COLUMNS, READINGS
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.experiments.request import FORMAT, Answer, Request
from dolfingrip.experiments.simulate import enter, simulate
from dolfingrip.extensions.index import NAMES
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import content_key
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, silent
from dolfingrip.jobs.store import Store

CORE: Final = ("dolfingrip.forms", "dolfingrip.meshes", "dolfingrip.mechanics",
               "dolfingrip.experiments")  # fmt: skip
"""Packages that every simulation of a finger depends on."""


@cache
def core_digest() -> str:
    """Digest of the solver's sources."""
    return _digest(file for name in CORE for file in sorted(_folder(name).rglob("*.py")))


@cache
def effect_digest(name: str) -> str:
    """Digest of an effect's file, and of the files of this package that it imports itself."""
    own = _folder("dolfingrip.extensions") / f"{name}.py"
    imported = {
        node.module
        for node in ast.walk(ast.parse(own.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module
    }
    files = [_file(each) for each in sorted(imported) if each.startswith("dolfingrip.")]
    return _digest([own, *(file for file in files if file is not None)])


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    assert spec is not None
    assert spec.submodule_search_locations
    return Path(next(iter(spec.submodule_search_locations)))


def _file(module: str) -> Path | None:
    spec = importlib.util.find_spec(module)
    return Path(spec.origin) if spec and spec.origin else None


def _digest(files: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for file in files:
        found.update(file.name.encode())
        found.update(structure(file.read_text(encoding="utf-8")).encode())
    return found.hexdigest()


def structure(text: str) -> str:
    """The syntax tree without docstrings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [  # type: ignore[attr-defined]
                each
                for each in body
                if not isinstance(each, ast.Expr)
                or not isinstance(getattr(each.value, "value", None), str)
            ]
    return ast.dump(tree)


FILE: Final = Path(__file__).with_name("reference.json.gz")

Protocol = dict[str, list[Any]]


@dataclass(frozen=True, slots=True)
class Known:
    """One answer of the file.

    Attributes:
        key: hash of its request without protocol and derivatives.
        effects: that were on, by name.
        protocol: stops.
        gradients: keys of the parameters of its derivatives.
        answer: what the simulation gave.
    """

    key: str
    effects: Sequence[str]
    protocol: Protocol
    gradients: Sequence[str]
    answer: Answer

    def serves(self, request: Request) -> bool:
        """Tell whether a request's protocol is the beginning of this, and its derivatives are here.

        Args:
            request: of the same key without protocol.

        Returns:
            Whether they are.
        """
        if not set(request.gradients or ()) <= set(self.gradients):
            return False
        asked = protocol_of(request)
        return asked.keys() == self.protocol.keys() and all(
            self.protocol[name][: len(values)] == values for name, values in asked.items()
        )

    def part(self, request: Request) -> Answer:
        """Return the beginning of the answer that a request asks for.

        Args:
            request: that this serves.

        Returns:
            Readings and derivatives at its stops.
        """
        count, keys = len(request.config.protocol.time_s), request.gradients or ()
        columns = {name: values[:count] for name, values in self.answer.columns.items()}
        slopes = {
            (column, key): values[:count]
            for (column, key), values in self.answer.slopes.items()
            if not {key, key.split("[")[0]}.isdisjoint(keys)  # one entry of a list, or all
        }
        found = replace(self.answer, columns=columns, slopes=slopes)
        if min((len(values) for values in columns.values()), default=0) == count:
            found = replace(found, failure_class=None, failure=None)
        return found


@dataclass(slots=True)
class Shipped:
    """The answers of a file.

    Attributes:
        format: its version.
        core: digest of the code that computed it.
        effects: the same of each effect that acts in some answer.
        known: its entries.
        agrees: whether a simulation computed anew agreed; None where that was not tried.
    """

    format: int
    core: str
    effects: Mapping[str, str]
    known: Sequence[Known]
    agrees: bool | None = None

    def answers(
        self, requests: Iterable[Request], computed: Callable[[Request], Answer]
    ) -> list[tuple[Request, Answer]]:
        """Look requests up.

        Args:
            requests: that are wanted.
            computed: computes a request anew; called once, where the code has changed.

        Returns:
            Those that are known, with their answers.
        """
        found = [(one, known) for one in requests if (known := self.entry(one)) is not None]
        if not found or not self._believed(computed, found):
            return []
        return [(one, known.part(one)) for one, known in found]

    def entry(self, request: Request) -> Known | None:
        """Return the entry that serves a request; None where there is none."""
        key = key_without_protocol(request)
        return next((each for each in self.known if each.key == key and each.serves(request)), None)

    def _believed(
        self, computed: Callable[[Request], Answer], found: Sequence[tuple[Request, Known]]
    ) -> bool:
        if self.agrees is None:
            quickest = min(found, key=lambda pair: pair[1].answer.wall_s or 0.0)
            self.agrees = self.core == core_digest() or self._checked(computed, *quickest)
        return self.agrees

    def _checked(self, computed: Callable[[Request], Answer], request: Request, own: Known) -> bool:
        """Tell whether a request comes out as it did, within the tolerance of each channel."""
        anew, before = computed(request).columns, own.part(request).columns
        return all(
            len(anew.get(name, ())) == len(values)
            and np.allclose(anew[name], values, 0.0, CHANNELS[name].tolerance)
            for name in READING_COLUMNS
            if (values := before.get(name, np.empty(0))).size
        )


def key_without_protocol(request: Request) -> str:
    """Hash of the request without protocol and gradients.

    Args:
        request: of a diagnosis.

    Returns:
        The hash; requests of one hash are simulations of one model.
    """
    content = request.content()
    content["config"].pop("protocol", None)
    del content["gradients"]
    return content_key(content)


def protocol_of(request: Request) -> Protocol:
    """Return the stops of a request, by key of the section."""
    told = request.config.protocol.model_dump(mode="json")
    return {name: values for name, values in told.items() if values}


def loaded(file: Path) -> Shipped:
    """Read the whole content of a file."""
    return TypeAdapter(Shipped).validate_json(gzip.decompress(file.read_bytes()))


@cache
def shipped(file: Path = FILE) -> Shipped | None:
    """Read a file of answers.

    Args:
        file: where it is.

    Returns:
        Its entries, without those of effects whose code has changed; None where there is no file,
        or one of another format.
    """
    if not file.is_file():
        return None
    found = loaded(file)
    if found.format != FORMAT:
        return None
    own = found.effects.items()
    unchanged = {name for name, old in own if name in NAMES and old == effect_digest(name)}
    return replace(found, known=[e for e in found.known if unchanged.issuperset(e.effects)])


def request(
    experiment: str,
    config: Config,
    gradients: Sequence[str] = (),
    *,
    mesh_check: bool = False,
    read: Sequence[str] = (),
) -> Request:
    """Ask for an experiment as a diagnosis simulates it.

    States beyond a snap are not what was measured up to there, and cost most of the time. How far a
    path goes beyond its last stop is never read.

    Args:
        experiment: its name.
        config: with the protocol of the measurement.
        gradients: keys of parameters that all readings are derived by.
        mesh_check: whether the error of the mesh is estimated, too.
        read: columns that are read; the experiment's own where empty, without markers.

    Returns:
        The request.

    Raises:
        ConfigError: one line, where the configuration cannot have the experiment's settings.
    """
    shortest = max(config.solver.min_step_kPa, POLICY.shortest_step * config.solver.max_step_kPa)
    plain = config.changed(experiment={"snaps": False}, solver={"min_step_kPa": shortest})
    columns = (TIME.name, CONTROL[experiment], *(read or READINGS[experiment]))
    return Request.of(experiment, plain, gradients or None, columns=columns, mesh_check=mesh_check)


class NotAtHand(Exception):
    """Simulations would have to be computed; the text says how many."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Where simulations are computed and kept.

    Attributes:
        store: folder of the results, made where there is none.
        where: which workers; one MPI process each.
        progress: called with each simulation that is done.
        kept: processes that are started when something is to be computed, and kept; started for
            each call where None.
        known: results that come with the package.
        computes: whether what is not there is computed.
        spent_s: time that each simulation took, by its key.
    """

    store: Path
    where: Where = field(default_factory=Where)
    progress: Progress = silent
    kept: Pool | None = None
    known: Shipped | None = None
    computes: bool = True
    spent_s: dict[str, float] = field(default_factory=dict)

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        """Compute each request where it is not in the store.

        Args:
            requests: what is wanted.

        Returns:
            Their answers, in order. That of a simulation that failed has its class, a sentence and
            what was read before.

        Raises:
            ConfigError: one line: no workers, or the store is in use or another's.
            NotAtHand: simulations are missing, and nothing is computed.
            Unfinished: the workers are gone, or the machine did not let some simulations come to
                an end; what was computed is kept.
        """
        if self.known is not None:
            self._enter(self.known, self._missing(requests))
        if not self.computes and (missing := self._missing(requests)):
            one = len(missing) == 1
            raise NotAtHand(f"{len(missing)} simulation{' is' if one else 's are'} not at hand")
        return self._computed(requests)

    def at_hand(self) -> Workers:
        """Return workers that raise :class:`NotAtHand` where a simulation is missing."""
        return replace(self, computes=False)

    def pool(self) -> AbstractContextManager[Pool]:
        """The workers that compute what is missing; those not kept end with the ``with`` block."""
        return Pool(self.where) if self.kept is None else nullcontext(self.kept)

    def _computed(self, requests: Sequence[Request]) -> list[Answer]:
        with self.pool() as pool:
            found = simulate(requests, self.store, pool, self.progress)
        for asked, answer in zip(requests, found, strict=True):
            self.spent_s[asked.key] = answer.wall_s or 0.0
        return found

    def _enter(self, known: Shipped, missing: Sequence[Request]) -> None:
        """Enter what comes with the package."""
        found = known.answers(missing, lambda asked: self._computed([asked])[0])
        if found:
            enter(found, self.store, "shipped")

    def _missing(self, requests: Sequence[Request]) -> list[Request]:
        try:
            with Store(self.store) as store:
                return [one for one in requests if store.status(one.key) in (None, "pending")]
        except ConfigError:
            return list(requests)


@contextmanager
def staying(
    store: Path, workers: int, progress: Progress, *, anew: bool = False
) -> Iterator[Workers]:
    """Workers that end with the ``with`` block: a diagnosis asks many times, and starts them once.

    With ``anew`` they compute what comes with the package, too.
    """
    where = Where(workers=workers)
    with Pool(where) as pool:
        yield Workers(store, where, progress, pool, None if anew else shipped())
