"""How a browser gets the server's address: by a file that its user alone may read.

The address has the token, so it stands neither in the folder of results, which may be sent to
others, nor in the browser's command line, which every user of the machine can read.
"""

from __future__ import annotations

import hashlib
import html
import os
import re
from dataclasses import dataclass
from pathlib import Path

from dolfingrip.files import whole
from dolfingrip.sections.private import cache_folder


@dataclass(frozen=True, slots=True)
class Handover:
    """The file of the server whose solutions are in a folder.

    Attributes:
        file: HTML that leads to the address.
    """

    file: Path

    @staticmethod
    def of(solutions: Path) -> Handover:
        """The file for a folder of solutions.

        Raises:
            ConfigError: one line, where another user could write to the cache.
        """
        name = hashlib.sha256(os.fsencode(solutions.resolve())).hexdigest()[:16]
        return Handover(cache_folder("dolfingrip", "explore") / f"{name}.html")

    def write(self, address: str) -> None:
        """Lead to an address.

        Args:
            address: of the server, with the token.

        Raises:
            WriteError: one line.
        """
        whole.write(self.file, leading_to(address), mode=0o600)

    def before(self) -> tuple[int, str] | None:
        """Port and token of the server that wrote the file last; None if none did."""
        try:
            text = self.file.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        found = re.search(r'href="http://[^/"]+:(\d+)/\?token=([\w-]{32,})"', text)
        return (int(found[1]), found[2]) if found else None


def leading_to(address: str) -> str:
    """An HTML page that leads to an address.

    Args:
        address: of a page, absolute or on the same server.
    """
    shown = html.escape(address)
    return (
        '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
        f'<meta http-equiv="refresh" content="0;url={shown}"><title>dolfingrip explore</title>'
        f'<a href="{shown}">the explorer</a>\n'
    )
