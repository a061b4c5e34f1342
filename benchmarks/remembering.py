"""Workers that keep what they were asked for, so that it can be written to a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import of_row
from dolfingrip.jobs.store import Store


@dataclass(frozen=True, slots=True)
class Remembering(Workers):
    """Workers that keep what they were asked for.

    Attributes:
        asked: requests by key, in the order in which they were asked for.
    """

    asked: dict[str, Request] = field(default_factory=dict)

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        """Return answers of requests, which are remembered."""
        self.asked.update({each.key: each for each in requests})
        return Workers.results(self, requests)

    def remembered(self) -> tuple[list[Request], list[Answer]]:
        """Return those requests that have ended, and their answers."""
        with Store(self.store) as store:
            rows = {row["key"]: row for row in store.rows() if row["status"] != "pending"}
        ended = [each for key, each in self.asked.items() if key in rows]
        return ended, [of_row(rows[each.key]) for each in ended]
