"""Packages of parts that others made: 3MF and XLSX, which are ZIP archives of XML.

An archive of a few kilobytes can unpack to more than a machine's memory, so its own table of
contents is looked at before anything is unpacked. Python's ``zipfile`` unpacks no more of a part
than the table says.

Source: Open Packaging Conventions, ECMA-376-2.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile, ZipFile


class PackageError(ValueError):
    """One line about a package that is damaged, or larger than it may be."""


@dataclass(frozen=True, slots=True)
class PackagePolicy:
    """How large a package may be.

    A sheet of a million rows, or a part of some million triangles, has 0.1 to 0.4 GB of XML, which
    is packed to a tenth, and to a fiftieth where most of it repeats.

    Attributes:
        parts: most parts.
        unpacked_bytes: most bytes of all parts, unpacked.
        ratio: most bytes unpacked for each byte of the file.
        small_bytes: unpacked size up to which the ratio does not matter.
    """

    parts: int = 10_000
    unpacked_bytes: int = 1 << 29
    ratio: int = 200
    small_bytes: int = 1 << 20


@contextmanager
def opened(path: Path, policy: PackagePolicy = PackagePolicy()) -> Iterator[ZipFile]:
    """Open a package whose table of contents keeps to the limits.

    Args:
        path: the file.
        policy: the limits.

    Yields:
        The archive; an error of its parts becomes one line.

    Raises:
        PackageError: one line.
        OSError: where the file cannot be read.
    """
    try:
        with ZipFile(path) as packed:
            _check(packed, path.stat().st_size, policy)
            yield packed
    except PackageError:
        raise
    # of the format, of its compression, encrypted, of a kind of compression that Python lacks
    except (BadZipFile, zlib.error, EOFError, RuntimeError) as error:
        raise PackageError(f"damaged archive: {error}") from None


def _check(packed: ZipFile, size: int, policy: PackagePolicy) -> None:
    parts = packed.infolist()
    unpacked = sum(part.file_size for part in parts)
    if len(parts) > policy.parts:
        raise PackageError(f"archive of {len(parts)} parts; allowed: up to {policy.parts}")
    if unpacked > policy.unpacked_bytes:
        raise PackageError(
            f"archive of {unpacked / 1e6:.0f} MB unpacked; allowed: up to "
            f"{policy.unpacked_bytes / 1e6:.0f} MB"
        )
    if unpacked > max(policy.ratio * size, policy.small_bytes):
        raise PackageError(
            f"archive that unpacks to {unpacked / size:.0f} times its size; allowed: up to "
            f"{policy.ratio} times"
        )
