"""Folders of the cache: what lies there is run, so nobody but their owner may write to them."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from dolfingrip.sections.errors import ConfigError


def cache_folder(*names: str) -> Path:
    """Make a folder of the cache that nobody else may write to.

    The cache is ``$XDG_CACHE_HOME``, or ``.cache`` in the user's home.

    Args:
        names: of the folder, and of those that it lies in.

    Returns:
        The folder, without symbolic links.

    Raises:
        ConfigError: one line, where another user could write to the folder or put another one in
            its place, or where it cannot be made.
    """
    given = os.environ.get("XDG_CACHE_HOME")
    try:
        cache = Path(given) if given else Path.home() / ".cache"
    except RuntimeError:
        raise ConfigError("cache: this user has no home; allowed: XDG_CACHE_HOME") from None
    folder = cache.joinpath(*names).resolve()
    chain = [folder, *folder.parents]
    try:
        _check(folder, [path for path in chain if path.exists()])
        for path in reversed(chain):
            if not path.exists():
                path.mkdir(mode=0o700, exist_ok=True)
        _check(folder, chain)  # somebody may have come between
    except OSError as error:
        raise ConfigError(f"cache {folder}: {error.strerror}; {_ALLOWED}") from None
    return folder


_ALLOWED = "allowed: a folder of your own that nobody else may write to (XDG_CACHE_HOME names one)"


def _check(folder: Path, chain: list[Path]) -> None:
    """Refuse a folder that another user could write to, or put another one in its place."""
    system = os.stat("/proc").st_uid  # in a user namespace root has another number
    for path in chain:
        status = path.stat()
        inner = path == folder
        if status.st_uid != os.geteuid() and (inner or status.st_uid != system):
            raise ConfigError(f"cache {folder}: {path} belongs to another user; {_ALLOWED}")
        # in a folder with the sticky bit, as /tmp, each may rename only what is theirs
        if status.st_mode & 0o022 and (inner or not status.st_mode & stat.S_ISVTX):
            raise ConfigError(f"cache {folder}: others may write to {path}; {_ALLOWED}")
