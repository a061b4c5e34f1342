"""The writer of every file: a file is written whole, or what was there before stays.

The content goes into a temporary file beside the target, and from there to the disk; then it takes
the target's name. A failure is a :class:`WriteError`, of one line, and removes the temporary file.
A :class:`GrowingFile` grows by whole lines while something goes on.
"""

from __future__ import annotations

import errno
import io
import os
import secrets
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final

PROBE: Final = bytes(1 << 20)
"""What a disk is tried with that may be full; libraries' buffers are smaller."""

FULL: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS})
"""Kinds of the system's errors that tell of a full or read-only disk, whatever met them."""

Check = Callable[[Path], bool]
"""Says of a file that a library wrote whether all of it is there."""


class WriteError(OSError):
    """One line about a file that could not be written: its path, and why.

    ``errno`` tells the kind, as of any error of the system.
    """

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written: {self.strerror}"


def write(
    path: Path, content: str | bytes, *, check: Check | None = None, mode: int = 0o666
) -> None:
    """Write a file; an existing one is replaced.

    Args:
        path: target; missing folders are made.
        content: text, which is written as UTF-8, or bytes.
        check: reads the file back before it takes the target's name; None: it is not read.
        mode: permissions, of which the user's mask takes some away.

    Raises:
        WriteError: one line, with the number of bytes that were missing.
    """
    with replacing(path, check=check, mode=mode) as (partial,):
        _fill(path, partial, content)


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together: all of them, or none.

    Args:
        contents: text or bytes by target. The targets are replaced in this order, once all
            contents are on the disk.

    Raises:
        WriteError: one line.
    """
    with replacing(*contents) as partials:
        for partial, (path, content) in zip(partials, contents.items(), strict=True):
            _fill(path, partial, content)


@contextmanager
def stream(path: Path) -> Iterator[IO[bytes]]:
    """Write a file by a library that takes a stream.

    Args:
        path: target; an existing file is replaced.

    Yields:
        A stream in memory, which can seek; it is written when the block ends without an error.

    Raises:
        WriteError: one line, with the number of bytes that were missing.
    """
    memory = io.BytesIO()
    yield memory
    write(path, memory.getvalue())


@contextmanager
def replacing(
    *paths: Path, check: Check | None = None, mode: int = 0o666
) -> Iterator[tuple[Path, ...]]:
    """Write files by a library that asks for their names and may fail without a word.

    Args:
        paths: targets; existing files are replaced.
        check: whether a file that was written is whole; None: all are.
        mode: permissions, of which the user's mask takes some away.

    Yields:
        Names of empty files beside the targets, with the same suffixes, one for each target. They
        take the targets' names when the block ends without an error.

    Raises:
        WriteError: one line, also for a library's own error where the disk is full.
    """
    targets = [path.resolve() for path in paths]  # a link stays one
    partials: list[Path] = []
    path = paths[0]
    try:
        for path, target in zip(paths, targets, strict=True):
            if not target.parent.exists():  # a file in its place is told by what opens the target
                target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(f".{secrets.token_hex(6)}.part{path.suffix.lower()}")
            os.close(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
            partials.append(partial)
        yield tuple(partials)
        for path, partial in zip(paths, partials, strict=True):
            require(path, partial, check)
            with partial.open("rb") as file:
                os.fsync(file.fileno())
        for partial, target in zip(partials, targets, strict=True):
            partial.replace(target)
    except WriteError:
        raise
    except Exception as error:
        if not isinstance(error, OSError) or error.errno in (None, *FULL):
            for path, partial in zip(paths, partials, strict=False):
                _require_space(path, partial)
        if isinstance(error, OSError):
            raise failed(path, error) from error
        raise
    finally:
        for partial in partials:
            partial.unlink(missing_ok=True)


def require(path: Path, written: Path, check: Check | None) -> None:
    """Raise unless a file that a library wrote is whole.

    Args:
        path: target, which the error names.
        written: file that was written; it may be the target.
        check: says whether it is whole, and may raise any error where it is not.

    Raises:
        WriteError: one line, which tells a full disk from other reasons.
    """
    if check is None:
        return
    try:
        if check(written):
            return
    except Exception as error:
        reason = f"it is not whole when read back ({error or type(error).__name__})"
    else:
        reason = "it is not whole when read back"
    _require_space(path, written)
    raise WriteError(errno.EIO, reason, str(path))


def ends_with(mark: bytes) -> Check:
    """Make a check of files that end with a mark, but for blanks.

    Args:
        mark: the end of every whole file of a format.

    Returns:
        The check.
    """

    def check(file: Path) -> bool:
        with file.open("rb") as stream:
            stream.seek(max(file.stat().st_size - 1024, 0))
            return stream.read().rstrip().endswith(mark)

    return check


def append(handle: int, content: bytes) -> None:
    """Append to an open file: all of the content, or nothing of it.

    Args:
        handle: descriptor of a file whose place is at its end.
        content: bytes.

    Raises:
        OSError: it tells the number of bytes that were missing.
    """
    begin, left = os.lseek(handle, 0, os.SEEK_CUR), memoryview(content)
    try:
        while left:
            left = left[os.write(handle, left) :]
    except OSError as error:
        os.ftruncate(handle, begin)
        os.lseek(handle, begin, os.SEEK_SET)
        sentence = f"{error.strerror}; {len(left):,} of {len(content):,} bytes are missing"
        raise OSError(error.errno, sentence) from error


def failed(path: Path, error: OSError) -> WriteError:
    """The error of a file that could not be written.

    Args:
        path: target.
        error: of the system.

    Returns:
        One line with the path and the system's reason.
    """
    return WriteError(error.errno or errno.EIO, error.strerror or str(error), str(path))


def _fill(path: Path, partial: Path, content: str | bytes) -> None:
    data = content.encode() if isinstance(content, str) else content
    try:
        with partial.open("wb", buffering=0) as file:
            append(file.fileno(), data)
    except OSError as error:
        raise failed(path, error) from error


def _require_space(path: Path, partial: Path) -> None:
    """Raise if the disk takes no more of a file."""
    size = partial.stat().st_size if partial.is_file() else 0
    try:
        with partial.open("ab", buffering=0) as file:
            append(file.fileno(), PROBE)
            os.ftruncate(file.fileno(), size)
    except OSError as error:
        cause = error.__cause__
        reason = cause.strerror if isinstance(cause, OSError) else error.strerror
        sentence = f"{reason}; {size:,} bytes were written, more are missing"
        raise WriteError(error.errno or errno.EIO, sentence, str(path)) from error


class GrowingFile:
    """A text file whose lines are whole at any moment; nothing is buffered.

    Args:
        path: target; an existing file is replaced.
        head: text at its start.

    Raises:
        WriteError: one line, if it cannot be written; an existing file stays as it was.
    """

    def __init__(self, path: Path, head: str) -> None:
        write(path, head)
        self._path = path
        try:
            self._handle = os.open(path, os.O_WRONLY | os.O_APPEND)
            os.lseek(self._handle, 0, os.SEEK_END)
        except OSError as error:
            raise failed(path, error) from error

    def append(self, text: str) -> None:
        """Append whole lines.

        Args:
            text: lines, each with its end.

        Raises:
            WriteError: one line; the file then ends as before.
        """
        try:
            append(self._handle, text.encode())
        except OSError as error:
            raise failed(self._path, error) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._handle)
