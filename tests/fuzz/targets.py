# SPDX-License-Identifier: Apache-2.0
"""What is fed with hostile bytes: everything that opens, checks, draws or replays what came from elsewhere.

Rule: a target ends or raises a `MissionError`; whatever else comes out is a crash, and so is a mission that is not
what its own JSON reports.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path

from rai_missions.check import check, check_file
from rai_missions.embodiment import Identity
from rai_missions.errors import MissionError
from rai_missions.journal import Header, Journal, read, verify
from rai_missions.journal.rows import GENESIS, chained
from rai_missions.mission.files import dump, load
from rai_missions.profile import dump_profile, load_profile, missing, parse_profile
from rai_missions.recording import journal_of
from rai_missions.replay.rebuild import mission_of, robot_of
from rai_missions.replay.replay import replay
from tests.fuzz.seeds import LAMP
from visualize import difference, draw, draw_difference, draw_review

__all__ = ("TARGETS", "fed")

MOST_ROWS = 200
DRAWN_EVERY = 8
"""Of so many missions one is drawn next to another: it takes as long as all the rest."""
MOST_STATES = 60
"""A mission of more states is loaded and checked, but not drawn: an execution is to be quick."""


def mission(data: bytes, folder: Path) -> None:
    """A mission in JSON: loaded, checked, written, loaded again, drawn and compared."""
    file = folder / "mission.json"
    file.write_bytes(data)
    check_file(str(file))
    loaded = load(file)
    holds = not any(each.severity == "error" for each in check(loaded))
    again = folder / "again.json"
    dump(loaded, again)
    assert load(again) == loaded, "a mission is not what its own JSON describes"
    if sum(1 for _ in loaded.walk()) > MOST_STATES:
        return
    for form in ("dot", "mmd", "md", "html"):
        draw(loaded, folder / f"picture.{form}")
    changed = difference(loaded, loaded)
    assert changed.empty or not holds, "a mission differs from itself"
    for found in (difference(LAMP, loaded), difference(loaded, LAMP)):
        tuple(found.lines())
        for form in ("dot", "mmd", "md", "html", "json") if zlib.crc32(data) % DRAWN_EVERY == 0 else ():
            draw_difference(found, folder / f"difference.{form}")


def profile(data: bytes, folder: Path) -> None:
    """A robot profile: loaded, held against a mission, written and read again."""
    file = folder / "robot.json"
    (folder / "identity").mkdir(exist_ok=True)
    file.write_bytes(data)
    robot = load_profile(file)
    missing(LAMP, robot)
    assert parse_profile(dump_profile(robot)) == robot, "a profile is not what its own JSON describes"


def journal(data: bytes, folder: Path) -> None:
    """The bytes of a journal's file: verified, read, replayed and shown."""
    file = folder / "run.journal"
    file.write_bytes(data)
    _shown(file, folder)


def rows(data: bytes, folder: Path) -> None:
    """What is in a journal's rows, as `[[kind, content], …]`, under hashes that hold: anybody can work them out."""
    try:
        listed = json.loads(data)
        parts = [(str(kind), content) for kind, content in listed[:MOST_ROWS]]
    except (ValueError, TypeError, KeyError, RecursionError):
        return
    file = folder / "run.journal"
    for path in (file, folder / "run.journal-wal"):
        path.unlink(missing_ok=True)
    Journal.create(file, Header("")).close()
    before = GENESIS
    with contextlib.closing(sqlite3.connect(file, isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode=DELETE").fetchall()
        database.execute("DELETE FROM rows")
        for number, (kind, content) in enumerate(parts):
            text = content if isinstance(content, str) else json.dumps(content)
            before = chained(before, number, kind, text)
            with contextlib.suppress(UnicodeEncodeError):
                database.execute("INSERT INTO rows VALUES (?, ?, ?, ?)", (number, kind, text, before))
    _shown(file, folder)


def recording(data: bytes, folder: Path) -> None:
    """The bytes of an MCAP file: its journal is taken out, and shown."""
    file = folder / "run.mcap"
    file.write_bytes(data)
    with journal_of(file) as found:
        _shown(found.path, folder)


def identity(data: bytes, folder: Path) -> None:
    """The files of an identity: a description, a build, two pictures, each with the same bytes."""
    place = folder / "identity"
    place.mkdir(exist_ok=True)
    (place / "description.md").write_bytes(b"A robot.")
    for name in ("body.urdf", "portrait.png", "side.jpg", "more.md"):
        for other in place.glob("[!d]*"):
            other.unlink()
        (place / name).write_bytes(data)
        with contextlib.suppress(MissionError):
            Identity.read(place).words()


def _shown(file: Path, folder: Path) -> None:
    verify(file)
    with contextlib.suppress(MissionError):
        draw_review(LAMP, folder / "page.html", [file])
    with read(file) as record:
        ran = mission_of(record)
        tuple(record.rows())
        robot_of(record)
        steps = tuple(record.steps())
    if sum(1 for _ in ran.walk()) <= MOST_STATES:
        draw(ran, folder / "picture.dot", steps=steps)
        replay(file)


TARGETS: Mapping[str, Callable[[bytes, Path], None]] = {
    "mission": mission, "profile": profile, "journal": journal, "rows": rows, "recording": recording,
    "identity": identity,
}  # fmt: skip


def fed(name: str, data: bytes, folder: Path) -> str:
    """What a target makes of bytes: nothing, or the sentence of the error by which it refuses them."""
    try:
        TARGETS[name](data, folder)
    except MissionError as error:
        return str(error)
    return ""
