"""Expressions at the integration points, and how often they are compiled."""

from __future__ import annotations

from typing import Any

import cffi
import pytest
from support import bodies


def test_a_second_model_compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """What UFL counts through the process is no part of what a model is compiled as."""

    def evaluated() -> None:
        solid = bodies.body(bodies.hollow_cube(), 1)
        solid.energy()
        solid.gradient()
        solid.tangent()  # with the carried stress
        assert solid.model.potential.smallest_jacobian() == 1.0

    evaluated()

    def compiled(*args: Any, **kwargs: Any) -> None:
        raise AssertionError("compiled anew")

    monkeypatch.setattr(cffi.FFI, "compile", compiled)
    evaluated()
