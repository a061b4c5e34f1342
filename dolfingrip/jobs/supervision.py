"""Supervision of a local Dask worker that dies while it still starts.

Dask's own supervisor process, the Nanny, restarts a worker that dies at work. It gives up the whole
cluster where a worker dies before it was ready for the first time.
"""

from __future__ import annotations

import asyncio
from typing import Any

from distributed import Nanny, Status

from dolfingrip.jobs.job import WorkerPolicy


class WorkerSupervisor(Nanny):
    """Restarts a worker that died while it started."""

    def __init__(
        self, *addresses: Any, policy: WorkerPolicy = WorkerPolicy(), **options: Any
    ) -> None:
        self._policy = policy
        super().__init__(*addresses, **options)

    async def instantiate(self) -> Any:
        """Start the worker and return the state in which that ended."""
        status = await super().instantiate()
        for _ in range(self._policy.starts - 1):
            # once it runs, Dask itself notices that the worker dies
            if status == Status.running or self.status not in (Status.init, Status.starting):
                break
            status = await super().instantiate()
        return status

    async def _on_worker_exit(self, exitcode: int) -> None:
        # Dask drops the report of a death between the worker's start and its supervisor's
        while self.status in (Status.init, Status.starting):
            await asyncio.sleep(self._policy.start_check_s)
        if not self.is_alive():
            await super()._on_worker_exit(exitcode)
