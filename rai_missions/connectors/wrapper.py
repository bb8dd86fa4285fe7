# SPDX-License-Identifier: Apache-2.0
"""A connector around another: what it does not replace is what the one inside does, its optional abilities too."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rai_missions.connectors.connector import Close, Connector, ConnectorMode

__all__ = ("ConnectorWrapper",)

METHODS = (
    "start", "stop", "listed", "subscribe", "publish", "call", "send_goal", "find_goal", "cancel_goal", "serve",
    "offer",
)  # fmt: skip
ABILITIES = ("adopt_goal", "conclude", "definition", "expect", "offered", "parameters", "resolved", "survey", "tap")
"""What only some connectors have, by the protocols of `connector`."""


class ConnectorWrapper:
    """A `Connector` around another one, of which a subclass replaces some methods.

    The methods of the one inside become attributes, so that a check for an ability finds what the one inside has, and
    nothing else.

    Args:
        inner: Does everything that is not replaced.
    """

    start: Callable[[], None]
    stop: Callable[[], None]
    listed: Callable[[ConnectorMode], Mapping[str, str]]
    subscribe: Callable[..., Close]
    publish: Callable[..., None]
    call: Callable[..., None]
    send_goal: Callable[..., None]
    find_goal: Callable[..., None]
    cancel_goal: Callable[[str], None]
    serve: Callable[..., Close]
    offer: Callable[..., Close]

    def __init__(self, inner: Connector) -> None:
        self.inner, self.modes = inner, inner.modes
        for name in (*METHODS, *ABILITIES):
            if hasattr(inner, name) and not hasattr(type(self), name):
                setattr(self, name, getattr(inner, name))

    @property
    def running(self) -> bool:
        return self.inner.running
