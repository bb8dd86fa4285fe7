# SPDX-License-Identifier: Apache-2.0
"""`rai-missions try`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rai_missions.cli.command import Argument, GuardsFile, MissionFile, command

__all__ = ("try_",)


@command()
def try_(
    mission: MissionFile,
    *,
    terminal: bool = False,
    no_browser: bool = False,
    port: Annotated[int | None, Argument("PORT")] = None,
    journal: Annotated[Path | None, Argument("FILE", files=("*.journal",))] = None,
    as_test: Annotated[Path | None, Argument("FILE.py", files=("*.py",))] = None,
    guards: GuardsFile | None = None,
    no_python: bool = False,
) -> int:
    """Play a mission without a robot: you are the robot, and everyone else.

    Offered is what can happen now: events, the ends of what runs, facts, answers, the passing of time, the operator's
    commands. Undo goes back. What led to the present is saved as a journal, which replay and draw read, and which
    states that it was played. In the browser, or at the terminal where the input is piped.

    Args:
        mission: A .json file, or a .py file with a mission or a function mission().
        terminal: Play at the terminal; no page is served.
        no_browser: Print the page's address, and do not open it.
        port: The page's port; without it, any that is free.
        journal: Where the play is saved. Without it: NAME.played.journal. With it the play is saved at its end, too.
        as_test: Write the play as a pytest whenever it is saved, and at its end.
        guards: A Python file with the predicates of 'named' guards.
        no_python: Refuse a mission and guards in Python.

    Exit status:
        0 it was ended (q, Ctrl-C, SIGTERM), 2 the input is at fault

    Example:
        rai-missions try mission.json --as-test test_play.py
    """
    import sys

    from rai_missions.check import load_whole
    from rai_missions.cli.inputs import distinct, load_guards
    from rai_missions.cli.play.session import PlayFiles, PlaySession
    from rai_missions.replay.play import PlaySource
    from rai_missions.runtime.interrupts import until_signals

    distinct({"MISSION": mission, "--guards": guards, "--journal": journal, "--as-test": as_test})
    loaded = load_whole(mission, python=not no_python)
    source = PlaySource(Path(mission), Path(guards) if guards else None)
    session = PlaySession(loaded, PlayFiles(source, journal, as_test), load_guards(guards, python=not no_python))
    if terminal or (port is None and not no_browser and not sys.stdin.isatty()):
        from rai_missions.cli.play.terminal import TerminalPlay

        with until_signals():
            TerminalPlay(session, sys.stdin, sys.stdout, is_person=sys.stdin.isatty()).run()
    else:
        from rai_missions.cli.play.page import serve
        from rai_missions.cli.run.open_page import open_page

        instead = "; or play at the terminal: --terminal"
        page = open_page(port or 0, host=None, tls_cert=None, tls_key=None, instead=instead)
        try:
            serve(page, session, opens=not no_browser)
        finally:
            page.stop()
    for line in session.finish():
        print(line)
    return 0
