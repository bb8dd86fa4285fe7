# SPDX-License-Identifier: Apache-2.0
"""Where a recording is written: what its file may be called, and what becomes of an earlier one of that name.

Rule: nothing of an earlier run is lost. What is no recording stays as it is, and so does one that is being written.
"""

from __future__ import annotations

import fcntl
from contextlib import suppress
from pathlib import Path
from typing import IO, NamedTuple

from rai_missions.errors import UsageError, install_command, make_folder_of
from rai_missions.journal import free_name

__all__ = ("ENDING", "MAGIC", "RecordingFile", "cannot_write", "check_name", "is_mcap", "make_file")

ENDING = ".mcap"
MAGIC = b"\x89MCAP0\r\n"
"""How a file begins; the MCAP specification."""


class RecordingFile(NamedTuple):
    """A new file, open and locked, and the file that an earlier recording of its name is in now."""

    path: Path
    stream: IO[bytes]
    moved_aside: Path | None = None

    def give_back(self) -> None:
        """Remove the new file, and give the earlier one its name again."""
        with suppress(OSError):  # a full disk keeps what is to be removed
            self.stream.close()
        self.path.unlink(missing_ok=True)
        if self.moved_aside is not None:
            self.moved_aside.rename(self.path)


def cannot_write(path: Path, fault: OSError) -> str:
    """Why a recording cannot be written, in a sentence."""
    return f"a recording cannot be written at {path}: {fault.strerror}; name another file"


def check_name(path: Path) -> None:
    """Whether a recording may be called so, and whether there is what writes it.

    Raises:
        UsageError: It may not, or the library is missing.
    """
    if path.suffix != ENDING:
        name = f"{path.stem or 'run'}{ENDING}"
        raise UsageError(f"a recording is an MCAP file, and '{path.name}' does not end so; name it '{name}'")
    try:
        import mcap  # noqa: F401 - only whether it is there
    except ImportError as fault:
        raise UsageError(f"a recording needs the package mcap ({fault}): {install_command('record')}") from None


def is_mcap(path: Path) -> bool:
    """Whether a file is an MCAP file, by how it begins."""
    if not path.is_file():  # a pipe would keep anyone who opens it
        return False
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def make_file(path: Path) -> RecordingFile:
    """Make a new file; an earlier recording of its name is renamed.

    Raises:
        UsageError: It cannot be made; what has its name is no recording, or is being written.
    """
    check_name(path)
    aside = None
    try:
        make_folder_of(path)
        if path.exists():
            aside = _set_aside(path)
        stream = path.open("xb")
    except OSError as fault:
        if aside is not None:
            aside.rename(path)
        raise UsageError(cannot_write(path, fault)) from None
    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return RecordingFile(path, stream, aside)


def _set_aside(path: Path) -> Path:
    """Rename a recording; gives its new name."""
    if path.is_file():  # a pipe would keep anyone who opens it
        with path.open("rb") as stream:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:  # also while nothing of it has reached the disk
                raise UsageError(f"{path} is being written by another run; wait for its end or name another") from None
            if is_mcap(path):
                return path.rename(free_name(path))
    raise UsageError(f"{path} is there already, and is no recording; name another file")
