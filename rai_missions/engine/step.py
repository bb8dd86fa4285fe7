# SPDX-License-Identifier: Apache-2.0
"""The unit of a run: everything that one event did.

Rule: a Step is a value. Who performs its effects, writes it down or draws it needs nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.engine.decision import Question, Verdict
from rai_missions.engine.modes import Mode
from rai_missions.event import Event
from rai_missions.guards.view import Truth
from rai_missions.plain_data import listed
from rai_missions.states import answerer_words
from rai_missions.states.control import CONTROLLERS, Holder
from rai_missions.states.final import FinalOutcome

__all__ = (
    "Ask", "CallService", "CancelGoal", "Cause", "Effect", "Handover", "LogLine", "Move", "PublishMessage",
    "Refusal", "SayAloud", "StartBehaviour", "StartGoal", "Step", "StopBehaviour", "Withdraw", "control_note",
    "step_count",
)  # fmt: skip


def _sent(values: Mapping[str, Any]) -> str:
    return f" ({listed(values)})" if values else ""


class StartGoal(NamedTuple):
    """Send a goal to an action's server."""

    number: int
    owner: str
    """The state, or `state#path` for a leaf of a tree."""
    action: str
    goal: Mapping[str, Any]

    def describe(self) -> str:
        return f"start {self.action}{_sent(self.goal)} for {self.owner} (number {self.number})"


class CancelGoal(NamedTuple):
    """Ask for the end of a goal that was started under this number."""

    number: int
    action: str

    def describe(self) -> str:
        return f"cancel {self.action} (number {self.number})"


class CallService(NamedTuple):
    """Call a service; the reply comes back as a `result` with this number."""

    number: int
    owner: str
    """Empty for an effect whose reply no state waits for."""
    service: str
    request: Mapping[str, Any]
    timeout_s: float | None = None

    def describe(self) -> str:
        return f"call {self.service}{_sent(self.request)} (number {self.number})"


class PublishMessage(NamedTuple):
    """Publish a message on a topic of the profile."""

    topic: str
    message: Mapping[str, Any]

    def describe(self) -> str:
        return f"publish {self.topic}{_sent(self.message)}"


class SayAloud(NamedTuple):
    """A sentence to be spoken to people who are near."""

    text: str

    def describe(self) -> str:
        return f"say “{self.text}”"


class LogLine(NamedTuple):
    """A line of the mission's author for the journal's reader."""

    text: str

    def describe(self) -> str:
        return f"log “{self.text}”"


class Ask(NamedTuple):
    """Put a question to its answerer."""

    question: Question

    def describe(self) -> str:
        return f"ask {answerer_words(self.question.asked)} (question {self.question.number})"


class Withdraw(NamedTuple):
    """The question is no longer asked."""

    number: int

    def describe(self) -> str:
        return f"withdraw question {self.number}"


class Handover(NamedTuple):
    """Ask for control to be handed over; a `control` event reports when it is."""

    to: str

    def describe(self) -> str:
        return f"ask for control to go to {CONTROLLERS.get(self.to, self.to)}"


class StartBehaviour(NamedTuple):
    """Tick a behaviour that is written in Python, until it has ended or is stopped."""

    number: int
    owner: str
    """`state#path` of its leaf."""

    def describe(self) -> str:
        return f"tick the behaviour of {self.owner} (number {self.number})"


class StopBehaviour(NamedTuple):
    """Interrupt a behaviour that was started under this number."""

    number: int

    def describe(self) -> str:
        return f"stop the behaviour (number {self.number})"


Effect = (
    StartGoal
    | CancelGoal
    | CallService
    | PublishMessage
    | SayAloud
    | LogLine
    | Ask
    | Withdraw
    | Handover
    | StartBehaviour
    | StopBehaviour
)
"""What the performer is to do; `describe` has it in words."""

Refusal = Literal["", "not_started", "ended", "stale", "unknown", "unfit", "mode"]
"""Why an event changed nothing: the mission has not started, or has ended; nothing waits for the number any more; there
is no event, key, command, kind or holder of that name; the value does not fit its key; the mode forbids the command."""

Cause = Literal["", "invariant", "cycle"]
"""What ended a mission that its own rules did not end: an invariant that is false, or a cycle without end at one
instant. Empty for any other end, and while the mission runs."""


class Move(NamedTuple):
    """One microstep: the transitions that were taken together, and what they left and entered."""

    taken: tuple[str, ...]
    """JSON pointers of the transitions; empty for the entry of the mission and for what the engine does by itself."""
    exited: tuple[str, ...]
    """Innermost first."""
    entered: tuple[str, ...]
    """Outermost first."""
    trigger: str = ""
    """What fired it: an event's or outcome's name, `after_s`, or empty for an eventless transition."""


class Step(NamedTuple):
    """All that one event did, as a value: moves, writes, verdicts, and what the robot is asked for (`effects`)."""

    seq: int
    """From 1, without gaps in a run."""
    at: float
    event: Event
    moves: tuple[Move, ...] = ()
    """In the order in which they were made."""
    guards: tuple[tuple[str, Truth], ...] = ()
    """The guards that were looked at, by the JSON pointer of their transition or option, and their truth."""
    writes: tuple[tuple[str, Any], ...] = ()
    """The keys that were written and their new values, in order."""
    outcome: FinalOutcome | None = None
    """How the mission ended: `succeeded`, `failed`, `aborted`, `canceled`; None while it runs."""
    wake_at: float | None = None
    """The earliest instant at which time alone can change something; then a `Tick` is due."""
    effects: tuple[Effect, ...] = ()
    why: str = ""
    """The rule that decided the outcome, or why the event was refused or stale."""
    notes: tuple[str, ...] = ()
    """What a reader should know: verdicts, orphans, unknown invariants."""
    resting: tuple[str, ...] = ()
    """The states whose tree has reached a limit and rests, though it would be ticked again; `wake_at` is now where its
    rounds continue in the next step, else it waits for the next event that concerns it."""

    mode: Mode | None = None
    """The run's after this step; None in a row of a journal of an earlier version."""
    holder: Holder | None = None
    """Who holds control after this step; None as in `mode`."""
    verdicts: tuple[Verdict, ...] = ()
    """What the rules decided about proposals, and about questions that got none, in order."""
    refusal: Refusal = ""
    """Why the event was refused; empty where it was not. `why` has it in words, unless the mission ended here."""
    kept: bool = False
    """What the event brought waits: until the run is resumed, or the operator gives control back."""

    @property
    def verdict(self) -> Verdict | None:
        """What became of the proposal that this step was given; of any other step, the first verdict that it holds.

        None where nothing was judged, such as a proposal that is kept until the run is resumed.
        """
        event = self.event
        number = event.number if event.kind == "proposal" else None
        return next((each for each in self.verdicts if number in (None, each.number)), None)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The notes that are not the words of a verdict."""
        judged = {verdict.note for verdict in self.verdicts}
        return tuple(note for index, note in enumerate(self.notes) if index not in judged)

    @property
    def ignored(self) -> bool:
        """The event changed nothing but the blackboard and the clock."""
        return not (self.moves or self.effects or self.outcome or self.notes)

    @property
    def question(self) -> Question | None:
        """The question that this step asks, if it asks one."""
        return next((effect.question for effect in self.effects if isinstance(effect, Ask)), None)

    @property
    def questions(self) -> int:
        """How many more questions were put to an answerer; -1 where the one that was asked before is absent."""
        absent = sum(verdict.kind == "absent" for verdict in self.verdicts)
        return sum(isinstance(effect, Ask) for effect in self.effects) - absent

    @property
    def entered(self) -> tuple[str, ...]:
        """The states entered, in order."""
        return tuple(name for move in self.moves for name in move.entered)

    @property
    def exited(self) -> tuple[str, ...]:
        """The states left, in order."""
        return tuple(name for move in self.moves for name in move.exited)

    def stamp_of(self, key: str) -> float:
        """When a value that this step wrote was so, seconds on the run's clock; negative before the run began."""
        event = self.event
        stamp: Any = self.at
        if event.kind == "write" and event.name == key:
            stamp = event.data.get("stamp", event.at)
        elif event.kind == "command" and event.name == "take_up":
            stamp = event.data.get("heard", {}).get(key, (None, self.at))[1]
        return min(float(stamp), self.at) if isinstance(stamp, int | float) else self.at


def step_count(steps: Iterable[Step]) -> int:
    """How many steps were made: of each run the number of its last one.

    Readings that enabled nothing are steps as well; a journal holds them with the next one that did more.

    Args:
        steps: The steps of one run or of several, one after the other; some of a run may be left out.
    """
    count, last = 0, None
    for step in steps:
        if last is not None and (step.seq <= last.seq or step.at < last.at):  # another run begins
            count += last.seq
        last = step
    return count + (last.seq if last is not None else 0)


def control_note(holder: str) -> str:
    """The note of a step on who has control; journals keep it with the holder's own word."""
    return f"control: {holder}"
