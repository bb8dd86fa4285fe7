# SPDX-License-Identifier: Apache-2.0
"""Who may write a journal: one process, by a lock that dies with it, as far as the system gives it files."""

from __future__ import annotations

import errno
import fcntl
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rai_missions.errors import UsageError, irregular, make_folder_of, meant_file

__all__ = ("FILES", "Lock", "file_id", "in_place_of", "may_open", "out_of_files", "writing_at")

FILES = 3
"""The files of a journal that is made: its lock, its database and the log."""


@contextmanager
def writing_at(path: Path, what: str = "a journal") -> Iterator[None]:
    """Raise what the system refuses while a file is written as an error that names the file.

    Args:
        path: The file.
        what: What it is, with its article.

    Raises:
        UsageError: It cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"{what} cannot be written at {path}: {error.strerror}; name another file") from None


class Lock:
    """The right to write a journal: held by one process, given back by its end, however it ends.

    Two readings of one file in one process share SQLite's own locks, and closing any descriptor of the file would drop
    them; that is why anyone who reads in the process that writes reads through this descriptor.

    Raises:
        UsageError: Someone else has it, or the file cannot be opened for writing.
    """

    held: dict[tuple[int, int], int] = {}  # noqa: RUF012 - one table a process is the point
    """(device, inode) → descriptor, of the journals this process writes."""

    def __init__(self, path: Path, *, new: bool) -> None:
        if not new and irregular(path):
            raise UsageError(f"no journal at {path}: {in_place_of(path)}")
        if new:
            with writing_at(path):
                make_folder_of(path)
        try:
            if not new and file_id(path) in self.held:
                raise UsageError(f"{path} is being written by this process already; close that journal first")
            self.descriptor = os.open(path, os.O_RDWR | (os.O_CREAT | os.O_EXCL if new else 0), 0o644)
        except FileExistsError:
            if sort := irregular(path):
                raise UsageError(f"a journal cannot be written at {path}: that is {sort}; name another file") from None
            raise UsageError(
                f"{path} is there already, and a journal is never overwritten; name another file"
            ) from None
        except OSError as error:
            cure = out_of_files() or f"{error.strerror}; name another file"
            raise UsageError(f"a journal cannot be written at {path}: {cure}") from None
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self.descriptor)
            raise UsageError(
                f"{path} is being written by another process; wait for its end or name another file"
            ) from None
        self._key = file_id(path)
        self.held[self._key] = self.descriptor

    def is_of(self, path: Path) -> bool:
        """Whether the file that has a name now is the one that is locked."""
        try:
            return file_id(path) == self._key
        except OSError:
            return False

    def release(self) -> None:
        """Give it back; doing so twice changes nothing."""
        if self.held.pop(self._key, None) is not None:
            os.close(self.descriptor)


def in_place_of(path: Path) -> str:
    """What there is where a journal was expected."""
    sort = irregular(path)
    return f"that is {sort}" if sort else f"there is no such file{meant_file(path, '.journal')}"


def file_id(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_dev, found.st_ino


def out_of_files() -> str:
    """The cure where this process may not open the files of a journal; empty where it may."""
    if may_open(FILES):
        return ""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return f"this process may open {most} files, and a journal takes one to three; raise `ulimit -n`"


def may_open(count: int) -> bool:
    """Whether this process may open so many files more."""
    opened: list[int] = []
    try:
        for _ in range(count):
            opened.append(os.open(os.devnull, os.O_RDONLY))
    except OSError as error:
        return error.errno != errno.EMFILE
    finally:
        for descriptor in opened:
            os.close(descriptor)
    return True
