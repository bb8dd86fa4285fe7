# SPDX-License-Identifier: Apache-2.0
"""A mission as it was at a revision of the git repository that it is in, with the missions that it includes.

Rule: what is asked of git names objects only, so no hook, filter or attribute of the repository runs; what comes out
lies in a folder of its own that is gone afterwards.
"""

from __future__ import annotations

import os
import posixpath
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rai_missions.errors import UsageError, make_folder_of
from rai_missions.mission.json_reader import MAX_BYTES
from rai_missions.plain_data import json_value

__all__ = ("at_revision",)

PLAIN = ("100644", "100755")
"""The modes of files that are neither links nor repositories."""
MOST = 1000
"""Files of one mission."""
MOST_BYTES = 64 * 2**20
"""The largest file that is read."""
ALONE = ("-c", "protocol.allow=never", "-c", "core.fsmonitor=false", "-c", "core.hooksPath=/dev/null")
"""A repository from elsewhere brings settings of its own, and some name programs: to fetch what it lacks is one."""


@contextmanager
def at_revision(revision: str, mission: Path, *, python: bool) -> Iterator[Path]:
    """The file of a mission as it was, in a folder that holds what it includes too.

    Args:
        revision: A commit, a branch or a tag.
        mission: The file as it is named now; it need not be there any more.
        python: Whether a mission in Python of that revision may be executed; its whole folder is taken along then.

    Raises:
        UsageError: There is no git, no repository, no such revision, or no such file in it.
    """
    if mission.suffix == ".py" and not python:
        why = "is Python, and that of another revision is executed only with --python; or compare the missions as JSON"
        raise UsageError(f"'{mission}' {why}")
    folder = mission.absolute().parent
    if not folder.is_dir():
        raise UsageError(f"there is no folder '{folder}'; name the mission by where it lies in the repository")
    top = Path(_git(folder, "rev-parse", "--show-toplevel").decode().removesuffix("\n"))
    commit = _commit(top, revision)
    name = (folder.resolve() / mission.name).relative_to(top.resolve()).as_posix()
    room = posixpath.dirname(name)
    with tempfile.TemporaryDirectory(prefix="rai-missions-") as made:
        known = _files(top, commit, room)
        if name not in known:
            raise UsageError(f"'{name}' is not a file of {revision!r}; name it as it was called there")
        for file in known if mission.suffix == ".py" else _needed(top, known, name):
            _put(Path(made) / file, _blob(top, known[file]))
        yield Path(made) / name


def _commit(top: Path, revision: str) -> str:
    try:
        found = _git(top, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    except UsageError:
        raise UsageError(f"there is no revision {revision!r} in {top}; give a commit, a branch or a tag") from None
    return found.decode().strip()


def _files(top: Path, commit: str, room: str) -> dict[str, str]:
    """Path → object, of the files in a folder and below it."""
    listed = _git(
        top, "--literal-pathspecs", "ls-tree", "-r", "-z", "--full-tree", commit, "--", f"{room}/" if room else "."
    )
    found = {}
    for entry in listed.decode("utf-8", "surrogateescape").split("\0"):
        about, _, path = entry.partition("\t")
        if path and (parts := about.split(" "))[0] in PLAIN and ".." not in path.split("/"):
            found[path] = parts[2]
    return found


def _needed(top: Path, known: Mapping[str, str], name: str) -> Iterator[str]:
    """A mission's file and those that it includes, and those that they include."""
    waiting, seen = [name], {name}
    while waiting:
        file = waiting.pop()
        yield file
        for written in _included(_blob(top, known[file])):
            other = posixpath.normpath(posixpath.join(posixpath.dirname(file), written))
            if other in known and other not in seen and len(seen) < MOST:
                seen.add(other)
                waiting.append(other)


def _included(data: bytes) -> Iterator[str]:
    """What a file includes, whether or not it is a mission that holds."""
    waiting: list[Any] = [json_value(data)] if len(data) <= MAX_BYTES else []
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            if isinstance(value.get("mission"), str):
                yield value["mission"]
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value


def _blob(top: Path, name: str) -> bytes:
    size = int(_git(top, "cat-file", "-s", name))
    if size > MOST_BYTES:
        raise UsageError(f"a file of {size} bytes is not taken out of {top}; {MOST_BYTES} are the most")
    return _git(top, "cat-file", "blob", name)


def _put(path: Path, data: bytes) -> None:
    make_folder_of(path)
    path.write_bytes(data)


def _git(folder: Path, *words: str) -> bytes:
    try:
        done = subprocess.run(
            ["git", *ALONE, "-C", str(folder), *words],
            capture_output=True,
            check=False,
            env={**os.environ, "GIT_NO_LAZY_FETCH": "1", "GIT_TERMINAL_PROMPT": "0"},
        )
    except FileNotFoundError:
        raise UsageError("there is no git on this machine; give two files instead: diff OLD NEW") from None
    if done.returncode:
        message = done.stderr.decode(errors="replace").strip().removeprefix("fatal: ")
        raise UsageError(f"git {words[0]}: {message or f'exit {done.returncode}'}")
    return done.stdout
