# SPDX-License-Identifier: Apache-2.0
"""What the people of the house speak to the robot, and when: sentences on the topic `/from_human`.

Source: rai_interfaces/msg/HRIMessage of RobotecAI/rai.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.plain_data import is_number
from rai_missions.worlds import messages
from rai_missions.worlds.options import check_names

__all__ = ("FROM_HUMAN", "HRI_MESSAGE", "Sentence", "Speech", "sentences")

FROM_HUMAN, HRI_MESSAGE = "from_human", "rai_interfaces/msg/HRIMessage"
Speech = Sequence[Mapping[str, Any]]
"""Mappings of `at_s` (seconds since the start) and `text`."""
FIELDS = ("at_s", "text")
LONGEST = 2000


class Sentence(NamedTuple):
    """One sentence that a person speaks."""

    at_s: float
    text: str
    number: int

    def message(self, at: float) -> dict[str, Any]:
        """A rai_interfaces/msg/HRIMessage, whole in one part."""
        return {
            "header": messages.header(at, ""),
            "text": self.text,
            "images": [],
            "audios": [],
            "communication_id": f"house-{self.number}",
            "seq_no": 0,
            "seq_end": True,
        }


def sentences(speech: Speech | Any) -> list[Sentence]:
    """The sentences in the order of their time.

    Raises:
        UsageError: One has another field, no time or no text.
    """
    if isinstance(speech, str):
        raise UsageError(f'speech: {speech!r} is no list; give sentences, [{{"at_s": 5, "text": "stop"}}]')
    return sorted((_sentence(number, one) for number, one in enumerate(speech)), key=lambda one: (one.at_s, one.number))


def _sentence(number: int, given: Any) -> Sentence:
    one = dict(given) if isinstance(given, Mapping) else {}
    check_names("speech", one, FIELDS)
    at_s, text = one.get("at_s"), one.get("text")
    if not is_number(at_s) or not 0 <= at_s <= 1e6:
        raise UsageError(f"speech: at_s takes the seconds since the start, not {at_s!r}")
    if not isinstance(text, str) or not 0 < len(text) <= LONGEST:
        raise UsageError(f"speech: text takes a sentence of 1 to {LONGEST} characters")
    return Sentence(float(at_s), text, number)
