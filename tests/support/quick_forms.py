"""How forms are compiled for a few seconds' run: those of tests, and of all stages of CI.

    eval "$(scripts/run python tests/support/quick_forms.py)"

sets it in a shell.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import subprocess
import sysconfig
from pathlib import Path
from typing import Final

LEVEL: Final = "1"
"""Of the compiler's optimisation: in a fourth of level 3's time."""

HEADER: Final = """#define _CFFI_
#define Py_LIMITED_API
#include <Python.h>
"""
"""What the source of each compiled form begins with: half of a small form's time."""

COMPILER: Final = [
    # Registers are allocated at once, not loop by loop, and in kernels of more than 1,000
    # instructions by the simple method that gcc otherwise keeps for a million: the search takes
    # half of a long kernel's time, by its square, and kernels run 5 % faster by it.
    "-fira-region=one", "--param", "ira-simple-lra-insn-threshold=1",
    # Loops of element matrices in vector instructions, where their lengths are known: kernels in
    # half the time for a fourteenth of the compiler's.
    "-ftree-loop-vectorize", "-fvect-cost-model=very-cheap",
]  # fmt: skip
"""What suits such forms, beside the level."""


def set_level() -> None:
    """Set the level, which the package reads when it is first imported."""
    os.environ.setdefault("DOLFINGRIP_OPTIMISATION", LEVEL)


def flags() -> str:
    """Return CFLAGS by which forms take Python's header as it was compiled before.

    Returns:
        The options; "" where the header cannot be compiled.
    """
    from dolfingrip.mechanics.model import jit

    variables = sysconfig.get_config_vars()
    call = [*shlex.split(variables["CC"]), *shlex.split(variables["CFLAGS"]), "-fPIC", "-std=c17"]
    call += [*COMPILER, *jit.FLAGS, f"-I{sysconfig.get_path('include')}"]
    key = hashlib.sha256(f"{call} {HEADER}".encode()).hexdigest()[:12]
    file = Path(jit.options()["cache_dir"]) / "header" / f"{key}.h"
    compiled = file.with_name(f"{file.name}.gch")
    if not compiled.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(HEADER, encoding="utf-8")
        made = compiled.with_suffix(f".{os.getpid()}")
        call += ["-x", "c-header", str(file), "-o", str(made)]
        if subprocess.run(call, capture_output=True, check=False).returncode != 0:
            return ""
        made.replace(compiled)
    return f"{variables['CFLAGS']} {' '.join(COMPILER)} -include {file}"


if __name__ == "__main__":
    set_level()
    print(f"export DOLFINGRIP_OPTIMISATION={LEVEL} CFLAGS={shlex.quote(flags())}")
