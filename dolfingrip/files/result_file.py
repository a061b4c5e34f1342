"""Result files: JSON of a declared content, with a version.

A result file is one class in a file of this package. Its maker calls :meth:`ResultFile.write`;
reports, the explorer and users call :meth:`ResultFile.read`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, Self, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from dolfingrip.files import whole
from dolfingrip.files.text_table import TextTable


class ResultFileError(ValueError):
    """One line about a file of results that cannot be read."""


@contextmanager
def reading(file: Path) -> Iterator[None]:
    """Make one line of whatever a damaged file of results leads to.

    Args:
        file: that is read.

    Yields:
        Nothing; the file is read meanwhile.

    Raises:
        ResultFileError: one line.
    """
    try:
        yield
    except ResultFileError:
        raise
    except OSError as error:
        raise ResultFileError(f"{file}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError) as error:
        why = str(error).removeprefix(f"{file}: ")
        raise ResultFileError(f"{file}: damaged: {why}") from None


class Part(BaseModel):
    """A part of a result file; keys that it does not know are left out when it is read."""

    model_config = ConfigDict(extra="ignore", populate_by_name=True, frozen=True)


class ResultFile(Part):
    """A file of results in its folder.

    A subclass has ``schema_version``, which rises if a key changes its meaning or goes.

    Attributes:
        FILE: its name.
        MADE_BY: command that makes it, for messages.
    """

    FILE: ClassVar[str]
    MADE_BY: ClassVar[str]

    @classmethod
    def is_in(cls, folder: Path) -> bool:
        """Tell whether a folder has this file.

        Args:
            folder: that is looked into.
        """
        return (folder / cls.FILE).is_file()

    @classmethod
    def read(cls, folder: Path | str) -> Self:
        """Read the file.

        Args:
            folder: folder that has it, or the file itself.

        Returns:
            Its content.

        Raises:
            ResultFileError: one line, if there is none, or one that another version wrote, or its
                content is not that of such a file.
        """
        file = Path(folder)
        file = file if file.suffix == ".json" else file / cls.FILE
        try:
            content = json.loads(file.read_text(encoding="utf-8"))
        except OSError as error:
            raise ResultFileError(f"{file}: {error.strerror}") from None
        except (ValueError, RecursionError) as error:
            raise ResultFileError(f"{file}: not JSON: {error}") from None
        if not isinstance(content, dict):
            raise ResultFileError(f"{file}: no JSON object; allowed: a file that dolfingrip wrote")
        (supported,) = get_args(cls.model_fields["schema_version"].annotation)
        version = content.setdefault("schema_version", 1)
        if version != supported:
            raise ResultFileError(
                f"{file}: schema_version = {version}; allowed: {supported}; "
                f"{cls.MADE_BY} of this version writes it"
            )
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(map(str, first["loc"]))
            raise ResultFileError(f"{file}: {key}: {first['msg']}") from None

    def write(self, folder: Path | str) -> Path:
        """Write the file; one that is there is replaced.

        Args:
            folder: where it is written.

        Returns:
            The file.

        Raises:
            WriteError: one line.
        """
        file = Path(folder) / self.FILE
        whole.write(file, self.text())
        return file

    def text(self) -> str:
        """The file's text."""
        return self.model_dump_json(indent=1, by_alias=True) + "\n"

    def overview(self) -> TextTable:
        """Return the table of texts and numbers, with their meaning, that a reader sees first."""
        shown = {name: getattr(self, name) for name in type(self).model_fields}
        rows = [
            [name, f"{value:.6g}" if isinstance(value, float) else str(value),
             type(self).model_fields[name].description or ""]
            for name, value in shown.items() if isinstance(value, str | int | float)
        ]  # fmt: skip
        return TextTable(["", "value", "meaning"], rows, f"{self.FILE} of {self.MADE_BY}")

    def tables(self) -> list[TextTable]:
        """List parts as tables."""
        return []

    def __repr__(self) -> str:
        """The overview, as a console shows it."""
        return self.overview().text()

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """The overview and all tables, as a notebook shows them."""
        return "\n".join(table.html() for table in (self.overview(), *self.tables()))

    def plain(self) -> dict[str, Any]:
        """The content as the file has it."""
        content: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        return content
