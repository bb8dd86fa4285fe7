# SPDX-License-Identifier: Apache-2.0
"""An exporter: the names of a mission's states, a line each."""

from __future__ import annotations

from visualize.model import Picture

__all__ = ("outline",)


def outline(given: Picture) -> bytes:
    """A picture as the bytes of an `.outline` file."""
    return "".join(f"{node.name} {node.title}\n" for node in given.nodes).encode()
