# SPDX-License-Identifier: Apache-2.0
"""The form of a lens: what stays lit, and what is said beside the picture."""

from __future__ import annotations

from collections.abc import Iterable

from visualize.page.as_json import Json

__all__ = ("item", "lens")


def item(text: str, *, state: str = "", row: str = "") -> Json:
    """A sentence, and what it is about where that can be shown."""
    return {"text": text} | ({"state": state} if state else {}) | ({"row": row} if row else {})


def lens(
    name: str, title: str, key: str, *, states: Iterable[str], rows: Iterable[str], options: Iterable[str] = (),
    sections: Iterable[tuple[str, list[Json]]] = (),
) -> Json:  # fmt: skip
    """A switch of the page.

    Args:
        name: What links name it.
        title: The question, as the switch has it.
        key: The key that turns it.
        states: The names of those that stay lit.
        rows: The JSON pointers of those that stay lit.
        options: The JSON pointers of those that stay lit.
        sections: Heading and sentences, for beside the picture.
    """
    return {
        "name": name, "title": title, "key": key,
        "states": sorted(set(states)), "rows": sorted(set(rows)), "options": sorted(set(options)),
        "sections": [{"heading": heading, "items": said} for heading, said in sections],
    }  # fmt: skip
