# SPDX-License-Identifier: Apache-2.0
"""Templates: values as an author writes them, in which each `{"from": path}` is the value there now."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.guards.view import Operand, Site, View
from rai_missions.model.references import reference_word, template_paths

__all__ = ("ValueTemplate",)


class ValueTemplate:
    """A template, compiled.

    Args:
        written: As the author wrote it.
        site: Where; it learns what is read.
    """

    def __init__(self, written: Any, site: Site) -> None:
        self._written = written
        self._operands = {path: Operand(path, site) for path, _ in template_paths(written)}

    def fill(self, view: View) -> tuple[Any, list[str]]:
        """The value now, and the places in it that are unknown, such as `pose.x`; empty for the whole."""
        unknown: list[str] = []
        value = _filled(self._written, "", lambda path: self._operands[path].read(view), unknown)
        return value, sorted(unknown)


def _filled(written: Any, place: str, read: Callable[[str], Any], unknown: list[str]) -> Any:
    """A part of the value; its place joins those that are unknown where it refers to nothing known."""
    if reference_word(written) is not None:
        if (value := read(written["from"])) is None:
            unknown.append(place)
        return value
    before = f"{place}." if place else ""
    if isinstance(written, Mapping):
        return {name: _filled(item, f"{before}{name}", read, unknown) for name, item in written.items()}
    if isinstance(written, list | tuple):
        return [_filled(item, f"{before}{index}", read, unknown) for index, item in enumerate(written)]
    return written
