# SPDX-License-Identifier: Apache-2.0
"""The file of a journal: what it declares, and where its log is."""

from __future__ import annotations

import sqlite3
from pathlib import Path

__all__ = (
    "APPLICATION", "BLOB", "FORMAT", "LONGEST_BYTES", "MORE", "ROW", "SCHEMA", "TABLES", "Connection", "SqliteError",
    "log_of", "uri_of",
)  # fmt: skip

SqliteError = sqlite3.Error
Connection = sqlite3.Connection

APPLICATION = 0x5241494D
"""`RAIM` in the file's header: what reports a journal from other SQLite files."""
FORMAT = 1
COLUMNS = {
    "rows": "number INTEGER PRIMARY KEY, kind TEXT NOT NULL, content TEXT NOT NULL, hash TEXT NOT NULL",
    "blobs": "sha256 TEXT PRIMARY KEY, media_type TEXT NOT NULL, bytes BLOB NOT NULL",
}
ROW = "INSERT INTO rows VALUES (?, ?, ?, ?)"
MORE = ", (?, ?, ?, ?)"
"""Another row in the same statement, which is a transaction by itself."""
BLOB = "INSERT OR IGNORE INTO blobs VALUES (?, ?, ?)"
TABLES = {name: f"CREATE TABLE {name} ({columns})" for name, columns in COLUMNS.items()}
SCHEMA = sorted(
    [
        *(("table", name, name, made) for name, made in TABLES.items()),
        ("index", "sqlite_autoindex_blobs_1", "blobs", ""),
    ]
)
"""All that a journal's file declares. A trigger may have the name of a table, so the sort counts as well."""
LONGEST_BYTES = 64 * 1024 * 1024
"""No row and no picture is longer: neither written nor read."""


def log_of(path: Path) -> Path:
    """Where SQLite writes what is not yet in a journal's file itself."""
    return path.with_name(f"{path.name}-wal")


def uri_of(path: Path, mode: str) -> str:
    return f"{path.absolute().as_uri()}?mode={mode}"
