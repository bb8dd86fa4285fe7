# SPDX-License-Identifier: Apache-2.0
"""A mission: the graph, frozen. The run, the check, the replay and the picture all read this.

Rule: all that a mission means is data in it; nothing in it can be executed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from rai_missions.errors import UsageError, suggestion
from rai_missions.given import check_given
from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.keys import Key, PythonType, Source, field_type
from rai_missions.kinds import PackageOffer, lacking, named
from rai_missions.model import (
    AnyOf,
    EventName,
    Format,
    KeyName,
    MissionModel,
    Name,
    Seconds,
    StateName,
    StateNames,
    TaggedModel,
    Text,
    fault,
    without_schema,
)
from rai_missions.redaction import shown
from rai_missions.states.decision import answerer_offer
from rai_missions.states.final import Final
from rai_missions.states.state import State, States, descendants
from rai_missions.states.transition import Transition, Transitions
from rai_missions.states.tree.behaviour import ONLY_IN_PYTHON, BehaviourLeaf

if TYPE_CHECKING:
    from rai_missions.mission.builder import Keys

FAMILIES: tuple[type[TaggedModel], ...] = (Guard, State)
"""The families of which other packages may offer kinds."""
__all__ = ("BUILT_IN_EVENTS", "EventSpec", "Mission", "given_mission")

BUILT_IN_EVENTS = ("call_failed", "orphaned", "uncertain")
"""Events that the engine raises; a mission may have transitions for them without declaring them."""


EventField = Literal["string", "number", "integer", "boolean", "object", "list"]


class EventSpec(MissionModel):
    """An event that may come from outside."""

    about: Text = ""
    """What has happened then, in a sentence."""
    fields: dict[Text, Annotated[EventField, BeforeValidator(field_type)]] = Field(default_factory=dict)
    """What its payload holds; read as `event.<field>`."""

    def __init__(self, about: str = "", *, fields: Mapping[str, EventField | PythonType] = {}) -> None: ...


def declared_events(given: Any) -> Any:
    """Events as an object, which may be written as a list of names."""
    listed = isinstance(given, list | tuple) and all(isinstance(name, str) for name in given)
    return {name: {} for name in given} if listed else given


def _declared_once(given: Any) -> Any:
    """Events as an object; of a list each is declared once."""
    seen = set[str]()
    for at, name in enumerate(given if isinstance(given, list | tuple) else ()):
        if not isinstance(name, str):
            continue
        if name in seen:
            raise fault("events", f"the event {shown(name)} is declared already; keep one", at=(at,))
        seen.add(name)
    return declared_events(given)


def _met(given: str) -> str:
    if why := lacking(given):
        raise fault("package", why)
    return given


Requirement = Annotated[Text, AfterValidator(_met)]


def _keys(given: Any) -> Any:
    return given.__keys__ if hasattr(given, "__keys__") else given


class Mission(MissionModel):
    """A statechart whose states run actions, trees, questions and calls; transitions own its state."""

    format: Format = 1
    """The version of the format."""
    name: Name
    """Its name: lower case letters, digits and `_`."""
    version: Text = "0.0.0"
    """The version of this mission, as its author counts."""
    about: Text = ""
    """What it is for, in a sentence; pictures and reports show it."""
    uses: tuple[Requirement, ...] = ()
    """The packages whose guards, activities and answerers it uses, each with its version: `orchard_kinds>=1`."""
    blackboard: Annotated[dict[KeyName, Key], BeforeValidator(_keys)] = Field(default_factory=dict)
    """What it knows: its keys, by their names."""
    events: Annotated[dict[EventName, EventSpec], BeforeValidator(_declared_once)] = Field(default_factory=dict)
    """What may happen outside, by name."""
    initial: StateNames
    """The state with which it begins, or one a region."""
    states: States = Field(min_length=1)
    """The states, by their names."""
    transitions: Transitions = ()
    """The mission's own transitions, tried after those of the states."""
    invariants: dict[Name, AnyOf[Guard]] = Field(default_factory=dict)
    """What must never be false; a run that finds one false ends as by an e-stop."""
    on_cancel: StateName | None = None
    """The state in which a cancel is carried out; without it everything is left and canceled."""
    cancel_s: Seconds = 30.0
    """Seconds that a cancel may take."""
    settle_s: Seconds = 0.0
    """Seconds that the facts may take to agree with a final's `requires`."""
    ready_s: Seconds = 10.0
    """Seconds that the start waits for the robot keys that are not optional."""

    def __init__(
        self,
        name: str,
        *,
        initial: str | Sequence[str],
        states: Mapping[str, State],
        version: str = "0.0.0",
        about: str = "",
        uses: Sequence[str] = (),
        keys: Keys | Mapping[str, Key] = {},  # noqa: B006 - declared, never used
        events: Sequence[str] | Mapping[str, EventSpec] = (),
        transitions: Sequence[Transition] = (),
        invariants: Mapping[str, GuardOrKey] = {},
        on_cancel: str | None = None,
        cancel_s: float = 30.0,
        settle_s: float = 0.0,
        ready_s: float = 10.0,
        format: Literal[1] = 1,
    ) -> None: ...

    @classmethod
    def spelled(cls, words: dict[str, Any]) -> dict[str, Any]:
        return {"blackboard" if word == "keys" else word: value for word, value in words.items()}

    @classmethod
    def meanings(cls) -> Mapping[str, str]:
        texts = super().meanings()
        return {**texts, "keys": texts["blackboard"]}

    _without_schema = model_validator(mode="before")(without_schema)

    @model_validator(mode="after")
    def _names_packages(self) -> Self:
        """A kind of another package is used under that package's name and version."""
        named_here = {named(each) for each in self.uses}
        for place, offer in self.foreign():
            if offer.package not in named_here:
                remedy = f'"uses": ["{offer.package}>={offer.version}"]'
                raise fault("uses", f"{offer} is used at {place}, and the mission does not list it; add {remedy}")
        return self

    def foreign(self) -> Iterator[tuple[str, PackageOffer]]:
        """What it uses of other packages, each with its JSON pointer.

        Raises:
            PydanticCustomError: No installed package offers the kind, which was made in Python.
        """
        rest: list[tuple[str, Any]] = [("", self)] if any(each.foreign for each in FAMILIES) else []
        while rest:
            place, thing = rest.pop()
            rest += thing.inside(place)
            if isinstance(thing, TaggedModel) and type(thing) in thing.foreign:
                offer = thing.offer(thing.word)
                if offer is None or thing.kind(thing.word) is not type(thing):
                    what = f"the {thing.family} '{thing.word}' at {place} is of {type(thing).__module__}"
                    raise fault("package", f"{what}, and no installed package offers it: give it an entry point")
                yield place, offer

    def packages(self) -> Mapping[str, str]:
        """The packages whose kinds it uses, and their versions here."""
        return {offer.package: offer.version for _, offer in self.foreign()}

    def answerers(self) -> Mapping[str, PackageOffer]:
        """Whom its decisions ask of the packages that `uses` lists, by name; nothing of them is loaded.

        Raises:
            UsageError: Two packages offer one name.
        """
        packages = {named(each) for each in self.uses}
        if not packages:
            return {}
        asked = (name for _, _, state in self.walk() for each in state.decisions().values() for name in each.ask)
        offers = ((name, answerer_offer(name)) for name in dict.fromkeys(asked))
        return {name: offer for name, offer in offers if offer is not None and offer.package in packages}

    @property
    def stem(self) -> str:
        """The mission's name as part of that of a file, a node or a function: without slashes, at most 100 letters."""
        return self.name.replace("/", "_")[:100]

    def walk(self) -> Iterator[tuple[str, str, State]]:
        """Every state in document order as (JSON pointer, name, state), outer before inner."""
        return descendants(self.states)

    def every_transition(self) -> Iterator[tuple[str, Transition]]:
        """Every transition with its JSON pointer: the mission's own, then those of the states in document order."""
        of_states = ((place, state.transitions) for place, _, state in self.walk())
        for place, transitions in (("", self.transitions), *of_states):
            for index, transition in enumerate(transitions):
                yield f"{place}/transitions/{index}", transition

    def keys_of(self, source: Source) -> dict[str, Key]:
        """The keys whose values come from there, in document order."""
        return {name: key for name, key in self.blackboard.items() if key.source == source}

    def needed_facts(self) -> tuple[str, ...]:
        """The keys that the robot must have reported before the mission starts."""
        return tuple(name for name, key in self.keys_of("robot").items() if not key.optional)

    def needed_arguments(self) -> tuple[str, ...]:
        """The arguments without which a run is refused."""
        arguments = self.keys_of("argument").items()
        return tuple(name for name, key in arguments if key.initial is None and not key.optional)

    def lasting_keys(self) -> frozenset[str]:
        """The keys that are what they were at the start: arguments, and what has an `initial` and is never written."""
        written = {each.key for thing in self.everything() for each in thing.writes()}
        own = {name for name, key in self.keys_of("mission").items() if key.initial is not None}
        return frozenset(
            name
            for name in self.keys_of("argument").keys() | (own - written)
            if self.blackboard[name].max_age_s is None
        )

    def predicates(self) -> frozenset[str]:
        """The predicates of the user's program that its guards name, in options and trees, too."""
        found = (reference for thing in self.everything() for reference in thing.references())
        return frozenset(name for refers, name, _ in found if refers.sort == "predicate")

    def behaviours(self) -> Mapping[str, BehaviourLeaf]:
        """`state#path` → the leaf there that is written in Python; a mission with one has no JSON."""
        return {f"{name}#{path}": leaf for _, name, state in self.walk() for path, leaf in state.behaviours().items()}

    def state(self, name: str) -> State:
        """The state of a name.

        Raises:
            KeyError: There is none.
        """
        for _, found, state in self.walk():
            if found == name:
                return state
        raise KeyError(f"no state '{name}'{suggestion(name, (each for _, each, _ in self.walk()))}")

    def end_words(self, outcome: str | None, active: Iterable[str]) -> str:
        """What its author states about the end that a run has reached; empty where there is nothing.

        Args:
            outcome: Of the run: one other than its final's has another reason, such as a `requires` that is not true.
            active: The names of the active states.
        """
        ends = (state for name in active if isinstance(state := self.states.get(name), Final))
        return next((end.about for end in ends if end.final == outcome), "")

    def written(self) -> dict[str, Any]:
        """As JSON has it.

        Raises:
            UsageError: A state runs a behaviour that is written in Python.
        """
        for owner, leaf in self.behaviours().items():
            raise UsageError(f"state '{owner.partition('#')[0]}' runs '{leaf.program()}': {ONLY_IN_PYTHON}")
        return {"format": self.format, **super().written()}


def given_mission(given: Any, taker: str) -> Mission:
    """What a program gave as a mission.

    Args:
        given: What was given.
        taker: The function that takes it, for the sentence: `check`.

    Raises:
        UsageError: It is none.
    """
    check_given(given, Mission, taker, "a Mission", "load(FILE) makes one of a file")
    mission: Mission = given
    return mission
