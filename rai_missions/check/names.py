# SPDX-License-Identifier: Apache-2.0
"""Names that there are not, that there are twice, or that mean two things."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef
from rai_missions.check.name_table import NameTable
from rai_missions.check.pointers import listed_names, pointer
from rai_missions.errors import escaped
from rai_missions.guards.named import Named
from rai_missions.mission.mission import BUILT_IN_EVENTS
from rai_missions.states.effects import Drop, Raise
from rai_missions.states.state import OUTCOMES
from rai_missions.states.transition import ANY_EVENT

__all__ = (
    "colliding_names",
    "duplicate_states",
    "literal_references",
    "repeated_names",
    "unknown_events",
    "unknown_ids",
    "unknown_predicates",
    "unknown_states",
)


def duplicate_states(index: MissionIndex) -> Found:
    """A state's name is unique in the mission, whatever it is in."""
    for spot in index.spots:
        first = index.by_name[spot.name]
        if first is not spot:
            yield spot.place, f"a second state is called '{spot.name}', as {first.place} is; give it a name of its own"


def repeated_names(index: MissionIndex) -> Found:
    """`on`, `evidence` and `tools` list each name once; a second one changes nothing."""
    lists = [(f"{each.place}/on", each.definition.on) for each in index.transitions if len(each.definition.on) > 1]
    for asked, place, _ in index.asked:
        lists += [(f"{place}/evidence", asked.evidence), (f"{place}/tools", asked.tools)]
    for place, listed in lists:
        for number, name in enumerate(listed):
            if name in listed[:number]:
                yield f"{place}/{number}", f"'{name}' is listed twice; drop this one"


def literal_references(index: MissionIndex) -> Found:
    """In a goal, a request, a message or a payload `from` takes a value; a similar word is sent as it is written."""
    for template, place in index.templates:
        items = template.items() if isinstance(template, Mapping) else ()
        for word, item in items:
            yield from _literal(index, item, f"{place}/{escaped(word)}")


def _literal(index: MissionIndex, value: Any, place: str) -> Found:
    if isinstance(value, list | tuple):
        for number, item in enumerate(value):
            yield from _literal(index, item, f"{place}/{number}")
    elif isinstance(value, Mapping):
        for word, item in value.items():
            here = f"{place}/{escaped(word)}"
            if len(value) == 1 and isinstance(item, str) and _is_like_from(word) and _is_path(index, item):
                yield here, f"'{word}' takes no value: the text '{item}' is sent; write {{\"from\": \"{item}\"}}"
            else:
                yield from _literal(index, item, here)


def _is_like_from(word: str) -> bool:
    """Whether a word is a misspelt `from` (letters swapped, missing or added), or `key`, which guards use instead."""
    return word != "from" and (
        word == "key" or sorted(word) == sorted("from") or bool(difflib.get_close_matches(word, ["from"], cutoff=0.8))
    )


def _is_path(index: MissionIndex, text: str) -> bool:
    root, dot, _ = text.partition(".")
    return root in index.keys or (bool(dot) and root in ("event", "answer"))


def unknown_states(index: MissionIndex) -> Found:
    """What `to`, `initial`, `of`, `in` and `on_cancel` name is a state."""
    for place, name in index.state_names:
        if name not in index.states:
            yield place, index.states.missing(name)


def unknown_events(index: MissionIndex) -> Found:
    """What `on` and `raise` name is an event, an outcome, or an option of the transition's own decision."""
    words = NameTable("event or outcome", (*index.events.known, *OUTCOMES))
    known = {ANY_EVENT, *words.known}
    options = {name: spot for spot in index.spots for name in spot.options}
    for transition in index.transitions:
        if known.issuperset(transition.definition.on):
            continue
        source = index.spot(transition.definition.of) if transition.definition.of is not None else transition.owner
        own = tuple(source.options) if source is not None else ()
        for place, word in listed_names(f"{transition.place}/on", transition.definition.on):
            if word not in known and word not in own:
                yield place, _of_another_sort(word, index) or _unknown_trigger(word, own, words, options)
    for effect, place, _ in index.effects:
        if isinstance(effect, Raise) and effect.event not in index.events:
            yield f"{place}/raise", index.events.missing(effect.event)


def _of_another_sort(word: str, index: MissionIndex) -> str:
    """The sentence on a word that fires nothing, but names a state or a key; empty for any other."""
    if word in index.states:
        return f"'{word}' is a state, and no event; name it in 'to' to lead there"
    if word in index.keys:
        return f"'{word}' is a key, and no event; compare it in 'when'"
    return ""


def _unknown_trigger(word: str, own: tuple[str, ...], words: NameTable, options: dict[str, StateRef]) -> str:
    if word in options:
        name = options[word].name
        return (
            f"'{word}' is an option of '{name}', and fires only transitions there: "
            f'move this one, or add "of": "{name}"'
        )
    close = difflib.get_close_matches(word, own, n=1, cutoff=0.6)
    if close:
        return f"no event, outcome or option '{word}'; did you mean '{close[0]}'?"
    return words.missing(word)


def unknown_ids(index: MissionIndex) -> Found:
    """What `drop` names is the `id` of a delayed `raise`."""
    raised = [done.effect for done in index.effects if isinstance(done.effect, Raise)]
    ids = NameTable("delayed 'raise' with the id", (effect.id for effect in raised if effect.id is not None))
    for effect, place, _ in index.effects:
        if isinstance(effect, Drop) and effect.drop not in ids:
            remedy = "" if ids.known else "; give the 'raise' that it takes back an 'id'"
            yield f"{place}/drop", ids.missing(effect.drop) + remedy
        elif isinstance(effect, Raise) and effect.id is not None and effect.after_s is None:
            yield (
                f"{place}/id",
                f"'{effect.event}' is raised at once, so nothing can drop '{effect.id}'; add 'after_s' or drop the id",
            )


def unknown_predicates(index: MissionIndex) -> Found:
    """What `named` names is a predicate that was registered, where the registered ones are known, and fits its use."""
    if index.predicates is None:
        return
    known = NameTable("registered predicate", index.predicates, "register it with --guards FILE.py")
    functions = index.predicates if isinstance(index.predicates, Mapping) else {}
    for place, part, _ in index.parts:
        for refers, name, here in part.references(place):
            if refers.sort == "predicate" and name not in known:
                yield here, known.missing(name)
        if isinstance(part, Named) and (function := functions.get(part.named)) is not None:
            yield from ((f"{place}/named", why) for why in _misfits(part, function))


def _misfits(guard: Named, function: Callable[..., Any]) -> Iterator[str]:
    """Why a predicate cannot be called as a guard calls it."""
    try:
        signature = inspect.signature(function)
    except ValueError:  # a builtin without a signature
        return
    try:
        signature.bind({}, **guard.with_)
    except TypeError:
        called, wanted = (
            ", ".join(["board", *(f"{word}=…" for word in guard.with_)]),
            ", ".join(["board", *guard.with_]),
        )
        yield (
            f"'{guard.named}' takes {signature}, and is called with ({called}): the blackboard and the values of "
            f"'with'; write def {guard.named}({wanted})"
        )


def colliding_names(index: MissionIndex) -> Found:
    """No event is called as an outcome, no option as an event, no key `event` or `answer`."""
    for name in index.mission.blackboard:
        if name in ("event", "answer"):
            what = "an event's payload" if name == "event" else "an option's parameters"
            yield (
                pointer("/blackboard", name),
                f"a key may not be called '{name}': '{name}.…' reads {what}; choose another word",
            )
    for name in index.mission.events:
        if name in OUTCOMES:
            yield (
                pointer("/events", name),
                f"an event may not be called '{name}': that is an outcome; choose another word",
            )
    for asked, place, _ in index.asked:
        for name in asked.options:
            if name in index.mission.events or name in BUILT_IN_EVENTS:
                sentence = f"an option may not be called '{name}': that is an event; choose another word"
                yield pointer(place, "options", name), sentence
