# SPDX-License-Identifier: Apache-2.0
"""What comes into a dialogue: sentences, a model's text, ends of speech and of orders; each with its instant.

Rule: the role is set by the door through which a sentence came. No text and no author's name changes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.engine.step import Refusal
from rai_missions.event import Role
from rai_missions.mission.start_fault import StartFault, StartFaultKind
from rai_missions.redaction import cut

__all__ = (
    "DocumentQuote", "FoundQuotes", "ModelText", "OrderEnd", "OrderResult", "RefusalKind", "SpeechEnd",
    "SpeechResult", "Utterance", "by_words",
)  # fmt: skip

SpeechResult = Literal["whole", "cut", "failed"]
"""How a speech ended: every word came out; it was interrupted; the speaker did not speak it."""
LONGEST_READ = 10_000
"""Characters of a text in which a stop is looked for; a door takes no sentence that is longer than `LONGEST`."""
RefusalKind = Literal[
    Refusal,
    StartFaultKind,
    "judged",
    "values",
    "late",
    "stopped",
    "second",
    "last",
    "unsafe",
    "locked",
    "closing",
    "no_run",
    "inactive",
    "other",
]
"""Why an order was not carried out: what the engine refuses, and what a mission has against a start, by their kinds; an
answer whose option is not possible any more, or whose values do not fit; an order that the run did not take in time;
a start to which a stop came, or that has another before it; no other run begins here, or none may, as the robot may
move or was stopped at once, or the program ends; there is no run; the run's node is not active; any other reason. Empty
for an order that was carried out."""


class OrderResult(NamedTuple):
    """Whether an order was carried out."""

    refused: str = ""
    """Why it was not, in a sentence; empty where it was."""
    kind: RefusalKind = ""
    """What kind of refusal that is; each language has a text for each kind."""
    name: str = ""
    """What it is about: of a start the argument; else empty."""

    @classmethod
    def of_start(cls, faults: Sequence[StartFault]) -> OrderResult:
        """What became of an order to start, by what the mission has against it."""
        if not faults:
            return cls()
        return cls("; ".join(each.sentence for each in faults), faults[0].kind, faults[0].argument)


class Utterance(NamedTuple):
    """One sentence of a person, as a door received it: typed, or transcribed from sound."""

    text: str
    """The sentence; of spoken ones the first recogniser's transcription."""
    role: Role
    """What the door grants: the page's token, the terminal, everything else. Never from the text."""
    channel: str
    """The door: `terminal`, `page`, `voice`, `topic`, …; an answer goes back to it."""
    author: str = ""
    """A free name, for people. Channel and author together are the speaker to whom a confirmation is bound."""
    at: float = 0.0
    """When the door received it, on the dialogue's clock: it answers nothing that was shown or spoken later."""
    readings: tuple[str, ...] = ()
    """Of a spoken sentence each recogniser's transcription, the first included; empty for a typed one.

    The dialogue works out which of them agree on an order: one suffices to stop, two are needed for other orders.
    """
    id: str = ""
    """The message's id, if it has one; a sentence that comes again with its author and id changes nothing."""
    age_s: float = 0.0
    """How long before its receipt it was sent, by its own stamp; 0 where that is not known."""
    number: int = 0
    """Of its turn, as in `TalkTurn.number`; the dialogue counts. 0: what goes to its speaker is no answer to it."""

    @property
    def is_spoken(self) -> bool:
        return bool(self.readings)

    @property
    def asks(self) -> bool:
        """Whether it is written as a question; what is spoken has a mark only where no phrase was read."""
        return self.text.rstrip().endswith("?")

    @property
    def without_secrets(self) -> Utterance:
        """A copy without the secrets of this process, and without what no grammar reads."""
        readings = tuple(cut(each, LONGEST_READ) for each in self.readings)
        return self._replace(text=cut(self.text, LONGEST_READ), readings=readings)

    @property
    def speaker(self) -> tuple[str, str]:
        return self.channel, self.author

    @property
    def unnumbered(self) -> Utterance:
        """A copy for what its speaker receives later, without being an answer."""
        return self._replace(number=0)

    @property
    def by(self) -> str:
        """Who spoke, as the journal has it."""
        return by_words(self.role, self.author, self.channel)


class ModelText(NamedTuple):
    """A piece of a model's reply, as it arrives."""

    number: int
    """Of the `AskModel` that it replies to; any other is dropped."""
    text: str = ""
    """The next piece of its text; pieces are joined and go out sentence by sentence."""
    order: Mapping[str, Any] | None = None
    """An order that it proposes, in the closed form of `AskModel.orders`; it counts once a person has confirmed it."""
    is_end: bool = False
    """Nothing follows."""
    failed: str = ""
    """Why there is no reply, for the journal; empty where there is one."""
    at: float = 0.0


class DocumentQuote(NamedTuple):
    """What a document has on a question, word for word."""

    source: str
    """Its file and its headings."""
    text: str


class FoundQuotes(NamedTuple):
    """What the robot's documents have on a question."""

    number: int
    """Of the `LookUp` that it replies to; any other is dropped."""
    quotes: tuple[DocumentQuote, ...] = ()
    """The best first; none where the documents have no answer."""
    failed: str = ""
    """Why nothing could be looked up, for the journal; empty where it was."""
    at: float = 0.0


class SpeechEnd(NamedTuple):
    """A speech has ended; for a text that is only shown, `whole` as soon as it is shown."""

    key: str
    """Of the `Speech`; any other is dropped."""
    result: SpeechResult
    at: float = 0.0
    """When it did so; it may be handled later."""


class OrderEnd(NamedTuple):
    """What became of an order that the dialogue gave out."""

    number: int
    """Of the `Order`."""
    result: OrderResult = OrderResult()
    at: float = 0.0


def by_words(role: Role, author: str, channel: str) -> str:
    """Who gave an order, as the journal has it: `operator Anna (page)`."""
    return " ".join(filter(None, (role, author, f"({channel})")))
