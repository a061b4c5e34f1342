"""Dask's nanny of a worker process here, for a worker that dies while it still starts.

Dask's own starts a worker again that died at work, but gives up the whole cluster where one dies
before it first was ready.
"""

from __future__ import annotations

import asyncio
from typing import Any

from distributed import Nanny, Status

STARTS = 10
"""How often a worker is started before it first is ready."""

_LOOK_EVERY_S = 0.05


class PatientNanny(Nanny):
    """Starts a worker again that died while it started."""

    async def instantiate(self) -> Any:
        """Start the worker; the state in which that ended."""
        status = await super().instantiate()
        for _ in range(STARTS - 1):
            # once it runs, the nanny is told when the worker dies, and this is not needed
            if status == Status.running or self.status not in (Status.init, Status.starting):
                break
            status = await super().instantiate()
        return status

    async def _on_worker_exit(self, exitcode: int) -> None:
        # Dask drops the news of a death that falls between the worker's start and the nanny's
        while self.status in (Status.init, Status.starting):
            await asyncio.sleep(_LOOK_EVERY_S)
        if not self.is_alive():
            await super()._on_worker_exit(exitcode)
