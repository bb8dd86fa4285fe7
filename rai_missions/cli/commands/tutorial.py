# SPDX-License-Identifier: Apache-2.0
"""`rai-missions tutorial`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("tutorial",)


@command()
def tutorial(
    *,
    terminal: bool = False,
    no_browser: bool = False,
    port: Annotated[int | None, Argument("PORT")] = None,
) -> int:
    """Play the first mission of the tutorial, as its robot.

    A robot takes the bin to the kerb. Each click is a step of the mission: an action that ends, a fact, time that
    passes. It needs no file, no account and no network. The steps of the tutorial are in the folder that is printed.

    Args:
        terminal: Play at the terminal; no page is served.
        no_browser: Print the page's address, and do not open it.
        port: The page's port; without it, any that is free.

    Exit status:
        0 it was ended (q, Ctrl-C, SIGTERM), 2 this installation has no tutorial

    Example:
        rai-missions tutorial
    """
    from rai_missions.cli.commands.try_ import try_
    from rai_missions.cli.templates import tutorial_folder

    folder = tutorial_folder()
    print(f"the tutorial: {folder}\nits first step is played now; end it with q or Ctrl-C", flush=True)
    return try_(folder / "1_mission/mission.json", terminal=terminal, no_browser=no_browser, port=port)
