"""A short part of ``scripts/fuzz``: mutated input ends in one line, or is still good."""

from __future__ import annotations

import errno
import random
from pathlib import Path

import pytest
from tools import fuzz

from dolfingrip.files.whole import WriteError
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.solid import MeshError

SEED = 1
NUMBER = 40
"""Mutations for each reader; of meshes and campaigns, a fourth."""


@pytest.fixture(scope="module")
def readers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, fuzz.Reader]:
    return fuzz.readers(tmp_path_factory.mktemp("good"), quick=True)


def test_mutated_input(readers: dict[str, fuzz.Reader]) -> None:
    print("seed", SEED)
    all_named = all_keyed = 0
    for name, reader in readers.items():
        assert name == "--set" or fuzz.once(reader, -1)[0] == "accepted", name
        refused = 0
        for seed in range(SEED, SEED + (NUMBER // 4 if name[:4] in ("mesh", "camp") else NUMBER)):
            way, named, said = fuzz.once(reader, seed)
            assert way in ("accepted", "refused"), (name, seed, way, said)
            refused += way == "refused"
            all_keyed += named is not None
            all_named += named is True
        assert refused, name
    assert all_named >= 0.98 * all_keyed


def test_what_the_fuzzer_finds(tmp_path: Path) -> None:
    """A reader that breaks, one that goes on for ever, and one that leaves a file."""

    def of(read: object) -> fuzz.Reader:
        def fuzzed(folder: Path, rng: object, told: object) -> None:
            assert callable(read)
            read()

        return fuzz.Reader(fuzzed)

    def refuses() -> None:
        Path("left").write_text("")
        raise fuzz.ConfigError("no")

    def lines() -> None:
        raise WriteError(errno.ENOSPC, "full", "two\nlines")

    assert fuzz.once(of(lambda: 1 // 0), 0)[0] == "traceback"
    assert fuzz.once(of(lines), 0)[0] == "traceback"
    assert fuzz.once(of(refuses), 0)[0] == "files"
    assert fuzz.once(of(lambda: None), 0)[0] == "accepted"


def test_a_file_that_opencascade_dies_of(tmp_path: Path) -> None:
    """Found by ``scripts/fuzz``; the process that reads it is another one."""
    seed = 20019
    good = fuzz.EXAMPLES / "half_round_finger.step"
    rng = random.Random(seed)
    rng.choice([good])
    file = tmp_path / "part.step"
    file.write_bytes(fuzz.damaged(good.read_bytes(), rng))
    with pytest.raises(MeshError, match=r"part\.step: damaged: OpenCASCADE ends by SIG"):
        adopt(file, Asked(), MeshRequest())
