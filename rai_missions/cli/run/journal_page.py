# SPDX-License-Identifier: Apache-2.0
"""The live page of a journal: it follows what is written there, and takes no commands."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.cli.inputs import warn
from rai_missions.runtime.interrupts import wait_for_signal

if TYPE_CHECKING:
    from visualize.live import LivePage

__all__ = ("show_journal",)


def show_journal(page: LivePage, path: Path, own: Mapping[str, Any] | None) -> None:
    """Follow a journal on a page until an interrupt.

    Args:
        page: Where it is shown; commands are not taken there.
        path: The journal, or a recording of one.
        own: What the run reports of its own page, if it has one.
    """
    from rai_missions.recording import journal_of
    from visualize.live import JournalFeed
    from visualize.live.journal_feed import PLAYED

    with journal_of(str(path)) as journal:
        warn(journal.warning)
        _check_mission(journal.path)
        feed = JournalFeed(journal.path)
        about = {"run": feed.header.run, "journal": str(path), "answers": False, "played": feed.header.played}
        page.start(feed.mission, feed, None, about)
        print(f"watch: {page.url}", flush=True)
        if feed.header.played:
            warn(f"this run was played: {PLAYED}")
        if own is not None:
            warn(f"this page only shows the run; the run's own page takes commands: {own['url']}")
        wait_for_signal(lambda: page.serves)


def _check_mission(journal: Path) -> None:
    """Check that the mission in a journal is one, within the limits that hold for its file as well.

    Raises:
        DefinitionError: It is not.
    """
    from rai_missions.journal.reader import Record
    from rai_missions.replay.rebuild import mission_of

    with Record(journal) as record:
        if record.header.mission:
            mission_of(record)
