# SPDX-License-Identifier: Apache-2.0
"""The file by which the page of a run is found, and which journal `rai-missions watch` means."""

from __future__ import annotations

import ipaddress
import json
import os
import re
import socket
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from rai_missions.errors import MissionError, UsageError, irregular

__all__ = ("find_journal", "left_tokens", "run_file", "running_page")

FOLDER = Path("journals")
RUN_FILES = ("*.journal.watch", "*/*.journal.watch", "*/*/*.journal.watch")
"""Where a run that is still active is looked for: here, and two folders deep."""
ANSWERS_S = 1.0
TOKEN = re.compile(r"#token=(?P<token>[A-Za-z0-9_-]{43})$")


@contextmanager
def run_file(journal: str, what: dict[str, Any]) -> Iterator[None]:
    """A file next to a run's journal, while it lasts, with the address of its page; no other user may read it."""
    if not journal:
        yield
        return
    path = Path(f"{journal}.watch")
    with suppress(FileNotFoundError):
        path.unlink()
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        json.dump({**what, "pid": os.getpid()}, file)
    try:
        yield
    finally:
        with suppress(FileNotFoundError):
            path.unlink()


def find_journal(name: str | None) -> Path:
    """The journal that is meant: a file, or a run in `journals/` by its id or its name; else the newest.

    Raises:
        UsageError: There is none.
    """
    if name is not None and Path(name).exists():
        return Path(name)
    journals = sorted(FOLDER.glob("*.journal"), key=_changed, reverse=True)
    if name is None:
        return _newest(journals)
    named = [path for path in journals if name in (path.stem, path.name) or _run_of(path) == name]
    if not named:
        known = ", ".join(path.stem for path in journals[:5])
        raise UsageError(
            f"there is no journal '{name}', and no run of that name in {FOLDER}/{': ' if known else ''}{known}"
        )
    return named[0]


def _newest(journals: list[Path]) -> Path:
    running = next((path for path in [*journals, *_elsewhere()] if running_page(path) is not None), None)
    if running is not None:
        return running
    if not journals:
        raise UsageError(
            f"no run has written a journal in {FOLDER}/, and no active run has a page in a folder below this one; "
            "begin one with: rai-missions run --watch …, or name a journal: rai-missions watch JOURNAL"
        )
    print(
        f"no run with a page is active here; this is the newest journal in {FOLDER}/, and only that folder was "
        f"searched for journals: {journals[0]}. Name another with: rai-missions watch JOURNAL",
        file=sys.stderr,
    )
    return journals[0]


def _elsewhere() -> list[Path]:
    """The journals of active runs below this folder, the newest run first."""
    marks = [path for pattern in RUN_FILES for path in Path().glob(pattern)]
    return [mark.with_suffix("") for mark in sorted(marks, key=_changed, reverse=True)]


def running_page(journal: Path) -> dict[str, Any] | None:
    """What the run of a journal reports of its own page, if it is there and answers."""
    about_page = _private(journal)
    try:
        place = urlsplit(about_page["url"])
        if not _is_here(place.hostname or ""):
            return None
        with socket.create_connection((place.hostname or "", place.port or 0), timeout=ANSWERS_S):
            return about_page
    except (OSError, ValueError, KeyError):
        return None


def left_tokens(journal: str | Path | None) -> tuple[str, str] | None:
    """The tokens of the page of a run that was killed: those who had it open are let in by the process that resumes it.

    Returns:
        The operator's and the viewers'; None where the run has left no file that its user alone could write.
    """
    about_page = _private(Path(journal)) if journal else {}
    found = [TOKEN.search(str(about_page.get(word, ""))) for word in ("url", "viewer_url")]
    operator, viewer = (each["token"] if each else "" for each in found)
    return (operator, viewer) if operator and viewer and operator != viewer else None


def _private(journal: Path) -> dict[str, Any]:
    """What the file of a journal's page holds; empty where there is none that its user alone may read."""
    path = Path(f"{journal}.watch")
    if irregular(path):
        return {}
    try:
        about = path.stat()
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    is_private = about.st_uid == os.getuid() and not stat.S_IMODE(about.st_mode) & 0o077
    return found if is_private and isinstance(found, dict) and isinstance(found.get("url"), str) else {}


def _is_here(host: str) -> bool:
    """Whether an address is this machine's: a file that came with a journal may name any, and none is asked."""
    if host in ("localhost", socket.gethostname().lower()):
        return True
    try:
        address = ipaddress.ip_address(host)
        with socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET, socket.SOCK_DGRAM) as tried:
            tried.bind((host, 0))  # nothing is sent: only what is ours can be bound
    except (OSError, ValueError):
        return False
    return True


def _changed(path: Path) -> float:
    """When a file or its write-ahead log was written last; 0 where both have just gone."""
    times = [0.0]
    for each in (path, path.with_name(f"{path.name}-wal")):
        with suppress(OSError):
            times.append(each.stat().st_mtime)
    return max(times)


def _run_of(path: Path) -> str:
    from rai_missions.journal.reader import Record

    try:
        with Record(path) as record:
            return record.header.run
    except MissionError:
        return ""
