# SPDX-License-Identifier: Apache-2.0
"""`rai-missions watch`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("watch",)


@command()
def watch(
    journal: Annotated[str | None, Argument("JOURNAL|RUN", files=("*.journal", "*.mcap"))] = None,
    *,
    port: Annotated[int, Argument("PORT")] = 8765,
    host: Annotated[str | None, Argument("ADDRESS")] = None,
    tls_cert: Annotated[str | None, Argument("FILE", files=("*",))] = None,
    tls_key: Annotated[str | None, Argument("FILE", files=("*",))] = None,
) -> int:
    """Show a run in a browser.

    Prints the address of the page that a run serves (run --watch). For a JOURNAL or RUN that is named, or where no run
    serves a page, it serves a page that follows the journal and takes no commands.

    Args:
        journal: A journal or recording, or a run's id or name in journals/. Without it: the run with a page, or the
            newest journal.
        port: The port; 0 is any that is free.
        host: The address on which the page listens, which needs TLS; without it, 127.0.0.1.
        tls_cert: The page's certificate, PEM.
        tls_key: The certificate's private key, PEM.

    Exit status:
        0 it was ended (Ctrl-C, SIGTERM), 2 the input is at fault

    Example:
        rai-missions watch journals/tractor-20260101-090000-4711.journal
    """
    from rai_missions.cli.run.find_page import find_journal, running_page
    from rai_missions.cli.run.journal_page import show_journal
    from rai_missions.cli.run.open_page import open_page

    path = find_journal(journal)
    own = running_page(path)
    if own is not None and journal is None:
        print(f"watch: {own['url']}", flush=True)
        return 0
    page = open_page(port, host=host, tls_cert=tls_cert, tls_key=tls_key)
    try:
        show_journal(page, path, own)
    finally:
        page.stop()
    return 0
