# SPDX-License-Identifier: Apache-2.0
"""What can be read of a mission of which some words cannot, so that the rest of it is judged as well.

Rule: what cannot be read is replaced by something neutral at the same place; no pointer into the rest moves.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import ValidationError

from rai_missions.errors import Fault, pointer, steps_of
from rai_missions.mission.mission import BUILT_IN_EVENTS, Mission, declared_events
from rai_missions.mission.readings import sure_faults
from rai_missions.mission.schema import STRONGER
from rai_missions.model.validation_errors import KEY, faults_of, model_at, place_of, refusals

__all__ = ("LegiblePart", "is_entry", "legible_part", "words_in")

Steps = tuple[str | int, ...]
ROUNDS = 30
"""A document that is not read after so many repairs is left."""
MOST_FAULTS = 200
"""Where more than so many words cannot be read, the rest is left: it would take long, and there is enough to mend."""
UNREAD = "not_legible"
"""The predicate, and the text, in the place of what cannot be read."""
GUARDS = frozenset({"when", "achieved", "requires", "not", "possible", "held", "all", "any"})
"""The words whose value is a guard or a list of guards."""
EFFECTS = frozenset({"do", "entry", "exit"})
TARGETS = frozenset({"to", "transitions", "default", "initial", "on_cancel"})
REPORTING = frozenset({"decision"})
"""The words of a state whose value decides which options it has."""
STATES = frozenset({"states", "parallel"})
NAMED = frozenset({*STATES, "blackboard", "events", "options", "invariants"})
"""The words whose value has names of the author."""
UNREADABLE: frozenset[Steps] = frozenset({(), ("blackboard",), ("events",), ("states",), ("uses",), ("format",)})
"""Where one of these cannot be read, the rest of a mission has no meaning."""
KEPT = frozenset({"about", "transitions", "states", "parallel", "initial", "entry", "exit"})
"""What of a state is tried again where it cannot be read."""


class LegiblePart(NamedTuple):
    """A mission without what cannot be read."""

    mission: Mission
    unread: tuple[Steps, ...]
    """The places of what was replaced or left out."""
    names: frozenset[str]
    """All words in it, for it may declare or mention a name."""
    has_states: bool
    """The names of all states are known."""
    has_targets: bool
    """Whatever leads to a state is known."""
    faults: tuple[Fault, ...] = ()
    """What else cannot be read, which what was replaced first had hidden."""

    def hides(self, place: str) -> bool:
        """Whether a place is, or is inside, what was replaced or left out."""
        return any(_within(place, pointer(steps)) for steps in self.unread)

    def has_words_of(self, place: str) -> bool:
        """Whether it is known which events and options the state around a place reports."""
        for steps in self.unread:
            around = _entry(steps)
            if _within(place, pointer(around)) and (around == steps or steps[len(around)] in REPORTING):
                return False
        return True

    def mentions(self, text: str) -> bool:
        """Whether a name, or the key of a path, is among the words of what was replaced or left out."""
        return text in self.names or text.partition(".")[0] in self.names

    def touches(self, place: str) -> bool:
        """Whether something of the state, key or event that a place belongs to was replaced or left out."""
        return any(_within(place, pointer(_entry(steps))) for steps in self.unread)


def legible_part(data: Mapping[str, Any]) -> LegiblePart | None:
    """What can be read of a mission that cannot be read whole; None for too little.

    Args:
        data: The JSON document.
    """
    written = {word: declared_events(item) if word == "events" else item for word, item in data.items()}
    document, original = copy.deepcopy(written), copy.deepcopy(written)
    repair = _Repair(document, original)
    faults: list[Fault] = []
    for _ in range(ROUNDS):
        try:
            mission = Mission.model_validate(document)
        except ValidationError as error:
            if error.error_count() > MOST_FAULTS:
                return None
            found = tuple(faults_of(error, Mission, document))
            faults += [each for each in found if _is_original(each.place, original, document)]
            faults += repair.sure_faults({each.place for each in found})
            if not repair.attempt(error):
                return None
        else:
            return LegiblePart(
                _joined(mission, document, repair.names),
                tuple(repair.unread),
                frozenset(repair.names),
                repair.has_states,
                repair.has_targets,
                tuple(dict.fromkeys(faults)),
            )
    return None


def _joined(mission: Mission, document: dict[str, Any], names: set[str]) -> Mission:
    """The mission, in which each state that is mentioned in what cannot be read counts as reached."""
    mentioned = [name for _, name, _ in mission.walk() if name in names]
    if not mentioned:
        return mission
    more = [{"on": BUILT_IN_EVENTS[0], "to": name} for name in mentioned]
    return Mission.model_validate({**document, "transitions": [*document.get("transitions", []), *more]})


class _Repair:
    """Replaces in a document what cannot be read.

    Args:
        document: Changed in place.
        original: As its author wrote it, but for guards that were replaced: no name around one depends on it.
    """

    def __init__(self, document: dict[str, Any], original: dict[str, Any]) -> None:
        self._document, self._original = document, original
        self.unread: list[Steps] = []
        self._unknown: dict[Steps, list[tuple[str, Any]]] = {}
        """The place of an object → the words of it that are unknown, with their values."""
        self._tried: set[Steps] = set()
        self._misnamed: set[Steps] = set()
        self.names: set[str] = set()
        self.has_states = self.has_targets = True

    def attempt(self, error: ValidationError) -> bool:
        """Replace what an error is about; False where it cannot be."""
        targets = set()
        for item in refusals(error):
            steps = tuple(place_of(item, self._document))
            if item["loc"] and item["loc"][-1] == KEY:
                self._misnamed.add(steps)
            if item["type"] == "extra_forbidden":
                self._unknown.setdefault(steps[:-1], []).append((str(steps[-1]), item["input"]))
            targets.add(self._target(steps, item["type"]))
        inside = (each for each in targets if any(each[:length] in targets for length in range(len(each))))
        outermost = targets - {(), *inside}
        return bool(outermost) and not targets & UNREADABLE and all(map(self._replace, outermost))

    def sure_faults(self, places: Collection[str]) -> Iterator[Fault]:
        """What is wrong with objects of which nothing but an unknown word was left out, whatever it was meant to be.

        Args:
            places: Where there is a fault now; objects without one in them have none.
        """
        for steps, unknown in self._unknown.items():
            if not any(_within(place, pointer(steps)) for place in places):
                continue
            kind = model_at(Mission, self._document, steps)
            (word, value), here = unknown[0], _at(self._document, steps)
            is_left_out = isinstance(here, Mapping) and {**here, word: value} == _at(self._original, steps)
            if kind is not None and len(unknown) == 1 and is_left_out:
                place = pointer(steps)
                yield from (Fault(place + each.place, each.sentence) for each in sure_faults(kind, here, word, value))

    def _target(self, steps: Steps, kind: str) -> Steps:
        """The smallest thing around a fault that can be replaced or left out."""
        for length in range(len(steps), 0, -1):
            here = steps[:length]
            if _is_guard(here) or self._is_listed(here) or is_entry(here):
                return here
            if (_is_node(here) and not is_entry(here)) or self._is_deciding(here):
                continue
            if isinstance(here[-1], str) and (length < len(steps) or kind != "missing"):
                return here
        return ()

    def _is_deciding(self, steps: Steps) -> bool:
        """Whether the object around a word would be read as another kind without it: `in` alone asks for a state."""
        holder = _inside(self._document, steps[:-1])
        return any(steps[-1] in stronger and word in holder for (_, word), stronger in STRONGER.items())

    def _is_listed(self, steps: Steps) -> bool:
        return len(steps) > 1 and isinstance(steps[-1], int) and steps[-2] in {"transitions", *EFFECTS}

    def _replace(self, steps: Steps) -> bool:
        holder, last = _inside(self._document, steps[:-1]), steps[-1]
        is_object = isinstance(holder, dict)
        if (not is_object and not isinstance(holder, list)) or (is_object and last not in holder):
            return False
        was, again = holder[last], steps in self._tried
        self._tried.add(steps)
        neutral = None if steps in self._misnamed else self._neutral(steps, was, again=again)
        if isinstance(was, Mapping) and isinstance(neutral, Mapping) and was and neutral.items() <= was.items():
            for word in was.keys() - neutral.keys():
                self._forget((*steps, word), was[word])
        else:
            self._forget(steps, was)
        if neutral is None and is_object:
            del holder[last]
        elif neutral is None or neutral == was:
            return False
        else:
            holder[last] = neutral
            if _is_guard(steps):
                _inside(self._original, steps[:-1])[last] = neutral
        return True

    def _forget(self, steps: Steps, was: Any) -> None:
        """Remember what is not known any more."""
        last, word = steps[-1], steps[-2] if len(steps) > 1 else ""
        self.unread.append(steps)
        if not isinstance(was, Mapping) and (last in STATES or (is_entry(steps) and word in STATES)):
            self.has_states = self.has_states and not isinstance(was, list)  # text and numbers hold no state's name
            self.has_targets = self.has_targets and last in _flags({str(last): was})
        if last in TARGETS or (isinstance(last, int) and word == "transitions"):
            self.has_targets = False
        self.names.update(words_in(was))
        if steps[0] in ("blackboard", "events"):
            self.names.update(map(str, steps[1:2]))
        if is_entry(steps):
            self.names.add(str(last))

    def _neutral(self, steps: Steps, was: Any, *, again: bool) -> Any:
        """What takes the place of something; None where it is left out."""
        if _is_guard(steps):
            return {"named": UNREAD}
        word = steps[-2] if len(steps) > 1 else ""
        if self._is_listed(steps):
            return {"when": {"named": UNREAD}} if word == "transitions" else {"log": UNREAD}
        if steps == ("name",):
            return UNREAD
        if steps[-1] == "initial" and word not in NAMED and "blackboard" not in steps:
            return self._first_child(steps[:-1])
        if not is_entry(steps) or word == "options":
            return {} if is_entry(steps) else None
        if word in STATES:
            kept = {key: was[key] for key in was if key in KEPT - _flags(was)} if isinstance(was, Mapping) else {}
            return kept if kept != was and not again else {"final": "aborted"} if was == {} else {}
        return {"type": "string", "initial": ""} if word == "blackboard" else None if again else {}

    def _first_child(self, steps: Steps) -> str | None:
        inner = _inside(self._document, steps).get("states")
        return next(iter(inner), None) if isinstance(inner, Mapping) else None


def _inside(document: Any, steps: Steps) -> Any:
    """What is at a place, which must be there."""
    for step in steps:
        document = document[step]
    return document


def _at(document: Any, steps: Steps) -> Any:
    """What is at a place; None where there is nothing."""
    try:
        return _inside(document, steps)
    except (KeyError, IndexError, TypeError):
        return None


def _flags(state: Mapping[str, Any]) -> frozenset[str]:
    """The word `parallel` where it is written as a flag: it holds no region."""
    return frozenset({"parallel"} if isinstance(state.get("parallel"), bool) else ())


def _is_original(place: str, data: Any, document: Any) -> bool:
    """Whether the object at a place, or around it, is as its author wrote it; if not, a repair may be the cause."""
    steps, around = steps_of(place), (data, document)
    for index, name in enumerate(steps):
        step: Any = name
        if isinstance(data, list) and isinstance(document, list) and name.isdigit():
            step = int(name)
        try:
            data, document = data[step], document[step]
        except (KeyError, IndexError, TypeError):
            if index < len(steps) - 1:
                return False
            break  # a word that is missing
        if isinstance(document, Mapping | list):
            around = data, document
    return bool(around[0] == around[1])


def is_entry(steps: Sequence[str | int]) -> bool:
    """Whether it is something that the author named."""
    return len(steps) > 1 and steps[-2] in NAMED and isinstance(steps[-1], str) and steps[-1] != "options"


def _is_guard(steps: Steps) -> bool:
    if len(steps) > 1 and steps[-2] == "invariants":
        return True
    if isinstance(steps[-1], int):
        return len(steps) > 1 and steps[-2] in ("all", "any")
    return steps[-1] in GUARDS - {"all", "any"} and not (len(steps) > 1 and steps[-2] in NAMED)


def _is_node(steps: Steps) -> bool:
    """Whether it belongs to the nodes of a tree, for which there is nothing neutral, and not to a question in it."""
    return "tree" in steps[:-1] and "decision" not in steps[steps.index("tree") : -1]


def _entry(steps: Steps) -> Steps:
    """The innermost state, key, event or invariant around a place; the place itself where there is none."""
    found = (
        steps[:length]
        for length in range(len(steps), 1, -1)
        if is_entry(steps[:length]) and steps[length - 2] != "options"
    )
    return next(found, steps)


def _within(place: str, outer: str) -> bool:
    return place == outer or place.startswith(f"{outer}/")


def words_in(value: Any) -> Iterator[str]:
    """Every text and word in a JSON value, and the keys of paths."""
    if isinstance(value, str):
        yield from (value, value.partition(".")[0])
    elif isinstance(value, Mapping):
        for word, item in value.items():
            yield word
            yield from words_in(item)
    elif isinstance(value, Sequence):
        for item in value:
            yield from words_in(item)
