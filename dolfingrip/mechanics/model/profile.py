"""Wall time and counts by phase, for ``run.json``."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass(slots=True)
class Profile:
    """Seconds and visits by phase.

    Phases may nest: an inner phase's time is its own and not the outer one's, so that the
    seconds add up to what was spent.
    """

    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    visits: Counter[str] = field(default_factory=Counter)
    _inner: list[float] = field(default_factory=list)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time spent inside to ``name`` and count the visit."""
        start = time.perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            spent = time.perf_counter() - start
            self.seconds[name] += spent - self._inner.pop()
            self.visits[name] += 1
            if self._inner:
                self._inner[-1] += spent

    def as_dict(self) -> dict[str, dict[str, float | int]]:
        """``{phase: {wall_s, calls}}``, the longest first."""
        order = sorted(self.visits, key=lambda name: -self.seconds[name])
        return {
            name: {"wall_s": round(self.seconds[name], 4), "calls": self.visits[name]}
            for name in order
        }
