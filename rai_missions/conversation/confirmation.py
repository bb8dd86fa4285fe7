# SPDX-License-Identifier: Apache-2.0
"""A confirmation: one order that was read back and waits for its yes.

Rule: the yes counts for exactly what was read back: by one who may, in time, while what it rests on is the same, and
as the first that this person utters after it. A yes from before it was read back, or that may be meant for the question
before, does not count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.outputs import Mapper
from rai_missions.conversation.senses import Sense

__all__ = ("Confirmable",)


class Confirmable(NamedTuple):
    """An order that was read back."""

    sense: Sense
    utterance: Utterance
    """The sentence that was read as this order."""
    mapper: Mapper
    words: str
    """The order as it was read back."""
    binding: tuple[object, ...]
    """What it rests on; `order_rules.binding`."""
    until: float
    read_at: float = math.inf
    """From when on it can be known: it was shown, or spoken to its end."""
    key: str = ""
    """Of the speech that reads it back."""
    distracted: frozenset[tuple[str, str]] = frozenset()
    """The speakers who have uttered something else since; the yes of one of them has it read back again."""
    is_crossing: bool = False
    """Another question ended right before this one, so a yes may be meant for that one: it has this read back again."""
    understood_by: tuple[str, str] = ("", "")
    """The speaker who ended the other question, and so knows of this one."""
    is_request: bool = False
    """It waited for the end of a mission, which did not succeed."""

    def is_unclear(self, yes: Utterance) -> bool:
        """Whether a yes came too early, or may be meant for something else, and has the order read back again."""
        is_crossing = self.is_crossing and yes.speaker != self.understood_by
        return yes.at < self.read_at or yes.speaker in self.distracted or is_crossing

    def asked_again(self) -> Confirmable:
        """The same, to be read back again: the next yes of each speaker is clear."""
        return self._replace(distracted=frozenset(), is_crossing=False)
