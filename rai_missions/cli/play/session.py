# SPDX-License-Identifier: Apache-2.0
"""A play and the files that it is written to."""

from __future__ import annotations

import operator
from pathlib import Path
from typing import NamedTuple

from rai_missions.check import errors_of
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import writing_at
from rai_missions.mission.files import write_atomically
from rai_missions.mission.mission import Mission
from rai_missions.replay.play import Click, Play, PlaySource, save, written_test
from rai_missions.replay.rebuild import Predicates

__all__ = ("PlayFiles", "PlaySession")


class PlayFiles(NamedTuple):
    """Where a play came from, and where it is written."""

    source: PlaySource | None = None
    """The mission's file; None for a mission that has none, of which no test can be written."""
    journal: Path | None = None
    """None: named after the mission, in the working directory."""
    as_test: Path | None = None


class PlaySession:
    """A mission that one person plays.

    Args:
        mission: Any mission.
        files: Where it came from, and where the play is written.
        named: The predicates that guards name.

    Raises:
        DefinitionError: A check finds an error in the mission.
        UsageError: It names a predicate that was not given.
    """

    def __init__(self, mission: Mission, files: PlayFiles | None = None, named: Predicates | None = None) -> None:
        self.files = files or PlayFiles()
        file = str(self.files.source.mission) if self.files.source else ""
        if faults := errors_of(mission, file, named=named):
            raise DefinitionError(faults, file or mission.name)
        self.play = Play(mission, named=named)
        self.journal = self.files.journal or Path(f"{mission.stem}.played.journal")
        self._saved: set[Path] = set()
        self._saved_last: Path | None = None
        self._written: list[Click] = []

    @property
    def is_saved(self) -> bool:
        """The present path is what was written last."""
        path = self.play.path
        return len(path) == len(self._written) and all(map(operator.is_, path, self._written))

    def save(self, path: Path | None = None) -> list[str]:
        """Write the present path as a journal, and as a test where one was asked for; returns so, in words.

        Args:
            path: Another journal than the session's.

        Raises:
            UsageError: Nothing was played, or a file cannot be written.
            DefinitionError: There is a file of that name that is no journal.
        """
        to = path or self.journal
        aside = save(self.play, to, replaces=to.resolve() in self._saved)
        self._saved.add(to.resolve())
        self._saved_last = to
        words = [f"saved {to}{f'; the journal that had this name is now {aside}' if aside else ''}"]
        if self.files.as_test is not None:
            words.append(self.write_test(self.files.as_test))
        self._written = list(self.play.path)
        return words

    def finish(self) -> list[str]:
        """Write what was asked for on the command line and is not written yet; returns what was, in words."""
        files = self.files
        if not self.play.path or (self.is_saved and files.journal in (None, self._saved_last)):
            return []
        if files.journal is not None:
            return self.save()
        return [self.write_test(files.as_test)] if files.as_test is not None else []

    def write_test(self, to: Path) -> str:
        """Write the present path as a pytest; returns so, in words.

        Raises:
            UsageError: Nothing was played, the mission has no file, or the test cannot be written.
        """
        if self.files.source is None:
            raise UsageError("a test needs the mission's file, and this mission has none; save a journal")
        text = written_test(self.play, self.files.source, to)
        with writing_at(to, "a test"):
            write_atomically(to, text.encode())
        return f"wrote {to}"
