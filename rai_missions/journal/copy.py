# SPDX-License-Identifier: Apache-2.0
"""A journal made of the rows of another: what was carried elsewhere becomes a file that is read as any journal is.

Rule: rows come as they were written, hashes and all; nothing is made good here, so whatever is wrong with them shows.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rai_missions.errors import DefinitionError, Fault
from rai_missions.journal.rows import Blob, Raw
from rai_missions.journal.sqlite import BLOB, ROW, Lock, SqliteError, open_to_write

__all__ = ("copied",)


def copied(path: Path, parts: Iterable[Raw | Blob], source: str) -> None:
    """Write a new journal.

    Args:
        path: Where; must not be there.
        parts: Rows, in any order, and pictures.
        source: Where they come from, for an error.

    Raises:
        DefinitionError: A row that no journal holds, or two of one number.
        UsageError: It cannot be written there.
    """
    lock, number = Lock(path, new=True), -1
    try:
        database = open_to_write(path, new=True)
        try:
            database.execute("BEGIN")
            for part in parts:
                number = part[0] if isinstance(part[0], int) else number
                database.execute(ROW if isinstance(part[0], int) else BLOB, part)
            database.execute("COMMIT")
        except (SqliteError, OverflowError, UnicodeError) as error:
            raise DefinitionError([Fault(f"row {number}", f"no journal has such a row: {error}")], source) from None
        finally:
            database.close()
    finally:
        lock.release()
