"""What a tutorial's kernel does first: ``conf.py`` copies this behind a line with ``CHECKOUT``."""

import os
import subprocess

from IPython.core.magic import register_cell_magic

# the kernel asks programs for colours and bars, which a page does not show
for name in ("CLICOLOR", "FORCE_COLOR"):
    os.environ.pop(name, None)
os.environ.update(TERM="dumb", NO_COLOR="1")
os.chdir(CHECKOUT)  # type: ignore[name-defined]  # noqa: F821


@register_cell_magic
def bash(line: str, cell: str) -> None:
    """``%%bash`` that prints all at once: IPython's breaks lines wherever its pipe was emptied.

    A command that fails ends the tutorial, but with ``--no-raise-error``.
    """
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", cell],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    print(done.stdout, end="")
    if done.returncode and line.strip() != "--no-raise-error":
        raise RuntimeError(f"exit code {done.returncode}")
