# SPDX-License-Identifier: Apache-2.0
"""Questions, proposals, and the verdict that decides whether a proposal counts.

Rule: a proposal is a wish. Only `judge`, on what is known at that moment, makes an outcome of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from rai_missions.event import Event
from rai_missions.given import check_given, given_names
from rai_missions.guards.view import Test, Truth, View
from rai_missions.image import Image
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.plain_data import apart, quoted
from rai_missions.redaction import clipped

__all__ = (
    "Answerer", "Evidence", "Limits", "Offer", "Proposal", "Question", "ReadsRun", "Verdict", "VerdictKind",
    "VerdictNote", "check_answerers", "judge", "malformed", "stale_verdict", "with_verdicts",
)  # fmt: skip


class Offer(NamedTuple):
    """One option as it is offered."""

    name: str
    about: str = ""
    parameters: Mapping[str, Any] | None = None
    """JSON Schema of what the answer must bring along, if anything."""


class Evidence(NamedTuple):
    """One key as the question shows it."""

    key: str
    value: Any
    """None where it was never received; an `Image` for pictures."""
    age_s: float | None
    """Seconds since it was so; None where it was never received."""
    fresh: bool

    def words(self) -> str:
        """`obstacle: {…}, 0.2 s old`, or `obstacle: unknown, 3.2 s old`."""
        age = "never heard" if self.age_s is None else f"{self.age_s:.1f} s old"
        if not self.fresh or self.value is None:
            return f"{self.key}: unknown, {age}"
        return f"{self.key}: {'a picture' if isinstance(self.value, Image) else quoted(self.value, self.key)}, {age}"


class Limits(NamedTuple):
    """How much an answerer may use for one answer."""

    calls: int = 8
    """Calls of a model and of read-only tools together."""
    tokens: int = 20_000
    """Tokens in and out together, where the provider counts them; once spent, no further call is begun."""
    seconds: float | None = None
    """Wall time; None: as long as the question is asked."""


class Question(NamedTuple):
    """What is asked, of whom, and which answers there are."""

    number: int
    """Its number in the run; an answer carries it."""
    owner: str
    """The state, or leaf of a tree (`state#path`), that asks."""
    asked: str
    """`agent`, `operator`, `rules` or a script's name."""
    text: str
    options: tuple[Offer, ...]
    evidence: tuple[Evidence, ...] = ()
    attempt: int = 1
    """1 for the first time that this answerer is asked."""
    at: float = 0.0
    """The instant at which it was asked, on the run's clock."""
    until: float = 0.0
    """The instant at which its time is over, on the run's clock."""
    refused: tuple[str, ...] = ()
    """Why the earlier answers to this decision were refused, oldest first."""
    tools: tuple[str, ...] = ()
    """The read-only tools that may be used while thinking."""
    budget: Limits = Limits()

    @property
    def state(self) -> str:
        """The state that asks."""
        return self.owner.partition("#")[0]

    def apart(self) -> Question:
        """A copy for the answerer, which shares no value with the question."""
        options = tuple(offer._replace(parameters=apart(offer.parameters)) for offer in self.options)
        evidence = tuple(each._replace(value=apart(each.value)) for each in self.evidence)
        return self._replace(options=options, evidence=evidence)


class Proposal(NamedTuple):
    """An answer without its reason, which is no fact: only the event that brought it has it, and no step states it."""

    option: str
    parameters: Mapping[str, Any] = {}


VerdictKind = Literal["proposal", "failed", "absent", "timed_out", "stale", "fallback"]
"""What was judged: an option that was proposed; an answer without one; an answerer that is absent, or gave no answer
within its time; a proposal whose question is not open; the fallback, taken because no answer was accepted."""


class Verdict(NamedTuple):
    """What the rules decide about a proposal, or about a question that got none."""

    accepted: bool
    """The option that was proposed is the decision's outcome."""
    why: str = ""
    """For a refusal: what was wrong and what would be right; the next question quotes it."""
    kind: VerdictKind = "proposal"
    number: int = 0
    """The question's."""
    by: str = ""
    """Who answered, or was asked; empty for the fallback."""
    option: str = ""
    """The option that was proposed, or the fallback; empty where there is none."""
    note: int | None = None
    """Which of the step's notes, from 0, has the verdict in words; None where none has."""


class VerdictNote(NamedTuple):
    """A verdict and its words, on their way into a step."""

    verdict: Verdict
    text: str


def stale_verdict(event: Event, why: str) -> Verdict:
    """What becomes of a proposal whose question is not open."""
    given = event.data.get("option")
    option = clipped(given, 60) if isinstance(given, str) else ""
    return Verdict(False, why, "stale", event.number, event.name, option)


def with_verdicts(notes: Iterable[str | VerdictNote]) -> tuple[tuple[str, ...], tuple[Verdict, ...]]:
    """The notes of a step in words, and its verdicts, each with the number of its note."""
    texts, verdicts = [], []
    for index, note in enumerate(notes):
        if isinstance(note, VerdictNote):
            verdicts.append(note.verdict._replace(note=index))
        texts.append(note.text if isinstance(note, VerdictNote) else note)
    return tuple(texts), tuple(verdicts)


@runtime_checkable
class Answerer(Protocol):
    """Answers questions: a model, a person, rules, a script."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Take a question; never waits.

        `answer` is called once, from any thread, with `{"option", "parameters", "why"}`, or `{"absent": why}`, or
        `{"failed": why}`. A second call is stale, and changes nothing. `usage` may come along:
        `{"calls", "tokens_in", "tokens_out", "seconds", "model"}`; and `looked`, what was looked up before the answer:
        `[{"tool", "arguments", "said"}]`, each text.
        """

    def withdraw(self, number: int) -> None:
        """The question is no longer asked: stop the work on it, answer nothing."""


def check_answerers(given: object) -> None:
    """Refuse what is no mapping of names to answerers; see `check_given`.

    Raises:
        UsageError: It is none; the answerer that is none is named.
    """
    for name, each in given_names(given, "answerers", "answerers").items():
        check_given(each, Answerer, f"'{name}' of answerers", "an answerer")


@runtime_checkable
class ReadsRun(Protocol):
    """An answerer that decides by what is known of the run."""

    def read_from(self, view: View) -> None:
        """Decide by this run from now on; it is read on the thread that asks."""


def judge(question: Question, proposal: Proposal, view: View, guards: Mapping[str, Test]) -> Verdict:
    """Whether a proposal counts, on what is known now.

    Args:
        question: As it was asked: its options are what was offered.
        proposal: The option's name and its parameters.
        view: The blackboard, configuration and time of this moment.
        guards: Option → its compiled guard; an option without one may always be taken.
    """
    if why := malformed(question, proposal):
        return Verdict(False, why)
    test = guards.get(proposal.option)
    value: Truth = True if test is None else test(view)
    if value is not True:
        truth = "no longer holds" if value is False else "is unknown now"
        return Verdict(False, f"the guard of '{proposal.option}' {truth}; choose another option")
    return Verdict(True)


def malformed(question: Question, proposal: Proposal) -> str:
    """Why a proposal is no answer to a question, whatever is known: its option, or its parameters; empty if it is."""
    offered = {offer.name: offer for offer in question.options}
    if proposal.option not in offered:
        return f"'{clipped(proposal.option, 60)}' was not offered; offered: {', '.join(offered)}"
    why = _parameters(offered[proposal.option], proposal.parameters)
    return f"the parameters of '{proposal.option}' are not valid: {why}" if why else ""


def _parameters(offer: Offer, given: Mapping[str, Any]) -> str:
    if offer.parameters is None:
        return "" if not given else f"'{offer.name}' takes none"
    return parameter_faults(offer.parameters, given)
