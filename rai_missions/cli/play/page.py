# SPDX-License-Identifier: Apache-2.0
"""A play in the browser: what the page shows of it, and what it may order."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.cli.play.session import PlaySession
from rai_missions.errors import UsageError
from rai_missions.replay.play import Click
from rai_missions.runtime.interrupts import wait_for_signal

if TYPE_CHECKING:
    from visualize.live import LivePage

__all__ = ("ShownPlay", "opened", "serve")

MOST_PATH = 500
"""How many of the last choices are on the page."""


class ShownPlay:
    """A play as a page sees it; from any thread.

    Args:
        session: The play and its files.
    """

    def __init__(self, session: PlaySession) -> None:
        self._session, self._alone = session, threading.Lock()
        self._revision = 0

    def look(self) -> dict[str, Any]:
        """All that the page shows of the present."""
        with self._alone:
            return self._look()

    def act(self, order: dict[str, Any]) -> dict[str, Any]:
        """Carry out an order: `{"do", "values"}`, `{"undo": count}` or `{"save": true}`, given at a `revision`.

        Raises:
            UsageError: It makes no sense now; nothing has changed then.
        """
        with self._alone:
            play = self._session.play
            if order.get("revision") != self._revision:
                raise UsageError("the play has moved on in another window; this is where it is now")
            saved: list[str] = []
            if isinstance(name := order.get("do"), str):
                values = order.get("values")
                play.do(name, values if isinstance(values, dict) else {})
            elif isinstance(count := order.get("undo"), int):
                play.undo(count)
            elif order.get("save") is True:
                saved = self._session.save()
            else:
                raise UsageError("an order is 'do', 'undo' or 'save'")
            self._revision += 1
            return {**self._look(), "saved": saved}

    def _look(self) -> dict[str, Any]:
        from visualize.live.as_json import bounded, question_data

        session, chart = self._session, self._session.play.chart
        path = session.play.path
        board = {key: [bounded(entry.value), round(entry.at, 3)] for key, entry in chart.view.board.items()}
        last = path[-1].steps if path else ()
        return {
            "revision": self._revision,
            "at": chart.at,
            "mode": chart.mode,
            "control": chart.holder,
            "held_by": chart.held_by,
            "active": sorted(chart.active),
            "outcome": chart.outcome or "",
            "why": bounded(chart.why) if chart.outcome else "",
            "board": board,
            "questions": [question_data(each) for each in chart.questions],
            "choices": [each.data() for each in session.play.choices()],
            "taken": [place for step in last for move in step.moves for place in move.taken],
            "length": len(path),
            "path": [_clicked(click) for click in path[-MOST_PATH:]],
            "is_saved": session.is_saved,
            "file": str(session.journal),
        }


def _clicked(click: Click) -> dict[str, Any]:
    """A choice of the path, with the steps in which something happened."""
    from visualize.live.as_json import bounded, line

    steps = [found for step in click.steps if (found := line(step)) is not None]
    at = click.steps[-1].at if click.steps else click.before.at
    return {"words": click.words, "values": bounded(dict(click.values)), "at": round(at, 3), "steps": steps}


def serve(page: LivePage, session: PlaySession, *, opens: bool) -> None:
    """Serve a play until an interrupt.

    Args:
        page: Where.
        session: The play and its files.
        opens: The page is opened in the user's browser, where there is a screen.
    """
    page.start_play(session.play.mission, ShownPlay(session))
    print(f"try: {page.url}", flush=True)
    with opened(page.url) if opens and has_screen() else nullcontext():
        wait_for_signal(lambda: page.serves)


def has_screen() -> bool:
    """Whether a browser can be shown on this machine."""
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@contextmanager
def opened(url: str) -> Iterator[None]:
    """Open an address in the browser by a file of the user's own: other users can read a command line, and not that.

    It is in the working directory: a browser in a sandbox may read nothing of the system's folder of temporary files.
    """
    folder = Path.cwd() if os.access(Path.cwd(), os.W_OK) else None
    with tempfile.NamedTemporaryFile("w", dir=folder, prefix="try-", suffix=".html", encoding="utf-8") as file:
        file.write(f'<!DOCTYPE html><meta http-equiv="refresh" content="0;url={escape(url)}">')
        file.flush()
        webbrowser.open(Path(file.name).as_uri())
        yield
