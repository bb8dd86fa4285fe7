# SPDX-License-Identifier: Apache-2.0
"""What a dialogue gives out: speech, orders that were judged, requests to a model, and notes for the journal.

Rule: an `Order` is the only output that touches a run, and it was permitted, possible and, where demanded, confirmed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.event import Role
from rai_missions.profile.conversation import OrderName
from rai_missions.voice.spoken_text import SpeechPriority

__all__ = (
    "AskModel", "DropModel", "LookUp", "Mapper", "NoteKind", "Order", "Output", "Silence",
    "Speech", "TalkNote", "TalkTurn", "Way",
)  # fmt: skip

Way = Literal["rules", "model", "documents", "unknown"]
"""By which way a text was made: templates, a model, a quotation of documents, or none of them knew an answer."""
Mapper = Literal["grammar", "model", "nearest"]
"""What read a sentence as an order: its grammar, a model, or the likeness of its words to the phrases of orders."""


NoteKind = Literal[
    "heard",
    "mapped",
    "read_back",
    "confirmed",
    "void",
    "refused",
    "ordered",
    "performed",
    "queued",
    "dropped",
    "waiting",
    "asked_model",
    "model_text",
    "replaced",
    "looked_up",
    "spoken",
    "unspoken",
]


class Speech(NamedTuple):
    """A text to be spoken and shown. A `SpeechEnd` with its key must follow, whatever becomes of it."""

    key: str
    """Unique in a process life; a report that is spoken again has another one."""
    text: str
    priority: SpeechPriority = "answer"
    way: Way = "rules"
    """The page and the journal show it as a field; `aloud` has it in words."""
    uncut: bool = False
    """A person who begins to speak does not interrupt it; only `Silence` does."""
    to: str = ""
    """The channel that asked; empty for every channel, as for reports."""
    reply_to: int = 0
    """The number of the sentence that it answers, as in `TalkTurn.number`; 0 for what no one asked."""
    report: str = ""
    """The identity of a report, one for all times that it is spoken: `run-1:end`; empty for any other text."""
    repeated: bool = False
    """It may have been spoken before: after a kill or a dead speaker. The text has it as well."""
    aloud: str = ""
    """The words where only words arrive: a model's text after "I think", in the conversation's language; else empty."""

    @property
    def words(self) -> str:
        """What is spoken or sent where only words arrive."""
        return self.aloud or self.text


class Silence(NamedTuple):
    """Stop speaking now and drop what is queued; each speech reports its end as `cut`."""

    at: float
    is_total: bool = True
    """Uncut speech is stopped as well: after a stop. False: only what a person may interrupt."""


class Order(NamedTuple):
    """An order that was judged: to be carried out at once. An `OrderEnd` with its number must follow."""

    number: int
    name: OrderName
    """`stop`: pause, and cancel every goal, also those that the profile keeps in a pause."""
    role: Role
    channel: str
    author: str
    mission: str = ""
    """Of a `start`."""
    arguments: Mapping[str, Any] = {}
    """Of a `start`: the values of its argument keys, each of the key's type; those left out keep their initial."""
    question: int = 0
    """Of an `answer`: the question's number."""
    option: str = ""
    parameters: Mapping[str, Any] = {}
    mapper: Mapper = "grammar"
    sentence: str = ""
    """What was ordered, as it was received."""
    confirmed: str = ""
    """The sentence that confirmed it; empty where none was demanded."""
    at: float = 0.0


class TalkTurn(NamedTuple):
    """One turn of the conversation, as the history has it."""

    number: int
    """From 1 in a process life."""
    by: str
    """The role of a person, or `robot`."""
    text: str
    way: Way | Literal[""] = ""
    """Of the robot's turns."""
    channel: str = ""
    at: float = 0.0
    author: str = ""


class AskModel(NamedTuple):
    """A request to a model. `ModelText` with its number must follow, or it times out at `until`."""

    number: int
    text: str
    role: Role
    channel: str
    author: str
    history: tuple[TalkTurn, ...]
    """The last turns, oldest first, without this one; bounded."""
    status: str
    """The status in sentences, by rules; to be put behind the constant part of the prompt."""
    orders: tuple[Mapping[str, Any], ...]
    """What it may propose, each a JSON Schema of a closed object; empty where the role may order nothing."""
    at: float
    until: float
    """The instant after which the dialogue does not wait for it any longer."""


class DropModel(NamedTuple):
    """The reply to this request is not wanted any more: it timed out, or the person interrupted."""

    number: int


class LookUp(NamedTuple):
    """A question to the robot's documents. `FoundQuotes` with its number must follow, or it times out at `until`."""

    number: int
    text: str
    """The question, as it was received."""
    until: float
    """The instant after which the dialogue does not wait for it any longer."""


class TalkNote(NamedTuple):
    """A line for the journal, as data: sentence, mapper, confirmation, refusal, replaced claim, what was spoken."""

    kind: NoteKind
    at: float
    data: Mapping[str, Any]


Output = Speech | Silence | Order | AskModel | DropModel | LookUp | TalkNote
