"""Simulations of the reference finger that come with the package: a small file of answers.

An answer serves a request of the same configuration whose protocol is the beginning of its own: who
loads once, or unloads, is served by three cycles. A file is stale where the code has changed since:
answers with an effect count only with that effect's code unchanged, and where the mechanics have
changed at all, one simulation is computed anew and has to agree before any other is believed.

Digests of the code are of its syntax trees, comments and texts aside.
"""

from __future__ import annotations

import ast
import gzip
import hashlib
import importlib.util
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.experiments.request import FORMAT, Answer, Request
from dolfingrip.jobs.job import content_key

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
            node.body = [each for each in body if not _is_text(each)]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


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
            if key.split("[")[0] in keys
        }
        found = replace(self.answer, columns=columns, slopes=slopes)
        if min((len(values) for values in columns.values()), default=0) == count:
            found = replace(found, failure_class=None, failure=None)
        return found


@dataclass(slots=True)
class Shipped:
    """The answers of a file.

    Attributes:
        core: digest of the code that computed it.
        known: its entries by their requests' key without protocol.
        agrees: whether a simulation computed anew agreed; None where that was not tried.
    """

    core: str
    known: Mapping[str, Sequence[Known]]
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
        candidates = self.known.get(key_without_protocol(request), ())
        return next((known for known in candidates if known.serves(request)), None)

    def _believed(
        self, computed: Callable[[Request], Answer], found: Sequence[tuple[Request, Known]]
    ) -> bool:
        if self.agrees is None and self.core == core_digest():
            self.agrees = True
        plain = [(one, known) for one, known in found if not known.effects]
        if self.agrees is None and plain:
            quickest = min(plain, key=lambda pair: pair[1].answer.wall_s or 0.0)
            self.agrees = self._checked(computed, *quickest)
        return bool(self.agrees)

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


@dataclass(frozen=True, slots=True)
class Content:
    """The content of a file: version, digests of the code, entries."""

    format: int
    core: str
    effects: Mapping[str, str]
    known: Sequence[Known]


def loaded(file: Path) -> Content:
    """Read the whole content of a file."""
    return TypeAdapter(Content).validate_json(gzip.decompress(file.read_bytes()))


@cache
def read(file: Path = FILE) -> Shipped | None:
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
    unchanged = {name for name, old in found.effects.items() if old == _now(name)}
    known: dict[str, list[Known]] = {}
    for each in found.known:
        if set(each.effects) <= unchanged:
            known.setdefault(each.key, []).append(each)
    return Shipped(found.core, known)


def _now(name: str) -> str | None:
    try:
        return effect_digest(name)
    except FileNotFoundError:
        return None
