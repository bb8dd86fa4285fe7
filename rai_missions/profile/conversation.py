# SPDX-License-Identifier: Apache-2.0
"""How a robot talks with people: who may order what, and what becomes of what is asked of it meanwhile.

Rule: it grants orders to roles. Which role a person has, the door through which the message came decides.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator

from rai_missions.errors import suggestion
from rai_missions.event import Role
from rai_missions.model import LISTED, Bool, Json, MissionModel, Name, Number, Text, fault, refuse

__all__ = (
    "GRANTED", "ORDERS", "ConversationPolicy", "NamedPlace", "OrderName", "SentenceArguments", "WhileAnswering",
    "WhileRunning",
)  # fmt: skip

OrderName = Literal["start", "pause", "resume", "cancel", "stop", "answer"]
ORDERS: tuple[OrderName, ...] = get_args(OrderName)
"""What can be ordered by talk."""
GRANTED: dict[Role, tuple[OrderName, ...]] = {"operator": ORDERS, "viewer": (), "person": ("stop",)}
"""Role → what it may order where a profile grants nothing; every role may ask."""
Orders = Annotated[tuple[OrderName, ...], LISTED]
Keys = Annotated[tuple[Name, ...], LISTED]
WhileRunning = Literal["queue", "refuse"]
WhileAnswering = Literal["queue", "last", "interrupt"]
SentenceArguments = Mapping[str, Mapping[str, Any]]
"""Sentence → the arguments of a start that it gives without words for them."""
BELOW = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)*")
Span = Annotated[tuple[Number, Number], LISTED]


class NamedPlace(MissionModel):
    """Where a place is that people name: a room, a dock."""

    x: Span
    """From where to where it reaches, in metres: `[0.1, 5]`; twice the same number is a point."""
    y: Span
    frame: Text = "map"
    """In which frame; a pose of another one is not called by it."""

    @field_validator("x", "y")
    @classmethod
    def _is_from_to(cls, span: tuple[float, float], info: ValidationInfo) -> tuple[float, float]:
        if span[0] > span[1]:
            raise fault(str(info.field_name), f"{list(span)} ends before it begins; write [{span[1]}, {span[0]}]")
        return span

    def distance_m(self, x: float, y: float) -> float:
        """How far a position is from it, in metres; 0 inside."""
        return math.hypot(*(max(span[0] - at, 0.0, at - span[1]) for at, span in ((x, self.x), (y, self.y))))


class ConversationPolicy(MissionModel):
    """How a robot talks with people."""

    may: dict[Text, Orders] = Field(default_factory=dict)
    """Role → the orders that it may give as well: `person` is anyone who speaks or writes from outside and by default
    may stop, `viewer` looks at a page and by default may order nothing, and `operator` may everything."""
    requests: WhileRunning = "queue"
    """What becomes of a start that is ordered while a mission runs: it waits for its turn, at most 3, or is refused."""
    while_answering: WhileAnswering = "queue"
    """What becomes of a message that comes while a model answers the one before: it waits, only the last waits, or the
    answer is dropped for it."""
    language: Text = "en"
    """In which language it talks: the name of a file of templates and grammar."""
    begins: Literal["at_once", "ready"] = "at_once"
    """Whether `run --talk` begins the mission, or waits for the order to start it, again after each end."""
    phrases: dict[Text, dict[Name, Json]] = Field(default_factory=dict)
    """What may be uttered for a start with arguments → the arguments that it gives without words for them. In a phrase
    `(a|b)` is one of several, `[a]` may be left out, and `{key}` is the value of that argument. A text given may quote
    the sentence: `{"stack {rest}": {"request": "stack {rest}"}}`. A phrase counts in each mission that takes all of its
    arguments."""
    names: dict[Name, dict[Text, Json]] = Field(default_factory=dict)
    """Argument → the words for each of its values in a phrase, where it has no other values."""
    spoken: dict[Text, dict[Name, Json]] = Field(default_factory=dict)
    """How a start is read back: a text → the arguments that it has without words for them. `{key}` is the value
    of that argument. `{"go to the {place}": {"task": "go"}}` is for a start with these two and no others; where no text
    gives all arguments, the start is read back as the mission and its arguments."""
    questions: dict[Text, Text] = Field(default_factory=dict)
    """What may be asked of this robot → the key, or the field of one, whose value is the answer. A question is written
    as a phrase is; `*` is any words. It counts in each mission that has the key."""
    places: dict[Text, NamedPlace] = Field(default_factory=dict)
    """The name of a place → where it is. A position is answered with the place in which it is, or the nearest one."""
    asked_with: Annotated[tuple[Text, ...], LISTED] = ()
    """Keys, or fields of one, whose text is spoken with a question that has them as evidence: what may be meant, or why
    it is asked."""
    results: Keys = ()
    """Keys whose values are spoken with the end of a mission, where they have one; those that it lacks are left out."""
    hri: Bool = False
    """Whether it receives messages on `/from_human`, of persons, and reports on `/to_human`."""
    hri_below: Text = ""
    """Where these two topics are: `/alpha` for `/alpha/from_human`, so that a person addresses one robot of several."""

    @field_validator("hri_below")
    @classmethod
    def _is_a_namespace(cls, below: str) -> str:
        if not BELOW.fullmatch(below):
            raise fault("hri_below", f"'{below}' is no beginning of a topic's name; write it like '/alpha'")
        return below

    @field_validator("may")
    @classmethod
    def _knows_its_roles(cls, may: dict[str, tuple[OrderName, ...]]) -> dict[str, tuple[OrderName, ...]]:
        refuse(
            fault("may", f"no role '{role}'; there is: {', '.join(GRANTED)}{suggestion(role, GRANTED)}", at=(role,))
            for role in may
            if role not in GRANTED
        )
        return may

    def granted(self) -> dict[Role, frozenset[OrderName]]:
        """Role → all that it may order."""
        return {role: frozenset((*orders, *self.may.get(role, ()))) for role, orders in GRANTED.items()}
