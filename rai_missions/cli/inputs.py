# SPDX-License-Identifier: Apache-2.0
"""What several commands read: guards in Python, the steps of a journal, `KEY=VALUE` pairs."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Container, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.errors import DefinitionError, Fault, UsageError, irregular, meant_file, raised_text
from rai_missions.mission.mission import Mission

if TYPE_CHECKING:
    from rai_missions.journal.reader import Record

__all__ = ("distinct", "is_robot_program", "journal_steps", "load_guards", "program_hashes", "read_pairs", "warn")


def warn(sentence: str) -> None:
    """Print a sentence on stderr; nothing where it is empty."""
    if sentence:
        print(sentence, file=sys.stderr)


def distinct(files: Mapping[str, str | Path | None]) -> None:
    """Refuse a file that is named twice: what is written last would be all that is left of the other.

    Args:
        files: Word of the command line → the file that it names; None where it is not given.

    Raises:
        UsageError: Two words name one file.
    """
    words: dict[str, str] = {}
    for word, path in files.items():
        if path is not None and (other := words.setdefault(os.path.realpath(path), word)) != word:
            raise UsageError(f"{other} and {word} name one file, '{path}'; name two")


def load_guards(path: str | None, *, python: bool = True) -> dict[str, Callable[..., bool | None]] | None:
    """The public functions of a file, by name.

    Args:
        path: The file, which is executed.
        python: Whether it may be.
    """
    if path is None:
        return None
    if not python:
        raise UsageError(f"--guards {path} is Python, which --no-python refuses; leave one of them out")
    import runpy

    if sort := irregular(path):
        raise UsageError(f"'{path}' is {sort}; name a .py file with guards")
    if Path(path).suffix != ".py":
        raise UsageError(f"'{path}' is not executed: guards are Python; name a .py file with guards")
    if not Path(path).is_file():
        raise UsageError(f"there is no file '{path}' with guards{meant_file(path, '.py')}")
    try:
        found = runpy.run_path(path)
    except (Exception, SystemExit) as error:  # a file that exits must not look like a run that succeeded
        raise DefinitionError([Fault("", raised_text(error))], path) from error
    own = {name: each for name, each in found.items() if callable(each) and not name.startswith("_")}
    return {name: each for name, each in own.items() if getattr(each, "__module__", None) == "<run_path>"}


def program_hashes(**files: str | None) -> dict[str, str]:
    """The hashes of those files that are Python: what the file is for → the SHA-256 of its bytes, in hex."""
    import hashlib

    from rai_missions.mission.json_reader import file_bytes

    named = {name: Path(path) for name, path in files.items() if path is not None and Path(path).suffix == ".py"}
    return {name: hashlib.sha256(file_bytes(path)).hexdigest() for name, path in named.items()}


def is_robot_program(path: str | None, *, python: bool = True) -> bool:
    """Whether what is named as the robot is a file in Python.

    Args:
        path: The file, of which only the name is looked at.
        python: Whether it may be executed.

    Raises:
        UsageError: It is, and may not be executed.
    """
    from rai_missions.profile.files import is_program

    if not is_program(path):
        return False
    if not python:
        raise UsageError(f"--robot {path} is Python, which --no-python refuses; give a profile in JSON, or drop one")
    return True


def journal_steps(journal: str | None, mission: Mission | None = None, *, remedy: str = "") -> tuple[Any, ...]:
    """The steps of a journal, or of the one in a recording.

    Args:
        journal: The file.
        mission: Whose it must be.
        remedy: What to do where its rows are damaged or were altered.

    Raises:
        DefinitionError: The journal is damaged, or is of another mission.
    """
    if journal is None:
        return ()
    from rai_missions.recording import journal_of
    from rai_missions.replay.rebuild import mission_of

    with journal_of(journal) as found, _sound(found.path, remedy) as record:
        warn(found.warning)
        if mission is not None and record.header.mission and mission_of(record) != mission:
            sentence = "this is the journal of another mission, or of another version of it"
            raise DefinitionError(
                [Fault("", f"{sentence}: {mission_of(record).name} {mission_of(record).version}")], journal
            )
        return tuple(record.steps())


def _sound(path: Path, remedy: str) -> Record:
    """A journal whose rows are as they were written."""
    from rai_missions.journal import read

    try:
        return read(path)
    except DefinitionError as error:
        more = [Fault("", remedy)] if remedy else []
        raise DefinitionError([*error.faults, *more], str(path)) from None


def read_pairs(option: str, pairs: Sequence[str], texts: Container[str] = ()) -> dict[str, Any]:
    """`KEY=VALUE` pairs by key; a value is JSON, or text where it is not.

    Args:
        option: Whose they are: `--set`.
        pairs: As given.
        texts: The keys whose values are text, whatever they look like.

    Raises:
        UsageError: One has no `=` or no key, or a key is given twice.
        DefinitionError: A value is JSON beyond the limits of a file: a number that has no value here, too deep.
    """
    values: dict[str, Any] = {}
    for pair in pairs:
        name, sign, text = pair.partition("=")
        if not sign or not name:
            raise UsageError(f"{option} {pair}: write KEY=VALUE")
        if name in values:
            raise UsageError(f"{option} {name} is given twice; give one value")
        values[name] = text if name in texts else _value(f"{option} {name}", text)
    return values


def _value(option: str, text: str) -> Any:
    """JSON within the limits of a file, or the text where it is not JSON."""
    from rai_missions.mission.json_reader import parse_json

    try:
        json.loads(text)
    except json.JSONDecodeError:
        return text
    except (ValueError, RecursionError):
        pass  # it is JSON, and what follows states which limit it is beyond
    return parse_json(text.encode("utf-8", "surrogateescape"), option)
