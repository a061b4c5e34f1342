"""Collects the tests, each file as if it were the only one.

Before each file the path for imports is put back, and what other files imported of ``tests`` and
``benchmarks`` is forgotten. So a file that imports what another file has to find first is an error
here, not only where somebody runs it alone.
"""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOT_INSTALLED = (f"{ROOT}/tests", f"{ROOT}/benchmarks")


def _is_not_installed(module: object) -> bool:
    """Tell if a module can be imported by its place alone; conftest files are pytest's own."""
    spec = getattr(module, "__spec__", None)
    if not isinstance(spec, ModuleSpec) or spec.name.endswith("conftest"):
        return False
    places = [spec.origin or ""] if spec.has_location else []
    places += spec.submodule_search_locations or ()
    return any(place.startswith(NOT_INSTALLED) for place in places)


class Alone:
    """Plugin of pytest that makes each file find what a process of its own has."""

    def pytest_sessionstart(self) -> None:
        self.path = list(sys.path)

    def pytest_collectstart(self, collector: pytest.Collector) -> None:
        if isinstance(collector, pytest.Module):
            sys.path[:] = self.path
            for name in [name for name, each in sys.modules.items() if _is_not_installed(each)]:
                del sys.modules[name]


if __name__ == "__main__":
    options = ["--collect-only", "-qq", "-n", "0", "-m", ""]
    options += [str(ROOT / "tests"), str(ROOT / "benchmarks" / "tests")]
    sys.exit(pytest.main(options, plugins=[Alone()]))
