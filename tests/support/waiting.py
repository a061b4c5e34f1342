"""A job that says where it runs, and waits."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

from dolfingrip.jobs.single import tell

PATH = "support.waiting:wait"


def wait(start: str, seconds: float) -> dict[str, Any]:
    """A job: say where it runs, and wait."""
    Path(start).write_text(str(os.getpid()), encoding="ascii")
    tell(1, 2, "waiting")
    time.sleep(seconds)
    return {"waited_s": seconds}
