"""The writer of files on disks that are full, with libraries that fail without a word."""

from __future__ import annotations

import pickle
import re
from contextlib import suppress
from pathlib import Path

import pytest
from support.disks import Disk, MemoryDisk

from dolfingrip.files import table, whole
from dolfingrip.files.whole import GrowingFile, WriteError

BEFORE = b"what was there before"


def test_the_missing_bytes_are_told(each_disk: Disk) -> None:
    target = each_disk.folder / "target.txt"
    target.write_bytes(BEFORE)
    with each_disk.full(left=4096), pytest.raises(WriteError) as caught:
        whole.write(target, "ä" * 50_000)
    said = re.fullmatch(
        rf"{target}: cannot be written: {each_disk.reason}; ([\d,]+) of 100,000 bytes are missing",
        str(caught.value),
    )
    assert said
    missing = int(said[1].replace(",", ""))
    assert 100_000 - 8192 <= missing <= 100_000 - 4096 + (4096 * isinstance(each_disk, MemoryDisk))
    assert each_disk.contents() == {"target.txt": BEFORE}


def test_a_library_that_tells_nothing_is_found_out(each_disk: Disk) -> None:
    """Its file ends where the disk did."""
    target = each_disk.folder / "target.bin"
    target.write_bytes(BEFORE)

    def wrong(file: Path) -> bool:
        return file.stat().st_size == 100_000

    with (
        each_disk.full(left=8192),
        pytest.raises(WriteError, match=rf"target\.bin: .*{each_disk.reason}; [\d,]+ bytes were"),
        whole.replacing(target, check=wrong) as (partial,),
    ):
        _write_without_a_word(partial)
    assert each_disk.contents() == {"target.bin": BEFORE}


def _write_without_a_word(file: Path) -> None:
    """Write 100,000 bytes, as far as they go."""
    assert file.suffix == ".bin"
    with suppress(OSError), file.open("wb", buffering=0) as stream:
        for _ in range(25):
            stream.write(bytes(4000))


def test_a_library_that_fails_without_a_reason(each_disk: Disk) -> None:
    target = each_disk.folder / "target.bin"
    for error in (RuntimeError("some library's"), OSError("8 requested and 3 written")):
        with (
            each_disk.full(),
            pytest.raises(WriteError, match=f"cannot be written: {each_disk.reason}; 0 bytes"),
            whole.replacing(target),
        ):
            raise error
    assert not each_disk.contents()


def test_errors_that_are_not_of_the_disk_stay(tmp_path: Path) -> None:
    target = tmp_path / "target.txt"
    target.write_bytes(BEFORE)
    with pytest.raises(ZeroDivisionError), whole.replacing(target):
        raise ZeroDivisionError
    with pytest.raises(KeyboardInterrupt), whole.stream(target):
        raise KeyboardInterrupt
    with pytest.raises(WriteError, match=r"it is not whole when read back$"):
        whole.write(target, "short", check=lambda file: file.stat().st_size > 5)
    with pytest.raises(
        WriteError, match=r"not whole when read back \(integer division or modulo by zero\)$"
    ):
        whole.write(target, "short", check=lambda file: 1 // 0 > 0)
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [BEFORE]


def test_files_that_belong_together(each_disk: Disk) -> None:
    """The first has room, the second has none: both stay as they were."""
    first, second = each_disk.folder / "first", each_disk.folder / "second"
    whole.write_together({first: "a", second: "b"})
    with each_disk.full(left=4096), pytest.raises(WriteError, match="second: cannot be written"):
        whole.write_together({first: "c", second: "d" * 50_000})
    assert each_disk.contents() == {"first": b"a", "second": b"b"}
    whole.write_together({first: "c", second: "d"})
    assert each_disk.contents() == {"first": b"c", "second": b"d"}


def test_a_growing_file_ends_with_a_whole_line(each_disk: Disk) -> None:
    target = each_disk.folder / "rows.csv"
    target.write_bytes(BEFORE)
    with each_disk.full(), pytest.raises(WriteError, match=r"rows\.csv: .* 4 of 4 bytes are"):
        GrowingFile(target, "a,b\n")
    assert target.read_bytes() == BEFORE
    file = GrowingFile(target, "a,b\n")
    row = table.lines([{"a": "1" * 500, "b": "x"}], ("a", "b"))
    with each_disk.full(left=8192), pytest.raises(WriteError, match=r"of 503 bytes are missing$"):
        _append(file, row, 100)
    lines = target.read_text(encoding="utf-8").splitlines(keepends=True)
    assert len(lines) > 10
    assert lines == ["a,b\n", *[row] * (len(lines) - 1)]
    file.append(row)  # once there is room again
    file.close()
    assert target.read_text(encoding="utf-8").splitlines(keepends=True) == [*lines, row]


def _append(file: GrowingFile, row: str, count: int) -> None:
    for _ in range(count):
        file.append(row)


def test_links_and_permissions_are_kept(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "far" / "file")
    whole.write(tmp_path / "link", "text", mode=0o600)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "far" / "file").read_text(encoding="utf-8") == "text"
    assert (tmp_path / "far" / "file").stat().st_mode & 0o777 == 0o600


def test_the_error_travels_between_processes() -> None:
    error = WriteError(28, "No space left on device", "some/file")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.errno, str(again)) == (WriteError, 28, str(error))
    assert str(error) == "some/file: cannot be written: No space left on device"
