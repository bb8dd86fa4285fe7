# SPDX-License-Identifier: Apache-2.0
"""What a state is.

Rule: a state is data. What it does while it is active is worked out by a pure machine in the file of its kind.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, get_args

from pydantic import BeforeValidator, Field

from rai_missions.errors import suggestion
from rai_missions.guards.analysis import Distinctions
from rai_missions.guards.purity import impurity
from rai_missions.model import (
    AnyOf,
    Name,
    Seconds,
    StateName,
    TaggedModel,
    Text,
    fault,
)
from rai_missions.model.references import PATH, Refers, fields_of
from rai_missions.model.validation_errors import words_of
from rai_missions.redaction import clipped, shown
from rai_missions.states.control import Controller
from rai_missions.states.effects import Effect
from rai_missions.states.transition import Effects, Transition, Transitions

if TYPE_CHECKING:
    from rai_missions.states.decision import DecisionSpec, Option
    from rai_missions.states.tree.behaviour import BehaviourLeaf
    from rai_missions.states.tree.node import TreeNode

__all__ = ("OUTCOMES", "ActivityOutcome", "ResultKey", "State", "States", "TypeNeed")

TREE = "tree node"
"""The family of what an activity may make; its class is built upon this module."""
MOST_LETTERS = 60
"""A text that is longer is no name of an action or a mission."""
ActivityOutcome = Literal[
    "succeeded", "failed", "timed_out", "rejected", "canceled", "unverified", "aborted", "unclear", "refused"
]
"""What an activity can report about itself, next to a decision's options; the last two of a request that is read."""
OUTCOMES: tuple[ActivityOutcome, ...] = get_args(ActivityOutcome)

ResultKey = Annotated[Name, Refers("key", "result")]
"""A key of the mission that a field of a result is written to."""


class TypeNeed(NamedTuple):
    """The type that a state needs something to be of that it reads or writes."""

    place: str
    """JSON pointer from the state on."""
    path: str
    kind: str
    why: str
    """What it is for, in a clause."""
    is_goal: bool = False
    """A goal is read from it, as the planner reads one."""


class State(TaggedModel, family="state", group="rai_missions.activities", word=""):
    """A state that only waits; the other kinds are known by their word."""

    meant: ClassVar[Mapping[str, str]] = {
        "on": "transitions", "outcomes": "transitions", "regions": "parallel", "children": "states",
        "on_entry": "entry", "on_exit": "exit", "invoke": "action", "description": "about",
        "service": "call", "behavior_tree": "tree", "behaviour_tree": "tree", "question": "decision",
    }  # fmt: skip

    yields: ClassVar[bool] = True
    """What it runs is ended while someone else has control, or the run is paused, and begins again afterwards."""
    reports_robot: ClassVar[bool] = False
    """What its outcomes bring along is what the robot reported, so that success may rest on it."""
    LAST: ClassVar = frozenset(("entry", "exit", "transitions", "timeout_s", "handover_s"))

    about: Text = ""
    """What it is for, in a sentence; pictures, questions and reports show it."""
    control: Controller | None = None
    """Who must hold control while it is active; the innermost one decides."""
    entry: Effects = ()
    """What is done when it is entered."""
    exit: Effects = ()
    """What is done when it is left."""
    transitions: Transitions = ()
    """How it is left, or what is done without leaving it; tried in this order."""
    timeout_s: Seconds | None = Field(default=None, gt=0)
    """Seconds after the entry at which it reports `timed_out` and what it runs is canceled."""
    handover_s: Seconds = 5.0
    """Seconds that the handover of control may take before the start is `rejected`."""

    def __init__(
        self,
        *,
        about: str = "",
        control: Controller | None = None,
        entry: Effect | Sequence[Effect] = (),
        exit: Effect | Sequence[Effect] = (),
        transitions: Sequence[Transition] = (),
        timeout_s: float | None = None,
        handover_s: float = 5.0,
    ) -> None: ...

    # -- how it is read and written -----------------------------------------------------------------------------------

    @classmethod
    def admit(cls, kind: type[Any]) -> str:
        return super().admit(kind) or _lack(kind) or impurity(kind)

    @classmethod
    def choose(cls, data: Mapping[str, Any]) -> str:
        """A state has at most one kind's word; `each` comes with `states`, and none is a plain state."""
        if data.keys() <= cls.known_words():
            return ""
        given = [word for word in cls.kinds if word and word in data]
        if "each" in given and "states" in given:
            given.remove("states")
        unknown = [] if given else [str(word) for word in data if word not in cls.known_words()]
        given = given or [word for word in unknown if cls.kind(word) is not None]
        if "parallel" in given and isinstance(data["parallel"], bool):
            raise fault("kinds", _no_flag(data))
        if set(given) == {"parallel", "states"}:
            raise fault("kinds", "a state has 'states' or 'parallel'; regions are written \"parallel\": {…}, alone")
        if len(given) > 1:
            raise fault("kinds", f"a state is one thing, this is {len(given)}: {', '.join(given)}; nest or split it")
        if not given:
            for word in sorted(unknown, key=lambda each: each not in cls.meant):
                known = {*cls.known_kinds(), *cls.known_words()}
                near = f"; did you mean '{cls.meant[word]}'?" if word in cls.meant else suggestion(word, known)
                if not near.endswith("?") and len(owners := cls.kinds_with(word)) == 1:
                    near = f"; it belongs to one with '{owners[0]}'"
                raise fault("kind", f"a state has no '{word}'{near}")
        return given[0] if given else ""

    @classmethod
    def remedy(cls, data: Any) -> str:
        """A state that a text, or a node of a tree, most likely means."""
        if isinstance(data, TaggedModel) and data.family == TREE:
            return "; a tree is in a state of its own: Tree(…)"
        if not isinstance(data, str) or len(data) > MOST_LETTERS:
            return "; write {…}"
        word = "mission" if data.endswith(".json") else "action"
        return f"; write {json.dumps({word: data}, ensure_ascii=False)}, or {{}} for a state that waits"

    @classmethod
    def kinds_with(cls, word: str) -> list[str]:
        """The words of the format's kinds that have a word, as `call` has `request`."""
        return [each for each, kind in cls.kinds.items() if each and word in words_of(kind)]

    @classmethod
    def known_words(cls) -> frozenset[str]:
        """The words that every state may have."""
        return _common_words()

    def why_unusable(self) -> str:
        """Why its tree, outcomes or words are of no use; empty where they are."""
        made: Any = self.made()
        outcomes: Any = self.outcomes()
        activity: Any = self.activity()
        if made is not None and getattr(made, "family", "") != TREE:
            return f"'made' gives {shown(made, by=clipped)}, which is no tree"
        if not isinstance(outcomes, AbstractSet) or not all(isinstance(each, str) for each in outcomes):
            return f"'outcomes' gives {shown(outcomes, by=clipped)}, which is no set of names"
        return "" if isinstance(activity, str) else f"'activity' gives {shown(activity, by=clipped)}, which is no text"

    def written(self) -> dict[str, Any]:
        """The state as a person would write it: the words of its kind before those that every state has."""
        words = super().written()
        return {word: words[word] for word in sorted(words, key=self.LAST.__contains__)}

    # -- what is inside -----------------------------------------------------------------------------------------------

    def children(self) -> Mapping[str, State]:
        """The states directly inside it."""
        return {}

    def child_place(self) -> str:
        """The word under which its children are written."""
        return "states"

    def with_children(self, children: Mapping[str, State]) -> Self:
        """A copy with other states directly inside it; a state that has none stays as it is."""
        return self.model_copy(update={self.child_place(): dict(children)}) if self.children() else self

    def starts(self) -> tuple[str, ...]:
        """The states inside it with which it begins, by their names; empty where none is named."""
        return ()

    def inside(self, place: str = "") -> Iterator[tuple[str, Any]]:
        """The written things directly inside it, and the tree that it makes of them, which has its own place."""
        held, made = super().inside(place), self.made()
        return held if made is None else chain(held, ((place, made),))

    # -- what it runs -------------------------------------------------------------------------------------------------

    def machine(self, bench: Any) -> Any:
        """The machine of a kind of another package, which may know the engine; the format's own kinds register theirs.

        Args:
            bench: What it is made with, an `engine.activities.activity.Bench`.
        """
        return None

    def made(self) -> TreeNode | None:
        """The behaviour tree that a kind of another package makes of its fields, and that runs; None for none."""
        return None

    def root(self) -> TreeNode | None:
        """The behaviour tree that it runs, written in it or made of its fields; None for none."""
        return self.made()

    def nodes(self) -> Mapping[str, TreeNode]:
        """Path → the node of its tree, outer before inner."""
        root = self.root()
        return dict(root.paths()) if root is not None else {}

    def behaviours(self) -> Mapping[str, BehaviourLeaf]:
        """Path → the leaf of its tree that is written in Python, which JSON cannot hold."""
        return {path: leaf for path, node in self.nodes().items() if (leaf := node.behaviour()) is not None}

    def program(self) -> str:
        """What it runs of the user's program; empty for nothing."""
        return next((leaf.program() for leaf in self.behaviours().values()), "")

    def takes_time(self) -> bool:
        """Whether what it runs ends no sooner than something has been received, or time has passed."""
        return any(node.takes_time for node in self.nodes().values())

    # -- what it asks -------------------------------------------------------------------------------------------------

    def decisions(self) -> Mapping[str, DecisionSpec]:
        """What it asks: `#` and the path of a leaf of its tree, empty where it asks itself → the question."""
        if not (nodes := self.nodes()):
            return {}
        asked = ((f"#{path}", node.question()) for path, node in nodes.items())
        return {owner: question for owner, question in asked if question is not None}

    def question(self) -> DecisionSpec | None:
        """What it asks itself; None for nothing."""
        return self.decisions().get("")

    @property
    def options(self) -> Mapping[str, Option]:
        """The answers that are outcomes of its own."""
        asked = self.question()
        return asked.options if asked is not None else {}

    def with_options(self, names: Mapping[str, str]) -> State:
        """A copy with other names for some of its options."""
        return self

    def within(self, part: str) -> str:
        """The JSON pointer from here to what asks or is run there, as `decisions` names it."""
        return ""

    # -- what it reports and looks at, for checks and proofs ----------------------------------------------------------

    def outcomes(self) -> frozenset[str]:
        """What it can report about itself, next to the outcomes of children."""
        return frozenset({"timed_out"} if self.timeout_s is not None else ())

    def computed(self) -> frozenset[str]:
        """The outcomes of what it works out in the step in which it begins; empty for what runs longer."""
        return frozenset()

    def computed_examples(self, outcome: str) -> Sequence[Mapping[str, Any]]:
        """Examples of what it works out, as whole as it is written.

        Which fields are known is so in one of them, whatever it works out. Without examples nothing is known of that.

        Args:
            outcome: Of `computed`.
        """
        return ()

    def type_needs(self) -> Iterator[TypeNeed]:
        """What it reads or writes by itself that has to be of a type."""
        return iter(())

    def distinguish(self, by: Distinctions) -> None:
        """Which values of keys make a difference to what it runs; what it does with a key that it names is unknown."""
        for use in fields_of(type(self)):
            if use.hint is PATH:
                by.sample(getattr(self, use.name))

    # -- in words -----------------------------------------------------------------------------------------------------

    def activity(self) -> str:
        """What it runs while it is active, in a word or two; empty for nothing."""
        return ""

    def title(self) -> str:
        """What it is, in a line of a picture; empty for one that only waits, asks or holds others."""
        return self.activity()

    def details(self) -> Iterator[str]:
        """What else a reviewer must know of what it runs, a line each."""
        if self.timeout_s is not None:
            yield f"at most {self.timeout_s:g} s"

    def lines(self) -> Iterator[str]:
        """What else a reviewer must know of it, a line each."""
        yield from self.details()
        for word, does in (("entry", self.entry), ("exit", self.exit)):
            if does:
                yield f"{word}: {'; '.join(effect.details() for effect in does)}"

    def proof(self) -> str:
        """What must be so before its success is believed, in a sentence; empty where its own report suffices."""
        return ""

    def leads(self, option: str) -> str:
        """Where an answer of its own leads, in words."""
        ways = [each.leads() for each in self.transitions if option in each.on and each.of is None]
        return ", else ".join(ways) or "no transition of its own: it leads nowhere from here"


@cache
def _common_words() -> frozenset[str]:
    return frozenset(State.model_fields)


def _states(given: Any) -> Any:
    return dict(given) if isinstance(given, Mapping) else given


States = Annotated[dict[StateName, AnyOf[State]], BeforeValidator(_states)]


def descendants(states: Mapping[str, State], place: str = "/states") -> Iterator[tuple[str, str, State]]:
    """Every state in document order as (JSON pointer, name, state), outer before inner."""
    for name, state in states.items():
        here = f"{place}/{name.replace('~', '~0').replace('/', '~1')}"
        yield here, name, state
        if children := state.children():
            yield from descendants(children, f"{here}/{state.child_place()}")


def _no_flag(data: Mapping[str, Any]) -> str:
    """What to write where `parallel` is a flag."""
    rather = "write it in the place of 'states', without 'initial'" if "states" in data else "name them"
    regions, given = '{"left": {…}, "right": {…}}', str(data["parallel"]).lower()
    return f"'parallel' holds the regions themselves, {regions}, not {given}; {rather}, or take it away"


def _lack(kind: type[State]) -> str:
    runs = any(getattr(kind, name) is not getattr(State, name) for name in ("made", "root", "machine"))
    return "" if runs else "it has neither 'made' nor 'machine', so it runs nothing"
