# SPDX-License-Identifier: Apache-2.0
"""A run that is migrated into a mission with more, or with less, of what no run reaches does what it would have done.

The additions come between what was there: states, transitions, guards that are held, a key and an event. So each place
in the mission is another one, while each state means what it meant.
"""

from __future__ import annotations

import copy
import random
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile, robot_facts
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.resume import resumption
from tests.laws.drawn import DrawnEvent, document, happenings
from tests.laws.test_cut_short import NAMED, Written, plain, profile
from tests.laws.test_instants import AFTER_S
from tests.rigs.charts import ScriptedRobot
from tests.rigs.journals import assert_whole
from tests.rigs.turns import sooner_ended

Json = dict[str, Any]
IS_ON: Json = {"key": "extra", "==": True}
"""Never so: nothing sets the key."""
NEVER: list[Json] = [
    {"on": "never"}, {"when": IS_ON}, {"when": {"held": IS_ON, "for_s": 0.5}},
    {"after_s": 0.5 + 1 / 1024, "when": IS_ON}, {"on": "never", "when": IS_ON},
]  # fmt: skip
"""What triggers an addition. Its time is at an instant of its own: within one either order is right, and `*` would keep
an event that comes in a hold."""
SHARE = 0.5
"""Of the places that gain something."""


def gained(rng: random.Random, made: Json) -> Json:
    """The same mission with more in it, none of which is ever reached."""
    more = copy.deepcopy(made)
    more["blackboard"] = {"extra": {"type": "boolean", "initial": False}, **more["blackboard"]}
    more["events"] = ["never", *more["events"]]
    names = [name for name, _ in each_state(more["states"])]
    rooms = [more["states"], *(state["states"] for _, state in each_state(more["states"]) if "states" in state)]
    for place in [more, *(state for _, state in each_state(more["states"]) if not state.keys() & {"final", "history"})]:
        for _ in range(rng.randint(1, 2)):
            if rng.random() < SHARE:
                trigger: Json = rng.choice(NEVER)
                rules = place.setdefault("transitions", [])
                rules.insert(rng.randint(0, len(rules)), {**trigger, "to": rng.choice(names)})
    for number, room in enumerate(rooms):
        if rng.random() < SHARE:
            there = [*room.items()]
            there.insert(
                rng.randint(0, len(there)), (f"extra{number}", {"transitions": [{"after_s": 1.0, "to": names[0]}]})
            )
            room.clear()
            room.update(there)
    return more


def each_state(states: Json) -> Iterator[tuple[str, Json]]:
    for name, state in states.items():
        yield name, state
        yield from each_state(state.get("states") or state.get("parallel") or {})


def is_added(transition: Json) -> bool:
    guard = transition.get("when", {})
    return transition.get("on") == "never" or IS_ON in (guard, guard.get("held"))


def places(more: Json, at: str = "") -> dict[str, str]:
    """Place of each transition in the mission with more → its place in the one with less; empty for an addition."""
    found, count = dict[str, str](), 0
    for index, each in enumerate(more.get("transitions", ())):
        found[f"{at}/transitions/{index}"] = "" if is_added(each) else f"{at}/transitions/{count}"
        count += not is_added(each)
    for room in ("states", "parallel"):
        for name, state in more.get(room, {}).items():
            found |= places(state, f"{at}/{room}/{name}")
    return found


REMEMBERED = ("memory", "lists", "entered", "_rounds", "_settling", "_frozen", "_held_since", "_paused_at", "_queue")
PLACE = re.compile(r"(?:/(?:states|parallel)/\w+)*/transitions/\d+")


def known(chart: Chart, there: dict[str, str]) -> Any:
    """What a chart remembers of what both missions have, by the places in the one with less."""

    def named(what: object) -> str | None:
        found = PLACE.search(text := str(what))
        place = there.get(found[0], found[0]) if found else ""
        return (text.replace(found[0], place) if place else None) if found else text

    snapshot = chart.snapshot()
    timers = sorted(  # one of an event without an id is called by a number
        (timer.due, timer.name, place if isinstance(key[1], str) else "")
        for key, timer in snapshot["_timers"].items()
        if (place := named(key)) is not None
    )
    held = {named(key): since for key, since in snapshot["held"].items()}
    board = {key: value for key, value in snapshot["board"].items() if key != "extra"}
    held.pop(None, None)
    return plain([timers, held, board, *(snapshot[word] for word in REMEMBERED)])


def done(step: Step) -> Any:
    """What a step did, wherever in the mission it is written."""
    found: Any = [step.outcome, step.why, step.mode, step.holder, step.entered, step.exited, step.writes, step.effects]
    found += [[each._replace(note=None) for each in step.verdicts], step.kept, step.refusal]
    return re.sub(r"/transitions/\d+", "/transitions/#", repr(plain(found)))


@sooner_ended()
def agree(folder: Path, seed: int) -> str:
    """Cut a run short, and continue in the mission with more, or with less; gives whether it could be compared."""
    rng = random.Random(seed)
    less, script = document(rng, trees=seed % 3 == 0), happenings(rng)
    more = gained(rng, less)
    missions: list[tuple[Mission, dict[str, str]]] = [
        (Mission.model_validate(less), {}),
        (Mission.model_validate(more), places(more)),
    ]
    (mission, here), (now, there) = missions[:: rng.choice([1, -1])]
    robot = profile(rng, missions[1][0])
    cut, path, new = rng.randint(0, len(script)), folder / "run.journal", folder / "new.journal"
    whole, answers = Chart(mission, robot_facts=robot_facts(robot), named=NAMED), ScriptedRobot("agent")
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        written = Written(whole, journal)
        answers.follow(written.step(lambda: whole.start(0.0)))
        for happening in script[:cut]:
            if whole.outcome is None:
                event = answers.event(*happening)
                answers.follow(written.step(lambda event=event: whole.send(event)))
        written.flush()
    if whole.outcome is not None:
        return "it had ended"
    same = {name: name for _, name, _ in missions[0][0].walk()}
    map_ = Map(states=same, keys={"extra": None} if there == {} else {})
    notes = migrate(path, now, map_, to=new, robot=robot, named=NAMED).notes
    assert all(note.startswith("the time of ") for note in notes), (
        seed,
        notes,
    )  # of an addition; no other begins again
    assert_whole(new)
    with read(new) as record:
        migrated = resumption(record, now, named=NAMED).chart
    whole.settle_holds()
    assert known(migrated, there) == known(whole, here), seed
    for happening in [*script[cut:], DrawnEvent(("tick",), script[-1].at + AFTER_S)]:
        event = answers.event(*happening)
        step, other = answers.follow(whole.send(event)), migrated.send(event)
        if whole.cause == "cycle":  # the states of one are named in the order of the alphabet
            return "it went round for ever"
        assert done(other) == done(step), seed
        assert (migrated.active, known(migrated, there)) == (whole.active, known(whole, here)), seed
    return "same"


def agree_each(folder: Path, seeds: range) -> Counter[str]:
    found = Counter[str]()
    for seed in seeds:
        (folder / f"{seed}").mkdir()
        found[agree(folder / f"{seed}", seed)] += 1
    return found


@pytest.mark.parametrize("first", range(0, 30, 10))
def test_a_run_continues_in_a_mission_with_more_or_with_less_that_no_run_reaches(first: int, tmp_path: Path) -> None:
    assert agree_each(tmp_path, range(first, first + 10))["same"] > 1


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_three_thousand_runs_continue_in_missions_with_more_or_with_less_that_no_run_reaches(tmp_path: Path) -> None:
    assert agree_each(tmp_path, range(1_000, 4_000))["same"] > 1_000
