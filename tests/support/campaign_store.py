"""Queries of a store that only tests need."""

from __future__ import annotations

from collections import Counter

from dolfingrip.jobs.store import Store


def failures(store: Store) -> dict[str, int]:
    """Number of failed designs by class."""
    return Counter(row["failure_class"] for row in store.rows() if row["status"] == "failed")
