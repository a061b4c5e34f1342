"""Connections that begin a request and do not end it: few at a time, and for some seconds."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

from dolfingrip.explore.policy import POLICY


class Patience(H11Protocol):
    """An HTTP connection that is ended where its request does not arrive.

    The newest may always come: where too many wait, the one that has waited longest is ended.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take up a connection."""
        super().connection_made(transport)
        self._since = self.loop.time()
        waiting = [c for c in self.connections if isinstance(c, Patience) and c.half_open]
        if len(waiting) > POLICY.half_open:
            min(waiting, key=lambda c: c._since).transport.abort()
        self.loop.call_later(POLICY.request_s, self._look)

    @property
    def half_open(self) -> bool:
        """Whether a request has begun, or is the first to come, and has not arrived."""
        cycle: Any = self.cycle
        if cycle is None:
            return True
        return bool(cycle.response_complete) and self.timeout_keep_alive_task is None

    def _look(self) -> None:
        if self not in self.connections:  # it has ended, or is a websocket
            return
        if self.half_open:
            self.transport.abort()
        else:
            self.loop.call_later(POLICY.request_s, self._look)
