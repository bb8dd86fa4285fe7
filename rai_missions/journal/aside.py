# SPDX-License-Identifier: Apache-2.0
"""A journal that gets another name, so that another run may have its old one.

Rule: nothing of it is lost by that: the log beside its file is folded in first, and one that is being written stays.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from rai_missions.errors import UsageError
from rai_missions.journal.chain import read
from rai_missions.journal.database import Lock, SqliteError, Unbegun, log_of, open_to_write

__all__ = ("set_aside",)


def set_aside(path: Path, to: Path) -> None:
    """Rename a journal, or a file in which one was begun.

    Raises:
        UsageError: Another process writes it, or its log cannot be folded in.
        DefinitionError: It is no journal, or it was altered.
    """
    lock = Lock(path, new=False)
    try:
        with suppress(Unbegun):  # no row is in it, so none can be lost
            read(path).close()
            _fold_in(path)
        path.rename(to)
    finally:
        lock.release()


def _fold_in(path: Path) -> None:
    """SQLite does so when whoever writes closes the file, and takes the log away."""
    log = log_of(path)
    if not log.exists():
        return
    with suppress(SqliteError):
        open_to_write(path, new=False).close()
    if log.exists():
        raise UsageError(f"what {log.name} holds cannot be written into {path}, so it is not moved aside; name another")
