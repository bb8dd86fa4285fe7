# SPDX-License-Identifier: Apache-2.0
"""The journal out of a recording, so that whatever reads journals reads recordings.

Rule: what is missing or altered is reported; a recording that was cut off is read as far as it goes, and states it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.recording.file import ENDING, check_name, is_mcap

__all__ = ("JournalSource", "journal_of")


class JournalSource(NamedTuple):
    """A journal, wherever it came from."""

    path: Path
    """A journal; it goes with the context if it came out of a recording."""
    warning: str = ""
    """What a reader should know: the recording was cut off."""


@contextmanager
def journal_of(given: Path | str) -> Iterator[JournalSource]:
    """The journal that a file is, or that a recording holds; for as long as the context lasts.

    Raises:
        DefinitionError: It is no recording of a run, or it is damaged; also from inside the context.
        UsageError: The library that reads recordings is missing.
    """
    path = Path(given)
    if not is_mcap(path) and (path.suffix != ENDING or not path.is_file()):
        yield JournalSource(path)
        return
    check_name(path if path.suffix == ENDING else path.with_suffix(ENDING))
    from rai_missions.recording.mcap_reader import restore  # loads mcap

    with tempfile.TemporaryDirectory(prefix="rai_missions-") as folder:
        journal = Path(folder) / "journal"
        try:
            yield JournalSource(journal, restore(path, journal))
        except DefinitionError as error:
            raise DefinitionError(error.faults, error.source.replace(str(journal), str(path))) from None
        except UsageError as error:
            raise UsageError(str(error).replace(str(journal), str(path))) from None
