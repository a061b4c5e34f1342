"""Processor seconds of a whole command around a short run, by what they go into.

    scripts/run python -m benchmarks.short_run

The command is ``dolfingrip bend --pressure 1`` with its forms compiled. Beside it stand an import
of the package and the help. Each is the least of several processes.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile

ROUNDS = 5
STARTS = {
    "import dolfingrip": "import dolfingrip",
    "dolfingrip --help": """
import sys
from dolfingrip.cli.app import main
sys.argv = ["dolfingrip", "--help"]
main()
""",
}
SHORT_RUN = """
import json, sys, time

spent = {}

def counted(module, name, title):
    function = getattr(module, name)
    def call(*given, **named):
        before = time.process_time()
        try:
            return function(*given, **named)
        finally:
            spent[title] = time.process_time() - before
    setattr(module, name, call)

from dolfingrip.cli import experiment_commands
from dolfingrip.cli.app import main

counted(experiment_commands, "_run", "the run")
counted(experiment_commands, "_pictures", "the picture")
sys.argv = ["dolfingrip", "bend", "--pressure", "1", "--out", sys.argv[1]]
try:
    main()
finally:
    whole = time.process_time()
    print(json.dumps({"whole command": whole, **spent,
                      "the rest, mostly imports": whole - sum(spent.values())}))
"""


def processor_s(code: str, folder: str) -> tuple[float, str]:
    """Processor seconds of a Python that runs some code (s), and what it printed last."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run(
        [sys.executable, "-c", code, folder], cwd=folder, env=os.environ, check=True,
        capture_output=True, text=True,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return spent, ended.stdout.splitlines()[-1] if ended.stdout else ""


def main() -> None:
    """Print the least processor seconds of each."""
    found: list[dict[str, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        processor_s(SHORT_RUN, folder)  # compiles what is not yet compiled
        for _ in range(ROUNDS):
            turn = {name: processor_s(code, folder)[0] for name, code in STARTS.items()}
            found.append(turn | json.loads(processor_s(SHORT_RUN, folder)[1]))
    for name in found[0]:
        print(f"{name}: {min(turn[name] for turn in found):.2f} s")


if __name__ == "__main__":
    main()
