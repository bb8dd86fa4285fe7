# SPDX-License-Identifier: Apache-2.0
"""As much of the grammar of Mermaid's state diagrams as pictures use; anything else is refused."""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ("Diagram", "read")

STATE = re.compile(r'state "([^"<>{}]*(?:<br/>[^"<>{}]*)*)" as (\w+)( \{)?')
ARROW = re.compile(r"(\[\*\]|\w+) --> (\w+)(?:: (.+))?")
OTHER = re.compile(r"classDef \w+ [\w:#,. -]+|class \w+ \w+|acc(?:Title|Descr): [^\n]+|--|%% .+")


class Diagram(NamedTuple):
    states: dict[str, str]
    """Id → description, in the order written."""
    arrows: list[tuple[str, str, str]]


def read(text: str) -> Diagram:
    """Raises ValueError with the line that is not understood."""
    first, *lines = text.splitlines()
    if first != "stateDiagram-v2":
        raise ValueError(first)
    found = Diagram({}, [])
    depth = 0
    for line in map(str.strip, lines):
        if state := STATE.fullmatch(line):
            found.states[state[2]] = state[1]
            depth += bool(state[3])
        elif arrow := ARROW.fullmatch(line):
            found.arrows.append((arrow[1], arrow[2], arrow[3] or ""))
        elif line == "}" and depth:
            depth -= 1
        elif not OTHER.fullmatch(line):
            raise ValueError(line)
    if depth:
        raise ValueError("a state is left open")
    return found
