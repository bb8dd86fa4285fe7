# SPDX-License-Identifier: Apache-2.0
"""From a profile's `conversation` to the settings of a dialogue, and what is at fault in it."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.conversation import Settings
from rai_missions.conversation.grammar.start_phrases import arguments_of
from rai_missions.conversation.language.language import language, languages, spoken
from rai_missions.conversation.language.phrases import SLOT, Phrases
from rai_missions.errors import DefinitionError, Fault, MissionError, UsageError, pointer, suggestion
from rai_missions.keys import Key, type_error
from rai_missions.mission.mission import Mission
from rai_missions.profile import ConversationPolicy, Robot

__all__ = ("conversation_faults", "conversation_oddities", "settings_of")


def settings_of(policy: ConversationPolicy | None, missions: Iterable[Mission] = ()) -> Settings:
    """The settings of a robot's dialogue; those of no profile where it states none.

    Args:
        policy: As the profile has it.
        missions: Those that the dialogue may start. The listed values of an argument are named as they are written,
            where the profile has no names for them.
    """
    policy = policy or ConversationPolicy()
    listed = {
        name: {spoken(value): value for value in key.enum}
        for mission in missions
        for name, key in mission.keys_of("argument").items()
        if key.enum is not None
    }
    return Settings(
        language=policy.language,
        may=policy.granted(),
        requests=policy.requests,
        late=policy.while_answering,
        phrases=policy.phrases,
        spoken=policy.spoken,
        names={**listed, **policy.names},
        places=policy.places,
        questions=policy.questions,
        asked_with=policy.asked_with,
        results=policy.results,
    )


def conversation_faults(robot: Robot, mission: Mission | None = None) -> tuple[Fault, ...]:
    """What is wrong with how a robot is to talk.

    Args:
        robot: The profile.
        mission: What it is to run. A phrase that gives only arguments of other missions is no fault.
    """
    policy = robot.conversation
    if policy is None:
        return ()
    if of_language := _language_faults(policy.language):
        return of_language
    keys = mission.keys_of("argument") if mission is not None else {}
    takes, found = keys.keys(), list[Fault]()
    for place, slots, arguments in _sentences(policy):
        if isinstance(slots, Fault):
            found.append(slots)
        else:
            found += _argument_faults(arguments_of(slots, arguments), takes, place)
            found += _value_faults(arguments, keys, place)
    for name, values in policy.names.items():
        for words, value in values.items():
            found += _value_faults({name: value}, keys, pointer(("conversation", "names", name, words)))
    return (*found, *_question_faults(policy, mission))


def _language_faults(code: str) -> tuple[Fault, ...]:
    """Why a language cannot be spoken: there is none, or its package's file is at fault, each fault with that file."""
    if code in languages():
        return ()
    try:
        language(code)
    except DefinitionError as error:
        return tuple(fault._replace(file=error.source) for fault in error.faults)
    except MissionError as error:
        return (Fault("/conversation/language", str(error)),)
    return ()


def _sentences(policy: ConversationPolicy) -> Iterator[tuple[str, frozenset[str] | Fault, Mapping[str, Any]]]:
    """Each sentence that starts a mission: its place, its slots or why it cannot be read, and what it gives besides."""
    for phrase, arguments in policy.phrases.items():
        place = pointer(("conversation", "phrases", phrase))
        compiled = _compiled(phrase, policy, place)
        yield place, compiled if isinstance(compiled, Fault) else compiled.slots, arguments
    for text, arguments in policy.spoken.items():
        yield pointer(("conversation", "spoken", text)), frozenset(SLOT.findall(text)), arguments


def _value_faults(given: Mapping[str, Any], keys: Mapping[str, Key], place: str) -> Iterator[Fault]:
    """The values that the mission's arguments refuse; what quotes the sentence is a text."""
    for name, value in given.items():
        if name in keys and (why := type_error(keys[name], value, written=True)):
            yield Fault(place, f"the argument '{name}': {why}")


def _argument_faults(gives: AbstractSet[str], takes: AbstractSet[str], place: str) -> Iterator[Fault]:
    """The arguments of a sentence that the mission lacks, where it has others of it."""
    for name in sorted(gives - takes) if takes & gives else ():
        yield Fault(place, f"the mission takes no argument '{name}'; it takes: {', '.join(sorted(takes))}")


def _compiled(phrase: str, policy: ConversationPolicy, place: str) -> Phrases | Fault:
    """A sentence as the policy's language reads it, or what is wrong with it."""
    try:
        return language(policy.language).own_phrases([phrase])
    except UsageError as error:
        return Fault(place, str(error))


def _question_faults(policy: ConversationPolicy, mission: Mission | None) -> Iterator[Fault]:
    """What is wrong with a robot's own questions, and with what it asks; a key that the mission lacks is no fault."""
    for question in policy.questions:
        place = pointer(("conversation", "questions", question))
        if isinstance(compiled := _compiled(question, policy, place), Fault):
            yield compiled
    for place, path in _paths(policy):
        name, _, field = path.partition(".")
        key = mission.blackboard.get(name) if mission is not None else None
        if key is not None and field and _lacks(key, field):
            yield Fault(place, f"'{name}' has no field '{field}'{suggestion(field, key.fields or ())}")


def _lacks(key: Key, field: str) -> bool:
    """Whether a key has no such field; an object without `fields` may have any."""
    return field not in key.fields if key.fields else key.type != "object"


def _paths(policy: ConversationPolicy) -> Iterator[tuple[str, str]]:
    """Where a key, or a field of one, is named to be spoken, and that."""
    for question, path in policy.questions.items():
        yield pointer(("conversation", "questions", question)), path
    for word, paths in (("asked_with", policy.asked_with), ("results", policy.results)):
        for number, path in enumerate(paths):
            yield pointer(("conversation", word, number)), path


def conversation_oddities(robot: Robot, mission: Mission) -> Iterator[Fault]:
    """What is never used: keys and arguments that the mission has under a name that only resembles them, among others.

    They may be of another mission of the robot, so they are no faults.
    """
    policy, keys = robot.conversation or ConversationPolicy(), mission.blackboard
    if policy.hri_below and not policy.hri:
        yield Fault("/conversation/hri_below", 'without "hri": true no topic is opened there')
    for place, path in _paths(policy):
        if close := _resembling(name := path.partition(".")[0], keys):
            yield Fault(place, f"the mission has no key '{name}', so it is never spoken; did you mean '{close}'?")
    takes = mission.keys_of("argument").keys()
    for place, gives in _given(policy):
        for name in sorted(gives) if takes.isdisjoint(gives) else ():
            if close := _resembling(name, takes):
                yield Fault(
                    place, f"the mission takes no argument '{name}', so it is not used; did you mean '{close}'?"
                )


def _resembling(name: str, known: Collection[str]) -> str:
    """The known name that was probably meant; empty where the name is known, or none resembles it."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.75) if name not in known else []
    return close[0] if close else ""


def _given(policy: ConversationPolicy) -> Iterator[tuple[str, AbstractSet[str]]]:
    """Where arguments are given, or have words of their own, and which; phrases that cannot be read are left out."""
    for place, slots, arguments in _sentences(policy):
        if not isinstance(slots, Fault):
            yield place, arguments_of(slots, arguments)
    for name in policy.names:
        yield pointer(("conversation", "names", name)), {name}
