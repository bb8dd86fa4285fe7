# SPDX-License-Identifier: Apache-2.0
"""A decision: the only place where a model, a person or a policy has a say, and how far it goes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.errors import nearest, suggestion
from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.kinds import PackageOffer, offered
from rai_missions.model import AnyOf, Bool, Json, KeyPath, MissionModel, Name, Path, Text, fault, refuse
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.state import OUTCOMES, State
from rai_missions.states.transition import Transition

__all__ = (
    "ACTING_TOOLS", "ANSWERERS", "BUDGET", "LOOKING_TOOLS", "Budget", "Decision", "DecisionFields", "DecisionSpec",
    "Option", "answerer_offer", "answerer_words",
)  # fmt: skip

ANSWERERS: Mapping[str, str] = {"agent": "the model", "operator": "the operator", "rules": "the fixed rules"}
"""By the word of `ask`. Where control is meant `agent` is the mission itself, so no reader sees the word alone."""

LOOKING_TOOLS = frozenset({
    "describe_type", "get_distance_to_objects", "get_image", "get_occupancy_grid", "get_robot_pose", "get_transform",
    "list_actions", "list_goals", "list_services", "list_topics", "recall", "receive_message", "watch_action",
})  # fmt: skip
"""The tools of ours that only look: a decision may name them."""
ACTING_TOOLS = frozenset({"call_service", "cancel_action", "navigate_to_pose", "publish_message", "start_action"})
"""The tools of ours that act: no decision has them."""


def answerer_words(name: str) -> str:
    """Whom a decision asks, for a reader: `the model`; any other name is of the program, or of another package."""
    return ANSWERERS.get(name, f"the answerer '{name}'")


def answerer_offer(name: str) -> PackageOffer | None:
    """Who offers an answerer, which no package can do under a name of ours; None if none does. Nothing is loaded.

    Raises:
        UsageError: Two packages offer it.
    """
    return None if name in ANSWERERS else offered("rai_missions.answerers", name, {})


class Option(MissionModel):
    """One answer that may be given, and when."""

    about: Text = ""
    """What it means, for anyone who is asked."""
    when: AnyOf[Guard] | None = None
    """Where this is not true the option is not offered, and not taken."""
    parameters: dict[str, Json] | None = None
    """JSON Schema of what the answer brings along, read as `answer.<name>` in the option's transition."""
    confirm: Bool = False
    """A person who chooses it by talk is asked once more before it counts."""

    def __init__(
        self,
        about: str = "",
        *,
        when: GuardOrKey | None = None,
        parameters: Mapping[str, Any] | None = None,
        confirm: bool = False,
    ) -> None: ...


class Budget(MissionModel):
    """How much a model may use for one decision."""

    calls: Annotated[int, Field(strict=True, ge=1)] = 8
    """Calls of the model and of read-only tools together."""
    tokens: Annotated[int, Field(strict=True, ge=1)] = 20_000
    """Tokens in and out together, where the provider counts them."""
    seconds: Annotated[float, Field(strict=True, gt=0)] | None = None
    """Seconds of wall time; the deadline bounds it anyway."""

    def __init__(self, *, calls: int = 8, tokens: int = 20_000, seconds: float | None = None) -> None: ...


BUDGET = Budget()


class DecisionSpec(MissionModel):
    """The question of a decision, its answers, and who is asked."""

    family: ClassVar = "decision"
    ordered = ("options",)

    question: Text
    """What is asked, in a sentence."""
    evidence: tuple[Path, ...] = ()
    """The keys that the question shows, pictures included."""
    options: dict[Name, Option] = Field(min_length=1)
    """The answers that may be given, by their names; each is an outcome."""
    ask: Annotated[tuple[Name, ...], Field(min_length=1)] = ("agent", "operator", "rules")
    """Who is asked, in this order; one that is absent is skipped. Other names than these three are answerers of the
    program, or of a package that the mission lists in `uses`."""
    attempts: Annotated[int, Field(strict=True, ge=1, le=100)] = 1
    """How often each is asked before the next is."""
    deadline_s: Annotated[float, Field(strict=True, gt=0)] | None = None
    """Seconds for the whole decision; then the fallback is taken."""
    within_s: Annotated[float, Field(strict=True, gt=0)] | None = None
    """Seconds that each of them has; left out, an equal share of the time left."""
    fallback: Name | None = None
    """The option taken when no one gave an answer that counts; it has no `when`."""
    budget: Budget = BUDGET
    """How much a model may use."""
    tools: tuple[Name, ...] = ()
    """The read-only tools that a model may use while it thinks."""

    def __init__(
        self,
        question: str,
        *,
        options: Mapping[str, Option],
        evidence: Sequence[KeyPath] = (),
        ask: Sequence[str] = ("agent", "operator", "rules"),
        attempts: int = 1,
        deadline_s: float | None = None,
        within_s: float | None = None,
        fallback: str | None = None,
        budget: Budget = BUDGET,
        tools: Sequence[str] = (),
    ) -> None: ...

    @model_validator(mode="after")
    def _options_fit(self) -> Self:
        refuse((*self._option_faults(), *self._fallback_faults()))
        return self

    def _fallback_faults(self) -> Iterator[PydanticCustomError]:
        if self.fallback is None:
            return
        at = ("fallback",)
        if self.fallback not in self.options:
            known = suggestion(self.fallback, self.options)
            yield fault("fallback", f"'fallback' names no option: '{self.fallback}'{known}", at=at)
            return
        option = self.options[self.fallback]
        if option.when is not None:
            yield fault(
                "fallback",
                f"the fallback '{self.fallback}' has a 'when'; it must always be open: drop its guard",
                at=at,
            )
        if option.parameters is not None:
            yield fault(
                "fallback", f"the fallback '{self.fallback}' takes parameters, and no answer would bring them", at=at
            )

    def _option_faults(self) -> Iterator[PydanticCustomError]:
        for name in self.options:
            if name in OUTCOMES:
                why = f"an option may not be called '{name}': that is an outcome; choose another word"
                yield fault("option", why, at=("options", name))

    def lines(self) -> Iterator[str]:
        """What is asked of whom, a line each."""
        yield f"“{self.question}”"
        if self.evidence:
            yield "shows " + ", ".join(self.evidence)
        often = f", {self.attempts} attempts each" if self.attempts > 1 else ""
        within = f", {self.within_s:g} s each" if self.within_s is not None else ""
        yield f"asks {', then '.join(map(answerer_words, self.ask))}{often}{within}"
        yield f"at most {self.deadline_s:g} s" if self.deadline_s is not None else "no deadline"
        if self.tools:
            yield "may use " + ", ".join(self.tools)

    def guards(self) -> Iterator[tuple[str, Guard]]:
        """Option → its guard, where it has one."""
        for name, option in self.options.items():
            if option.when is not None:
                yield name, option.when


class DecisionFields(MissionModel):
    """What a state that asks and a node of a tree that asks have in common."""

    decision: DecisionSpec
    """What is asked of whom."""

    @classmethod
    def spelled(cls, words: dict[str, Any]) -> dict[str, Any]:
        """The words of a constructor with those of its question under `decision`, as the format has them.

        A word that neither has is put where the nearest is, so that it is refused with that one.
        """
        if "decision" in words:
            return words
        asked = set(DecisionSpec.model_fields)
        known = asked | set(cls.model_fields)
        inside = {word for word in words if word in asked or (word not in known and nearest(word, known) in asked)}
        rest = {word: value for word, value in words.items() if word not in inside}
        return {"decision": {word: words[word] for word in words if word in inside}, **rest}

    @classmethod
    def meanings(cls) -> Mapping[str, str]:
        return {**DecisionSpec.meanings(), **super().meanings()}


class Decision(DecisionFields, State, word="decision"):
    """Asks. In Python the question's words are next to the state's: `Decision("What now?", options=…, ask=…)`."""

    yields: ClassVar = False

    def __init__(
        self,
        question: str,
        *,
        options: Mapping[str, Option],
        evidence: Sequence[KeyPath] = (),
        ask: Sequence[str] = ("agent", "operator", "rules"),
        attempts: int = 1,
        deadline_s: float | None = None,
        within_s: float | None = None,
        fallback: str | None = None,
        budget: Budget = BUDGET,
        tools: Sequence[str] = (),
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | frozenset(self.decision.options)

    def decisions(self) -> Mapping[str, DecisionSpec]:
        return {"": self.decision}

    def with_options(self, names: Mapping[str, str]) -> Decision:
        asked = self.decision
        options = {names.get(name, name): option for name, option in asked.options.items()}
        update = {"options": options, "fallback": names.get(asked.fallback or "", asked.fallback)}
        transitions = tuple(
            transition.model_copy(update={"on": tuple(names.get(word, word) for word in transition.on)})
            for transition in self.transitions
        )
        return self.model_copy(update={"decision": asked.model_copy(update=update), "transitions": transitions})

    def takes_time(self) -> bool:
        return True

    def activity(self) -> str:
        return "decision"

    def title(self) -> str:
        return ""

    def details(self) -> Iterator[str]:
        yield from self.decision.lines()
        yield from super().details()
