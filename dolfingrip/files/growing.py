"""Text files that grow line by line while something goes on."""

from __future__ import annotations

import os
from pathlib import Path

from dolfingrip.files import whole


class GrowingFile:
    """A text file whose lines are whole at any moment; nothing is buffered.

    Args:
        path: target; an existing file is replaced.
        head: text at its start.

    Raises:
        WriteError: one line, if it cannot be written; an existing file stays as it was.
    """

    def __init__(self, path: Path, head: str) -> None:
        whole.write(path, head)
        self._path = path
        try:
            self._handle = os.open(path, os.O_WRONLY | os.O_APPEND)
            os.lseek(self._handle, 0, os.SEEK_END)
        except OSError as error:
            raise whole.failed(path, error) from error

    def append(self, text: str) -> None:
        """Append whole lines.

        Args:
            text: lines, each with its end.

        Raises:
            WriteError: one line; the file then ends as before.
        """
        try:
            whole.append(self._handle, text.encode())
        except OSError as error:
            raise whole.failed(self._path, error) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._handle)
