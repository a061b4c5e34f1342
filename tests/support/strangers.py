"""A stranger's folder: files that some library would read or run, and which of them are opened."""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SETTINGS = {
    ".gmsh-options": 'SystemCall "touch {trace}";',
    ".gmshrc": 'SystemCall "touch {trace}";',
    ".petscrc": "-info {trace}",
    "petscrc": "-info {trace}",
    "ucx.conf": "UCX_LOG_FILE={trace}",
    "dolfinx_jit_options.json": "{{",
    "ffcx_options.json": "{{",
    "matplotlibrc": "backend: module://signal",
    "ezdxf.ini": "[core]",
    "XSTEP.us": "xstep.cascade.unit : M",
    "SHAPE.us": "",
}
"""What libraries read in the working folder or in the user's home."""

MODULES = ("gmsh.py", "ipctk.py", "json.py", "multiprocessing.py", "numpy.py", "signal.py")
"""What Python imports from the working folder where it is called with ``-m`` or ``-c``."""

BESIDE = (".opt", ".geo", ".pos", ".py")
"""What is put behind a file's name, and in the place of its ending."""

_IN_OPEN, _IN_NONBLOCK = 0x20, 0o4000


def plant(folder: Path, trace: Path, *, modules: bool = True) -> list[Path]:
    """Plant settings and modules.

    Args:
        folder: gets them.
        trace: what appears where a planted file is run.
        modules: plant modules, too.

    Returns:
        What was planted.
    """
    contents = {name: text.format(trace=trace) for name, text in SETTINGS.items()}
    if modules:
        contents |= dict.fromkeys(MODULES, f"open({str(trace)!r}, 'w')\n")
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in contents]


def plant_beside(file: Path, trace: Path) -> list[Path]:
    """Plant scripts beside a file, by whose name Gmsh finds them.

    Args:
        file: that will be read.
        trace: what appears where a planted file is run.

    Returns:
        What was planted.
    """
    planted = [
        place for ending in BESIDE for place in (Path(f"{file}{ending}"), file.with_suffix(ending))
    ]
    for each in planted:
        each.write_text(f'SystemCall "touch {trace}";\n', encoding="utf-8")
    return planted


@contextmanager
def opened(files: list[Path]) -> Iterator[set[str]]:
    """Watch files by Linux' inotify.

    Args:
        files: that are watched.

    Yields:
        Names of those that any process has opened, once the block has ended.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    queue = libc.inotify_init1(_IN_NONBLOCK)
    assert queue >= 0, os.strerror(ctypes.get_errno())
    found: set[str] = set()
    try:
        names = {libc.inotify_add_watch(queue, os.fsencode(f), _IN_OPEN): f.name for f in files}
        assert min(names) >= 0, os.strerror(ctypes.get_errno())
        yield found
        try:
            while events := os.read(queue, 1 << 16):
                at = 0
                while at < len(events):
                    watch, _, _, more = struct.unpack_from("iIII", events, at)
                    found.add(names[watch])
                    at += 16 + more
        except BlockingIOError:  # no more events
            pass
    finally:
        os.close(queue)
