# SPDX-License-Identifier: Apache-2.0
"""Whether a robot has all that a mission uses, reported before anything moves.

Rule: a place is where the profile's author mends it; the sentence states where the mission wants it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.check.index import MissionIndex
from rai_missions.errors import Fault, pointer, suggestion
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.profile.entries import references
from rai_missions.profile.profile import Robot
from rai_missions.profile.receivers import SENT_WORDS, receiver_of
from rai_missions.states.decision import Option
from rai_missions.states.effects import Raise

__all__ = ("actions_of", "commanded_names", "keys_read", "missing", "missing_tools", "missing_world")

FITTING: Mapping[str, frozenset[str]] = {"integer": frozenset({"integer", "number"})}
"""What a source gives → the types of the keys that can take it, where that is more than its own."""


def missing(mission: Mission, robot: Robot, *, remedies: Mapping[str, str] = {}) -> tuple[Fault, ...]:
    """What a profile lacks, or has wrongly, for a mission; nothing if the mission can run on the robot.

    Args:
        mission: The mission.
        robot: The profile.
        remedies: Section → what adds a name to it, with `{}` for the name; by default the profile's author names it.

    Raises:
        UsageError: It is no mission.
    """
    given_mission(mission, "missing")
    index = MissionIndex(mission)
    return (
        *_keys(mission, robot, remedies),
        *_events(index, robot),
        *_interfaces(index, robot, remedies),
        *_templates(index, robot),
        *_composed(index, robot),
        *_rules(index, robot),
    )


def missing_tools(mission: Mission, robot: Robot) -> Iterator[Fault]:
    """What a profile lacks for the tools that decisions name: a run has them decided without those tools."""
    seen = set[str]()
    for asked, place, _ in MissionIndex(mission).asked:
        needs = {"identity" if name == "recall" else "tools": name for name in asked.tools}
        for section, name in needs.items():
            if not getattr(robot, section) and section not in seen:
                seen.add(section)
                why = f"missing, so the tool '{name}' is not there, which the mission names at {place}/tools"
                yield Fault(pointer([section]), why)


def actions_of(mission: Mission) -> frozenset[str]:
    """The names of the actions that a mission uses."""
    return frozenset(use.name for use in MissionIndex(mission).uses if use.sort == "action")


def missing_world(mission: Mission, robot: Robot) -> Iterator[Fault]:
    """A mission that needs a robot, and a profile without one: a program has to open it on the run's connector."""
    connector = robot.connector
    if connector["kind"] != "local" or "world" in connector:
        return
    needs = [f"the key '{name}'" for name in mission.keys_of("robot")]
    needs += [f"the {use.sort} '{use.name}'" for use in MissionIndex(mission).uses]
    if needs:
        why = (
            f"names no world, so {needs[0]} has no other side, unless a program opens one; add a 'world', or the 'kind'"
        )
        yield Fault("/connector", f'{why} that reaches the robot, as "ros2"')


def commanded_names(mission: Mission, robot: Robot) -> frozenset[str]:
    """The robot's own names for what a mission has it do: actions, services and topics; what it reads is left out."""
    found = set[str]()
    for use in MissionIndex(mission).uses:
        if use.sort == "action" and (action := robot.actions.get(use.name)) is not None:
            found |= {action.action or "", action.start.service if action.start is not None else ""}
        elif use.sort == "service" and (service := robot.services.get(use.name)) is not None:
            found.add(service.service)
        elif use.sort == "topic" and (topic := robot.topics.get(use.name)) is not None:
            found.add(topic.topic)
    return frozenset(found - {""})


def keys_read(mission: Mission, robot: Robot) -> frozenset[str]:
    """The keys that the profile itself looks at, and of a robot that talks each that it writes: people ask for any."""
    site = Site("", mission.blackboard)
    ends = (guard for action in robot.actions.values() for guard in (action.succeeded, action.failed))
    whens = (rule.when for rules in robot.rules.values() for rule in rules)
    for guard in (*ends, *whens):
        if guard is not None:
            guard.compiled(site)
    return frozenset(site.reads).union(robot.blackboard if robot.conversation is not None else ())


def _lacks(sort: str, name: str, known: Mapping[str, Any], place: str, remedies: Mapping[str, str] = {}) -> Fault:
    near = _shared(sort, name) or (suggestion(name, known) if known else "")
    remedy = f"; {remedies[sort].replace('{}', name)}" if sort in remedies else ""
    sentence = f"missing; the mission uses it at {place}{remedy + near or '; name what is behind it'}"
    return Fault(pointer([sort, name]), sentence)


def _shared(sort: str, name: str) -> str:
    """The remedy for a key or event that an included mission brings; empty for one of the mission itself."""
    state, _, own = name.rpartition("/")
    given = '"…"' if sort == "events" else '{"from": …}'
    share = f'"with": {{"{own}": {given}}}'
    return f"; the mission in '{state}' has it as '{own}': share it there, {share}, or name it here" if state else ""


def _keys(mission: Mission, robot: Robot, remedies: Mapping[str, str]) -> Iterator[Fault]:
    for name, key in mission.blackboard.items():
        source = robot.blackboard.get(name)
        if key.source == "robot" and source is None:
            yield _lacks("blackboard", name, robot.blackboard, pointer(["blackboard", name]), remedies)
        elif key.source != "robot" and source is not None:
            sentence = f"the mission's '{name}' is of source '{key.source}' and not the robot's to write; drop it here"
            yield Fault(pointer(["blackboard", name]), sentence)
        elif source is not None and source.gives is not None and not _takes(key, source.gives):
            sentence = f"its messages give '{source.gives}', and the mission's '{name}' is of type '{key.type}'"
            remedy = "name the 'field' that is meant"
            if source.gives == "string" and source.reads == "plain":
                remedy += ', or add "json": true if that text is JSON'
            yield Fault(pointer(["blackboard", name]), f"{sentence}; {remedy}")


def _takes(key: Key, given: str) -> bool:
    return key.type == given or key.type in FITTING.get(given, ())


def _events(index: MissionIndex, robot: Robot) -> Iterator[Fault]:
    raised = {done.effect.event for done in index.effects if isinstance(done.effect, Raise)}
    for name, declared in index.mission.events.items():
        source = robot.events.get(name)
        if source is None:
            if name not in raised:
                yield _lacks("events", name, robot.events, pointer(["events", name]))
        elif source.fields:
            for field in sorted(declared.fields.keys() - source.fields.keys()):
                place = pointer(["events", name, "fields", field])
                yield Fault(place, f"missing; the mission's '{name}' has it{suggestion(field, source.fields)}")


def _interfaces(index: MissionIndex, robot: Robot, remedies: Mapping[str, str]) -> Iterator[Fault]:
    """The actions, services and topics that are used and not there, each once."""
    first: dict[tuple[str, str], str] = {}
    for use in sorted(index.uses, key=lambda use: use.sort):
        first.setdefault((use.sort, use.name), use.named_at)
    for (sort, name), place in first.items():
        known = getattr(robot, f"{sort}s")
        if name not in known:
            yield _lacks(f"{sort}s", name, known, place, remedies)


def _templates(index: MissionIndex, robot: Robot) -> Iterator[Fault]:
    """The fields that a goal, a request or a message takes from the mission, and the mission does not give."""
    for use in index.uses:
        receiver, word = receiver_of(robot, use), SENT_WORDS[use.sort]
        given = getattr(use.user, word, None)
        if receiver is None or given is None:
            continue
        where = pointer([*receiver.place, receiver.word])
        for field in dict.fromkeys(path.partition(".")[0] for path in references(receiver.template)):
            if field not in given:
                yield Fault(
                    where, f"it takes '{field}' from the mission, which gives no such field at {use.place}/{word}"
                )


def _composed(index: MissionIndex, robot: Robot) -> Iterator[Fault]:
    """What the guards of composed actions read and the mission lacks."""
    for name in dict.fromkeys(use.name for use in index.uses if use.sort == "action"):
        entry = robot.actions.get(name)
        for word, guard in (("succeeded", entry.succeeded), ("failed", entry.failed)) if entry is not None else ():
            if guard is not None:
                yield from _unknown_keys(index, guard, pointer(["actions", name, word]))


def _rules(index: MissionIndex, robot: Robot) -> Iterator[Fault]:
    options: dict[str, dict[str, Option]] = {}
    for asked, _, spot in index.asked:
        options.setdefault(spot.name, {}).update(asked.options)
    for state, rows in robot.rules.items():
        if state not in options:
            known = suggestion(state, options) if options else "; drop it"
            yield Fault(pointer(["rules", state]), f"the mission asks nothing in a state '{state}'{known}")
            continue
        for number, row in enumerate(rows):
            here = pointer(["rules", state, number])
            if row.answer not in options[state]:
                near = suggestion(row.answer, options[state])
                yield Fault(f"{here}/answer", f"'{state}' has no option '{row.answer}'{near}")
            elif why := parameter_faults(options[state][row.answer].parameters or {}, {}):
                yield Fault(f"{here}/answer", f"a rule gives no parameters, and '{row.answer}' asks for some: {why}")
            if row.when is not None:
                yield from _unknown_keys(index, row.when, f"{here}/when")


def _unknown_keys(index: MissionIndex, guard: Guard, place: str) -> Iterator[Fault]:
    """The keys and states of a guard in the profile that the mission does not have."""
    keys = index.mission.blackboard
    site = Site(place, keys)
    guard.compiled(site)
    for key in sorted(site.reads - keys.keys() - {"*"}):
        yield Fault(place, f"the mission has no key '{key}'{suggestion(key, keys)}")
    for state in sorted(site.states - index.by_name.keys()):
        yield Fault(place, f"the mission has no state '{state}'{suggestion(state, index.by_name)}")
