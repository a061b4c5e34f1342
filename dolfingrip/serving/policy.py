"""The numbers of a server."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class ServingPolicy:
    """How a server listens.

    Attributes:
        port: at which it listens if none is told; the next ones are tried where it is taken.
        ports: how many are tried.
        largest_message: bytes that a page may send at once.
        half_open: connections whose request has not arrived yet, at one time.
        request_s: time that a request may take to arrive.
    """

    port: int = 8760
    ports: int = 20
    largest_message: int = 100_000
    half_open: int = 64
    request_s: float = 10.0


POLICY: Final = ServingPolicy()
