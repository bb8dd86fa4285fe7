# SPDX-License-Identifier: Apache-2.0
"""A goal as data: a closed list of predicates over named things, or a refusal.

Rule: nothing but what is declared here can be asked for; unknown words are refused, nothing is coerced.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, PlainSerializer, Strict, field_validator

from rai_missions.model import AnyOf, MissionModel, TaggedModel, Text, fault
from rai_missions.model.validation_errors import validated

__all__ = (
    "FIRST_SEEN", "Apart", "AtPlace", "Behind", "Between", "Beyond", "Goal", "Grouped", "InContainer", "LeftOf",
    "NextTo", "OnTop", "Predicate", "Refusal", "Shifted", "Swapped", "goal_schema", "read_goal",
)  # fmt: skip

MOST = 64
"""Predicates of a goal, and things of a predicate, at the most."""
ThingName = Annotated[Text, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
"""The name of a thing that is seen: `red_cube_2`; where its field explains so, `desk` too."""
Pair = tuple[ThingName, ThingName]
Several = Annotated[tuple[ThingName, ...], Field(min_length=2, max_length=MOST), PlainSerializer(list)]
Metres = Annotated[float, Strict(), Field(ge=-10, le=10, allow_inf_nan=False)]
Gap = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]


class Predicate(TaggedModel, family="predicate"):
    """What is wanted of one or several things."""

    def things(self) -> tuple[str, ...]:
        """The names in it, in their order, `desk` included."""
        named = getattr(self, type(self).named_in)
        return (named,) if isinstance(named, str) else named

    named_in: ClassVar[str] = ""
    """The field that has the names."""
    is_mutual: ClassVar[bool] = False
    """Whether it asks for the same in whatever order the things are named."""

    def __init_subclass__(cls, *, named_in: str = "", is_mutual: bool = False, **rest: Any) -> None:
        super().__init_subclass__(**rest)
        cls.named_in, cls.is_mutual = named_in or cls.word, is_mutual

    @property
    def meaning(self) -> Hashable:
        """What it asks for: the same for two that hold of the same desks."""
        return (self.word, frozenset(self.things())) if self.is_mutual else self


def _different(names: tuple[str, ...]) -> tuple[str, ...]:
    doubled = next((name for place, name in enumerate(names) if name in names[:place]), None)
    if doubled is not None:
        raise fault("same", f"'{doubled}' is named twice; a relation is between different things")
    return names


def _no_desk(names: tuple[str, ...]) -> tuple[str, ...]:
    if "desk" in names:
        raise fault("desk", "'desk' carries all things and is none of them; only 'on' may have it, as its second name")
    return _different(names)


def _alone(name: str) -> str:
    return _no_desk((name,))[0]


class OnTop(Predicate, word="on"):
    """One thing rests on another, or on the desk: `{"on": ["a", "b"]}`; a tower is its relations from below."""

    on: Pair
    """What is on top, and what it rests on, which may be `desk`."""

    def __init__(self, on: tuple[str, str]) -> None: ...

    @field_validator("on")
    @classmethod
    def _two_things(cls, names: tuple[str, str]) -> tuple[str, str]:
        _no_desk(names[:1])
        _different(names)
        return names


class AtPlace(Predicate, word="at"):
    """A thing at a place, whatever carries it there: `{"at": "a", "x": 0.5, "y": 0.1}`."""

    at: Annotated[ThingName, AfterValidator(_alone)]
    """The thing whose centre is meant."""
    x: Metres
    """Metres in front of the robot's base."""
    y: Metres
    """Metres to the left of the robot's base."""

    def __init__(self, at: str, x: float, y: float) -> None: ...


class InContainer(Predicate, word="in", named_in="in_"):
    """A thing inside a tray or a bin, its whole footprint: `{"in": ["a", "tray"]}`."""

    in_: Annotated[Pair, Field(alias="in")]
    """The thing, and what holds it."""

    def __init__(self, in_: tuple[str, str]) -> None: ...

    _separate = field_validator("in_")(_no_desk)


class Beyond(Predicate):
    """One thing further along an axis of the robot's base frame than another, both at rest on something."""

    axis: ClassVar[int]
    """0 for x, ahead of the robot; 1 for y, to its left."""
    if TYPE_CHECKING:  # each kind declares it, after its things
        gap_m: float | None

    @property
    def pair(self) -> Pair:
        """The thing further along, and the other."""
        further, other = self.things()
        return further, other


class LeftOf(Beyond, word="left_of"):
    """One thing to the left of another, both at rest on something: `{"left_of": ["a", "b"], "gap_m": 0.05}`.

    Left is greater y: the robot's left. Without a gap any distance will do.
    """

    axis: ClassVar = 1

    left_of: Pair
    """The left one, and the other."""
    gap_m: Gap | None = None
    """The free distance between the two along y in metres; the two are then side by side."""

    def __init__(self, left_of: tuple[str, str], gap_m: float | None = None) -> None: ...

    _separate = field_validator("left_of")(_no_desk)


class Behind(Beyond, word="behind"):
    """One thing behind another as the robot sees them, both at rest on something: `{"behind": ["a", "b"]}`.

    Behind is greater x: further from the robot. Without a gap any distance will do.
    """

    axis: ClassVar = 0
    behind: Pair
    """The one further from the robot, and the other."""
    gap_m: Gap | None = None
    """The free distance between the two along x in metres; the two are then one behind the other."""

    def __init__(self, behind: tuple[str, str], gap_m: float | None = None) -> None: ...

    _separate = field_validator("behind")(_no_desk)


class Between(Predicate, word="between"):
    """One thing between two others, from above: `{"between": ["a", "b", "c"]}`, a between b and c."""

    between: tuple[ThingName, ThingName, ThingName]
    """The one in the middle, and the two at the ends."""

    def __init__(self, between: tuple[str, str, str]) -> None: ...

    _separate = field_validator("between")(_no_desk)

    @property
    def meaning(self) -> Hashable:
        middle, *ends = self.between
        return self.word, middle, frozenset(ends)


class NextTo(Predicate, word="next_to", is_mutual=True):
    """Two things side by side, neither on the other: `{"next_to": ["a", "b"]}`."""

    next_to: Pair
    """The two."""

    def __init__(self, next_to: tuple[str, str]) -> None: ...

    _separate = field_validator("next_to")(_no_desk)


class Grouped(Predicate, word="grouped", is_mutual=True):
    """Things close together, each with a near neighbour of the group: `{"grouped": ["a", "b", "c"]}`."""

    grouped: Several
    """The things of the group."""

    def __init__(self, grouped: tuple[str, ...]) -> None: ...

    _separate = field_validator("grouped")(_no_desk)


class Apart(Predicate, word="apart", is_mutual=True):
    """Things of which no two are near each other: `{"apart": ["a", "b"]}`."""

    apart: Several
    """The things that are to be apart."""

    def __init__(self, apart: tuple[str, ...]) -> None: ...

    _separate = field_validator("apart")(_no_desk)


class Swapped(Predicate, word="swapped", is_mutual=True):
    """Two things, each where the other was first seen: `{"swapped": ["a", "b"]}`.

    It depends on poses that are gone once a thing has moved: `at_first_poses` rewrites it when the goal is read.
    """

    swapped: Pair
    """The two."""

    def __init__(self, swapped: tuple[str, str]) -> None: ...

    _separate = field_validator("swapped")(_no_desk)


class Shifted(Predicate, word="shifted"):
    """A thing so far from where it was first seen: `{"shifted": "a", "dx": 0.0, "dy": 0.1}`.

    By nothing, it stays there.
    It depends on a pose that is gone once the thing has moved: `at_first_poses` rewrites it when the goal is read.
    """

    shifted: Annotated[ThingName, AfterValidator(_alone)]
    """The thing."""
    dx: Metres
    """Metres ahead, away from the robot."""
    dy: Metres
    """Metres to the robot's left."""

    def __init__(self, shifted: str, dx: float, dy: float) -> None: ...


FIRST_SEEN = (Swapped, Shifted)
"""Predicates about the poses first seen."""


class Goal(MissionModel):
    """What is wanted: every predicate of a list at once."""

    all: Annotated[tuple[AnyOf[Predicate], ...], Field(min_length=1, max_length=MOST), PlainSerializer(list)]
    """The predicates."""

    def __init__(self, all: tuple[Predicate, ...]) -> None: ...

    def of_kind(self, *kinds: type[Predicate]) -> Iterator[Any]:
        """The goal's predicates of some kinds, in the order written."""
        return (each for each in self.all if isinstance(each, kinds))

    def things(self) -> tuple[str, ...]:
        """The names of all things in it, `desk` not counted, each once, in the order of their first mention."""
        return tuple(dict.fromkeys(name for each in self.all for name in each.things() if name != "desk"))

    @property
    def meaning(self) -> Hashable:
        """What is wanted, in whatever order it is written."""
        return frozenset(each.meaning for each in self.all)


class Refusal(MissionModel):
    """Why a request is not carried out: `{"refused": "absent", "about": "there is no lemon on the desk"}`."""

    refused: Annotated[Text, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
    """The reason's code."""
    about: Annotated[Text, Field(max_length=1000)] = ""
    """A sentence for the person."""

    def __init__(self, refused: str, about: str = "") -> None: ...


def read_goal(data: object) -> Goal | Refusal:
    """A goal or a refusal from plain data.

    Raises:
        DefinitionError: With every fault, each with its JSON pointer.
    """
    kind: type[Goal | Refusal] = Refusal if isinstance(data, Mapping) and "refused" in data else Goal
    if isinstance(data, kind):
        return data
    return validated(kind, data)


def goal_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a goal or a refusal, for models that answer in it."""
    goal = Goal.model_json_schema()
    goal["properties"]["all"]["items"] = {"anyOf": [kind.model_json_schema() for kind in Predicate.kinds.values()]}
    return {"anyOf": [goal, Refusal.model_json_schema()]}
