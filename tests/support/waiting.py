"""A job that says where it runs, and waits."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

from dolfingrip.jobs.single import tell

PATH = "support.waiting:wait"


def wait(start: str, seconds: float, every_s: float = 0.0) -> dict[str, Any]:
    """A job: say where it runs, and wait; tell of it every so often where that is asked for."""
    Path(start).write_text(str(os.getpid()), encoding="ascii")
    tell(1, 2, "waiting")
    ends = time.monotonic() + seconds
    while every_s and time.monotonic() < ends:
        time.sleep(every_s)
        tell(1, 2, "waiting")
    time.sleep(max(0.0, ends - time.monotonic()))
    return {"waited_s": seconds}
