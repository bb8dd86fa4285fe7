# SPDX-License-Identifier: Apache-2.0
"""A model's text as it arrives, in pieces, and as it goes out: sentence by sentence."""

from __future__ import annotations

import re
from typing import NamedTuple

from rai_missions.planning.text.normalise import readable
from rai_missions.redaction import cut

__all__ = ("SentenceStream", "sentences")

END = re.compile(r"(?<=[.!?…])[\"'”’)\]*_]*\s+|\n+")
ABBREVIATIONS = re.compile(r"\b(?:e\.g|i\.e|z\.b|d\.h|u\.a|mr|mrs|dr|vs|etc|ca|no|nr)\.$|(?:^|\s)\d+\.$", re.IGNORECASE)
LONGEST_SENTENCE = 400
"""Characters after which a text without an end of sentence is cut at a space."""


def sentences(text: str) -> tuple[list[str], str]:
    """The whole sentences of a text, and the rest that is not ended yet."""
    made, start = list[str](), 0
    for end in END.finditer(text):
        part = text[start : end.start()].strip()
        if part and not ABBREVIATIONS.search(part):
            made.append(text[start : end.end()].strip())
            start = end.end()
    rest = text[start:].lstrip()
    while len(rest) > LONGEST_SENTENCE:
        at = rest.rfind(" ", 0, LONGEST_SENTENCE)
        at = at if at > 0 else LONGEST_SENTENCE
        made.append(rest[:at].strip())
        rest = rest[at:].lstrip()
    return [each for each in made if each], rest


class SentenceStream(NamedTuple):
    """The text of one reply that has not gone out yet."""

    rest: str = ""

    def add(self, piece: str, *, is_end: bool) -> tuple[SentenceStream, list[str]]:
        """The stream after a piece, and the sentences that are whole now."""
        made, rest = sentences(readable(self.rest + piece, by=cut) if piece else self.rest)
        if is_end and rest.strip():
            made, rest = [*made, rest.strip()], ""
        return SentenceStream(rest), made
