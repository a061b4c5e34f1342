"""Wall time and counts by phase, for ``run.json``."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass(slots=True)
class Profile:
    """Seconds and counts by phase; phases do not nest."""

    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    counts: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time spent inside to ``name`` and count the visit."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - start
            self.counts[name] += 1

    def as_dict(self) -> dict[str, dict[str, float | int]]:
        """``{phase: {wall_s, calls}}``, the longest first."""
        order = sorted(self.counts, key=lambda name: -self.seconds[name])
        return {
            name: {"wall_s": round(self.seconds[name], 4), "calls": self.counts[name]}
            for name in order
        }
