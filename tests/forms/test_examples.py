"""The example in each file of ``forms/`` runs and gives the number that it says."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

from dolfingrip import forms

FILES = sorted(file.stem for file in Path(forms.__path__[0]).glob("[!_]*.py"))


@pytest.mark.parametrize("name", FILES)
def test_example(name: str) -> None:
    found = doctest.testmod(importlib.import_module(f"dolfingrip.forms.{name}"))
    assert found.attempted > 0, "a file without an example"
    assert found.failed == 0
