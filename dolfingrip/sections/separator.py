"""The separator of a CSV file: a comma. Spreadsheets of some languages write another one."""

from __future__ import annotations

from typing import Final

from dolfingrip.sections.errors import ConfigError

OTHERS: Final = {";": "semicolons", "\t": "tabs"}
"""Other separators, and their names."""


def check_separator(told: str, header: str) -> None:
    """Refuse a table whose entries are not separated by commas.

    Args:
        told: option and file that the message begins with.
        header: first line of the table.

    Raises:
        ConfigError: one line.
    """
    for character, name in OTHERS.items():
        if header.count(character) > header.count(","):
            raise ConfigError(
                f"{told}: its entries are separated by {name}; allowed: commas, with a point "
                "before decimals"
            )
