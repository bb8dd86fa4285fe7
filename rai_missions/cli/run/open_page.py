# SPDX-License-Identifier: Apache-2.0
"""Where a live page is served: an address of this machine, with a server behind it."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from rai_missions.errors import UsageError, install_command

if TYPE_CHECKING:
    from visualize.live import LivePage

__all__ = ("open_page",)


def open_page(
    port: str | int,
    *,
    host: str | None,
    tls_cert: str | None,
    tls_key: str | None,
    tokens: tuple[str, str] | None = None,
    instead: str = "",
) -> LivePage:
    """An address for a page; nothing is shown there yet.

    Args:
        port: Its port; 0 is any that is free.
        host: Its address; None is this machine's own.
        tls_cert: The file of its certificate.
        tls_key: The file of the key.
        tokens: The operator's and the viewers', where a page continues; new ones by default.
        instead: What is possible where no page can be served, as the end of the sentence of the fault.

    Raises:
        UsageError: It is in use, or unprotected, or there is no server on this machine.
    """
    if importlib.util.find_spec("starlette") is None or importlib.util.find_spec("uvicorn") is None:
        raise UsageError(f"the live page needs Starlette and uvicorn: {install_command('watch')}{instead}")
    from visualize.live import LivePage, PageAddress

    return LivePage(PageAddress(host or "127.0.0.1", int(port), tls_cert or "", tls_key or ""), tokens)
